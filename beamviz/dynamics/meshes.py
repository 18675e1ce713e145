"""Meshes for the motion in time, and their refinement.

A first mesh has one element between two bodies or jumps of a property, and thinner ones where
tension makes bending layers. Refinement raises the order of the elements, and halves those whose
order is the highest. The stretch has no layers and takes half the order of the bending.
"""

from itertools import pairwise

from beamviz.beam import Beam
from beamviz.mechanics.planar_mesh import Grading, graded_breaks
from beamviz.solver.problem import Problem
from beamviz.space.elements import Elements

HIGHEST_ORDER, ORDERS_ADDED = 24, 2
LONG = 0.6  # an element at least so long resolves three bending modes with the second order
FIRST_ORDERS = 6, 8
# A layer of width d is resolved by an element of length 6 d, the first order at least; the next is
# at most 6 times as long. Above a width of 0.15 an element of the whole length suffices.
LAYERS = Grading(layer=6.0, ratio=6.0, widest=0.15)


def first_mesh(beam: Beam, problem: Problem) -> Elements:
    """Elements for the layers at the speed of a beam."""
    breaks = graded_breaks(beam, problem, LAYERS)
    return with_orders(breaks, [FIRST_ORDERS[b - a >= LONG] for a, b in pairwise(breaks)])


def refined(elements: Elements) -> Elements:
    """A mesh of higher orders, or of halves."""
    breaks, orders = [0.0], list[int]()
    for (start, end), order in zip(pairwise(elements.breaks), elements.orders, strict=True):
        if order + ORDERS_ADDED > HIGHEST_ORDER:
            breaks += [(start + end) / 2, end]
            orders += [order, order]
        else:
            breaks.append(end)
            orders.append(order + ORDERS_ADDED)
    return with_orders(breaks, orders)


def with_orders(breaks: list[float], orders: list[int]) -> Elements:
    """Elements of these orders across the beam."""
    return Elements(tuple(breaks), tuple(orders), tuple(order // 2 + 1 for order in orders))
