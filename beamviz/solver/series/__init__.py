"""Methods whose resolution is a number of terms: assumed modes, power series, Chebyshev."""

from collections.abc import Callable
from typing import NamedTuple

from beamviz.beam import Beam, check_int
from beamviz.errors import InvalidInput
from beamviz.solver.families import Solved, build_solution
from beamviz.solver.problem import Problem
from beamviz.solver.series.assumed_modes import solve_assumed_modes
from beamviz.solver.series.chebyshev import solve_chebyshev
from beamviz.solver.series.power_series import solve_power_series
from beamviz.solver.solution import Solution


class Series(NamedTuple):
    """A method: its solver (beam, problem, number of terms), the default number of terms, its
    limits, and whether it limits the number of modes (not of a power series, which seeks roots)."""

    solve: Callable[[Beam, Problem, int], Solved]
    default: int
    least: int
    most: int
    limit_modes: bool = True


SERIES = {
    "assumed-modes": Series(solve_assumed_modes, 10, 1, 100),  # cosh overflows soon after
    "power-series": Series(solve_power_series, 80, 6, 1000, limit_modes=False),
    "chebyshev": Series(solve_chebyshev, 32, 2, 200),
}


def solve(beam: Beam, problem: Problem, start: float) -> Solution:
    """Equilibrium and modes with `problem.terms` terms, or an error of `beamviz.solve`. start: the
    clock at the call."""
    method = SERIES[problem.method]
    terms = method.default if problem.terms is None else problem.terms
    terms = check_int("terms", terms, method.least, method.most)
    if method.limit_modes and problem.modes > terms:
        raise InvalidInput(
            f"modes = {problem.modes}: at most {terms} with terms = {terms};"
            " ask for more terms or fewer modes"
        )
    solved = method.solve(beam, problem, terms)
    return build_solution(beam, problem, start, solved, order=terms)
