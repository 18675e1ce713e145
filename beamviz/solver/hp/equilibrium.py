"""The stretched equilibrium of a straight beam on a mesh (paper, eq. 40, one component).

The unknown is the stretch f at the mesh points. A beam that hardly stretches, or that has one
state only, is solved at once from a guess; any other is followed from rest, on its stable
branch, to its load or to the limit below it.
"""

import math
from typing import Any

import numpy as np
from scipy.linalg import lapack

from beamviz.beam import Beam
from beamviz.errors import NotConverged
from beamviz.solver import constitutive
from beamviz.solver.constitutive import Function, StrainLaw
from beamviz.solver.continuation import Path, Root, continue_load
from beamviz.solver.hp.matrices import Inertia, Numbers, Stretch, diagonal, inertia
from beamviz.solver.hp.mesh import Mesh, mesh
from beamviz.solver.hp.mesh_design import unstretched

SMALL_FORCE = 0.3  # n below which a beam hardly stretches
LESS_INWARDS = 0.2  # so much less of compression, of which green's law carries 0.19 at most
GENTLE_FORCE = 0.1  # below which a few terms of the stretch in n are as good as a guess needs
MANY_PASSES = 6  # of a guess for beams that stretch far
NEWTON_ITERATIONS = 12
NEWTON_STEP = 1e-7  # relative to the stretch at the clamp: quadratic, the next is below rounding
SAME_TANGENT = 1e-3  # stretch within which a tangent is as good as new
NEUMANN_TERMS = 3
FAR_FROM_END = 0.1  # least margin of beams solved together: nearer, its bound is too rough
MOST = 0.7  # a bound of the margin that is as good as the margin
LARGEST_SHARE = 0.5  # of one pass in the next, that is believed
TINY = 1e-300
LIMIT_BREAKS = (0.0, 1e-4, 1e-3, 1e-2, 0.1, 1.0)
LIMIT_ORDER = 12

State = tuple[Mesh, np.ndarray]  # the stretch f (n,) at the points of a mesh


def greatest_force(beam: Beam | Numbers) -> Any:
    """What the force n is at most anywhere, without what the stretch adds; of one beam or of
    many. Of an outward beam it is that at the clamp."""
    hub: Any = abs(beam.delta)
    moment = 0.5 + hub + beam.alpha * (beam.beta + hub)
    return (beam.gamma / beam.mu) ** 2 * moment


def hardly_stretches(beam: Beam | Numbers) -> Any:
    """Whether the force is small all along; of one beam or of many."""
    return greatest_force(beam) < SMALL_FORCE - LESS_INWARDS * (beam.delta < 0)


def one_state(beam: Beam | Numbers, law: StrainLaw) -> Any:
    """Whether there is no other state to run into than the stable one, of one beam or of many."""
    return (beam.delta >= 0) & (law.max_stretch == math.inf)


def equilibrium(
    points: Mesh,
    rho: Inertia,
    beam: Beam,
    law: StrainLaw,
    near: State | None = None,
    enough: float = 0.0,
) -> Stretch:
    """The equilibrium on a mesh.

    A small load at once, and so a large one from the state `near` it; any other, or one near a
    limit, by continuation from rest. To rounding, or `enough` near to be left at that.
    """
    if not beam.gamma:
        return Stretch(np.ones(len(points.weights)), 0, 0.0)
    load, one = (beam.gamma / beam.mu) ** 2, one_state(beam, law)
    if not one:  # near a limit a small residual is a long way from equilibrium
        enough = 0.0
    if near is None:
        guess = _guess(points, rho, beam, law, enough)
    else:
        elsewhere, f = near
        guess = Stretch(elsewhere.at(points.points) @ f, 0, math.inf)
    if guess is not None:
        if guess.off < enough:
            return guess
        found = newton(points, rho, beam.delta, law, load, guess.f, enough)
        if found is not None and one:
            return found
        if found is not None and (left := _margin(points, rho, beam, law, load, found.f)) > 0:
            return found._replace(margin=left)
    path = _follow(points, rho, beam.delta, law, load)
    if path.limit is None:
        left = _margin(points, rho, beam, law, load, path.state)
        return Stretch(path.state, path.iterations, 0.0, left)
    limit = _limit(beam, law, load)
    if limit < beam.gamma:
        raise constitutive.no_equilibrium(beam, limit, law)
    raise NotConverged(
        f"gamma = {beam.gamma:.9g}: so close to the limit of equilibrium, gamma = {limit:.9g},"
        f" that the mesh of {points.elements} elements does not reach it"
    )


def _guess(points: Mesh, rho: Inertia, beam: Beam, law: StrainLaw, enough: float) -> Stretch | None:
    """The stretch of a beam that hardly stretches, in one pass where that is `enough` near, or of
    one that has one state only; None of any other."""
    force = greatest_force(beam)
    if force < SMALL_FORCE:
        passes = 1 if force**2 < enough else 2
        stretch = law.gentle_stretch if force < GENTLE_FORCE else law.stretch
        f = first_guess(points, rho, beam, stretch, passes)
        return Stretch(f, 0, force ** (passes + 1))
    if one_state(beam, law):
        return Stretch(first_guess(points, rho, beam, law.stretch, MANY_PASSES), 0, math.inf)
    return None


def _follow(points: Mesh, rho: Inertia, delta: float, law: StrainLaw, load: float) -> Path:
    """Continuation of the stable branch from no load towards `load` = (gamma / mu)^2."""

    def solve_at(trial: float, guess: np.ndarray) -> Root | None:
        found = newton(points, rho, delta, law, trial, guess)
        return None if found is None else Root(found.f, found.iterations)

    def left(reached: float, f: np.ndarray) -> float:
        return margin(points, rho, delta, law, reached, f)

    return continue_load(solve_at, np.ones(len(points.weights)), load, left)


def _limit(beam: Beam, law: StrainLaw, load: float) -> float:
    """The largest gamma with an equilibrium, on a mesh fine enough where a force law ends."""
    breaks = sorted({*LIMIT_BREAKS, *unstretched(beam).ends})
    points = mesh(tuple(breaks), (LIMIT_ORDER,) * (len(breaks) - 1))
    rho = inertia(points, beam)
    path = _follow(points, rho, beam.delta, law, load)
    return beam.mu * (load if path.limit is None else path.limit) ** 0.5


def newton(
    mesh: Mesh,
    rho: Inertia,
    delta: float,
    law: StrainLaw,
    load: float,
    f: np.ndarray,
    enough: float = 0.0,
) -> Stretch | None:
    """The stretch f (n,) in equilibrium at load = (gamma / mu)^2, by Newton-Raphson from f.

    The residual is w n(f) - load (G f + delta g), the paper's eq. 40 for a straight beam. A
    tangent serves as long as f has hardly moved from where it was taken: each step then errs by
    its own size times that distance.
    Returns None where an iterate leaves the stable branch.
    """
    w, A, b = mesh.weights, load * rho.G, (load * delta) * rho.g
    moved, least = math.inf, f.item(f.argmin())  # least: a lower bound of f from here on
    if least <= law.min_stretch:
        return None
    for iteration in range(1, NEWTON_ITERATIONS + 1):
        residual = w * law.force(f) - A @ f - b
        if moved > SAME_TANGENT:
            tangent = mesh.eye * (w * law.stiffness(f)) - A
            factor, step, info = lapack.dposv(tangent.T, residual, overwrite_a=True)
            moved = 0.0
        else:
            step, info = lapack.dpotrs(factor, residual)
        if info:
            return None
        f = f - step
        size = math.sqrt(step @ step)
        moved, least = moved + size, least - size
        if least <= law.min_stretch:
            least = float(f.min())
            if least <= law.min_stretch:
                return None
        off = moved * size / f.item(0) ** 2
        if off < NEWTON_STEP**2 or off < enough:
            unbounded = law.max_stretch == math.inf
            held = unbounded or f.max() < law.max_stretch
            if held and not (unbounded and delta >= 0):
                held = _left_at_clamp(rho, delta, law, load, f) > 0
            return Stretch(f, iteration, off) if held else None
    return None


def newton_many(
    mesh: Mesh, rho: Inertia, beams: Numbers, law: StrainLaw, load: np.ndarray, f: np.ndarray
) -> tuple[Stretch, np.ndarray]:
    """As `newton`, for many beams (beams, n) that hardly stretch or have one state only: no watch
    is kept on the branch, so a state that may be near a limit does not count. Also says which
    count; the rest is 1.

    The tangent D - A, D diagonal and A = load G the smaller, is inverted by a few terms of
    D^-1 + D^-1 A D^-1 + ...: for many that takes less than their factors.
    """
    w, static = mesh.weights, beams.delta * rho.g

    def pulled(f: np.ndarray) -> np.ndarray:
        return load * np.matvec(rho.G, f)

    iteration, size, converged = 0, np.zeros(len(f)), np.zeros(len(f), bool)
    with np.errstate(all="ignore"):  # what runs away is not converged
        while iteration < NEWTON_ITERATIONS and not converged.all():
            iteration += 1
            residual, D = w * law.force(f) - pulled(f) - load * static, w * law.stiffness(f)
            step = residual / D
            for _ in range(NEUMANN_TERMS - 1):
                step = (residual + pulled(step)) / D
            f = f - step
            previous, size = size, abs(step).max(axis=-1)
            rate = size / np.where(previous > size, previous, np.maximum(size, 1e-300))
            converged = rate * size < NEWTON_STEP**2
    sound = converged & (f.min(axis=-1) > law.min_stretch)
    one = one_state(beams, law)[:, 0]
    if one.all():
        return Stretch(np.where(sound[:, None], f, 1.0), iteration, NEWTON_STEP**2), sound
    f = np.where(sound[:, None], f, 1.0)
    left = np.where(one, 1.0, least_margin(mesh, rho, beams.delta, law, load, f))
    sound &= left > FAR_FROM_END
    return Stretch(f, iteration, NEWTON_STEP**2, np.where(sound, left, 1.0)), sound


def first_guess(
    mesh: Mesh, rho: Inertia, beam: Beam | Numbers, stretch: Function, passes: int
) -> np.ndarray:
    """The stretch (..., n) of one beam or many from the force of each as it was before,
    n = load (G f + delta g) / w, again and again from rest. stretch: of a force, by their law.

    Each pass adds a share of what the one before it did, much the same share all along a beam that
    hardly stretches as at its clamp: two passes say what all the others would add. With a force n
    at the clamp of an outward beam, one pass is off by about n^2, two by less than n^3.
    """
    pull = (beam.gamma / beam.mu) ** 2 / mesh.weights
    static = beam.delta * rho.g
    f = stretch(pull * (rho.G1 + static))
    if passes == 2:
        first, f = f, stretch(pull * (np.matvec(rho.G, f) + static))
        more = f - first
        share = more[..., :1] / (first[..., :1] - 1 + TINY)
        share = np.minimum(share, LARGEST_SHARE)
        return f + more * (share / (1 - share))
    for _ in range(passes - 1):
        f = stretch(pull * (np.matvec(rho.G, f) + static))
    return f


def _left_at_clamp(
    rho: Inertia, delta: float | np.ndarray, law: StrainLaw, load: Any, f: np.ndarray
) -> Any:
    """The share (...) of its greatest force, in tension and compression, that the law has left at
    the clamp, which no Gauss point sees. Of one beam or of many."""
    least, most = law.forces
    force = load * (np.vecdot(rho.g, f)[..., None] + delta * rho.total)
    return (1 - np.maximum(force / most, force / least))[..., 0]


def _margin(
    mesh: Mesh, rho: Inertia, beam: Beam, law: StrainLaw, load: float, f: np.ndarray
) -> float:
    """`margin`, or what it is at least where that is most of it."""
    least = least_margin(mesh, rho, beam.delta, law, load, f)
    return least if least > MOST else margin(mesh, rho, beam.delta, law, load, f)


def margin(
    mesh: Mesh, rho: Inertia, delta: float, law: StrainLaw, load: float, f: np.ndarray
) -> float:
    """How far an equilibrium is from its end: 1 at rest, falling to 0 there.

    The least eigenvalue of the tangent relative to rest (a fold), or what the law has left at
    the clamp, whichever is less.
    """
    scale = 1 / np.sqrt(mesh.weights)[:, None]
    tangent = np.diag(law.stiffness(f)) - load * scale * rho.G * scale.T
    return min(np.linalg.eigvalsh(tangent)[0], _left_at_clamp(rho, delta, law, load, f))


def least_margin(
    mesh: Mesh, rho: Inertia, delta: float | np.ndarray, law: StrainLaw, load: Any, f: np.ndarray
) -> Any:
    """What `margin` (...) is at least, of one beam or of many, without an eigenproblem: the
    greatest pull is less than the trace of all of them."""
    trace = (diagonal(rho.G) / mesh.weights).sum(axis=-1)
    fold = law.stiffness(f).min(axis=-1) - (load * trace[..., None])[..., 0]
    return np.minimum(fold, _left_at_clamp(rho, delta, law, load, f))
