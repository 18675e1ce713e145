"""The scene as a picture in a file."""

import contextlib
import math
import os
import queue
import sys
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from time import monotonic

import numpy as np
from PIL import Image  # which comes with matplotlib
from viser import ClientHandle
from viser.transforms import SO3

from beamviz.beam import whole
from beamviz.errors import InvalidInput, Unavailable
from beamviz.look import Look
from beamviz.scene_file import Camera, SavedScene
from beamviz.show import camera
from beamviz.show.browser import found_browser, opened
from beamviz.show.figure import drawn
from beamviz.show.hosting import hosted
from beamviz.show.scene import Scene
from beamviz.show.shot import Shot

DEADLINE = 90.0  # [s]; a software renderer needs about 5
PIXELS = (64, 4096)
LIGHT, DARK = (255, 255, 255), (20, 20, 20)


def screenshot(
    path: str | Path,
    scene: SavedScene,
    width: int = 1280,
    height: int = 720,
    phase: float = 0.25,
    transparent: bool = False,
) -> None:
    """Write a scene as a PNG, its first mode shown at `phase` of its period (0.25 is its largest
    displacement), through a browser, or through matplotlib where there is none.

    Raises InvalidInput, Unavailable, and what `solve` raises; the file is either complete or
    untouched.
    """
    width, height = whole("width", width, *PIXELS), whole("height", height, *PIXELS)
    if not math.isfinite(phase):
        raise InvalidInput(f"phase = {phase}: must be finite")
    with replaced(Path(path)) as file:
        shot = Shot.of(scene)
        if browser := found_browser():
            picture = photograph(browser, shot, shot.time(phase), width, height)
        else:
            print(
                "beamviz: no browser found (set BEAMVIZ_BROWSER), drawn by matplotlib",
                file=sys.stderr,
            )
            picture = drawn(shot, shot.time(phase), width, height)
        Image.fromarray(picture if transparent else opaque(picture, scene.look)).save(file, "PNG")


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


def photograph(browser: str, shot: Shot, time: float, width: int, height: int) -> np.ndarray:
    """The scene (height, width, 4) as `browser` renders it, at twice the size and averaged."""
    deadline = monotonic() + DEADLINE
    clients: queue.Queue[ClientHandle] = queue.Queue()
    with hosted(pictures=True) as server:
        scene = Scene(server.scene)
        scene.show(shot.shapes, shot.scene.look, shot.shown, words=shot.words)
        scene.move(shot.phases(time), shot.amplitudes, shot.angle(time))
        server.on_client_connect(clients.put)
        dark = "&darkMode" if shot.scene.look.dark else ""
        with opened(browser, f"http://127.0.0.1:{server.get_port()}/?fixedDpr=1{dark}", 320, 240):
            try:
                client = clients.get(timeout=DEADLINE)
                return rendered(client, shot.camera(width / height), width, height, deadline)
            except (queue.Empty, TimeoutError, RuntimeError):
                raise Unavailable(
                    f"{browser} drew no picture within {DEADLINE:g} s: name another browser in"
                    " BEAMVIZ_BROWSER, or none (BEAMVIZ_BROWSER=none) for matplotlib"
                ) from None


def rendered(
    client: ClientHandle, view: Camera, width: int, height: int, deadline: float
) -> np.ndarray:
    """The client's picture (height, width, 4) from a viewpoint."""
    position, target = np.array(view.position), np.array(view.look_at)
    render = partial(
        client.get_render,
        position=position,
        wxyz=SO3.from_matrix(camera.axes(position - target)).wxyz,
        fov=camera.FIELD_OF_VIEW,
        transport_format="png",
    )
    for _ in range(2):  # labels and instanced bodies lag behind
        render(64, 64, timeout=max(deadline - monotonic(), 0.1))
    picture = render(2 * height, 2 * width, timeout=max(deadline - monotonic(), 0.1))
    return averaged(picture)


def averaged(picture: np.ndarray) -> np.ndarray:
    """A picture (2 h, 2 w, 4) at half its size, (h, w, 4), its edges smoothed."""
    height, width = picture.shape[0] // 2, picture.shape[1] // 2
    blocks = picture.reshape(height, 2, width, 2, 4).astype(float)
    alpha = blocks[..., 3:].mean(axis=(1, 3))
    colour = (blocks[..., :3] * blocks[..., 3:]).mean(axis=(1, 3)) / np.maximum(alpha, 1e-9)
    return np.rint(np.concatenate([colour, alpha], -1)).astype(np.uint8)


def opaque(picture: np.ndarray, look: Look) -> np.ndarray:
    """A picture (h, w, 4) on the background, (h, w, 3)."""
    alpha, ground = picture[..., 3:] / 255, np.array(DARK if look.dark else LIGHT)
    return np.rint(picture[..., :3] * alpha + ground * (1 - alpha)).astype(np.uint8)
