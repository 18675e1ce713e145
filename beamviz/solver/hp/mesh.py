"""Meshes of a few high-order elements with Gauss-Legendre points.

A quantity that is a polynomial on each element is represented by its values at the Gauss points.
A matrix J integrates it exactly from the clamp: u = J f, theta = J kappa, w = J (f theta). The
quantities integrated may be discontinuous across elements, as at a concentrated mass.
"""

from dataclasses import dataclass
from functools import lru_cache
from itertools import accumulate, pairwise

import numpy as np
from numpy.polynomial import legendre

from beamviz.solver.solution import read_only


@dataclass(frozen=True)
class Reference:
    """The reference element [-1, 1] with p Gauss points."""

    points: np.ndarray  # (p,)
    weights: np.ndarray  # (p,)
    last_two: np.ndarray  # (p, p) projects values onto the two highest Legendre polynomials
    tails: np.ndarray  # (2, p) coefficients of these, normalised
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
    last_two = P[:, -3:-1] @ to_legendre[-2:]
    tails = to_legendre[-2:] / np.sqrt(norms[-2:, None])
    integrals = np.column_stack((points + 1, (P[:, 2:] - P[:, :-2]) / (2 * norms[1:])))
    nodes = np.append(-1.0, points)
    apart = nodes[:, None] - nodes + np.eye(order + 1)
    barycentric = 1 / (2 * apart).prod(axis=1)  # differences of capacity 1: no under- or overflow
    arrays = (points, weights, last_two, tails, integrals @ to_legendre, nodes, barycentric)
    return Reference(*map(read_only, arrays))


@dataclass(frozen=True, eq=False)
class Grid:
    """Elements between `breaks`, each with as many Gauss points as its order; n in all. Or a stack
    of such grids, in leading axes, with the same orders and different breaks.

    J integrates values at the points from the clamp to each point. A solution keeps its grid only,
    which suffices to evaluate it as a function of x.
    """

    breaks: np.ndarray  # (..., elements + 1)
    orders: tuple[int, ...]  # (elements,)
    points: np.ndarray  # (..., n)
    weights: np.ndarray  # (..., n)
    J: np.ndarray  # (..., n, n)

    def __getitem__(self, k: int) -> "Grid":
        """Grid k of a stack."""
        return Grid(self.breaks[k], self.orders, self.points[k], self.weights[k], self.J[k])

    def from_clamp(self, x: np.ndarray) -> np.ndarray:
        """Matrix (..., len(x), n): values at the points -> integral from the clamp to each x; of a
        stack, x is (..., len(x))."""
        rows = np.empty((*x.shape, self.points.shape[-1]))
        for e, block in enumerate(_blocks(self.orders)):
            start, end = self.breaks[..., e, None], self.breaks[..., e + 1, None]
            # Elements before x are integrated completely, those beyond it not at all.
            xi = np.clip((2 * x - start - end) / (end - start), -1, 1)
            half = (end - start)[..., None] / 2
            rows[..., block] = half * reference(self.orders[e]).integrals(xi)
        return rows

    def at(self, x: np.ndarray) -> np.ndarray:
        """Matrix (len(x), n) of one grid: values at the points -> their polynomials at each x; a
        break between two elements is in the left one."""
        rows = np.zeros((len(x), len(self.points)))
        element = np.maximum(np.searchsorted(self.breaks, x) - 1, 0)
        for e, block in enumerate(_blocks(self.orders)):
            inside = element == e
            start, end = self.breaks[e : e + 2]
            xi = (2 * x[inside] - start - end) / (end - start)
            rows[inside, block] = reference(self.orders[e]).values(xi)
        return rows


@dataclass(frozen=True, eq=False)
class Mesh(Grid):
    """A grid, or a stack of them, with the matrices that stiffness and mass are assembled from.

    T projects values at the points onto the two highest Legendre polynomials of each element,
    `tails` gives the coefficients of their orthonormal multiples. G = J' W J and g = J' W 1 are the
    inertia of a unit line density in terms of the gradient of the displacement.
    """

    grid: Grid  # without the matrices
    rooted: np.ndarray  # (..., n, n) roots of the weights times J: rooted' rooted = G
    IJT: np.ndarray  # (..., 2 n, n) the identity and, below it, J, times T
    tails: np.ndarray  # (..., 2 elements, n)
    G: np.ndarray  # (..., n, n)
    G1: np.ndarray  # (..., n) row sums of G
    g: np.ndarray  # (..., n)
    eye: np.ndarray  # (n, n)


@lru_cache(maxsize=128)
def make_mesh(breaks: tuple[float, ...], orders: tuple[int, ...]) -> Mesh:
    """The mesh with elements of these orders between `breaks` (0 .. 1, ascending); cached."""
    return make_meshes(np.array(breaks), orders)


def make_meshes(breaks: np.ndarray, orders: tuple[int, ...]) -> Mesh:
    """A mesh, or a stack of meshes of the same orders, between `breaks` (..., elements + 1)."""
    stack, n = breaks.shape[:-1], sum(orders)
    halves = np.diff(breaks)[..., None] / 2
    points, weights = np.empty((*stack, n)), np.empty((*stack, n))
    J, tails = np.zeros((*stack, n, n)), np.zeros((*stack, 2 * len(orders), n))
    T, eye = np.zeros((n, n)), np.eye(n)
    for k, block in enumerate(_blocks(orders)):
        e = reference(orders[k])
        h = halves[..., k, :]
        points[..., block] = breaks[..., k, None] + h * (e.points + 1)
        weights[..., block] = h * e.weights
        J[..., block, : block.start] = weights[..., None, : block.start]
        J[..., block, block] = h[..., None] * e.integration
        tails[..., 2 * k : 2 * k + 2, block] = np.sqrt(h)[..., None] * e.tails
        T[block, block] = e.last_two
    rooted = np.sqrt(weights)[..., None] * J
    G, g = rooted.mT @ rooted, np.vecmat(weights, J)
    IJ = np.concatenate((np.broadcast_to(eye, J.shape), J), axis=-2)
    breaks, points, weights, J = map(read_only, (breaks, points, weights, J))
    grid = Grid(breaks, orders, points, weights, J)
    arrays = (rooted, IJ @ T, tails, G, G.sum(axis=-1), g, eye)
    return Mesh(breaks, orders, points, weights, J, grid, *map(read_only, arrays))


def _blocks(orders: tuple[int, ...]) -> list[slice]:
    """The points of each element."""
    ends = [0, *accumulate(orders)]
    return [slice(a, b) for a, b in pairwise(ends)]
