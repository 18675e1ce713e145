"""The tab Veering: two loci magnified around a crossing or veering, without and with Coriolis
forces, and the mode shapes before, at and after it."""

import math
from dataclasses import dataclass
from html import escape
from typing import NamedTuple

import numpy as np
from viser import uplot

from beamviz.beam import PARAMETERS
from beamviz.drawing.text import Measure
from beamviz.explorer.features.loci_chart import (
    FAMILIES,
    ChartRequest,
    Lines,
    lines_by_family,
    same_event,
)
from beamviz.explorer.features.loci_tab import LociTab
from beamviz.explorer.jobs import Answer
from beamviz.explorer.page.html import SMALL, coloured, small
from beamviz.explorer.page.style import COLOURS, FAINT, LINE, MARK, Plot, dot, marks
from beamviz.explorer.visitor import Feature, Visitor
from beamviz.frequency_loci import Branch, Event, Loci, loci
from beamviz.frequency_loci.identity import identify_modes
from beamviz.solver.solution import BENDING, STRETCHING

POINTS = 40  # of a sweep; even, so that its middle is not one of them
REACH = 0.2  # of the chart's range to both sides: where the other event is searched, widest view
MIN_WIDTH = 0.004  # of the chart's range: half width of the narrowest view
MARGIN = 5.0  # half width of the view, in distances over which the gap doubles
BESIDE = 1e-3  # of the view: shapes are taken beside a crossing, where they are not unique
EXCHANGED, KEPT = 0.5, 0.1  # change of the bending fraction that makes an exchange, or none
X = np.linspace(0.0, 1.0, 61)


class ModeShape(NamedTuple):
    """Displacements (61, 2) of a mode along and across the beam at X, the largest 1, and its share
    of bending energy."""

    displacement: np.ndarray
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
        return ModeShape(np.full((len(X), 2), np.nan), np.nan)
    shape = solution.shape(mode, X)
    parts = shape.real + shape.imag
    largest = np.linalg.norm(parts, axis=1).max()
    return ModeShape(parts / largest, float(solution.bending_energy_fraction[mode]))


def aligned(one: ModeShape, other: ModeShape) -> ModeShape:
    """A shape with the sign that correlates with another."""
    opposite = (one.displacement * other.displacement).sum() < 0
    return one._replace(displacement=-one.displacement) if opposite else one


# The tab

HEIGHT = 175  # [px] of the chart
WIDTH, TALL = 96, 30  # [px] of the drawing of a shape
CASES: dict[str, uplot.Series] = {"off": {"width": 1.25, "dash": (5, 4)}, "on": {"width": 2.5}}
STYLES: dict[str, uplot.Series] = {
    **{
        f"{case} {family}": {"stroke": COLOURS[family], **LINE, **style}
        for case, style in CASES.items()
        for family in FAMILIES
    },
    "gap": {"stroke": MARK, "width": 1.5, **LINE},
    "crossing": dot("#ffffff", MARK, 7),
}
INVITATION = "Choose a crossing or veering in the tab Loci to see it magnified here."
KEY = small(
    f"Displacement of the beam: {coloured('━', COLOURS[BENDING])} transverse (bending), "
    f"{coloured('━', COLOURS[STRETCHING])} axial (stretching)."
)


class VeeringTab(Feature):
    """A summary, a chart of both cases and the mode shapes."""

    def __init__(self, visitor: Visitor, loci_tab: LociTab):
        super().__init__(visitor)
        gui, self.loci_tab = visitor.client.gui, loci_tab
        self.job = visitor.job("veering", VeeringRequest.pairs)
        self.summary = gui.add_html(small(INVITATION))
        self.plot = Plot(gui, STYLES, HEIGHT, visible=False)
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
        self.plot.handle.visible = bool(pairs)
        self.summary.content = summary(answer, exists=exists)
        self.shapes.content = "".join(map(shape_table, pairs)) + KEY if pairs else ""
        if answer and pairs:
            values = pairs[0].values
            frequency = [branch.frequency for pair in pairs for branch in pair.branches]
            low, high = np.nanmin(frequency), np.nanmax(frequency)
            margin = 0.06 * (high - low)
            ranges = (values[0], values[-1]), (low - margin, high + margin)
            self.plot.show(*pair_lines(pairs), answer.request.chart.measures, *ranges)


def pair_lines(pairs: Pairs) -> tuple[np.ndarray, Lines]:
    """x (n,) and the lines by the groups of STYLES: the loci without and with Coriolis forces, the
    smallest gap as an upright line, the crossings."""
    x = values = pairs[0].values
    veering = next((pair for pair in reversed(pairs) if pair.kind == "veering"), None)
    if veering:  # twice, so that the gap can be an upright line
        x = np.insert(x, np.searchsorted(x, veering.at), veering.at)
    keep = np.searchsorted(values, x)
    lines: Lines = {}
    for case, pair in zip(CASES, pairs, strict=True):
        for family, rows in lines_by_family(pair.branches).items():
            lines[f"{case} {family}"] = [row[keep] for row in rows]
    if veering:
        k, gap = int(np.searchsorted(x, veering.at)), np.full(len(x), np.nan)
        gap[k : k + 2] = [branch.frequency[keep[k]] for branch in veering.branches]
        lines["gap"] = [gap]
    crossings = [pair.event for pair in pairs if pair.event and pair.kind == "crossing"]
    lines["crossing"] = [marks(x, [(event.at, event.frequency) for event in crossings])]
    return x, lines


def summary(answer: Answer[VeeringRequest, Pairs] | None, *, exists: bool) -> str:
    """A sentence for each case; `exists`: the two still cross or veer in the chart."""
    if answer is None:
        return small(INVITATION)
    a, b = (escape(label) for label in answer.request.event.branches)
    if answer.message or not exists:
        reason = escape(answer.message)
        return small(reason or f"{a} and {b} neither cross nor veer now. {INVITATION}", "note")
    measures = answer.request.chart.measures
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
    first, _, last = pair.shapes[0]
    change = abs(last.bending_fraction - first.bending_fraction)
    exchange = "they exchange part of their shapes"
    if not change >= KEPT:  # or nan
        exchange = "each keeps its family"
    elif change > EXCHANGED:
        exchange = "they exchange their shapes"
    return f"{case}they veer, smallest frequency gap {gap} {at}; {exchange}."


def shape_table(pair: LociPair) -> str:
    """The shapes of both branches, the upper one first, before, at and after."""
    order = sorted((0, 1), key=lambda k: -float(np.nan_to_num(pair.branches[k].frequency[0])))
    rows = "".join(
        f"<tr><td><b>{escape(names(pair.branches[k]))}</b></td>"
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


def names(branch: Branch) -> str:
    """What the mode of a branch is called before and after: two that veer exchange their names."""
    ends = ((branch.solutions[k], int(branch.mode_index[k])) for k in (0, -1))
    found = (identify_modes(solution).labels[k] for solution, k in ends if solution and k >= 0)
    return " → ".join(dict.fromkeys(found))


def drawing(shape: ModeShape) -> str:
    """A shape as SVG: displacement along and across the beam over x."""
    if not math.isfinite(shape.bending_fraction):
        return "–"
    family = BENDING if shape.bending_fraction >= 0.5 else STRETCHING
    lines = ""
    for own, part in zip((STRETCHING, BENDING), shape.displacement.T, strict=True):
        places = zip(WIDTH * X, TALL / 2 * (1 - 0.9 * part), strict=True)
        points = " ".join(f"{x:.1f},{y:.1f}" for x, y in places)
        lines += (
            f'<polyline points="{points}" fill="none" stroke="{COLOURS[own]}" '
            f'stroke-width="{2 if own == family else 1}"/>'
        )
    share = max(shape.bending_fraction, 1 - shape.bending_fraction)
    return (
        f'<svg width="{WIDTH}" height="{TALL}" role="img">'
        f'<path d="M0 {TALL / 2}H{WIDTH}" stroke="{FAINT}" stroke-width=".5"/>{lines}</svg>'
        f"<br>{100 * share:.0f} % {family}"
    )
