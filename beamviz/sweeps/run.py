"""A sweep is run: which chunks are left, and who computes them.

The executor is one of the standard library or Dask's; a task is a chunk of the store.
"""

import contextlib
import itertools
import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from concurrent import futures
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from beamviz.checks import check_int
from beamviz.errors import Unavailable, requires
from beamviz.signals import defer_signals
from beamviz.sweeps.plan import Plan, Region
from beamviz.sweeps.store import open_store, solve_and_write

MAX_WORKERS = 1024
IN_FLIGHT = 2  # tasks for each worker: one is computed, one waits
THREADS = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS")
POLL = 0.2  # [s] until a signal that came while tasks are waited for is handled
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
    known = hasattr(os, "sched_getaffinity")  # the cores that this process may use
    cores = len(os.sched_getaffinity(0)) if known else os.cpu_count() or 1
    workers = cores if workers is None else check_int("workers", workers, 1, MAX_WORKERS)
    left = open_store(plan, path)
    before = plan.size - sum(plan.part(chunk).size for chunk in left)
    state, start = Progress(plan.size, before, before), time.monotonic()

    def capacity() -> int:
        return IN_FLIGHT * max(1, sum(executor.nthreads().values()) if is_dask else workers)

    is_dask = hasattr(executor, "get_executor")  # a client, whose workers may come and go
    with contextlib.ExitStack() as stack:
        if executor is None:
            pool = stack.enter_context(process_pool(min(workers, len(left))))
        else:
            pool = executor.get_executor(pure=False) if is_dask else executor
        work = ((path, plan.region(chunk), plan.part(chunk)) for chunk in left)
        for _, _, part in completed(pool, capacity, work, cancel=executor is not None):
            state.done += part.size
            state.seconds = time.monotonic() - start
            if report:
                report(state)


def completed(
    executor: futures.Executor | None,
    capacity: Callable[[], int],
    work: Iterator[Work],
    *,
    cancel: bool,
) -> Iterator[Work]:
    """Each chunk as it is done, with `capacity` of them submitted at a time; in this process
    without an executor. cancel: the executor outlives this, so that what waits is cancelled."""
    if executor is None:
        for chunk in work:
            solve_and_write(*chunk)
            yield chunk
        return
    pending: dict[futures.Future, Work] = {}
    try:
        while True:
            with defer_signals():  # an exception inside could leave a future locked for ever
                for chunk in itertools.islice(work, max(0, capacity() - len(pending))):
                    with blocked_interrupts():
                        future = executor.submit(solve_and_write, *chunk)
                    pending[future] = chunk
                done = futures.wait(pending, POLL, return_when=futures.FIRST_COMPLETED).done
            if not pending:
                return
            for future in done:
                future.result()
                yield pending.pop(future)
    except (futures.BrokenExecutor, futures.CancelledError):
        raise Unavailable(
            "a worker ended before its work was done (out of memory? a script without"
            ' `if __name__ == "__main__"`?); what is written is kept: run it again to resume'
        ) from None
    finally:
        for future in pending if cancel else ():
            future.cancel()


@contextlib.contextmanager
def process_pool(workers: int) -> Iterator[futures.Executor | None]:
    """Processes of this machine, which end with this one, however it ends; None for one worker."""
    if workers <= 1:
        yield None
        return
    spawn = multiprocessing.get_context("spawn")  # forking a process with threads is unsafe
    listener, ours = spawn.Pipe(duplex=False)
    before = {name: os.environ[name] for name in THREADS if name in os.environ}
    os.environ |= dict.fromkeys(THREADS, "1")  # small matrices: more threads wait for each other
    pool = futures.ProcessPoolExecutor(workers, spawn, _start_worker, (listener,))
    try:
        yield pool
        pool.shutdown()
    finally:
        ours.close()
        pool.shutdown()
        listener.close()
        for name in THREADS:
            del os.environ[name]
        os.environ |= before


@contextlib.contextmanager
def blocked_interrupts() -> Iterator[None]:
    """Within, Ctrl-C waits; a process that is started never gets it, not even while it imports."""
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, (signal.SIGINT,))
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _start_worker(listener: Any) -> None:
    """In a worker: leave Ctrl-C to the first process, and end as soon as that closes its end of the
    pipe or dies."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    def watch() -> None:
        listener.poll(None)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


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
