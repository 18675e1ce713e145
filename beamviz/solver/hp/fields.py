"""Solutions of the default discretisation: `auto`, and the models with a rigid tension."""

import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from beamviz.beam import Beam
from beamviz.solver.hp.mesh import each_from_clamp
from beamviz.solver.hp.refinement import StraightModes, solve_straight
from beamviz.solver.problem import Problem
from beamviz.solver.solution import Equilibrium, Solution, Stats


def hp_solution(beam: Beam, problem: Problem, start: float) -> Solution:
    """The straight beam on as few unknowns as the tolerance asks for."""
    found = solve_straight(beam, problem.modes, problem, problem.tolerance)
    return as_solution(beam, problem, found, start)


def as_solution(beam: Beam, problem: Problem, found: StraightModes, start: float) -> Solution:
    """What was found on a mesh, as functions of x."""
    grid = found.grid
    return Solution(
        beam=beam,
        problem=problem,
        equilibrium=Equilibrium(
            bool(found.omega_squared[0] >= 0), found.iterations, partial(_axial, found)
        ),
        stats=Stats(
            2 * len(found.f),
            time.perf_counter() - start,
            "hp",
            grid.elements,
            max(grid.orders),
        ),
        omega_squared=found.omega_squared,
        estimate_errors=partial(np.add, found.truncation, found.rounding),
        bending_energy_fraction=found.bending_energy_fraction,
        fields=Fields(found),
    )


def _axial(found: StraightModes, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """u(x) and f(x) of the equilibrium."""
    return found.grid.from_clamp(x) @ found.f, found.grid.at(x) @ found.f


@dataclass(frozen=True, eq=False)
class Fields:
    """The modes found on a mesh as functions of x."""

    found: StraightModes

    def __call__(self, x: np.ndarray) -> np.ndarray:
        """Fields (len(x), 2, modes) along and across the beam."""
        found = self.found
        rows = found.grid.from_clamp(x)
        return _fields(rows, found.grid.J, found.f, found.kappa, found.s, found.picks)


def displacements(solutions: Sequence[Solution], x: np.ndarray) -> np.ndarray:
    """`displacement(x)` of solutions with equally many modes, (solutions, len(x), 2, modes), at
    places x (solutions, len(x)) of their own; of those on one mesh, or on alike ones, at once."""
    groups: dict[object, list[int]] = {}
    for k, solution in enumerate(solutions):
        fields = solution.fields
        key: object = k
        if isinstance(fields, Fields):
            key = fields.found.grid.orders, fields.found.picks is None
        groups.setdefault(key, []).append(k)
    places = np.concatenate(list(groups.values()))
    found = [_alike([solutions[k].fields for k in group], x[group]) for group in groups.values()]
    return np.concatenate(found)[places.argsort()]


def _alike(each: list[Any], x: np.ndarray) -> np.ndarray:
    """Fields (several, len(x), 2, modes) of modes found on meshes of the same orders, or of one
    solution of any kind."""
    found = [fields.found for fields in each if isinstance(fields, Fields)]
    if len(each) == 1 or not found:
        return np.array([fields(at) for fields, at in zip(each, x, strict=True)])
    grid = found[0].grid
    if all(one.grid is grid for one in found) and (x == x[0]).all():
        rows, J = grid.from_clamp(x[0]), grid.J
    else:
        rows = each_from_clamp([one.grid for one in found], x)
        J = np.array([one.grid.J for one in found])
    f, kappa, s = (np.array([getattr(one, name) for one in found]) for name in ("f", "kappa", "s"))
    picks = [one.picks for one in found if one.picks is not None]
    return _fields(rows, J, f, kappa, s, np.array(picks) if picks else None)


def _fields(
    from_clamp: np.ndarray,
    J: np.ndarray,
    f: np.ndarray,
    kappa: np.ndarray,
    s: np.ndarray,
    picks: np.ndarray | None,
) -> np.ndarray:
    """Fields (..., len(x), 2, modes): u = int s along the beam, w = int f theta across it."""
    if picks is not None:
        modes = s.shape[-1]
        bending, place = picks[..., None, :] < modes, picks[..., None, :] % modes
        kappa = np.where(bending, np.take_along_axis(kappa, place, axis=-1), 0.0)
        s = np.where(bending, 0.0, np.take_along_axis(s, place, axis=-1))
    # In memory x runs fastest: what samples many solutions reads all of one mode in a row.
    fields = np.empty((*s.shape[:-2], s.shape[-1], 2, from_clamp.shape[-2]), s.dtype)
    fields[..., 0, :] = s.mT @ from_clamp.mT
    fields[..., 1, :] = (f[..., None] * (J @ kappa)).mT @ from_clamp.mT
    return np.swapaxes(fields, -3, -1)
