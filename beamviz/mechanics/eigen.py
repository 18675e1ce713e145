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
    if K.ndim != 3:
        n = K.shape[-1]
        squares, V, added = lowest(K.reshape(-1, n, n), M.reshape(-1, n, n), count, shift)
        stack = K.shape[:-2]
        added = added if isinstance(added, float) else added.reshape(*stack, 1)
        return Lowest(squares.reshape(*stack, -1), V.reshape(*stack, n, -1), added)
    count = min(count, K.shape[-1])
    nu, V = np.empty((len(K), count)), np.empty((*K.shape[:2], count))
    shifts = [shift] * len(K)
    for k in range(len(K)):
        nu[k], V[k], shifts[k] = _largest(M[k], K[k], count, shift)
    squares = 1 / nu
    V *= np.sqrt(abs(squares))[:, None]
    if not any(shifts):
        return Lowest(squares, V, 0.0)
    added = np.array(shifts)[:, None]
    return Lowest(squares - added, V, added)


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
        nu, V, info = lapack.dsygvd(M.T, K.T)
    else:
        nu, V, _, _, info = lapack.dsygvx(M.T, K.T, range="I", il=n - count + 1, iu=n)
        nu, V = nu[:count], V[:, :count]
    if 0 < info <= n:
        raise NotConverged(f"the eigenvalues did not converge (LAPACK: {info})")
    return None if info else (nu[: -count - 1 : -1], V[:, : -count - 1 : -1])
