"""Limits of a sweep: values at which equilibrium, stability or convergence begin or end; and events
of an equilibrium that may be bent: buckling, limit points, second stable states."""

import math
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import NamedTuple, TypeGuard

import numpy as np
from scipy.interpolate import barycentric_interpolate
from scipy.optimize import brentq

from beamviz.errors import BeamvizError, NoEquilibrium, NotConverged
from beamviz.frequency_loci.axis import Axis
from beamviz.frequency_loci.crossings import Event
from beamviz.frequency_loci.curves import Curves, polish
from beamviz.frequency_loci.mode_vectors import Outcome
from beamviz.frequency_loci.sweep import Sweep
from beamviz.solver import solve
from beamviz.solver.solution import Solution

PRECISION = 1e-9  # relative, of a limit of equilibrium and of a buckling point
FINEST = 1e-12  # of the sweep: least precision of these
ROUGH = 1e-5  # of the sweep: precision of a limit of convergence
OVERSHOOT = 0.1  # of the remaining interval: trial value beyond the extrapolated limit
EXTRAPOLATED = 3  # number of values that a limit is extrapolated from
MAX_SOLVES = 300  # for all limits of a sweep; one takes about 10, few sweeps have more than 4
JUMP = 4.0  # ratio of a tip displacement to the neighbouring ones from which it may be a jump
SAME_TIP = 1e-3  # [L] distance of the tips up to which two states are the same
SECOND_STATES_SOUGHT = 4  # number of values at which second states are searched for

STABLE = "stable"

Change = tuple[float, str]  # value and new kind


class Limit(NamedTuple):
    """A range of a sweep without equilibrium, stability or convergence."""

    kind: str  # "no-equilibrium", "unstable", "not-converged"
    start: float
    stop: float
    message: str


def _kind(outcome: Outcome) -> str:
    """The kind of an error; of any solution STABLE, until `find_instabilities`."""
    return STABLE if isinstance(outcome, Solution) else outcome.kind


def _lowest(p: np.ndarray, squares: np.ndarray) -> np.ndarray:
    """A function (n, 1) that vanishes with the lowest omega^2, and nearer to a straight line: that
    may be -1e9."""
    return np.arcsinh(np.fmin.reduce(squares, axis=(1, 2)))[:, None]


@dataclass
class LimitSearch:
    """Search for limits between the solved values of a sweep, with a limited number of solves."""

    sweep: Sweep
    length: float  # of the sweep
    changes: list[Change] = field(default_factory=list)  # found so far
    remaining: int = MAX_SOLVES  # solves

    def axes(self) -> list[Axis]:
        """The ranges of the sweep with solutions; their ends are added to `changes`."""
        outcomes = self.sweep.outcomes
        solved = sorted(outcomes)
        axes: list[Axis] = []
        start, limited, kind = solved[0], False, _kind(outcomes[solved[0]])
        for low, high in pairwise(solved):
            if (after := _kind(outcomes[high])) == kind:
                continue
            at = self._between(low, high)
            self.changes.append((at, after))
            at_limit = NoEquilibrium.kind in (kind, after)
            if kind == STABLE:
                axes += self._axis(start, at, (limited, at_limit))
            start, limited, kind = at, at_limit, after
        return axes + (self._axis(start, solved[-1], (limited, False)) if kind == STABLE else [])

    def _axis(self, low: float, high: float, limited: tuple[bool, bool]) -> list[Axis]:
        """The axis between two changes, up to limits of equilibrium or else the last solutions."""
        solved = [
            value
            for value, outcome in self.sweep.outcomes.items()
            if isinstance(outcome, Solution) and low <= value <= high
        ]
        if not solved:
            return []
        ends = low if limited[0] else min(solved), high if limited[1] else max(solved)
        return [replace(self.sweep.axis(*ends), limited=limited)]

    def find_instabilities(self, curves: Curves) -> None:
        """Add the values at which the lowest omega^2 of the loci vanishes to `changes`."""
        if _lowest(*curves.table[:2])[0] < 0:
            self.changes.append((curves.axis.low, "unstable"))
        roots = curves.roots(_lowest)
        polish(roots, self.sweep, _lowest)
        self.changes += [(root.at, STABLE if root.slope > 0 else "unstable") for root in roots]

    def limits(self, start: float, stop: float) -> Iterator[Limit]:
        """The ranges of start .. stop without equilibrium, stability or convergence."""
        kinds: list[Change] = [(start, _kind(self.sweep.outcomes[start]))]
        for at, kind in sorted(self.changes):
            if kind != kinds[-1][1]:
                kinds.append((at, kind))
        ends = [*(at for at, _ in kinds[1:]), stop]
        for (low, kind), high in zip(kinds, ends, strict=True):
            if kind != STABLE:
                about = "" if self.remaining > 0 else "about "  # some are midpoints
                where = f"{self.sweep.over} = {about}{low:.6g} .. {high:.6g}"
                yield Limit(kind, low, high, f"{kind.replace('-', ' ')} for {where}")

    def _between(self, low: float, high: float) -> float:
        """The value between two solved ones at which equilibrium, or convergence, begins or ends;
        the midpoint once no solves remain. By bisection, accelerated by extrapolation of the excess
        of gamma over the limit of equilibrium; over gamma that is the distance from the limit."""
        if self.remaining <= 0:
            return (low + high) / 2
        after = self.sweep.outcomes[high]
        if self.sweep.over == "gamma" and (excess := self._excess(high, after)):
            return min(max(high - excess[0][0], low), high)
        before, after = self._outcome(low), self._outcome(high)
        numerical = isinstance(before, NotConverged) or isinstance(after, NotConverged)
        coarse = ROUGH * self.length if numerical else 0.0
        ends_at_stop = isinstance(after, NoEquilibrium)
        existence = isinstance(before, NoEquilibrium) != ends_at_stop
        sought = NoEquilibrium if existence else Solution  # solves may fail close to a limit
        start, stop, root = low, high, math.nan
        excesses = self._excess(low, before) + self._excess(high, after)
        while self.remaining > 0:
            fine = max(PRECISION * max(abs(start), abs(stop)), FINEST * self.length)
            if stop - start <= max(fine, coarse):
                break
            value = (start + stop) / 2
            if start < root < stop:
                value = root + OVERSHOOT * ((stop if ends_at_stop else start) - root)
            outcome = self._outcome(value)
            if isinstance(outcome, sought) == isinstance(before, sought):
                start = value
            else:
                stop = value
            if excess := self._excess(value, outcome):
                excesses += excess
                last, root = root, _extrapolate(excesses)
                if start < root < stop and abs(root - last) <= fine:
                    return root
        return (start + stop) / 2

    def _outcome(self, value: float) -> Outcome:
        """The outcome at a value, solved if it was not."""
        self.remaining -= value not in self.sweep.outcomes
        (outcome,) = self.sweep.solve(np.array([value]))
        if isinstance(outcome, NoEquilibrium) and self.sweep.at(value).gamma < outcome.limit:
            return NotConverged(str(outcome))  # it exists, but is too near its limit
        return outcome

    def _excess(self, value: float, outcome: Outcome) -> list[tuple[float, float]]:
        """The excess of gamma over the limit of equilibrium and the value; empty without limit."""
        if not (isinstance(outcome, NoEquilibrium) and math.isfinite(outcome.limit)):
            return []
        return [(self.sweep.at(value).gamma - outcome.limit, value)]


def _extrapolate(excesses: Sequence[tuple[float, float]]) -> float:
    """The value of no excess, extrapolated from the least ones; nan for fewer than two."""
    excess, values = np.array(sorted(excesses)[:EXTRAPOLATED]).reshape(-1, 2).T
    if len(excess) < 2 or not np.diff(excess).all():
        return math.nan
    return float(barycentric_interpolate(excess, values, 0.0))


def state_events(sweep: Sweep, values: np.ndarray) -> list[Event]:
    """The events, in no order, of the equilibria at ascending values. "buckling": the straight
    state loses its stability; "limit point": the bent state ends, and the branches end or continue
    on another state; "second state": the value from which another stable bent state exists."""
    events: list[Event] = []
    over, outcomes = sweep.over, sweep.solve(values)
    for low, high in pairwise(range(len(values))):
        before, after = outcomes[low], outcomes[high]
        ends = float(values[low]), float(values[high])
        if isinstance(before, Solution) and isinstance(after, Solution):
            if before.equilibrium.shape != after.equilibrium.shape:
                events += _buckling(sweep, *ends, before, after)
            elif is_bent(before) and _may_jump(outcomes, low):
                events += _limit_point(over, *ends, before, after)
        elif is_bent(before) or is_bent(after):
            events += _limit_point(over, *ends, before, after)
    return events + _second_states(sweep, values, outcomes)


def _buckling(
    sweep: Sweep, low: float, high: float, before: Solution, after: Solution
) -> list[Event]:
    """The point where the lowest omega^2 of the straight state vanishes."""
    options = sweep.problem.options | {"state": "straight", "coriolis": False, "modes": 1}

    def lowest(value: float) -> float:
        return float(np.arcsinh(solve(sweep.at(value), **options).omega_squared[0]))

    try:
        at = brentq(lowest, low, high, xtol=PRECISION * (high - low), rtol=PRECISION)
    except (BeamvizError, ValueError):  # with a spin-up, or no straight state at one of the ends
        return []
    return [Event("buckling", (before.labels[0], after.labels[0]), float(at), 0.0)]


def is_bent(outcome: Outcome) -> TypeGuard[Solution]:
    """Whether an outcome is a bent state."""
    return isinstance(outcome, Solution) and outcome.equilibrium.shape == "bent"


def _may_jump(outcomes: list[Outcome], k: int) -> bool:
    """Whether the tip moves much further from value k to the next than between their neighbours."""
    first, last = max(k - 2, 0), min(k + 4, len(outcomes))
    near, none = outcomes[first:last], np.full(2, np.nan)
    tips = np.array([one.equilibrium.tip if is_bent(one) else none for one in near])
    moves = np.linalg.norm(np.diff(tips, axis=0), axis=1)
    others = np.delete(moves, k - first)
    others = others[np.isfinite(others)]
    return moves[k - first] > max(SAME_TIP, JUMP * others.max() if len(others) else 0.0)


def _limit_point(
    over: str, low: float, high: float, before: Outcome, after: Outcome
) -> list[Event]:
    """The limit point, between two values, of the bent state at one of them."""
    from beamviz.solver.bent import end_of_bent_state

    for start, stop in ((before, high), (after, low)):
        if not is_bent(start):
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
    from beamviz.solver.bent import end_of_bent_state, other_stable_states

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
