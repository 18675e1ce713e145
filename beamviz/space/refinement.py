"""Errors and refinement by the tails: what the highest functions of an element carry estimates what
those left out would; an element in which that is too much gets a higher order, or is halved."""

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from beamviz.blade import Blade
from beamviz.space.elements import Elements

# Safety factor of the truncation error: twice the least for which the errors of 5000 random beams
# over the accepted domain were within their estimates (scripts/measure_error_bars.py).
TRUNCATION_FACTOR = 10.0
# Of the error allowed, share that the quadrature of a blade may have. 80 blades with dips take as
# long with ten times as much and a quarter more time with a tenth; with ten times as much elements
# are refined in vain where a frequency nearly vanishes.
QUADRATURE = 0.1
MAX_ORDER = 30  # of an element: from here two halves with the same digits have fewer unknowns
KINKED_ORDER = 16  # of an element with stations of a blade inside
MORE_ORDER = 2  # added to an element, and one for each digit that it misses


def quadrature_share(tolerance: float) -> float:
    """The share of the energy of a mode that the quadrature of a blade may lose."""
    return QUADRATURE * tolerance / TRUNCATION_FACTOR


def truncation_errors(tail: NDArray, scale: NDArray, lost: NDArray, stretch: NDArray) -> NDArray:
    """Estimated errors of omega^2 (..., modes, elements) from the order of each element.

    tail: energies (..., modes, elements) of its highest functions in modes of unit modal mass.
    scale: of omega^2 (..., modes) without any softening. lost: relative error of the state
    (..., elements), or (..., 1, elements). stretch: at the clamp, at least 1: a large one varies
    almost singularly along the beam, and the error then exceeds the tail.
    """
    # The tail of a mode may nearly vanish by chance: it is at least that of each lower mode,
    # relative to its scale.
    relative = np.maximum.accumulate(tail / scale[..., None], axis=-2)
    return TRUNCATION_FACTOR * stretch * scale[..., None] * (relative + lost)


def refined(elements: Elements, excess: Sequence[float], blade: Blade | None = None) -> Elements:
    """Finer elements where the error is more than an even share of what is allowed: of a higher
    order, or halves where that would be above MAX_ORDER. excess: of each element, the error
    relative to what is allowed for all. blade: whose stations may be inside of elements, and are
    where these are divided."""
    breaks, orders, axial_orders = [0.0], [], []
    ends, columns = pairwise(elements.breaks), (*elements.all_orders, excess)
    for (start, end), order, axial_order, share in zip(ends, *columns, strict=True):
        missed = share * len(excess)  # relative to an even share
        more = MORE_ORDER + math.ceil(math.log10(missed)) if missed > 1 else 0
        inside = [x for x in blade.breaks if start < x < end] if blade else []
        halves = 2 if order + more > (KINKED_ORDER if inside else MAX_ORDER) else 1
        if halves == 1:
            order += more
        else:
            middle = (start + end) / 2
            breaks.append(min(inside, key=lambda x: abs(x - middle)) if inside else middle)
        breaks.append(end)
        orders += [order] * halves
        axial_orders += [min(axial_order + more, order)] * halves
    return Elements(tuple(breaks), tuple(orders), tuple(axial_orders))
