"""The server, in one process and in several behind one address: where it listens, who is served by
whom, no work while nothing moves, and a clean end."""

import contextlib
import os
import re
import signal
import socket
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from live.server import TIMEOUT, ServeProcess, handshake_status, http_get, is_alive, wait_until
from live.visitor import PAPER, pause, visitor
from websockets.exceptions import ConnectionClosed

from beamviz.errors import InvalidInput
from beamviz.explorer import explorer, serve
from beamviz.explorer.jobs import PATIENCE
from beamviz.scene import Scene
from beamviz.server.processes import MIN_LIFETIME, listening_sockets, process_count

on_linux = pytest.mark.skipif(sys.platform != "linux", reason="one process on other systems")


@pytest.mark.slow
def test_nothing_is_computed_while_nothing_moves():
    """With a paused visitor, and without any, the frame loop does not wake."""

    def is_idle() -> bool:
        """Whether the process uses less than a twentieth of a processor; frames take more."""
        began = time.process_time()
        time.sleep(1.2 * PATIENCE)
        return time.process_time() - began < 0.05 * 1.2 * PATIENCE

    with explorer(Scene(PAPER)) as url:
        with visitor(url) as guest:
            pause(guest)
            wait_until(is_idle)  # once charts and what else was asked for are there
        wait_until(is_idle)


def test_an_explorer_leaves_no_thread():
    """Neither that opens sessions nor its solvers."""
    before = set(threading.enumerate())

    def new_threads() -> set[str]:
        return {thread.name.split("_")[0] for thread in set(threading.enumerate()) - before}

    with explorer(Scene(PAPER)) as url, visitor(url):
        assert "opener" in new_threads()
    wait_until(lambda: not {"opener", "solver", "solver batch", "chart"} & new_threads())


@pytest.mark.parametrize(
    ("processes", "host"),
    [("1", "127.0.0.1"), ("1", "no such host"), ("2", "127.0.0.1"), ("2", "192.0.2.1")],
)
def test_a_busy_port_or_a_host_that_does_not_exist_is_an_error_of_one_line(run, processes, host):
    """With the address and the remedy; no other port is used, and nothing waits for the host."""
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = str(taken.getsockname()[1])
        code, out, err = run("serve", "--host", host, "--port", port, "--processes", processes)
    assert (code, out, err.count("\n")) == (1, "", 1)
    assert re.match(rf"beamviz: cannot serve on {host}:{port} .*--port or --host", err)


def test_invalid_options_are_refused_before_serving():
    with pytest.raises(InvalidInput, match="rubber"):
        serve(Scene(PAPER, {"strain": "rubber"}), port=0)


# Several processes


def open_sockets(pid: int) -> int:
    return sum(file.is_socket() for file in Path(f"/proc/{pid}/fd").iterdir())


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """Of the temporary files of `hall`."""
    return tmp_path_factory.mktemp("hall")


@pytest.fixture(scope="module")
def hall(folder) -> Iterator[ServeProcess]:
    """Two processes for at most five visitors."""
    with ServeProcess(folder, "--visitors", "5") as served:
        yield served


def ended(
    served: ServeProcess, folder: Path, pids: list[int], number: signal.Signals
) -> tuple[int, str, str]:
    """Exit code, stdout and stderr of a server that gets a signal while a visitor is connected. No
    process and no file is left, and its port is free."""
    workers = served.workers
    with contextlib.suppress(ConnectionClosed), visitor(served.url) as guest:
        for pid in pids:
            os.kill(pid, number)
        while True:
            guest.receive(TIMEOUT)
    output, errors = served.process.communicate(timeout=TIMEOUT)
    assert not any(map(is_alive, workers))
    assert list(folder.iterdir()) == []
    with socket.create_server(("127.0.0.1", served.port)):
        pass
    return served.process.returncode, output, errors


@on_linux
def test_visitors_are_shared_evenly_and_have_private_scenes(hall):
    """Two in each process do not see the edits of others. All processes send the same page, and
    share one limit: five visitors are served, the sixth is refused until one has left."""
    first, second = hall.workers  # which has inherited one of the first
    wait_until(lambda: open_sockets(second) == open_sockets(first) + 1)  # after the self-test
    before = [open_sockets(pid) for pid in hall.workers]
    assert len({http_get(hall.url)[2] for _ in range(4)}) == 1
    with contextlib.ExitStack() as stack:
        guests = [stack.enter_context(visitor(hall.url)) for _ in range(4)]
        two_more = [count + 2 for count in before]
        wait_until(lambda: [open_sockets(pid) for pid in hall.workers] == two_more)
        for k, guest in enumerate(guests):
            guest.choose("gamma", 20.0 + k)
        for k, guest in enumerate(guests):
            guest.shows(PAPER.replace(gamma=20 + k))
        stack.enter_context(visitor(hall.url))
        for _ in range(4):  # by either process
            assert http_get(hall.url)[0] == 503
            assert handshake_status(hall.url) == 503
    wait_until(lambda: [open_sockets(pid) for pid in hall.workers] == before)
    wait_until(lambda: http_get(hall.url)[0] == 200)
    with visitor(hall.url):
        pass


@on_linux
@pytest.mark.slow
def test_a_worker_that_dies_is_replaced(hall):
    """Its visitor connects again, others are not affected; one line is printed."""
    time.sleep(max(0.0, hall.began + MIN_LIFETIME - time.monotonic()))
    with visitor(hall.url) as one, visitor(hall.url) as other:
        before = hall.workers
        os.kill(before[0], signal.SIGKILL)
        wait_until(lambda: len(hall.workers) == 2 and hall.workers != before)
        served = []
        for guest in (one, other):
            with contextlib.suppress(ConnectionClosed):
                guest.edit(gamma=31.0)
                served.append(guest)
        assert len(served) == 1
        with visitor(hall.url) as again:
            again.edit(gamma=32.0)
    wait_until(lambda: "died (exit code -9)" in hall.process.stderr.readline())


@on_linux
def test_a_signal_ends_the_server_cleanly(hall, folder):
    """With a visitor connected. SIGTERM is how a service is ended: exit code 0, and nothing on
    stderr. The last test of these processes."""
    assert ended(hall, folder, [hall.process.pid], signal.SIGTERM) == (0, "", "")


@on_linux
@pytest.mark.slow
@pytest.mark.parametrize("visitors", ["1", "5"])
def test_ctrl_c_ends_the_server_cleanly(tmp_path, visitors):
    """It reaches all processes at once. One visitor has one process: several would count each
    other's self-test as visitors."""
    with ServeProcess(tmp_path, "--visitors", visitors) as served:
        assert len(served.workers) == (0 if visitors == "1" else 2)
        pids = [*served.workers, served.process.pid]
        assert ended(served, tmp_path, pids, signal.SIGINT) == (130, "", "beamviz: interrupted\n")


@on_linux
@pytest.mark.slow
def test_workers_end_with_the_main_process(tmp_path):
    """Even if that was killed."""
    with ServeProcess(tmp_path) as served:
        workers = served.workers
        served.process.kill()
        wait_until(lambda: not any(map(is_alive, workers)))


def test_all_addresses_of_a_host_are_served():
    """localhost has two on a machine with IPv6, with one port."""
    with listening_sockets("localhost", 0) as found:
        assert len({line.getsockname()[1] for line in found}) == 1
        assert {line.getsockname()[0] for line in found} >= {"127.0.0.1"}


@on_linux
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
