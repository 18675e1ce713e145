"""Every check of the project: format, lint, types, tests.

    python3 scripts/test.py [--all] [options of pytest]

Makes the environment if needed and finds or installs a browser for the tests of the page. Tests
run in parallel, and types are checked meanwhile. `--all` adds the tests marked `slow`. The exit
code is 0 only if every check passed. With CI set in the environment a missing browser is a
failure too, unless BEAMVIZ_BROWSER=none asks for none.
"""

import os
import subprocess
import sys
import tempfile
import time
from typing import Any

from _browser import find_or_fetch
from _environment import ROOT, ensure, say

WORKERS = min(4, (os.cpu_count() or 2) + 1)  # one waits for a server or the browser
CHECKS = {  # in this order; the types run in the background until the tests are done
    "types": ["mypy"],
    "format": ["ruff", "format", "--check", "."],
    "lint": ["ruff", "check", "."],
    "tests": ["pytest", "-n", str(WORKERS), "--dist", "worksteal"],
}
IN_BACKGROUND = ("types",)


def main(options: list[str]) -> int:
    """Run all checks, also after one has failed; 0 if all passed, else 1."""
    if {"-h", "--help"} & {*options}:
        print(__doc__)
        return 0
    python = ensure("test")
    browser = find_or_fetch(python)
    say(f"browser: {browser}" if browser else "no browser: the tests of the page are skipped")
    required = os.environ.get("CI") and os.environ.get("BEAMVIZ_BROWSER") != "none"
    failed = ["browser"] if required and not browser else []
    environment = {**os.environ, "BEAMVIZ_BROWSER": browser or "none"}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)  # each process would compile all modules again
    background = []
    for name, arguments in {**CHECKS, "tests": CHECKS["tests"] + pytest_options(options)}.items():
        check = Check(name, [str(python), "-m", *arguments], environment)
        if name in IN_BACKGROUND:
            background.append(check)
        elif not check.passed():
            failed.append(name)
    failed += [check.name for check in background if not check.passed()]
    say(f"FAILED: {', '.join(failed)}" if failed else "all checks passed")
    return 1 if failed else 0


def pytest_options(options: list[str]) -> list[str]:
    """`--all` in pytest's words: an empty expression of markers deselects nothing."""
    every_test = ["-m", ""] if "--all" in options else []
    return every_test + [option for option in options if option != "--all"]


class Check:
    """A check started as a module of the environment; its output streams, or is kept."""

    def __init__(self, name: str, command: list[str], environment: dict[str, str]):
        self.name, self.began = name, time.monotonic()
        self.output = tempfile.TemporaryFile() if name in IN_BACKGROUND else None  # noqa: SIM115
        say(f"{name}: {' '.join(command[2:])}")
        streams: Any = {"stdin": subprocess.DEVNULL, "stdout": self.output, "stderr": self.output}
        self.process = subprocess.Popen(command, cwd=ROOT, env=environment, **streams)

    def passed(self) -> bool:
        """Wait for the end, show the output that was kept; whether the check passed."""
        code = self.process.wait()
        if self.output:
            self.output.seek(0)
            sys.stderr.buffer.write(self.output.read())
            self.output.close()
        seconds = time.monotonic() - self.began
        say(f"{self.name}: {'FAILED' if code else 'passed'} in {seconds:.0f} s")
        return code == 0


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except KeyboardInterrupt:
        sys.exit(130)
