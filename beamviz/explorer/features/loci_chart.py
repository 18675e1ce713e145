"""The tab Frequencies: the Campbell diagram along one of the five numbers, with lists of events."""

import contextlib
import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property, partial
from itertools import pairwise
from typing import Any, Self

import numpy as np

from beamviz.beam import PARAMETERS, Beam
from beamviz.chart_ranges import CHART_POINTS, chart_range
from beamviz.drawing.text import Measure, frequencies, measure
from beamviz.errors import InvalidInput
from beamviz.explorer import page
from beamviz.explorer.features.comparison import Comparison
from beamviz.explorer.jobs import Answer, SolverAnswer
from beamviz.explorer.page import Data
from beamviz.explorer.state import Case, State
from beamviz.explorer.visitor import Feature, Visitor
from beamviz.frequency_loci import Branch, Event, Loci, loci
from beamviz.frequency_loci.events import EVENT_KINDS
from beamviz.frequency_loci.identity import names_of_branches
from beamviz.scene import PER_REV

ROUND = (1.0, 1.2, 1.4, 1.6, 1.8, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0)
FAILURES = {
    "no-equilibrium": "No equilibrium",
    "unstable": "Unstable",
    "not-converged": "The calculation did not converge",
}
AXES = {name: PARAMETERS[name].slider_label for name in ("gamma", "alpha", "beta", "delta", "mu")}
PER_REV_HELP = (
    "A force spread over the beam like its weight, repeating k times per revolution, excites a mode"
    " where the line k × speed intersects it. The chart with these lines is a Campbell diagram."
)


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
        beam = case.beam()
        start, stop = chart_range(beam, over)
        beam = beam.replace(**{over: start})
        return cls(beam, over, start, stop, case.options, per_rev if over == "gamma" else 0)

    def same_axis(self, case: Case) -> Self:
        """The chart of another case over the same range."""
        beam = case.beam().replace(**{self.over: self.start})
        return replace(self, beam=beam, options=case.options, per_rev=0)

    @property
    def measures(self) -> tuple[Measure, Measure]:
        """Display units of the axis and of the frequencies; none over mu, on which T* depends."""
        units = None if self.over == "mu" else self.beam.units
        return measure(self.over, units), frequencies(units)

    def chart(self) -> "Chart":
        """The chart. Raises the errors of `loci`."""
        values = np.linspace(self.start, self.stop, CHART_POINTS)
        return Chart(self, loci(self.beam, self.over, values, per_rev=self.per_rev, **self.options))


@dataclass(frozen=True)
class Chart:
    """Computed loci."""

    request: ChartRequest
    loci: Loci

    @cached_property
    def events(self) -> dict[str, Event]:
        """The events but resonances by key: the labels of their branches and a count, as
        'B3 S1 1'. Keys remain valid when the beam or the model changes."""
        events = (event for event in self.loci.events if not event.per_rev)
        return numbered((" ".join(sorted(event.branches)), event) for event in events)

    @property
    def pairs(self) -> dict[str, Event]:
        """The crossings and veerings among the events."""
        kinds = ("crossing", "veering")
        return {key: event for key, event in self.events.items() if event.kind in kinds}

    def resonances_at(self, multiples: Sequence[int]) -> dict[str, Event]:
        """Resonances with these multiples of the speed by key: multiple, branch and a count."""
        shown = (event for event in self.loci.events if event.per_rev in multiples)
        return numbered((f"{event.per_rev} {event.branches[0]}", event) for event in shown)

    @cached_property
    def top(self) -> float:
        """End of the frequency axis: a round number in display units, just above all loci."""
        factor = self.request.measures[1].factor
        found = np.concatenate([branch.frequency for branch in self.loci.branches])
        largest = 1.03 * factor * np.max(found, initial=0.0, where=np.isfinite(found)) or 1.0
        power = 10.0 ** math.floor(math.log10(largest))
        return power * next(step for step in ROUND if step * power >= largest) / factor


def numbered(named: Iterable[tuple[str, Any]]) -> dict[str, Any]:
    """Records with names by their names and a count from 1."""
    counts, found = Counter[str](), {}
    for name, record in named:
        counts[name] += 1
        found[f"{name} {counts[name]}"] = record
    return found


# Data for the page


def cursor(answer: SolverAnswer | None, over: str, along: Measure) -> Data | None:
    """The line at the beam of an answer, which sets the number along the axis."""
    if answer is None or answer.beam is None:
        return None
    return {"action": over, "x": along.factor * getattr(answer.beam, over)}


def loci_lines(
    found: Loci, x: np.ndarray, factor: float, branches: Sequence[Branch] | None = None
) -> list[Data]:
    """The loci, of all or some branches, interpolated at x (n,), in runs of one family and name of
    the mode; consecutive runs share a point, so that lines have no gaps."""
    lines = []
    last, solved = len(x) - 1, found.problem.gyroscopic  # then a name takes two solves
    before = np.maximum(np.searchsorted(found.values, x, "right") - 1, 0).tolist()
    names = cache(lambda k: names_of_branches(found, float(found.values[k])))

    def name_at(label: str, i: int) -> str:
        return names(before[i]).get(label, label)

    for branch in branches or found.branches:
        y, name = np.interp(x, found.values, branch.frequency), partial(name_at, branch.label)
        family = [branch.family[k] if math.isfinite(y[i]) else None for i, k in enumerate(before)]
        kinds = [(one, None if solved else name(i)) for i, one in enumerate(family)]
        cuts = [k for k in range(1, len(x)) if kinds[k] != kinds[k - 1]]
        runs = []
        for start, stop in pairwise([0, *cuts, len(x)]):
            if own := family[start]:
                parts = one_name(name, start, stop)
                runs += [[first, min(end, last), own, name(first)] for first, end in parts]
        if runs:
            lines.append({"label": runs[-1][3], "y": page.sent(factor * y), "runs": runs})
    return lines


def one_name(name: Callable[[int], str], start: int, stop: int) -> list[tuple[int, int]]:
    """The parts of a run of points in which a name is constant if it is the same at both ends."""
    middle = (start + stop) // 2
    if middle == start or name(start) == name(stop - 1):
        return [(start, stop)]
    return one_name(name, start, middle) + one_name(name, middle, stop)


def axes_data(request: ChartRequest, message: str, second: Chart | None) -> Data:
    """A chart without loci, for the reason `message`, and the loci of a second beam."""
    along, across = request.measures
    lines = []
    if second:
        x = second.loci.values
        own = {"second": True, "at": page.sent(along.factor * x)}
        lines = [line | own for line in loci_lines(second.loci, x, across.factor)]
    return {
        "name": f"Frequencies over {along.label}",
        "message": message,
        "x": page.axis_data(along, (request.start, request.stop)),
        "y": page.frequency_axis(across, (0.0, 1.0)),
        "lines": lines,
        "perRev": None,
        "gaps": [],
        "marks": [],
    }


def chart_data(chart: Chart, multiples: Sequence[int] = (), second: Chart | None = None) -> Data:
    """The chart with per-rev lines, and behind it the loci of a second beam."""
    data, (along, across) = axes_data(chart.request, "", second), chart.request.measures
    x = np.union1d(chart.loci.values, [event.at for event in chart.loci.events])
    if chart.request.over == "gamma":
        per_rev = {"slope": across.factor / along.factor, "multiples": list(multiples)}
        data |= {"name": "Campbell diagram", "perRev": per_rev if multiples else None}
    return data | {
        "y": page.frequency_axis(across, (0.0, chart.top)),
        "at": page.sent(along.factor * x),
        "lines": data["lines"] + loci_lines(chart.loci, x, across.factor),
        "gaps": [
            [along.factor * one.start, along.factor * one.stop, FAILURES[one.kind]]
            for one in chart.loci.limits
        ],
        "marks": marks(chart, multiples),
    }


def marks(chart: Chart, multiples: Sequence[int]) -> list[Data]:
    """Crossings, veerings and resonances as buttons."""
    axes = along, across = chart.request.measures
    places = {**chart.events, **chart.resonances_at(multiples)}
    found = []
    for key, one in places.items():
        force = f" with {one.per_rev} per revolution" if one.per_rev else ""
        name = f"{one.kind} of {' and '.join(event_names(chart, one))}{force}"
        text = f"{name}: {along.text(one.at, 4)}, {across.text(one.frequency, 4)}"
        action = {"action": "go_to_event", "value": key}
        found.append(page.mark(key, one.kind, axes, (one.at, one.frequency), text, **action))
    return found


def event_names(chart: Chart, event: Event) -> list[str]:
    """The names of the modes of an event there, stretching modes first."""
    names = names_of_branches(chart.loci, event.at)
    found = {names.get(one, one) for one in event.branches}
    return sorted(found, key=lambda name: (name[0] != "S", name))


# The tab


class LociTab(Feature):
    """The chart and its lists. chosen: the key of the event that the beam was moved to last;
    choice: the number of these moves, so that a second one to the same event shows it again."""

    def __init__(self, visitor: Visitor, comparison: Comparison):
        super().__init__(visitor)
        self.comparison = comparison
        self.charts = visitor.job("chart", ChartRequest.chart)
        self.second_charts = visitor.job("chart compared with", ChartRequest.chart)
        self.chosen, self.choice = "", 0
        help = page.hint("per-rev lines", PER_REV_HELP)
        lines = f'<span class="name">per-rev lines{help}</span>'
        for k in PER_REV:
            names = {"data_set": f"per_rev_{k}", "aria_label": f"{k} × per revolution"}
            lines += page.button(f"{k} ×", class_="toggle", **names)
            visitor.bind(f"per_rev_{k}", partial(with_line, k=k), partial(has_line, k=k))
        lines = page.group("per-rev lines", lines, id="per-rev")
        tools = page.select("over", "horizontal axis", AXES) + lines
        lists = "loci-resonances", "loci-events"
        self.page.html("tab-frequencies", page.chart_tab(tools, "loci-chart", *lists, hidden=False))
        self.page.on("go_to_event", self.go_to)

    def go_to(self, key: Any) -> None:
        """Move the beam to a crossing, a veering or a resonance."""
        if chart := self.charts.result:
            events = chart.events | chart.resonances_at(self.visitor.state.per_rev)
            if event := events.get(key):
                self.chosen, self.choice = key, self.choice + 1
                self.visitor.change(lambda state: state.changed(chart.request.over, event.at))

    @property
    def event(self) -> Event | None:
        """The crossing or veering to magnify: the chosen one, or that nearest to the beam."""
        chart, answer = self.charts.result, self.visitor.answer
        if chart is None or not chart.pairs or answer is None or answer.beam is None:
            return None
        value = getattr(answer.beam, chart.request.over)
        nearest = min(chart.pairs.values(), key=lambda event: abs(event.at - value))
        return chart.pairs.get(self.chosen, nearest)

    def show(self) -> None:
        """Request the charts of the beam and the one compared with, and show the last ones."""
        state, shown, other = self.visitor.state, self.visitor.answer, self.comparison.case.case
        with contextlib.suppress(InvalidInput):  # shown elsewhere; the last chart stays
            if shown:
                highest = max(state.per_rev, default=0)
                request = ChartRequest.around(shown.request, state.over, highest)
                self.charts.request(request)
                if other:
                    self.second_charts.request(request.same_axis(other))
        second = self.second_charts.answer if other else None
        self.fade(self.charts, "loci-chart", "loci-resonances", "loci-events")
        if (answer := self.charts.answer) is None:
            return
        if self.redraws(answer, second, state.per_rev):
            self.draw(answer, second.result if second else None)
        chosen = {"chosen": self.chosen, "choice": self.choice}
        self.page.chart("loci-chart", {"cursor": self.cursor, **chosen})
        self.page.value("go_to_event", self.chosen)

    def draw(self, answer: Answer[ChartRequest, Chart], second: Chart | None) -> None:
        """Show a chart, or the reason why there is none, and the loci of a second beam."""
        chart, multiples = answer.result, self.visitor.state.per_rev
        over_speed = answer.request.over == "gamma"
        self.page.props("per-rev", hidden=not over_speed)
        self.page.props("loci-resonances", hidden=not (chart and over_speed and multiples))
        if chart is None:
            self.page.chart("loci-chart", axes_data(answer.request, answer.message, second))
            self.page.html("loci-events", page.note(answer.message))
            return
        self.page.chart("loci-chart", chart_data(chart, multiples, second))
        self.page.html("loci-events", event_table(chart) + notes(chart))
        self.page.html("loci-resonances", resonance_table(chart, multiples))

    @property
    def cursor(self) -> Data | None:
        if self.charts.answer is None:
            return None
        request = self.charts.answer.request
        return cursor(self.visitor.answer, request.over, request.measures[0])


def has_line(values: Mapping[str, Any], k: int) -> bool:
    return k in values["per_rev"]


def with_line(state: State, on: Any, k: int) -> State:
    multiples = {*state.per_rev, k} if on else {*state.per_rev} - {k}
    return state.changed("per_rev", sorted(multiples))


# Lists of the tab


def event_table(chart: Chart) -> str:
    """The events, each with a button that moves the beam there."""
    if not chart.events:
        return "<p>No crossing or veering in this range.</p>"
    along, across = chart.request.measures
    heads = ("go to", f"at {along.head}", across.label, "smallest gap")
    rows = []
    for key, event in chart.events.items():
        sign, gap = EVENT_KINDS[event.kind].sign, f"{across.factor * event.gap:.3g}"
        rows.append((*cells(chart, key, sign, event), gap))
    kinds = {event.kind for event in chart.events.values()}
    shown = {name: kind.sign for name, kind in EVENT_KINDS.items() if name in kinds}
    caption = ", ".join(f"{name} {sign}" for name, sign in shown.items()).capitalize()
    return page.table("crossings and veerings", heads, rows, caption=caption)


def event_buttons(chart: Chart) -> str:
    """Buttons that move the beam to the crossings and veerings."""
    along, buttons = chart.request.measures[0], ""
    for key, event in chart.pairs.items():
        label = f"{' and '.join(event_names(chart, event))}, {along.text(event.at, 4)}"
        buttons += page.button(label, data_set="go_to_event", data_value=key)
    return page.group("go to", buttons)


def cells(chart: Chart, key: str, sign: str, one: Event) -> tuple[str, str, str]:
    """A button that moves the beam to an event, with its value and its frequency."""
    along, across = chart.request.measures
    label = f"{sign} {', '.join(event_names(chart, one))}"
    go_to = page.button(label, data_set="go_to_event", data_value=key, class_="quiet")
    return go_to, along.number(one.at, 4), across.number(one.frequency, 3)


def resonance_table(chart: Chart, multiples: tuple[int, ...]) -> str:
    """The resonances in order of speed, each with a button that moves the beam there."""
    found = chart.resonances_at(multiples)
    lines = " ".join(f"{k} ×" for k in multiples)
    if not found:
        return f"<p>No line {lines} speed intersects a mode in this range.</p>"
    along, across = chart.request.measures
    heads = ("go to", "per rev", f"at {along.head}", across.label)
    rows = []
    for key, one in found.items():
        go_to, *place = cells(chart, key, "◆", one)
        rows.append((go_to, f"{one.per_rev} ×", *place))
    return page.table("resonances", heads, rows, caption="Resonances")


def notes(chart: Chart) -> str:
    """The reasons why loci end, with the ranges."""
    request, text = chart.request, ""
    for limit in chart.loci.limits:
        first, last = (request.measures[0].text(end, 4) for end in (limit.start, limit.stop))
        place = f"from {first} to {last}"
        if limit.stop == request.stop:
            place = f"above {first}"
        elif limit.start == request.start:
            place = f"below {last}"
        stretched = limit.kind == "no-equilibrium" and request.beam.delta >= 0  # else compressed
        law = " with this material law" if stretched else ""
        text += page.note(f"{FAILURES[limit.kind]} {place}{law}.")
    return text
