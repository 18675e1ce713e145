"""The tab with the loci chart: its controls, the chart, and what there is to say of it."""

import contextlib
import math
from collections.abc import Callable, Sequence
from html import escape
from typing import Any

from viser import GuiTabHandle, uplot

from beamviz.beam import PARAMETERS
from beamviz.display_units import Measure, frequencies, measure
from beamviz.errors import InvalidInput
from beamviz.explorer.features.comparison import against
from beamviz.explorer.features.loci_chart import (
    FAMILIES,
    LANES,
    PER_REV,
    Chart,
    Point,
    Question,
    charted,
    roomy,
    series,
    top,
)
from beamviz.explorer.features.veering import Closeup, MicroscopeTab, Target, magnified, same
from beamviz.explorer.jobs import Answer
from beamviz.explorer.page.html import SMALL
from beamviz.explorer.page.style import (
    ABOVE,
    BELOW,
    COLOURS,
    FAINT,
    LEFT,
    LINE,
    MARK,
    add_plot,
    apart,
    axes,
    dot,
    scales,
)
from beamviz.explorer.state import Case
from beamviz.explorer.visitor import Feature, Visitor, on_press
from beamviz.exports.html_tables import table
from beamviz.frequency_loci import Event, Loci
from beamviz.frequency_loci.forced_response import Resonance
from beamviz.scene import MODES

SIGNS = {"crossing": "○", "veering": "●"}
VERBS = {"crossing": "cross", "veering": "veer"}
MAX_MEETINGS = 8
LETTERS = 11  # [px]
HEIGHT, RIGHT = 210, 32  # [px] of the chart, and of its margin at the right
FRAME = (10.25, 8.25, 12)  # [px] around the chart: left, right, below


def shown(chart: Chart) -> tuple[Measure, Measure]:
    """How the number along the chart and the frequencies are shown."""
    units = chart.loci.units if chart.loci else chart.question.beam.units
    return measure(chart.question.over, units), frequencies(units)


def labels(found: Loci, per_rev: bool) -> str:
    """The names that modes have at the right end, put over the chart that stands above: where
    two loci have exchanged their shapes, they have exchanged their names."""
    high = top(found)
    ends = sorted(
        (float(solution.frequencies[k]), solution.labels[k], COLOURS[solution.families[k]])
        for branch in found.branches
        if (solution := branch.solutions[-1]) and (k := int(branch.mode_index[-1])) >= 0
        if math.isfinite(solution.frequencies[k])
    )
    places = apart([end for end, _, _ in ends], high * 13 / (HEIGHT - ABOVE - BELOW))
    names = [
        f'<b style="position:absolute;left:100%;margin-left:4px;color:{colour};'
        f'bottom:calc({100 * place / high:.2f}% - .65em)">{escape(label)}</b>'
        for place, (_, label, colour) in zip(places, ends, strict=True)
    ]
    if per_rev and found.over == "gamma":
        names += per_rev_labels(float(found.values[-1]), high)
    return (
        '<div aria-hidden="true" data-labels style="position:relative;height:0;'
        'pointer-events:none;font-size:11px;line-height:1.3">'
        f'<div style="position:absolute;left:{LEFT + FRAME[0]}px;right:{RIGHT + FRAME[1]}px;'
        f'bottom:{BELOW + FRAME[2]}px;height:{HEIGHT - ABOVE - BELOW}px">'
        + "".join(names)
        + "</div></div>"
    )


def per_rev_labels(stop: float, high: float) -> list[str]:
    """The names of the per-rev lines, near their upper ends; where they would touch, some."""
    names, below, height = [], -math.inf, HEIGHT - ABOVE - BELOW
    for k in PER_REV:
        x = min(0.97 * stop, 0.94 * high / k)
        right, up = x / stop, k * x / high
        crowded = right > 0.9 and (up - below) * height < LETTERS
        if not crowded:
            below = up
            names.append(
                f'<span style="position:absolute;color:#6b7177;left:{100 * right:.2f}%;'
                f'bottom:{100 * up:.2f}%;transform:translate(-110%,0)">{k}γ</span>'
            )
    return names


def key(chart: Chart, second: Chart | None) -> str:
    """What colours and marks mean."""
    if chart.loci is None:
        return ""
    seen = {str(family) for branch in chart.loci.branches for family in branch.family if family}
    parts = [f'<b style="color:{COLOURS[f]}">━</b> {f}' for f in FAMILIES if f in seen]
    if second:
        parts.append(f'<b style="color:{FAINT}">╍</b> compared with')
    kinds = {event.kind for event in chart.events}
    parts += [f"{SIGNS[kind]} {VERBS[kind]}" for kind in SIGNS if kind in kinds]
    return f'<div aria-label="key" style="{SMALL};opacity:.8">{" &ensp;".join(parts)}</div>'


def here(point: Point | None, along: Measure, across: Measure) -> str:
    """The modes of the beam of the scene: the upright line of the chart."""
    if point is None:
        return ""
    modes = " &ensp;".join(
        f'<span style="white-space:nowrap"><b style="color:{COLOURS[family]}">{label}</b>'
        f" {across.factor * frequency:.4g}</span>"
        for label, family, frequency in zip(*point.names, point.frequencies, strict=True)
        if math.isfinite(frequency)
    )
    value = along.text(point.value, 5)
    unit = f" {across.unit}" if across.unit else ""
    return (
        f'<div aria-label="this beam" style="{SMALL}">┊ this beam, {value}:<br>{modes}{unit}</div>'
    )


def meetings(chart: Chart, chosen: Event | None) -> str:
    """The table of the meetings."""
    warning = chart.loci.warning if chart.loci else ""
    if not chart.events:
        words = warning or ("" if chart.loci is None else "No two of these lines meet here.")
        return f'<div style="{SMALL}">{words}</div>' if words else ""
    along, across = shown(chart)
    heads = ("", "", "lines", f"at {along.head}", across.label, "least gap")
    rows = [row(k, event, along, across) for k, event in enumerate(chart.events[:MAX_MEETINGS])]
    marked = [k for k, event in enumerate(chart.events) if event == chosen]
    more = len(chart.events) - MAX_MEETINGS
    return (
        table("meetings", heads, rows, marked=marked)
        + (f'<div style="{SMALL}">and {more} more</div>' if more > 0 else "")
        + (f'<div style="{SMALL}">{warning}</div>' if warning else "")
    )


def row(k: int, event: Event, along: Measure, across: Measure) -> tuple[object, ...]:
    """One meeting."""
    a, b = event.branches
    gap = "0" if event.kind == "crossing" else f"{across.factor * event.gap:.3g}"
    return (
        k + 1,
        f"{SIGNS[event.kind]} {VERBS[event.kind]}",
        f"<b>{escape(a)}, {escape(b)}</b>",
        along.number(event.at, 4),
        across.number(event.frequency, 3),
        gap,
    )


def gaps(chart: Chart) -> str:
    """Why a line ends, or why there is none."""
    limits = chart.loci.limits if chart.loci else ()
    over = chart.question.over
    named = [limit.message.replace(f"{over} =", f"{PARAMETERS[over].symbol} =") for limit in limits]
    words = [chart.words] if chart.words else named
    return "".join(f'<div role="note" style="{SMALL}"><b>Gap:</b> {escape(w)}</div>' for w in words)


MOST = 12  # rows
CAPTION = "Resonances: a force that comes so often in each turn excites the mode"


def resonance_list(found: Sequence[Resonance], along: Measure, across: Measure) -> str:
    """The table of resonances in the units of `along` (speed) and `across` (frequency), the
    fastest ones first: there the modes are told apart best."""
    if not found:
        return f'<div style="{SMALL}">No line 1γ .. 5γ meets a mode here.</div>'
    heads = ("per turn", "mode", f"at {along.head}", across.label)
    rows = [
        (f"{one.per_rev} ×", f"<b>{one.branch}</b>", along.number(one.at, 4),
         across.number(one.frequency, 3))
        for one in reversed(found)
    ]  # fmt: skip
    more = len(rows) - MOST
    shown = table("resonances", heads, rows[:MOST], CAPTION)
    return shown + (
        f'<div style="{SMALL}">and {more} more at lower speeds</div>' if more > 0 else ""
    )


AXES = {PARAMETERS[name].slider_label: name for name in ("gamma", "alpha", "beta", "delta", "mu")}
SECOND_LANES = 4  # lines of one family of a second chart there is room for at first


class ChartTab:
    """Shows a chart and hands on the choices made about it."""

    def __init__(self, visitor: Visitor, choose: Callable[[int], None]):
        self.choose, self.room, self.second_room = choose, LANES, 0
        gui = visitor.client.gui
        self.known: tuple = ()  # what the axes were built for
        self.axis = axis = gui.add_dropdown(
            "along", tuple(AXES), hint="The number the chart runs over"
        )
        visitor.bind(
            axis,
            lambda state: PARAMETERS[state.over].slider_label,
            lambda state, label: state.changed("over", AXES.get(label, "")),
        )
        self.per_rev = gui.add_checkbox(
            "per-rev lines",
            False,
            hint="ω = 1, 2 ... 5 times γ: where a line meets one, each turn can excite that mode",
        )
        visitor.bind_key(self.per_rev, "per_rev")
        nothing = series(Chart.nothing(), None, LANES, per_rev=False)
        self.plot = add_plot(
            gui,
            nothing,
            styles(LANES),
            axes(axis.value, frequencies(None).label),
            HEIGHT,
            right=RIGHT,
        )
        self.labels, self.table = gui.add_html(""), gui.add_html("")
        self.go = gui.add_button_group("go to", ("1",), visible=False, hint="Move the beam there")
        on_press(self.go, self.pick)

    def pick(self, number: Any) -> None:
        """A meeting was chosen, by its number."""
        if number in self.go.options:
            self.choose(int(number) - 1)

    def show(
        self,
        chart: Chart,
        point: Point | None,
        per_rev: bool,
        chosen: Event | None,
        second: Chart | None,
    ) -> None:
        """Draw a chart, with the beam of the scene on it, and a second one under it."""
        question, over = chart.question, chart.question.over
        along, across = shown(chart)
        x = along.factor * question.start, along.factor * question.stop
        y = 0.0, across.factor * top(chart.loci) if chart.loci else 1.0
        self.per_rev.visible = over == "gamma"
        if self.known != (along, across, x, y):  # not every time: it builds the chart anew
            self.known, self.plot.scales = (along, across, x, y), scales(x, y)
            self.plot.axes = axes(along.label, across.label)
        rooms = self.room, self.second_room
        self.room = roomy(self.room, chart.rows)
        if second:
            self.second_room = roomy(self.second_room or SECOND_LANES, second.rows)
        self.plot.data = series(
            chart,
            point,
            self.room,
            per_rev=per_rev,
            second=second,
            second_room=self.second_room,
        )
        if rooms != (self.room, self.second_room):
            self.plot.series = styles(self.room, self.second_room)
        self.labels.content = labels(chart.loci, per_rev) if chart.loci else ""
        self.table.content = (
            key(chart, second)
            + here(point, along, across)
            + meetings(chart, chosen)
            + (resonance_list(chart.resonances, along, across) if per_rev else "")
            + gaps(chart)
        )
        numbers = tuple(str(k + 1) for k in range(min(len(chart.events), MAX_MEETINGS)))
        self.go.visible = bool(numbers)
        if numbers and self.go.options != numbers:
            self.go.options = numbers


def styles(room: int, second_room: int = 0) -> tuple[uplot.Series, ...]:
    """How the arrays of `chart.series` are drawn, with `room` lanes for each family and
    `second_room` for each of a second chart."""
    lines: list[uplot.Series] = [{}]
    for family in FAMILIES:
        lines += [{"stroke": COLOURS[family], "width": 2, **LINE}] * room
    lines += [{"stroke": FAINT, "width": 1, "dash": (5, 4), **LINE}] * len(PER_REV)
    lines.append({"stroke": MARK, "width": 1, "dash": (2, 3), **LINE})
    lines += [{"stroke": MARK, "width": 0, "points": dot("#ffffff", MARK, 9)}] * MODES
    for family in FAMILIES:
        paler: uplot.Series = {"stroke": COLOURS[family] + "90", "width": 1.25, "dash": (4, 3)}
        lines += [{**paler, **LINE}] * second_room
    lines.append({"stroke": MARK, "width": 0, "points": dot("#ffffff", MARK, 7)})
    lines.append({"stroke": MARK, "width": 0, "points": dot(MARK, MARK, 7)})
    return tuple(lines)


class Charting(Feature):
    """Follows the scene, one step behind it."""

    def __init__(self, visitor: Visitor, loci: GuiTabHandle, microscope: GuiTabHandle):
        super().__init__(visitor)
        self.chosen: Event | None = None
        self.charts = visitor.job("chart", charted)
        self.others = visitor.job("chart", charted)  # of the beam that is compared with
        self.closeups = visitor.job("close-up", magnified)
        with loci:
            self.tab = ChartTab(visitor, self.choose)
        with microscope:
            self.microscope = MicroscopeTab(visitor.client.gui)

    def choose(self, number: int) -> None:
        """Take a meeting (from 0) under the microscope, and move the beam there."""
        chart = self.charts.result
        if chart is None or not 0 <= number < len(chart.events):
            return
        self.chosen = event = chart.events[number]
        self.visitor.change(lambda state: state.changed(chart.question.over, event.at))

    @property
    def inputs(self) -> tuple:
        """What the tabs depend on."""
        state = self.visitor.state
        return (
            self.visitor.chart_answer, state.over, state.per_rev, state.comparison,
            state.kept, self.chosen, self.charts.answer, self.closeups.answer, self.others.answer,
        )  # fmt: skip

    def other(self) -> Case | None:
        """What is compared with, None where nothing is."""
        answer, state = self.visitor.chart_answer, self.visitor.state
        other = against(state, answer.request) if answer else ""
        return None if isinstance(other, str) else other.case

    def request(self) -> None:
        """Ask for the chart around what the scene shows, and for that of the other beam on the
        same axis."""
        answer, other = self.visitor.chart_answer, self.other()
        if answer is None:
            return
        with contextlib.suppress(InvalidInput):  # the panel says so; the last chart stays
            question = Question.of(answer.request, self.visitor.state.over)
            self.charts.request(question)
            if other:
                self.others.request(question.asked_of(other))

    def show(self) -> None:
        """Show the latest of everything."""
        state, answer = self.visitor.state, self.visitor.chart_answer
        self.request()
        chart = drawable(self.charts.answer)
        if self.chosen and chart and chart.question.over != state.over:
            self.chosen = None
        if chart is not None and not self.charts.busy:
            self.look_closer(chart)
        if chart is None:
            return
        solution = answer.solution if answer else None
        point = Point.of(solution, chart.question.over) if solution else None
        second = drawable(self.others.answer) if self.other() else None
        self.tab.show(chart, point, state.per_rev, self.chosen, second)
        found = self.closeups.answer if self.chosen else None
        closeup = (found.result or Closeup(found.request, words=found.message)) if found else None
        lost = self.chosen is not None and self.chosen not in chart.events
        self.microscope.show(closeup, lost=lost)

    def look_closer(self, chart: Chart) -> None:
        """Keep the chosen meeting under the microscope while the chart changes."""
        if (
            self.chosen is None
            or chart.loci is None
            or chart.question.over != self.visitor.state.over
        ):
            return
        question = chart.question
        self.chosen = same(chart.loci, self.chosen, question.stop - question.start) or self.chosen
        target = Target(question, self.chosen)
        if self.chosen in chart.events:
            self.closeups.request(target)


def drawable(answer: Answer[Question, Chart] | None) -> Chart | None:
    """The chart of an answer, or an empty one with the reason."""
    if answer is None:
        return None
    return answer.result or Chart(answer.request, words=answer.message)
