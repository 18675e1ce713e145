"""Several processes behind one address.

Each worker runs the complete explorer. The main process passes each connection to the worker with
the fewest visitors, whichever served the page, and replaces a worker that dies.
"""

import contextlib
import errno
import multiprocessing
import os
import signal
import socket
import sys
import time
from collections.abc import Callable, Iterator
from multiprocessing.connection import Connection, wait
from typing import Any, cast

from beamviz.errors import BeamvizError, InvalidInput, Unavailable
from beamviz.signals import Terminated

BACKLOG = 128  # connections that wait to be accepted
BYTE = b"."  # sent with each connection
POLL = 0.2  # [s] between two checks for a signal to stop
START_TIMEOUT = 60.0  # [s] for a worker to be ready
STOP_TIMEOUT = 5.0  # [s] for all workers to end
MIN_LIFETIME = 5.0  # [s] of a worker that is replaced; an earlier death ends the server


class VisitorCount:
    """Visitors of all processes, in shared memory; each counts its own at its index `process`."""

    def __init__(self, processes: int = 1):
        self.counts = multiprocessing.RawArray("q", processes)
        self.process = 0

    @property
    def total(self) -> int:
        return sum(self.counts)

    def add(self, visitors: int) -> None:
        self.counts[self.process] += visitors


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
        return self.address

    def accept(self) -> tuple[socket.socket, Any]:
        """The next connection."""
        _, descriptors, *_ = socket.recv_fds(self, 1, 1)
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


Run = Callable[[int, Pipe, Callable[[], None]], None]  # of number, listener, call when ready


class Worker:
    """A process that runs `run`; address: of the server."""

    def __init__(self, number: int, run: Run, address: Any):
        self.number, self.accepted, self.started = number, 0, time.monotonic()
        self.sender, end = socket.socketpair()
        self.sender.setblocking(False)
        fork = multiprocessing.get_context("fork")
        self.result, report = fork.Pipe(duplex=False)  # of the start: "", or an error
        with Pipe(end, self.sender, address) as pipe, report:
            arguments = (run, number, pipe, report)
            self.process = fork.Process(target=work, args=arguments, daemon=True)
            signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGTERM])  # until `work` handles it
            self.process.start()
            signal.pthread_sigmask(signal.SIG_UNBLOCK, [signal.SIGTERM])

    def wait(self) -> None:
        """Wait until it is ready. Raises Unavailable if it ends before or takes too long."""
        error = "a process that serves visitors ended before it was ready"
        with self.result, contextlib.suppress(EOFError):
            error = self.result.recv() if self.result.poll(START_TIMEOUT) else error
        if error:
            raise Unavailable(error)


def work(run: Run, number: int, pipe: Pipe, report: Connection) -> None:
    """The main function of a worker. It ignores Ctrl-C, which the main process handles."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, [signal.SIGTERM])
        run(number, pipe, lambda: report.send(""))
    except Terminated:
        pass
    except BeamvizError as error:
        report.send(str(error))
        sys.exit(1)


class ProcessPool:
    """The workers: accepts connections and passes each to one."""

    def __init__(self, listeners: list[socket.socket], visitor_count: VisitorCount, run: Run):
        self.listeners, self.visitor_count, self.run = listeners, visitor_count, run
        self.workers: list[Worker] = []
        for number in range(len(visitor_count.counts)):
            self.start(number)

    def start(self, number: int) -> Worker:
        self.visitor_count.counts[number] = 0
        self.workers.append(Worker(number, self.run, self.listeners[0].getsockname()))
        return self.workers[-1]

    def serve(self) -> None:
        """Pass on connections until Terminated is raised; Unavailable if a new worker dies."""
        while True:
            ends: dict[Any, Worker] = {worker.process.sentinel: worker for worker in self.workers}
            for ready in wait([*self.listeners, *ends], POLL):
                if ready in ends:
                    self.replace(ends[ready])
                else:
                    self.accept(cast(socket.socket, ready))

    def accept(self, listener: socket.socket) -> None:
        """Pass the next connection to the worker with the fewest visitors that accepts it."""
        try:
            connection, _ = listener.accept()
        except OSError:  # closed already, or too many open files
            time.sleep(0.01)
            return
        counts = self.visitor_count.counts
        with connection:
            for worker in sorted(self.workers, key=lambda w: (counts[w.number], w.accepted)):
                with contextlib.suppress(OSError):  # its pipe is full or closed
                    socket.send_fds(worker.sender, [BYTE], [connection.fileno()])
                    worker.accepted += 1
                    return

    def replace(self, worker: Worker) -> None:
        """Replace a worker that died. Raises Unavailable if it died soon after its start."""
        worker.process.join()
        worker.sender.close()
        what = f"a process that serves visitors died (exit code {worker.process.exitcode})"
        if time.monotonic() - worker.started < MIN_LIFETIME:
            raise Unavailable(f"{what} soon after it began")
        print(f"beamviz: {what}; their pages connect again, to a new one", file=sys.stderr)
        self.workers.remove(worker)
        self.start(worker.number).wait()

    def close(self) -> None:
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
def listening_sockets(host: str, port: int) -> Iterator[list[socket.socket]]:
    """Sockets that listen on the same port of all addresses of a host on this machine, closed on
    leaving; port 0 takes a free one. Raises Unavailable if the address is not available."""
    with contextlib.ExitStack() as stack:
        lines: list[socket.socket] = []
        try:
            addresses = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)
            for family, *_, (address, _, *scope) in dict.fromkeys(addresses):
                port = port or (lines[0].getsockname()[1] if lines else 0)
                try:
                    place = (address, port, *scope)
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
