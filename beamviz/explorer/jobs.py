"""Background jobs on worker threads shared by all visitors.

A `Job` computes one kind of result for one visitor, always for the latest request. It runs on a
`WorkerPool`, whose threads persist and in which long work does not delay other work; solves go
through `Workers`, which runs them in batches while visitors are many.
"""

import contextlib
import math
import threading
import time
from collections import deque
from collections.abc import Callable
from contextvars import copy_context
from dataclasses import dataclass
from functools import cached_property, partial
from queue import SimpleQueue
from typing import Any, ClassVar, Generic, TypeVar

from beamviz.beam import Beam
from beamviz.drawing.modes import SampledModes
from beamviz.drawing.text import error_summary, stability_warning, stretch_caution
from beamviz.errors import BeamvizError, Cancelled, InvalidInput, NoEquilibrium
from beamviz.explorer.state import Case
from beamviz.server.log import RateLimitedLog
from beamviz.solver import Solution, interruption, solve

SOLVERS = 2  # solves at once, for all visitors of a process
LONG = 2.0  # [s] of work, after which another thread takes the place of its own
QUICK = 0.02  # [s] processor time of a solve that may run in a batch
PATIENCE = 1.0  # [s] after which the page shows that a job is running
OUTDATED = 3.0  # [s] after which a computation is cancelled if there is a later request
BATCH_TIMEOUT = 0.25  # [s] that the frame loop waits for a batch of solves

log = RateLimitedLog(__name__)

Q = TypeVar("Q")
R = TypeVar("R")
Callback = Callable[[], None]
Submit = Callable[[Callback], None]


class WorkerPool:
    """Runs work in order of submission, on `workers` threads besides those that are late and were
    replaced. They are daemons: the process may end before them. Work must not raise.

    started: the time [s] when each busy thread began its work, without those replaced.
    """

    def __init__(self, workers: int, name: str):
        self.workers, self.name, self.closed = workers, name, False
        self.waiting: SimpleQueue[Callback | None] = SimpleQueue()
        self.started: dict[threading.Thread, float] = {}
        for _ in range(workers):
            self.add_thread()

    def add_thread(self) -> None:
        threading.Thread(target=self.run, name=self.name, daemon=True).start()

    def submit(self, work: Callback) -> None:
        self.waiting.put(work)

    def run(self) -> None:
        """Run work until the pool is closed, or another thread has taken the place of this one."""
        thread = threading.current_thread()
        while (work := self.waiting.get()) and not self.closed:
            self.started[thread] = time.monotonic()
            work()
            del work  # it refers to a visitor, who may leave
            if self.started.pop(thread, None) is None:
                return

    def replace(self, late: float = LONG) -> None:
        """Start threads in place of those whose work has taken `late` seconds, which end after it.
        The frame loop calls this at least every PATIENCE seconds while a job is busy."""
        for thread, started in list(self.started.items()):
            if time.monotonic() >= started + late and self.started.pop(thread, 0.0):
                self.add_thread()

    def close(self) -> None:
        """Discard waiting work and end the threads; running work is completed."""
        self.closed = True
        for _ in range(self.workers):
            self.waiting.put(None)


class Workers:
    """The worker threads of all visitors of a process.

    While visitors are many, quick solves wait here, and the frame loop runs them in batches: this
    takes less time than threads that compete with the frame loop for the interpreter lock.

    crowded: whether there are many visitors; notify: called when a solve waits for a batch;
    background: for charts, maps and other long work.
    """

    def __init__(self, crowded: Callable[[], bool], notify: Callback = lambda: None):
        self.crowded, self.notify = crowded, notify
        self.background, self.pool = WorkerPool(1, "chart"), WorkerPool(SOLVERS, "solver")
        self.batch_pool = WorkerPool(1, "solver batch")
        self.waiting: deque[tuple[Callback, Callable[[], bool]]] = deque()

    def solve(self, work: Callback, is_quick: Callable[[], bool]) -> None:
        if self.crowded() and is_quick():
            self.waiting.append((work, is_quick))
            self.notify()
        else:
            self.pool.submit(work)

    def run_batch(self, count: int) -> None:
        """Run up to `count` of the waiting solves and wait for them, BATCH_TIMEOUT at most: a solve
        that takes longer is completed in the background, as are those after it."""
        if not self.waiting:
            return
        for _ in range(min(count, len(self.waiting))):
            work, is_quick = self.waiting.popleft()
            pool = self.batch_pool if is_quick() else self.pool  # the method may have changed
            pool.submit(work)
        done = threading.Event()
        self.batch_pool.submit(done.set)
        if not done.wait(BATCH_TIMEOUT):
            self.batch_pool.replace(late=0.0)

    def close(self) -> None:
        self.waiting.clear()
        for pool in (self.background, self.pool, self.batch_pool):
            pool.close()


@dataclass(frozen=True)
class Answer(Generic[Q, R]):
    """The answer to a request: a result, or an error."""

    request: Q
    result: R | None = None
    error: BeamvizError | Cancelled | None = None

    @property
    def message(self) -> str:
        """The text of the error; "" for a result."""
        return str(self.error) if self.error else ""


class Job(Generic[Q, R]):
    """Computes the latest request of one visitor and skips those before it.

    name: of the result, for messages; compute: returns the result of a request, on a worker thread;
    ready: called after each answer. answer: the last one, None before the first; latest: the last
    request; busy: a request is being computed; started: the time [s] when that began; done: the
    fraction computed, 0 where unknown; number: of the run whose result counts; following: answers
    are those of another visitor's job, and nothing is computed; kind: of the answers.
    """

    kind: ClassVar[type[Answer]] = Answer

    def __init__(self, name: str, compute: Callable[[Q], R], submit: Submit, ready: Callback):
        self.name, self.compute, self.submit, self.ready = name, compute, submit, ready
        self.lock = threading.RLock()
        self.latest: Q | None = None
        self.answer: Answer[Q, R] | None = None
        self.busy = self.closed = self.following = False
        self.started, self.done, self.number = 0.0, 0.0, 0

    @property
    def result(self) -> R | None:
        return self.answer.result if self.answer else None

    def request(self, request: Q) -> None:
        """Compute `request` instead of earlier ones, unless it is the latest already."""
        with self.lock:
            if request == self.latest or self.following:
                return
            self.latest = request
            if not self.busy:
                self.start()

    def start(self) -> None:
        """Submit the latest request, to run in a context of its own."""
        self.busy, self.started, self.done = True, time.monotonic(), 0.0
        self.submit(partial(copy_context().run, self.run, self.number))

    @property
    def slow(self) -> bool:
        """Whether the computation has taken PATIENCE seconds."""
        return self.busy and time.monotonic() > self.started + PATIENCE

    @property
    def cancelled(self) -> bool:
        return self.answer is not None and isinstance(self.answer.error, Cancelled)

    def cancel(self) -> None:
        """Stop computing; the answer to the latest request is that it was cancelled."""
        with self.lock:
            if not self.busy:
                return
            self.number, self.busy = self.number + 1, False
            self.answer = self.kind(self.latest, error=Cancelled("The calculation was cancelled."))
        self.ready()

    def withdraw(self) -> None:
        """Stop computing the latest request, or forget that it was cancelled."""
        with self.lock:
            if self.busy:
                self.number, self.busy, self.latest = self.number + 1, False, None
            elif self.cancelled:
                self.answer = self.latest = None

    def retry(self) -> None:
        """Compute the latest request again if it was cancelled."""
        with self.lock:
            if self.cancelled and not self.busy:
                self.start()

    def follow(self, other: "Job[Q, R] | None") -> None:
        """Use the answer of another visitor's job, and compute nothing until there is none."""
        with self.lock:
            self.following = other is not None
            if other and other.answer:
                self.answer, self.latest = other.answer, other.answer.request

    def run(self, number: int) -> None:
        """Compute the latest request, then the next one if there is one by then."""
        request = self.latest
        if self.closed or request is None or number != self.number:
            return
        interruption.set(partial(self.check, number, request))
        answer = self.answered(request)
        with self.lock:
            if number != self.number:
                return
            replaced = self.latest is not request
            if not (replaced and isinstance(answer.error, Cancelled)):
                self.answer = answer
            self.busy = replaced
            if self.busy:
                self.start()
        self.ready()

    def check(self, number: int, request: Q, done: float | None = None) -> None:
        """Store the fraction `done` of a run. Raises Cancelled if the visitor has cancelled it, or
        has made another request and it has taken OUTDATED seconds."""
        late = self.latest is not request and time.monotonic() > self.started + OUTDATED
        if self.number != number or self.closed or late:
            raise Cancelled
        self.done = self.done if done is None else done

    def answered(self, request: Q) -> Answer[Q, R]:
        """The answer to a request; an unexpected error is logged, and is an answer too."""
        try:
            return self.kind(request, self.compute(request))
        except (BeamvizError, Cancelled) as error:
            return self.kind(request, error=error)
        except Exception as error:
            log.error(self.name, request, error)
            return self.kind(request, error=BeamvizError(f"unexpected: {error}"))

    def close(self) -> None:
        self.closed = True


# Solutions


@dataclass(frozen=True)
class SolverAnswer(Answer[Case, SampledModes]):
    """The answer to a case: its modes as the scene draws them, or the error."""

    @property
    def solution(self) -> Solution | None:
        return self.result.solution if self.result else None

    @cached_property
    def beam(self) -> Beam | None:
        """The beam of the case; None where one of its numbers is out of range."""
        with contextlib.suppress(InvalidInput):
            return self.request.beam()
        return None

    @cached_property
    def warning(self) -> str:
        """The reason why the beam is drawn grey, in short lines; "" for a stable equilibrium."""
        if self.error:
            return error_summary(self.error, self.beam)
        return stability_warning(self.solution) if self.solution else ""

    @cached_property
    def caution(self) -> str:
        """The reason why no real beam has this stable equilibrium; "" where one may."""
        return stretch_caution(self.solution) if self.solution and not self.warning else ""

    @property
    def message(self) -> str:
        """The full text of the warning or the error; "" for a stable equilibrium."""
        known = self.error is None or isinstance(self.error, NoEquilibrium)
        return self.warning if known else str(self.error)


class SolveJob(Job[Case, SampledModes]):
    """Solves the latest case of one visitor. Modes keep the signs of the last stable ones."""

    kind = SolverAnswer
    answer: SolverAnswer | None

    def __init__(self, workers: Workers, ready: Callback):
        submit = partial(workers.solve, is_quick=self.is_quick)
        super().__init__("solution", self.solved, submit, ready)
        self.shapes: SampledModes | None = None  # the last stable ones
        self.options: dict[str, Any] | None = None  # of the last case solved
        self.seconds = math.inf  # processor time of its solve

    def is_quick(self) -> bool:
        """Whether the latest case has the options of the last one solved, and that was quick."""
        latest = self.latest
        return self.seconds < QUICK and latest is not None and self.options == latest.options

    def solved(self, case: Case) -> SampledModes:
        start = time.thread_time()
        try:
            solution = solve(case.beam(), **case.options)
            shapes = SampledModes.sampled(solution, self.shapes)
        finally:
            self.options, self.seconds = case.options, time.thread_time() - start
        if not stability_warning(solution):
            self.shapes = shapes
        return shapes
