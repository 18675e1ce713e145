"""Files made of a scene: pictures, films, a page that plays offline, a 3D model, numbers."""

import math
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from beamviz.beam import check_float, check_int
from beamviz.errors import InvalidInput
from beamviz.exports.film import ENCODERS
from beamviz.exports.gltf import write_glb
from beamviz.exports.html_page import write_html
from beamviz.exports.renderer import open_renderer, over_background
from beamviz.exports.solved_scene import Direction, Loop, SolvedScene, find_loop
from beamviz.files import check_suffix, replaced
from beamviz.output import field_arrays, fields_csv
from beamviz.scene import Scene

PIXELS = (64, 4096)  # width and height of a picture
FRAME_RATES = (5.0, 50.0)  # [1/s]; the limit of GIF
MAX_FRAMES = 1000


def export(path: str | Path, scene: Scene) -> None:
    """Write a scene as a file of the format its suffix names.

    .html: one page with film, chart and table that needs no network; .glb: an animated 3D model;
    .csv, .npz: frequencies, shapes and equilibrium (see `beamviz.output.field_arrays`).

    Raises InvalidInput, Unavailable, and the errors of `solve`; the file is complete or untouched.
    """
    path = Path(path)
    write = WRITERS[check_suffix(path, tuple(WRITERS))]
    with replaced(path) as file:
        write(file, SolvedScene.of(scene))


def write_csv(file: Path, solved: SolvedScene) -> None:
    """Equilibrium and modes along the beam, one line for each mode and station."""
    file.write_text(fields_csv(solved.solution))


def write_npz(file: Path, solved: SolvedScene) -> None:
    """Equilibrium and modes along the beam as arrays."""
    arrays: dict[str, Any] = field_arrays(solved.solution)
    with file.open("wb") as stream:  # given a path, numpy would add a suffix
        np.savez_compressed(stream, **arrays)


WRITERS: dict[str, Callable[[Path, SolvedScene], None]] = {
    ".html": write_html,
    ".glb": write_glb,
    ".csv": write_csv,
    ".npz": write_npz,
}


def screenshot(
    path: str | Path,
    scene: Scene,
    width: int = 1280,
    height: int = 720,
    phase: float = 0.25,
    transparent: bool = False,
    direction: Direction | None = None,
    zoom: float = 1.0,
) -> None:
    """Write a scene as a PNG of `width` by `height` pixels, each 64 .. 4096.

    phase: of the first mode shown, in periods; 0.25 is its largest displacement. direction: from
    the middle of the scene to the camera, in place of the scene's camera; zoom: 0.1 .. 100.

    Raises InvalidInput, Unavailable, and the errors of `solve`; the file is complete or untouched.
    """
    path = Path(path)
    check_suffix(path, [".png"])
    size = check_int("width", width, *PIXELS), check_int("height", height, *PIXELS)
    if not math.isfinite(phase):
        raise InvalidInput(f"phase = {phase}: must be finite")
    with replaced(path) as file:
        solved = SolvedScene.of(scene, direction, zoom)
        with open_renderer(solved, *size, supersampling=2) as render:
            picture = render(solved.moment(solved.time(phase)))
        if not transparent:
            picture = over_background(picture, scene.view)
        Image.fromarray(picture).save(file, "PNG")


def animate(
    path: str | Path,
    scene: Scene,
    width: int = 800,
    height: int = 450,
    fps: float = 25.0,
    periods: int | None = None,
    direction: Direction | None = None,
    zoom: float = 1.0,
    progress: Callable[[int], Iterable[int]] = range,
) -> Loop:
    """Write a scene as a seamless film: .gif, .webp or .mp4, by the suffix.

    fps: frames per second, 5 .. 50 (a GIF rounds to hundredths of a second per frame); periods: of
    the first mode shown, by default as few as make a seamless loop; progress: yields the numbers
    0 .. n - 1 of n frames as they are rendered; width, height, direction, zoom: as in `screenshot`.

    Raises InvalidInput, Unavailable, and the errors of `solve`; the file is complete or untouched.
    """
    path = Path(path)
    encoder = ENCODERS[check_suffix(path, tuple(ENCODERS))]
    size = check_int("width", width, *PIXELS), check_int("height", height, *PIXELS)
    fps = encoder.nearest_rate(check_float("fps", fps, *FRAME_RATES))
    encoder.check(*size)
    periods = None if periods is None else check_int("periods", periods, 1, MAX_FRAMES)
    with replaced(path) as file:
        solved = SolvedScene.of(scene, direction, zoom)
        loop = find_loop(solved, periods)
        count = round(loop.seconds * fps)
        if count > MAX_FRAMES:
            raise InvalidInput(
                f"the film has {count} frames: must be at most {MAX_FRAMES}; ask for fewer"
                " periods, a lower fps or a higher pace"
            )
        with open_renderer(solved, *size) as render:

            def frames(numbers: Iterable[int]) -> Iterator[np.ndarray]:
                for k in numbers:
                    yield over_background(render(loop.moment(k / count)), scene.view)

            sample = frames(np.linspace(0, count, encoder.sample, endpoint=False).astype(int))
            encoder.write(file, frames(progress(count)), fps, list(sample))
    return loop
