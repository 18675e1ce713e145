"""Public entry point: validates the options and dispatches to the chosen method."""

import time
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import lru_cache
from operator import attrgetter
from typing import Any

import numpy as np

from beamviz.beam import Beam, check_float, check_int
from beamviz.errors import (
    BeamvizError,
    InvalidInput,
    NoEquilibrium,
    NotConverged,
    unknown_keyword,
)
from beamviz.solver.hp import displacements as displacements
from beamviz.solver.hp import family_spectrum as family_spectrum
from beamviz.solver.hp import mesh_spectrum as mesh_spectrum
from beamviz.solver.hp import solve_hp
from beamviz.solver.hp.equilibrium import greatest_force as greatest_force
from beamviz.solver.hp.equilibrium import is_small_strain as is_small_strain
from beamviz.solver.hp.mesh import interpolation_matrix as interpolation_matrix
from beamviz.solver.problem import CHOICES, METHODS, OPTIONS, Problem, interruption
from beamviz.solver.solution import Solution

MAX_MODES = 20
TOLERANCES = (1e-12, 0.1)  # least and greatest relative error that may be asked for
DEFAULTS = {name: getattr(Problem, name) for name in OPTIONS}


def solve(
    beam: Beam,
    modes: int = 5,
    method: str = "auto",
    strain: str = "green",
    curvature: str = "spatial",
    coriolis: bool = False,
    plane: str = "chordwise",
    tolerance: float = 1e-6,
    elements: int | None = None,
    terms: int | None = None,
    stiffening: bool = True,
    softening: bool = True,
    state: str = "straight",
    **unknown: Any,
) -> Solution:
    """Equilibrium and the lowest `modes` modes of a beam.

    tolerance: relative error of each frequency that `auto` refines to. elements: number of
    elements of `ancf` (20, the paper's, when not given). terms: of the series of `assumed-modes`
    (basis functions), `power-series` (powers) and `chebyshev` (order). Coriolis forces act in the
    chordwise plane only. stiffening, softening: whether the tension stiffens bending, and whether
    the centrifugal force, growing outwards, softens motion in the plane of rotation: switched off
    to see what each term does. Unstable straight states are returned, with status "unstable".
    state: "straight"; "bent": the stable bent state of lowest energy; "stable": the straight state
    where it is stable, else the bent one. A beam with a spin-up has no straight state.
    Raises InvalidInput, NoEquilibrium (with .limit) and NotConverged.
    """
    start = time.perf_counter()
    model = (modes, method, strain, curvature, coriolis, plane)
    others = (tolerance, elements, terms, stiffening, softening, state)
    problem = parse_options(*model, *others, **unknown)
    answer = _solve([beam], problem, start)[0]
    if isinstance(answer, BeamvizError):
        raise answer
    return answer


def solve_many(
    beams: Iterable[Beam], extra_modes: int = 0, mesh_of: Sequence[Beam] = (), **options: Any
) -> list[Solution | BeamvizError]:
    """`solve` for many beams with the same options, in batches where the method can.

    extra_modes: number of modes beyond those asked for, which need not meet the tolerance: their
    errors say how well the mesh of the others resolves them. mesh_of: beams
    between which these are, on a line: those with their mass at the same place then share a mesh,
    in this call and others. The place of a beam without an answer
    holds its error: NoEquilibrium or NotConverged. Raises InvalidInput for wrong options.
    """
    start = time.perf_counter()
    beams = list(beams)
    given = [options.pop(name, default) for name, default in DEFAULTS.items()]
    problem = parse_options(*given, **options)
    extra_modes = check_int("extra_modes", extra_modes, 0, MAX_MODES)
    return _solve(beams, problem, start, extra_modes, mesh_of)


def other_stable_states(solution: Solution, near: Sequence[Solution] = ()) -> list[Solution]:
    """The other stable bent states found of the beam of a solution, mirror images apart, with their
    modes: by ascending energy, or in the order of the states of other beams that they are near."""
    from beamviz.solver.bent import other_states

    return other_states(solution, near)


def end_of_bent_state(solution: Solution, over: str, stop: float) -> float | None:
    """The limit point of a bent state: the value of the number `over` of its beam, between the
    beam's own and `stop`, beyond which the state cannot be followed; None where it can all the way.
    """
    from beamviz.solver.bent import end_of_state

    return end_of_state(solution, over, stop)


def parse_options(*options: Any, **unknown: Any) -> Problem:
    """The problem that options describe, in the order of OPTIONS; InvalidInput where one is wrong.

    Valid combinations are remembered: a slider or a sweep gives the same ones again and again.
    """
    for name in unknown:
        raise unknown_keyword("option", name, OPTIONS)
    try:
        return _validated(*options)
    except TypeError:  # an option that cannot be hashed
        return _validated.__wrapped__(*options)


@lru_cache(maxsize=256, typed=True)
def _validated(*options: Any) -> Problem:
    """The problem in plain Python numbers; InvalidInput where an option is wrong."""
    values = dict(zip(OPTIONS, options, strict=True))
    for name, known in CHOICES.items():
        if not isinstance(values[name], str) or values[name] not in known:
            raise InvalidInput(f"{name} = {values[name]!r}: must be one of {', '.join(known)}")
    for name in ("coriolis", "stiffening", "softening"):
        if not isinstance(values[name], bool | np.bool_):
            raise InvalidInput(f"{name} = {values[name]!r}: must be True or False")
        values[name] = bool(values[name])
    values["modes"] = check_int("modes", values["modes"], 1, MAX_MODES)
    values["tolerance"] = check_float("tolerance", values["tolerance"], *TOLERANCES)
    problem = Problem(**values)
    for feature in METHODS[problem.method].unsupported:
        if option := feature.requested_by(problem):
            able = [name for name, row in METHODS.items() if feature not in row.unsupported]
            raise InvalidInput(
                f"{option}: method {problem.method} takes no {feature.noun};"
                f" methods that do: {', '.join(able)}"
            )
    return problem


def _solve(
    beams: list[Beam],
    problem: Problem,
    start: float,
    extra_modes: int = 0,
    mesh_of: Sequence[Beam] = (),
) -> list[Solution | BeamvizError]:
    """By the package of the method; those that `auto` does not need are imported when used."""
    if problem.state != "straight" or any(map(attrgetter("spin_up"), beams)):
        from beamviz.solver.states import solve_states

        return solve_states(_solve, beams, problem, start, extra_modes)
    package = METHODS[problem.method].package
    interruption.get()()
    if package == "hp":
        return solve_hp(beams, problem, start, extra_modes, mesh_of)
    if package == "fem":
        from beamviz.solver.fem import solve as solve_one
    else:
        from beamviz.solver.series import solve as solve_one
    more = replace(problem, modes=problem.modes + extra_modes)
    answers: list[Solution | BeamvizError] = []
    for beam in beams:
        interruption.get()()
        try:
            answers.append(solve_one(beam, more, start))
        except (NoEquilibrium, NotConverged) as error:
            answers.append(error)
    return answers
