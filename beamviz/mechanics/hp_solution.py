"""Solutions of the default discretisation: `auto`, and the models with a rigid tension."""

import time
from functools import partial

import numpy as np

from beamviz.mechanics.adaptive import StraightModes, solve_straight
from beamviz.mechanics.method import Task
from beamviz.mechanics.physics import Tension
from beamviz.mechanics.solution import Equilibrium, Solution, Stats, status


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
        displacement=partial(_displacement, found),
    )


def _axial(found: StraightModes, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """u(x) and f(x) of the equilibrium."""
    return found.mesh.from_clamp(x) @ found.f, found.mesh.at(x) @ found.f


def _displacement(found: StraightModes, x: np.ndarray) -> np.ndarray:
    """Fields (len(x), 2, modes): u = int s along the beam, w = int f theta across it."""
    rows, modes = found.mesh.from_clamp(x), len(found.squares)
    u = rows @ found.s
    w = rows @ (found.f[:, None] * (found.mesh.J @ found.kappa))
    if found.picks is None:
        return np.stack((u, w), axis=1)
    fields = np.zeros((len(x), 2, 2 * modes))
    fields[:, 1, :modes], fields[:, 0, modes:] = w, u
    return fields[:, :, found.picks]
