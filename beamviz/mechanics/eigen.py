"""Eigenproblems of vibration, solved so that the low modes keep their digits.

K v = lambda M v with thin elements or high order has eigenvalues 1e17 apart, and the usual
reduction by M loses the low ones. Here M v = nu K v is solved and lambda = 1/nu: the low
modes are the largest nu, and rounding falls on the high modes nobody asked for.
"""

from itertools import chain
from typing import NamedTuple

import numpy as np
from scipy.linalg import lapack

from beamviz.errors import NotConverged

COMPRESSED = 16.0  # a shift for beams that may buckle: omega^2 of bending at rest is 12
SHIFTS = tuple(COMPRESSED * 4.0**k for k in range(28))
SUBSET = 32  # unknowns from which on a few eigenvectors come faster than all


class Lowest(NamedTuple):
    """The lowest eigenvalues of a stack of problems K v = lambda M v."""

    squares: np.ndarray  # (..., count) lambda, ascending
    V: np.ndarray  # (..., n, count), V' M V = 1
    added: np.ndarray | float  # (..., 1) the multiple of M added to K: what rounds is K + added M


def lowest(K: np.ndarray, M: np.ndarray, count: int, shift: float = 0.0) -> Lowest:
    """The `count` lowest eigenvalues of K v = lambda M v and their vectors.

    K (..., n, n) symmetric, M (..., n, n) symmetric positive semidefinite. K + shift M is solved,
    the shift growing until that is positive definite: name one where K may not be (a compressed
    beam), for an eigenvalue near -shift takes the digits of the others.
    """
    n = K.shape[-1]
    count = min(count, n)
    added: float | np.ndarray
    if K.ndim == 2:
        nu, V, added = _largest(M, K, count, shift)
    else:
        problems = zip(M.reshape(-1, n, n), K.reshape(-1, n, n), strict=True)
        found = [_largest(*problem, count, shift) for problem in problems]
        parts = (np.array(part) for part in zip(*found, strict=True))
        nu, V, each = (part.reshape(*K.shape[:-2], *part.shape[1:]) for part in parts)
        added = each[..., None]
    squares = 1 / nu
    V = V * np.sqrt(abs(squares))[..., None, :]
    return Lowest(squares - added, V, added)


def lowest_of_diagonal(d: np.ndarray, M: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """`lowest` for K = diag(d), d (..., n) > 0, which takes less: lambda and V."""
    root = 1 / np.sqrt(d)
    A = root[..., :, None] * M * root[..., None, :]
    nu, V = symmetric(A)
    squares = 1 / nu[..., : -count - 1 : -1]
    V = root[..., None] * V[..., : -count - 1 : -1] * np.sqrt(squares)[..., None, :]
    return squares, V


def symmetric(A: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """All eigenvalues (..., n), ascending, and vectors (..., n, n) of symmetric A (overwritten)."""
    if A.ndim > 2:  # in one call numpy would set threads on each of these small problems
        nu, V = map(np.array, zip(*map(symmetric, A), strict=True))
        return nu, V
    routine = lapack.dsyev if len(A) < SUBSET else lapack.dsyevd
    nu, V, info = routine(A.T, overwrite_a=True)
    if info:
        raise NotConverged(f"the eigenvalues did not converge (LAPACK: {info})")
    return nu, V


def _largest(
    M: np.ndarray, K: np.ndarray, count: int, shift: float
) -> tuple[np.ndarray, np.ndarray, float]:
    """The `count` largest nu (descending) of M v = nu (K + added M) v, v (n, count), and added."""
    for added in chain((shift,), SHIFTS):
        found = _definite(M, K + added * M if added else K, count)
        if found is not None:
            if found[0][0] * added > 4:  # all but singular: that would cost digits
                again = _definite(M, K + 2 * added * M, count)
                found, added = (found, added) if again is None else (again, 2 * added)
            return *found, added
    raise NotConverged(
        f"the stiffness is not positive definite, nor with {SHIFTS[-1]:.3g} times the mass added:"
        " the beam may be too near a limit of its equilibrium"
    )


def _definite(M: np.ndarray, K: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray] | None:
    """The `count` largest nu (descending) and v of M v = nu K v; None if K is not definite."""
    # Transposed, symmetric matrices come as LAPACK wants them: no conversion.
    n = len(K)
    if n < SUBSET:
        nu, V, info = lapack.dsygv(M.T, K.T)
    elif count > n / 2:
        nu, V, info = lapack.dsygvd(M.T, K.T)
    else:
        nu, V, _, _, info = lapack.dsygvx(M.T, K.T, range="I", il=n - count + 1, iu=n)
        nu, V = nu[:count], V[:, :count]
    if 0 < info <= n:
        raise NotConverged(f"the eigenvalues did not converge (LAPACK: {info})")
    return None if info else (nu[: -count - 1 : -1], V[:, : -count - 1 : -1])
