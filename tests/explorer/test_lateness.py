"""What is shown belongs to the numbers shown; what does not yet says so, and only that."""

import re
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import Any

import pytest
from helpers import slow
from live.fresh import Guest
from live.server import TIMEOUT, frame_loop_at, held_back, wait_until
from live.visitor import Visitor, frequency_text, pause, visitor

from beamviz.explorer import computed_loci, frame_loop, jobs, solutions
from beamviz.explorer.features import loads
from beamviz.explorer.features import map as map_tab
from beamviz.explorer.jobs import LATE, OUTDATED, PATIENCE, Job
from beamviz.explorer.session import Session
from beamviz.explorer.state import State
from beamviz.scene import START
from beamviz.solver import solve

FIRST = START


class Computer:
    """A job whose computations end, and whose time passes, when it is told so."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch):
        self.now, self.waiting = 1.0, list[Callable[[], None]]()
        monkeypatch.setattr(jobs.time, "monotonic", lambda: self.now)
        self.job: Job[int, int] = Job("test", lambda one: one, self.waiting.append, lambda: None)

    def after(self, seconds: float) -> Any:
        """The status after some seconds."""
        self.now += seconds
        return self.job.status

    def compute(self) -> None:
        """Compute what was begun."""
        self.waiting.pop(0)()


@pytest.fixture
def computer(monkeypatch) -> Computer:
    return Computer(monkeypatch)


def test_an_answer_is_late_since_its_request_was_replaced(computer):
    """Not before LATE, and until the next one is there; to cancel is offered later."""
    computer.job.request(1)
    computer.compute()
    assert not computer.after(10).late
    computer.job.request(2)
    assert not computer.after(0.9 * LATE).late
    assert computer.after(0.2 * LATE).late
    assert not computer.job.status.slow
    assert computer.after(PATIENCE).slow
    computer.compute()
    assert not computer.job.status.late


def test_a_request_that_is_replaced_before_its_work_begins_leaves_nothing_late(computer):
    """The work is that of the latest one then."""
    computer.job.request(1)
    computer.job.request(2)
    computer.compute()
    assert (computer.job.status.result, computer.job.busy) == (2, False)
    assert not computer.after(10).late


@pytest.mark.parametrize(("seconds", "late"), [(0.25 * LATE, False), (1.5 * LATE, True)])
def test_during_a_drag_an_answer_is_late_if_it_is_older_than_that(computer, seconds, late):
    """Each answer is that to an earlier request, but if computed quickly it is hardly older."""
    computer.job.request(0)
    computer.compute()
    found = []
    for k in range(1, 200):
        computer.job.request(k)
        found.append(computer.after(0.1 * LATE).late)
        if computer.now - computer.job.run.started >= seconds:
            computer.compute()
    assert any(found[50:]) is late
    assert computer.job.status.answer.result < 199


def test_back_at_the_numbers_of_the_answer_nothing_is_late(computer):
    """As after undo: what was begun meanwhile does not replace it."""
    computer.job.request(1)
    computer.compute()
    computer.job.request(2)
    assert computer.after(2 * LATE).late
    computer.job.request(1)
    assert not computer.job.status.late
    computer.compute()
    assert (computer.job.status.result, computer.job.busy) == (1, False)


def test_an_answer_is_late_while_its_next_request_is_not_known(computer):
    """As it follows from an answer to come; and it is not late any more if nothing has changed."""
    for request in (1, 2, 1):
        computer.job.request(request)
        computer.compute()
        computer.job.expect()
        assert computer.after(2 * LATE).late
        computer.job.request(request)
        assert not computer.job.status.late
        computer.job.expect()
        assert computer.after(2 * LATE).late
        computer.job.request(3)
        assert computer.job.status.late
        computer.job.expect()
        computer.compute()
        assert (computer.job.status.result, computer.job.status.busy) == (request, False)
        computer.job.request(3)
        computer.compute()
        assert (computer.job.status.result, computer.job.status.late) == (3, False)
        computer.job.expect()
        computer.job.withdraw()
        assert not computer.after(2 * LATE).late


def test_nothing_is_late_after_a_request_that_does_not_come(computer):
    """As when a tab is closed: what was begun is computed, and the last answer is not outdated."""
    computer.job.request(1)
    computer.compute()
    computer.job.expect()
    assert computer.after(2 * LATE).late
    computer.job.settle()
    assert not computer.job.status.late
    computer.job.request(2)
    computer.job.expect()
    computer.job.settle()
    computer.compute()
    assert (computer.job.status.result, computer.job.busy) == (2, False)
    assert not computer.after(2 * LATE).late


def test_a_request_replaced_before_it_is_begun_leaves_nothing_late(computer):
    """Where all threads are at work, it is the latest request that is computed when one is free."""
    computer.job.request(1)
    computer.after(0.5)
    computer.job.request(2)
    computer.compute()
    assert computer.job.status.result == 2
    assert not computer.after(2 * PATIENCE).late
    assert not computer.job.status.slow


# On the page

LISTS = ("loci-events", "loci-resonances")


def test_a_computation_that_has_waited_has_its_time(computer):
    """Where all threads are at work it begins late, and is not given up for the next request before
    it has taken as long as another."""
    computer.job.request(1)
    computer.after(2 * OUTDATED)
    run, seen = computer.job.run, list[float]()

    def compute(request: int) -> int:
        computer.job.request(request + 1)
        while True:
            computer.after(0.1)
            seen.append(computer.now)
            computer.job.check(run)

    computer.job.compute = compute
    begun = computer.now
    computer.compute()
    assert seen[-1] - begun == pytest.approx(OUTDATED, abs=0.2)


@pytest.fixture
def guest(connected) -> Visitor:
    """A visitor with a connection: what is late depends on time."""
    return connected


@pytest.fixture
def session(served) -> Session:
    """The session of `guest`."""
    return served


@pytest.fixture
def release(monkeypatch) -> Iterator[threading.Event]:
    """An event that charts and solves wait for while it is cleared; nothing is offered to be
    cancelled meanwhile."""
    event = threading.Event()
    event.set()
    monkeypatch.setattr(jobs, "PATIENCE", TIMEOUT)
    yield event
    event.set()


@pytest.fixture(autouse=True)
def small_map(monkeypatch) -> None:
    """A map that is computed sooner."""
    monkeypatch.setattr(map_tab, "SIZE", (9, 5))


def told(guest: Visitor, id: str) -> str:
    """What an element says of its numbers, "" for nothing."""
    return guest.props[id].get("data-outdated") or ""


@pytest.mark.parametrize(
    ("module", "name", "tab", "chart", "others"),
    [
        (computed_loci, "loci", "frequencies", "loci-chart", LISTS),
        (map_tab, "solve_in_memory", "map", "map-chart", ("map-text",)),
        *slow(
            (computed_loci, "loci", "veering", "veering-chart", ("veering-shapes",)),
            (loads, "loads_along", "loads", "loads-axial", ("loads-text",)),
        ),
    ],
)
def test_a_chart_of_earlier_numbers_says_so(
    guest, release, monkeypatch, module, name, tab, chart, others
):
    """Until it is that of the numbers shown; and it has not changed meanwhile."""
    monkeypatch.setattr(module, name, held_back(getattr(module, name), release))
    pause(guest)
    guest.do("tab", tab)
    guest.wait(lambda _: guest.charts[chart].get("lines") or guest.charts[chart].get("values"))
    release.clear()
    before = dict(guest.charts[chart])
    guest.do("delta", 0.7)
    guest.wait(lambda _: "outdated" in told(guest, chart) and not told(guest, "mode-rows"))
    assert all(told(guest, one) for one in others)
    for one in ("lines", "values"):
        assert guest.charts[chart].get(one) == before.get(one)
    release.set()
    guest.wait(lambda _: not told(guest, chart) and guest.charts[chart] != before)
    assert not any(told(guest, one) for one in others)


def test_undo_takes_back_what_was_said_of_a_chart(guest, release, monkeypatch):
    """Though the other one is still being computed."""
    monkeypatch.setattr(computed_loci, "loci", held_back(computed_loci.loci, release))
    guest.wait(lambda _: guest.charts["loci-chart"].get("lines"))
    pause(guest)
    release.clear()
    guest.do("delta", 0.7)
    guest.wait(lambda _: told(guest, "loci-chart"))
    guest.do("undo")
    guest.wait(lambda _: not told(guest, "loci-chart"))


@pytest.mark.parametrize(("tab", "chart"), [("frequencies", "loci-chart"), ("map", "map-chart")])
def test_the_handle_of_a_chart_is_at_the_numbers_also_before_they_are_solved(
    guest, release, monkeypatch, tab, chart
):
    """A key moves it from there, not from where the beam was."""
    pause(guest)
    guest.do("tab", tab)
    guest.wait(lambda _: guest.charts[chart].get("cursor"))
    monkeypatch.setattr(solutions, "solve", held_back(solve, release))
    release.clear()
    guest.do("gamma", 7.0)
    guest.wait(lambda _: guest.charts[chart]["cursor"]["x"] == 7.0)
    guest.wait(lambda _: told(guest, "mode-rows"))
    release.set()
    guest.wait(lambda _: not told(guest, "mode-rows"))
    assert guest.charts[chart]["cursor"]["x"] == 7.0


def test_beam_and_table_of_earlier_numbers_say_so(guest, release, monkeypatch):
    """While these are being solved, and with them the chart; not after that."""
    guest.wait(lambda _: guest.charts["loci-chart"].get("lines"))
    pause(guest)
    monkeypatch.setattr(solutions, "solve", held_back(solve, release))
    release.clear()
    guest.do("alpha", 3.0)
    guest.wait(lambda _: "beam before the last change" in guest.texts["scene-caption"])
    guest.wait(lambda _: all(told(guest, id) for id in ("mode-rows", "equilibrium", "loci-chart")))
    release.set()
    guest.says(frequency_text(START.beam.replace(alpha=3)))
    guest.wait(lambda _: not any(told(guest, id) for id in ("mode-rows", "loci-chart")))
    assert "before the last change" not in guest.texts["scene-caption"]


def test_a_comparison_has_the_title_of_its_own_beam(guest, release, monkeypatch):
    """While the next one is being solved, table and scene show the one before under its name, and
    say that it is of earlier numbers."""

    def titles() -> set[str]:
        """What the table calls the second beam, and what the scene does."""
        (in_table,) = re.findall("this beam, .*?</th>.*?>([^<]*), [^,<]*</th>", told_of(guest))
        drawn = [one["text"] for one in guest.parts["captions"] if one["name"].endswith("/title")]
        return {in_table, *drawn} - {"this beam"}

    pause(guest)
    guest.do("tab", "compare")
    guest.do("stacked", True)
    guest.do("comparison", "ancf", until="20 ANCF elements, ")
    guest.wait(lambda _: titles() == {"20 ANCF elements"})
    before = told_of(guest)
    monkeypatch.setattr(solutions, "solve", held_back(solve, release))
    release.clear()
    guest.do("comparison", "mass", until=lambda _: told(guest, "comparison"))
    assert guest.values["comparison"] == "mass"
    assert told_of(guest) == before
    assert titles() == {"20 ANCF elements"}
    assert "beam before the last change" in guest.texts["scene-caption"]
    release.set()
    guest.wait(lambda _: titles() == {"twice the mass"} and not told(guest, "comparison"))
    assert told_of(guest) != before


def told_of(guest: Visitor) -> str:
    """The table of the comparison."""
    return guest.texts["comparison"]


def test_a_chart_that_a_drag_leaves_behind_says_so(guest, session, monkeypatch):
    """On a server that is too busy to compute charts during a drag."""
    monkeypatch.setattr(frame_loop.FrameLoop, "step", property(lambda _: 1e-6))
    guest.do("over", "delta")
    guest.wait(lambda _: guest.charts["loci-chart"].get("x", {}).get("symbol") == "δ")
    ended = threading.Event()

    def drag() -> None:
        gamma = 0.0
        while not ended.wait(0.002):
            gamma = (gamma + 0.01) % 10
            session.visitor.change(partial(State.changed, name="gamma", value=gamma))

    dragging = threading.Thread(target=drag)
    dragging.start()
    try:
        guest.wait(lambda _: told(guest, "loci-chart"))
    finally:
        ended.set()
        dragging.join()
    guest.wait(lambda _: not told(guest, "loci-chart"))


def test_the_moment_of_a_motion_is_shown_while_another_page_is_edited_without_pause(
    guest, session, url, frame_loops, monkeypatch
):
    """Each time that the edits are, though frames of the scenes that move are due meanwhile."""
    guest.do("tab", "motion")
    guest.do("experiment", "pull", until=lambda _: session.snapshot.film)
    with visitor(url) as other:
        pause(other)
        sessions, seen = frame_loop_at(url, frame_loops).sessions, list[float]()
        edited = sessions[max(sessions)]
        show = edited.tick

        def show_and_edit(*given: Any, **options: Any) -> None:
            time.sleep(1.5 / frame_loop.FRAMES)
            show(*given, **options)
            shown = session.visitor.page.sent["charts", "motion-chart", "cursor"]["x"]
            seen.append(session.snapshot.clock.moment - shown)
            edited.visitor.wake()

        monkeypatch.setattr(edited, "tick", show_and_edit)
        edited.visitor.wake()
        wait_until(lambda: len(seen) >= 20)
    assert not any(seen[1:])  # the first may be shown before a frame is due


def test_a_map_that_was_not_begun_is_not_waited_for(guest, frame_loops):
    """On a busy server its request is left to the next frame; by then its tab may be closed."""
    own = Guest(guest, frame_loops[0])
    session = own.session
    guest.do("tab", "map", until=lambda _: guest.charts["map-chart"].get("values"))
    pause(guest)
    own.settle()

    def in_two_frames() -> None:
        visitor = session.visitor
        visitor.change(partial(State.changed, name="delta", value=0.4))
        session.tick(time.monotonic(), postpones=True)
        visitor.set_state(replace(visitor.state, tab="loads"))
        session.tick(time.monotonic())

    own.on_loop(in_two_frames)
    own.settle()
    assert not session.visitor.jobs["map"].busy
    assert session.visitor.jobs["map"].since is None
