"""The problem K v = lambda M v, inverted: M v = nu (K + shift M) v.

Then lambda is 1/nu - shift. The low modes are the largest nu, and the rounding errors are in the
high modes.
"""

from functools import lru_cache
from itertools import chain

import numpy as np
from scipy.linalg import blas, lapack

from beamviz.errors import NotConverged

# Shift of stiffnesses that may be indefinite, and the least scale of the errors of omega^2, which
# compression may bring near zero: omega^2 of bending at rest is 12.
COMPRESSED = 16.0
SHIFTS = tuple(COMPRESSED * 4.0**k for k in range(28))
NEARLY_SINGULAR = 4.0  # ratio of shift to least shifted eigenvalue above which both lose digits
FEW = 30  # number of unknowns from which a few eigenvectors are computed faster than all
SPURIOUS = 1e-12  # share of the largest nu below which one is rounding
REAL = 1e-6  # an eigenvalue is real whose imaginary part is a smaller share
BLOCK = 8  # columns that LAPACK reduces at once: faster than its choice of 32 up to 250 unknowns


def eigh_largest(A: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """The `count` largest eigenvalues (count,), descending, of symmetric A (n, n), of which the
    upper triangle is read, and their vectors, each a row.

    Of a larger problem a few vectors are computed by inverse iteration on the tridiagonal matrix:
    scipy.linalg.eigh with subset_by_index takes twice as long, which is a tenth to a fifth of a
    solve with Coriolis forces or of a fast beam. Below that size its checks alone are 7 % of one.
    """
    # The transpose is in column order as LAPACK requires: no copy.
    n, count = len(A), min(count, len(A))
    if n >= max(FEW, 2 * count):
        reflectors, d, e, tau, _ = lapack.dsytrd(A.T, lower=1, lwork=BLOCK * n)
        nu, failed = lapack.dsterf(d, e)
        if not failed:
            V, failed = lapack.dstein(d, e, nu[n - count :], *_one_block(n))
        if not failed:
            V[1:] = lapack.dormqr("L", "N", reflectors[1:, :-1], tau, V[1:], BLOCK * n)[0]
            return nu[: -count - 1 : -1], V.T[count - 1 :: -1]
    nu, V, info = lapack.dsyevd(A.T, lower=1)
    if info:
        raise NotConverged(f"the eigenvalues did not converge (LAPACK: {info})")
    return nu[: -count - 1 : -1], V.T[: -count - 1 : -1]


@lru_cache
def _one_block(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Numbers and ends (n,) of the blocks of a tridiagonal matrix of one block."""
    return np.ones(n, np.int32), np.full(n, n, np.int32)


def generalized_eigh(
    M: np.ndarray, K: np.ndarray, count: int
) -> tuple[np.ndarray, np.ndarray] | None:
    """The `count` largest nu, descending, of M v = nu K v, V K V' = 1, their v as rows; None for an
    indefinite K."""
    L, info = lapack.dpotrf(K.T, lower=1)
    if info:
        return None
    A, _ = lapack.dsygst(M.T, L, lower=1)
    nu, V = eigh_largest(A.T, count)
    return nu, blas.dtrsm(1, L, V.T, lower=1, trans_a=1).T


def inverse_modes_with_shift(
    M: np.ndarray, K: np.ndarray, count: int, shift: float
) -> tuple[np.ndarray, np.ndarray, float]:
    """The `count` largest nu, descending, of M v = nu (K + added M) v, their v as rows, and the
    shift added: the one given, or one that makes it positive definite."""
    for added in chain((shift,), SHIFTS):
        modes = generalized_eigh(M, K + added * M if added else K, count)
        if modes is None:
            continue
        nu, vectors = modes
        if nu[0] * added > NEARLY_SINGULAR:
            modes = generalized_eigh(M, K + 2 * added * M, count)
            if modes is not None:
                return *modes, 2 * added
        return nu, vectors, added
    raise NotConverged(
        f"the stiffness is not positive definite, nor with {SHIFTS[-1]:.3g} times the mass added:"
        " the beam may be too near a limit of its equilibrium"
    )


def real_modes(
    K: np.ndarray, M: np.ndarray, count: int, indefinite: bool
) -> tuple[np.ndarray, np.ndarray]:
    """The `count` lowest real lambda, ascending, or as many as there are, and their vectors
    (n, count), of matrices by collocation: neither is symmetric, and high lambda may be complex,
    which are no modes. indefinite: whether a lambda may be negative, or nearly 0, beside which the
    others would have no digits."""
    shift = COMPRESSED if indefinite else 0.0
    nu, V = np.linalg.eig(np.linalg.solve(K + shift * M, M))
    real = abs(nu.imag) <= REAL * abs(nu)
    possible = (nu.real > 0) | indefinite
    kept = np.flatnonzero(real & possible & (abs(nu) > SPURIOUS * abs(nu).max()))
    values = 1 / nu[kept].real - shift
    lowest = values.argsort()[:count]
    return values[lowest], V[:, kept[lowest]].real
