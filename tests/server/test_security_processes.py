"""The attacks of test_security.py again, where several processes share the visitors: each is tried
often enough to meet all of them."""

import sys
from collections.abc import Callable, Iterator
from functools import partial

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
from live.visitor import PAPER, frequency_text, pause, visitor

from beamviz.server.connection import MAX_BYTES

PROCESSES = 2
POLICY_VIOLATION, TOO_BIG = 1008, 1009

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


@pytest.mark.slow
def test_all_processes_accept_the_key(hall):
    """And its cookie, so that the other tests fail for their own reasons."""
    assert hall.pages(**hall.cookie) == {(200, True)}
    assert hall.sockets(**hall.cookie) == {101}
    assert hall.pages(f"/?token={hall.key}") == {(303, False)}


def test_no_process_accepts_a_request_without_the_key_or_from_a_foreign_page(hall):
    """403 for pages and WebSockets; also for a foreign page or a rebound name if the browser has
    the key."""
    for path, headers in (
        ("/", {}),
        (f"/?token={hall.key}x", {}),
        ("/", {"Origin": FOREIGN_ORIGIN, **hall.cookie}),
        ("/", {"Host": "evil.example", "Origin": "http://evil.example", **hall.cookie}),
    ):
        assert hall.pages(path, **headers) == {(403, False)}
        assert hall.sockets(path, **headers) == {403}


def test_an_invalid_message_closes_the_connection(hall):
    """In each process: an unknown message, a number out of range, too many bytes."""
    for message, code in (
        ({"type": "ShareUrlRequest"}, POLICY_VIOLATION),  # a public tunnel
        (CAMERA_MESSAGE | {"position": (1e300, 0.0, 0.0)}, POLICY_VIOLATION),
        ({"type": "CommandTriggerMessage", "uuid": "x" * MAX_BYTES}, TOO_BIG),
    ):
        attack = partial(close_code, hall.url, encoded(**message), additional_headers=hall.cookie)
        assert hall.everywhere(attack) == {code}


@pytest.mark.slow
def test_no_visitor_changes_the_controls_of_another(hall):
    """In the same process and in the other."""
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


def test_no_process_serves_other_files(hall):
    """Or lists folders."""
    for path in ("/../../../../etc/passwd", "//etc/passwd", "/assets/"):
        assert hall.pages(path, **hall.cookie) == {(404, False)}


def test_every_response_has_the_security_headers(hall):
    """The page, a refusal, and an unknown path."""
    for path, headers in (("/", hall.cookie), ("/nothing-here", hall.cookie), ("/", {})):
        attack = partial(http_get, hall.url, path, **headers)
        assert hall.everywhere(lambda: bool(missing_headers(attack()[1]))) == {False}  # noqa: B023
