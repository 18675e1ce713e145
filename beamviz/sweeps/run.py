"""A sweep is run: which chunks are left, and who computes them.

The executor is one of the standard library or Dask's; a task is a chunk of the store.
"""

import contextlib
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from beamviz.checks import check_int
from beamviz.errors import Unavailable, requires
from beamviz.sweeps.plan import Plan, Region
from beamviz.sweeps.store import open_store, solve_and_write
from beamviz.workers import WorkerEnded, completed, core_count, process_pool

MAX_WORKERS = 1024
CONNECT = 30.0  # [s] to find a scheduler and a first worker


@dataclass
class Progress:
    """The progress of a sweep: numbers of beams, of those of earlier runs, and the seconds of this
    run."""

    total: int
    done: int
    before: int
    seconds: float = 0.0

    @property
    def rate(self) -> float:
        """Beams per second in this run."""
        return (self.done - self.before) / self.seconds if self.seconds else 0.0

    @property
    def left(self) -> float:
        """Seconds left at this rate."""
        return (self.total - self.done) / self.rate if self.rate else float("inf")

    def __str__(self) -> str:
        seconds = round(self.left)
        left = f"{seconds} s" if seconds < 120 else f"{seconds // 3600}:{seconds // 60 % 60:02d} h"
        return (
            f"{100 * self.done // self.total} %, {self.done:,} of {self.total:,} beams,"
            f" {self.rate:,.0f} a second, {left} left"
        )


Report = Callable[[Progress], None]
Work = tuple[Path, Region, Plan]  # of a chunk: the arguments of solve_and_write


def run(
    plan: Plan,
    path: Path,
    executor: Any = None,
    workers: int | None = None,
    report: Report | None = None,
) -> None:
    """Compute the chunks that are missing in a store, or damaged."""
    path = path.absolute()  # the working directory of workers may be another
    workers = core_count() if workers is None else check_int("workers", workers, 1, MAX_WORKERS)
    left = open_store(plan, path)
    before = plan.size - sum(plan.part(chunk).size for chunk in left)
    state, start = Progress(plan.size, before, before), time.monotonic()
    is_dask = hasattr(executor, "get_executor")  # a client, whose workers may come and go

    def working() -> int:
        return sum(executor.nthreads().values()) if is_dask else workers

    with contextlib.ExitStack() as stack:
        pool = executor.get_executor(pure=False) if is_dask else executor
        if executor is None and min(workers, len(left)) > 1:
            pool = stack.enter_context(process_pool(min(workers, len(left))))
        work = ((path, plan.region(chunk), plan.part(chunk)) for chunk in left)
        for _, _, part in written(pool, working, work, cancel=executor is not None):
            state.done += part.size
            state.seconds = time.monotonic() - start
            if report:
                report(state)


def written(
    pool: Any, workers: Callable[[], int], work: Iterator[Work], *, cancel: bool
) -> Iterator[Work]:
    """Each chunk as it is written: by an executor (see `completed`), or in this process."""
    if pool is None:
        for chunk in work:
            solve_and_write(*chunk)
            yield chunk
        return
    try:
        for chunk, _ in completed(pool, solve_and_write, work, workers, cancel=cancel):
            yield chunk
    except WorkerEnded as error:
        raise Unavailable(f"{error}; what is written is kept: run it again to resume") from None


@contextlib.contextmanager
def dask_client(address: str) -> Iterator[Any]:
    """A client of a Dask scheduler that has a worker; Unavailable where there is none."""
    with requires("cluster"):
        import distributed
    try:
        client = distributed.Client(address, timeout=CONNECT)
    except (OSError, ValueError) as error:
        raise Unavailable(f"no Dask scheduler at {address} ({error})") from None
    with client:
        try:
            client.wait_for_workers(1, timeout=CONNECT)
        except TimeoutError:
            raise Unavailable(f"the Dask scheduler at {address} has no workers") from None
        yield client
