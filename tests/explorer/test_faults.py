"""What a hall can do to the explorer, done to it: afterwards the others are served as before."""

import asyncio
import contextlib
import gc
import logging
import math
import os
import re
import socket
import struct
import threading
import time
from collections.abc import Iterator
from functools import partial
from typing import Any

import pytest
import websockets.exceptions
from live.server import CAMERA_MESSAGE, TIMEOUT, encoded, last_until, raw_socket, wait_until
from live.visitor import BEAM, PAPER, Visitor, beam_moved, frequency_text, pause, visitor

from beamviz.beam import Beam
from beamviz.explorer import FrameLoop, explorer, frame_loop, jobs, solutions
from beamviz.scene import Scene
from beamviz.server import connection, viser_private
from beamviz.solver import solve

SCENE = Scene(PAPER)
ENDLESS, BROKEN = 46.0, 48.0  # speeds at which the solver does not end by itself, or fails
ENOUGH = threading.Event()
SOLVED: list[Beam] = []
BAD = (float("nan"), -float("inf"), 1e300, 2**63, -1, "", "9" * 900, True, [1, 2], ["a"])


@pytest.fixture(scope="module")
def url(frame_loops) -> Iterator[str]:
    """A running explorer whose solver does not end for one speed and fails for another."""

    def solved(beam: Beam, **options: Any) -> Any:
        SOLVED.append(beam)
        if beam.gamma == BROKEN:
            raise ZeroDivisionError("a mistake of ours")
        if beam.gamma == ENDLESS:
            last_until(ENOUGH)
        return solve(beam, **options)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(solutions, "solve", solved)
        with explorer(SCENE, max_visitors=200) as found:
            yield found


@pytest.fixture
def other(url) -> Iterator[Visitor]:
    """A paused visitor whose beam must be unchanged at the end of the test."""
    with visitor(url) as guest:
        pause(guest)
        yield guest
        pause(guest)
        assert frequency_text(PAPER) in guest.text
        assert "Stable equilibrium" in guest.text
        guest.choose("playing", True, until=beam_moved)


@pytest.fixture(autouse=True)
def fresh_log() -> None:
    """Clear the log, so that no line is skipped because of an earlier test."""
    for module in (frame_loop, connection, viser_private, jobs):
        module.log.reported.clear()


def vanish(line: socket.socket) -> None:
    """Disconnect without closing, as a laptop that is shut."""
    line.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    line.shutdown(socket.SHUT_RDWR)


def alone(frame_loops: list[FrameLoop], count: int = 1) -> None:
    """Wait until there are only `count` sessions."""
    wait_until(lambda: len(frame_loops[0].sessions) == count)


@pytest.mark.slow
def test_many_visits_leak_nothing(url, other, frame_loops):
    """Of 200 every 50th opens a session: no session, thread, socket or object for each is left."""
    come_and_go(url, visits=50)  # what is built once, is built
    alone(frame_loops)
    threads, files, objects = left()
    come_and_go(url, visits=200)
    alone(frame_loops)
    most = threads, files, objects + 150  # a visit that left one object would leave 200
    wait_until(lambda: all(now <= limit for now, limit in zip(left(), most, strict=True)))


def come_and_go(url: str, visits: int) -> None:
    """Connect and disconnect, 50 at once."""
    for _ in range(visits // 50):
        with contextlib.ExitStack() as open_lines:
            line, *_ = [open_lines.enter_context(raw_socket(url)) for _ in range(50)]
            line.send(encoded(**CAMERA_MESSAGE))
            line.recv(timeout=TIMEOUT)
            vanish(line.socket)


def left() -> tuple[int, int, int]:
    """Numbers of threads, without those of pools, which start when all others are at work; of open
    files and sockets; of objects."""
    names = [thread.name for thread in threading.enumerate()]
    threads = sum(not name.startswith(("ThreadPoolExecutor", "solver", "chart")) for name in names)
    gc.collect()
    return threads, len(os.listdir("/proc/self/fd")), len(gc.get_objects())


def test_messages_may_come_out_of_order(url, other):
    """Controls are moved before the page has sent its camera; cameras are sent without a pause."""
    with raw_socket(url) as line:
        line.send(encoded(type="GuiUpdateMessage", uuid="nobody", updates={"value": "1"}))
        line.send(encoded(type="CommandTriggerMessage", uuid="nobody"))
        for k in range(1, 30002, 600):
            size = {"image_width": k, "image_height": 30002 - k}
            line.send(encoded(**CAMERA_MESSAGE | size))
        line.recv(timeout=TIMEOUT)
    with visitor(url) as guest:
        assert BEAM in guest.nodes


def test_of_5000_values_the_last_one_is_solved(other, connected):
    """And other visitors are not delayed."""
    pause(connected)
    for k in range(5000):
        connected.choose("gamma", 30 - 0.005 * k)
    connected.says(frequency_text(PAPER.replace(gamma=30 - 0.005 * 4999)))


@pytest.mark.slow
def test_every_action_tolerates_invalid_values(url, other, frame_loops, caplog, capfd):
    """Every action is sent twice with a value that is invalid for most; the session continues, and
    the log has at most one line for each kind of error."""
    beam = PAPER.replace(gamma=12)
    file = f"twelve.toml\n{Scene(beam).to_toml()}"

    def is_solved(guest: Visitor, own: Any) -> bool:
        """Open a file, and again, as a job may end meanwhile."""
        guest.do("load", file)
        answer, *_ = own.solver.compared
        return answer is not None and answer.beam == beam

    for bad in BAD:
        caplog.clear()
        alone(frame_loops)
        with caplog.at_level(logging.WARNING), visitor(url) as guest:
            guest.choose("playing", False)
            alone(frame_loops, 2)
            own = frame_loops[0].sessions[max(frame_loops[0].sessions)].visitor
            for action in 2 * list(own.page.actions):
                guest.do(action, bad)
            wait_until(partial(is_solved, guest, own))
        lines = [record.getMessage() for record in caplog.records]
        assert len(lines) <= 2, (bad, lines)
        assert "\n" not in "".join(lines)
        assert not any(record.exc_info for record in caplog.records), bad
    assert "Traceback" not in capfd.readouterr().err


def test_an_unexpected_error_of_the_solver_is_shown_and_logged_once(other, connected, caplog):
    """The visitor reads that it was unexpected; the next number is solved."""
    for _ in range(3):
        connected.choose("gamma", 12.0, until=lambda _: "a mistake of ours" not in connected.text)
        connected.choose("gamma", BROKEN, until="unexpected: a mistake of ours")
    connected.edit(gamma=12.0)
    (line,) = [record for record in caplog.records if "a mistake of ours" in record.getMessage()]
    assert not line.exc_info


def test_endless_solves_do_not_delay_other_visitors(url, other, frame_loops):
    """Three visitors wait for one. Another visitor gets frames and answers as before, and so does a
    later one, as visitors may vanish during drawing and solves."""
    with contextlib.ExitStack() as guests:
        ENOUGH.clear()
        guests.callback(ENOUGH.set)
        *crowd, last = [guests.enter_context(visitor(url)) for _ in range(4)]
        for guest in (*crowd, last):
            guests.callback(vanish, guest.socket.socket)
        alone(frame_loops, 5)
        for guest in crowd:
            guest.edit(gamma=11.0)
            guest.choose("gamma", ENDLESS)
        for gamma in (12.0, 13.0):
            last.edit(gamma=gamma)
            for _ in range(20):
                last.wait(beam_moved)
        sessions = list(frame_loops[0].sessions.values())
        assert sum(session.visitor.solver.busy for session in sessions) == len(crowd)
    alone(frame_loops)
    with visitor(url) as guest:
        guest.edit(gamma=14.0)


def test_the_server_stops_during_an_endless_solve(url):
    """Ctrl-C does not wait for it."""
    ENOUGH.clear()
    SOLVED.clear()
    try:
        with explorer(SCENE) as found, visitor(found) as guest:
            guest.choose("gamma", ENDLESS)
            wait_until(lambda: any(beam.gamma == ENDLESS for beam in SOLVED))
            vanish(guest.socket.socket)
    finally:
        ENOUGH.set()


def test_an_error_in_drawing_ends_only_this_session(other, connected, served, frame_loops, caplog):
    """The page connects again, to a new session; the log has one line."""
    served.draw = lambda *_: 1 / 0
    with pytest.raises(websockets.exceptions.ConnectionClosed):
        connected.wait(lambda _: served.visitor.wake())  # a picture may be under way
    assert connected.socket.close_code == 1011
    alone(frame_loops)
    (line,) = [record.getMessage() for record in caplog.records if record.levelname == "ERROR"]
    assert re.search(r"drawing: failed for visitor \d+, .* disconnected: ZeroDivisionError", line)


def test_an_error_in_opening_a_session_ends_only_that(other, url, frame_loops, caplog, monkeypatch):
    """The page connects again, and does not wait for ever; the log has one line."""

    def broken(*given: Any) -> Any:
        raise RuntimeError("a mistake of ours")

    monkeypatch.setattr(frame_loop, "Session", broken)
    with raw_socket(url) as line:
        guest = Visitor(line)
        with pytest.raises(websockets.exceptions.ConnectionClosed):
            guest.wait(lambda _: False, timeout=10.0)
    assert line.close_code == 1011
    alone(frame_loops)
    (told,) = [record.getMessage() for record in caplog.records if record.levelname == "ERROR"]
    assert re.search(r"opening: failed for visitor \d+, .* disconnected: RuntimeError", told)


def test_motion_goes_on_after_jumps_of_the_system_time_and_a_sleep(other, frame_loops, monkeypatch):
    """By an hour back and a day forward. Hours without a tick advance it by at most 0.2 s."""
    session, now = list(frame_loops[0].sessions.values())[-1], time.time

    async def angle_during_sleep() -> float:
        """The angle of the hub after a sleep; on the event loop, so between other ticks."""
        before = session.visitor.clock.angle
        session.tick(session.last_tick + 36000.0)
        session.last_tick = time.monotonic()
        return (session.visitor.clock.angle - before) % math.tau

    other.choose("playing", True)
    for jump in (-3600, 86400):
        monkeypatch.setattr(time, "time", lambda jump=jump: now() + jump)
        for _ in range(5):
            other.wait(beam_moved)
    wait_until(lambda: session.is_moving)
    angle = asyncio.run_coroutine_threadsafe(angle_during_sleep(), frame_loops[0].loop).result(
        TIMEOUT
    )
    assert 0 < angle <= 0.2 * session.snapshot.rate * PAPER.gamma + 1e-9
