"""Gauss points between breaks, and integrals from the clamp of what has values there.

A quantity that is a polynomial between breaks is represented by its values at the Gauss points. A
matrix J integrates it exactly from the clamp: u = J f, theta = J kappa, w = J (f theta). What is
integrated may be discontinuous at the breaks, as at a concentrated mass.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import accumulate, pairwise
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre

from beamviz.solver.solution import read_only

SMALL = 400  # points of a mesh whose matrices are cached: those of larger ones take megabytes


@dataclass(frozen=True)
class Reference:
    """The reference element [-1, 1] with p Gauss points."""

    points: np.ndarray  # (p,)
    weights: np.ndarray  # (p,)
    legendre: np.ndarray  # (p, p) orthonormal polynomials, each times the roots of the weights
    integration: np.ndarray  # (p, p) integrates values from -1 to each point
    nodes: np.ndarray  # (p + 1,) -1 and the points: nodes of an integral
    barycentric: np.ndarray  # (p + 1,) weights of interpolation between the nodes

    def values(self, xi: np.ndarray) -> np.ndarray:
        """Matrix (..., p): values at the points -> their polynomial at each xi (...)."""
        return interpolation_matrix(xi, self.points, self.barycentric[1:] * (self.points + 1))

    def integrals(self, xi: np.ndarray) -> np.ndarray:
        """Matrix (..., p): values at the points -> the integral from -1 to each xi (...)."""
        return interpolation_matrix(xi, self.nodes, self.barycentric)[..., 1:] @ self.integration


def interpolation_matrix(xi: np.ndarray, nodes: np.ndarray, barycentric: np.ndarray) -> np.ndarray:
    """Matrix (..., nodes): values at the nodes -> their interpolant at each xi (...), by Berrut &
    Trefethen (2004, eq. 4.2)."""
    away = xi[..., None] - nodes
    hits = away == 0
    if hits.any():
        away[hits.any(axis=-1)] = np.inf
        away[hits] = 1.0
    terms = barycentric / away
    return terms / terms.sum(axis=-1, keepdims=True)


@lru_cache(maxsize=64)
def reference(order: int) -> Reference:
    """The reference element with `order` Gauss points."""
    points, weights = legendre.leggauss(order)
    norms = np.arange(order) + 0.5
    P = legendre.legvander(points, order)
    to_legendre = norms[:, None] * P[:, :-1].T * weights
    normalised = np.sqrt(norms * weights[:, None]) * P[:, :-1]
    integrals = np.column_stack((points + 1, (P[:, 2:] - P[:, :-2]) / (2 * norms[1:])))
    nodes = np.append(-1.0, points)
    apart = nodes[:, None] - nodes + np.eye(order + 1)
    barycentric = 1 / (2 * apart).prod(axis=1)  # differences of capacity 1: no under- or overflow
    arrays = (points, weights, normalised, integrals @ to_legendre, nodes, barycentric)
    return Reference(*map(read_only, arrays))


class Located(NamedTuple):
    """Points in elements of one order: k of all. xi: their coordinate within -1 .. 1."""

    order: int
    places: np.ndarray  # (k,) indices among all points
    columns: np.ndarray  # (k, order) indices of the Gauss points of their elements
    xi: np.ndarray  # (k,)
    half: np.ndarray  # (k,) half the length of their elements


@dataclass(frozen=True, eq=False)
class Grid:
    """Pieces between `breaks`, each with as many Gauss points as its order; n in all. Or a stack of
    such grids, in leading axes, with the same orders and different breaks. A solution keeps its
    grid only, which suffices to evaluate it as a function of x.
    """

    breaks: np.ndarray  # (..., pieces + 1)
    orders: tuple[int, ...]  # (pieces,)
    points: np.ndarray  # (..., n)
    weights: np.ndarray  # (..., n)

    def __getitem__(self, k: int) -> "Grid":
        """Grid k of a stack."""
        breaks, points, weights = self.breaks[k], self.points[k], self.weights[k]
        return Grid(breaks, self.orders, points, weights)

    @property
    def integration_matrix(self) -> np.ndarray:
        """J (..., n, n), read-only."""
        *stack, n = self.points.shape
        J = np.zeros((*stack, n, n))
        halves = np.diff(self.breaks)[..., None, None] / 2
        for k, (order, block) in enumerate(zip(self.orders, blocks(self.orders), strict=True)):
            J[..., block, : block.start] = self.weights[..., None, : block.start]
            J[..., block, block] = halves[..., k, :, :] * reference(order).integration
        return read_only(J)

    def integrals(self, values: np.ndarray, out: np.ndarray | None = None) -> np.ndarray:
        """J times values (..., n, k), element by element: faster for many columns. out: array of
        the result, which may be that of the values."""
        result, total = np.empty_like(values) if out is None else out, 0.0
        halves = np.diff(self.breaks)[..., None, None] / 2
        for k, (order, block) in enumerate(zip(self.orders, blocks(self.orders), strict=True)):
            here, weights = values[..., block, :], self.weights[..., None, block]
            integration = halves[..., k, :, :] * reference(order).integration
            integral = total + integration @ here
            total = total + weights @ here
            result[..., block, :] = integral
        return result

    def from_clamp(self, x: np.ndarray) -> np.ndarray:
        """Matrix (..., len(x), n): values at the points -> integral from the clamp to each x; of a
        stack, x is (..., len(x))."""
        before = np.repeat(self.breaks[..., 1:], self.orders, axis=-1)[..., None, :] <= x[..., None]
        rows = np.where(before, self.weights[..., None, :], 0.0)  # of whole elements before each x
        for order, places, columns, xi, half in self._located(x):
            integrals = half[:, None] * reference(order).integrals(xi)
            rows.reshape(-1, rows.shape[-1])[places[:, None], columns] = integrals
        return rows

    def at(self, x: np.ndarray) -> np.ndarray:
        """Matrix (len(x), n) of one grid: values at the points -> their polynomials at each x; a
        break between two elements is in the left one."""
        rows = np.zeros((len(x), len(self.points)))
        for order, places, columns, xi, _ in self._located(x):
            rows[places[:, None], columns] = reference(order).values(xi)
        return rows

    def _located(self, x: np.ndarray) -> Iterator[Located]:
        """The elements of all x (..., len(x)), those of each order in turn; a break is in the left
        one."""
        elements = (x[..., None] > self.breaks[..., None, 1:-1]).sum(axis=-1)
        orders, firsts = np.array(self.orders), np.cumsum([0, *self.orders[:-1]])
        starts, ends = (
            np.take_along_axis(breaks, elements, axis=-1)
            for breaks in (self.breaks[..., :-1], self.breaks[..., 1:])
        )
        xi, half = (2 * x - starts - ends) / (ends - starts), (ends - starts) / 2
        for order in set(self.orders):
            of_order = orders[elements] == order
            columns = firsts[elements[of_order]][:, None] + np.arange(order)
            yield Located(order, np.flatnonzero(of_order), columns, xi[of_order], half[of_order])


class Inertia(NamedTuple):
    """The inertia of a line density in terms of the gradient of the displacement."""

    G: np.ndarray  # (..., n, n) J' W J
    G1: np.ndarray  # (..., n) row sums of G
    g: np.ndarray  # (..., n) J' W 1


@dataclass(frozen=True, eq=False)
class Mesh:
    """A grid, or a stack of them, with the matrix of its integrals."""

    grid: Grid
    J: np.ndarray  # (..., n, n) integrates values at the points from the clamp to each point

    @property
    def is_small(self) -> bool:
        """Whether what belongs to it is cached."""
        return self.J.shape[-1] <= SMALL

    @cached_property
    def inertia(self) -> Inertia:
        """The inertia of a unit line density; that of a blade does not need it."""
        return inertia_of(self, self.grid.weights)


def inertia_of(mesh: Mesh, mass: np.ndarray) -> Inertia:
    """The inertia of a mass (..., n) at the points of a mesh.

    All that is further out than x moves by what is integrated at x, times its weight w. So of two
    points i, j in different pieces, j further out, G_ij = w_i g_j.
    """
    J, w = mesh.J, mesh.grid.weights
    g = np.vecmat(mass, J)
    upper = w[..., :, None] * g[..., None, :]
    G = np.triu(upper)
    G += np.triu(upper, 1).mT
    beyond = mass.sum(axis=-1)[..., None, None]
    for block in blocks(mesh.grid.orders):
        inside, rows = mass[..., block, None], J[..., block, block]
        beyond = beyond - inside.sum(axis=-2, keepdims=True)
        inner = w[..., block, None]
        G[..., block, block] = rows.mT @ (inside * rows) + beyond * inner * inner.mT
    return Inertia(*map(read_only, (G, G.sum(axis=-1), g)))


def make_mesh(breaks: tuple[float, ...], orders: tuple[int, ...]) -> Mesh:
    """The mesh with pieces of these orders between `breaks` (0 .. 1, ascending); a small one is
    cached."""
    return (_cached_mesh if sum(orders) <= SMALL else _mesh)(breaks, orders)


def _mesh(breaks: tuple[float, ...], orders: tuple[int, ...]) -> Mesh:
    """`make_mesh` without a cache."""
    grid = make_grid(np.array(breaks), orders)
    return Mesh(grid, grid.integration_matrix)


_cached_mesh = lru_cache(maxsize=4)(_mesh)


def make_grid(breaks: np.ndarray, orders: tuple[int, ...]) -> Grid:
    """A grid, or a stack of grids of the same orders, between `breaks` (..., pieces + 1)."""
    stack, n = breaks.shape[:-1], sum(orders)
    halves = np.diff(breaks)[..., None] / 2
    points, weights = np.empty((*stack, n)), np.empty((*stack, n))
    for k, (order, block) in enumerate(zip(orders, blocks(orders), strict=True)):
        e = reference(order)
        h = halves[..., k, :]
        points[..., block] = breaks[..., k, None] + h * (e.points + 1)
        weights[..., block] = h * e.weights
    arrays = map(read_only, (points, weights))
    return Grid(read_only(breaks), orders, *arrays)


def blocks(orders: tuple[int, ...]) -> list[slice]:
    """The points of each piece."""
    ends = [0, *accumulate(orders)]
    return [slice(a, b) for a, b in pairwise(ends)]
