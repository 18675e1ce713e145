"""Several processes behind one address: by visits, by signals, by force."""

import contextlib
import os
import signal
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
import websockets.exceptions
from live.server import ServeProcess, free_port, handshake_status, http_get, is_alive, wait_until
from live.visitor import PAPER, frequency_text, visitor

from beamviz.errors import InvalidInput
from beamviz.server.processes import MIN_LIFETIME, listening_sockets, process_count

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="one process on other systems")


def open_sockets(pid: int) -> int:
    kinds = []
    for file in Path(f"/proc/{pid}/fd").iterdir():
        with contextlib.suppress(FileNotFoundError):  # closed meanwhile
            kinds.append(os.readlink(file))
    return sum(kind.startswith("socket:") for kind in kinds)


@pytest.fixture(scope="module")
def hall(tmp_path_factory) -> Iterator[ServeProcess]:
    """Two processes for at most five visitors."""
    options = ("--port", str(free_port()), "--visitors", "5")
    with ServeProcess(tmp_path_factory.mktemp("hall"), *options) as served:
        yield served


def test_visitors_are_shared_evenly_and_have_private_scenes(hall):
    """Two in each process do not see the edits of others. All processes send the same page."""
    wait_until(lambda: len({open_sockets(pid) for pid in hall.workers}) == 1)  # after the self-test
    before = [open_sockets(pid) for pid in hall.workers]
    with contextlib.ExitStack() as stack:
        guests = [stack.enter_context(visitor(hall.url)) for _ in range(4)]
        now = [open_sockets(pid) for pid in hall.workers]
        assert [n - m for n, m in zip(now, before, strict=True)] == [2, 2]
        for k, guest in enumerate(guests):
            guest.choose("gamma", 20.0 + k)
        for k, guest in enumerate(guests):
            guest.says(frequency_text(PAPER.replace(gamma=20 + k)))
    wait_until(lambda: [open_sockets(pid) for pid in hall.workers] == before)
    assert len({http_get(hall.url)[2] for _ in range(4)}) == 1


@pytest.mark.slow
def test_the_limit_of_visitors_is_that_of_all_processes(hall):
    """Five are served in any process; the sixth is refused, and served when one has left."""
    with contextlib.ExitStack() as stack:
        for _ in range(5):
            stack.enter_context(visitor(hall.url))
        for _ in range(4):  # by either process
            assert http_get(hall.url)[0] == 503
            assert handshake_status(hall.url) == 503
    wait_until(lambda: http_get(hall.url)[0] == 200)
    with visitor(hall.url):
        pass


@pytest.mark.slow
def test_a_worker_that_dies_is_replaced(hall):
    """Its visitor connects again, others are not affected; one line is printed."""
    time.sleep(max(0.0, hall.began + MIN_LIFETIME - time.monotonic()))
    with visitor(hall.url) as one, visitor(hall.url) as other:
        before = hall.workers
        os.kill(before[0], signal.SIGKILL)
        wait_until(lambda: len(hall.workers) == 2 and hall.workers != before)
        disconnected = 0
        for guest in (one, other):
            try:
                guest.edit(gamma=31.0)
            except websockets.exceptions.ConnectionClosed:
                disconnected += 1
        assert disconnected == 1
        with visitor(hall.url) as again:
            again.edit(gamma=32.0)
    wait_until(lambda: "died (exit code -9)" in hall.process.stderr.readline())


def test_workers_end_with_the_main_process(hall):
    """Even if that was killed. The last test of these processes."""
    workers = hall.workers
    hall.process.kill()
    wait_until(lambda: not any(map(is_alive, workers)))


@pytest.mark.slow
def test_one_visitor_has_one_process(tmp_path):
    """Several would count each other's self-test as visitors."""
    with ServeProcess(tmp_path, "--port", str(free_port()), "--visitors", "1") as served:
        assert not served.workers


def test_all_addresses_of_a_host_are_served():
    """localhost has two on a machine with IPv6, with one port."""
    with listening_sockets("localhost", 0) as found:
        assert len({line.getsockname()[1] for line in found}) == 1
        assert {line.getsockname()[0] for line in found} >= {"127.0.0.1"}


def test_the_number_of_processes(monkeypatch):
    """One for this machine, for a presenter or without fork, else one per core, unless set."""
    assert process_count(None, shared=False, follow=False) == 1
    assert process_count(None, shared=True, follow=True) == 1
    assert process_count(1, shared=True, follow=False) == 1
    assert process_count(3, shared=False, follow=False) == 3
    assert process_count(None, shared=True, follow=False) == len(os.sched_getaffinity(0))
    with pytest.raises(InvalidInput, match="--follow"):
        process_count(2, shared=True, follow=True)
    monkeypatch.setattr(sys, "platform", "win32")
    assert process_count(None, shared=True, follow=False) == 1
    with pytest.raises(InvalidInput, match="Linux"):
        process_count(2, shared=True, follow=False)
