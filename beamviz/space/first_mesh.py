"""The first mesh of a beam, from the half-waves of its modes, its boundary layers, and the distance
of singularities.

A tension N large against the bending stiffness EI causes boundary layers of width
sqrt(EI / (N f^(2c-3))), c the power of the curvature measure, at the clamp, on both sides of a
concentrated mass and where a property jumps; at a free tip, where the tension vanishes, the layer
is an Airy function of width (EI / N')^(1/3). The stretch is singular where the tension, continued
beyond the end of a span, reaches a limit of the strain law. Gauss points are dense at the ends of
an element: only what they do not resolve with fewer unknowns gets elements of its own.

The order of an element follows from the Legendre expansions of what it resolves. The polynomial of
degree n has, on [-1, 1], these shares of the square integral, j_n the spherical Bessel function:

    cos(k x + any phase)        (2 n + 1) j_n(k)^2
    exp(-a (x + 1))             exp(-n^2 / a)                 a >> n
    exp(-2/3 (a (x + 1))^1.5)   exp(-1.886 n^1.5 (2 a)^-0.75)
    1 / (x + z)                 (z + sqrt(z^2 - 1))^(-2 n)    (Bernstein)

These are shares of the strain energy of a mode, and so of its omega^2.
"""

import math
from collections.abc import Iterator
from itertools import chain, pairwise, starmap
from typing import NamedTuple

import numpy as np

from beamviz.blade import Blade
from beamviz.solver.problem import Problem
from beamviz.space.elements import SpanElements
from beamviz.space.refinement import MAX_ORDER, TRUNCATION_FACTOR
from beamviz.space.spans import Span, properties_of_spans

# Nine random beams in ten need no second mesh. The work, n^3 over all meshes, changes by less than
# 5 % for MAX_ORDER from 24 to 36, GRADING from 4 to 9 and CANCELLED from 1e-3 to 0.1.
MIN_ORDER = 4  # so that the two highest polynomials of an element are not all of it
GRADING = 6.0  # ratio of the length of an element to its distance from a singularity, at most
CANCELLED = 1e-2  # least omega^2 that centrifugal and Coriolis forces leave of strain energy 1
MOST_WAVES = 300.0  # [rad] half the phase of a mode along an element that is to be divided
ROUNDED = 0.8  # least ratio of the width of a layer to that of the rounded numbers


class Layer(NamedTuple):
    """A boundary layer at an end x of a span."""

    x: float
    inward: int  # 1 where the span begins at x, -1 where it ends
    width: float
    tip: bool  # whether it is an Airy function

    def reach(self, share: float) -> float:
        """The distance from x beyond which this share of its energy is left."""
        left = math.log(1 / share)
        return self.width * ((0.75 * left) ** (2 / 3) if self.tip else left / 2)

    def order(self, length: float, share: float) -> int:
        """The order of an element of this length at x."""
        widths, left = length / self.width, math.log(1 / share)
        degree = math.sqrt(widths) * (left / 1.886) ** (2 / 3)
        if not self.tip:
            degree = 1 + math.sqrt(widths / 2 * left)  # a is not so much larger than n
        return math.ceil(degree) + 2  # the tail is that of two polynomials

    def is_in(self, start: float, stop: float) -> bool:
        """Whether it is at the end of an element between these fractions of its span."""
        return start == 0 if self.inward > 0 else stop == 1


def layers(span: Span, power: int) -> list[Layer]:
    """The boundary layers of a span thinner than it is long, by the tension N f^power."""
    thin = []
    for end in span:
        if end.smooth:
            continue
        tip = end.x == 1  # free to rotate: a layer only where the tension vanishes
        if tip:
            width = (end.EI / end.slope) ** (1 / 3) if end.N == 0 and end.slope > 0 else math.inf
        else:
            width = math.sqrt(end.EI / (end.N * end.f**power)) if end.N > 0 else math.inf
        if width < span.length:
            thin.append(Layer(end.x, end.inward, width, tip))
    return thin


class WaveDensities(NamedTuple):
    """How waves are distributed along a blade. Frequencies of short waves are (k / bending)^2 and
    mu k / stretching, with k = pi times their number of half-waves along the beam."""

    bending: float  # int (rho / EI)^(1/4) dx
    stretching: float  # int (rho / EA)^(1/2) dx
    of_spans: tuple[float, ...]  # the greater of the densities of both, over that of a uniform beam
    twisted: float = 0.0  # half-waves of the direction of the section's axes along the beam


def wave_densities(
    blade: Blade, ends: tuple[float, ...], runs: list[tuple[int, int]], bending: str
) -> WaveDensities:
    """The densities of waves on runs of spans of a blade, given by the first and the last of each.
    bending: "bending", "flap" or "both"."""
    spans = properties_of_spans(blade, ends, bending)
    bend = np.vecdot(spans.weights, (spans.mass / spans.bending) ** 0.25)
    stretch = np.vecdot(spans.weights, (spans.mass / spans.axial) ** 0.5)
    firsts = [first for first, _ in runs]
    lengths = np.diff([*(ends[first] for first in firsts), ends[-1]])
    shares = (np.add.reduceat(density, firsts) / density.sum() for density in (bend, stretch))
    shares = np.maximum(*shares) / lengths
    twist = (blade.twist or ()) if bending == "both" else ()
    turns = sum(abs(b - a) for a, b in pairwise(twist)) / 90.0
    return WaveDensities(float(bend.sum()), float(stretch.sum()), tuple(shares.tolist()), turns)


def elements_of_spans(
    mu: float, spans: list[Span], problem: Problem, densities: WaveDensities | None = None
) -> list[SpanElements]:
    """The elements of each span, of orders beyond which polynomials have at most the share of the
    energy of a mode that the tolerance allows. densities: None of a beam without a blade."""
    share = problem.tolerance / TRUNCATION_FACTOR
    power = 2 * problem.curvature_power - 3
    ends = [end for span in spans for end in span]
    most = max(0.0, *(end.N for end in ends))
    if densities:
        mu *= densities.bending**2 / densities.stretching
        most *= densities.bending**2
    # Without tension as many modes as possible bend, with the greatest as many as possible stretch.
    bending, _ = half_waves(mu, problem.modes, 0.0)
    _, stretching = half_waves(ROUNDED * mu, problem.modes, most)
    compression = max(-end.N * end.f**power / end.EI for end in ends)
    if compression > 0:  # half-waves of buckling over the whole beam
        bending += math.sqrt(compression) / math.pi
    waves = max(bending, stretching) + (densities.twisted if densities else 0.0)
    stretched = any(end.f != 1 for end in ends)  # so the axial stiffness varies
    axial_waves = waves if problem.gyroscopic or stretched or densities else stretching
    factors = densities.of_spans if densities else [1.0] * len(spans)
    return [
        elements_of_span(span, factor * waves, factor * axial_waves, power, share)
        for span, factor in zip(spans, factors, strict=True)
    ]


def elements_of_span(
    span: Span, waves: float, axial_waves: float, power: int, share: float
) -> SpanElements:
    """The elements of a span, of a beam whose modes have at most `waves` half-waves across it, and
    `axial_waves` along it, over its length.

    power: 2 c - 3, of the stretch in the width of a layer. share: of the energy of a mode, the most
    that polynomials of higher orders may have.
    """
    length = span.length
    breaks = {0.0, 1.0}  # from the start of the span, in its lengths
    thin: list[Layer] = []  # with an element of their own
    wide: list[Layer] = []
    for layer in layers(span, power):
        reach = reach_of_element(layer, length, order_of_waves(waves * length, share), share)
        (thin if reach < 1 else wide).append(layer)
        breaks.add(reach if layer.inward > 0 else 1 - reach)
    singular = [end for end in span if end.singularity < math.inf]
    for end in singular:
        for away in graded(end.singularity / length, share):
            breaks.add(away if end.inward > 0 else 1 - away)

    def elements_between(start: float, stop: float) -> Iterator[tuple[float, int, int]]:
        """End, order and order along the beam of elements of at most the highest order."""
        size = (stop - start) * length
        order = order_of_waves(waves * size, share)
        axial_order = order_of_waves(axial_waves * size, share)
        for layer in [*wide, *(layer for layer in thin if layer.is_in(start, stop))]:
            order = max(order, layer.order(size, share))
        for end in singular:
            apart = end.singularity + length * (start if end.inward > 0 else 1 - stop)
            least = order_of_singularity(apart / size, share)
            order, axial_order = max(order, least), max(axial_order, least)
        if order <= MAX_ORDER:
            yield stop, order, min(axial_order, order)
            return
        middle = (start + stop) / 2
        yield from elements_between(start, middle)
        yield from elements_between(middle, stop)

    rows = chain.from_iterable(starmap(elements_between, pairwise(sorted(breaks))))
    stops, orders, axial_orders = zip(*rows, strict=True)
    return SpanElements(stops, orders, axial_orders)


def reach_of_element(layer: Layer, length: float, beside: int, share: float) -> float:
    """The length of an element for a layer, in those of its span, a power of 1/2; 1 where it needs
    none. beside: order of the rest of the span."""
    whole = layer.order(length, share)
    if whole <= beside:
        return 1.0
    # Beyond its element what is left of the layer is as wide as the distance of Gauss points.
    wider = max(1.0, length / (layer.width * beside**2))
    reach = layer.reach(CANCELLED * share / wider) / (ROUNDED * length)
    reach = 0.5 ** int(-math.log2(reach)) if reach < 1 else 1.0
    return reach if whole > min(layer.order(reach * length, share) + beside, MAX_ORDER) else 1.0


def graded(distance: float, share: float) -> Iterator[float]:
    """Ends of elements that grow away from a singularity beyond the end of a span, in its lengths,
    as the distance is; none where one element resolves it."""
    if order_of_singularity(distance, share) > MAX_ORDER:
        away = GRADING * distance
        while away < 0.5:
            yield away
            away *= GRADING


def order_of_waves(half_waves: float, share: float) -> int:
    """The order of an element for so many half-waves of a mode along it, with
    j_n(k) = k^n / (2 n + 1)!! exp(-k^2 / (4 n + 6)) for n > k."""
    k = math.pi / 2 * half_waves
    if k > MOST_WAVES:  # more than any element resolves, and k^n would overflow
        return math.ceil(k)
    degree, power, left = 0, 1.0, 1.0
    while degree < k or left > share:
        degree += 1
        power *= k / (2 * degree + 1)
        left = (2 * degree + 1) * (power * math.exp(-(k**2) / (4 * degree + 6))) ** 2
    return max(degree + 2, MIN_ORDER)  # the tail is that of two polynomials


def order_of_singularity(distance: float, share: float) -> int:
    """The order of an element from whose end a singularity has this distance, in its lengths."""
    return math.ceil(math.log(1 / share) / (2 * math.acosh(1 + 2 * distance))) + 2


def half_waves(mu: float, modes: int, N: float) -> tuple[float, float]:
    """The greatest numbers of half-waves of bending and of stretching among the lowest `modes`
    modes under a uniform tension: mode k has k - 1/2."""
    bending = stretching = 0
    while bending + stretching < modes:
        k = math.pi * (bending + 0.5)
        if mu * math.pi * (stretching + 0.5) < k * math.sqrt(k**2 + N):
            stretching += 1
        else:
            bending += 1
    return max(bending - 0.5, 0.0), max(stretching - 0.5, 0.0)
