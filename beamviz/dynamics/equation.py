"""The equation of motion in the rotating frame (paper, eqs. 26-38), dimensionless.

With r(x, t) the position from the clamp in the axes of the hub, as complex numbers r1 + i r2, and
R = r + delta that from the axis of rotation, the force of inertia of each point of mass is

    p = rho (r" + 2 i gamma r' + (i gamma' - gamma^2) R),    rho = 1 + alpha Dirac(x - beta),

its Coriolis, Euler and centrifugal parts among them. By the principle of virtual work the forces on
the unknowns q that r depends on vanish together,

    int p . dr/dq dx + D q' + dU/dq - F . dr/dq = 0,

with the damping D and a constant force F at one point. For positions r = N q, which are linear in
the unknowns, this is M q" + 2 gamma G q' + D q' + (gamma' G - gamma^2 M)(q + delta) + dU/dq = F.

The speed gamma(t) is prescribed, or that of a hub of inertia J under a torque:

    J gamma' + int R x p dx = torque.

Arrays have the instants of time in their first axis: q, v = q' and a = q" are (k, n).
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from beamviz.beam import Beam
from beamviz.dynamics.coordinates import State, StretchAndAngle
from beamviz.dynamics.cubic import CubicPositions, CubicState
from beamviz.dynamics.elements import Elements
from beamviz.errors import NoEquilibrium
from beamviz.solver.constitutive import StrainLaw

Speed = Callable[[NDArray], tuple[NDArray, NDArray]]  # t (k,) -> gamma and gamma' (k,) each
Load = tuple[NDArray, NDArray]  # what is prescribed at k times, and its rate
TIP = 1.0


@dataclass(frozen=True)
class Model:
    """The beam, its strain law and the power of its curvature measure. cubic: whether the unknowns
    are those of the paper. force_at: the point that a force acts on."""

    beam: Beam
    law: StrainLaw
    curvature_power: int
    cubic: bool = False
    force_at: float = TIP

    def unknowns(self, elements: Elements) -> StretchAndAngle | CubicPositions:
        """The unknowns on some elements; the mass and the force act on the last two points."""
        kind = CubicPositions if self.cubic else StretchAndAngle
        others = (self.beam.beta, self.force_at)
        return kind(elements, self.beam.mu, self.law, self.curvature_power, others)


class Equation:
    """The equation of motion of a beam whose speed is prescribed. rho: mass of the points
    (m + 2,)."""

    def __init__(
        self,
        elements: Elements,
        model: Model,
        speed: Speed,
    ):
        self.model, self.speed = model, speed
        self.unknowns = model.unknowns(elements)
        self.size = self.unknowns.size  # of the beam
        self.delta = model.beam.delta
        self.rho = np.append(elements.weights, (model.beam.alpha, 0.0))
        self.D = np.zeros((self.size, self.size))  # the damping
        self.force: complex = 0.0

    # Motion

    def load(self, t: NDArray) -> Load:
        """gamma and gamma' (k,) at times t."""
        return self.speed(t)

    def residual(self, load: Load, q: NDArray, v: NDArray, a: NDArray) -> NDArray:
        """The left-hand side of the equation (k, n). load: at the times of q, v and a."""
        state = self.unknowns.state(q, v, a)
        return self.forces(state, self.inertia(state, *load), v)

    def tangents(self, load: Load, q: NDArray, v: NDArray, a: NDArray) -> tuple[NDArray, ...]:
        """Derivatives of the residual by q, v and a: (n, n) each. load, q, v and a: of one
        instant, k = 1."""
        return self.tangents_of(self.unknowns.state(q, v, a), load)[:3]

    def balance(self, gamma: float, q: NDArray) -> tuple[NDArray, NDArray, NDArray]:
        """The forces (n,) on the unknowns (n,) of the beam at rest at a constant speed, K and M."""
        load, still = (np.array([gamma]), np.zeros(1)), np.zeros((1, self.size))
        state = self.unknowns.state(q[None], still, still)
        (R,) = self.forces(state, self.inertia(state, *load), still)
        K, _, M, *_ = self.tangents_of(state, load)
        return R, K, M

    def accelerations(self, t: NDArray, q: NDArray, v: NDArray) -> NDArray:
        """a (1, n) from positions and velocities at one instant."""
        load, none = self.load(t), np.zeros_like(q)
        *_, M = self.tangents(load, q, v, none)
        return -np.linalg.solve(M, self.residual(load, q, v, none)[0])[None]

    def after_docking(
        self, q: NDArray, v: NDArray, before: "Equation", velocity: complex
    ) -> NDArray:
        """v (n,) after the body of this equation has docked with a velocity relative to the hub's
        frame: M v is what it was `before`, and the momentum of the body."""
        load, q, none = self.load(np.zeros(1)), q[None], np.zeros((1, len(v)))
        (*_, M_before), (*_, M) = (e.tangents(load, q, none, none) for e in (before, self))
        body, carried = self.body(q, v, velocity)
        momentum = self.model.beam.alpha * (body.conjugate() * carried).real
        return np.linalg.solve(M, M_before @ v + momentum)

    def body(self, q: NDArray, v: NDArray, velocity: complex) -> tuple[complex, NDArray]:
        """The velocity of a body in the frame in which the momentum is kept, and how its place
        moves with the unknowns (n,)."""
        none = np.zeros_like(q)
        return velocity, self.unknowns.state(q, none, none).derivatives().r_q[-2]

    # Its parts

    def inertia(self, state: State | CubicState, gamma: NDArray, rate: NDArray) -> NDArray:
        """p of each point (k, m + 2), with the force F."""
        gamma, rate = gamma[:, None], rate[:, None]
        R = state.r + self.delta
        p = self.rho * (state.a + 2j * gamma * state.v + (1j * rate - gamma**2) * R)
        if self.force:
            p[:, -1] -= self.force
        return p

    def forces(self, state: State | CubicState, p: NDArray, v: NDArray) -> NDArray:
        """The left-hand side of the equation of the beam (k, n)."""
        return state.pulled_back(p) + state.elastic() + v @ self.D.T

    def tangents_of(
        self, state: State | CubicState, load: Load
    ) -> tuple[NDArray, NDArray, NDArray, NDArray, NDArray]:
        """K, C and M (n, n), then the derivatives of p by q and by v (m + 2, n) over rho."""
        (gamma,), (rate,) = load
        r_q, v_q, a_q, a_v = state.derivatives()
        p_q = a_q + 2j * gamma * v_q + (1j * rate - gamma**2) * r_q
        p_v = a_v + 2j * gamma * r_q
        virtual = (r_q.conj() * self.rho[:, None]).T
        p = self.inertia(state, *load)
        K = (virtual @ p_q).real + state.geometric(p) + state.elastic_tangent()
        return K, (virtual @ p_v).real + self.D, (virtual @ r_q).real, p_q, p_v

    def gamma(self, t: NDArray, v: NDArray) -> NDArray:
        """The speed (k,)."""
        return self.speed(t)[0]

    def energy(self, gamma: NDArray, q: NDArray, v: NDArray) -> NDArray:
        """int rho |r'|^2 / 2 + U - gamma^2 / 2 int rho |R|^2 (k,), constant at a constant speed
        without damping (the Jacobi integral)."""
        state = self.unknowns.state(q, v, np.zeros_like(q))
        kinetic = abs(state.v) ** 2 @ self.rho / 2
        centrifugal = gamma**2 / 2 * (abs(state.r + self.delta) ** 2 @ self.rho)
        return kinetic + self.unknowns.strain_energy(q) - centrifugal

    def check(self, t: float, q: NDArray, v: NDArray) -> None:
        """Raises NoEquilibrium where the stretch of positions q (n,), with velocities v, is out of
        the range of the strain law."""
        law, f = self.model.law, self.unknowns.gauss_stretch(q[: self.size])
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

    def __init__(
        self,
        elements: Elements,
        model: Model,
        inertia: float,
        torque: Speed,
    ):
        super().__init__(elements, model, torque)
        self.J = inertia

    def gamma(self, t: NDArray, v: NDArray) -> NDArray:
        return v[:, -1]

    def residual(self, load: Load, q: NDArray, v: NDArray, a: NDArray) -> NDArray:
        """As with a prescribed speed, and the balance of angular momentum (k, n + 1). load: the
        torque and its rate."""
        state = self.unknowns.state(q[:, :-1], v[:, :-1], a[:, :-1])
        p = self.inertia(state, v[:, -1], a[:, -1])
        R = state.r + self.delta
        hub = self.J * a[:, -1] + (R.conj() * p).imag.sum(axis=1) - load[0]
        return np.column_stack((self.forces(state, p, v[:, :-1]), hub))

    def tangents(self, load: Load, q: NDArray, v: NDArray, a: NDArray) -> tuple[NDArray, ...]:
        state = self.unknowns.state(q[:, :-1], v[:, :-1], a[:, :-1])
        motion = v[:, -1], a[:, -1]
        p, (R,) = self.inertia(state, *motion)[0], state.r + self.delta
        *beam, p_q, p_v = self.tangents_of(state, motion)
        r_q, rho = state.derivatives().r_q, self.rho
        p_gamma = 2j * (state.v[0] + 1j * v[0, -1] * R)
        turned, n = (R.conj() * rho), self.size
        K, C, M = np.zeros((3, n + 1, n + 1))
        K[:n, :n], C[:n, :n], M[:n, :n] = beam
        K[n, :n] = (turned @ p_q + p @ r_q.conj()).imag
        C[:n, n] = ((rho * p_gamma) @ r_q.conj()).real
        C[n, :n] = (turned @ p_v).imag
        C[n, n] = (turned @ p_gamma).imag
        M[n, :n] = M[:n, n] = (turned @ r_q).imag
        M[n, n] = self.J + (turned @ R).real
        return K, C, M

    def body(self, q: NDArray, v: NDArray, velocity: complex) -> tuple[complex, NDArray]:
        """As with a prescribed speed, but the velocity in the fixed frame, of a body whose velocity
        is relative to the frame of the hub before."""
        _, r_q = super().body(q[:, :-1], v[:-1], velocity)
        R = self.unknowns.positions(q[:, :-1], self.model.beam.beta)[0, 0] + self.delta
        return velocity + 1j * v[-1] * R, np.append(r_q, 1j * R)
