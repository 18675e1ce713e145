"""The tab with the loci chart: its controls, the chart, and what there is to say of it."""

import threading
from typing import Any

from viser import GuiApi, uplot

from beamviz.display_units import LABELS, frequencies
from beamviz.explorer.features.loci_chart import (
    FAMILIES,
    LANES,
    PER_REV,
    Chart,
    Point,
    roomy,
    series,
    top,
)
from beamviz.explorer.features.loci_html import (
    HEIGHT,
    MAX_MEETINGS,
    RIGHT,
    gaps,
    here,
    key,
    labels,
    meetings,
    shown,
)
from beamviz.explorer.features.resonance_list import resonance_list
from beamviz.explorer.page.inputs import Listener, assign, heard
from beamviz.explorer.page.plot_style import COLOURS, FAINT, LINE, MARK, add_plot, axes, dot, scales
from beamviz.explorer.request import MODES
from beamviz.frequency_loci import Event

AXES = {LABELS[name]: name for name in ("gamma", "alpha", "beta", "delta", "mu")}
SECOND_LANES = 4  # lines of one family of a second chart there is room for at first


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
