"""The guided panel: one lesson after the other, step by step, with a challenge checked live."""

import re
from dataclasses import replace
from functools import partial
from html import escape
from typing import Any

from viser import PanelHandle

from beamviz.explorer.jobs import SolverAnswer
from beamviz.explorer.page.html import GOOD
from beamviz.explorer.visitor import Feature, Visitor, on_edit
from beamviz.explorer.visitor import show as assign
from beamviz.lessons import LESSONS, NAMES
from beamviz.lessons.model import Lesson, Verdict
from beamviz.scene import Scene

STEPS = ("try it", "why", "challenge")
SMALL = "font-size:.85em;line-height:1.45;margin:.35em .75em .5em"
FAINT = "opacity:.7"
LARGE = "font-size:1.1em;font-weight:600;line-height:1.35"
BOX = "border-left:4px solid {};padding:.15em .6em;margin:.5em 0 0"
ACCENT, WAITING = "#2f7fc1", "#9aa0a6"


def invitation(count: int, met: int) -> str:
    """Before a lesson is chosen, and after the last."""
    done = f"<br>Challenges met: {met} of {count}." if met else ""
    return framed(
        f'<div style="{LARGE}">New here?</div>'
        + entry(
            "The picture",
            "a beam, clamped to a turning hub; here it swings slowly and far,"
            " so that one can see it.",
        )
        + entry(
            "The table",
            "the ways it swings on its own, its *modes*. B bends, S stretches;"
            " ω, the *frequency*, says how fast.",
        )
        + entry("The sliders", "what the beam is like. Each move is solved anew.")
        + f'<div style="margin-top:.45em">{count} short lessons, a question each: press'
        f" <b>next</b>, or choose one.{done}</div>"
    )


def page(lesson: Lesson, step: int) -> str:
    """One step of a lesson, without what changes with the beam."""
    return framed(heading(lesson, step) + PAGES[step](lesson))


def heading(lesson: Lesson, step: int) -> str:
    """Where one is: the steps, this one marked; and a link that opens this lesson."""
    names = [f"<b>{name}</b>" if k == step else name for k, name in enumerate(STEPS)]
    return (
        f'<div style="display:flex;justify-content:space-between;{FAINT};margin-bottom:.3em">'
        f"<span>{' &ensp;›&ensp; '.join(names)}</span>"
        f'<a href="?lesson={lesson.name}" title="Opens this lesson: copy it" style="color:inherit">'
        "link</a></div>"
    )


def trying(lesson: Lesson) -> str:
    """The question, what to do, what to look for."""
    return (
        f'<div style="{LARGE}">{marked(lesson.question)}</div>'
        f"{entry('Do', lesson.do)}{entry('Look for', lesson.see)}"
    )


def entry(name: str, text: str) -> str:
    """A paragraph with a name before it."""
    return (
        f'<div style="margin-top:.45em"><span style="{FAINT}">{name}:</span> {marked(text)}</div>'
    )


def why(lesson: Lesson) -> str:
    """What it means, and the number that proves it."""
    return (
        f"<div>{marked(lesson.meaning)}</div>"
        f'<div style="{BOX.format(ACCENT)}"><span style="{FAINT}">The number that proves it:</span>'
        f" {escape(lesson.proof.words)}</div>"
    )


def challenge(lesson: Lesson) -> str:
    """The task, and how to set a slider finely."""
    return (
        f'<div style="{LARGE}">{marked(lesson.challenge.task)}</div>'
        f'<div style="{FAINT};margin-top:.3em">Fine steps: click a slider and use the arrow keys,'
        " or type the number beside it.</div>"
    )


PAGES = (trying, why, challenge)


def standing(verdict: Verdict, gauge: str) -> str:
    """How the challenge stands with the beam as it is."""
    colour, word = (GOOD, "Right!") if verdict.met else (WAITING, "Not yet.")
    now = f"<br>Now: {escape(gauge)}." if gauge else ""
    return framed(
        f'<div role="status" style="{BOX.format(colour)}"><b>{word}</b> {escape(verdict.words)}'
        f"{now}</div>"
    )


def framed(content: str) -> str:
    """With the margins of the panel."""
    return f'<div style="{SMALL}">{content}</div>'


def marked(text: str) -> str:
    """**What is to be found on the page** in bold, *terms of the field* in italics."""
    text = re.sub(r"\*\*(.+?)\*\*", r"<b>\1</b>", escape(text))
    return re.sub(r"\*(.+?)\*", r"<i>\1</i>", text)


NONE = "choose one ..."
BACK, RESET, NEXT = "‹ back", "reset", "next ›"
CHALLENGE = len(STEPS) - 1


class Lessons(Feature):
    """What a visitor reads. Its pages are an invitation (0) and the steps of every lesson."""

    def __init__(self, visitor: Visitor, results: PanelHandle):
        super().__init__(visitor)
        gui, self.lock = visitor.client.gui, visitor.lock
        self.page = 0
        self.met: set[int] = set()
        self.answer: SolverAnswer | None = None
        self.panel = gui.add_panel()
        with self.panel.add_tab("Lessons"):
            self.choice = gui.add_dropdown("lesson", self.titles, hint="A question about the beam")
            turn = gui.add_button_group("page", (BACK, RESET, NEXT))
            self.text, self.standing = gui.add_html(""), gui.add_html("")
        on_edit(self.choice, self.choose)
        turn.on_click(lambda event: self.turn(event.target.value))
        self.panel.dock_below(results)
        self.begin(visitor.state.scene)
        self.add_commands()

    @property
    def titles(self) -> tuple[str, ...]:
        """The choices of a lesson; those whose challenge has been met are ticked."""
        ticks = ("✓ " if k in self.met else "" for k in range(len(LESSONS)))
        named = zip(ticks, LESSONS, strict=True)
        return (NONE, *(f"{k}  {tick}{one.title}" for k, (tick, one) in enumerate(named, 1)))

    @property
    def place(self) -> tuple[int, int] | None:
        """Which lesson and which of its steps (from 0) is open, if one is."""
        return divmod(self.page - 1, len(STEPS)) if self.page else None

    @property
    def lesson(self) -> Lesson | None:
        """The lesson that is open."""
        return LESSONS[self.place[0]] if self.place else None

    # What the visitor chooses.

    def begin(self, scene: Scene) -> None:
        """Begin the lesson that has this scene, or none."""
        k = next((k for k, lesson in enumerate(LESSONS) if lesson.scene == scene), None)
        self.page = 0 if k is None else 1 + len(STEPS) * k
        self.first = scene
        self.show_page()

    def opened(self, name: str, _: object) -> None:
        """A command of a lesson was run."""
        self.open(name)

    def open(self, name: str) -> None:
        """Begin the lesson of that name."""
        self.go(1 + len(STEPS) * NAMES.index(name))

    def choose(self, title: Any) -> None:
        """A lesson was chosen by its title."""
        if title in self.titles:
            k = self.titles.index(title)
            self.go(1 + len(STEPS) * (k - 1) if k else 0)

    def turn(self, button: Any) -> None:
        """One of the buttons was pressed."""
        if button == RESET:
            self.reset()
        elif button in (BACK, NEXT):
            self.step(1 if button == NEXT else -1)

    def step(self, pages: int) -> None:
        """Turn some pages on or back; behind the last one is the first."""
        self.go(max(self.page + pages, 0) % (1 + len(STEPS) * len(LESSONS)))

    def reset(self) -> None:
        """The scene as it is at the start of the lesson, or was when the page was opened."""
        self.visitor.reset()

    def add_commands(self) -> None:
        """Keys that turn the pages, and a command for each lesson."""
        add = self.visitor.client.gui.add_command
        add("Lesson: next page", hotkey="N").on_trigger(lambda _: self.step(1))
        add("Lesson: previous page", hotkey="B").on_trigger(lambda _: self.step(-1))
        for one in LESSONS:
            add(f"Lesson: {one.title}").on_trigger(partial(self.opened, one.name))

    def go(self, page: int) -> None:
        """Open a page; a lesson begins with a scene of its own."""
        if page:
            prepare(LESSONS[(page - 1) // len(STEPS)])
        with self.lock:
            before, self.page = self.lesson, page
            if self.lesson and self.lesson is not before:
                self.panel.expand()
                dark = self.visitor.state.view.dark
                self.visitor.load(self.lesson.scene.changed(dark=dark), home=self.lesson.scene)
            elif before and not self.lesson:
                self.visitor.change(lambda state: replace(state, home=self.first))
            self.show_page()

    # What is told.

    @property
    def inputs(self) -> tuple:
        """The answer that is judged."""
        return (self.visitor.answer,)

    def show_page(self) -> None:
        """Show the page that is open."""
        with self.lock:
            assign(self.choice, self.titles[self.place[0] + 1 if self.place else 0])
            if self.place and self.lesson:
                self.text.content = page(self.lesson, self.place[1])
            else:
                self.text.content = invitation(len(LESSONS), len(self.met))
            self.judge()

    def show(self) -> None:
        """Judge the beam that an answer is about."""
        with self.lock:
            self.answer = self.visitor.answer
            self.judge()

    def judge(self) -> None:
        """Say how the challenge stands, where it is open."""
        content = ""
        if self.place and self.place[1] == CHALLENGE and self.answer and self.answer.beam:
            content = self.verdict(LESSONS[self.place[0]], self.answer)
        if content != self.standing.content:
            self.standing.content = content

    def verdict(self, lesson: Lesson, answer: SolverAnswer) -> str:
        """How the challenge of a lesson stands with an answer."""
        assert answer.beam
        verdict = lesson.check(answer.beam, answer.request.options)
        if verdict.met and LESSONS.index(lesson) not in self.met:
            self.met.add(LESSONS.index(lesson))
            self.choice.options = self.titles
            assign(self.choice, self.titles[LESSONS.index(lesson) + 1])
        astray = verdict.words and not verdict.met
        gauge = lesson.measured(answer.solution) if answer.solution and not astray else ""
        return standing(verdict, gauge)


def prepare(lesson: Lesson) -> tuple[float, ...]:
    """Compute the numbers of a lesson, here rather than in the thread that draws for all."""
    return (*lesson.proof.numbers, lesson.challenge.answer)
