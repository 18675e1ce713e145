"""Public entry point: validates the options and dispatches to the chosen method."""

import time
from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from beamviz.beam import Beam, check_int
from beamviz.errors import BeamvizError, NoEquilibrium, NotConverged
from beamviz.solver.hp import displacements as displacements
from beamviz.solver.hp import solve_hp
from beamviz.solver.problem import CHOICES as CHOICES
from beamviz.solver.problem import MAX_MODES, METHODS, Problem, parse_options
from beamviz.solver.problem import OPTIONS as OPTIONS
from beamviz.solver.problem import PLANES as PLANES
from beamviz.solver.solution import Solution


DEFAULTS = vars(Problem()).copy()


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
    **unknown: Any,
) -> Solution:
    """Equilibrium and the lowest `modes` modes of a beam.

    tolerance: relative error of each frequency that `auto` refines to. elements: number of
    elements of `ancf` (20, the paper's, when not given). terms: of the series of `assumed-modes`
    (basis functions), `power-series` (powers) and `chebyshev` (order). Coriolis forces act in the
    chordwise plane only. stiffening, softening: whether the tension stiffens bending, and whether
    the centrifugal force, growing outwards, softens motion in the plane of rotation: switched off
    to see what each term does. Unstable states are returned, with status "unstable".
    Raises InvalidInput, NoEquilibrium (with .limit) and NotConverged.
    """
    start = time.perf_counter()
    problem = parse_options(
        {
            "modes": modes,
            "method": method,
            "strain": strain,
            "curvature": curvature,
            "coriolis": coriolis,
            "plane": plane,
            "tolerance": tolerance,
            "elements": elements,
            "terms": terms,
            "stiffening": stiffening,
            "softening": softening,
            **unknown,
        }
    )
    answer = _solve([beam], problem, start)[0]
    if isinstance(answer, BeamvizError):
        raise answer
    return answer


def solve_many(
    beams: Iterable[Beam], extra_modes: int = 0, **options: Any
) -> list[Solution | BeamvizError]:
    """`solve` for many beams with the same options, in batches where the method can.

    extra_modes: number of modes beyond those asked for, which need not meet the tolerance: their
    errors say how well the mesh of the others resolves them. The place of a beam without an answer
    holds its error: NoEquilibrium or NotConverged. Raises InvalidInput for wrong options.
    """
    start = time.perf_counter()
    beams = list(beams)
    problem = parse_options({**DEFAULTS, **options})
    extra_modes = check_int("extra_modes", extra_modes, 0, MAX_MODES)
    return _solve(beams, problem, start, extra_modes)


def _solve(
    beams: list[Beam], problem: Problem, start: float, extra_modes: int = 0
) -> list[Solution | BeamvizError]:
    """By the package of the method; those that `auto` does not need are imported when used."""
    package = METHODS[problem.method].package
    if package == "hp":
        return solve_hp(beams, problem, start, extra_modes)
    if package == "fem":
        from beamviz.solver.fem import solve as solve_one
    else:
        from beamviz.solver.series import solve as solve_one
    more = replace(problem, modes=problem.modes + extra_modes)
    answers: list[Solution | BeamvizError] = []
    for beam in beams:
        try:
            answers.append(solve_one(beam, more, start))
        except (NoEquilibrium, NotConverged) as error:
            answers.append(error)
    return answers
