"""Modes about a bent state: M q" + 2 gamma G q' + K q = 0 with the full planar tangent.

A mode is q(t) = Re(v e^(s t)). Low modes keep their digits because the inverse problem is solved,
as in `beamviz.solver.eigen`: the lowest frequencies are then the largest eigenvalues.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg import lapack

from beamviz.errors import NotConverged
from beamviz.solver.bent.tangent import BentBeam
from beamviz.solver.eigen import symmetric_modes

STILL = 1e-9  # share of its growth rate up to which a frequency is rounding


class BentModes(NamedTuple):
    """The lowest modes: frequency and growth rate from s = growth + i frequency."""

    frequencies: np.ndarray  # (count,) ascending
    growth_rates: np.ndarray  # (count,) real part of s; 0 without a spin-up
    V: np.ndarray  # (2 n, count) complex with Coriolis forces or a spin-up, unit modal mass
    definite: bool  # whether K is positive definite: a stable state, where it is symmetric

    @property
    def omega_squared(self) -> np.ndarray:
        """Squared frequencies (count,); minus squared growth rates of modes without frequency."""
        return squared(self.growth_rates + 1j * self.frequencies)


def squared(s: np.ndarray) -> np.ndarray:
    """Squared frequencies; minus squared growth rates of modes without a frequency."""
    return np.where(s.imag <= STILL * abs(s.real), -(s.real**2), s.imag**2)


def oscillating_or_growing(s: np.ndarray) -> np.ndarray:
    """Of each pair s and -s the one with a frequency above 0, or that grows."""
    still = abs(s.imag) <= STILL * abs(s)
    return np.where(np.where(still, s.real < 0, s.imag < 0), -s, s)


def bent_modes(bent: BentBeam, q: np.ndarray, K: np.ndarray, count: int) -> BentModes:
    """The `count` lowest modes about a state q (2 n,) with the tangent stiffness K (2 n, 2 n).

    A state without a spin-up has to be stable, which the descent to it guarantees. Raises
    NotConverged where the stiffness of such a state is not positive definite.
    """
    scale, gamma = bent.scale, bent.beam.gamma
    K, B = scale[:, None] * K * scale, bent.displacements(q) * scale
    F = B.reshape(-1, len(scale))  # M = F' F
    G = None
    if bent.problem.gyroscopic and gamma:
        S = B[1].T @ B[0]
        G = S - S.T  # e3 x r' against virtual displacements
    L, info = lapack.dpotrf((K + K.T) / 2, lower=1, clean=1)
    if bent.beam.spin_up:
        found = _general(K, F, G, gamma, count)
    elif info:
        raise NotConverged("the stiffness of a bent state is not positive definite")
    elif G is None:
        omega_squared, V = symmetric_modes(K, F.T @ F, count)
        found = 1j * np.sqrt(omega_squared), V
    else:
        found = _gyroscopic(L, F, G, gamma, count)
    s, V = found
    V = V / np.sqrt((abs(F @ V) ** 2).sum(axis=0))
    order = np.lexsort((-s.real, np.where(s.imag <= STILL * abs(s), 0.0, s.imag)))
    return BentModes(s.imag[order], s.real[order], scale[:, None] * V[:, order], info == 0)


def _gyroscopic(
    L: np.ndarray, F: np.ndarray, G: np.ndarray, gamma: float, count: int
) -> tuple[np.ndarray, np.ndarray]:
    """With Coriolis forces, p = L' q and r = F q': the inverse of (p, r)' = s (p, r) is the skew
    matrix T = [[-C, -X], [X', 0]], C = 2 gamma L^-1 G L^-T, X = L^-1 F'. Its eigenvalues
    1 / s = -i / omega are imaginary; those of T' T are 1 / omega^2, twice each."""
    X = lapack.dtrtrs(L, F.T, lower=1)[0]
    C = lapack.dtrtrs(L, lapack.dtrtrs(L, 2 * gamma * G, lower=1)[0].T, lower=1)[0].T
    n, m = X.shape
    T = np.zeros((n + m, n + m))
    T[:n, :n], T[:n, n:], T[n:, :n] = -C, -X, X.T
    nu, Z = np.linalg.eigh(T.T @ T)
    omega = 1 / np.sqrt(nu[: -2 * count - 1 : -2])
    z = Z[:, : -2 * count - 1 : -2]
    real, imaginary = z[:n], omega * (T[:n] @ z)  # z + i omega T z has the eigenvalue -i / omega
    V = lapack.dtrtrs(L, np.hstack((real, imaginary)), lower=1, trans=1)[0]
    return 1j * omega, V[:, :count] + 1j * V[:, count:]


def _general(
    K: np.ndarray, F: np.ndarray, G: np.ndarray | None, gamma: float, count: int
) -> tuple[np.ndarray, np.ndarray]:
    """s and vectors for an unsymmetric K: the largest eigenvalues of the inverse problem, without
    Coriolis forces M v = (-1 / s^2) K v."""
    M, n = F.T @ F, len(K)
    if G is None:
        nu, V = np.linalg.eig(np.linalg.solve(K, M))  # 1 / omega^2
        largest = np.argsort(-abs(nu))[:count]
        return oscillating_or_growing(1j * np.sqrt(1 / nu[largest].astype(complex))), V[:, largest]
    inverse = np.linalg.solve(K, np.hstack((-2 * gamma * G, -M)))  # q = inverse (s q, s^2 q)
    P = np.zeros((2 * n, 2 * n))
    P[:n], P[n:, :n] = inverse, np.eye(n)  # (q, s q) = s P (q, s q)
    nu, V = np.linalg.eig(P)
    s = 1 / nu
    upward = np.flatnonzero(oscillating_or_growing(s) == s)
    lowest = upward[np.argsort(abs(s[upward]))[:count]]
    return s[lowest], V[:n, lowest]
