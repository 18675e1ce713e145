"""Public entry points of the solver: the options are checked, the method and the state chosen.

What a method needs is imported when it is first used: most processes use one method, and none that
only checks options or prints help needs scipy.
"""

import time
from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import partial
from operator import attrgetter
from typing import Any

from beamviz.beam import Beam
from beamviz.checks import check_int
from beamviz.errors import BeamvizError, InvalidInput, NoEquilibrium, NotConverged, to_keep
from beamviz.solver.planes import beam_in_plane, solve_both
from beamviz.solver.problem import (
    MAX_MODES,
    METHODS,
    Problem,
    documents_options,
    interruption,
    parse_keywords,
)
from beamviz.solver.solution import Solution

Answer = Solution | BeamvizError
SolveOne = Callable[[Beam, Problem], Solution]


# The keywords are spelled out, although `Problem` declares them, because editors and notebooks
# complete them then and show the defaults; tests/solver/test_options.py compares the two.
@documents_options
def solve(
    beam: Beam,
    modes: int = Problem.modes,
    method: str = Problem.method,
    strain: str = Problem.strain,
    curvature: str = Problem.curvature,
    coriolis: bool | float = Problem.coriolis,
    plane: str = Problem.plane,
    tolerance: float = Problem.tolerance,
    elements: int | None = Problem.elements,
    terms: int | None = Problem.terms,
    stiffening: bool = Problem.stiffening,
    softening: bool = Problem.softening,
    state: str = Problem.state,
    **unknown: Any,
) -> Solution:
    """Equilibrium and the lowest `modes` modes of a beam.

    Raises InvalidInput, NoEquilibrium (with .limit) and NotConverged.
    """
    problem = parse_keywords(
        modes=modes,
        method=method,
        strain=strain,
        curvature=curvature,
        coriolis=coriolis,
        plane=plane,
        tolerance=tolerance,
        elements=elements,
        terms=terms,
        stiffening=stiffening,
        softening=softening,
        state=state,
        **unknown,
    )
    (answer,) = _solve([beam], problem)
    if isinstance(answer, BeamvizError):
        raise answer
    return answer


@documents_options
def solve_many(beams: Iterable[Beam], extra_modes: int = 0, **options: Any) -> list[Answer]:
    """`solve` for many beams with the same options, in batches where the method allows it.

    Returns a Solution for each beam, or its error: NoEquilibrium or NotConverged.
    extra_modes: number of modes beyond those asked for, 0 to 20, whose errors may exceed the
    tolerance; where the mesh that resolves those asked for has fewer, or the method at its number
    of elements or terms, the others are nan or left out.
    Raises InvalidInput for wrong options.
    """
    problem = parse_keywords(**options)
    extra_modes = check_int("extra_modes", extra_modes, 0, MAX_MODES)
    return _solve(list(beams), problem, problem.available(extra_modes))


def _solve(beams: list[Beam], problem: Problem, extra_modes: int = 0) -> list[Answer]:
    """Dispatch to the plane, the state and the method."""
    start = time.perf_counter()
    if problem.in_space:
        answers = solve_both(beams, problem, partial(_solve_section, extra_modes=extra_modes))
    else:
        sections = [beam_in_plane(beam, problem.plane) for beam in beams]
        answers = _solve_section(sections, problem, extra_modes)
    seconds = time.perf_counter() - start
    for k, (beam, answer) in enumerate(zip(beams, answers, strict=True)):
        if isinstance(answer, Solution):
            if answer.beam is not beam:
                answers[k] = answer = replace(answer, beam=beam)
            answer.stats.seconds = seconds
    return answers


def _solve_section(beams: list[Beam], problem: Problem, extra_modes: int = 0) -> list[Answer]:
    """Dispatch to the state and the method, of beams of the mechanics."""
    if not METHODS[problem.method].blades:
        _check_uniform(beams, problem)
    answers: list[Answer]
    if problem.state != "straight" or any(map(attrgetter("spin_up"), beams)):
        answers = _solve_states(beams, problem, extra_modes)
    elif METHODS[problem.method].package == "hp":
        from beamviz.solver.straight import solve_hp

        answers = solve_hp(beams, problem, extra_modes)
    else:
        solve_one = _solver_of_one_beam(problem.method)
        more = replace(problem, modes=problem.modes + extra_modes)
        answers = [_attempt(solve_one, beam, more) for beam in beams]
    return answers


def _check_uniform(beams: list[Beam], problem: Problem) -> None:
    """InvalidInput for a beam that is not uniform in the plane it bends in, which the method does
    not solve."""
    if all(beam.is_prismatic if problem.chordwise else beam.is_uniform for beam in beams):
        return
    alike = "" if problem.chordwise else ", and as stiff out of the plane of rotation as in it"
    raise InvalidInput(
        f"method {problem.method}: the beam has to be uniform, clamped, with one concentrated mass"
        f"{alike}",
        use={"method": [name for name, row in METHODS.items() if row.blades]},
    )


def _solver_of_one_beam(method: str) -> SolveOne:
    """The function of a method that solves for one beam at a time."""
    if METHODS[method].package == "fem":
        from beamviz.solver import fem

        return fem.solve
    from beamviz.solver import series

    return {
        "assumed-modes": series.assumed_modes,
        "power-series": series.power_series,
        "chebyshev": series.chebyshev_collocation,
    }[method]


def _attempt(solve_one: Callable[..., Solution], *arguments: Any) -> Answer:
    """The Solution of a solver of one beam, or the NoEquilibrium or NotConverged that it raises."""
    interruption.get()()
    try:
        return solve_one(*arguments)
    except (NoEquilibrium, NotConverged) as error:
        return to_keep(error)


def _solve_states(beams: list[Beam], problem: Problem, extra_modes: int) -> list[Answer]:
    """The straight state of each beam where state="stable" is asked for and the straight state is
    stable, else a bent state; each bent state is the first guess for the next beam."""
    for beam in beams:
        _check_state(beam, problem)
    straight: dict[int, Answer] = {}
    if problem.state == "stable":
        steady = [k for k, beam in enumerate(beams) if not beam.spin_up]
        straight_problem = replace(problem, state="straight")
        straight_answers = _solve_section([beams[k] for k in steady], straight_problem, extra_modes)
        straight = dict(zip(steady, straight_answers, strict=True))
    answers: list[Answer] = []
    near: Any = None  # the last bent state
    for k, beam in enumerate(beams):
        answer = straight.get(k)
        if isinstance(answer, Solution) and answer.equilibrium.stable:
            answers.append(replace(answer, problem=problem))
            continue
        from beamviz.solver.bent import solve_bent

        answer = _attempt(solve_bent, beam, problem, near, extra_modes)
        near = answer.equilibrium.bent_state if isinstance(answer, Solution) else None
        answers.append(answer)
    return answers


def _check_state(beam: Beam, problem: Problem) -> None:
    """InvalidInput where the other options exclude the state or the spin-up asked for."""
    use: dict[str, tuple[str, ...]] = {}
    requested = f"spin_up = {beam.spin_up:g}" if beam.spin_up else f"state = {problem.state!r}"
    if beam.spin_up and problem.state == "straight":
        reason, use = "there is no straight state", {"state": ("stable", "bent")}
    elif problem.method != Problem.method:
        reason, use = f"method {problem.method} has no bent states", {"method": (Problem.method,)}
    elif not (problem.stiffening and problem.softening):
        reason = "stiffening and softening cannot be switched off"
    elif beam.spin_up and not problem.chordwise:
        reason, use = "it bends the beam in the plane of rotation", {"plane": ("chordwise",)}
    else:
        return
    raise InvalidInput(f"{requested}: {reason}", use=use)
