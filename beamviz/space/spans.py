"""The spans of a straight beam, between clamp, bodies, ends of the segments of a blade, and tip.

Within a span everything is smooth. The first mesh needs its properties and, at its ends, the
tension and the stretch.
"""

import math
from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise
from operator import attrgetter
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from beamviz.beam import PARAMETERS, Beam
from beamviz.blade import MAX_DEGREE, Blade, Mass
from beamviz.solver.constitutive import StrainLaw

AT_END = 1e-13  # distance by which rounding may move a body from the end of a span
SAMPLES = 9  # of a span, besides its ends, at which its least stiffness is sought
LEAST = 0.9  # of the least sample of a polynomial, which may fall below it between two samples
# Greatest ratio of a property within an element that spans stations of a blade: from 1.5 to 30 the
# time of seven blades of 33 to 52 stations changes by a quarter.
SPREAD = 3.0
JUMP = 1e-3  # relative, of a property, from which a layer gets an element of its own at once
NEAREST = 1e-5  # least distance to a singularity: the accuracy it is known to


numbers_of = attrgetter(*PARAMETERS)  # alpha, beta, gamma, delta, mu


class Numbers(NamedTuple):
    """The numbers of a straight beam, and its properties where it is not uniform: as of a `Beam`,
    but not checked, because rounded numbers may be just outside their limits."""

    alpha: float
    beta: float
    gamma: float
    delta: float
    mu: float
    blade: Blade | None = None
    masses: tuple[Mass, ...] = ()
    root: float = np.inf


AnyBeam = Beam | Numbers


def is_uniform(beam: AnyBeam) -> bool:
    """Whether it has one section, at most one concentrated mass, and a clamp."""
    return beam.blade is None and not beam.masses and beam.root == np.inf


class Positions(NamedTuple):
    """Positions u of an equilibrium, measured from the clamp, and the mass of the spans."""

    ends: tuple[float, ...]  # x of the ends of the spans
    u: tuple[float, ...]  # at the ends
    means: tuple[float, ...]  # of u in each span, by mass
    masses: tuple[float, ...]  # of each span


class SpanProperties(NamedTuple):
    """Properties of the spans between discontinuities of a blade, at k Gauss points of each and at
    both its ends."""

    x: NDArray  # (spans, k) Gauss points
    weights: NDArray  # (spans, k)
    mass: NDArray  # (spans, k) rho A at the points
    bending: NDArray  # (spans, k) E I
    axial: NDArray  # (spans, k) E A
    bending_at_ends: NDArray  # (spans, 2)
    axial_at_ends: NDArray  # (spans, 2)
    mass_at_ends: NDArray  # (spans, 2)
    least_axial: NDArray  # (spans,)


def ends_of_spans(beam: AnyBeam) -> tuple[float, ...]:
    """x of the clamp, of what is not smooth between clamp and tip (bodies, ends of the segments of
    a blade), and of the tip."""
    if is_uniform(beam):
        inside = beam.alpha > 0 and AT_END < beam.beta < 1 - AT_END
        return (0.0, beam.beta, 1.0) if inside else (0.0, 1.0)
    bodies = [beta for _, beta in masses_and_places(beam)]
    ends = [0.0]
    for x in sorted({*bodies, *(beam.blade.breaks if beam.blade else ())}):
        if ends[-1] + AT_END < x < 1 - AT_END:
            ends.append(x)
    return (*ends, 1.0)


def masses_and_places(beam: AnyBeam) -> list[tuple[float, float]]:
    """alpha and beta of the concentrated mass, if any, and of each of the other bodies."""
    concentrated = [(beam.alpha, beam.beta)] * (beam.alpha > 0)
    return concentrated + [(mass.alpha, mass.beta) for mass in beam.masses]


def unstretched_positions(beam: AnyBeam) -> Positions:
    """The positions of an unstretched beam, u = x."""
    ends = ends_of_spans(beam)
    if beam.blade is None:
        means, masses = zip(*(((a + b) / 2, b - a) for a, b in pairwise(ends)), strict=True)
        return Positions(ends, ends, means, masses)
    spans = properties_of_spans(beam.blade, ends, "bending")
    masses = np.vecdot(spans.weights, spans.mass)
    means = np.vecdot(spans.weights, spans.mass * spans.x) / masses
    return Positions(ends, ends, tuple(means.tolist()), tuple(masses.tolist()))


@lru_cache(maxsize=4)
def properties_of_spans(blade: Blade, ends: tuple[float, ...], bending: str) -> SpanProperties:
    """The properties of the spans of a blade. bending: "bending" or "flap"."""
    start, stop = np.array([ends[:-1], ends[1:]])
    xi, weights = legendre.leggauss(MAX_DEGREE // 2 + 2)  # exact for the static moment
    half = (stop - start)[:, None] / 2
    x = start[:, None] + half * (xi + 1)

    def at_ends(name: str) -> NDArray:
        return np.stack((blade.at(name, start), blade.at(name, stop, inboard=True)), axis=-1)

    axial_at_ends = at_ends("axial")
    inside = blade.at("axial", np.linspace(start, stop, SAMPLES + 2)[1:-1]).min(axis=0)
    least = np.minimum(axial_at_ends.min(axis=-1), inside)
    return SpanProperties(
        x=x,
        weights=half * weights,
        mass=blade.at("mass", x),
        bending=blade.at(bending, x),
        axial=blade.at("axial", x),
        bending_at_ends=at_ends(bending),
        axial_at_ends=axial_at_ends,
        mass_at_ends=at_ends("mass"),
        least_axial=least * (1.0 if blade.degree == 1 else LEAST),
    )


def greatest_force(beam: AnyBeam) -> float:
    """An upper bound of the axial force of the unstretched beam over E A, in units of gamma^2."""
    hub = abs(beam.delta)
    if beam.blade is None:
        moment = 0.5 + hub + beam.alpha * (beam.beta + hub)
        return moment + sum(mass.alpha * (mass.beta + hub) for mass in beam.masses)
    ends, _, means, masses = unstretched_positions(beam)
    least = properties_of_spans(beam.blade, ends, "bending").least_axial.tolist()
    bodies = masses_and_places(beam)
    greatest, moment = 0.0, 0.0
    for k in range(len(least) - 1, -1, -1):  # from the tip
        start, stop = ends[k], ends[k + 1]
        moment += masses[k] * (means[k] + hub)
        moment += sum(
            alpha * (beta + hub) for alpha, beta in bodies if start + AT_END < beta <= stop + AT_END
        )
        greatest = max(greatest, moment / least[k])
    return greatest


class End(NamedTuple):
    """An end of a span at x, on the side of the span."""

    x: float
    inward: int  # 1 where the span begins at x, -1 where it ends
    N: float  # tension
    f: float  # stretch
    slope: float  # -dN/dx
    singularity: float  # the distance from x, away from the span, of a singularity of the stretch
    EI: float  # bending stiffness
    smooth: bool  # whether the next span only has another slope of a property


class Span(NamedTuple):
    """A span of a beam under tension, by its two ends."""

    start: End
    end: End

    @property
    def length(self) -> float:
        """The length of the span, a share of that of the beam."""
        return self.end.x - self.start.x


class EndProperties(NamedTuple):
    """Properties at both ends of each span."""

    EI: Sequence[Sequence[float]]
    EA: Sequence[Sequence[float]]
    mass: Sequence[Sequence[float]]


def properties_at_ends(beam: AnyBeam, ends: tuple[float, ...], bending: str) -> EndProperties:
    """The properties of a beam at both ends of each span between `ends`."""
    if beam.blade is None:
        uniform = [(1.0, 1.0)] * (len(ends) - 1)
        return EndProperties(uniform, uniform, uniform)
    spans = properties_of_spans(beam.blade, ends, bending)
    return EndProperties(
        spans.bending_at_ends.tolist(), spans.axial_at_ends.tolist(), spans.mass_at_ends.tolist()
    )


def find_spans(
    beam: AnyBeam, positions: Positions, law: StrainLaw | None, bending: str
) -> list[Span]:
    """The spans of a beam, clamp first, with N = gamma^2 int_x^1 rho (u + delta) at their ends.
    law: None where the strain is small, and the stretch taken to be 1. bending: "bending" or
    "flap"."""
    ends, u, means, masses = positions
    properties = properties_at_ends(beam, ends, bending)
    bodies = masses_and_places(beam)
    spans: list[Span] = []
    load, N = beam.gamma**2, 0.0

    def end_of_span(k: int, inward: int) -> End:
        span, side = (k, 0) if inward > 0 else (k - 1, 1)
        EI, EA, rho = (values[span][side] for values in properties)
        slope = load * rho * (u[k] + beam.delta)
        smooth = is_smooth(properties, bodies, ends, k)
        if law is None:
            return End(ends[k], inward, N, 1.0, slope, math.inf, EI, smooth)
        f = float(law.stretch_from_force(np.array(N / (beam.mu**2 * EA))))
        # Continued beyond the end, away from the span, the tension grows or falls to a limit.
        least, most = law.force_limits
        limit = beam.mu**2 * EA * (most if inward * slope > 0 else least)
        distance = max(inward * (limit - N) / slope, NEAREST) if slope else math.inf
        return End(ends[k], inward, N, f, slope, distance, EI, smooth)

    for k in range(len(means), 0, -1):  # from the tip
        for alpha, beta in bodies:
            if abs(ends[k] - beta) <= AT_END:
                N += alpha * load * (u[k] + beam.delta)
        end = end_of_span(k, -1)
        N += load * masses[k - 1] * (means[k - 1] + beam.delta)
        spans.insert(0, Span(end_of_span(k - 1, 1), end))
    return spans


def mild_runs(beam: AnyBeam, ends: tuple[float, ...], bending: str) -> list[tuple[int, int]]:
    """The first and the last span of each run of spans without a body or a jump between them, in
    which no property varies by more than a factor SPREAD."""
    count = len(ends) - 1
    if beam.blade is None:
        return [(k, k) for k in range(count)]
    spans, bodies = properties_of_spans(beam.blade, ends, bending), masses_and_places(beam)
    properties = properties_at_ends(beam, ends, bending)
    inside = np.array((spans.bending, spans.axial, spans.mass))  # (3, spans, points)
    least = np.minimum(inside.min(axis=-1), np.array(properties).min(axis=-1))
    most = np.maximum(inside.max(axis=-1), np.array(properties).max(axis=-1))
    runs, first = [], 0
    for k in range(1, count + 1):
        run = slice(first, k + 1)
        mild = (most[:, run].max(axis=-1) <= SPREAD * least[:, run].min(axis=-1)).all()
        if k == count or not (mild and is_smooth(properties, bodies, ends, k)):
            runs.append((first, k - 1))
            first = k
    return runs


def is_smooth(
    properties: EndProperties, bodies: list[tuple[float, float]], ends: tuple[float, ...], k: int
) -> bool:
    """Whether no property jumps at end k, between two spans, and no body is there."""
    if k in (0, len(ends) - 1) or any(abs(ends[k] - beta) <= AT_END for _, beta in bodies):
        return False
    return all(abs(values[k][0] - values[k - 1][1]) <= JUMP * values[k][0] for values in properties)
