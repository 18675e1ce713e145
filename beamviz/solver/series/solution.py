"""Solutions of the methods whose resolution is a number of terms."""

import time
from functools import partial

import numpy as np

from beamviz.beam import Beam, check_int
from beamviz.errors import InvalidInput
from beamviz.solver.hp.refinement import errors_against_reference
from beamviz.solver.problem import Problem
from beamviz.solver.series.assumed_modes import assumed_modes
from beamviz.solver.series.chebyshev import axial, chebyshev_modes
from beamviz.solver.series.families import Modes
from beamviz.solver.series.power_series import power_series_modes
from beamviz.solver.solution import Axial, Equilibrium, Solution, Stats

ASSUMED, MAX_ASSUMED = 10, 100  # basis functions: cosh overflows soon after
ORDER, MAX_ORDER = 32, 200
POWERS, MIN_POWERS, MAX_POWERS = 80, 6, 1000


def solve(beam: Beam, problem: Problem, start: float) -> Solution:
    """The modes of a beam with `problem.terms` terms; `start` is the clock (time.perf_counter) at
    the call."""
    return SOLVERS[problem.method](beam, problem, start)


def _assumed_modes(beam: Beam, problem: Problem, start: float) -> Solution:
    """`terms` functions across the beam and as many along it."""
    terms = check_int("terms", ASSUMED if problem.terms is None else problem.terms, 1, MAX_ASSUMED)
    if problem.modes > terms:
        raise InvalidInput(f"modes = {problem.modes}: at most {terms} with terms = {terms}")
    found = assumed_modes(beam, problem, terms, problem.modes)
    return _solution(beam, problem, start, found, terms, 2 * terms)


def _power_series(beam: Beam, problem: Problem, start: float) -> Solution:
    """`terms` powers of x on each part of the beam."""
    terms = POWERS if problem.terms is None else problem.terms
    terms = check_int("terms", terms, MIN_POWERS, MAX_POWERS)
    found = power_series_modes(beam, problem, terms, problem.modes)
    return _solution(beam, problem, start, found, terms, 2)


def _chebyshev(beam: Beam, problem: Problem, start: float) -> Solution:
    """Polynomials of order `terms` on each part of the beam."""
    order = check_int("terms", ORDER if problem.terms is None else problem.terms, 2, MAX_ORDER)
    if problem.modes > order:
        raise InvalidInput(f"modes = {problem.modes}: at most {order} with terms = {order}")
    found, on, state = chebyshev_modes(beam, problem, order, problem.modes)
    about = partial(axial, on, state.f)
    return _solution(
        beam, problem, start, found, order, 2 * len(on.points), about, state.iterations
    )


SOLVERS = {
    "assumed-modes": _assumed_modes,
    "power-series": _power_series,
    "chebyshev": _chebyshev,
}


def unstretched(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """u(x) and f(x) of the beam at its reference length."""
    return x, np.ones_like(x)


def _solution(
    beam: Beam,
    problem: Problem,
    start: float,
    found: Modes,
    terms: int,
    dof: int,
    about: Axial = unstretched,
    iterations: int = 0,
) -> Solution:
    """The modes as a Solution; its errors are differences from the default method."""
    return Solution(
        beam=beam,
        problem=problem,
        equilibrium=Equilibrium(found.omega_squared[0] >= 0, iterations, about),
        stats=Stats(dof, time.perf_counter() - start, problem.method, 1, terms),
        omega_squared=found.omega_squared,
        estimate_errors=partial(
            errors_against_reference,
            beam,
            problem,
            found.omega_squared,
            found.bending_energy_fraction,
        ),
        bending_energy_fraction=found.bending_energy_fraction,
        fields=found.displacement,
    )
