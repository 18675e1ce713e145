"""The tab Methods: solve time against frequency error of every method for the beam shown."""

import math
from html import escape
from typing import Any, NamedTuple

import numpy as np

from beamviz.errors import BeamvizError
from beamviz.explorer.jobs import Answer
from beamviz.explorer.page.html import SMALL, coloured, small
from beamviz.explorer.page.style import apart
from beamviz.explorer.state import Case
from beamviz.explorer.visitor import Feature, Visitor
from beamviz.frequency_loci.identity import match_modes
from beamviz.solver import METHODS, Solution, solve

REFERENCE_TOLERANCE = 1e-11  # relative, of the frequencies that errors are measured against
MIN_ERROR = 1e-12  # smaller errors are not resolved by the reference
REPEATS = 3  # solves of which the fastest counts
RESOLUTIONS: dict[str, tuple[float, ...]] = {
    "tolerance": (1e-2, 1e-4, 1e-6, 1e-8),
    "elements": (5, 10, 20, 40),
    "terms": (8, 16, 32),
}
OPTION = {
    **dict.fromkeys(("auto", "foac", "zoac"), "tolerance"),
    **dict.fromkeys(("ancf", "ancf-planar", "linear"), "elements"),
    **dict.fromkeys(("assumed-modes", "power-series", "chebyshev"), "terms"),
}


class Timing(NamedTuple):
    """One method at one resolution: solve time [s] and largest relative frequency error, or in
    `reason` why there is none."""

    method: str
    resolution: str
    seconds: float
    error: float
    reason: str = ""


def time_methods(case: Case) -> tuple[Timing, ...]:
    """A case by every method at its resolutions. Raises BeamvizError where there is no reference
    solution."""
    options = {**case.options, "method": "auto", "tolerance": REFERENCE_TOLERANCE}
    reference = solve(case.beam(), **options)
    return tuple(
        time_method(reference, method, value, case.options)
        for method in METHODS
        for value in RESOLUTIONS[OPTION[method]]
    )


def time_method(reference: Solution, method: str, value: float, options: dict[str, Any]) -> Timing:
    """One method at the resolution `value`."""
    option = OPTION[method]
    resolution = f"{option} {value:g}"
    settings: dict[str, Any] = {**options, "method": method, option: value}
    try:
        runs = [solve(reference.beam, **settings) for _ in range(REPEATS)]
    except BeamvizError as failure:
        return Timing(method, resolution, math.nan, math.nan, str(failure))
    status, expected = runs[0].equilibrium.status, reference.equilibrium.status
    if status != expected:
        reason = f"predicts an {status} beam; it is {expected}"
        return Timing(method, resolution, math.nan, math.nan, reason)
    seconds = min(run.stats.seconds for run in runs)
    return Timing(method, resolution, seconds, frequency_error(runs[0], reference))


def frequency_error(solution: Solution, reference: Solution) -> float:
    """Largest relative error of the frequencies (growth rates where unstable) of the modes that
    both solutions have, matched by shape."""
    pairs = zip(match_modes(reference, solution).partner, rates(reference), strict=True)
    errors = [abs(rates(solution)[k] / exact - 1) for k, exact in pairs if k >= 0 and exact > 0]
    return max(MIN_ERROR, *errors)


def rates(solution: Solution) -> np.ndarray:
    """Frequency of each mode (modes,), growth rate where unstable."""
    return np.sqrt(abs(solution.omega_squared))


# The tab

WIDTH, HEIGHT = 345, 222  # [px] of the chart
LEFT, RIGHT, ABOVE, BELOW = 42, 88, 10, 34  # [px] of its margins
MAX_ERROR = 1.0
PALETTE = (
    "#0072B2", "#D55E00", "#E69F00", "#CC79A7", "#009E73", "#999999", "#56B4E9", "#B59F00",
    "#8C6BB1",
)  # fmt: skip
COLOURS = dict(zip(METHODS, PALETTE, strict=True))
INVITATION = "Try another method under <b>Model</b> on the right, and see what it costs."
NOTE = (
    "Further right: slower. Higher: less accurate (largest relative frequency error). A line that"
    " stays high belongs to a model that leaves something out. The ring is this scene: the time of"
    " its last solve and its estimated error."
)
Span = tuple[float, float]  # ends of the time axis [s]


class MethodTimingTab(Feature):
    """The method in use, and the chart of all methods where that is switched on."""

    def __init__(self, visitor: Visitor):
        super().__init__(visitor)
        gui, self.job = visitor.client.gui, visitor.job("method timing", time_methods)
        self.summary = gui.add_html("")
        hint = "Time them all, again for every beam you show"
        visitor.bind_control_key(gui.add_checkbox("all methods", False, hint=hint), "time_methods")
        self.chart = gui.add_html("")

    @property
    def inputs(self) -> tuple[object, ...]:
        """The answer shown, the switch, and the timings."""
        return self.visitor.chart_answer, self.visitor.state.time_methods, self.job.answer

    def show(self) -> None:
        """Describe the method in use; request the timings and draw the last ones."""
        answer, timings = self.visitor.chart_answer, None
        solution = answer.solution if answer else None
        if answer and self.visitor.state.time_methods:
            self.job.request(answer.request.with_options(method="auto"))
            timings = self.job.answer
        invitation = "" if timings else INVITATION  # the chart needs the room
        self.summary.content = small((summary(solution) if solution else "") + invitation)
        self.chart.content = timing_chart(timings, solution) if timings else ""


def summary(solution: Solution) -> str:
    """The method in use, and when to choose it."""
    name = solution.problem.method
    return (
        f'<div role="note" aria-label="this method">{coloured(name, COLOURS[name])}: '
        f"{escape(cost(solution))}<br>"
        f'<span style="opacity:.65">Recommended {escape(METHODS[name].choose)}.</span></div>'
    )


def cost(solution: Solution) -> str:
    """Elements, order, unknowns, time and largest relative error of a solution."""
    stats = solution.stats
    elements = f"{stats.elements} element{'s' if stats.elements > 1 else ''}"
    return (
        f"{elements}, order {stats.order}, {stats.dof} unknowns, {1000 * stats.seconds:.2g} ms,"
        f" relative error {relative_error(solution):.0e}"
    )


def relative_error(solution: Solution) -> float:
    """Largest estimated relative error of a frequency or growth rate."""
    return float(np.max(solution.errors / np.maximum(rates(solution), 1e-300)))


def timing_chart(answer: Answer[Case, tuple[Timing, ...]], solution: Solution | None) -> str:
    """Time against error of all methods, on logarithmic axes, and why methods are missing."""
    if answer.result is None:
        return small(escape(answer.message), "note")
    good = [timing for timing in answer.result if math.isfinite(timing.error)]
    times = [math.log10(timing.seconds) for timing in good]
    span = 10.0 ** math.floor(min(times)), 10.0 ** math.ceil(max(times))
    own = solution.problem.method if solution else ""
    order = sorted(COLOURS, key=lambda name: name == own)  # the one in use on top
    lines = "".join(
        line([t for t in good if t.method == name], name == own, span) for name in order
    )
    ring = ""  # at the time and the estimated error of the scene's own solve
    if solution:
        x, y = position(
            min(max(solution.stats.seconds, span[0]), span[1]), relative_error(solution), span
        )
        title = f"this scene: {escape(cost(solution))}"
        ring = (
            f'<g fill="none" stroke="currentColor" stroke-width="1.6">{circle(x, y, 6, title)}</g>'
        )
    reasons = {timing.method: timing.reason for timing in answer.result if timing.reason}
    missing = "".join(
        f"<li>{coloured(name, COLOURS[name])}: {escape(reason)}</li>"
        for name, reason in reasons.items()
    )
    return (
        f'<svg viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="time against error" '
        'style="width:calc(100% - 1.5em);margin:.2em .75em;overflow:visible" '
        'font-family="sans-serif" font-size="10.5" fill="currentColor">'
        f"{frame(span)}{lines}{method_labels(good, own)}{ring}</svg>"
        f'<div style="{SMALL};opacity:.8">{NOTE}</div>'
        + (f'<ul style="{SMALL};padding-left:1.2em">{missing}</ul>' if missing else "")
    )


def position(seconds: float, error: float, span: Span) -> tuple[float, float]:
    """Position [px] of a time and an error on the logarithmic axes."""
    right = math.log(seconds / span[0]) / math.log(span[1] / span[0])
    up = math.log(min(max(error, MIN_ERROR), MAX_ERROR) / MIN_ERROR) / math.log(
        MAX_ERROR / MIN_ERROR
    )
    x = LEFT + right * (WIDTH - LEFT - RIGHT)
    return x, HEIGHT - BELOW - up * (HEIGHT - ABOVE - BELOW)


def text(x: float, y: float, content: str, attributes: str = 'text-anchor="middle"') -> str:
    """A text in the chart."""
    return f'<text x="{x:.1f}" y="{y:.1f}" {attributes}>{content}</text>'


def circle(x: float, y: float, radius: float, title: str) -> str:
    """A mark in the chart, with a title that appears under the pointer."""
    return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius}"><title>{title}</title></circle>'


def frame(span: Span) -> str:
    """Grid and axes."""
    marks, bottom = [], HEIGHT - BELOW
    for power in range(-12, 1, 3):
        _, y = position(span[0], 10.0**power, span)
        label = "1" if power == 0 else f"10<tspan dy=-4 font-size=8>{power}</tspan>"
        marks.append(f'<path d="M{LEFT} {y:.1f}H{WIDTH - RIGHT}"/>')
        marks.append(text(LEFT - 5, y + 4, label, 'text-anchor="end"'))
    low, high = (round(math.log10(end)) for end in span)
    for power in range(low, high + 1):
        x, _ = position(10.0**power, MAX_ERROR, span)
        marks.append(f'<path d="M{x:.1f} {ABOVE}V{bottom}"/>')
        marks.append(text(x, bottom + 14, f"{10.0 ** (power + 3):g} ms"))
    marks.append(text((LEFT + WIDTH - RIGHT) / 2, HEIGHT - 4, "time of a solve"))
    rotated = f'transform="translate(10 {(bottom + ABOVE) / 2}) rotate(-90)" text-anchor="middle"'
    marks.append(text(0, 0, "relative error", rotated))
    return f'<g stroke="currentColor" stroke-opacity=".18" stroke-width=".7">{"".join(marks)}</g>'


def line(timings: list[Timing], own: bool, span: Span) -> str:
    """One method, its resolutions joined; `own`: the method in use."""
    if not timings:
        return ""
    colour = COLOURS[timings[0].method]
    places = [position(t.seconds, t.error, span) for t in timings]
    path = " ".join(f"{x:.1f},{y:.1f}" for x, y in places)
    dots = ""
    for t, (x, y) in zip(timings, places, strict=True):
        title = f"{t.method}, {t.resolution}: {1000 * t.seconds:.2g} ms, error {t.error:.0e}"
        dots += circle(x, y, 4 if own else 2.5, title)
    width = 2.5 if own else 1.2
    return (
        f'<g fill="{colour}"><polyline points="{path}" fill="none" stroke="{colour}" '
        f'stroke-width="{width}"/>{dots}</g>'
    )


def method_labels(timings: list[Timing], own: str) -> str:
    """Names of the methods on the right, near the end of their lines, without overlap."""
    errors = {timing.method: timing.error for timing in timings}
    ends = sorted((position(1.0, error, (1.0, 10.0))[1], name) for name, error in errors.items())
    bottom, lowered = float(HEIGHT - BELOW), apart([y for y, _ in ends], 13)
    heights = apart([max(bottom - y, 0.0) for y in reversed(lowered)], 13)  # within the chart
    labels = ""
    for height, (_, name) in zip(heights, reversed(ends), strict=True):
        weight = f'fill="{COLOURS[name]}" font-weight="{700 if name == own else 400}"'
        labels += text(WIDTH - RIGHT + 6, bottom - height + 3.5, name, weight)
    return labels
