"""The fold in the tab Lessons in which a visitor writes a lesson: scenes are kept in order, with a
sentence and a question for each. The lesson is shared as a file or a link.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import lru_cache, partial
from html import escape
from typing import Any, NamedTuple
from urllib.parse import parse_qsl, urlencode

from beamviz.errors import InvalidInput
from beamviz.explorer import page
from beamviz.explorer.feature import Feature
from beamviz.explorer.features.lesson_player import OwnLessonState, own_state, with_lesson
from beamviz.explorer.features.lessons import OWN_LESSON, left
from beamviz.explorer.page import Content
from beamviz.explorer.snapshot import Snapshot
from beamviz.explorer.state import State
from beamviz.explorer.visitor import Visitor
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
)
from beamviz.scene import MAX_LINK

FILE_NAME = "lesson.toml"
TEXTS = ("say", "ask")  # of a step, each a field
LABELS = {"title": "Title of the lesson", "say": "Sentence", "ask": "Question"}
HINT = (
    "Set a scene, keep it, and write a sentence and a question for it; then the next one. The"
    " lesson is a link or a file: nothing of it is stored here."
)
NOT_TAKEN = "This entry is not taken"


class LessonEditor(Feature):
    """The lesson that a visitor writes, which is no edit of the scene: it is no step to undo."""

    style = "lesson_editor.css"

    def __init__(self, visitor: Visitor):
        super().__init__(visitor)
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
        written = Written(
            now.own_lesson,
            edited_place(state),
            now.own_removed is not None,
            bool(now.replaced_lessons),
            state.reserved or (),
            tuple(self.tab_names.items()),
        )
        shown = page.html(OWN_LESSON, "") if snapshot.is_led else editor_content(written)
        return shown | fields_content(state, next(iter(self.tab_names)))

    def react(self, snapshot: Snapshot, elapsed: float) -> None:
        """Give the field of a step that was kept the focus, in the message that has it."""
        if self.kept:
            self.page.focus(self.kept)
            self.kept = ""

    @property
    def tab_names(self) -> dict[str, str]:
        """The names of the tabs that a step may open, by key."""
        return {key: tab.name for key, tab in self.visitor.tabs.items() if not tab.is_aside}

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


# The lesson


def edited_place(state: State) -> int:
    """The place of the step whose fields are shown, from 0, also for a lesson without steps; a link
    may have named one that is not there."""
    now = own_state(state)
    return max(min(now.own_edited, len(now.own_lesson.steps) - 1), 0)


def edited_step(state: State) -> LessonStep | None:
    """The step whose fields are shown; None for a lesson without steps."""
    steps = own_state(state).own_lesson.steps
    return steps[edited_place(state)] if steps else None


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


def cut(text: Any, name: str) -> str:
    """A text as typed, without blanks around it, and no longer than it may be; what is no
    character is left out."""
    clean = str(text).encode(errors="ignore").decode().replace("\r\n", "\n").replace("\0", "")
    return clean[: MAX_CHARACTERS[name]].strip()


def with_tab(link: str, tab: str) -> str:
    """The query of a link that opens another tab."""
    pairs = [pair for pair in parse_qsl(link, keep_blank_values=True) if pair[0] != "tab"]
    return urlencode([("tab", tab), *pairs], safe="[],{}=")


# The fields


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
