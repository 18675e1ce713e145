"""Background jobs: the latest request of a visitor wins, on worker threads shared by all.

A `Job` computes one kind of result for one visitor. It runs on a `WorkerPool`, whose threads
persist and on which a long job of one visitor delays nobody else; solves go through the
`SolveQueue`, which runs them in batches while visitors are many.
"""

import contextlib
import math
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, ClassVar, Generic, NamedTuple, Self, TypeVar

from beamviz.beam import Beam
from beamviz.drawing.modes import SampledModes
from beamviz.drawing.text import error_summary, stability_warning, stretch_caution
from beamviz.errors import BeamvizError, Cancelled, InvalidInput, NoEquilibrium
from beamviz.explorer.state import Case
from beamviz.server.log import RateLimitedLog
from beamviz.solver import Solution, interruption, solve

LONG = 2.0  # [s] a job that has run for this long no longer counts as one of those at work
QUICK = 0.02  # [s] of processor time
PATIENCE = 1.0  # [s] after which the page says that a job is at work
OUTDATED = 3.0  # [s] after which a computation ends whose result is not wanted any more
BATCH_TIMEOUT = 0.25  # [s] that the frame loop waits for a batch of solves

log = RateLimitedLog(__name__)

Q = TypeVar("Q")
R = TypeVar("R")
Work = Callable[[], None]


class WorkerPool:
    """Runs work in order of submission, `workers` pieces at a time.

    Work that has taken `long` seconds no longer counts: an idle thread goes on in its place. All
    threads are started here, and one more for each piece of long work. They are daemons: the end
    of the process does not wait for them. Work must not raise.
    """

    def __init__(self, workers: int, name: str, long: float = LONG):
        self.workers, self.name, self.long = workers, name, long
        self.changed = threading.Condition()
        self.waiting: deque[Work] = deque()
        self.started: dict[threading.Thread, float] = {}  # when each busy thread began its work
        self.idle = 0
        self.closed = False
        for _ in range(workers + 1):
            self.add_thread()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def submit(self, work: Work) -> None:
        """Run `work` as soon as a worker is free."""
        with self.changed:
            if not self.closed:
                self.waiting.append(work)
                self.changed.notify()

    def close(self) -> None:
        """Drop what waits and end the idle threads; work that is running ends by itself."""
        with self.changed:
            self.closed = True
            self.waiting.clear()
            self.changed.notify_all()

    def add_thread(self) -> None:
        """Start a thread, which is idle at first."""
        self.idle += 1
        threading.Thread(target=self.run, name=self.name, daemon=True).start()

    def run(self) -> None:
        """Do work until the pool is closed or has threads to spare."""
        thread = threading.current_thread()
        while work := self.next_work(thread):
            work()
            with self.changed:
                del self.started[thread]
                if self.idle > self.workers:
                    return  # the substitute of long work, or its replacement
                self.idle += 1

    def next_work(self, thread: threading.Thread) -> Work | None:
        """Wait for work and for room to do it; None when the pool is closed."""
        with self.changed:
            while not (self.closed or (self.waiting and self.delay() <= 0)):
                self.changed.wait(self.delay() if self.waiting else None)
            self.idle -= 1
            if self.closed:
                return None
            self.started[thread] = time.monotonic()
            if self.idle == 0:
                self.add_thread()
            return self.waiting.popleft()

    def delay(self) -> float:
        """Time [s] until one more piece of work may start, as far as is known now."""
        latest = sorted(self.started.values())[-self.workers :]
        return latest[0] + self.long - time.monotonic() if len(latest) == self.workers else 0.0


class SolveQueue:
    """Hands solves to worker threads while visitors are few. While they are many, quick solves
    wait here, and the frame loop has them run in batches: threads that compete with it for the
    interpreter lock would take longer."""

    def __init__(
        self,
        pool: WorkerPool,
        crowded: Callable[[], bool] = lambda: False,
        notify: Callable[[], None] = lambda: None,
    ):
        self.pool, self.crowded, self.notify = pool, crowded, notify
        self.waiting: deque[tuple[Work, Callable[[], bool]]] = deque()
        self.batch_pool = WorkerPool(1, "solver batch", BATCH_TIMEOUT)

    def submit(self, work: Work, is_quick: Callable[[], bool]) -> None:
        """Run `work` soon; `notify` is called when it waits for a batch."""
        if self.crowded() and is_quick():
            self.waiting.append((work, is_quick))
            self.notify()
        else:
            self.pool.submit(work)

    def run_batch(self, count: int) -> None:
        """Run up to `count` of the waiting solves and wait for them, BATCH_TIMEOUT at most: one
        that takes longer than it seemed goes on in the background, and the workers do the rest."""
        batch, done = deque[Work](), threading.Event()
        while self.waiting and len(batch) < count:
            work, is_quick = self.waiting.popleft()
            if is_quick():
                batch.append(work)
            else:  # another method was chosen meanwhile
                self.pool.submit(work)
        if batch:

            def run_all() -> None:
                with contextlib.suppress(IndexError):  # none is left, or the rest is taken away
                    while True:
                        batch.popleft()()
                done.set()

            self.batch_pool.submit(run_all)
            if not done.wait(BATCH_TIMEOUT):
                with contextlib.suppress(IndexError):
                    while True:
                        self.pool.submit(batch.popleft())

    def close(self) -> None:
        """Run nothing more."""
        self.waiting.clear()
        self.batch_pool.close()


current = threading.local()  # the job that a thread computes, its request and number of the run


def check_cancelled(done: float | None = None) -> None:
    """Note how much of a computation of many parts is done; raise Cancelled where a visitor has
    cancelled it, or waits for another one already and for long."""
    job, request, number = current.run
    if job.number != number or job.closed:
        raise Cancelled
    if job.latest is not request and time.monotonic() > job.started + OUTDATED:
        raise Cancelled
    if done is not None:
        job.done = done


@dataclass(frozen=True)
class Answer(Generic[Q, R]):
    """What came of a request: a result, or the error that says why there is none."""

    request: Q
    result: R | None = None
    error: BeamvizError | Cancelled | None = None

    @property
    def message(self) -> str:
        """Why there is no result, "" where there is one."""
        return str(self.error) if self.error else ""


class Job(Generic[Q, R]):
    """Computes the latest request of one visitor; those that came while it was busy are skipped
    but for the last.

    name: what is computed; compute: the result of a request, called on a worker thread; ready:
    called after each answer. answer: the last one, None before the first; latest: the last request;
    busy: whether a request is being computed, started: since when [s], done: the share that is done
    where that is known; number: of the run whose result is wanted; following: answers are taken
    over from another visitor, nothing is computed.
    """

    kind: ClassVar[type[Answer]] = Answer

    def __init__(
        self,
        name: str,
        compute: Callable[[Q], R],
        submit: Callable[[Work], None],
        ready: Callable[[], None],
    ):
        self.name, self.compute, self.submit, self.ready = name, compute, submit, ready
        self.lock = threading.RLock()
        self.latest: Q | None = None
        self.answer: Answer[Q, R] | None = None
        self.busy = self.closed = self.following = False
        self.started, self.done, self.number = 0.0, 0.0, 0

    @property
    def result(self) -> R | None:
        """The result of the last answer, if it has one."""
        return self.answer.result if self.answer else None

    def request(self, request: Q) -> None:
        """Compute `request` in place of any earlier one, unless it is the latest already."""
        with self.lock:
            if request == self.latest or self.closed or self.following:
                return
            self.latest = request
            if not self.busy:
                self.start()

    def start(self) -> None:
        """Have the latest request computed."""
        self.busy, self.started, self.done = True, time.monotonic(), 0.0
        self.submit(partial(self.run, self.number))

    @property
    def slow(self) -> bool:
        """Whether the visitor has waited for long."""
        return self.busy and time.monotonic() > self.started + PATIENCE

    @property
    def cancelled(self) -> bool:
        """Whether the latest request was cancelled."""
        return self.answer is not None and isinstance(self.answer.error, Cancelled)

    def cancel(self) -> None:
        """Give up what is being computed; its result is discarded."""
        with self.lock:
            if not self.busy or self.latest is None:
                return
            self.number, self.busy = self.number + 1, False
            self.answer = self.kind(self.latest, error=Cancelled("The calculation was cancelled."))
        self.ready()

    def retry(self) -> None:
        """Compute again what was cancelled."""
        with self.lock:
            if self.cancelled and not self.busy:
                self.start()

    def adopt(self, other: "Job[Q, R]") -> None:
        """Take over the answer of another visitor's job."""
        with self.lock:
            if other.answer is not None:
                self.answer, self.latest = other.answer, other.answer.request

    def run(self, number: int) -> None:
        """Compute the latest request, and again if there is another one by then."""
        request = self.latest
        if self.closed or request is None or number != self.number:
            return
        current.run = self, request, number
        token = interruption.set(check_cancelled)
        try:
            answer = self.answered(request)
        finally:
            interruption.reset(token)
        with self.lock:
            if number != self.number:
                return
            replaced = self.latest is not request
            if not (replaced and isinstance(answer.error, Cancelled)):
                self.answer = answer
            self.busy = replaced and not self.closed
            if self.busy:
                self.start()
        self.ready()

    def answered(self, request: Q) -> Answer[Q, R]:
        """The answer to a request. A mistake of ours is logged and ends nobody's session."""
        try:
            return self.kind(request, self.compute(request))
        except (BeamvizError, Cancelled) as error:
            return self.kind(request, error=error)
        except Exception as error:
            log.error(self.name, request, error)
            return self.kind(request, error=BeamvizError(f"unexpected: {error}"))

    def close(self) -> None:
        """Compute nothing more."""
        with self.lock:
            self.closed = True


# The solution of the case that a visitor has entered


@dataclass(frozen=True)
class SolverAnswer(Answer[Case, "Solved"]):
    """What came of a case."""

    @property
    def solution(self) -> Solution | None:
        """The solution, if there is one."""
        return self.result.solution if self.result else None

    @property
    def shapes(self) -> SampledModes | None:
        """The solution as the scene draws it, if there is one."""
        return self.result.shapes if self.result else None

    @cached_property
    def beam(self) -> Beam | None:
        """The beam of the case, None where its numbers are no beam."""
        with contextlib.suppress(InvalidInput):
            return self.request.beam()
        return None

    @cached_property
    def warning(self) -> str:
        """Why the scene is greyed, on a few short lines; "" for a stable equilibrium."""
        if self.error:
            return error_summary(self.error, self.beam)
        return stability_warning(self.result.solution) if self.result else ""

    @cached_property
    def caution(self) -> str:
        """Why a stable equilibrium is far from a real beam, "" where it is not."""
        if self.solution is None or self.warning:
            return ""
        return stretch_caution(self.solution)

    @property
    def message(self) -> str:
        """What is wrong in full, "" for a stable equilibrium."""
        known = self.error is None or isinstance(self.error, NoEquilibrium)
        return self.warning if known else str(self.error)


class Solved(NamedTuple):
    """A solution, and its shapes as the scene draws them."""

    solution: Solution
    shapes: SampledModes


class SolveJob(Job[Case, Solved]):
    """Solves the latest case of one visitor. Modes keep the signs of the last stable ones."""

    kind = SolverAnswer
    answer: SolverAnswer | None

    def __init__(self, queue: SolveQueue, ready: Callable[[], None]):
        super().__init__("solution", self.solved, self.enqueue, ready)
        self.queue = queue
        self.shapes: SampledModes | None = None
        self.options: dict[str, Any] | None = None  # the last keywords solved with, and
        self.seconds = math.inf  # the processor time that took

    def enqueue(self, work: Work) -> None:
        """Have the latest case solved."""
        self.queue.submit(work, self.is_quick)

    def is_quick(self) -> bool:
        """Whether the latest case will take a moment, as the last one with its options did."""
        latest = self.latest
        return self.seconds < QUICK and latest is not None and self.options == latest.options

    def solved(self, case: Case) -> Solved:
        """Solve a case."""
        start = time.thread_time()
        try:
            solution = solve(case.beam(), **case.options)
            shapes = SampledModes.sampled(solution, self.shapes)
        finally:
            self.options, self.seconds = case.options, time.thread_time() - start
        if not stability_warning(solution):
            self.shapes = shapes
        return Solved(solution, shapes)
