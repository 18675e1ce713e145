"""Events of the equilibrium along a sweep: buckling, limit points, second stable states."""

from contextlib import suppress
from itertools import pairwise
from typing import TypeGuard

import numpy as np
from scipy.optimize import brentq

from beamviz.errors import BeamvizError, NotConverged
from beamviz.frequency_loci.crossings import Event
from beamviz.frequency_loci.mode_vectors import Outcome
from beamviz.frequency_loci.sweep import Sweep
from beamviz.solver import end_of_bent_state, other_stable_states, solve
from beamviz.solver.solution import Solution

PRECISION = 1e-9  # relative, of a buckling point
JUMP = 4.0  # ratio of a tip displacement to the neighbouring ones from which it may be a jump
SAME_TIP = 1e-3  # [L] distance of the tips up to which two states are the same
SECOND_STATES_SOUGHT = 4  # number of values at which second states are searched for


def state_events(sweep: Sweep, values: np.ndarray) -> list[Event]:
    """The events, in no order, of the equilibria at ascending values.

    "buckling": the straight state loses its stability; "limit point": the bent state ends, and the
    branches end or continue on another state; "second state": the value from which another stable
    bent state exists.
    """
    events: list[Event] = []
    over, outcomes = sweep.over, sweep.solve(values)
    for low, high in pairwise(range(len(values))):
        before, after = outcomes[low], outcomes[high]
        ends = float(values[low]), float(values[high])
        if isinstance(before, Solution) and isinstance(after, Solution):
            if before.equilibrium.shape != after.equilibrium.shape:
                events += _buckling(sweep, *ends, before, after)
            elif _is_bent(before) and _may_jump(outcomes, low):
                events += _limit_point(over, *ends, before, after)
        elif _is_bent(before) or _is_bent(after):
            events += _limit_point(over, *ends, before, after)
    return events + _second_states(sweep, values, outcomes)


def _buckling(
    sweep: Sweep, low: float, high: float, before: Solution, after: Solution
) -> list[Event]:
    """The point where the lowest omega^2 of the straight state vanishes."""
    options = sweep.options | {"state": "straight", "coriolis": False}

    def lowest(value: float) -> float:
        return float(np.arcsinh(solve(sweep.at(value), modes=1, **options).omega_squared[0]))

    try:
        at = brentq(lowest, low, high, xtol=PRECISION * (high - low), rtol=PRECISION)
    except (BeamvizError, ValueError):  # with a spin-up, or no straight state at one of the ends
        return []
    return [Event("buckling", (before.labels[0], after.labels[0]), float(at), 0.0)]


def _is_bent(outcome: Outcome) -> TypeGuard[Solution]:
    return isinstance(outcome, Solution) and outcome.equilibrium.shape == "bent"


def _tips(outcomes: list[Outcome]) -> np.ndarray:
    """Tips (values, 2) of the states; nan without a bent one."""
    none = np.full(2, np.nan)
    return np.array([one.equilibrium.tip if _is_bent(one) else none for one in outcomes])


def _may_jump(outcomes: list[Outcome], k: int) -> bool:
    """Whether the tip moves much further from value k to the next than between their neighbours."""
    first, last = max(k - 2, 0), min(k + 4, len(outcomes))
    moves = np.linalg.norm(np.diff(_tips(outcomes[first:last]), axis=0), axis=1)
    others = np.delete(moves, k - first)
    others = others[np.isfinite(others)]
    return moves[k - first] > max(SAME_TIP, JUMP * others.max() if len(others) else 0.0)


def _limit_point(
    over: str, low: float, high: float, before: Outcome, after: Outcome
) -> list[Event]:
    """The limit point, between two values, of the bent state at one of them."""
    for start, stop in ((before, high), (after, low)):
        if not _is_bent(start):
            continue
        with suppress(NotConverged):
            at = end_of_bent_state(start, over, stop)
            if at is not None and low <= at <= high:
                first, last = (
                    one if isinstance(one, Solution) else start for one in (before, after)
                )
                return [Event("limit point", (first.labels[0], last.labels[0]), at, 0.0)]
    return []


def _second_states(sweep: Sweep, values: np.ndarray, outcomes: list[Outcome]) -> list[Event]:
    """The limit point, or else the first value, of the first other stable bent state found. The
    label of its lowest branch is "B1 (state 2)" or so."""
    for k in np.unique(np.linspace(0, len(values) - 1, SECOND_STATES_SOUGHT).astype(int)):
        own = outcomes[k]
        for other in other_stable_states(own)[:1] if isinstance(own, Solution) else ():
            end, start = None, float(values[0])
            with suppress(NotConverged):
                end = end_of_bent_state(other, sweep.over, start)
            labels = own.labels[0], f"{other.labels[0]} (state 2)"
            at = start if end is None else end
            return [Event("second state", labels, at, float(other.frequencies[0]))]
    return []
