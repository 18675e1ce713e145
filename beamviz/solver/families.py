"""Solution of the finite-element and series methods: modes of two families in one list.

Errors are estimated by the difference from the default method, which converges to the same model.
"""

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from beamviz.beam import Beam
from beamviz.errors import BeamvizError, NoEquilibrium
from beamviz.mechanics.straight import turns_freely
from beamviz.mechanics.straight_properties import stack_of
from beamviz.solver import eigen
from beamviz.solver.loads import Curve, Loads
from beamviz.solver.problem import Problem
from beamviz.solver.solution import (
    Equilibrium,
    Fields,
    Solution,
    Stats,
    exponents,
    read_only,
    status_of,
    straight,
)
from beamviz.solver.straight import is_buckled, solve_hp
from beamviz.space.spans import ends_of_spans

REFERENCE_TOLERANCE = 1e-9  # of the default method, for the error estimates of other methods

Pair = tuple[np.ndarray, np.ndarray]  # matrices along the beam and across it
Shapes = Callable[[np.ndarray], np.ndarray]  # x -> (len(x), modes); picklable
Basis = Callable[[np.ndarray], Shapes]  # coordinates (n, modes) -> functions of x


class Family(NamedTuple):
    """The lowest modes of bending or of stretching alone, of unit modal mass."""

    omega_squared: np.ndarray  # (modes,) ascending
    shapes: Shapes


Modes = tuple[np.ndarray, np.ndarray, Fields]  # omega^2 and bending energy fraction (modes,)


def merge(stretching: Family, bending: Family, modes: int) -> Modes:
    """The lowest `modes` modes of two uncoupled families."""
    omega_squared = np.concatenate((stretching.omega_squared, bending.omega_squared))
    order = omega_squared.argsort(kind="stable")[:modes]
    fraction = (order >= len(stretching.omega_squared)).astype(float)
    fields = partial(fields_of_families, stretching.shapes, bending.shapes, order)
    return omega_squared[order], fraction, fields


def fields_of_families(
    along: Shapes, across: Shapes, order: np.ndarray, x: np.ndarray
) -> np.ndarray:
    """Displacements (len(x), 2, modes) along and across the beam of the modes of both families in
    this order."""
    u, w = along(x), across(x)
    uncoupled = np.zeros((len(x), 2, u.shape[1] + w.shape[1]))
    uncoupled[:, 0, : u.shape[1]], uncoupled[:, 1, u.shape[1] :] = u, w
    return uncoupled[:, :, order]


def coupled_fields(along: Shapes, across: Shapes, x: np.ndarray) -> np.ndarray:
    """Displacements (len(x), 2, modes) of modes that have both components."""
    return np.stack((along(x), across(x)), axis=1)


def modes_of_matrices(
    beam: Beam, problem: Problem, K: Pair, F: Pair, shapes: tuple[Basis, Basis]
) -> Modes:
    """The lowest modes of the matrices along the beam and of those across it. K (n, n): stiffness
    without softening. F (m, n): factors of the mass matrices F' F. The softening, a multiple of the
    mass, shifts omega^2, across the beam in the plane of rotation only."""
    Ma, Mb = (f.T @ f for f in F)
    free = beam.root == 0 and bool(turns_freely(stack_of([beam]), problem)[0])
    if problem.gyroscopic and beam.gamma:
        Ka, Kb = K[0] - beam.gamma**2 * Ma, K[1] - beam.gamma**2 * Mb
        stacks = (Ka[None], Kb[None]), (F[0][None], F[1][None])
        gamma = np.full((1, 1, 1), beam.gamma)
        coupled = eigen.gyroscopic_modes(*stacks, gamma, problem.modes, singular=free)
        along, across = shapes[0](coupled.a[0]), shapes[1](coupled.b[0])
        fields = partial(coupled_fields, along, across)
        omega_squared = coupled.omega_squared[0]
        if free:
            omega_squared[abs(omega_squared).argmin()] = 0.0
        return omega_squared, coupled.fraction[0], fields
    softening = beam.gamma**2

    omega_squared, V = eigen.symmetric_modes(K[0], Ma, problem.modes)
    stretching = Family(omega_squared - softening, shapes[0](V))

    shift = eigen.COMPRESSED if beam.delta < 0 or beam.root < math.inf else 0.0
    omega_squared, V = eigen.symmetric_modes(K[1], Mb, problem.modes, shift)
    omega_squared = omega_squared - softening * problem.chordwise
    if free:  # a rigid rotation about the hinge
        omega_squared[0] = 0.0
    bending = Family(omega_squared, shapes[1](V))
    return merge(stretching, bending, problem.modes)


def build_solution(
    beam: Beam,
    problem: Problem,
    modes: Modes,
    size: tuple[int, int, int],
    curve: Curve = straight,
    iterations: int = 0,
    nodes: ArrayLike = (),
) -> Solution:
    """The Solution. size: unknowns, elements, order. curve, iterations: of the equilibrium, nodes:
    between which it is smooth."""
    (omega_squared, fraction, fields), (dof, elements, order) = modes, size
    s = exponents(omega_squared)
    buckled = False
    if not problem.chordwise and beam.delta < 0:
        bending = omega_squared[fraction >= 0.5]
        if beam.is_uniform and len(bending):  # in the plane, omega^2 is lower by gamma^2
            buckled = bool(bending[0] < beam.gamma**2)
        else:
            buckled = is_buckled(beam, problem)
    breaks = np.union1d(nodes, ends_of_spans(beam))
    loads = Loads(beam, problem.chordwise, breaks, curve)
    errors = partial(errors_against_reference, beam, problem, omega_squared, fraction)
    return Solution(
        beam=beam,
        problem=problem,
        equilibrium=Equilibrium(status_of(s), iterations, loads, buckled_chordwise=buckled),
        stats=Stats(dof, problem.method, elements, order),
        s=read_only(s),
        estimate_errors=errors,
        bending_energy_fraction=read_only(fraction),
        fields=fields,
    )


def no_equilibrium(beam: Beam, problem: Problem) -> NoEquilibrium | None:
    """The error of the default method for a beam that has no equilibrium, with its limit; None
    where it has one, or none that the default method finds. For a method that did not converge."""
    finer = replace(problem, modes=1, method="auto", coriolis=False, elements=None, terms=None)
    (reference,) = solve_hp([beam], finer)
    return reference if isinstance(reference, NoEquilibrium) else None


def errors_against_reference(
    beam: Beam, problem: Problem, omega_squared: np.ndarray, bending_energy_fraction: np.ndarray
) -> np.ndarray:
    """Errors (modes,) of omega^2: the difference from the default method plus the error of that.
    Modes are paired within their family, for a coarse basis may change the order of families.
    Infinite where the default method has no answer, or no partner among twice as many modes."""
    modes = len(omega_squared)
    method = "foac" if problem.rigid_tension else "auto"
    finer = replace(problem, modes=2 * modes, method=method, elements=None, terms=None)
    (reference,) = solve_hp([beam], replace(finer, tolerance=REFERENCE_TOLERANCE))
    errors = np.full(modes, np.inf)
    if isinstance(reference, BeamvizError):
        return errors
    for bending in (True, False):
        places = np.flatnonzero((bending_energy_fraction >= 0.5) == bending)
        partners = np.flatnonzero((reference.bending_energy_fraction >= 0.5) == bending)
        pairs = min(len(places), len(partners))
        places, partners = places[:pairs], partners[:pairs]
        errors[places] = abs(omega_squared[places] - reference.omega_squared[partners])
        errors[places] += reference.omega_squared_errors[partners]
    return errors
