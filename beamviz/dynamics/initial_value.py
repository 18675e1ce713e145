"""The equations of a motion on a mesh, and the state that it starts from."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from beamviz.dynamics import start
from beamviz.dynamics.drives import Hub
from beamviz.dynamics.equation import AnyBeam, Equation, HubEquation
from beamviz.dynamics.problem import MotionProblem
from beamviz.dynamics.schemes import Scheme, scheme
from beamviz.errors import unknown_keyword
from beamviz.mechanics.cubic import CubicBeam
from beamviz.mechanics.cubic_elements import nodes_of
from beamviz.mechanics.planar import PlanarBeam
from beamviz.solver import Solution, solve
from beamviz.space.elements import Elements
from beamviz.space.refinement import quadrature_share
from beamviz.space.trial import cached_trial

MODES = 10  # that a start may name
SOLVE_TOLERANCE = 1e-9  # of the equilibrium and the modes that a motion starts from

Mesh = Elements | int  # the elements of method auto, the number of those of ancf


class EquationPart(NamedTuple):
    """The equation of a part of the motion."""

    end: float  # [T*]
    with_mass: bool  # whether the concentrated mass is on the beam
    equation: Equation


@dataclass(frozen=True)
class InitialValueProblem:
    """The equations of a motion on a mesh, the state at t = 0, and the scheme."""

    parts: tuple[EquationPart, ...]
    q: NDArray  # (n,) unknowns at t = 0
    v: NDArray  # (n,) their rates
    scheme: Scheme
    breaks: Sequence[float]  # times at which the speed is not smooth
    body_velocity: complex  # of the body that docks, relative to the frame of the hub


def start_solution(problem: MotionProblem) -> Solution:
    """The equilibrium at the first speed, and the modes about it where the start names some.
    Raises NoEquilibrium."""
    beam = problem.beam.replace(gamma=abs(problem.first_speed))
    if not problem.parts[0].with_mass:
        beam = beam.replace(alpha=0.0)
    return solve(
        beam,
        modes=MODES if problem.start else 1,
        strain=problem.strain,
        curvature=problem.curvature,
        state=problem.state,
        coriolis=bool(problem.start),
        tolerance=SOLVE_TOLERANCE,
    )


def initial_value_problem(
    problem: MotionProblem, solution: Solution, mesh: Mesh
) -> InitialValueProblem:
    """The problem on a mesh, from the equilibrium or the modes of a solution. Raises NoEquilibrium
    and NotConverged."""
    equations = [equation_of(problem, mesh, part.with_mass) for part in problem.parts]
    beam, gamma = equations[0].beam, problem.first_speed
    q = start.equilibrium(beam, solution)
    if problem.damping:
        damping = start.damping_matrix(beam, q, gamma, problem.damping)
        for equation in equations:
            equation.D = damping
    v = np.zeros_like(q)
    if problem.release:
        q = start.under_force(beam, q, gamma, problem.release)
    elif problem.start:
        turning = math.copysign(1.0, gamma)
        q, v = start.with_modes(beam, q, solution, mode_amplitudes(problem, solution), turning)
    if isinstance(problem.drive, Hub):
        q, v = np.append(q, 0.0), np.append(v, problem.beam.gamma)
    parts = (
        EquationPart(part.end, part.with_mass, equation)
        for part, equation in zip(problem.parts, equations, strict=True)
    )
    return InitialValueProblem(
        parts=tuple(parts),
        q=q,
        v=v,
        scheme=scheme(problem.integrator),
        breaks=problem.drive.breaks,
        body_velocity=complex(*problem.body_velocity),
    )


def beam_of(problem: MotionProblem, mesh: Mesh, with_mass: bool) -> AnyBeam:
    """The beam on a mesh, with or without the concentrated mass."""
    beam = problem.beam if with_mass else replace(problem.beam, alpha=0.0)
    theory = problem.statics.theory
    if isinstance(mesh, int):
        return CubicBeam(nodes_of(problem.beam, mesh), beam, theory, problem.release_at)
    share = quadrature_share(problem.tolerance)
    trial = cached_trial(mesh, beam.blade, theory.bending_property, share)
    return PlanarBeam(trial, beam, theory, problem.release_at)


def equation_of(problem: MotionProblem, mesh: Mesh, with_mass: bool) -> Equation:
    """The equation of motion, not damped, with or without the concentrated mass."""
    beam = beam_of(problem, mesh, with_mass)
    if isinstance(problem.drive, Hub):
        return HubEquation(beam, problem.drive.inertia, problem.drive.history)
    return Equation(beam, problem.drive)


def mode_amplitudes(problem: MotionProblem, solution: Solution) -> dict[int, float]:
    """The amplitudes that a start gives, by the number of the mode; raises InvalidInput for a mode
    that is not among the lowest."""
    for name in problem.amplitudes:
        if name not in solution.labels:
            raise unknown_keyword("mode", name, solution.labels)
    return {solution.labels.index(name): size for name, size in problem.amplitudes.items()}
