"""Solution of the finite-element and series methods: modes of two families in one list.

Errors are estimated by the difference from the default method, which converges to the same model.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from beamviz.beam import Beam
from beamviz.errors import BeamvizError, NoEquilibrium
from beamviz.mechanics.straight_properties import stack_of
from beamviz.solver.build import SolvedState, Vibration, build_solution
from beamviz.solver.loads import Curve
from beamviz.solver.pencil import lowest_modes
from beamviz.solver.pencil import matrices as pencils
from beamviz.solver.pencil.matrices import Families, exponents
from beamviz.solver.problem import Problem
from beamviz.solver.solution import Fields, Solution, Stats, straight
from beamviz.solver.stability import (
    cancelled_softening,
    definiteness_of_bending,
    is_buckled_chordwise,
    softening_of_families,
    turns_freely,
)
from beamviz.solver.straight import solve_one
from beamviz.space.spans import ends_of_spans

REFERENCE_TOLERANCE = 1e-9  # of the default method, for the error estimates of other methods

Pair = tuple[np.ndarray, np.ndarray]  # matrices along the beam and across it
# x -> (len(x), modes), or across the beam in space (len(x), 2, modes); picklable
Shapes = Callable[[np.ndarray], np.ndarray]
Basis = Callable[[np.ndarray], Shapes]  # coordinates (n, modes) -> functions of x


class FamilyModes(NamedTuple):
    """The lowest modes of bending or of stretching alone, of unit modal mass."""

    omega_squared: np.ndarray  # (modes,) ascending
    shapes: Shapes


class ModesOfFamilies(NamedTuple):
    """The lowest modes of both families in one list."""

    omega_squared: np.ndarray  # (modes,) ascending
    fraction: np.ndarray  # (modes,) share of the kinetic energy across the beam
    fields: Fields
    in_plane_fraction: np.ndarray | None = None  # (modes,) of it in the plane of rotation, in space


def merge(
    stretching: FamilyModes, bending: FamilyModes, modes: int, in_plane: np.ndarray | None = None
) -> ModesOfFamilies:
    """The lowest `modes` modes of two uncoupled families. in_plane: of bending in space, the share
    (modes,) in the plane of rotation."""
    omega_squared = np.concatenate((stretching.omega_squared, bending.omega_squared))
    known = np.isfinite(omega_squared).sum()  # a family may have fewer than another
    order = omega_squared.argsort(kind="stable")[: min(modes, known)]
    fraction = (order >= len(stretching.omega_squared)).astype(float)
    fields = partial(fields_of_families, stretching.shapes, bending.shapes, order)
    if in_plane is not None:
        in_plane = np.concatenate((np.ones(len(stretching.omega_squared)), in_plane))[order]
    return ModesOfFamilies(omega_squared[order], fraction, fields, in_plane)


def fields_of_families(
    along: Shapes, across: Shapes, order: np.ndarray, x: np.ndarray
) -> np.ndarray:
    """Displacements (len(x), 2 or 3, modes) along and across the beam of the modes of both families
    in this order."""
    u, w = along(x)[:, None], _with_components(across(x))
    uncoupled = np.zeros((len(x), 1 + w.shape[1], u.shape[2] + w.shape[2]))
    uncoupled[:, :1, : u.shape[2]], uncoupled[:, 1:, u.shape[2] :] = u, w
    return uncoupled[:, :, order]


def coupled_fields(along: Shapes, across: Shapes, x: np.ndarray) -> np.ndarray:
    """Displacements (len(x), 2 or 3, modes) of modes that have all components."""
    return np.concatenate((along(x)[:, None], _with_components(across(x))), axis=1)


def _with_components(across: np.ndarray) -> np.ndarray:
    """Displacements across the beam (len(x), components, modes)."""
    return across[:, None] if across.ndim == 2 else across


def modes_of_matrices(
    beam: Beam, problem: Problem, K: Pair, F: Pair, shapes: tuple[Basis, Basis]
) -> ModesOfFamilies:
    """The lowest modes of the matrices along the beam and of those across it. K (n, n): stiffness
    without softening. F (m, n): factors of the mass matrices F' F. The softening, a multiple of the
    mass, shifts omega^2, across the beam in the plane of rotation only."""
    beams = stack_of([beam])
    Ka, Kb, Fa, Fb = (matrix[None] for matrix in (*K, *F))
    pencil = Families(
        across=pencils.Family(Kb, Fb.mT @ Fb, Fb),
        along=pencils.Family(Ka, Fa.mT @ Fa, Fa),
        softening=softening_of_families(beams, problem),
        gamma=problem.coriolis_factor * beams.gamma[..., None]
        if problem.gyroscopic and beam.gamma
        else None,
        definiteness=definiteness_of_bending(beams, problem),
        rigid=turns_freely(beams, problem),
        cancelled=cancelled_softening(beams, problem),
    )
    modes = lowest_modes(pencil, problem.modes)
    b, a = modes.V
    along, across = shapes[0](a[0]), shapes[1](b[0])
    omega_squared, in_plane = modes.omega_squared[0], None
    if problem.in_space:
        out_of_plane = Fb[0][:, Fb.shape[2] // 2 :] @ b[0][Fb.shape[2] // 2 :]
        in_plane = np.clip(1 - (abs(out_of_plane) ** 2).sum(axis=0), 0.0, 1.0)
    if modes.fraction is not None:
        fields = partial(coupled_fields, along, across)
        return ModesOfFamilies(omega_squared, modes.fraction[0], fields, in_plane)
    bending, stretching = omega_squared
    return merge(
        FamilyModes(stretching, along), FamilyModes(bending, across), problem.modes, in_plane
    )


def solution_of(
    beam: Beam,
    problem: Problem,
    modes: ModesOfFamilies,
    size: tuple[int, int, int],
    curve: Curve = straight,
    iterations: int = 0,
    nodes: ArrayLike = (),
) -> Solution:
    """The Solution. size: unknowns, elements, order. curve, iterations: of the equilibrium, nodes:
    between which it is smooth."""
    (omega_squared, fraction, fields, in_plane), (dof, elements, order) = modes, size
    bending = omega_squared[fraction >= 0.5]
    lowest = float(bending[0]) if len(bending) else None
    breaks = np.union1d(nodes, ends_of_spans(beam))
    buckled = is_buckled_chordwise(beam, problem, lowest, solve_one)
    return build_solution(
        beam,
        problem,
        SolvedState(curve, breaks, iterations, buckled_chordwise=buckled),
        Vibration(
            s=exponents(omega_squared),
            fraction=fraction,
            fields=fields,
            in_plane_fraction=in_plane,
            estimate_errors=partial(
                errors_against_reference, beam, problem, omega_squared, fraction
            ),
        ),
        Stats(dof, problem.method, elements, order),
    )


def no_equilibrium(beam: Beam, problem: Problem) -> NoEquilibrium | None:
    """The error of the default method for a beam that has no equilibrium, with its limit; None
    where it has one, or none that the default method finds. For a method that did not converge."""
    finer = replace(problem, modes=1, method="auto", coriolis=False, elements=None, terms=None)
    reference = solve_one(beam, finer)
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
    reference = solve_one(beam, replace(finer, tolerance=REFERENCE_TOLERANCE))
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
