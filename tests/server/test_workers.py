"""Several processes behind one address, tested as processes: by visits, by signals, by force."""

import contextlib
import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
import websockets.exceptions
from live.server import ServeProcess, free_port, http_get, raw_socket, wait_until
from live.visitor import BEAM, PAPER, frequency_text, visitor

from beamviz.errors import InvalidInput, Unavailable
from beamviz.explorer.app import serve
from beamviz.scene import Scene
from beamviz.server.access import VisitorCount
from beamviz.server.processes import MIN_LIFETIME, listening_sockets, process_count

ROOT = Path(__file__).parents[2]

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="one process on other systems")


def lines(pid: int) -> int:
    """The connections that a process holds open, beside the pipe to the first process."""
    kinds = [os.readlink(file) for file in Path(f"/proc/{pid}/fd").iterdir()]
    return sum(kind.startswith("socket:") for kind in kinds)


def alive(pid: int) -> bool:
    """Whether a process runs."""
    with contextlib.suppress(OSError):
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    return False


def caught(pid: int) -> bool:
    """Whether a process takes SIGTERM in hand, as it does in its first line."""
    status = Path(f"/proc/{pid}/status").read_text()
    (line,) = [line for line in status.splitlines() if line.startswith("SigCgt")]
    return bool(int(line.split()[1], 16) & 1 << (signal.SIGTERM - 1))


@pytest.fixture(scope="module")
def hall(tmp_path_factory) -> Iterator[ServeProcess]:
    """Two processes with room for five."""
    folder = tmp_path_factory.mktemp("hall")
    with ServeProcess(folder, "--port", str(free_port()), "--visitors", "5") as explorer:
        yield explorer


def test_visitors_are_shared_evenly_and_have_private_scenes(hall):
    """Four visitors, two for each process; what one does, no other sees."""
    wait_until(lambda: len({lines(pid) for pid in hall.workers}) == 1)  # after the self-test
    before = [lines(pid) for pid in hall.workers]
    with contextlib.ExitStack() as stack:
        guests = [stack.enter_context(visitor(hall.url)) for _ in range(4)]
        assert [lines(pid) - n for pid, n in zip(hall.workers, before, strict=True)] == [2, 2]
        for k, guest in enumerate(guests):
            guest.choose("speed γ", 20.0 + k)
        for k, guest in enumerate(guests):
            guest.says(frequency_text(PAPER.replace(gamma=20 + k)))
    wait_until(lambda: [lines(pid) for pid in hall.workers] == before)


def test_the_limit_of_visitors_is_for_all_processes_together(hall):
    """Five are in, wherever; the sixth is told so, and comes in when one has left."""
    with contextlib.ExitStack() as stack:
        for _ in range(5):
            stack.enter_context(visitor(hall.url))
        for _ in range(4):  # by whichever process
            assert http_get(hall.url)[0] == 503
            with (
                pytest.raises(websockets.exceptions.InvalidStatus, match="503"),
                raw_socket(hall.url),
            ):
                pass
        stack.close()
    wait_until(lambda: http_get(hall.url)[0] == 200)
    with visitor(hall.url) as guest:
        assert BEAM in "".join(guest.nodes)


def test_a_worker_that_dies_is_replaced(hall):
    """Its visitor is cut off and comes back; the others do not notice; the log has one line."""
    time.sleep(MIN_LIFETIME)
    with visitor(hall.url) as one, visitor(hall.url) as other:
        before = hall.workers
        os.kill(before[0], signal.SIGKILL)
        wait_until(lambda: len(hall.workers) == 2 and hall.workers != before)
        cut = 0
        for guest in (one, other):
            try:
                guest.choose("speed γ", 31.0)
                guest.says(frequency_text(PAPER.replace(gamma=31)))
            except websockets.exceptions.ConnectionClosed:
                cut += 1
        assert cut == 1
        with visitor(hall.url) as again:
            again.choose("speed γ", 32.0)
            again.says(frequency_text(PAPER.replace(gamma=32)))
    wait_until(
        lambda: hall.process.stderr and "died (exit code -9)" in hall.process.stderr.readline()
    )


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_all_end_together_and_leave_nothing(tmp_path, number):
    """Even with visitors in the middle of a picture; a Ctrl-C reaches all of them at once."""
    with ServeProcess(tmp_path, "--port", str(free_port())) as explorer:
        team = explorer.workers
        assert len(team) == 2
        with contextlib.suppress(websockets.exceptions.ConnectionClosed), visitor(explorer.url):
            if number == signal.SIGINT:
                for pid in team:
                    os.kill(pid, number)
            start = time.monotonic()
            assert explorer.end(number) == (0, "")
            assert time.monotonic() - start < 15
        assert not any(map(alive, team))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("after", [0.0, 0.2, 0.5, 0.8, 1.1])
def test_they_end_at_any_moment(tmp_path, after):
    """While they load, while they start; nothing is left, and no traceback."""
    explorer = ServeProcess(tmp_path, "--port", str(free_port()), processes=3)
    with explorer.process as process:
        wait_until(lambda: caught(process.pid))
        time.sleep(after)
        team = explorer.workers
        code, errors = explorer.end(signal.SIGTERM)
    assert code in (0, 128 + signal.SIGTERM, -signal.SIGTERM)
    assert errors == ""
    wait_until(lambda: not any(map(alive, team)))
    assert list(tmp_path.iterdir()) == []


def test_workers_do_not_outlive_the_first_process(tmp_path):
    """Even where that was killed and could not tell them."""
    with ServeProcess(tmp_path, "--port", str(free_port())) as explorer:
        team = explorer.workers
        explorer.process.kill()
        wait_until(lambda: not any(map(alive, team)))


def test_a_port_in_use_is_one_line(tmp_path, hall):
    """The same line and code as with one process."""
    port = hall.url.rsplit(":", 1)[1]
    second = ServeProcess(tmp_path, "--port", port)
    with second.process as process:
        out, errors = process.communicate(timeout=30)
    assert (process.returncode, out) == (1, "")
    assert errors.startswith(f"beamviz: cannot serve on 127.0.0.1:{port}")
    assert errors.count("\n") == 1


def test_a_host_that_does_not_exist_is_refused():
    """Before any process is started."""
    threads = threading.active_count()
    with pytest.raises(Unavailable, match=r"cannot serve on no\.such\.host"):
        serve(Scene(PAPER), host="no.such.host.invalid", port=0, processes=2)
    assert threading.active_count() == threads


def test_all_addresses_of_a_host_are_listened_to():
    """localhost has two where the machine speaks IPv6, on one port."""
    with listening_sockets("localhost", 0) as found:
        assert len({line.getsockname()[1] for line in found}) == 1
        assert {line.getsockname()[0] for line in found} >= {"127.0.0.1"}


@pytest.mark.parametrize(
    ("processes", "shared", "follow", "count"),
    [(None, False, False, 1), (None, True, True, 1), (1, True, False, 1), (3, False, False, 3)],
)
def test_how_many_there_are(processes, shared, follow, count):
    """One for oneself and for a lecture, as many as cores for others, unless told otherwise."""
    assert process_count(processes, shared=shared, follow=follow) == count
    cores = len(os.sched_getaffinity(0))
    assert process_count(None, shared=True, follow=False) == cores


def test_a_lecture_is_in_one_process():
    """The presenter's session is there for all to follow."""
    with pytest.raises(InvalidInput, match="--follow"):
        process_count(2, shared=True, follow=True)


def test_other_systems_have_one(monkeypatch):
    """Doubling a process is not safe, or not possible, there."""
    monkeypatch.setattr(sys, "platform", "win32")
    assert process_count(None, shared=True, follow=False) == 1
    with pytest.raises(InvalidInput, match="Linux"):
        process_count(2, shared=True, follow=False)


def test_each_process_counts_its_own_visitors():
    """All see the sum, in processes too."""
    visitor_count = VisitorCount(2)
    visitor_count.enter()
    if (child := os.fork()) == 0:
        visitor_count.process = 1
        visitor_count.enter()
        visitor_count.enter()
        os._exit(0)
    os.waitpid(child, 0)
    visitor_count.leave()
    assert visitor_count.total == 2
    assert visitor_count.counts.tolist() == [0, 2]


def test_a_page_is_the_same_from_every_process(hall):
    """It may come from one and open its WebSocket at another."""
    assert len({http_get(hall.url)[2] for _ in range(4)}) == 1
