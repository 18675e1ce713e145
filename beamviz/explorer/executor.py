"""Threads for the work of all visitors, on which nobody waits for another one's long work."""

import threading
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import Executor, Future
from functools import partial
from typing import Any

LONG = 2.0  # [s] from which on work is no longer counted


class Threads(Executor):
    """Does work in order, `at_once` pieces at a time, not counting those that have taken long.

    The end of the process does not wait for what is still being done.
    """

    def __init__(self, at_once: int, name: str):
        self.at_once, self.name, self.lock = at_once, name, threading.Lock()
        self.waiting: deque[Callable[[], None]] = deque()
        self.begun: dict[object, float] = {}  # since when each running thread is at its work
        self.alarm: threading.Timer | None = None

    def submit(self, work: Callable[..., Any], /, *given: Any, **named: Any) -> Future:
        """Have work done as soon as it is its turn."""
        future: Future = Future()
        with self.lock:
            self.waiting.append(partial(done, future, partial(work, *given, **named)))
            self.go_on()
        return future

    def go_on(self) -> None:
        """Begin with what has waited longest, or look again when there may be room."""
        while self.waiting and (wait := self.wait()) <= 0:
            thread = object()
            self.begun[thread] = time.monotonic()
            given = (thread, self.waiting.popleft())
            threading.Thread(target=self.run, args=given, name=self.name, daemon=True).start()
        if self.waiting and not self.alarm:
            self.alarm = threading.Timer(wait, self.ring)
            self.alarm.daemon = True
            self.alarm.start()

    def wait(self) -> float:
        """How long [s] until there is room: as so many began last, and may yet take long."""
        last = sorted(self.begun.values())[-self.at_once :]
        return last[0] + LONG - time.monotonic() if len(last) == self.at_once else 0.0

    def ring(self) -> None:
        """Something may have taken long by now."""
        with self.lock:
            self.alarm = None
            self.go_on()

    def run(self, thread: object, work: Callable[[], None] | None) -> None:
        """Do one piece of work after the other, as long as there is any and room for it."""
        while work:
            work()
            with self.lock:
                del self.begun[thread]
                work = self.waiting.popleft() if self.waiting and self.wait() <= 0 else None
                if work:
                    self.begun[thread] = time.monotonic()

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Begin with nothing more; what is being done is left to itself."""
        with self.lock:
            self.waiting.clear()
            if self.alarm:
                self.alarm.cancel()


def done(future: Future, work: Callable[[], Any]) -> None:
    """Do some work; what comes of it goes into the future, be it an error."""
    try:
        future.set_result(work())
    except BaseException as error:
        future.set_exception(error)
