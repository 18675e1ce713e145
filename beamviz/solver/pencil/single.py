"""The pencil of one beam: K symmetric or not, with Coriolis forces or without, dense or sparse.

C is skew, the Coriolis forces 2 gamma G. K, with the softening in it, is symmetric where the loads
have a potential; the Euler force of a spin-up adds a skew part.
"""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

from beamviz.errors import NotConverged
from beamviz.solver.pencil.inverse import COMPRESSED, inverse_modes_with_shift
from beamviz.solver.pencil.matrices import EPS, TINY, Modes, Pencil, exponents, product

FEW = 60  # number of unknowns up to which all modes are computed faster than some
# Size of a Hermitian problem up to which, and up to how many times the modes asked for, all its
# modes are computed faster than some: 2 ms.
FEW_HERMITIAN, FEW_FOR_EACH = 150, 25
MORE_MODES = 4  # beyond those asked for, in which an instability is seen
ROUNDING_FACTOR = 100.0  # of the estimated rounding error, see scripts/measure_error_bars.py
MIXING_FACTOR = 10.0  # of the error estimated for other modes in a vector; at most 4 was seen
# Of the rounding error by the largest eigenvalue of an inverse problem: with 1 a mode beyond those
# asked for passed for a growing one on one of four kinds of processors.
INVERSE_FACTOR = 10.0

Solve = Callable[..., NDArray]  # f -> K^-1 f, with trans=1 K'^-1 f


def symmetric_modes(pencil: Pencil, count: int) -> Modes:
    """The modes without Coriolis forces: s^2 is real."""
    K, M = pencil.K, pencil.M
    nu, rows, added = inverse_modes_with_shift(M, K, count, COMPRESSED)
    V = _of_unit_mass(rows.T, M)
    definite = pencil.factor is not None
    s = 1j * _frequencies(K, None, V) if definite else exponents(1 / nu - added)
    return _with_errors(pencil, s, V, inverse=1 / nu)


def steady_gyroscopic_modes(pencil: Pencil, count: int) -> Modes:
    """The modes with Coriolis forces and a positive definite K, which all vibrate."""
    K, M, C, F, L = pencil.K, pencil.M, pencil.C, pencil.F, pencil.factor
    assert F is not None
    assert L is not None
    s, V = _steady_gyroscopic(L, F, C, count)
    V = _of_unit_mass(V, M)
    return _with_errors(pencil, 1j * _frequencies(K, C, V), V, inverse=abs(s) ** 2)


def _with_errors(pencil: Pencil, s: NDArray, V: NDArray, inverse: NDArray) -> Modes:
    """The modes of a symmetric K, whose left vectors are the vectors. inverse (count,): inverses of
    the eigenvalues of the inverse problem."""
    K, M = pencil.K, pencil.M
    terms = np.diag(K)[:, None] + M.diagonal()[:, None] * (pencil.softening + abs(s) ** 2)
    pairing = _pairing(pencil, s, V, V)
    rounding = ROUNDING_FACTOR * EPS * (terms * abs(V) ** 2).sum(axis=0)
    # The vectors are those of K^-1 M, whose rounding errors are relative to its largest eigenvalue:
    # a vector of a higher mode, with a small one, contains others in that proportion.
    mixed = EPS * inverse / inverse[0]
    rounding += pairing * MIXING_FACTOR * abs(s) * (np.sqrt(EPS * mixed) + mixed**2)
    definite = pencil.factor is not None
    return Modes(-np.square(s).real, V, rounding, definite, pairing)


def _frequencies(K: NDArray, C: NDArray | None, V: NDArray) -> NDArray:
    """The frequencies (count,) at which v* T(i omega) v = 0, T(s) = s^2 M + s C + K, for vectors V
    of unit modal mass: Rayleigh quotients, and with Coriolis forces roots of a quadratic. Their
    errors are the squares of those of the vectors.

    Just past buckling the lowest frequency nearly vanishes. The eigenvalues of the inverse problem
    then have rounding errors of the size of its largest one, beside which the others are small.
    """
    stored = np.maximum((V.conj() * product(K, V)).sum(axis=0).real, 0.0)
    if C is None:
        return np.sqrt(stored)
    swirl = (V.conj() * product(C, V)).sum(axis=0).imag
    root = np.sqrt(swirl**2 + 4 * stored)
    return np.where(swirl > 0, 2 * stored / (root + abs(swirl)), (root - swirl) / 2)


def _of_unit_mass(V: NDArray, M: Any) -> NDArray:
    """The vectors (n, count), of unit modal mass."""
    return V / np.sqrt((V.conj() * product(M, V)).sum(axis=0).real)


def _pairing(pencil: Pencil, s: NDArray, V: NDArray, W: NDArray) -> NDArray:
    """|y* T'(s) v| (count,) for the vectors of modes V and the left ones W, both of unit modal
    mass."""
    slope = 2 * s * product(pencil.M, V)
    if pencil.C is not None:
        slope = slope + product(pencil.C, V)
    return abs((W.conj() * slope).sum(axis=0))


def _steady_gyroscopic(L: NDArray, F: NDArray, C: NDArray, count: int) -> tuple[NDArray, NDArray]:
    """s and vectors (n, count) of the lowest modes of F' F q" + C q' + K q = 0, which all vibrate.

    With K = L L', p = L' q and r = F q' the inverse of (p, r)' = s (p, r) is the skew matrix

        T = [[-L^-1 C L^-T, -L^-1 F'], [F L^-T, 0]].

    Its eigenvalues 1 / s = -i / omega are imaginary: those of the Hermitian i T are 1 / omega.
    """
    n, size = len(L), len(L) + len(F)

    def divided(f: NDArray, transposed: bool) -> NDArray:
        """L^-1 f or L^-T f."""
        return lapack.dtrtrs(L, f, lower=1, trans=transposed)[0]

    def inverse(v: NDArray) -> NDArray:
        """T v of real v (size, k)."""
        q = divided(v[:n], transposed=True)
        return np.concatenate((-divided(C @ q + F.T @ v[n:], transposed=False), F @ q))

    if size > max(FEW_HERMITIAN, FEW_FOR_EACH * count):

        def hermitian(v: NDArray) -> NDArray:
            """i T v of complex v (size,)."""
            parts = inverse(v.view(float).reshape(size, 2))
            return 1j * (parts[:, 0] + 1j * parts[:, 1])

        start = np.random.default_rng(0).standard_normal(size).astype(complex)
        nu, Z = _few_eigenvalues(hermitian, count, start, which="LR")
        highest = nu.real.argsort()[::-1]
        omega, z = 1 / nu.real[highest], Z[:n, highest]
    else:
        T = inverse(np.eye(size))
        nu, Z = np.linalg.eigh(T.T @ T)  # 1 / omega^2, twice each
        omega, Z = 1 / np.sqrt(nu[: -2 * count - 1 : -2]), Z[:, : -2 * count - 1 : -2]
        z = Z[:n] + 1j * omega * (T[:n] @ Z)
    V = divided(np.hstack((z.real, z.imag)), transposed=True)
    return 1j * omega, V[:, : len(omega)] + 1j * V[:, len(omega) :]


def _few_eigenvalues(
    times: Callable[[NDArray], NDArray], count: int, start: NDArray, which: str = "LM"
) -> tuple[NDArray, NDArray]:
    """`count` eigenvalues and vectors (size, count) of a matrix, whose product with v (size,) is
    times(v), by Arnoldi's method from the vector `start`; which: those of largest magnitude ("LM")
    or real part ("LR"). Raises NotConverged."""
    from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigs  # not always needed

    operator = LinearOperator((len(start), len(start)), times, dtype=start.dtype)
    try:
        return eigs(operator, count, which=which, ncv=2 * count + 8, v0=start)
    except ArpackNoConvergence as error:
        raise NotConverged(f"Arnoldi's method found no {count} modes: {error}") from error


def general_modes(pencil: Pencil, count: int) -> Modes:
    """The modes of any regular K, by ascending frequency; of a pair of one frequency that grows and
    decays, the growing mode first.

    A growth rate, or a frequency, within the rounding error of s is 0. The left vectors are the
    vectors of K' and C'.
    """
    M, C, more = pencil.M, pencil.C, count + MORE_MODES
    solve, diagonal = _factorised(pencil.K)
    s, V = _inverse_spectrum(solve, M, C, more)
    transposed = None if C is None else C.T
    s_left, W = _inverse_spectrum(partial(solve, trans=1), M, transposed, more)
    W = W[:, abs(s[:, None] - s_left).argmin(axis=1)].conj()
    V, W = _of_unit_mass(V, M), _of_unit_mass(W, M)
    pairing = _pairing(pencil, s, V, W)
    rounding = ROUNDING_FACTOR * EPS * (diagonal @ (abs(V) * abs(W)))
    if C is not None:  # that of the largest eigenvalue 1/s of the inverse problem
        rounding += INVERSE_FACTOR * pairing * EPS * abs(s) ** 2 / abs(s).min()
    error = rounding / np.maximum(pairing, TINY)
    real = np.where(abs(s.real) <= error, 0.0, s.real)
    s = real + 1j * np.where(abs(s.imag) <= error, 0.0, s.imag)
    kept = np.lexsort((-s.real, abs(s)))[:count]  # the lowest by |s|, by ascending frequency
    kept = kept[np.lexsort((-s.real[kept], s.imag[kept]))]
    return Modes(-np.square(s[kept]), V[:, kept], rounding[kept], False, pairing[kept], all_s=s)


def _factorised(K: Any) -> tuple[Solve, NDArray]:
    """K^-1, and the absolute values of the diagonal of K (n,)."""
    if isinstance(K, np.ndarray):
        # scipy.linalg.lu_solve takes a fifth longer for the modes of a small beam.
        return partial(_solve_dense, lapack.dgetrf(K)[:2]), abs(np.diag(K))
    from scipy.sparse.linalg import splu

    return partial(_solve_sparse, splu(K)), abs(K.diagonal())


def _solve_dense(factors: tuple[NDArray, NDArray], f: NDArray, trans: int = 0) -> NDArray:
    return lapack.dgetrs(*factors, f, trans=trans)[0]


def _solve_sparse(factors: Any, f: NDArray, trans: int = 0) -> NDArray:
    return factors.solve(f, "T" if trans else "N")


def _inverse_spectrum(
    solve: Callable[[NDArray], NDArray], M: Any, C: Any, count: int
) -> tuple[NDArray, NDArray]:
    """s, with Im s >= 0, and vectors (n, count) of the modes of smallest |s|, from the largest
    eigenvalues 1/s^2, or with C (n, n) 1/s, of the inverse problem. Arnoldi's method finds a few of
    many in a subspace that is large enough not to be restarted often."""
    n = M.shape[0]
    size, wanted = (n, count) if C is None else (2 * n, 2 * count)  # s comes with -s or s*
    start = np.random.default_rng(0).standard_normal(size)
    unit = np.sqrt(np.linalg.norm(solve(M @ start[:n])) / np.linalg.norm(start[:n]))

    def inverse(v: NDArray) -> NDArray:
        if C is None:
            return -solve(M @ v)
        # (s q, unit s^2 q) -> (q, unit s q), of one size where s is about 1 / unit
        return np.concatenate((-solve(C @ v[:n] + M @ (v[n:] / unit)), unit * v[:n]))

    if size > max(FEW, 2 * wanted + 8):
        nu, V = _few_eigenvalues(inverse, wanted, start)
    else:
        nu, V = np.linalg.eig(inverse(np.eye(size)))
    if C is None:
        s = np.sqrt(1 / nu.astype(complex))
        s = np.where(s.imag < 0, -s, s)
        lowest = abs(s).argsort()[:count]
    else:
        s = 1 / nu
        forward = np.flatnonzero((s.imag > 0) | ((s.imag == 0) & (s.real > 0)))
        lowest = forward[abs(s[forward]).argsort()[:count]]
    return s[lowest], V[:n, lowest]
