"""A headless Chrome, Chromium or Edge: found, started and ended. Standard library only."""

import contextlib
import os
import shutil
import signal
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path

BROWSERS = (
    *("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome"),
    *("microsoft-edge", "msedge"),
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
    "/Applications/Microsoft Edge.app/Contents/MacOS/Microsoft Edge",
)
FLAGS = (
    "--headless",
    "--no-sandbox",  # it needs rights that containers lack; only our own page is opened
    *("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"),
    # Drawing text and page on the simulated graphics card takes longer.
    *("--disable-gpu-rasterization", "--disable-gpu-compositing"),
    *("--hide-scrollbars", "--no-first-run", "--disable-background-networking"),
    *("--disable-component-update", "--disable-sync", "--disable-quic"),
    *("--disable-dev-shm-usage", "--remote-debugging-port=0"),
)


def find_browser() -> str | None:
    """The browser named by BEAMVIZ_BROWSER (a name or a path), else the first of BROWSERS found."""
    named = os.environ.get("BEAMVIZ_BROWSER")
    return next(filter(None, map(shutil.which, [named] if named else BROWSERS)), None)


@contextlib.contextmanager
def browser_process(command: list[str], environment: dict[str, str]) -> Iterator[None]:
    """A browser without a terminal, killed with its child processes at last."""
    quiet = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.DEVNULL)
    own = {**os.environ, **environment}
    process = subprocess.Popen(command, env=own, start_new_session=True, **quiet)
    try:
        yield
    finally:
        if os.name == "posix":
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
        else:
            process.kill()
        process.wait()


@contextlib.contextmanager
def open_browser(browser: str, url: str) -> Iterator[Path]:
    """`browser` showing `url` without a window, ended at last; yields its profile folder."""
    with tempfile.TemporaryDirectory(prefix="beamviz-", ignore_cleanup_errors=True) as profile:
        command = [browser, *FLAGS, f"--user-data-dir={profile}", url]
        with browser_process(
            command, {"TMPDIR": profile}
        ):  # what it leaves, killed, is removed too
            yield Path(profile)
