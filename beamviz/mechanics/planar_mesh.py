"""The first mesh of a beam that deflects or moves: elements graded towards the layers of bending of
the beam folded over, to where the load pulls it."""

import math
from collections.abc import Iterator
from contextlib import suppress
from itertools import pairwise
from typing import NamedTuple

from beamviz.beam import Beam
from beamviz.errors import NoEquilibrium, NotConverged
from beamviz.mechanics.straight_equilibrium import coarse_equilibrium, is_small_strain
from beamviz.solver.problem import Problem
from beamviz.space.elements import Elements
from beamviz.space.spans import Span, find_spans, unstretched_positions

FIRST_ORDER, LONGEST_ELEMENT = 10, 0.5


class Grading(NamedTuple):
    """How elements are graded towards a bending layer. layer: length of the first one, in widths
    of the layer; ratio: of neighbours; widest: layer that gets elements of its own, over the length
    of its part of the beam."""

    layer: float
    ratio: float
    widest: float


# The first elements of the straight beam folded over have half as many unknowns and solve spin-ups
# in half the time, but of 60 deflected beams two then had error bars a tenth too small and one a
# limit that was 0.2 % too low: they resolve the straight modes and leave little to spare.
LAYERS = Grading(layer=3.0, ratio=4.0, widest=math.inf)


def folded_over(beam: Beam) -> Beam:
    """The beam turned over at its clamp, to where the load pulls it: a straight outward one."""
    load = max(beam.gamma**2, abs(beam.spin_up))
    return beam.replace(gamma=math.sqrt(load), delta=abs(beam.delta), spin_up=0.0)


def layer_widths(beam: Beam, problem: Problem) -> list[tuple[Span, list[float]]]:
    """The parts of the beam folded over, and the widths of the bending layers at both ends of each:
    sqrt of bending stiffness over tension."""
    folded, law = folded_over(beam), problem.strain_law
    positions = unstretched_positions(folded)
    if not is_small_strain(folded, law):
        with suppress(NoEquilibrium, NotConverged):  # more force than the law has
            _, positions = coarse_equilibrium(folded, law)
    spans = find_spans(folded, positions, law, problem.bending_property)
    power = 2 * problem.curvature_power - 3
    return [
        (span, [math.sqrt(end.EI / (max(end.N, end.EI) * end.f**power)) for end in span])
        for span in spans
    ]


def graded_breaks(beam: Beam, problem: Problem, grading: Grading) -> list[float]:
    """Ends of elements graded towards the layers of bending at the clamp, at bodies and at jumps of
    a property."""
    breaks = {0.0}
    for span, (first, last) in layer_widths(beam, problem):
        start, end = span.start.x, span.end.x
        length = end - start
        if not span.start.smooth and first < grading.widest * length:
            away = distances(grading.layer * first, grading.ratio, length / 2)
            breaks |= {start + distance for distance in away}
        if end == 1 or not span.end.smooth:
            breaks.add(end)
        if end < 1 and not span.end.smooth and last < grading.widest * length:
            away = distances(grading.layer * last, grading.ratio, length / 2)
            breaks |= {end - distance for distance in away}
    return sorted(breaks)


def first_elements(beam: Beam, problem: Problem) -> Elements:
    """Elements graded towards the layers of bending."""
    starts: list[float] = []  # of the elements
    for a, b in pairwise(graded_breaks(beam, problem, LAYERS)):
        n = math.ceil((b - a) / LONGEST_ELEMENT)
        starts += [a + (b - a) * k / n for k in range(n)]
    orders = (FIRST_ORDER,) * len(starts)
    return Elements((*starts, 1.0), orders, orders)


def distances(first: float, ratio: float, longest: float) -> Iterator[float]:
    """Distances of graded breaks from the end of a span, below `longest`."""
    while first < longest:
        yield first
        first *= ratio
