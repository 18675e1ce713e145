"""Processes of this machine that compute for this one, and end with it, however it ends."""

import contextlib
import itertools
import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from concurrent import futures
from typing import Any, TypeVar

from beamviz.errors import Unavailable
from beamviz.signals import defer_signals

IN_FLIGHT = 2  # tasks for each worker: one is computed, one waits
THREADS = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS")
# Where a signal ends the process before all is closed, Python's own tracker of semaphores, which
# then removes them, is not to warn of it.
NO_TRACKER = "ignore:resource_tracker"
POLL = 0.2  # [s] until a signal that came while tasks are waited for is handled

Task = TypeVar("Task", bound=tuple)
Result = TypeVar("Result")


class WorkerEnded(Unavailable):
    """A worker has ended before its work was done."""

    def __init__(self) -> None:
        super().__init__(
            "a worker ended before its work was done (out of memory? a script without"
            ' `if __name__ == "__main__"`?)'
        )


def core_count() -> int:
    """The number of cores that this process may use."""
    known = hasattr(os, "sched_getaffinity")
    return len(os.sched_getaffinity(0)) if known else os.cpu_count() or 1


def completed(
    executor: futures.Executor,
    compute: Callable[..., Result],
    tasks: Iterator[Task],
    workers: Callable[[], int] = core_count,
    *,
    cancel: bool = False,
) -> Iterator[tuple[Task, Result]]:
    """Each task and what `compute` returns for it, as it is done. workers: their number now, each
    of which has at most IN_FLIGHT tasks at a time; cancel: the executor outlives this, so that what
    waits is cancelled.

    Raises WorkerEnded.
    """
    pending: dict[futures.Future[Result], Task] = {}
    try:
        while True:
            with defer_signals():  # an exception inside could leave a future locked for ever
                room = IN_FLIGHT * max(1, workers()) - len(pending)
                for task in itertools.islice(tasks, max(0, room)):
                    pending[executor.submit(compute, *task)] = task
                done = futures.wait(pending, POLL, return_when=futures.FIRST_COMPLETED).done
            if not pending:
                return
            for future in done:
                result = future.result()
                yield pending.pop(future), result
    except (futures.BrokenExecutor, futures.CancelledError):
        raise WorkerEnded from None
    finally:
        for future in pending if cancel else ():
            future.cancel()


class SpawnedWorkers(futures.ProcessPoolExecutor):
    """A pool whose processes never get Ctrl-C, not even while they import."""

    def submit(
        self, function: Callable[..., Any], /, *arguments: Any, **keywords: Any
    ) -> futures.Future[Any]:
        """Submit a task, for which a process may be started."""
        with defer_signals(), blocked_interrupts():
            return super().submit(function, *arguments, **keywords)


@contextlib.contextmanager
def process_pool(workers: int) -> Iterator[SpawnedWorkers]:
    """Workers, which end with this process, however it ends, and at once where an exception does
    not wait for their work."""
    spawn = multiprocessing.get_context("spawn")  # forking a process with threads is unsafe
    listener, ours = spawn.Pipe(duplex=False)
    before = {name: os.environ[name] for name in THREADS if name in os.environ}
    os.environ |= dict.fromkeys(THREADS, "1")  # small matrices: more threads wait for each other
    others = {*multiprocessing.active_children()}
    sys.warnoptions.append(NO_TRACKER)  # the process that Python starts besides inherits it
    pool = SpawnedWorkers(workers, spawn, _start_worker, (listener,))
    try:
        yield pool
        pool.shutdown()
    finally:
        ours.close()
        for process in {*multiprocessing.active_children()} - others:
            process.kill()  # it may be importing still, and not look at the pipe
        pool.shutdown(cancel_futures=True)
        listener.close()
        sys.warnoptions.remove(NO_TRACKER)
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
