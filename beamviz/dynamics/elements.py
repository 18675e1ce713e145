"""Positions as polynomials on a few elements: the unknowns of the motion in time.

Each component of r(x) is a polynomial of order p >= 3 on each element: the cubic Hermite functions
of its ends, which share position and gradient with the neighbour, and internal functions whose
second derivatives are the Legendre polynomials of degree 2 .. p - 2. With p = 3 these are the
paper's elements (eqs. 2-6); their mass, Coriolis and centrifugal matrices are constant for any p.

At an interior concentrated mass the axial force jumps, and with it the stretch |r'|. There each
side has a gradient of its own, and the directions are held together by an interior penalty (see
`beamviz.dynamics.joint`).

The clamp holds r(0) and the direction of r'(0); the length of r'(0) is free.
"""

from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from beamviz.solver.fem.elements import gauss, hermite
from beamviz.solver.solution import read_only

EXTRA_POINTS = 3  # Gauss points of an element: its order and these (the energy is no polynomial)


@dataclass(frozen=True, eq=False)
class PositionElements:
    """Functions of one component: `count` of them, and which of them the clamp leaves free.

    ends: of the elements (e + 1,); orders: (e,); jump: the element end at which the gradient is
    not shared, None where there is none. points, weights: (m,) of Gauss on all elements. S, dS,
    ddS: all functions and their derivatives at the points (m, count).
    """

    ends: NDArray
    orders: tuple[int, ...]
    jump: int | None
    count: int
    points: NDArray
    weights: NDArray
    S: NDArray
    dS: NDArray
    ddS: NDArray

    @property
    def free(self) -> NDArray:
        """Which of the 2 `count` functions of both components are free: r(0) = 0, r2'(0) = 0."""
        fixed = [0, self.count, self.count + 1]
        return np.setdiff1d(np.arange(2 * self.count), fixed)

    def at(
        self, x: NDArray, derivative: int = 0, side: Literal["left", "right"] = "left"
    ) -> NDArray:
        """All functions, or a derivative of them, at points x of the beam: (len(x), count). A point
        between two elements belongs to the one on this side of it."""
        element = np.clip(np.searchsorted(self.ends, x, side) - 1, 0, len(self.orders) - 1)
        rows = np.zeros((len(x), self.count))
        for e in range(len(self.orders)):
            inside = np.flatnonzero(element == e)
            length = self.ends[e + 1] - self.ends[e]
            local = functions((x[inside] - self.ends[e]) / length, length, self.orders[e])
            rows[np.ix_(inside, self.numbers(e))] = local[derivative]
        return rows

    def numbers(self, e: int) -> NDArray:
        """The functions of element e: those of its ends, then its internal ones."""
        ends = np.arange(2 * e, 2 * e + 4)
        if e == self.jump:
            ends[1] = 2 * len(self.ends)
        first = 2 * len(self.ends) + (self.jump is not None)
        first += sum(order - 3 for order in self.orders[:e])
        return np.append(ends, np.arange(first, first + self.orders[e] - 3))


def functions(xi: NDArray, length: float, order: int) -> tuple[NDArray, NDArray, NDArray]:
    """The functions of an element of a length, and their two derivatives by x, at xi = 0 .. 1:
    (len(xi), order + 1) each."""
    ends = hermite(xi, length)
    if order == 3:
        return ends
    z, half = 2 * xi - 1, length / 2
    second = np.eye(order - 1)[:, 2:]  # Legendre coefficients of the second derivatives
    first = legendre.legint(second, lbnd=-1)
    value = legendre.legint(first, lbnd=-1)
    internal = [
        factor * legendre.legval(z, coefficients).T
        for factor, coefficients in ((half**2, value), (half, first), (1.0, second))
    ]
    S, dS, ddS = (np.hstack(pair) for pair in zip(ends, internal, strict=True))
    return S, dS, ddS


@lru_cache(maxsize=32)
def position_elements(
    ends: tuple[float, ...], orders: tuple[int, ...], jump: int | None
) -> PositionElements:
    """The elements between `ends` (0 .. 1, ascending), cached."""
    count = 2 * len(ends) + (jump is not None) + sum(order - 3 for order in orders)
    parts: list[tuple[NDArray, NDArray]] = []
    for (start, end), order in zip(pairwise(ends), orders, strict=True):
        points, weights = gauss(2 * (order + EXTRA_POINTS) - 1)
        parts.append((start + (end - start) * points, (end - start) * weights))
    points, weights = map(np.concatenate, zip(*parts, strict=True))
    empty = np.zeros((0, count))
    bare = PositionElements(
        np.array(ends), orders, jump, count, points, weights, empty, empty, empty
    )
    S, dS, ddS = (read_only(bare.at(points, k)) for k in range(3))
    arrays = read_only(bare.ends), orders, jump, count, read_only(points), read_only(weights)
    return PositionElements(*arrays, S, dS, ddS)
