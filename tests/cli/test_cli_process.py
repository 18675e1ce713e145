"""The command line as a process: its exit code, its pipes, and what it loads at the start."""

import os
import subprocess
import sys
import typing
from collections.abc import Mapping
from pathlib import Path

import pytest

from beamviz import __version__

ROOT = Path(__file__).resolve().parents[2]
BUFFERED = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}


def process(
    *arguments: str, environment: Mapping[str, str] = {}, **settings: typing.Any
) -> subprocess.CompletedProcess[str]:
    """Run a command line as a process of its own, with further variables in its environment."""
    command = [sys.executable, "-m", "beamviz", *arguments]
    settings = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **settings}
    env = {**BUFFERED, **environment}
    return subprocess.run(command, cwd=ROOT, env=env, text=True, check=False, **settings)


@pytest.mark.parametrize("command", [["modes"], ["modes", "--help"]])
def test_a_reader_that_leaves_early_is_no_failure_to_talk_about(command):
    """`beamviz modes | true` prints no traceback."""
    with subprocess.Popen(
        [sys.executable, "-m", "beamviz", *command],
        cwd=ROOT,
        env=BUFFERED,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as program:
        assert program.stdout
        assert program.stderr
        program.stdout.close()
        assert program.stderr.read() == ""
    assert program.returncode == 1


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_a_full_disk_is_one_line():
    """Output that could not be written is an error, and says so."""
    with open("/dev/full", "w") as full:
        done = process("modes", stdout=full)
    assert done.returncode == 1
    assert done.stderr == "beamviz: [Errno 28] No space left on device\n"


@pytest.mark.parametrize("name", ["beam.html", "beam.csv"])
def test_a_file_does_not_depend_on_the_encoding_of_the_system(tmp_path, name):
    """Greek letters are written where the locale has none."""
    ascii_only = {"LC_ALL": "POSIX", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    done = process("export", str(tmp_path / name), environment=ascii_only)
    assert (done.returncode, done.stderr) == (0, "")
    text = (tmp_path / name).read_text("utf-8")
    assert ("γ = " in text) == (name == "beam.html")


def test_as_a_module_the_exit_code_reaches_the_shell():
    """`python -m beamviz` ends with the code of main()."""
    assert process("--version").stdout == f"beamviz {__version__}\n"
    assert process("modes", "--alpha", "-1").returncode == 2


def test_modes_starts_light():
    """Start-up loads of scipy its LAPACK only, and none of what draws or serves."""
    script = """
import sys
from beamviz.cli import main
main(["modes", "--format", "json"])
print(*sys.modules, file=sys.stderr)
"""
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, check=True
    )
    loaded = set(done.stderr.split())
    heavy = {"scipy.optimize", "scipy.sparse", "scipy.special", "scipy.integrate", "rich"}
    assert "scipy.linalg" in loaded
    assert loaded & {*heavy, "viser", "matplotlib", "trimesh"} == set()
