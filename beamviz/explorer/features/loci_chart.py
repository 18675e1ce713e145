"""The tab Frequencies: the Campbell diagram along one of the numbers, with lists of events."""

import contextlib
import math
from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np

from beamviz.adjusting.goals import ClearGoal
from beamviz.beam import Beam
from beamviz.drawing.text import measure
from beamviz.errors import InvalidInput, NoEquilibrium
from beamviz.explorer import page
from beamviz.explorer.computed_loci import (
    FAILURES,
    Chart,
    ChartRequest,
    axes_data,
    axes_options,
    chart_data,
    cursor,
)
from beamviz.explorer.declarations import Tab
from beamviz.explorer.feature import Feature, fading, waiting
from beamviz.explorer.features.adjust import (
    AdjustState,
    AdjustTab,
    goal_of_lines,
    measured_points,
)
from beamviz.explorer.jobs import Answer
from beamviz.explorer.page import Content
from beamviz.explorer.snapshot import Snapshot
from beamviz.explorer.solutions import SOLUTION
from beamviz.explorer.state import State
from beamviz.explorer.visitor import Visitor
from beamviz.frequency_loci import Event
from beamviz.frequency_loci.events import EVENT_KINDS, EXCHANGES
from beamviz.frequency_loci.identity import identify_modes
from beamviz.frequency_loci.limits import Limit
from beamviz.frequency_loci.margins import percent
from beamviz.scene import PER_REV
from beamviz.solver.solution import Solution

PER_REV_HELP = (
    "A force spread over the beam like its weight, repeating k times per revolution, excites a mode"
    " where the line k × speed intersects it. The chart with these lines is a Campbell diagram."
)
WIDER = 1.3  # the chart of the tab Adjust, than to the last point or speed
CHART, SECOND_CHART = "chart", "chart compared with"  # names of the jobs
INSET = '<div id="loci-inset"></div>'  # see veering_inset.py
LISTS = "loci-margins", "loci-resonances", "loci-events"
CHART_KINDS = {".svg": "Chart (SVG)", ".png": "Chart (PNG)", ".csv": "Chart (CSV)"}  # files of it


def tools() -> str:
    """The controls of the tab."""
    lines = f'<span class="name">per-rev lines{page.hint("per-rev lines", PER_REV_HELP)}</span>'
    for k in PER_REV:
        names = {"data_set": f"per_rev_{k}", "aria_label": f"{k} × per revolution"}
        lines += page.button(f"{k} ×", class_="toggle", **names)
    lines = page.group("per-rev lines", lines, id="per-rev")
    files = page.group(
        "Download the chart",
        '<span class="soft">download</span>',
        *(
            page.button(suffix[1:].upper(), data_do="export_chart", data_value=suffix)
            for suffix in CHART_KINDS
        ),
        id="chart-files",
    )
    files += (
        '<div id="chart-file-work" class="row" hidden><span id="chart-file-state"></span>'
        f"{page.button('Cancel', data_do='cancel_export')}</div>"
    )
    return page.select("over", "horizontal axis", (), id="loci-over") + lines + files


class LociTab(Feature):
    """The chart and its lists."""

    tab = Tab(
        "Frequencies",
        1,
        "The frequencies over a number of the beam: drag its line, press a crossing to go there",
        page.chart_tab(
            tools(), "loci-chart", *LISTS, hidden=False, over='<div id="loci-inset"></div>'
        ),
        (SOLUTION, CHART),
        view="chart",
    )

    def __init__(self, visitor: Visitor):
        super().__init__(visitor)
        visitor.job(CHART, ChartRequest.chart)
        visitor.job(SECOND_CHART, ChartRequest.chart)
        for k in PER_REV:
            visitor.bind(f"per_rev_{k}", partial(with_line, k=k), partial(has_line, k=k), bool)
        self.page.on("go_to_event", self.go_to, str)

    def go_to(self, key: Any) -> None:
        """Move the beam to an event, and show its modes."""
        visitor = self.visitor
        with visitor.lock:
            answer = visitor.shown_answer(CHART)
            if answer and (chart := answer.result):
                events = chart.events | chart.resonances_at(visitor.state.per_rev)
                if event := events.get(key):
                    modes = chart.modes_of(event)
                    edit = partial(at_event, over=chart.request.over, event=event, modes=modes)
                    visitor.change(edit)

    def wanted(self, snapshot: Snapshot) -> Mapping[str, Any]:
        """The charts of the beam and of the one compared with."""
        request, other = chart_wanted(snapshot), snapshot.comparison.case
        if request is None:
            return {}
        with contextlib.suppress(InvalidInput):
            if other:
                return {CHART: request, SECOND_CHART: request.same_axis(other)}
        return {CHART: request}

    def content(self, snapshot: Snapshot) -> Content:
        answer, state = snapshot.job_answer(CHART), snapshot.state
        content = chart_content(answer, second_chart(snapshot), state.per_rev)
        content |= cursor_content(answer, snapshot.entered_beam)
        if answer and answer.result:
            content = with_goal(content, answer.request, state)
        if state.tab == AdjustTab.tab.key:
            content |= page.chart("adjust-chart", chart_parts(content))
            if answer and answer.result:
                content |= page.chart(
                    "adjust-chart", axes_near_goal(content, answer.request, state)
                )
        return (
            content
            | margins_content(snapshot)
            | axes_options(snapshot.state.case, "loci-over")
            | fading(snapshot, [CHART], "loci-chart", "adjust-chart", *LISTS)
            | waiting(snapshot, "loci-chart-wait", self.tab)
        )


def chart_wanted(snapshot: Snapshot) -> ChartRequest | None:
    """The chart of the beam in the scene; None before the first answer."""
    state, case = snapshot.state, snapshot.drawn_case
    if case is None:
        return None
    return ChartRequest.around(case, state.over, max(state.per_rev, default=0))


def current_chart(snapshot: Snapshot) -> Answer[ChartRequest, Chart] | None:
    """The answer with the chart of the beam in the scene; None before it is computed."""
    answer = snapshot.job_answer(CHART)
    return answer if answer and answer.request == chart_wanted(snapshot) else None


def second_chart(snapshot: Snapshot) -> Answer[ChartRequest, Chart] | None:
    """The answer with the chart of the beam compared with, on the axis of the first chart."""
    first, second = snapshot.job_answer(CHART), snapshot.job_answer(SECOND_CHART)
    case = snapshot.comparison.case
    if first and second and case:
        with contextlib.suppress(InvalidInput):
            return second if second.request == first.request.same_axis(case) else None
    return None


NO_LINES: page.Data = {"message": "", "lines": [], "marks": [], "gaps": [], "keys": []}


def chart_content(
    answer: Answer[ChartRequest, Chart] | None,
    other: Answer[ChartRequest, Chart] | None,
    multiples: tuple[int, ...],
) -> Content:
    """A chart, or the reason why there is none, the loci of a second beam, and the lists. Before
    the first answer the chart is empty."""
    content = page.props("loci-chart", hidden=False)
    if answer is None:
        content |= page.chart("loci-chart", {**NO_LINES, "perRev": None})
        content |= page.props("per-rev", hidden=False)
        content |= page.props("loci-resonances", hidden=True)
        return content | page.html("loci-resonances", "") | page.html("loci-events", "")
    chart, over_speed = answer.result, answer.request.over == "gamma"
    content |= page.props("per-rev", hidden=not over_speed)
    content |= page.props("loci-resonances", hidden=not (chart and over_speed and multiples))
    second = other.result if other else None
    if chart is None:
        reason = no_chart(answer)
        content |= page.chart("loci-chart", axes_data(answer.request, reason, second))
        content |= page.html("loci-events", page.note(reason))
        return content | page.html("loci-resonances", "")
    content |= page.chart("loci-chart", chart_data(chart, multiples, second))
    content |= page.html("loci-events", event_table(chart) + notes(chart))
    return content | page.html("loci-resonances", resonance_table(chart, multiples))


def with_goal(content: Content, request: ChartRequest, state: State) -> Content:
    """The content of a chart with what the tab Adjust aims at: the measured frequencies, or the
    bands that are to be kept free, behind the loci."""
    points, bars = measured_data(request, state)
    goal = goal_of_lines(state) if request.over == "gamma" else None
    behind = bands_to_clear(request, goal) if goal else []
    if not (points or behind):
        return content
    chart = chart_parts(content)
    added: page.Data = {
        "lines": [*behind, *chart["lines"], *bars],
        "marks": [*chart["marks"], *points],
        "keys": [*chart["keys"], *page.keys([], points)],
    }
    if goal:
        along, across = request.measures
        multiples = sorted({*state.per_rev, *goal.lines})
        added["perRev"] = {"slope": float(across.factor / along.factor), "multiples": multiples}
        text = f"to be kept free: {100 * goal.margin:.3g} % from {listed_lines(goal.lines)}"
        added["keys"].append({"style": "line kept-free", "text": text})
    return content | page.chart("loci-chart", added)


def listed_lines(multiples: tuple[int, ...]) -> str:
    return ", ".join(f"{k} ×" for k in multiples)


def bands_to_clear(request: ChartRequest, goal: ClearGoal) -> list[page.Data]:
    """The band of the margin around each per-rev line between the two speeds, as a closed line."""
    along, across = request.measures
    bands = []
    for line in goal.lines:
        speeds, corners = goal.band(line)
        place = {"at": page.sent(along.factor * speeds), "y": page.sent(across.factor * corners)}
        bands.append({"label": "", **place, "runs": [[0, len(speeds) - 1, "kept-free", ""]]})
    return bands


def measured_data(request: ChartRequest, state: State) -> tuple[list[page.Data], list[page.Data]]:
    """The measured frequencies of a chart as marks, and for each whose error is known a line of one
    standard deviation to both sides."""
    axes = along, across = request.measures
    points, bars = list[page.Data](), list[page.Data]()
    for k, (at, row) in enumerate(measured_points(state, request.over), 1):
        text = f"measured {row.mode}: {along.text(at, 4)}, {across.text(row.frequency, 5)}"
        points.append(page.mark(f"measured {k}", "measured", axes, (at, row.frequency), text))
        if math.isfinite(row.error):
            x = float(along.factor * at)
            ends = [float(across.factor * (row.frequency + d)) for d in (-row.error, row.error)]
            bars.append({"label": "", "at": [x, x], "y": ends, "runs": [[0, 1, "measured", ""]]})
    return points, bars


def axes_near_goal(content: Content, request: ChartRequest, state: State) -> page.Data:
    """The axes of the chart in the tab Adjust, which end near to what is aimed at."""
    chart, goal = chart_parts(content), state.slice(AdjustState).goal
    points = measured_points(state, request.over) if goal == "measured" else []
    speeds = goal_of_lines(state) if request.over == "gamma" else None
    farthest = max((at for at, _ in points), default=0.0) if speeds is None else speeds.high
    highest = max((row.frequency for _, row in points), default=0.0)
    axes: page.Data = {}
    for name, shown, end in zip("xy", request.measures, (farthest, highest), strict=True):
        axis = chart[name]
        first, last = axis["range"]
        if (near := WIDER * shown.factor * end) > first:
            axes[name] = axis | {"range": [first, min(float(near), last)]}
    return axes


def chart_parts(content: Content) -> page.Data:
    """The data of the chart in the content of the page."""
    place = ("charts", "loci-chart")
    return {path[2]: part for path, part in content.items() if path[:2] == place}


def no_chart(answer: Answer[ChartRequest, Chart]) -> str:
    """Why there is no chart; "" for one. The largest speed with an equilibrium is that of its first
    beam, which may be another one than that in the scene."""
    request, text = answer.request, answer.message
    if isinstance(answer.error, NoEquilibrium) and request.over != "gamma":
        return f"{text}, at {request.measures[0].place(request.start)}"
    return text


def cursor_content(answer: Answer[ChartRequest, Chart] | None, beam: Beam | None) -> Content:
    """The line of the beam, None where a number is out of range, and the event that it is at."""
    if answer is None:
        return page.chart("loci-chart", {"cursor": None}) | page.value("go_to_event", "")
    request, chart = answer.request, answer.result
    line = cursor(beam, request.over, request.measures[0])
    chosen = chart.event_at(getattr(beam, request.over)) if chart and beam else ""
    found = page.chart("loci-chart", {"cursor": line, "chosen": chosen})
    return found | page.value("go_to_event", chosen)


def margins_content(snapshot: Snapshot) -> Content:
    """The table of margins over the speed where per-rev lines are chosen and the beam rotates."""
    answer, solved, multiples = (
        snapshot.job_answer(CHART),
        snapshot.solved,
        snapshot.state.per_rev,
    )
    solution, text = solved.solution if solved else None, ""
    over_speed = answer is not None and answer.request.over == "gamma"
    if solution and multiples and over_speed and solution.beam.gamma:
        text = margin_table(solution, multiples, answer.result if answer else None)
    return page.html("loci-margins", text) | page.props("loci-margins", hidden=not text)


def at_event(state: State, over: str, event: Event, modes: tuple[int, ...]) -> State:
    """With the beam at an event, in equal shares of its modes, and not compared with a beam before
    an edit, which has other numbers."""
    state = state.without_edit_kept().changed(over, event.at)
    return state.only(*modes) if modes else state


def has_line(state: State, k: int) -> bool:
    return k in state.per_rev


def with_line(state: State, on: Any, k: int) -> State:
    multiples = {*state.per_rev, k} if on else {*state.per_rev} - {k}
    return state.changed("per_rev", sorted(multiples))


# Lists of the tab


def event_table(chart: Chart) -> str:
    """The events, each with a button that moves the beam there."""
    text = "" if chart.pairs else f"<p>No {' or '.join(EXCHANGES)} in this range.</p>"
    if not chart.events:
        return text
    along, across = chart.request.measures
    heads = ("go to", f"at {along.head}", across.label, "smallest gap")
    rows = []
    for key, event in chart.events.items():
        sign, gap = page.sign(event.kind), across.gap(event.gap)
        rows.append((*cells(chart, key, sign, event), gap))
    kinds = {event.kind for event in chart.events.values()}
    shown = {name: kind.sign for name, kind in EVENT_KINDS.items() if name in kinds}
    caption = ", ".join(f"{name} {sign}" for name, sign in shown.items()).capitalize()
    return page.table("events", heads, rows, caption=caption) + text


def event_buttons(chart: Chart) -> str:
    """Buttons that move the beam to the crossings and veerings."""
    along, buttons = chart.request.measures[0], ""
    for key, event in chart.pairs.items():
        label = f"{' and '.join(chart.names_of(event))}, {along.place(event.at)}"
        buttons += page.button(label, data_set="go_to_event", data_value=key)
    return page.group("go to", f'<span class="soft">go to</span>{buttons}')


def cells(chart: Chart, key: str, sign: str, one: Event) -> tuple[str, str, str]:
    """A button that moves the beam to an event, with its value and its frequency."""
    along, across = chart.request.measures
    label = f"{sign} {', '.join(chart.names_of(one))}"
    go_to = page.button(label, data_set="go_to_event", data_value=key, class_="quiet")
    return go_to, along.number(one.at), across.number(one.frequency)


def resonance_table(chart: Chart, multiples: tuple[int, ...]) -> str:
    """The resonances in order of speed, each with a button that moves the beam there, and the loci
    that lie on a line."""
    found, along_lines = chart.resonances_at(multiples), resonances_along(chart, multiples)
    if not found:
        lines = " ".join(f"{k} ×" for k in multiples)
        none = f"<p>No line {lines} speed intersects a mode in this range.</p>"
        return along_lines or none
    along, across = chart.request.measures
    heads = ("go to", "per rev", f"at {along.head}", across.label)
    rows = []
    for key, one in found.items():
        go_to, *place = cells(chart, key, page.sign("resonance"), one)
        rows.append((go_to, f"{one.per_rev} ×", *place))
    return along_lines + page.table("resonances", heads, rows, caption="Resonances")


def margin_table(solution: Solution, multiples: tuple[int, ...], chart: Chart | None) -> str:
    """The margins of the modes to per-rev lines at the speed of the beam. Modes that lie on a line
    at all speeds are known from the chart."""
    speed = solution.beam.gamma
    on_lines = chart.modes_on_lines(speed, multiples) if chart else set()
    rows = []
    for label, frequency in zip(
        identify_modes(solution).labels, solution.frequencies.tolist(), strict=True
    ):
        margins = percent(frequency, speed, np.array(multiples)).tolist()
        cells = (
            "on it" if (label, k) in on_lines else percent_text(margin)
            for k, margin in zip(multiples, margins, strict=True)
        )
        rows.append((label, *cells))
    place = measure("gamma", solution.beam.units).text(speed, 4)
    heads = ("mode", *(f"{k} ×" for k in multiples))
    caption = f"Margins to per-rev lines at {place} [%]"
    return page.table("margins", heads, rows, caption=caption)


def percent_text(margin: float) -> str:
    """A margin [%] with its sign, to 0.1 where it is below 100; a dash for a mode without a
    frequency."""
    if not math.isfinite(margin):
        return "–"
    digits = 1 if abs(margin) < 99.95 else 0
    return f"{margin:+.{digits}f}".replace("-", "−")


def resonances_along(chart: Chart, multiples: tuple[int, ...]) -> str:
    """The loci that lie on a line, in words."""
    along, text = chart.request.measures[0], ""
    for one in chart.resonances_along(multiples):
        assert one.until is not None
        first, last = (along.text(end, 4) for end in (one.at, one.until))
        name = " and ".join(chart.names_of(one))
        text += (
            f"<p><b>{name}</b> lies on the line {one.per_rev} × speed: it is in resonance at every"
            f" speed from {first} to {last}.</p>"
        )
    return text


def notes(chart: Chart) -> str:
    """The reasons why loci end, with the ranges."""
    request, text = chart.request, ""
    for limit in chart.limits:
        stretched = limit.kind == "no-equilibrium" and request.beam.delta >= 0  # else compressed
        law = " with this material law" if stretched else ""
        text += page.note(f"{FAILURES[limit.kind]} {range_of(limit, request)}{law}.")
    return text


def range_of(limit: Limit, request: ChartRequest) -> str:
    """The range of a limit in words. Where it reaches an end of the chart, no value is known beyond
    that; but equilibrium does not begin again at higher speeds."""
    first, last = (request.measures[0].place(end) for end in (limit.start, limit.stop))
    if limit.stop == request.stop:
        over_speed = limit.kind == "no-equilibrium" and request.over == "gamma"
        return f"above {first}" if over_speed else f"from {first} to the end of the chart"
    begin = "the beginning of the chart" if limit.start == request.start else first
    return f"from {begin} to {last}"
