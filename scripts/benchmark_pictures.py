"""Times of pictures and films: python scripts/benchmark_pictures.py

A picture and films as whole processes, from a cold start, and frames within one process; best of
several. Run it on a machine that does nothing else.
"""

import io
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from _arguments import Parser  # noqa: E402

from beamviz.exports import PNG_LEVEL, Renderer, SolvedScene  # noqa: E402
from beamviz.scene import Scene  # noqa: E402

REPEATS = 3
SCENE = ["--alpha", "1", "--beta", "0.5", "--gamma", "10"]


def main() -> None:
    """Print the times and sizes."""
    with tempfile.TemporaryDirectory() as folder:
        for command, name in (("screenshot", "a.png"), *(("animate", f"a.{s}") for s in FORMATS)):
            path = Path(folder) / name
            run = [sys.executable, "-m", "beamviz", command, str(path), *SCENE]
            seconds = best(partial(subprocess.run, run, cwd=ROOT, check=True))
            print(f"{command} {name}: {seconds:.2f} s, {path.stat().st_size / 1e6:.2f} MB")
    solved = SolvedScene(Scene.of(alpha=1, beta=0.5, gamma=10))
    print(f"picture of 1280x720 in a batch: {best(lambda: write_picture(solved)):.3f} s")
    with ThreadPoolExecutor(2) as pool:
        seconds = best(lambda: list(pool.map(write_picture, [solved] * 6))) / 6
    print(f"the same on two threads: {seconds:.3f} s")
    for width, height in ((640, 360), (800, 450)):
        frame = best(partial(render_frame, solved, Renderer(solved, width, height)))
        print(f"frame of {width}x{height}, one thread: {frame:.3f} s")


def write_picture(solved: SolvedScene) -> None:
    """One picture, encoded."""
    Renderer(solved, 1280, 720).picture(solved.moment()).save(
        io.BytesIO(), "PNG", compress_level=PNG_LEVEL
    )


def render_frame(solved: SolvedScene, renderer: Renderer) -> None:
    """One frame of a film."""
    renderer.picture(solved.moment())


FORMATS = ("gif", "webp", "mp4")


def best(work: Callable[[], object]) -> float:
    """The shortest time [s] of several."""
    times = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return min(times)


if __name__ == "__main__":
    Parser(__doc__).parse_args()
    main()
