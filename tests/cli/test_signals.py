"""Ctrl-C and SIGTERM at any moment: a quick end, no file left, no traceback."""

import importlib
import signal
import subprocess
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import matplotlib.image
import pytest
from helpers import contents, slow
from live.server import ServeProcess, handles_sigterm, python, wait_until

from beamviz.server.processes import Worker
from beamviz.signals import DELAY, Terminated, defer_signals, reraise, terminate_on_signal

SIGNALS = (signal.SIGINT, signal.SIGTERM)

pytestmark = [
    pytest.mark.usefixtures("interruptible"),
    pytest.mark.skipif(not Path("/proc").is_dir(), reason="processes are seen in /proc"),
]


def ended(
    process: subprocess.Popen, begun: Callable[[], object], after: float, number: signal.Signals
) -> tuple[int, str]:
    """Exit code and stderr of a process that gets two signals a while after it has begun, once
    neither it nor a process that it started has stderr open."""
    with process:
        try:
            wait_until(begun)
            time.sleep(after)
            process.send_signal(number)
            time.sleep(0.05)
            process.send_signal(number)  # to nobody, if it has ended
            _, errors = process.communicate(timeout=120)
        finally:
            process.kill()
    return process.returncode, errors


def endings(number: int) -> list[tuple[int, str]]:
    """Exit codes and stderr: interrupted, done already, or interrupted while Python was shutting
    down, by the second signal or by the alarm that repeats the first."""
    return [(128 + number, ""), (0, ""), (-number, ""), (-signal.SIGALRM, "")]


@pytest.mark.parametrize(
    ("number", "processes", "after"),
    [
        (signal.SIGINT, 1, 0.6),
        *slow(*((signal.SIGINT, 1, after) for after in (0.0, 0.1, 0.3, 1.2))),
        *slow(*((signal.SIGTERM, 3, after) for after in (0.0, 0.3, 1.2))),
    ],
)
def test_the_server_ends_at_any_moment(tmp_path, number, processes, after):
    """While it loads, while it starts, while it serves; in one process or several."""
    server = ServeProcess(tmp_path, processes=processes).process
    begun = partial(handles_sigterm, server.pid)
    assert ended(server, begun, after, number) in endings(number)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("after", [0.7, *slow(0.0, 0.5, 1.2, 2.3)])
def test_a_picture_given_up_leaves_no_file(tmp_path, after):
    """While it loads, solves, draws and writes; the picture is there whole or not at all."""
    target = tmp_path / "out" / "picture.png"
    target.parent.mkdir()
    number = SIGNALS[int(10 * after) % 2]
    size = ("--width", "320", "--height", "180")
    process = python(tmp_path, "-m", "beamviz", "screenshot", str(target), *size)
    begun = partial(handles_sigterm, process.pid)
    assert ended(process, begun, after, number) in endings(number)
    if target.exists():
        assert matplotlib.image.imread(target).shape[:2] == (180, 320)
    assert contents(tmp_path).keys() <= {"out/picture.png"}
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["gif", "mp4"])
def test_a_film_given_up_leaves_the_former_one(tmp_path, kind):
    """While its frames are drawn, beside a half file."""
    target = tmp_path / f"film.{kind}"
    target.write_bytes(b"before")
    process = python(tmp_path, "-m", "beamviz", "animate", str(target), "--periods", "12")

    def has_half_a_file() -> bool:
        return len(list(tmp_path.iterdir())) == 2

    code, errors = ended(process, has_half_a_file, 1.0, signal.SIGINT)
    assert (code, errors.replace("beamviz: frames\n", "")) in endings(signal.SIGINT)
    assert contents(tmp_path) == {target.name: b"before"}


@pytest.mark.parametrize("number", SIGNALS)
def test_only_the_first_signal_counts(number):
    """A second one does not interrupt the closing of what is open."""
    closed = []

    def work() -> None:
        try:
            signal.raise_signal(number)
        finally:
            signal.raise_signal(number)
            closed.append(True)

    with pytest.raises(Terminated) as caught, terminate_on_signal():
        work()
    assert (caught.value.code, closed) == (128 + number, [True])


@pytest.mark.parametrize("number", SIGNALS)
def test_a_signal_handled_within_stays_the_only_one(number):
    """The server ends by it, and the command line around it while Python shuts down."""
    with terminate_on_signal():
        with pytest.raises(Terminated), terminate_on_signal():
            signal.raise_signal(number)
        signal.raise_signal(number)
    signal.raise_signal(number)


def test_an_import_that_discards_exceptions_does_not_discard_the_signal(tmp_path, monkeypatch):
    """Some modules do, with a bare except around their optional parts."""
    (tmp_path / "greedy.py").write_text(GREEDY)
    monkeypatch.syspath_prepend(tmp_path)

    def work() -> None:
        assert importlib.import_module("greedy").loaded
        time.sleep(10)

    with pytest.raises(Terminated), terminate_on_signal():
        work()


GREEDY = """
import signal
try:
    signal.raise_signal(signal.SIGTERM)
    sum(range(1000))
except BaseException:
    pass
loaded = True
"""


@pytest.mark.parametrize("send", [signal.raise_signal, reraise])
def test_a_signal_waits_until_what_is_started_is_known(send):
    """Otherwise it could not be ended; also one that was deferred by an import and comes again."""
    known = []

    def start() -> None:
        send(signal.SIGTERM)
        time.sleep(4 * DELAY)
        known.append("process")

    with pytest.raises(Terminated), terminate_on_signal(), defer_signals():
        start()
    assert known == ["process"]


def test_a_signal_that_waits_is_not_lost_by_an_error():
    """As where it has ended a process as well, which is missed before the signal is handled."""

    def wait_for_process() -> None:
        signal.raise_signal(signal.SIGTERM)
        raise OSError("a process has ended")

    with pytest.raises(Terminated), terminate_on_signal(), defer_signals():
        wait_for_process()


def test_a_signal_whose_exception_python_discards_comes_again(capsys):
    """Exceptions in `__del__`, which runs at any moment, are printed and ignored."""

    class Greedy:
        def __del__(self) -> None:
            signal.raise_signal(signal.SIGTERM)

    def work() -> None:
        Greedy()
        time.sleep(10)

    with pytest.raises(Terminated), terminate_on_signal():
        work()
    assert capsys.readouterr().err == ""


def test_a_worker_that_does_not_serve_yet_ends_quietly(capfd):
    """By a signal at any moment after its start."""
    with terminate_on_signal():
        worker = Worker(0, lambda *_: signal.raise_signal(signal.SIGTERM), None)
        with worker.sender, worker.result:
            worker.process.join()
    assert (worker.process.exitcode, capfd.readouterr().err) == (0, "")
