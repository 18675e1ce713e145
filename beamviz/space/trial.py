"""Trial functions of stretch and bending on elements longer than the distance of the stations of a
blade.

Where a property or its slope jumps, the stretch and the curvature jump with it, but the axial force
and the bending moment are smooth. So a change of the stretch is a polynomial over E A, one of the
curvature a polynomial over E I, and an element may span many stations. Integrals are sums over
pieces, between stations and ends of elements, each with Gauss points of its own.

The functions are orthonormal in the energy at rest (of mu = 1), so that their coefficients are in
natural units and the two highest of each element, its tail, estimate what those left out carry.
"""

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from beamviz.blade import Blade
from beamviz.space.elements import Elements
from beamviz.space.grid import Grid, make_grid

# Gauss points of a piece, more than half-waves of the highest polynomial in it: seven more change
# frequencies by 2e-9 at most (three blades).
MORE_POINTS = 1
# Functions in the tail of an element with stations inside, where single coefficients may vanish:
# with four the errors of 31 random deflected blades are at most 0.2 of their bars, with two 11.
KINKED_TAIL = 4
SHORTEST = 1e-9  # piece, relative to the beam: a station nearer to the end of an element is there


class Pieces(NamedTuple):
    """Pieces of elements, as arguments of `make_grid`, and the number of them in each element."""

    breaks: tuple[float, ...]
    orders: tuple[int, ...]
    counts: tuple[int, ...]


def pieces_of(elements: Elements, blade: Blade | None, bending: str, share: float) -> Pieces:
    """The pieces of elements between the ends of the segments of a blade, with as many Gauss points
    as the trial functions need. share: of the energy of a mode that may be lost."""
    if blade is None:
        return Pieces(elements.breaks, elements.orders, (1,) * len(elements.orders))
    breaks, orders, counts = [0.0], [], []
    for (start, stop), order in zip(pairwise(elements.breaks), elements.orders, strict=True):
        inside = [x for x in blade.breaks if start + SHORTEST < x < stop - SHORTEST]
        ends = [start, *inside, stop]
        counts.append(len(ends) - 1)
        breaks += ends[1:]
        for a, b in pairwise(ends):
            # A polynomial of degree n has cos(n phi) as its waves, x = cos(phi).
            phi = [math.acos(np.clip(2 * (x - start) / (stop - start) - 1, -1, 1)) for x in (b, a)]
            waves = order * (phi[1] - phi[0]) / math.pi
            orders.append(
                math.ceil(waves) + MORE_POINTS + order_of_quotient(blade, bending, a, b, share)
            )
    return Pieces(tuple(breaks), tuple(orders), tuple(counts))


def order_of_quotient(blade: Blade, bending: str, start: float, stop: float, share: float) -> int:
    """The number of Gauss points that 1 over the properties of a blade takes in a piece, by the
    roots of their polynomials (Bernstein)."""
    nearest = math.inf  # the size of the least ellipse around the piece through a root
    for segment in blade.segments:
        if not segment.start <= (start + stop) / 2 <= segment.stop:
            continue
        for name in (bending, "axial"):
            roots = np.array(segment.polynomials[name].roots(), complex)
            x = segment.start + (segment.stop - segment.start) * roots
            z = (2 * x - start - stop) / (stop - start)
            size = abs(z + np.sqrt(z - 1) * np.sqrt(z + 1))
            nearest = min([nearest, *size])
    return math.ceil(math.log(1 / share) / (4 * math.log(nearest))) if nearest < math.inf else 0


class Block(NamedTuple):
    """The p points and the functions of an element, all in it. Matrices of all points and functions
    would hold little but zeros."""

    points: slice
    along: slice  # numbers of the functions of stretch
    across: slice  # numbers of the functions of bending
    stretch: NDArray  # (p, functions of stretch)
    bending: NDArray  # (p, functions of bending)


@dataclass(frozen=True, eq=False)
class Trial:
    """Trial functions on the elements of a beam, with its properties at the Gauss points: n points,
    in all r functions of bending, of the orders of the elements, and of stretch of their axial
    orders."""

    elements: Elements
    grid: Grid  # of the pieces
    J: NDArray  # (n, n) integrates values at the points from the clamp to each point
    counts: tuple[int, ...]  # of pieces of each element
    mass: NDArray  # (n,) rho A
    EI: NDArray  # (n,)
    EA: NDArray  # (n,)
    blocks: list[Block]  # of each element

    @cached_property
    def angle(self) -> NDArray:
        """Integrals (n, r) of the functions of bending, from the clamp."""
        angle = np.zeros((len(self.mass), sum(self.elements.orders)))
        for points, _, across, _, bending in self.blocks:
            angle[points, across] = self.J[points, points] @ bending
            angle[points.stop :, across] = self.grid.weights[points] @ bending
        return angle

    @cached_property
    def element_of_points(self) -> NDArray:
        """The number of the element of each point (n,)."""
        pieces = np.repeat(np.arange(len(self.counts)), self.counts)
        return np.repeat(pieces, self.grid.orders)

    @cached_property
    def highest(self) -> list[tuple[NDArray, NDArray]]:
        """Numbers of the highest functions of each element, of stretch and of bending: the two
        highest, more where a property has kinks inside."""
        tails = [KINKED_TAIL if count > 1 else 2 for count in self.counts]
        return [
            (np.arange(along.stop - tail, along.stop), np.arange(across.stop - tail, across.stop))
            for (_, along, across, _, _), tail in zip(self.blocks, tails, strict=True)
        ]

    def tails(self, stretch: NDArray, bending: NDArray) -> tuple[NDArray, NDArray]:
        """What the highest functions of each element contribute to values (n,) of stretch and of
        bending."""
        axial, across = self.grid.weights * (self.EA * stretch, self.EI * bending)
        tails = np.empty((2, len(axial)))
        for block, (along, of_bending) in zip(self.blocks, self.highest, strict=True):
            f, kappa = block.stretch[:, -len(along) :], block.bending[:, -len(of_bending) :]
            tails[0, block.points] = f @ (axial[block.points] @ f)
            tails[1, block.points] = kappa @ (across[block.points] @ kappa)
        return tails[0], tails[1]


def make_trial(elements: Elements, blade: Blade | None, bending: str, share: float) -> Trial:
    """The trial functions on elements. bending: the property that is the bending stiffness."""
    pieces = pieces_of(elements, blade, bending, share)
    grid = make_grid(np.array(pieces.breaks), pieces.orders)
    n, x = len(grid.points), grid.points
    rho = EI = EA = np.ones(n)
    if blade is not None:
        rho, EI, EA = (blade.at(name, x) for name in ("mass", bending, "axial"))
    blocks = []
    ends = zip(_blocks(elements, pieces), pairwise(elements.breaks), strict=True)
    for (points, along, across), (start, stop) in ends:
        xi, w = (2 * x[points] - start - stop) / (stop - start), grid.weights[points]
        stretch = orthonormal(xi, w, EA[points], along.stop - along.start)
        bending_functions = orthonormal(xi, w, EI[points], across.stop - across.start)
        blocks.append(Block(points, along, across, stretch, bending_functions))
    return Trial(elements, grid, grid.integration_matrix, pieces.counts, rho, EI, EA, blocks)


@lru_cache(maxsize=1)
def cached_trial(elements: Elements, blade: Blade | None, bending: str, share: float) -> Trial:
    """`make_trial`, cached for the next of many beams on the same elements."""
    return make_trial(elements, blade, bending, share)


def orthonormal(xi: NDArray, w: NDArray, rigidity: NDArray, count: int) -> NDArray:
    """The first `count` polynomials over a rigidity (p,) that are orthonormal in the energy, at p
    points xi in -1 .. 1 with weights w: (p, count)."""
    P = legendre.legvander(xi, count - 1)
    Q, _ = np.linalg.qr(np.sqrt(w / rigidity)[:, None] * P)
    return Q / np.sqrt(w * rigidity)[:, None]


def _blocks(elements: Elements, pieces: Pieces) -> list[tuple[slice, slice, slice]]:
    """The points, the functions of stretch and those of bending of each element."""
    points = np.cumsum([0, *pieces.orders])[np.cumsum([0, *pieces.counts])]
    along, across = (np.cumsum([0, *row]) for row in (elements.axial_orders, elements.orders))
    rows = ((slice(*ends) for ends in pairwise(row.tolist())) for row in (points, along, across))
    return list(zip(*rows, strict=True))
