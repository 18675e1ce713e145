"""What a visitor may send and see: each attack first on a plain viser server, then refused here;
and the log, which has one line for each kind of error, whatever a visitor does."""

import logging
from collections.abc import Iterator
from typing import Any
from unittest import mock

import pytest
import viser
from live.server import (
    CAMERA_MESSAGE,
    TIMEOUT,
    close_code,
    encoded,
    plain_viser_server,
    raw_socket,
    url_of,
    wait_until,
)
from live.visitor import BEAM, PAPER, Visitor, beam_moved, catch_up, frequency_text, pause, visitor
from websockets.sync.connection import Connection

from beamviz.server import connection, run_server
from beamviz.server.connection import MAX_BYTES, POLICY_VIOLATION
from beamviz.server.log import INTERVAL, MAX_KINDS, RateLimitedLog


@pytest.fixture
def plain() -> Iterator[viser.ViserServer]:
    """viser's own server, for one test, as attacks succeed."""
    with plain_viser_server() as server:
        yield server


@pytest.fixture
def slider(plain) -> viser.GuiSliderHandle:
    """A slider of viser's own server."""
    return plain.gui.add_slider("x", 0.0, 1.0, 0.1, 0.5)


@pytest.fixture
def line(plain) -> Iterator[Connection]:
    """The socket of a visitor of viser's own server."""
    with raw_socket(url_of(plain)) as socket:
        yield socket


def update(uuid: str, **updates: Any) -> bytes:
    return encoded(type="GuiUpdateMessage", uuid=uuid, updates=updates)


def test_no_visitor_can_open_a_public_tunnel(plain, line, url):
    """viser opens one for a single message, with its button hidden or not."""
    with mock.patch("viser._viser.ViserTunnel") as tunnel:
        tunnel.return_value.get_status.return_value = "connected"
        plain.gui.configure_theme(show_share_button=False)
        line.send(encoded(type="ShareUrlRequest"))
        connected = tunnel.return_value.on_connect
        wait_until(lambda: connected.called)
        connected.call_args[0][0](1)  # ends viser's thread
        tunnel.reset_mock()
        assert close_code(url, encoded(type="ShareUrlRequest")) == POLICY_VIOLATION
        with run_server() as ours:
            ours.request_share_url()
        assert not tunnel.called


def test_a_visitor_cannot_set_attributes_fill_the_memory_or_reach_others(plain, line, slider, url):
    """viser sets any attribute of a control that a message names, accepts files for any control
    without a limit, forwards "form" messages to all and stores them for later visitors, and reads
    up to 50 MB; messages of the page are far below our limit."""
    control, file = slider._impl, {"filename": "f", "mime_type": "x", "part_count": 1000}
    file |= {"transfer_uuid": "t", "size_bytes": 10**12, "source_component_uuid": control.uuid}
    form = encoded(type="GuiFormDirtyMessage", uuid="x" * 100)
    upload = encoded(type="FileTransferStartUpload", **file)
    removal = update(control.uuid, removed=True, update_cb=[])
    huge = update("x", value="x" * MAX_BYTES)
    stored = plain._websock_server._broadcast_buffer.message_from_id
    before = len(stored)
    for message, code, succeeds in (
        (form, POLICY_VIOLATION, lambda: len(stored) > before),
        (upload, POLICY_VIOLATION, lambda: plain.gui._current_file_upload_states),
        (removal, POLICY_VIOLATION, lambda: control.removed),
        (huge, 1009, lambda: line.ping().wait(TIMEOUT)),  # too big
    ):
        line.send(message)
        wait_until(succeeds)
        assert close_code(url, message) == code


WRONG_CAMERAS: list[dict[str, Any]] = [
    *({"fov": float("nan")}, {"position": (1e300, 0.0, 0.0)}, {"look_at": (0.0, 0.0)}),
    *({"image_height": 0}, {"image_width": -5}, {"excluded_self_client": 1}),
]
INVALID = (
    *("text instead of bytes", b"", b"\xc1", b"\x81" * 5000),  # nested too deep to be decoded
    *(encoded(no="type"), encoded(type=["GuiUpdateMessage"]), encoded(type="Message")),
    encoded(type="SetPositionMessage", name="/scene", position=(0, 0, 0)),
    encoded(type="RemoveSceneNodeMessage", name=BEAM),
    *(encoded(type="GuiRemoveMessage", uuid="x"), encoded(type="ViewerCameraMessage")),
    *(encoded(**CAMERA_MESSAGE | wrong) for wrong in WRONG_CAMERAS),
    encoded(type="GuiUpdateMessage", uuid=5, updates={"value": "1"}),
    encoded(type="GuiUpdateMessage", uuid="x", updates={"value": "1"}, more=1),
    *(update("x"), update("x", update_cb=[]), update("x", value="1", removed=True)),
    *(update("x", value=value) for value in (None, {"a": 1}, [[[1]]], 1, ["x"])),
    encoded(type="CommandTriggerMessage", uuid="x" * 2000),
)


def test_an_invalid_message_closes_its_connection_and_no_other(url, caplog):
    """One line in the log has the address and the reason; another visitor is not affected."""
    connection.log.reported.clear()
    with visitor(url) as other, caplog.at_level(logging.WARNING):
        for message in INVALID:
            assert close_code(url, message) == POLICY_VIOLATION, message[:80]
        (line,) = [record.message for record in caplog.records if "closed" in record.message]
        assert "127.0.0.1: closed for an invalid message" in line
        other.choose("gamma", 11.0, until=beam_moved)


def test_messages_above_the_rate_are_coalesced(plain):
    """Of a flood viser reads all messages; here those of a burst, then only some and the last."""

    def read(server: viser.ViserServer) -> list[float]:
        """What a server reads of 3000 camera positions sent at once, up to the last."""
        places: list[float] = []

        async def moved(camera: viser.CameraHandle) -> None:
            places.append(camera.position[0])

        server.on_client_connect(lambda client: client.camera.on_update(moved))
        with raw_socket(url_of(server)) as socket:
            socket.send(encoded(**CAMERA_MESSAGE))
            wait_until(lambda: server.get_clients())
            for place in range(3000):
                socket.send(encoded(**CAMERA_MESSAGE | {"position": (place, -3.0, 2.0)}))
            wait_until(lambda: places and places[-1] == 2999)
        return places

    with run_server() as server:
        assert len(read(server)) < 1500 < 2900 < len(read(plain))


def test_a_visitor_neither_changes_nor_receives_what_belongs_to_another(plain, line, slider, url):
    """viser shares controls, whose edits all receive. Here nobody shares control, text or scene."""
    with raw_socket(url_of(plain)) as other:
        other.send(update(slider._impl.uuid, value=1.0))
        eavesdropper = Visitor(line)
        eavesdropper.wait(lambda _: slider._impl.uuid in eavesdropper.updated)
        assert slider.value == 1.0
    with visitor(url) as one, visitor(url) as other:
        for mine, others in ((one.controls, other.controls), (one.commands, other.commands)):
            assert mine.keys() == others.keys() != set()
            assert not set(mine.values()) & set(others.values())
        for guest in (one, other):
            guest.wait(lambda _, charts=guest.charts: charts["loci-chart"].get("lines"))
            pause(guest)
        before = one.values.copy(), other.values.copy()
        for uuid in other.controls.values():
            one.send(type="GuiUpdateMessage", uuid=uuid, updates={"value": "1"})
        action = {"value": '[1, "gamma", 20]'}
        one.send(type="GuiUpdateMessage", uuid=other.parts["bridge"], updates=action)
        for guest in (one, other):
            catch_up(guest)
        assert (one.values, other.values) == before
        assert frequency_text(PAPER) in other.text
        other.edit(gamma=11.0)
        catch_up(one)
        assert one.values == before[0]
        assert frequency_text(PAPER) in one.text
        assert frequency_text(other.beam) not in one.text


# The log


def test_repeated_errors_are_one_line_and_a_count(monkeypatch, caplog):
    """Other visitors and other errors have lines of their own; after a while there is another line.
    A text with line breaks is one line. The memory is limited: errors are forgotten."""
    clock = mock.Mock(return_value=1000.0)
    monkeypatch.setattr("beamviz.server.log.time.monotonic", clock)
    log = RateLimitedLog("a test")
    for _ in range(5000):
        log.warn("visitor 1", "ValueError", "ignored: rubber")
    log.warn("visitor 1", "TypeError", "ignored: two\nlines\r\nof it")
    log.warn("visitor 2", "ValueError", "ignored: rubber")
    clock.return_value += INTERVAL
    log.warn("visitor 1", "ValueError", "ignored: gum")
    assert [record.getMessage() for record in caplog.records] == [
        "visitor 1: ignored: rubber",
        "visitor 1: ignored: two lines of it",
        "visitor 2: ignored: rubber",
        "visitor 1: ignored: gum (4999 more like this since the last line)",
    ]
    with log.muted():
        for k in range(3 * MAX_KINDS):
            log.warn(f"visitor {k}", "text", "ignored")
    assert len(log.reported) <= MAX_KINDS


def test_an_internal_error_is_one_line_with_its_traceback_at_level_debug(caplog):
    """At other levels only the line."""
    log = RateLimitedLog("a test")
    for level in (logging.INFO, logging.DEBUG):
        with caplog.at_level(level, "a test"):
            log.error("chart", "a beam", ZeroDivisionError("by zero"))
    line, traceback = caplog.records
    assert line.getMessage() == "chart: failed for a beam: ZeroDivisionError('by zero')"
    assert traceback.exc_info
