"""The attacks of test_security.py again, where several processes share the visitors: each is tried
often enough to meet all of them."""

import sys
from collections.abc import Callable, Iterator

import pytest
import websockets.exceptions
from live.server import (
    CAMERA_MESSAGE,
    FOREIGN_ORIGIN,
    ServeProcess,
    close_code,
    encoded,
    free_port,
    http_get,
    missing_headers,
    raw_socket,
)
from live.visitor import BEAM, PAPER, frequency_text, pause, visitor

from beamviz.server.connection import MAX_BYTES, MAX_PART_BYTES

PROCESSES = 2
POLICY_VIOLATION, TOO_BIG = 1008, 1009
PART = {"source_component_uuid": "", "transfer_uuid": "t", "part_index": 0}

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="one process on other systems")


class Hall:
    """A running `beamviz serve` that the network can reach, with the key for it."""

    def __init__(self, link: str):
        place, self.key = link.split("/?token=")
        port = place.rsplit(":", 1)[1]
        self.url = f"http://127.0.0.1:{port}"
        self.cookie = {"Cookie": f"beamviz-{port}={self.key}"}

    def everywhere(self, attack: Callable[[], object]) -> set:
        """The results of an attack on each process; connections go to them in turn."""
        return {attack() for _ in range(2 * PROCESSES)}

    def pages(self, path: str = "/", **headers: str) -> set[tuple[int, bool]]:
        """Status of a page, and whether it is viser's."""

        def attack() -> tuple[int, bool]:
            status, _, body = http_get(self.url, path, **headers)
            return status, b"viser" in body

        return self.everywhere(attack)

    def sockets(self, path: str = "/", **headers: str) -> set[int]:
        """Status of a WebSocket's handshake, 101 where it opens."""

        def attack() -> int:
            try:
                with raw_socket(self.url, path, additional_headers=headers):
                    return 101
            except websockets.exceptions.InvalidStatus as error:
                return error.response.status_code

        return self.everywhere(attack)


@pytest.fixture(scope="module")
def hall(tmp_path_factory) -> Iterator[Hall]:
    """Two processes."""
    options = ("--host", "0.0.0.0", "--port", str(free_port()))
    with ServeProcess(tmp_path_factory.mktemp("hall"), *options, processes=PROCESSES) as served:
        assert len(served.workers) == PROCESSES
        yield Hall(served.url)


def test_the_key_opens_all_of_them(hall):
    """So that what follows is refused for its own reason; a cookie is good for all."""
    assert hall.pages(**hall.cookie) == {(200, True)}
    assert hall.sockets(**hall.cookie) == {101}
    assert hall.pages(f"/?token={hall.key}") == {(303, False)}


@pytest.mark.parametrize("path", ["/", "/?token=", "/?token=no", "/?token={key}x", "/?token=%ff"])
def test_none_opens_without_the_key(hall, path):
    """403, before any page, and for a WebSocket."""
    assert hall.pages(path.format(key=hall.key)) == {(403, False)}
    assert hall.sockets(path.format(key=hall.key)) == {403}


@pytest.mark.parametrize(
    "headers",
    [{"Origin": FOREIGN_ORIGIN}, {"Origin": "null"}]
    + [
        {"Host": host, "Origin": f"http://{host}"}
        for host in ("evil.example", "127.0.0.1.evil.example", "127.0.0.1:1")
    ],
)
def test_none_answers_a_foreign_page_or_a_rebound_name(hall, headers):
    """Even if the browser has the key."""
    assert hall.pages(**headers, **hall.cookie) == {(403, False)}
    assert hall.sockets(**headers, **hall.cookie) == {403}


@pytest.mark.parametrize(
    ("message", "code"),
    [
        ({"type": "ShareUrlRequest"}, POLICY_VIOLATION),  # a public tunnel
        ({"type": "GuiFormDirtyMessage", "uuid": "x"}, POLICY_VIOLATION),  # which viser broadcasts
        ({"type": "GuiRemoveMessage", "uuid": "x"}, POLICY_VIOLATION),
        ({"type": "RemoveSceneNodeMessage", "name": BEAM}, POLICY_VIOLATION),
        ({"type": "GuiUpdateMessage", "uuid": "x", "updates": {"update_cb": []}}, POLICY_VIOLATION),
        (
            {"type": "GuiUpdateMessage", "uuid": "x", "updates": {"value": "x" * MAX_BYTES}},
            POLICY_VIOLATION,
        ),
        ({"type": "FileTransferPart", "content": b"x" * MAX_PART_BYTES} | PART, TOO_BIG),
        (CAMERA_MESSAGE | {"position": (1e300, 0.0, 0.0)}, POLICY_VIOLATION),
    ],
    ids=lambda value: str(value)[:40],
)
def test_an_invalid_message_closes_the_connection(hall, message, code):
    """In whichever process it is."""
    options = {"additional_headers": hall.cookie}
    assert hall.everywhere(lambda: close_code(hall.url, encoded(**message), **options)) == {code}


def test_nobody_changes_or_removes_the_controls_of_another(hall):
    """A visitor names the controls of another one, in the same process and in the other."""
    cookie = {"additional_headers": hall.cookie}
    action = {"value": '[1, "gamma", 11]'}

    def sees(guest, gamma: float) -> str:
        guest.choose("gamma", gamma)
        return guest.says(frequency_text(PAPER.replace(gamma=gamma)))

    with visitor(hall.url, **cookie) as one, visitor(hall.url, **cookie) as other:
        for k, guest in enumerate((one, other)):
            sees(guest, 20.0 + k)
            uuid = guest.parts["bridge"]
            for _ in range(PROCESSES):
                with visitor(hall.url, **cookie) as stranger:
                    stranger.send(type="GuiUpdateMessage", uuid=uuid, updates=action)
                    sees(stranger, 33.0)  # so the message has been read
            removal = encoded(type="GuiUpdateMessage", uuid=uuid, updates={"removed": True})
            closing = hall.everywhere(lambda: close_code(hall.url, removal, **cookie))  # noqa: B023
            assert closing == {POLICY_VIOLATION}
        for k, guest in enumerate((one, other)):
            pause(guest)
            assert frequency_text(PAPER.replace(gamma=20.0 + k)) in guest.text
            sees(guest, 21.0 + k)


@pytest.mark.parametrize(
    "path", ["/../../../../etc/passwd", "/%2e%2e/%2e%2e/etc/passwd", "//etc/passwd", "/assets/"]
)
def test_no_other_file_is_served_by_any(hall, path):
    """Nor a folder listed."""
    assert hall.pages(path, **hall.cookie) == {(404, False)}


def test_every_response_has_the_security_headers(hall):
    """Whether it is the page, a refusal or nothing."""
    for path, headers in (("/", hall.cookie), ("/nothing-here", hall.cookie), ("/", {})):
        assert hall.everywhere(
            lambda path=path, headers=headers: bool(
                missing_headers(http_get(hall.url, path, **headers)[1])
            )
        ) == {False}
