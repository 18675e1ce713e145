"""Meshes for the motion in time, and their refinement.

A first mesh has one element on each side of an interior mass, and thinner ones where tension makes
bending layers at the clamp and at the mass. Refinement raises the order of the elements, and halves
those whose order is the highest.
"""

import math
from itertools import pairwise

from beamviz.beam import Beam
from beamviz.dynamics.elements import Elements, elements_between

HIGHEST_ORDER, ORDERS_ADDED = 24, 2
LONG = 0.6  # an element at least so long resolves three bending modes with the second order
FIRST_ORDERS = 6, 8
# A layer of width d is resolved by an element of length 6 d, the first order at least; the next is
# at most 6 times as long. Above a width of 0.15 an element of the whole length suffices.
LAYER, GRADING, WIDEST = 6.0, 6.0, 0.15
AT_END = 1e-6  # distance to the clamp or the tip of a mass that is taken to be there


def interior_mass(beam: Beam) -> bool:
    """Whether the stretch jumps at the mass."""
    return beam.alpha > 0 and AT_END < beam.beta < 1 - AT_END


def first_mesh(beam: Beam, gamma: float) -> Elements:
    """Elements for the layers at a greatest speed gamma."""
    parts = [0.0, beam.beta, 1.0] if interior_mass(beam) else [0.0, 1.0]
    ends = set(parts)
    for start, end in pairwise(parts):
        ends |= {start + x for x in layer_ends(tension(beam, gamma, start), end - start)}
        if end < 1:
            ends |= {end - x for x in layer_ends(tension(beam, gamma, end), end - start)}
    orders = tuple(FIRST_ORDERS[b - a >= LONG] for a, b in pairwise(sorted(ends)))
    return elements_between(tuple(sorted(ends)), orders)


def tension(beam: Beam, gamma: float, x: float) -> float:
    """The size of the axial force at x of the unstretched beam [E I / L^2]."""
    distributed = (1 - x) * ((1 + x) / 2 + beam.delta)
    carried = beam.alpha * (beam.beta + beam.delta) if x <= beam.beta else 0.0
    return gamma**2 * abs(distributed + carried)


def layer_ends(tension: float, length: float) -> list[float]:
    """Distances from a layer of the ends of its elements, within half a length."""
    width = 1 / math.sqrt(max(tension, 1e-12))
    if width > WIDEST * length:
        return []
    distances, reach = [], LAYER * width
    while reach < length / 2:
        distances.append(reach)
        reach *= GRADING
    return distances


def refined(elements: Elements) -> Elements:
    """A mesh of higher orders, or of halves."""
    ends, orders = [0.0], list[int]()
    for (start, end), order in zip(pairwise(elements.ends.tolist()), elements.orders, strict=True):
        if order + ORDERS_ADDED > HIGHEST_ORDER:
            ends += [(start + end) / 2, end]
            orders += [order, order]
        else:
            ends.append(end)
            orders.append(order + ORDERS_ADDED)
    return elements_between(tuple(ends), tuple(orders))


def cubic_mesh(count: int) -> Elements:
    """The paper's elements, of equal length."""
    ends = tuple(k / count for k in range(count)) + (1.0,)
    return elements_between(ends, (3,) * count)
