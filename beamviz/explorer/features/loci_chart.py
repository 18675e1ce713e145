"""The loci chart as data: the loci to compute, and the lines to draw."""

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
from beamviz.explorer.jobs import Answer
from beamviz.explorer.page.style import COLOURS, FAINT, LINE, MARK, dot, marks
from beamviz.explorer.state import Case
from beamviz.frequency_loci import Branch, Event, Loci, loci
from beamviz.frequency_loci.forced_response import Resonance, resonances
from beamviz.frequency_loci.sweep import CHART_POINTS, chart_range
from beamviz.solver.solution import BENDING, MIXED, STRETCHING, Solution

FAMILIES = (BENDING, STRETCHING, MIXED)
PER_REV = (1, 2, 3, 4, 5)
ROUND = (1.0, 1.2, 1.4, 1.6, 1.8, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0)
Lines = dict[str, list[np.ndarray]]  # arrays (n,) by family, or by another group of one style


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

    @property
    def measures(self) -> tuple[Measure, Measure]:
        """Display units of the axis and of the frequencies; T* itself depends on mu."""
        units = None if self.over == "mu" else self.beam.units
        return measure(self.over, units), frequencies(units)

    def chart(self) -> "Chart":
        """The chart. Raises the errors of `loci`."""
        values = np.linspace(self.start, self.stop, CHART_POINTS)
        found = loci(self.beam, self.over, values, **self.options)
        count = len(PER_REV) if self.over == "gamma" else 0
        return Chart(self, found, tuple(resonances(found, count)))


@dataclass(frozen=True)
class Chart:
    """Computed loci, with their resonances over the speed; or in `message` why there are none."""

    request: ChartRequest
    loci: Loci | None = None
    resonances: tuple[Resonance, ...] = ()
    message: str = ""

    @classmethod
    def of(cls, answer: Answer[ChartRequest, Self] | None) -> Self | None:
        """The chart of an answer, one without loci for an error; None without an answer."""
        if answer is None:
            return None
        return answer.result or cls(answer.request, message=answer.message)

    @property
    def values(self) -> np.ndarray:
        """Values (n,) of the axis; both its ends where there are no loci."""
        return self.loci.values if self.loci else np.array([self.request.start, self.request.stop])

    @property
    def events(self) -> tuple[Event, ...]:
        """Crossings and veerings."""
        return self.loci.events if self.loci else ()

    @cached_property
    def lines(self) -> Lines:
        """The loci by family."""
        return lines_by_family(self.loci.branches if self.loci else ())

    @cached_property
    def top(self) -> float:
        """End of the frequency axis: a round number in display units, a little above all loci."""
        if self.loci is None:
            return 1.0
        factor = self.request.measures[1].factor
        found = np.concatenate([branch.frequency for branch in self.loci.branches])
        largest = 1.03 * factor * np.max(found, initial=0.0, where=np.isfinite(found)) or 1.0
        power = 10.0 ** math.floor(math.log10(largest))
        return power * next(step for step in ROUND if step * power >= largest) / factor


def lines_by_family(branches: Sequence[Branch]) -> Lines:
    """One array (n,) per run of points in which a branch stays in one family, nan elsewhere.

    Consecutive runs share a point, so that a line in two colours has no gap. A branch needs
    several arrays because uPlot draws a straight line across nan.
    """
    lines: Lines = {family: [] for family in FAMILIES}
    for branch in branches:
        known, count = np.isfinite(branch.frequency), len(branch.frequency)
        family = [own if there else None for own, there in zip(branch.family, known, strict=True)]
        cuts = [k for k in range(1, count) if family[k] != family[k - 1]]
        for start, stop in pairwise([0, *cuts, count]):
            if kind := family[start]:
                line = np.full(count, np.nan)
                end = stop + 1 if stop < count and known[stop] else stop
                line[start:end] = branch.frequency[start:end]
                lines[kind].append(line)
    return lines


STYLES: dict[str, uplot.Series] = {
    **{family: {"stroke": COLOURS[family], "width": 2, **LINE} for family in FAMILIES},
    "per-rev": {"stroke": FAINT, "width": 1, "dash": (5, 4), **LINE},
    "beam": {"stroke": MARK, "width": 1, "dash": (2, 3), **LINE},
    "modes": dot("#ffffff", MARK, 9),
    **{
        f"second {family}": {
            "stroke": COLOURS[family] + "90", "width": 1.25, "dash": (4, 3), **LINE
        }
        for family in FAMILIES
    },
    "crossing": dot("#ffffff", MARK, 7),
    "veering": dot(MARK, MARK, 7),
}  # fmt: skip


def chart_lines(
    chart: Chart, solution: Solution | None, *, per_rev: bool, second: Chart | None = None
) -> tuple[np.ndarray, Lines]:
    """x (n,) and the lines by the groups of STYLES: the loci, multiples of the speed, an upright
    line and marks at the beam of `solution`, the loci of a second chart, crossings and veerings."""
    over, top = chart.request.over, chart.top
    value = getattr(solution.beam, over) if solution else math.nan
    shown = chart.loci is not None and chart.values[0] <= value <= chart.values[-1]
    own = [value] if shown else []
    x = np.union1d(chart.values, [*(event.at for event in chart.events), *own])
    if shown:  # twice, so that the mark of the beam can be an upright line
        x = np.insert(x, np.searchsorted(x, value), value)
    lines = lines_at(x, chart)
    if per_rev and over == "gamma" and chart.loci:
        lines["per-rev"] = [np.where(k * x <= top, k * x, np.nan) for k in PER_REV]
    if solution and shown:
        upright = marks(x, [(value, 0.0)])
        upright[np.searchsorted(x, value) + 1] = top
        lines["beam"] = [upright]
        lines["modes"] = [marks(x, [(value, frequency)]) for frequency in solution.frequencies]
    for family, rows in (lines_at(x, second) if second else {}).items():
        lines[f"second {family}"] = [np.where(row <= top, row, np.nan) for row in rows]
    for kind in ("crossing", "veering"):
        found = [(event.at, event.frequency) for event in chart.events if event.kind == kind]
        lines[kind] = [marks(x, found)]
    return x, lines


def lines_at(x: np.ndarray, chart: Chart) -> Lines:
    """The loci of a chart, interpolated at x (n,)."""
    return {
        family: [np.interp(x, chart.values, row, math.nan, math.nan) for row in rows]
        for family, rows in chart.lines.items()
    }


def same_event(found: Loci, event: Event, reach: float) -> Event | None:
    """The nearest event of the same two branches in other loci, within `reach`."""
    near = [
        one
        for one in found.events
        if {*one.branches} == {*event.branches} and abs(one.at - event.at) <= reach
    ]
    return min(near, key=lambda one: abs(one.at - event.at), default=None)
