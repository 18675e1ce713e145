"""Stability of equilibria: what is unstable, and how.

*Divergence* is a static instability: a disturbance grows without vibration, s is real and positive.
*Flutter* is a growing vibration: s is complex with a positive real part. In JSON and in Python the
`status` of an equilibrium with divergence is "unstable", with flutter alone "growing".

The loads on a straight state, and on a deflected one without a spin-up, have a potential: the
stiffness K is symmetric, s^2 is real, and its sign decides, without a threshold. Such a state is
unstable where K is not positive definite, with divergence: Coriolis forces do not change that, as K
of one of the two families that they couple is always definite. The Euler force of a spin-up has no
potential. There growth rates within the rounding error of s count as zero
(`beamviz.solver.pencil.single.general_modes`), and the modes asked for and the four next ones by
|s| are seen.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from beamviz.beam import Beam
from beamviz.errors import BeamvizError
from beamviz.mechanics.straight_properties import BeamStack
from beamviz.solver.pencil.matrices import Definiteness
from beamviz.solver.problem import Problem
from beamviz.solver.solution import Solution, Status
from beamviz.space.spans import AnyBeam

INSTABILITIES = {"unstable": "divergence", "growing": "flutter"}  # by status


def status_of(s: NDArray) -> Status:
    """The status of an equilibrium with modes s (modes,), growth rate + i frequency; divergence
    comes before flutter."""
    grows = s.real > 0
    if not grows.any():
        return "stable"
    return "unstable" if (s.imag[grows] == 0).any() else "growing"


def may_buckle(beam: AnyBeam) -> bool:
    """Whether the straight state of a beam may have divergence: where it points inward. Outward
    the tension stiffens bending by more than the rotation of its frame softens it."""
    return beam.delta < 0


def is_certain_to_be_stable(beam: AnyBeam) -> bool:
    """Whether it has none, and nothing is free to turn either."""
    return not may_buckle(beam) and (beam.delta > 0 or beam.root > 0)


def is_buckled_chordwise(
    beam: Beam,
    problem: Problem,
    lowest_bending: float | None,
    solve: Callable[[Beam, Problem], Solution | BeamvizError],
) -> bool:
    """Whether the straight state of a beam that vibrates flapwise is unstable in the plane of
    rotation.

    lowest_bending: omega^2 of its lowest bending mode; None where it is not known. solve: by the
    default method. Of a uniform beam softening lowers every omega^2 by gamma^2 there. Others may
    have another bending stiffness, and their bodies another inertia, than out of it: those that
    point inward are solved for.
    """
    if problem.chordwise or not problem.softening:
        return False
    if beam.is_uniform and lowest_bending is not None:
        return bool(lowest_bending < beam.gamma**2)
    if not may_buckle(beam):
        return False
    chordwise = solve(beam, replace(problem, plane="chordwise", coriolis=False, modes=1))
    return isinstance(chordwise, Solution) and not chordwise.equilibrium.stable


def softening_of_families(beams: BeamStack, problem: Problem) -> NDArray:
    """gamma^2 (beams, 2, 1) by which softening lowers omega^2 of bending and of stretching; in
    space K of bending is less by it."""
    return beams.gamma[..., None] ** 2 * problem.softened


def cancelled_softening(beams: BeamStack, problem: Problem) -> NDArray | None:
    """gamma^2 (beams, 2, 1) that K of bending in space is less by in the plane of rotation; None in
    one plane."""
    if not (problem.in_space and problem.softening):
        return None
    return beams.gamma[..., None] ** 2 * np.array([[1.0], [0.0]])


def definiteness_of_bending(beams: BeamStack, problem: Problem) -> Definiteness:
    """Of the stiffness of bending, without softening. The lowest omega^2 of a beam that turns about
    its root may be as small as the spring there is weak or the speed is low."""
    if problem.in_space and (beams.hinged or not problem.stiffens):
        return "indefinite"
    free = beams.root == 0 and not (beams.rotating and problem.stiffens)
    # Flapwise, centrifugal forces turn a body that is long along the axis of rotation away from it.
    tilts = not problem.chordwise and any(Jx > Jz for Jx, _, Jz in inertias_of(beams))
    if beams.inward or free or tilts:
        return "indefinite"
    return "semidefinite" if beams.hinged else "definite"


def inertias_of(beams: BeamStack) -> list[tuple[float, float, float]]:
    """The principal moments of inertia of the bodies."""
    return [mass.inertia for mass in beams.masses]


def turns_freely(beams: BeamStack, problem: Problem) -> NDArray:
    """The number of the first modes of each beam (beams,) that are rigid rotations about a hinge
    that nothing holds: at rest; without stiffening; and in the plane of rotation about the axis of
    rotation."""
    gamma, delta = beams.gamma[:, 0], beams.delta[:, 0]
    if beams.root != 0:
        return np.zeros(len(gamma), int)
    steady = problem.stiffens or any(Jz != Jx for Jx, _, Jz in inertias_of(beams))
    free = {
        True: (gamma == 0) | ((delta == 0) & problem.stiffens & problem.softening),
        False: (gamma == 0) | (not steady and not problem.in_space),
    }
    return sum(free[in_plane].astype(int) for in_plane in problem.components_in_plane)
