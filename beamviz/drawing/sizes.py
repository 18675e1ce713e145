"""The sizes that a beam is drawn with: its sections along the span, and the bodies on it.

A beam has stiffnesses, not dimensions. It is drawn as a solid rectangular section that has them, at
its place in the hub's frame whatever plane it moves in:

    size in the plane of rotation ~ sqrt(bending / axial),    out of it ~ sqrt(flap / axial)

where flap is bending if it is not given. A section with thin walls has another area than that,
axial. Its sizes are then the geometric mean of those and of such as have its area.
"""

import math
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from beamviz.beam import Beam
from beamviz.blade import Blade, Mass
from beamviz.si import INEXTENSIBLE

VISIBLE_THICKNESS = 0.04
SLENDER = 100.0
LARGER = (0.01, 0.2)  # [beam lengths] least and largest of the larger size
RELATIVE_SIZES = (0.25, 2.0)  # of a section over that of the root: the tip of a taper is visible
COLLAR_LENGTH = 0.9  # over its radius, unless the mass is too small for that
COLLAR_HEIGHT = 0.62  # least radius, over the diagonal of the section that it encloses
BOX_HEIGHT = 1.4  # least size of a box across the beam, over the section that it encloses
BOX_SIZES = (0.03, 0.25)  # [beam lengths] least size along the beam, largest size
NO_MASS = 1e-12  # in place of a mass of 0 that has an inertia


def section_size(
    beam: Beam, thicken: bool = False, plane: str = "chordwise"
) -> tuple[float, float]:
    """At the root, thickness in the plane of motion and breadth along its normal; in both planes
    those in the plane of rotation and along its normal, before the section is turned. h = sqrt(12)
    / mu in the plane of rotation, of an inextensible beam, whose size is not known, as with
    SLENDER. They have their true proportion, unless the larger one would be
    above LARGER."""
    h = math.sqrt(12) / (SLENDER if beam.mu == INEXTENSIBLE else beam.mu)
    flap = beam.blade.flap[0] if beam.blade and beam.blade.flap else beam.flap
    small, large = sorted((h, h * math.sqrt(flap)))
    larger = max(1.0, LARGER[0] / large, VISIBLE_THICKNESS / small if thicken else 0.0)
    small, large = larger * small, larger * large
    large = min(large, max(small, LARGER[1]))
    is_flat = flap < 1  # its larger size is in the plane of rotation
    return (small, large) if is_flat == (plane == "flapwise") else (large, small)


def relative_sections(blade: Blade, plane: str, x: NDArray, inboard: bool = False) -> NDArray:
    """Thickness and breadth (n, 2) at x (n,) over those at the root, within RELATIVE_SIZES; where
    they jump, as in `Blade.at`."""
    at = np.append(0.0, x)
    names = ("flap", "bending") if plane == "flapwise" else ("bending", "flap")
    axial, moving, other = (blade.at(name, at, inboard) for name in ("axial", *names))
    sizes = np.sqrt(np.stack([moving, other], 1) / axial[:, None])
    sizes *= (axial / sizes.prod(axis=1))[:, None] ** 0.25
    return np.clip(sizes[1:] / sizes[0], *RELATIVE_SIZES)


def sections(beam: Beam, plane: str, x: NDArray, thicken: bool = False) -> NDArray:
    """Thickness and breadth at the start and the end of each piece between x (n,), (n - 1, 2, 2).
    Those of neighbours differ where the section jumps."""
    sizes = np.empty((len(x) - 1, 2, 2))
    sizes[:] = section_size(beam, thicken, plane)
    if beam.blade:
        starts = relative_sections(beam.blade, plane, x[:-1])
        ends = relative_sections(beam.blade, plane, x[1:], inboard=True)
        sizes *= np.stack([starts, ends], 1)
    return sizes


def turns(beam: Beam, x: NDArray) -> NDArray:
    """The angles (n,) [rad] of the section at x (n,) about the axis of the beam, from the plane of
    rotation towards its axis."""
    degrees = beam.pitch + beam.twist * x
    if beam.blade and beam.blade.twist:
        degrees = degrees + beam.blade.at("twist", x)
    return np.radians(degrees)


def jumps(beam: Beam) -> list[float]:
    """Where its section jumps: the stations named twice between root and tip."""
    x = beam.blade.x if beam.blade else ()
    return [here for here, there in pairwise(x) if 0 < here == there < 1]


def drawn_bodies(beam: Beam) -> tuple[Mass, ...]:
    """The concentrated mass, if there is one, and then `Beam.masses`."""
    return (*((Mass(beam.alpha, beam.beta),) if beam.alpha > 0 else ()), *beam.masses)


def local_section(
    beam: Beam, body: Mass, thicken: bool = False, plane: str = "chordwise"
) -> tuple[float, float]:
    """The section that a body encloses, where it jumps the larger one."""
    thickness, breadth = section_size(beam, thicken, plane)
    if beam.blade is None:
        return thickness, breadth
    x = np.array([body.beta])
    sides = [relative_sections(beam.blade, plane, x, inboard)[0] for inboard in (False, True)]
    larger = np.maximum(*sides)
    return thickness * larger[0], breadth * larger[1]


def collar_size(
    beam: Beam, body: Mass, thicken: bool = False, plane: str = "chordwise"
) -> tuple[float, float]:
    """Length and radius of a body without inertia, a collar around the beam with the density of
    the beam: its volume is alpha times that of a uniform beam."""
    section = local_section(beam, body, thicken, plane)
    inside = math.prod(section)  # area of the hole
    volume = body.alpha * math.prod(section_size(beam, thicken, plane))
    radius = max(
        (volume / (COLLAR_LENGTH * math.pi)) ** (1 / 3), COLLAR_HEIGHT * math.hypot(*section)
    )
    return volume / (math.pi * radius**2 - inside), radius


def box_size(
    beam: Beam, body: Mass, thicken: bool = False, plane: str = "chordwise"
) -> tuple[float, float, float]:
    """Sizes of a body with inertia along the beam, across it in the plane of rotation, and along
    the axis: the box of its mass and inertia, a^2 = 6 (Jy + Jz - Jx) / m, which encloses the
    beam and is not larger than can be shown."""
    section = local_section(beam, body, thicken, plane)
    y, z = section[::-1] if plane == "flapwise" else section
    least = (BOX_SIZES[0], BOX_HEIGHT * y, BOX_HEIGHT * z)
    total, mass = sum(body.inertia), max(body.alpha, NO_MASS)
    squares = (6 * (total - 2 * J) / mass for J in body.inertia)
    a, b, c = (
        max(min(math.sqrt(max(square, 0.0)), BOX_SIZES[1]), low)
        for square, low in zip(squares, least, strict=True)
    )
    return a, b, c


def has_box(body: Mass) -> bool:
    """Whether a body is drawn as a box."""
    return any(body.inertia)


def reach(beam: Beam, body: Mass) -> float:
    """The distance from the centre of a body that contains it."""
    return max(box_size(beam, body)) / 2 if has_box(body) else max(collar_size(beam, body))


def largest_reach(beam: Beam) -> float:
    """That of the largest body, 0 without bodies."""
    return max((reach(beam, body) for body in drawn_bodies(beam)), default=0.0)


def largest_height(beam: Beam) -> float:
    """Half the height of the largest body above the plane of rotation, 0 without bodies."""
    heights = (
        box_size(beam, body)[2] / 2 if has_box(body) else collar_size(beam, body)[1]
        for body in drawn_bodies(beam)
    )
    return max(heights, default=0.0)
