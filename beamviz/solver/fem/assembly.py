"""From elements to the beam and back, in time linear in the number of elements.

Each element shares half its coordinates with the next, so a symmetric matrix is a band.
It is kept as LAPACK's lower band: A[k, j] is the entry in row j + k, column j.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack


def vector(parts: NDArray) -> NDArray:
    """The sum of element vectors (elements, w), sum_e B_e' parts_e (paper, eq. 19)."""
    elements, width = parts.shape
    total = np.zeros((elements + 1, width // 2), parts.dtype)
    total[:-1] += parts[:, : width // 2]
    total[1:] += parts[:, width // 2 :]
    return total.ravel()


def band(parts: NDArray) -> NDArray:
    """The sum of symmetric element matrices (elements, w, w), sum_e B_e' parts_e B_e (paper,
    eqs. 10 and 43), as a lower band (w, n)."""
    elements, width, _ = parts.shape
    stride = width // 2
    A = np.zeros((width, stride * (elements + 1)))
    for j in range(width):
        A[: width - j, j : j + stride * elements : stride] += parts[:, j:, j].T
    return A


def held(A: NDArray, fixed: Sequence[int]) -> NDArray:
    """The band with the coordinates in `fixed` taken out of play: 1 on their diagonal, else 0."""
    A = A.copy()
    for j in fixed:
        A[:, j] = 0
        for k in range(1, min(j, len(A) - 1) + 1):
            A[k, j - k] = 0
        A[0, j] = 1
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


def skew(parts: NDArray) -> NDArray:
    """The sum of skew element matrices (elements, w, w): a full matrix (n, n)."""
    lower = np.tril(dense(band(parts)))
    return lower - lower.T


def cholesky(A: NDArray) -> NDArray:
    """The factor L of a band A = L L', itself a lower band.

    Raises np.linalg.LinAlgError when A is not positive definite.
    """
    L, info = lapack.dpbtrf(A, lower=1)
    if info:
        raise np.linalg.LinAlgError("the matrix is not positive definite")
    return L


def positive_definite(A: NDArray) -> bool:
    """Whether a symmetric band is positive definite."""
    try:
        cholesky(A)
    except np.linalg.LinAlgError:
        return False
    return True


def solve(L: NDArray, b: NDArray) -> NDArray:
    """x with L L' x = b, for a factor from `cholesky`."""
    return lapack.dpbtrs(L, b, lower=1)[0]
