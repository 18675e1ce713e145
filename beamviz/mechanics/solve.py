"""solve(beam, ...): the one door to every method."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from beamviz.beam import Beam, checked
from beamviz.errors import InvalidInput
from beamviz.mechanics.adaptive import Physics, StraightModes, solve_straight
from beamviz.mechanics.solution import Equilibrium, Model, Solution, Stats
from beamviz.mechanics.strain import CURVATURES, STRAIN_LAWS

PLANES = ("chordwise", "flapwise")
MAX_MODES = 40
TOLERANCES = (1e-12, 0.1)


@dataclass(frozen=True)
class Method:
    """A way to solve: its name, where it comes from, and when to choose it."""

    name: str
    source: str
    choose: str
    solve: Callable[[Beam, Model, int, float, int | None, float], Solution]


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
    elements of `ancf` (20, the paper's, when not given). Unstable states are returned, with
    status "unstable". Raises InvalidInput, NoEquilibrium (with .limit) and NotConverged.
    """
    start = time.perf_counter()
    row = METHODS.get(method)
    if (
        row is None
        or strain not in STRAIN_LAWS
        or curvature not in CURVATURES
        or plane not in PLANES
    ):
        _refuse_unknown(method=method, strain=strain, curvature=curvature, plane=plane)
    if type(modes) is not int or not 1 <= modes <= MAX_MODES:
        raise InvalidInput(f"modes = {modes}: must be a whole number in 1 .. {MAX_MODES}")
    tolerance = checked("tolerance", tolerance, *TOLERANCES)
    model = Model(method, strain, curvature, bool(coriolis), plane)
    return row.solve(beam, model, modes, tolerance, elements, start)


def _refuse_unknown(**chosen: str) -> None:
    """InvalidInput for the first choice that is not on its list."""
    known = {"method": METHODS, "strain": STRAIN_LAWS, "curvature": CURVATURES, "plane": PLANES}
    for name, value in chosen.items():
        if value not in known[name]:
            raise InvalidInput(f"{name} = {value!r}: must be one of {', '.join(known[name])}")


def _auto(beam, model, modes, tolerance, elements, start) -> Solution:
    """The straight scene on as few unknowns as the tolerance asks for."""
    if elements is not None:
        raise InvalidInput(f"elements = {elements}: is for method ancf; auto chooses its own")
    found = solve_straight(beam, modes, physics(model), tolerance)
    mesh = found.mesh
    return Solution(
        beam=beam,
        model=model,
        equilibrium=Equilibrium(_status(found.squares), found.iterations, _axial(found)),
        stats=Stats(
            2 * len(found.f), time.perf_counter() - start, "hp", mesh.elements, mesh.order
        ),
        squares=found.squares,
        square_errors=found.truncation + found.rounding,
        bending_fractions=found.bending_fractions,
        displacement=_displacement(found),
    )


def physics(model: Model) -> Physics:
    """The laws a model names."""
    return Physics(
        STRAIN_LAWS[model.strain],
        CURVATURES[model.curvature],
        model.plane == "chordwise",
        model.coriolis,
    )


def _status(squares: np.ndarray) -> Literal["stable", "unstable"]:
    return "stable" if squares[0] >= 0 else "unstable"


def _axial(found: StraightModes) -> Callable:
    """u(x) and f(x) of the equilibrium."""

    def axial(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return found.mesh.from_clamp(x) @ found.f, found.mesh.at(x) @ found.f

    return axial


def _displacement(found: StraightModes) -> Callable:
    """Fields (len(x), 2, modes): u = int s along the beam, w = int f theta across it."""

    def displacement(x: np.ndarray) -> np.ndarray:
        rows, modes = found.mesh.from_clamp(x), len(found.squares)
        u = rows @ found.s
        w = rows @ (found.f[:, None] * (found.mesh.J @ found.kappa))
        if found.picks is None:
            return np.stack((u, 1j * w), axis=1)
        fields = np.zeros((len(x), 2, 2 * modes))
        fields[:, 1, :modes], fields[:, 0, modes:] = w, u
        return fields[:, :, found.picks]

    return displacement


METHODS = {
    row.name: row
    for row in (
        Method(
            "auto",
            "this program: p-version in gradient and curvature, split at the mass",
            "always, unless you study another method: fastest to any accuracy",
            _auto,
        ),
    )
}
