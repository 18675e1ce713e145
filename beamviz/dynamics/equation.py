"""The equation of motion in the rotating frame (paper, eqs. 26-38), dimensionless:

    M q" + 2 gamma G q' + D q' + (gamma' G - gamma^2 M)(q + delta) + dU/dq = F

q: free coefficients of the positions r(x) = N(x) q from the clamp. M = int rho N' N and
G = int rho N' (e3 x N), which is skew, with rho = 1 + alpha Dirac(x - beta); delta stands for the
translation by the hub radius; D is the damping, F a constant force. The strain energy is
U = int mu^2 e(f)^2 / 2 + kappa^2 / 2 dx with f = |r'| and kappa = (r' x r'') / f^c.

The speed gamma(t) is prescribed, or that of a hub of inertia J under a torque:

    (J + int rho |R|^2) gamma' + int rho (R x r" + 2 gamma R . r') = torque,   R = r + delta e1.

Arrays have the instants of time in their first axis: q, v = q' and a = q" are (k, n).
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from beamviz.beam import Beam
from beamviz.dynamics.elements import PositionElements
from beamviz.dynamics.joint import Joint
from beamviz.errors import NoEquilibrium
from beamviz.solver.constitutive import StrainLaw
from beamviz.solver.fem.elements import TURN, axial_hessian, bending, bending_hessian

Speed = Callable[[NDArray], tuple[NDArray, NDArray]]  # t (k,) -> gamma and gamma' (k,) each


@dataclass(frozen=True)
class Model:
    """The beam, its strain law and the power of its curvature measure."""

    beam: Beam
    law: StrainLaw
    curvature_power: int


class Equation:
    """The equation of motion of a beam whose speed is prescribed.

    M, G: (n, n). m: int rho N (2, n). unstressed: q of the straight, unstretched beam (n,).
    """

    def __init__(
        self,
        elements: PositionElements,
        model: Model,
        speed: Speed,
        damping: NDArray | None = None,
        force: NDArray | None = None,
    ):
        self.elements, self.model, self.speed = elements, model, speed
        beam, free = model.beam, elements.free
        self.delta = beam.delta
        S, dS, ddS = elements.S, elements.dS, elements.ddS
        mass, tip = elements.at(np.array([beam.beta]))[0], elements.at(np.ones(1))[0]
        m = S.T @ (elements.weights[:, None] * S) + beam.alpha * np.outer(mass, mass)
        self.M = np.kron(np.eye(2), m)[np.ix_(free, free)]
        self.G = np.kron(TURN, m)[np.ix_(free, free)]
        line = elements.weights @ S + beam.alpha * mass
        self.m = np.kron(np.eye(2), line)[:, free]
        self.at_mass = np.kron(np.eye(2), mass)[:, free]  # (2, n)
        self.at_tip = np.kron(np.eye(2), tip)[:, free]  # (2, n)
        zero = np.zeros_like(dS)
        B = np.stack([[dS, zero], [zero, dS], [ddS, zero], [zero, ddS]])  # (4, 2, m, count)
        B = np.moveaxis(B, 1, 2).reshape(4, len(S), -1)[..., free]
        self.B = np.moveaxis(B, 0, 1)  # (m, 4, n): q -> (r1', r2', r1'', r2'') at the points
        self.flat = self.B.reshape(-1, len(free))  # (4 m, n)
        jump = elements.jump
        self.joint = None if jump is None else Joint(elements, jump, model.curvature_power)
        self.size = self.unknowns = len(free)
        self.D = np.zeros_like(self.M) if damping is None else damping
        self.F = np.zeros(self.size) if force is None else force

    @cached_property
    def unstressed(self) -> NDArray:
        full = np.zeros((2, self.elements.count))
        ends = self.elements.ends
        full[0, : 2 * len(ends) : 2], full[0, 1 : 2 * len(ends) : 2] = ends, 1.0
        if self.elements.jump is not None:
            full[0, 2 * len(ends)] = 1.0
        return full.ravel()[self.elements.free]

    # Motion

    def load(self, t: NDArray) -> tuple[NDArray, NDArray]:
        """What is prescribed at times t: gamma and gamma' (k,) each."""
        return self.speed(t)

    def residual(
        self, load: tuple[NDArray, NDArray], q: NDArray, v: NDArray, a: NDArray
    ) -> NDArray:
        """The left-hand side of the equation less F: (k, n). load: at the times of q, v and a."""
        gamma, rate = load
        return a @ self.M + self.forces(gamma, rate, q, v)

    def tangents(
        self, load: tuple[NDArray, NDArray], q: NDArray, v: NDArray, a: NDArray
    ) -> tuple[NDArray, NDArray, NDArray]:
        """Derivatives of the residual by q, v and a: (k, n, n) each."""
        gamma, rate = load
        M = np.broadcast_to(self.M, (len(q), *self.M.shape))
        return self.stiffness(gamma, rate, q), self.gyroscopic(gamma), M

    def accelerations(self, t: NDArray, q: NDArray, v: NDArray) -> NDArray:
        """a (k, n) from positions and velocities."""
        load = self.load(t)
        rest = self.residual(load, q, v, np.zeros_like(q))
        *_, M = self.tangents(load, q, v, np.zeros_like(q))
        return -np.linalg.solve(M, rest[..., None])[..., 0]

    def after_docking(
        self, q: NDArray, v: NDArray, before: "Equation", velocity: NDArray
    ) -> NDArray:
        """v (n,) after the body of this equation has docked with a velocity (2,) relative to the
        hub's frame: M v is what it was `before`, and the momentum of the body."""
        momentum = before.M @ v + self.model.beam.alpha * velocity @ self.at_mass
        return np.linalg.solve(self.M, momentum)

    # Its parts

    def forces(self, gamma: NDArray, rate: NDArray, q: NDArray, v: NDArray) -> NDArray:
        """All terms but M q"."""
        gamma, rate = gamma[:, None], rate[:, None]
        inertia = q @ self.M + self.delta * self.m[0]  # M (q + delta)
        euler = q @ self.G.T + self.delta * self.m[1]  # G (q + delta)
        coriolis = 2 * gamma * (v @ self.G.T) + v @ self.D.T
        return coriolis + rate * euler - gamma**2 * inertia + self.elastic(q) - self.F

    def stiffness(self, gamma: NDArray, rate: NDArray, q: NDArray) -> NDArray:
        """Derivative of the forces by q: (k, n, n)."""
        gamma, rate = gamma[:, None, None], rate[:, None, None]
        return rate * self.G - gamma**2 * self.M + self.elastic_tangent(q)

    def gyroscopic(self, gamma: NDArray) -> NDArray:
        """Derivative of the forces by v: (k, n, n)."""
        return 2 * gamma[:, None, None] * self.G + self.D

    def strain_state(self, q: NDArray) -> NDArray:
        """(r1', r2', r1'', r2'') at the Gauss points: (k, m, 4)."""
        return (q @ self.flat.T).reshape(len(q), -1, 4)

    def stretch(self, q: NDArray) -> NDArray:
        """f at the Gauss points: (k, m)."""
        s = self.strain_state(q)
        return np.hypot(s[..., 0], s[..., 1])

    def elastic(self, q: NDArray) -> NDArray:
        """dU/dq (k, n)."""
        s = self.strain_state(q)
        f = np.hypot(s[..., 0], s[..., 1])
        kappa, dkappa = bending(s, f, self.model.curvature_power)
        g = kappa[..., None] * dkappa
        g[..., :2] += (self.model.beam.mu**2 * self.model.law.force(f) / f)[..., None] * s[..., :2]
        g *= self.elements.weights[:, None]
        force = g.reshape(len(q), -1) @ self.flat
        return force if self.joint is None else force + self.joint.force(q)

    def elastic_tangent(self, q: NDArray) -> NDArray:
        """d^2 U / dq^2 (k, n, n)."""
        s = self.strain_state(q)
        f = np.hypot(s[..., 0], s[..., 1])
        H = self.model.beam.mu**2 * axial_hessian(s, f, self.model.law)
        H += bending_hessian(s, f, self.model.curvature_power)
        H *= self.elements.weights[:, None, None]
        K = self.flat.T @ (H @ self.B).reshape(len(q), -1, self.size)
        return K if self.joint is None else K + self.joint.tangent(q)

    def strain_energy(self, q: NDArray) -> NDArray:
        """U (k,)."""
        s = self.strain_state(q)
        f = np.hypot(s[..., 0], s[..., 1])
        kappa, _ = bending(s, f, self.model.curvature_power)
        density = (self.model.beam.mu * self.model.law.strain(f)) ** 2 + kappa**2
        energy = density @ self.elements.weights / 2
        return energy if self.joint is None else energy + self.joint.energy(q)

    def moment_of_inertia(self, q: NDArray) -> NDArray:
        """int rho |R|^2 about the axis of rotation (k,)."""
        whole = 1 + self.model.beam.alpha  # int rho
        arm = 2 * (q @ self.m[0]) + self.delta * whole
        return ((q @ self.M) * q).sum(axis=1) + self.delta * arm

    def gamma(self, t: NDArray, v: NDArray) -> NDArray:
        """The speed (k,)."""
        return self.speed(t)[0]

    def energy(self, gamma: NDArray, q: NDArray, v: NDArray) -> NDArray:
        """q' M q' / 2 + U - gamma^2 / 2 int rho |R|^2 - F q (k,), constant at a constant speed
        without damping (the Jacobi integral)."""
        kinetic = ((v @ self.M) * v).sum(axis=1) / 2
        centrifugal = gamma**2 / 2 * self.moment_of_inertia(q)
        return kinetic + self.strain_energy(q) - centrifugal - q @ self.F

    def check(self, t: float, gamma: float, q: NDArray) -> None:
        """Raises NoEquilibrium where the stretch of a position (n,) is out of the range of the
        strain law."""
        law, f = self.model.law, self.stretch(q[None])[0]
        for value, beyond in ((f.min(), law.min_stretch), (f.max(), law.max_stretch)):
            if (value <= beyond) == (beyond < 1):
                raise NoEquilibrium(
                    f"t = {t:.4g}, gamma = {gamma:.4g}: the stretch {value:.4g} leaves the range of"
                    f" {law.name} strain, {law.min_stretch:.4g} .. {law.max_stretch:.4g}, in which"
                    " the axial force grows with the stretch",
                    gamma,
                )


class HubEquation(Equation):
    """The equation of motion of a beam on a hub of inertia J under a torque. The last unknown is
    the angle of the hub, its velocity the speed gamma."""

    def __init__(
        self,
        elements: PositionElements,
        model: Model,
        inertia: float,
        torque: Speed,
        damping: NDArray | None = None,
        force: NDArray | None = None,
    ):
        super().__init__(elements, model, torque, damping, force)
        self.J, self.torque = inertia, torque
        self.unknowns = self.size + 1

    def gamma(self, t: NDArray, v: NDArray) -> NDArray:
        return v[:, -1]

    def load(self, t: NDArray) -> tuple[NDArray, NDArray]:
        """The torque and its rate (k,) each."""
        return self.torque(t)

    def residual(
        self, load: tuple[NDArray, NDArray], q: NDArray, v: NDArray, a: NDArray
    ) -> NDArray:
        q, v, a, gamma, rate = q[:, :-1], v[:, :-1], a[:, :-1], v[:, -1], a[:, -1]
        torque, _ = load
        beam = a @ self.M + self.forces(gamma, rate, q, v)
        R, turned = self.arm(q)
        hub = (self.J + self.moment_of_inertia(q)) * rate + (turned * a).sum(axis=1)
        hub += 2 * gamma * (R * v).sum(axis=1) - torque
        return np.column_stack((beam, hub))

    def tangents(
        self, load: tuple[NDArray, NDArray], q: NDArray, v: NDArray, a: NDArray
    ) -> tuple[NDArray, NDArray, NDArray]:
        q, v, a, gamma, rate = q[:, :-1], v[:, :-1], a[:, :-1], v[:, -1], a[:, -1]
        R, turned = self.arm(q)
        K, C, M = np.zeros((3, len(q), self.unknowns, self.unknowns))
        K[:, :-1, :-1] = self.stiffness(gamma, rate, q)
        K[:, -1, :-1] = 2 * rate[:, None] * R + a @ self.G + 2 * gamma[:, None] * (v @ self.M)
        C[:, :-1, :-1] = self.gyroscopic(gamma)
        C[:, :-1, -1] = 2 * (v @ self.G.T) - 2 * gamma[:, None] * R
        C[:, -1, :-1] = 2 * gamma[:, None] * R
        C[:, -1, -1] = 2 * (R * v).sum(axis=1)
        M[:, :-1, :-1] = self.M
        M[:, :-1, -1] = M[:, -1, :-1] = turned
        M[:, -1, -1] = self.J + self.moment_of_inertia(q)
        return K, C, M

    def after_docking(self, q: NDArray, v: NDArray, before: Equation, velocity: NDArray) -> NDArray:
        """As with a prescribed speed, but the momentum is that of beam and hub, and the velocity
        relative to the frame of the hub before."""
        none = np.zeros((1, self.unknowns))
        q, alpha, load = q[None], self.model.beam.alpha, self.load(np.zeros(1))
        (M_before,), (M,) = (e.tangents(load, q, none, none)[2] for e in (before, self))
        R = self.at_mass @ q[0, :-1] + [self.delta, 0.0]
        carried = np.append(self.at_mass, (TURN @ R)[:, None], axis=1)  # (2, n): v -> velocity
        body = velocity + v[-1] * (TURN @ R)
        return np.linalg.solve(M, M_before @ v + alpha * body @ carried)

    def arm(self, q: NDArray) -> tuple[NDArray, NDArray]:
        """int rho N' R and int rho N' (e3 x R): (k, n) each."""
        return q @ self.M + self.delta * self.m[0], q @ self.G.T + self.delta * self.m[1]

    def angular_momentum(self, q: NDArray, v: NDArray) -> NDArray:
        """About the axis, with the hub: (k,)."""
        _, turned = self.arm(q[:, :-1])
        inertia = self.J + self.moment_of_inertia(q[:, :-1])
        return inertia * v[:, -1] + (turned * v[:, :-1]).sum(axis=1)
