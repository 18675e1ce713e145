"""The tab Lessons, with a card for each lesson; the open lesson is shown beside the tabs."""

import re
from dataclasses import replace
from functools import cache, partial
from html import escape
from typing import Any

import numpy as np

from beamviz.beam import NUMBERS, Beam
from beamviz.drawing.modes import rotated
from beamviz.errors import BeamvizError
from beamviz.explorer import page
from beamviz.explorer.features.loci_chart import loci_lines
from beamviz.explorer.jobs import SolverAnswer
from beamviz.explorer.state import TABS
from beamviz.explorer.visitor import Feature, Visitor
from beamviz.frequency_loci import loci
from beamviz.lessons import LESSONS, NAMES, lesson
from beamviz.lessons.model import Lesson
from beamviz.scene import Scene
from beamviz.solver import solve

STEPS = ("Try it", "Why", "Challenge")
CHALLENGE = len(STEPS) - 1
FINE_STEPS = "Fine steps: click a slider and use the arrow keys, or type the number beside it."
CONTROLS = {  # named in the texts of lessons: the key of each, or the id of a tab
    **{parameter.slider_label: name for name, parameter in NUMBERS.items()},
    **{name: name for name in ("method", "plane", "strain", "state", "curvature")},
    "Coriolis": "coriolis",
    "Frequencies": "tab-frequencies",
    "Veering": "tab-veering",
}


class Lessons(Feature):
    """The lessons of one visitor; the open lesson and its step are in the state.

    met: names of the lessons whose challenge is met; named: keys of the controls to highlight.
    """

    def __init__(self, visitor: Visitor):
        super().__init__(visitor)
        self.met: frozenset[str] = frozenset()
        self.named: tuple[str, ...] = ()
        self.page.on("lesson", self.open)
        self.page.on("lesson_step", self.go)
        self.page.on("lesson_turn", self.turn)
        self.page.on("lesson_restart", lambda _: visitor.reset())
        for one in LESSONS:
            if one.scene == visitor.state.scene:
                visitor.change(partial(replace, lesson=one.name))
            visitor.command(f"Lesson: {one.title}", partial(self.open, one.name))

    def open(self, name: Any) -> None:
        """Begin the lesson of a name, or with "" leave it; an unknown name changes nothing."""
        if name in NAMES:
            self.visitor.background.submit(partial(self.begin, name))
        elif name == "":
            self.visitor.change(partial(replace, lesson="", step=0))

    def begin(self, name: str, scene: Scene | None = None) -> None:
        """Show a lesson with its own scene or another one. Takes time: its numbers are computed."""
        begun = lesson(name)
        _ = begun.numbers, begun.answer
        scene = (scene or begun.scene).changed(dark=self.visitor.state.view.dark)
        keys = controls(begun.do)
        tabs = [key for key in keys if key.startswith("tab-")]
        self.named = tuple(key for key in keys if key not in tabs)
        tab = tabs[0].removeprefix("tab-") if tabs else TABS[0]
        self.visitor.load(scene, lesson=name, step=0, tab=tab)

    def go(self, step: Any) -> None:
        """Go to a step (0-based) of the open lesson; an unknown one changes nothing."""
        if step in range(len(STEPS)) and self.visitor.state.lesson:
            self.visitor.change(partial(replace, step=int(step)))

    def turn(self, by: Any) -> None:
        """Go to the next (1) or previous (-1) step, from the last or first step to the next or
        previous lesson; without a lesson, to the first or last one."""
        state, names = self.visitor.state, ("", *NAMES)
        if by not in (1, -1):
            return
        if state.lesson and state.step + by in range(len(STEPS)):
            self.go(state.step + by)
        else:
            self.open(names[(names.index(state.lesson) + by) % len(names)])

    def show(self) -> None:
        """Show the cards, and the open lesson with the verdict on its challenge."""
        name, step, named = self.visitor.state.lesson, self.visitor.state.step, self.named
        answer = self.visitor.answer if name and step == CHALLENGE else None
        if not self.redraws(answer, name, step, named):
            return
        verdict = self.check(lesson(name), answer, answer.beam) if answer and answer.beam else ""
        self.page.html("lesson-text", lesson_html(lesson(name), step) if name else "")
        self.page.html("verdict", verdict)
        self.page.props("lesson", hidden=not name)
        self.page.html("tab-lessons", cards_html(name, self.met))
        if name and named:
            self.page.point(*named)
            self.named = ()

    def check(self, lesson: Lesson, answer: SolverAnswer, beam: Beam) -> str:
        """The verdict on a challenge with the present value of its quantity; stores its success."""
        verdict = lesson.check(beam, answer.request.options)
        if verdict.met:
            self.met |= {lesson.name}
        word = "Right!" if verdict.met else "Not yet."
        words = f"<b>{word}</b> {escape(verdict.reason)}"
        if answer.solution and (verdict.met or not verdict.reason):  # no obstacle
            words += f"<br>Now: {escape(lesson.measured(answer.solution))}."
        return f'<p class="verdict{" met" if verdict.met else ""}">{words}</p>'


# Texts


def draw_sketches() -> None:
    """Compute the pictures of the cards, which are stored; this takes some time."""
    for name in NAMES:
        sketch(name)


def cards_html(open_lesson: str, met: frozenset[str]) -> str:
    """A card for each lesson; the open one is marked, those with a challenge met are ticked."""
    text = f"{len(LESSONS)} short lessons, one question each, every one a small experiment."
    text += f" Challenges met: {len(met)} of {len(LESSONS)}." if met else ""
    begin, cards = page.button("Begin", data_do="lesson_turn", data_value=1, data_key="n"), ""
    for k, one in enumerate(LESSONS, 1):
        own = page.attributes(data_do="lesson", data_value=one.name, class_="card")
        own += page.attributes(aria_current=True if one.name == open_lesson else None)
        title = f"<b>{k}. {escape(one.title)}{' ✓' if one.name in met else ''}</b>"
        cards += f'<button type="button"{own}>{sketch(one.name)}{title}</button>'
    return f'<div class="row"><span>{text}</span>{begin}</div><div class="cards">{cards}</div>'


def lesson_html(lesson: Lesson, step: int) -> str:
    """One step of a lesson, without the verdict on its challenge."""
    steps = ""
    for k, name in enumerate(STEPS):
        current, key = "step" if k == step else None, "b" if k == step - 1 else None
        own = {"data_do": "lesson_step", "data_value": k, "aria_current": current, "data_key": key}
        steps += page.button(name, class_="step", **own)
    ahead = page.button("Next ›", data_do="lesson_turn", data_value=1, data_key="n", class_="main")
    restart = {"data_do": "lesson_restart", "title": "Restart", "aria_label": "Restart the lesson"}
    leave = {"data_do": "lesson", "data_value": "", "aria_label": "Leave the lesson"}
    body = (
        f'<p class="question">{formatted(lesson.question)}</p>'
        + f'<p><span class="soft">Do:</span> {formatted(lesson.do)}</p>'
        + f'<p><span class="soft">Look for:</span> {formatted(lesson.see)}</p>',
        f"<p>{formatted(lesson.meaning)}</p>"
        f'<p class="proof"><span class="soft">The number that proves it:</span>'
        f" {escape(lesson.proof)}</p>",
        f'<p class="question">{formatted(lesson.task)}</p><p class="soft">{FINE_STEPS}</p>',
    )[step]
    number = NAMES.index(lesson.name) + 1
    title = f"<h3>{number}. {escape(lesson.title)}</h3>"
    title += page.button("↺", class_="quiet", **restart) + page.button("✕", class_="quiet", **leave)
    choices = page.group("Steps of the lesson", steps, ahead)
    return f'<div class="title">{title}</div>{choices}{body}'


def controls(text: str) -> list[str]:
    """The keys of the controls, and the ids of the tabs, that are named in a text."""
    names = re.findall(r"\*\*(.+?)\*\*", text)
    return [CONTROLS[name] for name in names if name in CONTROLS]


def formatted(text: str) -> str:
    """A text as HTML: **controls** as buttons that highlight them, *technical terms* in italics."""

    def control(match: re.Match[str]) -> str:
        key = CONTROLS.get(match[1])
        if key is None:
            return f"<b>{match[1]}</b>"
        return f'<button type="button" class="link" data-point="{key}">{match[1]}</button>'

    text = re.sub(r"\*\*(.+?)\*\*", control, escape(text))
    return re.sub(r"\*(.+?)\*", r"<i>\1</i>", text)


# Pictures of the cards

WIDTH, HEIGHT = 160, 90
CLAMP, LENGTH = 28, 112  # [px] position of the clamp, length of the beam
MARGIN = 8  # [px] around loci
AMPLITUDE = 0.17  # of the length
X = np.linspace(0.0, 1.0, 41)
TICKS = slice(0, None, 5)  # points of X with a cross-section
POINTS = 41  # of loci
LOCI = {  # lessons with a chart: start and stop of the axis, branches
    "mode-shift": (0.6, 2.4, ("B3", "S1")),
    "crossing": (3.5, 6.0, ("B3", "S1")),
    "veering": (4.2, 5.1, ("B3", "S1")),
    "resonance": (0.0, 14.0, ("B1", "B2", "B3")),
    "paradox": (0.0, 3.5, ("B1",)),
    "buckling": (0.0, 2.99, ("B1",)),
}


@cache
def sketch(name: str) -> str:
    """The SVG picture of a lesson: the mode of its scene, or the loci of its question."""
    shown = lesson(name)
    try:
        drawn = chart(shown) if name in LOCI else mode(shown)
    except BeamvizError:  # of a scene without equilibrium
        drawn = ""
    return f'<svg class="sketch" viewBox="0 0 {WIDTH} {HEIGHT}" aria-hidden="true">{drawn}</svg>'


def mode(shown: Lesson) -> str:
    """The hub, the equilibrium, and the mode with the largest share."""
    scene = shown.scene
    beam, solution = scene.beam, solve(scene.beam, **scene.solver_options)
    k = int(np.argmax(scene.view.shares))
    angle = solution.equilibrium.angle(X)
    moved = rotated(solution.shape(k, X).real, angle)
    rest = solution.equilibrium.position(X)
    points = rest + AMPLITUDE * moved / np.linalg.norm(moved, axis=1).max()
    family = solution.families[k]
    parts = [hub(beam.delta), line(rest, "rest"), line(points, family)]
    if family != "bending":
        normal = 0.05 * rotated(np.array([0.0, 1.0]), angle)
        ticks = np.stack([points - normal, points + normal], axis=1)[TICKS]
        parts += [line(tick, family) for tick in ticks]
    if beam.alpha > 0:
        x, y = place(points[int(np.argmin(abs(X - beam.beta)))])
        parts.append(f'<circle class="mass" cx="{x:.1f}" cy="{y:.1f}" r="5"/>')
    return "".join(parts)


def hub(delta: float) -> str:
    """The axis with the hub around it, or the rim of a beam that points inward."""
    axis, middle = CLAMP - LENGTH * delta, HEIGHT / 2
    radius = max(LENGTH * abs(delta), 10)
    x = axis if delta else CLAMP - 4
    cross = f'<path class="hub" d="M{x - 4:.1f} {middle}h8m-4 -4v8"/>'
    return f'<circle class="hub" cx="{x:.1f}" cy="{middle}" r="{radius:.1f}"/>{cross}'


def chart(shown: Lesson) -> str:
    """Loci of some modes, in the colours of their families, with the multiples of the speed."""
    scene, (start, stop, labels) = shown.scene, LOCI[shown.name]
    values = np.linspace(start, stop, POINTS)
    found = loci(scene.beam, scene.over, values, **scene.options)
    branches = [found[label] for label in labels]
    frequency = np.array([branch.frequency for branch in branches])
    low, high = 0.0 if "B1" in labels else np.nanmin(frequency), np.nanmax(frequency)

    def height(frequency: np.ndarray) -> np.ndarray:
        return HEIGHT - MARGIN - (HEIGHT - 2 * MARGIN) * (frequency - low) / (high - low)

    x = MARGIN + (WIDTH - 2 * MARGIN) * (values - start) / (stop - start)
    parts = [f'<path class="rest" d="M{MARGIN} {MARGIN}V{HEIGHT - MARGIN}H{WIDTH - MARGIN}"/>']
    multiples = (height(k * values) for k in scene.per_rev)
    parts += [page.polyline(x[y >= MARGIN], y[y >= MARGIN], "hub") for y in multiples]
    for locus in loci_lines(found, values, 1.0, branches):
        y = height(np.array(locus["y"], float))
        for first, last, family, _ in locus["runs"]:
            parts.append(page.polyline(x[first : last + 1], y[first : last + 1], family))
    return "".join(parts)


def place(points: np.ndarray) -> np.ndarray:
    """Positions (2, ...) [px] of points (..., 2) from the clamp in lengths of the beam."""
    return np.stack([CLAMP + LENGTH * points[..., 0], HEIGHT / 2 - LENGTH * points[..., 1]])


def line(points: np.ndarray, name: str) -> str:
    """A line through points (n, 2) in lengths of the beam."""
    x, y = place(points)
    return page.polyline(x, y, name)
