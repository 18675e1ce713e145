"""The server in one process: no work while nothing moves, where it listens, and a clean end."""

import contextlib
import re
import signal
import socket
import threading
import time
from unittest import mock

import pytest
from helpers import slow
from live.server import ServeProcess, free_port, wait_until
from live.visitor import PAPER, pause, visitor
from websockets.exceptions import ConnectionClosed

from beamviz.errors import InvalidInput, Unavailable
from beamviz.explorer import app
from beamviz.explorer.app import explorer, serve
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


@pytest.mark.parametrize("processes", ["1", "2"])
def test_a_busy_port_is_an_error_of_one_line(run, processes):
    """With the address and the remedy; no other port is used silently."""
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = str(taken.getsockname()[1])
        code, out, err = run("serve", "--port", port, "--processes", processes)
    assert (code, out, err.count("\n")) == (1, "", 1)
    assert re.match(rf"beamviz: cannot serve on 127\.0\.0\.1:{port} .*--port", err)


@pytest.mark.parametrize("host", ["999.1.1.1", "192.0.2.1", "no such host"])
@pytest.mark.parametrize("processes", [1, 2])
def test_a_host_that_does_not_exist_is_an_error(host, processes):
    """viser would wait for it forever."""
    with pytest.raises(Unavailable, match=f"cannot serve on {host}.*--host"):
        serve(Scene(PAPER), host=host, port=0, processes=processes)


def test_invalid_options_are_refused_before_serving():
    with pytest.raises(InvalidInput, match="rubber"):
        serve(Scene(PAPER, {"strain": "rubber"}), port=0)


@pytest.mark.parametrize("number", [signal.SIGTERM, *slow(signal.SIGINT)])
def test_a_signal_ends_the_server_cleanly(tmp_path, number):
    """With a visitor connected: exit code 0, nothing on stderr, the port free."""
    port = free_port()
    with ServeProcess(tmp_path, "--port", str(port), processes=1) as served:
        with contextlib.suppress(ConnectionClosed), visitor(served.url) as guest:
            served.process.send_signal(number)
            while True:
                guest.receive(10)
        output, errors = served.process.communicate(timeout=20)
    assert (served.process.returncode, output, errors) == (0, "", "")
    with socket.create_server(("127.0.0.1", port)):
        pass
