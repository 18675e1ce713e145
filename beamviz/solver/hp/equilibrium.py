"""The stretched equilibrium of straight beams on a mesh (paper, eq. 40, one component).

The unknown is the stretch f at the mesh points, (beams, n) for a stack of beams. Beams of small
strain, and those with a unique equilibrium, are solved by Newton's method from a first guess; any
other is followed from rest, alone, on its stable branch to its load or to the limit below it.
"""

import math
from functools import lru_cache, partial
from itertools import accumulate
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import lapack

from beamviz.beam import Beam
from beamviz.errors import NoEquilibrium
from beamviz.solver.constitutive import StrainLaw, no_equilibrium
from beamviz.solver.continuation import Root, continue_load
from beamviz.solver.hp.mesh import Mesh, make_mesh
from beamviz.solver.hp.mesh_design import Positions, unstretched_positions

SMALL_FORCE = 0.3  # force n below which the strain is small
SMALLER_INWARD = 0.2  # reduction of SMALL_FORCE in compression: Green's law has n >= -0.19
SERIES_FORCE = 0.1  # force n below which the series of the stretch in n is used in the guess
# Relative error of the guess for an outward beam of Green's law, n the force at its clamp: n^2
# after one iteration; (TWO_PASSES + SERIES_END n) n^3 after two: twice the largest of 6000 random
# beams, and the first term that the series omits.
TWO_PASSES, SERIES_END = 0.1, 14.0
GUESS_PASSES = 3  # iterations of the guess for a large stretch
NEWTON_ITERATIONS = 12
SAME_TANGENT = 1e-4  # relative change of the stretch up to which a tangent is kept
NEWTON_STEP = 1e-7  # relative to the stretch: by quadratic convergence the next is below rounding
BOUND_SUFFICES = 0.5  # lower bound of the margin from which it is taken for the margin
LARGEST_RATIO = 0.5  # of successive increments, in the extrapolation of the guess
TINY = 1e-300
COARSE_ORDER, COARSE_ERROR = 6, 1e-6  # of the equilibrium from which a mesh is designed
LIMIT_BREAKS = (0.0, 1e-4, 1e-3, 1e-2, 0.1, 1.0)  # mesh on which a limit is located
LIMIT_ORDER = 12
NEAR_LIMIT = 1.01  # relative load up to which a limit is searched for a beam that was not solved


State = tuple[Mesh, np.ndarray]  # the stretch f (1, n) of one beam on a mesh


class BeamStack(NamedTuple):
    """The parameters of a stack of beams, each (beams, 1), or a float in a stack of one."""

    alpha: Any
    beta: Any
    gamma: Any
    delta: Any
    mu: Any
    size: int
    outward: bool  # whether no beam points inward


def single(beam: Beam) -> BeamStack:
    """A stack of one beam."""
    return BeamStack(beam.alpha, beam.beta, beam.gamma, beam.delta, beam.mu, 1, beam.delta >= 0)


class Inertia(NamedTuple):
    """The inertia of the line density rho = 1 + alpha Dirac(x - beta) in terms of the gradient of
    the displacement on a mesh. Of arrays that the beams of a stack share, vectors have a leading
    axis of 1 and matrices none: numpy is fastest on arrays of the same shape."""

    weights: np.ndarray  # (1 or beams, n) of the mesh
    G: np.ndarray  # (..., n, n) mass matrix J' rho J
    G1: np.ndarray  # (1 or beams, n) G applied to the stretch of a beam at rest
    g: np.ndarray  # (1 or beams, n) static moment J' rho 1
    to_mass: np.ndarray  # (..., n) integrates from the clamp to the mass
    alpha: float | np.ndarray  # (..., 1)
    total: float | np.ndarray  # mass outboard of the clamp


class AxialState(NamedTuple):
    """Equilibria of a stack of beams."""

    f: np.ndarray  # (beams, n) stretch at the mesh points
    iterations: int  # of Newton's method
    error: Any  # (beams,), or a float for all: relative, of f; infinite where not converged
    margin: np.ndarray | None = None  # (beams,) 1 at rest, 0 at the limit; None without a limit


def axial_problem(mesh: Mesh, beams: BeamStack, law: StrainLaw) -> "AxialProblem":
    """The problem of beams whose mass sits on a break of the mesh."""
    alpha, beta = beams.alpha, beams.beta
    if beams.size == 1:
        inertia = _inertia(mesh, alpha, beta)
    elif mesh.breaks.ndim == 1 and (alpha == alpha[0]).all() and (beta == beta[0]).all():
        inertia = _inertia(mesh, alpha.item(0), beta.item(0))
    else:
        inertia = _inertia.__wrapped__(mesh, alpha, beta)
    return AxialProblem(mesh, inertia, beams, law)


@lru_cache(maxsize=64)
def _inertia(mesh: Mesh, alpha: float | np.ndarray, beta: float | np.ndarray) -> Inertia:
    """The inertia of the mesh with a mass, cached: sweeps of other parameters keep the mass."""
    to_mass = np.where(mesh.points < beta, mesh.weights, 0.0)
    carried = alpha * to_mass
    G = mesh.G + carried[..., None] * to_mass[..., None, :]
    rows = mesh.weights, mesh.G1 + beta * carried, mesh.g + carried
    weights, G1, g = map(np.atleast_2d, rows)
    return Inertia(weights, G, G1, g, to_mass, alpha, 1.0 + alpha * (beta > 0))


def greatest_force(beams: Beam | BeamStack, load: Any = None) -> Any:
    """An upper bound of |n| of an unstretched beam, for an outward one its value at the clamp:
    float, or (beams, 1). load: replaces (gamma / mu)^2."""
    hub: Any = abs(beams.delta)
    moment = 0.5 + hub + beams.alpha * (beams.beta + hub)
    return ((beams.gamma / beams.mu) ** 2 if load is None else load) * moment


def is_small_strain(beams: Beam | BeamStack) -> Any:
    """Whether the force is small along the whole beam: bool, or (beams, 1)."""
    return greatest_force(beams) < SMALL_FORCE - SMALLER_INWARD * (beams.delta < 0)


def has_unique_equilibrium(beams: Beam | BeamStack, law: StrainLaw) -> Any:
    """Whether Newton's method can converge to the stable state only: bool, or (beams, 1)."""
    return (beams.delta >= 0) & (law.max_stretch == math.inf)


class AxialProblem(NamedTuple):
    """A stack of beams on a mesh, and their equilibrium w n(f) = load (G f + delta g) with
    load = (gamma / mu)^2, the paper's eq. 40 for a straight beam.

    In a stack of several, each beam must be of small strain or have a unique equilibrium.
    """

    mesh: Mesh
    inertia: Inertia
    beams: BeamStack
    law: StrainLaw

    def solve(self, start: State | None = None, accept_error: float = 0.0) -> AxialState:
        """The equilibria, with an infinite error where Newton's method failed for one of several;
        a single beam is then solved by continuation, which raises NoEquilibrium with the limit.

        start: the state of a single beam on another mesh. accept_error: relative error of f at
        which iteration ends; 0 if there is a limit, near which a small residual is a large error.
        """
        beams, law = self.beams, self.law
        load = (beams.gamma / beams.mu) ** 2
        if beams.size == 1 and not load:
            return AxialState(np.ones((1, self.mesh.weights.shape[-1])), 0, 0.0)
        limited = not (law.hardens and beams.outward)
        if limited:
            accept_error = 0.0
        f, error = self.first_guess(load, start, accept_error)
        if f is not None:
            if error < accept_error:
                return AxialState(f, 0, error)
            state = self.newton(load, f, accept_error)
            if limited:
                left = self.margin(load, state.f)
                left[state.error == math.inf] = 1.0
                found = left > 0
                state = state._replace(
                    error=np.where(found, state.error, math.inf), margin=np.where(found, left, 1.0)
                )
            if beams.size > 1 or state.error[0] < math.inf:
                return state
        path = self.follow(load)
        if path.limit is None:
            return AxialState(path.state, path.iterations, 0.0, self.margin(load, path.state))
        raise no_equilibrium(Beam(*beams[:5]), beams.mu * path.limit**0.5, law)

    def first_guess(
        self, load: Any, start: State | None, accept_error: float
    ) -> tuple[np.ndarray | None, float]:
        """First guess (beams, n) of the stretch for Newton's method and its relative error; None
        where the iteration might converge to another branch."""
        inertia, beams, law = self.inertia, self.beams, self.law
        if start is not None:
            mesh_of_start, f = start
            return f @ mesh_of_start.at(self.mesh.points).T, math.inf
        force = greatest_force(beams)
        if beams.size > 1:
            force = force.max()
        if force < SMALL_FORCE:
            passes, error = 1, force**2
            if error >= accept_error:
                passes, error = 2, (TWO_PASSES + SERIES_END * force) * force**3
        elif beams.size > 1 or has_unique_equilibrium(beams, law):
            passes, error = GUESS_PASSES, math.inf
        else:
            return None, math.inf
        # Fixed-point iteration with the force n = load (G f + delta g) / w. Its increments are
        # nearly a geometric series, with the same ratio along a beam of small strain as at its
        # clamp: two iterations give the sum.
        stretch = law.stretch_series if force < SERIES_FORCE else law.stretch
        pull, static = load / inertia.weights, beams.delta * inertia.g
        f = stretch(pull * (inertia.G1 + static))
        more = f - 1
        for _ in range(passes - 1):
            before, rest = more, f
            f = stretch(pull * (np.matvec(inertia.G, f) + static))
            more = f - rest
        if passes > 1:
            ratio = np.minimum(more[:, :1] / (before[:, :1] + TINY), LARGEST_RATIO)  # at the clamp
            f = rest + more / (1 - ratio)
        return f, error

    def newton(self, load: Any, f: np.ndarray, accept_error: float = 0.0) -> AxialState:
        """The stretch f (beams, n) in equilibrium at a load, by Newton-Raphson from f.

        The error is infinite, and f is 1, where it does not converge on the stable branch. The
        force at the clamp may still exceed that of the strain law: see `margin`.
        """
        inertia, beams, law = self.inertia, self.beams, self.law
        A = load * inertia.G if beams.size == 1 else load[..., None] * inertia.G
        w, static = inertia.weights, (load * beams.delta) * inertia.g
        accepted, iteration, renew, largest = max(accept_error, NEWTON_STEP**2), 0, True, math.inf
        while iteration < NEWTON_ITERATIONS and largest >= accepted:
            iteration += 1
            step = w * law.force(f) - np.matvec(A, f) - static  # the residual; solved in place
            if renew:
                tangent = self.mesh.eye * (w * law.stiffness(f))[:, None, :] - A
            for k in range(len(f)):
                if renew:  # the tangent is replaced by its factors
                    *_, info = lapack.dposv(tangent[k].T, step[k], 0, True, True)
                else:
                    _, info = lapack.dpotrs(tangent[k].T, step[k], 0, True)
                if info:  # not positive definite: off the stable branch
                    step[k] = np.nan
            f = f - step
            error = np.vecdot(step, step) / f[:, 0] ** 2
            if renew:  # quadratic convergence
                first = error
            else:
                error = np.sqrt(first * error)
            largest = np.fmax.reduce(error) if len(f) > 1 else error.item(0)
            renew = renew and not largest < SAME_TANGENT**2
        low, high = law.min_stretch, law.max_stretch
        inside = np.minimum.reduce(f, axis=None) > low and (high == math.inf or f.max() < high)
        if not (inside and largest < accepted):  # also where nan
            stable = (error < accepted) & (f.min(axis=-1) > low) & (f.max(axis=-1) < high)
            f, error = np.where(stable[:, None], f, 1.0), np.where(stable, error, math.inf)
        return AxialState(f, iteration, error)

    @np.errstate(all="ignore")  # a diverging iteration is detected
    def follow(self, load: float) -> Root:
        """Continuation of the stable branch of a single beam from rest to a load."""

        def solve_at(trial: float, guess: np.ndarray) -> Root | None:
            f, iterations, error, _ = self.newton(trial, guess)
            return Root(f, iterations) if error[0] < math.inf else None

        margin = partial(self.margin, bound=math.inf)
        return continue_load(solve_at, np.ones((1, len(self.mesh.points))), load, margin)

    def margin(self, load: Any, f: np.ndarray, bound: float = BOUND_SUFFICES) -> np.ndarray:
        """Stability margins (beams,) of equilibria f (beams, n): 1 at rest, 0 at the limit.

        The lesser of `left_at_clamp` and the least eigenvalue of the tangent relative to rest, zero
        at a fold. A lower bound of the eigenvalue is the least ratio of (tangent x) to w x for any
        x > 0 (Collatz and Wielandt), here the displacement under a uniform load; it replaces the
        eigenvalue where it is at least `bound`.
        """
        weights, (_, G, G1, *_) = self.mesh.weights, self.inertia
        stiffness = self.law.stiffness(f)
        pull = np.matvec(G, G1 / weights) / G1
        fold = np.minimum.reduce(stiffness - load * pull, axis=-1)
        near = (fold < bound).nonzero()[0]
        if len(near):
            scale = 1 / np.sqrt(weights)
            A = scale[..., None] * G * scale[..., None, :]
            A = load * A if self.beams.size == 1 else load[..., None] * A
            tangents = self.mesh.eye * stiffness[:, None, :] - A
            for k in near:
                fold[k] = np.linalg.eigvalsh(tangents[k])[0]
        return np.minimum(fold, self.left_at_clamp(load, f))

    def left_at_clamp(self, load: Any, f: np.ndarray) -> np.ndarray:
        """1 - (force at the clamp / greatest force of the strain law), (beams,), in tension or in
        compression; the force of most beams is greatest at the clamp."""
        least, most = self.law.force_limits
        moment = np.vecdot(self.inertia.g, f)[:, None] + self.beams.delta * self.inertia.total
        force = load * moment
        return (1 - np.maximum(force / most, force / least))[:, 0]


def limit_error(beam: Beam, law: StrainLaw) -> NoEquilibrium | None:
    """The error of a beam beyond its limit of equilibrium or too near it, located on a mesh that is
    fine at the clamp; None where there is no limit. Raises NotConverged."""
    breaks = sorted({*LIMIT_BREAKS, *unstretched_positions(beam).ends})
    mesh = make_mesh(tuple(breaks), (LIMIT_ORDER,) * (len(breaks) - 1))
    load = NEAR_LIMIT * (beam.gamma / beam.mu) ** 2
    limit = axial_problem(mesh, single(beam), law).follow(load).limit
    return None if limit is None else no_equilibrium(beam, beam.mu * limit**0.5, law)


def coarse_equilibrium(beam: Beam, law: StrainLaw) -> tuple[State, Positions]:
    """The equilibrium of a beam of large strain on a coarse mesh, and its positions."""
    ends = unstretched_positions(beam).ends
    mesh = make_mesh(ends, (COARSE_ORDER,) * (len(ends) - 1))
    problem = axial_problem(mesh, single(beam), law)
    load = (beam.gamma / beam.mu) ** 2
    # Where an equilibrium certainly exists the first guess suffices, within 1 %.
    guess = problem.first_guess(load, None, 0.0)[0] if law.hardens and beam.delta >= 0 else None
    state = problem.solve(accept_error=COARSE_ERROR).f if guess is None else guess
    f = state[0]
    values = mesh.weights * np.array((f, mesh.J @ f))
    parts = values.reshape(2, -1, COARSE_ORDER).sum(axis=2)  # integrals of f and u over each part
    u = accumulate(parts[0].tolist(), initial=0.0)
    means = parts[1] / (mesh.breaks[1:] - mesh.breaks[:-1])
    return (mesh, state), Positions(ends, tuple(u), tuple(means.tolist()))
