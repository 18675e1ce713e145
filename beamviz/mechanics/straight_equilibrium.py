"""The stretched equilibrium of straight beams on a mesh (paper, eq. 40, one component).

The unknown is the stretch f at the mesh points, (beams, n) for a stack of beams. Beams of small
strain, and those with a unique equilibrium, are solved by Newton's method from a first guess; any
other is followed from rest, alone, on its stable branch to its load or to the limit below it.
"""

import math
from itertools import accumulate
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from beamviz.beam import PARAMETERS, Beam
from beamviz.errors import NoEquilibrium
from beamviz.mechanics.straight_properties import BeamStack, Properties, properties_on, stack_of
from beamviz.solver.constitutive import StrainLaw, no_equilibrium
from beamviz.solver.continuation import LAST, Root, continue_load
from beamviz.space.elements import Elements
from beamviz.space.grid import Grid, Mesh, make_mesh
from beamviz.space.spans import AnyBeam, Numbers, Positions, ends_of_spans, greatest_force
from beamviz.space.trial import pieces_of

# Error of the stretch at which Newton's method ends, relative to the tolerance.
STRETCH_SHARE = 1e-3
SMALL_FORCE = 0.3  # axial force n, as a share of 1 and of the limits of the law, of a small strain
PASSES = 4  # of the first guess, each a quarter of the work of an iteration of Newton's method
NEWTON_ITERATIONS = 12
MAX_CHANGE = 0.25  # of ln f in a step of continuation: a larger one may lead to another branch
BOUND_SUFFICES = 0.5  # lower bound of the margin from which it is taken for the margin
COARSE_ORDER = 6  # of the mesh of the equilibrium from which the first mesh is designed
FEW_BREAKS = 20  # up to which a limit is located on elements of LIMIT_ORDER
LIMIT_BREAKS = (0.0, 1e-4, 1e-3, 1e-2, 0.1, 1.0)  # mesh on which a limit is located
LIMIT_ORDER = 12
# Share of an energy that the quadrature of a blade may lose: with 1e-8 limits of six random blades
# with dips change by 1.3e-6 at most, relative.
LIMIT_SHARE = 1e-11
NEAR_LIMIT = 1.01  # relative load up to which a limit is searched for a beam that was not solved


class StretchOnGrid(NamedTuple):
    """The stretch f (n,) of a beam on a grid."""

    grid: Grid
    f: NDArray


class AxialState(NamedTuple):
    """Equilibria of a stack of beams."""

    f: NDArray  # (beams, n) stretch at the mesh points
    iterations: int  # of Newton's method
    error: NDArray  # (beams,) relative, of f; infinite where not converged
    margin: NDArray  # (beams,) 1 at rest, 0 at a limit of equilibrium


def axial_problem(mesh: Mesh, beams: BeamStack, law: StrainLaw) -> "AxialProblem":
    """The problem of beams whose bodies sit on breaks of the mesh."""
    return AxialProblem(mesh, properties_on(mesh, beams), beams, law)


def is_small_strain(beam: AnyBeam, law: StrainLaw) -> bool:
    """Whether the axial force, that of the unstretched beam or more, is far from the limits of the
    law and of the beam along its whole length."""
    force = (beam.gamma / beam.mu) ** 2 * greatest_force(beam)
    least, most = law.force_limits
    limit = most if beam.delta >= 0 else min(-least, most)  # inward both may be met
    return force < SMALL_FORCE * min(1.0, limit)


def has_unique_equilibrium(beam: AnyBeam, law: StrainLaw) -> bool:
    """Whether Newton's method can converge to the stable state only."""
    return beam.delta >= 0 and law.max_stretch == math.inf


class AxialProblem(NamedTuple):
    """A stack of beams on a mesh, and their equilibrium w n(f) = load (G f + delta g) with
    load = (gamma / mu)^2, the paper's eq. 40 for a straight beam. w contains E A."""

    mesh: Mesh
    properties: Properties
    beams: BeamStack
    law: StrainLaw

    def solve(
        self, small: bool, tolerance: float, start: StretchOnGrid | None = None
    ) -> AxialState:
        """The equilibria by Newton's method, with an infinite error where it failed.

        small: whether all beams are of small strain: then they have no limit of equilibrium near.
        tolerance: of omega^2. start: the state of a single beam on another mesh; else the beams are
        of small strain or have a unique equilibrium.
        """
        load = (self.beams.gamma / self.beams.mu) ** 2
        accuracy = STRETCH_SHARE * tolerance if small else LAST**2
        if start is not None:
            f = (start.grid.at(self.mesh.grid.points) @ start.f)[None]
        else:
            f, guess_error = self.first_guess(load, accuracy)
            if small and guess_error < accuracy:
                return AxialState(f, 0, np.full(len(f), guess_error), np.ones(len(f)))
        if small:
            return self.newton(load, f, accuracy)
        with np.errstate(all="ignore"):  # a diverging iteration is detected
            state = self.newton(load, f)
            margin = self.margin(load, state.f)
        stable = (state.error < math.inf) & (margin > 0)
        error, margin = np.where(stable, state.error, math.inf), np.where(stable, margin, 1.0)
        return state._replace(error=error, margin=margin)

    def first_guess(self, load: NDArray, accuracy: float) -> tuple[NDArray, float]:
        """The stretch (beams, n) by fixed-point iteration, f = stretch(load (G f + delta g) / w),
        from rest, and the error for a small strain: an iteration reduces it by the force."""
        properties, stretch = self.properties, self.law.stretch_from_force
        pull, static = load / properties.axial, self.beams.delta * properties.g
        most = float((pull * (properties.G1 + abs(static))).max())  # of the force
        f, error = stretch(pull * (properties.G1 + static)), 2 * most**2
        for _ in range(PASSES):
            if error < accuracy:
                break
            f, error = stretch(pull * (np.matvec(properties.G, f) + static)), most * error
        return f, error

    def at_rest(self) -> AxialState:
        """The unstretched state of all beams."""
        size = len(self.beams.gamma)
        shape = size, self.mesh.grid.weights.shape[-1]
        return AxialState(np.ones(shape), 0, np.zeros(size), np.ones(size))

    def stable_state(self, unique: bool) -> AxialState:
        """The stable equilibrium of a single beam. unique: whether the beam cannot have another:
        then Newton's method is tried first, else it is followed from rest. Raises NoEquilibrium
        with the limit below its load, and NotConverged."""
        state = self.solve(False, 0.0) if unique else None
        return self.followed() if state is None or state.error[0] == math.inf else state

    def followed(self) -> AxialState:
        """The equilibrium of a single beam by continuation from rest; raises NoEquilibrium with the
        limit below its load."""
        load = (self.beams.gamma / self.beams.mu) ** 2
        path = self.follow(load.item())
        if path.limit is not None:
            beam = Numbers(*(getattr(self.beams, name).flat[0] for name in PARAMETERS))
            raise no_equilibrium(beam, beam.mu * path.limit**0.5, self.law)
        return AxialState(path.state, path.iterations, np.zeros(1), self.margin(load, path.state))

    def newton(self, load: NDArray, f: NDArray, accuracy: float = LAST**2) -> AxialState:
        """The stretch f (beams, n) in equilibrium at a load (beams, 1), by Newton-Raphson from f:
        `continuation.newton` of a stack of beams, which takes one step of all in one call of
        LAPACK.

        The error is infinite, and f is 1, where it does not converge between the stretches of the
        law's limits. The state may still be unstable: see `margin`.
        """
        properties, beams, law = self.properties, self.beams, self.law
        A = load[..., None] * properties.G
        w, static = properties.axial, load * beams.delta * properties.g
        iteration, error = 0, np.full(len(f), math.inf)
        while iteration < NEWTON_ITERATIONS and not np.fmax.reduce(error) < accuracy:
            iteration += 1
            residual = w * law.force(f) - np.matvec(A, f) - static
            tangent = -A
            diagonals = tangent.reshape(len(f), -1)[:, :: f.shape[-1] + 1]  # a view
            diagonals += w * law.stiffness(f)
            try:
                step = np.linalg.solve(tangent, residual[..., None])[..., 0]
            except np.linalg.LinAlgError:  # singular: off the stable branch
                break
            f = f - step
            error = np.vecdot(step, step) / f[:, 0] ** 2  # the next step is as small as this square
        inside = (f > law.min_stretch) & (f < law.max_stretch)
        converged = (error < accuracy) & np.logical_and.reduce(inside, axis=-1)
        if not converged.all():
            f, error = np.where(converged[:, None], f, 1.0), np.where(converged, error, math.inf)
        return AxialState(f, iteration, error, np.ones(len(f)))

    @np.errstate(all="ignore")
    def follow(self, load: float) -> Root:
        """Continuation of the stable branch of a single beam from rest to a load."""

        def solve_at(trial: float, guess: NDArray) -> Root | None:
            f, iterations, error, _ = self.newton(np.array([[trial]]), guess)
            near = error[0] < math.inf and abs(np.log(f / guess)).max() <= MAX_CHANGE
            return Root(f, iterations) if near else None

        def margin(trial: float, f: NDArray) -> NDArray:
            return self.margin(np.array([[trial]]), f, math.inf)

        return continue_load(solve_at, np.ones((1, len(self.mesh.grid.points))), load, margin)

    def margin(self, load: NDArray, f: NDArray, bound: float = BOUND_SUFFICES) -> NDArray:
        """Stability margins (beams,) of equilibria f (beams, n): 1 at rest, 0 at a limit.

        The lesser of `force_left` and the least eigenvalue of the tangent relative to rest, zero
        at a fold. A lower bound of the eigenvalue is the least ratio of (tangent x) to w x for any
        x > 0 (Collatz and Wielandt), here f, in equilibrium; it replaces the eigenvalue where it is
        at least `bound`. It is never less than 1 in an outward beam of a law that hardens.
        """
        w, G, law = self.properties.axial, self.properties.G, self.law
        stiffness = law.stiffness(f)
        pull = law.force(f) - load * self.beams.delta * self.properties.g / w  # load G f / w
        fold = np.minimum.reduce(stiffness - pull / f, axis=-1)
        for k in (fold < bound).nonzero()[0]:
            # Beam k, or the only row of an array that all beams share.
            scale, Gk = 1 / np.sqrt(w[k % len(w)]), G[k % len(G)]
            tangent = np.diag(stiffness[k]) - load[k] * scale[:, None] * Gk * scale
            fold[k] = np.linalg.eigvalsh(tangent)[0]
        return np.minimum(fold, self.force_left(load, f))

    def force_left(self, load: NDArray, f: NDArray) -> NDArray:
        """1 - (greatest force / greatest force of the strain law), (beams,), in tension or in
        compression, at the ends of elements where the force over E A may be greatest: of a uniform
        beam at the clamp."""
        least, most = self.law.force_limits
        properties = self.properties
        # int rho (u + delta) (beams, ends), u = J f
        moment = np.matvec(properties.to_ends, f) + self.beams.delta * properties.total
        force = load * moment
        return np.minimum.reduce(1 - np.maximum(force / most, force / least), axis=-1)


def limit_error(beam: Beam, law: StrainLaw) -> NoEquilibrium | None:
    """The error of a beam beyond its limit of equilibrium or too near it, located on a mesh that is
    fine at the clamp; None where there is no limit. Raises NotConverged."""
    breaks = sorted({*LIMIT_BREAKS, *ends_of_spans(beam)})
    order = LIMIT_ORDER if len(breaks) <= FEW_BREAKS else COARSE_ORDER
    orders = (order,) * (len(breaks) - 1)
    elements = Elements(tuple(breaks), orders, orders)
    pieces = pieces_of(elements, beam.blade, "bending", LIMIT_SHARE)
    mesh = make_mesh(pieces.breaks, pieces.orders)
    load = NEAR_LIMIT * (beam.gamma / beam.mu) ** 2
    limit = axial_problem(mesh, stack_of([beam]), law).follow(load).limit
    return None if limit is None else no_equilibrium(beam, beam.mu * limit**0.5, law)


def coarse_equilibrium(beam: AnyBeam, law: StrainLaw) -> tuple[StretchOnGrid, Positions]:
    """The equilibrium of a beam of large strain on a coarse mesh, and its positions. Raises
    NoEquilibrium with the limit, and NotConverged."""
    ends = ends_of_spans(beam)
    mesh = make_mesh(ends, (COARSE_ORDER,) * (len(ends) - 1))
    problem = axial_problem(mesh, stack_of([beam]), law)
    f = problem.stable_state(has_unique_equilibrium(beam, law)).f[0]
    rho = 1.0 if beam.blade is None else beam.blade.at("mass", mesh.grid.points)
    values = mesh.grid.weights * np.array((f, rho * (mesh.J @ f), rho * np.ones_like(f)))
    # Integrals of f, of rho u and of rho over each span, which is an element.
    int_f, moment, mass = values.reshape(3, -1, COARSE_ORDER).sum(axis=2)
    u = accumulate(int_f.tolist(), initial=0.0)
    positions = Positions(ends, tuple(u), tuple((moment / mass).tolist()), tuple(mass.tolist()))
    return StretchOnGrid(mesh.grid, f), positions
