"""The default method `auto`: as few unknowns as the tolerance asks for."""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from beamviz.beam import Beam
from beamviz.errors import NoEquilibrium, NotConverged
from beamviz.solver import eigen
from beamviz.solver.constitutive import StrainLaw
from beamviz.solver.hp import matrices as hp
from beamviz.solver.hp.equilibrium import State, equilibrium, hardly_stretches
from beamviz.solver.hp.mesh import Grid, Mesh, mesh
from beamviz.solver.hp.mesh_design import (
    MAX_UNKNOWNS,
    Positions,
    discretisation,
    more_digits,
    segments,
    unstretched,
)
from beamviz.solver.hp.modes import apart, coupled
from beamviz.solver.problem import Problem

REFINEMENTS = 8
REFERENCE_TOLERANCE = 1e-9  # of the solves other methods are compared with
COARSE_ORDER = 6
STRETCH_SHARE = 1e-3  # of the tolerance: an error of the stretch that need not be mended


class StraightModes(NamedTuple):
    """Equilibrium and the lowest modes on the mesh that met the tolerance; from kappa on the
    fields of vibration.Modes."""

    grid: Grid
    f: np.ndarray  # (n,) stretch at the mesh points
    iterations: int
    kappa: np.ndarray
    s: np.ndarray
    picks: np.ndarray | None
    bending_energy_fraction: np.ndarray
    omega_squared: np.ndarray
    truncation: np.ndarray
    rounding: np.ndarray


def solve_straight(beam: Beam, modes: int, problem: Problem, tolerance: float) -> StraightModes:
    """Equilibrium and the lowest `modes` modes within the relative `tolerance`.

    Raises NoEquilibrium with the limit, NotConverged when refinement does not get there.
    """
    near, positions = None, unstretched(beam)
    if not problem.rigid_tension and not hardly_stretches(beam):
        near, positions = coarse(beam, problem.strain_law)
    pulled = beam if problem.stiffens else beam.replace(gamma=0.0)  # no tension, no layers
    parts = segments(pulled, positions, problem.strain_law)
    more = more_digits(beam, positions, parts, problem)
    digits, enough = more - math.log10(tolerance), STRETCH_SHARE * tolerance / 10**more
    over, tried = math.inf, 0
    for attempt in range(1, REFINEMENTS + 1):
        breaks, orders = discretisation(parts, beam.mu, modes, problem.curvature_measure, digits)
        if sum(orders) > MAX_UNKNOWNS:
            break
        points = mesh(breaks, orders)
        found = solve_on(points, beam, modes, problem, tolerance, near, enough)
        over, tried = float(excess(found, tolerance, modes)), len(points.points)
        if over <= 1:
            return found
        near = points, found.f
        digits += 0.7 * attempt + math.log10(over)
    if not tried:
        raise NotConverged(
            "the straight beam buckles in too many half-waves to resolve: that takes"
            f" {sum(orders)} unknowns in each family, at most {MAX_UNKNOWNS} are tried; ask for a"
            " lower gamma or a larger delta"
        )
    raise NotConverged(
        f"errors are still {over:.1e} times the tolerance {tolerance:g} with {tried} unknowns in"
        " each family; ask for a larger tolerance or fewer modes"
    )


def excess(found: StraightModes, tolerance: float, modes: int) -> np.ndarray:
    """The largest error (...) of the lowest `modes` in units of the one allowed. Rounding is
    allowed: no mesh mends it, and the reported error says it."""
    allowed = 2 * tolerance * abs(found.omega_squared) + found.rounding
    return (found.truncation / allowed)[..., :modes].max(axis=-1)


def solve_on(
    points: Mesh,
    beam: Beam,
    modes: int,
    problem: Problem,
    tolerance: float,
    near: State | None = None,
    enough: float = 0.0,
) -> StraightModes:
    """Equilibrium, `enough` near, and modes on one mesh; `near` is the equilibrium on another."""
    rho = hp.inertia(points, beam)
    if not problem.rigid_tension:
        stretch = equilibrium(points, rho, beam, problem.strain_law, near, enough)
    else:
        stretch = hp.Stretch(np.ones(len(points.weights)), 0, 0.0)
    f, gamma, softening = stretch.f, beam.gamma, problem.softening
    forms = hp.forms(
        points, rho, beam, f, problem.strain_law, problem.curvature_measure, problem.stiffens
    )
    if problem.gyroscopic and gamma:
        vibration = coupled(points, rho, stretch, gamma, forms, modes, softening, tolerance)
    else:
        shift = eigen.COMPRESSED if beam.delta < 0 else 0.0
        vibration = apart(points, stretch, gamma**2, forms, modes, problem, shift)
    return StraightModes(points.grid, f, stretch.iterations, *vibration)


def coarse(beam: Beam, law: StrainLaw) -> tuple[State, Positions]:
    """The equilibrium of a beam that stretches on a coarse mesh, and the positions it gives."""
    ends = unstretched(beam).ends
    points = mesh(ends, (COARSE_ORDER,) * (len(ends) - 1))
    f = equilibrium(points, hp.inertia(points, beam), beam, law).f
    weighted = (points.weights * (points.J @ f)).reshape(-1, COARSE_ORDER).sum(axis=1)
    u = points.from_clamp(np.array(ends)) @ f
    means = weighted / np.diff(ends)
    return (points, f), Positions(ends, tuple(u.tolist()), tuple(means.tolist()))


def errors_against_reference(
    beam: Beam, problem: Problem, omega_squared: np.ndarray, bending_energy_fraction: np.ndarray
) -> np.ndarray:
    """Errors (modes,) of omega^2 found by another method: the distance from that of this one, which
    converges to the same model, and the error of that.

    Modes are paired within their family: a coarse basis may shift one past another. Infinite
    where this method has no answer to compare with.
    """
    modes = len(omega_squared)
    method = "foac" if problem.rigid_tension else "auto"
    reference = replace(problem, method=method, elements=None, terms=None)
    try:
        exact = solve_straight(beam, 2 * modes, reference, REFERENCE_TOLERANCE)
    except (NoEquilibrium, NotConverged):
        return np.full(modes, np.inf)
    exact_errors = exact.truncation + exact.rounding
    errors = np.empty(modes)
    for bending in (True, False):
        ours = np.flatnonzero((bending_energy_fraction >= 0.5) == bending)
        theirs = np.flatnonzero((exact.bending_energy_fraction >= 0.5) == bending)[: len(ours)]
        if len(theirs) < len(ours):  # so far off that its partner is out of sight
            theirs = np.append(theirs, [2 * modes - 1] * (len(ours) - len(theirs)))
        errors[ours] = abs(omega_squared[ours] - exact.omega_squared[theirs]) + exact_errors[theirs]
    return errors
