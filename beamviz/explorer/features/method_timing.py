"""The tab Methods: solve time against frequency error of every method for the beam shown."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from typing import Any, NamedTuple

import numpy as np

from beamviz.drawing.text import Measure, error_text, significant
from beamviz.errors import BeamvizError
from beamviz.explorer import page
from beamviz.explorer.declarations import SWITCH, Tab, choice, switch_key
from beamviz.explorer.feature import Feature, fading, waiting
from beamviz.explorer.jobs import Answer
from beamviz.explorer.page import Content
from beamviz.explorer.snapshot import Snapshot
from beamviz.explorer.solutions import SOLUTION, SolverAnswer
from beamviz.explorer.state import Case, Slice
from beamviz.explorer.visitor import Visitor
from beamviz.frequency_loci.identity import match_modes
from beamviz.solver import METHODS, Solution, solve
from beamviz.tables import plural

REFERENCE_TOLERANCE = 1e-11  # relative, of the frequencies that errors are measured against
REPEATS = 3  # solves of which the fastest counts
RESOLUTIONS: dict[str, tuple[float, ...]] = {
    "tolerance": (1e-2, 1e-4, 1e-6, 1e-8),
    "elements": (5, 10, 20, 40),
    "terms": (8, 16, 32),
}


class Timing(NamedTuple):
    """A method at a resolution: solve time [s], largest relative frequency error; or a `reason`."""

    method: str
    resolution: str
    seconds: float = math.nan
    error: float = math.nan
    reason: str = ""


def time_methods(case: Case) -> tuple[Timing, ...]:
    """Time every method at its resolutions on a case. Raises the errors of `solve`."""
    options = {**case.options, "method": "auto", "tolerance": REFERENCE_TOLERANCE}
    reference = solve(case.beam, **options)
    timings = []
    for method, row in METHODS.items():
        option = row.resolution.option if row.resolution else "tolerance"
        settings = {**case.options, "method": method}
        timings += [time_method(reference, option, one, settings) for one in RESOLUTIONS[option]]
    return tuple(timings)


def time_method(reference: Solution, option: str, value: float, settings: dict[str, Any]) -> Timing:
    """Time the method of some settings at a resolution, a value of an option."""
    method, resolution = settings["method"], f"{option} {value:g}".replace("e-0", "e-")
    try:
        found = solve(reference.beam, **{**settings, option: value})
        seconds = found.stats.seconds
        for _ in range(REPEATS - 1):
            again = solve(reference.beam, **{**settings, option: value})
            seconds = min(seconds, again.stats.seconds)
    except BeamvizError as failure:
        return Timing(method, resolution, reason=error_text(failure, reference.beam))
    status, expected = found.equilibrium.status, reference.equilibrium.status
    if status != expected:
        return Timing(method, resolution, reason=f"predicts an {status} beam; it is {expected}")
    return Timing(method, resolution, seconds, frequency_error(found, reference))


def frequency_error(solution: Solution, reference: Solution) -> float:
    """Largest relative error of the frequencies, or growth rates, of the modes matched by shape."""
    pairs = zip(match_modes(reference, solution).partner, rates(reference), strict=True)
    errors = [abs(rates(solution)[k] / rate - 1) for k, rate in pairs if k >= 0 and rate > 0]
    return max(MIN_ERROR, *errors)


def rates(solution: Solution) -> np.ndarray:
    """The frequency of each mode (modes,), or its growth rate if unstable."""
    return np.sqrt(abs(solution.omega_squared))


# The tab

ERRORS = MIN_ERROR, MAX_ERROR = 1e-12, 1.0  # those shown; smaller ones are not resolved
STYLES = {name: f"method-{k}" for k, name in enumerate(METHODS)}
INVITATION = (
    "<p>Time all methods to compare them, or choose another "
    '<button type="button" class="link" data-point="method">method</button> for this beam.</p>'
)
NOTE = (
    "<p>Further right: slower. Higher: less accurate (largest relative frequency error). A line"
    " that does not fall is that of a model with an error of its own. The ring is this scene: the"
    " time of its last solve and its estimated error.</p>"
)


JOB = "method timing"
SHOWN = "timing-chart", "timings"  # ids of the chart and of the table
HELP = "Every method at several resolutions, while this tab is open; again for another beam"
TOOLS = page.checkbox("time_methods", "time all methods", HELP) + '<div id="method"></div>'


@dataclass(frozen=True)
class TimingState(Slice):
    """Whether all methods are timed."""

    time_methods: bool = field(
        default=False, metadata=choice(values=SWITCH, key=switch_key("methods"))
    )


class MethodTimingTab(Feature):
    """The method in use, and the chart of all methods if that is switched on. They are only timed
    while the tab is open: another one needs the processor, and would falsify them."""

    tab = Tab(
        "Methods",
        11,
        "The time and the error of every method of solution",
        page.chart_tab(TOOLS, "timing-chart", "timings"),
        (SOLUTION, JOB),
        is_aside=True,
    )
    state = TimingState

    def __init__(self, visitor: Visitor):
        super().__init__(visitor)
        visitor.job(JOB, time_methods)

    def wanted(self, snapshot: Snapshot) -> Mapping[str, Any]:
        """The timings while the tab is open, and only then."""
        if snapshot.state.tab != self.tab.key:
            return {JOB: None}
        if not (snapshot.answer and snapshot.state.slice(TimingState).time_methods):
            return {}
        return {JOB: snapshot.answer.request.with_options(method="auto")}

    def content(self, snapshot: Snapshot) -> Content:
        """The method of the answer and the timings, if they are asked for; neither while the tab is
        closed."""
        is_asked = snapshot.state.slice(TimingState).time_methods
        answer = snapshot.answer if snapshot.state.tab == self.tab.key else None
        return (
            timing_content(answer, is_asked, snapshot.job_answer(JOB) if is_asked else None)
            | fading(snapshot, [JOB], *SHOWN)
            | waiting(snapshot, "timing-chart-wait", self.tab)
        )


def timing_content(
    answer: SolverAnswer | None,
    is_asked: bool,
    timings: Answer[Case, tuple[Timing, ...]] | None,
) -> Content:
    """The method in use; the timings, the reason why there are none, or an invitation."""
    if answer is None:
        content = page.html("method", "") | page.html("timings", "")
        return content | page.props("timing-chart", hidden=True)
    solution = answer.solution
    content = page.html("method", summary(solution) if solution else "")
    content |= page.props("timing-chart", hidden=not (timings and timings.result))
    if timings and timings.result:
        content |= page.html("timings", timing_table(timings.result) + NOTE)
        return content | page.chart("timing-chart", timing_data(timings.result, solution))
    if timings is None:
        return content | page.html("timings", "" if is_asked else INVITATION)
    return content | page.html("timings", page.note(timings.message))


def summary(solution: Solution) -> str:
    """The method in use, and its recommended use."""
    name = solution.problem.method
    own = f'<b class="swatch {STYLES[name]}">{escape(name)}</b>: {escape(cost(solution))}'
    advice = f'<span class="soft">Recommended {escape(METHODS[name].choose)}.</span>'
    return f'<p role="note" aria-label="this method">{own}<br>{advice}</p>'


def milliseconds(seconds: float) -> str:
    return f"{significant(1000 * seconds, 2)} ms"


def cost(solution: Solution) -> str:
    """Elements, order, unknowns, time and largest relative error of a solution."""
    stats, error = solution.stats, f"relative error {relative_error(solution):.0e}"
    size = f"{plural(stats.elements, 'element')}, order {stats.order}, {stats.dof} unknowns"
    return f"{size}, {milliseconds(stats.seconds)}, {error}"


def relative_error(solution: Solution) -> float:
    """Largest estimated relative error of a frequency or growth rate."""
    return float(np.max(solution.errors / np.maximum(rates(solution), 1e-300)))


def timing_data(timings: Sequence[Timing], solution: Solution | None) -> page.Data:
    """The chart: time and error of all methods, on logarithmic axes, and those of the scene."""
    good = [timing for timing in timings if math.isfinite(timing.error)]
    times = [math.log10(1000 * timing.seconds) for timing in good]
    span = 10.0 ** math.floor(min(times)), 10.0 ** math.ceil(max(times))
    axes = Measure("time of a solve [ms]", "time", "ms"), Measure("relative error", "error")
    lines, marks = [], []
    for method, style in STYLES.items():
        own = [one for one in good if one.method == method]
        places = [(1000 * one.seconds, min(one.error, MAX_ERROR)) for one in own]
        for one, place in zip(own, places, strict=True):
            key = f"{method}, {one.resolution}"
            text = f"{key}: {milliseconds(one.seconds)}, relative error {one.error:.0e}"
            marks.append(page.mark(key, "point", axes, place, text))
        if own:
            at, y = map(page.sent, np.transpose(places))
            runs = [[0, len(own) - 1, style, method]]
            lines.append({"label": method, "at": at, "y": y, "runs": runs, "dots": True})
    if solution:
        x = float(np.clip(1000 * solution.stats.seconds, *span))
        place = x, float(np.clip(relative_error(solution), *ERRORS))
        marks.append(page.mark("this scene", "here", axes, place, f"this scene: {cost(solution)}"))
    name, ends = "Time against error of every method", (span, ERRORS)
    across, up = (page.axis_data(*one, log=True) for one in zip(axes, ends, strict=True))
    keys: list[page.Data] = [
        {"style": "mark here", "text": "this scene", "sign": page.sign("here")}
    ]
    return {"name": name, "x": across, "y": up, "lines": lines, "marks": marks, "keys": keys}


def timing_table(timings: Sequence[Timing]) -> str:
    """Every method with a button that chooses it, and its most accurate result or the reason."""
    rows = []
    for name, style in STYLES.items():
        own = [timing for timing in timings if timing.method == name]
        good = [timing for timing in own if math.isfinite(timing.error)]
        choose = page.button(name, data_set="method", data_value=name, class_=f"quiet {style}")
        if good:
            best = min(good, key=lambda timing: timing.error)
            result = milliseconds(best.seconds), f"{best.error:.0e}", best.resolution
        else:
            result = "–", "–", f'<span class="reason">{escape(own[0].reason)}</span>'
        rows.append((choose, *result))
    return page.table("methods", ("use", "time", "error", "at"), rows)
