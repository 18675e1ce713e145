"""Solutions of the methods whose resolution is a number of terms."""

import time
from functools import partial

import numpy as np

from beamviz.beam import whole
from beamviz.errors import InvalidInput
from beamviz.solver.error_estimates import differences
from beamviz.solver.problem import Task
from beamviz.solver.series.assumed_modes import assumed_modes
from beamviz.solver.series.chebyshev import axial, chebyshev_modes
from beamviz.solver.series.families import Modes
from beamviz.solver.series.power_series import power_series_modes
from beamviz.solver.solution import Axial, Equilibrium, Solution, Stats, status

ASSUMED, MAX_ASSUMED = 10, 100  # basis functions: cosh overflows soon after
ORDER, MAX_ORDER = 32, 200
POWERS, MIN_POWERS, MAX_POWERS = 80, 6, 1000


def assumed_modes_solution(task: Task) -> Solution:
    """The scene on `terms` functions across the beam and as many along it."""
    terms = whole("terms", ASSUMED if task.terms is None else task.terms, 1, MAX_ASSUMED)
    if task.modes > terms:
        raise InvalidInput(f"modes = {task.modes}: at most {terms} with terms = {terms}")
    found = assumed_modes(task.beam, task.physics, terms, task.modes)
    return _solution(rigid(task), found, terms, 2 * terms)


def power_series_solution(task: Task) -> Solution:
    """The scene with `terms` powers of x on each part of the beam."""
    terms = whole("terms", POWERS if task.terms is None else task.terms, MIN_POWERS, MAX_POWERS)
    found = power_series_modes(task.beam, task.physics, terms, task.modes)
    return _solution(rigid(task), found, terms, 2)


def chebyshev_solution(task: Task) -> Solution:
    """The scene with polynomials of order `terms` on each part of the beam."""
    order = whole("terms", ORDER if task.terms is None else task.terms, 2, MAX_ORDER)
    if task.modes > order:
        raise InvalidInput(f"modes = {task.modes}: at most {order} with terms = {order}")
    found, on, state = chebyshev_modes(task.beam, task.physics, order, task.modes)
    about = partial(axial, on, state.f)
    return _solution(task, found, order, 2 * len(on.points), about, state.iterations)


def rigid(task: Task) -> Task:
    """The task about the beam at its reference length."""
    return task._replace(physics=task.physics._replace(tension="reference"))


def unstretched(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """u(x) and f(x) of the beam at its reference length."""
    return x, np.ones_like(x)


def _solution(
    task: Task,
    found: Modes,
    terms: int,
    dof: int,
    about: Axial = unstretched,
    iterations: int = 0,
) -> Solution:
    """What was found as a Solution; its errors are differences from the default method."""
    return Solution(
        beam=task.beam,
        model=task.model,
        equilibrium=Equilibrium(status(found.squares), iterations, about),
        stats=Stats(dof, time.perf_counter() - task.start, task.model.method, 1, terms),
        squares=found.squares,
        estimate=partial(
            differences, task.beam, task.physics, found.squares, found.bending_fractions
        ),
        bending_fractions=found.bending_fractions,
        displacement=found.displacement,
    )
