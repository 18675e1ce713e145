"""The command line as a process: its exit code and its pipes."""

import os
import subprocess
import sys
import typing
from pathlib import Path

import pytest

from beamviz import Scene, __version__, export

ROOT = Path(__file__).resolve().parents[2]
BUFFERED = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}


def process(
    *arguments: str, stdout: typing.Any = subprocess.PIPE, **environment: str
) -> subprocess.CompletedProcess[str]:
    """Run a command line as a process of its own, with further variables in its environment."""
    command = [sys.executable, "-m", "beamviz", *arguments]
    settings: typing.Any = {"cwd": ROOT, "env": {**BUFFERED, **environment}, "text": True}
    return subprocess.run(command, stdout=stdout, stderr=subprocess.PIPE, check=False, **settings)


@pytest.mark.parametrize("command", [["modes"], ["modes", "--help"]])
def test_a_reader_that_leaves_early_is_no_failure_to_talk_about(command):
    """`beamviz modes | true` prints no traceback."""
    reader, writer = os.pipe()
    os.close(reader)
    done = process(*command, stdout=writer)
    os.close(writer)
    assert (done.returncode, done.stderr) == (1, "")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_a_full_disk_is_one_line():
    with open("/dev/full", "w") as full:
        done = process("modes", stdout=full)
    assert (done.returncode, done.stderr) == (1, "beamviz: [Errno 28] No space left on device\n")


def test_a_file_does_not_depend_on_the_encoding_of_the_system(tmp_path):
    """Greek letters are written where the locale has none; a CSV file needs none."""
    ascii_only = {"LC_ALL": "POSIX", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    done = process("export", str(tmp_path / "beam.html"), **ascii_only)
    assert (done.returncode, done.stderr) == (0, "")
    assert "γ = " in (tmp_path / "beam.html").read_text("utf-8")
    export(tmp_path / "beam.csv", Scene())
    assert (tmp_path / "beam.csv").read_bytes().isascii()


def test_as_a_module_the_exit_code_reaches_the_shell():
    """`python -m beamviz` ends with the code of main(); the version is that of the package."""
    version = process("--version")
    assert (version.returncode, version.stdout) == (0, f"beamviz {__version__}\n")
    assert version.stderr == ""
    assert process("modes", "--alpha", "-1").returncode == 2
