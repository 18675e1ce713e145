"""A sweep that is killed, out of room or forbidden to write loses nothing and can be resumed."""

import contextlib
import json
import os
import resource
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from helpers import contents
from live.server import python, wait_until

from beamviz import Beam
from beamviz.cli import main
from beamviz.cli.commands import KEPT
from beamviz.sweeps import sweep
from beamviz.sweeps.plan import make_plan
from beamviz.sweeps.store import created

LINE = ["--over", "gamma=0:10:401", "--over", "alpha=0:3:26"]
CHUNKS, SOLVED = 13, "10426 solved\n"
Run = Callable[..., tuple[int, str, str]]

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals and limits of Unix")


def start(store: Path, *more: str, **settings) -> subprocess.Popen:
    """`beamviz sweep` as a process."""
    return python(store.parent, "-m", "beamviz", "sweep", str(store), *LINE, *more, **settings)


def chunks(store: Path) -> int:
    """How many chunks of `status` are there."""
    return sum(path.is_file() for path in (store / "status" / "c").rglob("*"))


def has_chunks(store: Path, count: int) -> bool:
    """Whether a store is there, with so many chunks."""
    return store.exists() and chunks(store) >= count


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory) -> dict[str, bytes]:
    """The store of a run to its end, with one process."""
    store = tmp_path_factory.mktemp("undisturbed") / "a.zarr"
    assert main(["sweep", str(store), *LINE, "--workers", "1"]) == 0
    return contents(store)


def finish(run: Run, store: Path, undisturbed: dict[str, bytes]) -> str:
    """Resume a sweep; the same store as that of one run, byte by byte. Returns its progress."""
    code, out, err = run("sweep", str(store), *LINE, "--workers", "1")
    assert (code, out) == (0, SOLVED), err
    assert contents(store) == undisturbed
    return err


def ended(store: Path, number: signal.Signals, count: int) -> None:
    """Start a sweep, and end it when it has so many chunks. By Ctrl-C, which its workers get too,
    or SIGTERM: one line and the exit code of the signal. Killed, its workers end too."""
    with start(store, "--workers", "2", start_new_session=True) as process:
        wait_until(partial(has_chunks, store, count))
        (os.kill if number == signal.SIGKILL else os.killpg)(process.pid, number)
        out, err = process.communicate(timeout=120)  # when the workers have ended, too
    if number == signal.SIGKILL:
        (store / "status" / "c" / "0.0123.partial").touch()  # as left by a write
        return
    assert (process.returncode, out) == (128 + number, "")
    *progress, last = err.splitlines()
    name = "interrupted" if number == signal.SIGINT else "terminated"
    assert last == f"beamviz: {name}; {KEPT}"
    assert all("a second" in line for line in progress), err


@pytest.mark.slow
def test_ended_by_signals(undisturbed, tmp_path, run):
    """One after the other: as soon as the store is there, while workers start, and while they work.
    Resumed at last it has the same store as in one run, byte by byte."""
    store = tmp_path / "a.zarr"
    ended(store, signal.SIGTERM, 0)
    for number in (signal.SIGKILL, signal.SIGINT):
        before = chunks(store)
        ended(store, number, before + 1)
        assert before < chunks(store) < CHUNKS
    assert "100 %, 10,426 of 10,426 beams" in finish(run, store, undisturbed)


def test_another_process_makes_the_store_meanwhile(tmp_path):
    """Two that start at once: one makes the store, the other goes on with it."""
    plan, store = make_plan({"gamma": [0.0, 1.0]}, Beam(), modes=1), tmp_path / "a.zarr"
    assert created(plan, store)
    assert not created(plan, store)
    assert [path.name for path in tmp_path.iterdir()] == ["a.zarr"]
    assert len(sweep({"gamma": [0.0, 1.0]}, store, modes=1, workers=1)["frequency"]) == 2


def test_an_interrupt_leaves_no_future_locked(tmp_path, interruptible):
    """However it falls: the pool, which locks the futures to set their results, still ends."""
    interrupts = []

    class InterruptedExecutor(ThreadPoolExecutor):
        def submit(self, *task, **arguments):
            future = super().submit(*task, **arguments)
            acquire = future._condition.acquire

            def interrupted(*options):
                taken = acquire(*options)
                if not interrupts and threading.current_thread() is threading.main_thread():
                    interrupts.append(signal.SIGINT)
                    signal.raise_signal(signal.SIGINT)
                return taken

            future._condition.acquire = interrupted
            return future

    executor = InterruptedExecutor(1)
    with pytest.raises(KeyboardInterrupt):
        sweep({"gamma": np.linspace(0, 10, 2000)}, tmp_path / "a.zarr", executor=executor)
    end = threading.Thread(target=executor.shutdown, daemon=True)
    end.start()
    end.join(120)
    assert interrupts
    assert not end.is_alive()


@pytest.mark.slow
def test_no_room(undisturbed, tmp_path, run):
    """A file may not become large enough: one line, what is written stays; with room it resumes."""
    store = tmp_path / "a.zarr"
    largest = max(len(data) for name, data in undisturbed.items() if name.startswith("frequency"))
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    try:
        resource.setrlimit(resource.RLIMIT_FSIZE, (largest - 1, before[1]))
        code, out, err = run("sweep", str(store), *LINE, "--workers", "1")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert (code, out) == (1, "")
    assert err.splitlines()[-1] == (
        f"beamviz: cannot write {store}: File too large; what is written is kept; make room there,"
        " or choose another place"
    )
    assert "Traceback" not in err
    finish(run, store, undisturbed)


@pytest.mark.slow
def test_memory_does_not_grow(tmp_path):
    """Neither that of the first process nor that of a worker, for a sweep of 4 times as many
    beams."""
    peaks = []
    for count in (2, 8):
        store = tmp_path / f"{count}.zarr"
        axes = "--over", "gamma=0:2:1001", "--over", f"alpha=0:5:{count}"
        command = "-m", "beamviz", "sweep", str(store), "--workers", "2", "--modes", "2"
        with python(tmp_path, *command, *axes) as process:
            _, process.returncode, usage = os.wait4(process.pid, 0)
        assert process.returncode == 0
        peaks.append(usage.ru_maxrss)  # the largest, of it and of its workers
    assert peaks[1] < 1.3 * peaks[0]


@pytest.mark.slow
def test_a_dask_cluster_loses_a_worker(undisturbed, tmp_path):
    """A scheduler and two workers, as processes; one is killed in the middle of its work."""
    store = tmp_path / "a.zarr"
    address = tmp_path / "scheduler.json"
    options = ("--no-dashboard", "--scheduler-file", str(address))
    scheduler = "-m", "distributed.cli.dask_scheduler", "--port", "0"
    worker = "-m", "distributed.cli.dask_worker", "--nthreads", "1", "--no-nanny"
    with contextlib.ExitStack() as stack:

        def started(*arguments: str) -> subprocess.Popen:
            process = stack.enter_context(python(tmp_path, *arguments, *options, cwd=tmp_path))
            stack.callback(process.kill)
            return process

        started(*scheduler)
        wait_until(address.exists)
        first, _ = started(*worker), started(*worker)
        with start(store, "--scheduler", json.loads(address.read_text())["address"]) as process:
            wait_until(partial(has_chunks, store, 3))
            first.kill()
            out, err = process.communicate(timeout=120)
        assert (process.returncode, out) == (0, SOLVED), err
        assert first.wait() == -signal.SIGKILL
        assert contents(store) == undisturbed
