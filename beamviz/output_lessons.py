"""The lessons as text: a list to read, JSON for programs."""

import json
import textwrap
from typing import Any

from beamviz.lessons import LESSONS
from beamviz.lessons.model import Lesson

WIDTH = 88


def to_table() -> str:
    """Each lesson's name, title and question."""
    column = 2 + max(len(lesson.name) for lesson in LESSONS)
    lines = []
    for lesson in LESSONS:
        lines.append(f"{lesson.name:<{column}}{lesson.title}")
        indent = " " * column
        lines += textwrap.wrap(
            lesson.question, WIDTH, initial_indent=indent, subsequent_indent=indent
        )
    return "\n".join(lines)


def to_json() -> str:
    """Everything in the lessons, with the numbers that are computed for them."""
    return json.dumps(
        {"lessons": [fields(lesson) for lesson in LESSONS]}, indent=2, ensure_ascii=False
    )


def fields(lesson: Lesson) -> dict[str, Any]:
    """One lesson under the names of the JSON."""
    challenge = lesson.challenge
    return {
        "name": lesson.name,
        "title": lesson.title,
        "question": lesson.question,
        "do": plain(lesson.do),
        "see": plain(lesson.see),
        "meaning": plain(lesson.meaning),
        "proof": {"words": lesson.proof.words, "numbers": lesson.proof.numbers},
        "challenge": {
            "task": challenge.task,
            "number": challenge.number,
            "within": challenge.within,
            "answers": [challenge.answer],
        },
        "scene": lesson.scene.tables,
    }


def plain(text: str) -> str:
    """Words without their marks."""
    return text.replace("*", "")


FORMATS = {"table": to_table, "json": to_json}
