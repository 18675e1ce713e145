"""A viser server of our own: one address or a clear error, no banner, no tunnel."""

import contextlib
import logging
import socket
from collections.abc import Iterator
from typing import Any

import viser

from beamviz.errors import Unavailable
from beamviz.server.access import Access, VisitorCount
from beamviz.server.connection import Guard
from beamviz.server.processes import claimed
from beamviz.server.sending import send
from beamviz.server.viser_private import running


@contextlib.contextmanager
def run_server(
    host: str = "127.0.0.1",
    port: int = 0,
    *,
    pictures: bool = False,
    listener: socket.socket | None = None,
    visitor_count: VisitorCount | None = None,
    **access: Any,
) -> Iterator[viser.ViserServer]:
    """A running server, stopped on leaving; port 0 takes a free one.

    pictures: whether a browser of ours may send them; listener: what connections come from, if
    that is there already; visitor_count: where visitors
    are counted; access: further keywords of Access.
    Raises Unavailable where the address cannot be had: viser itself would silently take the next
    port, and wait for ever on a host that does not exist.
    """
    port = listener.getsockname()[1] if listener else claimed(host, port)
    logging.getLogger("websockets.server").setLevel(logging.CRITICAL)  # browsers hang up at will
    guard = Guard(Access(host, port, **access), visitor_count or VisitorCount(), pictures, listener)
    with running(host, port, guard.serve, send) as server:
        if server.get_port() != port:
            raise Unavailable(f"port {port} was taken a moment ago: choose another with --port")
        yield server
