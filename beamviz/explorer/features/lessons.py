"""The tab Lessons, with a card for each lesson; the open lesson is shown beside the tabs."""

import contextlib
import math
import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from functools import cache, partial
from html import escape
from typing import Any, NamedTuple, Self

import numpy as np

from beamviz.beam import NUMBERS
from beamviz.checks import check_int
from beamviz.drawing.beam_mesh import DEFAULT_SCALE
from beamviz.drawing.modes import rotated
from beamviz.drawing.text import frequencies, significant
from beamviz.errors import BeamvizError, InvalidInput
from beamviz.explorer import page
from beamviz.explorer.computed_loci import lines_of
from beamviz.explorer.declarations import Key, Tab, choice, count_key
from beamviz.explorer.experiment import MotionState, of_lesson
from beamviz.explorer.feature import Feature, fading
from beamviz.explorer.features.loci_chart import LociTab
from beamviz.explorer.jobs import Answer
from beamviz.explorer.page import Content
from beamviz.explorer.snapshot import Snapshot
from beamviz.explorer.solutions import solver_answer
from beamviz.explorer.state import Case, Slice, State
from beamviz.explorer.view import picture_of
from beamviz.explorer.visitor import Visitor
from beamviz.frequency_loci import loci
from beamviz.frequency_loci.identity import identify_modes
from beamviz.lessons import LESSONS, NAMES, lesson
from beamviz.lessons.model import Lesson, Verdict
from beamviz.scene import Scene
from beamviz.solver import Solution, solve

JOB = "lesson"
LESSONS_HELP = (
    "A question, what to do, the answer with its number, and a challenge; and your own lesson, of"
    " scenes that you keep"
)
# On a phone they are as wide as the scene, with a button beside them.
RETURNED = "Your scene is back."
STARTED = "This is the page as it starts."
STEPS = ("Try it", "Why", "Challenge")
CHALLENGE = len(STEPS) - 1
FINE_STEPS = "Fine steps: type the number beside a slider, or click the slider and use arrow keys."
AWAITED = '<p class="soft">The answer is being computed …</p>'
CONTROLS = {  # named in the texts of lessons: the key of each, or the id of a tab
    **{parameter.slider_label: name for name, parameter in NUMBERS.items()},
    **{name: name for name in ("method", "plane", "strain", "state", "curvature")},
    "Coriolis": "coriolis",
    "Frequencies": "tab-frequencies",
    "Veering": "tab-veering",
    "Motion": "tab-motion",
    "pull at": "motion.pull_at",
}


OWN_STEP, OWN_LESSON = "own-step", "own-lesson"  # ids of places for a lesson of the visitor's own
MOST_GUESSES = max(len(one.guesses) for one in LESSONS)


def read_lesson(name: Any) -> str:
    return lesson(str(name)).name


@dataclass(frozen=True)
class LessonState(Slice):
    """The open lesson."""

    # Its name; "" for none.
    lesson: str = field(
        default="", metadata=choice(key=Key("lesson", read_lesson), until=("opened",))
    )
    # Its step, from 0.
    step: int = field(
        default=0, metadata=choice(key=count_key("step", len(STEPS)), until=("lesson", "opened"))
    )
    # The answer chosen at its first step.
    guess: int | None = field(
        default=None, metadata=choice(key=count_key("guess", MOST_GUESSES), until=("scene",))
    )
    # The state before the first of the lessons, also of the visitor's own, to which leaving them
    # returns; None while none is open.
    before_lesson: State | None = field(default=None, metadata=choice(until=("opened",)))
    # Those whose challenge is met.
    met: frozenset[str] = field(default=frozenset(), metadata=choice(undo="keeps", led="keeps"))


class Lessons(Feature):
    """The lessons of one visitor; the open lesson, its step and the guess are in the state."""

    style = "lessons.css"
    tab = Tab("Lessons", 9, LESSONS_HELP)
    state = LessonState

    def __init__(self, visitor: Visitor):
        super().__init__(visitor)
        visitor.job(JOB, Facts.of)
        self.page.on("lesson", self.open, str)
        self.page.on("lesson_step", self.go, int)
        self.page.on("lesson_turn", self.turn, int)
        self.page.on("lesson_guess", self.guess, int)
        self.page.on("lesson_restart", lambda _: visitor.reset())
        self.page.on("met", self.keep_met, str)
        for one in LESSONS:
            visitor.command(f"Lesson: {one.title}", partial(self.open, one.name))

    @classmethod
    def prepare(cls) -> None:
        """Compute the pictures of the cards and the rates of the clock, which are stored."""
        for name in NAMES:
            sketch(name)
            lesson_rate(name)

    @classmethod
    def begun(cls, state: State) -> State:
        """On the scene of a lesson, that begins."""
        found = (begun(state, one) for one in LESSONS if one.scene == state.opened)
        return next(found, state)

    def open(self, name: Any) -> None:
        """Begin the lesson of a name, or with "" leave all; an unknown name changes nothing."""
        if name in NAMES:
            said = f"Lesson {NAMES.index(name) + 1} has replaced your scene."
            with self.visitor.lock:
                said = "" if lesson_state(self.visitor.state).lesson else said
                edit = partial(begun, lesson=lesson(name))
                self.visitor.change(edit, loads=True, replaced=said)
        elif name == "":
            self.leave()

    def leave(self) -> None:
        """Return to the scene before the lessons; the address of a page that was opened, or loaded
        again, within one does not have it."""
        visitor = self.visitor
        with visitor.lock:
            found = lesson_state(visitor.state).before_lesson
            visitor.change(left, loads=True, replaced=RETURNED)
            if found and found.reserved is None:  # that of a page before its own address
                visitor.update(lambda state: replace(state, replaced=STARTED))

    def go(self, step: Any) -> None:
        """Go to a step (0-based) of the open lesson; an unknown one changes nothing."""
        with self.visitor.lock:
            if step in range(len(STEPS)) and (name := lesson_state(self.visitor.state).lesson):
                known = facts_in(self.visitor.shown_answer(JOB), name) is not None
                self.visitor.change(partial(at_step, step=int(step), known=known))

    def turn(self, by: Any) -> None:
        """Go to the next (1) or previous (-1) step, from the last or first step to the next or
        previous lesson; without a lesson, to the first or last one."""
        if by not in (1, -1):
            return
        with self.visitor.lock:
            now, names = lesson_state(self.visitor.state), ("", *NAMES)
            if now.lesson and now.step + by in range(len(STEPS)):
                self.go(now.step + by)
            else:
                self.open(names[(names.index(now.lesson) + by) % len(names)])

    def guess(self, number: Any) -> None:
        """Choose an answer to the question, and highlight the controls of the experiment."""
        with self.visitor.lock:
            name = lesson_state(self.visitor.state).lesson
            if not (name and number in range(len(lesson(name).guesses))):
                return
            self.visitor.change(lambda state: state.with_values(LessonState, guess=int(number)))
        keys = controls(lesson(name).do)
        self.page.point(*(key for key in keys if not key.startswith("tab-")))

    def keep_met(self, names: Any) -> None:
        """Take the lessons whose challenge was met in the same browser before."""
        known = {*str(names).split()} & {*NAMES}
        self.visitor.update(partial(with_met, names=known))

    def react(self, snapshot: Snapshot, elapsed: float) -> None:
        """Remember a challenge that is met."""
        now, verdict = lesson_state(snapshot.state), verdict_of(snapshot)
        if verdict and verdict.met and now.lesson not in now.met:
            self.visitor.update(partial(with_met, names={now.lesson}))

    def wanted(self, snapshot: Snapshot) -> Mapping[str, Any]:
        """The facts of the open lesson."""
        name = lesson_state(snapshot.state).lesson
        return {JOB: name} if name else {}

    def content(self, snapshot: Snapshot) -> Content:
        name, met = lesson_state(snapshot.state).lesson, lesson_state(snapshot.state).met
        is_open = lesson_state(snapshot.state).before_lesson is not None
        verdict = verdict_html(snapshot)
        return (
            lesson_content(snapshot)
            | page.html("verdict", verdict)
            | page.html("lesson-reading", verdict + watched_html(snapshot))
            | fading(snapshot, [], "verdict", "lesson-reading")
            | page.html("tab-lessons", cards_html(name, met, is_open=is_open))
            | {("met",): sorted(met)}
        )


class Facts(NamedTuple):
    """What is computed for a lesson."""

    lesson: str
    proof: str
    answer: float

    @classmethod
    def of(cls, name: str) -> Self:
        """The facts of a lesson, which stores them."""
        return cls(name, lesson(name).proof, lesson(name).answer)


def check_guess(guess: int, name: str) -> None:
    """Check that a lesson, "" for none, has the answer of an index to choose. Raises InvalidInput,
    which counts from 1."""
    if not name:
        raise InvalidInput(f"guess = {guess + 1}: there is no lesson to guess in")
    check_int("guess", guess + 1, 1, len(lesson(name).guesses))


def facts_of(snapshot: Snapshot) -> Facts | None:
    """The facts of the open lesson; None before they are computed."""
    return facts_in(snapshot.job_answer(JOB), lesson_state(snapshot.state).lesson)


def facts_in(answer: Answer[str, Facts] | None, name: str) -> Facts | None:
    """The facts in an answer that are those of a lesson."""
    facts = answer.result if answer else None
    return facts if facts and facts.lesson == name else None


def lesson_state(state: State) -> LessonState:
    return state.slice(LessonState)


def outside(state: State) -> State:
    """The state without lessons: that before them while one is open."""
    return lesson_state(state).before_lesson or state


def with_met(state: State, names: Collection[str]) -> State:
    """With the challenges of the lessons of these names met, too."""
    return state.with_values(LessonState, met=lesson_state(state).met | {*names})


def begun(state: State, lesson: Lesson, scene: Scene | None = None) -> State:
    """At the first step of a lesson, with its own scene or another one, the tab that it names, and
    the clock locked, so that a faster vibration looks faster than the one before."""
    scene = (scene or lesson.scene).changed(dark=state.view.dark)
    named = [key.removeprefix("tab-") for key in controls(lesson.do) if key.startswith("tab-")]
    tab = named[0] if named else LociTab.tab.key
    loaded = of_lesson(state.loaded(scene).after("lesson"), lesson)
    loaded = replace(loaded, tab=tab, rate=lesson_rate(lesson.name)).at_home(lesson.scene)
    return loaded.with_values(LessonState, lesson=lesson.name, before_lesson=outside(state))


def left(state: State) -> State:
    """As before the first lesson, but for the open tab and what undo leaves as it is."""
    found = lesson_state(state).before_lesson
    if found is None:
        return state
    restored = state.restored(found).with_viewpoint(found.camera)
    return restored.with_values(MotionState, moment=found.slice(MotionState).moment)


@cache
def lesson_rate(name: str) -> float | None:
    """The time [T*] per second on the screen that suits the first scene of a lesson; None for a
    motion in time, which has a rate of its own."""
    if lesson(name).motion:
        return None
    scene = lesson(name).scene
    return picture_of(solver_answer(Case.of(scene)), scene.view, DEFAULT_SCALE).rate


def at_step(state: State, step: int, known: bool) -> State:
    """At another step of the open lesson; its challenge begins unsolved. known: whether the answer
    is: it may take seconds, and nothing waits for it."""
    now = lesson_state(state)
    open_lesson, after = lesson(now.lesson), state.with_values(LessonState, step=step)
    if not step == CHALLENGE != now.step:
        return after
    if known and not is_met(open_lesson, state):
        return after
    scene = open_lesson.scene.changed(dark=state.view.dark)
    loaded = after.loaded(scene).with_values(LessonState, guess=now.guess)
    return of_lesson(replace(loaded, rate=state.rate), open_lesson)


def is_met(open_lesson: Lesson, state: State) -> bool:
    """Whether the challenge of a lesson is met, which takes its answer; not by a number out of
    range."""
    with contextlib.suppress(InvalidInput):
        return open_lesson.check(state.case.beam, state.case.options, pull_at(state)).met
    return False


def lesson_content(snapshot: Snapshot) -> Content:
    """The open lesson beside the tabs, or a place for one of the visitor's own."""
    now, text = lesson_state(snapshot.state), f'<div id="{OWN_STEP}"></div>'
    name = now.lesson
    if name:
        text = lesson_html(lesson(name), now.step, now.guess, facts_of(snapshot))
    in_tab = bool(name) and any(key.startswith("tab-") for key in controls(lesson(name).do))
    is_open = now.before_lesson is not None
    shown = page.props("lesson", hidden=not is_open, data_beside="tab" if in_tab else "controls")
    return page.html("lesson-text", text) | shown


def verdict_of(snapshot: Snapshot) -> Verdict | None:
    """The verdict on the challenge of the open lesson; None while that is not shown, and before its
    facts are known."""
    now, answer = lesson_state(snapshot.state), snapshot.answer
    shown = now.lesson and now.step == CHALLENGE and facts_of(snapshot)
    if not (shown and answer and answer.beam):
        return None
    return lesson(now.lesson).check(answer.beam, answer.request.options, pull_at(snapshot.state))


def pull_at(state: State) -> float:
    """The point x of the beam that the visitor pulls."""
    return state.slice(MotionState).experiment.pull_at


def verdict_html(snapshot: Snapshot) -> str:
    """The verdict, with the present value of the quantity of the challenge; "" without one."""
    verdict, answer, state = verdict_of(snapshot), snapshot.answer, snapshot.state
    if verdict is None:
        return ""
    word = "Right!" if verdict.met else "Not yet."
    words = f"<b>{word}</b> {escape(verdict.reason)}"
    if answer and answer.solution and (verdict.met or not verdict.reason):  # no obstacle
        reading = lesson(lesson_state(state).lesson).measured(answer.solution, pull_at(state))
        words += f" <br>Now: {escape(reading)}."
    return f'<p class="verdict{" met" if verdict.met else ""}">{words}</p>'


def watched_html(snapshot: Snapshot) -> str:
    """The frequencies that a lesson about modes watches, over the scene, which stays in view while
    a slider is dragged: on narrow pages the table of modes may be out of view then."""
    name = lesson_state(snapshot.state).lesson
    solution = snapshot.answer.solution if snapshot.answer else None
    of_modes = name and not lesson(name).motion
    return frequencies_html(solution) if of_modes and solution else ""


def frequencies_html(solution: Solution) -> str:
    """The names of the modes with their frequencies, in ascending order."""
    shown = frequencies(solution.beam.units)
    values = (shown.factor * solution.frequencies).tolist()
    texts = (significant(one, 4) if math.isfinite(one) else "grows" for one in values)
    pairs = zip(identify_modes(solution).labels, texts, strict=True)
    modes = "".join(f"<span><b>{escape(label)}</b> {text}</span>" for label, text in pairs)
    return f'<p aria-hidden="true"><span>{shown.head}</span>{modes}</p>'


# Texts


def cards_html(open_lesson: str, met: frozenset[str], *, is_open: bool) -> str:
    """A card for each lesson; the open one is marked, those with a challenge met are ticked.
    is_open: this one, or one of the visitor's own, is open."""
    text = f"{len(LESSONS)} short lessons, one question each, every one a small experiment."
    text += f" Challenges met: {len(met)} of {len(LESSONS)}." if met else ""
    begin = cards = ""
    if not is_open:  # whose next step it would be
        begin = page.button("Begin", data_do="lesson_turn", data_value=1, data_key="n")
    for k, one in enumerate(LESSONS, 1):
        own = page.attributes(data_do="lesson", data_value=one.name, class_="card")
        own += page.attributes(aria_current=True if one.name == open_lesson else None)
        tick = "\u00a0✓" if one.name in met else ""
        title = f"<b>{k}. {escape(one.title)}{tick}</b>"
        cards += f'<button type="button"{own}>{sketch(one.name)}{title}</button>'
    head = f'<div class="row"><span>{text}</span>{begin}</div><div id="{OWN_LESSON}"></div>'
    return f'{head}<div class="cards">{cards}</div>'


def lesson_html(lesson: Lesson, step: int, guess: int | None, facts: Facts | None) -> str:
    """One step of a lesson, without the verdict on its challenge. The experiment follows a guess at
    its outcome."""
    steps = ""
    for k, name in enumerate(STEPS):
        current, key = "step" if k == step else None, "b" if k == step - 1 else None
        own = {"data_do": "lesson_step", "data_value": k, "aria_current": current, "data_key": key}
        steps += page.button(name, class_="step", **own)
    is_last = lesson.name == NAMES[-1] and step == len(STEPS) - 1
    text = "Finish" if is_last else "Next ›"
    ahead = page.button(text, data_do="lesson_turn", data_value=1, data_key="n", class_="main")
    restart = {"data_do": "lesson_restart", "title": "Restart", "aria_label": "Restart the lesson"}
    leave = {"data_do": "lesson", "data_value": "", "aria_label": "Leave the lesson"}
    body = (
        prediction(lesson, guess),
        f"<p>{formatted(lesson.meaning)}</p>{judged(lesson, guess)}"
        '<p class="proof"><span class="soft">The number that proves it:</span>'
        f" {escape(facts.proof) if facts else 'being computed …'}</p>",
        f'<p class="question">{formatted(lesson.task)}</p><p class="soft fine">{FINE_STEPS}</p>'
        f"{'' if facts else AWAITED}",
    )[step]
    number = NAMES.index(lesson.name) + 1
    title = f"<h3>{number}. {escape(lesson.title)}</h3>"
    title += page.button("↺", class_="quiet", **restart) + page.button("✕", class_="quiet", **leave)
    choices = page.group("Steps of the lesson", steps, ahead)
    return f'<div class="title">{title}</div>{choices}{body}'


def prediction(lesson: Lesson, guess: int | None) -> str:
    """The question with its guesses, and, once one is chosen, what to do and to look for."""
    choices = "".join(
        page.button(text, data_do="lesson_guess", data_value=k, aria_pressed=k == guess)
        for k, text in enumerate(lesson.guesses)
    )
    text = f'<p class="question">{formatted(lesson.question)}</p>'
    text += page.group("Your guess", choices, class_="row guesses")
    if guess is None:
        return text + '<p class="soft">What do you expect? Choose, then try it.</p>'
    return (
        f'{text}<div id="try"><p><span class="soft">Do:</span> {formatted(lesson.do)}</p>'
        f'<p><span class="soft">Look for:</span> {formatted(lesson.see)}</p></div>'
    )


def judged(lesson: Lesson, guess: int | None) -> str:
    """The guess, compared with the answer."""
    if guess is None:
        return ""
    right, text = guess == lesson.right, escape(lesson.guesses[guess])
    word = "as you expected" if right else "not what you expected"
    return f'<p class="soft">Your guess: \u201c{text}\u201d \u2013 {word}.</p>'


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
    "flap-and-lag": (0.0, 6.0, ("F1", "L1")),
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
    moved = rotated(in_the_picture(solution.shape(k, X).real), angle)
    rest = solution.equilibrium.position(X)
    points = rest + AMPLITUDE * moved / np.linalg.norm(moved, axis=1).max()
    family = solution.families[k]
    if solution.in_plane_fraction is not None and family == "bending":
        family = "lag" if solution.in_plane_fraction[k] > 0.5 else "flap"
    parts = [hub(beam.delta), line(rest, "rest"), line(points, family)]
    if family in ("stretching", "mixed"):
        normal = 0.05 * rotated(np.array([0.0, 1.0]), angle)
        ticks = np.stack([points - normal, points + normal], axis=1)[TICKS]
        parts += [line(tick, family) for tick in ticks]
    if beam.alpha > 0:
        x, y = place(points[int(np.argmin(abs(X - beam.beta)))])
        parts.append(f'<circle class="mass" cx="{x:.1f}" cy="{y:.1f}" r="5"/>')
    return "".join(parts)


def in_the_picture(shape: np.ndarray) -> np.ndarray:
    """The components (n, 2) along a beam and across it of a shape (n, 2), or of one in both planes
    (n, 3) the larger of those across it."""
    if shape.shape[1] == 2:
        return shape
    across = 1 + int(np.argmax(np.abs(shape[:, 1:]).max(axis=0)))
    return shape[:, [0, across]]


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
    for line in lines_of(found, values, branches):
        y = height(line.frequency)
        for first, last, family, _ in line.runs:
            parts.append(page.polyline(x[first : last + 1], y[first : last + 1], family))
    return "".join(parts)


def place(points: np.ndarray) -> np.ndarray:
    """Positions (2, ...) [px] of points (..., 2) from the clamp in lengths of the beam."""
    return np.stack([CLAMP + LENGTH * points[..., 0], HEIGHT / 2 - LENGTH * points[..., 1]])


def line(points: np.ndarray, name: str) -> str:
    """A line through points (n, 2) in lengths of the beam."""
    x, y = place(points)
    return page.polyline(x, y, name)
