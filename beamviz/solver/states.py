"""Straight and stable states told apart: what is bent is imported where a beam needs it."""

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

from beamviz.beam import Beam
from beamviz.errors import BeamvizError, InvalidInput, NoEquilibrium, NotConverged
from beamviz.solver.problem import Problem, interruption
from beamviz.solver.solution import Solution

if TYPE_CHECKING:
    from beamviz.solver.bent.equilibrium import State

METHODS_THAT_BEND = ("auto", "ancf-planar")
Solver = Callable[[list[Beam], Problem, float, int], list[Solution | BeamvizError]]


def solve_states(
    solve_straight: Solver, beams: list[Beam], problem: Problem, start: float, extra_modes: int = 0
) -> list[Solution | BeamvizError]:
    """Solutions of beams about the states that the problem asks for, or their errors: straight
    where that is stable and "stable" is asked for, else bent. Each bent state is the first guess
    for the next beam. solve_straight: solves straight states by the problem's method."""
    for beam in beams:
        _check(beam, problem)
    answers: list[Solution | BeamvizError] = []
    near: State | None = None
    for beam, answer in zip(
        beams, _straight(solve_straight, beams, problem, start, extra_modes), strict=True
    ):
        if not (isinstance(answer, Solution) and answer.equilibrium.stable):
            interruption.get()()
            from beamviz.solver.bent import solve_by_method

            try:
                answer, near = solve_by_method(beam, problem, start, near, extra_modes)
            except (NoEquilibrium, NotConverged) as error:
                answer, near = error, None
        answers.append(answer)
    return answers


def _straight(
    solve_straight: Solver, beams: list[Beam], problem: Problem, start: float, extra_modes: int
) -> list[Solution | BeamvizError | None]:
    """The straight states of beams without a spin-up where the stable state is asked for."""
    answers: list[Solution | BeamvizError | None] = [None] * len(beams)
    still = [k for k, beam in enumerate(beams) if not beam.spin_up]
    if problem.state == "stable" and still:
        straight = replace(problem, state="straight")
        found = solve_straight([beams[k] for k in still], straight, start, extra_modes)
        for k, answer in zip(still, found, strict=True):
            answers[k] = (
                replace(answer, problem=problem) if isinstance(answer, Solution) else answer
            )
    return answers


def _check(beam: Beam, problem: Problem) -> None:
    """InvalidInput where a bent state is not what the options describe."""
    wanted = f"spin_up = {beam.spin_up:g}" if beam.spin_up else f"state = {problem.state!r}"
    if beam.spin_up and problem.state == "straight":
        raise InvalidInput(f"{wanted}: there is no straight state; use state = 'bent' or 'stable'")
    if problem.method not in METHODS_THAT_BEND:
        able = " or ".join(METHODS_THAT_BEND)
        raise InvalidInput(f"{wanted}: method {problem.method} has no bent states; use {able}")
    if not (problem.stiffening and problem.softening):
        raise InvalidInput(f"{wanted}: stiffening and softening cannot be switched off")
    if beam.spin_up and not problem.chordwise:
        raise InvalidInput(f"{wanted}: bends the beam in the plane of rotation; use chordwise")
