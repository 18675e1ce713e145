"""Stored pictures, and how different two pictures look. `python tests/exports/pictures.py` makes
them anew: look at each before it is committed."""

from pathlib import Path

import numpy as np
from PIL import Image

from beamviz.beam import Beam
from beamviz.exports import Renderer
from beamviz.exports.solved_scene import SolvedScene
from beamviz.scene import Scene

REFERENCES = Path(__file__).with_name("references")
BLOCK = 5  # [pixels] over which a difference is averaged: edges of samples may move by rounding
SIZE = (480, 270)
SCENES = {
    "mass": Scene.of(Beam(alpha=1, beta=0.5, gamma=10), mode=2),
    "bent": Scene.of(Beam(gamma=4, delta=-1), state="bent", mode=1, dark=True),
    "unstable": Scene.of(Beam(gamma=5, delta=-1), rotating_frame=False),
    "all modes": Scene.of(Beam(gamma=5), all_modes=True, colouring="axial strain"),
}


def rendered(scene: Scene, size: tuple[int, int] = SIZE, **options: bool) -> np.ndarray:
    """A picture (h, w, 3 or 4), bytes."""
    solved = SolvedScene(scene)
    return np.asarray(Renderer(solved, *size).picture(solved.moment(), **options))


def stored(name: str) -> np.ndarray:
    """The stored picture (h, w, 3) of a scene, bytes."""
    return np.asarray(Image.open(REFERENCES / f"{name}.png"))


def difference(one: np.ndarray, other: np.ndarray) -> float:
    """The largest difference of two pictures (h, w, 3) in CIELAB, averaged over blocks: 2 can just
    be seen."""
    height, width = one.shape[0] // BLOCK * BLOCK, one.shape[1] // BLOCK * BLOCK
    shape = height // BLOCK, BLOCK, width // BLOCK, BLOCK, 3
    means = [lab(p[:height, :width]).reshape(shape).mean(axis=(1, 3)) for p in (one, other)]
    return float(np.linalg.norm(means[0] - means[1], axis=-1).max())


def lab(picture: np.ndarray) -> np.ndarray:
    """sRGB bytes (..., 3) in CIELAB."""
    c = picture / 255
    c = np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)
    xyz = c @ np.array(
        [[0.4339, 0.2126, 0.0178], [0.3762, 0.7152, 0.1095], [0.1899, 0.0722, 0.8727]]
    )
    f = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16 / 116)
    x, y, z = np.moveaxis(f, -1, 0)
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], -1)


if __name__ == "__main__":
    for name, scene in SCENES.items():
        Image.fromarray(rendered(scene)).save(REFERENCES / f"{name}.png", optimize=True)
