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
from typing import Any

import pytest
import websockets.exceptions
from live.server import CAMERA_MESSAGE, encoded, raw_socket, wait_until
from live.visitor import BEAM, PAPER, Visitor, beam_moved, frequency_text, pause, visitor

from beamviz.beam import Beam
from beamviz.explorer import app as server
from beamviz.explorer import frames as frame_loop
from beamviz.explorer import jobs
from beamviz.explorer.app import FrameLoop, explorer
from beamviz.explorer.session import Session
from beamviz.scene import Scene
from beamviz.server import connection as guard
from beamviz.server import viser_private as hardening
from beamviz.solver import solve

SCENE = Scene(PAPER)
# Speeds at which the solver of these tests does not end by itself, is slow, or fails.
ENDLESS, SLOW, BROKEN = 46.0, 47.0, 48.0
ENOUGH = threading.Event()
SOLVED: list[Beam] = []
BAD = (float("nan"), float("inf"), -float("inf"), 1e300, -1e300, 2**63, -1, 0, "", "rubber",
       "9" * 900, True, [], [1, 2], ["a"], [float("nan")] * 3, [1e300, 2, 3])  # fmt: skip


@pytest.fixture(scope="module")
def url(frame_loops) -> Iterator[str]:
    """A running explorer; it takes its time for one speed, and fails at another."""

    def solved(beam: Beam, **options: Any) -> Any:
        SOLVED.append(beam)
        if beam.gamma == BROKEN:
            raise ZeroDivisionError("a mistake of ours")
        if beam.gamma == SLOW:
            time.sleep(1.0)
        if beam.gamma == ENDLESS:
            ENOUGH.wait(120)
        return solve(beam, **options)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(jobs, "solve", solved)
        with explorer(SCENE, max_visitors=200) as found:
            yield found


@pytest.fixture
def other(url) -> Iterator[Visitor]:
    """A visitor who has paused, and whose beam must be as it was when the test is over."""
    with visitor(url) as guest:
        pause(guest)
        yield guest
        pause(guest)
        assert frequency_text(PAPER) in guest.text
        assert "Stable equilibrium" in guest.text
        guest.choose("playing", True)
        guest.wait(beam_moved)


@pytest.fixture(autouse=True)
def fresh_log() -> None:
    """No line is left out because an earlier test has had it."""
    for module in (frame_loop, guard, hardening, jobs):
        module.log.reported.clear()


def vanish(line: socket.socket) -> None:
    """Leave without a word, as a laptop that is shut does."""
    line.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    line.shutdown(socket.SHUT_RDWR)


def alone(frame_loops: list[FrameLoop], count: int = 1) -> None:
    """Wait until only `count` sessions are left."""
    wait_until(lambda: len(frame_loops[0].sessions) == count)


def newest(frame_loops: list[FrameLoop]) -> Session:
    """The session of the guest who came last, beside one other, once it is counted."""
    wait_until(lambda: len(frame_loops[0].sessions) == 2)
    return frame_loops[0].sessions[max(frame_loops[0].sessions)]


# Visitors who leave


@pytest.mark.slow
def test_tabs_closed_in_the_middle_of_a_picture(url, other, frame_loops):
    """Ten visitors vanish while their beams move."""
    for _ in range(10):
        with visitor(url) as guest:
            guest.wait(beam_moved)
            vanish(guest.socket.socket)
    alone(frame_loops)


@pytest.mark.slow
def test_tabs_closed_in_the_middle_of_a_solution(url, other, frame_loops):
    """A later visitor gets an answer."""
    for _ in range(8):
        with visitor(url) as guest:
            guest.choose("gamma", SLOW)
            vanish(guest.socket.socket)
    alone(frame_loops)
    with visitor(url) as guest:
        guest.choose("gamma", 12.0)
        guest.says(frequency_text(PAPER.replace(gamma=12)))


def test_a_page_loaded_again_and_again(url, other, frame_loops):
    """Each load is a new visit that starts from the beginning."""
    for _ in range(5):
        with visitor(url) as guest:
            assert frequency_text(PAPER) in guest.text
    alone(frame_loops)


@pytest.mark.slow
def test_a_thousand_visits_leave_nothing_behind(url, other, frame_loops):
    """1000 that only connect, every 50th of which opens a session and leaves without a word: no
    session, thread or socket stays, and not one object for each of them."""
    come_and_go(url, visits=100)  # what is built once, is built
    alone(frame_loops)
    before = left()
    come_and_go(url, visits=1000)
    alone(frame_loops)
    wait_until(lambda: all(now <= then for now, then in zip(left(), before, strict=True)))


def come_and_go(url: str, visits: int, at_once: int = 50) -> None:
    """Connect and disconnect."""
    for _ in range(visits // at_once):
        with contextlib.ExitStack() as open_lines:
            lines = [open_lines.enter_context(raw_socket(url)) for _ in range(at_once)]
            for k in range(0, at_once, 50):
                lines[k].send(encoded(**CAMERA_MESSAGE))
                lines[k].recv(timeout=20)
                vanish(lines[k].socket)


def left() -> tuple[int, int, int]:
    """Threads that run, but for viser's own pool, which grows to its size once; open files and
    sockets; objects, in hundreds."""
    names = [thread.name for thread in threading.enumerate()]
    threads = sum(not name.startswith("ThreadPoolExecutor") for name in names)
    gc.collect()
    return threads, len(os.listdir("/proc/self/fd")), len(gc.get_objects()) // 100


# Messages


def test_messages_out_of_order(url, other):
    """Controls moved before the page said where its camera is, and cameras without end."""
    with raw_socket(url) as line:
        line.send(encoded(type="GuiUpdateMessage", uuid="nobody", updates={"value": "1"}))
        line.send(encoded(type="CommandTriggerMessage", uuid="nobody"))
        for k in range(50):
            line.send(
                encoded(
                    **CAMERA_MESSAGE | {"image_width": 1 + 600 * k, "image_height": 30001 - 600 * k}
                )
            )
        line.recv(timeout=20)
    with visitor(url) as guest:
        assert BEAM in guest.nodes


def test_a_flood_of_5000_values_ends_at_the_last(url, other):
    """None of them is queued: most are never solved, and the others are not held up."""
    with visitor(url) as guest:
        pause(guest)
        SOLVED.clear()
        for k in range(5000):
            guest.choose("gamma", 30 - 0.005 * k)
        guest.says(frequency_text(PAPER.replace(gamma=30 - 0.005 * 4999)))
        assert len(SOLVED) < 2500


@pytest.mark.slow
def test_no_control_takes_harm_from_a_bad_value(url, other, frame_loops, caplog, capfd):
    """Every action is sent three times with a value that makes no sense for most; the session goes
    on, and the log has at most a line for each kind of mistake."""
    for bad in BAD:
        caplog.clear()
        alone(frame_loops)
        with caplog.at_level(logging.WARNING), visitor(url) as guest:
            guest.choose("playing", False)
            session = newest(frame_loops)
            for action in 3 * list(session.visitor.page.handlers):
                guest.do(action, bad)
            wait_until(lambda: answered(guest, session, PAPER.replace(gamma=12)))  # noqa: B023
        lines = [record.getMessage() for record in caplog.records]
        assert all("\n" not in line for line in lines)
        assert len(lines) <= 2, (bad, lines)
        assert not [record for record in caplog.records if record.exc_info], bad
    assert "Traceback" not in capfd.readouterr().err


def answered(guest: Visitor, session: Session, beam: Beam) -> bool:
    """Set the five numbers, and see whether the answer is there; a button pressed just before
    may still put others in their place."""
    for name, value in beam.numbers.items():
        guest.choose(name, value)
    time.sleep(0.3)
    return session.visitor.answer is not None and session.visitor.answer.beam == beam


# Work that fails or takes long


def test_a_solver_that_fails_is_said_and_logged_in_one_line(url, other, caplog):
    """The visitor reads that it was unexpected; the next number is solved."""
    with visitor(url) as guest:
        for _ in range(3):
            guest.choose("gamma", 12.0)
            guest.wait(lambda _: "a mistake of ours" not in guest.text)
            guest.choose("gamma", BROKEN)
            guest.says("unexpected: a mistake of ours")
        guest.choose("gamma", 12.0)
        guest.says(frequency_text(PAPER.replace(gamma=12)))
    lines = [record for record in caplog.records if "a mistake of ours" in record.getMessage()]
    assert len(lines) == 1
    assert lines[0].exc_info in (None, False)


def test_a_slow_solver_does_not_stop_the_pictures(url, other):
    """While one visitor waits, another sees frames and gets answers."""
    other.choose("playing", True)
    with visitor(url) as guest:
        guest.choose("gamma", SLOW)
        frames, end = 0, time.monotonic() + 0.9
        while time.monotonic() < end:
            frames += beam_moved(other.receive(1.0))
        assert frames >= 5
        guest.says(frequency_text(PAPER.replace(gamma=SLOW)))


def test_solutions_without_end_stop_nobody_else(url, other):
    """More visitors wait for such a one than solve at once: another one sees frames, and gets
    answers as before."""
    other.choose("playing", True)
    with contextlib.ExitStack() as guests:
        for _ in range(server.SOLVERS + 1):
            guest = guests.enter_context(visitor(url))
            guests.callback(vanish, guest.socket.socket)
            guest.choose("gamma", ENDLESS)
        guests.callback(ENOUGH.set)
        for gamma in (12.0, 13.0):
            other.choose("gamma", gamma)
            other.says(frequency_text(PAPER.replace(gamma=gamma)))
            for _ in range(5):
                other.wait(beam_moved)
    other.choose("gamma", PAPER.gamma)
    other.says(frequency_text(PAPER))


@pytest.mark.slow
def test_solutions_without_end_stop_nobody_in_a_crowd(url, other, frame_loops):
    """Where all are answered in turn, such a one looks as quick as the last: another visitor sees
    frames, and gets answers as before."""
    with contextlib.ExitStack() as guests:
        ENOUGH.clear()
        crowd = [guests.enter_context(visitor(url)) for _ in range(frame_loop.CROWD)]
        for guest in crowd:
            guests.callback(vanish, guest.socket.socket)
        guests.callback(ENOUGH.set)
        wait_until(frame_loops[0].crowded)
        for guest in crowd[:3]:
            guest.choose("gamma", 11.0)
            guest.says(frequency_text(PAPER.replace(gamma=11)))
            guest.choose("gamma", ENDLESS)
        for gamma in (12.0, 13.0):
            crowd[-1].choose("gamma", gamma)
            crowd[-1].says(frequency_text(PAPER.replace(gamma=gamma)))
            for _ in range(20):
                crowd[-1].wait(beam_moved)
        sessions = list(frame_loops[0].sessions.values())
        assert sum(session.visitor.solver.busy for session in sessions) >= 3
    alone(frame_loops)


def test_the_server_ends_in_the_middle_of_a_solution_without_end(monkeypatch):
    """Ctrl-C need not wait for it."""
    begun, enough = threading.Event(), threading.Event()

    def solved(beam: Beam, **options: Any) -> Any:
        if beam.gamma == ENDLESS:
            begun.set()
            enough.wait()
        return solve(beam, **options)

    monkeypatch.setattr(jobs, "solve", solved)
    try:
        with explorer(SCENE) as found, visitor(found) as guest:
            guest.choose("gamma", ENDLESS)
            assert begun.wait(20)
            vanish(guest.socket.socket)
    finally:
        enough.set()


def test_drawing_that_fails_ends_that_visit_alone(url, other, frame_loops, caplog):
    """The page connects again, to a new session; the log has one line."""
    with visitor(url) as guest:
        session = newest(frame_loops)
        session.draw = lambda: 1 / 0
        with pytest.raises(websockets.exceptions.ConnectionClosed):
            guest.wait(lambda _: session.visitor.reset_view())  # a picture may be under way
        assert guest.socket.close_code == 1011
    alone(frame_loops)
    (line,) = [record.getMessage() for record in caplog.records if record.levelname == "ERROR"]
    assert re.search(r"drawing: failed for visitor \d+, .* disconnected: ZeroDivisionError", line)


def test_clocks_that_jump_do_not_stop_the_picture(url, other, monkeypatch):
    """The clock of the day jumps an hour back and a day forward."""
    now = time.time
    other.choose("playing", True)
    for jump in (-3600, 86400):
        monkeypatch.setattr(time, "time", lambda jump=jump: now() + jump)
        for _ in range(5):
            other.wait(beam_moved)


def test_a_machine_that_slept_goes_on_where_it_was(url, other, frame_loops):
    """Hours without a tick move the picture by 0.2 s at most."""
    session = next(iter(frame_loops[0].sessions.values()))

    async def angle_during_sleep() -> float:
        """Angle by which the rotor turns; on the event loop, where no other tick comes between."""
        before = session.view.clock.angle
        session.tick(session.last_tick + 36000.0)
        session.last_tick = time.monotonic()
        return (session.view.clock.angle - before) % math.tau

    other.choose("playing", True)
    other.wait(beam_moved)
    angle = asyncio.run_coroutine_threadsafe(angle_during_sleep(), frame_loops[0].loop).result(60)
    assert 0 < angle <= 0.2 * session.view.pace * PAPER.gamma + 1e-9
