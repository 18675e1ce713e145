"""How many visitors are in, over all processes that serve them."""

import mmap

ITEM = 8  # bytes of a count


class Attendance:
    """A count for each process, in memory they share: each changes its own, all see the total."""

    def __init__(self, processes: int = 1):
        self.counts = memoryview(mmap.mmap(-1, ITEM * processes)).cast("q")
        self.number = 0  # of this process

    @property
    def total(self) -> int:
        """Visitors in all processes."""
        return sum(self.counts)

    def enter(self) -> None:
        """One more has come to this process."""
        self.counts[self.number] += 1

    def leave(self) -> None:
        """One has gone."""
        self.counts[self.number] -= 1
