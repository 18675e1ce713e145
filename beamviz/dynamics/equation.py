"""The equation of motion of a beam on a hub, as a system of differential equations in time.

That of the beam is in `beamviz.mechanics`. The speed gamma(t) is prescribed, or that of a hub of
inertia J under a torque:

    J gamma' + int R x p dx + moments of bodies = torque,

with the force of inertia p and the position R from the axis. Arrays have the instants of time in
their first axis: q, v = q' and a = q" are (k, n).
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from beamviz.errors import NoEquilibrium
from beamviz.mechanics.cubic import CubicBeam, CubicState
from beamviz.mechanics.inertia import Loading
from beamviz.mechanics.planar import MovingState, PlanarBeam, Tangents

AnyBeam = PlanarBeam | CubicBeam
AnyState = MovingState | CubicState
Speed = Callable[[NDArray], tuple[NDArray, NDArray]]  # t (k,) -> gamma and gamma' (k,) each
Load = tuple[NDArray, NDArray]  # what is prescribed at k times, and its rate


class Energies(NamedTuple):
    """Energies in the rotating frame (k,) [E I / L]."""

    kinetic: NDArray  # int rho |r'|^2 / 2, with that of bodies that turn
    strain: NDArray  # U, with that of a spring at the root
    centrifugal: NDArray  # -gamma^2 / 2 int rho |R|^2, a potential

    @property
    def total(self) -> NDArray:
        """Their sum: at a constant speed without damping it is constant, the Jacobi integral."""
        return self.kinetic + self.strain + self.centrifugal


class Equation:
    """The equation of motion of a beam whose speed is prescribed."""

    def __init__(self, beam: AnyBeam, speed: Speed):
        self.beam, self.speed = beam, speed
        self.size = beam.size  # of the beam
        self.D = np.zeros((self.size, self.size))  # the damping
        self.lengths = beam.lengths  # (n,) [L] of a unit of each unknown

    def load(self, t: NDArray) -> Load:
        """gamma and gamma' (k,) at times t."""
        return self.speed(t)

    def gamma(self, t: NDArray, v: NDArray) -> NDArray:
        """The speed (k,)."""
        return self.speed(t)[0]

    def residual(self, load: Load, q: NDArray, v: NDArray, a: NDArray) -> NDArray:
        """The left-hand side of the equation (k, n). load: at the times of q, v and a."""
        gamma, rate = load
        return self.moving(gamma, rate, q, v, a).residual + v @ self.D.T

    def tangents(self, load: Load, q: NDArray, v: NDArray, a: NDArray) -> Tangents:
        """Derivatives of the residual by q, v and a, of one instant: k = 1."""
        (gamma,), (rate,) = load
        (K, C, M), _ = self.beam.moving(q[0], v[0], a[0], Loading(gamma, rate)).tangents()
        return Tangents(K, C + self.D, M)

    def moving(self, gamma: NDArray, rate: NDArray, q: NDArray, v: NDArray, a: NDArray) -> AnyState:
        """The states of the beam at k instants."""
        return self.beam.moving(q, v, a, Loading(gamma[:, None], rate[:, None]))

    def accelerations(self, t: NDArray, q: NDArray, v: NDArray) -> NDArray:
        """a (1, n) from positions and velocities at one instant."""
        load, none = self.load(t), np.zeros_like(q)
        M = self.tangents(load, q, v, none).M
        return -np.linalg.solve(M, self.residual(load, q, v, none)[0])[None]

    def after_docking(
        self, q: NDArray, v: NDArray, before: "Equation", velocity: complex
    ) -> NDArray:
        """v (n,) after the body of this equation has docked with a velocity relative to the hub's
        frame: M v is what it was `before`, and the momentum of the body."""
        load, q, none = self.load(np.zeros(1)), q[None], np.zeros((1, len(v)))
        M_before, M = (each.tangents(load, q, none, none).M for each in (before, self))
        body, carried = self.body(q[0], v, velocity)
        momentum = self.beam.beam.alpha * (body.conjugate() * carried).real
        return np.linalg.solve(M, M_before @ v + momentum)

    def body(self, q: NDArray, v: NDArray, velocity: complex) -> tuple[complex, NDArray]:
        """The velocity of a body in the frame in which the momentum is kept, and how its place
        moves with the unknowns (n,)."""
        return velocity, self.beam.state(q).displacement_at(self.beam.beam.beta)

    def energies(self, gamma: NDArray, q: NDArray, v: NDArray) -> Energies:
        """The energies (k,) at k instants."""
        state = self.moving(gamma, np.zeros_like(gamma), q, v, np.zeros_like(q))
        return Energies(state.kinetic, state.stored, -state.centrifugal)

    def energy(self, gamma: NDArray, q: NDArray, v: NDArray) -> NDArray:
        """Their sum (k,)."""
        return self.energies(gamma, q, v).total

    def check(self, t: float, q: NDArray, v: NDArray) -> None:
        """Raises NoEquilibrium where the stretch of positions q (n,), with velocities v, is out of
        the range of the strain law."""
        law, f = self.beam.theory.law, self.beam.state(q[: self.size]).f
        for value, beyond in ((f.min(), law.min_stretch), (f.max(), law.max_stretch)):
            if (value <= beyond) == (beyond < 1):
                gamma = float(self.gamma(np.array([t]), v[None])[0])
                raise NoEquilibrium(
                    f"t = {t:.4g}, gamma = {gamma:.4g}: the stretch {value:.4g} leaves the range of"
                    f" {law.name} strain, {law.min_stretch:.4g} .. {law.max_stretch:.4g}, in which"
                    " the axial force grows with the stretch",
                    math.nan,
                )


class HubEquation(Equation):
    """The equation of motion of a beam on a hub of inertia J under a torque. The last unknown is
    the angle of the hub, its velocity the speed gamma."""

    def __init__(self, beam: AnyBeam, inertia: float, torque: Speed):
        super().__init__(beam, torque)
        self.J = inertia
        self.lengths = np.append(self.lengths, 1.0)

    def gamma(self, t: NDArray, v: NDArray) -> NDArray:
        return v[:, -1]

    def residual(self, load: Load, q: NDArray, v: NDArray, a: NDArray) -> NDArray:
        """As with a prescribed speed, and the balance of angular momentum (k, n + 1). load: the
        torque and its rate."""
        state = self.moving(v[:, -1], a[:, -1], q[:, :-1], v[:, :-1], a[:, :-1])
        moment = (state.R.conj() * state.p).imag.sum(axis=1) + state.body_moments.sum(axis=1)
        hub = self.J * a[:, -1] + moment - load[0]
        return np.column_stack((state.residual + v[:, :-1] @ self.D.T, hub))

    def tangents(self, load: Load, q: NDArray, v: NDArray, a: NDArray) -> Tangents:
        gamma, n = v[0, -1], self.size
        state = self.beam.moving(q[0, :-1], v[0, :-1], a[0, :-1], Loading(gamma, a[0, -1]))
        of_beam, derivatives = state.tangents()
        position, by_q, by_v = derivatives
        R, mass = state.R, self.beam.mass
        by_gamma = 2j * (state.velocities + 1j * gamma * R)  # of the force of inertia
        turned, rotary = R.conj() * mass, self.beam.rotary_inertia
        K, C, M = np.zeros((3, n + 1, n + 1))
        K[:n, :n], C[:n, :n], M[:n, :n] = of_beam.K, of_beam.C + self.D, of_beam.M
        K[n, :n] = (turned @ by_q + state.p @ position.conj()).imag
        C[:n, n] = ((mass * by_gamma) @ position.conj()).real
        C[n, :n] = (turned @ by_v).imag
        C[n, n] = (turned @ by_gamma).imag
        M[n, :n] = M[:n, n] = (turned @ position).imag + rotary.sum(axis=0)
        M[n, n] = self.J + (turned @ R).real + self.beam.rotary.sum()
        return Tangents(K, C, M)

    def body(self, q: NDArray, v: NDArray, velocity: complex) -> tuple[complex, NDArray]:
        """As with a prescribed speed, but the velocity in the fixed frame, of a body whose velocity
        is relative to the frame of the hub before."""
        _, carried = super().body(q[:-1], v[:-1], velocity)
        beam = self.beam.beam
        R = self.beam.state(q[:-1]).positions(np.array([beam.beta]))[0] + beam.delta
        return velocity + 1j * v[-1] * R, np.append(carried, 1j * R)
