"""The first mesh of a straight beam, from its spans under the tension of a coarse equilibrium.

Beams whose numbers agree when rounded share their elements.
"""

import math
from functools import lru_cache

from beamviz.beam import Beam
from beamviz.mechanics.straight_equilibrium import (
    StretchOnGrid,
    coarse_equilibrium,
    has_unique_equilibrium,
    is_small_strain,
)
from beamviz.solver.problem import Problem
from beamviz.space.elements import Elements, SpanElements, joined_elements
from beamviz.space.first_mesh import elements_of_spans, wave_densities
from beamviz.space.spans import (
    AT_END,
    AnyBeam,
    Numbers,
    Span,
    ends_of_spans,
    find_spans,
    is_uniform,
    mild_runs,
    numbers_of,
    unstretched_positions,
)


def first_elements(beam: Beam, problem: Problem) -> tuple[Elements, StretchOnGrid | None]:
    """The elements of a beam for the modes of the problem and its tolerance. Of a large strain that
    is not certain to have an equilibrium also its equilibrium on a coarse mesh, else None. Raises
    NoEquilibrium with the limit, and NotConverged.

    Beams whose numbers agree when rounded share their elements: to find these takes longer than to
    solve one of many beams, and beams with the same elements are solved together.
    """
    law = problem.strain_law
    limited = not (problem.rigid_tension or is_small_strain(beam, law))
    start = None
    if limited and (beam.delta < 0 or not law.stiffens):
        spans, start = first_elements_of_spans(beam, problem)
        start = None if has_unique_equilibrium(beam, law) else start
    else:
        spans = elements_by_rounded_numbers(rounded(beam), problem)
    return joined_elements(ends_of_spans(beam), spans), start


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
    """The elements of each run of spans of a beam, and its equilibrium on a coarse mesh where the
    strain is large, else None. Raises NoEquilibrium and NotConverged."""
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
    runs = mild_runs(beam, positions.ends, bending)
    return elements_of_runs(beam, spans, runs, problem), start


def elements_of_runs(
    beam: AnyBeam, spans: list[Span], runs: list[tuple[int, int]], problem: Problem
) -> list[SpanElements]:
    """The elements of each run of spans, given by the first and the last of it."""
    densities = None
    if beam.blade is not None:
        ends = tuple([span.start.x for span in spans] + [1.0])
        densities = wave_densities(beam.blade, ends, runs, problem.bending_property)
    joined = [Span(spans[first].start, spans[last].end) for first, last in runs]
    rows = elements_of_spans(beam.mu, joined, problem, densities)
    return [
        row._replace(spans=last - first + 1) for row, (first, last) in zip(rows, runs, strict=True)
    ]


@lru_cache(maxsize=64)
def elements_by_rounded_numbers(beam: Numbers, problem: Problem) -> list[SpanElements]:
    """The elements of each span of a beam of rounded numbers."""
    spans, _ = first_elements_of_spans(beam, problem)
    return spans
