"""Eigenproblems of vibration, solved so that the low modes keep their digits.

K v = lambda M v with thin elements or high order has eigenvalues 1e17 apart, and the usual
reduction by M loses the low ones. Here M v = nu K v is solved and lambda = 1/nu: the low
modes are the largest nu, and rounding falls on the high modes nobody asked for.
"""

from itertools import chain

import numpy as np
from scipy.linalg import lapack

from beamviz.errors import NotConverged

COMPRESSED = 16.0  # a shift for beams that may buckle: omega^2 of bending at rest is 12
SHIFTS = tuple(COMPRESSED * 4.0**k for k in range(28))


def lowest(
    K: np.ndarray, M: np.ndarray, count: int, shift: float = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    """The `count` lowest eigenvalues (ascending) of K v = lambda M v and their vectors.

    K (n, n) symmetric, M (n, n) symmetric positive semidefinite. K + shift M is solved, the
    shift growing until that is positive definite: name one where K may not be (a compressed
    beam), for an eigenvalue near -shift takes the digits of the others.
    Returns lambda (count,) and V (n, count) with V' M V = 1; for stacks of matrices, stacks.
    """
    if K.ndim != 3:
        n = K.shape[-1]
        squares, V = lowest(K.reshape(-1, n, n), M.reshape(-1, n, n), count, shift)
        return squares.reshape(*K.shape[:-2], -1), V.reshape(*K.shape[:-1], -1)
    count = min(count, K.shape[-1])
    nu, V = np.empty((len(K), count)), np.empty((*K.shape[:2], count))
    added = [shift] * len(K)
    for k in range(len(K)):
        nu[k], V[k], added[k] = _largest(M[k], K[k], count, shift)
    squares = 1 / nu
    V *= np.sqrt(abs(squares))[:, None]
    return (squares - np.array(added)[:, None] if any(added) else squares), V


def _largest(
    M: np.ndarray, K: np.ndarray, count: int, shift: float
) -> tuple[np.ndarray, np.ndarray, float]:
    """The `count` largest nu (descending) of M v = nu (K + added M) v, v (n, count), and added."""
    for added in chain((shift,), SHIFTS):
        # Transposed, symmetric matrices come as LAPACK wants them: no conversion.
        nu, V, info = lapack.dsygvd(M.T, (K + added * M if added else K).T)
        if not info:
            return nu[: -count - 1 : -1], V[:, : -count - 1 : -1], added
        if info <= len(K):
            raise NotConverged(f"the eigenvalues did not converge (LAPACK dsygvd: {info})")
    raise NotConverged(
        f"the stiffness is not positive definite, nor with {SHIFTS[-1]:.3g} times the mass added:"
        " the beam may be too near a limit of its equilibrium"
    )
