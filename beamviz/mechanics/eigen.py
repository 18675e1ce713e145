"""Eigenproblems of vibration, solved so that the low modes keep their digits.

K v = lambda M v with thin elements or high order has eigenvalues 1e17 apart, and the usual
reduction by M loses the low ones. Here M v = nu K v is solved and lambda = 1/nu: the low
modes are the largest nu, and rounding falls on the high modes nobody asked for.
"""

import numpy as np
from scipy.linalg import lapack

from beamviz.errors import NotConverged

SHIFTS = (0.0, *(4.0**k for k in range(2, 30)))


def lowest(K: np.ndarray, M: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """The `count` lowest eigenvalues (ascending) of K v = lambda M v and their vectors.

    K (n, n) symmetric, M (n, n) symmetric positive semidefinite. A K that is not positive
    definite (a compressed beam) is shifted by a multiple of M until it is.
    Returns lambda (count,) and V (n, count) with V' M V = 1.
    """
    for shift in SHIFTS:
        # Transposed, symmetric matrices come as LAPACK wants them: no conversion.
        nu, V, info = lapack.dsygvd(M.T, (K + shift * M if shift else K).T)
        if not info:
            nu = nu[: -count - 1 : -1]
            return 1 / nu - shift, V[:, : -count - 1 : -1] / np.sqrt(nu)
        if info <= len(K):
            raise NotConverged(f"the eigenvalues did not converge (LAPACK dsygvd: {info})")
    raise NotConverged(f"no shift up to {SHIFTS[-1]:.3g} made the stiffness positive definite")
