"""How soon an edit is seen: a scripted visitor moves a slider and times the new picture.

Starts the explorer as a process of its own, connects a client to it (no browser: what a browser
adds is its own drawing), and prints as a table what one edit takes until the new beam has arrived,
while paused and while playing, and what a moving picture costs. Run it on a quiet machine:

    python scripts/measure_edit_to_update.py [--edits 100]
"""

import argparse
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

from live.visitor import Visitor, beam_moved, visitor  # type: ignore[import-not-found]  # noqa: E402

TABLE = 'aria-label=\\"modes\\"'  # in JSON
SERVE = """
from beamviz.beam import Beam
from beamviz.scene import Scene
from beamviz.explorer.app import serve
serve(Scene(Beam(alpha=1, beta=0.5, gamma=10)), port=0)
"""


def main() -> None:
    """Measure, and print (key, value, unit) rows."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--edits", type=int, default=100)
    edits = parser.parse_args().edits
    process = subprocess.Popen(
        [sys.executable, "-c", SERVE], stdout=subprocess.PIPE, text=True, cwd=ROOT
    )
    try:
        assert process.stdout
        words = process.stdout.readline().split()
        url = next(word for word in words if word.startswith("http://"))
        with visitor(url) as guest:
            report("playing", moving_picture(guest))
            report("edit while playing", edit_times(guest, edits, has_new_table))
            guest.choose("playing", False)
            drain(guest)
            report("edit while paused", edit_times(guest, edits, beam_moved))
    finally:
        process.terminate()
        process.wait()


def report(name: str, rows: dict[str, tuple[float, str]]) -> None:
    """Print rows."""
    for key, (value, unit) in rows.items():
        print(f"{name:<20} {key:<10} {value:8.1f} {unit}")


def has_new_table(messages: list[dict[str, Any]]) -> bool:
    """Whether a group of messages brings a new table of modes with the beam."""
    texts = [str(m.get("source", "")) for m in messages]
    return beam_moved(messages) and any(TABLE in text for text in texts)


def edit_times(
    guest: Visitor, edits: int, seen: Callable[[list[dict[str, Any]]], bool]
) -> dict[str, tuple[float, str]]:
    """Time from sending an edit until its picture has arrived."""
    times = []
    for k in range(edits):
        time.sleep(0.03)
        start = time.perf_counter()
        guest.choose("gamma", 10.0 + 0.1 * (1 + k % 99) + 0.01 * (k // 99))
        guest.wait(seen)
        times.append(1000 * (time.perf_counter() - start))
    twentieths = statistics.quantiles(times, n=20)
    return {
        "least": (min(times), "ms"),
        "median": (statistics.median(times), "ms"),
        "95 %": (twentieths[-1], "ms"),
    }


def moving_picture(guest: Visitor, seconds: float = 4.0) -> dict[str, tuple[float, str]]:
    """Frames and bytes a second while playing."""
    end, before, frames = time.monotonic() + seconds, guest.received, 0
    while time.monotonic() < end:
        frames += beam_moved(guest.receive(seconds))
    return {
        "frames": (frames / seconds, "1/s"),
        "traffic": ((guest.received - before) / seconds / 1000, "kB/s"),
    }


def drain(guest: Visitor) -> None:
    """Receive the messages that are on their way."""
    try:
        while True:
            guest.receive(0.5)
    except TimeoutError:
        return


if __name__ == "__main__":
    main()
