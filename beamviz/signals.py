"""How a process ends when it is asked to: everything it started is put away first, once."""

import contextlib
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from types import FrameType
from typing import Any

ENDINGS = (signal.SIGINT, signal.SIGTERM)
PATIENCE, MOMENT = 5.0, 0.05  # [s]
Handler = Callable[[int, FrameType | None], None]


class Terminated(BaseException):
    """A signal asked the process to end; `code` is its exit code."""

    def __init__(self, number: int):
        super().__init__(number)
        self.number, self.code = number, 128 + number


@contextlib.contextmanager
def terminate_on_signal() -> Iterator[None]:
    """Within, SIGINT or SIGTERM raises Terminated, so that what is open is closed; further ones
    change nothing for a while, up to the end of the process."""
    asked: list[float] = []

    def end(number: int, frame: FrameType | None) -> None:
        if importing(frame):
            reraise(number)
        elif not asked or time.monotonic() - asked[-1] > PATIENCE:
            asked.append(time.monotonic())
            raise Terminated(number)

    before = handled_by(end)
    try:
        with unswallowed(asked):
            yield
    finally:
        if not asked:
            restored(before)


@contextlib.contextmanager
def unswallowed(asked: list[float]) -> Iterator[None]:
    """Within, a Terminated raised where Python ignores exceptions (in `__del__`, which runs at any
    moment) is not lost: its signal comes again."""
    usual = sys.unraisablehook

    def swallowed(lost: Any) -> None:
        if isinstance(lost.exc_value, Terminated):
            asked.clear()
            reraise(lost.exc_value.number)
        else:
            usual(lost)

    sys.unraisablehook = swallowed
    try:
        yield
    finally:
        sys.unraisablehook = usual


def importing(frame: FrameType | None) -> bool:
    """Whether a module is being loaded: some swallow whatever is raised meanwhile."""
    while frame and not frame.f_code.co_filename.startswith("<frozen importlib"):
        frame = frame.f_back
    return frame is not None


def reraise(number: int) -> None:
    """Let a signal come once more in a moment, to whoever handles it then."""
    if hasattr(signal, "setitimer"):  # not on Windows, where the next Ctrl-C has to do
        signal.signal(signal.SIGALRM, lambda *_: signal.raise_signal(number))
        signal.setitimer(signal.ITIMER_REAL, MOMENT)


@contextlib.contextmanager
def defer_signals() -> Iterator[None]:
    """Within, a signal waits: what is started here is known to who must end it."""
    waiting: list[int] = []
    with handle_signals(lambda number, _: waiting.append(number)):
        yield
    for number in waiting[:1]:
        signal.raise_signal(number)


@contextlib.contextmanager
def handle_signals(handler: Handler) -> Iterator[None]:
    """Within, both signals are handled by `handler`."""
    before = handled_by(handler)
    try:
        yield
    finally:
        restored(before)


def handled_by(handler: Handler) -> dict[signal.Signals, Any]:
    """Let `handler` have both signals; who had them before. Only the main thread has a say."""
    if threading.current_thread() is not threading.main_thread():
        return {}
    return {number: signal.signal(number, handler) for number in ENDINGS}


def restored(before: dict[signal.Signals, Any]) -> None:
    """Give the signals back to who had them before."""
    for number, handler in before.items():
        signal.signal(number, handler)
