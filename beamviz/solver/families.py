"""Modes of the finite-element and series methods: two families in one list, and their Solution.

Errors are estimated by the distance from the default method, which converges to the same model.
"""

import time
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from beamviz.beam import Beam
from beamviz.solver.hp.refinement import errors_against_reference
from beamviz.solver.problem import Problem
from beamviz.solver.solution import Axial, Equilibrium, Fields, Solution, Stats

Shapes = Callable[[np.ndarray], np.ndarray]  # x -> (len(x), modes); picklable


class Family(NamedTuple):
    """The lowest modes of bending or of stretching alone, of unit modal mass."""

    omega_squared: np.ndarray  # (modes,) ascending
    shapes: Shapes


class Modes(NamedTuple):
    """The lowest modes of both families."""

    omega_squared: np.ndarray  # (modes,) ascending
    bending_energy_fraction: np.ndarray  # (modes,) share of the kinetic energy across the beam
    fields: Fields


def merge(stretching: Family, bending: Family, modes: int) -> Modes:
    """The lowest `modes` modes of two uncoupled families."""
    omega_squared = np.concatenate((stretching.omega_squared, bending.omega_squared))
    order = omega_squared.argsort(kind="stable")[:modes]
    fraction = (order >= len(stretching.omega_squared)).astype(float)
    fields = partial(_merged_fields, stretching.shapes, bending.shapes, order)
    return Modes(omega_squared[order], fraction, fields)


def _merged_fields(along: Shapes, across: Shapes, order: np.ndarray, x: np.ndarray) -> np.ndarray:
    u, w = along(x), across(x)
    stretching = np.stack((u, np.zeros_like(u)), axis=1)
    bending = np.stack((np.zeros_like(w), w), axis=1)
    return np.concatenate((stretching, bending), axis=2)[:, :, order]


def coupled_fields(along: Shapes, across: Shapes, x: np.ndarray) -> np.ndarray:
    """Displacement (len(x), 2, modes) of modes with both components."""
    return np.stack((along(x), across(x)), axis=1)


def unstretched(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """u(x) and f(x) of the beam at its reference length."""
    return x, np.ones_like(x)


class Solved(NamedTuple):
    """The answer of a method: modes, number of unknowns, and the straight state of equilibrium."""

    modes: Modes
    dof: int
    axial: Axial = unstretched
    iterations: int = 0


def build_solution(
    beam: Beam, problem: Problem, start: float, solved: Solved, *, order: int, elements: int = 1
) -> Solution:
    """The solution of a problem; start is the clock (time.perf_counter) at the call."""
    omega_squared, fraction, fields = solved.modes
    stable = bool(omega_squared[0] >= 0)
    seconds = time.perf_counter() - start
    return Solution(
        beam=beam,
        problem=problem,
        equilibrium=Equilibrium(stable, solved.iterations, solved.axial),
        stats=Stats(solved.dof, seconds, problem.method, elements, order),
        omega_squared=omega_squared,
        estimate_errors=partial(errors_against_reference, beam, problem, omega_squared, fraction),
        bending_energy_fraction=fraction,
        fields=fields,
    )
