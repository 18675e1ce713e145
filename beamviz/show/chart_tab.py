"""The tab with the loci chart: its controls, the chart, labels on its lines, and the meetings."""

import math
import threading
from html import escape
from typing import Any

from viser import GuiApi, uplot

from beamviz.mechanics.solution import MIXED
from beamviz.show.chart import FAMILIES, LANES, PER_REV, Chart, Point, roomy, series, top
from beamviz.show.controls import MODES
from beamviz.show.measures import LABELS, Measure, frequencies, measure
from beamviz.show.per_rev import resonance_list
from beamviz.show.sliders import Listener, assign, heard
from beamviz.show.tables import SMALL
from beamviz.study.chart_style import COLOURS as FAMILY_COLOURS
from beamviz.study.chart_style import SYMBOLS
from beamviz.study.loci import Event, Loci

COLOURS = {**FAMILY_COLOURS, MIXED: "#CC79A7"}
FAINT, MARK = "#9AA0A6", "#787E85"  # seen on light and dark pages
SIGNS = {"crossing": "○", "veering": "●"}
VERBS = {"crossing": "cross", "veering": "veer"}
AXES = {LABELS[name]: name for name in ("gamma", "alpha", "beta", "delta", "mu")}
MAX_MEETINGS = 8
HEIGHT, LEFT, RIGHT, ABOVE, BELOW = 210, 40, 32, 8, 44  # [px] of the chart and its margins
FRAME = (10.25, 8.25, 12)  # [px] around the chart: left, right, below
SECOND_LANES = 4  # lines of one family of a second chart there is room for at first
LINE: uplot.Series = {"points": {"show": False}, "pxAlign": False}


class ChartTab:
    """Shows a chart and hands on the choices made about it."""

    def __init__(self, gui: GuiApi, lock: threading.RLock, listener: Listener):
        self.listener, self.room, self.second_room = listener, LANES, 0
        self.known: tuple = ()  # what the axes were built for
        self.axis = axis = gui.add_dropdown(
            "along", tuple(AXES), hint="The number the chart runs over"
        )
        heard(axis, lock, lambda label: listener.sweep(AXES.get(label, "")))
        self.per_rev = gui.add_checkbox(
            "per-rev lines",
            False,
            hint="ω = 1, 2 ... 5 times γ: where a line meets one, each turn can excite that mode",
        )
        heard(self.per_rev, lock, listener.show_per_rev)
        self.plot = gui.add_uplot(
            series(Chart.nothing(), None, LANES, per_rev=False),
            styles(LANES),
            scales=scales((0.0, 1.0), (0.0, 1.0)),
            axes=axes(axis.value),
            legend={"show": False},
            cursor={"drag": {"x": False, "y": False}, "points": {"show": False}},
            padding=(ABOVE, RIGHT, 0, 0),
            height=HEIGHT,
        )
        self.labels, self.table = gui.add_html(""), gui.add_html("")
        self.go = gui.add_button_group("go to", ("1",), visible=False, hint="Move the beam there")
        self.go.on_click(lambda event: self.pick(event.target.value))

    def put(self, over: str, per_rev: bool) -> None:
        """Put the controls where a scene has them."""
        assign(self.axis, next(label for label, name in AXES.items() if name == over))
        assign(self.per_rev, per_rev)

    def show_lines(self) -> None:
        """Draw the per-rev lines, as if they had been asked for."""
        assign(self.per_rev, True)
        self.listener.show_per_rev(True)

    def pick(self, number: Any) -> None:
        """A meeting was chosen, by its number."""
        if number in self.go.options:
            self.listener.meet(int(number) - 1)

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
        if self.known != (along, x, y):  # not every time: it builds the chart anew
            self.known, self.plot.scales = (along, x, y), scales(x, y)
            self.plot.axes = axes(along.label)
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


def shown(chart: Chart) -> tuple[Measure, Measure]:
    """How the number along the chart and the frequencies are shown."""
    units = chart.loci.units if chart.loci else chart.question.beam.units
    return measure(chart.question.over, units), frequencies(units)


def scales(x: tuple[float, float], y: tuple[float, float]) -> dict[str, uplot.Scale]:
    """The ends of both axes; missing values spoil those the page would find by itself."""
    return {"x": {"time": False, "range": x}, "y": {"range": y}}


FONTS: uplot.Axis = {"font": "11px sans-serif", "labelFont": "12px sans-serif"}


def axes(label: str) -> tuple[uplot.Axis, ...]:
    """The two axes, of fixed size so that labels can be put on the lines."""
    return (
        {
            "label": label,
            "size": BELOW - 18,
            "labelSize": 18,
            "labelGap": 0,
            "gap": 3,
            "space": 45,
            **FONTS,
        },
        {"size": LEFT, "gap": 3, "space": 28, **FONTS},
    )


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


def dot(fill: str, stroke: str, size: int) -> uplot.Series_Points:
    """A round mark."""
    return {"show": True, "fill": fill, "stroke": stroke, "size": size, "width": 1.5}


def labels(found: Loci, per_rev: bool) -> str:
    """The names that modes have at the right end, put over the chart that stands above: where
    two loci have exchanged their shapes, they have exchanged their names."""
    high = top(found)
    ends = sorted(
        (float(solution.frequencies[k]), solution.labels[k], COLOURS[solution.families[k]])
        for branch in found.branches
        if (solution := branch.solutions[-1]) and (k := int(branch.places[-1])) >= 0
        if math.isfinite(solution.frequencies[k])
    )
    places = apart([end for end, _, _ in ends], high * 13 / (HEIGHT - ABOVE - BELOW))
    names = [
        f'<b style="position:absolute;left:100%;margin-left:4px;color:{colour};'
        f'bottom:calc({100 * place / high:.2f}% - .65em)">{escape(label)}</b>'
        for place, (_, label, colour) in zip(places, ends, strict=True)
    ]
    if per_rev and found.over == "gamma":
        names += [per_rev_label(k, float(found.values[-1]), high) for k in PER_REV]
    return (
        '<div aria-hidden="true" data-labels style="position:relative;height:0;'
        'pointer-events:none;font-size:11px;line-height:1.3">'
        f'<div style="position:absolute;left:{LEFT + FRAME[0]}px;right:{RIGHT + FRAME[1]}px;'
        f'bottom:{BELOW + FRAME[2]}px;height:{HEIGHT - ABOVE - BELOW}px">'
        + "".join(names)
        + "</div></div>"
    )


def per_rev_label(k: int, stop: float, high: float) -> str:
    """The name of a per-rev line, near its upper end."""
    x = min(0.97 * stop, 0.94 * high / k)
    return (
        f'<span style="position:absolute;color:#6b7177;left:{100 * x / stop:.2f}%;'
        f'bottom:{100 * k * x / high:.2f}%;transform:translate(-110%,0)">{k}γ</span>'
    )


def apart(places: list[float], least: float) -> list[float]:
    """Ascending places moved up until none is nearer than `least` to the one below."""
    moved: list[float] = []
    for place in places:
        moved.append(max(place, moved[-1] + least) if moved else place)
    return moved


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
    unfinished = "" if chart.loci is None or chart.loci.complete else chart.loci.unfinished
    if not chart.events:
        words = unfinished or ("" if chart.loci is None else "No two of these lines meet here.")
        return f'<div style="{SMALL}">{words}</div>' if words else ""
    along, across = shown(chart)
    heads = ("", "", "lines", f"at {along.head}", across.label, "least gap")
    rows = [row(k, event, along, across, event == chosen) for k, event in enumerate(chart.events)]
    more = len(rows) - MAX_MEETINGS
    return (
        '<table aria-label="meetings" style="width:calc(100% - 1.5em);margin:0 .75em .2em;'
        "border-collapse:collapse;font-size:.8em;font-variant-numeric:tabular-nums;"
        'line-height:1.6;text-align:right"><tr style="opacity:.65">'
        + "".join(f'<th style="font-weight:500">{head}</th>' for head in heads)
        + "</tr>"
        + "".join(rows[:MAX_MEETINGS])
        + "</table>"
        + (f'<div style="{SMALL}">and {more} more</div>' if more > 0 else "")
        + (f'<div style="{SMALL}">{unfinished}</div>' if unfinished else "")
    )


def row(k: int, event: Event, along: Measure, across: Measure, marked: bool) -> str:
    """One meeting."""
    a, b = event.branches
    gap = "0" if event.kind == "crossing" else f"{across.factor * event.gap:.3g}"
    cells = (
        k + 1,
        f"{SIGNS[event.kind]} {VERBS[event.kind]}",
        f"<b>{escape(a)}, {escape(b)}</b>",
        along.number(event.at, 4),
        across.number(event.frequency, 3),
        gap,
    )
    style = ' style="background:rgba(204,60,140,.14)"' if marked else ""
    return f"<tr{style}>" + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>"


def gaps(chart: Chart) -> str:
    """Why a line ends, or why there is none."""
    limits = chart.loci.limits if chart.loci else ()
    over = chart.question.over
    named = [limit.message.replace(f"{over} =", f"{SYMBOLS[over]} =") for limit in limits]
    words = [chart.words] if chart.words else named
    return "".join(f'<div role="note" style="{SMALL}"><b>Gap:</b> {escape(w)}</div>' for w in words)
