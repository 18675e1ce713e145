"""Cubic Hermite elements: shape functions, quadrature, mass and assembly.

A beam between 0 and 1 is divided by `nodes`, ascending. Each node carries the value and the slope
of a field, so an element has 4 coordinates for each component: value, slope, value, slope.
Symmetric matrices are assembled as LAPACK's lower bands: A[k, j] is the entry in row j + k,
column j.
"""

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import cholesky_banded

MASS_DEGREE = 6  # S' S of cubics


def gauss(degree: int) -> tuple[NDArray, NDArray]:
    """The fewest Gauss points in [0, 1] that integrate a polynomial of `degree` exactly, and
    their weights."""
    points, weights = legendre.leggauss(degree // 2 + 1)
    return (points + 1) / 2, weights / 2


def hermite(xi: ArrayLike, length: ArrayLike) -> tuple[NDArray, NDArray, NDArray]:
    """S, S' and S'' of cubic elements (paper, eqs. 5-6), one component: (..., 4) each.

    xi = x / length in [0, 1] and length are broadcast; the derivatives are by x.
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


def element_coordinates(q: NDArray, per_node: int) -> NDArray:
    """Coordinates of each element, q_e = B_e q (paper, eqs. 2-4): (elements, 2 per_node, ...)."""
    q = q.reshape(-1, per_node, *q.shape[1:])
    return np.concatenate((q[:-1], q[1:]), axis=1)


def interpolate(nodes: NDArray, q: NDArray, x: ArrayLike, derivative: int = 0) -> NDArray:
    """A field or its derivative (1 or 2) at x (k,), from value and slope of node after node.

    q (2N, ...) of N nodes; the field (k, ...).
    """
    element, xi = locate(nodes, x)
    S = hermite(xi, np.diff(nodes)[element])[derivative]
    return np.einsum("xi,xi...->x...", S, element_coordinates(q, 2)[element])


def mass(nodes: NDArray, alpha: float, beta: float) -> NDArray:
    """Mass matrix m_e of one component: (elements, 4, 4).

    int S' S dx of each element for rho A = 1 (paper, eq. 8), and alpha S'(beta) S(beta) in the
    element that holds the concentrated mass (eqs. 29-32).
    """
    points, weights = gauss(MASS_DEGREE)
    lengths = np.diff(nodes)
    S, _, _ = hermite(points, lengths[:, None])
    m = np.einsum("ep,epi,epj->eij", weights * lengths[:, None], S, S)
    element, xi = locate(nodes, beta)
    S, _, _ = hermite(xi, lengths[element])
    m[element] += alpha * np.outer(S, S)
    return m


def assemble_vector(parts: NDArray) -> NDArray:
    """The sum of element vectors (elements, w), sum_e B_e' parts_e (paper, eq. 19)."""
    elements, width = parts.shape
    total = np.zeros((elements + 1, width // 2), parts.dtype)
    total[:-1] += parts[:, : width // 2]
    total[1:] += parts[:, width // 2 :]
    return total.ravel()


def assemble_band(parts: NDArray) -> NDArray:
    """The sum of symmetric element matrices (elements, w, w), sum_e B_e' parts_e B_e (paper,
    eqs. 10 and 43), as a lower band (w, n)."""
    elements, width, _ = parts.shape
    stride = width // 2
    A = np.zeros((width, stride * (elements + 1)))
    for j in range(width):
        A[: width - j, j : j + stride * elements : stride] += parts[:, j:, j].T
    return A


def dense(A: NDArray) -> NDArray:
    """The full matrix (n, n) of a lower band."""
    n = A.shape[1]
    full = np.zeros((n, n))
    j = np.arange(n)
    for k, diagonal in enumerate(A[:n]):
        rows, columns = j[k:], j[: n - k]
        full[rows, columns] = full[columns, rows] = diagonal[: n - k]
    return full


def positive_definite(A: NDArray) -> bool:
    """Whether a symmetric band is positive definite."""
    try:
        cholesky_banded(A, lower=True, check_finite=False)
    except np.linalg.LinAlgError:
        return False
    return True
