"""Pictures in rounds, and charts after them: by counts, with stand-ins for visitors."""

import asyncio
from types import SimpleNamespace

import pytest

from beamviz.explorer import ALL_FRAMES, BATCH, FEWER_FRAMES, FRAMES, FrameLoop
from beamviz.explorer.session import Session
from beamviz.server.access import Access


class Still:
    """A session that counts its frames."""

    def __init__(self, *, needs_tick: bool = True, outdated: bool = False):
        self.needs_tick, self.outdated, self.last_tick, self.pictures = needs_tick, outdated, 0.0, 0

    def tick(self, now: float) -> None:
        self.last_tick, self.pictures, self.outdated = now, self.pictures + 1, False


def frame_loop(*sessions: Still, waiting: int = 0) -> FrameLoop:
    """A frame loop without a running event loop."""
    made = FrameLoop.__new__(FrameLoop)
    made.sessions = dict(enumerate(sessions))
    made.workers = SimpleNamespace(waiting=[None] * waiting)
    made.woken, made.drawn, made.access = {}, 0.0, Access()
    return made


def test_a_round_draws_one_frame_for_each_visitor():
    """While solves wait, a session that just had an answer is skipped; one at rest has none."""
    sessions = [Still(outdated=k < 2, needs_tick=k < 4) for k in range(5)]
    made = frame_loop(*sessions, waiting=1)
    made.woken = dict.fromkeys([0, 1, 4, 5])  # one at rest, and one who has left
    made.draw_next()
    assert not made.woken
    for pictures in ([1, 1, 0, 0, 0], [1, 1, 1, 1, 0], [2, 2, 2, 2, 0]):
        assert [one.pictures for one in sessions] == pictures
        asyncio.run(made.draw_all(made.step))


def test_answers_are_drawn_in_batches():
    """In order of arrival; messages are exchanged in between."""
    sessions = [Still(outdated=True) for _ in range(BATCH + 3)]
    made = frame_loop(*sessions)
    made.woken = dict.fromkeys(reversed(range(len(sessions))))
    for pictures in ([0] * 3 + [1] * BATCH, [1] * len(sessions)):
        made.draw_next()
        assert [one.pictures for one in sessions] == pictures


@pytest.mark.parametrize(
    ("visitors", "waiting", "rate"),
    [(1, 0, FRAMES), (1, 1, FEWER_FRAMES), (60, 0, ALL_FRAMES / 60), (60, 9, FEWER_FRAMES)],
)
def test_the_frame_rate_falls_with_waiting_solves_and_with_visitors(visitors, waiting, rate):
    """Equally for all visitors."""
    made = frame_loop(Still(), waiting=waiting)
    for _ in range(visitors):
        made.access.visitor_count.enter()
    assert 1 / made.step == pytest.approx(rate)


@pytest.mark.parametrize(
    ("crowded", "now", "busy", "follow"),
    [(False, 1.0, True, True), (True, 0.9, False, False), (True, 1.1, True, False),
     (True, 1.1, False, True)],
)  # fmt: skip
def test_with_many_visitors_charts_wait_until_a_slider_is_at_rest(crowded, now, busy, follow):
    """At 1 s, and for a running solve; with few visitors they do not wait."""
    session = Session.__new__(Session)
    session.features, session.charts_due = [], 1.0
    parts = {
        "solver": SimpleNamespace(busy=busy),
        "workers": SimpleNamespace(crowded=lambda: crowded),
    }
    session.visitor = SimpleNamespace(answer=1, chart_answer=None, **parts)
    session.update_features(now)
    assert (session.visitor.chart_answer == 1) == follow
