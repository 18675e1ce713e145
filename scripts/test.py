"""Every check of the project: format, lint, types, tests.

    python3 scripts/test.py [options of pytest]

Makes the environment if needed and finds a browser for the tests of the page. The exit code
is 0 only if every check passed.
"""

import os
import subprocess
import sys
import time
from pathlib import Path

from _browser import find_or_fetch
from _environment import ROOT, ensure, say

CHECKS = {
    "format": ["ruff", "format", "--check", "."],
    "lint": ["ruff", "check", "."],
    "types": ["mypy"],
    "tests": ["pytest"],
}


def main(pytest_options: list[str]) -> int:
    """Run all checks, also after one has failed; 0 if all passed, else 1."""
    python = ensure("test")
    browser = find_or_fetch(python)
    say(f"browser: {browser}" if browser else "no browser: the tests of the page are skipped")
    environment = {**os.environ, "BEAMVIZ_BROWSER": browser or "none"}
    commands = {**CHECKS, "tests": [*CHECKS["tests"], *pytest_options]}
    failed = [
        name for name, command in commands.items() if not passed(name, python, command, environment)
    ]
    say(f"FAILED: {', '.join(failed)}" if failed else "all checks passed")
    return 1 if failed else 0


def passed(name: str, python: Path, command: list[str], environment: dict[str, str]) -> bool:
    """Run one check as a module of the environment, its output streaming; whether it passed."""
    say(f"{name}: {' '.join(command)}")
    began = time.monotonic()
    done = subprocess.run(
        [python, "-m", *command], cwd=ROOT, env=environment, stdin=subprocess.DEVNULL, check=False
    )
    verdict = "FAILED" if done.returncode else "passed"
    say(f"{name}: {verdict} in {time.monotonic() - began:.0f} s")
    return done.returncode == 0


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except KeyboardInterrupt:
        sys.exit(130)
