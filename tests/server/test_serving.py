"""The server in one process: no work while nothing moves, where it listens, and a clean end."""

import contextlib
import os
import re
import signal
import socket
import sys
import threading
import time
from unittest import mock

import pytest
from helpers import slow
from live.server import ServeProcess, free_port, is_alive, wait_until
from live.visitor import PAPER, pause, visitor
from websockets.exceptions import ConnectionClosed

from beamviz import explorer as app
from beamviz.errors import InvalidInput
from beamviz.explorer import explorer, serve
from beamviz.explorer.jobs import PATIENCE
from beamviz.scene import Scene


def test_nothing_is_computed_while_nothing_moves(monkeypatch):
    """With a paused visitor, and without any, the frame loop does not wake."""
    sleep = mock.Mock(wraps=app.FrameLoop.sleep)
    monkeypatch.setattr(app.FrameLoop, "sleep", lambda loop, due: sleep(loop, due))

    def wakes() -> int:
        sleep.reset_mock()
        time.sleep(1.2 * PATIENCE)  # a loop that is awake sleeps less
        return sleep.call_count

    with explorer(Scene(PAPER)) as url:
        with visitor(url) as guest:
            pause(guest)
            wait_until(lambda: wakes() == 0)  # once charts and what else was asked for are there
        wait_until(lambda: wakes() == 0)


def test_an_explorer_leaves_no_thread():
    """Neither that opens sessions nor its solvers."""
    before = set(threading.enumerate())

    def new_threads() -> set[str]:
        return {thread.name.split("_")[0] for thread in set(threading.enumerate()) - before}

    with explorer(Scene(PAPER)) as url, visitor(url):
        assert "opener" in new_threads()
    wait_until(lambda: not {"opener", "solver", "chart"} & new_threads())


@pytest.mark.parametrize("host", ["127.0.0.1", "999.1.1.1", "192.0.2.1", "no such host"])
@pytest.mark.parametrize("processes", ["1", "2"])
def test_a_busy_port_or_a_host_that_does_not_exist_is_an_error_of_one_line(run, processes, host):
    """With the address and the remedy; no other port is used silently, and viser would wait for
    such a host forever."""
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = str(taken.getsockname()[1])
        code, out, err = run("serve", "--host", host, "--port", port, "--processes", processes)
    assert (code, out, err.count("\n")) == (1, "", 1)
    assert re.match(rf"beamviz: cannot serve on {host}:{port} .*--port or --host", err)


def test_invalid_options_are_refused_before_serving():
    with pytest.raises(InvalidInput, match="rubber"):
        serve(Scene(PAPER, {"strain": "rubber"}), port=0)


@pytest.mark.parametrize(
    ("number", "processes"),
    [(signal.SIGTERM, 1), *slow((signal.SIGINT, 1), (signal.SIGTERM, 2), (signal.SIGINT, 2))],
)
def test_a_signal_ends_the_server_cleanly(tmp_path, number, processes):
    """With a visitor connected; Ctrl-C reaches all processes at once. Exit code 0, nothing on
    stderr, no process and no file is left, and the port is free."""
    if processes > 1 and sys.platform != "linux":
        pytest.skip("one process on other systems")
    port = free_port()
    with ServeProcess(tmp_path, "--port", str(port), processes=processes) as served:
        workers = served.workers if processes > 1 else []
        assert processes == max(len(workers), 1)
        with contextlib.suppress(ConnectionClosed), visitor(served.url) as guest:
            for pid in [*(workers if number == signal.SIGINT else ()), served.process.pid]:
                os.kill(pid, number)
            while True:
                guest.receive(10)
        output, errors = served.process.communicate(timeout=60)
    assert (served.process.returncode, output, errors) == (0, "", "")
    assert not any(map(is_alive, workers))
    assert list(tmp_path.iterdir()) == []
    with socket.create_server(("127.0.0.1", port)):
        pass
