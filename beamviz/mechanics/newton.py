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

LIMIT_PRECISION = 1e-10  # of a load, relative
LIMIT_MARGIN = 1e-3  # of the margin at the start: below it, a path that stops has met its limit
APPROACH = 0.9  # the share of the estimated way to the limit taken in one step


@dataclass(frozen=True)
class Root:
    """A state the increments vanish at, and the iterations it took."""

    state: NDArray
    iterations: int


@dataclass(frozen=True)
class Path:
    """How far an equilibrium was followed: `limit` is None where the target was reached, else
    the largest load with an equilibrium, relative error LIMIT_PRECISION."""

    state: NDArray
    limit: float | None
    iterations: int
    steps: int
    rejected: int


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
    margin: Callable[[NDArray, float], float],
) -> Path:
    """Follow the equilibrium from `start` at load 0 to `target`, or to the limit below it.

    solve_at(load, guess) returns the root on the branch of the guess, None if there is none;
    margin(state, load) > 0 measures how far the branch is from its end. The first step is the
    whole load; a step that fails is halved, one that succeeds is doubled, and near a limit it
    stays short of where the margin is heading. Raises NotConverged where the path stops with a
    margin left.
    """
    followed = [(0.0, start)]
    step, iterations, rejected = target, 0, 0
    while followed[-1][0] < target:
        load, state = followed[-1]
        trial = min(load + step, target)
        root = solve_at(trial, state)
        if root is not None:
            followed.append((trial, root.state))
            iterations += root.iterations
            step = 2 * step
        elif trial - load <= LIMIT_PRECISION * trial:
            break
        else:
            rejected += 1
            step = (trial - load) / 2
        if rejected:
            ahead = APPROACH * way_to_limit(followed[-2:], margin)
            step = max(min(step, ahead), LIMIT_PRECISION * trial)
    load, state = followed[-1]
    ended = load < target
    if ended and margin(state, load) > LIMIT_MARGIN * margin(start, 0.0):
        raise NotConverged(
            f"the equilibrium was followed to {load / target:.6g} of the load (gamma^2) in"
            f" {len(followed) - 1} steps and not beyond, though no limit is near; smaller or more"
            " even elements may help"
        )
    return Path(state, load if ended else None, iterations, len(followed) - 1, rejected)


def way_to_limit(
    followed: list[tuple[float, NDArray]], margin: Callable[[NDArray, float], float]
) -> float:
    """The load left until the margin vanishes, seen from the last of two states: at a fold the
    margin squared is linear in the load. Infinite where it does not fall."""
    if len(followed) < 2:
        return math.inf
    (load_0, state_0), (load_1, state_1) = followed
    m0, m1 = margin(state_0, load_0) ** 2, margin(state_1, load_1) ** 2
    return (load_1 - load_0) * m1 / (m0 - m1) if m0 > m1 else math.inf
