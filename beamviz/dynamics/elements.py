"""Elements of the beam, on each of which functions of x are polynomials."""

from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import ArrayLike, NDArray

from beamviz.mechanics.cubic_elements import gauss
from beamviz.solver.solution import read_only

EXTRA_POINTS = 3  # Gauss points of an element: its order and these (the energy is no polynomial)


@dataclass(frozen=True, eq=False)
class Elements:
    """ends: of the elements (e + 1,), 0 .. 1, ascending. orders: of the polynomials (e,). points,
    weights: (m,) of Gauss on all elements."""

    ends: NDArray
    orders: tuple[int, ...]
    points: NDArray
    weights: NDArray

    def polynomials(self, counts: tuple[int, ...], x: NDArray) -> tuple[NDArray, NDArray]:
        """The Legendre polynomials of degree 0 .. counts[e] - 1 on each element e, orthonormal on
        it but for its length, and their integrals from 0, at points x of the beam: (len(x),
        sum(counts)) each. A point between two elements belongs to the one inboard."""
        element = np.clip(np.searchsorted(self.ends, x) - 1, 0, len(counts) - 1)
        P, E = np.zeros((2, len(x), sum(counts)))
        first = 0
        for e, (start, end) in enumerate(pairwise(self.ends)):
            inside, beyond = element == e, element > e
            columns = slice(first, first + counts[e])
            values, integrals = legendre_integrals((x[inside] - start) / (end - start), counts[e])
            P[inside, columns], E[inside, columns] = values, (end - start) * integrals
            E[beyond, first] = end - start  # the higher polynomials have no mean
            first += counts[e]
        return P, E

    def integration(self, x: ArrayLike) -> NDArray:
        """The integral from 0 to points x of a function of which the values at the Gauss points are
        given: (len(x), m)."""
        counts = tuple(order + EXTRA_POINTS for order in self.orders)
        P, _ = self.polynomials(counts, self.points)
        _, E = self.polynomials(counts, np.atleast_1d(x))
        lengths = np.repeat(np.diff(self.ends), counts)
        return E @ (P.T * (self.weights / lengths))


def legendre_integrals(c: ArrayLike, s: int) -> tuple[NDArray, NDArray]:
    """The orthonormal Legendre polynomials of degree 0 .. s - 1 on 0 .. 1 at c, and their integrals
    from 0: (len(c), s) each."""
    z = 2 * np.asarray(c, float) - 1
    L, root = legendre.legvander(z, s), np.sqrt(2 * np.arange(s) + 1.0)
    # (2 k + 1) L_k is the derivative of L_k+1 - L_k-1, which vanishes at z = -1; dx = dz / 2.
    E = (L[:, 1:] - np.column_stack((-np.ones_like(z), L[:, : s - 1]))) / (2 * root)
    return L[:, :s] * root, E


@lru_cache(maxsize=32)
def elements_between(ends: tuple[float, ...], orders: tuple[int, ...]) -> Elements:
    """The elements between `ends`. They are kept: motions of a beam, and its deflections by
    hand, ask for the same ones."""
    parts: list[tuple[NDArray, NDArray]] = []
    for (start, end), order in zip(pairwise(ends), orders, strict=True):
        points, weights = gauss(2 * (order + EXTRA_POINTS) - 1)
        parts.append((start + (end - start) * points, (end - start) * weights))
    points, weights = map(np.concatenate, zip(*parts, strict=True))
    return Elements(read_only(np.array(ends)), orders, read_only(points), read_only(weights))
