"""Limits of a sweep: values at which equilibrium, stability or convergence begin or end."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.interpolate import barycentric_interpolate

from beamviz.errors import NoEquilibrium, NotConverged
from beamviz.frequency_loci.axis import Axis
from beamviz.frequency_loci.curves import Curves, polish
from beamviz.frequency_loci.mode_vectors import Outcome
from beamviz.frequency_loci.sweep import Sweep
from beamviz.solver.solution import Solution

PRECISION = 1e-9  # relative, of a limit of equilibrium
FINEST = 1e-12  # of the sweep: least precision of these
ROUGH = 1e-5  # of the sweep: precision of a limit of convergence
OVERSHOOT = 0.1  # of the remaining interval: trial value beyond the extrapolated limit
EXTRAPOLATED = 3  # number of values that a limit is extrapolated from
MAX_SOLVES = 300  # for all limits of a sweep; one takes about 10, few sweeps have more than 4

WORDS = {
    NoEquilibrium.kind: "no equilibrium",
    NotConverged.kind: "not converged",
    "unstable": "unstable",
}
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
            if kind in WORDS:
                about = "" if self.remaining > 0 else "about "  # some are midpoints
                message = f"{WORDS[kind]} for {self.sweep.over} = {about}{low:.6g} .. {high:.6g}"
                yield Limit(kind, low, high, message)

    def _between(self, low: float, high: float) -> float:
        """The value between two solved ones at which equilibrium, or convergence, begins or ends;
        the midpoint once no solves remain.

        By bisection, accelerated by extrapolation of the excess of gamma over the limit of
        equilibrium; over gamma that is the distance from the limit.
        """
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
