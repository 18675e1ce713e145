"""Cubic Hermite elements: shape functions, Gauss points, and where a point lies.

A beam between 0 and 1 is divided by `nodes`, ascending. Each node carries a value and a slope,
so one component of a field has 4 coordinates per element: value, slope, value, slope.
"""

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import ArrayLike, NDArray

from beamviz.errors import InvalidInput

MAX_ELEMENTS = 10_000


def uniform(elements: int) -> NDArray:
    """The nodes of `elements` equal elements: (elements + 1,).

    Raises InvalidInput unless 1 <= elements <= MAX_ELEMENTS.
    """
    if not 1 <= elements <= MAX_ELEMENTS:
        raise InvalidInput(f"elements = {elements}: must lie in 1 .. {MAX_ELEMENTS}")
    return np.linspace(0.0, 1.0, elements + 1)


def gauss(degree: int) -> tuple[NDArray, NDArray]:
    """The fewest Gauss points in [0, 1] that integrate a polynomial of `degree` exactly, and
    their weights."""
    points, weights = legendre.leggauss(degree // 2 + 1)
    return (points + 1) / 2, weights / 2


def hermite(xi: ArrayLike, length: ArrayLike) -> tuple[NDArray, NDArray, NDArray]:
    """S, S' and S'' of cubic elements (paper, eqs. 5-6), one component: (..., 4) each.

    xi = x / length in [0, 1] and length broadcast; the derivatives are by x.
    """
    xi, l = np.broadcast_arrays(xi, length)
    S = [1 - xi * xi * (3 - 2 * xi), l * xi * (1 - xi) ** 2, xi * xi * (3 - 2 * xi)]
    S.append(-l * xi * xi * (1 - xi))
    dS = [-6 * xi * (1 - xi) / l, (1 - xi) * (1 - 3 * xi), 6 * xi * (1 - xi) / l, xi * (3 * xi - 2)]
    ddS = [(12 * xi - 6) / l**2, (6 * xi - 4) / l, (6 - 12 * xi) / l**2, (6 * xi - 2) / l]
    return np.stack(S, -1), np.stack(dS, -1), np.stack(ddS, -1)


def locate(nodes: NDArray, x: ArrayLike) -> tuple[NDArray, NDArray]:
    """The element of each x and xi in it; a node belongs to its right element (paper, eq. 30)."""
    element = np.clip(np.searchsorted(nodes, x, side="right") - 1, 0, len(nodes) - 2)
    return element, (x - nodes[element]) / np.diff(nodes)[element]


def interpolate(nodes: NDArray, q: NDArray, x: ArrayLike, derivative: int = 0) -> NDArray:
    """r, r' or r'' (derivative 0, 1 or 2) at x, from planar coordinates q: (len(x), 2).

    q holds r1, r2, r1', r2' of node after node (paper, eqs. 2-4).
    """
    element, xi = locate(nodes, x)
    S = hermite(xi, np.diff(nodes)[element])[derivative]
    return np.einsum("xi,xic->xc", S, coordinates(q)[element].reshape(-1, 4, 2))


def coordinates(q: NDArray) -> NDArray:
    """The 8 coordinates of each element, q_e = B_e q (paper, eqs. 2-4): (elements, 8)."""
    q = q.reshape(-1, 4)
    return np.concatenate((q[:-1], q[1:]), axis=1)
