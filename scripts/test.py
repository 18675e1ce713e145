"""Every check of the project: format, lint, types, tests.

    python3 scripts/test.py [--all] [options of pytest]

Makes the environment if needed and finds or installs a browser for the tests of the page. Tests
run in parallel, and types are checked meanwhile. `--all` adds the tests marked `slow`, one of which
needs Firefox, and is skipped where that is missing and cannot be installed. The exit code is 0 only
if every check passed. With CI set in the environment a missing browser is a failure too, unless
BEAMVIZ_BROWSER=none asks for none. The types of the page need Node: where it is missing and cannot
be installed, the last line says that they were not checked.
"""

import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from _environment import ROOT, ensure, run, run_quietly, say

sys.path.insert(0, str(ROOT / "tests"))
from live.chromium import find_browser  # type: ignore[import-not-found]
from live.firefox_path import find_firefox  # type: ignore[import-not-found]

WORKERS = min(4, (os.cpu_count() or 2) + 1)  # some wait for a server or the browser
CHECKS = {  # in this order; the types are checked in the background until the tests are done
    "types": ["mypy"],
    "types of the page": ["scripts.check_page"],
    "format": ["ruff", "format", "--check", "."],
    "lint": ["ruff", "check", "."],
    "tests": ["pytest", "-n", str(WORKERS), "--dist", "loadscope", "--no-loadscope-reorder"],
}
IN_BACKGROUND = ("types", "types of the page")
NOT_CHECKED = 77  # exit code of a check that could not be made
PLAYWRIGHT_PATH = """
from playwright.sync_api import sync_playwright
with sync_playwright() as playwright:
    print(playwright.chromium.executable_path)
"""


def main(options: list[str]) -> int:
    """Run all checks, also after one has failed; 0 if all passed, else 1."""
    if {"-h", "--help"} & {*options}:
        print_help()
        return 0
    python = ensure("test")
    fetch_node()
    browser = find_or_fetch(python)
    if browser and "--all" in options:
        fetch_firefox()
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
    skipped = [check.name for check in background if check.code == NOT_CHECKED]
    passed = f"all checks passed, but NOT CHECKED: {', '.join(skipped)}"
    passed = passed if skipped else "all checks passed"
    say(f"FAILED: {', '.join(failed)}" if failed else passed)
    return 1 if failed else 0


def print_help() -> None:
    """The help on stdout, whose reader may leave early, as `head` does."""
    try:
        print(__doc__, flush=True)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # or its last flush fails


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
        self.code = code = self.process.wait()
        if self.output:
            self.output.seek(0)
            sys.stderr.buffer.write(self.output.read())
            self.output.close()
        seconds = time.monotonic() - self.began
        result = {0: "passed", NOT_CHECKED: "NOT CHECKED"}.get(code, "FAILED")
        say(f"{self.name}: {result} in {seconds:.0f} s")
        return code in (0, NOT_CHECKED)


# A browser for the tests of the page: the one that is there, Debian's, or Playwright's


def find_or_fetch(python: Path) -> str | None:
    """A browser that runs, or None where none can be had; `python` may install Playwright's."""
    named = os.environ.get("BEAMVIZ_BROWSER")
    if named == "none":
        return None
    if named:
        remedy = "name one that does, or none, or unset it"
        return working(find_browser()) or sys.exit(
            f"beamviz: BEAMVIZ_BROWSER = {named}: does not start; {remedy}"
        )
    return working(find_browser()) or from_debian(python) or from_playwright(python)


def working(browser: str | None) -> str | None:
    """The browser, if it starts (on some systems the command only tells how to install it)."""
    if browser and (os.name == "nt" or run_quietly([browser, "--version"])):
        return browser
    return None


def from_debian(python: Path) -> str | None:
    """Debian's Chromium, where this process may install it."""
    say("no Chrome, Chromium or Edge found: trying Debian's Chromium")
    packages = "chromium", "fonts-liberation"  # else only DejaVu is there
    return working(find_browser()) if install_from_debian(*packages) else None


def install_from_debian(*packages: str) -> bool:
    """Install packages of Debian, where this process may; whether that ended well."""
    if not (shutil.which("apt-get") and hasattr(os, "geteuid") and os.geteuid() == 0):
        return False
    succeeded(["apt-get", "update"])  # may fail for one source and still do for ours
    return succeeded(["apt-get", "install", "--yes", "--no-install-recommends", *packages])


def fetch_node() -> None:
    """Install Node, whose npx fetches TypeScript, where neither is there."""
    if not (shutil.which("tsc") or shutil.which("npx")):
        say("neither tsc nor npx found: trying Debian's Node")
        install_from_debian("nodejs", "npm")


def fetch_firefox() -> None:
    """Install Firefox, in which a slow test does the main jobs of the page, where it is missing."""
    if not find_firefox():
        say("no Firefox found: trying Debian's")
        install_from_debian("firefox-esr")


def from_playwright(python: Path) -> str | None:
    """Playwright's Chromium, put where Playwright keeps its browsers."""
    say("no Chrome, Chromium or Edge found: trying Playwright's Chromium")
    pip = [str(python), "-m", "pip", "install", "--disable-pip-version-check", "playwright"]
    playwright = [str(python), "-m", "playwright", "install", "chromium"]
    if not (succeeded(pip) and succeeded(playwright)):
        return None
    found = run([str(python), "-c", PLAYWRIGHT_PATH], subprocess.PIPE, cwd=ROOT)
    return working(found.stdout.strip())


def succeeded(command: list[str]) -> bool:
    """Run a command with its output on stderr; whether it ended well."""
    environment = {**os.environ, "DEBIAN_FRONTEND": "noninteractive"}
    return run(command, env=environment).returncode == 0


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except KeyboardInterrupt:
        sys.exit(130)
