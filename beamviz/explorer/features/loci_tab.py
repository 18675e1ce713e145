"""The tab Loci: the chart of frequencies along one of the five numbers, with tables of crossings,
veerings and resonances."""

import contextlib
import math
from html import escape
from typing import Any

from beamviz.beam import PARAMETERS
from beamviz.errors import InvalidInput
from beamviz.explorer.features.comparison import comparison_case
from beamviz.explorer.features.loci_chart import (
    FAMILIES,
    PER_REV,
    STYLES,
    Chart,
    ChartRequest,
    chart_lines,
    same_event,
)
from beamviz.explorer.page.html import SMALL, coloured, small
from beamviz.explorer.page.style import ABOVE, BELOW, COLOURS, FAINT, LEFT, Plot, apart
from beamviz.explorer.visitor import Feature, Visitor, on_press
from beamviz.exports.html_page import table
from beamviz.frequency_loci import Event
from beamviz.frequency_loci.identity import identify_modes, names_of_branches
from beamviz.solver.solution import Solution

AXES = {PARAMETERS[name].slider_label: name for name in ("gamma", "alpha", "beta", "delta", "mu")}
RESONANCES = "Resonances: a force that repeats k times per revolution excites the mode"
SIGNS = {"crossing": "○", "veering": "●"}
MAX_EVENTS, MAX_RESONANCES = 8, 12  # rows of the tables
HEIGHT, RIGHT = 210, 32  # [px] of the chart, and of its right margin
LINES_HEIGHT = HEIGHT - ABOVE - BELOW
FRAME = (10.25, 8.25, 12)  # [px] around the chart: left, right, below
LETTERS = 11  # [px]


class LociTab(Feature):
    """The chart and its controls. chosen: the crossing or veering magnified by the tab Veering."""

    def __init__(self, visitor: Visitor):
        super().__init__(visitor)
        gui = visitor.client.gui
        self.charts = visitor.job("loci chart", ChartRequest.chart)
        self.second_charts = visitor.job("loci chart", ChartRequest.chart)  # of the comparison
        self.chosen: Event | None = None
        axis = gui.add_dropdown("horizontal axis", tuple(AXES), hint="The number that varies")
        visitor.bind_control(
            axis,
            lambda state: PARAMETERS[state.over].slider_label,
            lambda state, label: state.changed("over", AXES.get(label, "")),
        )
        hint = "ω = γ, 2γ ... 5γ: where a line intersects a mode, each revolution can excite it"
        self.per_rev = gui.add_checkbox("per-rev lines", False, hint=hint)
        visitor.bind_control_key(self.per_rev, "per_rev")
        self.plot = Plot(gui, STYLES, HEIGHT, right=RIGHT)
        self.labels, self.texts = gui.add_html(""), gui.add_html("")
        hint = "Move the beam to a crossing or veering"
        self.go_to = gui.add_button_group("go to", ("1",), visible=False, hint=hint)
        on_press(self.go_to, self.choose)

    def choose(self, number: Any) -> None:
        """Choose a crossing or veering by its number in the table, and move the beam there."""
        chart = self.charts.result
        if chart is None or number not in self.go_to.options[: len(chart.events)]:
            return
        self.chosen = event = chart.events[int(number) - 1]
        self.visitor.change(lambda state: state.changed(chart.request.over, event.at))

    @property
    def chart(self) -> Chart | None:
        """The last chart; one without lines where it could not be computed."""
        return Chart.of(self.charts.answer)

    @property
    def inputs(self) -> tuple[object, ...]:
        """The answer shown, the choices and the charts."""
        state = self.visitor.state
        return (
            self.visitor.chart_answer, state.over, state.per_rev, state.comparison, state.kept,
            state.following, self.chosen, self.charts.answer, self.second_charts.answer,
        )  # fmt: skip

    def show(self) -> None:
        """Request the charts, and draw the last ones."""
        state, answer = self.visitor.state, self.visitor.chart_answer
        compared = self.request()
        chart = self.chart
        if chart is None:
            return
        request = chart.request
        if self.chosen and request.over != state.over:
            self.chosen = None
        if self.chosen and chart.loci and not self.charts.busy:  # it moves with the chart
            reach = request.stop - request.start
            self.chosen = same_event(chart.loci, self.chosen, reach) or self.chosen
        second = Chart.of(self.second_charts.answer) if compared else None
        solution = answer.solution if answer else None
        x, lines = chart_lines(chart, solution, per_rev=state.per_rev, second=second)
        ranges = (request.start, request.stop), (0.0, chart.top)
        self.plot.show(x, lines, request.measures, *ranges)
        self.per_rev.visible = request.over == "gamma"
        self.labels.content = line_labels(chart, state.per_rev)
        self.texts.content = (
            legend(chart, second)
            + (modes_here(chart, solution) if solution else "")
            + event_table(chart, self.chosen)
            + (resonance_table(chart) if state.per_rev else "")
            + gap_notes(chart)
        )
        numbers = tuple(str(k + 1) for k in range(min(len(chart.events), MAX_EVENTS)))
        self.go_to.visible = bool(numbers)
        if numbers and self.go_to.options != numbers:
            self.go_to.options = numbers

    def request(self) -> bool:
        """Request the chart around the answer shown, and that of the beam compared with; whether
        there is one. A follower takes over the chart of the presenter."""
        state, answer = self.visitor.state, self.visitor.chart_answer
        other = comparison_case(state, answer.request) if answer else ""
        if answer is not None:
            with contextlib.suppress(InvalidInput):  # the panel says so; the last chart stays
                request = ChartRequest.around(answer.request, state.over)
                if not (state.following and self.charts.answer):
                    self.charts.request(request)
                if not isinstance(other, str):
                    self.second_charts.request(request.same_axis(other.case))
        return not isinstance(other, str)


# Labels and texts


def line_labels(chart: Chart, per_rev: bool) -> str:
    """Mode labels at the right ends of the lines, as an overlay of the chart above.

    A mode is called as its shape there; the colour is its family there.
    """
    if chart.loci is None:
        return ""
    top, names = chart.top, names_of_branches(chart.loci, chart.values[-1])
    ends = sorted(
        (float(solution.frequencies[k]), names[branch.label], COLOURS[solution.families[k]])
        for branch in chart.loci.branches
        if (solution := branch.solutions[-1]) and (k := int(branch.mode_index[-1])) >= 0
        if math.isfinite(solution.frequencies[k])
    )
    heights = apart([end for end, _, _ in ends], top * 13 / LINES_HEIGHT)
    labels = "".join(
        f'<b style="position:absolute;left:100%;margin-left:4px;color:{colour};'
        f'bottom:calc({100 * height / top:.2f}% - .65em)">{escape(label)}</b>'
        for height, (_, label, colour) in zip(heights, ends, strict=True)
    )
    if per_rev and chart.loci.over == "gamma":
        labels += "".join(per_rev_labels(float(chart.values[-1]), top))
    return (
        '<div aria-hidden="true" data-labels style="position:relative;height:0;'
        'pointer-events:none;font-size:11px;line-height:1.3">'
        f'<div style="position:absolute;left:{LEFT + FRAME[0]}px;right:{RIGHT + FRAME[1]}px;'
        f'bottom:{BELOW + FRAME[2]}px;height:{LINES_HEIGHT}px">{labels}</div></div>'
    )


def per_rev_labels(stop: float, top: float) -> list[str]:
    """Labels near the upper ends of the per-rev lines; overlapping ones are left out."""
    labels, below = [], -math.inf
    for k in PER_REV:
        x = min(0.97 * stop, 0.94 * top / k)
        right, up = x / stop, k * x / top
        if right <= 0.9 or (up - below) * LINES_HEIGHT >= LETTERS:
            below = up
            labels.append(
                f'<span style="position:absolute;color:#6b7177;left:{100 * right:.2f}%;'
                f'bottom:{100 * up:.2f}%;transform:translate(-110%,0)">{k}γ</span>'
            )
    return labels


def legend(chart: Chart, second: Chart | None) -> str:
    """Meaning of the colours and marks."""
    if chart.loci is None:
        return ""
    parts = [
        f"{coloured('━', COLOURS[family])} {family}" for family in FAMILIES if chart.lines[family]
    ]
    if second:
        parts.append(f"{coloured('╍', FAINT)} compared with")
    kinds = {event.kind for event in chart.events}
    parts += [f"{sign} {kind}" for kind, sign in SIGNS.items() if kind in kinds]
    return f'<div aria-label="key" style="{SMALL};opacity:.8">{" &ensp;".join(parts)}</div>'


def modes_here(chart: Chart, solution: Solution) -> str:
    """The modes of the beam shown, which is the upright line of the chart."""
    along, across = chart.request.measures
    labels = identify_modes(solution).labels
    modes = " &ensp;".join(
        f'<span style="white-space:nowrap">{coloured(label, COLOURS[family])}'
        f" {across.factor * frequency:.4g}</span>"
        for label, family, frequency in zip(
            labels, solution.families, solution.frequencies, strict=False
        )
        if math.isfinite(frequency)
    )
    value = along.text(getattr(solution.beam, chart.request.over), 5)
    return (
        f'<div aria-label="this beam" style="{SMALL}">┊ this beam, {value}:<br>'
        f"{f'{modes} {across.unit}'.rstrip()}</div>"
    )


def named(chart: Chart, value: float, *branches: str) -> list[str]:
    """What the modes of branches are called near a value."""
    names = names_of_branches(chart.loci, value) if chart.loci else {}
    return [names.get(branch, branch) for branch in branches]


def event_table(chart: Chart, chosen: Event | None) -> str:
    """Table of crossings and veerings."""
    if chart.loci is None:
        return ""
    if not chart.events:
        return small(chart.loci.warning or "No crossing or veering in this range.")
    along, across = chart.request.measures
    heads = ("", "", "modes", f"at {along.head}", across.label, "smallest<br>frequency gap")
    rows = [
        (
            k,
            f"{SIGNS[event.kind]} {event.kind}",
            f"<b>{escape(', '.join(named(chart, event.at, *event.branches)))}</b>",
            along.number(event.at, 4),
            across.number(event.frequency, 3),
            "0" if event.kind == "crossing" else f"{across.factor * event.gap:.3g}",
        )
        for k, event in enumerate(chart.events[:MAX_EVENTS], 1)
    ]
    marked = [k for k, event in enumerate(chart.events) if event == chosen]
    more = len(chart.events) - MAX_EVENTS
    return (
        table("crossings and veerings", heads, rows, marked=marked)
        + (small(f"and {more} more") if more > 0 else "")
        + (small(chart.loci.warning) if chart.loci.warning else "")
    )


def resonance_table(chart: Chart) -> str:
    """Table of resonances, in descending order of speed: slow ones are close together."""
    if not chart.resonances:
        return small("No line 1γ .. 5γ intersects a mode in this range.")
    along, across = chart.request.measures
    heads = ("per rev", "mode", f"at {along.head}", across.label)
    rows = [
        (
            f"{one.per_rev} ×",
            f"<b>{escape(named(chart, one.at, one.branch)[0])}</b>",
            along.number(one.at, 4),
            across.number(one.frequency, 3),
        )
        for one in reversed(chart.resonances)
    ]
    more = len(rows) - MAX_RESONANCES
    return table("resonances", heads, rows[:MAX_RESONANCES], RESONANCES) + (
        small(f"and {more} more at lower speeds") if more > 0 else ""
    )


def gap_notes(chart: Chart) -> str:
    """Why a line ends, or why there is no chart."""
    over = chart.request.over
    limits = chart.loci.limits if chart.loci else ()
    reasons = [
        limit.message.replace(f"{over} =", f"{PARAMETERS[over].symbol} =") for limit in limits
    ]
    return "".join(
        small(f"<b>Gap:</b> {escape(reason)}", "note")
        for reason in ([chart.message] if chart.message else reasons)
    )
