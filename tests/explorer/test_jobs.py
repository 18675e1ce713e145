"""Background jobs: the latest request wins, nobody waits for another one's long job; and pictures
in rounds, and charts after them, by counts, with stand-ins for visitors."""

import asyncio
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from functools import partial
from types import SimpleNamespace

import pytest
from charts import case
from live.server import wait_until

from beamviz.beam import Beam
from beamviz.errors import Cancelled
from beamviz.explorer import ALL_FRAMES, BATCH, FEWER_FRAMES, FRAMES, FrameLoop
from beamviz.explorer.features.loci_chart import ChartRequest
from beamviz.explorer.features.map import MapRequest
from beamviz.explorer.features.run_up import RunUpRequest
from beamviz.explorer.jobs import Job, WorkerPool, Workers
from beamviz.explorer.session import Session
from beamviz.explorer.state import Case
from beamviz.server.access import Access


@pytest.fixture
def release() -> Iterator[threading.Event]:
    """An event that ends long work, set at the latest after the test."""
    event = threading.Event()
    yield event
    event.set()


def test_work_starts_in_order_two_at_a_time(release):
    """The others wait, and start in the order of submission, or when these are late: then other
    threads take the place of theirs, which end."""
    begun: list[int] = []
    with closing(WorkerPool(2, "test")) as pool:
        for k in range(6):
            pool.submit(lambda k=k: (begun.append(k), release.wait(20)))
        wait_until(lambda: len(begun) == 2)
        time.sleep(0.1)
        pool.replace()
        assert begun == [0, 1]
        pool.replace(late=0.0)
        wait_until(lambda: len(begun) == 4)
        release.set()
        wait_until(lambda: len(begun) == 6)
        wait_until(lambda: [one.name for one in threading.enumerate()].count("test") == 2)
    assert [sorted(begun[k : k + 2]) for k in (2, 4)] == [[2, 3], [4, 5]]


def test_closing_a_pool_discards_waiting_work(release):
    """Running work is completed, and no thread is left."""
    done: list[int] = []
    with closing(WorkerPool(1, "test close")) as pool:
        pool.submit(lambda: release.wait(60))
        wait_until(lambda: pool.started)
        pool.submit(lambda: done.append(1))
    release.set()
    wait_until(lambda: "test close" not in [one.name for one in threading.enumerate()])
    assert not done


@pytest.fixture
def crowd() -> Iterator[Workers]:
    """The queue with many visitors."""
    with closing(Workers(lambda: True)) as made:
        yield made


def test_solves_of_many_visitors_run_in_batches_and_slow_ones_on_workers(crowd, release):
    """In order, and completed when `run_batch` returns; slow at submission, or if the method is
    changed while they wait. One that is unexpectedly slow goes on in the background, and those
    after it are done in order."""
    order: list[int] = []
    for k in range(5):
        crowd.solve(partial(order.append, k), lambda: True)
    for most, count in ((0, 0), (2, 2), (9, 5), (9, 5)):
        crowd.run_batch(most)
        assert order == [*range(count)]
    quick, threads = [True], list[str]()
    for _ in range(2):
        crowd.solve(lambda: threads.append(threading.current_thread().name), lambda: quick[0])
        quick[0] = False
        crowd.run_batch(1)
    wait_until(lambda: threads == ["solver", "solver"])
    assert not crowd.waiting
    for work in (partial(release.wait, 600), partial(order.append, 5), partial(order.append, 6)):
        crowd.solve(work, lambda: True)
    crowd.run_batch(9)
    wait_until(lambda: order == [*range(7)])


def test_a_job_computes_the_latest_request():
    """Of 100 requests during a computation only the last one, and not again once it is answered; a
    closed job neither a new request nor a waiting one."""
    waiting: list[Callable[[], None]] = []
    computed: list[int] = []

    def compute(request: int) -> int:
        computed.append(request)
        for later in range(request + 1, 100):
            job.request(later)
        return 2 * request

    job: Job[int, int] = Job("number", compute, waiting.append, lambda: None)
    job.request(0)
    while waiting:
        waiting.pop()()
    assert (job.answer.request, job.result, job.answer.message) == (99, 198, "")
    job.request(99)
    assert not waiting
    job.request(100)
    job.close()
    waiting.pop()()
    job.request(101)
    assert (computed, waiting) == ([0, 99], [])


@pytest.mark.parametrize(
    "compute",
    [
        lambda slow: ChartRequest.around(slow, "gamma", 2).chart(),
        lambda slow: RunUpRequest(slow.changed("gamma", 0.0), 2, 0.02).run_up(),
        lambda slow: MapRequest.around(slow, ("gamma", "alpha"), None).solve(),
        lambda slow: ChartRequest.around(slow.with_options(state="stable"), "delta").chart(),
    ],
    ids=["chart", "run-up", "map", "bent beams"],
)
def test_a_cancelled_job_frees_its_worker(crowd, compute):
    """After the present beam, or batch of beams."""
    pool, ended = crowd.background, threading.Event()

    def cancelled(slow: Case) -> None:
        with pytest.raises(Cancelled):
            compute(slow)
        ended.set()

    job: Job[Case, None] = Job("slow", cancelled, pool.submit, lambda: None)
    job.request(case(Beam(alpha=1, beta=0.5, gamma=5), method="ancf-planar", elements=100))
    wait_until(lambda: pool.started)
    time.sleep(0.2)
    job.cancel()
    wait_until(lambda: not pool.started)
    assert ended.is_set()


# Pictures


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


def test_a_round_draws_one_frame_for_each_visitor_and_answers_come_in_batches():
    """While solves wait, a session that just had an answer is skipped; one at rest has none.
    Answers are drawn in order of arrival; messages are exchanged in between."""
    sessions = [Still(outdated=k < 2, needs_tick=k < 4) for k in range(5)]
    made = frame_loop(*sessions, waiting=1)
    made.woken = dict.fromkeys([0, 1, 4, 5])  # one at rest, and one who has left
    made.draw_next()
    assert not made.woken
    for pictures in ([1, 1, 0, 0, 0], [1, 1, 1, 1, 0], [2, 2, 2, 2, 0]):
        assert [one.pictures for one in sessions] == pictures
        asyncio.run(made.draw_all(made.step))
    others = [Still(outdated=True) for _ in range(BATCH + 3)]
    many = frame_loop(*others)
    many.woken = dict.fromkeys(reversed(range(len(others))))
    for pictures in ([0] * 3 + [1] * BATCH, [1] * len(others)):
        many.draw_next()
        assert [one.pictures for one in others] == pictures


@pytest.mark.parametrize(
    ("visitors", "waiting", "rate"),
    [(1, 0, FRAMES), (1, 1, FEWER_FRAMES), (60, 0, ALL_FRAMES / 60), (60, 9, FEWER_FRAMES)],
)
def test_the_frame_rate_falls_with_waiting_solves_and_with_visitors(visitors, waiting, rate):
    """Equally for all visitors."""
    made = frame_loop(Still(), waiting=waiting)
    for _ in range(visitors):
        made.access.visitor_count.add(1)
    assert 1 / made.step == pytest.approx(rate)


@pytest.mark.parametrize(
    ("crowded", "now", "busy", "follow"),
    [(False, 1.0, True, True), (True, 0.9, False, False), (True, 1.1, True, False),
     (True, 1.1, False, True)],
)  # fmt: skip
def test_with_many_visitors_charts_wait_until_a_slider_is_at_rest(crowded, now, busy, follow):
    """At 1 s, and for a running solve; with few visitors they do not wait."""
    session, shown = Session.__new__(Session), list[bool]()
    session.charts, session.charts_due = [SimpleNamespace(show=lambda: shown.append(True))], 1.0
    workers = SimpleNamespace(crowded=lambda: crowded)
    session.visitor = SimpleNamespace(solver=SimpleNamespace(busy=busy), workers=workers)
    session.charts_outdated = True
    session.show_charts(now)
    assert session.charts_outdated == (not follow) == (not shown)
