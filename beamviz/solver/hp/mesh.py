"""Gauss-Legendre points on a few elements, and exact integration of what is known there.

A quantity that is a polynomial on each element is known by its values at the Gauss points.
Its integral from the clamp is one matrix J away: u = J f, theta = J kappa, w = J (f theta).
Nothing has to be continuous across elements that is not so in the beam.
"""

from dataclasses import dataclass
from functools import lru_cache
from itertools import accumulate, pairwise

import numpy as np
from numpy.polynomial import legendre


@dataclass(frozen=True)
class Reference:
    """The reference element [-1, 1] with p Gauss points."""

    points: np.ndarray  # (p,)
    weights: np.ndarray  # (p,)
    last_two: np.ndarray  # (p, p) values -> the part of the two highest Legendre polynomials
    tails: np.ndarray  # (2, p) values -> that part in terms of two orthonormal polynomials
    integration: np.ndarray  # (p, p) values -> integral from -1 to each point
    nodes: np.ndarray  # (p + 1,) -1 and the points: where an integral is known
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
    return Reference(*(_frozen(array) for array in arrays))


@dataclass(frozen=True, eq=False)
class Grid:
    """Elements between `breaks`, each with as many Gauss points as its order; n in all. Or a stack
    of such grids with the same orders and breaks of their own, in leading axes.

    J integrates values at the points from the clamp to each point. This is all that values at the
    points need to be functions of x: a solution keeps no more of its mesh.
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
            # Of an element before x all is integrated, of one beyond it nothing.
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
    """A grid, or a stack of them, with what the forms of a beam are assembled from.

    T keeps the part of values at the points that is in the two highest polynomials of each
    element, `tails` that part in terms of orthonormal ones; G = J' W J and g = J' W 1 are the
    inertia of a unit line density in terms of a gradient.
    """

    grid: Grid  # alone
    rooted: np.ndarray  # (..., n, n) roots of the weights times J: rooted' rooted = G
    IJT: np.ndarray  # (..., 2 n, n) the identity and, below it, J, times T
    tails: np.ndarray  # (..., 2 elements, n)
    G: np.ndarray  # (..., n, n)
    G1: np.ndarray  # (..., n) row sums of G
    g: np.ndarray  # (..., n)
    eye: np.ndarray  # (n, n)


@lru_cache(maxsize=128)
def make_mesh(breaks: tuple[float, ...], orders: tuple[int, ...]) -> Mesh:
    """The mesh with elements between `breaks` (0 .. 1, ascending) of these orders."""
    return make_meshes(np.array(breaks), orders)


def make_meshes(breaks: np.ndarray, orders: tuple[int, ...]) -> Mesh:
    """The meshes between `breaks` (..., elements + 1), all of these orders."""
    elements = [reference(order) for order in orders]
    stack, n = breaks.shape[:-1], sum(orders)
    halves = np.diff(breaks)[..., None] / 2
    points, weights = np.empty((*stack, n)), np.empty((*stack, n))
    J, tails = np.zeros((*stack, n, n)), np.zeros((*stack, 2 * len(orders), n))
    T, eye = np.zeros((n, n)), np.eye(n)
    for k, (e, block) in enumerate(zip(elements, _blocks(orders), strict=True)):
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
    breaks, points, weights, J = (_frozen(array) for array in (breaks, points, weights, J))
    grid = Grid(breaks, orders, points, weights, J)
    arrays = (rooted, IJ @ T, tails, G, G.sum(axis=-1), g, eye)
    return Mesh(breaks, orders, points, weights, J, grid, *(_frozen(array) for array in arrays))


def _blocks(orders: tuple[int, ...]) -> list[slice]:
    """The points of each element."""
    ends = [0, *accumulate(orders)]
    return [slice(a, b) for a, b in pairwise(ends)]


def _frozen(array: np.ndarray) -> np.ndarray:
    """The array, made read-only: meshes are shared."""
    array.setflags(write=False)
    return array
