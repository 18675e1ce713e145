"""Several processes behind one address, where visitors are many.

Each runs the whole explorer for the visitors it is given. This process only takes in connections
and hands each on to the worker with the fewest visitors; a worker that dies is replaced. Which
worker serves a page, and which its WebSocket, makes no difference to them.
"""

import contextlib
import errno
import multiprocessing
import os
import selectors
import signal
import socket
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

from beamviz.errors import BeamvizError, InvalidInput, Unavailable
from beamviz.server.access import VisitorCount

BACKLOG = 128  # connections that wait to be taken in
WORD = b"."  # sent when a worker is ready, and with each connection
START = 60.0  # [s] for a worker to be ready
PATIENCE = 5.0  # [s] for workers to end; one that dies sooner than that is not replaced

Run = Callable[[int, socket.socket, Callable[[], None]], None]


def usual(processes: int | None, *, shared: bool, follow: bool) -> int:
    """How many processes there are to be: unless told otherwise, one for each core where others
    are let in. In a lecture all are in one. Raises InvalidInput for what cannot be."""
    able = sys.platform == "linux"  # where a process can safely be doubled as it stands
    if processes is None:
        return len(os.sched_getaffinity(0)) if shared and able and not follow else 1
    if processes > 1 and follow:
        raise InvalidInput(f"processes = {processes}: with --follow all visitors are in one")
    if processes > 1 and not able:
        raise InvalidInput(f"processes = {processes}: more than one needs Linux")
    return processes


class Handed(socket.socket):
    """The end of a pipe through which connections come, in place of a socket that listens."""

    def __init__(self, pipe: socket.socket, address: Any):
        super().__init__(fileno=pipe.detach())
        self.address = address

    def listen(self, backlog: int = 0) -> None:
        """Another process does."""

    def getsockname(self) -> Any:
        """The address that visitors know."""
        return self.address

    def accept(self) -> tuple[socket.socket, Any]:
        """The next connection; where none will ever come again, this process is to end."""
        word, lines, *_ = socket.recv_fds(self, 1, 1)
        if not word:
            os.kill(os.getpid(), signal.SIGTERM)
            raise BlockingIOError
        line = socket.socket(fileno=lines[0])
        try:
            return line, line.getpeername()
        except OSError:
            line.close()
            raise ConnectionAbortedError from None  # gone already


class Worker:
    """A process that serves, and the pipe to it. mine: what it must not keep open."""

    def __init__(self, number: int, run: Run, address: Any, mine: list[socket.socket]):
        self.number, self.handed, self.started = number, 0, time.monotonic()
        self.pipe, end = socket.socketpair()
        given = number, run, Handed(end, address), [*mine, self.pipe]
        fork = multiprocessing.get_context("fork")
        self.process = fork.Process(target=work, args=given, daemon=True)
        self.process.start()
        given[2].close()

    def wait(self) -> None:
        """Wait until it is ready; Unavailable where it does not come to that."""
        self.pipe.settimeout(START)
        word = b""
        with contextlib.suppress(OSError):
            word = self.pipe.recv(1)
        self.pipe.setblocking(False)
        if word != WORD:
            raise Unavailable("a process that serves visitors ended before it was ready")

    def take(self, line: socket.socket) -> bool:
        """Give it a connection; False where it cannot take it."""
        try:
            socket.send_fds(self.pipe, [WORD], [line.fileno()])
        except OSError:
            return False
        self.handed += 1
        return True


def work(number: int, run: Run, handed: Handed, others: list[socket.socket]) -> None:
    """What a worker does. Ctrl-C reaches it as well, but is for the first process."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    for line in others:
        line.close()  # or nobody would notice the end of the first process
    try:
        run(number, handed, lambda: handed.sendall(WORD))
    except BeamvizError as error:
        sys.exit(f"beamviz: {error}")


class Team:
    """The workers, and who of them gets the next connection."""

    def __init__(self, listeners: list[socket.socket], visitor_count: VisitorCount, run: Run):
        self.listeners, self.visitor_count, self.run = listeners, visitor_count, run
        self.workers: list[Worker] = []
        for number in range(len(visitor_count.counts)):
            self.workers.append(self.hired(number))

    def hired(self, number: int) -> Worker:
        """A new worker."""
        self.visitor_count.counts[number] = 0
        mine = [*self.listeners, *(worker.pipe for worker in self.workers)]
        return Worker(number, self.run, self.listeners[0].getsockname(), mine)

    def serve(self, over: Callable[[], bool]) -> None:
        """Hand on connections until it is over."""
        with selectors.DefaultSelector() as events, alarm() as bell:
            for line in (*self.listeners, bell):
                events.register(line, selectors.EVENT_READ)
            for worker in self.workers:
                events.register(worker.process.sentinel, selectors.EVENT_READ, worker)
            while not over():
                for key, _ in events.select(1.0):
                    if isinstance(key.data, Worker):
                        events.unregister(key.fileobj)
                        worker = self.replaced(key.data)
                        events.register(worker.process.sentinel, selectors.EVENT_READ, worker)
                    elif key.fileobj is bell:
                        bell.recv(100)
                    elif isinstance(key.fileobj, socket.socket):
                        self.hand_on(key.fileobj)

    def hand_on(self, listener: socket.socket) -> None:
        """Give the next connection to the worker with the fewest visitors that takes it."""
        try:
            line, _ = listener.accept()
        except OSError:  # gone already, or no more files can be open
            time.sleep(0.01)
            return
        counts = self.visitor_count.counts
        with line:
            fewest = sorted(self.workers, key=lambda one: (counts[one.number], one.handed))
            any(worker.take(line) for worker in fewest)

    def replaced(self, worker: Worker) -> Worker:
        """A new worker for one that died; Unavailable where that happens all the time."""
        worker.process.join()
        worker.pipe.close()
        how = f"a process that serves visitors died (exit code {worker.process.exitcode})"
        if time.monotonic() - worker.started < PATIENCE:
            raise Unavailable(f"{how} soon after it began")
        print(f"beamviz: {how}; their pages connect again, to a new one", file=sys.stderr)
        self.workers.remove(worker)
        self.workers.append(self.hired(worker.number))
        self.workers[-1].wait()
        return self.workers[-1]

    def end(self) -> None:
        """End all workers."""
        for worker in self.workers:
            worker.process.terminate()
        deadline = time.monotonic() + PATIENCE
        for worker in self.workers:
            worker.process.join(max(deadline - time.monotonic(), 0.0))
            worker.process.kill()
            worker.process.join()
            worker.pipe.close()


@contextlib.contextmanager
def team(listeners: list[socket.socket], visitor_count: VisitorCount, run: Run) -> Iterator[Team]:
    """Workers that are ready, and ended on leaving."""
    hired = Team(listeners, visitor_count, run)
    try:
        for worker in hired.workers:
            worker.wait()
        yield hired
    finally:
        hired.end()


@contextlib.contextmanager
def alarm() -> Iterator[socket.socket]:
    """A socket that can be read from as soon as a signal has come."""
    bell, rope = socket.socketpair()
    with bell, rope:
        rope.setblocking(False)
        before = signal.set_wakeup_fd(rope.fileno())
        try:
            yield bell
        finally:
            signal.set_wakeup_fd(before)


def claimed(host: str, port: int) -> int:
    """The port, found free by binding to it once; Unavailable says what is in the way."""
    with contextlib.ExitStack() as stack:
        (first, *_) = bound(host, port, stack)
        return int(first.getsockname()[1])


@contextlib.contextmanager
def listening_sockets(host: str, port: int) -> Iterator[list[socket.socket]]:
    """Sockets that listen on all addresses of a host, closed on leaving; port 0 takes a free one.
    Raises Unavailable as well."""
    with contextlib.ExitStack() as stack:
        lines = bound(host, port, stack)
        for line in lines:
            line.listen(BACKLOG)
            line.setblocking(False)
        yield lines


def bound(host: str, port: int, stack: contextlib.ExitStack) -> list[socket.socket]:
    """Sockets on all addresses of a host that this machine has, on the same port."""
    lines: list[socket.socket] = []
    try:
        for family, kind, protocol, _, address in dict.fromkeys(
            socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)
        ):
            line = stack.enter_context(socket.socket(family, kind, protocol))
            line.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            if family == socket.AF_INET6:
                line.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_V6ONLY, 1)
            port = port or (lines[0].getsockname()[1] if lines else 0)
            try:
                line.bind((address[0], port, *address[2:]))
            except OSError as error:
                if not lines or error.errno != errno.EADDRNOTAVAIL:
                    raise
            else:
                lines.append(line)
    except (OSError, OverflowError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise Unavailable(
            f"cannot serve on {host}:{port} ({reason}): choose another --port or --host"
        ) from None
    return lines
