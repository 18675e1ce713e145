"""A moment of a scene as a PNG."""

import math
from pathlib import Path

from PIL import Image

from beamviz.beam import check_int
from beamviz.errors import InvalidInput
from beamviz.exports.renderer import opaque, studio
from beamviz.exports.solved_scene import Direction, Shot
from beamviz.files import check_suffix, replaced
from beamviz.scene import Scene

PIXELS = (64, 4096)


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
    """Write a scene as a PNG, its first mode shown at `phase` of its period (0.25 is its largest
    displacement), through a browser, or through matplotlib where there is none.

    direction, zoom: where to look from, in place of the camera of the scene. Raises InvalidInput,
    Unavailable, and what `solve` raises; the file is either complete or untouched.
    """
    path = Path(path)
    check_suffix(path, [".png"])
    width, height = check_int("width", width, *PIXELS), check_int("height", height, *PIXELS)
    if not math.isfinite(phase):
        raise InvalidInput(f"phase = {phase}: must be finite")
    with replaced(path) as file:
        shot = Shot.of(scene, direction, zoom)
        with studio(shot, width, height, scale=2) as picture:
            taken = picture(shot.moment(shot.time(phase)))
        Image.fromarray(taken if transparent else opaque(taken, scene.view)).save(file, "PNG")
