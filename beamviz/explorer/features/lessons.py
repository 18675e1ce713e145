"""The tab Lessons, with a card for each lesson; the open lesson is shown beside the tabs."""

import re
from dataclasses import replace
from functools import partial
from html import escape
from typing import Any

from beamviz.beam import NUMBERS, Beam
from beamviz.explorer.jobs import SolverAnswer
from beamviz.explorer.page.html import attributes, button, group
from beamviz.explorer.visitor import Feature, Visitor
from beamviz.lessons import LESSONS, NAMES, lesson
from beamviz.lessons.model import Lesson
from beamviz.lessons.sketches import sketch
from beamviz.scene import Scene

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

    met: names of the lessons whose challenge has been met; named: keys of the controls that are to
    be highlighted when the lesson is shown.
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
        """Show a lesson with its own scene or another one; called on a worker thread, as its
        numbers are computed first."""
        begun = lesson(name)
        _ = begun.numbers, begun.answer
        scene = (scene or begun.scene).changed(dark=self.visitor.state.view.dark)
        keys = controls(begun.do)
        tabs = [key for key in keys if key.startswith("tab-")]
        self.page.open([*tabs, "tab-frequencies"][0])
        self.named = tuple(key for key in keys if key not in tabs)
        self.visitor.load(scene, lesson=name, step=0)

    def go(self, step: Any) -> None:
        """Go to a step (0-based) of the open lesson; an unknown one changes nothing."""
        if step in range(len(STEPS)) and self.visitor.state.lesson:
            self.visitor.change(partial(replace, step=int(step)))

    def turn(self, by: Any) -> None:
        """Go to the next (1) or previous (-1) step, from the last or first step to the next or
        previous lesson; without a lesson, to the first or last one."""
        state = self.visitor.state
        if by not in (1, -1):
            return
        here = NAMES.index(state.lesson) if state.lesson else -1 if by == 1 else len(NAMES)
        step = state.step + by if state.lesson else -1
        if step in range(len(STEPS)):
            self.go(step)
        elif here + by in range(len(NAMES)):
            self.open(NAMES[here + by])
        else:
            self.open("")

    @property
    def inputs(self) -> tuple[SolverAnswer | None, str, int, tuple[str, ...]]:
        state = self.visitor.state
        answer = self.visitor.answer if state.lesson and state.step == CHALLENGE else None
        return answer, state.lesson, state.step, self.named

    def show(self) -> None:
        """Show the cards, and the open lesson with the verdict on its challenge."""
        answer, name, step, named = self.inputs
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
    done = f" Challenges met: {len(met)} of {len(LESSONS)}." if met else ""
    return (
        f'<div class="row"><span>{len(LESSONS)} short lessons, one question each, every one a small'
        f" experiment.{done}</span>"
        + button("Begin", data_do="lesson_turn", data_value=1, data_key="n")
        + '</div><div class="cards">'
        + "".join(
            f'<button type="button" class="card"'
            f"{attributes(data_do='lesson', data_value=one.name)}"
            f"{' aria-current=true' if one.name == open_lesson else ''}>{sketch(one.name)}"
            f"<b>{k}. {escape(one.title)}{' ✓' if one.name in met else ''}</b></button>"
            for k, one in enumerate(LESSONS, 1)
        )
        + "</div>"
    )


def lesson_html(lesson: Lesson, step: int) -> str:
    """One step of a lesson, without the verdict on its challenge."""
    steps = "".join(
        button(
            name, data_do="lesson_step", data_value=k, class_="step",
            aria_current="step" if k == step else None, data_key="b" if k == step - 1 else None,
        )
        for k, name in enumerate(STEPS)
    )  # fmt: skip
    forward = button("Next ›", data_do="lesson_turn", data_value=1, data_key="n", class_="main")
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
    return (
        f'<div class="title"><h3>{number}. {escape(lesson.title)}</h3>'
        f"{button('Restart', data_do='lesson_restart', class_='quiet')}"
        f"{button('✕', class_='quiet', **leave)}</div>"
        f"{group('Steps of the lesson', steps, forward)}{body}"
    )


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
