"""A browser for the tests of the page: the one that is there, Debian's, or Playwright's.

Standard library only.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

from _environment import ROOT, run, run_quietly, say

sys.path.insert(0, str(ROOT / "tests"))
from live.chromium import find_browser  # type: ignore[import-not-found]

PLAYWRIGHT_PATH = """
from playwright.sync_api import sync_playwright
with sync_playwright() as playwright:
    print(playwright.chromium.executable_path)
"""


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
    if not (shutil.which("apt-get") and hasattr(os, "geteuid") and os.geteuid() == 0):
        return None
    say("no Chrome, Chromium or Edge found: installing Debian's Chromium")
    succeeded(["apt-get", "update"])  # may fail for one source and still do for ours
    packages = ["chromium", "fonts-liberation"]  # else only DejaVu is there
    succeeded(["apt-get", "install", "--yes", "--no-install-recommends", *packages])
    return working(find_browser())


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
