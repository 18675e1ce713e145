"""Where wishes are answered: on threads, or, in a crowd, one after the other by what draws."""

from collections import deque
from collections.abc import Callable
from concurrent.futures import Executor

Work = Callable[[], None]
Quick = Callable[[], bool]


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
        self.waiting: deque[tuple[Work, Quick]] = deque()

    def submit(self, work: Work, quick: Quick) -> None:
        """Do some work soon; quick: whether it takes but a moment, as far as is known."""
        if self.crowded() and quick():
            self.waiting.append((work, quick))
            self.come()
        else:
            self.pool.submit(work)

    def take(self) -> None:
        """Do what has waited longest."""
        work, quick = self.waiting.popleft()
        if quick():
            work()
        else:  # another method was chosen meanwhile
            self.pool.submit(work)
