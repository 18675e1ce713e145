"""Newton-Raphson iteration, and continuation of an equilibrium in its load (paper, eq. 40).

Continuation has three outcomes: the load is reached; the equilibrium ends at a limit below it,
where a stability margin falls to zero; or the iteration failed (NotConverged).
"""

import math
from collections.abc import Callable
from functools import partial
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from beamviz.errors import NotConverged
from beamviz.solver.problem import interruption

# Size of the last increment of Newton's method, relative to the state: the error that it leaves is
# its square.
LAST = 1e-8
ROUNDING = 1e-7  # size below which an increment that no longer shrinks is rounding error
MAX_ITERATIONS = 30
LARGEST_STEP = 2.0  # of a state, in units of a step that should be taken at once

LIMIT_PRECISION = 1e-10  # relative difference of two successive estimates of a limit load
LIMIT_MARGIN = 1e-2  # margin below which a limit is accepted
EXTRAPOLATED = 4  # number of points that a limit is extrapolated from
APPROACH = 0.9  # share of the estimated distance to the limit taken in one step


class Root(NamedTuple):
    """A converged state and the number of iterations. Of a continuation, the last equilibrium and,
    where the target load was not reached, the largest load that has one."""

    state: NDArray
    iterations: int
    limit: float | None = None


def is_last(size: float, previous: float, rounding: float = ROUNDING) -> bool:
    """Whether Newton's method ends after an increment of a size: its square, the error left, is
    below rounding, or it is rounding error itself and no longer shrinks. previous: of the
    increment before it."""
    return size <= LAST or (size <= rounding and size > previous / 4)


@np.errstate(over="ignore", invalid="ignore", divide="ignore")  # divergence is detected below
def newton(increment: Callable[[NDArray], NDArray], start: NDArray) -> Root | None:
    """Add increment(q) = -K(q)^-1 R(q) until it `is_last`. None where it does not converge, or
    where increment raises np.linalg.LinAlgError (for a tangent that is not positive definite, say).
    """
    q, previous = start, math.inf
    for iteration in range(1, MAX_ITERATIONS + 1):
        try:
            dq = increment(q)
        except np.linalg.LinAlgError:
            return None
        q = q + dq
        size = np.abs(dq).max() / max(1.0, np.abs(q).max())
        if not math.isfinite(size):
            return None
        if is_last(size, previous):
            return Root(q, iteration)
        previous = size
    return None


class Balance(Protocol):
    """A state of which `balancing_step` finds the equilibrium nearby."""

    @property
    def f(self) -> NDArray:
        """The stretch."""

    @property
    def residual(self) -> NDArray:
        """R (n,), zero in equilibrium."""

    @property
    def stiffness(self) -> NDArray:
        """K (n, n), its derivative by the unknowns."""

    def step_size(self, step: NDArray) -> float:
        """The size of a step (n,) in units of the largest that should be taken at once."""


def balancing_step(state: Balance) -> NDArray:
    """Newton's step (n,) from a state to the equilibrium near it. LinAlgError where f <= 0, or
    where the step is so long that it may lead to another equilibrium."""
    _check(state.f.min() > 0)
    residual = state.residual
    if not residual.any():  # nothing loads the beam, which may turn freely
        return np.zeros_like(residual)
    step = -np.linalg.solve(state.stiffness, residual)
    _check(state.step_size(step) < LARGEST_STEP)
    return step


def bordered(state: Balance, by_parameter: NDArray, row: NDArray) -> NDArray:
    """The derivative (n + 1, n + 1) by the unknowns and a parameter of R, and of an equation more:
    that of a point held, or of a plane across a path. by_parameter (n,): of R; row (n + 1,): of the
    equation."""
    return np.vstack((np.column_stack((state.stiffness, by_parameter)), row))


def bordered_step(
    state: Balance, by_parameter: NDArray, row: NDArray, missing: float = 0.0
) -> NDArray:
    """Newton's step (n + 1,) of the unknowns and the parameter, see `bordered`. missing: what is
    left of the equation. LinAlgError as in `balancing_step`."""
    _check(state.f.min() > 0)
    tangent = bordered(state, by_parameter, row)
    step = -np.linalg.solve(tangent, np.append(state.residual, missing))
    _check(state.step_size(step[:-1]) < LARGEST_STEP)
    return step


def _check(condition: bool) -> None:
    """LinAlgError where a step should not be taken."""
    if not condition:
        raise np.linalg.LinAlgError


Solver = Callable[[float, NDArray], Root | None]


def newton_at(increment: Callable[[float, NDArray], NDArray]) -> Solver:
    """`newton` at a load, from a guess; increment(load, q)."""
    return lambda load, guess: newton(partial(increment, load), guess)


def continue_load(
    solve_at: Solver,
    start: NDArray,
    target: float,
    margin: Callable[[float, NDArray], float | NDArray],
    first_step: float = math.inf,
    precision: float = LIMIT_PRECISION,
) -> Root:
    """Follow the equilibrium from `start` at load 0 to `target`, or to the limit below it.

    solve_at(load, guess) returns a root near the guess, None if there is none. margin(load, state),
    a number or several (k,), is 1 at rest; a state with one that is not positive is not on the
    branch, which ends where one has fallen to zero. first_step: increment of the load, by default
    the whole target; it is halved after a step that fails, doubled after one that succeeds, and
    after the first failure limited to a share of the estimated distance to the limit. precision:
    relative, of the limit. Raises NotConverged where the path stops although no margin vanishes.
    """
    load, state, step, limit = 0.0, start, min(target, first_step), math.inf
    iterations, steps, rejected = 0, 0, False
    margins = np.ones(1)  # at the load reached
    points: list[tuple[NDArray, float]] = []  # (margins, load), since the first step that failed
    while load < target:
        interruption.get()()
        trial = min(load + step, target)
        root = solve_at(trial, state)
        reached = np.atleast_1d(margin(trial, root.state)) if root else np.zeros(1)
        if root is None or not reached.min() > 0:
            rejected, step = True, (trial - load) / 2
            if step > precision * trial:
                continue
            if margins.min() < LIMIT_MARGIN:
                return Root(state, iterations, load)
            raise NotConverged(
                f"the equilibrium was followed to {load / target:.6g} of the load (gamma^2) in"
                f" {steps} steps and not beyond, though no limit was found; a finer or a more even"
                " mesh may help"
            )
        load, state, step, margins = trial, root.state, 2 * step, reached
        iterations, steps = iterations + root.iterations, steps + 1
        if not rejected:
            continue
        points = [*points[1 - EXTRAPOLATED :], (margins, load)]
        history, loads = (np.array(column) for column in zip(*points, strict=True))
        previous, limit = limit, min(vanishing_load(column, loads) for column in history.T)
        if load < limit <= target:
            if abs(limit - previous) <= precision * limit and margins.min() < LIMIT_MARGIN:
                return Root(state, iterations, limit)
            step = min(step, APPROACH * (limit - load))
    return Root(state, iterations)


def vanishing_load(margins: NDArray, loads: NDArray) -> float:
    """The load at which a margin vanishes: extrapolation of the polynomial in the margin through
    points (n,) by Neville's scheme.

    The load is smooth in the margin at a fold (margin ~ root of the remaining load) and where the
    state diverges (margin ~ remaining load). Infinite where the margins do not fall or the result
    is below the last load.
    """
    if len(loads) < 2 or np.any(np.diff(margins) >= 0):
        return math.inf
    table = loads
    for k in range(1, len(loads)):
        near, far = margins[k:], margins[:-k]
        table = (far * table[1:] - near * table[:-1]) / (far - near)
    return float(table[0]) if table[0] > loads[-1] else math.inf
