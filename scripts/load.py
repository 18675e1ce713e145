"""Load test: visitors at once, each dragging the speed slider of its own scene.

Starts the explorer with all its processes, connects WebSocket clients to it (a browser would add
its own drawing), and prints rows of (key, value, unit): frames per second of the visitor with the
fewest, time from an edit to the frame with its table, cost of the server and of the clients on the
same machine, and growth of the server's memory. With `--visitors 1` it measures the delay of one
visitor, with `--bent` on a beam past buckling. Run it on a machine that does nothing else:

    python scripts/load.py [--visitors 60] [--seconds 60] [--processes 2] [--resolves 20000]
                           [--bent]
"""

import asyncio
import math
import os
import random
import re
import subprocess
import sys
import time
from collections import deque
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import _script
import msgspec.msgpack
import numpy as np
import zstandard
from live.server import CAMERA_MESSAGE, PROTOCOL  # type: ignore[import-not-found]
from websockets.asyncio.client import ClientConnection, connect

from beamviz.beam import Beam
from beamviz.drawing.text import rounded_to_error
from beamviz.solver import solve

PICTURE = b"/scene/rotor/ends\xa7updates"
TABLE = rb"aria-label=\"modes\""  # in JSON
CELL = re.compile(r">([\d.]+)<")
BRIDGE = re.compile(rb'"bridge": ?"([^"]+)"')
EDITS = 20  # per second, as a browser sends them while a slider is dragged
CONNECTING = 60.0  # [s] at most, until all visitors have their page
SETTLING = 5.0  # [s] before anything is measured
SERVE = """
from beamviz.beam import Beam
from beamviz.explorer import serve
from beamviz.scene import Scene
scene = Scene(Beam(**{numbers}), {{"state": "{state}"}})
serve(scene, port=0, visitors={visitors}, processes={processes})
"""
Row = tuple[str, float, str]


class Drag(NamedTuple):
    """What the visitors drag: a beam, the state that is solved for, and the speeds of the edits. No
    two are the same, so that a late table is not mistaken for that of an earlier edit."""

    beam: Beam
    state: str
    speeds: list[float]


STRAIGHT = Drag(
    Beam(alpha=1, beta=0.5, gamma=10),
    "straight",
    [round(10 + 0.1 * k + 0.01 * drag, 2) for drag in range(10) for k in range(100)],
)
BENT = Drag(Beam(gamma=4, delta=-1), "stable", [round(4 + 0.02 * k, 2) for k in range(100)])


@dataclass
class Visitor:
    """A client without a browser: its unanswered edits, and the frames and answers it received.
    An edit is answered by its own table or that of a later edit."""

    pace: float = 1 / EDITS  # [s] between two edits
    speeds: list[float] = field(default_factory=list)
    bridge: str = ""  # the control that takes actions
    actions: int = 0
    frames: int = 0
    received: int = 0  # [bytes]
    waiting: deque[tuple[int, float]] = field(default_factory=deque)  # edit and time sent
    latencies: list[float] = field(default_factory=list)  # of every edit
    answers: list[float] = field(default_factory=list)  # of edits with a table of their own
    unpacker: zstandard.ZstdDecompressor = field(default_factory=zstandard.ZstdDecompressor)

    async def visit(self, url: str, texts: dict[str, int]) -> None:
        """Connect, drag the slider and receive until cancelled; OSError if the server ends it."""
        place = url.replace("http://", "ws://")
        async with connect(place, subprotocols=[PROTOCOL], compression=None, max_size=None) as line:
            await line.send(msgspec.msgpack.encode(CAMERA_MESSAGE))
            dragging = asyncio.create_task(self.drag(line))
            try:
                async for data in line:
                    assert isinstance(data, bytes)
                    self.receive(data, texts)
                raise OSError(f"the server closed a connection: {line.close_reason}")
            finally:
                dragging.cancel()

    async def drag(self, line: ClientConnection) -> None:
        """Move the slider up, again and again, from a random value on."""
        while not self.bridge:
            await asyncio.sleep(self.pace)
        k = random.randrange(len(self.speeds))
        while True:
            await asyncio.sleep(self.pace)
            k = (k + 1) % len(self.speeds)
            self.waiting.append((k, time.perf_counter()))
            self.actions += 1
            updates = {"value": f'[{self.actions}, "gamma", {self.speeds[k]}]'}
            message = {"type": "GuiUpdateMessage", "uuid": self.bridge, "updates": updates}
            await line.send(msgspec.msgpack.encode(message))

    def receive(self, data: bytes, texts: dict[str, int]) -> None:
        """Count frames, and find the edit that a new table answers. Messages are searched, not
        decoded: the visitors share the machine with the server."""
        size = int.from_bytes(data[8:16], "little")
        group = self.unpacker.decompress(data[16 : 16 + size])
        self.received += len(data)
        self.frames += PICTURE in group
        if TABLE in group:
            self.answered(group[group.index(TABLE) :].decode(errors="replace"), texts)
        if found := BRIDGE.search(group):
            self.bridge = found[1].decode()

    def answered(self, content: str, texts: dict[str, int]) -> None:
        """Record the edit that a table answers, found by its first frequency."""
        now = time.perf_counter()
        found = next((texts[t] for t in CELL.findall(content) if t in texts), None)
        if found is not None and found in [k for k, _ in self.waiting]:
            seen = None
            while seen != found:
                seen, sent = self.waiting.popleft()
                self.latencies.append(now - sent)
            self.answers.append(now - sent)


def first_frequencies(drag: Drag) -> dict[str, int]:
    """The number of each edit by the text of the first frequency of its table."""
    beams = [drag.beam.replace(gamma=speed) for speed in drag.speeds]
    solutions = [solve(beam, state=drag.state) for beam in beams]
    texts = [rounded_to_error(s.frequencies[0], s.errors[0]) for s in solutions]
    return {text: k for k, text in enumerate(texts)}


async def measure(
    url: str, drag: Drag, visitors: list[Visitor], seconds: float, pid: int, resolves: int = 0
) -> list[Row]:
    """Connect all visitors, let them settle, and measure for `seconds` and at least `resolves`
    answers."""
    texts = first_frequencies(drag)
    async with asyncio.TaskGroup() as group:
        visits = [group.create_task(visitor.visit(url, texts)) for visitor in visitors]
        async with asyncio.timeout(CONNECTING):
            while not all(visitor.bridge for visitor in visitors):
                await asyncio.sleep(0.1)
        await asyncio.sleep(SETTLING)
        for visitor in visitors:
            visitor.frames, visitor.received, visitor.latencies, visitor.answers = 0, 0, [], []
        began, spent, before, own = time.perf_counter(), cpu(pid), memory(pid), time.process_time()
        await asyncio.sleep(seconds)
        while sum(len(visitor.answers) for visitor in visitors) < resolves:
            await asyncio.sleep(1.0)
        took, spent = time.perf_counter() - began, cpu(pid) - spent
        frames = sum(visitor.frames for visitor in visitors)
        rows = summary(visitors, took) + [
            ("server CPU", 100 * spent / took, "% of a core"),
            ("server CPU per frame", 1000 * spent / max(frames, 1), "ms"),
            ("clients' CPU", 100 * (time.process_time() - own) / took, "% of a core"),
            ("processes", len(process_tree(pid)), ""),
            ("memory", memory(pid), "MB"),
            ("memory growth", 100 * (memory(pid) / before - 1), "%"),
            ("load of the machine", os.getloadavg()[0], ""),
        ]
        for visit in visits:
            visit.cancel()
    return rows


def summary(visitors: list[Visitor], took: float) -> list[Row]:
    """Frames and latencies of the visitors."""
    rates = [visitor.frames / took for visitor in visitors]
    waits = [1000 * wait for visitor in visitors for wait in visitor.latencies] or [math.nan]
    own = [1000 * wait for visitor in visitors for wait in visitor.answers] or [math.nan]
    return [
        ("visitors", len(visitors), ""),
        ("fewest frames", min(rates), "1/s"),
        ("median frames", np.median(rates), "1/s"),
        ("most frames", max(rates), "1/s"),
        ("traffic", sum(v.received for v in visitors) / len(visitors) / took / 1000, "kB/s each"),
        ("re-solves seen", sum(len(visitor.answers) for visitor in visitors), ""),
        ("every edit to update, median", np.median(waits), "ms"),
        ("every edit to update, 95 %", np.percentile(waits, 95), "ms"),
        ("edit to its own update, median", np.median(own), "ms"),
        ("edit to its own update, 95 %", np.percentile(own, 95), "ms"),
    ]


def process_tree(pid: int) -> list[int]:
    """A process and its running descendants."""
    children = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    return [pid, *(one for child in children for one in process_tree(int(child)))]


def cpu(pid: int) -> float:
    """Processor time [s] of a process and its descendants."""
    stats = [Path(f"/proc/{one}/stat").read_text() for one in process_tree(pid)]
    fields = [stat.rpartition(")")[2].split() for stat in stats]
    return sum(int(field) for one in fields for field in one[11:13]) / os.sysconf("SC_CLK_TCK")


def memory(pid: int) -> float:
    """Memory [MB] of a process and its descendants; shared memory counts once."""
    maps = [Path(f"/proc/{one}/smaps_rollup").read_text() for one in process_tree(pid)]
    return sum(int(size) for text in maps for size in re.findall(r"^Pss: +(\d+)", text, re.M)) / 1e3


def main() -> None:
    """Measure, and print the rows."""
    parser = _script.Parser(__doc__)
    parser.add_argument("--visitors", type=_script.count, default=60)
    parser.add_argument("--seconds", type=_script.count, default=60)
    parser.add_argument("--processes", type=_script.count, default=len(os.sched_getaffinity(0)))
    parser.add_argument("--resolves", type=_script.count, default=0, help="answers, at least")
    parser.add_argument("--bent", action="store_true", help="measure on a beam past buckling")
    options = parser.parse_args()
    drag = BENT if options.bent else STRAIGHT
    serve = SERVE.format(**vars(options), numbers=drag.beam.numbers, state=drag.state)
    command = [sys.executable, "-c", serve]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=_script.ROOT) as process:
        try:
            assert process.stdout
            url = next(w for w in process.stdout.readline().split() if w.startswith("http"))
            visitors = [Visitor(speeds=drag.speeds) for _ in range(options.visitors)]
            measured = measure(url, drag, visitors, options.seconds, process.pid, options.resolves)
            for key, value, unit in asyncio.run(measured):
                _script.print_row(key, float(value), unit)
        finally:
            process.terminate()


if __name__ == "__main__":
    main()
