"""Lecture mode: one presents, all see it; each can go exploring and come back."""

from collections.abc import Iterator

import pytest
from live.server import wait_until
from live.visitor import PAPER, frequency_text, visitor

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


def test_all_visitors_see_the_page_of_the_presenter(url, frame_loops, monkeypatch):
    """Numbers, answers, view, comparison, tab, lesson, clock; each case is solved once for all."""
    with visitor(f"{url}/?token={PRESENTER}") as lead, visitor(url) as one, visitor(url) as other:
        solved = []
        monkeypatch.setattr(
            jobs, "solve", lambda *a, **o: (solved.append(a[0].gamma), solve(*a, **o))[1]
        )
        lead.choose("gamma", 21.0)
        for guest in (one, other):
            guest.shows(PAPER.replace(gamma=21))
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
        one.shows(PAPER.replace(gamma=21))
        one.edit(alpha=2.0)
        lead.do("lesson", "")
        lead.choose("gamma", 22.0)
        other.shows(PAPER.replace(gamma=22))
        assert lesson("nodes").question in one.text
        assert lesson("nodes").question not in other.text
        own = frequency_text(one.beam)
        assert own in one.text
        assert own not in lead.text + other.text
        one.choose("following", True)
        one.shows(PAPER.replace(gamma=22))


def test_a_visitor_cannot_present(url):
    """Without the presenter's key: another one, though drawn again, stays at the first scene."""
    with visitor(f"{url}/?token=guessed") as one, visitor(url) as other:
        one.edit(gamma=21.0)
        other.choose("dark", True)
        other.wait(lambda _: other.values["dark"] is True)
        assert other.values["gamma"] == PAPER.gamma
        assert "following" in one.values


def test_a_presenter_may_leave_and_return(url, frame_loops):
    """Meanwhile the last scene is kept."""
    with visitor(url) as one:
        with visitor(f"{url}/?token={PRESENTER}") as lead:
            assert "following" not in lead.values
            lead.choose("gamma", 21.0)
            one.shows(PAPER.replace(gamma=21))
            lead.choose("playing", False)
        wait_until(lambda: len(frame_loops[-1].sessions) == 1)
        assert frequency_text(PAPER.replace(gamma=21)) in one.text
        with visitor(f"{url}/?token={PRESENTER}") as lead:
            lead.choose("gamma", 5.0)
            one.shows(PAPER.replace(gamma=5))
