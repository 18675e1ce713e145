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
from collections.abc import Iterator, Sequence
from functools import lru_cache
from itertools import chain, pairwise, starmap
from typing import NamedTuple

import numpy as np

from beamviz.beam import Beam
from beamviz.blade import Blade
from beamviz.solver.hp.equilibrium import (
    StretchOnGrid,
    coarse_equilibrium,
    has_unique_equilibrium,
    is_small_strain,
)
from beamviz.solver.hp.error_estimates import TRUNCATION_FACTOR
from beamviz.solver.hp.properties import AnyBeam, Numbers, is_uniform, numbers_of
from beamviz.solver.hp.spans import (
    AT_END,
    Span,
    ends_of_spans,
    find_spans,
    properties_of_spans,
    unstretched_positions,
)
from beamviz.solver.problem import Problem

# Nine random beams in ten need no second mesh. The work, n^3 over all meshes, changes by less than
# 5 % for MAX_ORDER from 24 to 36, GRADING from 4 to 9 and CANCELLED from 1e-3 to 0.1.
MIN_ORDER = 4  # so that the two highest polynomials of an element are not all of it
MAX_ORDER = 30  # of an element: from here two halves with the same digits have fewer unknowns
GRADING = 6.0  # ratio of the length of an element to its distance from a singularity, at most
CANCELLED = 1e-2  # least omega^2 that centrifugal and Coriolis forces leave of strain energy 1
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


class SpanElements(NamedTuple):
    """The elements of one span."""

    ends: tuple[float, ...]  # where each element ends, as a fraction of the span: the last is 1
    orders: tuple[int, ...]  # of modes across the beam: the numbers of Gauss points
    axial_orders: tuple[int, ...]  # of modes along it, at most as high


class Elements(NamedTuple):
    """The elements of a mesh, as arguments of `make_mesh`."""

    breaks: tuple[float, ...]
    orders: tuple[int, ...]
    axial_orders: tuple[int, ...]

    @property
    def all_orders(self) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """The orders across the beam and along it: meshes with the same ones form a stack."""
        return self.orders, self.axial_orders

    @property
    def halved(self) -> "Elements":
        """Elements of half the length and the same orders."""
        middles = [(start + end) / 2 for start, end in pairwise(self.breaks)]
        orders, axial_orders = (
            tuple(order for order in row for _ in range(2)) for row in self.all_orders
        )
        return Elements(tuple(sorted((*self.breaks, *middles))), orders, axial_orders)


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


def first_elements(beam: Beam, problem: Problem) -> tuple[Elements, StretchOnGrid | None]:
    """The elements of a beam for the modes of the problem and its tolerance. Of a large strain that
    is not certain to have an equilibrium also its equilibrium on a coarse mesh, else None. Raises
    NoEquilibrium with the limit, and NotConverged.

    Beams whose numbers agree when rounded share their elements: to find these takes longer than to
    solve one of many beams, and beams with the same elements are solved together.
    """
    law = problem.strain_law
    limited = not (problem.rigid_tension or is_small_strain(beam, law))
    if limited and (beam.delta < 0 or not law.stiffens):
        spans, start = first_elements_of_spans(beam, problem)
        return joined_elements(beam, spans), None if has_unique_equilibrium(beam, law) else start
    return joined_elements(beam, elements_by_rounded_numbers(rounded(beam), problem)), None


def joined_elements(beam: Beam, spans: Sequence[SpanElements]) -> Elements:
    """The elements of a beam from those of each of its spans."""
    breaks = [0.0]
    for span, (start, end) in zip(spans, pairwise(ends_of_spans(beam)), strict=True):
        breaks += [start + (end - start) * fraction for fraction in span.ends[:-1]] + [end]
    orders = tuple(order for span in spans for order in span.orders)
    axial_orders = tuple(order for span in spans for order in span.axial_orders)
    return Elements(tuple(breaks), orders, axial_orders)


def rounded(beam: Beam) -> Numbers:
    """The numbers of a beam to four binary digits; the position of the mass by its distance from
    the nearer end."""
    alpha, beta, gamma, delta, mu = numbers_of(beam)
    if not is_uniform(beam):  # the mass stays in its span
        alpha, gamma, delta, mu = map(four_digits, (alpha, gamma, delta, mu))
        return Numbers(alpha, beta, gamma, delta, mu, beam.blade, beam.masses, beam.root)
    if len(ends_of_spans(beam)) == 2:  # no mass, or one at an end
        beta = float(round(beta)) if alpha else 1.0
    else:  # it stays between the ends
        distance = max(four_digits(min(beta, 1 - beta)), 2 * AT_END)
        beta = distance if beta < 0.5 else 1 - distance
    alpha, gamma, delta, mu = map(four_digits, (alpha, gamma, delta, mu))
    return Numbers(alpha, beta, gamma, delta, mu)


def four_digits(x: float) -> float:
    """x, rounded to four binary digits."""
    mantissa, exponent = math.frexp(x)
    return math.ldexp(round(16 * mantissa), exponent - 4)


def first_elements_of_spans(
    beam: AnyBeam, problem: Problem
) -> tuple[list[SpanElements], StretchOnGrid | None]:
    """The elements of each span of a beam, and its equilibrium on a coarse mesh where the strain is
    large, else None. Raises NoEquilibrium and NotConverged."""
    law, start, positions = problem.strain_law, None, unstretched_positions(beam)
    small = problem.rigid_tension or is_small_strain(beam, law)
    if not small:
        start, positions = coarse_equilibrium(beam, law)
    # No tension, no layers.
    loaded = beam
    if not problem.stiffens:
        properties = beam.blade, beam.masses, beam.root
        loaded = Numbers(beam.alpha, beam.beta, 0.0, beam.delta, beam.mu, *properties)
    bending = problem.bending_property
    spans = find_spans(loaded, positions, None if small else law, bending)
    densities = None if beam.blade is None else wave_densities(beam.blade, positions.ends, bending)
    return elements_of_spans(beam.mu, spans, problem, densities), start


@lru_cache(maxsize=64)
def elements_by_rounded_numbers(beam: Numbers, problem: Problem) -> list[SpanElements]:
    """The elements of each span of a beam of rounded numbers."""
    spans, _ = first_elements_of_spans(beam, problem)
    return spans


class WaveDensities(NamedTuple):
    """How waves are distributed along a blade. Frequencies of short waves are (k / bending)^2 and
    mu k / stretching, with k = pi times their number of half-waves along the beam."""

    bending: float  # int (rho / EI)^(1/4) dx
    stretching: float  # int (rho / EA)^(1/2) dx
    of_spans: tuple[float, ...]  # the greater of the densities of both, over that of a uniform beam


def wave_densities(blade: Blade, ends: tuple[float, ...], bending: str) -> WaveDensities:
    """The densities of waves on the spans of a blade. bending: "bending" or "flap"."""
    spans = properties_of_spans(blade, ends, bending)
    bend = np.vecdot(spans.weights, (spans.mass / spans.bending) ** 0.25)
    stretch = np.vecdot(spans.weights, (spans.mass / spans.axial) ** 0.5)
    shares = np.maximum(bend / bend.sum(), stretch / stretch.sum()) / np.diff(ends)
    return WaveDensities(float(bend.sum()), float(stretch.sum()), tuple(shares.tolist()))


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
    waves = max(bending, stretching)
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
