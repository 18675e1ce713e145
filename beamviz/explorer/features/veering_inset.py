"""The inset of the chart Frequencies: at a crossing or veering the two loci magnified until the gap
is seen; it opens the view Veering."""

import math
from collections.abc import Callable
from functools import lru_cache
from html import escape

import numpy as np

from beamviz.explorer import page
from beamviz.explorer.computed_loci import LocusLine
from beamviz.explorer.computed_veering import LociPair, Pairs, ends_of
from beamviz.explorer.feature import Feature
from beamviz.explorer.features.loci_chart import CHART, LociTab, current_chart
from beamviz.explorer.features.veering import JOB, VeeringAnswer, VeeringTab, in_percent
from beamviz.explorer.page import Content
from beamviz.explorer.snapshot import Snapshot
from beamviz.frequency_loci import Event

WIDTH, TALL = 170, 84  # [px] of the drawing
POINTS = 61  # of each of its lines
Placing = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]  # value, frequency
INSET = "loci-inset"  # id of its place in the tab Frequencies


class VeeringInset(Feature):
    """Shown while the beam is at a crossing or veering of the chart, in the half of the chart
    without it."""

    style = "veering.css"

    def content(self, snapshot: Snapshot) -> Content:
        answer, event = snapshot.job_answer(JOB), chosen_event(snapshot)
        if event is None or answer is None or answer.result is None:
            return page.html(INSET, "") | page.props(INSET, data_side=None)
        if {*answer.request.event.branches} != {*event.branches}:
            return page.html(INSET, "") | page.props(INSET, data_side=None)
        chart = answer.request.chart
        is_left = event.at < (chart.start + chart.stop) / 2
        charts = snapshot.job_answer(CHART)
        top = charts.result.top if charts and charts.result else math.nan
        content = page.html(INSET, inset(answer, top))
        return content | page.props(INSET, data_side="right" if is_left else "left")


def chosen_event(snapshot: Snapshot) -> Event | None:
    """The crossing or veering of the chart Frequencies that the beam is at, while that is open."""
    charts, beam = current_chart(snapshot), snapshot.entered_beam
    if snapshot.state.tab != LociTab.tab.key or not (charts and charts.result and beam):
        return None
    return charts.result.pairs.get(charts.result.event_at(getattr(beam, charts.request.over)))


@lru_cache(16)
def inset(answer: VeeringAnswer, top: float) -> str:
    """The drawing with the gap in the units of the chart, as a button that opens the view; top: end
    of the frequency axis of the chart [1/T*]."""
    request, pairs = answer.request, answer.result or ()
    across, pair = request.chart.measures[1], pairs[-1]
    low, high = ends_of(pairs)
    gap = "they cross: gap 0"
    if pair.event is None:
        gap = "gap too large for a veering"
    elif pair.event.kind == "veering":
        gap = f"gap {across.gap(pair.event.gap)} {across.unit}".strip()
    times = f"{float(f'{top / (high - low):.2g}'):g} × magnified"
    label = f"{gap}, {times}: open the view Veering, which has a slider for {in_percent(request)}"
    own = page.attributes(data_panel=f"tab-{VeeringTab.tab.key}", aria_label=label, title=label)
    texts = f"<b>{escape(gap)}</b><span>{times}</span>"
    return f'<button type="button"{own}>{drawing(pairs)}{texts}</button>'


def drawing(pairs: Pairs) -> str:
    """The two loci with a bracket for the gap, and without their coupling dashed (SVG)."""
    low, high = ends_of(pairs)
    values = pairs[0].values
    x = np.linspace(values[0], values[-1], POINTS)

    def place(at: np.ndarray, frequency: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return (
            WIDTH * (at - values[0]) / (values[-1] - values[0]),
            TALL * (high - frequency) / (high - low),
        )

    lines = ""
    for pair in pairs:
        for line in pair.lines:
            lines += locus(pair, line, x, place, is_own=pair is pairs[-1])
    own = pairs[-1]
    if own.event and own.event.kind == "veering":
        lines += page.polyline(*place(np.full(2, own.at), np.array(own.gap)), "measure")
    box = page.attributes(viewBox=f"0 0 {WIDTH} {TALL}", aria_hidden="true")
    return f"<svg{box}>{lines}</svg>"


def locus(pair: LociPair, line: LocusLine, x: np.ndarray, place: Placing, *, is_own: bool) -> str:
    """A locus in pieces, each of the colour of its family there."""
    pieces = ""
    for first, last, style, _ in line.runs:
        ends = pair.values[[first, last]]
        at = np.union1d(x[(x > ends[0]) & (x < ends[1])], ends)
        points = place(at, np.interp(at, pair.values, line.frequency))
        pieces += page.polyline(*points, style if is_own else f"{style} dashed")
    return pieces
