"""The tab Frequencies: the Campbell diagram along one of the five numbers, and lists of crossings,
veerings and resonances."""

import contextlib
from functools import partial
from html import escape
from typing import Any

from beamviz.beam import PARAMETERS
from beamviz.errors import InvalidInput
from beamviz.explorer.features import loci_chart
from beamviz.explorer.features.comparison import comparison_case
from beamviz.explorer.features.loci_chart import Chart, ChartRequest, Data
from beamviz.explorer.jobs import Answer
from beamviz.explorer.page.html import button, chart_tab, hint, note, select, table
from beamviz.explorer.state import State
from beamviz.explorer.visitor import Feature, Visitor
from beamviz.frequency_loci import Event
from beamviz.frequency_loci.forced_response import Resonance
from beamviz.scene import PER_REV

AXES = {name: PARAMETERS[name].slider_label for name in ("gamma", "alpha", "beta", "delta", "mu")}
SIGNS = {"crossing": "○", "veering": "●", "buckling": "▽", "limit point": "△", "second state": "◇"}
PER_REV_HELP = (
    "A force spread over the beam like its weight, repeating k times per revolution, excites a mode"
    " where the line k × speed intersects it. The chart with these lines is a Campbell diagram."
)


class LociTab(Feature):
    """The chart and its lists. chosen: the key of the event that the beam was moved to last;
    choice: the number of these moves, so that a second one to the same event shows it again."""

    def __init__(self, visitor: Visitor):
        super().__init__(visitor)
        self.charts = visitor.job("chart", ChartRequest.chart)
        self.second_charts = visitor.job("chart compared with", ChartRequest.chart)
        self.chosen, self.choice = "", 0
        self.page.html("tab-frequencies", skeleton())
        visitor.bind("over")
        for k in PER_REV:
            edit, shown = partial(with_line, k=k), lambda multiples, k=k: k in multiples
            visitor.bind(f"per_rev_{k}", edit, of="per_rev", shown=shown)
        self.page.on("go_to_event", self.go_to)

    def go_to(self, key: Any) -> None:
        """Move the beam to a crossing, a veering or a resonance."""
        if chart := self.chart:
            events = chart.events | chart.resonances_at(self.visitor.state.per_rev)
            if event := events.get(key):
                self.chosen, self.choice = key, self.choice + 1
                self.visitor.change(lambda state: state.changed(chart.request.over, event.at))

    @property
    def event(self) -> Event | None:
        """The crossing or veering to magnify: the chosen one, or that nearest to the beam."""
        chart, answer = self.chart, self.visitor.chart_answer
        if chart is None or not chart.events or answer is None or answer.beam is None:
            return None
        value = getattr(answer.beam, chart.request.over)
        nearest = min(chart.events.values(), key=lambda event: abs(event.at - value))
        return chart.events.get(self.chosen, nearest)

    @property
    def chart(self) -> Chart | None:
        """The last chart; None if it could not be computed."""
        return self.charts.result

    @property
    def inputs(self) -> tuple[object, ...]:
        state = self.visitor.state
        return (
            self.visitor.chart_answer, state.over, state.per_rev, state.comparison, state.kept,
            state.following, self.choice, self.charts.answer, self.second_charts.answer,
            self.charts.slow,
        )  # fmt: skip

    def show(self) -> None:
        """Request the charts, and show the last ones."""
        second = self.second_charts.answer if self.request() else None
        self.fade(self.charts, "loci-chart", "loci-resonances", "loci-events")
        if (answer := self.charts.answer) is None:
            return
        if self.redraws(answer, second, self.visitor.state.per_rev):
            self.draw(answer, second.result if second else None)
        chosen = {"chosen": self.chosen, "choice": self.choice}
        self.page.chart("loci-chart", {"cursor": self.cursor, **chosen})
        self.page.value("go_to_event", self.chosen)

    def draw(self, answer: Answer[ChartRequest, Chart], second: Chart | None) -> None:
        """Show a chart, or the reason why there is none, and the loci of a second beam."""
        page, multiples = self.page, self.visitor.state.per_rev
        chart, over_speed = answer.result, answer.request.over == "gamma"
        page.props("per-rev", hidden=not over_speed)
        page.props("loci-resonances", hidden=not (chart and over_speed and multiples))
        if chart is None:
            page.chart("loci-chart", loci_chart.axes_data(answer.request, answer.message, second))
            page.html("loci-events", note(answer.message))
            return
        page.chart("loci-chart", loci_chart.chart_data(chart, multiples, second))
        page.html("loci-events", event_table(chart) + notes(chart))
        page.html("loci-resonances", resonance_table(chart, multiples))

    @property
    def cursor(self) -> Data | None:
        """The line at the beam shown."""
        if self.charts.answer is None:
            return None
        request = self.charts.answer.request
        return loci_chart.cursor(self.visitor.chart_answer, request.over, request.measures[0])

    def request(self) -> bool:
        """Request the chart around the answer shown, and that of the beam compared with. Returns
        whether there is such a beam."""
        state, answer = self.visitor.state, self.visitor.chart_answer
        if answer is None:
            return False
        other = comparison_case(state, answer.request)
        with contextlib.suppress(InvalidInput):  # shown elsewhere; the last chart stays
            highest = max(state.per_rev, default=0)
            request = ChartRequest.around(answer.request, state.over, highest)
            self.charts.request(request)
            if not isinstance(other, str):
                self.second_charts.request(request.same_axis(other.case))
        return not isinstance(other, str)


def with_line(state: State, on: Any, k: int) -> State:
    """With or without the line k × speed."""
    multiples = {*state.per_rev, k} if on else {*state.per_rev} - {k}
    return state.changed("per_rev", sorted(multiples))


# HTML


def skeleton() -> str:
    """The tab without its contents."""
    toggles = ""
    for k in PER_REV:
        names = {"data_set": f"per_rev_{k}", "aria_label": f"{k} × per revolution"}
        toggles += button(f"{k} ×", class_="toggle", **names)
    tools = (
        select("over", "horizontal axis", AXES)
        + '<div id="per-rev" class="row" role="group" aria-label="per-rev lines">'
        f"<span>per-rev lines</span>{toggles}{hint('per-rev lines', PER_REV_HELP)}</div>"
    )
    return chart_tab(tools, "loci-chart", "loci-resonances", "loci-events", hidden=False)


def event_table(chart: Chart) -> str:
    """The crossings and veerings, each with a button that moves the beam there."""
    warning = f"<p>{escape(chart.loci.warning)}</p>" if chart.loci.warning else ""
    if not chart.events:
        return warning or "<p>No crossing or veering in this range.</p>"
    along, across = chart.request.measures
    heads = ("go to", f"at {along.head}", across.label, "smallest gap")
    rows = [
        (*cells(chart, key, SIGNS[event.kind], event), f"{across.factor * event.gap:.3g}")
        for key, event in chart.events.items()
    ]
    return (
        table("crossings and veerings", heads, rows, caption="Crossings ○ and veerings ●") + warning
    )


def cells(chart: Chart, key: str, sign: str, one: Event | Resonance) -> tuple[str, str, str]:
    """A button that moves the beam to an event, with its value and its frequency."""
    along, across = chart.request.measures
    label = f"{sign} {', '.join(loci_chart.event_names(chart, one))}"
    go_to = button(label, data_set="go_to_event", data_value=key, class_="quiet")
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
    return table("resonances", heads, rows, caption="Resonances")


def notes(chart: Chart) -> str:
    """The reasons why loci end."""
    return "".join(note(loci_chart.limit_text(chart.request, one)) for one in chart.loci.limits)
