"""The default method `auto`: as few unknowns as the tolerance asks for."""

import math
from typing import NamedTuple

import numpy as np

from beamviz.beam import Beam
from beamviz.errors import NotConverged
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
from beamviz.solver.physics import Physics

REFINEMENTS = 8
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
    bending_fractions: np.ndarray
    squares: np.ndarray
    truncation: np.ndarray
    rounding: np.ndarray


def solve_straight(beam: Beam, modes: int, physics: Physics, tolerance: float) -> StraightModes:
    """Equilibrium and the lowest `modes` modes within the relative `tolerance`.

    Raises NoEquilibrium with the limit, NotConverged when refinement does not get there.
    """
    near, positions = None, unstretched(beam)
    if physics.tension == "equilibrium" and not hardly_stretches(beam):
        near, positions = coarse(beam, physics.law)
    pulled = beam if physics.stiffening else beam.replace(gamma=0.0)  # no tension, no layers
    parts = segments(pulled, positions, physics.law)
    more = more_digits(beam, positions, parts, physics)
    digits, enough = more - math.log10(tolerance), STRETCH_SHARE * tolerance / 10**more
    over, tried = math.inf, 0
    for attempt in range(1, REFINEMENTS + 1):
        breaks, orders = discretisation(parts, beam.mu, modes, physics.curvature, digits)
        if sum(orders) > MAX_UNKNOWNS:
            break
        points = mesh(breaks, orders)
        found = solve_on(points, beam, modes, physics, tolerance, near, enough)
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
    allowed = 2 * tolerance * abs(found.squares) + found.rounding
    return (found.truncation / allowed)[..., :modes].max(axis=-1)


def solve_on(
    points: Mesh,
    beam: Beam,
    modes: int,
    physics: Physics,
    tolerance: float,
    near: State | None = None,
    enough: float = 0.0,
) -> StraightModes:
    """Equilibrium, `enough` near, and modes on one mesh; `near` is the equilibrium on another."""
    rho = hp.inertia(points, beam)
    if physics.tension == "equilibrium":
        stretch = equilibrium(points, rho, beam, physics.law, near, enough)
    else:
        stretch = hp.Stretch(np.ones(len(points.weights)), 0, 0.0)
    f, gamma, softening = stretch.f, beam.gamma, physics.softening
    forms = hp.forms(points, rho, beam, f, physics.law, physics.curvature, physics.stiffening)
    if physics.couples and gamma:
        vibration = coupled(points, rho, stretch, gamma, forms, modes, softening, tolerance)
    else:
        shift = eigen.COMPRESSED if beam.delta < 0 else 0.0
        vibration = apart(points, stretch, gamma**2, forms, modes, physics, shift)
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
