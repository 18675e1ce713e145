"""A bent beam on an hp mesh: energy, residual, tangent stiffness and inertia.

The state is the stretch f = |r'| at the Gauss points, which may have a jump at the concentrated
mass, and the slope kappa = theta' of the angle. Then theta = int kappa, r' = f (cos theta,
sin theta) and r = int r' from the clamp, so that the clamp is exact and nothing else has to be
continuous: the straight formulation of `beamviz.solver.straight` with an angle that is not small.

Energy (paper, eqs. 14-19): int mu^2 e(f)^2 / 2 + b(f) kappa^2 / 2 dx with b = f^(4 - 2c), c the
power of the curvature measure; centrifugal potential -gamma^2 / 2 int rho |P R|^2 dx with
R = r + delta e1 and P the projection away from the axis of rotation. The Euler force of a spin-up,
-lambda rho e3 x R (paper, eq. 45), has no potential; its tangent is skew. At an equilibrium the
second derivative does not depend on the coordinates: in (f, kappa) it is the tangent of eq. 44.
"""

from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

from beamviz.beam import Beam
from beamviz.mechanics.straight import with_root
from beamviz.solver.problem import Problem
from beamviz.space.elements import Elements
from beamviz.space.grid import Grid
from beamviz.space.refinement import TRUNCATION_FACTOR
from beamviz.space.trial import Trial, cached_trial, make_trial

SECTION_STEPS = 60  # of Newton's method for the stretch at the weakest sections
SECTION_ACCURACY = 1e-9  # of that stretch, relative
LEAST_RIGIDITY = 0.1  # of the axial stiffness, relative to that at rest: a law may have none left
MAX_TURN, MAX_STRETCH = 0.7, 0.3  # of a step: angle [rad], relative change of f
COLUMNS = 512  # of a product of matrices at a time
STRAIGHT = 1e-6  # largest angle [rad] of a state that counts as straight
SAME_ENERGY = 1e-9  # relative difference of two descents to the same state


def corotational_components(dx: NDArray, dy: NDArray, angle: NDArray) -> NDArray:
    """Corotational components (k, 2, modes), along and across the deflected beam, of displacements
    dx and dy (k, modes) at points where it has an angle (k,)."""
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    return np.stack((c * dx + s * dy, c * dy - s * dx), axis=1)


def product(A: Any, V: NDArray) -> NDArray:
    """A V of a real matrix A (k, n) and vectors V (..., n, modes), which may be complex: numpy
    would make the matrix complex, a copy of twice its size."""
    if V.dtype != complex:
        return A @ V
    V = np.ascontiguousarray(V)
    return (A @ V.view(float)).view(V.dtype)


def subtract_square(K: NDArray, F: NDArray, factor: float) -> None:
    """Subtract factor F' F from K (n, n), some columns at a time: large blades have large
    matrices."""
    for start in range(0, len(K), COLUMNS):
        stop = start + COLUMNS
        part = factor * (F[:, start:].T @ F[:, start:stop])
        K[start:, start:stop] -= part
        K[start:stop, stop:] -= part[COLUMNS:].T


class Sections(NamedTuple):
    """Sections of a beam at which it may be weakest: the clamp, of a blade both sides of each
    break."""

    from_clamp: NDArray  # (k, n) integrates from the clamp to each section
    nearest: NDArray  # (k,) number of the nearest mesh point
    outboard: NDArray  # (k, m) 1 for the masses outboard of it, 0 for the others
    bodies: NDArray  # (k, masses) 1 for the bodies outboard of it
    EI: NDArray  # (k,)
    EA: NDArray  # (k,)


def weakest_sections(grid: Grid, beam: Beam, masses: NDArray, problem: Problem) -> Sections:
    """The sections of a beam that has mass at the points `masses` (m,)."""
    bodies = np.array([mass.beta for mass in beam.masses])
    if beam.blade is None:
        clamp, one = np.zeros((1, len(grid.points))), np.ones(1)
        ones = np.ones((1, len(masses))), np.ones((1, len(bodies)))
        return Sections(clamp, np.zeros(1, int), *ones, one, one)
    starts, stops = grid.breaks[:-1], grid.breaks[1:]
    first = np.cumsum([0, *grid.orders[:-1]])

    def outboard(x: NDArray) -> NDArray:
        return np.vstack((x > starts[:, None], x >= stops[:, None])).astype(float)

    def both(name: str) -> NDArray:
        assert beam.blade
        return np.append(beam.blade.at(name, starts), beam.blade.at(name, stops, inboard=True))

    return Sections(
        from_clamp=grid.from_clamp(np.append(starts, stops)),
        nearest=np.append(first, first + np.array(grid.orders) - 1),
        outboard=outboard(masses),
        bodies=outboard(bodies),
        EI=both(problem.bending_property),
        EA=both("axial"),
    )


def _about_trial(elements: Elements, beam: Beam, problem: Problem) -> tuple[Any, ...]:
    """What the trial functions of a beam on elements depend on."""
    share = problem.tolerance / TRUNCATION_FACTOR
    return elements, beam.blade, problem.bending_property, share


class BentBeam:
    """A beam on elements whose ends hold the bodies.

    It has mass at the n Gauss points and at the bodies: m in all. Its state changes by multiples of
    r trial functions of the stretch, of as many of kappa and, where the root is not clamped, of the
    angle there: these are the `size` unknowns, in natural units.
    """

    def __init__(
        self, elements: Elements, beam: Beam, problem: Problem, trial: Trial | None = None
    ):
        self.elements, self.beam, self.problem = elements, beam, problem
        self.trial = trial = trial or cached_trial(*_about_trial(elements, beam, problem))
        grid = self.grid = trial.grid
        self.w, self.EI, self.EA = grid.weights, trial.EI, trial.EA  # (n,)
        self.J = trial.J  # (n, n) integrates from the clamp to each Gauss point
        bodies = [(beam.alpha, beam.beta), *((mass.alpha, mass.beta) for mass in beam.masses)]
        alpha, beta = np.array(bodies).T
        to_bodies = np.where(grid.points < beta[:, None], self.w, 0.0)
        carried = (alpha > 0) & (beta > 0)
        self.to_carried = to_bodies[carried]  # (m - n, n)
        self.mass = np.append(self.w * trial.mass, alpha[carried])  # (m,)
        self.mass_points = np.append(grid.points, beta[carried])  # (m,)
        self.hinged = bool(beam.root < np.inf)
        # Of the bodies `masses`: kappa -> their angles (masses, turning); moments of inertia about
        # the axis of bending (masses,); and those by which centrifugal forces turn them back into
        # the plane of rotation (masses,), with the moment restoring gamma^2 sin(2 theta) / 2.
        turned = to_bodies[1:]
        self.to_body_angles = with_root(turned) if self.hinged else turned
        Jx, Jy, Jz = np.array([mass.inertia for mass in beam.masses]).reshape(-1, 3).T
        self.rotary = Jz if problem.chordwise else Jy
        self.restoring = 0 * Jz if problem.chordwise else Jz - Jx
        self.law = problem.strain_law
        self.power = 4 - 2 * problem.curvature_power
        self.softens = float(problem.chordwise)  # P keeps the component across the beam
        # Trial functions of f and of kappa by element, r in all of each, and the angles of the
        # latter (n, r or r + 1).
        self.r = trial.angle.shape[1]
        self.blocks = [block._replace(stretch=block.stretch / beam.mu) for block in trial.blocks]
        self.root_scale = 1 / np.sqrt(1 + beam.root) if self.hinged else 0.0
        self.angle = trial.angle
        if self.hinged:
            self.angle = np.column_stack((self.angle, np.full(len(self.w), self.root_scale)))
        self.size = self.r + self.angle.shape[1]

    def to_masses(self, values: NDArray) -> NDArray:
        """Integrals (..., m, k) from the clamp to each mass of values (..., n, k)."""
        integrals = product(self.J, values)
        if not len(self.to_carried):
            return integrals
        return np.concatenate((integrals, product(self.to_carried, values)), axis=-2)

    def to_angle(self, turning: NDArray) -> NDArray:
        """Angles (n, ...) of kappa and, where the root is not clamped, of the angle there (turning,
        ...)."""
        n = len(self.w)
        angle = product(self.J, turning[:n])
        return angle + turning[n:] if self.hinged else angle

    @cached_property
    def body_angles(self) -> NDArray:
        """Angles (masses, r or r + 1) of the bodies `masses` by the trial functions of kappa."""
        n = len(self.w)
        angles = [self.to_body_angles[:, block.points] @ block.bending for block in self.blocks]
        return np.hstack((*angles, self.root_scale * self.to_body_angles[:, n:]))

    @property
    def highest(self) -> list[NDArray]:
        """Numbers of the unknowns of the highest functions of each element, of both kinds."""
        return [np.append(along, self.r + across) for along, across in self.trial.highest]

    def values(self, c: NDArray) -> NDArray:
        """Changes of q (n + turning, ...) of unknowns c (size, ...)."""
        of_f, of_kappa = c[: self.r], c[self.r : 2 * self.r]
        parts = [block.stretch @ of_f[block.along] for block in self.blocks]
        parts += [block.bending @ of_kappa[block.across] for block in self.blocks]
        return np.concatenate((*parts, self.root_scale * c[2 * self.r :]))

    def on_unknowns(self, residual: NDArray) -> NDArray:
        """Derivatives by the unknowns (size,) of those by q (n + turning,)."""
        n = len(self.w)
        by_f, by_kappa = residual[:n], residual[n : 2 * n]
        parts = [by_f[block.points] @ block.stretch for block in self.blocks]
        parts += [by_kappa[block.points] @ block.bending for block in self.blocks]
        return np.concatenate((*parts, self.root_scale * residual[2 * n :]))

    def local(self, ff: NDArray, fk: NDArray, kk: NDArray, root: float = 0.0) -> NDArray:
        """Matrix (size, size) in the unknowns of a quadratic form whose density is given by its
        coefficients (n,) of f^2, of f kappa and of kappa^2, with that of the angle at the root."""
        K = np.zeros((self.size, self.size))
        for rows, own, _, Bf, Bk in self.blocks:
            turning = slice(self.r + own.start, self.r + own.stop)
            K[own, own] = (Bf.T * ff[rows]) @ Bf
            K[turning, turning] = (Bk.T * kk[rows]) @ Bk
            K[own, turning] = coupling = (Bf.T * fk[rows]) @ Bk
            K[turning, own] = coupling.T
        if self.hinged:
            K[-1, -1] = self.root_scale**2 * root
        return K

    @cached_property
    def sections(self) -> Sections:
        """The sections where the beam may be weakest."""
        return weakest_sections(self.grid, self.beam, self.mass_points, self.problem)

    def unknowns(self, f: NDArray, kappa: NDArray, root_angle: float = 0.0) -> NDArray:
        """q of a stretch and a kappa (n,), with an angle at the root where that is not clamped."""
        return np.concatenate((f, kappa, [root_angle] * self.hinged))

    def changed(self, **numbers: Any) -> "BentBeam":
        """With other numbers of the beam."""
        return BentBeam(self.elements, self.beam.replace(**numbers), self.problem, self.trial)

    def on(self, elements: Elements) -> "BentBeam":
        """On other elements. Most are used once: their matrices, which may be large, are not
        cached."""
        trial = make_trial(*_about_trial(elements, self.beam, self.problem))
        return BentBeam(elements, self.beam, self.problem, trial)


class BentState:
    """A state of a bent beam, in equilibrium or not.

    q (n + turning,): the stretch f at the n Gauss points, after it kappa, and the angle at the root
    where that is not clamped. iterations: number of them that led to the state. theta (n,): angle
    [rad]. direction (2, n): cos theta and sin theta.
    """

    def __init__(self, beam: BentBeam, q: NDArray, iterations: int = 0):
        self.beam, self.q, self.iterations = beam, q, iterations
        n = len(beam.w)
        self.f, self.kappa, self.turning = q[:n], q[n : 2 * n], q[n:]
        self.theta = beam.to_angle(self.turning)
        self.direction = np.stack((np.cos(self.theta), np.sin(self.theta)))

    @cached_property
    def arms(self) -> NDArray:
        """x and y (2, m) of each mass, measured from the axis of rotation."""
        x, y = self.beam.to_masses((self.f * self.direction).T).T
        return np.stack((x + self.beam.beam.delta, y))

    def resampled(self, beam: BentBeam) -> NDArray:
        """q by interpolation at the Gauss points of the beam on other elements."""
        rows = self.beam.grid.at(beam.grid.points)
        return np.concatenate((rows @ self.f, rows @ self.kappa, self.turning[len(self.kappa) :]))

    @property
    def root_angle(self) -> float:
        """The angle [rad] at the root."""
        return float(self.turning[-1]) if self.beam.hinged else 0.0

    @property
    def mirrored(self) -> "BentState":
        """Its mirror image, bent to the other side."""
        return BentState(self.beam, np.concatenate((self.f, -self.turning)), self.iterations)

    @property
    def upward(self) -> "BentState":
        """The state or its mirror image: that whose tip has y >= 0."""
        return self.mirrored if self.beam.w @ (self.f * self.direction[1]) < 0 else self

    def is_same(self, other: "BentState") -> bool:
        """Whether two states are one, or mirror images."""
        return abs(self.energy - other.energy) <= SAME_ENERGY * (1 + abs(other.energy))

    @property
    def largest_angle(self) -> float:
        """The largest angle [rad] of the beam from where it is clamped."""
        return float(abs(self.theta).max())

    @property
    def is_straight(self) -> bool:
        """Whether no point of the beam has turned."""
        return self.largest_angle <= STRAIGHT

    def step_size(self, step: NDArray) -> float:
        """The size of a step of q in units of the largest that descent takes."""
        df, dkappa = step[: len(self.f)], step[len(self.f) :]
        turn, stretch = abs(self.beam.to_angle(dkappa)).max(), abs(df / self.f).max()
        return float(max(turn / MAX_TURN, stretch / MAX_STRETCH))

    @cached_property
    def energies(self) -> tuple[float, float]:
        """Stored and centrifugal energy, without the Euler force: their sum scales the rounding
        error of their difference. Infinite where f <= 0."""
        if not self.f.min() > 0:
            return np.inf, 0.0
        bent, (x, y) = self.beam, self.arms
        stored = bent.beam.mu**2 * bent.EA * bent.law.strain(self.f) ** 2
        stored = bent.w @ (stored + bent.EI * self.f**bent.power * self.kappa**2)
        if bent.hinged:
            stored += bent.beam.root * self.root_angle**2
        arms = bent.mass @ (x * x + bent.softens * y * y)
        arms -= bent.restoring @ np.sin(self.body_angles) ** 2
        return float(stored) / 2, float(bent.beam.gamma**2 * arms) / 2

    @property
    def body_angles(self) -> NDArray:
        """Angles [rad] of the bodies `masses` of the beam."""
        return self.beam.to_body_angles @ self.turning

    @property
    def energy(self) -> float:
        """Potential energy, without the Euler force; infinite where f <= 0."""
        stored, centrifugal = self.energies
        return stored - centrifugal

    @property
    def rigidities(self) -> NDArray:
        """Material stiffness of each unknown, without softening by compression."""
        bent = self.beam
        axial = bent.beam.mu**2 * bent.EA * np.maximum(bent.law.stiffness(self.f), LEAST_RIGIDITY)
        bending = bent.w * bent.EI * self.f**bent.power
        return np.concatenate((bent.w * axial, bending, [1 + bent.beam.root] * bent.hinged))

    @cached_property
    def local_stiffness(self) -> NDArray:
        """Stiffness (n + sections,) in f of deformations much shorter than the beam, over that of
        the section at rest: at the mesh points and at the weakest sections.

        Such a deformation changes f at a constant moment, so that kappa follows: with the energy
        density W(f, kappa) the stiffness is W_ff - W_fk^2 / W_kk. At a section the force P and the
        moment m are known instead, and f is the root of

            mu^2 EA n(f) + p / 2 f^(-p - 1) m^2 / EI = P,

        whose derivative by f is the stiffness.
        """
        bent, p, law, at = self.beam, self.beam.power, self.beam.law, self.beam.sections
        pull, moment = self.section_forces
        mu2 = bent.beam.mu**2
        n, bending = pull / (mu2 * at.EA), p / 2 * moment**2 / (mu2 * at.EA * at.EI)
        f = self.f[at.nearest]
        for _ in range(SECTION_STEPS):
            stiffness = law.stiffness(f) - (p + 1) * f ** (-p - 2) * bending
            excess = law.force(f) + f ** (-p - 1) * bending - n
            moving = (stiffness > 0) & (abs(excess) > SECTION_ACCURACY * stiffness * f)
            if not moving.any():
                break
            step = np.clip(excess / stiffness, -MAX_STRETCH * f, MAX_STRETCH * f)
            f = f - np.where(moving, step, 0.0)
        softening = p * (p + 1) / 2 * self.f ** (p - 2) * bent.EI * self.kappa**2
        return np.append(law.stiffness(self.f) - softening / (mu2 * bent.EA), stiffness)

    @property
    def section_forces(self) -> tuple[NDArray, NDArray]:
        """Axial force and bending moment (sections,) at the weakest sections."""
        at, (x, y), (X, Y) = self.beam.sections, self.arms, self.distributed_loads
        Px, Py = at.outboard @ X, at.outboard @ Y
        here = at.from_clamp @ (self.f * self.direction).T
        about_axis = at.outboard @ (x * Y - y * X) - at.bodies @ self.body_moments
        moment = about_axis - (here[:, 0] + self.beam.beam.delta) * Py + here[:, 1] * Px
        angle = at.from_clamp @ self.kappa + self.root_angle
        return Px * np.cos(angle) + Py * np.sin(angle), moment

    @property
    def body_moments(self) -> NDArray:
        """The moments (masses,) on the beam of the forces distributed over bodies, taken by the
        beam: against their angle out of the plane of rotation, and against a spin-up in it."""
        bent = self.beam
        moments = bent.beam.gamma**2 * bent.restoring * np.sin(2 * self.body_angles) / 2
        return moments + bent.beam.spin_up * bent.rotary * bent.softens

    @property
    def collapses(self) -> bool:
        """Whether some short piece of the beam is not stable (Legendre's condition)."""
        return not self.local_stiffness.min() > 0

    @property
    def is_stable(self) -> bool:
        """Whether the stiffness is positive definite, on the mesh and for shorter deformations."""
        return self.is_positive_definite and not self.collapses

    @property
    def is_positive_definite(self) -> bool:
        """Whether the stiffness is positive definite, on the mesh."""
        return lapack.dpotrf(self.stiffness, lower=1)[1] == 0

    @cached_property
    def distributed_loads(self) -> tuple[NDArray, NDArray]:
        """Centrifugal and Euler force (m,) in x and in y on each mass."""
        bent, (x, y) = self.beam, self.arms
        gamma2, spin_up = bent.beam.gamma**2, bent.beam.spin_up
        load_y = gamma2 * bent.softens * y - spin_up * x
        return bent.mass * (gamma2 * x + spin_up * y), bent.mass * load_y

    @cached_property
    def loads(self) -> tuple[NDArray, NDArray]:
        """Force (n,) along the beam and across it of all that lies further out, times weights."""
        bent, n = self.beam, len(self.f)
        x, y = (load[:n] @ bent.J + load[n:] @ bent.to_carried for load in self.distributed_loads)
        c, s = self.direction
        return x * c + y * s, y * c - x * s

    @cached_property
    def residual(self) -> NDArray:
        """Derivative of the energy by q, less the Euler force (paper, eq. 40)."""
        bent, f, kappa, p = self.beam, self.f, self.kappa, self.beam.power
        along, across = self.loads
        axial = bent.beam.mu**2 * bent.EA * bent.law.force(f)
        axial += p * f ** (p - 1) * bent.EI * kappa**2 / 2
        moment = self.body_moments @ bent.to_body_angles
        moment[: len(f)] += bent.w * bent.EI * f**p * kappa - (f * across) @ bent.J
        if bent.hinged:
            moment[-1] += bent.beam.root * self.root_angle - f @ across
        return np.concatenate((bent.w * axial - along, moment))

    @cached_property
    def stiffness(self) -> NDArray:
        """Tangent (size, size) by the unknowns, symmetric without a spin-up (paper, eqs. 42-44)."""
        bent, f, kappa, (along, across) = self.beam, self.f, self.kappa, self.loads
        w, p, beam = bent.w, bent.power, bent.beam
        gamma2, spin_up = beam.gamma**2, beam.spin_up
        b, db, ddb = f**p, p * f ** (p - 1), p * (p - 1) * f ** (p - 2)
        axial = beam.mu**2 * bent.EA * bent.law.stiffness(f) + ddb * bent.EI * kappa**2 / 2
        K = bent.local(w * axial, w * bent.EI * db * kappa, w * bent.EI * b, beam.root)
        # The axial and the shear force turn with the beam.
        r, angle = bent.r, bent.angle
        turned = np.concatenate(
            [(Bf.T * across[points]) @ angle[points] for points, _, _, Bf, _ in bent.blocks]
        )
        K[:r, r:] -= turned
        K[r:, :r] -= turned.T
        K[r:, r:] += (angle.T * (f * along)) @ angle
        if bent.restoring.any():
            rows, turned = bent.body_angles, np.cos(2 * self.body_angles)
            K[r:, r:] += gamma2 * (rows.T * (bent.restoring * turned)) @ rows
        # The loads move along with the masses.
        x, y = self.displacements
        subtract_square(K, x, gamma2)
        if bent.softens:
            subtract_square(K, y, gamma2)
        if spin_up:  # the load is not symmetric
            K += spin_up * self.swirl
        return K

    @cached_property
    def inertia(self) -> NDArray:
        """Mass (size, size) by the unknowns, with the rotary inertia of bodies."""
        F = self.factor_of_inertia
        return F.T @ F

    @property
    def factor_of_inertia(self) -> NDArray:
        """F (2 m + masses, size) with the inertia F' F: `displacements`, and roots of moments of
        inertia times the angles of bodies."""
        bent = self.beam
        rotations = np.zeros((len(bent.rotary), bent.size))
        rotations[:, bent.r :] = np.sqrt(bent.rotary)[:, None] * bent.body_angles
        return np.vstack((*self.displacements, rotations))

    @cached_property
    def coriolis(self) -> NDArray | None:
        """Matrix (size, size) of the Coriolis forces, skew; None without them."""
        gamma = self.beam.beam.gamma
        return 2 * gamma * self.swirl if self.beam.problem.gyroscopic and gamma else None

    @property
    def swirl(self) -> NDArray:
        """Integral (size, size) of virtual displacements times e3 x displacements: skew."""
        X, Y = self.displacements
        S = Y.T @ X
        return S - S.T

    def displaced(self, V: NDArray) -> NDArray:
        """Root of the mass times the displacements (2, m, modes) by changes V (n + turning, modes)
        of q: those that `displacements` gives by the unknowns."""
        df, dkappa = V[: len(self.f)], V[len(self.f) :]
        (c, s), turn = self.direction[..., None], self.f[:, None] * self.beam.to_angle(dkappa)
        moved = self.beam.to_masses(np.stack((c * df - s * turn, s * df + c * turn)))
        return np.sqrt(self.beam.mass)[:, None] * moved

    def turned(self, V: NDArray) -> NDArray:
        """Root of the moments of inertia times the angles (masses, modes) of bodies by changes V
        (n + turning, modes) of q."""
        return np.sqrt(self.beam.rotary)[:, None] * (self.beam.to_body_angles @ V[len(self.f) :])

    def stiffness_of(self, V: NDArray) -> NDArray:
        """v' K v (modes,) of changes V (n + turning, modes) of q, by the integrals that `stiffness`
        consists of: to set up the matrix takes n / modes times as long."""
        bent, beam, f, p = self.beam, self.beam.beam, self.f[:, None], self.beam.power
        along, across = self.loads
        df, dkappa = V[: len(f)], V[len(f) :]
        turn, dkappa = bent.to_angle(dkappa), dkappa[: len(f)]
        kappa, EI = self.kappa, bent.w * bent.EI

        def product(weight: NDArray, a: NDArray, b: NDArray) -> NDArray:
            return weight @ (a.conj() * b).real

        axial = beam.mu**2 * bent.EA * bent.law.stiffness(self.f)
        axial += p * (p - 1) * self.f ** (p - 2) * bent.EI * kappa**2 / 2
        elastic = product(bent.w * axial, df, df) + product(EI * self.f**p, dkappa, dkappa)
        elastic += 2 * product(EI * p * self.f ** (p - 1) * kappa, df, dkappa)
        geometric = product(self.f * along, turn, turn) - 2 * product(across, df, turn)
        # The loads that move along with the masses.
        x, y = self.displaced(V)
        load = beam.gamma**2 * (abs(x) ** 2 + bent.softens * abs(y) ** 2)
        if beam.spin_up:
            load = load + 2j * beam.spin_up * (x.conj() * y).imag
        stiffness = elastic + geometric - load.sum(axis=0)
        if bent.hinged:
            stiffness += beam.root * abs(V[-1]) ** 2
        if bent.restoring.any():
            turned = abs(bent.to_body_angles @ V[len(f) :]) ** 2
            stiffness += beam.gamma**2 * (bent.restoring * np.cos(2 * self.body_angles)) @ turned
        return stiffness

    @property
    def displacements(self) -> NDArray:
        """Root of the mass times the derivatives (2, m, size) of x and y by the unknowns: F with
        the inertia F' F. Larger than the matrices, and computed anew, in half the time of one."""
        (c, s), bent = self.direction[..., None], self.beam
        n, f = len(self.f), self.f[:, None]
        displaced = np.zeros((2, len(bent.mass), bent.size))
        gradient = displaced[:, :n]  # which the integrals replace: large blades have large matrices
        for points, own, _, Bf, _ in bent.blocks:
            gradient[:, points, own] = self.direction[:, points, None] * Bf
        np.multiply(-f * s, bent.angle, out=gradient[0, :, bent.r :])
        np.multiply(f * c, bent.angle, out=gradient[1, :, bent.r :])
        displaced[:, n:] = bent.to_carried @ gradient
        bent.grid.integrals(gradient, out=gradient)
        displaced *= np.sqrt(bent.mass)[:, None]
        return displaced
