"""Loci as background jobs compute them for charts, and these charts as data for the page."""

import math
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property, partial
from itertools import pairwise
from typing import Any, NamedTuple, Self

import numpy as np

from beamviz.beam import NUMBERS, Beam
from beamviz.chart_ranges import CHART_POINTS, chart_range
from beamviz.drawing.text import Measure, frequencies, measure
from beamviz.explorer import page
from beamviz.explorer.page import Data
from beamviz.explorer.state import Case
from beamviz.frequency_loci import Branch, Event, Loci, loci
from beamviz.frequency_loci.events import EXCHANGES
from beamviz.frequency_loci.identity import names_of_branches, names_of_event
from beamviz.frequency_loci.limits import Limit
from beamviz.scene import PER_REV
from beamviz.solver.problem import MAX_MODES
from beamviz.solver.stability import INSTABILITIES

AT = 1e-7  # of the range: distance of a beam that is at an event
ROUND = (1.0, 1.2, 1.4, 1.6, 1.8, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0)
FAILURES = {
    "no-equilibrium": "No equilibrium",
    **{status: name.capitalize() for status, name in INSTABILITIES.items()},
    "not-converged": "The calculation did not converge",
    "not-located": "An event was not located",
}


@dataclass(frozen=True)
class ChartRequest:
    """The loci to compute."""

    beam: Beam  # its number `over` is `start`
    over: str
    start: float
    stop: float
    options: dict[str, Any]  # keywords of `solve`
    per_rev: int = 0  # the largest multiple of the speed for resonances

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
        computed = loci(self.beam, self.over, values, per_rev=self.per_rev, **self.options)
        x = np.union1d(values, [event.at for event in computed.events])
        pairs = [event for event in computed.events if not event.per_rev]
        names = {event: names_of_event(computed, event) for event in pairs}
        return Chart(self, x, lines_of(computed, x), computed.events, computed.limits, names)


PLANES: dict[str | None, str] = {"F": "flap", "L": "lag"}  # names of kinds of bending


class LocusLine(NamedTuple):
    """A branch of loci as a line, at values x (n,) of the axis."""

    label: str
    frequency: np.ndarray  # (n,) in units of 1/T*, nan where it has none
    # First point, last point, style (family, flap or lag) and name of the mode of each part in
    # which these two are the same; consecutive parts share a point, so that lines have no gaps.
    runs: list[tuple[int, int, str, str]]

    def name_at(self, k: int) -> str:
        """The name of the mode at a point; that of the branch where there is none."""
        names = [name for first, last, _, name in self.runs if first <= k <= last]
        return names[-1] if names else self.label


@dataclass(frozen=True, eq=False)
class Chart:
    """Loci as lines, without the solutions: those of a blade take megabytes."""

    request: ChartRequest
    x: np.ndarray  # values of the axis (n,): of the loci and of the events
    lines: list[LocusLine]
    located: tuple[Event, ...]  # events and resonances
    limits: tuple[Limit, ...]
    names: dict[Event, tuple[str, ...]]  # of the modes of each event that is no resonance

    @cached_property
    def events(self) -> dict[str, Event]:
        """The events but resonances by key: the labels of their branches and a count, as
        'B3 S1 1'. Keys remain valid when the beam or the model changes."""
        events = (event for event in self.located if not event.per_rev)
        return numbered((" ".join(sorted(event.branches)), event) for event in events)

    @property
    def pairs(self) -> dict[str, Event]:
        """The events at which two modes exchange their order or their shapes."""
        return {key: event for key, event in self.events.items() if event.kind in EXCHANGES}

    def resonances_at(self, multiples: Sequence[int]) -> dict[str, Event]:
        """Resonances at a speed, with these multiples of it, by key: multiple, branch and a
        count."""
        events = (event for event in self.located if event.until is None)
        shown = (event for event in events if event.per_rev in multiples)
        return numbered((f"{event.per_rev} {event.branches[0]}", event) for event in shown)

    def resonances_along(self, multiples: Sequence[int]) -> list[Event]:
        """Resonances of loci that lie on the line of one of these multiples of the speed."""
        events = (event for event in self.located if event.until is not None)
        return [event for event in events if event.per_rev in multiples]

    def event_at(self, value: float) -> str:
        """The key of the event or resonance at a value of the axis, "" where there is none."""
        near = AT * (self.request.stop - self.request.start)
        places = self.events | self.resonances_at(PER_REV)
        distance = {key: abs(event.at - value) for key, event in places.items()}
        nearest = min(distance, key=distance.__getitem__, default="")
        return nearest if nearest and distance[nearest] <= near else ""

    def modes_of(self, event: Event) -> tuple[int, ...]:
        """The modes (from 0) of an event, also those above the modes asked for."""
        return tuple(sorted({mode for mode in event.modes if mode < MAX_MODES}))

    def names_of(self, event: Event) -> list[str]:
        """The names of the modes of an event or a resonance there, stretching modes first."""
        names = self.names.get(event)
        if names is None:
            k = self.index_of(event)
            names = tuple(line.name_at(k) for line in self.lines if line.label in event.branches)
        return sorted(set(names), key=lambda name: (name[0] != "S", name))

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
        omegas = np.concatenate([line.frequency for line in self.lines])
        largest = 1.03 * factor * np.max(omegas, initial=0.0, where=np.isfinite(omegas)) or 1.0
        power = 10.0 ** math.floor(math.log10(largest))
        return power * next(step for step in ROUND if step * power >= largest) / factor


def lines_of(
    computed: Loci, x: np.ndarray, branches: Sequence[Branch] | None = None
) -> list[LocusLine]:
    """The loci, of all or some branches, interpolated at x (n,). With Coriolis forces the names at
    a value take a solve: a run with the same name at both ends is taken to have one name."""
    lines, takes_solve = [], computed.problem.gyroscopic
    before = np.maximum(np.searchsorted(computed.values, x, "right") - 1, 0).tolist()
    names = cache(lambda k: names_of_branches(computed, float(computed.values[k])))

    def name_at(label: str, i: int) -> str:
        return names(before[i]).get(label, label)

    for branch in branches or computed.branches:
        y, name = np.interp(x, computed.values, branch.frequency), partial(name_at, branch.label)
        styles = styles_of(branch)
        family = [styles[k] if math.isfinite(y[i]) else None for i, k in enumerate(before)]
        kinds = [(kind, None if takes_solve else name(i)) for i, kind in enumerate(family)]
        cuts = [k for k in range(1, len(x)) if kinds[k] != kinds[k - 1]]
        runs = []
        for start, stop in pairwise([0, *cuts, len(x)]):
            if kind := family[start]:
                parts = runs_of_a_name(name, start, stop)
                runs += [(first, min(end, len(x) - 1), kind, name(first)) for first, end in parts]
        lines.append(LocusLine(branch.label, y, runs))
    return lines


def styles_of(branch: Branch) -> list[str | None]:
    """The style of the line of a branch at each value: its family there; where the beam bends in
    both planes, flap or lag in place of bending."""
    pairs = zip(branch.family, branch.kinds, strict=True)
    return [PLANES.get(kind, name) if name == "bending" else name for name, kind in pairs]


def runs_of_a_name(name: Callable[[int], str], start: int, stop: int) -> list[tuple[int, int]]:
    """The parts of a run of points in which a name is constant if it is the same at both ends."""
    middle = (start + stop) // 2
    if middle == start or name(start) == name(stop - 1):
        return [(start, stop)]
    return runs_of_a_name(name, start, middle) + runs_of_a_name(name, middle, stop)


def numbered(named: Iterable[tuple[str, Any]]) -> dict[str, Any]:
    """Records with names by their names and a count from 1."""
    counts, records = Counter[str](), {}
    for name, record in named:
        counts[name] += 1
        records[f"{name} {counts[name]}"] = record
    return records


# Content of the page


def axes_options(case: Case, *ids: str) -> page.Content:
    """The numbers that the select elements with these ids offer as an axis."""
    choices = page.options({name: NUMBERS[name].short_label for name in case.axes})
    return {("html", id): choices for id in ids}


def cursor(beam: Beam | None, over: str, along: Measure) -> Data | None:
    """The line at a beam, which sets the number along the axis; None without one."""
    return {"action": over, "x": float(along.factor * getattr(beam, over))} if beam else None


def lines_data(lines: Iterable[LocusLine], factor: float) -> list[Data]:
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
        second_line = {"second": True, "at": page.sent(along.factor * second.x)}
        lines = [line | second_line for line in lines_data(second.lines, across.factor)]
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
    bands, event_marks = bands_data(chart, multiples), marks(chart, multiples)
    band_keys = [{"style": "line band", "text": "resonance along a per-rev line"}] if bands else []
    return data | {
        "y": page.frequency_axis(across, (0.0, chart.top)),
        "at": page.sent(along.factor * chart.x),
        "lines": [*bands, *lines],
        "gaps": [
            [*(float(along.factor * x) for x in (limit.start, limit.stop)), FAILURES[limit.kind]]
            for limit in chart.limits
        ],
        "marks": event_marks,
        "keys": [*page.keys(lines, event_marks), *band_keys],
    }


def bands_data(chart: Chart, multiples: Sequence[int]) -> list[Data]:
    """The resonances along lines of multiples of the speed as wide lines behind the loci."""
    along, across = chart.request.measures
    bands = []
    for event in chart.resonances_along(multiples):
        x = np.array([event.at, event.until])
        ends = {
            "at": page.sent(along.factor * x),
            "y": page.sent(across.factor * event.per_rev * x),
        }
        bands.append({"label": "", **ends, "runs": [[0, 1, "band", ""]]})
    return bands


def marks(chart: Chart, multiples: Sequence[int]) -> list[Data]:
    """Crossings, veerings and resonances as buttons."""
    axes = along, across = chart.request.measures
    places = {**chart.events, **chart.resonances_at(multiples)}
    data = []
    for key, event in places.items():
        force = f" with {event.per_rev} per revolution" if event.per_rev else ""
        name = f"{event.kind} of {' and '.join(chart.names_of(event))}{force}"
        text = f"{name}: {along.place(event.at)}, {across.place(event.frequency)}"
        action = {"action": "go_to_event", "value": key}
        data.append(page.mark(key, event.kind, axes, (event.at, event.frequency), text, **action))
    return data
