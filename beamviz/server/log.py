"""A rate-limited log: repeated warnings are counted instead of written."""

import contextlib
import logging
import math
import threading
import time
from collections.abc import Iterator

INTERVAL = 600.0  # [s] between two lines about one kind of error of one visitor
MAX_KINDS = 1000  # pairs of visitor and kind that are stored


class RateLimitedLog:
    """A logger that writes one line per `INTERVAL` for each kind of error of each visitor; the next
    line gives the number of those skipped."""

    def __init__(self, name: str):
        self.logger, self.lock = logging.getLogger(name), threading.Lock()
        self.reported: dict[tuple[str, str], tuple[float, int]] = {}

    def warn(self, subject: str, kind: str, text: str, level: int = logging.WARNING) -> None:
        """Write a line, unless there was one with this subject and kind within INTERVAL."""
        key, now = (subject, kind), time.monotonic()
        with self.lock:
            if len(self.reported) >= MAX_KINDS and key not in self.reported:
                self.reported.clear()
            last, skipped = self.reported.get(key, (-math.inf, 0))
            due = now - last >= INTERVAL
            self.reported[key] = (now, 0) if due else (last, skipped + 1)
        if due:
            more = f" ({skipped} more like this since the last line)" if skipped else ""
            self.logger.log(level, "%s: %s%s", subject, " ".join(text.split()), more)

    def error(self, job: str, request: object, error: Exception) -> None:
        """Write a line about an internal error; its traceback only at level DEBUG."""
        self.warn(job, type(error).__name__, f"failed for {request}: {error!r}", logging.ERROR)
        self.logger.debug("%s: failed for %s", job, request, exc_info=error)

    @contextlib.contextmanager
    def muted(self) -> Iterator[None]:
        """Context in which nothing is written."""
        self.logger.disabled = True
        try:
            yield
        finally:
            self.logger.disabled = False
