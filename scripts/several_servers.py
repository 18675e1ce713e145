"""Several servers behind one address: spread visitors, kill a server, see who comes back.

Starts servers with one shared key behind HAProxy with assets/haproxy.cfg (its addresses changed),
connects visitors (WebSocket clients, each with a beam of its own in its address), kills one server,
and prints rows of (key, value, unit): visitors of each server, the time until those of the killed
one have their beam again, requests without the key that were let in, memory, processor time. Needs
Linux and HAProxy (Debian: apt install haproxy).

    python scripts/several_servers.py [--visitors 150]
"""

import asyncio
import contextlib
import http.client
import os
import secrets
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import _script
import msgspec.msgpack
import zstandard
from live.server import CAMERA_MESSAGE, PROTOCOL, free_port  # type: ignore[import-not-found]
from load import BRIDGE, CELL, STRAIGHT, TABLE, cpu, first_frequencies, memory
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidHandshake

NAMES = ("one", "two", "three")  # of the servers in the configuration
HOST = "beams.example.org"  # in the configuration
CONNECTING = 120.0  # [s] at most, until all visitors have their beam
WATCHING = 10.0  # [s]
PAUSE = 0.2  # [s] between two attempts to connect; viser's page takes 1 s
SERVE = (
    "serve --host 127.0.0.1 --port {port} --public-url http://localhost:{public} --key-file {key}"
)
Servers = dict[str, subprocess.Popen[str]]  # by their names


class Visitor:
    """A page without a browser: its cookies, and the beam in its address."""

    def __init__(self, port: int, gamma: float, text: str):
        beam = STRAIGHT.beam
        self.address = f"alpha={beam.alpha}&beta={beam.beta}&gamma={gamma}"
        self.port, self.text = port, text  # of its first frequency
        self.cookies: dict[str, str] = {}
        self.has_beam = asyncio.Event()
        self.since = 0.0  # when it had its beam last
        self.received = 0  # [bytes]

    @property
    def server(self) -> str:
        """The name of its server."""
        return self.cookies.get("server", "")

    def open_page(self, key: str) -> None:
        """Open the link, and the page that it leads to."""
        for path in (f"/?token={key}&{self.address}", f"/?{self.address}"):
            status, cookies = request(self.port, path, self.cookies)
            self.cookies |= cookies
        assert status == 200, f"the page is answered with {status}"

    async def stay(self) -> None:
        """Be connected, and connect again whenever the connection ends, until cancelled."""
        while True:
            with contextlib.suppress(OSError, ConnectionClosed, InvalidHandshake):
                await self.visit()
            self.has_beam.clear()
            await asyncio.sleep(PAUSE)

    async def visit(self) -> None:
        """Connect, send the address, and receive."""
        header = {"Cookie": "; ".join(f"{name}={value}" for name, value in self.cookies.items())}
        place = f"ws://localhost:{self.port}"
        options = {"subprotocols": [PROTOCOL], "compression": None, "max_size": None}
        async with connect(place, additional_headers=header, **options) as line:  # type: ignore[arg-type]
            assert line.response
            self.cookies |= received_cookies(line.response.headers.get_all("Set-Cookie"))
            await line.send(msgspec.msgpack.encode(CAMERA_MESSAGE))
            await self.receive(line)

    async def receive(self, line: ClientConnection) -> None:
        """Send the address as soon as the page can take it, and wait for the table of the beam."""
        unpacker, linked = zstandard.ZstdDecompressor(), False
        async for data in line:
            assert isinstance(data, bytes)
            self.received += len(data)
            group = unpacker.decompress(data[16 : 16 + int.from_bytes(data[8:16], "little")])
            if not linked and (found := BRIDGE.search(group)):
                updates = {"value": f'[1, "link", "?{self.address}"]'}
                message = {"type": "GuiUpdateMessage", "uuid": found[1].decode()}
                await line.send(msgspec.msgpack.encode(message | {"updates": updates}))
                linked = True
            table = group[group.index(TABLE) :].decode(errors="replace") if TABLE in group else ""
            if self.text in CELL.findall(table) and not self.has_beam.is_set():
                self.since = time.perf_counter()
                self.has_beam.set()


def received_cookies(lines: list[str]) -> dict[str, str]:
    """Names and values of cookies from the headers that set them."""
    pairs = (line.partition(";")[0].partition("=") for line in lines)
    return {name: value for name, _, value in pairs}


def request(port: int, path: str, cookies: dict[str, str]) -> tuple[int, dict[str, str]]:
    """Status and cookies of a page."""
    line = http.client.HTTPConnection("localhost", port, timeout=30)
    with contextlib.closing(line):
        cookie = "; ".join(f"{name}={value}" for name, value in cookies.items())
        line.request("GET", path, headers={"Cookie": cookie} if cookie else {})
        answer = line.getresponse()
        answer.read()
        return answer.status, received_cookies(answer.headers.get_all("Set-Cookie") or [])


@contextlib.contextmanager
def running(visitors: int) -> Iterator[tuple[int, str, Servers]]:
    """Servers behind a proxy: its port, the key, and the servers by their names."""
    public, key = free_port(), secrets.token_urlsafe(16)
    text = (_script.ROOT / "assets" / "haproxy.cfg").read_text()
    text = text.replace("bind :8080", f"bind 127.0.0.1:{public}").replace(
        HOST, f"localhost:{public}"
    )
    with contextlib.ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        (folder / "key").write_text(key)
        servers = {}
        for number, name in enumerate(NAMES, 1):
            port = free_port()
            text = text.replace(f"127.0.0.1:808{number}", f"127.0.0.1:{port}")
            options = SERVE.format(port=port, public=public, key=folder / "key").split()
            options += ["--processes", "1", "--visitors", str(visitors)]
            servers[name] = start(stack, [sys.executable, "-m", "beamviz", *options])
        for server in servers.values():
            assert server.stdout
            server.stdout.readline()  # its link: it is ready
        (folder / "haproxy.cfg").write_text(text)
        start(stack, ["haproxy", "-db", "-f", str(folder / "haproxy.cfg")])
        time.sleep(3)  # of its first health checks
        yield public, key, servers


def start(stack: contextlib.ExitStack, command: list[str]) -> subprocess.Popen[str]:
    """A process that is ended with the stack."""
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=_script.ROOT)
    stack.enter_context(process)
    stack.callback(process.kill)
    return process


async def measure(port: int, key: str, servers: Servers, count: int) -> None:
    """Connect the visitors, kill the second server, and print the rows."""
    texts = list(first_frequencies(STRAIGHT))
    visitors = [Visitor(port, STRAIGHT.speeds[k], texts[k]) for k in range(count)]
    async with asyncio.TaskGroup() as group:
        stays = []
        for visitor in visitors:
            await asyncio.to_thread(visitor.open_page, key)
            stays.append(group.create_task(visitor.stay()))
        await all_have_beam(visitors)
        spread = Counter(visitor.server for visitor in visitors)
        for name in NAMES:
            _script.print_row(f"visitors of server {name}", spread[name], "")
            _script.print_row("its memory", memory(servers[name].pid), "MB")
        await watch(visitors, servers)
        lost = [visitor for visitor in visitors if visitor.server == NAMES[1]]
        servers[NAMES[1]].kill()
        killed = time.perf_counter()
        await asyncio.sleep(0.1)
        await all_have_beam(lost)
        waits = sorted(visitor.since - killed for visitor in lost)
        _script.print_row("visitors of the killed server", len(lost), "")
        _script.print_row("beam again: median", waits[len(waits) // 2], "s")
        _script.print_row("beam again: last", waits[-1], "s")
        spread = Counter(visitor.server for visitor in visitors)
        _script.print_row("visitors by server afterwards", str(dict(spread)))
        wrong = [{}, {"beamviz": "a-wrong-key-of-22-characters"}, {"server": "one"}]
        admitted = [request(port, "/", dict(cookies))[0] != 403 for cookies in wrong]
        _script.print_row("let in without the key", sum(admitted), f"of {len(admitted)}")
        for stay in stays:
            stay.cancel()


async def watch(visitors: list[Visitor], servers: Servers) -> None:
    """What visitors cost who only watch their beams vibrate."""
    spent = sum(cpu(server.pid) for server in servers.values())
    received = sum(visitor.received for visitor in visitors)
    await asyncio.sleep(WATCHING)
    spent = sum(cpu(server.pid) for server in servers.values()) - spent
    received = sum(visitor.received for visitor in visitors) - received
    _script.print_row("processor time, watching", 100 * spent / WATCHING, "% of a core")
    _script.print_row("traffic", received / len(visitors) / WATCHING / 1000, "kB/s each")


async def all_have_beam(visitors: list[Visitor]) -> None:
    """Wait until all visitors have their beam; TimeoutError after CONNECTING."""
    async with asyncio.timeout(CONNECTING):
        await asyncio.gather(*(visitor.has_beam.wait() for visitor in visitors))


def main() -> None:
    """Start, measure, and end all."""
    parser = _script.Parser(__doc__)
    parser.add_argument("--visitors", type=_script.count, default=150)
    options = parser.parse_args()
    if not shutil.which("haproxy"):
        parser.error("HAProxy is missing: apt install haproxy")
    with running(options.visitors) as (port, key, servers):
        asyncio.run(measure(port, key, servers, options.visitors))
    _script.print_row("load of the machine", os.getloadavg()[0], "")


if __name__ == "__main__":
    main()
