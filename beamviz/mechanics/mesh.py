"""Gauss-Legendre points on a few elements, and exact integration of what is known there.

A quantity that is a polynomial on each element is known by its values at the Gauss points.
Its integral from the clamp is one matrix J away: u = J f, theta = J kappa, w = J (f theta).
Nothing has to be continuous across elements that is not so in the beam.
"""

import math
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
    to_legendre: np.ndarray  # (p, p) values at the points -> Legendre coefficients
    last_two: np.ndarray  # (p, p) values -> the part of the two highest Legendre polynomials
    tails: np.ndarray  # (2, p) values -> that part in terms of two orthonormal polynomials
    integration: np.ndarray  # (p, p) values -> integral from -1 to each point


@lru_cache(maxsize=64)
def reference(order: int) -> Reference:
    """The reference element with `order` Gauss points."""
    points, weights = legendre.leggauss(order)
    norms = np.arange(order) + 0.5
    to_legendre = norms[:, None] * legendre.legvander(points, order - 1).T * weights
    last_two = legendre.legvander(points, order - 1)[:, -2:] @ to_legendre[-2:]
    integration = _antiderivatives(points, order) @ to_legendre
    tails = to_legendre[-2:] / np.sqrt(norms[-2:, None])
    arrays = (points, weights, to_legendre, last_two, tails, integration)
    return Reference(*(_frozen(array) for array in arrays))


def _antiderivatives(xi: np.ndarray, order: int) -> np.ndarray:
    """Integrals of P_0 .. P_(order-1) from -1 to each xi: (n, order)."""
    P = legendre.legvander(xi, order)
    Q = np.empty((len(xi), order))
    Q[:, 0] = xi + 1
    Q[:, 1:] = (P[:, 2:] - P[:, :-2]) / (2 * np.arange(1, order) + 1)
    return Q


@dataclass(frozen=True, eq=False)
class Mesh:
    """Elements between `breaks`, each with as many Gauss points as its order; n in all.

    J integrates values at the points from the clamp to each point, T keeps the part of them in
    the two highest polynomials of each element, `tails` that part in terms of orthonormal ones;
    G = J' W J and g = J' W 1 are the inertia of a unit line density in terms of a gradient.
    """

    breaks: np.ndarray  # (elements + 1,)
    orders: tuple[int, ...]  # (elements,)
    points: np.ndarray  # (n,)
    weights: np.ndarray  # (n,)
    roots: np.ndarray  # (n, 1) square roots of the weights
    J: np.ndarray  # (n, n)
    rooted: np.ndarray  # (n, n) roots * J: rooted' rooted = G
    T: np.ndarray  # (n, n)
    eye: np.ndarray  # (n, n)
    IJ: np.ndarray  # (2 n, n) identity and J
    IJT: np.ndarray  # (2 n, n) IJ T
    tails: np.ndarray  # (2 elements, n)
    G: np.ndarray  # (n, n)
    G1: np.ndarray  # (n,) row sums of G
    g: np.ndarray  # (n,)

    @property
    def elements(self) -> int:
        return len(self.orders)

    def from_clamp(self, x: np.ndarray) -> np.ndarray:
        """Matrix (len(x), n): values at the points -> integral from the clamp to each x."""
        return _from_clamp(self, x.tobytes())

    def at(self, x: np.ndarray) -> np.ndarray:
        """Matrix (len(x), n): values at the points -> their interpolant at each x."""
        element, xi, _ = self._locate(x)
        rows = np.zeros((len(x), len(self.points)))
        for e, block in enumerate(_blocks(self.orders)):
            here, order = element == e, self.orders[e]
            rows[here, block] = (
                legendre.legvander(xi[here], order - 1) @ reference(order).to_legendre
            )
        return rows

    def _locate(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Element, local coordinate in [-1, 1] and half length for each x."""
        element = np.clip(np.searchsorted(self.breaks, x, side="left") - 1, 0, self.elements - 1)
        left, right = self.breaks[element], self.breaks[element + 1]
        half = (right - left) / 2
        return element, (x - left) / half - 1, half


@lru_cache(maxsize=64)
def _from_clamp(mesh: Mesh, x: bytes) -> np.ndarray:
    """Mesh.from_clamp; the points of a sweep share mesh and x."""
    element, xi, half = mesh._locate(np.frombuffer(x))
    rows = np.where(mesh.points < mesh.breaks[element][:, None], mesh.weights, 0.0)
    for e, block in enumerate(_blocks(mesh.orders)):
        here, order = element == e, mesh.orders[e]
        local = _antiderivatives(xi[here], order) @ reference(order).to_legendre
        rows[here, block] = half[here, None] * local
    return _frozen(rows)


@lru_cache(maxsize=128)
def mesh(breaks: tuple[float, ...], orders: tuple[int, ...]) -> Mesh:
    """The mesh with elements between `breaks` (0 .. 1, ascending) of these orders."""
    elements = [reference(order) for order in orders]
    halves = [(b - a) / 2 for a, b in pairwise(breaks)]
    points = np.concatenate(
        [a + h * (e.points + 1) for a, h, e in zip(breaks, halves, elements, strict=False)]
    )
    weights = np.concatenate([h * e.weights for h, e in zip(halves, elements, strict=True)])
    n = len(points)
    J, T, tails = np.zeros((n, n)), np.zeros((n, n)), np.zeros((2 * len(orders), n))
    for k, (h, e, block) in enumerate(zip(halves, elements, _blocks(orders), strict=True)):
        J[block, : block.start] = weights[: block.start]
        J[block, block] = h * e.integration
        T[block, block] = e.last_two
        tails[2 * k : 2 * k + 2, block] = math.sqrt(h) * e.tails
    WJ = weights[:, None] * J
    G, g = J.T @ WJ, WJ.sum(axis=0)
    roots, eye = np.sqrt(weights)[:, None], np.eye(n)
    IJ = np.concatenate((eye, J))
    arrays = (points, weights, roots, J, roots * J, T, eye, IJ, IJ @ T, tails, G, G.sum(axis=1), g)
    return Mesh(_frozen(np.array(breaks)), orders, *(_frozen(array) for array in arrays))


def _blocks(orders: tuple[int, ...]) -> list[slice]:
    """The points of each element."""
    ends = [0, *accumulate(orders)]
    return [slice(a, b) for a, b in pairwise(ends)]


def _frozen(array: np.ndarray) -> np.ndarray:
    """The array, made read-only: meshes are shared."""
    array.setflags(write=False)
    return array
