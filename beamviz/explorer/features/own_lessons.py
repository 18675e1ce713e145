"""Lessons of a teacher's own: a fold in the tab Lessons keeps scenes in order, with a sentence and
a question for each; beside the tabs they are shown as the other lessons are.

A lesson is a file or a link (`beamviz.lessons.lesson_file`). Answers stay in the browser; in a
lecture the presenter sees how many have chosen which.
"""

import re
import secrets
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from html import escape
from typing import Any, NamedTuple, Self
from urllib.parse import parse_qsl, urlencode

from beamviz.errors import InvalidInput
from beamviz.explorer import page
from beamviz.explorer.declarations import Key, choice, count_key
from beamviz.explorer.feature import Feature
from beamviz.explorer.features.lessons import (
    OWN_LESSON,
    OWN_STEP,
    LessonState,
    formatted,
    left,
    outside,
)
from beamviz.explorer.page import Content
from beamviz.explorer.snapshot import Snapshot
from beamviz.explorer.state import Slice, State
from beamviz.explorer.visitor import Visitor
from beamviz.input_files import errors_of_file
from beamviz.lessons.lesson_file import (
    LEAST_ANSWERS,
    LESSON_KEY,
    MAX_CHARACTERS,
    MAX_STEPS,
    MOST_ANSWERS,
    STEP_KEY,
    LessonStep,
    OwnLesson,
    check_size,
    packed,
    unpacked,
)
from beamviz.scene import MAX_LINK

MOST_REPLACED = 5  # lessons that can be brought back
MOST_KEPT = 200  # answers of earlier lessons that a browser keeps
KEPT_ANSWER = re.compile(r"([0-9a-f]{12}):([0-3])")
VOTER = re.compile(r"[a-z0-9]{1,20}")
STEP_TABLE = re.compile(r"^[ \t]*\[\[[ \t]*step[ \t]*\]\]", re.MULTILINE)
FILE_NAME = "lesson.toml"
TEXTS = ("say", "ask")  # of a step, each a field
LABELS = {"title": "Title of the lesson", "say": "Sentence", "ask": "Question"}
HINT = (
    "Set a scene, keep it, and write a sentence and a question for it; then the next one. The"
    " lesson is a link or a file: nothing of it is stored here."
)
SENT = "Your answer is sent; you can change it."
KEPT = "Your answer stays in this browser."
NOT_TAKEN = "This entry is not taken"
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


class OwnLessons(Feature):
    """The lesson that a visitor writes, and its steps when they are shown."""

    style = "own_lessons.css"
    state = OwnLessonState

    def __init__(self, visitor: Visitor):
        super().__init__(visitor)
        self.voter = ""  # the name by which the visitor votes, of their browser or a random one
        self.kept = ""  # id of the field of a step that was kept
        on = self.page.on
        on("own.keep", lambda _: self.keep())
        on("own.take", lambda _: self.take())
        on("own.edit", self.choose, int)
        on("own.move", self.move, int)
        on("own.remove", lambda _: visitor.update(removed))
        on("own.restore", lambda _: self.restore())
        on("own.bring_back", lambda _: visitor.update(brought_back))
        on("own.save", lambda _: self.save())
        on("own.go", self.go, int)
        on("own.turn", self.turn, int)
        on("own.answer", self.answer, int)
        on("own.show_answer", lambda _: visitor.update(with_answer_switched))
        on("answers", self.take_answers, str, max_text=20 * MOST_KEPT)
        on("own.title", self.write_title, str)
        on("own.tab", self.write_tab, str)
        on("own.right", self.write_right, int)
        for name in TEXTS:
            on(f"own.{name}", partial(self.write, name), str)
        for k in range(MOST_ANSWERS):
            on(f"own.answer.{k + 1}", partial(self.write_answer, k), str)
        visitor.command("Keep this scene in your own lesson", self.keep)

    def content(self, snapshot: Snapshot) -> Content:
        state = snapshot.state
        now = own_state(state)
        with_votes = snapshot if self.visitor.presents else None
        shown = player_html(state, with_votes, is_led=snapshot.is_led)
        answers = [f"{key}:{answer}" for key, answer in now.own_answers]
        written = Written(
            now.own_lesson,
            edited_place(state),
            now.own_removed is not None,
            bool(now.replaced_lessons),
            state.reserved or (),
            tuple(self.tab_names.items()),
        )
        return (
            page.html(OWN_STEP, shown)
            | (page.html(OWN_LESSON, "") if snapshot.is_led else editor_content(written))
            | fields_content(state, next(iter(self.tab_names)))
            | {("answers",): answers}
        )

    def react(self, snapshot: Snapshot, elapsed: float) -> None:
        """Give the field of a step that was kept the focus, in the message that has it."""
        if self.kept:
            self.page.focus(self.kept)
            self.kept = ""

    @property
    def tab_names(self) -> dict[str, str]:
        """The names of the tabs that a step may open, by key."""
        return {key: tab.name for key, tab in self.visitor.tabs.items() if not tab.is_aside}

    # The lesson is written, which is no edit of the scene: it is no step to undo

    def keep(self) -> None:
        """Add the present scene as a step after the one that is edited."""
        visitor = self.visitor
        with visitor.lock, visitor.reporting("This scene cannot be kept"):
            if len(own_state(visitor.state).own_lesson.steps) >= MAX_STEPS:
                raise InvalidInput(f"a lesson has at most {MAX_STEPS} scenes; remove one")
            step = LessonStep(visitor.links.write(visitor.state))
            self.write_lesson(partial(with_new_step, step=step))
            self.kept = "own-say"

    def take(self) -> None:
        """Replace the scene of the step that is edited by the present one."""
        visitor = self.visitor
        with visitor.lock, visitor.reporting("This scene cannot be kept"):
            link = visitor.links.write(visitor.state)
            self.write_lesson(partial(with_edited, link=link))
            self.page.say(f"Scene {edited_place(visitor.state) + 1} is replaced.")

    def restore(self) -> None:
        """Put the step that was removed last back."""
        with self.visitor.reporting("The removed scene is not put back"):
            self.write_lesson(restored)

    def write_lesson(self, edit: Callable[[State], State]) -> None:
        """Edit the lesson. Raises InvalidInput where its file could not be opened again."""
        with self.visitor.lock:
            before = self.visitor.state
            state = edit(before)
            check_size(own_state(state).own_lesson, own_state(before).own_lesson)
            self.visitor.set_state(state)

    def choose(self, k: Any) -> None:
        """Show the fields of a step."""
        if k in range(len(own_state(self.visitor.state).own_lesson.steps)):
            self.visitor.update(lambda state: state.with_values(OwnLessonState, own_edited=int(k)))

    def move(self, by: Any) -> None:
        """Move the step that is edited one place up (-1) or down (1)."""
        if by in (-1, 1):
            self.visitor.update(partial(moved, by=by))

    def write(self, name: str, text: Any) -> None:
        values: dict[str, Any] = {name: cut(text, name)}
        with self.visitor.reporting(NOT_TAKEN):
            self.write_lesson(lambda state: with_edited(state, **values))

    def write_title(self, text: Any) -> None:
        with self.visitor.reporting(NOT_TAKEN):
            self.write_lesson(partial(with_title, title=cut(text, "title")))

    def write_answer(self, k: int, text: Any) -> None:
        """Write an answer (from 0) of the step that is edited; one that is there already is not
        taken."""
        with self.visitor.lock, self.visitor.reporting(NOT_TAKEN):
            step, answer = edited_step(self.visitor.state), cut(text, "answers")
            if step is None:
                return
            if answer in (*step.answers[:k], *step.answers[k + 1 :]):
                raise InvalidInput(f"{answer!r}: two answers are the same; change one")
            changed = step.with_answer(k, answer)
            self.write_lesson(partial(with_edited, answers=changed.answers, right=changed.right))

    def write_right(self, k: Any) -> None:
        """Mark the right answer (from 0) of the step that is edited; a second time, none."""
        with self.visitor.lock:
            step = edited_step(self.visitor.state)
            if step and k in range(len(step.answers)):
                self.visitor.update(partial(with_edited, right=None if k == step.right else int(k)))

    def write_tab(self, tab: Any) -> None:
        """Choose the tab that the step which is edited opens."""
        with self.visitor.lock, self.visitor.reporting(NOT_TAKEN):
            step = edited_step(self.visitor.state)
            if step and tab in self.tab_names:
                self.write_lesson(partial(with_edited, link=with_tab(step.link, str(tab))))

    def save(self) -> None:
        """Send the lesson as a file."""
        lesson = own_state(self.visitor.state).own_lesson
        if not lesson.steps:
            return
        with self.visitor.reporting("The lesson is not saved"):
            check_size(lesson)
            self.visitor.client.send_file_download(
                FILE_NAME, lesson.contents, save_immediately=True
            )

    # The lesson is shown

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


def edited_place(state: State) -> int:
    """The place of the step whose fields are shown, from 0, also for a lesson without steps; a link
    may have named one that is not there."""
    now = own_state(state)
    return max(min(now.own_edited, len(now.own_lesson.steps) - 1), 0)


def is_closed(now: OwnLessonState, step: LessonStep) -> bool:
    """Whether a presenter shows which answer to the question of a step is right."""
    return now.answer_shown and step.right is not None


def edited_step(state: State) -> LessonStep | None:
    """The step whose fields are shown; None for a lesson without steps."""
    steps = own_state(state).own_lesson.steps
    return steps[edited_place(state)] if steps else None


def with_lesson(state: State, lesson: OwnLesson, edited: int) -> State:
    """With another lesson, of which the fields of a step are shown."""
    edited = max(min(edited, len(lesson.steps) - 1), 0)
    lesson = lesson if lesson.steps else OwnLesson()
    return state.with_values(OwnLessonState, own_lesson=lesson, own_edited=edited)


def with_new_step(state: State, step: LessonStep) -> State:
    """With a step after the one that is edited, which takes its place there."""
    now = own_state(state)
    steps = list(now.own_lesson.steps)
    place = min(edited_place(state) + 1, len(steps))
    return with_lesson(
        state, now.own_lesson.with_steps([*steps[:place], step, *steps[place:]]), place
    )


def with_edited(state: State, **values: Any) -> State:
    """With other values of the step that is edited."""
    place = edited_place(state)
    return with_lesson(state, own_state(state).own_lesson.with_step(place, **values), place)


def with_title(state: State, title: str) -> State:
    lesson = replace(own_state(state).own_lesson, title=title)
    return with_lesson(state, lesson, edited_place(state))


def moved(state: State, by: int) -> State:
    """With the step that is edited at another place."""
    now = own_state(state)
    steps, place = list(now.own_lesson.steps), edited_place(state)
    if place + by not in range(len(steps)):
        return state
    steps.insert(place + by, steps.pop(place))
    return with_lesson(state, now.own_lesson.with_steps(steps), place + by)


def removed(state: State) -> State:
    """Without the step that is edited, which can be put back; a lesson without steps is left."""
    now = own_state(state)
    if not now.own_lesson.steps:
        return state
    steps, place = list(now.own_lesson.steps), edited_place(state)
    gone = steps.pop(place)
    state = left(state) if not steps and now.own_step is not None else state
    state = with_lesson(state, now.own_lesson.with_steps(steps), place)
    shown = now.own_step if now.own_step is None else min(now.own_step, len(steps) - 1)
    return state.with_values(
        OwnLessonState, own_removed=(place, gone), own_step=shown if steps else None
    )


def restored(state: State) -> State:
    """With the step that was removed last at its place."""
    now = own_state(state)
    if now.own_removed is None or len(now.own_lesson.steps) >= MAX_STEPS:
        return state
    (place, step), steps = now.own_removed, list(now.own_lesson.steps)
    steps.insert(place, step)
    state = with_lesson(state, now.own_lesson.with_steps(steps), place)
    return state.with_values(OwnLessonState, own_removed=None)


def with_replaced(state: State, before: State) -> State:
    """A state that offers the lesson of the state `before` back where it has another one, or none:
    the step that was removed last is not one of that."""
    old, new = own_state(before).own_lesson, own_state(state).own_lesson
    if old == new:
        return state
    kept = [lesson for lesson in own_state(before).replaced_lessons if lesson not in (old, new)]
    kept = [*kept, old][-MOST_REPLACED:] if old.steps else kept
    return state.with_values(OwnLessonState, replaced_lessons=tuple(kept), own_removed=None)


def brought_back(state: State) -> State:
    """With the lesson that was replaced last in the place of the present one; again, with the one
    before that."""
    now = own_state(state)
    if not now.replaced_lessons:
        return state
    *kept, lesson = now.replaced_lessons
    kept = [now.own_lesson, *kept] if now.own_lesson.steps else kept
    state = left(state) if now.own_step is not None else state
    return with_lesson(state, lesson, 0).with_values(
        OwnLessonState, replaced_lessons=tuple(kept), own_removed=None, own_step=None
    )


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


def cut(text: Any, name: str) -> str:
    """A text as typed, without blanks around it, and no longer than it may be; what is no
    character is left out."""
    clean = str(text).encode(errors="ignore").decode().replace("\r\n", "\n").replace("\0", "")
    return clean[: MAX_CHARACTERS[name]].strip()


def with_tab(link: str, tab: str) -> str:
    """The query of a link that opens another tab."""
    pairs = [pair for pair in parse_qsl(link, keep_blank_values=True) if pair[0] != "tab"]
    return urlencode([("tab", tab), *pairs], safe="[],{}=")


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


# The player


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


# The fields in which a lesson is written


class Written(NamedTuple):
    """What the fold shows in which a lesson is written."""

    lesson: OwnLesson
    place: int  # of the step whose fields are shown, from 0
    has_removed: bool  # a step can be put back
    has_replaced: bool  # a lesson can be brought back
    reserved: tuple[tuple[str, str], ...]  # parameters of the address with other readers
    tabs: tuple[tuple[str, str], ...]  # keys and names of those that a step may open

    @property
    def query(self) -> str:
        """The query of a link that begins the lesson."""
        return urlencode([*self.reserved, (LESSON_KEY, packed(self.lesson)), (STEP_KEY, 1)])


@lru_cache(64)
def editor_content(written: Written) -> Content:
    """The fold in which a lesson is written, which is the same in most frames."""
    return page.html(OWN_LESSON, editor_html(written))


def editor_html(written: Written) -> str:
    """The fold in which a lesson is written."""
    steps, place = written.lesson.steps, written.place
    if not steps:
        body = f'<p class="soft">{HINT}</p>' + page.group("Your own lesson", first_tools(written))
        is_open = page.attributes(open=written.has_removed or written.has_replaced)
        return f'<details class="own"{is_open}><summary>Your own lesson</summary>{body}</details>'
    count = f"{len(steps)} scene{'' if len(steps) == 1 else 's'}"
    listed = "".join(list_entry(k, step, is_edited=k == place) for k, step in enumerate(steps))
    title = text_field("title", "own.title", LABELS["title"], MAX_CHARACTERS["title"])
    body = (
        f'{share_tools(written)}<div class="own-parts">'
        f'<div>{title}<ol class="own-list">{listed}</ol>{step_tools(place, len(steps))}</div>'
        f"{step_fields(steps[place], dict(written.tabs))}</div>"
    )
    return f'<details class="own" open><summary>Your own lesson: {count}</summary>{body}</details>'


def first_tools(written: Written) -> str:
    """The buttons that a lesson begins with."""
    kind = None if written.lesson.steps else "main"
    tools = page.button("Keep this scene", data_do="own.keep", class_=kind)
    tools += '<label class="button" for="own-file">Open file</label>'
    tools += '<input type="file" id="own-file" class="hidden" data-do="load" accept=".toml">'
    if written.has_removed:
        tools += page.button("Put the removed scene back", data_do="own.restore")
    if written.has_replaced:
        tools += page.button("Bring back the lesson before", data_do="own.bring_back")
    return tools


def share_tools(written: Written) -> str:
    """These, and the buttons that share and begin a lesson. The address has no room either for one
    that is too long for a link."""
    link = written.query
    is_short = len(link) <= MAX_LINK
    copied = {"data_copy": link if is_short else None, "disabled": not is_short}
    tools = (
        first_tools(written),
        page.button("Save file", data_do="own.save"),
        page.button("Copy lesson link", **copied),
        page.button("Begin your lesson", data_do="own.go", data_value=0, class_="main"),
    )
    long = (
        f"A link has at most {MAX_LINK} characters, this lesson {len(link)}: save the file, which"
    )
    long += " keeps it after this page is closed."
    return page.group("Your own lesson", *tools) + page.note("" if is_short else long)


def list_entry(k: int, step: LessonStep, *, is_edited: bool) -> str:
    """A step in the list, a button that shows its fields."""
    text = step.say or step.ask or "(no sentence yet)"
    current = "true" if is_edited else None
    entry = page.button(
        f"{k + 1}. {text}", data_do="own.edit", data_value=k, class_="quiet", aria_current=current
    )
    return f"<li>{entry}</li>"


def step_tools(k: int, count: int) -> str:
    """The buttons for the step k (from 0)."""
    move = {"data_do": "own.move"}
    replace_hint = "Take the present scene in its place"
    tools = (
        page.button("Show", data_do="own.go", data_value=k, title="Show the lesson from here"),
        page.button("Replace", data_do="own.take", title=replace_hint),
        page.button("↑", data_value=-1, disabled=k == 0, aria_label="Up", **move),
        page.button("↓", data_value=1, disabled=k == count - 1, aria_label="Down", **move),
        page.button("✕", data_do="own.remove", aria_label="Remove", title="Remove this scene"),
    )
    return page.group(f"Scene {k + 1}", *tools)


def step_fields(step: LessonStep, tabs: Mapping[str, str]) -> str:
    """The fields of a step, and those of its answers."""
    say = page.attributes(id="own-say", data_set="own.say", maxlength=MAX_CHARACTERS["say"])
    fields = f'<label for="own-say">{LABELS["say"]}</label><textarea{say} rows="2"></textarea>'
    fields += text_field("ask", "own.ask", LABELS["ask"], MAX_CHARACTERS["ask"])
    fields += page.select("own.tab", "opens the tab", tabs, id="own-tab")
    answers = '<p class="soft">Answers, if any, and which is right</p>'
    for i in range(min(max(len(step.answers) + 1, LEAST_ANSWERS), MOST_ANSWERS)):
        right = page.button(
            "right",
            data_set="own.right",
            data_value=i,
            disabled=i >= len(step.answers),
            aria_label=f"Answer {i + 1} is right",
        )
        name, most = f"answer-{i + 1}", MAX_CHARACTERS["answers"]
        key = f"own.answer.{i + 1}"
        answers += text_field(name, key, "", most, right, aria_label=f"Answer {i + 1}")
    return f"<div>{fields}</div><div>{answers}</div>"


def text_field(name: str, key: str, label: str, most: int, beside: str = "", **values: Any) -> str:
    """A field for a text of at most so many characters; label: above it, "" for none; beside: HTML
    beside it."""
    usual = {"id": f"own-{name}", "data_set": key, "maxlength": most, "autocomplete": "off"}
    box = page.attributes(**usual, **values)
    field = f'<label for="own-{name}">{escape(label)}</label>' if label else ""
    return f'{field}<div class="own-field"><input type="text"{box}>{beside}</div>'


def fields_content(state: State, usual_tab: str) -> Content:
    """What the fields show. usual_tab: the key of the one that a link without a tab opens."""
    step = edited_step(state) or LessonStep("")
    tab = dict(parse_qsl(step.link)).get("tab", usual_tab)
    content = page.value("own.title", own_state(state).own_lesson.title) | page.value(
        "own.tab", tab
    )
    content |= page.value("own.right", step.right)
    for name in TEXTS:
        content |= page.value(f"own.{name}", getattr(step, name))
    for k in range(MOST_ANSWERS):
        answer = step.answers[k] if k < len(step.answers) else ""
        content |= page.value(f"own.answer.{k + 1}", answer)
    return content
