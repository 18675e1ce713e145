"""Background jobs on worker threads shared by all visitors.

A `Job` computes one kind of result for one visitor, always for the latest request, on a
`WorkerPool`.
"""

import contextlib
import threading
import time
from collections.abc import Callable, Iterable
from contextvars import copy_context
from dataclasses import dataclass
from functools import partial
from queue import SimpleQueue
from typing import Any, Generic, NamedTuple, TypeVar

from beamviz.beam import Beam
from beamviz.drawing.text import error_text, in_words
from beamviz.errors import BeamvizError, Cancelled, InvalidInput, to_keep
from beamviz.server.log import RateLimitedLog
from beamviz.solver import interruption

SOLVERS = 16  # threads: more only start while others solve for long
CHARTS = 2  # threads for charts and maps, which take 5 to 140 MB each
LATE = 0.25  # [s] after which the page says that a result is outdated
PATIENCE = 1.0  # [s] after which it offers to cancel the computation
OUTDATED = 3.0  # [s] after which a computation is cancelled if there is a later request
PENDING = object()  # stands for a request that will follow from an answer that is not there yet

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
        """Computation work until the pool is closed."""
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
        if self.error is None:
            return ""
        if self.beam:
            return error_text(self.error, self.beam)
        return in_words(str(self.error), getattr(self.request, "units", None))

    @property
    def beam(self) -> Beam | None:
        """The beam of the request; None without one, or with a number out of range."""
        with contextlib.suppress(InvalidInput):
            return getattr(self.request, "beam", None)
        return None

    @property
    def cancelled(self) -> bool:
        return isinstance(self.error, Cancelled)


class JobStatus(NamedTuple, Generic[Q, R]):
    """A job at one moment. Its last answer is outdated while that is not the answer to the latest
    request."""

    name: str
    answer: Answer[Q, R] | None  # the last one; None before the first
    busy: bool  # a request is being computed
    late: bool  # the answer has been outdated for LATE seconds
    slow: bool  # the answer has been outdated for PATIENCE seconds
    seconds: int  # for which it has been outdated; 0 unless slow
    done: float  # fraction computed; 0 where unknown
    note: str  # progress in words
    latest: Q | None = None  # request; None before the first, and while the next is not known yet
    is_own: bool = True  # the visitor can cancel and repeat it

    @property
    def result(self) -> R | None:
        return self.answer.result if self.answer else None

    @property
    def cancelled(self) -> bool:
        return self.answer is not None and self.answer.cancelled


def percentage(jobs: Iterable[JobStatus[Any, Any]]) -> str:
    """The largest fraction that running jobs have computed, below 100 %; "" where unknown."""
    done = max((job.done for job in jobs), default=0.0)
    return f" {min(100 * done, 99):.0f} %" if done else ""


@dataclass(eq=False)
class Computation(Generic[Q]):
    """The computation of a request; times in seconds of the monotonic clock."""

    request: Q  # the latest request at the start
    started: float  # when it began; until then when it was submitted
    replaced: float | None = None  # when another request became the latest
    done: float = 0.0  # fraction computed; 0 where unknown
    note: str = ""  # progress in words


class Job(Generic[Q, R]):
    """Computes the latest request of one visitor and skips those before it.

    name: of the result, for messages; compute: returns the result of a request, on a worker thread;
    ready: called after each answer.
    """

    def __init__(self, name: str, compute: Callable[[Q], R], submit: Submit, ready: Callback):
        self.name, self.compute, self.submit, self.ready = name, compute, submit, ready
        self.lock = threading.RLock()
        self.latest: Q | None = None  # request; None while the next one is not known yet
        self.answer: Answer[Q, R] | None = None  # the last one
        self.run: Computation[Q] | None = None  # under way
        self.since: float | None = None  # [s] when `answer` ceased to be that to `latest`
        self.closed = False

    @property
    def busy(self) -> bool:
        return self.run is not None

    @property
    def status(self) -> JobStatus[Q, R]:
        """The job at this moment."""
        with self.lock:
            seconds = 0.0 if self.since is None else time.monotonic() - self.since
            late, slow = seconds > LATE, seconds > PATIENCE
            shown = int(seconds) if slow else 0
            done, note = (self.run.done, self.run.note) if self.run else (0.0, "")
            return JobStatus(
                name=self.name,
                answer=self.answer,
                busy=self.busy,
                late=late,
                slow=slow,
                seconds=shown,
                done=done,
                note=note,
                latest=self.latest,
            )

    def knows(self, request: Q) -> bool:
        """Whether a request is the latest, or the one that was answered last."""
        with self.lock:
            answered = self.answer is not None and self.answer.request == request
            return answered or request == self.latest

    def request(self, request: Q) -> None:
        """Compute `request` instead of earlier ones, unless it is the latest already, or the last
        answer is that to it."""
        with self.lock:
            if self.closed or request == self.latest:
                return
            self.latest = request
            if self.is_answered:
                self.run = self.since = None
                return
            self.outdate()
            if self.run is None:
                self.begin()

    @property
    def is_answered(self) -> bool:
        """Whether the last answer is a result, or an error, of the latest request."""
        answer = self.answer
        return answer is not None and answer.request == self.latest and not answer.cancelled

    def expect(self) -> None:
        """A request is to come that is not known yet: the last answer is that to an earlier one."""
        with self.lock:
            self.latest = None
            self.outdate()

    def settle(self) -> None:
        """No request is to come after all: the latest one is that of the computation under way, or
        else that of the last answer."""
        with self.lock:
            if self.latest is not None or self.since is None:
                return
            if self.run:
                self.latest, self.run.replaced = self.run.request, None
            else:
                self.since = None

    def outdate(self) -> None:
        """Note that the latest request is not that of the last answer, and whether it is that of
        the computation under way."""
        now = time.monotonic()
        self.since = self.since or now
        if self.run and self.run.request == self.latest:
            self.run.replaced = None
        elif self.run:
            self.run.replaced = self.run.replaced or now

    def begin(self) -> None:
        """Submit the latest request, to run in a context of its own."""
        assert self.latest is not None
        self.run = Computation(self.latest, time.monotonic())
        self.submit(partial(copy_context().run, self.perform, self.run))

    def perform(self, run: Computation[Q]) -> None:
        """Compute the latest request, then the next one if there is one by then."""
        if not self.is_needed(run):
            return
        interruption.set(partial(self.check, run))
        answer = self.answered(run.request)
        with self.lock:
            if run is not self.run:
                return
            self.run = None
            if not answer.cancelled:  # else it was given up
                self.answer, self.since = answer, run.replaced
            if self.since is not None and self.latest is not None:
                self.begin()
        self.ready()

    def is_needed(self, run: Computation[Q]) -> bool:
        """Whether there is something to compute in a run, which is the latest request then: those
        before it are skipped."""
        with self.lock:
            if self.closed or run is not self.run:
                return False
            if self.latest is None:  # it was replaced by one that is not known yet
                self.run = None
                return False
            run.request, run.replaced, run.started = self.latest, None, time.monotonic()
            return True

    def check(self, run: Computation[Q], done: float | None = None) -> None:
        """Store the fraction `done` of a run. Raises Cancelled if the visitor has cancelled it, or
        has made another request and it has taken OUTDATED seconds."""
        outdated = run.replaced and time.monotonic() > run.started + OUTDATED
        if run is not self.run or self.closed or outdated:
            raise Cancelled
        run.done = run.done if done is None else done

    def answered(self, request: Q) -> Answer[Q, R]:
        """The answer to a request; an unexpected error is logged, and is an answer too."""
        try:
            return Answer(request, self.compute(request))
        except (BeamvizError, Cancelled) as error:
            return Answer(request, error=to_keep(error))
        except Exception as error:
            log.error(self.name, request, error)
            return Answer(request, error=BeamvizError(f"unexpected: {error}"))

    def cancel(self) -> None:
        """Stop computing; the answer to the latest request is that it was cancelled."""
        with self.lock:
            if self.run is None:
                return
            request = self.run.request if self.latest is None else self.latest
            self.answer = Answer(request, error=Cancelled("The calculation was cancelled."))
            self.run = self.since = None
        self.ready()

    def retry(self) -> None:
        """Compute the latest request again if it was cancelled."""
        with self.lock:
            if self.answer and self.answer.cancelled and self.run is None:
                self.latest = self.answer.request
                self.outdate()
                self.begin()

    def withdraw(self) -> None:
        """Stop computing, and forget a request that was cancelled."""
        with self.lock:
            if self.answer and self.answer.cancelled:
                self.answer = None
            self.latest = self.run = self.since = None

    def taken(self) -> Answer[Q, R] | None:
        """The last answer, which is kept with its request only where that was cancelled, to be
        computed again."""
        with self.lock:
            answer = self.answer
            if answer and not answer.cancelled:
                self.answer = None
                if self.latest is answer.request:
                    self.latest = None
            return answer

    def close(self) -> None:
        self.closed = True
