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
from scipy.linalg import lapack, lu_factor, lu_solve

from beamviz.errors import NotConverged
from beamviz.solver.bent.beam import BentState
from beamviz.solver.eigen import EPS, symmetric_modes
from beamviz.solver.solution import Status, status_of

FEW = 60  # number of unknowns up to which all modes are computed faster than some
MORE_MODES = 4  # beyond those asked for, in which an instability is seen
ROUNDING_FACTOR = 100.0  # of the estimated rounding error, see scripts/measure_error_bars.py
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
    K, M, C = state.stiffness, state.inertia, coriolis(state)
    if state.beam.beam.spin_up:
        factors = lu_factor(K)
        return unsymmetric_modes(partial(lu_solve, factors), abs(np.diag(K)), M, C, count)
    L, info = lapack.dpotrf(K, lower=1, clean=1)
    if info:
        raise NotConverged("the stiffness of a deflected equilibrium is not positive definite")
    F = np.vstack((*state.displacements, state.rotations))
    if C is not None:
        s, V = _steady_gyroscopic(L, np.linalg.qr(F)[1], C, count)
    else:
        omega_squared, V = symmetric_modes(K, M, count)
        s = 1j * np.sqrt(omega_squared)
    V = V / np.sqrt((abs(F @ V) ** 2).sum(axis=0))
    pairing, rounding = _pairing(abs(np.diag(K)), M, C, s, V, V)
    return BentModes(s, V, pairing, rounding, "stable")


def coriolis(state: BentState) -> NDArray | None:
    """The matrix C of a state; None without Coriolis forces."""
    gamma = state.beam.beam.gamma
    return 2 * gamma * state.swirl if state.beam.problem.gyroscopic and gamma else None


def _pairing(
    stiffness: NDArray, M: Any, C: Any, s: NDArray, V: NDArray, W: NDArray
) -> tuple[NDArray, NDArray]:
    """|y* T'(s) v| with T(s) = s^2 M + s C + K, for the vectors of modes V and the left ones W,
    both of unit modal mass, and the rounding error of s: that of y* K v over it. stiffness: the
    diagonal of K."""
    slope = 2 * s * (M @ V)
    if C is not None:
        slope = slope + C @ V
    pairing = abs((W.conj() * slope).sum(axis=0))
    size = stiffness @ (abs(V) * abs(W))
    return pairing, ROUNDING_FACTOR * EPS * size / np.maximum(pairing, TINY)


def _steady_gyroscopic(L: NDArray, F: NDArray, C: NDArray, count: int) -> tuple[NDArray, NDArray]:
    """s and vectors (n, count) of the lowest modes of F' F q" + C q' + L L' q = 0, which all
    vibrate.

    With p = L' q, K = L L', and r = F q' the inverse of (p, r)' = s (p, r) is the skew matrix
    T = [[-L^-1 C L^-T, -X], [X', 0]], X = L^-1 F'. Its eigenvalues
    1 / s = -i / omega are imaginary; those of T' T are 1 / omega^2, twice each.
    """
    X = lapack.dtrtrs(L, F.T, lower=1)[0]
    C = lapack.dtrtrs(L, lapack.dtrtrs(L, C, lower=1)[0].T, lower=1)[0].T
    n, m = X.shape
    T = np.zeros((n + m, n + m))
    T[:n, :n], T[:n, n:], T[n:, :n] = -C, -X, X.T
    nu, Z = np.linalg.eigh(T.T @ T)
    omega = 1 / np.sqrt(nu[: -2 * count - 1 : -2])
    z = Z[:, : -2 * count - 1 : -2]
    real, imaginary = z[:n], omega * (T[:n] @ z)  # z + i omega T z has the eigenvalue -i / omega
    V = lapack.dtrtrs(L, np.hstack((real, imaginary)), lower=1, trans=1)[0]
    return 1j * omega, V[:, :count] + 1j * V[:, count:]


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
    V, W = (
        vectors / np.sqrt(abs((vectors.conj() * (M @ vectors)).sum(axis=0))) for vectors in (V, W)
    )
    pairing, rounding = _pairing(stiffness, M, C, s, V, W)
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

    if isinstance(M, np.ndarray):  # products with a matrix take less time than solutions
        A = -solve(M) if C is None else -solve(np.hstack((C, M / unit)))

    def inverse(v: NDArray) -> NDArray:
        if isinstance(M, np.ndarray):
            first = A @ v
        else:
            first = -solve(M @ v if C is None else C @ v[:n] + M @ (v[n:] / unit))
        # (s q, unit s^2 q) -> (q, unit s q), of one size where s is about 1 / unit
        return first if C is None else np.concatenate((first, unit * v[:n]))

    if size > max(FEW, 2 * wanted + 8):
        from scipy.sparse.linalg import LinearOperator, eigs  # other states need none of it

        operator = LinearOperator((size, size), inverse, dtype=float)
        nu, V = eigs(operator, wanted, ncv=2 * wanted + 8, v0=start)
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
