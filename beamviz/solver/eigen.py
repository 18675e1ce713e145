"""Eigenproblems of vibration, solved so that the low modes keep their digits.

K v = lambda M v with thin elements or high order has eigenvalues 1e17 apart, and the usual
reduction by M loses the low ones. Here M v = nu K v is solved and lambda = 1/nu: the low
modes are the largest nu, and rounding falls on the high modes nobody asked for.
"""

from collections.abc import Iterable
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
    size: np.ndarray  # (..., count) lambda of what was solved, K + a multiple of M: that rounds


def lowest(K: np.ndarray, M: np.ndarray, count: int, shift: float = 0.0) -> Lowest:
    """The `count` lowest eigenvalues of K v = lambda M v and their vectors.

    K (..., n, n) symmetric, M (..., n, n) symmetric positive semidefinite. K + shift M is solved,
    the shift growing until that is positive definite: name one where K may not be (a compressed
    beam), for an eigenvalue near -shift takes the digits of the others.
    """
    stack, n = K.shape[:-2], K.shape[-1]
    count = min(count, n)
    nu, V, added = np.empty((*stack, count)), np.empty((*stack, count, n)), np.empty((*stack, 1))
    for k in _each(stack):
        nu[k], V[k], added[k] = _largest(M[k], K[k], count, shift)
    return _lowest(nu, V, added)


def lowest_of_families(
    K: np.ndarray, M: np.ndarray, d: np.ndarray, G: np.ndarray, count: int
) -> Lowest:
    """`lowest` of K v = lambda M v and, second in an axis after those of the stack, of
    diag(d) v = lambda G v, d (..., n) > 0, which takes less."""
    stack, n = d.shape[:-1], d.shape[-1]
    count = min(count, n)
    root = 1 / np.sqrt(d)[..., None, :]
    A = root.mT * G * root
    nu, V = np.empty((*stack, 2, count)), np.empty((*stack, 2, count, n))
    added = np.zeros((*stack, 2, 1))
    for k in _each(stack):
        nu[*k, 0], V[*k, 0], added[*k, 0] = _largest(M[k], K[k], count, 0.0)
        nu[*k, 1], V[*k, 1] = _last(symmetric(A[k]), count)
    V[..., 1, :, :] *= root
    return _lowest(nu, V, added)


def _each(stack: tuple[int, ...]) -> Iterable[tuple[int, ...]]:
    """The places in a stack; of one problem alone, the only one."""
    return np.ndindex(stack) if stack else ((),)


def _last(found: tuple[np.ndarray, np.ndarray], count: int) -> tuple[np.ndarray, np.ndarray]:
    """The last `count` eigenvalues of those found in ascending order, descending, and their
    vectors as rows."""
    nu, V = found
    return nu[: -count - 1 : -1], V.T[: -count - 1 : -1]


def _lowest(nu: np.ndarray, V: np.ndarray, added: np.ndarray) -> Lowest:
    """What was found of M v = nu (K + added M) v in terms of lambda; V (..., count, n) holds each
    v as a row, in one stretch of memory, and is overwritten."""
    size = 1 / nu
    V *= np.sqrt(abs(size))[..., None]
    return Lowest(size - added, V.mT, size)


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
    """The `count` largest nu (descending) of M v = nu (K + added M) v, each v a row, and added."""
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
    """The `count` largest nu (descending) of M v = nu K v, each v a row; None if K is not
    definite."""
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
    return None if info else _last((nu, V), count)
