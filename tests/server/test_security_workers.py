"""What a stranger may not do, tried again where several processes share the visitors: each attack
often enough to meet all of them. (tests/server/test_security.py shows them on a bare server.)"""

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
from live.visitor import BEAM, PAPER, Visitor, frequency_text, pause, visitor

from beamviz.server.connection import MAX_BYTES, MAX_PART_BYTES

PROCESSES = 2
VIOLATION, TOO_BIG = 1008, 1009
LONG = "x" * MAX_BYTES
HUGE = {"source_component_uuid": "", "transfer_uuid": "t", "part_index": 0}

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="one process on other systems")


class Hall:
    """An explorer that the network can reach: where it is on this machine, and its key."""

    def __init__(self, link: str):
        place, self.key = link.split("/?token=")
        port = place.rsplit(":", 1)[1]
        self.url = f"http://127.0.0.1:{port}"
        self.cookie = {"Cookie": f"beamviz-{port}={self.key}"}
        self.invited = {"additional_headers": self.cookie}

    def everywhere(self, attack: Callable[[], object]) -> set:
        """What comes of an attack on each process; connections go to them by turns."""
        return {attack() for _ in range(2 * PROCESSES)}

    def asked(self, path: str = "/", **headers: str) -> set[tuple[int, bool]]:
        """Status of a page, and whether it is viser's."""

        def attack() -> tuple[int, bool]:
            status, _, body = http_get(self.url, path, **headers)
            return status, b"viser" in body

        return self.everywhere(attack)

    def opened(self, **options: object) -> set[str]:
        """What becomes of a WebSocket."""

        def attack() -> str:
            try:
                with raw_socket(self.url, **options):
                    return "open"
            except websockets.exceptions.InvalidStatus as error:
                return str(error.response.status_code)

        return self.everywhere(attack)

    def sent(self, message: bytes) -> set[int]:
        """With which code a message of somebody with the key ends their connection."""
        return self.everywhere(lambda: close_code(self.url, message, **self.invited))


@pytest.fixture(scope="module")
def hall(tmp_path_factory) -> Iterator[Hall]:
    """Two processes, open to the network."""
    options = ("--host", "0.0.0.0", "--port", str(free_port()))
    folder = tmp_path_factory.mktemp("hall")
    with ServeProcess(folder, *options, processes=PROCESSES) as explorer:
        assert len(explorer.workers) == PROCESSES
        yield Hall(explorer.url)


@pytest.fixture
def guests(hall) -> Iterator[list[Visitor]]:
    """A visitor in each process."""
    with visitor(hall.url, **hall.invited) as one, visitor(hall.url, **hall.invited) as other:
        yield [one, other]


def frequency(gamma: float) -> str:
    """The first frequency as the table prints it."""
    return frequency_text(PAPER.replace(gamma=gamma))


def test_with_the_key_all_of_them_open(hall):
    """So that what follows is refused for its own reason; a cookie of one is good for all."""
    assert hall.asked(**hall.cookie) == {(200, True)}
    assert hall.opened(**hall.invited) == {"open"}
    assert hall.asked(f"/?token={hall.key}") == {(303, False)}


@pytest.mark.parametrize("key", ["", "?token=", "?token=wrong", "?token={key}x", "?token=%ff%fe"])
def test_without_the_key_none_of_them_opens(hall, key):
    """403, before any page, and for a WebSocket."""
    path = "/" + key.format(key=hall.key)
    assert hall.asked(path) == {(403, False)}
    assert hall.opened(path=path) == {"403"}


@pytest.mark.parametrize("origin", [FOREIGN_ORIGIN, "null"])
def test_a_page_of_another_site_is_turned_away_by_all(hall, origin):
    """Even if its browser has the key."""
    assert hall.asked(Origin=origin, **hall.cookie) == {(403, False)}
    assert hall.opened(origin=origin, **hall.invited) == {"403"}


@pytest.mark.parametrize("host", ["evil.example", "127.0.0.1.evil.example", "127.0.0.1:1"])
def test_a_name_made_to_point_here_is_answered_by_none(hall, host):
    """DNS rebinding."""
    headers = {"Host": host, **hall.cookie}
    assert hall.asked(**headers) == {(403, False)}
    assert hall.opened(additional_headers=headers, origin=f"http://{host}") == {"403"}


@pytest.mark.parametrize(
    ("message", "code"),
    [
        ({"type": "ShareUrlRequest"}, VIOLATION),  # a public tunnel
        ({"type": "GuiFormDirtyMessage", "uuid": "x"}, VIOLATION),  # what viser tells all
        ({"type": "GuiRemoveMessage", "uuid": "x"}, VIOLATION),
        ({"type": "RemoveSceneNodeMessage", "name": BEAM}, VIOLATION),
        ({"type": "GuiUpdateMessage", "uuid": "x", "updates": {"update_cb": []}}, VIOLATION),
        ({"type": "GuiUpdateMessage", "uuid": "x", "updates": {"value": LONG}}, VIOLATION),
        ({"type": "FileTransferPart", "content": b"x" * MAX_PART_BYTES} | HUGE, TOO_BIG),
        (CAMERA_MESSAGE | {"position": (1e300, 0.0, 0.0)}, VIOLATION),
    ],
    ids=lambda value: str(value)[:40],
)  # fmt: skip
def test_a_message_that_no_page_sends_ends_its_sender(hall, message, code):
    """In whichever process they are."""
    assert hall.sent(encoded(**message)) == {code}


def test_nobody_changes_or_removes_what_is_another_ones(hall, guests):
    """A visitor names the controls of another one, in the same process and in the other."""
    before = []
    for k, guest in enumerate(guests):
        guest.choose("speed γ", 20.0 + k)
        guest.says(frequency(20.0 + k))
        before.append(guest.controls["speed γ"])
    for uuid in before:
        change = encoded(type="GuiUpdateMessage", uuid=uuid, updates={"value": 11.0})
        removal = encoded(type="GuiUpdateMessage", uuid=uuid, updates={"removed": True})
        for _ in range(2):
            with visitor(hall.url, **hall.invited) as stranger:
                stranger.socket.send(change)
                stranger.choose("speed γ", 33.0)
                stranger.says(frequency(33.0))  # so that was read
        assert hall.sent(removal) == {VIOLATION}
    for k, guest in enumerate(guests):
        pause(guest)
        assert frequency(20.0 + k) in guest.text
        guest.choose("speed γ", 21.0 + k)
        guest.says(frequency(21.0 + k))


@pytest.mark.parametrize(
    "path", ["/../../../../etc/passwd", "/%2e%2e/%2e%2e/etc/passwd", "//etc/passwd", "/assets/"]
)
def test_no_other_file_is_served_by_any(hall, path):
    """Nor a folder listed."""
    assert hall.asked(path, **hall.cookie) == {(404, False)}


def test_every_answer_of_all_ties_the_pages_hands(hall):
    """Whether it is the page, a refusal or nothing."""
    for path, headers in (("/", hall.cookie), ("/nothing-here", hall.cookie), ("/", {})):
        for _ in range(2 * PROCESSES):
            assert not missing_headers(http_get(hall.url, path, **headers)[1])
