"""A bent beam on an hp mesh: energy, residual, tangent stiffness, inertia and modes.

The unknowns at the Gauss points are the stretch f = |r'|, which may have a jump at the concentrated
mass, and the slope kappa = theta' of the angle. Then theta = int kappa, r' = f (cos theta,
sin theta) and r = int r' from the clamp, so that the clamp is exact and nothing else has to be
continuous: the straight formulation of `beamviz.solver.hp` with an angle that is not small.

Energy (paper, eqs. 14-19): int mu^2 e(f)^2 / 2 + b(f) kappa^2 / 2 dx with b = f^(4 - 2c), c the
power of the curvature measure; centrifugal potential -gamma^2 / 2 int rho |P R|^2 dx with
R = r + delta e1 and P the projection away from the axis of rotation. The Euler force of a spin-up,
-lambda rho e3 x R (paper, eq. 45), has no potential; its tangent is skew. At an equilibrium the
second derivative does not depend on the coordinates: in (f, kappa) it is the tangent of eq. 44.

Modes: M q" + 2 gamma G q' + K q = 0 with q(t) = Re(v e^(s t)). Low modes keep their digits because
the inverse problem is solved, as in `beamviz.solver.eigen`: the lowest frequencies are then the
largest eigenvalues.
"""

from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import lapack

from beamviz.beam import Beam
from beamviz.errors import NotConverged
from beamviz.solver.eigen import symmetric_modes
from beamviz.solver.hp.mesh import Mesh
from beamviz.solver.problem import Problem

SECTION_STEPS = 60  # of Newton's method for the stretch at the clamp
STILL = 1e-9  # share of its growth rate up to which a frequency is rounding


class Tangent(NamedTuple):
    """Residual and tangent stiffness of a state."""

    residual: np.ndarray  # (2 n,) derivative of the energy by (f, kappa), less the Euler force
    K: np.ndarray  # (2 n, 2 n) symmetric without a spin-up


def in_axes_of_the_beam(dx: np.ndarray, dy: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Displacements (k, 2, modes) along and across the beam at points with an angle (k,), of those
    in x and in y (k, modes)."""
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    return np.stack((c * dx + s * dy, c * dy - s * dx), axis=1)


class BentBeam:
    """A beam on a mesh whose breaks hold the concentrated mass.

    A state q (2 n,) is the stretch f at the n Gauss points and after it kappa.
    """

    def __init__(self, mesh: Mesh, beam: Beam, problem: Problem):
        self.mesh, self.beam, self.problem = mesh, beam, problem
        self.w, self.J, self.R, self.mass = mesh.weights, mesh.J, mesh.J, mesh.weights
        self.inertia = mesh.G  # (n, n) R' mass R
        if beam.alpha and beam.beta:
            to_mass = np.where(mesh.points < beam.beta, self.w, 0.0)
            self.R, self.mass = np.vstack([self.J, to_mass]), np.append(self.w, beam.alpha)
            self.inertia = mesh.G + beam.alpha * np.outer(to_mass, to_mass)
        self.law = problem.strain_law
        self.power = 4 - 2 * problem.curvature_power
        self.softens = float(problem.chordwise)  # P keeps the component across the beam

    def changed(self, mesh: Mesh | None = None, /, **numbers: Any) -> "BentBeam":
        """On another mesh, or with other numbers of the beam."""
        return BentBeam(mesh or self.mesh, self.beam.replace(**numbers), self.problem)

    @property
    def scale(self) -> np.ndarray:
        """1 / sqrt of the stiffness of the beam at rest (2 n,): the unknowns' natural units."""
        return 1 / np.sqrt(np.concatenate((self.beam.mu**2 * self.w, self.w)))

    def rigidities(self, q: np.ndarray) -> np.ndarray:
        """Material stiffness (2 n,) of each unknown, without softening by compression."""
        f, _ = self.split(q)
        axial = self.beam.mu**2 * np.maximum(self.law.stiffness(f), 0.1)
        return np.concatenate((self.w * axial, self.w * f**self.power))

    def split(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Stretch f (n,) and kappa (n,) of a state."""
        n = len(self.w)
        return q[:n], q[n:]

    def resampled(self, q: np.ndarray, mesh: Mesh) -> np.ndarray:
        """A state by interpolation at the Gauss points of another mesh."""
        rows = self.mesh.grid.at(mesh.points)
        return np.concatenate([rows @ part for part in self.split(q)])

    def directions(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """cos theta (n,) and sin theta (n,)."""
        theta = self.J @ self.split(q)[1]
        return np.cos(theta), np.sin(theta)

    def largest_angle(self, q: np.ndarray) -> float:
        """The largest angle [rad] of the beam from where it is clamped."""
        return float(abs(self.J @ self.split(q)[1]).max())

    def energy(self, q: np.ndarray) -> float:
        """Potential energy of a state, without the Euler force; infinite where f <= 0."""
        stored, centrifugal = self.energies(q)
        return stored - centrifugal

    def energies(self, q: np.ndarray) -> tuple[float, float]:
        """Its terms, stored and by the centrifugal force: their sum scales its rounding error."""
        f, kappa = self.split(q)
        if not f.min() > 0:
            return np.inf, 0.0
        c, s = self.directions(q)
        x, y = self.R @ (f * c) + self.beam.delta, self.R @ (f * s)
        stored = self.beam.mu**2 * self.law.strain(f) ** 2 + f**self.power * kappa**2
        centrifugal = self.beam.gamma**2 * (self.mass @ (x * x + self.softens * y * y))
        return float(self.w @ stored) / 2, float(centrifugal) / 2

    def local_stiffness(self, q: np.ndarray) -> np.ndarray:
        """Stiffness (n + 1,) in f of deformations much shorter than the beam, the angle following:
        the second derivative of the energy density less what kappa takes of it; at the points and,
        by the force and the moment there, at the clamp."""
        f, kappa = self.split(q)
        p, mu2, law = self.power, self.beam.mu**2, self.law
        load_x, _ = self.distributed_loads(q)
        moment, pull = f @ self.loads(q)[1], load_x.sum()  # at the clamp
        f0 = float(f[0])
        for _ in range(SECTION_STEPS):
            stiffness = mu2 * law.stiffness(f0) - p * (p + 1) / 2 * f0 ** (-p - 2) * moment**2
            excess = mu2 * law.force(f0) + p / 2 * f0 ** (-p - 1) * moment**2 - pull
            if stiffness <= 0 or abs(excess) <= 1e-9 * stiffness * f0:
                break
            f0 -= float(np.clip(excess / stiffness, -0.3 * f0, 0.3 * f0))
        softening = p * (p + 1) / 2 * f ** (p - 2) * kappa**2
        return np.append(mu2 * law.stiffness(f) - softening, stiffness)

    def distributed_loads(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Centrifugal and Euler force (m,) in x and in y on each mass."""
        (f, _), (c, s), beam = self.split(q), self.directions(q), self.beam
        gamma2, spin_up = beam.gamma**2, beam.spin_up
        x, y = self.R @ (f * c) + beam.delta, self.R @ (f * s)
        load_y = gamma2 * self.softens * y - spin_up * x
        return self.mass * (gamma2 * x + spin_up * y), self.mass * load_y

    def loads(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Force (n,) along the beam and across it of all that lies further out, times weights."""
        (c, s), (x, y) = self.directions(q), (load @ self.R for load in self.distributed_loads(q))
        return x * c + y * s, y * c - x * s

    def residual(self, q: np.ndarray) -> np.ndarray:
        """Derivative (2 n,) of the energy by (f, kappa), less the Euler force (paper, eq. 40)."""
        (f, kappa), (along, across), p = self.split(q), self.loads(q), self.power
        axial = self.beam.mu**2 * self.law.force(f) + p * f ** (p - 1) * kappa**2 / 2
        return np.concatenate(
            (self.w * axial - along, self.w * f**p * kappa - (f * across) @ self.J)
        )

    def tangent(self, q: np.ndarray) -> Tangent:
        """Residual and tangent stiffness of a state (paper, eqs. 40-44)."""
        (f, kappa), (c, s), (along, across) = self.split(q), self.directions(q), self.loads(q)
        w, J, n, p, beam = self.w, self.J, len(f), self.power, self.beam
        gamma2, spin_up = beam.gamma**2, beam.spin_up
        b, db, ddb = f**p, p * f ** (p - 1), p * (p - 1) * f ** (p - 2)
        # d(x, y) = R (t df + f n J dkappa), on which the load works that moves along.
        load = np.array([[gamma2, spin_up], [-spin_up, gamma2 * self.softens]])
        t, fn = np.stack((c, s)), f * np.stack((-s, c))
        along_t, along_n = self.inertia * (t.T @ load @ t), self.inertia * (fn.T @ load @ fn)
        mixed = (-np.diag(across) - self.inertia * (t.T @ load @ fn)) @ J
        i = np.arange(n)
        K = np.empty((2 * n, 2 * n))
        K[:n, :n] = np.diag(w * (beam.mu**2 * self.law.stiffness(f) + ddb * kappa**2 / 2)) - along_t
        K[:n, n:], K[n:, :n] = mixed, mixed.T
        if spin_up:
            K[n:, :n] = J.T @ (-np.diag(across) - self.inertia * (fn.T @ load @ t))
        K[n:, n:] = J.T @ (np.diag(f * along) - along_n) @ J
        K[i, n + i] += w * db * kappa
        K[n + i, i] += w * db * kappa
        K[n + i, n + i] += w * b
        return Tangent(self.residual(q), K)

    def displacements(self, q: np.ndarray) -> np.ndarray:
        """B (2, m, 2 n), root of the mass times d(x, y) / d(f, kappa): the inertia is B' B."""
        (f, _), (c, s), J, R = self.split(q), self.directions(q), self.J, self.R
        B = np.stack(
            (np.hstack((R * c, -(R * (f * s)) @ J)), np.hstack((R * s, (R * (f * c)) @ J)))
        )
        return B * np.sqrt(self.mass)[:, None]

    def position(self, q: np.ndarray, x: np.ndarray) -> np.ndarray:
        """Position (len(x), 2) of reference points, from the clamp."""
        f, _ = self.split(q)
        return self.mesh.grid.from_clamp(x) @ np.column_stack(
            [f * direction for direction in self.directions(q)]
        )


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
    """s and vectors for an unsymmetric K. Without Coriolis forces M v = (-1 / s^2) K v."""
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
