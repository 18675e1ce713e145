"""Solutions of the default discretisation: `auto`, and the models with a rigid tension."""

import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from beamviz.mechanics.adaptive import StraightModes, solve_straight
from beamviz.mechanics.mesh import Mesh
from beamviz.mechanics.method import Task
from beamviz.mechanics.physics import Tension
from beamviz.mechanics.solution import Displacement, Equilibrium, Solution, Stats, status


def hp_solution(task: Task, tension: Tension = "equilibrium", stiffening: bool = True) -> Solution:
    """The straight scene on as few unknowns as the tolerance asks for."""
    physics = task.physics
    if tension != "equilibrium":
        stiffening = stiffening and physics.stiffening
        physics = physics._replace(tension=tension, stiffening=stiffening)
    return as_solution(task, solve_straight(task.beam, task.modes, physics, task.tolerance))


def as_solution(task: Task, found: StraightModes) -> Solution:
    """What was found on a mesh, as functions of x."""
    mesh = found.mesh
    return Solution(
        beam=task.beam,
        model=task.model,
        equilibrium=Equilibrium(status(found.squares), found.iterations, partial(_axial, found)),
        stats=Stats(
            2 * len(found.f),
            time.perf_counter() - task.start,
            "hp",
            mesh.elements,
            max(mesh.orders),
        ),
        squares=found.squares,
        estimate=partial(np.add, found.truncation, found.rounding),
        bending_fractions=found.bending_fractions,
        displacement=Fields(found),
    )


def _axial(found: StraightModes, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """u(x) and f(x) of the equilibrium."""
    return found.mesh.from_clamp(x) @ found.f, found.mesh.at(x) @ found.f


@dataclass(frozen=True, eq=False)
class Fields:
    """The modes found on a mesh as functions of x."""

    found: StraightModes

    def __call__(self, x: np.ndarray) -> np.ndarray:
        """Fields (len(x), 2, modes) along and across the beam."""
        found = self.found
        return _fields(found.mesh, x, found.f, found.kappa, found.s, found.picks)


def displacements(solutions: Sequence[Solution], x: np.ndarray) -> np.ndarray:
    """`displacement(x)` of solutions with equally many modes, (solutions, len(x), 2, modes); of
    those on one mesh at once."""
    each = [solution.displacement for solution in solutions]
    groups: dict[object, list[int]] = {}
    for k, fields in enumerate(each):
        groups.setdefault(fields.found.mesh if isinstance(fields, Fields) else k, []).append(k)
    places = np.concatenate(list(groups.values()))
    found = np.concatenate([_on_one_mesh([each[k] for k in group], x) for group in groups.values()])
    return found[places.argsort()]


def _on_one_mesh(each: list[Displacement], x: np.ndarray) -> np.ndarray:
    """Fields (several, len(x), 2, modes) of modes found on one mesh, or of one other solution."""
    found = [fields.found for fields in each if isinstance(fields, Fields)]
    if len(found) < 2 or any(one.picks is None for one in found):
        return np.array([fields(x) for fields in each])
    f, kappa, s, picks = map(
        np.array, zip(*((one.f, one.kappa, one.s, one.picks) for one in found), strict=True)
    )
    return _fields(found[0].mesh, x, f, kappa, s, picks)


def _fields(
    mesh: Mesh,
    x: np.ndarray,
    f: np.ndarray,
    kappa: np.ndarray,
    s: np.ndarray,
    picks: np.ndarray | None,
) -> np.ndarray:
    """Fields (..., len(x), 2, modes): u = int s along the beam, w = int f theta across it."""
    from_clamp = mesh.from_clamp(x).T
    if picks is not None:
        modes = s.shape[-1]
        bending, place = picks[..., None, :] < modes, picks[..., None, :] % modes
        kappa = np.where(bending, np.take_along_axis(kappa, place, axis=-1), 0.0)
        s = np.where(bending, 0.0, np.take_along_axis(s, place, axis=-1))
    # In memory x runs fastest: what samples many solutions reads all of one mode in a row.
    fields = np.empty((*s.shape[:-2], s.shape[-1], 2, len(x)), s.dtype)
    fields[..., 0, :] = s.mT @ from_clamp
    fields[..., 1, :] = (f[..., None] * (mesh.J @ kappa)).mT @ from_clamp
    return np.swapaxes(fields, -3, -1)
