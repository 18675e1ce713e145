"""SIGINT and SIGTERM: a process ends once, after closing everything it has opened."""

import contextlib
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from types import FrameType
from typing import Any

SIGNALS = (signal.SIGINT, signal.SIGTERM)
IGNORE_TIME = 5.0  # [s] after a signal, during which further ones are ignored
DELAY = 0.05  # [s] until a signal is raised again
Handler = Callable[[int, FrameType | None], None]


class Terminated(BaseException):
    """Raised by a signal; `code` is the exit code of the process."""

    def __init__(self, number: int):
        super().__init__(number)
        self.number, self.code = number, 128 + number


@contextlib.contextmanager
def terminate_on_signal() -> Iterator[None]:
    """Within, SIGINT or SIGTERM raises Terminated. Further ones are ignored for a while, also after
    leaving, so that nothing interrupts the closing of what is open."""
    received: list[float] = []

    def terminate(number: int, frame: FrameType | None) -> None:
        if is_importing(frame):
            reraise(number)
        elif not received or time.monotonic() - received[-1] > IGNORE_TIME:
            received.append(time.monotonic())
            raise Terminated(number)

    before = set_handlers(terminate)
    try:
        with reraise_unraisable(received):
            yield
    finally:
        if not received:
            restore_handlers(before)


@contextlib.contextmanager
def reraise_unraisable(received: list[float]) -> Iterator[None]:
    """Within, the signal is raised again if Python discarded its Terminated, as it does in
    `__del__`, which may run at any moment."""
    original = sys.unraisablehook

    def hook(discarded: Any) -> None:
        if isinstance(discarded.exc_value, Terminated):
            received.clear()
            reraise(discarded.exc_value.number)
        else:
            original(discarded)

    sys.unraisablehook = hook
    try:
        yield
    finally:
        sys.unraisablehook = original


def is_importing(frame: FrameType | None) -> bool:
    """Whether a module is being imported: some modules discard any exception on import."""
    while frame and not frame.f_code.co_filename.startswith("<frozen importlib"):
        frame = frame.f_back
    return frame is not None


def reraise(number: int) -> None:
    """Raise a signal again after DELAY, for the handler set then."""
    if hasattr(signal, "setitimer"):  # not on Windows, where Ctrl-C has to be pressed again
        signal.signal(signal.SIGALRM, lambda *_: signal.raise_signal(number))
        signal.setitimer(signal.ITIMER_REAL, DELAY)


@contextlib.contextmanager
def defer_signals() -> Iterator[None]:
    """Within, signals are deferred, so that a process started here is known to the code that ends
    it."""
    waiting: list[int] = []
    with handle_signals(lambda number, _: waiting.append(number)):
        yield
    for number in waiting[:1]:
        signal.raise_signal(number)


@contextlib.contextmanager
def handle_signals(handler: Handler) -> Iterator[None]:
    """Within, `handler` handles SIGINT and SIGTERM."""
    before = set_handlers(handler)
    try:
        yield
    finally:
        restore_handlers(before)


def set_handlers(handler: Handler) -> dict[signal.Signals, Any]:
    """Have `handler` handle both signals, and return the earlier handlers. Python allows this in
    the main thread only; in others nothing changes."""
    if threading.current_thread() is not threading.main_thread():
        return {}
    return {number: signal.signal(number, handler) for number in SIGNALS}


def restore_handlers(before: dict[signal.Signals, Any]) -> None:
    """Set the earlier handlers again."""
    for number, handler in before.items():
        signal.signal(number, handler)
