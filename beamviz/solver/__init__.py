"""solve(beam, ...): the one door to every method."""

import time
from collections.abc import Collection, Iterable
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from beamviz.beam import Beam, checked, whole
from beamviz.errors import BeamvizError, InvalidInput, NoEquilibrium, NotConverged
from beamviz.solver.constitutive import CURVATURES, STRAIN_LAWS
from beamviz.solver.hp.batch import solve_straight_many
from beamviz.solver.hp.fields import as_solution
from beamviz.solver.hp.fields import displacements as displacements
from beamviz.solver.hp.refinement import StraightModes
from beamviz.solver.methods import METHODS, check
from beamviz.solver.physics import Physics
from beamviz.solver.problem import TOLERANCE, Task
from beamviz.solver.solution import Model, Solution

PLANES = ("chordwise", "flapwise")
MAX_MODES = 20
TOLERANCES = (1e-12, 0.1)
CHOICES: dict[str, Collection[str]] = {
    "method": METHODS,
    "strain": STRAIN_LAWS,
    "curvature": CURVATURES,
    "plane": PLANES,
}


class Options(NamedTuple):
    """The keywords of `solve`, as they were given; `solve` has their defaults."""

    modes: int
    method: str
    strain: str
    curvature: str
    coriolis: bool
    plane: str
    tolerance: float
    elements: int | None
    terms: int | None
    stiffening: bool
    softening: bool


def solve(
    beam: Beam,
    modes: int = 5,
    method: str = "auto",
    strain: str = "green",
    curvature: str = "spatial",
    coriolis: bool = False,
    plane: str = "chordwise",
    tolerance: float = TOLERANCE,
    elements: int | None = None,
    terms: int | None = None,
    stiffening: bool = True,
    softening: bool = True,
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
    numbers = (tolerance, elements, terms)
    options = Options(
        modes, method, strain, curvature, coriolis, plane, *numbers, stiffening, softening
    )
    return _attempt(_task(beam, start, options))


DEFAULTS = Options(*(solve.__defaults__ or ()))


def solve_many(
    beams: Iterable[Beam], beside: int = 0, **options: Any
) -> list[Solution | BeamvizError]:
    """`solve` for many beams with the same options, together where the method can.

    beside: so many modes more, which need not meet the tolerance: their errors say how well the
    mesh of the others resolves them. The place of a beam without an answer (no equilibrium, not
    converged) holds its error. Raises InvalidInput for wrong options.
    """
    start = time.perf_counter()
    beams = list(beams)
    task = _task(Beam(), start, DEFAULTS._replace(**options))
    beside = whole("beside", beside, 0, MAX_MODES)
    check(task)
    together: list[StraightModes | None] = [None] * len(beams)
    if task.model.method == "auto":
        together = solve_straight_many(beams, task.modes, beside, task.physics, task.tolerance)
    task = task._replace(modes=task.modes + beside)
    return [
        _answer(task._replace(beam=beam), found)
        for beam, found in zip(beams, together, strict=True)
    ]


def _task(beam: Beam, start: float, options: Options) -> Task:
    """What the options ask for; InvalidInput where one is wrong."""
    try:
        meaning = _meaning(*options)
    except TypeError:  # one is a list, say: nothing to remember it by
        meaning = _meaning.__wrapped__(*options)
    return Task(beam, *meaning, start)


@lru_cache(maxsize=256, typed=True)
def _meaning(
    modes: int,
    method: str,
    strain: str,
    curvature: str,
    coriolis: bool,
    plane: str,
    tolerance: float,
    elements: int | None,
    terms: int | None,
    stiffening: bool,
    softening: bool,
) -> tuple[Model, Physics, int, float, int | None, int | None]:
    """The options in the terms of mechanics: a slider asks for the same ones again and again."""
    given: dict[str, object] = {
        "method": method,
        "strain": strain,
        "curvature": curvature,
        "plane": plane,
    }
    for name, value in given.items():
        if not isinstance(value, str) or value not in CHOICES[name]:
            raise InvalidInput(f"{name} = {value!r}: must be one of {', '.join(CHOICES[name])}")
    switches = {"coriolis": coriolis, "stiffening": stiffening, "softening": softening}
    for name, switch in switches.items():
        if not isinstance(switch, bool | np.bool_):
            raise InvalidInput(f"{name} = {switch!r}: must be True or False")
    modes = whole("modes", modes, 1, MAX_MODES)
    tolerance = checked("tolerance", tolerance, *TOLERANCES)
    model = Model(
        method, strain, curvature, bool(coriolis), plane, bool(stiffening), bool(softening)
    )
    law, measure = STRAIN_LAWS[strain], CURVATURES[curvature]
    physics = Physics(
        law,
        measure,
        plane == "chordwise",
        model.coriolis,
        stiffening=model.stiffening,
        softening=model.softening,
    )
    return model, physics, modes, tolerance, elements, terms


def _attempt(task: Task) -> Solution:
    check(task)
    return METHODS[task.model.method].solve(task)


def _answer(task: Task, found: StraightModes | None) -> Solution | BeamvizError:
    """The solution of a task whose modes may have been found already, or why there is none."""
    if found is not None:
        return as_solution(task, found)
    try:
        return _attempt(task)
    except (NoEquilibrium, NotConverged) as error:
        return error
