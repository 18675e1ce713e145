"""What each method takes, in time, and gives, in accuracy, for the beam that is shown."""

import math
from collections.abc import Iterator
from html import escape
from typing import Any, NamedTuple

import numpy as np

from beamviz.errors import BeamvizError
from beamviz.explorer.page.html import SMALL
from beamviz.explorer.page.style import apart
from beamviz.explorer.state import Case
from beamviz.explorer.visitor import Feature, Visitor
from beamviz.solver import METHODS, Solution, solve

EXACT = 1e-11  # relative tolerance of what all are held against
FLOOR = 1e-12  # a smaller error is not told from it
REPEATS = 3  # the fastest counts
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


class Effort(NamedTuple):
    """One solve: its time [s], and the largest relative distance of a frequency from the exact
    one; or why there is none."""

    method: str
    resolution: str
    seconds: float
    error: float
    reason: str = ""


class Efforts(NamedTuple):
    """Every method at some resolutions; why there is nothing to compare with."""

    points: tuple[Effort, ...]
    words: str = ""


def efforts(case: Case) -> Efforts:
    """All methods, timed on a case and held against its exact frequencies."""
    beam = case.beam()
    options = {**case.options, "method": "auto"}
    exact = solve(beam, **{**options, "tolerance": EXACT})

    def tried(method: str, resolution: float) -> Effort:
        option = OPTION[method]
        shown = f"{option} {resolution:g}"
        settings: dict[str, Any] = {**options, "method": method, option: resolution}
        try:
            runs = [solve(beam, **settings) for _ in range(REPEATS)]
        except BeamvizError as failure:
            return Effort(method, shown, np.nan, np.nan, str(failure))
        error, reason = distance(runs[0], exact)
        return Effort(method, shown, min(run.stats.seconds for run in runs), error, reason)

    points = [tried(method, r) for method in METHODS for r in RESOLUTIONS[OPTION[method]]]
    return Efforts(tuple(points))


def distance(solution: Solution, exact: Solution) -> tuple[float, str]:
    """The largest relative distance of a mode's frequency from the exact one of its name, and
    what is wrong beyond numbers."""
    if solution.equilibrium.status != exact.equilibrium.status:
        return np.nan, f"says {solution.equilibrium.status}: the beam is {exact.equilibrium.status}"
    pairs = list(paired(solution, exact))
    return max([FLOOR, *(abs(a - b) / abs(b) for a, b in pairs if b)]), ""


def paired(solution: Solution, exact: Solution) -> Iterator[tuple[float, float]]:
    """Frequencies (growth rates where unstable) of the modes that both have among theirs."""
    for k, label in enumerate(exact.labels):
        if label in solution.labels:
            j = solution.labels.index(label)
            if exact.omega_squared[k] >= 0 and solution.omega_squared[j] >= 0:
                yield float(solution.frequencies[j]), float(exact.frequencies[k])
            else:
                yield float(solution.growth_rates[j]), float(exact.growth_rates[k])


WIDTH, HEIGHT = 345, 222  # [px] of the chart
LEFT, RIGHT, ABOVE, BELOW = 42, 88, 10, 34
ERRORS = (FLOOR, 1.0)
COLOURS = dict(
    zip(
        METHODS,
        ("#0072B2", "#D55E00", "#E69F00", "#CC79A7", "#009E73", "#999999", "#56B4E9", "#B59F00")
        + ("#8C6BB1",),
        strict=True,
    )
)
INVITATION = "Try another method under <b>Model</b> on the right, and see what it costs."
NOTE = (
    "Right is slow, up is wrong: the largest distance of a frequency from the exact one. "
    "A line that stays high is a model that leaves something out. "
    "The ring is the scene: the time it took just now, the error it estimates."
)


class MethodTiming(Feature):
    """Shows what a method takes and gives; measures all methods while asked to."""

    def __init__(self, visitor: Visitor):
        super().__init__(visitor)
        self.trials, gui = visitor.job("trial of methods", efforts), visitor.client.gui
        self.words = gui.add_html("")
        hint = "Measure them all, again for every beam you show"
        visitor.bind_key(gui.add_checkbox("all methods", False, hint=hint), "time_methods")
        self.chart = gui.add_html("")

    @property
    def inputs(self) -> tuple:
        """What the tab depends on."""
        visitor = self.visitor
        return visitor.chart_answer, visitor.state.time_methods, self.trials.answer

    def show(self) -> None:
        """Tell what the method of the scene took, and draw all that were measured."""
        answer, measured = self.visitor.chart_answer, None
        if answer and self.visitor.state.time_methods:
            self.trials.request(answer.request.with_options(method="auto"))
            found = self.trials.answer
            measured = found and (found.result or Efforts((), found.message))
        solution = answer.solution if answer else None
        told = "" if measured else INVITATION  # the chart shows it, and needs the room
        self.words.content = (
            f'<div style="{SMALL}">{chosen(solution) if solution else ""}{told}</div>'
        )
        self.chart.content = chart(measured, solution) if measured else ""


def chosen(solution: Solution) -> str:
    """What was used, in a sentence."""
    name = escape(solution.problem.method)
    return (
        f'<div role="note" aria-label="this method"><b style="color:{COLOURS[name]}">{name}</b>: '
        f"{escape(used(solution))}<br>"
        f'<span style="opacity:.65">Choose it {escape(METHODS[name].choose)}.</span></div>'
    )


def used(solution: Solution) -> str:
    """Elements, order, unknowns, time and the largest relative error of a mode."""
    stats = solution.stats
    parts = f"{stats.elements} element{'s' if stats.elements > 1 else ''}, order {stats.order}"
    return (
        f"{parts}, {stats.dof} unknowns, {1000 * stats.seconds:.2g} ms,"
        f" error {relative_error(solution):.0e}"
    )


def relative_error(solution: Solution) -> float:
    """The largest estimated relative error of a frequency or growth rate."""
    sizes = np.where(solution.omega_squared >= 0, solution.frequencies, solution.growth_rates)
    return float(np.max(solution.errors / np.maximum(sizes, 1e-300)))


def chart(measured: Efforts, solution: Solution | None) -> str:
    """Time against error of all methods, both logarithmic, and what failed in words."""
    if measured.words:
        return f'<div role="note" style="{SMALL}">{escape(measured.words)}</div>'
    good = [point for point in measured.points if math.isfinite(point.error)]
    times = [point.seconds for point in good]
    span = 10 ** math.floor(math.log10(min(times))), 10 ** math.ceil(math.log10(max(times)))
    here = solution.problem.method if solution else ""
    order = sorted(COLOURS, key=lambda name: name == here)  # the one in use on top
    lines = "".join(
        line([p for p in good if p.method == name], name == here, span) for name in order
    )
    lines += names(good, here) + (live(solution, span) if solution else "")
    return (
        f'<svg viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="time against error" '
        'style="width:calc(100% - 1.5em);margin:.2em .75em;overflow:visible" '
        f'font-family="sans-serif" font-size="10.5" fill="currentColor">{frame(span)}{lines}</svg>'
        f'<div style="{SMALL};opacity:.8">{NOTE}</div>{failures(measured.points)}'
    )


def across(seconds: float, span: tuple[float, float]) -> float:
    """Where a time stands."""
    low, high = map(math.log10, span)
    return LEFT + (math.log10(seconds) - low) / (high - low) * (WIDTH - LEFT - RIGHT)


def above(error: float) -> float:
    """Where an error stands."""
    low, high = map(math.log10, ERRORS)
    share = (math.log10(min(max(error, ERRORS[0]), ERRORS[1])) - low) / (high - low)
    return HEIGHT - BELOW - share * (HEIGHT - ABOVE - BELOW)


def frame(span: tuple[float, float]) -> str:
    """Grid and axes."""
    marks = []
    for power in range(-12, 1, 3):
        y = above(10.0**power)
        words = "1" if power == 0 else f"10<tspan dy=-4 font-size=8>{power}</tspan>"
        marks.append(f'<path d="M{LEFT} {y:.1f}H{WIDTH - RIGHT}"/>')
        marks.append(f'<text x="{LEFT - 5}" y="{y + 4:.1f}" text-anchor="end">{words}</text>')
    low, high = (round(math.log10(end)) for end in span)
    for power in range(low, high + 1):
        x, bottom = across(10.0**power, span), HEIGHT - BELOW
        marks.append(f'<path d="M{x:.1f} {ABOVE}V{bottom}"/>')
        ms = f"{10.0 ** (power + 3):g} ms"
        marks.append(f'<text x="{x:.1f}" y="{bottom + 14}" text-anchor="middle">{ms}</text>')
    middle = (LEFT + WIDTH - RIGHT) / 2
    marks.append(f'<text x="{middle}" y="{HEIGHT - 4}" text-anchor="middle">time of a solve</text>')
    marks.append(
        f'<text transform="translate(10 {(HEIGHT - BELOW + ABOVE) / 2}) rotate(-90)" '
        'text-anchor="middle">error</text>'
    )
    return f'<g stroke="currentColor" stroke-opacity=".18" stroke-width=".7">{"".join(marks)}</g>'


def line(points: list[Effort], here: bool, span: tuple[float, float]) -> str:
    """One method: its resolutions joined, its name at the last."""
    if not points:
        return ""
    name = points[0].method
    places = [(across(p.seconds, span), above(p.error)) for p in points]
    path = " ".join(f"{x:.1f},{y:.1f}" for x, y in places)
    dots = "".join(
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{4 if here else 2.5}">'
        f"<title>{name}, {p.resolution}: {1000 * p.seconds:.2g} ms, error {p.error:.0e}</title>"
        "</circle>"
        for p, (x, y) in zip(points, places, strict=True)
    )
    return (
        f'<g fill="{COLOURS[name]}"><polyline points="{path}" fill="none" '
        f'stroke="{COLOURS[name]}" stroke-width="{2.5 if here else 1.2}"/>{dots}</g>'
    )


def live(solution: Solution, span: tuple[float, float]) -> str:
    """A ring at what the scene itself took and estimates."""
    seconds = min(max(solution.stats.seconds, span[0]), span[1])
    x, y = across(seconds, span), above(relative_error(solution))
    return (
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="6" fill="none" stroke="currentColor" '
        f'stroke-width="1.6"><title>this scene: {escape(used(solution))}</title></circle>'
    )


def names(points: list[Effort], here: str) -> str:
    """The names of the methods at the right, each at the height where its line ends."""
    finest = {point.method: above(point.error) for point in points}
    ends = sorted(finest.items(), key=lambda end: end[1])
    places = within(apart([y for _, y in ends], 13), HEIGHT - BELOW, 13)
    return "".join(
        f'<text x="{WIDTH - RIGHT + 6}" y="{y + 3.5:.1f}" fill="{COLOURS[name]}" '
        f'font-weight="{700 if name == here else 400}">{name}</text>'
        for (name, _), y in zip(ends, places, strict=True)
    )


def within(places: list[float], most: float, least: float) -> list[float]:
    """Ascending places moved down until none is above `most` or nearer than `least` to the next."""
    moved = []
    for place in reversed(places):
        moved.append(min(place, most))
        most = moved[-1] - least
    return moved[::-1]


def failures(points: tuple[Effort, ...]) -> str:
    """Which methods have no place on the chart, and why."""
    reasons = {point.method: point.reason for point in points if point.reason}
    rows = "".join(
        f'<li><b style="color:{COLOURS[name]}">{name}</b>: {escape(reason)}</li>'
        for name, reason in reasons.items()
    )
    return f'<ul style="{SMALL};padding-left:1.2em">{rows}</ul>' if rows else ""
