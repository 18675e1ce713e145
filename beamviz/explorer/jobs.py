"""The latest wish of one visitor, answered on threads shared by all."""

import threading
from abc import ABC, abstractmethod
from collections.abc import Callable
from concurrent.futures import Executor
from typing import Generic, Self, TypeVar

State = tuple[object, ...]
W = TypeVar("W")
A = TypeVar("A")


class Latest(ABC, Generic[W, A]):
    """Answers the latest wish; wishes that came while it was busy are skipped but for the last.

    answer: the last answer given, None before the first; `ready` is called after each.
    """

    def __init__(self, pool: Executor, ready: Callable[[], None]):
        self.lock = threading.RLock()
        self.pool, self.ready = pool, ready
        self.wanted: W | None = None
        self.answer: A | None = None
        self.busy = self.closed = False

    @abstractmethod
    def answered(self, wanted: W) -> A:
        """The answer to one wish."""

    def want(self, wanted: W) -> None:
        """Ask for an answer to `wanted`, soon, in place of any earlier wish."""
        with self.lock:
            self.wanted = wanted
            if not (self.busy or self.closed):
                self.busy = True
                self.line_up()

    def line_up(self) -> None:
        """Have the wish answered that is the latest when its time has come."""
        self.pool.submit(self.work)

    def adopt(self, other: Self) -> None:
        """Take over another's wish, and its answer as far as it has one."""
        with self.lock:
            self.wanted, self.answer = other.wanted, other.answer

    def work(self) -> None:
        """Answer the latest wish, and line up again if there is another by then."""
        wanted = self.wanted
        if self.closed or wanted is None:
            return
        answer = self.answered(wanted)
        with self.lock:
            self.answer = answer
            self.busy = self.wanted is not wanted and not self.closed
            if self.busy:
                self.line_up()
        self.ready()

    def close(self) -> None:
        """No more answers."""
        with self.lock:
            self.closed = True


def stale(drawn: State, state: State) -> bool:
    """Whether what was drawn last is not this state: each part has to be the very same thing."""
    return len(state) != len(drawn) or any(a is not b for a, b in zip(state, drawn, strict=True))
