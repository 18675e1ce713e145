"""Where wishes are answered: on threads, or, in a crowd, a few after the other while nobody else
is at work, not even what draws."""

import contextlib
import queue
import threading
from collections import deque
from collections.abc import Callable
from concurrent.futures import Executor

PATIENCE = 0.25  # [s] that all others wait for a few answers; what takes longer goes on beside

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
        self.helper: Helper | None = None

    def submit(self, work: Work, quick: Quick) -> None:
        """Do some work soon; quick: whether it takes but a moment, as far as is known."""
        if self.crowded() and quick():
            self.waiting.append((work, quick))
            self.come()
        else:
            self.pool.submit(work)

    def take(self, count: int) -> None:
        """Have done what has waited longest, `count` of it, and wait for it; but nobody waits for
        work that is not as quick as it seemed."""
        works: deque[tuple[Work, Quick]] = deque()
        while self.waiting and len(works) < count:
            work, quick = self.waiting.popleft()
            if quick():
                works.append((work, quick))
            else:  # another method was chosen meanwhile
                self.pool.submit(work)
        if works:
            self.helper = self.helper or Helper()
            if not self.helper.did(works):
                self.helper = None
                with contextlib.suppress(IndexError):  # it may take the last one meanwhile
                    while True:
                        self.waiting.appendleft(works.pop())

    def close(self) -> None:
        """Nothing more is done."""
        if self.helper:
            self.helper.works.put(None)


class Helper:
    """A thread that works while another one waits for it."""

    def __init__(self) -> None:
        self.works: queue.SimpleQueue[deque[tuple[Work, Quick]] | None] = queue.SimpleQueue()
        self.done = threading.Event()
        threading.Thread(target=self.run, name="helper", daemon=True).start()

    def did(self, works: deque[tuple[Work, Quick]]) -> bool:
        """Whether some work was done in a moment, bit by bit. If not, what has been begun is the
        last that this thread does."""
        self.done.clear()
        self.works.put(works)
        if self.done.wait(PATIENCE):
            return True
        self.works.put(None)
        return False

    def run(self) -> None:
        """Work."""
        while works := self.works.get():
            while work := first(works):
                work()
            self.done.set()


def first(works: deque[tuple[Work, Quick]]) -> Work | None:
    """Some work, taken out; None where there is no more, or it has been taken back."""
    try:
        return works.popleft()[0]
    except IndexError:
        return None
