"""A protected viser server: `run_server` starts it, `self_test` tests its protection."""

import contextlib
import logging
import socket
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import viser
from websockets.exceptions import ConnectionClosed, InvalidStatus, WebSocketException
from websockets.sync.client import unix_connect

from beamviz.errors import Unavailable
from beamviz.server import connection
from beamviz.server.access import Access
from beamviz.server.processes import listening_sockets
from beamviz.server.viser_private import PROTOCOL, viser_server

TIMEOUT = 30.0  # [s] for an answer in the self-test
COUNT_TIMEOUT = 1.0  # [s] for its connections to be closed
FOREIGN_ORIGIN = "http://foreign.invalid"


@contextlib.contextmanager
def run_server(
    access: Access | None = None, insert: connection.Insert = str
) -> Iterator[viser.ViserServer]:
    """A running server, stopped on leaving; port 0 takes a free one.

    insert: changes the HTML of viser's page. Raises Unavailable if the address is not available
    (viser would silently use the next port) or if viser lacks a required attribute.
    """
    access = access or Access()
    if access.listener:
        port = access.listener.getsockname()[1]
    else:
        with listening_sockets(access.host, access.port) as (first, *_):
            port = first.getsockname()[1]
    logging.getLogger("websockets.server").setLevel(logging.CRITICAL)  # browsers may disconnect
    guard = connection.Guard(replace(access, port=port), insert)
    with viser_server(access.host, port, guard.serve) as server:
        if server.get_port() != port:
            raise Unavailable(f"port {port} was taken a moment ago: choose another with --port")
        yield server


def self_test(server: viser.ViserServer, access: Access) -> None:
    """Test the protection of a server that has just been started, by attacks.

    If an attack succeeds, raises Unavailable if other machines can reach the server, else writes a
    line to the log.
    """

    def wait_until_left() -> None:
        """Wait until no connection of the test is counted as a visitor."""
        deadline, count = time.monotonic() + COUNT_TIMEOUT, access.visitor_count
        while count.counts[count.process] and time.monotonic() < deadline:
            time.sleep(0.005)

    def connect() -> socket.socket:
        """A connection to the server, one at a time."""
        wait_until_left()
        if access.listener:
            return access.listener.connect_to_self()
        host = {"0.0.0.0": "127.0.0.1", "::": "::1"}.get(access.host, access.host)
        return socket.create_connection((host, access.port), TIMEOUT)

    with connection.log.muted():
        try:
            failure = successful_attack(access, connect)
        except (OSError, WebSocketException) as error:
            failure = f"no connection: {error}"
        wait_until_left()
    if type(server).request_share_url is viser.ViserServer.request_share_url:
        failure = "viser's public tunnel can be opened"
    if failure and access.shared:
        raise Unavailable(f"self-test of the protection: {failure}: not served beyond this machine")
    if failure:
        connection.log.warn("self-test of the protection", failure, failure)


def successful_attack(access: Access, connect: Callable[[], socket.socket]) -> str:
    """Try to connect from a foreign page and without the key, and to send invalid messages. Returns
    a description of the attack that succeeded, or ""."""
    urls = (access.local_url, replace(access, public="").url)
    uri, keyed = (url.replace("http://", "ws://") for url in urls)
    keyless: dict[str, Any] = {"uri": uri, "subprotocols": [PROTOCOL], "open_timeout": TIMEOUT}
    key = keyless | {"uri": keyed}
    attacks: dict[str, tuple[dict[str, Any], bytes]] = {
        "a page of a foreign origin": (key | {"origin": FOREIGN_ORIGIN}, b""),
        "a message that no page sends": (key, b"\xc1"),
        "a request for a public tunnel": (key, b"\x81\xa4type\xafShareUrlRequest"),
    }
    if access.visitor_key:
        attacks["a visitor without the key"] = (keyless, b"")
    for name, (options, message) in attacks.items():
        try:
            with unix_connect(sock=connect(), **options) as line:
                if not message:
                    return f"{name} can connect"
                line.send(message)
                while True:
                    line.recv(TIMEOUT)
        except InvalidStatus as error:
            if message or error.response.status_code != 403:
                return f"{name} gets status {error.response.status_code}"
        except ConnectionClosed as closed:
            if closed.rcvd is None or closed.rcvd.code != connection.POLICY_VIOLATION:
                return f"{name} closes the connection with an unexpected code"
        except TimeoutError:
            return f"{name} gets no answer within {TIMEOUT:g} s"
    return ""
