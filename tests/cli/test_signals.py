"""Ctrl-C and SIGTERM at any moment: a quick end with one line, no process and no file left, no
traceback."""

import importlib
import os
import random
import signal
import subprocess
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import matplotlib.image
import pytest
from helpers import contents, slow
from live.server import ServeProcess, free_port, handles_sigterm, python, wait_until

from beamviz.server.processes import Worker
from beamviz.signals import DELAY, Terminated, defer_signals, reraise, terminate_on_signal

SIGNALS = (signal.SIGINT, signal.SIGTERM)
LINES = {signal.SIGINT: "beamviz: interrupted", signal.SIGTERM: "beamviz: terminated"}
LONGEST = 2.5  # [s] after its begin in which a command is interrupted
COMMANDS = {  # each works for longer: in a process, in workers, while it writes, and serves
    "loci": "loci --over gamma --start 0 --stop 50 --points 5001 --alpha 1 --coriolis --per-rev 8",
    "film of a motion": "motion {}/a.mp4 --until 20 --release 1",
    "reproduce": "reproduce all --out {}/a",
    "export": "export {}/a.html",
    "sweep": "sweep {}/a.zarr --over gamma=0:50:501 --over alpha=0:1:200 --workers 2",
    "serve": "serve --port {port} --processes 2",
}

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


def endings(number: signal.Signals) -> list[tuple[int, str]]:
    """Exit codes and stderr: interrupted, done already, or done and Python was shutting down."""
    return [(128 + number, f"{LINES[number]}\n"), (0, ""), (-number, "")]


def session_of(pid: int) -> list[str]:
    """The processes of the session that a process has begun: their names, without zombies."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            name, _, rest = (folder / "stat").read_text().rpartition(")")
        except OSError:  # it has ended
            continue
        state, _, _, session, *_ = rest.split()
        if int(session) == pid and state != "Z":
            found.append(name)
    return found


OTHERS = [name for name in COMMANDS if name != "sweep"]


@pytest.mark.parametrize(
    ("name", "to_group"),
    [("sweep", True), *slow(*((name, k % 2 == 0) for k, name in enumerate(OTHERS)))],
)
def test_a_command_ends_at_any_moment(tmp_path, name, to_group):
    """A random one, also while it imports and while its processes start. A terminal sends Ctrl-C to
    the whole group, a program to the one process."""
    after = random.SystemRandom().uniform(0, LONGEST)
    port = str(free_port())
    words = [word.format(tmp_path, port=port) for word in COMMANDS[name].split()]
    process = python(tmp_path, "-m", "beamviz", *words, start_new_session=True)
    send = os.killpg if to_group else os.kill
    with process:
        try:
            wait_until(partial(handles_sigterm, process.pid))
            time.sleep(after)
            if process.poll() is None:
                send(process.pid, signal.SIGINT)
            _, errors = process.communicate(timeout=60)
            wait_until(lambda: not session_of(process.pid), about=f", after {after:.3f} s")
        finally:
            if session_of(process.pid):
                os.killpg(process.pid, signal.SIGKILL)
    told = f"after {after:.3f} s: {process.returncode}, {errors}"
    assert "Traceback" not in errors, told
    if process.returncode not in (0, -signal.SIGINT):  # done already, or Python was shutting down
        assert process.returncode == 130, told
        assert errors.splitlines()[-1].startswith(LINES[signal.SIGINT]), told
    assert not list(tmp_path.rglob("*.part*")), told


STUCK = """
import signal, sys, time
from pathlib import Path
from beamviz import cli, files
import beamviz.cli.commands
def work(*given, **options):
    with files.replaced(sys.argv[2]) as part:
        try:
            signal.raise_signal(signal.SIGINT)
        finally:
            time.sleep(600)
beamviz.cli.commands.app = work
sys.argv[1:] = ["screenshot", *sys.argv[1:]]
sys.exit(cli.main())
"""


def test_what_does_not_end_is_ended(tmp_path):
    """A process that is still busy some time after the signal, as in a library that closes itself;
    its half file goes as well."""
    target = tmp_path / "out" / "a.png"
    target.parent.mkdir()
    target.write_bytes(b"before")
    process = python(tmp_path, "-c", STUCK, str(target))
    with process:
        try:
            _, errors = process.communicate(timeout=60)
        finally:
            process.kill()
    assert (process.returncode, errors) == (130, "beamviz: interrupted\n")
    assert contents(target.parent) == {"a.png": b"before"}


ENDED = """
import os, time
from beamviz.workers import process_pool
if __name__ == "__main__":
    with process_pool(2) as pool:
        pool.submit(time.sleep, 0).result()
        pool.submit(time.sleep, 600)
        os._exit(130)
"""


def test_workers_end_with_their_process_however_it_ends(tmp_path):
    """Nothing is said, neither by Python's own tracker of what is left."""
    script = tmp_path / "ended.py"
    script.write_text(ENDED)
    process = python(tmp_path, str(script), start_new_session=True)
    with process:
        _, errors = process.communicate(timeout=60)  # when the workers have ended, too
    assert (process.returncode, errors) == (130, "")
    wait_until(lambda: not session_of(process.pid))


@pytest.mark.slow
def test_sigterm_ends_a_server_that_starts(tmp_path):
    """While it loads and its processes start."""
    server = ServeProcess(tmp_path, processes=3).process
    begun = partial(handles_sigterm, server.pid)
    assert ended(server, begun, 0.4, signal.SIGTERM) in endings(signal.SIGTERM)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_a_picture_given_up_leaves_no_file(tmp_path):
    """While it loads, solves, draws and writes; the picture is there whole or not at all."""
    target = tmp_path / "out" / "picture.png"
    target.parent.mkdir()
    size = ("--width", "320", "--height", "180")
    process = python(tmp_path, "-m", "beamviz", "screenshot", str(target), *size)
    begun = partial(handles_sigterm, process.pid)
    assert ended(process, begun, 0.7, signal.SIGTERM) in endings(signal.SIGTERM)
    if target.exists():
        assert matplotlib.image.imread(target).shape[:2] == (180, 320)
    assert contents(tmp_path).keys() <= {"out/picture.png"}
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


@pytest.mark.slow
def test_a_film_given_up_leaves_the_former_one(tmp_path):
    """While its frames are drawn, beside a half file."""
    target = tmp_path / "film.mp4"
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
