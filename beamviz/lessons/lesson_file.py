"""The lesson of a teacher as data: scenes in order, each with a sentence and a question; as a TOML
file, and as a text in a link.

    title = "Why do blades stiffen?"

    [[step]]
    link = "alpha=1&gamma=10&mode=1"         # a scene as its link has it, or tables [step.scene]
    say = "The same beam, ten times faster."
    ask = "How does its first frequency change?"
    answers = ["It rises.", "It falls.", "It stays."]
    right = 1
"""

import base64
import hashlib
import json
import zlib
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any, Self
from urllib.parse import parse_qsl

from beamviz.checks import check_int
from beamviz.errors import InvalidInput
from beamviz.input_files import MAX_TOML_BYTES, check_keys, errors_of_file, parse_toml, read_small
from beamviz.scene import MAX_LINK, Scene, toml_table, toml_value

MAX_STEPS = 20
MAX_CHARACTERS = {"title": 80, "say": 500, "ask": 300, "answers": 100, "link": MAX_LINK}
LEAST_ANSWERS, MOST_ANSWERS = 2, 4
LESSON_KEY, STEP_KEY = "own_lesson", "own_step"  # of links
FILE_KEYS = ("title", "step")
STEP_KEYS = ("link", "scene", "say", "ask", "answers", "right")
HEADER = """\
# A lesson of beamviz: `beamviz serve --lesson FILE`, or drop it on the page.
# Each step has a scene (its link, or tables [step.scene] as a scene file has them) and, all
# optional, a sentence, a question with 2 to 4 answers, and the number of the right one.
"""


@dataclass(frozen=True)
class LessonStep:
    """A scene, by the query of its link, with a sentence and a question; right: the index of the
    right answer, None where none is."""

    link: str
    say: str = ""
    ask: str = ""
    answers: tuple[str, ...] = ()
    right: int | None = None

    @property
    def key(self) -> str:
        """A short text that only this question about this scene has."""
        content = json.dumps([self.link, self.ask, self.answers])
        return hashlib.sha256(content.encode()).hexdigest()[:12]

    @property
    def choices(self) -> tuple[str, ...]:
        """The answers to choose from; none while only one is written."""
        return self.answers if len(self.answers) >= LEAST_ANSWERS else ()

    def with_answer(self, k: int, text: str) -> Self:
        """With another text of an answer (from 0); "" removes it."""
        known = (*self.answers, *[""] * (MOST_ANSWERS - len(self.answers)))
        texts = [text if i == k else one for i, one in enumerate(known)]
        right = self.right
        if right is not None:
            right = sum(map(bool, texts[:right])) if texts[right] else None
        return replace(self, answers=tuple(filter(None, texts)), right=right)

    @property
    def table(self) -> dict[str, Any]:
        """It as a table of a file."""
        texts = {"link": self.link, "say": self.say, "ask": self.ask}
        table: dict[str, Any] = {key: text for key, text in texts.items() if text or key == "link"}
        if self.choices:
            table["answers"] = list(self.choices)
            table |= {} if self.right is None else {"right": self.right + 1}
        return table

    @classmethod
    def of_table(cls, table: Any) -> Self:
        """The step of a table of a file. Raises InvalidInput."""
        if not isinstance(table, dict):
            raise InvalidInput(f"{table!r}: must be a table [[step]]")
        check_keys(table, STEP_KEYS, "[[step]]")
        texts = {key: checked_text(key, table.get(key, "")) for key in ("say", "ask")}
        answers, right = checked_answers(table.get("answers", [])), table.get("right")
        if right is not None:
            if not answers:
                raise InvalidInput(f"right = {right!r}: there are no answers; add answers")
            right = check_int("right", right, 1, len(answers)) - 1
        return cls(scene_link(table), answers=answers, right=right, **texts)


@dataclass(frozen=True)
class OwnLesson:
    """The steps of a lesson, in order."""

    steps: tuple[LessonStep, ...] = ()
    title: str = ""

    def with_step(self, k: int, **values: Any) -> Self:
        """With other values of the step k (from 0)."""
        return self.with_steps(
            replace(step, **values) if i == k else step for i, step in enumerate(self.steps)
        )

    def with_steps(self, steps: Iterable[LessonStep]) -> Self:
        return replace(self, steps=tuple(steps))

    def to_toml(self) -> str:
        """It as the text of a TOML file."""
        title = f"title = {toml_value(self.title)}\n" if self.title else ""
        return title + "".join(toml_table("[[step]]", step.table) for step in self.steps)

    @property
    def contents(self) -> bytes:
        """The contents of its file."""
        return f"{HEADER}\n{self.to_toml()}".encode()

    @classmethod
    def from_toml(cls, path: str | Path) -> Self:
        """The lesson in a TOML file. Raises InvalidInput, which names the file and the mistake."""
        return cls.from_bytes(read_small(path), str(path))

    @classmethod
    def from_bytes(cls, text: bytes, name: str) -> Self:
        """The lesson in the contents of a TOML file with a name. Raises InvalidInput."""
        data = parse_toml(text, name)
        check_keys(data, FILE_KEYS, name)
        tables = data.get("step", [])
        with errors_of_file(name):
            title = checked_text("title", data.get("title", ""))
            if not isinstance(tables, list):
                raise InvalidInput(f"step = {tables!r}: must be tables [[step]]")
            if not tables:
                raise InvalidInput("a lesson has at least one table [[step]]; add one")
            if len(tables) > MAX_STEPS:
                raise InvalidInput(
                    f"{len(tables)} tables [[step]]: a lesson has at most {MAX_STEPS};"
                    " make two lessons of it"
                )
        steps = []
        for k, table in enumerate(tables, 1):
            with errors_of_file(f"{name}, step {k}"):
                steps.append(LessonStep.of_table(table))
        return cls(tuple(steps), title)


NO_LESSON = OwnLesson()


def check_size(lesson: OwnLesson, before: OwnLesson = NO_LESSON) -> None:
    """Check that the file of a lesson can be opened again; one that is too large already may become
    smaller. Raises InvalidInput."""
    size = len(lesson.contents)
    if size > max(MAX_TOML_BYTES, len(before.contents)):
        raise InvalidInput(
            f"the file of a lesson has at most {MAX_TOML_BYTES} bytes, this one would have {size};"
            " make two lessons of it"
        )


def checked_text(name: str, value: Any) -> str:
    """A text without blanks around it and not too long. Raises InvalidInput."""
    most = MAX_CHARACTERS[name]
    if not isinstance(value, str):
        raise InvalidInput(f"{name} = {value!r}: must be a text of at most {most} characters")
    text = value.strip()
    if len(text) > most:
        start = f"{text[:30]} …"
        raise InvalidInput(f"{name} = {start!r}: has {len(text)} characters; shorten it to {most}")
    return text


def checked_answers(values: Any) -> tuple[str, ...]:
    """The answers to a question; () for none. Raises InvalidInput."""
    is_list = isinstance(values, list) and all(isinstance(one, str) for one in values)
    if not is_list or (values and not LEAST_ANSWERS <= len(values) <= MOST_ANSWERS):
        raise InvalidInput(
            f"answers = {values!r}: must be {LEAST_ANSWERS} to {MOST_ANSWERS} texts, or be left out"
        )
    answers = tuple(checked_text("answers", one) for one in values)
    if not all(answers):
        raise InvalidInput(f"answers = {values!r}: an answer is empty; write it or remove it")
    if len({*answers}) < len(answers):
        raise InvalidInput(f"answers = {values!r}: two answers are the same; change one")
    return answers


def scene_link(table: dict[str, Any]) -> str:
    """The query of the link to the scene of a step, which its table has as `link` or as the tables
    of a scene file. Raises InvalidInput; the values of a link are checked where it is opened."""
    if ("link" in table) == ("scene" in table):
        raise InvalidInput("a step has a scene: either link or tables [step.scene]")
    if "scene" in table:
        if not isinstance(table["scene"], dict):
            raise InvalidInput(f"scene = {table['scene']!r}: must be a table [step.scene]")
        if "second" in table["scene"]:
            raise InvalidInput("scene: a second beam is not taken; use link, with compare=...")
        return Scene.from_tables(table["scene"], "scene").to_query()
    text = checked_text("link", table["link"])
    link = text.partition("?")[2] or text  # of an address, or of its query
    for key, _ in parse_qsl(link, keep_blank_values=True):
        if key in (LESSON_KEY, STEP_KEY):
            raise InvalidInput(f"link: has the key {key!r}: a step of a lesson has no lesson in it")
    return link


# A lesson in a link: its file, compressed, in characters that an address has as they are


@lru_cache(64)
def packed(lesson: OwnLesson) -> str:
    """The text of a lesson in a link."""
    compressed = zlib.compress(lesson.to_toml().encode(), 9)
    return base64.urlsafe_b64encode(compressed).decode().rstrip("=")


def unpacked(text: Any) -> OwnLesson:
    """The lesson of the value of a link. Raises InvalidInput."""
    return unpacked_text(str(text))


@lru_cache(64)
def unpacked_text(text: str) -> OwnLesson:
    """The lesson of a text in a link. Raises InvalidInput."""
    shown = f"{LESSON_KEY} = {text[:20]!r} …"
    try:
        data = base64.b64decode(text + -len(text) % 4 * "=", b"-_", validate=True)
        stream = zlib.decompressobj()
        content = stream.decompress(data, MAX_TOML_BYTES + 1)
        if not stream.eof and len(content) <= MAX_TOML_BYTES:
            raise ValueError("cut off")
    except (ValueError, zlib.error):
        raise InvalidInput(f"{shown}: is not a whole lesson; copy the link again") from None
    return OwnLesson.from_bytes(content, LESSON_KEY)
