"""Lecture mode: one presents, all see it; each can go exploring and come back."""

import time
from collections.abc import Iterator

import pytest
from live.server import wait_until
from live.visitor import PAPER, Visitor, frequency_text, visitor

from beamviz.explorer import explorer, jobs
from beamviz.lessons import lesson
from beamviz.scene import Scene
from beamviz.solver import solve

PRESENTER = "the-presenters-key"


@pytest.fixture
def url(frame_loops) -> Iterator[str]:
    """An explorer in lecture mode."""
    with explorer(Scene(PAPER), presenter_key=PRESENTER) as found:
        yield found


def shows(guest: Visitor, **numbers: float) -> None:
    """Wait until a page shows the first frequency of PAPER with other numbers."""
    guest.says(frequency_text(PAPER.replace(**numbers)))


def test_all_visitors_see_the_page_of_the_presenter(url, frame_loops, monkeypatch):
    """Numbers, answers, view, comparison, tab, lesson, clock; each case is solved once for all."""
    with visitor(f"{url}/?token={PRESENTER}") as lead, visitor(url) as one, visitor(url) as other:
        solved = []
        monkeypatch.setattr(
            jobs, "solve", lambda *a, **o: (solved.append(a[0].gamma), solve(*a, **o))[1]
        )
        lead.choose("gamma", 21.0)
        for guest in (one, other):
            shows(guest, gamma=21)
            guest.wait(lambda _, guest=guest: guest.values.get("gamma") == 21.0)
        lead.choose("colouring", "axial strain")
        for guest in (one, other):
            guest.says("axial strain, as drawn")
        assert solved.count(21.0) == 1  # that of a page which opens may still come
        lead.do("comparison", "mass")
        lead.do("tab", "compare")
        for guest in (one, other):
            guest.says(">twice the mass, ")
            guest.wait(lambda _, guest=guest: guest.parts.get("open") == "compare")
        assert solved.count(21.0) == 2
        sessions = list(frame_loops[-1].sessions.values())
        assert len({id(session.visitor.state.view) for session in sessions}) == 1
        lead.choose("playing", False)
        wait_until(lambda: not any(session.is_moving for session in sessions))
        wait_until(lambda: len({session.visitor.clock.angle for session in sessions}) == 1)
        lead.do("lesson", "nodes")
        lead.says(lesson("nodes").question)
        lead.do("lesson_step", 1)
        for guest in (one, other):
            guest.says(lesson("nodes").proof)


@pytest.mark.slow
def test_a_visitor_explores_and_follows_again(url):
    """From the scene and the lesson of the presenter; no other page changes; a checkbox returns."""
    with visitor(f"{url}/?token={PRESENTER}") as lead, visitor(url) as one, visitor(url) as other:
        lead.do("lesson", "nodes")
        one.says(lesson("nodes").question)
        lead.choose("gamma", 21.0)
        shows(one, gamma=21)
        one.choose("alpha", 2.0)
        shows(one, gamma=21, alpha=2)
        lead.do("lesson", "")
        lead.choose("gamma", 22.0)
        shows(other, gamma=22)
        assert lesson("nodes").question in one.text
        assert lesson("nodes").question not in other.text
        own = frequency_text(PAPER.replace(gamma=21, alpha=2))
        assert own in one.text
        assert own not in lead.text + other.text
        one.choose("following", True)
        shows(one, gamma=22)


def test_a_visitor_cannot_present(url):
    """Without the presenter's key."""
    with visitor(f"{url}/?token=guessed") as one, visitor(url) as other:
        one.edit(gamma=21.0)
        time.sleep(0.5)
        assert frequency_text(PAPER.replace(gamma=21)) not in other.text
        assert "following" in one.values


def test_a_presenter_may_leave_and_return(url, frame_loops):
    """Meanwhile the last scene is kept."""
    with visitor(url) as one:
        with visitor(f"{url}/?token={PRESENTER}") as lead:
            assert "following" not in lead.values
            lead.choose("gamma", 21.0)
            shows(one, gamma=21)
            lead.choose("playing", False)
        wait_until(lambda: len(frame_loops[-1].sessions) == 1)
        assert frequency_text(PAPER.replace(gamma=21)) in one.text
        with visitor(f"{url}/?token={PRESENTER}") as lead:
            lead.choose("gamma", 5.0)
            shows(one, gamma=5)
