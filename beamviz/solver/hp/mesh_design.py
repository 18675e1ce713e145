"""A-priori choice of the mesh of a straight beam, from the widths of its boundary layers.

A tension N large against the bending stiffness causes boundary layers of width
1 / sqrt(N f^(2c-3)) at the clamp and on both sides of a concentrated mass; at a free tip, where the
tension vanishes, the layer has the width (N')^(-1/3). Gauss points are dense at the ends of an
element, so order p resolves layers down to about 1/p^2 of it; only thinner ones get an element of
their own.

The mesh is also graded towards an end beyond which the stretch is nearly singular, and finer where
softening cancels digits of the lowest mode.

The constants below are fitted: too small a value costs another attempt (refinement adds digits),
too large a value costs unknowns; neither moves a frequency beyond its error estimate.
scripts/fit_mesh_constants.py measures attempts and unknowns over random beams as a function of any
of them.
"""

import math
from collections.abc import Iterator
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

from beamviz.beam import Beam
from beamviz.solver.constitutive import StrainLaw
from beamviz.solver.problem import Problem

# Widths. A layer decays as exp(-x / width), its energy twice as fast.
LAYER_REACH = 2.0  # length of its element in widths per digit: exp(-2 * 12) is left after 12 digits
WIDEST = 0.18  # of its span: width of a layer above which the order for the half-waves suffices
TIP_REACH = 4.0  # length of the element of a tip layer in widths: an Airy function decays faster
GRADING = 6.0  # ratio of neighbouring elements towards a singularity
NEGLIGIBLE_FORCE = 0.1  # force n below which layers are computed for a stretch of 1
NEAREST = 1e-5  # least distance to a singularity beyond the clamp: the accuracy it is known to
AT_END = 1e-13  # distance to the clamp or the tip, by rounding, of a mass that is taken to be there

# Orders. order = PER_HALF_WAVE half_waves + PER_DIGIT digits + AT_LEAST: Gauss points per half-wave
# (the asymptotic pi / 2 and a margin), and the exponential convergence with more.
PER_HALF_WAVE, PER_DIGIT, AT_LEAST = 1.86, 0.85, 1.4
# A layer of relative width d needs an order of LAYER_OFFSET + PER_ROOT_WIDTH / sqrt(d) for six
# digits, as the spacing of points at the ends is 1 / order^2; in an element of its own, of length
# reach * width, d = 1 / reach. A tip layer decays smoothly: order ~ 1 / d.
LAYER_OFFSET, PER_ROOT_WIDTH, TIP_OFFSET = 5.2, 2.4, 5.5
# Where all modes couple, the order of an element along the beam is that for the half-waves across
# it, less FEWER (the second at a large stretch): Coriolis forces move little along the beam.
FEWER = 2.0, 1.0
GRADED_ORDER = 8  # least order beside thin elements, for six digits
SHARE = 0.475, 0.0875  # factor of these orders for other numbers of digits: constant and slope
MIN_ORDER, MAX_ORDER = 4, 30  # below, elements are too many; above, two of half the length are less
SPLIT_ORDER = 32.0  # order from which two halves need fewer unknowns for the same digits
MAX_UNKNOWNS = 300  # of one family: a dense eigenproblem of more takes longer than a second
SPARE_DIGITS = 1.0  # digits that the orders above give beyond those asked for
DIGITS_PER_STRETCH = 1.8  # digits lost to a stretch of 10 at the clamp


class Positions(NamedTuple):
    """Positions u of an approximate equilibrium."""

    ends: tuple[float, ...]  # x of clamp, mass and tip
    u: tuple[float, ...]  # at the ends
    means: tuple[float, ...]  # of u between the ends


class Span(NamedTuple):
    """A part of the beam between clamp, mass and tip."""

    start: float
    end: float
    length: float
    N: tuple[float, float]  # tension at start and end
    f: tuple[float, float]  # stretch there
    slope: float  # -dN/dx at the end
    distance_to_force_limit: float  # inboard of the clamp, of the tension continued there


class Layer(NamedTuple):
    """A boundary layer between x and `end`, and the orders that resolve it."""

    x: float
    end: float  # of an element of its own, if that is within the span
    own_order: float  # of that element
    order: float  # of the element of the whole span
    length: float  # of the span


class HalfWaves(NamedTuple):
    """Numbers of half-waves that a mesh resolves."""

    most: int  # of any mode
    along: int  # of modes along the beam


class Elements(NamedTuple):
    """The elements of a mesh, as arguments of `make_mesh`."""

    breaks: tuple[float, ...]
    orders: tuple[int, ...]  # of modes across the beam: the numbers of Gauss points
    axial_orders: tuple[int, ...]  # of modes along it, at most as high


def unstretched_positions(beam: Beam) -> Positions:
    """The positions of a beam of small strain: u = x."""
    beta = beam.beta
    if not (beam.alpha > 0 and AT_END < beta < 1 - AT_END):
        return Positions((0.0, 1.0), (0.0, 1.0), (0.5,))
    return Positions((0.0, beta, 1.0), (0.0, beta, 1.0), (beta / 2, (beta + 1) / 2))


def find_spans(beam: Beam, positions: Positions, law: StrainLaw) -> list[Span]:
    """The spans of a beam, clamp first, with N = gamma^2 int_x^1 rho (u + delta) at their ends."""
    ends, u, means = positions
    spans: list[Span] = []
    load, N = beam.gamma**2, 0.0
    for k in range(len(means), 0, -1):  # from the tip
        a, b, slope = ends[k - 1], ends[k], load * (u[k] + beam.delta)
        if abs(b - beam.beta) <= AT_END:
            N += beam.alpha * slope
        N_end, N = N, N + load * (b - a) * (means[k - 1] + beam.delta)
        n, n_end = N / beam.mu**2, N_end / beam.mu**2
        f = 1.0 if n < NEGLIGIBLE_FORCE else float(law.stretch(n))
        f_end = 1.0 if n_end < NEGLIGIBLE_FORCE else float(law.stretch(n_end))
        distance = math.inf
        if not a and N * beam.delta > 0:  # else |N| does not grow inboard of the clamp
            limit = beam.mu**2 * law.force_limits[N > 0]
            distance = max((limit - N) / (load * beam.delta), NEAREST)
        spans.insert(0, Span(a, b, b - a, (N, N_end), (f, f_end), slope, distance))
    return spans


def extra_digits(beam: Beam, positions: Positions, spans: list[Span], problem: Problem) -> float:
    """Digits that a mesh needs beyond those asked for: for the decay of a large stretch along the
    beam, and where softening cancels digits of omega^2 of the lowest chordwise mode.

    That mode of a fast outward beam is almost a rigid rotation about the clamp. Its omega^2 is the
    bending stiffness, 3 at rest plus sqrt(N f^(5 - 2c)) of the layer, and the pull of the hub
    radius, over the moment of inertia.
    """
    N, f = spans[0].N[0], spans[0].f[0]
    more = DIGITS_PER_STRETCH * math.log10(f) - SPARE_DIGITS
    if beam.delta < 0 or not (problem.chordwise and problem.softening and problem.stiffens):
        return max(0.0, more)
    inertia = moment = 0.0
    for span, (u, u_end), mean in zip(spans, pairwise(positions.u), positions.means, strict=True):
        carried = beam.alpha if abs(span.end - beam.beta) <= AT_END else 0.0
        inertia += span.length * (mean**2 + (u_end - u) ** 2 / 12) + carried * u_end**2
        moment += span.length * mean + carried * u_end
    bending = 3 + math.sqrt(N * f ** (5 - 2 * problem.curvature_power))
    softening = beam.gamma**2
    left = (bending + softening * beam.delta * moment) / inertia
    return max(0.0, more + math.log10(1 + softening / left))


def choose_mesh(
    spans: list[Span],
    mu: float,
    waves: HalfWaves,
    problem: Problem,
    digits: float,
    same_breaks: bool = False,
) -> Elements:
    """Elements for modes with these numbers of half-waves to a number of digits; their unknowns may
    exceed MAX_UNKNOWNS. A layer gets an element of its own where two elements have fewer unknowns
    than one. same_breaks: the breaks are the same for all positions of the mass, as layers get no
    elements of their own, and no element is halved."""
    power, coupled = 2 * problem.curvature_power - 3, problem.gyroscopic
    most_waves, axial_waves, compression = float(waves.most), float(waves.along), 0.0
    stretched = spans[0].f[0] != 1  # a large stretch, and with it the stiffness, varies along x
    if stretched and not coupled:
        axial_waves = math.inf
    fewer = FEWER[stretched] if coupled else math.inf
    breaks = {0.0}
    for span in spans:
        (N, N_end), (f, f_end) = span.N, span.f
        compression = max(compression, -N * f**power, -N_end * f_end**power)
        breaks.add(span.end)
        first, longest = span.distance_to_force_limit, span.length / GRADING
        if first < longest:
            breaks.update(span.start + near for near in distances(first, GRADING, longest))
        # f ~ N^(1/3) of a large stretch is singular where n would be -0.2, its least value
        first = (N_end + 0.2 * mu**2) / span.slope if span.slope > 0 else math.inf
        if first < longest:
            breaks.update(span.end - near for near in distances(first, GRADING, longest))
    most_waves += math.sqrt(compression) / math.pi  # half-waves of buckling over the whole beam
    per_length, axial_per_length = PER_HALF_WAVE * most_waves, PER_HALF_WAVE * axial_waves
    smooth = AT_LEAST + PER_DIGIT * digits
    share = SHARE[0] + SHARE[1] * digits
    layers = _layers(spans, power, digits, share)
    thin = []
    for layer in layers:
        order_of_two = layer.own_order + per_length * layer.length + smooth
        inside = not same_breaks and abs(layer.end - layer.x) < layer.length
        if inside and layer.order > min(order_of_two, MAX_ORDER):
            thin.append(layer)
            breaks.add(layer.end)
    ends = sorted(breaks)
    least = share * GRADED_ORDER if len(ends) > len(spans) + 1 else 0.0
    orders = [max(per_length * (b - a) + smooth, least) for a, b in pairwise(ends)]
    for layer in layers:
        element = ends.index(layer.x) - (layer.end < layer.x)
        need = layer.own_order if layer in thin else layer.order
        orders[element] = max(orders[element], need)
    highest = MAX_UNKNOWNS
    if not same_breaks:
        highest, (ends, orders) = MAX_ORDER, _halved(ends, orders, smooth)
    whole, axial = [], []
    for (a, b), order in zip(pairwise(ends), orders, strict=True):
        whole.append(min(max(math.ceil(order), MIN_ORDER), highest))
        for_waves = max(axial_per_length * (b - a), per_length * (b - a) - fewer)
        along = max(for_waves + smooth, least, MIN_ORDER)  # there are no layers
        axial.append(math.ceil(min(along, whole[-1])))
    return Elements(tuple(ends), tuple(whole), tuple(axial))


def _halved(
    ends: list[float], orders: list[float], smooth: float
) -> tuple[list[float], list[float]]:
    """Breaks and orders, elements above SPLIT_ORDER halved unless that exceeds MAX_UNKNOWNS.
    smooth: order for digits alone, which halves need as well."""
    halves, each = ends, orders
    while max(each) > SPLIT_ORDER:
        k = each.index(max(each))
        halves = [*halves[: k + 1], (halves[k] + halves[k + 1]) / 2, *halves[k + 1 :]]
        each = [*each[:k], *2 * [(each[k] + smooth) / 2], *each[k + 1 :]]
        if not sum(each) <= MAX_UNKNOWNS - len(each):
            return ends, orders
    return halves, each


def _layers(spans: list[Span], power: int, digits: float, share: float) -> list[Layer]:
    """The boundary layers at the ends of each span, by the tension N f^power, and at the free tip,
    where the tension vanishes."""
    reach = LAYER_REACH * digits
    own = share * (LAYER_OFFSET + PER_ROOT_WIDTH * math.sqrt(reach))
    found = []
    for span in spans:
        for x, N, f in (span.start, span.N[0], span.f[0]), (span.end, span.N[1], span.f[1]):
            pull = N * f**power
            if x < 1 and pull * span.length**2 > WIDEST**-2:  # the tip is free to rotate
                width = 1 / math.sqrt(pull)
                order = share * (LAYER_OFFSET + PER_ROOT_WIDTH * math.sqrt(span.length / width))
                inward = reach * width if x == span.start else -reach * width
                found.append(Layer(x, x + inward, own, order, span.length))
    width = span.slope ** (-1 / 3) if span.slope > 0 else math.inf
    if TIP_REACH * width < span.length:
        own = share * (TIP_OFFSET + TIP_REACH)
        order = share * (TIP_OFFSET + span.length / width)
        found.append(Layer(1.0, 1 - TIP_REACH * width, own, order, span.length))
    return found


@lru_cache(maxsize=64)
def half_waves(mu: float, modes: int) -> HalfWaves:
    """The greatest numbers of half-waves of the lowest `modes` modes at rest."""
    bending = stretching = 0
    while bending + stretching < modes:
        if mu * (stretching + 0.5) < math.pi * (bending + 0.5) ** 2:
            stretching += 1
        else:
            bending += 1
    return HalfWaves(max(bending, stretching), stretching)


def distances(first: float, ratio: float, longest: float) -> Iterator[float]:
    """Distances of graded breaks from the end of a span, below `longest`."""
    while first < longest:
        yield first
        first *= ratio
