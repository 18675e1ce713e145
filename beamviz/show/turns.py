"""Where wishes are answered: on threads, or, in a crowd, one after the other by what draws."""

from collections import deque
from collections.abc import Callable
from concurrent.futures import Executor
from functools import partial
from typing import Any


class Turns:
    """Hands work to threads while visitors are few. Where they are many, quick work waits here
    for its turn, and `come` is called: threads in each other's way would take longer for it."""

    def __init__(
        self,
        pool: Executor,
        crowded: Callable[[], bool] = lambda: False,
        come: Callable[[], None] = lambda: None,
    ):
        self.pool, self.crowded, self.come = pool, crowded, come
        self.waiting: deque[Callable[[], None]] = deque()

    def submit(self, work: Callable[[Any], None], wanted: Any, *, quick: bool) -> None:
        """Let `work` answer what is wanted; quick: as far as is known, it takes but a moment."""
        if quick and self.crowded():
            self.waiting.append(partial(work, wanted))
            self.come()
        else:
            self.pool.submit(work, wanted)

    def take(self) -> None:
        """Do what has waited longest."""
        self.waiting.popleft()()
