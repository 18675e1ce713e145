"""Where a rotating beam needs thin elements, and of which order: read off its scales.

Tension N against bending makes layers of width 1 / sqrt(N f^(2c-3)) at the clamp and on both
sides of a concentrated mass; where the tension runs out, at a free tip, bending takes over
within (N')^(-1/3). Gauss points crowd at the ends of an element, so order p resolves layers
down to about 1/p^2 of it; only thinner ones get an element of their own.

Two more things make it finer: a stretch that is all but singular just beyond an end wants a mesh
graded towards it, and what softening takes from the lowest mode has to be there first.
"""

import math
from functools import lru_cache
from itertools import pairwise
from operator import itemgetter
from typing import NamedTuple

from beamviz.beam import Beam
from beamviz.solver.constitutive import Curvature, StrainLaw
from beamviz.solver.problem import Problem

LAYER_REACH = 2.0  # widths per digit: exp(-2 * 12) of a layer's energy is left after 12
TIP_REACH = 4.0
GRADING = 6.0  # ratio of neighbouring elements where the stretch falls off
WAVES_PER_ELEMENT = 9.0
NEGLIGIBLE_FORCE = 0.1  # n: the stretch is 1 for all that layers care
NEAREST = 1e-5  # beyond the clamp: nearer, where the law ends is not known
AT_END = 1e-13  # a mass this near the clamp or the tip sits on it, to rounding
GRADED_ORDER = 8  # least order beside thin elements, for six digits
MIN_ORDER, MAX_ORDER = 4, 30
MAX_UNKNOWNS = 300  # of one family; beyond, the scene is too near an end of equilibrium
TOO_HIGH = 38.0  # an order from which on two halves are better than MAX_ORDER
HALF = 0.7  # of the order of an element, in each half of it
SPARE_DIGITS = 1.0  # that the orders below give beyond those asked for
DIGITS_OF_STRETCH = 1.8  # lost to a stretch of 10 at the clamp
CAPS = (14, 18, 22, 30)  # orders above which a layer gets an element of its own, tried in turn


class Segment(NamedTuple):
    """A part of the beam between clamp, mass and tip, with tension N and stretch f at its ends."""

    start: float
    end: float
    N: tuple[float, float]
    f: tuple[float, float]
    slope: float  # -dN/dx at its end
    brink: float  # how far before the clamp, did the beam go on, its law would carry no more

    @property
    def length(self) -> float:
        return self.end - self.start

    def pull(self, curvature: Curvature) -> tuple[float, float]:
        """Tension against bending at its ends: N f^(2c - 3)."""
        power = 2 * curvature.power - 3
        (N, N_end), (f, f_end) = self.N, self.f
        return N * f**power, N_end * f_end**power


class Positions(NamedTuple):
    """Where the beam is in equilibrium, roughly: x of clamp, mass and tip, u there, and the mean
    u of each part between them."""

    ends: tuple[float, ...]
    u: tuple[float, ...]
    means: tuple[float, ...]


WHOLE = Positions((0.0, 1.0), (0.0, 1.0), (0.5,))


def unstretched(beam: Beam) -> Positions:
    """The positions of a beam that hardly stretches: u = x."""
    beta = beam.beta
    if not (beam.alpha > 0 and AT_END < beta < 1 - AT_END):
        return WHOLE
    ends = (0.0, beta, 1.0)
    return Positions(ends, ends, (beta / 2, (beta + 1) / 2))


def segments(beam: Beam, positions: Positions, law: StrainLaw) -> list[Segment]:
    """The parts of a beam with the tension N = gamma^2 int_x^1 rho (u + delta) at their ends."""
    ends, u, means = positions
    parts = []
    load, N = beam.gamma**2, 0.0
    for k in range(len(means), 0, -1):  # from the tip
        a, b, pull = ends[k - 1], ends[k], load * (u[k] + beam.delta)
        if beam.alpha and abs(b - beam.beta) <= AT_END:
            N += beam.alpha * pull
        N_end, N = N, N + load * (b - a) * (means[k - 1] + beam.delta)
        f, f_end = _stretch(law, N / beam.mu**2), _stretch(law, N_end / beam.mu**2)
        brink = math.inf if a else _brink(N, beam, law)
        parts.append(Segment(a, b, (N, N_end), (f, f_end), pull, brink))
    return parts[::-1]


def _brink(N: float, beam: Beam, law: StrainLaw) -> float:
    """How far before the clamp, where its tension is N, a beam would meet the end of its law."""
    if N * beam.delta <= 0:  # |N| falls off beyond the clamp, or is level
        return math.inf
    least, most = law.forces
    left = most * beam.mu**2 - N if N > 0 else N - least * beam.mu**2
    slope = beam.gamma**2 * abs(beam.delta)
    return max(left / slope, NEAREST) if left < slope else math.inf


def more_digits(beam: Beam, positions: Positions, parts: list[Segment], problem: Problem) -> float:
    """Digits that a mesh needs beyond those asked for: where softening takes some, and where a
    stretch falls off."""
    softened = problem.chordwise and problem.softening and problem.stiffens and beam.delta >= 0
    lost = lost_digits(beam, positions, parts, problem.curvature_measure) if softened else 0.0
    return max(0.0, lost + DIGITS_OF_STRETCH * math.log10(parts[0].f[0]) - SPARE_DIGITS)


def lost_digits(
    beam: Beam, positions: Positions, parts: list[Segment], curvature: Curvature
) -> float:
    """Digits that omega^2 of the lowest mode in the plane of rotation loses to the softening
    gamma^2 of a beam that points outwards.

    It turns about the clamp all but rigidly. What the softening leaves is bending, 3 at rest and
    sqrt(N f^(5 - 2c)) in a layer, and the pull of the hub radius, over its moment of inertia.
    """
    inertia = moment = 0.0
    start = u_start = 0.0
    for end, u, mean in zip(positions.ends[1:], positions.u[1:], positions.means, strict=True):
        length = end - start
        inertia += length * (mean**2 + (u - u_start) ** 2 / 12)
        moment += length * mean
        if beam.alpha and abs(end - beam.beta) <= AT_END:
            inertia += beam.alpha * u**2
            moment += beam.alpha * u
        start, u_start = end, u
    N, f = parts[0].N[0], parts[0].f[0]
    bending = 3 + math.sqrt(N * f ** (5 - 2 * curvature.power))
    softening = beam.gamma**2
    left = (bending + softening * beam.delta * moment) / inertia
    return math.log10(1 + softening / left)


def discretisation(
    parts: list[Segment], mu: float, modes: int, curvature: Curvature, digits: float
) -> tuple[tuple[float, ...], tuple[int, ...]]:
    """Breaks and orders that should give the lowest `modes` modes to so many digits, with as few
    unknowns as any choice of what is resolved by thin elements and what by order."""
    waves = float(half_waves(mu, modes))
    pulls = [part.pull(curvature) for part in parts]
    pull = min(map(min, pulls))
    if pull < 0:  # the half-waves over the whole beam where compression is greatest
        waves += math.sqrt(-pull) / math.pi
    layers: list[Layer] = []
    fixed = [0.0]
    for part, pull_at_ends in zip(parts, pulls, strict=True):
        layers += _layers(part, pull_at_ends, digits)
        fixed.append(part.end)
        fixed += [part.start + distance for distance in _graded(part.brink, part.length)]
        if part.slope > 0:
            fixed += _falling(part, mu)
    candidates = []
    for cap in CAPS:
        thin = [layer.end for layer in layers if layer.order > cap]
        ends = _spread(sorted({*fixed, *thin}), WAVES_PER_ELEMENT / waves)
        orders = [1.86 * waves * (b - a) + 1.4 + 0.85 * digits for a, b in pairwise(ends)]
        if len(ends) > len(parts) + 1:
            graded = _share_if_thin(digits) * GRADED_ORDER
            orders = [max(order, graded) for order in orders]
        for layer in layers:
            element = layer.element(ends)
            need = layer.order if layer.order <= cap else layer.own_order
            orders[element] = max(orders[element], need)
        ends, orders = _halved(ends, orders)
        whole = [min(max(math.ceil(order), MIN_ORDER), MAX_ORDER) for order in orders]
        candidates.append((sum(whole), tuple(ends), tuple(whole)))
        if not thin:
            break
    return min(candidates, key=itemgetter(0))[1:]


def _halved(ends: list[float], orders: list[float]) -> tuple[list[float], list[float]]:
    """Elements of too high an order in two halves each, as often as it takes; as they were where
    that is too much."""
    halves, each = ends, orders
    while TOO_HIGH < max(each) < math.inf:
        k = each.index(max(each))
        halves = [*halves[: k + 1], (halves[k] + halves[k + 1]) / 2, *halves[k + 1 :]]
        each = [*each[:k], *2 * [HALF * each[k]], *each[k + 1 :]]
    return (halves, each) if sum(each) <= MAX_UNKNOWNS - len(each) else (ends, orders)


class Layer(NamedTuple):
    """A layer at x, on the side of its `end`: where an element of its own would end, the order
    that needs, and the order that resolves the layer without one."""

    x: float
    end: float
    own_order: float
    order: float

    def element(self, ends: list[float]) -> int:
        """The element of the mesh that the layer lies in."""
        return ends.index(self.x) - (self.end < self.x)


def _share(digits: float) -> float:
    """The share that so many digits need of the order that six need."""
    return 0.4 + 0.1 * digits


def _share_if_thin(digits: float) -> float:
    """`_share` in thin elements, whose width goes with the digits already."""
    return 0.55 + 0.075 * digits


def _layers(part: Segment, pulls: tuple[float, float], digits: float) -> list[Layer]:
    """The layers of a segment that are short of it: at its ends with these pulls, and where its
    tension runs out at the free tip."""
    share, if_thin, reach = _share(digits), _share_if_thin(digits), LAYER_REACH * digits
    found = []
    for x, pull, side in (part.start, pulls[0], 1), (part.end, pulls[1], -1):
        if x < 1 and pull * part.length**2 > reach**2:  # nothing holds the rotation of the tip
            width = 1 / math.sqrt(pull)
            own = if_thin * (4.4 + 2.4 * math.sqrt(reach))
            order = share * (5.4 + 2.4 * math.sqrt(part.length / width))
            found.append(Layer(x, x + side * reach * width, own, order))
    if part.end == 1 and part.slope > 0:
        width = part.slope ** (-1 / 3)
        if TIP_REACH * width < part.length:
            own, order = if_thin * (5.5 + TIP_REACH), share * (6 + part.length / width)
            found.append(Layer(1.0, 1 - TIP_REACH * width, own, order))
    return found


@lru_cache(maxsize=64)
def half_waves(mu: float, modes: int) -> int:
    """How many half-waves the lowest `modes` modes have at most, of either family at rest."""
    bending = stretching = 0
    while bending + stretching < modes:
        if mu * (stretching + 0.5) < math.pi * (bending + 0.5) ** 2:
            stretching += 1
        else:
            bending += 1
    return max(bending, stretching)


def _stretch(law: StrainLaw, n: float) -> float:
    """The stretch at which the law carries the force n, as well as layers need it."""
    return 1.0 if n < NEGLIGIBLE_FORCE else float(law.stretch(n))


def _falling(part: Segment, mu: float) -> list[float]:
    """Breaks towards an end where a large stretch falls off: f ~ N^(1/3) has its singularity
    just beyond, as far as the force n needs to fall to -0.2, its least value."""
    distance = (part.N[1] + 0.2 * mu**2) / part.slope
    return [part.end - near for near in _graded(distance, part.length)]


def _graded(distance: float, length: float) -> list[float]:
    """How far from its end an element of this length is broken, for a singularity at a distance
    beyond the end."""
    breaks = []
    while GRADING * distance < length:
        breaks.append(distance)
        distance *= GRADING
    return breaks


def _spread(breaks: list[float], longest: float) -> list[float]:
    """The breaks with more between them where an element is longer than `longest`."""
    spread = [breaks[0]]
    for a, b in pairwise(breaks):
        if b - a > longest:
            pieces = math.ceil((b - a) / longest)
            spread += [a + (b - a) * i / pieces for i in range(1, pieces)]
        spread.append(b)
    return spread
