"""SIGINT and SIGTERM: a process ends once, after closing all resources, and within two seconds."""

import _thread
import contextlib
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from types import FrameType
from typing import Any

SIGNALS = (signal.SIGINT, signal.SIGTERM)
NAMES = {signal.SIGINT: "interrupted", signal.SIGTERM: "terminated"}
DELAY = 0.05  # [s] until a signal is raised again
GRACE = 1.0  # [s] after a signal in which a process closes its resources; then it is ended
Handler = Callable[[int, FrameType | None], None]
watches: list[Callable[[int], None]] = []  # of the first signal, also where it is deferred


class Terminated(BaseException):
    """Raised by a signal; `code` is the exit code of the process. Its notes are told, too."""

    def __init__(self, number: int):
        super().__init__(number)
        self.number, self.code, self.told = number, 128 + number, False

    def tell(self) -> None:
        """One line on stderr, the first time."""
        if not self.told:
            self.told = True
            parts = [NAMES[signal.Signals(self.number)], *getattr(self, "__notes__", ())]
            with contextlib.suppress(OSError):  # nobody reads it
                # In one piece: another thread may end the process meanwhile.
                print(f"beamviz: {'; '.join(parts)}\n", end="", file=sys.stderr, flush=True)


@contextlib.contextmanager
def terminate_on_signal(at_last: Callable[[], object] | None = None) -> Iterator[None]:
    """Context in which SIGINT and SIGTERM raise Terminated, again where Python discards it, as it
    does in `__del__`. Further signals are ignored, also after leaving, so that they do not
    interrupt the closing of resources.

    at_last: the process is ended GRACE after the signal, whatever it does, once this was called.
    """
    received: list[Terminated] = []
    original = sys.unraisablehook

    def watch(number: int) -> None:
        time.sleep(GRACE)
        end = received[-1] if received else Terminated(number)
        received[:] = [end]  # so that no other one is raised, and told, from now on
        if at_last:
            at_last()
        end.tell()
        time.sleep(DELAY)  # another thread may have begun to tell it
        os._exit(end.code)

    def terminate(number: int, frame: FrameType | None) -> None:
        start_watches(number)
        if is_importing(frame):
            reraise(number)
        elif not received:
            received.append(Terminated(number))
            raise received[-1]

    def hook(discarded: Any) -> None:
        if isinstance(discarded.exc_value, Terminated):
            received.clear()
            reraise(discarded.exc_value.number)
        else:
            original(discarded)

    watches[:] = [watch] if at_last else []
    with handle_signals(terminate, received):
        sys.unraisablehook = hook
        try:
            yield
        finally:
            sys.unraisablehook = original
            watches.clear()


def start_watches(number: int) -> None:
    """Start what is to end the process in the end, once; by bare threads, as this one may hold a
    lock of `threading`."""
    while watches:
        _thread.start_new_thread(watches.pop(), (number,))


def is_importing(frame: FrameType | None) -> bool:
    """Whether a module is being imported: some modules discard all exceptions on import."""
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
    """Context in which signals are deferred, so that code that starts a process can store it
    before a signal ends it. One that came is raised also after an error: it may be the reason, as
    where it has ended a process that the code waits for."""
    waiting: list[int] = []

    def wait(number: int, _: FrameType | None) -> None:
        start_watches(number)
        waiting.append(number)

    try:
        with handle_signals(wait):
            yield
    finally:
        for number in waiting[:1]:
            signal.raise_signal(number)


@contextlib.contextmanager
def handle_signals(handler: Handler, received: Sequence[object] = ()) -> Iterator[None]:
    """Context in which `handler` handles SIGINT and SIGTERM; only in the main thread, as Python
    demands. It stays where it has `received` any, also when the contexts around this one are left.
    """
    main = threading.current_thread() is threading.main_thread()
    before = {number: signal.signal(number, handler) for number in SIGNALS if main}
    try:
        yield
    finally:
        for number, earlier in before.items() if not received else ():
            if signal.getsignal(number) is handler:  # else that of an inner context stays
                signal.signal(number, earlier)
