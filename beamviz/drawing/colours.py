"""Colour-blind-safe colours: colour maps of displacement and strain, and colours of objects."""

from typing import Any

import numpy as np

from beamviz.drawing.modes import SampledModes, axial_strain

RGB = tuple[int, int, int]

HUB: RGB = (150, 160, 176)
ROTATION: RGB = (64, 132, 190)
MASS: RGB = (84, 92, 110)
NODE: RGB = (204, 60, 140)
GRIP: RGB = (240, 140, 30)  # what is to be taken by the hand
GHOST: RGB = (140, 148, 160)
BEFORE: RGB = (122, 124, 214)
TENSION: RGB = (236, 148, 92)  # of the band of forces, and below 0
COMPRESSION: RGB = (90, 150, 208)
FORCES: dict[str, RGB] = {  # arrows, by their kinds
    "pull": (213, 84, 0),
    "softening": (150, 80, 200),
    "Coriolis": (0, 160, 235),
    "Euler": (0, 150, 110),
}
ENERGIES: dict[str, RGB] = {  # by their kinds
    "kinetic": (86, 108, 190),
    "strain": (34, 158, 134),
    "centrifugal": (213, 84, 0),
}
GRID: RGB = (140, 146, 156)
# For light and dark: background of the scene (as in page.css), floor, text.
BACKGROUND: tuple[RGB, RGB] = ((244, 246, 248), (15, 18, 20))
FLOOR: tuple[RGB, RGB] = ((255, 255, 255), (62, 67, 75))
LETTERS: tuple[RGB, RGB] = ((27, 32, 38), (233, 236, 239))
GREYED: RGB = (165, 168, 174)

# Displacement, from 0: blue, teal, yellow (the bright part of viridis).
SEQUENTIAL = (
    (62, 84, 150),
    (44, 120, 142),
    (34, 158, 134),
    (94, 200, 98),
    (186, 222, 40),
    (253, 231, 37),
)
# Strain, from compression to tension: blue, grey, vermilion.
DIVERGING = ((16, 84, 168), (90, 150, 208), (204, 206, 208), (236, 148, 92), (204, 76, 2))
MAPS = {"displacement": SEQUENTIAL, "axial strain": DIVERGING}
STEPS = 4096  # of a tabulated colour map: finer than one level of a byte


def mapped(values: np.ndarray, anchors: tuple[RGB, ...]) -> np.ndarray:
    """sRGB colours (n, 3) in 0 .. 255 for values (n,) in 0 .. 1, by interpolation of `anchors`."""
    at = np.linspace(0.0, 1.0, len(anchors))
    return np.stack([np.interp(values, at, channel) for channel in np.transpose(anchors)], 1)


def instanced(colours: Any) -> np.ndarray:
    """sRGB colours in 0 .. 255 as bytes of linear light, which only instanced meshes require."""
    return np.rint(255 * linear(colours)).astype(np.uint8)


def linear(colours: Any) -> np.ndarray:
    """sRGB colours in 0 .. 255 as linear light in 0 .. 1."""
    share = np.asarray(colours) / 255
    return np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)


def painted(shapes: SampledModes, name: str, moved: np.ndarray, largest: float) -> np.ndarray:
    """Colours (n - 1, 3), bytes of linear light, of a beam displaced by `moved` (n, c)."""
    places = scaled(shapes, name, moved, largest) * (STEPS - 1) + 0.5
    return PALETTES[name][places.astype(int).clip(0, STEPS - 1)]


def scaled(shapes: SampledModes, name: str, moved: np.ndarray, largest: float) -> np.ndarray:
    """Positions (n - 1,) in 0 .. 1 on the colour map, for a beam displaced by `moved` (n, c)."""
    if name == "axial strain":
        return 0.5 + 0.5 * axial_strain(shapes, moved) / largest
    middle = moved[:-1] + moved[1:]
    return np.linalg.norm(middle, axis=1) / (2 * largest)


# The colour maps as bytes (STEPS, 3) of linear light.
PALETTES = {
    name: instanced(mapped(np.linspace(0.0, 1.0, STEPS), anchors)) for name, anchors in MAPS.items()
}
