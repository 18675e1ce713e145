"""Modes about deflected equilibria: M q" + C q' + K q = 0 with q(t) = Re(v e^(s t)).

C is skew, the Coriolis forces 2 gamma G. K, with the softening in it, is symmetric without a
spin-up; the Euler force of a spin-up adds a skew part. Low modes keep their digits because the
inverse problem is solved, as in `beamviz.solver.eigen`: the lowest frequencies are then the largest
eigenvalues.
"""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

from beamviz.errors import NotConverged
from beamviz.solver.bent.beam import BentState, product
from beamviz.solver.eigen import COMPRESSED, EPS, symmetric_modes
from beamviz.solver.solution import Status, status_of

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
TINY = 1e-300  # keeps a quotient finite whose denominator vanishes where modes coalesce


class BentModes(NamedTuple):
    """The lowest modes about a deflected state."""

    s: NDArray  # (count,) growth rate + i frequency, by ascending frequency
    V: NDArray  # (unknowns, count) complex with Coriolis forces or a spin-up, unit modal mass
    pairing: NDArray  # (count,) |y* (2 s M + C) v|, y the left vector: small where modes coalesce
    rounding: NDArray  # (count,) estimated rounding error of s
    status: Status  # by these modes and, with a spin-up, MORE_MODES beyond them


def bent_modes(state: BentState, count: int) -> BentModes:
    """The `count` lowest modes about a state. A state without a spin-up has to be stable, which the
    descent to it guarantees. Raises NotConverged where the stiffness of such a state is not
    positive definite."""
    K, M, C = state.stiffness, state.inertia, state.gyroscopic
    spin_up = state.beam.beam.spin_up
    F = None if spin_up or C is None else state.factor_of_inertia
    if spin_up:
        factors = lapack.dgetrf(K)[:2]
        return unsymmetric_modes(partial(_solve, factors), abs(np.diag(K)), M, C, count)
    if not state.is_positive_definite:
        raise NotConverged("the stiffness of a deflected equilibrium is not positive definite")
    if F is not None and C is not None:
        s, V = _steady_gyroscopic(K, F, C, count)
        inverse = abs(s) ** 2
    else:
        omega_squared, V = symmetric_modes(K, M, count, COMPRESSED)
        inverse = omega_squared + COMPRESSED
    V = _of_unit_mass(V, M)
    s = 1j * _frequencies(K, C, V)
    gamma = state.beam.beam.gamma  # whose square is the softening
    terms = np.diag(K)[:, None] + M.diagonal()[:, None] * (gamma**2 + abs(s) ** 2)
    pairing, rounding = _pairing((terms * abs(V) ** 2).sum(axis=0), M, C, s, V, V)
    # The vectors are those of K^-1 M, whose rounding errors are relative to its largest eigenvalue:
    # a vector of a higher mode, with a small one, contains others in that proportion.
    mixed = EPS * inverse / inverse[0]
    rounding += MIXING_FACTOR * abs(s) * (np.sqrt(EPS * mixed) + mixed**2)
    return BentModes(s, V, pairing, rounding, "stable")


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


def _solve(factors: tuple[NDArray, NDArray], f: NDArray, trans: int = 0) -> NDArray:
    """K^-1 f, or with trans=1 K'^-1 f, by the factors of K and their pivots: scipy.linalg.lu_solve
    takes a fifth longer for the modes of a small beam."""
    return lapack.dgetrs(*factors, f, trans=trans)[0]


def _of_unit_mass(V: NDArray, M: Any) -> NDArray:
    """The vectors (n, count), of unit modal mass."""
    return V / np.sqrt((V.conj() * product(M, V)).sum(axis=0).real)


def _pairing(
    size: NDArray, M: Any, C: Any, s: NDArray, V: NDArray, W: NDArray
) -> tuple[NDArray, NDArray]:
    """|y* T'(s) v| with T(s) = s^2 M + s C + K, for the vectors of modes V and the left ones W,
    both of unit modal mass, and the rounding error of s: that of y* T(s) v over it. size (count,):
    the sum of the absolute terms of y* T(s) v."""
    slope = 2 * s * product(M, V)
    if C is not None:
        slope = slope + product(C, V)
    pairing = abs((W.conj() * slope).sum(axis=0))
    return pairing, ROUNDING_FACTOR * EPS * size / np.maximum(pairing, TINY)


def _steady_gyroscopic(K: NDArray, F: NDArray, C: NDArray, count: int) -> tuple[NDArray, NDArray]:
    """s and vectors (n, count) of the lowest modes of F' F q" + C q' + K q = 0, which all vibrate.

    With p = L' q, K = L L', and r = F q' the inverse of (p, r)' = s (p, r) is the skew matrix

        T = [[-L^-1 C L^-T, -L^-1 F'], [F L^-T, 0]].

    Its eigenvalues 1 / s = -i / omega are imaginary: those of the Hermitian i T are 1 / omega.
    """
    n, size = len(K), len(K) + len(F)
    L = lapack.dpotrf(K, lower=1)[0]

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


def unsymmetric_modes(
    solve: Callable[..., NDArray], stiffness: NDArray, M: Any, C: Any, count: int
) -> BentModes:
    """The lowest modes of s^2 M v + s C v + K v = 0, by ascending frequency, with an unsymmetric
    K; of a pair of one frequency that grows and decays, the growing mode first.

    solve: f -> K^-1 f, with trans=1 K'^-1 f. stiffness: |diagonal| of K. A growth rate, or a
    frequency, within the rounding error of s is 0. The left vectors are the vectors of K' and C'.
    """
    s, V = _inverse_spectrum(solve, M, C, count + MORE_MODES)
    transposed = None if C is None else C.T
    s_left, W = _inverse_spectrum(partial(solve, trans=1), M, transposed, count + MORE_MODES)
    W = W[:, abs(s[:, None] - s_left).argmin(axis=1)].conj()
    V, W = _of_unit_mass(V, M), _of_unit_mass(W, M)
    pairing, rounding = _pairing(stiffness @ (abs(V) * abs(W)), M, C, s, V, W)
    if C is not None:  # that of the largest eigenvalue 1/s of the inverse problem
        rounding += INVERSE_FACTOR * EPS * abs(s) ** 2 / abs(s).min()
    real = np.where(abs(s.real) <= rounding, 0.0, s.real)
    s = real + 1j * np.where(abs(s.imag) <= rounding, 0.0, s.imag)
    kept = np.lexsort((-s.real, abs(s)))[:count]  # the lowest by |s|, by ascending frequency
    kept = kept[np.lexsort((-s.real[kept], s.imag[kept]))]
    return BentModes(s[kept], V[:, kept], pairing[kept], rounding[kept], status_of(s))


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
