"""The loci chart as data: the loci to compute, and the arrays and styles of the plot."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Any, Self

import numpy as np
from viser import uplot

from beamviz.beam import Beam
from beamviz.drawing.text import Measure, frequencies, measure
from beamviz.explorer.page.style import COLOURS, FAINT, LINE, MARK, dot
from beamviz.explorer.state import Case
from beamviz.frequency_loci import Branch, Event, Loci, loci
from beamviz.frequency_loci.forced_response import Resonance, resonances
from beamviz.frequency_loci.sweep import CHART_POINTS, chart_range
from beamviz.scene import MODES
from beamviz.solver.solution import BENDING, MIXED, STRETCHING, Solution

FAMILIES = (BENDING, STRETCHING, MIXED)
PER_REV = (1, 2, 3, 4, 5)
ROUND = (1.0, 1.2, 1.4, 1.6, 1.8, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0)


@dataclass(frozen=True)
class ChartRequest:
    """The loci to compute: `beam` has the start of the range as its number `over`; options:
    keywords of `solve`."""

    beam: Beam
    over: str
    start: float
    stop: float
    options: dict[str, Any]

    @classmethod
    def around(cls, case: Case, over: str) -> Self:
        """The chart around a case. Raises InvalidInput where a number is out of range."""
        beam = case.beam()
        start, stop = chart_range(beam, over)
        return cls(beam.replace(**{over: start}), over, start, stop, case.options)

    def same_axis(self, case: Case) -> Self:
        """The chart of another case over the same range."""
        beam = case.beam().replace(**{self.over: self.start})
        return replace(self, beam=beam, options=case.options)

    def chart(self) -> "Chart":
        """The chart. Raises the errors of `loci`."""
        values = np.linspace(self.start, self.stop, CHART_POINTS)
        found = loci(self.beam, self.over, values, **self.options)
        lines = len(PER_REV) if self.over == "gamma" else 0
        return Chart(self, found, tuple(resonances(found, lines)))


Lanes = dict[str, list[np.ndarray]]  # by family, arrays (n,)


@dataclass(frozen=True)
class Chart:
    """Computed loci, with their resonances over the speed; or in `message` why there are none."""

    request: ChartRequest
    loci: Loci | None = None
    resonances: tuple[Resonance, ...] = ()
    message: str = ""

    @property
    def values(self) -> np.ndarray:
        """Values (n,) of the axis; both its ends where there are no loci."""
        return self.loci.values if self.loci else np.array([self.request.start, self.request.stop])

    @property
    def events(self) -> tuple[Event, ...]:
        """Crossings and veerings."""
        return self.loci.events if self.loci else ()

    @cached_property
    def lanes(self) -> Lanes:
        """The lines to draw."""
        return lanes(self.loci.branches if self.loci else ())

    @cached_property
    def measures(self) -> tuple[Measure, Measure]:
        """Display units of the axis and of the frequencies."""
        units = self.loci.units if self.loci else self.request.beam.units
        return measure(self.request.over, units), frequencies(units)

    @cached_property
    def top(self) -> float:
        """End of the frequency axis: a round number in display units, a little above all loci."""
        if self.loci is None:
            return 1.0
        factor = self.measures[1].factor
        found = np.concatenate([branch.frequency for branch in self.loci.branches])
        largest = 1.03 * factor * np.max(found, initial=0.0, where=np.isfinite(found)) or 1.0
        power = 10.0 ** math.floor(math.log10(largest))
        return power * next(step for step in ROUND if step * power >= largest) / factor


def lanes(branches: Sequence[Branch]) -> Lanes:
    """One array (n,) per run of points in which a branch stays in one family, nan elsewhere.

    Consecutive runs share a point, so that a line in two colours has no gap. A branch needs
    several arrays because uPlot draws a straight line across nan.
    """
    rows: Lanes = {family: [] for family in FAMILIES}
    for branch in branches:
        known, count = np.isfinite(branch.frequency), len(branch.frequency)
        family = [own if there else None for own, there in zip(branch.family, known, strict=True)]
        cuts = [k for k in range(1, count) if family[k] != family[k - 1]]
        for start, stop in pairwise([0, *cuts, count]):
            if kind := family[start]:
                row = np.full(count, np.nan)
                end = stop + 1 if stop < count and known[stop] else stop
                row[start:end] = branch.frequency[start:end]
                rows[kind].append(row)
    return rows


def enough_lanes(count: int, rows: Lanes) -> int:
    """`count`, doubled until the lines of every family fit."""
    while count < max(map(len, rows.values())):
        count *= 2
    return count


def padded(rows: Lanes, count: int, points: int) -> list[np.ndarray]:
    """`count` arrays (points,) for each family, one family after the other."""
    nothing = np.full(points, np.nan)
    return [row for family in FAMILIES for row in (*rows[family], *[nothing] * count)[:count]]


def lines_at(x: np.ndarray, chart: Chart, count: int) -> list[np.ndarray]:
    """`count` lines (n,) of each family of a chart, interpolated at x (n,)."""
    rows = padded(chart.lanes, count, len(chart.values))
    return [np.interp(x, chart.values, row, math.nan, math.nan) for row in rows]


def series(
    chart: Chart,
    solution: Solution | None,
    count: int,
    *,
    per_rev: bool,
    second: Chart | None = None,
    second_count: int = 0,
) -> tuple[np.ndarray, ...]:
    """Arrays (n,) over a common x, in display units, nan where nothing is drawn.

    x, `count` lines per family, PER_REV lines, an upright line and MODES marks at the beam of
    `solution`, `second_count` lines per family of a second chart, crossings, veerings.
    """
    over, top = chart.request.over, chart.top
    value = getattr(solution.beam, over) if solution else math.nan
    shown = chart.loci is not None and chart.values[0] <= value <= chart.values[-1]
    own = [value] if shown else []
    x = np.union1d(chart.values, [*(event.at for event in chart.events), *own])
    if shown:  # twice, so that the mark of the beam can be an upright line
        x = np.insert(x, np.searchsorted(x, value), value)
    drawn = chart.loci is not None and per_rev and over == "gamma"
    upright, *marks = np.full((1 + MODES, len(x)), np.nan)
    if solution and shown:
        k = int(np.searchsorted(x, value))
        upright[k : k + 2] = 0.0, top
        for mark, frequency in zip(marks, solution.frequencies, strict=False):
            mark[k] = frequency
    events = {kind: np.full(len(x), np.nan) for kind in ("crossing", "veering")}
    for event in chart.events:
        events[event.kind][np.searchsorted(x, event.at)] = event.frequency
    below = [
        np.where(line <= top, line, np.nan)
        for line in lines_at(x, second or Chart(chart.request), second_count)
    ]
    lines = [
        *lines_at(x, chart, count),
        *(np.where(drawn & (k * x <= top), k * x, np.nan) for k in PER_REV),
        *(upright, *marks),
        *below,
        *events.values(),
    ]
    along, across = chart.measures
    return (along.factor * x, *(across.factor * line for line in lines))


def styles(count: int, second_count: int = 0) -> tuple[uplot.Series, ...]:
    """Styles of the arrays of `series`."""
    lines: list[uplot.Series] = [{}]
    for family in FAMILIES:
        lines += [{"stroke": COLOURS[family], "width": 2, **LINE}] * count
    lines += [{"stroke": FAINT, "width": 1, "dash": (5, 4), **LINE}] * len(PER_REV)
    lines.append({"stroke": MARK, "width": 1, "dash": (2, 3), **LINE})
    lines += [{"stroke": MARK, "width": 0, "points": dot("#ffffff", MARK, 9)}] * MODES
    for family in FAMILIES:
        paler: uplot.Series = {"stroke": COLOURS[family] + "90", "width": 1.25, "dash": (4, 3)}
        lines += [{**paler, **LINE}] * second_count
    lines += [{"stroke": MARK, "width": 0, "points": dot(c, MARK, 7)} for c in ("#ffffff", MARK)]
    return tuple(lines)


def same_event(found: Loci, event: Event, reach: float) -> Event | None:
    """The nearest event of the same two branches in other loci, within `reach`."""
    near = [
        one
        for one in found.events
        if {*one.branches} == {*event.branches} and abs(one.at - event.at) <= reach
    ]
    return min(near, key=lambda one: abs(one.at - event.at), default=None)
