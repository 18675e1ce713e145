"""Deflected states of a beam on the elements of a problem, and their stability.

A state is one of `beamviz.mechanics.planar` at rest in the rotating frame. Without a spin-up its
loads have a potential, and it is stable at a minimum of the energy: where the stiffness is positive
definite, on the mesh and for deformations much shorter than the beam (Legendre's condition).
"""

from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

from beamviz.beam import Beam
from beamviz.mechanics.planar import MAX_STRETCH, PlanarBeam, PlanarState
from beamviz.solver.pencil.matrices import product
from beamviz.solver.problem import Problem
from beamviz.space.elements import Elements
from beamviz.space.grid import Grid
from beamviz.space.refinement import quadrature_share
from beamviz.space.trial import Trial, cached_trial, make_trial

SECTION_STEPS = 60  # of Newton's method for the stretch at the weakest sections
SECTION_ACCURACY = 1e-9  # of that stretch, relative
LEAST_RIGIDITY = 0.1  # of the axial stiffness, relative to that at rest: a law may have none left
STRAIGHT = 1e-6  # largest angle [rad] of a state that counts as straight
SAME_ENERGY = 1e-9  # relative difference of two descents to the same state


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
        clamp, stiffness = np.zeros((1, len(grid.points))), np.ones(1)
        all_of_both = np.ones((1, len(masses))), np.ones((1, len(bodies)))
        return Sections(clamp, np.zeros(1, int), *all_of_both, stiffness, stiffness)
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
    share = quadrature_share(problem.tolerance)
    return elements, beam.blade, problem.bending_property, share


class BentBeam(PlanarBeam):
    """A beam on elements whose ends hold the bodies, for a problem."""

    def __init__(
        self, elements: Elements, beam: Beam, problem: Problem, trial: Trial | None = None
    ):
        self.elements, self.problem = elements, problem
        trial = trial or cached_trial(*_about_trial(elements, beam, problem))
        super().__init__(trial, beam, problem.theory)

    @property
    def highest(self) -> list[NDArray]:
        """Numbers of the unknowns of the highest functions of each element, of both kinds."""
        return [np.append(along, self.along + across) for along, across in self.trial.highest]

    @cached_property
    def sections(self) -> Sections:
        """The sections where the beam may be weakest."""
        return weakest_sections(self.grid, self.beam, self.masses.x, self.problem)

    def changed(self, **numbers: Any) -> "BentBeam":
        """With other numbers of the beam."""
        return BentBeam(self.elements, self.beam.replace(**numbers), self.problem, self.trial)

    def on(self, elements: Elements) -> "BentBeam":
        """On other elements. Most are used once: their matrices, which may be large, are not
        cached."""
        trial = make_trial(*_about_trial(elements, self.beam, self.problem))
        return BentBeam(elements, self.beam, self.problem, trial)


class BentState(PlanarState):
    """A state of a bent beam, in equilibrium or not. iterations: number of them that led to it."""

    beam: BentBeam

    def __init__(self, beam: BentBeam, q: NDArray, iterations: int = 0):
        super().__init__(beam, q, beam.loading)
        self.iterations = iterations

    def resampled(self, beam: BentBeam) -> NDArray:
        """q of the beam on other elements, by interpolation at its Gauss points."""
        rows = self.beam.grid.at(beam.grid.points)
        return beam.fitted(rows @ self.f, rows @ self.kappa, self.root_angle)

    def shifted(self, f: NDArray, kappa: NDArray) -> "BentState":
        """The state with changes of the stretch and of kappa (n,) at the Gauss points, which are no
        sums of trial functions; only for integrals of changes of its unknowns."""
        other, bent = BentState(self.beam, self.q), self.beam
        other.f, other.kappa = self.f + f, self.kappa + kappa
        other.theta = self.theta + bent.trial.J @ kappa
        other.e = np.exp(1j * other.theta)
        other.slope = other.f * other.e
        other.R = bent.to_masses(other.slope) + bent.beam.delta
        return other

    @property
    def mirrored(self) -> "BentState":
        """Its mirror image, bent to the other side."""
        q, r = self.q, self.beam.along
        return BentState(self.beam, np.append(q[:r], -q[r:]), self.iterations)

    @property
    def upward(self) -> "BentState":
        """The state or its mirror image: that whose tip has y >= 0."""
        return self.mirrored if self.beam.w @ self.slope.imag < 0 else self

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

    @cached_property
    def energies(self) -> tuple[float, float]:
        """Stored and centrifugal energy, without the Euler force: their sum scales the rounding
        error of their difference. Infinite where f <= 0."""
        if not self.f.min() > 0:
            return np.inf, 0.0
        return float(self.stored), float(self.centrifugal)

    @property
    def energy(self) -> float:
        """Potential energy, without the Euler force; infinite where f <= 0."""
        stored, centrifugal = self.energies
        return stored - centrifugal

    @cached_property
    def rigidity(self) -> NDArray:
        """Material stiffness (size, size), without softening by compression."""
        bent = self.beam
        axial = bent.section.axial * np.maximum(bent.section.law.stiffness(self.f), LEAST_RIGIDITY)
        bending = bent.section.bending * bent.section.power_of(self.f)
        return bent.local(bent.w * axial, 0.0 * bent.w, bent.w * bending, 1 + bent.beam.root)

    @property
    def gyroscopic(self) -> NDArray | None:
        """Matrix (size, size) of the Coriolis forces, skew; None without them."""
        factor = self.beam.problem.coriolis_factor
        return factor * self.coriolis if factor and self.beam.beam.gamma else None

    # Stability

    @cached_property
    def local_stiffness(self) -> NDArray:
        """Stiffness (n + sections,) in f of deformations much shorter than the beam, over that of
        the section at rest: at the mesh points and at the weakest sections.

        At a section the force P and the moment m are known, and f is the root of

            mu^2 EA n(f) + p / 2 f^(-p - 1) m^2 / EI = P,

        whose derivative by f is the stiffness. Of the roots that the bending term may add one alone
        is stiff: it is sought from where the law is stiffest. -1 where no stretch carries P and m.
        """
        section, at = self.beam.section, self.beam.sections
        p, law = section.power, section.law
        pull, moment = self.section_forces
        mu2 = self.beam.beam.mu**2
        n, bending = pull / (mu2 * at.EA), p / 2 * moment**2 / (mu2 * at.EA * at.EI)
        f = self.f[at.nearest]
        stiffer = MAX_STRETCH if law.stiffens else -MAX_STRETCH
        for _ in range(SECTION_STEPS):
            stiffness = law.stiffness(f) - (p + 1) * f ** (-p - 2) * bending
            excess = law.force(f) + f ** (-p - 1) * bending - n
            stiff = stiffness > 0
            step = -excess / np.where(stiff, stiffness * f, 1.0)  # relative to f
            step = np.where(stiff, np.clip(step, -MAX_STRETCH, MAX_STRETCH), stiffer)
            moving = abs(step) > SECTION_ACCURACY
            if not moving.any():
                break
            f = f * (1 + np.where(moving, step, 0.0))
        stiffness = np.where(moving, -1.0, stiffness)
        at_points = section.stiffness_at_constant_moment(self.f, self.kappa) / section.axial
        return np.append(at_points, stiffness)

    @property
    def weakest(self) -> float:
        """x where this stiffness is least."""
        at_sections = self.beam.sections.from_clamp.sum(axis=1)
        return float(np.append(self.beam.points, at_sections)[self.local_stiffness.argmin()])

    @property
    def section_forces(self) -> tuple[NDArray, NDArray]:
        """Axial force and bending moment (sections,) at the weakest sections."""
        at, load = self.beam.sections, -self.p
        outboard = at.outboard @ load
        here = at.from_clamp @ self.slope + self.beam.beam.delta
        about_axis = at.outboard @ (self.R.conj() * load).imag - at.bodies @ self.body_moments
        moment = about_axis - (here.conj() * outboard).imag
        angle = at.from_clamp @ self.kappa + self.root_angle
        return (outboard * np.exp(-1j * angle)).real, moment

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

    # Changes V (size, modes) of the unknowns

    def gradients(self, V: NDArray) -> NDArray:
        """Derivatives (2, n, modes) by x of the displacements in x and in y."""
        r, (c, s) = self.beam.along, (part[:, None] for part in (self.e.real, self.e.imag))
        df, turn = product(self.beam.Z, V[:r]), product(self.beam.S, V[r:]) * self.f[:, None]
        return np.stack((c * df - s * turn, s * df + c * turn))

    def displaced(self, V: NDArray) -> NDArray:
        """Root of the mass times the displacements (2, m, modes)."""
        gradients = self.gradients(V)
        inside = np.stack([product(self.beam.trial.J, part) for part in gradients])
        bodies = np.stack([product(self.beam.to_moving, part) for part in gradients])
        return np.sqrt(self.beam.mass)[:, None] * np.concatenate((inside, bodies), axis=1)

    def turned(self, V: NDArray) -> NDArray:
        """Root of the moments of inertia times the angles (masses, modes) of bodies."""
        return product(self.beam.rotations, V)

    def stiffness_of(self, V: NDArray) -> NDArray:
        """v' K v (modes,), by the integrals that `stiffness` consists of: to set up the matrix
        takes size / modes times as long."""
        bent, r = self.beam, self.beam.along
        df, dkappa, turn = (
            product(A, part) for A, part in ((bent.Z, V[:r]), (bent.B, V[r:]), (bent.S, V[r:]))
        )

        def integral(weight: NDArray, a: NDArray, b: NDArray) -> NDArray:
            return weight @ (a.conj() * b).real

        ff, fk, kk = (bent.w * part for part in bent.section.stiffness(self.f, self.kappa))
        elastic = integral(ff, df, df) + integral(kk, dkappa, dkappa) + 2 * integral(fk, df, dkappa)
        along, across = self.section_loads.real, self.section_loads.imag
        geometric = 2 * integral(across, df, turn) - integral(self.f * along, turn, turn)
        # The loads that move along with the masses.
        gamma, rate, in_plane, _ = self.loading
        x, y = self.displaced(V)
        load = gamma**2 * (abs(x) ** 2 + in_plane * abs(y) ** 2)
        if rate:
            load = load + 2j * rate * (x.conj() * y).imag
        stiffness = elastic + geometric - load.sum(axis=0)
        if bent.hinged:
            stiffness += bent.beam.root * abs(bent.root_scale * V[-1]) ** 2
        if bent.masses.restoring.any():
            restoring = bent.masses.restoring_stiffness(self.loading, self.body_angles)
            stiffness += restoring @ abs(product(bent.turning, V[r:])) ** 2
        return stiffness


def corotational_components(dx: NDArray, dy: NDArray, angle: NDArray) -> NDArray:
    """Corotational components (k, 2, modes), along and across the deflected beam, of displacements
    dx and dy (k, modes) at points where it has an angle (k,)."""
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    return np.stack((c * dx + s * dy, c * dy - s * dx), axis=1)
