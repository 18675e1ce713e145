"""How a process ends when it is asked to: everything it started is put away first, once."""

import contextlib
import signal
import threading
from collections.abc import Callable, Iterator
from types import FrameType

ENDINGS = (signal.SIGINT, signal.SIGTERM)


class Ended(BaseException):
    """A signal asked the process to end; `code` is its exit code."""

    def __init__(self, number: int):
        super().__init__(number)
        self.code = 128 + number


@contextlib.contextmanager
def ending() -> Iterator[None]:
    """Within, the first SIGINT or SIGTERM raises Ended, so that what is open is closed; later
    ones change nothing, so that closing it is not disturbed."""
    asked: list[int] = []

    def end(number: int, _: FrameType | None) -> None:
        if not asked:
            asked.append(number)
            raise Ended(number)

    with handled(end):
        yield


@contextlib.contextmanager
def undisturbed() -> Iterator[None]:
    """Within, a signal waits: what is started here is known to who must end it."""
    waiting: list[int] = []
    with handled(lambda number, _: waiting.append(number)):
        yield
    for number in waiting[:1]:
        signal.raise_signal(number)


@contextlib.contextmanager
def handled(handler: Callable[[int, FrameType | None], None]) -> Iterator[None]:
    """Both signals handled by `handler`; only the main thread has a say in this."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = {number: signal.signal(number, handler) for number in ENDINGS}
    try:
        yield
    finally:
        for number, old in before.items():
            signal.signal(number, old)
