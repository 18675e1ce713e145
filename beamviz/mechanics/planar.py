"""A beam that bends and stretches in one plane: its equation of motion and the tangents of this.

The unknowns are the stretch f = |r'| of the axis, which may jump at a body, and the slope
kappa = theta' of its angle. In complex numbers r = r1 + i r2,

    r' = f e^(i theta),    theta = theta_0 + int kappa,    r = int r',

so the clamp is exact and nothing else has to be continuous. Virtual work gives the equation of
motion (paper, eqs. 26-38): for all changes of the unknowns

    int W_f df + W_kappa dkappa + int p . dr - F . dr = 0,

with the energy W of the section (`section`), the force of inertia p (`inertia`) and a force F at
one point; bodies that turn and a spring at the root add their moments. Its derivatives by the
unknowns, by their velocities and by their accelerations are K, C and M. An equilibrium is a motion
in which nothing moves, and its modes are the solutions of M q" + C q' + K q = 0 (eqs. 40-48).

The unknowns q are the coefficients of trial functions in natural units: of f - 1, then of kappa,
then theta_0 where the root is not clamped. The stiffness is nearly constant in them, however far
the beam bends. Arrays of a state may have the instants of time in leading axes.
"""

from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from beamviz.beam import Beam
from beamviz.mechanics.inertia import Loading, Number, masses_of
from beamviz.mechanics.section import Section
from beamviz.solver.constitutive import Theory
from beamviz.space.trial import Trial

COLUMNS = 512  # of a product of matrices at a time
LEAST_STRAIN = -0.9  # f - 1 of a state fitted to another
MAX_TURN, MAX_STRETCH = 0.7, 0.3  # of a step: angle [rad], relative change of f


class Tangents(NamedTuple):
    """Derivatives (n, n) of the equation of motion by the unknowns, velocities, accelerations."""

    K: NDArray
    C: NDArray
    M: NDArray


class Derivatives(NamedTuple):
    """Derivatives (m, n) by the unknowns of the positions of the masses, and by q and by v of the
    force of inertia of a unit of mass there, complex."""

    position: NDArray
    by_q: NDArray
    by_v: NDArray


class PlanarBeam:
    """A beam on trial functions: all that does not depend on its state.

    It has mass at m points: the n Gauss points and the bodies that move. `force_at`: the point that
    a force acts on.
    """

    def __init__(self, trial: Trial, beam: Beam, theory: Theory, force_at: float = 1.0):
        self.trial, self.beam, self.theory, self.force_at = trial, beam, theory, force_at
        self.grid, self.w, self.points = trial.grid, trial.grid.weights, trial.grid.points
        power = 4 - 2 * theory.curvature_power
        self.section = Section(theory.law, power, beam.mu**2 * trial.EA, trial.EI)
        self.masses = masses_of(beam, self.grid.points, self.w * trial.mass, theory.in_plane)
        self.mass, self.rotary = self.masses.mass, self.masses.rotary  # (m,), (masses,)
        self.loading = Loading(beam.gamma, beam.spin_up, theory.in_plane)
        bodies = np.array([beam.beta, *(body.beta for body in beam.masses)])
        to_bodies = np.where(self.grid.points < bodies[:, None], self.w, 0.0)
        self.to_moving = to_bodies[self.masses.moving]  # (m - n, n) integrates from the clamp
        self.to_turning = to_bodies[1:]  # (masses, n), to the bodies with moments of inertia
        self.hinged = bool(beam.root < np.inf)
        self.root_scale = 1 / np.sqrt(1 + beam.root) if self.hinged else 0.0
        self.along = trial.stretch.shape[1]  # number of unknowns of the stretch
        self.size = self.along + trial.bending.shape[1] + self.hinged
        # By the unknowns, at the Gauss points: f - 1 (n, along), kappa and theta (n, size - along),
        # of which the last is theta_0 where the root is not clamped.
        self.Z = trial.stretch / beam.mu
        self.B = self._with_root(trial.bending, 0.0)
        self.S = self._with_root(trial.angle, self.root_scale)

    @cached_property
    def turning(self) -> NDArray:
        """theta at the bodies with moments of inertia by its unknowns (masses, size - along)."""
        return self._with_root(self.to_turning @ self.trial.bending, self.root_scale)

    @property
    def rotations(self) -> NDArray:
        """Roots of the moments of inertia times the angles of bodies by the unknowns (masses,
        size)."""
        rotations = np.zeros((len(self.masses.rotary), self.size))
        rotations[:, self.along :] = np.sqrt(self.masses.rotary)[:, None] * self.turning
        return rotations

    @property
    def rotary_inertia(self) -> NDArray:
        """Moments of inertia times the angles of bodies by the unknowns (masses, size)."""
        return np.sqrt(self.masses.rotary)[:, None] * self.rotations

    @cached_property
    def to_force(self) -> NDArray:
        """Integrates from the clamp to the point that the force acts on (n,)."""
        return self.grid.from_clamp(np.array([self.force_at]))[0]

    @property
    def lengths(self) -> NDArray:
        """The size [L] (size,) of the displacement by a unit of each unknown."""
        return np.where(np.arange(self.size) < self.along, 1 / self.beam.mu, 1.0)

    @property
    def orders(self) -> tuple[int, ...]:
        """Orders of the elements."""
        return self.trial.elements.orders

    def _with_root(self, functions: NDArray, at_root: float) -> NDArray:
        """Functions of theta_0 too, where the root is not clamped."""
        if not self.hinged:
            return functions
        return np.column_stack((functions, np.full(len(functions), at_root)))

    def to_masses(self, values: NDArray) -> NDArray:
        """Integrals (..., m) from the clamp to each mass of values (..., n)."""
        inside = times(values, self.trial.J.T)
        if not len(self.to_moving):
            return inside
        return np.concatenate((inside, times(values, self.to_moving.T)), axis=-1)

    def outboard(self, p: NDArray) -> NDArray:
        """Sums (..., n) of forces p (..., m) on all that lies further out, times weights."""
        n = len(self.w)
        total = times(p[..., :n], self.trial.J)
        return total + times(p[..., n:], self.to_moving) if len(self.to_moving) else total

    def moved(self, by_angle: NDArray, by_stretch: NDArray) -> NDArray:
        """The derivative (2, m, size) of the positions r1 and r2 of the masses by the unknowns, by
        those of r' by the angle and by the stretch (n,), complex."""
        n, r = len(self.w), self.along
        derivative = np.zeros((2, len(self.mass), self.size))
        gradient = derivative[:, :n]  # which the integrals replace: large blades have large ones
        for component, turned, stretched in zip(
            gradient,
            (by_angle.real, by_angle.imag),
            (by_stretch.real, by_stretch.imag),
            strict=True,
        ):
            for block in self.trial.blocks:
                here = stretched[block.points, None] / self.beam.mu
                component[block.points, block.along] = here * block.stretch
            np.multiply(turned[:, None], self.S, out=component[:, r:])
        derivative[:, n:] = self.to_moving @ gradient
        self.grid.integrals(gradient, out=gradient)
        return derivative

    def local(self, ff: NDArray, fk: NDArray, kk: NDArray, root: float = 0.0) -> NDArray:
        """Matrix (size, size) of a quadratic form whose density is given by its coefficients (n,)
        of f^2, of f kappa and of kappa^2, with that of theta_0^2."""
        K, r, mu = np.zeros((self.size, self.size)), self.along, self.beam.mu
        for points, along, across, Z, B in self.trial.blocks:
            turning = slice(r + across.start, r + across.stop)
            K[along, along] = (Z.T * (ff[points] / mu**2)) @ Z
            K[turning, turning] = (B.T * kk[points]) @ B
            K[along, turning] = coupling = (Z.T * (fk[points] / mu)) @ B
            K[turning, along] = coupling.T
        if self.hinged:
            K[-1, -1] = self.root_scale**2 * root
        return K

    def fitted(self, f: NDArray, kappa: NDArray, root_angle: float = 0.0) -> NDArray:
        """q (size,) of a stretch and of kappa (n,) at the Gauss points: their projection, as the
        trial functions are orthonormal in the energy at rest. In an element with a soft section
        the projection of a large strain may overshoot to f <= 0: then it is a share of it.
        """
        of_stretch = self.section.axial * self.w * (f - 1) @ self.Z
        for block in self.trial.blocks:
            least = (block.stretch @ of_stretch[block.along]).min() / self.beam.mu
            of_stretch[block.along] *= LEAST_STRAIN / min(least, LEAST_STRAIN)
        of_kappa = (self.w * self.trial.EI * kappa) @ self.trial.bending
        of_root = [root_angle / self.root_scale] if self.hinged else []
        return np.concatenate((of_stretch, of_kappa, of_root))

    def nearest(self, f: NDArray, theta: NDArray) -> NDArray:
        """q (size,) of a stretch and an angle (n,) at the Gauss points."""
        return self.nearest_rates(f, theta, f - 1, theta)

    def nearest_rates(
        self, f: NDArray, theta: NDArray, f_rate: NDArray, theta_rate: NDArray
    ) -> NDArray:
        """v (size,) of the rates of a stretch and an angle (n,): of the stretch in the energy at
        rest, of the angle in least squares."""
        root = np.sqrt(self.w)
        stretch = self.section.axial * self.w * f_rate @ self.Z
        S = self.S
        if self.hinged:  # as many angles as Gauss points: theta_0 takes the place of a function
            S = np.delete(S, -2, axis=1)
        turning = np.linalg.lstsq(root[:, None] * S, root * theta_rate)[0]
        if self.hinged:
            turning = np.insert(turning, -1, 0.0)
        return np.concatenate((stretch, turning))

    def state(self, q: NDArray, loading: Loading | None = None) -> "PlanarState":
        """The beam at rest in the rotating frame, under its own loading where none is given."""
        return PlanarState(self, q, loading or self.loading)

    def moving(self, q: NDArray, v: NDArray, a: NDArray, loading: Loading) -> "MovingState":
        """The beam in motion; q, v and a are (k, size)."""
        return MovingState(self, q, v, a, loading)


class PlanarState:
    """A state of a beam at rest in the rotating frame, in equilibrium or not."""

    def __init__(self, beam: PlanarBeam, q: NDArray, loading: Loading):
        self.beam, self.q, self.loading = beam, q, loading
        turning = q[..., beam.along :]
        self.f = 1 + q[..., : beam.along] @ beam.Z.T  # (..., n)
        self.kappa = turning @ beam.B.T
        self.theta = turning @ beam.S.T
        self.e = np.exp(1j * self.theta)
        self.slope = self.f * self.e  # r'
        self.R = beam.to_masses(self.slope) + beam.beam.delta  # (..., m), of the masses

    @property
    def root_angle(self) -> Any:
        """theta_0 [rad] (...)."""
        return self.beam.root_scale * self.q[..., -1] if self.beam.hinged else 0.0

    @property
    def body_angles(self) -> NDArray:
        """Angles [rad] (..., masses) of the bodies with moments of inertia."""
        return self.q[..., self.beam.along :] @ self.beam.turning.T

    def positions(self, x: NDArray) -> NDArray:
        """r (..., len(x)) from the clamp at points of the beam."""
        return times(self.slope, self.beam.grid.from_clamp(x).T)

    def stretch(self, x: NDArray) -> NDArray:
        """f (..., len(x)) at points of the beam; at a jump that inboard."""
        return self.f @ self.beam.grid.at(x).T

    def curvature(self, x: NDArray) -> NDArray:
        """theta' (..., len(x)) [1/L] at points of the beam; at a jump that inboard."""
        return self.kappa @ self.beam.grid.at(x).T

    def displacement_at(self, x: float) -> NDArray:
        """The derivative (size,) of the position of a point by the unknowns, of one state."""
        row, beam = self.beam.grid.from_clamp(np.array([x]))[0], self.beam
        return np.concatenate(((row * self.e) @ beam.Z, (row * 1j * self.slope) @ beam.S))

    def step_size(self, step: NDArray) -> float:
        """The size of a step of q in units of the largest that should be taken at once."""
        r = self.beam.along
        stretch = abs(self.beam.Z @ step[:r] / self.f).max()
        return float(max(abs(self.beam.S @ step[r:]).max() / MAX_TURN, stretch / MAX_STRETCH))

    # Energy

    @property
    def stored(self) -> Any:
        """Strain energy (...), with that of the root spring."""
        energy = self.beam.section.energy(self.f, self.kappa) @ self.beam.w
        return energy + self.beam.beam.root * self.root_angle**2 / 2 if self.beam.hinged else energy

    @property
    def centrifugal(self) -> Any:
        """gamma^2 / 2 int rho |P R|^2 (...), less that of bodies that turn out of the plane."""
        beam, loading = self.beam, self.loading
        axial = abs(self.R if loading.in_plane else self.R.real) ** 2 @ beam.mass
        turned = np.sin(self.body_angles) ** 2 @ beam.masses.restoring
        return np.squeeze(loading.gamma) ** 2 / 2 * (axial - turned)

    # The equation of motion

    @cached_property
    def p(self) -> NDArray:
        """The force of inertia (..., m) on each mass."""
        return self.beam.mass * self.loading.inertia(self.R)

    @property
    def body_moments(self) -> NDArray:
        """The moments of inertia (..., masses) on the bodies."""
        return self.beam.masses.moments(self.loading, self.body_angles, 0.0)

    @cached_property
    def section_loads(self) -> NDArray:
        """The force of inertia and F on all that lies further out than each Gauss point, times its
        weight, in the axes of the section (..., n): along the beam, across it."""
        total = self.beam.outboard(self.p)
        if self.loading.force:
            total = total - self.loading.force * self.beam.to_force
        return total * self.e.conj()

    @cached_property
    def residual(self) -> NDArray:
        """The left-hand side of the equation of motion (..., size) (paper, eq. 40 of a state at
        rest)."""
        beam, Q = self.beam, self.section_loads
        force, moment = beam.section.forces(self.f, self.kappa)
        of_stretch = (beam.w * force + Q.real) @ beam.Z
        of_angle = (beam.w * moment) @ beam.B + (self.f * Q.imag) @ beam.S
        if len(beam.masses.rotary):
            of_angle += self.body_moments @ beam.turning
        if beam.hinged:
            of_angle[..., -1] += beam.root_scale * beam.beam.root * self.root_angle
        return np.concatenate((of_stretch, of_angle), axis=-1)

    # Its derivatives, of one state

    @cached_property
    def elastic_stiffness(self) -> NDArray:
        """Second derivative (size, size) of the strain energy."""
        ff, fk, kk = self.beam.section.stiffness(self.f, self.kappa)
        w = self.beam.w
        return self.beam.local(w * ff, w * fk, w * kk, self.beam.beam.root)

    @cached_property
    def geometric_stiffness(self) -> NDArray:
        """The derivative (size, size) of the work of the loads as they turn with the beam."""
        beam, Q, r = self.beam, self.section_loads, self.beam.along
        K = np.zeros((beam.size, beam.size))
        K[r:, r:] = -(beam.S.T * (self.f * Q.real)) @ beam.S
        for block in beam.trial.blocks:
            turned = (block.stretch.T * (Q.imag[block.points] / beam.beam.mu)) @ beam.S[
                block.points
            ]
            K[block.along, r:] = turned
            K[r:, block.along] = turned.T
        if beam.masses.restoring.any():
            restoring = beam.masses.restoring_stiffness(self.loading, self.body_angles)
            K[r:, r:] += (beam.turning.T * restoring) @ beam.turning
        return K

    @property
    def displacements(self) -> NDArray:
        """The derivative (2, m, size) of the positions of the masses by the unknowns. It is larger
        than the matrices, and computed in half the time of one: it is not kept."""
        return self.beam.moved(1j * self.slope, self.e)

    @cached_property
    def stiffness(self) -> NDArray:
        """K (size, size), symmetric without a spin-up (paper, eqs. 42-44)."""
        gamma, rate, in_plane, _ = self.loading
        K = self.elastic_stiffness + self.geometric_stiffness
        moved = np.sqrt(self.beam.mass)[:, None] * self.displacements
        softening = moved if in_plane else moved[0]
        subtract_square(K, softening.reshape(-1, self.beam.size), gamma**2)
        return K + rate * swirl(*moved) if rate else K

    @cached_property
    def coriolis(self) -> NDArray:
        """C (size, size) of the Coriolis forces, skew."""
        X, Y = np.sqrt(self.beam.mass)[:, None] * self.displacements
        return 2 * self.loading.gamma * swirl(X, Y)

    @cached_property
    def inertia(self) -> NDArray:
        """M (size, size), with the rotary inertia of bodies."""
        F = self.factor_of_inertia
        return F.T @ F

    @property
    def factor_of_inertia(self) -> NDArray:
        """F (2 m + masses, size) with M = F' F."""
        X, Y = np.sqrt(self.beam.mass)[:, None] * self.displacements
        return np.vstack((X, Y, self.beam.rotations))


class MovingState(PlanarState):
    """A state of a beam in motion, with velocities v and accelerations a of its unknowns, at k
    instants: q, v and a are (k, size)."""

    def __init__(self, beam: PlanarBeam, q: NDArray, v: NDArray, a: NDArray, loading: Loading):
        super().__init__(beam, q, loading)
        self.v, self.a = v, a
        r = beam.along
        self.growth, growth_rate = (part[..., :r] @ beam.Z.T for part in (v, a))  # f', f"
        self.turn, turn_rate = (part[..., r:] @ beam.S.T for part in (v, a))  # theta', theta"
        self.turn_rate = turn_rate
        f, f1, theta1 = self.f, self.growth, self.turn
        self.slope_rate = (f1 + 1j * f * theta1) * self.e
        bent = f * turn_rate + 2 * f1 * theta1
        self.slope_rate2 = (growth_rate - f * theta1**2 + 1j * bent) * self.e

    @cached_property
    def velocities(self) -> NDArray:
        """r' (k, m) of the masses."""
        return self.beam.to_masses(self.slope_rate)

    @cached_property
    def p(self) -> NDArray:
        accelerations = self.beam.to_masses(self.slope_rate2)
        return self.beam.mass * self.loading.inertia(self.R, self.velocities, accelerations)

    def velocities_at(self, x: NDArray) -> NDArray:
        """r' (k, len(x)), the rate of the position, at points of the beam."""
        return times(self.slope_rate, self.beam.grid.from_clamp(x).T)

    @property
    def body_moments(self) -> NDArray:
        turning = self.a[..., self.beam.along :] @ self.beam.turning.T
        return self.beam.masses.moments(self.loading, self.body_angles, turning)

    @property
    def kinetic(self) -> Any:
        """int rho |r'|^2 / 2 (k,), with the rotation of bodies."""
        beam = self.beam
        turned = (self.v[..., beam.along :] @ beam.turning.T) ** 2 @ beam.masses.rotary
        return (abs(self.velocities) ** 2 @ beam.mass + turned) / 2

    def inertia_by_unknowns(self) -> NDArray:
        """The derivative (2, m, size) of the force of inertia of a unit of mass by q."""
        e, turn = self.e, self.turn
        return self.beam.moved(
            self.loading.inertia(1j * self.slope, 1j * self.slope_rate, 1j * self.slope_rate2),
            self.loading.inertia(e, 1j * turn * e, (1j * self.turn_rate - turn**2) * e),
        )

    def inertia_by_velocities(self) -> NDArray:
        """The derivative (2, m, size) of the force of inertia of a unit of mass by v."""
        none = np.zeros_like(self.e)
        return self.beam.moved(
            self.loading.inertia(none, 1j * self.slope, 2j * self.slope_rate),
            self.loading.inertia(none, self.e, 2j * self.turn * self.e),
        )

    def tangents(self) -> tuple[Tangents, Derivatives]:
        """K, C and M of a single state, and what they are made of."""
        moved = self.displacements
        by_q, by_v = self.inertia_by_unknowns(), self.inertia_by_velocities()
        size = self.beam.size
        virtual = (self.beam.mass[:, None] * moved).reshape(-1, size).T
        K, C, M = (virtual @ part.reshape(-1, size) for part in (by_q, by_v, moved))
        K += self.elastic_stiffness + self.geometric_stiffness
        rotations = self.beam.rotations
        derivatives = Derivatives(*(part[0] + 1j * part[1] for part in (moved, by_q, by_v)))
        return Tangents(K, C, M + rotations.T @ rotations), derivatives


def times(values: NDArray, A: NDArray) -> NDArray:
    """values A (..., k) of values (..., n), real or complex, and a real matrix A (n, k): numpy
    would make the matrix complex, a copy of twice its size."""
    if values.dtype != complex:
        return values @ A
    real, imaginary = np.stack((values.real, values.imag)) @ A
    return real + 1j * imaginary


def swirl(X: NDArray, Y: NDArray) -> NDArray:
    """Integral (size, size) of virtual displacements times e3 x displacements: skew."""
    S = Y.T @ X
    return S - S.T


def subtract_square(K: NDArray, F: NDArray, factor: Number) -> None:
    """Subtract factor F' F from K (n, n), some columns at a time: large blades have large
    matrices."""
    for start in range(0, len(K), COLUMNS):
        stop = start + COLUMNS
        part = factor * (F[:, start:].T @ F[:, start:stop])
        K[start:, start:stop] -= part
        K[start:stop, stop:] -= part[COLUMNS:].T
