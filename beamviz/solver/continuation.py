"""Newton-Raphson on callables, and the path of an equilibrium as its load grows (paper, eq. 40).

Three ends are told apart: the load is reached; the equilibrium ends at a limit below it, shown
by a margin that falls to zero there; or the numerics gave up (NotConverged).
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from beamviz.errors import NotConverged

TOLERANCE = 1e-11  # of an increment, relative to the state: the error left is its square
ROUNDING = 1e-8  # below this an increment that no longer shrinks is rounding
MAX_ITERATIONS = 30

LIMIT_PRECISION = 1e-10  # of a load, relative: two estimates of a limit that agree so far
LIMIT_MARGIN = 1e-2  # the margin a path must have fallen to before its limit is believed
EXTRAPOLATED = 4  # the points an estimate is made from
APPROACH = 0.9  # the share of the estimated way to the limit taken in one step


@dataclass(frozen=True)
class Root:
    """A state the increments vanish at, and the iterations it took."""

    state: NDArray
    iterations: int


@dataclass(frozen=True)
class Path:
    """How far an equilibrium was followed: `limit` is None where the target was reached, else
    the largest load with an equilibrium, and `state` the last one followed below it."""

    state: NDArray
    limit: float | None
    iterations: int


@np.errstate(over="ignore", invalid="ignore", divide="ignore")  # of what diverges: seen below
def newton(increment: Callable[[NDArray], NDArray], start: NDArray) -> Root | None:
    """Add increment(q) = -K(q)^-1 R(q) until it is TOLERANCE of the state or mere rounding.

    None where it does not converge. An increment raises np.linalg.LinAlgError to give up (a
    tangent that left the stable branch, say).
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
        if size <= TOLERANCE or (size <= ROUNDING and size > previous / 4):
            return Root(q, iteration)
        previous = size
    return None


def continue_load(
    solve_at: Callable[[float, NDArray], Root | None],
    start: NDArray,
    target: float,
    margin: Callable[[float, NDArray], float | NDArray],
    first_step: float = math.inf,
    precision: float = LIMIT_PRECISION,
) -> Path:
    """Follow the equilibrium from `start` at load 0 to `target`, or to the limit below it.

    solve_at(load, guess) returns the root on the branch of the guess, None if there is none;
    margin(load, state) is 1 at rest and falls smoothly to zero where the branch ends; of several
    margins (k,) it ends with the first that does. The first
    step is the whole load, or `first_step`; a step that fails is halved, one that succeeds is
    doubled, and once one has failed they stay short of where the margin vanishes. A limit is
    located to a relative `precision`. Raises NotConverged where the path stops though the margin
    has not vanished.
    """
    load, state, step, limit = 0.0, start, min(target, first_step), math.inf
    iterations, steps, rejected = 0, 0, False
    points: list[tuple[NDArray, float]] = []  # (margins, load), since the first step that failed
    while load < target:
        trial = min(load + step, target)
        root = solve_at(trial, state)
        if root is None:
            rejected, step = True, (trial - load) / 2
            if step > precision * trial:
                continue
            if np.min(margin(load, state)) < LIMIT_MARGIN:
                return Path(state, load, iterations)
            raise NotConverged(
                f"the equilibrium was followed to {load / target:.6g} of the load (gamma^2) in"
                f" {steps} steps and not beyond, though no limit was found; a finer or a more even"
                " mesh may help"
            )
        load, state, step = trial, root.state, 2 * step
        iterations, steps = iterations + root.iterations, steps + 1
        if not rejected:
            continue
        points = [*points[1 - EXTRAPOLATED :], (np.atleast_1d(margin(load, state)), load)]
        margins, loads = (np.array(column) for column in zip(*points, strict=True))
        previous, limit = limit, min(vanishing_load(column, loads) for column in margins.T)
        if load < limit <= target:
            if abs(limit - previous) <= precision * limit and margins[-1].min() < LIMIT_MARGIN:
                return Path(state, limit, iterations)
            step = min(step, APPROACH * (limit - load))
    return Path(state, None, iterations)


def vanishing_load(margins: NDArray, loads: NDArray) -> float:
    """Where a margin vanishes: the load as a polynomial in the margin through points (n,), at zero
    (Neville's scheme).

    The load is smooth in the margin whether the branch folds (margin ~ the root of the load
    left) or the state runs away (margin ~ the load left). Infinite where margins do not fall or
    would have vanished before.
    """
    if len(loads) < 2 or np.any(np.diff(margins) >= 0):
        return math.inf
    table = loads
    for k in range(1, len(loads)):
        near, far = margins[k:], margins[:-k]
        table = (far * table[1:] - near * table[:-1]) / (far - near)
    return float(table[0]) if table[0] > loads[-1] else math.inf
