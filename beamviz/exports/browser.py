"""Chrome, Chromium or Edge without a window, for pictures (and for tests of the page)."""

import atexit
import contextlib
import os
import shutil
import signal
import subprocess
import tempfile
from collections.abc import Iterator
from functools import partial
from pathlib import Path

from beamviz.signals import defer_signals

NAMES = (
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
    "chrome",
    "microsoft-edge",
    "msedge",
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
    "/Applications/Microsoft Edge.app/Contents/MacOS/Microsoft Edge",
)

# The sandbox needs rights that containers lack; the only page opened is our own.
FLAGS = (
    "--headless",
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--hide-scrollbars",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-quic",
    "--disable-dev-shm-usage",
    "--remote-debugging-port=0",
)


def found_browser() -> str | None:
    """The browser to use: the one named by BEAMVIZ_BROWSER (a name or a path), else a usual one."""
    named = os.environ.get("BEAMVIZ_BROWSER")
    return next(filter(None, map(shutil.which, [named] if named else NAMES)), None)


@contextlib.contextmanager
def opened(browser: str, url: str, width: int = 1280, height: int = 720) -> Iterator[Path]:
    """`browser` showing `url` without a window; gives its profile folder, ends it on leaving."""
    with tempfile.TemporaryDirectory(prefix="beamviz-", ignore_cleanup_errors=True) as profile:
        away = None
        try:
            with defer_signals():  # or a signal could come before the process is known
                process = started(browser, url, profile, width, height)
                away = partial(put_away, process, Path(profile))
                atexit.register(away)  # should a signal come as `finally` begins
            yield Path(profile)
        finally:
            if away is not None:
                away()
                atexit.unregister(away)


def started(browser: str, url: str, profile: str, width: int, height: int) -> subprocess.Popen:
    """A browser in a process group of its own."""
    return subprocess.Popen(
        [browser, *FLAGS, f"--window-size={width},{height}", f"--user-data-dir={profile}", url],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )


def put_away(process: subprocess.Popen, profile: Path) -> None:
    """End a browser, and remove what it leaves outside its profile; twice does no harm."""
    if process.returncode is None:
        ended(process)
    forget_socket(profile)


def forget_socket(profile: Path) -> None:
    """Remove the folder that Chromium, killed, leaves beside its profile: its path must be short,
    so it cannot lie in there."""
    socket = profile / "SingletonSocket"
    if socket.is_symlink() and socket.readlink().parent.name.startswith("org.chromium."):
        shutil.rmtree(socket.readlink().parent, ignore_errors=True)


def ended(process: subprocess.Popen) -> None:
    """End a browser and the processes it started, by its own group."""
    if os.name == "posix":
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
    else:
        process.kill()
    process.wait()
