"""Public entry point: validates the options and dispatches to the chosen method and state."""

import time
from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import lru_cache
from importlib import import_module
from operator import attrgetter
from typing import Any

import numpy as np

from beamviz.beam import Beam, check_choice, check_float, check_int
from beamviz.errors import BeamvizError, InvalidInput, NoEquilibrium, NotConverged, unknown_keyword
from beamviz.solver.families import gauss, quadrature  # noqa: F401
from beamviz.solver.hp import displacements, solve_hp  # noqa: F401
from beamviz.solver.hp.mesh import interpolation_matrix  # noqa: F401
from beamviz.solver.problem import CHOICES, FEATURES, METHODS, OPTIONS, Problem, interruption
from beamviz.solver.solution import Solution

Answer = Solution | BeamvizError
MAX_MODES = 20
TOLERANCES = (1e-12, 0.1)  # least and greatest relative error that may be asked for
METHODS_WITH_BENT_STATES = ("auto", "ancf-planar")
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

    modes: 1 to 20. method: a name in METHODS. strain: "green", "biot" or "hencky". curvature:
    "spatial" or "material". plane: "chordwise" (of rotation) or "flapwise". tolerance: relative
    error of each frequency, 1e-12 to 0.1, that `auto`, `foac` and `zoac` refine to.
    elements: number of elements of `ancf`, `ancf-planar` and `linear`; None: 20, as in the paper.
    terms: number of basis functions of `assumed-modes` or of powers of `power-series`, or the order
    of `chebyshev`. coriolis: whether Coriolis forces couple stretching and chordwise bending; they
    do not act flapwise. stiffening, softening: False leaves out the stiffening of bending by the
    tension, or the softening of motion in the plane of rotation by the centrifugal force.
    state: "straight", returned with status "unstable" where it is not stable; "bent": the stable
    bent state of lowest energy; "stable": the straight state where it is stable, else the bent one.
    A beam with a spin-up has no straight state.
    Raises InvalidInput, NoEquilibrium (with .limit) and NotConverged.
    """
    options = dict(locals())
    del options["beam"]
    (answer,) = _solve([beam], parse_keywords(**options.pop("unknown"), **options))
    if isinstance(answer, BeamvizError):
        raise answer
    return answer


def solve_many(
    beams: Iterable[Beam],
    extra_modes: int = 0,
    **options: Any,
) -> list[Answer]:
    """`solve` for many beams with the same options, in batches where the method allows it.

    Returns a Solution for each beam, or its error: NoEquilibrium or NotConverged.
    extra_modes: number of modes beyond those asked for, 0 to 20, whose errors may exceed the
    tolerance.
    Raises InvalidInput for wrong options.
    """
    problem = parse_keywords(**options)
    extra_modes = check_int("extra_modes", extra_modes, 0, MAX_MODES)
    return _solve(list(beams), problem, extra_modes)


def __getattr__(name: str) -> Any:
    """The functions of `bent` for other stable states and for limit points, on first use."""
    if name in ("other_stable_states", "end_of_bent_state"):
        return getattr(import_module("beamviz.solver.bent"), name)
    raise AttributeError(f"module 'beamviz.solver' has no attribute {name!r}")


def parse_keywords(**options: Any) -> Problem:
    """The problem with these options by name, the others by default; raises InvalidInput. Valid
    combinations are cached: a slider or a sweep repeats them."""
    values = DEFAULTS | options
    for name in list(values)[len(DEFAULTS) :]:
        raise unknown_keyword("option", name, OPTIONS)
    try:
        return _validated(*values.values())
    except TypeError:  # an unhashable option
        return _validated.__wrapped__(*values.values())


@lru_cache(maxsize=256, typed=True)
def _validated(*options: Any) -> Problem:
    """The problem, its numbers converted to Python types; raises InvalidInput."""
    values = dict(zip(OPTIONS, options, strict=True))
    for name, known in CHOICES.items():
        check_choice(name, values[name], known)
    for name in ("coriolis", "stiffening", "softening"):
        if not isinstance(values[name], bool | np.bool_):
            raise InvalidInput(f"{name} = {values[name]!r}: must be True or False")
        values[name] = bool(values[name])
    values["modes"] = check_int("modes", values["modes"], 1, MAX_MODES)
    values["tolerance"] = check_float("tolerance", values["tolerance"], *TOLERANCES)
    problem = Problem(**values)
    for option in METHODS[problem.method].unsupported:
        given = values[option]
        if given != DEFAULTS[option] and (option != "coriolis" or problem.gyroscopic):
            able = [name for name, row in METHODS.items() if option not in row.unsupported]
            raise InvalidInput(
                f"{option} = {given!r}: method {problem.method} takes no {FEATURES[option]};"
                f" methods that do: {', '.join(able)}"
            )
    return problem


def _solve(beams: list[Beam], problem: Problem, extra_modes: int = 0) -> list[Answer]:
    """Dispatch to the method; those other than `hp` are imported on first use."""
    start, package = time.perf_counter(), METHODS[problem.method].package
    answers: list[Answer]
    if problem.state != "straight" or any(map(attrgetter("spin_up"), beams)):
        answers = _solve_states(beams, problem, extra_modes)
    elif package == "hp":
        interruption.get()()
        answers = solve_hp(beams, problem, extra_modes)
    else:
        module, function = package.split(".")
        solve_one = getattr(import_module(f"beamviz.solver.{module}"), function)
        more = replace(problem, modes=problem.modes + extra_modes)
        answers = [_attempt(solve_one, beam, more) for beam in beams]
    seconds = time.perf_counter() - start
    for answer in answers:
        if isinstance(answer, Solution):
            answer.stats.seconds = seconds
    return answers


def _attempt(solve_one: Callable[..., Solution], *arguments: Any) -> Answer:
    """What a solver of one beam returns, or NoEquilibrium or NotConverged in its place."""
    interruption.get()()
    try:
        return solve_one(*arguments)
    except (NoEquilibrium, NotConverged) as error:
        return error


def _solve_states(beams: list[Beam], problem: Problem, extra_modes: int) -> list[Answer]:
    """The straight state of each beam where "stable" is asked for and it is, else a bent state;
    each bent state is the first guess for the next beam."""
    for beam in beams:
        _check_state(beam, problem)
    straight: dict[int, Answer] = {}
    if problem.state == "stable":
        where = [k for k, beam in enumerate(beams) if not beam.spin_up]
        first = replace(problem, state="straight")
        found = _solve([beams[k] for k in where], first, extra_modes)
        straight = dict(zip(where, found, strict=True))
    answers: list[Answer] = []
    near: Any = None  # the last bent state
    for k, beam in enumerate(beams):
        answer = straight.get(k)
        if isinstance(answer, Solution) and answer.equilibrium.stable:
            answers.append(replace(answer, problem=problem))
            continue
        from beamviz.solver.bent import solve_by_method

        answer = _attempt(solve_by_method, beam, problem, near, extra_modes)
        near = answer.equilibrium.bent_state if isinstance(answer, Solution) else None
        answers.append(answer)
    return answers


def _check_state(beam: Beam, problem: Problem) -> None:
    """InvalidInput where the other options exclude the state or the spin-up asked for."""
    requested = f"spin_up = {beam.spin_up:g}" if beam.spin_up else f"state = {problem.state!r}"
    if beam.spin_up and problem.state == "straight":
        reason = "there is no straight state; use state = 'bent' or 'stable'"
    elif problem.method not in METHODS_WITH_BENT_STATES:
        able = " or ".join(METHODS_WITH_BENT_STATES)
        reason = f"method {problem.method} has no bent states; use {able}"
    elif not (problem.stiffening and problem.softening):
        reason = "stiffening and softening cannot be switched off"
    elif beam.spin_up and not problem.chordwise:
        reason = "bends the beam in the plane of rotation; use chordwise"
    else:
        return
    raise InvalidInput(f"{requested}: {reason}")
