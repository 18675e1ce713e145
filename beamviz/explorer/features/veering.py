"""The tab Veering: two loci magnified around a crossing or veering, without and with Coriolis
forces, and the mode shapes before, at and after it."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from html import escape
from typing import Any, NamedTuple, Self

import numpy as np

from beamviz.beam import Beam
from beamviz.drawing.text import Measure
from beamviz.explorer import page
from beamviz.explorer.computed_loci import (
    Chart,
    ChartRequest,
    LocusLine,
    cursor,
    lines_data,
    lines_of,
)
from beamviz.explorer.declarations import Tab
from beamviz.explorer.feature import Feature, fading, waiting
from beamviz.explorer.features.loci_chart import CHART, current_chart, event_buttons, no_chart
from beamviz.explorer.jobs import PENDING, Answer
from beamviz.explorer.page import Content
from beamviz.explorer.snapshot import Snapshot
from beamviz.explorer.solutions import SOLUTION
from beamviz.explorer.visitor import Visitor
from beamviz.frequency_loci import Branch, Event, Loci, at_values, loci
from beamviz.frequency_loci.identity import identify_modes
from beamviz.solver.problem import MAX_MODES
from beamviz.solver.solution import BENDING, STRETCHING

POINTS = 40  # of a sweep; even, so that the middle is not one of them
REACH = 0.2  # of the chart's range, to each side: for the search of an event, and the widest view
MIN_WIDTH = 0.004  # of the chart's range: half width of the narrowest view
MARGIN = 5.0  # half width of the view, over that of a veering
BESIDE = 1e-3  # of the view: offset of shapes from a crossing, where they are not unique
EXCHANGED, KEPT = 0.5, 0.1  # change of the bending fraction: exchange above, none below
X = np.linspace(0.0, 1.0, 61)


class ModeShape(NamedTuple):
    """A mode: displacements along and across the beam at X, (61, 2) or in both planes (61, 3), the
    largest 1; fraction of bending energy; name, or the mixture that it is; fraction of the energy
    in the plane of rotation where it bends in both."""

    displacement: np.ndarray
    bending_fraction: float
    name: str
    in_plane_fraction: float = 1.0

    def change(self, other: Self) -> float:
        """The greatest change of a fraction to another shape; nan if either has none."""
        bending = abs(other.bending_fraction - self.bending_fraction)
        return max(bending, abs(other.in_plane_fraction - self.in_plane_fraction))


@dataclass(frozen=True, eq=False)
class LociPair:
    """Two loci around their crossing or veering, without or with Coriolis forces.

    values: (n,) in the view, of the two lines; event: None if the two neither cross nor veer; at:
    its value, else the middle of the view; shapes: of each branch before, at and after the event.
    """

    coriolis: bool
    values: np.ndarray
    lines: list[LocusLine]
    event: Event | None
    at: float
    shapes: tuple[tuple[ModeShape, ModeShape, ModeShape], ...]


Pairs = tuple[LociPair, ...]  # without and with Coriolis forces


@dataclass(frozen=True)
class VeeringRequest:
    """A crossing or veering of a chart to magnify."""

    chart: ChartRequest
    event: Event

    @property
    def beam(self) -> Beam:
        return self.chart.beam

    def pairs(self) -> Pairs:
        """The loci without and with Coriolis forces. Raises the errors of `loci`."""
        chart, at = self.chart, self.event.at
        reach = REACH * (chart.stop - chart.start)
        low, high = max(at - reach, chart.start), min(at + reach, chart.stop)
        wide = np.linspace(low, high, POINTS)
        # Enough modes for both branches on either side, and for a neighbour.
        modes = min(max(self.event.modes) + 2, MAX_MODES)
        options = [
            {**chart.options, "modes": modes, "coriolis": coriolis} for coriolis in (False, True)
        ]
        found = [loci(chart.beam, chart.over, wide, **one) for one in options]
        events = [same_event(one, self.event, reach) for one in found]
        centre, half = self.view([one for one in events if one] or [self.event])
        own = [one.at + (BESIDE * half if one.kind == "crossing" else 0) for one in events if one]
        near = np.linspace(max(centre - half, low), min(centre + half, high), POINTS)
        values = np.union1d(near, own)
        return tuple(
            loci_pair(at_values(one, values), event, self.event, centre)
            for one, event in zip(found, events, strict=True)
        )

    def view(self, events: list[Event]) -> tuple[float, float]:
        """Centre and half width of a view of these events and of the whole gap."""
        at, width = [one.at for one in events], self.chart.stop - self.chart.start
        half = max(max(at) - min(at), MARGIN * max(one.width for one in events))
        return (min(at) + max(at)) / 2, float(np.clip(half, MIN_WIDTH * width, REACH * width))


def same_event(found: Loci, event: Event, reach: float) -> Event | None:
    """The nearest event of the same two branches in other loci, within `reach`."""
    same = [one for one in found.events if {*one.branches} == {*event.branches}]
    nearest = min(same, key=lambda one: abs(one.at - event.at), default=None)
    return nearest if nearest and abs(nearest.at - event.at) <= reach else None


def branches_of(found: Loci, event: Event, at: float) -> tuple[Branch, Branch]:
    """The two branches of an event; the nearest in frequency if the loci have other labels."""
    by_label = {branch.label: branch for branch in found.branches}
    if all(label in by_label for label in event.branches):
        return by_label[event.branches[0]], by_label[event.branches[1]]
    k = int(np.argmin(abs(found.values - at)))
    distance = [abs(branch.frequency[k] - event.frequency) for branch in found.branches]
    first, second = np.argsort(np.nan_to_num(distance, nan=np.inf))[:2]
    return found.branches[first], found.branches[second]


def loci_pair(found: Loci, own: Event | None, event: Event, centre: float) -> LociPair:
    """Two loci with their shapes at the ends of the view and at the event `own`, if any."""
    at = own.at if own else centre
    branches = branches_of(found, own or event, at)
    k = int(np.argmin(abs(found.values - at)))
    shapes = []
    for branch in branches:
        middle = mode_shape(branch, k)
        first, last = (mode_shape(branch, i, middle) for i in (0, -1))
        shapes.append((first, middle, last))
    lines = lines_of(found, found.values, branches)
    return LociPair(found.problem.coriolis, found.values, lines, own, at, tuple(shapes))


def mode_shape(branch: Branch, k: int, other: ModeShape | None = None) -> ModeShape:
    """The shape of a branch at the value of index k, with the sign of positive correlation with
    another shape; nan if it has none.

    With Coriolis forces the phases of axial and transverse motion differ by a quarter of a period:
    the complex shape is real along the beam and imaginary across it, up to a factor.
    """
    solution, mode = branch.solutions[k], int(branch.mode_index[k])
    if solution is None or mode < 0:
        return ModeShape(np.full((len(X), 1), np.nan), np.nan, "")
    shape = solution.shape(mode, X)
    parts = shape.real + shape.imag
    parts /= np.linalg.norm(parts, axis=1).max()
    if other and (parts * other.displacement).sum() < 0:
        parts = -parts
    names = identify_modes(solution)
    name = names.mixtures[mode] or names.labels[mode]
    fraction = float(solution.bending_energy_fraction[mode])
    if solution.in_plane_fraction is None:
        return ModeShape(parts, fraction, name)
    return ModeShape(parts, fraction, name, float(solution.in_plane_fraction[mode]))


# The tab

JOB = "veering"
SHOWN = "veering-chart", "veering-shapes"  # ids of the chart and of the shapes beside it
WIDTH, TALL = 96, 24  # [px] of the drawing of a shape
INVITATION = "No crossing or veering in the range of the chart Frequencies."
DIRECTIONS = {  # of a displacement, by the style of its line
    "bending": "transverse (bending)",
    "lag": "in the plane of rotation (lag)",
    "flap": "out of it (flap)",
    "stretching": "axial (stretching)",
}
SKELETON = (
    f'<div class="veering-tab">{page.waiting_place("veering-chart-wait")}'
    '<div id="veering-chart" class="chart" data-chart></div>'
    '<div id="veering-shapes" tabindex="0" role="group" aria-label="Mode shapes"></div></div>'
)


class VeeringTab(Feature):
    """The crossing or veering nearest to the beam along the axis of the chart, magnified."""

    tab = Tab(
        "Veering",
        3,
        "Two frequencies that come close, magnified, and how the shapes of their modes mix",
        SKELETON,
        (SOLUTION, CHART, JOB),
        beside="Frequencies",
        view="veering",
    )

    def __init__(self, visitor: Visitor):
        super().__init__(visitor)
        visitor.job(JOB, VeeringRequest.pairs)

    def wanted(self, snapshot: Snapshot) -> Mapping[str, Any]:
        """The loci around the event while the tab is open; they wait for the chart."""
        if snapshot.state.tab != self.tab.key:
            return {}
        charts = current_chart(snapshot)
        event = nearest_event(charts, snapshot)
        if charts and event:
            return {JOB: VeeringRequest(charts.request, event)}
        return {JOB: PENDING if charts is None and snapshot.beam else None}

    def content(self, snapshot: Snapshot) -> Content:
        """The last chart, and the last answer if that has an event to show; neither while the tab
        is closed."""
        is_open = snapshot.state.tab == self.tab.key
        charts = snapshot.job_answer(CHART) if is_open else None
        answer = snapshot.job_answer(JOB) if nearest_event(charts, snapshot) else None
        return (
            event_content(charts, answer)
            | line_content(charts, answer, snapshot.entered_beam)
            | fading(snapshot, [CHART, JOB], *SHOWN)
            | waiting(snapshot, "veering-chart-wait", self.tab)
        )


ChartAnswer = Answer[ChartRequest, Chart]


def nearest_event(charts: ChartAnswer | None, snapshot: Snapshot) -> Event | None:
    """The crossing or veering of a chart that is nearest to the beam in the scene."""
    if charts is None or charts.result is None:
        return None
    beam = snapshot.picture.modes.beam
    return charts.result.nearest_pair(getattr(beam, charts.request.over))


@lru_cache(16)  # for several visitors: 1 ms of each frame with an edit
def event_content(
    charts: ChartAnswer | None, answer: Answer[VeeringRequest, Pairs] | None
) -> Content:
    """The event, or the reason why there is none, and buttons for all events of the chart; nothing
    without one."""
    if charts is None:
        return page.props("veering-chart", hidden=True) | page.html("veering-shapes", "")
    pairs, chart = answer.result if answer else None, charts.result
    text = page.note(no_chart(charts))
    if chart:
        text = event_buttons(chart) if chart.pairs else f"<p>{INVITATION}</p>"
    content = page.props("veering-chart", hidden=not pairs)
    if answer and pairs:
        request = answer.request.chart
        captions = (sentence(pair, *request.measures) for pair in pairs)
        content |= page.chart("veering-chart", pairs_data(pairs, request))
        text = "".join(map(shape_table, pairs, captions)) + text
        text += key_of_shapes(in_space=request.options["plane"] == "both")
    elif answer:
        text = page.note(answer.message) + text
    return content | page.html("veering-shapes", text)


def line_content(
    charts: ChartAnswer | None, answer: Answer[VeeringRequest, Pairs] | None, beam: Beam | None
) -> Content:
    """The line of the beam, in the chart if there is one."""
    if charts is None or answer is None or answer.result is None:
        return page.props("veering-chart", hidden=True)
    request = answer.request.chart
    line = cursor(beam, request.over, request.measures[0])
    return page.chart("veering-chart", {"cursor": line})


def pairs_data(pairs: Pairs, request: ChartRequest) -> page.Data:
    """The chart: loci without (dashed) and with Coriolis forces, crossings, the smallest gap."""
    along, across = request.measures
    values = pairs[0].values
    lines, gap, marks = [], [], []
    for pair in pairs:
        style = "thick" if pair.coriolis else "dashed"
        for line in lines_data(pair.lines, across.factor):
            runs = [[i, j, f"{family} {style}", name] for i, j, family, name in line["runs"]]
            lines.append({**line, "runs": runs, "label": line["label"] if pair.coriolis else ""})
        if pair.event and pair.event.kind == "veering":
            k = int(np.searchsorted(values, pair.at))
            y = across.factor * np.array([one.frequency[k] for one in pair.lines])
            ends = {"at": page.sent(np.full(2, along.factor * pair.at)), "y": page.sent(y)}
            gap = [{"label": "", **ends, "runs": [[0, 1, "measure", ""]]}]
        elif pair.event and pair.event.kind == "crossing":
            place, text = (pair.at, pair.event.frequency), f"crossing: {along.place(pair.at)}"
            marks.append(page.mark("crossing", "crossing", request.measures, place, text))
    frequency = np.array([line.frequency for pair in pairs for line in pair.lines])
    low, high = np.nanmin(frequency), np.nanmax(frequency)
    margin = 0.06 * (high - low)
    axes = {
        "x": page.axis_data(along, (values[0], values[-1])),
        "y": page.frequency_axis(across, (low - margin, high + margin)),
        "at": page.sent(along.factor * values),
    }
    content = {"lines": lines + gap, "marks": marks, "keys": page.keys(lines, marks)}
    return {"name": "Veering, magnified", **axes, **content}


def sentence(pair: LociPair, along: Measure, across: Measure) -> str:
    """The kind of the event, its position and the gap."""
    case = "<b>Coriolis on</b> (thick): " if pair.coriolis else "<b>Coriolis off</b> (dashed): "
    if pair.event is None:
        return case + "the gap is too large for a veering."
    at = f"at {along.place(pair.at)}"
    if pair.event.kind == "crossing":
        return f"{case}they cross {at}, uncoupled (gap 0)."
    gap = f"{across.gap(pair.event.gap)} {across.unit}".strip()
    first, _, last = pair.shapes[0]
    change = first.change(last)
    exchange = "they exchange part of their shapes"
    if not change >= KEPT:  # or nan
        exchange = "each keeps its family"
    elif change > EXCHANGED:
        exchange = "they exchange their shapes"
    return f"{case}they veer {at} (gap {gap}); {exchange}."


def shape_table(pair: LociPair, caption: str) -> str:
    """The shapes of both branches, the upper one first, before, at and after the event."""
    order = sorted((0, 1), key=lambda k: -float(np.nan_to_num(pair.lines[k].frequency[0])))
    rows = [map(drawing, pair.shapes[k]) for k in order]
    name = f"shapes, Coriolis {'on' if pair.coriolis else 'off'}"
    return page.table(name, ("before", "at", "after"), rows, caption, class_="shapes")


def styles_of_components(*, in_space: bool) -> tuple[str, ...]:
    """The styles of the lines of a shape, one for each component of the displacement."""
    return (STRETCHING, "lag", "flap") if in_space else (STRETCHING, BENDING)


def key_of_shapes(*, in_space: bool) -> str:
    """What the lines of the shapes are."""
    styles = styles_of_components(in_space=in_space)
    parts = (f'<b class="swatch {style}">━</b> {DIRECTIONS[style]}' for style in styles)
    return f"<p>Displacement of the beam: {', '.join(parts)}.</p>"


def drawing(shape: ModeShape) -> str:
    """A shape as SVG, displacement along and across the beam over x, in both planes where it has
    them, with its name below; the greatest of the family of the mode has the thickest line."""
    if not math.isfinite(shape.bending_fraction):
        return "–"
    components = shape.displacement.T
    styles = styles_of_components(in_space=len(components) == 3)
    greatest = 0
    if shape.bending_fraction >= 0.5:
        greatest = 1 + int(np.abs(components[1:]).max(axis=1).argmax())
    lines = ""
    for k, (style, part) in enumerate(zip(styles, components, strict=True)):
        y = TALL / 2 * (1 - 0.9 * part)
        lines += page.polyline(WIDTH * X, y, style, stroke_width="2.5" if k == greatest else None)
    own = page.attributes(viewBox=f"0 0 {WIDTH} {TALL}", role="img", aria_label=shape.name)
    return f'<svg{own}><path d="M0 {TALL / 2}H{WIDTH}"/>{lines}</svg>{escape(shape.name)}'
