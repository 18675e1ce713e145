"""Limits along a path: values at which equilibrium, stability or convergence begin or end."""

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import barycentric_interpolate

from beamviz.errors import NoEquilibrium, NotConverged
from beamviz.frequency_loci.mode_vectors import Outcome
from beamviz.frequency_loci.path import ParameterPath, PathModes
from beamviz.frequency_loci.roots import find_roots
from beamviz.frequency_loci.tracking import Track
from beamviz.solver.solution import Solution
from beamviz.solver.stability import INSTABILITIES

PRECISION = 1e-9  # relative, of a limit of equilibrium
FINEST = 1e-12  # of the range: least precision of one
ROUGH = 1e-5  # of the range: precision of a limit of convergence
OVERSHOOT = 0.1  # of the remaining interval: trial value beyond the extrapolated limit
EXTRAPOLATED = 3  # number of values that a limit is extrapolated from
MAX_SOLVES = 300  # for all limits of a path; one takes about 10, few paths have more than 4

STABLE = "stable"
MESSAGES = {  # by the kind of a limit
    NoEquilibrium.kind: "no equilibrium",
    NotConverged.kind: "not converged",
    **INSTABILITIES,
    "not-located": "an event not located",
}


class Limit(NamedTuple):
    """A range of a path without equilibrium, stability or convergence, or with an event that could
    not be located."""

    # "no-equilibrium", "unstable" (divergence), "growing" (flutter), "not-converged", "not-located"
    kind: str
    start: float
    stop: float
    message: str

    @property
    def name(self) -> str:
        """The kind in words."""
        return MESSAGES[self.kind]


def not_located(event: str, over: str, low: float, high: float) -> Limit:
    """The range of an event, of this kind, that could not be located."""
    return Limit(
        "not-located", low, high, f"{event} not located in {over} = {low:.6g} .. {high:.6g}"
    )


class Change(NamedTuple):
    """A value from which on the outcome is of another kind: STABLE or that of a Limit."""

    at: float
    kind: str


def limits_of(changes: Sequence[Change], stop: float, over: str) -> Iterator[Limit]:
    """The ranges without equilibrium, stability or convergence, from the first of some changes of
    the kind of outcome to `stop`."""
    kinds: list[Change] = []
    for change in sorted(changes):
        if not kinds or change.kind != kinds[-1].kind:
            kinds.append(change)
    ends = [*(change.at for change in kinds[1:]), stop]
    for (start, kind), stop in zip(kinds, ends, strict=True):
        if kind != STABLE and start < stop:
            yield Limit(
                kind, start, stop, f"{MESSAGES[kind]} for {over} = {start:.6g} .. {stop:.6g}"
            )


def kind_of(outcome: Outcome) -> str:
    """The kind of an outcome: the status of a solution, or the kind of an error."""
    return outcome.equilibrium.status if isinstance(outcome, Solution) else outcome.kind


class Range(NamedTuple):
    """A range of a path with solutions."""

    low: float
    high: float
    ends_low: bool  # whether equilibrium ends at `low`; else the path does, or convergence
    ends_high: bool  # whether equilibrium ends at `high`


class Excess(NamedTuple):
    """How far gamma is above its limit of equilibrium at a value without equilibrium."""

    gamma: float
    value: float


class ExistenceSearch:
    """The search for the values between solved ones at which equilibrium or convergence begins or
    ends, with a limited number of solves.

    changes: these values, ascending, with the kind of outcome from each on. ranges: with solutions.
    """

    def __init__(self, path: ParameterPath, grid: NDArray):
        self.path = path
        self.end = float(grid[-1])
        self.length = float(grid[-1] - grid[0])
        self.remaining = MAX_SOLVES
        self.changes = [Change(float(grid[0]), existence(path.outcomes[float(grid[0])]))]
        self.ranges: list[Range] = []
        self._find(grid.tolist())

    def _find(self, solved: list[float]) -> None:
        """Fill `changes` and `ranges`."""
        outcomes = self.path.outcomes
        kinds = [existence(outcomes[value]) for value in solved]
        start, ends_low = solved[0], False
        for k, (low, high) in enumerate(pairwise(solved)):
            before, after = kinds[k : k + 2]
            if before == after:
                continue
            at = self._boundary(low, high)
            self.changes.append(Change(at, after))
            at_limit = NoEquilibrium.kind in (before, after)
            if before == STABLE:
                self.ranges.append(Range(start, at, ends_low, at_limit))
            start, ends_low = at, at_limit
        if kinds[-1] == STABLE:
            self.ranges.append(Range(start, solved[-1], ends_low, False))

    def _boundary(self, low: float, high: float) -> float:
        """The value between two solved ones at which equilibrium, or convergence, begins or ends.

        Over gamma the error at `high` names it: the limit of equilibrium. That may lie above `high`
        by the little by which a solve has to stay away from it.
        """
        named = self._excess(high, self.path.outcomes[high])
        if self.path.over == "gamma" and named:
            return min(max(high - named[0].gamma, low), self.end)
        return self._bisected(low, high)

    def _bisected(self, low: float, high: float) -> float:
        """The boundary by bisection; the midpoint of what is left once no solves remain. It is
        accelerated where equilibrium ends: there gamma exceeds its limit by an amount that errors
        name, and that is extrapolated to zero."""
        before, after = self._outcome(low), self._outcome(high)
        # Just before equilibrium ends, solves may fail: only those without equilibrium are beyond.
        equilibrium_ends = isinstance(before, NoEquilibrium) != isinstance(after, NoEquilibrium)
        sought = NoEquilibrium if equilibrium_ends else Solution
        # Where convergence ends varies with rounding error: it needs no digits.
        numerical = isinstance(before, NotConverged) or isinstance(after, NotConverged)
        coarse = ROUGH * self.length if numerical else 0.0
        start, stop, root = low, high, math.nan
        excesses = self._excess(low, before) + self._excess(high, after)
        while self.remaining > 0:
            fine = max(PRECISION * max(abs(start), abs(stop)), FINEST * self.length)
            if stop - start <= max(fine, coarse):
                break
            value = (start + stop) / 2
            if start < root < stop:
                # A little beyond the root, where there is no equilibrium: errors name the excess.
                beyond = stop if isinstance(after, NoEquilibrium) else start
                value = root + OVERSHOOT * (beyond - root)
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
        self.remaining -= value not in self.path.outcomes
        (outcome,) = self.path.solve(np.array([value]))
        if isinstance(outcome, NoEquilibrium) and self.path.at(value).gamma < outcome.limit:
            return NotConverged(str(outcome))  # it exists, but is too near its limit
        return outcome

    def _excess(self, value: float, outcome: Outcome) -> list[Excess]:
        """The excess of gamma over the limit of equilibrium at a value; empty without limit."""
        if not (isinstance(outcome, NoEquilibrium) and math.isfinite(outcome.limit)):
            return []
        return [Excess(self.path.at(value).gamma - outcome.limit, value)]


def existence(outcome: Outcome) -> str:
    """The kind of an error; of any solution STABLE."""
    return STABLE if isinstance(outcome, Solution) else outcome.kind


def _extrapolate(excesses: Sequence[Excess]) -> float:
    """The value of no excess, extrapolated from the least ones; nan for fewer than two."""
    gamma, values = np.array(sorted(excesses)[:EXTRAPOLATED]).reshape(-1, 2).T
    if len(gamma) < 2 or not np.diff(gamma).all():
        return math.nan
    return float(barycentric_interpolate(gamma, values, 0.0))


def stability_changes(track: Track, coalescences: Sequence[float]) -> list[Change]:
    """The values of a part with solutions at which its stability changes, and at its beginning the
    status there. coalescences: where two frequencies merge, and a vibration begins to grow."""
    path, values = track.path, track.values
    kinds = [kind_of(path.outcomes[value]) for value in values.tolist()]
    changes = [Change(track.low, kinds[0])]
    if path.is_straight:
        samples = _lowest(track.modes)[:, None]
        roots = find_roots(values, samples, lambda at, _: _lowest(path.modes(at)))
        for at, rises in zip(roots.at.tolist(), roots.rises.tolist(), strict=True):
            changes.append(Change(at, STABLE if rises else "unstable"))
        for bracket in roots.unlocated:  # beside values without a solution
            before, after = ("unstable", STABLE) if bracket.rises else (STABLE, "unstable")
            changes.append(Change(_bisected(path, bracket.low, bracket.high, before), after))
        return changes
    for k, (low, high) in enumerate(pairwise(values.tolist())):
        if kinds[k] != kinds[k + 1]:
            located = [at for at in coalescences if low <= at <= high]
            at = located[0] if located else _bisected(path, low, high, kinds[k])
            changes.append(Change(at, kinds[k + 1]))
    return changes


def _lowest(modes: PathModes) -> NDArray:
    """A function (n,) that vanishes with the lowest omega^2, and nearer to a straight line: that
    may be -1e9."""
    return np.arcsinh(np.fmin.reduce(modes.omega_squared, axis=(1, 2)))


def _bisected(path: ParameterPath, low: float, high: float, kind: str) -> float:
    """The value between two at which an outcome ceases to be of a kind, to ROUGH of their
    distance."""
    fine = ROUGH * (high - low)
    while high - low > fine:
        middle = (low + high) / 2
        if kind_of(path.solve(np.array([middle]))[0]) == kind:
            low = middle
        else:
            high = middle
    return (low + high) / 2
