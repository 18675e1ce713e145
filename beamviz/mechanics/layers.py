"""Where a rotating beam needs thin elements, and of which order: read off its scales.

Tension N against bending makes layers of width 1 / sqrt(N f^(2c-3)) at the clamp and on both
sides of a concentrated mass; where the tension runs out, at a free tip, bending takes over
within (N')^(-1/3). Gauss points crowd at the ends of an element, so order p resolves layers
down to about 1/p^2 of it; only thinner ones get an element of their own.
"""

import math
from itertools import pairwise

import numpy as np

from beamviz.beam import Beam

LAYER_REACH = 12.0  # widths: exp(-12) of a layer is left where its element ends
TIP_REACH = 4.0
GRADING = 6.0  # ratio of neighbouring elements where the stretch falls off
THINNEST = 100.0  # an element this many times as long as its layer is still resolved by order
MAX_ORDER = 24


def discretisation(
    beam: Beam, modes: int, tolerance: float, stretch: float = 1.0, power: int = 3
) -> tuple[tuple[float, ...], int]:
    """Breaks and order that should meet `tolerance` for the lowest `modes` bending modes.

    `stretch` is a typical f, 1 for a beam that hardly stretches.
    """
    breaks = _breaks(beam, stretch, power)
    longest = max(b - a for a, b in pairwise(breaks))
    waves = 1.86 * modes * longest
    pieces = math.ceil(waves / 16)
    digits = -math.log10(tolerance)
    order = waves / pieces - 0.55 + 0.85 * digits
    layers = [
        5 + 1.5 * math.sqrt((b - a) / width)
        for a, b in pairwise(breaks)
        for width in (_width(beam, a, +1, stretch, power), _width(beam, b, -1, stretch, power))
        if width < (b - a) <= THINNEST * width
    ]
    order = max(order, *(layer * digits / 6 for layer in layers), 4)
    return _divided(breaks, pieces), min(math.ceil(order), MAX_ORDER)


def tension(beam: Beam, x: float, side: int, stretch: float) -> float:
    """N at x (just left or right of it: side -1 or +1) for a beam of uniform stretch."""
    N = stretch * (1 - x * x) / 2 + beam.delta * (1 - x)
    if x < beam.beta or (x == beam.beta and side < 0):
        N += beam.alpha * (stretch * beam.beta + beam.delta)
    return beam.gamma**2 * N


def _width(beam: Beam, x: float, side: int, stretch: float, power: int) -> float:
    """Width of the bending layer at x."""
    N = tension(beam, x, side, stretch)
    if x == 1.0 and not N:
        return math.inf
    return 1 / math.sqrt(N * stretch ** (2 * power - 3)) if N > 0 else math.inf


def _breaks(beam: Beam, stretch: float, power: int) -> tuple[float, ...]:
    """Ends of the elements: the clamp, the mass, the tip, and layers too thin for order."""
    interior = beam.alpha > 0 and 0 < beam.beta < 1
    ends = (0.0, beam.beta, 1.0) if interior else (0.0, 1.0)
    breaks = set(ends)
    for a, b in pairwise(ends):
        length = b - a
        left = _width(beam, a, +1, stretch, power)
        if THINNEST * left < length:
            breaks.add(a + LAYER_REACH * left)
        right = _width(beam, b, -1, stretch, power)
        if b < 1 and THINNEST * right < length:
            breaks.add(b - LAYER_REACH * right)
        breaks |= _grading(beam, a, b, stretch)
    breaks |= _tip(beam, ends[-2], stretch)
    return tuple(float(x) for x in np.unique(list(breaks)))


def _tip(beam: Beam, start: float, stretch: float) -> set[float]:
    """A break near the free tip, where the tension runs out and bending takes over."""
    slope = beam.gamma**2 * (stretch + beam.delta)
    if slope <= 0:
        return set()
    reach = TIP_REACH * slope ** (-1 / 3)
    return {1 - reach} if 8 * reach < 1 - start else set()


def _grading(beam: Beam, a: float, b: float, stretch: float) -> set[float]:
    """Breaks towards b where a large stretch falls off: f ~ N^(1/3) has its singularity just
    beyond b, as far as the force n needs to fall to -0.2, its least value."""
    slope = beam.gamma**2 * (stretch * b + beam.delta)
    if slope <= 0:
        return set()
    distance = (tension(beam, b, -1, stretch) + 0.2 * beam.mu**2) / slope
    breaks = set()
    while GRADING * distance < b - a:
        breaks.add(b - distance)
        distance *= GRADING
    return breaks


def _divided(breaks: tuple[float, ...], pieces: int) -> tuple[float, ...]:
    """Each element in equal pieces."""
    if pieces == 1:
        return breaks
    inner = [a + (b - a) * i / pieces for a, b in pairwise(breaks) for i in range(pieces)]
    return (*inner, breaks[-1])
