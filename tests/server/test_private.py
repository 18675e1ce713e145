"""What is one visitor's is nobody else's: shown on a bare viser server, then refused by ours."""

import viser
from live.server import close_code, encoded, plain_viser_server, raw_socket, url_of, wait_until
from live.visitor import BEAM, PAPER, Visitor, final_text, frequency_text, visitor

from beamviz.explorer import app as server
from beamviz.explorer.app import explorer
from beamviz.scene import Scene

VIOLATION = 1008


def test_a_visitor_cannot_change_another_ones_controls(url):
    """Controls that viser shares, one visitor can move for all; ours are private, every one."""
    with plain_viser_server() as viser_server, raw_socket(url_of(viser_server)) as line:
        slider = viser_server.gui.add_slider("x", 0.0, 1.0, 0.1, 0.5)
        line.send(encoded(type="GuiUpdateMessage", uuid=slider._impl.uuid, updates={"value": 1.0}))
        wait_until(lambda: slider.value == 1.0)
    with visitor(url) as one, visitor(url) as other:
        assert one.controls
        assert not set(one.controls.values()) & set(other.controls.values())
        for guest in (one, other):
            guest.choose("playing", False)
            final_text(guest)
        before = other.text
        for uuid in other.controls.values():
            one.send(type="GuiUpdateMessage", uuid=uuid, updates={"value": 1})
        assert final_text(other) == before


def test_a_visitor_cannot_remove_another_ones_controls(url):
    """viser takes a control away from all on a message of one: here its sender is sent off."""
    with plain_viser_server() as viser_server, raw_socket(url_of(viser_server)) as line:
        slider = viser_server.gui.add_slider("x", 0.0, 1.0, 0.1, 0.5)
        updates = {"removed": True}
        line.send(encoded(type="GuiUpdateMessage", uuid=slider._impl.uuid, updates=updates))
        wait_until(lambda: slider._impl.removed)
    with visitor(url) as other:
        uuid = other.controls["speed γ"]
        for message in (
            encoded(type="GuiUpdateMessage", uuid=uuid, updates=updates),
            encoded(type="GuiRemoveMessage", uuid=uuid),
            encoded(type="RemoveSceneNodeMessage", name=BEAM),
        ):
            assert close_code(url, message) == VIOLATION
        other.choose("speed γ", 11.0)
        other.says(frequency_text(PAPER.replace(gamma=11.0)))


def test_a_visitor_hears_nothing_of_another(url):
    """viser tells all of what one does; here not a control, nor a text, nor a picture of it."""
    with plain_viser_server() as viser_server, raw_socket(url_of(viser_server)) as one:
        slider = viser_server.gui.add_slider("x", 0.0, 1.0, 0.1, 0.5)
        with raw_socket(url_of(viser_server)) as other:
            other.send(
                encoded(type="GuiUpdateMessage", uuid=slider._impl.uuid, updates={"value": 1.0})
            )
            wait_until(lambda: slider.value == 1.0)
            eavesdropper = Visitor(one)
            eavesdropper.wait(lambda _: slider._impl.uuid in eavesdropper.updated)
    with visitor(url) as one, visitor(url) as other:
        for guest in (one, other):
            guest.choose("playing", False)
            final_text(guest)
        before = one.received
        other.choose("speed γ", 11.0)
        other.says(frequency_text(PAPER.replace(gamma=11.0)))
        final_text(one)
        assert one.received == before
        assert not {*one.texts, *one.updated} & {*other.texts, *other.updated}


def test_no_control_is_shared(monkeypatch):
    """The server's own scope, which any visitor could change for all, holds none."""
    made: list[viser.ViserServer] = []
    frame_loop = server.FrameLoop
    monkeypatch.setattr(
        server, "FrameLoop", lambda *given: (made.append(given[0]), frame_loop(*given))[1]
    )
    with explorer(Scene(PAPER)) as found, visitor(found) as guest:
        assert guest.controls
        assert not made[0].gui._gui_input_handle_from_uuid
        assert not made[0].gui._command_handle_from_uuid
