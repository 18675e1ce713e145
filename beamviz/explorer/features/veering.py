"""The tab Veering: two loci magnified around a crossing or veering, with a slider for what couples
them, and the mode shapes before, at and after it, which the scene shows on request."""

import math
from collections.abc import Mapping
from functools import lru_cache
from html import escape
from typing import Any

import numpy as np

from beamviz.beam import Beam
from beamviz.explorer import page
from beamviz.explorer.computed_loci import Chart, ChartRequest, cursor, lines_data
from beamviz.explorer.computed_veering import (
    LociPair,
    ModeShape,
    Pairs,
    VeeringRequest,
    X,
    coriolis_acts,
    coupling_text,
    ends_of,
    outcome,
    parts_of,
    styles_of_components,
    uncoupled,
)
from beamviz.explorer.declarations import Tab
from beamviz.explorer.feature import Feature, fading, waiting
from beamviz.explorer.features.loci_chart import (
    CHART,
    LociTab,
    chart_wanted,
    current_chart,
    event_buttons,
    no_chart,
)
from beamviz.explorer.jobs import PENDING, Answer
from beamviz.explorer.page import Content
from beamviz.explorer.snapshot import Snapshot
from beamviz.explorer.solutions import SOLUTION
from beamviz.explorer.state import State
from beamviz.explorer.visitor import Visitor
from beamviz.frequency_loci import Event
from beamviz.scene import clip
from beamviz.solver.problem import OPTIONS

JOB, UNCOUPLED = "veering", "uncoupled chart"  # names of the jobs
SHOWN = "veering-chart", "veering-told", "veering-shapes"  # ids of what shows an answer
WIDTH, TALL = 96, 24  # [px] of the drawing of a shape
PLACES = "before", "at", "after"  # the event, at which there are shapes
INVITATION = "No crossing or veering in the range of the chart Frequencies."
COUPLINGS = {  # the sliders by what couples two modes: label, help and end
    "coriolis": (
        "coriolis_percent",
        "Coriolis [%]",
        "A thought experiment: a real beam has all of them (100 %). Drag from 0 to see the gap"
        " open",
        100,
    ),
    "pitch": ("pitch_here", "pitch [deg]", "Turns the section, which couples flap and lag", 10),
}
DIRECTIONS = {  # of a displacement, by the style of its line
    "bending": "transverse (bending)",
    "lag": "in the plane of rotation (lag)",
    "flap": "out of it (flap)",
    "stretching": "axial (stretching)",
}
SLIDERS = "".join(
    page.slider(key, label, help, min=0, max=end, step=end / 100)
    for key, label, help, end in COUPLINGS.values()
)
VEERING_KINDS = {".webp": "Film (WebP)", ".gif": "Film (GIF)", ".html": "Page (HTML)"}
FILES = page.group(
    "Files of the opening gap",
    *(
        page.button(name, data_do="export_veering", data_value=suffix)
        for suffix, name in VEERING_KINDS.items()
    ),
    id="veering-files",
)
FILES += (
    '<div id="veering-file-work" class="row" hidden><span id="veering-file-state"></span>'
    f"{page.button('Cancel', data_do='cancel_export')}</div>"
)
SKELETON = (
    f'<div class="veering-tab">{page.waiting_place("veering-chart-wait")}'
    '<div id="veering-chart" class="chart" data-chart></div>'
    f'<div class="beside"><div id="veering-coupling">{SLIDERS}<p id="veering-told"></p>'
    f'<div id="veering-events"></div>{FILES}</div>'
    '<div id="veering-shapes" tabindex="0" role="group" aria-label="Mode shapes"></div></div></div>'
)

ChartAnswer = Answer[ChartRequest, Chart]
VeeringAnswer = Answer[VeeringRequest, Pairs]


class VeeringTab(Feature):
    """The crossing or veering nearest to the beam along the axis of the chart, magnified. Which
    modes meet is that of the uncoupled chart, so that it stays while the coupling changes."""

    style = "veering.css"
    tab = Tab(
        "Veering",
        3,
        "Two frequencies that meet, magnified: a slider opens the gap, and the shapes mix",
        SKELETON,
        (SOLUTION, UNCOUPLED, JOB),
        beside="Frequencies",
        view="veering",
    )

    def __init__(self, visitor: Visitor):
        super().__init__(visitor)
        visitor.job(UNCOUPLED, ChartRequest.chart)
        visitor.job(JOB, VeeringRequest.pairs)
        visitor.bind("coriolis_percent", with_coriolis_percent, coriolis_percent, float)
        visitor.bind("pitch_here", with_pitch, pitch_of, float)
        self.page.on("show_shape", self.show_shape, str)

    def show_shape(self, key: str) -> None:
        """Move the beam to one side of the event, and show a mode there; key: of a shape."""
        visitor = self.visitor
        with visitor.lock:
            answer = visitor.shown_answer(JOB)
            if answer and answer.result and key in (found := shapes_by_key(answer.result)):
                at, shape = found[key]
                over = answer.request.chart.over
                if shape.mode >= 0:
                    visitor.change(lambda state: at_shape(state, over, at, shape.mode))

    def wanted(self, snapshot: Snapshot) -> Mapping[str, Any]:
        """The uncoupled chart, and the loci around its event, while they are shown."""
        if not is_shown(snapshot):
            return {}
        chart = chart_wanted(snapshot)
        if chart is None:
            return {UNCOUPLED: None, JOB: None}
        request = uncoupled(chart)
        charts = snapshot.job_answer(UNCOUPLED)
        if charts is None or charts.request != request:
            return {UNCOUPLED: request, JOB: PENDING}
        event = nearest_event(charts, snapshot)
        return {UNCOUPLED: request, JOB: VeeringRequest(chart, event) if event else None}

    def content(self, snapshot: Snapshot) -> Content:
        """The last chart, and the last answer if that has an event to show; neither while the tab
        is closed."""
        is_open = snapshot.state.tab == self.tab.key
        charts = snapshot.job_answer(UNCOUPLED) if is_open else None
        answer = snapshot.job_answer(JOB) if nearest_event(charts, snapshot) else None
        listed = snapshot.job_answer(CHART)
        return (
            event_content(charts, answer, listed)
            | line_content(charts, answer, snapshot.entered_beam)
            | coupling_content(answer, snapshot.state)
            | fading(snapshot, [UNCOUPLED, JOB], *SHOWN)
            | waiting(snapshot, "veering-chart-wait", self.tab)
        )


def is_shown(snapshot: Snapshot) -> bool:
    """Whether the page shows the loci around an event: in the tab, or at the event in the inset of
    the chart Frequencies."""
    if snapshot.state.tab != LociTab.tab.key:
        return snapshot.state.tab == VeeringTab.tab.key
    charts, beam = current_chart(snapshot), snapshot.entered_beam
    if not (charts and charts.result and beam):
        return False
    return charts.result.event_at(getattr(beam, charts.request.over)) in charts.result.pairs


def nearest_event(charts: ChartAnswer | None, snapshot: Snapshot) -> Event | None:
    """The crossing or veering of a chart that is nearest to the beam in the scene."""
    if charts is None or charts.result is None:
        return None
    beam = snapshot.picture.modes.beam
    return charts.result.nearest_pair(getattr(beam, charts.request.over))


# The coupling


def with_coriolis_percent(state: State, percent: object) -> State:
    """With a part of the Coriolis forces. The beam before is not kept for comparison: the slider
    passes through many."""
    present = coriolis_percent(state)
    factor = OPTIONS["coriolis"].checked(clip(percent, 100.0, present) / 100)
    case = state.case.with_options(coriolis=factor)
    return state.without_edit_kept().with_fields(case=case).after("case").after("structure")


def coriolis_percent(state: State) -> float:
    return round(100 * float(state.case.options["coriolis"]), 4)


def with_pitch(state: State, degrees: object) -> State:
    return state.changed("pitch", degrees)


def pitch_of(state: State) -> float:
    return float(state.case.nearest_beam().pitch)


def coupling_content(answer: VeeringAnswer | None, state: State) -> Content:
    """The slider of what couples the two modes that are shown; none where nothing does."""
    options = state.case.options
    kind = answer.request.kind if answer and answer.result else ""
    acts = coriolis_acts(options["plane"], options["method"])
    shown = {"coriolis": kind == "coriolis" and acts, "pitch": kind == "pitch"}
    factor = options["coriolis"]
    part = None if isinstance(factor, bool) else f"{100 * factor:.3g} %"
    content = page.props("coriolis", data_part=part)
    for name, (key, *_) in COUPLINGS.items():
        content |= page.props(f"{key}-row", hidden=not shown[name])
    return content | page.props("veering-files", hidden=not any(shown.values()))


# The scene


def shapes_by_key(pairs: Pairs) -> dict[str, tuple[float, ModeShape]]:
    """The shapes of the beam's own coupling by key, as "0 before", each with its value of the
    axis."""
    pair = pairs[-1]
    return {
        f"{k} {name}": (at, shape)
        for k, shapes in enumerate(pair.shapes)
        for name, at, shape in zip(PLACES, pair.places, shapes, strict=True)
    }


def at_shape(state: State, over: str, at: float, mode: int) -> State:
    """With the beam at a value of the axis, and one mode (from 0) alone."""
    return state.without_edit_kept().changed(over, at).only(mode)


# The tab


@lru_cache(16)  # for several visitors: 1 ms of each frame with an edit
def event_content(
    charts: ChartAnswer | None, answer: VeeringAnswer | None, listed: ChartAnswer | None
) -> Content:
    """The event, or the reason why there is none, and buttons for all events of the chart that is
    listed; nothing without one."""
    pairs = answer.result if answer else None
    content = page.props("veering-chart", hidden=not pairs) | page.html("veering-told", "")
    content |= page.html("veering-events", "")
    if charts is None:
        return content | page.html("veering-shapes", "")
    text = page.note(no_chart(charts))
    if charts.result and not charts.result.pairs:
        text = f"<p>{INVITATION}</p>"
    if listed and listed.result and listed.result.pairs:
        content |= page.html("veering-events", event_buttons(listed.result))
    if answer and pairs:
        content |= page.chart("veering-chart", pairs_data(pairs, answer.request))
        content |= page.html("veering-told", told(pairs[-1], answer.request))
        text = shape_table(pairs, answer.request) + key_of_shapes(answer.request) + text
    elif answer:
        text = page.note(answer.message) + text
    return content | page.html("veering-shapes", text)


def line_content(
    charts: ChartAnswer | None, answer: VeeringAnswer | None, beam: Beam | None
) -> Content:
    """The line of the beam, in the chart if there is one."""
    if charts is None or answer is None or answer.result is None:
        return page.props("veering-chart", hidden=True)
    request = answer.request.chart
    line = cursor(beam, request.over, request.measures[0])
    return page.chart("veering-chart", {"cursor": line})


def pairs_data(pairs: Pairs, request: VeeringRequest) -> page.Data:
    """The chart: loci without their coupling (dashed) and with that of the beam, crossings, the
    smallest gap."""
    measures = along, across = request.chart.measures
    values = pairs[0].values
    lines, gap, marks = [], [], []
    for pair in pairs:
        is_own = pair is pairs[-1]
        style = "thick" if is_own else "dashed"
        for line in lines_data(pair.lines, across.factor):
            runs = [[i, j, f"{family} {style}", name] for i, j, family, name in line["runs"]]
            lines.append({**line, "runs": runs, "label": line["label"] if is_own else ""})
        if not (is_own and pair.event):
            continue
        if pair.event.kind == "veering":
            ends = {"at": page.sent(np.full(2, along.factor * pair.places[1]))}
            ends["y"] = page.sent(across.factor * np.array(pair.gap))
            gap = [{"label": "", **ends, "runs": [[0, 1, "measure", ""]]}]
        elif pair.event.kind == "crossing":
            place, text = (pair.at, pair.event.frequency), f"crossing: {along.place(pair.at)}"
            marks.append(page.mark("crossing", "crossing", measures, place, text))
    axes = {
        "x": page.axis_data(along, (values[0], values[-1])),
        "y": page.frequency_axis(across, ends_of(pairs)),
        "at": page.sent(along.factor * values),
    }
    content = {"lines": lines + gap, "marks": marks, "keys": page.keys(lines, marks)}
    return {"name": "Veering, magnified", **axes, **content}


def told(pair: LociPair, request: VeeringRequest) -> str:
    """The coupling and what the two loci do with it, as HTML."""
    return f"<b>{coupling_text(pair.coupling, request)}</b>: {outcome(pair, request)}"


def in_percent(request: VeeringRequest) -> str:
    """What the slider of the coupling changes."""
    return COUPLINGS[request.kind][1].partition(" [")[0]


def shape_table(pairs: Pairs, request: VeeringRequest) -> str:
    """The shapes of both branches, the upper one first, before, at and after the event: buttons
    that show the mode in the scene."""
    pair, along = pairs[-1], request.chart.measures[0]
    rows = []
    for k in pair.upper_first:
        cells = zip(PLACES, pair.places, pair.shapes[k], strict=True)
        rows.append(
            [shape_cell(f"{k} {name}", along.place(at), one, request) for name, at, one in cells]
        )
    return page.table("Mode shapes", PLACES, rows, class_="shapes")


def shape_cell(key: str, place: str, shape: ModeShape, request: VeeringRequest) -> str:
    """A shape with its parts as a button; a dash for a mode that is missing."""
    if shape.mode < 0:
        return "–"
    label = f"Show {shape.name} at {place} in the scene: {parts_text(shape, request)}"
    own = page.attributes(
        class_="quiet", data_do="show_shape", data_value=key, aria_label=label, title=label
    )
    content = drawing(shape) + parts_bar(shape, request)
    return f'<button type="button"{own}>{content}</button>'


def parts_text(shape: ModeShape, request: VeeringRequest) -> str:
    """The shares in words."""
    parts = parts_of(shape, request).items()
    return ", ".join(f"{100 * share:.0f} % {style}" for style, share in parts)


def parts_bar(shape: ModeShape, request: VeeringRequest) -> str:
    """The shares as a bar of two colours."""
    parts = parts_of(shape, request).items()
    pieces = (f'<i class="{style}" style="flex:{share:.3f}"></i>' for style, share in parts)
    return f'<span class="parts" aria-hidden="true">{"".join(pieces)}</span>'


def key_of_shapes(request: VeeringRequest) -> str:
    """What the lines of the shapes and the bars below them are."""
    in_space = request.chart.options["plane"] == "both"
    styles = styles_of_components(in_space=in_space)
    parts = (f'<b class="swatch {style}">━</b> {DIRECTIONS[style]}' for style in styles)
    energy = "kinetic energy" if request.kind == "pitch" else "strain energy"
    return (
        f"<p>Displacement of the beam: {', '.join(parts)}; below it the shares of its {energy}."
        " Press a shape to see the mode move.</p>"
    )


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
