"""How a process ends when it is asked to: everything it started is put away first, once."""

import contextlib
import signal
import threading
from collections.abc import Callable, Iterator
from types import FrameType
from typing import Any

ENDINGS = (signal.SIGINT, signal.SIGTERM)
Handler = Callable[[int, FrameType | None], None]


class Ended(BaseException):
    """A signal asked the process to end; `code` is its exit code."""

    def __init__(self, number: int):
        super().__init__(number)
        self.code = 128 + number


@contextlib.contextmanager
def ending() -> Iterator[None]:
    """Within, the first SIGINT or SIGTERM raises Ended, so that what is open is closed; later
    ones change nothing, up to the end of the process, so that closing it is not disturbed."""
    asked: list[int] = []

    def end(number: int, _: FrameType | None) -> None:
        if not asked:
            asked.append(number)
            raise Ended(number)

    before = handled_by(end)
    try:
        yield
    finally:
        if not asked:
            restored(before)


@contextlib.contextmanager
def undisturbed() -> Iterator[None]:
    """Within, a signal waits: what is started here is known to who must end it."""
    waiting: list[int] = []
    with handled(lambda number, _: waiting.append(number)):
        yield
    for number in waiting[:1]:
        signal.raise_signal(number)


@contextlib.contextmanager
def handled(handler: Handler) -> Iterator[None]:
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
