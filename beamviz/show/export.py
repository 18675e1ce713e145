"""The scene as a picture in a file."""

import contextlib
import math
import os
import queue
import sys
import time
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np
from PIL import Image  # which comes with matplotlib
from viser import ClientHandle
from viser.transforms import SO3

from beamviz.beam import Beam
from beamviz.errors import InvalidInput, Unavailable
from beamviz.mechanics.solve import solve
from beamviz.show import camera
from beamviz.show.browser import found_browser, opened
from beamviz.show.controls import MODES, Look
from beamviz.show.figure import drawn
from beamviz.show.hosting import hosted
from beamviz.show.motion import Shapes, Still
from beamviz.show.scene import Scene
from beamviz.show.words import unstable

DEADLINE = 90.0  # [s]; a software renderer needs about 5
PIXELS = (64, 4096)
BACKGROUND = (255, 255, 255)


def screenshot(
    path: str | Path,
    beam: Beam,
    options: dict,
    width: int = 1280,
    height: int = 720,
    mode: int = 1,
    phase: float = 0.25,
    transparent: bool = False,
) -> None:
    """Write the scene of `beam` as a PNG: mode number `mode` at `phase` of its period (0.25 is
    its largest displacement), through a browser, or through matplotlib where there is none.

    options: keywords of `solve`. Raises InvalidInput, Unavailable, and what `solve` raises;
    the file is either complete or untouched.
    """
    for name, pixels in (("width", width), ("height", height)):
        if not PIXELS[0] <= pixels <= PIXELS[1]:
            raise InvalidInput(f"{name} = {pixels}: must lie in {PIXELS[0]} .. {PIXELS[1]}")
    if not math.isfinite(phase):
        raise InvalidInput(f"phase = {phase}: must be finite")
    if mode < 1:
        raise InvalidInput(f"mode = {mode}: must be 1 or more")
    with replaced(Path(path)) as file:
        solution = solve(beam, **{"modes": max(mode, MODES), **options})
        still = Still(Shapes.sampled(solution), mode - 1, phase, unstable(solution))
        if browser := found_browser():
            picture = photograph(browser, still, width, height)
        else:
            print(
                "beamviz: no browser found (set BEAMVIZ_BROWSER), drawn by matplotlib",
                file=sys.stderr,
            )
            picture = drawn(still, width, height, Look.amplitude)
        Image.fromarray(picture if transparent else opaque(picture)).save(file, "PNG")


@contextlib.contextmanager
def replaced(path: Path) -> Iterator[Path]:
    """A temporary file beside `path` that takes its place once it is complete."""
    if path.suffix.lower() != ".png":
        raise InvalidInput(f"{path}: must end in .png")
    if path.is_dir():
        raise Unavailable(f"cannot write {path}: it is a folder")
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        part.open("xb").close()
        yield part
        part.replace(path)
    except OSError as error:
        raise Unavailable(f"cannot write {path}: {error.strerror or error}") from None
    finally:
        part.unlink(missing_ok=True)


def photograph(browser: str, still: Still, width: int, height: int) -> np.ndarray:
    """The scene (height, width, 4) as `browser` renders it, at twice the size and averaged."""
    deadline = time.monotonic() + DEADLINE
    clients: queue.Queue[ClientHandle] = queue.Queue()
    with hosted(pictures=True) as server:
        scene = Scene(server.scene)
        scene.show(still.shapes, Look(), [still.mode], words=still.words)
        scene.move(still.phases, still.amplitudes(Look.amplitude), angle=0.0)
        server.on_client_connect(clients.put)
        with opened(browser, f"http://127.0.0.1:{server.get_port()}/?fixedDpr=1", 320, 240):
            try:
                client = clients.get(timeout=DEADLINE)
                return rendered(client, still.shapes, width, height, deadline)
            except (queue.Empty, TimeoutError, RuntimeError):
                raise Unavailable(
                    f"{browser} drew no picture within {DEADLINE:g} s: name another browser in"
                    " BEAMVIZ_BROWSER, or none (BEAMVIZ_BROWSER=none) for matplotlib"
                ) from None


def rendered(
    client: ClientHandle, shapes: Shapes, width: int, height: int, deadline: float
) -> np.ndarray:
    """The client's picture (height, width, 4) from the usual viewpoint."""
    position = camera.viewpoint(shapes, riding=True, aspect=width / height)
    render = partial(
        client.get_render,
        position=position,
        wxyz=SO3.from_matrix(camera.axes(position)).wxyz,
        fov=camera.FIELD_OF_VIEW,
        transport_format="png",
    )
    for _ in range(2):  # labels and instanced bodies lag behind
        render(64, 64, timeout=max(deadline - time.monotonic(), 0.1))
    picture = render(2 * height, 2 * width, timeout=max(deadline - time.monotonic(), 0.1))
    return averaged(picture)


def averaged(picture: np.ndarray) -> np.ndarray:
    """A picture (2 h, 2 w, 4) at half its size, (h, w, 4), its edges smoothed."""
    height, width = picture.shape[0] // 2, picture.shape[1] // 2
    blocks = picture.reshape(height, 2, width, 2, 4).astype(float)
    alpha = blocks[..., 3:].mean(axis=(1, 3))
    colour = (blocks[..., :3] * blocks[..., 3:]).mean(axis=(1, 3)) / np.maximum(alpha, 1e-9)
    return np.rint(np.concatenate([colour, alpha], -1)).astype(np.uint8)


def opaque(picture: np.ndarray) -> np.ndarray:
    """A picture (h, w, 4) on the background, (h, w, 3)."""
    alpha = picture[..., 3:] / 255
    return np.rint(picture[..., :3] * alpha + np.array(BACKGROUND) * (1 - alpha)).astype(np.uint8)
