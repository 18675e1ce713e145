"""A viser server of our own: one address or a clear error, no banner, no tunnel."""

import contextlib
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
from beamviz.show.door import Door
from beamviz.show.hardening import hardened


@contextlib.contextmanager
def hosted(
    host: str = "127.0.0.1", port: int = 0, *, pictures: bool = False, **door: Any
) -> Iterator[viser.ViserServer]:
    """A running server, stopped on leaving; port 0 takes a free one.

    pictures: whether a browser of ours may send them; door: further keywords of Door. Raises
    Unavailable where the address cannot be had: viser itself would silently take the next port,
    and wait for ever on a host that does not exist.
    """
    port = claimed(host, port)
    logging.getLogger("websockets.server").setLevel(logging.CRITICAL)  # browsers hang up at will
    warnings.filterwarnings("ignore", "Queued a .* on a closed connection")  # in mid-picture, too
    server = None
    try:
        with undisturbed(), silence(), hardened(Door(host, port, **door), pictures=pictures):
            server = viser.ViserServer(host=host, port=port, verbose=False)
        if server.get_port() != port:
            raise Unavailable(f"port {port} was taken a moment ago: choose another with --port")
        with mock.patch.object(server, "request_share_url", return_value=None):
            yield server  # otherwise any visitor could open a public tunnel by a message
    finally:
        if server is not None:
            with silence():
                server.stop()


def claimed(host: str, port: int) -> int:
    """The port, found free by binding to it once; Unavailable says what is in the way."""
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(
            host, port, type=socket.SOCK_STREAM
        )[0]
        with socket.socket(family, kind, protocol) as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            probe.bind(address)
            return int(probe.getsockname()[1])
    except (OSError, OverflowError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise Unavailable(
            f"cannot serve on {host}:{port} ({reason}): choose another --port or --host"
        ) from None


@contextlib.contextmanager
def silence() -> Iterator[None]:
    """Keep viser's banners off stdout, which is for data."""
    with contextlib.redirect_stdout(io.StringIO()):
        yield
