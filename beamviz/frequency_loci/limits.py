"""Limits of a sweep: where equilibrium, stability or convergence begin and end."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import barycentric_interpolate
from scipy.optimize import brentq

from beamviz.errors import NoEquilibrium, NotConverged
from beamviz.frequency_loci.sweep import Outcome, Sweep
from beamviz.solver.solution import Solution

PRECISION = 1e-9  # relative: how exactly the end of an equilibrium or of stability is located
FINEST = 1e-12  # of the sweep: nor more exactly than this
ROUGH = 1e-5  # of the sweep: how exactly the end of convergence is located
OVERSHOOT = 0.1  # of the interval left: how far beyond the extrapolated limit it is bracketed
EXTRAPOLATED = 3  # values
MAX_SOLVES = 300  # for all limits of a sweep; one takes about 10, and few sweeps have more than 4

WORDS = {
    NoEquilibrium.kind: "no equilibrium",
    NotConverged.kind: "not converged",
    "unstable": "unstable",
}

Change = tuple[float, str]  # where the state changes, and to which


class Limit(NamedTuple):
    """A part of a sweep without equilibrium, without stability or without convergence."""

    kind: str  # "no-equilibrium", "unstable", "not-converged"
    start: float
    stop: float
    message: str


def locate_limits(sweep: Sweep, values: np.ndarray) -> Iterator[Limit]:
    """The parts of solved values (n,) without equilibrium, stability or convergence."""
    search = _Search(sweep, float(np.ptp(values)), MAX_SOLVES)
    changes = [(float(values[0]), _state(sweep.outcomes[float(values[0])]))]
    for low, high in pairwise(values.tolist()):
        changes += search.changes(low, high)
    ends = [*(at for at, _ in changes[1:]), float(values[-1])]
    for (start, kind), stop in zip(changes, ends, strict=True):
        if kind != "stable":
            about = "" if search.remaining > 0 else "about "  # some are halfway between two values
            message = f"{WORDS[kind]} for {sweep.over} = {about}{start:.6g} .. {stop:.6g}"
            yield Limit(kind, start, stop, message)


def _state(outcome: Outcome) -> str:
    """ "stable", "unstable", or the kind of the error."""
    return outcome.equilibrium.status if isinstance(outcome, Solution) else outcome.kind


class _ThirdState(Exception):
    """A third state between two others."""

    def __init__(self, at: float):
        self.at = at


@dataclass
class _Search:
    """Search between solved values of a sweep, with a limited number of solves."""

    sweep: Sweep
    length: float  # of the sweep
    remaining: int  # solves

    def changes(self, low: float, high: float) -> list[Change]:
        """Where the state changes between two solved values, and to which; halfway once no solves
        remain."""
        before, after = self.sweep.outcomes[low], self.sweep.outcomes[high]
        if _state(before) == _state(after):
            return []
        if self.remaining <= 0:
            return [((low + high) / 2, _state(after))]
        try:
            if isinstance(before, Solution) and isinstance(after, Solution):
                at = self._onset_of_instability(low, high)
            elif self.sweep.over == "gamma" and isinstance(after, NoEquilibrium):
                at = min(max(after.limit, low), high)
            else:
                at = self._end_of_equilibrium(low, high)
        except _ThirdState as third:
            return self.changes(low, third.at) + self.changes(third.at, high)
        return [(at, _state(after))]

    def _onset_of_instability(self, low: float, high: float) -> float:
        """Where the lowest omega^2 vanishes."""

        def lowest(value: float) -> float:
            outcome = self._outcome(value)
            if not isinstance(outcome, Solution):
                raise _ThirdState(value)
            return math.asinh(outcome.omega_squared[0])  # a straighter line: it may reach -1e9

        return brentq(lowest, low, high, xtol=FINEST * self.length, rtol=PRECISION)

    def _end_of_equilibrium(self, low: float, high: float) -> float:
        """Where the equilibrium, or convergence, begins or ends: by bisection, or faster by
        extrapolation of the excess of the beam's speed over the last one with an equilibrium."""
        before, after = self._outcome(low), self._outcome(high)
        numerical = isinstance(before, NotConverged) or isinstance(after, NotConverged)
        coarse = ROUGH * self.length if numerical else 0.0
        ends_at_stop = isinstance(after, NoEquilibrium)
        existence = isinstance(before, NoEquilibrium) != ends_at_stop

        def state(outcome: Outcome) -> Any:  # numerics may fail close to the end of an equilibrium
            return isinstance(outcome, NoEquilibrium) if existence else _state(outcome)

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
            if state(outcome) == state(before):
                start = value
            elif state(outcome) == state(after):
                stop = value
            else:
                raise _ThirdState(value)
            if excess := self._excess(value, outcome):
                excesses += excess
                last, root = root, _extrapolate(excesses)
                if start < root < stop and abs(root - last) <= fine:
                    return root
        return (start + stop) / 2

    def _outcome(self, value: float) -> Outcome:
        """The outcome at a value, solved if it was not."""
        if value not in self.sweep.outcomes:
            self.remaining -= 1
            self.sweep.solve(np.array([value]))
        outcome = self.sweep.outcomes[value]
        if isinstance(outcome, NoEquilibrium) and self.sweep.at(value).gamma < outcome.limit:
            return NotConverged(str(outcome))  # there is one, too near its end to be solved
        return outcome

    def _excess(self, value: float, outcome: Outcome) -> list[tuple[float, float]]:
        """Where no equilibrium exists: by how much the speed exceeds its limit, and the value."""
        if not isinstance(outcome, NoEquilibrium):
            return []
        return [(self.sweep.at(value).gamma - outcome.limit, value)]


def _extrapolate(excesses: Sequence[tuple[float, float]]) -> float:
    """The value without excess, by those with the least; nan if they are too few."""
    excess, values = np.array(sorted(excesses)[:EXTRAPOLATED]).reshape(-1, 2).T
    if len(excess) < 2 or not np.diff(excess).all():
        return math.nan
    return float(barycentric_interpolate(excess, values, 0.0))
