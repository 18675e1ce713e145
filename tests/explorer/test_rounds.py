"""Pictures in rounds, and charts after them: by counts, with stand-ins for visitors."""

import asyncio
from types import SimpleNamespace

import pytest
from beamviz.explorer.debounce import REST, Lag

from beamviz.explorer.frames import ALL_FRAMES, FEWER_FRAMES, FRAMES, TOGETHER, FrameLoop
from beamviz.server.access import VisitorCount


class Still:
    """A session that counts its pictures."""

    def __init__(self, *, ticking: bool = True, fresh: bool = False):
        self.ticking, self.fresh, self.seen, self.pictures = ticking, fresh, 0.0, 0

    def tick(self, now: float) -> None:
        self.seen, self.pictures, self.fresh = now, self.pictures + 1, False


def frame_loop(*sessions: Still, waiting: int = 0) -> FrameLoop:
    """An frame_loop that does not run by itself."""
    made = FrameLoop.__new__(FrameLoop)
    made.sessions = dict(enumerate(sessions))  # type: ignore[arg-type]
    made.turns = SimpleNamespace(waiting=[None] * waiting)  # type: ignore[assignment]
    made.woken, made.drawn, made.visitor_count = {}, set(), VisitorCount()
    return made


def test_a_round_has_one_picture_for_everybody():
    """Where somebody waits: who has just had an answer has had theirs, and gets the next one."""
    sessions = [Still(fresh=k < 2) for k in range(5)]
    made = frame_loop(*sessions, waiting=1)
    made.woken = dict.fromkeys([0, 1])
    made.draw_next()
    assert [one.pictures for one in sessions] == [1, 1, 0, 0, 0]
    asyncio.run(made.draw_all(made.step))
    assert [one.pictures for one in sessions] == [1, 1, 1, 1, 1]
    asyncio.run(made.draw_all(made.step))
    assert [one.pictures for one in sessions] == [2, 2, 2, 2, 2]


def test_who_rests_gets_none():
    """Only what moves is drawn, and what is woken only if it is fresh."""
    sessions = [Still(ticking=False), Still(ticking=False)]
    made = frame_loop(*sessions)
    made.woken = dict.fromkeys([0, 1, 2])  # one has left
    made.draw_next()
    asyncio.run(made.draw_all(made.step))
    assert [one.pictures for one in sessions] == [0, 0]
    assert not made.woken


def test_answers_are_drawn_a_few_at_a_time():
    """In the order in which they came; then messages come and go."""
    sessions = [Still(fresh=True) for _ in range(TOGETHER + 3)]
    made = frame_loop(*sessions)
    made.woken = dict.fromkeys(reversed(range(len(sessions))))
    made.draw_next()
    assert [one.pictures for one in sessions] == [0] * 3 + [1] * TOGETHER
    made.draw_next()
    assert all(one.pictures == 1 for one in sessions)


@pytest.mark.parametrize(
    ("visitors", "waiting", "rate"),
    [(1, 0, FRAMES), (1, 1, FEWER_FRAMES), (60, 0, ALL_FRAMES / 60), (60, 9, FEWER_FRAMES)],
)
def test_pictures_give_way_to_answers(visitors, waiting, rate):
    """Fewer where somebody waits, and where visitors are many; the same for all."""
    made = frame_loop(Still(), waiting=waiting)
    for _ in range(visitors):
        made.visitor_count.enter()
    assert 1 / made.step == pytest.approx(rate)


def test_charts_follow_a_few_visitors_at_once():
    """Once for each change, whether or not an answer is awaited."""
    lag = Lag(crowded=lambda: False)
    assert not lag.running
    assert not lag.over(1.0, busy=False)
    lag.begin(1.0)
    assert lag.running
    assert lag.over(1.0, busy=True)
    assert not lag.running
    assert not lag.over(2.0, busy=False)


def test_charts_of_a_crowd_wait_until_an_edit_has_come_to_rest():
    """Every change begins the rest anew, and an answer that is awaited will be a change."""
    lag = Lag(crowded=lambda: True)
    lag.begin(1.0)
    lag.begin(1.0 + 0.8 * REST)
    assert not lag.over(1.0 + 1.7 * REST, busy=False)
    assert not lag.over(1.0 + 1.9 * REST, busy=True)
    assert lag.running
    assert lag.over(1.0 + 1.9 * REST, busy=False)
