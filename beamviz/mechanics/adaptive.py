"""The default method `auto`: as few unknowns as the tolerance asks for."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from beamviz.beam import Beam
from beamviz.errors import NoEquilibrium, NotConverged
from beamviz.mechanics import hp
from beamviz.mechanics.layers import MAX_ORDER, discretisation, segments
from beamviz.mechanics.mesh import Mesh, mesh
from beamviz.mechanics.strain import Curvature, StrainLaw

REFINEMENTS = 8
ORDER_STEP = 3
SMALL_STRETCH = 0.15  # gamma / mu below which a beam hardly stretches
COARSE_ORDER = 6
SMALLEST_STEP = 1e-11  # of the load, when looking for the limit of equilibrium
LIMIT_BREAKS = (0.0, 1e-4, 1e-3, 1e-2, 0.1, 1.0)
LIMIT_ORDER = 12


class StraightModes(NamedTuple):
    """The lowest modes of both families on the mesh that met the tolerance."""

    mesh: Mesh
    f: np.ndarray  # (n,) stretch at the mesh points
    iterations: int
    bending: hp.Modes
    stretching: hp.Modes
    picks: np.ndarray  # (modes,) into bending then stretching laid end to end
    squares: np.ndarray  # (modes,) omega^2, ascending
    truncation: np.ndarray  # (modes,) error of omega^2 from the order of the mesh
    rounding: np.ndarray  # (modes,) error of omega^2 from rounding


def solve_straight(
    beam: Beam, modes: int, law: StrainLaw, curvature: Curvature, chordwise: bool, tolerance: float
) -> StraightModes:
    """Equilibrium and the lowest `modes` modes within the relative `tolerance`.

    Raises NoEquilibrium with the limit, NotConverged when refinement does not get there.
    """
    stretch = _typical_stretch(beam, law) if beam.gamma > SMALL_STRETCH * beam.mu else 1.0
    parts = segments(beam, stretch, law)
    breaks, order = discretisation(parts, beam.mu, modes, curvature, tolerance)
    for _ in range(REFINEMENTS):
        points = mesh(breaks, order)
        found = _solve_on(points, beam, modes, law, curvature, chordwise)
        # Rounding counts as met: no mesh mends it, and the reported error says it.
        allowed = 2 * tolerance * abs(found.squares) + found.rounding
        excess = (found.truncation / allowed).max()
        if excess <= 1:
            return found
        breaks, order = _refined(breaks, order)
    raise NotConverged(
        f"errors are {excess:.1e} times the tolerance {tolerance:g} after {REFINEMENTS}"
        f" refinements up to {points.elements} elements of order {points.order};"
        " ask for a larger tolerance or fewer modes"
    )


def _solve_on(
    points: Mesh,
    beam: Beam,
    modes: int,
    law: StrainLaw,
    curvature: Curvature,
    chordwise: bool,
) -> StraightModes:
    """Equilibrium and modes on one mesh."""
    rho = hp.inertia(points, beam.alpha, beam.beta)
    f, iterations = equilibrium(points, rho, beam, law)
    bending = hp.bending(points, rho, beam, f, curvature, modes)
    stretching = hp.stretching(points, rho, beam, f, law, modes)
    both = np.array([(*bending.squares, *stretching.squares), (*bending.lost, *stretching.lost)])
    softened = both[0] - beam.gamma**2
    if not chordwise:
        softened[:modes] = bending.squares
    picks = softened.argsort(kind="stable")[:modes]
    truncation, rounding = hp.errors(points, f, *both[:, picks])
    return StraightModes(
        points, f, iterations, bending, stretching, picks, softened[picks], truncation, rounding
    )


def _refined(breaks: tuple[float, ...], order: int) -> tuple[tuple[float, ...], int]:
    """The next finer mesh: a higher order, or halves of the elements once it is high."""
    if order + ORDER_STEP <= MAX_ORDER:
        return breaks, order + ORDER_STEP
    halves = [x for a, b in pairwise(breaks) for x in (a, (a + b) / 2)]
    return (*halves, breaks[-1]), MAX_ORDER - 2 * ORDER_STEP


def _typical_stretch(beam: Beam, law: StrainLaw) -> float:
    """The mean stretch, from a coarse equilibrium."""
    interior = beam.alpha > 0 and 0 < beam.beta < 1
    points = mesh((0.0, beam.beta, 1.0) if interior else (0.0, 1.0), COARSE_ORDER)
    f, _ = equilibrium(points, hp.inertia(points, beam.alpha, beam.beta), beam, law)
    return float(points.weights @ f)


def equilibrium(
    points: Mesh, rho: hp.Inertia, beam: Beam, law: StrainLaw
) -> tuple[np.ndarray, int]:
    """The stretch f (n,) at the mesh points and the Newton iterations it took.

    The full load first; where that leaves the stable branch, continuation in the load.
    """
    f = np.ones(len(points.weights))
    if not beam.gamma:
        return f, 0
    load = (beam.gamma / beam.mu) ** 2
    full, iterations = hp.newton(points, rho, beam.delta, law, load, f)
    if full is not None:
        return full, iterations
    f, reached, more = _follow(points, rho, beam.delta, law, load, f)
    if reached < load:
        raise _no_equilibrium(beam, law)
    return f, iterations + more


def _follow(
    points: Mesh, rho: hp.Inertia, delta: float, law: StrainLaw, load: float, f: np.ndarray
) -> tuple[np.ndarray, float, int]:
    """Continuation from no load towards `load`: stretch, load reached, iterations.

    The step doubles after success and halves after failure, so a limit is bracketed by
    bisection to SMALLEST_STEP.
    """
    reached, step, iterations = 0.0, load / 2, 0
    while reached < load and step > SMALLEST_STEP * load:
        target = min(reached + step, load)
        found, more = hp.newton(points, rho, delta, law, target, f)
        iterations += more
        if found is None:
            step /= 2
        else:
            f, reached, step = found, target, 2 * step
    return f, reached, iterations


def _no_equilibrium(beam: Beam, law: StrainLaw) -> NoEquilibrium:
    """The error that names the limit, computed on a mesh fine enough at the clamp."""
    interior = beam.alpha > 0 and 0 < beam.beta < 1
    breaks = sorted({*LIMIT_BREAKS, beam.beta} if interior else LIMIT_BREAKS)
    points = mesh(tuple(breaks), LIMIT_ORDER)
    rho = hp.inertia(points, beam.alpha, beam.beta)
    load = (beam.gamma / beam.mu) ** 2
    _, reached, _ = _follow(points, rho, beam.delta, law, load, np.ones_like(points.weights))
    limit = beam.mu * reached**0.5
    return NoEquilibrium(
        f"gamma = {beam.gamma:.6g}: no equilibrium beyond gamma = {limit:.6g}"
        f" ({law.name} strain, alpha = {beam.alpha:g}, beta = {beam.beta:g},"
        f" delta = {beam.delta:g}, mu = {beam.mu:g})",
        limit=limit,
    )
