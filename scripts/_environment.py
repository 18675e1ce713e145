"""The project's virtual environment: made once, reused, renewed when pyproject.toml changes.

Standard library only. The check of the version comes first, and the other scripts import this
file first, so that an old Python is reported in one line.
"""

import sys

if sys.version_info < (3, 11):  # noqa: UP036
    sys.exit(
        "beamviz needs Python 3.11 or newer; this is Python %d.%d (%s)"  # noqa: UP031
        % (sys.version_info[0], sys.version_info[1], sys.executable)
    )

import hashlib
import os
import shutil
import subprocess
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
VENV = ROOT / ".venv"
NO_VENV = """\
this Python cannot make a virtual environment (its venv or ensurepip module is missing).
On Debian or Ubuntu: apt-get install python3-venv. Elsewhere: use a Python from python.org."""


def say(text: str) -> None:
    """Progress, on stderr at once."""
    print(f"beamviz: {text}", file=sys.stderr, flush=True)


def run(
    command: Sequence[str | Path], stdout: Any = None, **options: Any
) -> subprocess.CompletedProcess[str]:
    """A command run to its end, without input; its output goes to stderr, or to `stdout`."""
    stdout = stdout or sys.stderr
    return subprocess.run(
        command, stdin=subprocess.DEVNULL, stdout=stdout, text=True, check=False, **options
    )


def python_of(venv: Path) -> Path:
    """The interpreter inside a virtual environment."""
    return venv / ("Scripts/python.exe" if os.name == "nt" else "bin/python")


def ensure(extra: str, root: Path = ROOT, venv: Path = VENV) -> Path:
    """The interpreter of an environment that has beamviz with one of its extras, "all" or "test",
    made if needed."""
    python, wanted = python_of(venv), fingerprint(root)
    # Written last: the installation came to its end. That of the tests contains all the others.
    stamps = [venv / f"beamviz-{name}.stamp" for name in (extra, "test")]
    done = [stamp for stamp in stamps if stamp.exists() and stamp.read_text() == wanted]
    if not (python.exists() and done):
        create(venv)
        for old in venv.glob("beamviz-*.stamp"):
            old.unlink()
        install(venv, root, extra)
        stamps[0].write_text(wanted)
    return python


def fingerprint(root: Path) -> str:
    """What an installation depends on: the project file, where it lies, and the Python."""
    text = f"{root}\n{sys.version_info[:2]}\n".encode() + (root / "pyproject.toml").read_bytes()
    return hashlib.sha256(text).hexdigest()


def create(venv: Path) -> None:
    """Make the environment, unless one with a working pip is there."""
    if has_pip(venv):
        return
    say(f"making a virtual environment in {venv}")
    command = [sys.executable, "-m", "venv", "--clear", str(venv)]
    made = run(command, subprocess.PIPE, stderr=subprocess.STDOUT)
    if made.returncode != 0 or not has_pip(venv):
        shutil.rmtree(venv, ignore_errors=True)
        missing = "ensurepip" in made.stdout or "No module named venv" in made.stdout
        sys.exit(f"beamviz: {NO_VENV if missing else made.stdout.strip()}")


def has_pip(venv: Path) -> bool:
    """Whether the environment is complete enough to install into."""
    python = python_of(venv)
    return python.exists() and run_quietly([python, "-m", "pip", "--version"])


def run_quietly(command: Sequence[str | Path]) -> bool:
    """Whether a command ends well, its output dropped."""
    try:
        quiet = subprocess.DEVNULL
        return run(command, quiet, stderr=quiet, timeout=60).returncode == 0
    except (OSError, subprocess.TimeoutExpired):
        return False


def install(venv: Path, root: Path, extra: str) -> None:
    """Install the project, editable, with an extra; pip's own progress streams to stderr."""
    say("installing beamviz and what it needs (once, about a minute)")
    began = time.monotonic()
    pip = [str(python_of(venv)), "-m", "pip", "install", "--disable-pip-version-check"]
    # In its folder: a path in front of [extra] must not contain brackets.
    if run([*pip, "--editable", f".[{extra}]"], cwd=root).returncode != 0:
        sys.exit("beamviz: the installation failed (see above); run the same command to try again")
    say(f"installed in {time.monotonic() - began:.0f} s")
