"""Events of the equilibria along a path: buckling, limit points, second stable states."""

from collections.abc import Iterator
from contextlib import suppress
from itertools import pairwise
from typing import NamedTuple, TypeGuard

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from beamviz.errors import BeamvizError, NotConverged
from beamviz.frequency_loci.mode_vectors import Outcome
from beamviz.frequency_loci.path import Path
from beamviz.solver import solve
from beamviz.solver.bent import end_of_bent_state, other_stable_states
from beamviz.solver.solution import Solution

PRECISION = 1e-9  # relative, of a buckling point
JUMP = 4.0  # ratio of a tip displacement to the neighbouring ones from which it may be a jump
SAME_TIP = 1e-3  # [L] distance of the tips up to which two states are the same
SECOND_STATES_SOUGHT = 4  # number of values at which second states are searched for


class StateEvent(NamedTuple):
    """An event of the equilibria."""

    at: float
    first: Solution  # before it
    second: Solution  # after it, or of another state
    ended: Solution | None = None  # the one of them whose state ends there


def is_deflected(outcome: Outcome) -> TypeGuard[Solution]:
    """Whether an outcome is a deflected state."""
    return isinstance(outcome, Solution) and outcome.equilibrium.shape == "bent"


def bucklings(path: Path, grid: NDArray) -> Iterator[StateEvent]:
    """The points where the lowest omega^2 of the straight state vanishes, and a deflected state
    takes its place."""
    if path.is_straight:
        return
    options = path.problem.options | {"state": "straight", "coriolis": False, "modes": 1}

    def lowest(value: float) -> float:
        """omega^2 of the straight state, nearer to a straight line: that may be -1e9."""
        return float(np.arcsinh(solve(path.at(value), **options).omega_squared[0]))

    outcomes = zip(grid.tolist(), path.solve(grid), strict=True)
    for (low, before), (high, after) in pairwise(outcomes):
        if not (isinstance(before, Solution) and isinstance(after, Solution)):
            continue
        if before.equilibrium.shape == after.equilibrium.shape:
            continue
        # With a spin-up there is no straight state, nor is there one beyond a limit.
        with suppress(BeamvizError, ValueError):
            at = brentq(lowest, low, high, xtol=PRECISION * (high - low), rtol=PRECISION)
            yield StateEvent(float(at), before, after)


def limit_points(path: Path, grid: NDArray) -> Iterator[StateEvent]:
    """The ends of deflected states between two solved values."""
    if path.is_straight:
        return
    values, outcomes = grid.tolist(), path.solve(grid)
    for k, (before, after) in enumerate(pairwise(outcomes)):
        ends = values[k], values[k + 1]
        if isinstance(before, Solution) and isinstance(after, Solution):
            same = before.equilibrium.shape == after.equilibrium.shape
            if same and is_deflected(before) and _may_jump(outcomes, k):
                yield from _limit_point(path.over, *ends, before, after)
        elif is_deflected(before) or is_deflected(after):
            yield from _limit_point(path.over, *ends, before, after)


def _may_jump(outcomes: list[Outcome], k: int) -> bool:
    """Whether the tip moves much further from value k to the next than between their neighbours."""
    first, last = max(k - 2, 0), min(k + 4, len(outcomes))
    none = np.full(2, np.nan)
    near = [
        outcome.equilibrium.tip if is_deflected(outcome) else none
        for outcome in outcomes[first:last]
    ]
    moves = np.linalg.norm(np.diff(near, axis=0), axis=1)
    others = np.delete(moves, k - first)
    others = others[np.isfinite(others)]
    return bool(moves[k - first] > max(SAME_TIP, JUMP * others.max() if len(others) else 0.0))


def _limit_point(
    over: str, low: float, high: float, before: Outcome, after: Outcome
) -> Iterator[StateEvent]:
    """The limit point, between two values, of the deflected state at one of them."""
    for start, stop in ((before, high), (after, low)):
        if not is_deflected(start):
            continue
        with suppress(NotConverged):
            at = end_of_bent_state(start, over, stop)
            if at is not None and low <= at <= high:
                first, last = (
                    outcome if isinstance(outcome, Solution) else start
                    for outcome in (before, after)
                )
                yield StateEvent(at, first, last, ended=start)
                return


def second_states(path: Path, grid: NDArray) -> Iterator[StateEvent]:
    """The limit point, or else the first value, of the first other stable deflected state found."""
    if path.is_straight:
        return
    values = grid.tolist()
    for k in np.unique(np.linspace(0, len(values) - 1, SECOND_STATES_SOUGHT).astype(int)):
        first = path.outcomes[values[k]]
        if not isinstance(first, Solution):
            continue
        for second in other_stable_states(first)[:1]:
            end = None
            with suppress(NotConverged):
                end = end_of_bent_state(second, path.over, values[0])
            yield StateEvent(values[0] if end is None else end, first, second)
            return
