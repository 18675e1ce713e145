"""Loci as background jobs compute them for charts, and these charts as data for the page."""

import math
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property, partial
from itertools import pairwise
from typing import Any, NamedTuple, Self

import numpy as np

from beamviz.beam import PARAMETERS, Beam
from beamviz.chart_ranges import CHART_POINTS, chart_range
from beamviz.drawing.text import Measure, frequencies, measure
from beamviz.explorer import page
from beamviz.explorer.page import Data
from beamviz.explorer.state import Case
from beamviz.frequency_loci import Branch, Event, Loci, loci
from beamviz.frequency_loci.identity import names_of_branches, names_of_event
from beamviz.frequency_loci.limits import Limit
from beamviz.scene import PER_REV

AT = 1e-7  # of the range: distance of a beam that is at an event
ROUND = (1.0, 1.2, 1.4, 1.6, 1.8, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0)
FAILURES = {
    "no-equilibrium": "No equilibrium",
    "unstable": "Unstable",
    "growing": "Vibrations grow",
    "not-converged": "The calculation did not converge",
    "not-located": "An event was not located",
}
AXES = {name: PARAMETERS[name].short_label for name in ("gamma", "alpha", "beta", "delta", "mu")}


@dataclass(frozen=True)
class ChartRequest:
    """The loci to compute. beam: its number `over` is the start of the range; options: keywords of
    `solve`; per_rev: the largest multiple of the speed for resonances."""

    beam: Beam
    over: str
    start: float
    stop: float
    options: dict[str, Any]
    per_rev: int = 0

    @classmethod
    def around(cls, case: Case, over: str, per_rev: int = 0) -> Self:
        """The chart around a case. Raises InvalidInput where a number is out of range."""
        beam = case.beam
        start, stop = chart_range(beam, over)
        beam = beam.replace(**{over: start})
        return cls(beam, over, start, stop, case.options, per_rev if over == "gamma" else 0)

    def same_axis(self, case: Case) -> Self:
        """The chart of another case over the same range."""
        beam = case.beam.replace(**{self.over: self.start})
        return replace(self, beam=beam, options=case.options, per_rev=0)

    @property
    def measures(self) -> tuple[Measure, Measure]:
        """Display units of the axis and of the frequencies; none over mu, on which T* depends."""
        units = None if self.over == "mu" else self.beam.units
        return measure(self.over, units), frequencies(units)

    def chart(self) -> "Chart":
        """The chart. Raises the errors of `loci`."""
        values = np.linspace(self.start, self.stop, CHART_POINTS)
        found = loci(self.beam, self.over, values, per_rev=self.per_rev, **self.options)
        x = np.union1d(values, [event.at for event in found.events])
        pairs = [event for event in found.events if not event.per_rev]
        names = {event: names_of_event(found, event) for event in pairs}
        return Chart(self, x, lines_of(found, x), found.events, found.limits, names)


class Line(NamedTuple):
    """A branch of loci as a line, at values x (n,) of the axis.

    frequency: (n,) in units of 1/T*, nan where it has none. mode: (n,) index at the nearest value
    solved for, -1 where the branch is not among the modes. runs: of one family and name of the
    mode, as index of the first point and of the last, family and name; consecutive runs share a
    point, so that lines have no gaps.
    """

    label: str
    frequency: np.ndarray
    mode: np.ndarray
    runs: list[tuple[int, int, str, str]]

    def name_at(self, k: int) -> str:
        """The name of the mode at a point; that of the branch where there is none."""
        names = [name for first, last, _, name in self.runs if first <= k <= last]
        return names[-1] if names else self.label


@dataclass(frozen=True, eq=False)
class Chart:
    """Loci as lines, without the solutions: those of a blade take megabytes.

    x: values of the axis (n,), of the loci and of the events. located: events and resonances.
    names: those of the modes of each event, but of resonances, whose names are those of the lines.
    """

    request: ChartRequest
    x: np.ndarray
    lines: list[Line]
    located: tuple[Event, ...]
    limits: tuple[Limit, ...]
    names: dict[Event, tuple[str, ...]]

    @cached_property
    def events(self) -> dict[str, Event]:
        """The events but resonances by key: the labels of their branches and a count, as
        'B3 S1 1'. Keys remain valid when the beam or the model changes."""
        events = (event for event in self.located if not event.per_rev)
        return numbered((" ".join(sorted(event.branches)), event) for event in events)

    @property
    def pairs(self) -> dict[str, Event]:
        """The crossings and veerings among the events."""
        kinds = ("crossing", "veering")
        return {key: event for key, event in self.events.items() if event.kind in kinds}

    def resonances_at(self, multiples: Sequence[int]) -> dict[str, Event]:
        """Resonances with these multiples of the speed by key: multiple, branch and a count."""
        shown = (event for event in self.located if event.per_rev in multiples)
        return numbered((f"{event.per_rev} {event.branches[0]}", event) for event in shown)

    def event_at(self, value: float) -> str:
        """The key of the event or resonance at a value of the axis, "" where there is none."""
        near = AT * (self.request.stop - self.request.start)
        places = self.events | self.resonances_at(PER_REV)
        distance = {key: abs(one.at - value) for key, one in places.items()}
        nearest = min(distance, key=distance.__getitem__, default="")
        return nearest if nearest and distance[nearest] <= near else ""

    def modes_of(self, event: Event) -> tuple[int, ...]:
        """The modes (from 0) of an event."""
        k = self.index_of(event)
        modes = {line.label: int(line.mode[k]) for line in self.lines}
        return tuple(modes[label] for label in event.branches if modes.get(label, -1) >= 0)

    def names_of(self, event: Event) -> list[str]:
        """The names of the modes of an event or a resonance there, stretching modes first."""
        found = self.names.get(event)
        if found is None:
            k = self.index_of(event)
            found = tuple(line.name_at(k) for line in self.lines if line.label in event.branches)
        return sorted(set(found), key=lambda name: (name[0] != "S", name))

    def index_of(self, event: Event) -> int:
        """The index in x of the value nearest to an event."""
        return int(np.argmin(abs(self.x - event.at)))

    def nearest_pair(self, value: float) -> Event | None:
        """The crossing or veering nearest to a value of the axis."""
        return min(self.pairs.values(), key=lambda event: abs(event.at - value), default=None)

    @cached_property
    def top(self) -> float:
        """End of the frequency axis: a round number in display units, just above all loci."""
        factor = self.request.measures[1].factor
        found = np.concatenate([line.frequency for line in self.lines])
        largest = 1.03 * factor * np.max(found, initial=0.0, where=np.isfinite(found)) or 1.0
        power = 10.0 ** math.floor(math.log10(largest))
        return power * next(step for step in ROUND if step * power >= largest) / factor


def lines_of(found: Loci, x: np.ndarray, branches: Sequence[Branch] | None = None) -> list[Line]:
    """The loci, of all or some branches, interpolated at x (n,). With Coriolis forces the names at
    a value take a solve: a run with the same name at both ends is taken to have one name."""
    lines, takes_solve = [], found.problem.gyroscopic
    before = np.maximum(np.searchsorted(found.values, x, "right") - 1, 0).tolist()
    nearest = abs(x[:, None] - found.values).argmin(axis=1)
    names = cache(lambda k: names_of_branches(found, float(found.values[k])))

    def name_at(label: str, i: int) -> str:
        return names(before[i]).get(label, label)

    for branch in branches or found.branches:
        y, name = np.interp(x, found.values, branch.frequency), partial(name_at, branch.label)
        family = [branch.family[k] if math.isfinite(y[i]) else None for i, k in enumerate(before)]
        kinds = [(one, None if takes_solve else name(i)) for i, one in enumerate(family)]
        cuts = [k for k in range(1, len(x)) if kinds[k] != kinds[k - 1]]
        runs = []
        for start, stop in pairwise([0, *cuts, len(x)]):
            if own := family[start]:
                parts = one_name(name, start, stop)
                runs += [(first, min(end, len(x) - 1), own, name(first)) for first, end in parts]
        lines.append(Line(branch.label, y, branch.mode_index[nearest], runs))
    return lines


def one_name(name: Callable[[int], str], start: int, stop: int) -> list[tuple[int, int]]:
    """The parts of a run of points in which a name is constant if it is the same at both ends."""
    middle = (start + stop) // 2
    if middle == start or name(start) == name(stop - 1):
        return [(start, stop)]
    return one_name(name, start, middle) + one_name(name, middle, stop)


def numbered(named: Iterable[tuple[str, Any]]) -> dict[str, Any]:
    """Records with names by their names and a count from 1."""
    counts, found = Counter[str](), {}
    for name, record in named:
        counts[name] += 1
        found[f"{name} {counts[name]}"] = record
    return found


# Data for the page


def cursor(beam: Beam | None, over: str, along: Measure) -> Data | None:
    """The line at a beam, which sets the number along the axis; None without one."""
    return {"action": over, "x": float(along.factor * getattr(beam, over))} if beam else None


def lines_data(lines: Iterable[Line], factor: float) -> list[Data]:
    """Lines with the last name as label; those without a frequency are left out."""
    return [
        {"label": line.runs[-1][3], "y": page.sent(factor * line.frequency), "runs": line.runs}
        for line in lines
        if line.runs
    ]


def axes_data(request: ChartRequest, message: str, second: Chart | None) -> Data:
    """A chart without loci, for the reason `message`, and the loci of a second beam."""
    along, across = request.measures
    lines = []
    if second:
        own = {"second": True, "at": page.sent(along.factor * second.x)}
        lines = [line | own for line in lines_data(second.lines, across.factor)]
    return {
        "name": f"Frequencies over {along.label}",
        "message": message,
        "x": page.axis_data(along, (request.start, request.stop)),
        "y": page.frequency_axis(across, (0.0, 1.0)),
        "lines": lines,
        "at": [],
        "perRev": None,
        "gaps": [],
        "marks": [],
        "keys": page.keys(lines),
    }


def chart_data(chart: Chart, multiples: Sequence[int] = (), second: Chart | None = None) -> Data:
    """The chart with per-rev lines, and behind it the loci of a second beam."""
    data, (along, across) = axes_data(chart.request, "", second), chart.request.measures
    if chart.request.over == "gamma":
        per_rev = {"slope": float(across.factor / along.factor), "multiples": list(multiples)}
        data |= {"name": "Campbell diagram", "perRev": per_rev if multiples else None}
    lines = data["lines"] + lines_data(chart.lines, across.factor)
    own_marks = marks(chart, multiples)
    return data | {
        "y": page.frequency_axis(across, (0.0, chart.top)),
        "at": page.sent(along.factor * chart.x),
        "lines": lines,
        "gaps": [
            [*(float(along.factor * x) for x in (one.start, one.stop)), FAILURES[one.kind]]
            for one in chart.limits
        ],
        "marks": own_marks,
        "keys": page.keys(lines, own_marks),
    }


def marks(chart: Chart, multiples: Sequence[int]) -> list[Data]:
    """Crossings, veerings and resonances as buttons."""
    axes = along, across = chart.request.measures
    places = {**chart.events, **chart.resonances_at(multiples)}
    found = []
    for key, one in places.items():
        force = f" with {one.per_rev} per revolution" if one.per_rev else ""
        name = f"{one.kind} of {' and '.join(chart.names_of(one))}{force}"
        text = f"{name}: {along.place(one.at)}, {across.place(one.frequency)}"
        action = {"action": "go_to_event", "value": key}
        found.append(page.mark(key, one.kind, axes, (one.at, one.frequency), text, **action))
    return found
