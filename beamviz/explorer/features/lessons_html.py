"""What the guide says, as HTML: an invitation, the steps of a lesson, how its challenge stands."""

import re
from html import escape

from beamviz.explorer.page.readout import GOOD
from beamviz.lessons.model import Lesson, Verdict

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
