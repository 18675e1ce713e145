"""A viser server as it comes, to show what the explorer's is protected from, and raw requests."""

import contextlib
import http.client
import io
import socket
import time
from collections.abc import Callable, Iterator
from typing import Any

import msgspec.msgpack
import viser
import websockets.exceptions
from websockets.sync.client import connect
from websockets.sync.connection import Connection

PROTOCOL = f"viser-v{viser.__version__}"
EVIL = "http://evil.example"
CAMERA = {
    "type": "ViewerCameraMessage",
    "wxyz": (1.0, 0.0, 0.0, 0.0),
    "position": (0.0, -3.0, 2.0),
    "fov": 0.4,
    "near": 0.01,
    "far": 1000.0,
    "image_height": 720,
    "image_width": 1280,
    "look_at": (0.0, 0.0, 0.0),
    "up_direction": (0.0, 0.0, 1.0),
}


def free_port(host: str = "127.0.0.1") -> int:
    """A port nobody listens on."""
    with socket.socket() as probe:
        probe.bind((host, 0))
        return int(probe.getsockname()[1])


@contextlib.contextmanager
def bare(host: str = "127.0.0.1") -> Iterator[viser.ViserServer]:
    """viser's own server."""
    with contextlib.redirect_stdout(io.StringIO()):
        server = viser.ViserServer(host=host, port=free_port(host), verbose=False)
    try:
        yield server
    finally:
        with contextlib.redirect_stdout(io.StringIO()):
            server.stop()


def address(server: viser.ViserServer) -> str:
    """Where a server of viser's is."""
    return f"http://127.0.0.1:{server.get_port()}"


@contextlib.contextmanager
def wire(url: str, path: str = "", **options: Any) -> Iterator[Connection]:
    """A bare WebSocket, as anybody can open one."""
    with connect(
        url.replace("http://", "ws://").split("/?")[0] + path,
        subprotocols=[PROTOCOL],  # type: ignore[list-item]
        compression=None,
        max_size=None,
        **options,
    ) as socket_:
        yield socket_


def packed(**message: Any) -> bytes:
    """One message as it goes over the wire."""
    return msgspec.msgpack.encode(message)


def closed(url: str, message: bytes | str, **options: Any) -> int:
    """Send a message; the code with which the explorer ends the connection."""
    with wire(url, **options) as line:
        line.send(packed(**CAMERA))
        line.send(message)
        with contextlib.suppress(websockets.exceptions.ConnectionClosed):
            while True:
                line.recv(timeout=10)
        return line.close_code or 0


def arrived(server: viser.ViserServer) -> None:
    """Wait until viser knows a visitor."""
    until(server.get_clients)


def until(done: Callable[[], Any], timeout: float = 40.0) -> Any:
    """Wait until something is true; its value."""
    end = time.monotonic() + timeout
    while not (value := done()):
        if time.monotonic() > end:
            raise TimeoutError("it never came true")
        time.sleep(0.02)
    return value


def got(url: str, path: str = "/", **headers: str) -> tuple[int, dict[str, str], bytes]:
    """Status, headers and body of a plain request; Host as given, if it is."""
    place = url.removeprefix("http://").split("/")[0]
    caller = http.client.HTTPConnection(place, timeout=10)
    try:
        caller.putrequest("GET", path, skip_host="Host" in headers, skip_accept_encoding=True)
        for name, value in headers.items():
            caller.putheader(name, value)
        caller.endheaders()
        reply = caller.getresponse()
        return reply.status, dict(reply.getheaders()), reply.read()
    finally:
        caller.close()


def loose(headers: dict[str, str]) -> set[str]:
    """What the headers of an answer leave a page, or tell of the server, against the rules."""
    rules = {
        "X-Frame-Options": "DENY",
        "X-Content-Type-Options": "nosniff",
        "Referrer-Policy": "no-referrer",
    }
    found = {name for name, value in rules.items() if headers.get(name) != value}
    policy = headers.get("Content-Security-Policy", "")
    if not all(words in policy for words in ("default-src 'none'", "frame-ancestors 'none'")):
        found.add("Content-Security-Policy")
    return found | headers.keys() & {"Server"}
