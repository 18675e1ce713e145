"""A viser server of our own: one address or a clear error, no banner, no tunnel."""

import contextlib
import errno
import io
import logging
import socket
import warnings
from collections.abc import Iterator
from typing import Any
from unittest import mock

import viser

from beamviz.ending import undisturbed
from beamviz.errors import Unavailable
from beamviz.show.attendance import Attendance
from beamviz.show.door import Door
from beamviz.show.hardening import Guard, hardened
from beamviz.show.sending import lean

BACKLOG = 128  # connections that wait to be taken in


@contextlib.contextmanager
def hosted(
    host: str = "127.0.0.1",
    port: int = 0,
    *,
    pictures: bool = False,
    listener: socket.socket | None = None,
    attendance: Attendance | None = None,
    **door: Any,
) -> Iterator[viser.ViserServer]:
    """A running server, stopped on leaving; port 0 takes a free one.

    pictures: whether a browser of ours may send them; listener: what connections come from, if
    that is there already; attendance: where visitors are counted; door: further keywords of
    Door. Raises
    Unavailable where the address cannot be had: viser itself would silently take the next port,
    and wait for ever on a host that does not exist.
    """
    port = listener.getsockname()[1] if listener else claimed(host, port)
    logging.getLogger("websockets.server").setLevel(logging.CRITICAL)  # browsers hang up at will
    warnings.filterwarnings("ignore", "Queued a .* on a closed connection")  # in mid-picture, too
    server = None
    try:
        guard = Guard(Door(host, port, **door), attendance or Attendance(), pictures, listener)
        with undisturbed(), silence(), hardened(guard):
            server = viser.ViserServer(host=host, port=port, verbose=False)
        if server.get_port() != port:
            raise Unavailable(f"port {port} was taken a moment ago: choose another with --port")
        with lean(), mock.patch.object(server, "request_share_url", return_value=None):
            yield server  # otherwise any visitor could open a public tunnel by a message
    finally:
        if server is not None:
            with silence():
                server.stop()


def claimed(host: str, port: int) -> int:
    """The port, found free by binding to it once; Unavailable says what is in the way."""
    with contextlib.ExitStack() as stack:
        (first, *_) = bound(host, port, stack)
        return int(first.getsockname()[1])


@contextlib.contextmanager
def listening(host: str, port: int) -> Iterator[list[socket.socket]]:
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


@contextlib.contextmanager
def silence() -> Iterator[None]:
    """Keep viser's banners off stdout, which is for data."""
    with contextlib.redirect_stdout(io.StringIO()):
        yield
