"""Background jobs on worker threads shared by all visitors.

A `Job` computes one kind of result for one visitor, always for the latest request, on a
`WorkerPool`. Solves that were quick so far wait for the next frame, which waits for them: threads
that compete with the frame loop for the interpreter lock would take more time than the work itself.
"""

import math
import threading
import time
from collections.abc import Callable
from contextvars import copy_context
from dataclasses import dataclass
from functools import cached_property, partial
from queue import SimpleQueue
from typing import Any, Generic, NamedTuple, TypeVar, cast

from beamviz.beam import Beam
from beamviz.drawing.modes import SampledModes
from beamviz.drawing.text import (
    error_summary,
    in_words,
    out_of_range,
    stability_warning,
    stretch_caution,
)
from beamviz.errors import BeamvizError, Cancelled, NoEquilibrium
from beamviz.explorer.second_beam import ComparisonCase
from beamviz.explorer.state import Case
from beamviz.server.log import RateLimitedLog
from beamviz.solver import Solution, interruption, solve
from beamviz.units import Units

SOLVERS = 16  # threads: more only start while others solve for long
CHARTS = 3  # threads for charts and maps
QUICK = 0.02  # [s] processor time of a solve that a frame waits for
LATE = 0.25  # [s] after which the page says of a result that it is that to an earlier request
PATIENCE = 1.0  # [s] after which it offers to cancel the computation
OUTDATED = 3.0  # [s] after which a computation is cancelled if there is a later request
SOLUTION = "solution"  # name of the job
PENDING = object()  # a request that follows from an answer to come
WAIT = 0.1  # [s] that a frame waits for it at most

log = RateLimitedLog(__name__)

Q = TypeVar("Q")
R = TypeVar("R")
Callback = Callable[[], None]
Submit = Callable[[Callback], None]


class WorkerPool:
    """Runs work in order of submission on up to `most` threads, which are started when all others
    are at work. They are daemons: the process may end before them. Work must not raise."""

    def __init__(self, most: int, name: str):
        self.most, self.name, self.closed = most, name, False
        self.waiting: SimpleQueue[Callback | None] = SimpleQueue()
        self.lock = threading.Lock()
        self.threads = self.unfinished = 0

    def submit(self, work: Callback) -> None:
        with self.lock:
            self.unfinished += 1
            if self.unfinished > self.threads < self.most and not self.closed:
                self.threads += 1
                threading.Thread(target=self.run, name=self.name, daemon=True).start()
        self.waiting.put(work)

    def run(self) -> None:
        """Run work until the pool is closed."""
        while (work := self.waiting.get()) and not self.closed:
            work()
            del work  # it refers to a visitor, who may leave
            with self.lock:
                self.unfinished -= 1

    def close(self) -> None:
        """Discard waiting work and end the threads; running work is completed."""
        with self.lock:
            self.closed = True
            for _ in range(self.threads):
                self.waiting.put(None)


class Workers:
    """The worker threads of all visitors of a process; background: for charts and maps."""

    def __init__(self) -> None:
        self.background, self.solvers = WorkerPool(CHARTS, "chart"), WorkerPool(SOLVERS, "solver")

    def close(self) -> None:
        self.background.close()
        self.solvers.close()


@dataclass(frozen=True, eq=False)
class Answer(Generic[Q, R]):
    """The answer to a request: a result, or an error."""

    request: Q
    result: R | None = None
    error: BeamvizError | Cancelled | None = None

    @property
    def message(self) -> str:
        """The text of the error in the words and units of the page; "" for a result."""
        return in_words(str(self.error), self.units) if self.error else ""

    @property
    def units(self) -> Units | None:
        """The size of the beam of the request, if it has one and its size is known."""
        return getattr(self.request, "units", None)

    @property
    def cancelled(self) -> bool:
        return isinstance(self.error, Cancelled)


class JobStatus(NamedTuple, Generic[Q, R]):
    """A job at one moment. answer: the last one, None before the first; busy: a request is being
    computed; late, slow: for LATE and PATIENCE seconds the last answer has not been that to the
    latest request; seconds: for how long, 0 unless slow; done: the fraction computed, 0 where
    unknown; note: its progress in words."""

    name: str
    answer: Answer[Q, R] | None
    busy: bool
    late: bool
    slow: bool
    seconds: int
    done: float
    note: str

    @property
    def result(self) -> R | None:
        return self.answer.result if self.answer else None

    @property
    def cancelled(self) -> bool:
        return self.answer is not None and self.answer.cancelled


class Job(Generic[Q, R]):
    """Computes the latest request of one visitor and skips those before it.

    name: of the result, for messages; compute: returns the result of a request, on a worker thread;
    ready: called after each answer. answer: the last one, None before the first; latest: the last
    request; delayed: it is not to be computed yet; busy: a request is being computed; started: the
    time [s] when that began; replaced: when another one replaced it, None while it is the latest;
    since: when the last answer ceased to be that to the latest request, None while it is; done: the
    fraction computed, 0 where unknown; note: its progress in words; number: of the run whose result
    counts.
    """

    def __init__(self, name: str, compute: Callable[[Q], R], submit: Submit, ready: Callback):
        self.name, self.compute, self.submit, self.ready = name, compute, submit, ready
        self.lock = threading.RLock()
        self.latest: Q | None = None
        self.answer: Answer[Q, R] | None = None
        self.busy = self.closed = self.delayed = False
        self.since: float | None = None
        self.replaced: float | None = None
        self.started, self.done, self.note, self.number = 0.0, 0.0, "", 0

    @property
    def status(self) -> JobStatus[Q, R]:
        """The job at this moment."""
        with self.lock:
            seconds = time.monotonic() - self.since if self.since else 0.0
            late, slow = seconds > LATE, seconds > PATIENCE
            shown = int(seconds) if slow else 0
            done, note = (self.done, self.note) if self.busy else (0.0, "")
            return JobStatus(self.name, self.answer, self.busy, late, slow, shown, done, note)

    def request(self, request: Q, *, later: bool = False) -> None:
        """Compute `request` instead of earlier ones, unless it is the latest already, or the last
        answer is that to it. later: do not begin it, as it will be requested again."""
        with self.lock:
            if request != self.latest:
                self.replace(request)
            elif not self.delayed:
                return
            self.delayed = later and self.since is not None
            if self.since is not None and not (self.busy or later):
                self.start()

    def replace(self, request: Q) -> None:
        """Take a request as the latest."""
        now, answer, self.latest = time.monotonic(), self.answer, request
        if answer and answer.request == request and not answer.cancelled:
            self.stop()
            return
        self.since = self.since or now
        if self.busy:
            self.replaced = self.replaced or now

    def expect(self) -> None:
        """A request is to come that is not known yet: the last answer is that to an earlier one."""
        with self.lock:
            now, self.latest, self.delayed = time.monotonic(), None, True
            self.since = self.since or now
            if self.busy:
                self.replaced = self.replaced or now

    def stop(self) -> None:
        """Do not go on with what is being computed."""
        self.number, self.busy, self.delayed = self.number + self.busy, False, False
        self.since = self.replaced = None

    def start(self) -> None:
        """Submit the latest request, to run in a context of its own."""
        self.begin()
        self.submit(partial(copy_context().run, self.run, self.number))

    def begin(self) -> None:
        """Note that the latest request is being computed."""
        self.busy, self.started, self.done, self.note = True, time.monotonic(), 0.0, ""
        self.since, self.replaced = self.since or self.started, None

    def cancel(self) -> None:
        """Stop computing; the answer to the latest request is that it was cancelled."""
        with self.lock:
            if not self.busy:
                return
            self.stop()
            self.answer = Answer(
                cast(Q, self.latest), error=Cancelled("The calculation was cancelled.")
            )
        self.ready()

    def withdraw(self) -> None:
        """Stop computing the latest request, or forget that it was cancelled."""
        with self.lock:
            if self.answer and self.answer.cancelled and not self.busy:
                self.answer = self.latest = None
            elif self.busy or self.delayed:
                self.latest = None
                self.stop()

    def retry(self) -> None:
        """Compute the latest request again if it was cancelled."""
        with self.lock:
            if self.answer and self.answer.cancelled and not self.busy:
                self.start()

    def run(self, number: int) -> None:
        """Compute the latest request, then the next one if there is one by then."""
        with self.lock:
            request, self.replaced = self.latest, None  # those before it are not computed any more
            if self.closed or number != self.number:
                return
            if request is None:  # it was replaced by one that is not known yet
                self.busy = False
                return
        interruption.set(partial(self.check, number, request))
        answer = self.answered(request)
        with self.lock:
            if number != self.number:
                return
            replaced = self.latest is not request
            if not (replaced and isinstance(answer.error, Cancelled)):
                self.answer, self.since = answer, self.replaced if replaced else None
            self.busy = replaced and not self.delayed
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
            return Answer(request, self.compute(request))
        except (BeamvizError, Cancelled) as error:
            return Answer(request, error=error)
        except Exception as error:
            log.error(self.name, request, error)
            return Answer(request, error=BeamvizError(f"unexpected: {error}"))

    def close(self) -> None:
        self.closed = True


# Solutions


@dataclass(frozen=True, eq=False)
class SolverAnswer(Answer[Case, SampledModes]):
    """The answer to a case: its modes as the scene draws them, or the error."""

    @property
    def solution(self) -> Solution | None:
        return self.result.solution if self.result else None

    @property
    def beam(self) -> Beam | None:
        """The beam of the case; None where one of its numbers is out of range."""
        return self.request.beam if self.request.in_range else None

    @cached_property
    def shapes(self) -> SampledModes:
        """The modes, or without a solution the unloaded beam of the case, or the nearest to it."""
        return self.result or SampledModes.at_rest(
            self.beam or self.request.nearest_beam(), self.request.options["plane"]
        )

    @cached_property
    def warning(self) -> str:
        """The reason why no beam is at rest here, in short lines; "" for a stable equilibrium."""
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
        return self.warning if known else case_error(str(self.error), self.request)


def case_error(text: str, case: Case) -> str:
    """An error of a case in the words of the page; a number out of range in its own unit."""
    return out_of_range(case.numbers, case.units) or in_words(text, case.units)


class Cases(NamedTuple):
    """A case to solve, and what to compare it with."""

    case: Case
    comparison: ComparisonCase = ComparisonCase()


class Solved(NamedTuple):
    """The answers to two cases, so that a picture never shows beams of different moments."""

    answer: SolverAnswer
    second: SolverAnswer | None


class SolveJob(Job[Cases, Solved]):
    """Solves the latest case of one visitor, and the one that it is compared with.

    options, seconds: of the last case solved, and the processor time that it took; first, second:
    the last answers, as many cases are compared with one, and one with many; waits: the latest
    request is left to the next frame; awaited: a frame waits for the answer, which needs no other;
    finished: set when nothing is being solved for a frame.
    """

    def __init__(self, workers: Workers, ready: Callback):
        super().__init__(SOLUTION, self.solved, workers.solvers.submit, self.tell)
        self.wake = ready
        self.options: dict[str, Any] | None = None
        self.seconds = math.inf
        self.first: SolverAnswer | None = None
        self.second: SolverAnswer | None = None
        self.waits, self.awaited, self.finished = False, False, threading.Event()

    def start(self) -> None:
        """Leave the latest request to the next frame if it is likely to be quick, else submit it.
        It is, if the last one was, with the same options."""
        assert self.latest
        self.waits = self.seconds < QUICK and self.options == self.latest.case.options
        if self.waits:
            self.begin()
            self.finished.clear()
        else:
            super().start()

    def finish(self) -> None:
        """Solve a request that was left to this frame, and wait for it. A solve that takes longer
        than WAIT goes on in the background."""
        with self.lock:
            if not self.waits:
                return
            self.waits, self.awaited = False, True
            super().start()
        self.finished.wait(WAIT)
        self.awaited = False

    def tell(self) -> None:
        """Wake the visitor, unless their frame waits for the answer."""
        if not self.awaited:
            self.wake()

    def run(self, number: int) -> None:
        super().run(number)
        self.finished.set()

    def solved(self, cases: Cases) -> Solved:
        """The answers. Raises Cancelled."""
        case, other = cases.case, cases.comparison.case
        first, second = self.first, self.second  # which a run that was given up may replace
        has_first = first is not None and first.request == case
        has_second = other is None or (second is not None and second.request == other)
        start = time.thread_time()
        try:
            if not has_first:
                self.first = first = solver_answer(case)
            if other and not has_second:
                self.second = second = solver_answer(other)
        finally:
            if not (has_first and has_second):
                self.options, self.seconds = case.options, time.thread_time() - start
        assert first
        return Solved(first, second if other else None)

    @property
    def compared(self) -> tuple[SolverAnswer | None, SolverAnswer | None, ComparisonCase]:
        """The latest answers, or the reason why there are none, and what was compared with."""
        if (answer := self.answer) is None:
            return None, None, ComparisonCase()
        comparison = answer.request.comparison
        if answer.result is None:
            return SolverAnswer(answer.request.case, error=answer.error), None, comparison
        return *answer.result, comparison


def solver_answer(case: Case) -> SolverAnswer:
    """The answer to a case. Raises Cancelled."""
    try:
        return SolverAnswer(case, SampledModes.sampled(solve(case.beam, **case.options)))
    except BeamvizError as error:
        return SolverAnswer(case, error=error)
