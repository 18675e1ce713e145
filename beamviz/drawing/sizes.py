"""How large things are drawn, in lengths of the beam."""

import math

from beamviz.beam import Beam

MIN_HUB = 0.05
VISIBLE_THICKNESS = 0.04
MASS_RADIUS = 0.08  # at alpha = 1


def section(beam: Beam, thicken: bool = False) -> tuple[float, float]:
    """Thickness in the plane of motion and breadth along its normal.

    The thickness is true: h = sqrt(12) / mu for a rectangle. The five numbers leave the
    breadth free; it is kept where it can be seen.
    """
    thickness = math.sqrt(12) / beam.mu
    if thicken:
        thickness = max(thickness, VISIBLE_THICKNESS)
    return thickness, min(max(1.5 * thickness, 0.05), 0.1)


def mass_radius(beam: Beam, thicken: bool = False) -> float:
    """Radius of the mass: its volume follows alpha, but it never hides inside the beam."""
    return max(MASS_RADIUS * beam.alpha ** (1 / 3), 0.8 * section(beam, thicken)[1])


def hub_radius(beam: Beam) -> float:
    """Radius of the hub: |delta|, but a small drum is left at delta = 0."""
    return max(abs(beam.delta), MIN_HUB)


def ground(beam: Beam) -> float:
    """Height of the ground below the beam."""
    return -max(0.3, 1.2 * mass_radius(beam)) if beam.alpha > 0 else -0.3
