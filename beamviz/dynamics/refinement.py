"""A motion refined until its error estimate is within the tolerance.

It is computed on meshes and with steps that become finer, until two of the motions agree to the
tolerance. Their difference, in the position of the tip, is the error estimate of the finer one.

A first motion has adaptive steps. In the others they are equal, as short as the shortest of these
that are sustained: with adaptive steps of their own they took five times as long.
"""

import math
from typing import NamedTuple

import numpy as np

from beamviz.beam import Beam
from beamviz.dynamics.controllers import AdaptiveSteps, Controller, EqualSteps, GivenSteps
from beamviz.dynamics.initial_value import Mesh, initial_value_problem
from beamviz.dynamics.integration import Budget, IntegratedMotion, integrate
from beamviz.dynamics.meshes import first_mesh, refined
from beamviz.dynamics.problem import DEFAULT_ELEMENTS, MotionProblem
from beamviz.errors import BeamvizError, NoEquilibrium, NotConverged
from beamviz.solver import Solution

COMPARED = 401  # times at which the tips of two runs are compared
REFINEMENTS = 9  # after which a motion counts as not converged
TAIL = 1.0  # of the first steps, over the tolerance
FINER = 32.0  # tolerance of adaptive steps over that of the finer motion, at a given resolution
# The error estimate is ESTIMATE times the sum of the changes by further refinements, which is taken
# for a geometric series with the ratio of the last two changes, and UNRESOLVED times the tolerance
# for vibrations that no run resolves. scripts/measure_motion_error_bars.py measures both.
ESTIMATE, UNRESOLVED = 2.0, 0.1
LEAST_RATIO, GREATEST_RATIO = 0.2, 0.6
# The error estimate of the coarser of two motions at a given resolution is COARSER times their
# difference; 4/3 would be enough where the second order of convergence has been reached.
COARSER = 2.0


Attempt = IntegratedMotion | BeamvizError  # a motion, or why it could not be computed


class RefinedMotion(NamedTuple):
    """A motion, its error estimate and the number of motions it took."""

    motion: IntegratedMotion
    error: float  # [L] of the tip
    runs: int


def to_tolerance(problem: MotionProblem, solution: Solution) -> RefinedMotion:
    """A motion refined until its error estimate is within the tolerance. Raises NoEquilibrium and
    NotConverged.

    A first run, whose steps adapt to the motion, tells how short they have to be; in the others
    their number is doubled while the orders of the mesh are raised. Without damping there is one
    more in between, with about as many steps as in the first, of equal length.
    """
    mesh, budget = first_mesh(fastest(problem), problem.statics), Budget()
    controller: Controller = AdaptiveSteps(TAIL * problem.tolerance)
    last, change = attempt(problem, solution, mesh, controller, budget), math.inf
    for runs in range(2, REFINEMENTS + 2):
        doubled = runs > 2 or problem.damping > 0
        controller, mesh = controller_after(problem, last, 1 + doubled), refined(mesh)
        before, change_before = last, change
        last = attempt(problem, solution, mesh, controller, budget)
        if isinstance(last, NoEquilibrium) and isinstance(before, NoEquilibrium):
            break
        change = difference(problem, last, before)
        error = estimate(problem, change, change_before)
        if doubled and isinstance(last, IntegratedMotion) and error <= problem.tolerance:
            return RefinedMotion(last, error, runs)
        if not budget.allows_another:
            break
    if isinstance(last, BeamvizError):
        raise last
    raise not_settled(problem, before, last)


def not_settled(problem: MotionProblem, before: Attempt, last: IntegratedMotion) -> BeamvizError:
    """The error for a motion of which two runs differ by more than the tolerance."""
    if isinstance(before, BeamvizError):
        return before
    t = np.linspace(0.0, problem.until, COMPARED)
    apart = np.linalg.norm(last.tip(t) - before.tip(t), axis=1)
    with_what = f"with {len(last.trajectory.q)} steps and {last.trajectory.beam.size} unknowns"
    remedy = "ask for a shorter time or a larger tolerance"
    if apart.max() <= problem.tolerance:
        return NotConverged(
            f"the position of the tip still changes by {apart.max():.1e} L {with_what}, and not"
            f" less than before, so it is not known to {problem.tolerance:g} L; {remedy}"
        )
    agree = t[max(int(np.argmax(apart > problem.tolerance)) - 1, 0)]
    return NotConverged(
        f"the position of the tip is known to {problem.tolerance:g} L until t = {agree:.3g} only;"
        f" then it still changes by up to {apart.max():.1e} L {with_what}, as small differences"
        f" grow; {remedy}"
    )


def at_resolution(problem: MotionProblem, solution: Solution) -> RefinedMotion:
    """A motion at a given resolution, with its error estimate by one of twice that."""
    count = problem.elements or DEFAULT_ELEMENTS
    meshes: tuple[Mesh, Mesh] = count, 2 * count
    if not problem.cubic:
        mesh = refined(first_mesh(fastest(problem), problem.statics))
        meshes = mesh, refined(mesh)
    motions = []
    for elements, tail, division in zip(meshes, (TAIL, TAIL / FINER), (1, 2), strict=True):
        tolerance = tail * problem.tolerance
        step = problem.step
        controller = EqualSteps(step / division) if step else AdaptiveSteps(tolerance)
        discrete = initial_value_problem(problem, solution, elements)
        motions.append(integrate(discrete, controller, tolerance, progress=problem.report))
    coarse, finer = motions
    return RefinedMotion(coarse, COARSER * difference(problem, coarse, finer), 2)


def fastest(problem: MotionProblem) -> Beam:
    """The beam at the speed that the first mesh resolves."""
    return problem.beam.replace(gamma=problem.greatest_speed)


def estimate(problem: MotionProblem, change: float, before: float) -> float:
    """The error bar of a run that differs by a change from a coarser one, which differed by the
    change before from one still coarser: the sum of the changes to come, if they go on so."""
    ratio = (
        min(max(change / max(before, 1e-300), LEAST_RATIO), GREATEST_RATIO)
        if before < math.inf
        else GREATEST_RATIO
    )
    return ESTIMATE * change * ratio / (1 - ratio) + UNRESOLVED * problem.tolerance


def attempt(
    problem: MotionProblem, solution: Solution, mesh: Mesh, controller: Controller, budget: Budget
) -> Attempt:
    """A motion on a mesh, or its failure: a finer one may succeed."""
    tolerance, progress = TAIL * problem.tolerance, problem.report
    try:
        discrete = initial_value_problem(problem, solution, mesh)
        return integrate(discrete, controller, tolerance, budget=budget, progress=progress)
    except (NoEquilibrium, NotConverged) as error:
        return error


def controller_after(problem: MotionProblem, coarse: Attempt, times: int) -> Controller:
    """The steps of the next motion: `times` as many as in a coarser one, or adaptive ones where it
    has failed. Without damping they are of equal length in each smooth part of the motion: an
    undamped vibration does not fade, and longer steps later would lose it."""
    if isinstance(coarse, BeamvizError):
        return AdaptiveSteps(TAIL * problem.tolerance)
    ends = coarse.trajectory.t
    if problem.damping:
        return GivenSteps.divided(ends, times)
    return GivenSteps.of_equal_length(ends, sorted({0.0, *problem.corners, problem.until}), times)


def difference(problem: MotionProblem, first: Attempt, second: Attempt) -> float:
    """The largest distance of the tip in two runs, infinite where one has failed."""
    if isinstance(first, BeamvizError) or isinstance(second, BeamvizError):
        return math.inf
    t = np.linspace(0.0, problem.until, COMPARED)
    return float(np.linalg.norm(first.tip(t) - second.tip(t), axis=1).max())
