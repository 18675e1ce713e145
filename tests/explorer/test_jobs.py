"""Background jobs: the latest request wins, and nobody waits for another one's long job."""

import threading
import time
import weakref
from collections.abc import Callable, Iterator
from contextlib import closing
from contextvars import copy_context
from functools import partial
from typing import Any

import pytest
from charts import case
from live.server import TIMEOUT, last_until, wait_until
from live.visitor import PAPER

from beamviz.beam import Beam
from beamviz.errors import Cancelled, NotConverged
from beamviz.explorer import solutions
from beamviz.explorer.computed_loci import ChartRequest
from beamviz.explorer.features.map import MapRequest
from beamviz.explorer.features.run_up import RunUpRequest
from beamviz.explorer.jobs import Job, JobStatus, WorkerPool, Workers, percentage
from beamviz.explorer.second_beam import ComparisonCase
from beamviz.explorer.solutions import Cases, SolveJob
from beamviz.explorer.state import Case
from beamviz.presets import preset
from beamviz.solver import interruption, solve

BUCKLED = Beam(alpha=1, beta=0.6, gamma=30, delta=-1)


@pytest.fixture
def release() -> Iterator[threading.Event]:
    """An event that ends long work, set at the latest after the test."""
    event = threading.Event()
    yield event
    event.set()


@pytest.fixture
def workers() -> Iterator[Workers]:
    """The workers of a process."""
    with closing(Workers()) as made:
        yield made


def running(name: str) -> int:
    """The number of threads of this name."""
    return [thread.name for thread in threading.enumerate()].count(name)


def test_work_starts_in_order_on_as_many_threads_as_are_needed(release):
    """One for quick work, more while others are at work, up to the number given."""
    begun: list[int] = []
    with closing(WorkerPool(2, "test")) as pool:
        for k in range(3):
            pool.submit(partial(begun.append, k))
            wait_until(lambda k=k: len(begun) == k + 1 and not pool.unfinished)
        assert running("test") == 1
        for k in range(3, 7):
            pool.submit(lambda k=k: (begun.append(k), release.wait(TIMEOUT)))
        wait_until(lambda: len(begun) == 5)
        time.sleep(0.1)
        assert running("test") == 2
        release.set()
        wait_until(lambda: len(begun) == 7)
    assert begun[:3] == [0, 1, 2]
    assert sorted(begun[3:5]) == [3, 4]


class Matrix:
    """Something large."""


@pytest.mark.parametrize("error", [NotConverged, Cancelled])
def test_an_answer_without_a_result_keeps_nothing_of_what_was_computed(error):
    """Though the page shows its error, maybe for hours."""
    matrices = []

    def compute(request: int) -> int:
        large = Matrix()
        matrices.append(weakref.ref(large))
        try:
            raise ZeroDivisionError(str(request))
        except ZeroDivisionError:
            raise error("not this time") from None

    job = Job("test", compute, lambda work: work(), lambda: None)
    answer = job.answered(1)
    assert isinstance(answer.error, error)
    assert [one() for one in matrices] == [None]


def test_closing_a_pool_discards_waiting_work(release):
    """Running work is completed, and no thread is left."""
    done, begun = list[int](), threading.Event()
    with closing(WorkerPool(1, "test close")) as pool:
        pool.submit(lambda: (begun.set(), release.wait(TIMEOUT)))
        assert begun.wait(TIMEOUT)
        pool.submit(lambda: done.append(1))
    release.set()
    wait_until(lambda: not running("test close"))
    assert not done


def test_a_quick_solve_is_done_in_the_frame_and_a_slow_one_is_not(workers, release, monkeypatch):
    """Quick is what the last one was. One that is unexpectedly slow is begun again on a thread."""

    def slow_at_3(beam: Beam, **options: Any) -> Any:
        if beam.gamma == 3.0:
            last_until(release)
        return solve(beam, **options)

    monkeypatch.setattr(solutions, "solve", slow_at_3)
    for limit in ("QUICK", "LONGEST"):  # on a busy machine nothing is quick
        monkeypatch.setattr(solutions, limit, TIMEOUT)
    job = SolveJob(workers, lambda: None)
    job.request(Cases(case(PAPER)))
    wait_until(lambda: not job.busy)
    job.request(Cases(case(PAPER.replace(gamma=2.0))))
    assert job.answer.result.answer.beam.gamma == 2.0
    monkeypatch.setattr(solutions, "LONGEST", 0.1)
    job.request(Cases(case(PAPER.replace(gamma=3.0))))
    assert job.busy
    assert job.answer.result.answer.beam.gamma == 2.0
    job.request(Cases(case(PAPER.replace(gamma=4.0))))
    assert job.answer.result.answer.beam.gamma == 2.0  # nor did this frame wait
    release.set()
    wait_until(lambda: not job.busy)
    assert job.answer.result.answer.beam.gamma == 4.0


def test_a_slow_beam_stays_slow_where_nothing_was_to_be_solved(workers, monkeypatch):
    """As when a comparison ends: the next beam is not solved in the frame."""
    solved_by: list[threading.Thread] = []

    def slow(beam: Beam, **options: Any) -> Any:
        solved_by.append(threading.current_thread())
        end = time.thread_time() + 2 * solutions.QUICK
        while time.thread_time() < end:
            solve(beam, **options)
        return solve(beam, **options)

    monkeypatch.setattr(solutions, "solve", slow)
    monkeypatch.setattr(solutions, "LONGEST", TIMEOUT)
    job, first = SolveJob(workers, lambda: None), case(PAPER)
    for cases in (Cases(first, ComparisonCase("before", case(Beam(gamma=1)))), Cases(first)):
        job.request(cases)
        wait_until(lambda: not job.busy)
    job.request(Cases(case(Beam(gamma=2))))
    wait_until(lambda: not job.busy)
    assert threading.current_thread() not in solved_by


@pytest.mark.parametrize("numbers", [{"delta": -0.5, "gamma": 20.0}, {"spin_up": 0.5}])
def test_a_solve_that_takes_long_is_interrupted_within(numbers):
    """Not only before it begins: a frame that has begun it, or who cancels it, does not wait for
    its end."""
    blade = preset("nrel-5mw-blade").beam.replace(**numbers)
    with pytest.raises(Cancelled):
        copy_context().run(interrupted, blade, state="stable")


def interrupted(beam: Beam, **options: Any) -> None:
    """Solve, and interrupt that in the midst."""
    moments = iter(range(5))

    def interrupt() -> None:
        if next(moments, None) is None:
            raise Cancelled

    interruption.set(interrupt)
    solve(beam, **options)


def test_a_comparison_has_both_answers(workers):
    """Also where one of the two was solved before."""
    job, first, second = SolveJob(workers, lambda: None), case(PAPER), case(Beam(gamma=1))
    comparison = ComparisonCase("before", second)
    for cases in (Cases(first), Cases(first, comparison), Cases(case(Beam(gamma=2)), comparison)):
        job.request(cases)
        wait_until(lambda: not job.busy)
        answer, other = job.answer.result
        assert answer.request == cases.case
        assert (other and other.request) == cases.comparison.case
        assert job.compared == (answer, other, cases.comparison)


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
    assert (job.answer.request, job.answer.result, job.answer.message) == (99, 198, "")
    job.request(99)
    assert not waiting
    job.request(100)
    job.close()
    waiting.pop()()
    job.request(101)
    assert (computed, waiting) == ([0, 99], [])


def test_an_answer_that_is_asked_for_again_stays():
    """Though another one was asked for meanwhile, which is being computed: that is given up."""
    waiting: list[Callable[[], None]] = []

    def compute(request: int) -> int:
        if request == 2:
            job.request(1)  # as a visitor does who returns to it
        return 10 * request

    job: Job[int, int] = Job("number", compute, waiting.append, lambda: None)
    for request in (1, 2):
        job.request(request)
        waiting.pop()()
    assert (job.answer.request, job.answer.result) == (1, 10)
    assert not waiting
    assert not job.busy
    assert not job.status.late
    job.request(3)
    waiting.pop()()
    assert (job.answer.request, job.answer.result) == (3, 30)


@pytest.mark.parametrize(
    ("parts", "text"), [((), ""), ((0.0, 0.0), ""), ((0.2, 0.42), " 42 %"), ((0.9999,), " 99 %")]
)
def test_what_is_being_computed_is_never_complete(parts, text):
    status = JobStatus("motion", None, True, True, True, 3, 0.0, "")
    assert percentage([status._replace(done=part) for part in parts]) == text


@pytest.mark.parametrize(
    "compute",
    [
        lambda slow: ChartRequest.around(slow, "gamma", 2).chart(),
        lambda slow: RunUpRequest(slow.changed("gamma", 0.0), 2, 0.02, 20.0).run_up(),
        lambda slow: MapRequest.around(slow, ("gamma", "alpha")).solve(),
        lambda _: ChartRequest.around(
            case(BUCKLED, state="bent", coriolis=True, modes=16, tolerance=1e-9), "gamma", 2
        ).chart(),
    ],
    ids=["chart", "run-up", "map", "bent beams"],
)
def test_a_cancelled_job_frees_its_worker(workers, compute):
    """After the present beam, or batch of beams."""
    pool, begun, ended = workers.background, threading.Event(), threading.Event()

    def cancelled(slow: Case) -> None:
        begun.set()
        with pytest.raises(Cancelled):
            compute(slow)
        ended.set()

    job: Job[Case, None] = Job("slow", cancelled, pool.submit, lambda: None)
    job.request(case(Beam(alpha=1, beta=0.5, gamma=5), method="ancf", elements=100))
    assert begun.wait(TIMEOUT)
    time.sleep(0.3)  # in the middle of it
    job.cancel()
    wait_until(lambda: not pool.unfinished)
    assert ended.is_set()


def test_a_cancelled_job_waits_until_it_is_asked_for_again():
    """Each frame requests what the page needs: the same request does not begin it again, another
    one does, and so does the visitor."""
    waiting = list[Callable[[], None]]()
    job: Job[int, int] = Job("test", lambda request: request, waiting.append, lambda: None)
    job.request(1)
    job.cancel()
    job.request(1)
    assert not job.busy
    assert job.status.cancelled
    job.retry()
    assert job.busy
    job.cancel()
    job.request(2)
    assert job.busy
