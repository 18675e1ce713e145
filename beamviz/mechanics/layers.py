"""Where a rotating beam needs thin elements, and of which order: read off its scales.

Tension N against bending makes layers of width 1 / sqrt(N f^(2c-3)) at the clamp and on both
sides of a concentrated mass; where the tension runs out, at a free tip, bending takes over
within (N')^(-1/3). Gauss points crowd at the ends of an element, so order p resolves layers
down to about 1/p^2 of it; only thinner ones get an element of their own.
"""

import math
from dataclasses import dataclass
from itertools import pairwise

from scipy.optimize import brentq

from beamviz.beam import Beam
from beamviz.mechanics.strain import Curvature, StrainLaw

LAYER_REACH = 12.0  # widths: exp(-12) of a layer is left where its element ends
TIP_REACH = 4.0
GRADING = 6.0  # ratio of neighbouring elements where the stretch falls off
THINNEST = 100.0  # an element up to this many times as long as its layer resolves it by order
WAVES_PER_ELEMENT = 9.0
MAX_ORDER = 24


@dataclass(frozen=True)
class Segment:
    """A part of the beam between clamp, mass and tip, with tension N and stretch f at its ends."""

    start: float
    end: float
    N: tuple[float, float]
    f: tuple[float, float]
    slope: float  # -dN/dx at its end

    @property
    def length(self) -> float:
        return self.end - self.start

    def layers(self, curvature: Curvature) -> tuple[float, float]:
        """Widths of the bending layers at its ends; infinite where there is no tension, and at
        the free tip, where nothing holds the rotation."""
        power = 2 * curvature.power - 3
        widths = [1 / math.sqrt(N * f**power) if N > 0 else math.inf for N, f in zip(self.N, self.f)]
        return widths[0], (widths[1] if self.end < 1 else math.inf)


def segments(beam: Beam, stretch: float, law: StrainLaw) -> list[Segment]:
    """The parts of a beam whose mean stretch is known (1 where it hardly stretches)."""
    interior = beam.alpha > 0 and 0 < beam.beta < 1
    ends = (0.0, beam.beta, 1.0) if interior else (0.0, 1.0)
    parts = []
    for a, b in pairwise(ends):
        N = (_tension(beam, stretch, a, beam.beta > a), _tension(beam, stretch, b, beam.beta >= b))
        f = (1.0, 1.0) if stretch == 1 else tuple(_stretch(law, n / beam.mu**2) for n in N)
        parts.append(Segment(a, b, N, f, beam.gamma**2 * (stretch * b + beam.delta)))
    return parts


def discretisation(
    parts: list[Segment], mu: float, modes: int, curvature: Curvature, tolerance: float
) -> tuple[tuple[float, ...], int]:
    """Breaks and order that should meet `tolerance` for the lowest `modes` modes."""
    breaks = {0.0, 1.0}
    for part in parts:
        breaks |= {part.start, *_layer_breaks(part, curvature), *_falling_breaks(part, mu)}
    breaks |= _tip_breaks(parts[-1])
    waves = _half_waves(mu, modes)
    ends = _spread(sorted(breaks), WAVES_PER_ELEMENT / waves)
    longest = max(b - a for a, b in pairwise(ends))
    digits = -math.log10(tolerance)
    order = 1.86 * waves * longest + 1.4 + 0.85 * digits
    for part in parts:
        for width in part.layers(curvature):
            if part.length <= THINNEST * width:
                order = max(order, (5 + 1.5 * math.sqrt(part.length / width)) * (0.4 + digits / 10))
    return tuple(ends), min(math.ceil(max(order, 4)), MAX_ORDER)


def _half_waves(mu: float, modes: int) -> int:
    """How many half-waves the lowest `modes` modes have at most, of either family at rest."""
    bending = stretching = 0
    while bending + stretching < modes:
        if mu * (stretching + 0.5) < math.pi * (bending + 0.5) ** 2:
            stretching += 1
        else:
            bending += 1
    return max(bending, stretching)


def _tension(beam: Beam, stretch: float, x: float, pulled: bool) -> float:
    """N at x of a beam of uniform stretch; `pulled` where the mass lies further out."""
    N = stretch * (1 - x * x) / 2 + beam.delta * (1 - x)
    if pulled:
        N += beam.alpha * (stretch * beam.beta + beam.delta)
    return beam.gamma**2 * N


def _stretch(law: StrainLaw, n: float) -> float:
    """The stretch at which the law carries the force n, within its range."""
    if n <= 0:
        return 1.0
    high = 2.0
    while high < law.max_stretch and law.force(high) < n:
        high *= 2
    high = min(high, law.max_stretch)
    return brentq(lambda f: law.force(f) - n, 1.0, high) if law.force(high) > n else high


def _layer_breaks(part: Segment, curvature: Curvature) -> set[float]:
    """Ends of the elements that hold the layers too thin for order."""
    left, right = part.layers(curvature)
    breaks = set()
    if THINNEST * left < part.length:
        breaks.add(part.start + LAYER_REACH * left)
    if THINNEST * right < part.length:
        breaks.add(part.end - LAYER_REACH * right)
    return breaks


def _falling_breaks(part: Segment, mu: float) -> set[float]:
    """Breaks towards an end where a large stretch falls off: f ~ N^(1/3) has its singularity
    just beyond, as far as the force n needs to fall to -0.2, its least value."""
    breaks = set()
    if part.slope > 0:
        distance = (part.N[1] + 0.2 * mu**2) / part.slope
        while GRADING * distance < part.length:
            breaks.add(part.end - distance)
            distance *= GRADING
    return breaks


def _tip_breaks(last: Segment) -> set[float]:
    """A break near the free tip, where the tension runs out and bending takes over."""
    if last.slope <= 0:
        return set()
    reach = TIP_REACH * last.slope ** (-1 / 3)
    return {1 - reach} if 8 * reach < last.length else set()


def _spread(breaks: list[float], longest: float) -> list[float]:
    """The breaks with more between them where an element is longer than `longest`."""
    spread = [breaks[0]]
    for a, b in pairwise(breaks):
        pieces = math.ceil((b - a) / longest)
        spread += [a + (b - a) * i / pieces for i in range(1, pieces)] + [b]
    return spread
