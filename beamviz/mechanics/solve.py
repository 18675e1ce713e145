"""solve(beam, ...): the one door to every method."""

import time
from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal, NamedTuple

import numpy as np

from beamviz.beam import Beam, checked, whole
from beamviz.errors import BeamvizError, InvalidInput, NoEquilibrium, NotConverged
from beamviz.mechanics import elements as cubic_elements
from beamviz.mechanics.adaptive import (
    Physics,
    StraightModes,
    Tension,
    solve_straight,
    solve_straight_many,
)
from beamviz.mechanics.solution import Equilibrium, Model, Solution, Stats
from beamviz.mechanics.strain import CURVATURES, STRAIN_LAWS

PLANES = ("chordwise", "flapwise")
MAX_MODES = 20
TOLERANCES = (1e-12, 0.1)


class Task(NamedTuple):
    """What is asked of a method."""

    beam: Beam
    model: Model
    physics: Physics
    modes: int
    tolerance: float
    elements: int | None
    start: float  # clock at the call


@dataclass(frozen=True)
class Method:
    """A way to solve: its name, where it comes from, and when to choose it."""

    name: str
    source: str
    choose: str
    solve: Callable[[Task], Solution]


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
) -> Solution:
    """Equilibrium and the lowest `modes` modes of a beam.

    tolerance: relative error of each frequency that `auto` refines to. elements: number of
    elements of `ancf` (20, the paper's, when not given). Coriolis forces act in the chordwise
    plane only. Unstable states are returned, with status "unstable".
    Raises InvalidInput, NoEquilibrium (with .limit) and NotConverged.
    """
    start = time.perf_counter()
    task = _task(
        beam, start, modes, method, strain, curvature, coriolis, plane, tolerance, elements
    )
    return METHODS[method].solve(task)


def _task(
    beam: Beam,
    start: float,
    modes: int = 5,
    method: str = "auto",
    strain: str = "green",
    curvature: str = "spatial",
    coriolis: bool = False,
    plane: str = "chordwise",
    tolerance: float = 1e-6,
    elements: int | None = None,
) -> Task:
    """The task that the options of `solve` name; InvalidInput where one is wrong."""
    choices: dict[str, object] = {
        "method": method,
        "strain": strain,
        "curvature": curvature,
        "plane": plane,
    }
    for name, value in choices.items():
        if not isinstance(value, str) or value not in CHOICES[name]:
            raise InvalidInput(f"{name} = {value!r}: must be one of {', '.join(CHOICES[name])}")
    if not isinstance(coriolis, bool | np.bool_):
        raise InvalidInput(f"coriolis = {coriolis!r}: must be True or False")
    modes = whole("modes", modes, 1, MAX_MODES)
    tolerance = checked("tolerance", tolerance, *TOLERANCES)
    model = Model(method, strain, curvature, bool(coriolis), plane)
    physics = Physics(
        STRAIN_LAWS[strain], CURVATURES[curvature], plane == "chordwise", model.coriolis
    )
    return Task(beam, model, physics, modes, tolerance, elements, start)


def solve_many(beams: Iterable[Beam], **options: Any) -> list[Solution | BeamvizError]:
    """`solve` for many beams with the same options, together where the method can.

    The place of a beam without an answer (no equilibrium, not converged) holds its error.
    Raises InvalidInput for wrong options.
    """
    start = time.perf_counter()
    beams = list(beams)
    template = _task(Beam(), start, **options)
    tasks = [template._replace(beam=beam) for beam in beams]
    together: list[StraightModes | None] = [None] * len(beams)
    if template.model.method == "auto" and template.elements is None:
        together = solve_straight_many(beams, template.modes, template.physics, template.tolerance)
    return [
        _attempt(task) if found is None else _straight_solution(task, found)
        for task, found in zip(tasks, together, strict=True)
    ]


def _rigid(tension: Tension, task: Task) -> Solution:
    """As `auto`, about the beam at its reference length."""
    return _auto(task._replace(physics=task.physics._replace(tension=tension)))


def _attempt(task: Task) -> Solution | BeamvizError:
    try:
        return METHODS[task.model.method].solve(task)
    except (NoEquilibrium, NotConverged) as error:
        return error


def _auto(task: Task) -> Solution:
    """The straight scene on as few unknowns as the tolerance asks for."""
    if task.elements is not None:
        raise InvalidInput(
            f"elements = {task.elements}: is for finite elements;"
            f" {task.model.method} chooses its own"
        )
    return _straight_solution(
        task, solve_straight(task.beam, task.modes, task.physics, task.tolerance)
    )


def _straight_solution(task: Task, found: StraightModes) -> Solution:
    mesh = found.mesh
    return Solution(
        beam=task.beam,
        model=task.model,
        equilibrium=Equilibrium(
            _status(found.squares), found.iterations, partial(_straight_axial, found)
        ),
        stats=Stats(2 * len(found.f), _since(task), "hp", mesh.elements, max(mesh.orders)),
        squares=found.squares,
        square_errors=found.truncation + found.rounding,
        bending_fractions=found.bending_fractions,
        displacement=partial(_straight_displacement, found),
    )


def _straight_axial(found: StraightModes, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """u(x) and f(x) of the equilibrium."""
    return found.mesh.from_clamp(x) @ found.f, found.mesh.at(x) @ found.f


def _straight_displacement(found: StraightModes, x: np.ndarray) -> np.ndarray:
    """Fields (len(x), 2, modes): u = int s along the beam, w = int f theta across it."""
    rows, modes = found.mesh.from_clamp(x), len(found.squares)
    u = rows @ found.s
    w = rows @ (found.f[:, None] * (found.mesh.J @ found.kappa))
    if found.picks is None:
        return np.stack((u, w), axis=1)
    fields = np.zeros((len(x), 2, 2 * modes))
    fields[:, 1, :modes], fields[:, 0, modes:] = w, u
    return fields[:, :, found.picks]


def _cubic(
    assemble: cubic_elements.Assemble, task: Task, tension: Tension = "equilibrium"
) -> Solution:
    """Uniform cubic elements."""
    physics = task.physics._replace(tension=tension)
    found = cubic_elements.solve_elements(task.beam, task.modes, physics, assemble, task.elements)
    count = len(found.assembled.nodes) - 1
    dof = len(found.assembled.Ka) + len(found.assembled.Kb)
    return Solution(
        beam=task.beam,
        model=task.model,
        equilibrium=Equilibrium(
            _status(found.squares),
            found.assembled.iterations,
            partial(cubic_elements.axial, found),
        ),
        stats=Stats(dof, _since(task), task.model.method, count, 3),
        squares=found.squares,
        square_errors=found.square_errors,
        bending_fractions=found.bending_fractions,
        displacement=partial(cubic_elements.displacement, found),
    )


def _status(squares: np.ndarray) -> Literal["stable", "unstable"]:
    return "stable" if squares[0] >= 0 else "unstable"


def _since(task: Task) -> float:
    return time.perf_counter() - task.start


METHODS = {
    row.name: row
    for row in (
        Method(
            "auto",
            "this program: high-order elements in gradient and curvature, split at the mass",
            "always, unless another method is what you study: fastest to any accuracy",
            _auto,
        ),
        Method(
            "ancf",
            "the paper's cubic elements (2017), stretching and bending solved apart",
            "to see the paper's own numbers; 20 elements are the paper's",
            partial(_cubic, cubic_elements.split),
        ),
        Method(
            "ancf-planar",
            "the paper's cubic elements through the full planar tangent (eqs. 40-48)",
            "to check ancf: the same answer with all unknowns at once",
            partial(_cubic, cubic_elements.full),
        ),
        Method(
            "linear",
            "linear finite elements with prestress and spin softening, as general codes do it",
            "to see what a linear prestressed analysis says; its limit is foac's",
            partial(_cubic, cubic_elements.linear, tension="reference"),
        ),
        Method(
            "foac",
            "first-order coupling: tension of the rigid reference length (Hong et al.; Yoo & Shin)",
            "to see the classical model of slender rotating beams, right while f is near 1",
            partial(_rigid, "reference"),
        ),
        Method(
            "zoac",
            "no coupling: the linear model without stiffening, the paradox of Kane et al. (1987)",
            "to see it fail: it falsely loses stability at gamma = 3.516",
            partial(_rigid, "none"),
        ),
    )
}
CHOICES: dict[str, Collection[str]] = {
    "method": METHODS,
    "strain": STRAIN_LAWS,
    "curvature": CURVATURES,
    "plane": PLANES,
}
