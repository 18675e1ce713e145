"""When the charts follow what is shown: at once, or, among many visitors, after a rest."""

import math
from collections.abc import Callable

REST = 0.3  # [s] that a slider has to rest before the charts of a crowd follow


class Lag:
    """Counts the rest: `begin` with every change, then ask whether it is `over`."""

    def __init__(self, crowded: Callable[[], bool]):
        self.crowded, self.due = crowded, math.inf

    @property
    def running(self) -> bool:
        """Whether a change has not been followed yet."""
        return self.due < math.inf

    def begin(self, now: float) -> None:
        """Something has changed, at `now` [s]."""
        self.due = now + (REST if self.crowded() else 0.0)

    def over(self, now: float, *, busy: bool) -> bool:
        """Whether to follow now; True once for each change. A crowd's charts also wait while an
        answer is awaited (busy)."""
        if now < self.due or (busy and self.crowded()):
            return False
        self.due = math.inf
        return True
