"""The panel of lessons: one after the other, step by step, with a challenge checked live."""

import re
from collections.abc import Collection
from dataclasses import replace
from functools import partial
from html import escape
from typing import Any

from viser import PanelHandle

from beamviz.beam import Beam
from beamviz.explorer.jobs import SolverAnswer
from beamviz.explorer.page.html import GOOD
from beamviz.explorer.visitor import Feature, Visitor, on_edit, on_press
from beamviz.explorer.visitor import show as show_value
from beamviz.lessons import LESSONS, NAMES
from beamviz.lessons.model import Lesson
from beamviz.server.viser_private import set_html

STEPS = ("try it", "why", "challenge")
CHALLENGE = len(STEPS) - 1
PAGES = 1 + len(STEPS) * len(LESSONS)  # an introduction, then the steps of every lesson
NO_LESSON = "choose one ..."
BACK, RESET, NEXT = "‹ back", "reset", "next ›"
FAINT = "opacity:.7"
LARGE = "font-size:1.1em;font-weight:600;line-height:1.35"
BOX = "border-left:4px solid {};padding:.15em .6em;margin:.5em 0 0"
ACCENT, WAITING = "#2f7fc1", "#9aa0a6"
INTRODUCTION = (
    (
        "The picture",
        "a beam clamped to a rotating hub. Its vibration is slowed down and enlarged.",
    ),
    (
        "The table",
        "its *natural modes*: shapes in which it vibrates freely, each at its own *frequency* ω."
        " B: bending, S: stretching.",
    ),
    ("The sliders", "the properties of the beam. Every change is solved at once."),
)
FINE_STEPS = "Fine steps: click a slider and use the arrow keys, or type the number beside it."


class Lessons(Feature):
    """The lessons of one visitor. page: 0 for the introduction, then the steps of every lesson;
    met: lessons, from 0, whose challenge has been met."""

    def __init__(self, visitor: Visitor, results: PanelHandle):
        super().__init__(visitor)
        gui = visitor.client.gui
        self.first = scene = visitor.state.scene
        self.met: set[int] = set()
        number = next((k for k, one in enumerate(LESSONS) if one.scene == scene), None)
        self.page = 0 if number is None else first_page(number)
        self.panel = gui.add_panel()
        with self.panel.add_tab("Lessons"):
            hint = "A question about the beam"
            self.choice = gui.add_dropdown("lesson", titles(self.met), hint=hint)
            buttons = gui.add_button_group("page", (BACK, RESET, NEXT))
            self.text, self.verdict = gui.add_html(""), gui.add_html("")
        self.panel.dock_below(results)
        on_edit(self.choice, self.choose)
        on_press(buttons, self.press)
        gui.add_command("Lesson: next page", hotkey="N").on_trigger(lambda _: self.press(NEXT))
        gui.add_command("Lesson: previous page", hotkey="B").on_trigger(lambda _: self.press(BACK))
        for lesson in LESSONS:
            command = gui.add_command(f"Lesson: {lesson.title}")
            command.on_trigger(partial(lambda name, _: self.open(name), lesson.name))
        self.show_page()

    @property
    def number(self) -> int | None:
        """The lesson that is open, from 0."""
        return (self.page - 1) // len(STEPS) if self.page else None

    @property
    def step(self) -> int:
        """The step of the open lesson, from 0."""
        return (self.page - 1) % len(STEPS)

    def open(self, name: str) -> None:
        """Begin a lesson by its name."""
        self.go(first_page(NAMES.index(name)))

    def choose(self, title: Any) -> None:
        """Begin a lesson by its title; an unknown one changes nothing."""
        choices = titles(self.met)
        if title in choices:
            self.submit(first_page(choices.index(title) - 1) if title != NO_LESSON else 0)

    def press(self, button: Any) -> None:
        """Turn a page (the introduction follows the last one) or reset the scene; an unknown
        button changes nothing."""
        if button == RESET:
            self.visitor.reset()
        elif button in (BACK, NEXT):
            self.submit(max(self.page + (1 if button == NEXT else -1), 0) % PAGES)

    def submit(self, page: int) -> None:
        """Go to a page on a worker thread: the numbers of a lesson take time to compute."""
        self.visitor.background.submit(partial(self.go, page))

    def go(self, page: int) -> None:
        """Go to a page; a lesson starts with its own scene."""
        if page:
            lesson = LESSONS[(page - 1) // len(STEPS)]
            _ = lesson.proof.numbers, lesson.challenge.answer  # computed here, and kept
        with self.visitor.lock:
            before, self.page = self.number, page
            if self.number is not None and self.number != before:
                self.panel.expand()
                scene, dark = LESSONS[self.number].scene, self.visitor.state.view.dark
                self.visitor.load(scene.changed(dark=dark), home=scene)
            elif self.number is None and before is not None:
                self.visitor.change(lambda state: replace(state, home=self.first))
            self.show_page()

    def show_page(self) -> None:
        """Show the page that is open."""
        with self.visitor.lock:
            number = self.number
            show_value(self.choice, titles(self.met)[0 if number is None else number + 1])
            if number is None:
                self.text.content = introduction(len(self.met))
            else:
                self.text.content = lesson_html(LESSONS[number], self.step)
            self.show()

    @property
    def inputs(self) -> tuple[object, ...]:
        """The answer that the challenge is checked with."""
        return (self.visitor.answer,)

    def show(self) -> None:
        """Show whether the challenge is met, where one is open."""
        with self.visitor.lock:
            answer, content = self.visitor.answer, ""
            if self.number is not None and self.step == CHALLENGE and answer and answer.beam:
                content = self.check(self.number, answer, answer.beam)
            set_html(self.verdict, content)

    def check(self, number: int, answer: SolverAnswer, beam: Beam) -> str:
        """Check the challenge of a lesson with an answer, and note where it is met: the verdict,
        and the quantity to watch."""
        lesson = LESSONS[number]
        verdict = lesson.check(beam, answer.request.options)
        if verdict.met and number not in self.met:
            self.met.add(number)
            self.choice.options = titles(self.met)
            show_value(self.choice, titles(self.met)[number + 1])
        colour, word = (GOOD, "Right!") if verdict.met else (WAITING, "Not yet.")
        words = f"<b>{word}</b> {escape(verdict.words)}"
        if answer.solution and (verdict.met or not verdict.words):  # nothing is in the way
            words += f"<br>Now: {escape(lesson.measured(answer.solution))}."
        return framed(f'<div role="status" style="{BOX.format(colour)}">{words}</div>')


def first_page(number: int) -> int:
    """The first page of a lesson (from 0)."""
    return 1 + len(STEPS) * number


# Texts


def titles(met: Collection[int]) -> tuple[str, ...]:
    """The choices of the dropdown; lessons whose challenge has been met are ticked."""
    ticked = (f"{'✓ ' if k in met else ''}{lesson.title}" for k, lesson in enumerate(LESSONS))
    return (NO_LESSON, *(f"{k}  {title}" for k, title in enumerate(ticked, 1)))


def introduction(met: int) -> str:
    """The page before the first lesson and after the last; `met`: number of challenges met."""
    count = len(LESSONS)
    done = f"<br>Challenges met: {met} of {count}." if met else ""
    return framed(
        f'<div style="{LARGE}">New here?</div>'
        + "".join(entry(*one) for one in INTRODUCTION)
        + f'<div style="margin-top:.45em">{count} short lessons, one question each: press'
        f" <b>next</b>, or choose one.{done}</div>"
    )


def lesson_html(lesson: Lesson, step: int) -> str:
    """One step of a lesson, without the verdict on its challenge."""
    names = [f"<b>{name}</b>" if k == step else name for k, name in enumerate(STEPS)]
    large = f'<div style="{LARGE}">{{}}</div>'
    body = (
        large.format(formatted(lesson.question))
        + entry("Do", lesson.do)
        + entry("Look for", lesson.see),
        f"<div>{formatted(lesson.meaning)}</div>"
        f'<div style="{BOX.format(ACCENT)}"><span style="{FAINT}">The number that proves it:</span>'
        f" {escape(lesson.proof.words)}</div>",
        large.format(formatted(lesson.challenge.task))
        + f'<div style="{FAINT};margin-top:.3em">{FINE_STEPS}</div>',
    )[step]
    return framed(
        f'<div style="display:flex;justify-content:space-between;{FAINT};margin-bottom:.3em">'
        f"<span>{' &ensp;›&ensp; '.join(names)}</span>"
        f'<a href="?lesson={lesson.name}" title="Opens this lesson: copy it" style="color:inherit">'
        f"link</a></div>{body}"
    )


def entry(name: str, text: str) -> str:
    """A paragraph with a name before it."""
    name = f'<span style="{FAINT}">{name}:</span>'
    return f'<div style="margin-top:.45em">{name} {formatted(text)}</div>'


def framed(content: str) -> str:
    """With the margins of the panel."""
    return f'<div style="font-size:.85em;line-height:1.45;margin:.35em .75em .5em">{content}</div>'


def formatted(text: str) -> str:
    """**Controls of the page** in bold, *technical terms* in italics."""
    text = re.sub(r"\*\*(.+?)\*\*", r"<b>\1</b>", escape(text))
    return re.sub(r"\*(.+?)\*", r"<i>\1</i>", text)
