"""Where a deflected state ends; the branches end too, or continue on another state."""

from collections.abc import Iterator
from contextlib import suppress
from itertools import pairwise
from typing import TypeGuard

import numpy as np

from beamviz.errors import NotConverged
from beamviz.frequency_loci.events.record import Event, EventKind, Tracked
from beamviz.frequency_loci.mode_vectors import Outcome
from beamviz.solver.bent import end_of_bent_state
from beamviz.solver.solution import Solution

JUMP = 4.0  # ratio of a tip displacement to the neighbouring ones from which it may be a jump
SAME_TIP = 1e-3  # [L] distance of the tips up to which two states are the same


def limit_points(tracked: Tracked) -> Iterator[Event]:
    """The ends of deflected states between two solved values."""
    path = tracked.path
    if path.is_straight:
        return
    values, outcomes = tracked.grid.tolist(), path.solve(tracked.grid)
    for k, (before, after) in enumerate(pairwise(outcomes)):
        ends = values[k], values[k + 1]
        if isinstance(before, Solution) and isinstance(after, Solution):
            same = before.equilibrium.shape == after.equilibrium.shape
            if same and _is_deflected(before) and _may_jump(outcomes, k):
                yield from _limit_point(path.over, *ends, before, after)
        elif _is_deflected(before) or _is_deflected(after):
            yield from _limit_point(path.over, *ends, before, after)


def _is_deflected(outcome: Outcome) -> TypeGuard[Solution]:
    """Whether an outcome is a deflected state."""
    return isinstance(outcome, Solution) and outcome.equilibrium.shape == "bent"


def _may_jump(outcomes: list[Outcome], k: int) -> bool:
    """Whether the tip moves much further from value k to the next than between their neighbours."""
    first, last = max(k - 2, 0), min(k + 4, len(outcomes))
    none = np.full(2, np.nan)
    near = [
        outcome.equilibrium.tip if _is_deflected(outcome) else none
        for outcome in outcomes[first:last]
    ]
    moves = np.linalg.norm(np.diff(near, axis=0), axis=1)
    others = np.delete(moves, k - first)
    others = others[np.isfinite(others)]
    return bool(moves[k - first] > max(SAME_TIP, JUMP * others.max() if len(others) else 0.0))


def _limit_point(
    over: str, low: float, high: float, before: Outcome, after: Outcome
) -> Iterator[Event]:
    """The limit point, between two values, of the deflected state at one of them."""
    for start, stop in ((before, high), (after, low)):
        if not _is_deflected(start):
            continue
        with suppress(NotConverged):
            at = end_of_bent_state(start, over, stop)
            if at is not None and low <= at <= high:
                states = [
                    outcome if isinstance(outcome, Solution) else start
                    for outcome in (before, after)
                ]
                frequencies = tuple(0.0 if state is start else None for state in states)
                labels = tuple(state.labels[0] for state in states)
                yield Event("limit point", labels, at, frequencies, (0, 0))
                return


LIMIT_POINT = EventKind(
    name="limit point",
    meaning="a deflected state ends there",
    sign="△",
    marker="^",
    filled=False,
    locate=limit_points,
    of_single_state=False,
    jumps=True,
)
