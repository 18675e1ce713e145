"""The progress of a sweep on stderr."""

import sys
import time
from typing import Any

from beamviz.sweeps import Progress

INTERRUPTED = "interrupted; what is written is kept: run the same command again to resume"
EVERY = 10.0  # [s] between lines where stderr is no terminal


class ProgressLine:
    """One line that is written anew on a terminal; elsewhere a line now and then, and the last."""

    def __init__(self) -> None:
        self.terminal, self.shown, self.text = sys.stderr.isatty(), time.monotonic(), ""

    def __enter__(self) -> "ProgressLine":
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: Any) -> None:
        if self.text:
            print(f"\r{self.text}" if self.terminal else self.text, file=sys.stderr)
        if kind and not issubclass(kind, Exception):
            print(f"beamviz: {INTERRUPTED}", file=sys.stderr)

    def show(self, progress: Progress) -> None:
        """Show the progress."""
        self.text = progress_text(progress)
        now = time.monotonic()
        if self.terminal:
            print(f"\r{self.text}\x1b[K", end="", file=sys.stderr, flush=True)
        elif now - self.shown > EVERY:
            print(self.text, file=sys.stderr, flush=True)
            self.shown, self.text = now, ""


def progress_text(progress: Progress) -> str:
    """Share and number of beams, rate, and time left."""
    done, total = progress.done, progress.total
    seconds = round(progress.left)
    left = f"{seconds} s" if seconds < 120 else f"{seconds // 3600}:{seconds // 60 % 60:02d} h"
    return (
        f"beamviz: {100 * done // total} %, {done:,} of {total:,} beams,"
        f" {progress.rate:,.0f} a second, {left} left"
    )
