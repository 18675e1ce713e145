"""The polynomials of a step in time."""

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import ArrayLike, NDArray


def legendre_integrals(c: ArrayLike, s: int) -> tuple[NDArray, NDArray]:
    """The orthonormal Legendre polynomials of degree 0 .. s - 1 on 0 .. 1 at c, and their integrals
    from 0: (len(c), s) each."""
    z = 2 * np.asarray(c, float) - 1
    L, root = legendre.legvander(z, s), np.sqrt(2 * np.arange(s) + 1.0)
    # (2 k + 1) L_k is the derivative of L_k+1 - L_k-1, which vanishes at z = -1; dx = dz / 2.
    E = (L[:, 1:] - np.column_stack((-np.ones_like(z), L[:, : s - 1]))) / (2 * root)
    return L[:, :s] * root, E
