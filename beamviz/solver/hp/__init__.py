"""The default method: high-order elements in gradient and curvature, split at the mass.

The entry point is `solve_hp`; Solutions and functions of x are built here from values on a mesh.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from typing import Any

import numpy as np

from beamviz.beam import Beam
from beamviz.errors import BeamvizError
from beamviz.solver.hp.modes import StraightModes
from beamviz.solver.hp.refinement import Answer, CommonMesh, Refinement
from beamviz.solver.problem import Problem
from beamviz.solver.solution import (
    Equilibrium,
    Solution,
    Stats,
    exponents,
    read_only,
    status_of,
    straight,
)


def solve_hp(
    beams: Sequence[Beam],
    problem: Problem,
    extra_modes: int = 0,
    common_mesh: CommonMesh | None = None,
) -> list[Solution | BeamvizError]:
    """The solution of each beam, or its error. See `solve_many`."""
    count = problem.modes + extra_modes
    refinement = Refinement(beams, problem, count, common_mesh)
    while refinement.waiting:
        for indices, mesh in refinement.next_stacks():
            refinement.solve_stack(indices, mesh)
        if common_mesh and refinement.refines(common_mesh):
            refinement = Refinement(beams, problem, count, common_mesh)
    return list(map(partial(_solution, problem), beams, refinement.answers))


def _solution(problem: Problem, beam: Beam, found: Answer) -> Solution | BeamvizError:
    """The Solution of modes on a mesh, or the error in their place."""
    if isinstance(found, BeamvizError):
        return found
    s, grid = exponents(found.omega_squared), found.grid
    orders, unknowns = grid.orders, sum(grid.orders) + sum(grid.axial_orders)
    buckled = False
    if found.family_omega_squared is not None and problem.softening and not problem.chordwise:
        buckled = bool(found.family_omega_squared[0, 0] < beam.gamma**2)  # softening lowers it
    curve = partial(_curve, found)
    equilibrium = Equilibrium(status_of(s), found.iterations, curve, buckled_chordwise=buckled)
    stats = Stats(unknowns, "hp", len(orders), max(orders))
    errors = partial(np.add, found.truncation, found.rounding)
    results = s, errors, found.bending_energy_fraction, Shapes(found)
    return Solution(beam, problem, equilibrium, stats, *results)


@lru_cache(maxsize=128)
def _rows(matrix: Callable[[np.ndarray], np.ndarray], x: bytes) -> np.ndarray:
    """A matrix of a grid at x, cached: the beams of a sweep share their grid and x."""
    return read_only(matrix(np.frombuffer(x)))


def _curve(found: StraightModes, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Position, stretch and angle of the equilibrium."""
    matrices = found.grid.from_clamp, found.grid.at
    return straight(*(_rows(matrix, x.tobytes()) @ found.f for matrix in matrices))


@dataclass(frozen=True, eq=False)
class Shapes:
    """Modes on a mesh as functions of x: the `fields` of a Solution."""

    found: StraightModes

    def __call__(self, x: np.ndarray) -> np.ndarray:
        """Displacements (len(x), 2, modes) along and across the beam."""
        return _displacements(_rows(self.found.grid.from_clamp, x.tobytes()), self.found)

    @property
    def families(self) -> tuple[np.ndarray, np.ndarray] | None:
        """omega^2 of the lowest k modes of each family, bending first, and its estimated errors,
        (2, k) each, k the number of modes solved for; None with Coriolis forces."""
        squares, errors = self.found.family_omega_squared, self.found.family_errors
        return None if squares is None or errors is None else (squares, errors)

    @property
    def stored(self) -> np.ndarray | None:
        """Twice the potential energies (2, modes), softening included, of modes of unit modal mass:
        along the beam, then across it; None without Coriolis forces and at rest."""
        return self.found.stored

    @property
    def spectrum(self) -> np.ndarray | None:
        """omega^2 of all modes of the mesh: of each family, bending first, (2, n), or with Coriolis
        forces of all, (1, n)."""
        found = self.found
        if found.nu is None:
            return None
        with np.errstate(divide="ignore", over="ignore"):  # the highest may be zero by rounding
            spectrum = 1 / found.nu
        if found.family_omega_squared is None:
            return spectrum
        shift = spectrum[:, :1] - found.family_omega_squared[:, :1]  # of each family
        return spectrum - shift


def displacements(solutions: Sequence[Solution], x: np.ndarray) -> np.ndarray:
    """Displacements (solutions, points, 2, modes) of solutions with equally many modes, each at its
    own x (solutions, points); computed at once where the meshes have the same orders.

    The phase of each mode is arbitrary, unlike that of `Solution.displacement`.
    """
    groups: dict[object, list[int]] = {}
    for k, solution in enumerate(solutions):
        modes = solution.fields.found if isinstance(solution.fields, Shapes) else None
        key = k if modes is None else (modes.grid.orders, modes.mode_order is None)
        groups.setdefault(key, []).append(k)
    places = np.concatenate(list(groups.values()))
    found = [_of_group([solutions[k] for k in group], x[group]) for group in groups.values()]
    return np.concatenate(found)[places.argsort()]


def _of_group(solutions: list[Solution], x: np.ndarray) -> np.ndarray:
    """`displacements` of modes on meshes of the same orders, or of a single solution."""
    if len(solutions) == 1:
        return solutions[0].fields(x[0])[None]
    found = [each.fields.found for each in solutions if isinstance(each.fields, Shapes)]

    def stacked(records: Sequence[Any], *names: str) -> dict[str, Any]:
        return {name: np.array([getattr(one, name) for one in records]) for name in names}

    first, grids = found[0], [one.grid for one in found]
    order = () if first.mode_order is None else ("mode_order",)
    modes = first._replace(**stacked(found, "f", "kappa", "s", *order))
    if all(grid is first.grid for grid in grids) and (x == x[0]).all():
        return _displacements(_rows(first.grid.from_clamp, x[0].tobytes()), modes)
    grid = replace(first.grid, **stacked(grids, "breaks", "points", "weights", "J"))
    return _displacements(grid.from_clamp(x), modes._replace(grid=grid))


def _displacements(from_clamp: np.ndarray, modes: StraightModes) -> np.ndarray:
    """Displacements (..., len(x), 2, modes): u = int s along the beam, w = int f theta across."""
    kappa, s, mode_order = modes.kappa, modes.s, modes.mode_order
    if mode_order is not None:
        count = s.shape[-1]
        place, bending = mode_order[..., None, :] % count, mode_order[..., None, :] < count
        kappa, s = (np.take_along_axis(v, place, axis=-1) for v in (kappa, s))
        kappa, s = np.where(bending, kappa, 0.0), np.where(bending, 0.0, s)
    # x is the last axis in memory: samples of one mode are contiguous.
    fields = np.empty((*s.shape[:-2], s.shape[-1], 2, from_clamp.shape[-2]), s.dtype)
    fields[..., 0, :] = s.mT @ from_clamp.mT
    fields[..., 1, :] = (modes.f[..., None] * (modes.grid.J @ kappa)).mT @ from_clamp.mT
    return np.swapaxes(fields, -3, -1)
