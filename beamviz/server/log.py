"""The log: one line for each kind of mistake of each visitor, then nothing for a while."""

import logging
import math
import threading
import time

QUIET = 600.0  # [s] until a line comes again
MOST = 1000  # kinds of mistakes remembered


class RateLimitedLog:
    """A log without floods: who repeats a mistake is only counted."""

    def __init__(self, name: str):
        self.logger, self.lock = logging.getLogger(name), threading.Lock()
        self.reported: dict[tuple[str, str], tuple[float, int]] = {}

    def warn(self, who: str, kind: str, words: str, level: int = logging.WARNING) -> None:
        """A line about one mistake, unless the same one of the same visitor has just had one."""
        before = self.counted((who, kind))
        if before is not None:
            more = f" ({before} more like this since the last line)" if before else ""
            self.logger.log(level, "%s: %s%s", who, " ".join(words.split()), more)

    def error(self, what: str, wanted: object, error: Exception) -> None:
        """A line about a mistake of ours; where in the code, only for who asks (DEBUG)."""
        self.warn(what, type(error).__name__, f"failed for {wanted}: {error!r}", logging.ERROR)
        self.logger.debug("%s: failed for %s", what, wanted, exc_info=error)

    def counted(self, key: tuple[str, str]) -> int | None:
        """How often it came since its last line, if it is time for another one, else None."""
        now = time.monotonic()
        with self.lock:
            if len(self.reported) >= MOST and key not in self.reported:
                self.reported.clear()
            last, count = self.reported.get(key, (-math.inf, 0))
            due = now - last >= QUIET
            self.reported[key] = (now, 0) if due else (last, count + 1)
        return count if due else None
