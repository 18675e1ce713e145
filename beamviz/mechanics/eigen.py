"""Eigenproblems of vibration, solved so that the low modes keep their digits.

K v = lambda M v with thin elements or high order has eigenvalues 1e17 apart, and the usual
reduction by M loses the low ones. Here M v = nu K v is solved and lambda = 1/nu: the low
modes are the largest nu, and rounding falls on the high modes nobody asked for.
"""

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
    n = K.shape[-1]
    pairs = zip(K.reshape(-1, n, n), M.reshape(-1, n, n), strict=True)
    nu, V, added = zip(*[_largest(M, K, count, shift) for K, M in pairs], strict=True)
    nu = np.array(nu).reshape(*K.shape[:-2], count)
    V = np.array(V).reshape(*K.shape[:-2], count, n) / np.sqrt(abs(nu))[..., None]
    return 1 / nu - np.reshape(added, (*K.shape[:-2], 1)), V.mT


def _largest(
    M: np.ndarray, K: np.ndarray, count: int, shift: float
) -> tuple[np.ndarray, np.ndarray, float]:
    """The `count` largest nu (descending) of M v = nu (K + added M) v, v (count, n), and added."""
    for added in (shift, *(s for s in SHIFTS if s > shift)):
        # Transposed, symmetric matrices come as LAPACK wants them: no conversion.
        nu, V, info = lapack.dsygvd(M.T, (K + added * M if added else K).T)
        if not info:
            return nu[: -count - 1 : -1], V.T[: -count - 1 : -1], added
        if info <= len(K):
            raise NotConverged(f"the eigenvalues did not converge (LAPACK dsygvd: {info})")
    raise NotConverged(
        f"the stiffness is not positive definite, nor with {SHIFTS[-1]:.3g} times the mass added:"
        " the beam may be too near a limit of its equilibrium"
    )
