"""One integration of a case on one mesh with one choice of steps."""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from beamviz.dynamics import start
from beamviz.dynamics.case import Case
from beamviz.dynamics.drives import Hub
from beamviz.dynamics.equation import AnyBeam, Equation, HubEquation
from beamviz.dynamics.integration import Control, Path, Recorder, integrate
from beamviz.dynamics.schemes import scheme
from beamviz.errors import unknown_keyword
from beamviz.mechanics.cubic import CubicBeam
from beamviz.mechanics.planar import PlanarBeam
from beamviz.solver import Solution, solve
from beamviz.space.elements import Elements
from beamviz.space.trial import cached_trial

MODES = 10  # that a start may name
SOLVE_TOLERANCE = 1e-9  # of the equilibrium and the modes that a motion starts from
FIRST_STEP = 0.1  # [T*]; the next ones are chosen by the tails
QUADRATURE_SHARE = (
    0.1  # of the tolerance, that integrals over 1 over a property of a blade may lose
)

Mesh = Elements | int  # the elements of method auto, the number of those of ancf


@dataclass(frozen=True)
class Run:
    """An integration: its path, and the equation that holds until each of some times."""

    path: Path
    parts: tuple[tuple[float, Equation], ...]

    def tip(self, t: NDArray) -> NDArray:
        """Position of the tip (len(t), 2)."""
        q, _ = self.path.at(t)
        beam = self.path.beam
        tip = beam.state(q[:, : beam.size]).positions(np.ones(1))[:, 0]
        return np.stack((tip.real, tip.imag), axis=1)

    def speed(self, t: NDArray) -> NDArray:
        """gamma (len(t),)."""
        _, v = self.path.at(t)
        return self.parts[0][1].gamma(t, v)

    def energy(self, t: NDArray) -> NDArray:
        """The energy in the rotating frame (len(t),)."""
        q, v = self.path.at(t)
        energy, before = np.empty(len(t)), -1.0
        for end, equation in self.parts:
            inside = (before < t) & (t <= end)
            gamma, n = equation.gamma(t[inside], v[inside]), equation.size
            energy[inside] = equation.energy(gamma, q[inside, :n], v[inside, :n])
            before = end
        return energy


def start_solution(case: Case) -> Solution:
    """The equilibrium at the first speed, and the modes about it where the start names some.
    Raises NoEquilibrium."""
    beam = case.beam.replace(gamma=abs(case.first_speed))
    if not case.parts[0].with_mass:
        beam = beam.replace(alpha=0.0)
    return solve(
        beam,
        modes=MODES if case.start else 1,
        strain=case.strain,
        curvature=case.curvature,
        state=case.state,
        coriolis=bool(case.start),
        tolerance=SOLVE_TOLERANCE,
    )


def run(case: Case, solution: Solution, mesh: Mesh, control: Control) -> Run:
    """Integrates a case. Raises NoEquilibrium and NotConverged."""
    if control.budget:
        control.budget.begin()
    first = equation_of(case, mesh, case.parts[0].with_mass)
    beam, gamma = first.beam, case.first_speed
    q = start.equilibrium(beam, solution)
    if case.damping:
        first.D = start.damping_matrix(beam, q, gamma, case.damping)
    v = np.zeros_like(q)
    if case.release:
        q = start.under_force(beam, q, gamma, case.release)
    elif case.start:
        turning = math.copysign(1.0, gamma)
        q, v = start.with_modes(beam, q, solution, mode_amplitudes(case, solution), turning)
    if isinstance(case.drive, Hub):
        q, v = np.append(q, 0.0), np.append(v, case.beam.gamma)
    record, t, length = Recorder(beam, 0.0), 0.0, FIRST_STEP
    parts: list[tuple[float, Equation]] = []
    before: Equation | None = None
    for part in case.parts:
        equation = equation_of(case, mesh, part.with_mass) if before else first
        equation.D = first.D
        if before and part.with_mass:
            v = equation.after_docking(q, v, before, complex(*case.body_velocity))
        if part.end > t:
            q, v, length = integrate(
                *(equation, scheme(case.integrator), (q, v), t, part.end),
                *(case.drive.breaks, control, record, length),
            )
            parts.append((part.end, equation))
        before, t = equation, part.end
    return Run(record.path, tuple(parts))


def beam_of(case: Case, mesh: Mesh, with_mass: bool) -> AnyBeam:
    """The beam on a mesh, with or without the concentrated mass."""
    beam = case.beam if with_mass else replace(case.beam, alpha=0.0)
    theory = case.problem.theory
    if isinstance(mesh, int):
        return CubicBeam(mesh, beam, theory, case.release_at)
    share = QUADRATURE_SHARE * case.tolerance
    trial = cached_trial(mesh, beam.blade, theory.bending_property, share)
    return PlanarBeam(trial, beam, theory, case.release_at)


def equation_of(case: Case, mesh: Mesh, with_mass: bool) -> Equation:
    """The equation of motion, not damped, with or without the concentrated mass."""
    beam = beam_of(case, mesh, with_mass)
    if isinstance(case.drive, Hub):
        return HubEquation(beam, case.drive.inertia, case.drive.history)
    return Equation(beam, case.drive)


def mode_amplitudes(case: Case, solution: Solution) -> dict[int, float]:
    """The amplitudes that a start gives, by the number of the mode; raises InvalidInput for a mode
    that is not among the lowest."""
    for name in case.amplitudes:
        if name not in solution.labels:
            raise unknown_keyword("mode", name, solution.labels)
    return {solution.labels.index(name): size for name, size in case.amplitudes.items()}
