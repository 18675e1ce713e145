"""Lessons of a teacher's own, shown beside the tabs as the other lessons are, from a link or a file
(`beamviz.lessons.lesson_file`). Answers stay in the browser; in a lecture the presenter sees how
many have chosen which.
"""

import re
import secrets
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from html import escape
from typing import Any, NamedTuple, Self

from beamviz.explorer import page
from beamviz.explorer.declarations import Key, choice, count_key
from beamviz.explorer.feature import Feature
from beamviz.explorer.features.lessons import OWN_STEP, LessonState, formatted, left, outside
from beamviz.explorer.page import Content
from beamviz.explorer.snapshot import Snapshot
from beamviz.explorer.state import Slice, State
from beamviz.explorer.visitor import Visitor
from beamviz.input_files import errors_of_file
from beamviz.lessons.lesson_file import (
    LESSON_KEY,
    MAX_STEPS,
    STEP_KEY,
    LessonStep,
    OwnLesson,
    packed,
    unpacked,
)

MOST_REPLACED = 5  # lessons that can be brought back
MOST_KEPT = 200  # answers of earlier lessons that a browser keeps
KEPT_ANSWER = re.compile(r"([0-9a-f]{12}):([0-3])")
VOTER = re.compile(r"[a-z0-9]{1,20}")
STEP_TABLE = re.compile(r"^[ \t]*\[\[[ \t]*step[ \t]*\]\]", re.MULTILINE)
SENT = "Your answer is sent; you can change it."
KEPT = "Your answer stays in this browser."
REPLACED = "The lesson has replaced your scene."
RIGHT, WRONG = "Right!", "Not quite: look at the scene again, and choose another answer."


class ShownStep(NamedTuple):
    """A step (from 0) of a lesson that is shown."""

    lesson: OwnLesson
    place: int

    @property
    def step(self) -> LessonStep:
        return self.lesson.steps[self.place]


@dataclass(frozen=True)
class OwnLessonState(Slice):
    """A lesson of the visitor's own, which is written, or shown from a link or a file."""

    own_lesson: OwnLesson = field(
        default=OwnLesson(),
        metadata=choice(
            key=Key(LESSON_KEY, unpacked, packed, is_long=True), undo="keeps", led="keeps"
        ),
    )
    # The step that is shown, from 0; None while the lesson is not.
    own_step: int | None = field(
        default=None,
        metadata=choice(
            key=replace(count_key(STEP_KEY, MAX_STEPS), is_long=True),
            led="ends",
            until=("lesson", "opened"),
        ),
    )
    # The step that is shown of a presenter's lesson, also after they are no longer followed.
    followed: ShownStep | None = field(default=None, metadata=choice(until=("lesson", "opened")))
    # Lessons that others have replaced, the latest last.
    replaced_lessons: tuple[OwnLesson, ...] = field(
        default=(), metadata=choice(undo="keeps", led="keeps")
    )
    # The step whose fields are shown, from 0.
    own_edited: int = field(
        default=0,
        metadata=choice(
            key=replace(count_key("own_edited", MAX_STEPS), is_long=True), undo="keeps", led="keeps"
        ),
    )
    # The step that was removed last, with its place.
    own_removed: tuple[int, LessonStep] | None = field(
        default=None, metadata=choice(undo="keeps", led="keeps")
    )
    # The answers (from 0) chosen in this browser, by the keys of their steps, the latest last.
    own_answers: tuple[tuple[str, int], ...] = field(
        default=(), metadata=choice(undo="keeps", led="keeps")
    )
    # A presenter shows which answer is right.
    answer_shown: bool = field(default=False, metadata=choice(undo="keeps", until=("scene",)))

    @property
    def shown_step(self) -> ShownStep | None:
        """The step that is shown, None without one; after an undo the last one where those after it
        were removed."""
        steps = self.own_lesson.steps
        if self.followed or self.own_step is None or not steps:
            return self.followed
        return ShownStep(self.own_lesson, min(self.own_step, len(steps) - 1))

    def led(self, presenter: Self) -> Self:
        return replace(self, followed=presenter.shown_step)

    def at_step(self, k: int) -> Self:
        """At another step (from 0) of the lesson that is shown, or else of the visitor's own."""
        if self.followed:
            return replace(self, followed=self.followed._replace(place=k), answer_shown=False)
        return replace(self, own_step=k, answer_shown=False)


class LessonPlayer(Feature):
    """The step that is shown of a lesson, its question, and the answers to that."""

    style = "lesson_player.css"
    state = OwnLessonState

    def __init__(self, visitor: Visitor):
        super().__init__(visitor)
        self.voter = ""  # the name by which the visitor votes, of their browser or a random one
        on = self.page.on
        on("own.go", self.go, int)
        on("own.turn", self.turn, int)
        on("own.answer", self.answer, int)
        on("own.show_answer", lambda _: visitor.update(with_answer_switched))
        on("answers", self.take_answers, str, max_text=20 * MOST_KEPT)

    def content(self, snapshot: Snapshot) -> Content:
        state = snapshot.state
        with_votes = snapshot if self.visitor.presents else None
        shown = player_html(state, with_votes, is_led=snapshot.is_led)
        answers = [f"{key}:{answer}" for key, answer in own_state(state).own_answers]
        return page.html(OWN_STEP, shown) | {("answers",): answers}

    def go(self, k: Any) -> None:
        """Show a step (from 0) of the visitor's own lesson; an unknown one changes nothing."""
        with self.visitor.lock:
            state = self.visitor.state
            if k in range(len(own_state(state).own_lesson.steps)):
                self.show(state.with_values(OwnLessonState, followed=None), int(k))

    def show(self, state: State, k: int) -> None:
        """Show a step (from 0) of the lesson that a state shows, or else of the visitor's own, with
        its scene."""
        visitor, now = self.visitor, own_state(state).at_step(k)
        shown = now.shown_step
        with visitor.lock, visitor.reporting("The scene of this step cannot be shown"):
            if shown is None:
                return
            begun = at_step(state, visitor.links.read(state, shown.step.link), k)
            in_lesson = state.slice(LessonState).before_lesson is not None
            said = "" if in_lesson else REPLACED
            visitor.change(lambda _: begun, loads=True, replaced=said)

    def turn(self, by: Any) -> None:
        """Go to the next (1) or previous (-1) step; after the last one the lesson is left."""
        with self.visitor.lock:
            state = self.visitor.state
            shown = own_state(state).shown_step
            if by not in (1, -1) or shown is None:
                return
            k = shown.place + by
            if k >= len(shown.lesson.steps):
                self.visitor.change(left, loads=True)
            elif k >= 0:
                self.show(state, k)

    def answer(self, k: Any) -> None:
        """Choose an answer (from 0) to the question that is shown: no edit of the scene. After a
        presenter has shown which one is right, none is taken."""
        with self.visitor.lock:
            state = self.visitor.state
            shown = own_state(state).shown_step
            if shown is None or k not in range(len(shown.step.choices)):
                return
            step = shown.step
            if state.following and is_closed(own_state(state), step):
                return
            self.visitor.update(partial(with_answers, answers={step.key: int(k)}))
            self.vote({step.key: int(k)})

    def take_answers(self, text: Any) -> None:
        """Take the name by which the browser votes, which a session does not change, and the
        answers that the browser has kept from before."""
        voter, *kept = str(text).split() or [""]
        if not self.voter and VOTER.fullmatch(voter):
            self.voter = voter
        matches = (KEPT_ANSWER.fullmatch(entry) for entry in kept[-MOST_KEPT:])
        answers = {match[1]: int(match[2]) for match in matches if match}
        self.visitor.update(partial(with_answers, answers=answers))
        self.vote(answers)

    def vote(self, answers: Mapping[str, int]) -> None:
        """Send answers to the presenter, by the keys of their steps."""
        if not self.visitor.may_follow:
            return
        self.voter = self.voter or secrets.token_hex(8)
        for key, answer in answers.items():
            self.visitor.votes.cast(self.voter, key, answer)


# The state


def own_state(state: State) -> OwnLessonState:
    return state.slice(OwnLessonState)


def is_closed(now: OwnLessonState, step: LessonStep) -> bool:
    """Whether a presenter shows which answer to the question of a step is right."""
    return now.answer_shown and step.right is not None


def with_lesson(state: State, lesson: OwnLesson, edited: int) -> State:
    """With another lesson, of which the fields of a step are shown."""
    edited = max(min(edited, len(lesson.steps) - 1), 0)
    lesson = lesson if lesson.steps else OwnLesson()
    return state.with_values(OwnLessonState, own_lesson=lesson, own_edited=edited)


def with_replaced(state: State, before: State) -> State:
    """A state that offers the lesson of the state `before` back where it has another one, or none:
    the step that was removed last is not one of that."""
    old, new = own_state(before).own_lesson, own_state(state).own_lesson
    if old == new:
        return state
    kept = [lesson for lesson in own_state(before).replaced_lessons if lesson not in (old, new)]
    kept = [*kept, old][-MOST_REPLACED:] if old.steps else kept
    return state.with_values(OwnLessonState, replaced_lessons=tuple(kept), own_removed=None)


def with_answers(state: State, answers: Mapping[str, int]) -> State:
    """With these answers, by the keys of their steps, in place of earlier ones to the same."""
    known = {key: k for key, k in own_state(state).own_answers if key not in answers}
    kept = [*(known | dict(answers)).items()][-MOST_KEPT:]
    return state.with_values(OwnLessonState, own_answers=tuple(kept))


def with_answer_switched(state: State) -> State:
    """With the right answer shown, or hidden again."""
    return state.with_values(OwnLessonState, answer_shown=not own_state(state).answer_shown)


def at_step(state: State, scene: State, k: int) -> State:
    """The state `scene`, that of the scene of a step, as the step k (from 0) of the lesson that is
    shown."""
    begun = scene.with_slice(own_state(state).at_step(k))
    lessons = LessonState(before_lesson=outside(state), met=state.slice(LessonState).met)
    return begun.with_slice(lessons)


# Files


def is_lesson_file(content: str) -> bool:
    """Whether the text of a TOML file is that of a lesson, not of a scene."""
    return STEP_TABLE.search(content) is not None


def open_lesson_file(visitor: Visitor, content: bytes, name: str) -> None:
    """Show the lesson of a file from its first step, or say what is wrong in it."""
    with visitor.lock, visitor.reporting("The lesson was not opened"):
        lesson = OwnLesson.from_bytes(content, name)
        begun = begun_lesson(visitor.state, lesson, name, visitor.links.read)
        visitor.change(lambda _: begun, loads=True, replaced=REPLACED)


def begun_lesson(
    state: State, lesson: OwnLesson, name: str, read: Callable[[State, str], State]
) -> State:
    """The state at the first step of a lesson from a file of this name. read: as in `LinkFormat`.
    Raises InvalidInput for a scene that is not valid, also a later one."""
    scenes = []
    for k, step in enumerate(lesson.steps, 1):
        with errors_of_file(f"{name}, step {k}"):
            scenes.append(read(state, step.link))
    opened = with_lesson(state, lesson, 0).with_values(OwnLessonState, followed=None)
    return at_step(with_replaced(opened, state), scenes[0], 0)


# What is shown


def player_html(state: State, presented: Snapshot | None, *, is_led: bool) -> str:
    """The step that is shown, "" for none. presented: to the presenter, with the votes; is_led: the
    visitor follows a presenter, who goes from step to step, and says which answer is right."""
    now = own_state(state)
    shown = now.shown_step
    if shown is None:
        return ""
    step = shown.step
    said = "".join(f"<p>{formatted(line)}</p>" for line in step.say.splitlines() if line.strip())
    asked = f'<p class="question">{formatted(step.ask)}</p>' if step.ask else ""
    chosen = dict(now.own_answers).get(step.key)
    if presented is not None:
        is_shown = now.answer_shown
        answers = votes_html(step, presented.votes.get(step.key, {}), presented.audience, is_shown)
    elif is_led and is_closed(now, step):
        answers = right_html(step, chosen)
    else:
        answers = answers_html(step, chosen, is_led=is_led)
    return head_html(shown.lesson, shown.place, is_led=is_led) + said + asked + answers


def head_html(lesson: OwnLesson, k: int, *, is_led: bool) -> str:
    """The title of a lesson, and the buttons that go from its step k (from 0) to another one."""
    title = f"<h3>{escape(lesson.title or 'Lesson')}</h3>"
    place = f'<span aria-current="step">{k + 1} of {len(lesson.steps)}</span>'
    if is_led:
        return f'<div class="title">{title}{place}</div>'
    restart = {"data_do": "lesson_restart", "title": "Restart", "aria_label": "Restart the scene"}
    leave = {"data_do": "lesson", "data_value": "", "aria_label": "Leave the lesson"}
    title += page.button("↺", class_="quiet", **restart) + page.button("✕", class_="quiet", **leave)
    turn = {"data_do": "own.turn"}
    back = page.button("‹ Back", data_value=-1, data_key="b", disabled=k == 0, **turn)
    text = "Finish" if k == len(lesson.steps) - 1 else "Next ›"
    ahead = page.button(text, data_value=1, data_key="n", class_="main", **turn)
    return (
        f'<div class="title">{title}</div>{page.group("Steps of the lesson", back, place, ahead)}'
    )


def answers_html(step: LessonStep, chosen: int | None, *, is_led: bool) -> str:
    """The answers to choose from, and what is said of the chosen one."""
    if not step.choices:
        return ""
    buttons = "".join(
        page.button(text, data_do="own.answer", data_value=k, aria_pressed=k == chosen)
        for k, text in enumerate(step.choices)
    )
    text = page.group("Answers", buttons, class_="row guesses")
    if chosen is None:
        return text
    if is_led or step.right is None:
        return text + verdict(SENT if is_led else KEPT, met=False)
    met = chosen == step.right
    return text + verdict(RIGHT if met else WRONG, met=met)


def right_html(step: LessonStep, chosen: int | None) -> str:
    """The answers after a presenter has shown which one is right."""
    entries = "".join(
        f"<li><b>{escape(text)}\u00a0✓</b></li>" if k == step.right else f"<li>{escape(text)}</li>"
        for k, text in enumerate(step.choices)
    )
    answers = f'<ul class="answers">{entries}</ul>'
    if chosen is None:
        return answers
    return answers + verdict(
        f"Your answer: {escape(step.choices[chosen])}", met=chosen == step.right
    )


def verdict(words: str, *, met: bool) -> str:
    """What is said of an answer; the page scrolls to it when it comes (`try`)."""
    return f'<p id="try" class="verdict{" met" if met else ""}" role="status">{words}</p>'


def votes_html(step: LessonStep, votes: Mapping[int, int], audience: int, is_shown: bool) -> str:
    """How many have chosen each answer, for the presenter; is_shown: also which one is right."""
    if not step.choices:
        return ""
    counts = [Counter(votes)[k] for k in range(len(step.choices))]
    rows, most = [], max(*counts, 1)
    for k, (text, count) in enumerate(zip(step.choices, counts, strict=True)):
        right = '\u00a0<b class="good">✓</b>' if is_shown and k == step.right else ""
        part = page.attributes(class_="vote", style=f"--part: {100 * count / most:.0f}%")
        rows.append((f"<span{part}>{escape(text)}{right}</span>", str(count)))
    heads = [f'<span class="hidden">{name}</span>' for name in ("answer", "chosen by")]
    table = page.table("Answers of the visitors", heads, rows, class_="votes")
    pages = "page" if audience == 1 else "pages"
    total = f'<span class="soft">{sum(counts)} answered, {audience} {pages} open</span>'
    text = "Hide the answer" if is_shown else "Show the answer"
    show = page.button(text, data_do="own.show_answer") if step.right is not None else ""
    return f'{table}<div class="row">{total}{show}</div>'
