"""Servers under test (viser's own, `beamviz serve` as a process), and raw requests to them."""

import contextlib
import http.client
import http.server
import io
import os
import random
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import msgspec.msgpack
import viser
import websockets.exceptions
from websockets.sync.client import connect
from websockets.sync.connection import Connection

from beamviz.solver import interruption

ROOT = Path(__file__).resolve().parents[2]
TIMEOUT = 60.0  # [s] of what is quick, on a machine however busy
PROTOCOL = f"viser-v{viser.__version__}"
CAMERA_MESSAGE: dict[str, Any] = {"type": "ViewerCameraMessage", "wxyz": (1.0, 0.0, 0.0, 0.0)}
CAMERA_MESSAGE |= {"position": (0.0, -3.0, 2.0), "look_at": (0.0, 0.0, 0.0)}
CAMERA_MESSAGE |= {"up_direction": (0.0, 0.0, 1.0), "fov": 0.4, "near": 0.01, "far": 1000.0}
CAMERA_MESSAGE |= {"image_height": 720, "image_width": 1280}


MEANWHILE: list[Callable[[], Any]] = []  # what has to go on while a test waits


def free_port(host: str = "127.0.0.1") -> int:
    """A port that is not in use: below those that the system gives out, and another for each worker
    of the tests, so that no other server takes it before this one starts."""
    worker = int(os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw")) % 8
    for _ in range(100):
        port = 8 * random.SystemRandom().randrange(2500, 4000) + worker
        with socket.socket() as probe, contextlib.suppress(OSError):
            probe.bind((host, port))
            return port
    raise OSError(f"no free port of {host}")


@cache
def first_port() -> int:
    """A port that was free when this process first asked for one."""
    return free_port()


def usual_port() -> int:
    """The same port each time, unless it is in use: a browser that has loaded a page from it before
    loads another in half the time."""
    with socket.socket() as probe, contextlib.suppress(OSError):
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        probe.bind(("127.0.0.1", first_port()))
        return first_port()
    return free_port()


@contextlib.contextmanager
def plain_viser_server(host: str = "127.0.0.1") -> Iterator[viser.ViserServer]:
    """An unprotected server of viser, for comparison."""
    with contextlib.redirect_stdout(io.StringIO()):
        server = viser.ViserServer(host=host, port=free_port(host), verbose=False)
    try:
        yield server
    finally:
        with contextlib.redirect_stdout(io.StringIO()):
            server.stop()


@contextlib.contextmanager
def website(content: str) -> Iterator[str]:
    """The address of a page with this content on localhost, which is another site than 127.0.0.1:
    a notebook, to which our page in it is foreign."""

    class Answer(http.server.BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(200)
            self.send_header("Content-Type", "text/html; charset=utf-8")
            self.end_headers()
            self.wfile.write(content.encode())

        def log_message(self, *_: Any) -> None:
            """Nothing on stderr."""

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Answer) as site:
        thread = threading.Thread(target=site.serve_forever)
        thread.start()
        try:
            yield f"http://localhost:{site.server_port}/"
        finally:
            site.shutdown()
            thread.join()


def url_of(server: viser.ViserServer) -> str:
    """The URL of a viser server."""
    return f"http://127.0.0.1:{server.get_port()}"


@contextlib.contextmanager
def raw_socket(url: str, path: str = "", **options: Any) -> Iterator[Connection]:
    """A WebSocket of viser's protocol without a client behind it."""
    usual = {"compression": None, "max_size": None, "subprotocols": [PROTOCOL]}
    usual |= {"open_timeout": TIMEOUT, "ping_timeout": TIMEOUT}
    usual["max_queue"] = None  # a reader that never pauses: a socket closes at once
    address = url.replace("http://", "ws://").split("/?")[0] + path
    with connect(address, **usual | options) as opened:
        yield opened


def handshake_status(url: str, path: str = "", **options: Any) -> int:
    """The status of a WebSocket's handshake: 101 where it opens."""
    try:
        with raw_socket(url, path, **options):
            return 101
    except websockets.exceptions.InvalidStatus as error:
        return error.response.status_code


def encoded(**message: Any) -> bytes:
    """One message as bytes of the protocol."""
    return msgspec.msgpack.encode(message)


def close_code(url: str, message: bytes | str, **options: Any) -> int:
    """The code with which the explorer closes the connection after a message."""
    with raw_socket(url, **options) as line:
        line.send(encoded(**CAMERA_MESSAGE))
        line.send(message)
        end = time.monotonic() + TIMEOUT  # of a moving scene, where the connection stays open
        with contextlib.suppress(websockets.exceptions.ConnectionClosed):
            while time.monotonic() < end:
                line.recv(timeout=TIMEOUT)
        return line.close_code or 0


def wait_until(done: Callable[[], Any], timeout: float = TIMEOUT, about: str = "") -> Any:
    """Wait until `done` returns a true value; that value. MEANWHILE is called while it waits."""
    end = time.monotonic() + timeout
    while not (value := done()):
        if time.monotonic() > end:
            raise TimeoutError(f"not true within {timeout:g} s{about}")
        for call in MEANWHILE:
            call()
        if not MEANWHILE:
            time.sleep(0.02)
    return value


def last_until(event: threading.Event) -> None:
    """Last until an event, as a long calculation: it can be interrupted."""
    while not event.wait(0.01):
        interruption.get()()


def held_back(compute: Callable[..., Any], event: threading.Event) -> Callable[..., Any]:
    """A function that computes the same, but not before an event."""

    def late(*given: Any, **options: Any) -> Any:
        last_until(event)
        return compute(*given, **options)

    return late


def frame_loop_at(url: str, loops: list[Any]) -> Any:
    """The frame loop of the explorer at a URL, which others may have had before."""
    return [loop for loop in loops if url.endswith(f":{loop.server.get_port()}")][-1]


def latest(loops: list[Any]) -> Any:
    """The session that began last, of the explorer that was started last."""
    sessions = loops[-1].sessions
    return sessions[max(sessions)]


def http_get(url: str, path: str = "/", **headers: str) -> tuple[int, dict[str, str], bytes]:
    """Status, headers and body of a GET request; a Host header replaces the usual one."""
    place = url.removeprefix("http://").split("/")[0]
    with contextlib.closing(http.client.HTTPConnection(place, timeout=TIMEOUT)) as caller:
        caller.putrequest("GET", path, skip_host="Host" in headers, skip_accept_encoding=True)
        for name, value in headers.items():
            caller.putheader(name, value)
        caller.endheaders()
        reply = caller.getresponse()
        return reply.status, dict(reply.getheaders()), reply.read()


def missing_headers(headers: dict[str, str]) -> set[str]:
    """Security headers that are missing or wrong, and headers that reveal the server."""
    rules = {"X-Frame-Options": "DENY", "X-Content-Type-Options": "nosniff"}
    rules["Referrer-Policy"] = "no-referrer"
    found = {name for name, value in rules.items() if headers.get(name) != value}
    policy = headers.get("Content-Security-Policy", "")
    if not all(words in policy for words in ("default-src 'none'", "frame-ancestors 'none'")):
        found.add("Content-Security-Policy")
    return found | headers.keys() & {"Server"}


def python(folder: Path, *arguments: str, **settings: Any) -> subprocess.Popen:
    """A Python process with a folder of its own for temporary files, which may hold modules."""
    settings |= {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    env = {**os.environ, "PYTHONPATH": f"{ROOT}:{folder}", "TMPDIR": str(folder)}
    return subprocess.Popen([sys.executable, *arguments], env=env, **settings)


class ServeProcess:
    """A running `beamviz serve`, with its own folder for temporary files."""

    def __init__(self, folder: Path, *options: str, processes: int = 2):
        self.port = free_port()
        command = ["-m", "beamviz", "serve", "--alpha", "1", "--beta", "0.5", "--gamma", "10"]
        options += ("--port", str(self.port), "--processes", str(processes))
        self.process = python(folder, *command, *options)

    def __enter__(self) -> "ServeProcess":
        assert self.process.stdout
        line = self.process.stdout.readline()
        self.url = next(word for word in line.split() if word.startswith("http"))
        self.began = time.monotonic()  # its workers have
        return self

    def __exit__(self, *_: object) -> None:
        with self.process:
            self.process.terminate()

    @property
    def workers(self) -> list[int]:
        """The pids of its worker processes."""
        pid = self.process.pid
        return list(map(int, Path(f"/proc/{pid}/task/{pid}/children").read_text().split()))


def is_alive(pid: int) -> bool:
    """Whether a process exists and is no zombie."""
    with contextlib.suppress(OSError):
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    return False


def handles_sigterm(pid: int) -> bool:
    """Whether a process has set its handler of SIGTERM, as it does in its first line."""
    status = Path(f"/proc/{pid}/status").read_text()
    (line,) = [line for line in status.splitlines() if line.startswith("SigCgt")]
    return bool(int(line.split()[1], 16) & 1 << (signal.SIGTERM - 1))
