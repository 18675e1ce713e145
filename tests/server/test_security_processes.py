"""The attacks of test_security.py again, where several processes share the visitors: each is tried
often enough to meet all of them."""

import sys
from collections.abc import Callable, Iterator
from functools import partial
from typing import NamedTuple

import pytest
from live.server import (
    CAMERA_MESSAGE,
    FOREIGN_ORIGIN,
    ServeProcess,
    close_code,
    encoded,
    free_port,
    handshake_status,
    http_get,
    missing_headers,
)
from live.visitor import PAPER, frequency_text, pause, visitor

from beamviz.server.connection import MAX_BYTES

PROCESSES = 2
POLICY_VIOLATION, TOO_BIG = 1008, 1009

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="one process on other systems")


class Hall(NamedTuple):
    """A running `beamviz serve` that the network can reach, its key, and the cookie with that."""

    url: str
    key: str
    cookie: dict[str, str]

    def page(self, path: str, headers: dict[str, str]) -> tuple[int, bool, bool]:
        """Status of a page, whether it is viser's, and whether it has all security headers."""
        status, received, body = http_get(self.url, path, **headers)
        return status, b"viser" in body, not missing_headers(received)

    def socket(self, path: str, headers: dict[str, str]) -> int:
        """Status of a WebSocket's handshake."""
        return handshake_status(self.url, path, additional_headers=headers)


def everywhere(attack: Callable[..., object], *given: object) -> set:
    """The results of an attack on each process; connections go to them in turn."""
    return {attack(*given) for _ in range(2 * PROCESSES)}


@pytest.fixture(scope="module")
def hall(tmp_path_factory) -> Iterator[Hall]:
    """Two processes."""
    options = ("--host", "0.0.0.0", "--port", str(free_port()))
    with ServeProcess(tmp_path_factory.mktemp("hall"), *options, processes=PROCESSES) as served:
        assert len(served.workers) == PROCESSES
        place, key = served.url.split("/?token=")
        port = place.rsplit(":", 1)[1]
        yield Hall(f"http://127.0.0.1:{port}", key, {"Cookie": f"beamviz-{port}={key}"})


def test_all_processes_accept_the_key(hall):
    """And its cookie, so that the other tests fail for their own reasons. Pages, refusals and
    unknown paths have the security headers; no other file is served, and no folder listed."""
    assert everywhere(hall.page, "/", hall.cookie) == {(200, True, True)}
    assert everywhere(hall.socket, "/", hall.cookie) == {101}
    assert everywhere(hall.page, f"/?token={hall.key}", {}) == {(303, False, True)}
    for path in ("/../../../../etc/passwd", "//etc/passwd", "/assets/", "/nothing-here"):
        assert everywhere(hall.page, path, hall.cookie) == {(404, False, True)}


def test_no_process_accepts_a_request_without_the_key_or_from_a_foreign_page(hall):
    """403 for pages and WebSockets; also for a foreign page or a rebound name if the browser has
    the key."""
    for path, headers in (
        ("/", {}),
        (f"/?token={hall.key}x", {}),
        ("/", {"Origin": FOREIGN_ORIGIN, **hall.cookie}),
        ("/", {"Host": "evil.example", "Origin": "http://evil.example", **hall.cookie}),
    ):
        assert everywhere(hall.page, path, headers) == {(403, False, True)}
        assert everywhere(hall.socket, path, headers) == {403}


def test_an_invalid_message_closes_the_connection(hall):
    """In each process: an unknown message, a number out of range, too many bytes."""
    attack = partial(close_code, hall.url, additional_headers=hall.cookie)
    for message, code in (
        ({"type": "ShareUrlRequest"}, POLICY_VIOLATION),  # a public tunnel
        (CAMERA_MESSAGE | {"position": (1e300, 0.0, 0.0)}, POLICY_VIOLATION),
        ({"type": "CommandTriggerMessage", "uuid": "x" * MAX_BYTES}, TOO_BIG),
    ):
        assert everywhere(attack, encoded(**message)) == {code}


@pytest.mark.slow
def test_no_visitor_changes_the_controls_of_another(hall):
    """In the same process and in the other."""
    cookie = {"additional_headers": hall.cookie}
    with visitor(hall.url, **cookie) as one, visitor(hall.url, **cookie) as other:
        for k, guest in enumerate((one, other)):
            guest.show_speed(20.0 + k)
            control = {"type": "GuiUpdateMessage", "uuid": guest.parts["bridge"]}
            for _ in range(PROCESSES):
                with visitor(hall.url, **cookie) as stranger:
                    stranger.send(**control, updates={"value": '[1, "gamma", 11]'})
                    stranger.show_speed(33.0)  # so the message has been read
            removal = encoded(**control, updates={"removed": True})
            assert everywhere(partial(close_code, **cookie), hall.url, removal) == {
                POLICY_VIOLATION
            }
        for k, guest in enumerate((one, other)):
            pause(guest)
            assert frequency_text(PAPER.replace(gamma=20.0 + k)) in guest.text
            guest.show_speed(21.0 + k)
