"""Where along a sweep equilibrium, stability or convergence begin and end."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.interpolate import barycentric_interpolate
from scipy.optimize import brentq

from beamviz.errors import NoEquilibrium, NotConverged
from beamviz.frequency_loci.sweep import Answer, Sweep
from beamviz.solver.solution import Solution

PRECISION = 1e-9  # relative: how exactly the end of an equilibrium or of stability is located
FINEST = 1e-12  # of the sweep: nor more exactly than this
ROUGH = 1e-5  # of the sweep: how exactly the end of what numerics can do is located
SHORT = 0.1  # of the way to where an equilibrium is expected: beyond it nothing is learnt
EXTRAPOLATED = 3  # places
MAX_SOLVES = 300  # for all edges of a sweep; one takes about 10, and few sweeps have more than 4

STABLE = "stable"
WORDS = {
    NoEquilibrium.kind: "no equilibrium",
    NotConverged.kind: "not converged",
    "unstable": "unstable",
}

Edge = tuple[float, str]  # where the state changes, and to what


class Limit(NamedTuple):
    """A part of a sweep that has no equilibrium, is unstable, or did not converge."""

    kind: str  # "no-equilibrium", "unstable", "not-converged"
    start: float
    stop: float
    message: str


def limits(sweep: Sweep, values: np.ndarray) -> Iterator[Limit]:
    """The parts of solved values without equilibrium, stability or convergence."""
    search = Search(sweep, float(np.ptp(values)), MAX_SOLVES)
    edges = [(float(values[0]), state(sweep.answers[float(values[0])]))]
    for low, high in pairwise(values.tolist()):
        edges += search.edges(low, high)
    ends = [*(place for place, _ in edges[1:]), float(values[-1])]
    for (start, kind), stop in zip(edges, ends, strict=True):
        if kind != STABLE:
            about = "" if search.room > 0 else "about "  # some edges are halfway between two values
            words = f"{WORDS[kind]} for {sweep.over} = {about}{start:.6g} .. {stop:.6g}"
            yield Limit(kind, start, stop, words)


def state(answer: Answer) -> str:
    """What an answer is: "stable", "unstable", or the kind of its error."""
    return answer.equilibrium.status if isinstance(answer, Solution) else answer.kind


class Between(Exception):
    """A third state at a place between two others."""

    def __init__(self, place: float):
        self.place = place


@dataclass
class Search:
    """Looks between solved values of a sweep, as long as there is room for more solves."""

    sweep: Sweep
    length: float  # of the sweep
    room: int

    def edges(self, low: float, high: float) -> list[Edge]:
        """Where the state changes between two solved values, and to what; in the middle where
        there is no room to view."""
        before, after = self.sweep.answers[low], self.sweep.answers[high]
        if state(before) == state(after):
            return []
        if self.room <= 0:
            return [((low + high) / 2, state(after))]
        try:
            if isinstance(before, Solution) and isinstance(after, Solution):
                place = self._buckling(low, high)
            elif self.sweep.over == "gamma" and isinstance(after, NoEquilibrium):
                place = min(max(after.limit, low), high)
            else:
                place = self._end(low, high)
        except Between as third:
            return self.edges(low, third.place) + self.edges(third.place, high)
        return [(place, state(after))]

    def _buckling(self, low: float, high: float) -> float:
        """Where stability begins or ends: the lowest omega^2 vanishes."""

        def lowest(place: float) -> float:
            answer = self._answer(place)
            if not isinstance(answer, Solution):
                raise Between(place)
            return float(
                np.arcsinh(answer.omega_squared[0])
            )  # a straighter line: it may reach -1e9

        return brentq(lowest, low, high, xtol=FINEST * self.length, rtol=PRECISION)

    def _end(self, low: float, high: float) -> float:
        """Where the equilibrium, or convergence, begins or ends: by halves, or nearly to where the
        last speed with an equilibrium becomes that of the beam, by what is known of it."""
        before, after = self._answer(low), self._answer(high)
        coarse = ROUGH * self.length if _numeric(before) or _numeric(after) else 0.0
        start, stop, root = low, high, math.nan
        beyond = [self._beyond(place) for place in (low, high) if self._ended(place)]
        while stop - start > max(fine := self._fine(start, stop), coarse) and self.room > 0:
            place = (start + stop) / 2
            if start < root < stop:
                place = root + SHORT * ((stop if self._ended(stop) else start) - root)
            answer = self._answer(place)
            if _alike(answer, before, after):
                start = place
            elif _alike(answer, after, before):
                stop = place
            else:
                raise Between(place)
            if self._ended(place):
                beyond.append(self._beyond(place))
                last, root = root, _root(beyond)
                if start < root < stop and abs(root - last) <= fine:
                    return root
        return (start + stop) / 2

    def _fine(self, start: float, stop: float) -> float:
        """How exactly an edge between two values is located."""
        return max(PRECISION * max(abs(start), abs(stop)), FINEST * self.length)

    def _answer(self, place: float) -> Answer:
        """The answer at a place."""
        if place not in self.sweep.answers:
            self.room -= 1
            self.sweep.solve(np.array([place]))
        return self.sweep.answers[place]

    def _ended(self, place: float) -> bool:
        """Whether there is no equilibrium at a place."""
        return isinstance(self._answer(place), NoEquilibrium)

    def _beyond(self, place: float) -> tuple[float, float]:
        """By how much the speed at a place is beyond the last with an equilibrium; the place."""
        answer = self._answer(place)
        assert isinstance(answer, NoEquilibrium)
        return self.sweep.at(place).gamma - answer.limit, place


def _root(beyond: Sequence[tuple[float, float]]) -> float:
    """The place that would be beyond by nothing, by those that are least; nan if they are few."""
    much, places = np.array(sorted(beyond)[:EXTRAPOLATED]).reshape(-1, 2).T
    if len(much) < 2 or not np.diff(much).all():
        return math.nan
    return float(barycentric_interpolate(much, places, 0.0))


def _numeric(answer: Answer) -> bool:
    """Whether it is the numerics that have come to an end, and not the beam."""
    return isinstance(answer, NotConverged)


def _alike(answer: Answer, one: Answer, other: Answer) -> bool:
    """Whether an answer is of the kind of one rather than of another.

    At the end of an equilibrium all that counts is whether there is one: close to it numerics
    fail first.
    """
    if isinstance(one, NoEquilibrium) != isinstance(other, NoEquilibrium):
        return isinstance(answer, NoEquilibrium) == isinstance(one, NoEquilibrium)
    return state(answer) == state(one)
