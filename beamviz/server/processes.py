"""Several processes behind one address.

Each worker runs the complete explorer for its visitors. The main process accepts connections and
passes each to the worker with the fewest visitors, whichever served the page; a worker that dies is
replaced.
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
from functools import partial
from typing import Any

from beamviz.errors import BeamvizError, InvalidInput, Unavailable
from beamviz.server.access import VisitorCount

BACKLOG = 128  # connections that wait to be accepted
MAX_ERROR_BYTES = 4000
BYTE = b"."  # sent when a worker is ready, and with each connection
POLL = 0.2  # [s] between two checks for a signal to stop
START_TIMEOUT = 60.0  # [s] for a worker to be ready
STOP_TIMEOUT = 5.0  # [s] for all workers to end
MIN_LIFETIME = 5.0  # [s] of a worker that is replaced; an earlier death ends the server


def process_count(processes: int | None, *, shared: bool, follow: bool) -> int:
    """The number of processes: `processes`, by default one per core if other machines can connect
    (shared), else one. With a presenter (follow) all visitors are in one process.

    Raises InvalidInput for a number that is not possible on this system or with `follow`.
    """
    can_fork = sys.platform == "linux"  # elsewhere forking is unsafe or impossible
    if processes is None:
        return len(os.sched_getaffinity(0)) if shared and can_fork and not follow else 1
    if processes > 1 and follow:
        raise InvalidInput(f"processes = {processes}: with --follow all visitors are in one")
    if processes > 1 and not can_fork:
        raise InvalidInput(f"processes = {processes}: more than one needs Linux")
    return processes


class Pipe(socket.socket):
    """The worker's end of a pipe of connections, used by asyncio as a listening socket.

    address: what getsockname() returns, the address of the server; sender: the other end.
    """

    def __init__(self, end: socket.socket, sender: socket.socket, address: Any):
        super().__init__(fileno=end.detach())
        self.sender, self.address = sender, address

    def listen(self, backlog: int = 0) -> None:
        """Do nothing: the main process listens."""

    def getsockname(self) -> Any:
        """The address of the server."""
        return self.address

    def accept(self) -> tuple[socket.socket, Any]:
        """The next connection. If the main process has ended, end this one."""
        data, descriptors, *_ = socket.recv_fds(self, 1, 1)
        if not data:
            os.kill(os.getpid(), signal.SIGTERM)
            raise BlockingIOError
        connection = socket.socket(fileno=descriptors[0])
        try:
            return connection, connection.getpeername()
        except OSError:  # closed already
            connection.close()
            raise ConnectionAbortedError from None

    def connect_to_self(self) -> socket.socket:
        """A connection to this worker itself, for the self-test."""
        ours, theirs = socket.socketpair()
        with theirs:
            socket.send_fds(self.sender, [BYTE], [theirs.fileno()])
        return ours

    def ready(self) -> None:
        """Report to the main process, and close its end here, so that its death is noticed."""
        self.sendall(BYTE)
        self.sender.close()


Run = Callable[[int, Pipe, Callable[[], None]], None]  # of number, listener, call when ready


class Worker:
    """A process that runs `run`; inherited: the sockets that it must close."""

    def __init__(self, number: int, run: Run, address: Any, inherited: list[socket.socket]):
        self.number, self.accepted, self.started = number, 0, time.monotonic()
        self.sender, end = socket.socketpair()
        pipe = Pipe(end, self.sender, address)
        fork = multiprocessing.get_context("fork")
        self.process = fork.Process(target=work, args=(number, run, pipe, inherited), daemon=True)
        self.process.start()
        pipe.close()

    def wait(self) -> None:
        """Wait until it is ready. Raises Unavailable if it ends before or takes too long."""
        self.sender.settimeout(START_TIMEOUT)
        data = b""
        with contextlib.suppress(OSError):
            data = self.sender.recv(MAX_ERROR_BYTES)
        self.sender.setblocking(False)
        if data != BYTE:
            error = data.decode(errors="replace")
            raise Unavailable(error or "a process that serves visitors ended before it was ready")

    def send(self, connection: socket.socket) -> bool:
        """Pass a connection to it; False if its pipe is full or closed."""
        try:
            socket.send_fds(self.sender, [BYTE], [connection.fileno()])
        except OSError:
            return False
        self.accepted += 1
        return True


def work(number: int, run: Run, pipe: Pipe, inherited: list[socket.socket]) -> None:
    """The main function of a worker. It ignores Ctrl-C, which the main process handles."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    for line in inherited:
        line.close()  # so that other workers notice the end of the main process
    report = socket.socket(fileno=os.dup(pipe.fileno()))  # asyncio closes the pipe itself
    try:
        run(number, pipe, pipe.ready)
    except BeamvizError as error:
        report.sendall(str(error).encode()[:MAX_ERROR_BYTES])
        sys.exit(1)


class ProcessPool:
    """The workers: accepts connections and passes each to one."""

    def __init__(self, listeners: list[socket.socket], visitor_count: VisitorCount, run: Run):
        self.listeners, self.visitor_count, self.run = listeners, visitor_count, run
        self.workers: list[Worker] = []
        for number in range(len(visitor_count.counts)):
            self.workers.append(self.started(number))

    def started(self, number: int) -> Worker:
        """A new worker, not ready yet."""
        self.visitor_count.counts[number] = 0
        inherited = [*self.listeners, *(worker.sender for worker in self.workers)]
        return Worker(number, self.run, self.listeners[0].getsockname(), inherited)

    def serve(self, stopped: Callable[[], bool]) -> None:
        """Pass on connections until `stopped()`. Raises Unavailable if a new worker dies."""
        with selectors.DefaultSelector() as events:
            for listener in self.listeners:
                events.register(listener, selectors.EVENT_READ, partial(self.accept, listener))
            for worker in self.workers:
                events.register(worker.process.sentinel, selectors.EVENT_READ, worker)
            while not stopped():
                for key, _ in events.select(POLL):
                    if isinstance(key.data, Worker):
                        events.unregister(key.fileobj)
                        worker = self.replaced(key.data)
                        events.register(worker.process.sentinel, selectors.EVENT_READ, worker)
                    else:
                        key.data()

    def accept(self, listener: socket.socket) -> None:
        """Pass the next connection to the worker with the fewest visitors that accepts it."""
        try:
            connection, _ = listener.accept()
        except OSError:  # closed already, or too many open files
            time.sleep(0.01)
            return
        counts = self.visitor_count.counts
        with connection:
            by_visitors = sorted(self.workers, key=lambda w: (counts[w.number], w.accepted))
            any(worker.send(connection) for worker in by_visitors)

    def replaced(self, worker: Worker) -> Worker:
        """A new worker for one that died. Raises Unavailable if it died soon after its start."""
        worker.process.join()
        worker.sender.close()
        what = f"a process that serves visitors died (exit code {worker.process.exitcode})"
        if time.monotonic() - worker.started < MIN_LIFETIME:
            raise Unavailable(f"{what} soon after it began")
        print(f"beamviz: {what}; their pages connect again, to a new one", file=sys.stderr)
        self.workers.remove(worker)
        self.workers.append(self.started(worker.number))
        self.workers[-1].wait()
        return self.workers[-1]

    def stop(self) -> None:
        """Terminate all workers, and kill them after STOP_TIMEOUT."""
        for worker in self.workers:
            worker.process.terminate()
        deadline = time.monotonic() + STOP_TIMEOUT
        for worker in self.workers:
            worker.process.join(max(deadline - time.monotonic(), 0.0))
            worker.process.kill()
            worker.process.join()
            worker.sender.close()


@contextlib.contextmanager
def process_pool(
    listeners: list[socket.socket], visitor_count: VisitorCount, run: Run
) -> Iterator[ProcessPool]:
    """Workers that are ready, stopped on leaving."""
    pool = ProcessPool(listeners, visitor_count, run)
    try:
        for worker in pool.workers:
            worker.wait()
        yield pool
    finally:
        pool.stop()


@contextlib.contextmanager
def listening_sockets(host: str, port: int) -> Iterator[list[socket.socket]]:
    """Sockets that listen on the same port of all addresses of a host on this machine, closed on
    leaving; port 0 takes a free one. Raises Unavailable if the address is not available."""
    with contextlib.ExitStack() as stack:
        lines: list[socket.socket] = []
        try:
            for family, *_, address in dict.fromkeys(
                socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)
            ):
                port = port or (lines[0].getsockname()[1] if lines else 0)
                place = (address[0], port, *address[2:])
                try:
                    line = socket.create_server(place, family=family, backlog=BACKLOG)
                except OSError as error:
                    if not lines or error.errno != errno.EADDRNOTAVAIL:
                        raise
                else:
                    line.setblocking(False)
                    lines.append(stack.enter_context(line))
        except (OSError, OverflowError) as error:
            reason = (getattr(error, "strerror", None) or str(error)).partition(" (while")[0]
            raise Unavailable(
                f"cannot serve on {host}:{port} ({reason}): choose another --port or --host"
            ) from None
        yield lines
