"""The stretched equilibrium of straight beams on a mesh (paper, eq. 40, one component).

The unknown is the stretch f at the mesh points, (beams, n) for a stack of beams. Beams of small
strain, and those with a unique equilibrium, are solved by Newton's method from a first guess; any
other is followed from rest, alone, on its stable branch to its load or to the limit below it.
"""

import math
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import lapack

from beamviz.beam import Beam
from beamviz.errors import NoEquilibrium
from beamviz.solver.constitutive import StrainLaw, no_equilibrium
from beamviz.solver.continuation import Path, Root, continue_load
from beamviz.solver.hp.mesh import Mesh, make_mesh
from beamviz.solver.hp.mesh_design import unstretched_positions

SMALL_FORCE = 0.3  # force n below which the strain is small
SMALLER_INWARD = 0.2  # less in compression, of which green's law carries 0.19 at most
SERIES_FORCE = 0.1  # force n below which a few terms of the stretch in n make a good guess
GUESS_PASSES = 4  # of the guess for a large stretch
NEWTON_ITERATIONS = 12
SAME_TANGENT = 1e-4  # relative change of the stretch up to which a tangent is kept
NEWTON_STEP = 1e-7  # relative to the stretch: quadratic, the next one is below rounding
BOUND_SUFFICES = 0.5  # a lower bound of the margin that serves as the margin
LARGEST_RATIO = 0.5  # of successive passes, in the extrapolation of the guess
TINY = 1e-300
LIMIT_BREAKS = (0.0, 1e-4, 1e-3, 1e-2, 0.1, 1.0)
LIMIT_ORDER = 12
NEAR_LIMIT = 1.01  # load up to which a limit is looked for where a beam was not solved


class BeamStack(NamedTuple):
    """The numbers of a stack of beams, each (beams, 1), or a float in a stack of one."""

    alpha: Any
    beta: Any
    gamma: Any
    delta: Any
    mu: Any
    size: int
    outward: bool  # whether no beam points inward


State = tuple[Mesh, np.ndarray]  # the stretch f (1, n) of one beam on a mesh


def single(beam: Beam) -> BeamStack:
    """A stack of one."""
    alpha, beta, gamma, delta, mu = beam.alpha, beam.beta, beam.gamma, beam.delta, beam.mu
    return BeamStack(alpha, beta, gamma, delta, mu, 1, delta >= 0)


class Inertia(NamedTuple):
    """The line density rho = 1 + alpha Dirac(x - beta) in terms of a gradient on a mesh. Of arrays
    that the beams of a stack share, vectors have a leading axis of 1 and matrices none: numpy is
    fastest on arrays of the same shape."""

    weights: np.ndarray  # (1 or beams, n) of the mesh
    G: np.ndarray  # (..., n, n) mass matrix J' rho J
    G1: np.ndarray  # (1 or beams, n) G applied to the stretch of a beam at rest
    g: np.ndarray  # (1 or beams, n) static moment J' rho 1
    to_mass: np.ndarray | None  # (..., n) integrates from the clamp to the mass
    alpha: float | np.ndarray  # (..., 1)
    total: float | np.ndarray  # mass that pulls at the clamp


class AxialState(NamedTuple):
    """Equilibria of a stack of beams: the stretch f at the mesh points, the Newton iterations, the
    relative error of f, infinite where none was found, and the margin: 1 at rest, 0 at the limit,
    None where there is no limit."""

    f: np.ndarray  # (beams, n)
    iterations: int
    error: Any  # (beams,), or a float for all
    margin: np.ndarray | None = None  # (beams,)


def inertia(mesh: Mesh, beams: BeamStack) -> Inertia:
    """The inertia of beams whose mass sits on a break of the mesh."""
    alpha, beta = beams.alpha, beams.beta
    if beams.size == 1:
        return _shared_inertia(mesh, alpha, beta)
    if mesh.breaks.ndim == 1 and (alpha == alpha[0]).all() and (beta == beta[0]).all():
        return _shared_inertia(mesh, alpha.item(0), beta.item(0))
    return _with_mass(mesh, alpha, beta)


@lru_cache(maxsize=64)
def _shared_inertia(mesh: Mesh, alpha: float, beta: float) -> Inertia:
    """`_with_mass` of one mass, kept: a sweep or a slider of anything else leaves it as it is."""
    if not (alpha and beta):
        weights, G1, g = map(np.atleast_2d, (mesh.weights, mesh.G1, mesh.g))
        return Inertia(weights, mesh.G, G1, g, None, 0.0, 1.0)
    shared = _with_mass(mesh, alpha, beta)
    for array in (shared.G, shared.G1, shared.g, shared.to_mass):
        assert array is not None
        array.setflags(write=False)
    return shared


def _with_mass(mesh: Mesh, alpha: float | np.ndarray, beta: float | np.ndarray) -> Inertia:
    """A concentrated mass added to the inertia of the mesh."""
    to_mass = np.where(mesh.points < beta, mesh.weights, 0.0)
    carried = alpha * to_mass
    G = mesh.G + carried[..., None] * to_mass[..., None, :]
    total = 1.0 + alpha * (beta > 0)
    rows = mesh.weights, mesh.G1 + beta * carried, mesh.g + carried
    weights, G1, g = map(np.atleast_2d, rows)
    return Inertia(weights, G, G1, g, to_mass, alpha, total)


def greatest_force(beams: Beam | BeamStack) -> Any:
    """An upper bound of |n| of an unstretched beam, and for an outward one its value at the
    clamp: float, or (beams, 1)."""
    hub: Any = abs(beams.delta)
    moment = 0.5 + hub + beams.alpha * (beams.beta + hub)
    return (beams.gamma / beams.mu) ** 2 * moment


def is_small_strain(beams: Beam | BeamStack) -> Any:
    """Whether the force is small all along: bool, or (beams, 1)."""
    return greatest_force(beams) < SMALL_FORCE - SMALLER_INWARD * (beams.delta < 0)


def has_unique_equilibrium(beams: Beam | BeamStack, law: StrainLaw) -> Any:
    """Whether Newton's method has no other state to run into than the stable one: bool, or
    (beams, 1)."""
    return (beams.delta >= 0) & (law.max_stretch == math.inf)


def equilibrium(
    mesh: Mesh,
    inertia: Inertia,
    beams: BeamStack,
    law: StrainLaw,
    start: State | None = None,
    accept_error: float = 0.0,
) -> AxialState:
    """The equilibria of a stack of beams on a mesh.

    start: the state of a single beam on another mesh. accept_error: relative error of f that need
    not be reduced; near a limit, where a small residual is a large error, none is accepted.
    Of several beams all are of small strain or have a unique equilibrium; a single one may be any,
    and raises NoEquilibrium where there is none.
    """
    load = (beams.gamma / beams.mu) ** 2
    if beams.size == 1 and not load:
        return AxialState(np.ones((1, mesh.weights.shape[-1])), 0, 0.0)
    limited = not (law.hardens and beams.outward)
    if limited:
        accept_error = 0.0
    f, error = _first_guess(mesh, inertia, beams, law, start, accept_error)
    if f is not None:
        if error < accept_error:
            return AxialState(f, 0, error)
        state = newton(mesh, inertia, beams, law, load, f, accept_error)
        if limited:
            left = margin(mesh, inertia, beams, law, load, state.f)
            left[state.error == math.inf] = 1.0
            error = np.where(left > 0, state.error, math.inf)
            state = AxialState(state.f, state.iterations, error, np.where(left > 0, left, 1.0))
        if beams.size > 1 or state.error[0] < math.inf:
            return state
    path = _follow(mesh, inertia, beams, law, load)
    if path.limit is None:
        left = margin(mesh, inertia, beams, law, load, path.state)
        return AxialState(path.state, path.iterations, 0.0, left)
    beam = Beam(*beams[:5])
    raise limit_error(beam, law) or no_equilibrium(beam, beam.mu * path.limit**0.5, law)


def _first_guess(
    mesh: Mesh,
    inertia: Inertia,
    beams: BeamStack,
    law: StrainLaw,
    start: State | None,
    accept_error: float,
) -> tuple[np.ndarray | None, float]:
    """A stretch (beams, n) to start Newton's method from and its relative error; None where it
    might lead to another branch."""
    if start is not None:
        mesh_of_start, f = start
        return f @ mesh_of_start.at(mesh.points).T, math.inf
    force = greatest_force(beams)
    if beams.size > 1:
        force = force.max()
    if force < SMALL_FORCE:
        passes = 1 if force**2 < accept_error else 2
        stretch = law.stretch_series if force < SERIES_FORCE else law.stretch
    elif beams.size > 1 or has_unique_equilibrium(beams, law):
        passes, stretch = GUESS_PASSES, law.stretch
    else:
        return None, math.inf
    # Each pass takes the force n = load (G f + delta g) / w from the stretch before it. It adds a
    # share of what the one before it did, much the same all along a beam of small strain as at its
    # clamp: two passes give the sum of all. With n at the clamp of an outward beam, one pass errs
    # by about n^2, two by less than n^3.
    pull = (beams.gamma / beams.mu) ** 2 / inertia.weights
    static = beams.delta * inertia.g
    f = first = stretch(pull * (inertia.G1 + static))
    for _ in range(passes - 1):
        f = stretch(pull * (np.matvec(inertia.G, f) + static))
    if passes == 2:
        more = f - first
        ratio = np.minimum(at_clamp(more) / (at_clamp(first) - 1 + TINY), LARGEST_RATIO)
        f = f + more * (ratio / (1 - ratio))
    return f, force ** (passes + 1) if force < SMALL_FORCE else math.inf


def newton(
    mesh: Mesh,
    inertia: Inertia,
    beams: BeamStack,
    law: StrainLaw,
    load: Any,
    f: np.ndarray,
    accept_error: float = 0.0,
) -> AxialState:
    """The stretch f (beams, n) in equilibrium at load = (gamma / mu)^2, by Newton-Raphson from f.

    Beams that converged on the stable branch have a finite error, though perhaps more force at the
    clamp than the law carries: `margin` tells. The f of the others is 1.

    The residual is w n(f) - load (G f + delta g), the paper's eq. 40 for a straight beam.
    """
    A = load * inertia.G if beams.size == 1 else load[..., None] * inertia.G
    w, static = inertia.weights, load * beams.delta * inertia.g
    step, accepted, iteration = np.empty(f.shape), max(accept_error, NEWTON_STEP**2), 0
    renew, largest = True, math.inf
    while iteration < NEWTON_ITERATIONS and largest >= accepted:
        iteration += 1
        residual = w * law.force(f) - np.matvec(A, f) - static
        if renew:
            tangent = mesh.eye * (w * law.stiffness(f))[:, None, :] - A
        for k in range(len(f)):
            if renew:  # its factors take the place of the tangent
                _, step[k], info = lapack.dposv(tangent[k].T, residual[k], overwrite_a=True)
            else:
                step[k], info = lapack.dpotrs(tangent[k].T, residual[k])
            if info:  # not positive definite: the branch of stable states was left
                step[k] = np.nan
        f = f - step
        error = np.vecdot(step, step) / f[:, 0] ** 2
        if renew:  # quadratic
            first = error
        else:
            error = np.sqrt(first * error)
        largest = np.fmax.reduce(error)
        renew = renew and not largest < SAME_TANGENT**2
    stable = (error < accepted) & (np.minimum.reduce(f, axis=-1) > law.min_stretch)
    if law.max_stretch < math.inf:
        stable &= np.maximum.reduce(f, axis=-1) < law.max_stretch
    if not np.logical_and.reduce(stable):
        f, error = np.where(stable[:, None], f, 1.0), np.where(stable, error, math.inf)
    return AxialState(f, iteration, error)


@np.errstate(all="ignore")  # in iterations that diverge, which do not converge
def _follow(mesh: Mesh, inertia: Inertia, beam: BeamStack, law: StrainLaw, load: float) -> Path:
    """Continuation of the stable branch from no load towards `load` = (gamma / mu)^2."""

    def solve_at(trial: float, guess: np.ndarray) -> Root | None:
        state = newton(mesh, inertia, beam, law, trial, guess)
        left = _left_at_clamp(inertia, beam, law, trial, state.f)[0]
        held = left > 0 and state.error[0] < math.inf
        return Root(state.f, state.iterations) if held else None

    def margin_at(reached: float, f: np.ndarray) -> float:
        return float(margin(mesh, inertia, beam, law, reached, f, math.inf)[0])

    return continue_load(solve_at, np.ones((1, mesh.weights.shape[-1])), load, margin_at)


def limit_error(beam: Beam, law: StrainLaw) -> NoEquilibrium | None:
    """The error of a beam beyond its limit of equilibrium, or too near it to be solved, on a mesh
    that is fine where a force law ends; None where there is no limit."""
    breaks = sorted({*LIMIT_BREAKS, *unstretched_positions(beam).ends})
    mesh = make_mesh(tuple(breaks), (LIMIT_ORDER,) * (len(breaks) - 1))
    load = NEAR_LIMIT * (beam.gamma / beam.mu) ** 2
    stack = single(beam)
    path = _follow(mesh, inertia(mesh, stack), stack, law, load)
    return None if path.limit is None else no_equilibrium(beam, beam.mu * path.limit**0.5, law)


def margin(
    mesh: Mesh,
    inertia: Inertia,
    beams: BeamStack,
    law: StrainLaw,
    load: Any,
    f: np.ndarray,
    bound: float = BOUND_SUFFICES,
) -> np.ndarray:
    """How far equilibria (beams, n) are from their limit: 1 at rest, falling to 0 there, (beams,).

    The least eigenvalue of the tangent relative to rest (a fold), or what the law has left at the
    clamp, whichever is less. The eigenvalue is at least the least ratio of (tangent x) to w x for
    any x > 0 (Collatz and Wielandt), here the displacement under a uniform load: close enough to
    take its place from `bound` on.
    """
    stiffness = law.stiffness(f)
    pull = np.matvec(inertia.G, inertia.G1 / inertia.weights) / inertia.G1
    fold = np.minimum.reduce(stiffness - load * pull, axis=-1)
    near = (fold < bound).nonzero()[0]
    if len(near):
        scale = 1 / np.sqrt(mesh.weights)
        A = scale[..., None] * inertia.G * scale[..., None, :]
        A = load * A if beams.size == 1 else load[..., None] * A
        tangents = mesh.eye * stiffness[:, None, :] - A
        for k in near:
            fold[k] = np.linalg.eigvalsh(tangents[k])[0]
    return np.minimum(fold, _left_at_clamp(inertia, beams, law, load, f))


def _left_at_clamp(
    inertia: Inertia, beams: BeamStack, law: StrainLaw, load: Any, f: np.ndarray
) -> np.ndarray:
    """The share (beams,) of its greatest force, in tension and compression, that the law has left
    at the clamp, where the force of most beams is greatest."""
    least, most = law.forces
    force = load * (np.vecdot(inertia.g, f)[:, None] + beams.delta * inertia.total)
    return (1 - np.maximum(force / most, force / least))[:, 0]


def at_clamp(values: np.ndarray) -> Any:
    """Values (beams, n) at the first point: (beams, 1), or a float in a stack of one."""
    return values[:, :1] if len(values) > 1 else values.item(0)


def diagonal(A: np.ndarray) -> np.ndarray:
    """The diagonals of contiguous matrices (..., n, n), as a view (..., n) to write to."""
    return A.reshape(*A.shape[:-2], -1)[..., :: A.shape[-1] + 1]
