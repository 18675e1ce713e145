"""A lecture hall: many visitors, each with a scene of their own, all dragging the same slider.

Starts the explorer with all its processes, connects real WebSocket clients to it (without
browsers: what a browser adds is its own drawing), and prints rows of (key, value, unit): frames a
second of the visitor who gets fewest, how soon an edit is seen, what the server costs, what the
clients cost on the same machine, and how the memory of the server grows. Run it on a machine that
does nothing else:

    python scripts/load.py [--visitors 60] [--seconds 60] [--processes 2] [--resolves 20000]
"""

import argparse
import asyncio
import math
import os
import random
import re
import statistics
import subprocess
import sys
import time
from collections import deque
from dataclasses import dataclass, field
from pathlib import Path

import msgspec.msgpack
import zstandard
from websockets.asyncio.client import ClientConnection, connect

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

from live.server import CAMERA_MESSAGE, PROTOCOL  # type: ignore[import-not-found]  # noqa: E402

from beamviz.beam import Beam  # noqa: E402
from beamviz.drawing.text import rounded_to_error  # noqa: E402
from beamviz.solver import solve  # noqa: E402

SLIDER = "speed γ"
PICTURE, TABLE, CELL = (
    b"/scene/rotor/ends\xa7updates",
    b'aria-label="modes"',
    re.compile(r">([\d.]+)<"),
)
EDITS = 20  # a second, as a browser sends them while a slider is dragged
SPEEDS = [round(10 + 0.1 * k, 1) for k in range(100)]
SETTLING = 5.0  # [s] before anything is measured
START = Beam(alpha=1, beta=0.5, gamma=10)
SERVE = """
import sys
from beamviz.beam import Beam
from beamviz.scene import Scene
from beamviz.explorer.app import serve
visitors, processes = map(int, sys.argv[1:])
scene = Scene(Beam(alpha=1, beta=0.5, gamma=10))
serve(scene, port=0, visitors=visitors, processes=processes)
"""
Row = tuple[str, float, str]


@dataclass
class Guest:
    """One visitor: the edits that wait to be seen, and what came back. An edit is seen when its
    answer comes, or that of a later one."""

    pace: float = 1 / EDITS  # [s] between two edits; infinite: only watching
    slider: str = ""
    frames: int = 0
    solved: int = 0
    waiting: deque[tuple[int, float]] = field(default_factory=deque)  # which, and since when
    latencies: list[float] = field(default_factory=list)  # of every edit
    answers: list[float] = field(default_factory=list)  # of those that had an answer of their own
    unpacker: zstandard.ZstdDecompressor = field(default_factory=zstandard.ZstdDecompressor)

    async def visit(self, url: str, texts: dict[str, int]) -> None:
        """Come, drag and watch until cancelled."""
        place = url.replace("http://", "ws://")
        async with connect(place, subprotocols=[PROTOCOL], compression=None, max_size=None) as line:
            await line.send(msgspec.msgpack.encode(CAMERA_MESSAGE))
            dragging = asyncio.create_task(self.drag(line))
            try:
                async for data in line:
                    assert isinstance(data, bytes)
                    self.take(data, texts)
            finally:
                dragging.cancel()

    async def drag(self, line: ClientConnection) -> None:
        """Move the slider up, again and again, each guest from another place."""
        k = random.randrange(len(SPEEDS))
        while True:
            await asyncio.sleep(self.pace)
            if self.slider:
                k = (k + 1) % len(SPEEDS)
                edit = {"uuid": self.slider, "updates": {"value": SPEEDS[k]}}
                self.waiting.append((k, time.perf_counter()))
                await line.send(msgspec.msgpack.encode({"type": "GuiUpdateMessage", **edit}))

    def take(self, data: bytes, texts: dict[str, int]) -> None:
        """Count pictures, and see which edit a new table answers. Messages are searched, not
        decoded: the guests share the machine with the server."""
        size = int.from_bytes(data[8:16], "little")
        group = self.unpacker.decompress(data[16 : 16 + size])
        self.frames += PICTURE in group
        if TABLE in group:
            self.answered(group[group.index(TABLE) :].decode(errors="replace"), texts)
        if not self.slider:
            self.look_for_slider(group)

    def look_for_slider(self, group: bytes) -> None:
        """The control to drag, once it has come."""
        for message in msgspec.msgpack.decode(group)["messages"]:
            if message.get("props", {}).get("label") == SLIDER:
                self.slider = message["uuid"]

    def answered(self, content: str, texts: dict[str, int]) -> None:
        """A table has come: the edit it answers, by its first frequency."""
        now = time.perf_counter()
        found = next((texts[t] for t in CELL.findall(content) if t in texts), None)
        if found is not None and found in [k for k, _ in self.waiting]:
            self.solved += 1
            seen = None
            while seen != found:
                seen, sent = self.waiting.popleft()
                self.latencies.append(now - sent)
            self.answers.append(now - sent)


def first_frequencies() -> dict[str, int]:
    """Which edit a table answers: the text of its first frequency."""
    solutions = [solve(START.replace(gamma=speed)) for speed in SPEEDS]
    return {rounded_to_error(s.frequencies[0], s.errors[0]): k for k, s in enumerate(solutions)}


async def hall(
    url: str, guests: list[Guest], seconds: float, pid: int, resolves: int = 0
) -> list[Row]:
    """Let all guests in, let them drag, and measure after a while: for so many seconds, and until
    they have seen so many re-solves."""
    texts = first_frequencies()
    visits = [asyncio.create_task(guest.visit(url, texts)) for guest in guests]
    while not all(guest.slider for guest in guests):
        await asyncio.sleep(0.1)
    await asyncio.sleep(SETTLING)
    for guest in guests:
        guest.frames, guest.solved, guest.latencies, guest.answers = 0, 0, [], []
    began, spent, before, own = time.perf_counter(), cpu(pid), memory(pid), time.process_time()
    await asyncio.sleep(seconds)
    while sum(guest.solved for guest in guests) < resolves:
        await asyncio.sleep(1.0)
    took, spent = time.perf_counter() - began, cpu(pid) - spent
    rows = summary(guests, took) + [
        ("server CPU", 100 * spent / took, "% of a core"),
        ("server CPU per frame", 1000 * spent / max(sum(g.frames for g in guests), 1), "ms"),
        ("clients' CPU", 100 * (time.process_time() - own) / took, "% of a core"),
        ("processes", len(family(pid)), ""),
        ("memory", memory(pid), "MB"),
        ("memory growth", 100 * (memory(pid) / before - 1), "%"),
        ("load of the machine", os.getloadavg()[0], ""),
    ]
    for visit in visits:
        visit.cancel()
    await asyncio.gather(*visits, return_exceptions=True)
    return rows


def summary(guests: list[Guest], took: float) -> list[Row]:
    """What the guests saw."""
    rates = [guest.frames / took for guest in guests]
    waits = sorted(1000 * wait for guest in guests for wait in guest.latencies) or [math.nan]
    own = sorted(1000 * wait for guest in guests for wait in guest.answers) or [math.nan]
    return [
        ("visitors", len(guests), ""),
        ("fewest frames", min(rates), "1/s"),
        ("median frames", statistics.median(rates), "1/s"),
        ("most frames", max(rates), "1/s"),
        ("re-solves seen", sum(guest.solved for guest in guests), ""),
        ("every edit to update, median", statistics.median(waits), "ms"),
        ("every edit to update, 95 %", waits[int(0.95 * (len(waits) - 1))], "ms"),
        ("edit to its own update, 95 %", own[int(0.95 * (len(own) - 1))], "ms"),
    ]


def family(pid: int) -> list[int]:
    """A process and all it has started that run."""
    children = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    return [pid, *(one for child in children for one in family(int(child)))]


def cpu(pid: int) -> float:
    """Processor time [s] of a process and all it has started."""
    stats = [Path(f"/proc/{one}/stat").read_text() for one in family(pid)]
    fields = [stat.rpartition(")")[2].split() for stat in stats]
    return sum(int(field) for one in fields for field in one[11:13]) / os.sysconf("SC_CLK_TCK")


def memory(pid: int) -> float:
    """Memory [MB] of a process and all it has started; what they share counts once."""
    maps = [Path(f"/proc/{one}/smaps_rollup").read_text() for one in family(pid)]
    return (
        sum(
            int(line.split()[1]) for m in maps for line in m.splitlines() if line.startswith("Pss:")
        )
        / 1e3
    )


def main() -> None:
    """Measure, and print the rows."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--visitors", type=int, default=60)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--processes", type=int, default=len(os.sched_getaffinity(0)))
    parser.add_argument("--resolves", type=int, default=0, help="go on until so many are seen")
    options = parser.parse_args()
    command = [sys.executable, "-c", SERVE, str(options.visitors), str(options.processes)]
    alone = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}  # as `beamviz serve` has it
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, text=True, cwd=ROOT, env=alone
    ) as process:
        try:
            assert process.stdout
            url = next(w for w in process.stdout.readline().split() if w.startswith("http"))
            guests = [Guest() for _ in range(options.visitors)]
            measured = hall(url, guests, options.seconds, process.pid, options.resolves)
            for key, value, unit in asyncio.run(measured):
                print(f"{key:<28} {value:10.2f} {unit}")
        finally:
            process.terminate()


if __name__ == "__main__":
    main()
