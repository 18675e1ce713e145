"""The default method: high-order elements in gradient and curvature, split at the mass.

A solve is `refinement.solve_stack`: trial functions on elements (`beamviz.space`), equilibrium,
matrices, modes and errors (`beamviz.mechanics`), and where these are too large, finer elements.
The entry point is `solve_hp`; Solutions and functions of x are built here from values on a mesh.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from typing import Any

import numpy as np

from beamviz.beam import Beam
from beamviz.errors import BeamvizError
from beamviz.mechanics.straight import StraightModes, rotation
from beamviz.solver.build import SolvedState, Vibration, build_solution
from beamviz.solver.pencil.matrices import exponents
from beamviz.solver.planes import JoinedModes
from beamviz.solver.problem import Problem
from beamviz.solver.solution import Solution, Stats, read_only, straight
from beamviz.solver.stability import is_buckled_chordwise
from beamviz.solver.straight.refinement import ModesOrError, converged_modes

MOST_CACHED = 2**14  # entries of a matrix: larger ones, of blades, are a small part of a solve
MOST_ENTRIES = 2**18  # of the matrices of a stack of solutions: 2 MB


def solve_hp(
    beams: Sequence[Beam], problem: Problem, extra_modes: int = 0
) -> list[Solution | BeamvizError]:
    """The solution of each beam, or its error. See `solve_many`."""
    answers = converged_modes(beams, problem, problem.modes + extra_modes)
    return [_solution(problem, *pair) for pair in zip(beams, answers, strict=True)]


def _solution(problem: Problem, beam: Beam, modes: ModesOrError) -> Solution | BeamvizError:
    """The Solution of modes on a mesh, or the error in their place."""
    if isinstance(modes, BeamvizError):
        return modes
    orders, axial_orders = modes.orders
    lowest = float(modes.lowest_bending)
    buckled = is_buckled_chordwise(beam, problem, lowest, solve_one)
    curve = partial(_curve, modes)
    state = SolvedState(curve, modes.grid.breaks, modes.iterations, buckled_chordwise=buckled)
    vibration = Vibration(
        s=exponents(modes.omega_squared),
        fraction=modes.bending_energy_fraction,
        fields=ModeFields(modes),
        estimate_errors=partial(_errors, modes),
        in_plane_fraction=modes.in_plane_fraction,
    )
    unknowns = len(problem.components_in_plane) * sum(orders) + sum(axial_orders)
    stats = Stats(unknowns, "hp", len(orders), max(orders))
    return build_solution(beam, problem, state, vibration, stats)


def solve_one(beam: Beam, problem: Problem) -> Solution | BeamvizError:
    """`solve_hp` of one beam."""
    (answer,) = solve_hp([beam], problem)
    return answer


def _errors(modes: StraightModes) -> np.ndarray:
    """Estimated errors (modes,) of omega^2."""
    return modes.truncation.sum(axis=-1) + modes.rounding


def _rows(matrix: Callable[[np.ndarray], np.ndarray], x: np.ndarray, n: int) -> np.ndarray:
    """A matrix (len(x), n) of a grid at x; a small one is cached, as the beams of a sweep share
    their grid and x."""
    return _cached_rows(matrix, x.tobytes()) if len(x) * n <= MOST_CACHED else matrix(x)


@lru_cache(maxsize=16)
def _cached_rows(matrix: Callable[[np.ndarray], np.ndarray], x: bytes) -> np.ndarray:
    """A matrix of a grid at x."""
    return read_only(matrix(np.frombuffer(x)))


def _curve(modes: StraightModes, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Position, stretch and angle of the equilibrium."""
    matrices = modes.grid.from_clamp, modes.grid.at
    return straight(*(_rows(matrix, x, len(modes.f)) @ modes.f for matrix in matrices))


@dataclass(frozen=True, eq=False)
class ModeFields:
    """The `fields` of a Solution, from its modes on a mesh: a class, not a closure, so that
    `displacements` finds the modes of many solutions."""

    modes: StraightModes  # of one beam

    def __call__(self, x: np.ndarray) -> np.ndarray:
        """Displacements (len(x), 2, modes) along and across the beam, or (len(x), 3, modes) along
        it, in the plane of rotation and out of it."""
        return _displacements(_rows(self.modes.grid.from_clamp, x, len(self.modes.f)), self.modes)


def displacements(solutions: Sequence[Solution], x: np.ndarray) -> np.ndarray:
    """Displacements (solutions, points, 2 or 3, modes) of solutions with equally many modes, each
    at its own x (solutions, points); computed in stacks where the meshes have the same orders.

    The phase of each mode is arbitrary, unlike that of `Solution.displacement`.
    """
    groups: dict[object, list[int]] = {}
    joined = [k for k, each in enumerate(solutions) if isinstance(each.fields, JoinedModes)]
    for k, solution in enumerate(solutions):
        if isinstance(solution.fields, JoinedModes):
            continue
        modes = solution.fields.modes if isinstance(solution.fields, ModeFields) else None
        key = k if modes is None else (modes.grid.orders, modes.mode_order is None)
        groups.setdefault(key, []).append(k)
    stacks = [stack for group in groups.values() for stack in _stacks(group, solutions, x)]
    parts = [_of_group([solutions[k] for k in stack], x[stack]) for stack in stacks]
    if joined:
        parts.append(_of_joined([solutions[k] for k in joined], x[joined]))
        stacks.append(joined)
    return np.concatenate(parts)[np.concatenate(stacks).argsort()]  # in the order of the solutions


def _of_joined(solutions: list[Solution], x: np.ndarray) -> np.ndarray:
    """`displacements` of modes in both planes that do not couple."""
    fields = [each.fields for each in solutions if isinstance(each.fields, JoinedModes)]
    chordwise, flapwise = (
        displacements(of_plane, x)
        for of_plane in ([each.chordwise for each in fields], [each.flapwise for each in fields])
    )
    rows = zip(fields, chordwise, flapwise, strict=True)
    return np.array([each.arranged(*of_planes) for each, *of_planes in rows])


def _stacks(group: list[int], solutions: Sequence[Solution], x: np.ndarray) -> list[list[int]]:
    """A group in stacks whose matrices have at most MOST_ENTRIES together."""
    fields = solutions[group[0]].fields
    unknowns = len(fields.modes.grid.points) if isinstance(fields, ModeFields) else 1
    size = max(1, MOST_ENTRIES // (unknowns * x.shape[1]))
    return [group[first : first + size] for first in range(0, len(group), size)]


def _of_group(solutions: list[Solution], x: np.ndarray) -> np.ndarray:
    """`displacements` of modes on meshes of the same orders, or of a single solution."""
    if len(solutions) == 1:
        return solutions[0].fields(x[0])[None]
    modes_of_each = [each.fields.modes for each in solutions if isinstance(each.fields, ModeFields)]

    def stacked(records: Sequence[Any], *names: str) -> dict[str, Any]:
        """The arrays of these names, those of all records in the leading axis."""
        return {name: np.array([getattr(record, name) for record in records]) for name in names}

    first, grids = modes_of_each[0], [modes.grid for modes in modes_of_each]
    order = () if first.mode_order is None else ("mode_order",)
    modes = first._replace(**stacked(modes_of_each, "f", "kappa", "s", *order))
    if all(grid is first.grid for grid in grids) and (x == x[0]).all():
        return _displacements(_rows(first.grid.from_clamp, x[0], len(first.f)), modes)
    grid = replace(first.grid, **stacked(grids, "breaks", "points", "weights"))
    return _displacements(grid.from_clamp(x), modes._replace(grid=grid))


def _displacements(from_clamp: np.ndarray, modes: StraightModes) -> np.ndarray:
    """Displacements (..., len(x), 1 + c, modes): u = int s along the beam, and across it, of c
    components, w = int f theta."""
    kappa, s, mode_order = modes.kappa, modes.s, modes.mode_order
    if mode_order is not None:
        count = s.shape[-1]
        place, bending = mode_order[..., None, :] % count, mode_order[..., None, :] < count
        kappa, s = (np.take_along_axis(v, place, axis=-1) for v in (kappa, s))
        kappa, s = np.where(bending, kappa, 0.0), np.where(bending, 0.0, s)
    # x is the last axis in memory: samples of one mode are contiguous.
    angle = rotation(modes.grid, kappa)  # (..., c, n, modes)
    components = angle.shape[-3]
    fields = np.empty((*s.shape[:-2], s.shape[-1], 1 + components, from_clamp.shape[-2]), s.dtype)
    fields[..., 0, :] = s.mT @ from_clamp.mT
    for k in range(components):
        across = modes.f[..., None] * angle[..., k, :, :]
        fields[..., 1 + k, :] = across.mT @ from_clamp.mT
    return np.swapaxes(fields, -3, -1)
