"""The server: no work while nothing moves, where it listens, and a clean end."""

import contextlib
import os
import signal
import socket
import subprocess
import sys
import threading
import time

import pytest
import websockets.exceptions
from live.server import wait_until
from live.visitor import BEAM, PAPER, pause, visitor

from beamviz.errors import InvalidInput, Unavailable
from beamviz.explorer import app as server
from beamviz.explorer.app import explorer, serve
from beamviz.scene import Scene


def test_nothing_is_computed_while_nothing_moves(monkeypatch):
    """A paused visitor, and none at all, cost no time: the frame_loop does not even wake."""
    woken: list[float] = []
    sleep = server.FrameLoop.sleep

    def counted(frame_loop: server.FrameLoop, due: float) -> set[int]:
        woken.append(due)
        return sleep(frame_loop, due)

    monkeypatch.setattr(server.FrameLoop, "sleep", counted)
    with explorer(Scene(PAPER)) as address:
        with visitor(address) as guest:
            pause(guest)
            count = len(woken)
            assert load(0.6) < 0.02
            assert len(woken) == count
        time.sleep(0.3)
        count = len(woken)
        assert load(0.6) < 0.02
        assert len(woken) == count


def load(seconds: float) -> float:
    """The share of one core this process uses."""
    start = time.process_time()
    time.sleep(seconds)
    return (time.process_time() - start) / seconds


def test_a_visitor_who_leaves_is_forgotten(frame_loops):
    """Their session is closed, and the frame_loop keeps none of it."""
    with explorer(Scene(PAPER)) as address:
        with visitor(address):
            assert len(frame_loops[-1].sessions) == 1
        end = time.monotonic() + 5
        while frame_loops[-1].sessions and time.monotonic() < end:
            time.sleep(0.02)
        assert not frame_loops[-1].sessions


def test_a_page_of_another_site_cannot_open_a_session(url):
    """A browser names the page it acts for; only our own may connect."""
    with (
        pytest.raises(websockets.exceptions.InvalidStatus, match="403"),
        visitor(url, origin="http://evil.example"),
    ):
        pass
    local = url.replace("127.0.0.1", "localhost")
    with visitor(local, origin=local) as guest:
        assert BEAM in guest.nodes


def test_a_busy_port_is_said_in_one_line():
    """Unavailable names the address and the remedy; no other port is taken silently."""
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(Unavailable, match=rf"127\.0\.0\.1:{port} .*--port") as caught:
            serve(Scene(PAPER), port=port)
        assert "\n" not in str(caught.value)


@pytest.mark.parametrize("host", ["999.1.1.1", "192.0.2.1", "no such host"])
def test_a_host_that_is_not_here_is_said_at_once(host):
    """viser would wait for ever on it."""
    start = time.monotonic()
    with pytest.raises(Unavailable, match="--host"):
        serve(Scene(PAPER), host=host, port=0)
    assert time.monotonic() - start < 15


def test_options_that_make_no_sense_are_refused_before_serving():
    """An unknown strain law raises what solve raises."""
    with pytest.raises(InvalidInput, match="rubber"):
        serve(Scene(PAPER, {"strain": "rubber"}), port=0)


@pytest.mark.parametrize("ending", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_ends_the_server_cleanly(ending):
    """With a visitor watching: exit code 0, one line on stdout, nothing on stderr, port free."""
    process = subprocess.Popen(
        [sys.executable, "-c", SERVE],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": os.getcwd()},
    )
    try:
        assert process.stdout
        line = process.stdout.readline()
        address = next(word for word in line.split() if word.startswith("http://127.0.0.1:"))
        with contextlib.suppress(websockets.exceptions.ConnectionClosed), visitor(address) as guest:
            process.send_signal(ending)
            while True:
                guest.receive(10)
        output, errors = process.communicate(timeout=20)
    finally:
        process.kill()
    assert process.returncode == 0
    assert (output, errors) == ("", "")
    with socket.socket() as free:
        free.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        free.bind(("127.0.0.1", int(address.rsplit(":", 1)[1])))


SERVE = """
from beamviz.beam import Beam
from beamviz.scene import Scene
from beamviz.explorer.app import serve
serve(Scene(Beam(alpha=1, beta=0.5, gamma=10)), port=0)
"""


def test_no_thread_is_left_behind():
    """After an explorer has ended, neither what opens sessions nor its solvers run."""
    before = set(threading.enumerate())
    with explorer(Scene(PAPER)) as address, visitor(address):
        names = {thread.name.split("_")[0] for thread in set(threading.enumerate()) - before}
        assert "opener" in names

    def names_left() -> set[str]:
        return {thread.name.split("_")[0] for thread in set(threading.enumerate()) - before}

    wait_until(lambda: not {"opener", "solver", "charter"} & names_left())
