"""A viser server of our own: one address or a clear error, no banner, no tunnel."""

import contextlib
import errno
import logging
import socket
from collections.abc import Iterator
from typing import Any

import viser

from beamviz.errors import Unavailable
from beamviz.server.access import Door
from beamviz.server.connection import Guard
from beamviz.server.sending import send
from beamviz.server.viser_private import running
from beamviz.server.visitor_count import Attendance

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
    that is there already; attendance: where visitors are counted; door: further keywords of Door.
    Raises Unavailable where the address cannot be had: viser itself would silently take the next
    port, and wait for ever on a host that does not exist.
    """
    port = listener.getsockname()[1] if listener else claimed(host, port)
    logging.getLogger("websockets.server").setLevel(logging.CRITICAL)  # browsers hang up at will
    guard = Guard(Door(host, port, **door), attendance or Attendance(), pictures, listener)
    with running(host, port, guard.serve, send) as server:
        if server.get_port() != port:
            raise Unavailable(f"port {port} was taken a moment ago: choose another with --port")
        yield server


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
