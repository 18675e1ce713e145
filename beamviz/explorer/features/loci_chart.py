"""The loci chart as data: the range of its axis, what is computed, and the lines to draw."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple, Self

import numpy as np

from beamviz.beam import Beam
from beamviz.display_units import frequencies, measure
from beamviz.explorer.state import Case
from beamviz.frequency_loci import Branch, Event, Loci, loci
from beamviz.frequency_loci.chart_range import POINTS, SPANS, chart_range
from beamviz.frequency_loci.forced_response import Resonance, resonances
from beamviz.scene import MODES
from beamviz.solver.solution import BENDING, MIXED, STRETCHING, Solution

FAMILIES = (BENDING, STRETCHING, MIXED)
LANES = 16  # lines of one family there is room for at first
PER_REV = (1, 2, 3, 4, 5)
ROUND = (1.0, 1.2, 1.4, 1.6, 1.8, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0)


@dataclass(frozen=True)
class Question:
    """A chart to compute: `beam` has the start of the range for the number swept over."""

    beam: Beam
    over: str
    start: float
    stop: float
    options: dict[str, Any]

    @classmethod
    def of(cls, case: Case, over: str) -> Self:
        """The chart around a case; InvalidInput where that is no beam."""
        beam = case.beam()
        start, stop = chart_range(beam, over)
        return cls(beam.replace(**{over: start}), over, start, stop, case.options)

    def asked_of(self, case: Case) -> Self:
        """The same chart of another beam."""
        beam = case.beam().replace(**{self.over: self.start})
        return replace(self, beam=beam, options=case.options)


@dataclass(frozen=True)
class Chart:
    """What came of a question: loci, with their resonances over the speed, or in `words` why
    there are none."""

    question: Question
    loci: Loci | None = None
    words: str = ""
    resonances: tuple[Resonance, ...] = ()

    @classmethod
    def nothing(cls) -> Self:
        """What is shown before the first chart."""
        return cls(Question(Beam(), "gamma", *SPANS["gamma"], {}))

    @property
    def events(self) -> tuple[Event, ...]:
        """The meetings."""
        return self.loci.events if self.loci else ()

    @cached_property
    def rows(self) -> "Lanes":
        """The lines over the values of the loci."""
        return lanes(self.loci.branches if self.loci else ())


def charted(question: Question) -> Chart:
    """Compute a chart."""
    found = computed(question)
    lines = len(PER_REV) if question.over == "gamma" else 0
    return Chart(question, found, resonances=tuple(resonances(found, lines)))


def computed(question: Question) -> Loci:
    """The loci of a question."""
    values = np.linspace(question.start, question.stop, POINTS)
    return loci(question.beam, question.over, values, **question.options)


class Point(NamedTuple):
    """Where the beam of the scene is on a chart."""

    value: float
    frequencies: np.ndarray  # (modes,), nan where unstable
    names: tuple[tuple[str, ...], tuple[str, ...]]  # labels and families

    @classmethod
    def of(cls, solution: Solution, over: str) -> Self:
        """The point of a solution on an axis."""
        names = solution.labels, solution.families
        return cls(float(getattr(solution.beam, over)), solution.frequencies, names)


class Piece(NamedTuple):
    """A part of a branch that stays in one family."""

    family: str
    start: int
    stop: int  # the first point behind it
    values: np.ndarray  # (stop - start,)


def pieces(branch: Branch) -> Iterator[Piece]:
    """A branch cut where it changes its family or has no frequency; pieces that follow each
    other share a point, so that a line in two colours has no gap."""
    frequency, family = branch.frequency, branch.family
    start, n = 0, len(frequency)
    while start < n:
        if not math.isfinite(frequency[start]):
            start += 1
            continue
        stop = start + 1
        while stop < n and math.isfinite(frequency[stop]) and family[stop] == family[start]:
            stop += 1
        end = min(stop + 1, n) if stop < n and math.isfinite(frequency[stop]) else stop
        yield Piece(str(family[start]), start, end, frequency[start:end])
        start = stop


Lanes = dict[str, list[np.ndarray]]  # for each family arrays (n,)


def lanes(branches: Sequence[Branch]) -> Lanes:
    """All pieces of all branches, nan around them. Each has an array of its own, since a page
    draws a line straight across nan."""
    rows: Lanes = {family: [] for family in FAMILIES}
    for branch in branches:
        for family, start, stop, values in pieces(branch):
            row = np.full(len(branch.frequency), np.nan)
            row[start:stop] = values
            rows[family].append(row)
    return rows


def roomy(room: int, rows: Lanes) -> int:
    """`room`, doubled until every family has enough of it."""
    while room < max(map(len, rows.values())):
        room *= 2
    return room


def filled(rows: Lanes, room: int, count: int) -> list[np.ndarray]:
    """`room` arrays (count,) for each family, one family after the other."""
    nothing = np.full(count, np.nan)
    return [row for family in FAMILIES for row in (*rows[family], *[nothing] * room)[:room]]


def spread(x: np.ndarray, values: np.ndarray, y: np.ndarray) -> np.ndarray:
    """y (values,) at x (n,), which holds all values: between them on the line, nan in gaps."""
    left = np.clip(np.searchsorted(values, x, side="right") - 1, 0, len(values) - 2)
    share = (x - values[left]) / (values[left + 1] - values[left])
    ends = y[left] * (1 - share) + y[left + 1] * share
    return np.where(share == 0, y[left], np.where(share == 1, y[left + 1], ends))


def marked(x: np.ndarray, at: float, value: float) -> np.ndarray:
    """nan (n,) but for `value` at the first x that is `at`."""
    row = np.full(len(x), np.nan)
    row[np.searchsorted(x, at)] = value
    return row


def top(found: Loci) -> float:
    """The end of the axis of frequency: a round number, as it is shown, a little above all loci."""
    factor = frequencies(found.units).factor
    largest = factor * 1.03 * max(
        (np.nanmax(b.frequency) for b in found.branches if np.isfinite(b.frequency).any()),
        default=1.0,
    )  # fmt: skip
    power = 10.0 ** math.floor(math.log10(largest))
    return power * next(step for step in ROUND if step * power >= largest) / factor


def series(
    chart: Chart,
    point: Point | None,
    room: int,
    *,
    per_rev: bool,
    second: Chart | None = None,
    second_room: int = 0,
) -> tuple[np.ndarray, ...]:
    """The chart, in the units of its beam, as arrays (n,) over a common x, nan where nothing is
    drawn: x, `room` lines of each family, PER_REV lines, the line and the MODES marks of the
    point, `second_room` lines of each family of a second chart, crossings, veerings."""
    found = chart.loci
    if found is None:
        return empty(chart.question, room + second_room)
    values, high = found.values, top(found)
    here = point if point and values[0] <= point.value <= values[-1] else None
    at = [event.at for event in found.events] + ([here.value] if here else [])
    x = np.union1d(values, at)
    if here:  # twice: the mark of the point is an upright line
        x = np.insert(x, np.searchsorted(x, here.value), here.value)
    lines = [spread(x, values, row) for row in filled(chart.rows, room, len(values))]
    shown = per_rev and found.over == "gamma"
    lines += [np.where(shown & (k * x <= high), k * x, np.nan) for k in PER_REV]
    lines += operating(x, here, high)
    lines += below(x, second, second_room, high)
    for kind in ("crossing", "veering"):
        marks = [marked(x, e.at, e.frequency) for e in found.events if e.kind == kind]
        lines.append(np.fmax.reduce([np.full(len(x), np.nan), *marks]))
    along, across = measure(found.over, found.units), frequencies(found.units)
    return (along.factor * x, *(across.factor * line for line in lines))


def operating(x: np.ndarray, here: Point | None, high: float) -> list[np.ndarray]:
    """The upright line through the point, and a mark for each of its modes."""
    line = np.full(len(x), np.nan)
    marks = [np.full(len(x), np.nan) for _ in range(MODES)]
    if here:
        k = int(np.searchsorted(x, here.value))
        line[k : k + 2] = 0.0, high
        for mark, frequency in zip(marks, here.frequencies, strict=False):
            mark[k] = frequency
    return [line, *marks]


def below(x: np.ndarray, second: Chart | None, room: int, high: float) -> list[np.ndarray]:
    """`room` lines of each family of a second chart at x (n,), as far as they are below `high`."""
    if second is None or second.loci is None:
        return [np.full(len(x), np.nan)] * (len(FAMILIES) * room)
    values = second.loci.values
    lines = [spread(x, values, row) for row in filled(second.rows, room, len(values))]
    return [np.where(line <= high, line, np.nan) for line in lines]


def empty(question: Question, room: int) -> tuple[np.ndarray, ...]:
    """A chart without lines."""
    count = len(FAMILIES) * room + len(PER_REV) + 1 + MODES + 2
    nothing = np.full(2, np.nan)
    return (
        np.array([question.start, question.stop]),
        *[nothing] * count,
    )
