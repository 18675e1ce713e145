"""The tab Veering: two loci magnified around a crossing or veering, without and with Coriolis
forces, and the mode shapes before, at and after it."""

import math
from dataclasses import dataclass
from html import escape
from typing import NamedTuple

import numpy as np
from viser import uplot

from beamviz.beam import PARAMETERS
from beamviz.drawing.text import Measure, frequencies, measure
from beamviz.explorer.features.loci_chart import (
    FAMILIES,
    ChartRequest,
    enough_lanes,
    lanes,
    padded,
    same_event,
)
from beamviz.explorer.features.loci_tab import LociTab
from beamviz.explorer.jobs import Answer
from beamviz.explorer.page.html import SMALL, small
from beamviz.explorer.page.style import COLOURS, FAINT, LINE, MARK, add_plot, axes, dot, scales
from beamviz.explorer.visitor import Feature, Visitor
from beamviz.frequency_loci import Branch, Event, Loci, loci
from beamviz.solver.solution import BENDING, STRETCHING

POINTS = 40  # of a sweep; even, so that its middle is not one of them
REACH = 0.2  # of the chart's range to both sides: where the other event is searched, widest view
MIN_WIDTH = 0.004  # of the chart's range: half width of the narrowest view
MARGIN = 5.0  # half width of the view, in distances over which the gap doubles
BESIDE = 1e-3  # of the view: shapes are taken beside a crossing, where they are not unique
EXCHANGED, KEPT = 0.5, 0.1  # change of the bending fraction that makes an exchange, or none
X = np.linspace(0.0, 1.0, 61)


class ModeShape(NamedTuple):
    """Shape of a mode at X, largest displacement 1, and its share of bending energy."""

    axial: np.ndarray  # (61,)
    transverse: np.ndarray  # (61,)
    bending_fraction: float


@dataclass(frozen=True)
class LociPair:
    """Two loci around their crossing or veering, without or with Coriolis forces.

    event: None where the two neither cross nor veer; shapes: of each branch before, at and after.
    """

    coriolis: bool
    event: Event | None
    at: float
    values: np.ndarray  # (n,)
    branches: tuple[Branch, Branch]
    shapes: tuple[tuple[ModeShape, ModeShape, ModeShape], ...]

    @property
    def kind(self) -> str:
        """crossing, veering or ""."""
        return self.event.kind if self.event else ""


Pairs = tuple[LociPair, LociPair]  # without and with Coriolis forces


@dataclass(frozen=True)
class VeeringRequest:
    """A crossing or veering of a chart to magnify."""

    chart: ChartRequest
    event: Event

    @property
    def measures(self) -> tuple[Measure, Measure]:
        """Display units of the axis and of the frequencies."""
        units = None if self.chart.over == "mu" else self.chart.beam.units
        return measure(self.chart.over, units), frequencies(units)

    @property
    def width(self) -> float:
        """The range of the chart."""
        return self.chart.stop - self.chart.start

    def pairs(self) -> Pairs:
        """Without and with Coriolis forces, over the same values; raises the errors of `loci`."""
        reach = REACH * self.width
        wide = self.values(self.event.at, reach)
        found = [self.loci(wide, coriolis) for coriolis in (False, True)]
        events = [same_event(one, self.event, reach) for one in found]
        centre, half = self.view(found[0], events)
        at = [one.at + (BESIDE * half if one.kind == "crossing" else 0) for one in events if one]
        values = np.union1d(self.values(centre, half), at)
        off, on = (
            loci_pair(self.loci(values, coriolis), event, self.event, centre)
            for coriolis, event in zip((False, True), events, strict=True)
        )
        return off, on

    def values(self, at: float, reach: float) -> np.ndarray:
        """Values to both sides of `at`, within the limits of the number."""
        low, high = PARAMETERS[self.chart.over].limits
        return np.linspace(max(at - reach, low), min(at + reach, high, self.chart.stop), POINTS)

    def loci(self, values: np.ndarray, coriolis: bool) -> Loci:
        """The loci over some values."""
        options = {**self.chart.options, "coriolis": coriolis}
        return loci(self.chart.beam, self.chart.over, values, **options)

    def view(self, found: Loci, events: list[Event | None]) -> tuple[float, float]:
        """Centre and half width of a view of both events and of the whole gap."""
        at = [one.at for one in events if one] or [self.event.at]
        centre, extent = (min(at) + max(at)) / 2, max(at) - min(at)
        a, b = branches_of(found, self.event, centre)
        slope = abs(np.gradient(b.frequency - a.frequency, found.values))
        steepest = float(np.nanmax(slope)) if np.isfinite(slope).any() else 0.0
        gap = max((one.gap for one in events if one), default=0.0)
        spread = MARGIN * gap / steepest if steepest else 0.0
        half = np.clip(max(extent, spread), MIN_WIDTH * self.width, REACH * self.width)
        return centre, float(half)


def branches_of(found: Loci, event: Event, at: float) -> tuple[Branch, Branch]:
    """The two branches of an event; by frequency where other loci have other labels."""
    by_label = {branch.label: branch for branch in found.branches}
    if all(label in by_label for label in event.branches):
        return by_label[event.branches[0]], by_label[event.branches[1]]
    k = int(np.argmin(abs(found.values - at)))
    distance = [abs(branch.frequency[k] - event.frequency) for branch in found.branches]
    first, second = np.argsort(np.nan_to_num(distance, nan=np.inf))[:2]
    return found.branches[first], found.branches[second]


def loci_pair(found: Loci, own: Event | None, event: Event, centre: float) -> LociPair:
    """Two loci with their shapes at the ends of the view and at their event."""
    at = own.at if own else centre
    branches = branches_of(found, own or event, at)
    k = int(np.argmin(abs(found.values - at)))
    shapes = []
    for branch in branches:
        first, middle, last = (mode_shape(branch, i) for i in (0, k, len(found.values) - 1))
        shapes.append((aligned(first, middle), middle, aligned(last, middle)))
    return LociPair(found.problem.coriolis, own, at, found.values, branches, tuple(shapes))


def mode_shape(branch: Branch, k: int) -> ModeShape:
    """Shape of a branch at value number k; nan where it has none.

    With Coriolis forces axial and transverse motion are a quarter of a period apart: the complex
    shape is real along the beam and imaginary across it, up to a factor.
    """
    solution, mode = branch.solutions[k], int(branch.mode_index[k])
    if solution is None or mode < 0:
        return ModeShape(np.full(len(X), np.nan), np.full(len(X), np.nan), np.nan)
    shape = solution.shape(mode, X)
    parts = shape.real + shape.imag
    axial, transverse = parts.T / np.linalg.norm(parts, axis=1).max()
    return ModeShape(axial, transverse, float(solution.bending_energy_fraction[mode]))


def aligned(one: ModeShape, other: ModeShape) -> ModeShape:
    """A shape with the sign that correlates with another."""
    overlap = one.axial @ other.axial + one.transverse @ other.transverse
    return one._replace(axial=-one.axial, transverse=-one.transverse) if overlap < 0 else one


HEIGHT = 175  # [px] of the chart
LANES = 4  # initial lines per family
WIDTH, TALL = 96, 30  # [px] of the drawing of a shape
INVITATION = "Choose a crossing or veering in the tab Loci to see it magnified here."
KEY = small(
    "Displacement of the beam: "
    f'<b style="color:{COLOURS[BENDING]}">━</b> transverse (bending), '
    f'<b style="color:{COLOURS[STRETCHING]}">━</b> axial (stretching).'
)


class VeeringTab(Feature):
    """A summary, a chart of both cases and the mode shapes."""

    def __init__(self, visitor: Visitor, loci_tab: LociTab):
        super().__init__(visitor)
        gui, self.loci_tab, self.lanes = visitor.client.gui, loci_tab, LANES
        self.job = visitor.job("veering", VeeringRequest.pairs)
        self.summary = gui.add_html(small(INVITATION))
        empty = (np.array([0.0, 1.0]), *[np.full(2, np.nan)] * (len(styles(LANES)) - 1))
        self.plot = add_plot(gui, empty, styles(LANES), axes("", ""), HEIGHT, visible=False)
        self.shapes = gui.add_html("")

    @property
    def inputs(self) -> tuple[object, ...]:
        """The chosen crossing or veering, and the answer."""
        return self.loci_tab.chosen, self.loci_tab.charts.answer, self.job.answer

    def show(self) -> None:
        """Magnify the chosen crossing or veering as long as the chart has it."""
        chosen, chart = self.loci_tab.chosen, self.loci_tab.chart
        exists = chosen is not None and chart is not None and chosen in chart.events
        if chosen and chart and exists and not self.loci_tab.charts.busy:
            self.job.request(VeeringRequest(chart.request, chosen))
        answer = self.job.answer if chosen else None
        pairs = (answer.result or ()) if answer and exists else ()
        self.plot.visible = bool(pairs)
        self.summary.content = summary(answer, exists=exists)
        self.shapes.content = "".join(map(shape_table, pairs)) + KEY if pairs else ""
        if answer and pairs:
            self.plot_pairs(pairs, *answer.request.measures)

    def plot_pairs(self, pairs: Pairs, along: Measure, across: Measure) -> None:
        """Draw the loci of both cases."""
        frequency = [branch.frequency for pair in pairs for branch in pair.branches]
        low, high = np.nanmin(frequency), np.nanmax(frequency)
        margin = 0.06 * (high - low)
        x_ends = along.factor * pairs[0].values[0], along.factor * pairs[0].values[-1]
        y_ends = across.factor * (low - margin), across.factor * (high + margin)
        before = self.lanes
        for pair in pairs:
            self.lanes = enough_lanes(self.lanes, lanes(pair.branches))
        x, *lines = series(pairs, self.lanes)
        self.plot.axes = axes(along.label, across.label)
        self.plot.scales = scales(
            (float(x_ends[0]), float(x_ends[1])), (float(y_ends[0]), float(y_ends[1]))
        )
        self.plot.data = (along.factor * x, *(across.factor * line for line in lines))
        if self.lanes != before:
            self.plot.series = styles(self.lanes)


def styles(count: int) -> tuple[uplot.Series, ...]:
    """Styles of `series`: dashed without Coriolis forces, thick with them."""
    lines: list[uplot.Series] = [{}]
    cases: tuple[uplot.Series, ...] = ({"width": 1.25, "dash": (5, 4)}, {"width": 2.5})
    for case in cases:
        for family in FAMILIES:
            lines += [{"stroke": COLOURS[family], **LINE, **case}] * count
    lines.append({"stroke": MARK, "width": 1.5, **LINE})
    return (*lines, {"stroke": MARK, "width": 0, "points": dot("#ffffff", MARK, 7)})


def series(pairs: Pairs, count: int) -> tuple[np.ndarray, ...]:
    """Arrays (n,) over common values: x, `count` lines per family without and with Coriolis
    forces, the smallest gap as an upright line, the crossings."""
    x = pairs[0].values
    veering = next((pair for pair in reversed(pairs) if pair.kind == "veering"), None)
    doubled = np.insert(x, np.searchsorted(x, veering.at), veering.at) if veering else x
    keep = np.searchsorted(x, doubled)
    lines = [row[keep] for pair in pairs for row in padded(lanes(pair.branches), count, len(x))]
    gap, crossings = np.full((2, len(doubled)), np.nan)
    if veering:
        k = int(np.searchsorted(doubled, veering.at))
        gap[k : k + 2] = [branch.frequency[keep[k]] for branch in veering.branches]
    for pair in pairs:
        if pair.event and pair.kind == "crossing":
            crossings[np.searchsorted(doubled, pair.at)] = pair.event.frequency
    return (doubled, *lines, gap, crossings)


def summary(answer: Answer[VeeringRequest, Pairs] | None, *, exists: bool) -> str:
    """A sentence for each case; `exists`: the two still cross or veer in the chart."""
    if answer is None:
        return small(INVITATION)
    a, b = (escape(label) for label in answer.request.event.branches)
    if answer.message or not exists:
        reason = escape(answer.message)
        return small(reason or f"{a} and {b} neither cross nor veer now. {INVITATION}", "note")
    measures = answer.request.measures
    items = "".join(f"<li>{sentence(pair, *measures)}</li>" for pair in answer.result or ())
    return (
        f'<div aria-label="crossing or veering" style="{SMALL}"><b>{a} and {b}</b>'
        f'<ul style="margin:.1em 0;padding-left:1.2em">{items}</ul></div>'
    )


def sentence(pair: LociPair, along: Measure, across: Measure) -> str:
    """Crossing or veering, where, and the size of the gap."""
    case = "<b>Coriolis on</b> (thick): " if pair.coriolis else "<b>Coriolis off</b> (dashed): "
    if pair.event is None:
        return case + "too far apart for a veering."
    value = along.number(pair.at, 3)
    at = f"at {value} {along.unit}" if along.unit else f"at {along.symbol} {value}"
    if pair.kind == "crossing":
        return f"{case}they cross {at}, uncoupled (gap 0)."
    gap = f"{across.factor * pair.event.gap:.3g} {across.unit}".strip()
    return f"{case}they veer, smallest frequency gap {gap} {at}; {exchange(pair)}."


def exchange(pair: LociPair) -> str:
    """How much of their shapes the two branches exchange."""
    first, _, last = pair.shapes[0]
    change = abs(last.bending_fraction - first.bending_fraction)
    if not math.isfinite(change) or change < KEPT:
        return "each keeps its family"
    return (
        "they exchange their shapes" if change > EXCHANGED else "they exchange part of their shapes"
    )


def shape_table(pair: LociPair) -> str:
    """The shapes of both branches, the upper one first, before, at and after."""
    order = sorted((0, 1), key=lambda k: -float(np.nan_to_num(pair.branches[k].frequency[0])))
    rows = "".join(
        f"<tr><td><b>{escape(pair.branches[k].label)}</b></td>"
        + "".join(f"<td>{drawing(shape)}</td>" for shape in pair.shapes[k])
        + "</tr>"
        for k in order
    )
    case = "on" if pair.coriolis else "off"
    heads = "".join(
        f'<th style="font-weight:500">{head}</th>' for head in ("before", "at", "after")
    )
    return (
        f'<table aria-label="shapes, Coriolis {case}" style="width:calc(100% - 1.5em);'
        "margin:.2em .75em;font-size:.75em;text-align:center;border-collapse:collapse;"
        f'line-height:1.2"><tr style="opacity:.65"><th style="text-align:left;font-weight:500">'
        f"{case}</th>{heads}</tr>{rows}</table>"
    )


def drawing(shape: ModeShape) -> str:
    """A shape as SVG: displacement along and across the beam over x."""
    if not math.isfinite(shape.bending_fraction):
        return "–"
    family = BENDING if shape.bending_fraction >= 0.5 else STRETCHING
    lines = "".join(
        f'<polyline points="{points(part)}" fill="none" stroke="{COLOURS[own]}" '
        f'stroke-width="{2 if own == family else 1}"/>'
        for own, part in ((STRETCHING, shape.axial), (BENDING, shape.transverse))
    )
    share = max(shape.bending_fraction, 1 - shape.bending_fraction)
    return (
        f'<svg width="{WIDTH}" height="{TALL}" role="img">'
        f'<path d="M0 {TALL / 2}H{WIDTH}" stroke="{FAINT}" stroke-width=".5"/>{lines}</svg>'
        f"<br>{100 * share:.0f} % {family}"
    )


def points(part: np.ndarray) -> str:
    """A curve as points of an SVG."""
    y = TALL / 2 * (1 - 0.9 * part)
    return " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(WIDTH * X, y, strict=True))
