"""The tab Adjust: the beam that fits measured frequencies, meets targets, or keeps clear of per-rev
lines, and what moves the frequency of a mode most."""

import contextlib
import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from html import escape
from typing import Any, NamedTuple, Self

import numpy as np

from beamviz.adjusting import adjust
from beamviz.adjusting.free_numbers import FACTORS, free_number, usual_bounds
from beamviz.adjusting.goals import ClearGoal
from beamviz.adjusting.result import Adjusted, Match
from beamviz.beam import NUMBERS, Beam
from beamviz.checks import check_float
from beamviz.drawing.text import Measure, in_words, measure, significant
from beamviz.errors import InvalidInput, NoAnswer
from beamviz.explorer import page
from beamviz.explorer.declarations import Key, Tab, choice, name_key
from beamviz.explorer.feature import Feature, cancelled, fading, progress
from beamviz.explorer.jobs import Answer, Job
from beamviz.explorer.page import Content
from beamviz.explorer.snapshot import Snapshot
from beamviz.explorer.state import Case, Slice, State
from beamviz.explorer.visitor import Visitor
from beamviz.measured import (
    MeasuredFrequency,
    points_over,
    table_of_text,
    target_frequencies,
    text_of_columns,
)
from beamviz.scene import Scene
from beamviz.solver import solve

GOALS = {
    "measured": "fit measured frequencies",
    "targets": "meet target frequencies",
    "clear": "keep clear of per-rev lines",
}
FREE = ("alpha", "beta", "gamma", "delta", "mu", "root", "pitch", "twist", *FACTORS)
NAMES = {
    "root": "root stiffness",
    "bending_factor": "factor on EI",
    "axial_factor": "factor on EA",
    "mass_factor": "factor on ρA",
}
MAX_CHARACTERS = 50_000  # of the measured frequencies
FAR, FAR_RELATIVE = 3.0, 0.05  # errors, or of the frequency, from which on a fit is called poor
STRONG = 0.95  # a correlation that is told
ROUNDING = 1e-9  # [%] a smaller effect of a number is none
JOB, EFFECTS = "adjusted beam", "sensitivities"

Bounds = tuple[float, float]


def read_text(value: Any) -> str:
    """A text of a link. Raises InvalidInput."""
    if not isinstance(value, str) or len(value) > MAX_CHARACTERS:
        raise InvalidInput(f"{str(value)[:40]!r}: must be a text of up to {MAX_CHARACTERS}")
    return value


def read_free(value: Any) -> tuple[tuple[str, Bounds | None], ...]:
    """The free numbers of a link, as "alpha, beta=0:1". Raises InvalidInput."""
    free: dict[str, Bounds | None] = {}
    for part in filter(None, map(str.strip, read_text(value).split(","))):
        name, equals, ends = part.partition("=")
        if name not in FREE:
            raise InvalidInput(f"free {name!r}: must be one of {', '.join(FREE)}")
        free[name] = None
        if equals:
            try:
                low, high = map(float, ends.split(":"))
            except ValueError:
                raise InvalidInput(f"free {part!r}: must be NAME or NAME=LOW:HIGH") from None
            free[name] = check_float(f"free {name}", low), check_float(f"free {name}", high)
    return tuple(free.items())


def write_free(free: tuple[tuple[str, Bounds | None], ...]) -> str:
    """The text that `read_free` reads."""
    return ", ".join(
        name if bounds is None else f"{name}={bounds[0]!r}:{bounds[1]!r}" for name, bounds in free
    )


@dataclass(frozen=True, eq=False)
class Outcome:
    """An answer: the adjusted beam, or why there is none, with the nearest one in the bounds."""

    case: Case  # before
    adjusted: Adjusted | None
    reason: str = ""


@dataclass(frozen=True)
class AdjustState(Slice):
    """The goal, what is free, and the last answer."""

    goal: str = field(
        default="measured", metadata=choice(values=GOALS, key=name_key("goal", GOALS))
    )
    # CSV of measured frequencies, as typed.
    measured: str = field(default="", metadata=choice(key=Key("measured", read_text, is_long=True)))
    # Frequencies by mode, as "B1=3.6, B2=4.2Hz".
    targets: str = field(default="", metadata=choice(key=Key("targets", read_text)))
    # Multiples of the speed, as "1, 2", the range of the speed, as "2:6", and the margin.
    clear_of: str = field(default="1", metadata=choice(key=Key("clear", read_text)))
    between: str = field(default="2:6", metadata=choice(key=Key("between", read_text)))
    margin: float = field(
        default=0.1,
        metadata=choice(key=Key("margin", lambda value: check_float("margin", value, 1e-4, 1.0))),
    )
    # Names of the free numbers, each with its bounds, None for the usual ones.
    free: tuple[tuple[str, Bounds | None], ...] = field(
        default=(("alpha", None), ("beta", None)),
        metadata=choice(key=Key("free", read_free, write_free)),
    )
    outcome: Outcome | None = field(default=None, metadata=choice(until=("scene",)))

    def saved(self, scene: Scene) -> Scene:
        """With the measured frequencies, unless there is an error in them."""
        if self.measured.strip():
            with contextlib.suppress(InvalidInput):
                table = table_of_text(self.measured, scene.beam.units)
                return replace(scene, measured=dict(table.columns))
        return scene

    def loaded(self, scene: Scene) -> Self:
        """With the measured frequencies of a scene, in place of those that are typed."""
        if not scene.measured:
            return self
        return replace(self, goal="measured", measured=text_of_columns(scene.measured))


class AdjustRequest(NamedTuple):
    """A beam to adjust."""

    case: Case
    goal: str
    free: dict[str, Bounds | None]
    given: dict[str, Any]  # the keywords of `adjust` of the goal

    @classmethod
    def of(cls, state: State) -> Self:
        """The beam of a state. Raises InvalidInput for what is typed wrong."""
        chosen, beam = state.slice(AdjustState), state.case.beam
        given = keywords_of(chosen, beam)
        free = {name: bounds for name, bounds in chosen.free if name in offered(state.case)}
        if not free:
            raise InvalidInput("choose at least one number that is free")
        for name, bounds in free.items():
            free_number(beam, name, bounds)
        return cls(state.case, chosen.goal, free, given)

    @property
    def beam(self) -> Beam:
        return self.case.beam

    def outcome(self) -> Outcome:
        """The adjusted beam, or the reason why there is none. Raises the errors of `adjust` for
        what is typed wrong."""
        try:
            return Outcome(self.case, adjust(self.beam, self.free, **self.given, **self.options))
        except NoAnswer as error:
            return Outcome(self.case, error.best, in_words(str(error), self.beam.units))

    @property
    def options(self) -> dict[str, Any]:
        return {name: value for name, value in self.case.options.items() if name != "modes"}


def keywords_of(chosen: AdjustState, beam: Beam) -> dict[str, Any]:
    """The keywords of `adjust` of a goal. Raises InvalidInput for what is typed wrong."""
    if chosen.goal == "measured":
        return {"measured": table_of_text(chosen.measured, beam.units).columns}
    if chosen.goal == "targets":
        targets = targets_of(chosen.targets)
        target_frequencies(beam, targets)
        return {"targets": targets}
    try:
        lines = tuple(int(part) for part in chosen.clear_of.replace(",", " ").split())
    except ValueError:
        raise InvalidInput(
            f"lines {chosen.clear_of!r}: must be whole numbers between commas, as 1, 2"
        ) from None
    ClearGoal.of(beam, lines, chosen.between, chosen.margin)
    return {"clear": lines, "between": chosen.between, "margin": chosen.margin}


def targets_of(text: str) -> dict[str, str]:
    """Frequencies by mode, of a text as "B1=3.6, B2=4.2Hz". Raises InvalidInput."""
    targets = {}
    for part in filter(None, (part.strip() for part in text.replace(";", ",").split(","))):
        mode, equals, frequency = map(str.strip, part.partition("="))
        if not (mode and equals and frequency):
            raise InvalidInput(f"target {part!r}: must be MODE=FREQUENCY, as B1=3.6 or B1=12Hz")
        targets[mode] = frequency
    if not targets:
        raise InvalidInput("no targets: give MODE=FREQUENCY, as B1=3.6 or B1=12Hz")
    return targets


def offered(case: Case) -> tuple[str, ...]:
    """The numbers that may be free: T* of a beam in SI depends on mu, and only that has factors."""
    has_size, in_space = case.units is not None, case.options["plane"] == "both"
    left_out = {"mu"} if has_size else {*FACTORS}
    if not in_space:
        left_out |= {"pitch", "twist"}
    return tuple(name for name in FREE if name not in left_out)


def display(name: str, beam: Beam) -> Measure:
    """The display of a number that may be free."""
    if name in NUMBERS:
        return measure(name, beam.units)
    return Measure(NAMES[name], NAMES[name])


def measured_points(state: State, over: str) -> list[tuple[float, MeasuredFrequency]]:
    """The measured frequencies that are typed, for a chart over a number of the beam, each at its
    value of that; none while there is an error in them."""
    text = state.slice(AdjustState).measured
    if text.strip():
        with contextlib.suppress(InvalidInput):
            beam = state.case.beam
            return points_over(beam, over, table_of_text(text, beam.units).rows)
    return []


def goal_of_lines(state: State) -> ClearGoal | None:
    """The goal to keep clear of per-rev lines; None while another one is chosen, or there is an
    error in it."""
    chosen = state.slice(AdjustState)
    if chosen.goal == "clear":
        with contextlib.suppress(InvalidInput):
            beam = state.case.beam
            return ClearGoal.of(beam, *keywords_of(chosen, beam).values())
    return None


# The tab


def free_row(name: str) -> str:
    """A number that may be free, and its bounds."""
    label = NAMES.get(name) or NUMBERS[name].slider_label
    box = f'<input type="checkbox"{page.attributes(data_set=f"adjust.free.{name}")}>'
    ends = ""
    for end, words in (("low", f"lowest {label}"), ("high", f"highest {label}")):
        box_of_end = page.number_box(
            f"adjust-{end}-{name}", f"adjust.{end}.{name}", aria_label=words
        )
        ends += f"<td>{box_of_end}</td>"
    head = f'<td><label class="check">{box}{escape(label)}</label></td>'
    return f'<tr id="adjust-row-{name}">{head}{ends}</tr>'


def text_field(key: str, label: str, help: str) -> str:
    """A field for a line of text."""
    attributes = page.attributes(id=f"{key}-field", type="text", data_set=f"adjust.{key}")
    name = f'<label for="{key}-field">{escape(label)}</label>{page.hint(label, help, key)}'
    return f'<div class="field"><span class="name">{name}</span><input{attributes}></div>'


MEASURED_HELP = (
    "A line for each frequency, below the names of the columns: frequency or hertz; if known mode,"
    " error, and gamma, rpm or another number at which it was measured."
)
EXAMPLE = "gamma, mode, frequency, error"
INPUTS = page.select("goal", "goal", GOALS)
INPUTS += page.button("Adjust", id="adjust-button", class_="main", data_do="adjust.run")
INPUTS += '<div id="adjust-work" role="status"></div>'
INPUTS += (
    '<div id="adjust-measured"><label for="measured-text">measured frequencies (CSV)</label>'
    f"{page.hint('measured frequencies', MEASURED_HELP)}"
    '<textarea id="measured-text" data-set="adjust.measured" rows="6" spellcheck="false"'
    f' placeholder="{EXAMPLE}" aria-describedby="adjust-wrong"></textarea>'
    '<div class="choices"><label class="button" for="measured-file">open a file</label>'
    '<input type="file" id="measured-file" class="hidden" data-do="adjust.file"'
    ' accept=".csv,.tsv,.txt"></div></div>'
)
INPUTS += '<div id="adjust-targets">'
INPUTS += text_field("targets", "targets", "MODE=FREQUENCY between commas, as B1=3.6, B2=12Hz")
INPUTS += '</div><div id="adjust-clear">'
INPUTS += text_field("clear_of", "per-rev lines", "Multiples of the speed between commas: 1, 2")
INPUTS += text_field("between", "speeds", "The range as LOW:HIGH, as 2:6 or 200rpm:400rpm")
MARGIN_HELP = "The least distance of a frequency from a line, relative to that"
INPUTS += page.slider("adjust.margin", "margin [%]", MARGIN_HELP, min=1, max=50, step=1)
INPUTS += '</div><div id="adjust-wrong" role="status"></div>'
INPUTS += (
    '<table class="adjust-free" aria-label="free numbers"><thead><tr><th scope="col">free</th>'
    '<th scope="col">from</th><th scope="col">to</th></tr></thead><tbody>'
    f"{''.join(map(free_row, FREE))}</tbody></table>"
)
CONTENT = (
    f'<div class="adjust-tab"><div class="tools">{INPUTS}</div>'
    '<div id="adjust-chart" class="chart" data-chart></div>'
    '<div class="lists"><div id="adjust-answer" role="status"></div><div id="adjust-matches"></div>'
    '<div id="adjust-effects"></div></div></div>'
)


class AdjustTab(Feature):
    """The goal, what is free, the answer, and the sensitivities of the mode shown."""

    style = "adjust.css"
    tab = Tab(
        "Adjust",
        8,
        "The beam that fits measured frequencies, meets targets or keeps clear of resonances",
        CONTENT,
    )
    state = AdjustState

    def __init__(self, visitor: Visitor):
        super().__init__(visitor)
        submit = visitor.workers.background.submit
        self.job: Job[AdjustRequest, Outcome] = visitor.add_own_job(
            Job(JOB, AdjustRequest.outcome, submit, self.finish)
        )
        visitor.job(EFFECTS, effects_of)
        for name in ("measured", "targets", "clear_of", "between"):
            self.page.on(f"adjust.{name}", partial(self.enter, name), str, max_text=MAX_CHARACTERS)
        self.page.on("adjust.file", self.open_file, str, max_text=MAX_CHARACTERS)
        visitor.bind("adjust.margin", with_margin, margin_shown, float)
        for name in FREE:
            visitor.bind(
                f"adjust.free.{name}", partial(with_free, name), partial(is_free, name), bool
            )
            for k, end in enumerate(("low", "high")):
                key = f"adjust.{end}.{name}"
                visitor.bind(
                    key, partial(with_bound, name, k), partial(bound_shown, name, k), float
                )
        self.page.on("adjust.run", self.run)

    def enter(self, name: str, text: Any) -> None:
        self.visitor.change(lambda state: state.with_values(AdjustState, **{name: str(text)}))

    def open_file(self, text: Any) -> None:
        """Take the text of a file, whose name is its first line."""
        self.enter("measured", str(text).partition("\n")[2])

    def run(self, _: Any) -> None:
        """Begin to adjust; the page says what is typed wrong."""
        with self.visitor.lock:
            try:
                request = AdjustRequest.of(self.visitor.state)
            except InvalidInput:
                return
            self.job.request(request)

    def finish(self) -> None:
        """Move the scene to the answer."""
        answer = self.job.taken()
        if answer is None or answer.cancelled:
            self.visitor.wake()
            return
        with self.visitor.lock:
            self.visitor.change(partial(answered, answer), loads=True)

    def wanted(self, snapshot: Snapshot) -> Mapping[str, Any]:
        """The sensitivities while the tab is open."""
        case = snapshot.drawn_case
        return {EFFECTS: case if case and snapshot.state.tab == self.tab.key else None}

    def content(self, snapshot: Snapshot) -> Content:
        state = snapshot.state
        status, wrong = snapshot.jobs[JOB], wrong_of(state)
        working = progress([status]) if status.late else cancelled([status])
        return (
            goal_content(state, wrong)
            | rows_content(state.case)
            | page.props("adjust-button", disabled=bool(wrong) or status.late)
            | page.html("adjust-work", working)
            | page.html("adjust-answer", answer_html(state))
            | page.html("adjust-effects", effects_html(snapshot))
            | fading(snapshot, [EFFECTS], "adjust-effects")
        )


def answered(answer: Answer[AdjustRequest, Outcome], state: State) -> State:
    """With an answer, and its beam where the goal is met and no number was edited since."""
    case = answer.request.case
    outcome = answer.result or Outcome(case, None, answer.message)
    if outcome.reason or outcome.adjusted is None:
        return state.with_values(AdjustState, outcome=outcome)
    if state.case != case:
        reason = "the beam was edited meanwhile and stays as it is"
        return state.with_values(AdjustState, outcome=replace(outcome, reason=reason))
    scene = Scene(outcome.adjusted.beam, case.options)
    moved = replace(state, case=Case.of(scene)).after("case").after("structure")
    return moved.with_mass_kept().with_values(AdjustState, outcome=outcome)


def wrong_of(state: State) -> str:
    """What is typed wrong; "" for nothing."""
    try:
        AdjustRequest.of(state)
    except InvalidInput as error:
        return in_words(str(error), state.case.units)
    return ""


def with_margin(state: State, percent: Any) -> State:
    margin = percent / 100 if isinstance(percent, int | float) else math.nan
    if not 0.001 <= margin <= 1:
        return state
    return state.with_values(AdjustState, margin=margin)


def margin_shown(state: State) -> float:
    return round(100 * state.slice(AdjustState).margin, 6)


def is_free(name: str, state: State) -> bool:
    return name in dict(state.slice(AdjustState).free)


def with_free(name: str, state: State, on: Any) -> State:
    free = {key: ends for key, ends in state.slice(AdjustState).free if key != name or on}
    if on:
        free.setdefault(name, None)
    return state.with_values(AdjustState, free=tuple(free.items()))


def bounds_of(name: str, state: State) -> Bounds:
    bounds = dict(state.slice(AdjustState).free).get(name)
    return bounds or usual_bounds(state.case.nearest_beam(), name)


def bound_shown(name: str, k: int, state: State) -> float:
    shown = display(name, state.case.nearest_beam())
    return float(f"{shown.factor * bounds_of(name, state)[k]:.6g}")


def with_bound(name: str, k: int, state: State, value: Any) -> State:
    """With a bound of a number, which is free then."""
    ends = [*bounds_of(name, state)]
    plain = display(name, state.case.nearest_beam()).plain(value)
    if not isinstance(plain, int | float) or not math.isfinite(plain):
        return state
    ends[k] = float(plain)
    free = dict(state.slice(AdjustState).free) | {name: (ends[0], ends[1])}
    return state.with_values(AdjustState, free=tuple(free.items()))


def goal_content(state: State, wrong: str) -> Content:
    """The fields of the goal, and what is wrong in them."""
    chosen = state.slice(AdjustState)
    content: Content = {}
    for goal in GOALS:
        content |= page.props(f"adjust-{goal}", hidden=chosen.goal != goal)
    for name in ("measured", "targets", "clear_of", "between"):
        content |= page.value(f"adjust.{name}", getattr(chosen, name))
    typed = chosen.measured if chosen.goal == "measured" else chosen.targets
    is_empty = chosen.goal != "clear" and not typed.strip()
    invitation = "<p>Type, paste or open the frequencies that the beam is to have.</p>"
    return content | page.html("adjust-wrong", invitation if is_empty else page.note(wrong))


def rows_content(case: Case) -> Content:
    """The numbers that may be free."""
    shown, content = offered(case), Content()
    for name in FREE:
        content |= page.props(f"adjust-row-{name}", hidden=name not in shown)
    return content


def answer_html(state: State) -> str:
    """The adjusted numbers, and what the data do not determine."""
    outcome = state.slice(AdjustState).outcome
    if outcome is None:
        return ""
    text = page.note(outcome.reason)
    if (adjusted := outcome.adjusted) is None:
        return text
    text += page.note(poor_fit(adjusted)) + numbers_table(adjusted) + doubts(adjusted)
    if held := adjusted.held:
        speed = measure("gamma", adjusted.units).text(held.speed, 4)
        text += (
            f"<p>Least margin {100 * held.margin:.3g} %: mode {escape(held.mode)} and the line"
            f" {held.per_rev} × speed, at {speed}.</p>"
        )
    return text


def poor_fit(adjusted: Adjusted) -> str:
    """How far the beam is from what was measured, where that is far; "" else."""
    worst = max(filter(is_far, adjusted.matches), key=relative_distance, default=None)
    if worst is None:
        return ""
    percent = 100 * (worst.predicted / worst.measured - 1)
    return (
        f"A poor fit: {worst.mode} is {percent:+.2g} % off. Are plane and modes those of the"
        " measurement, and is what is wrong in the beam among what may change?"
    )


def relative_distance(match: Match) -> float:
    return abs(match.predicted / match.measured - 1)


def is_far(match: Match) -> bool:
    """Whether a mode is far from its measured frequency, by the error if that is known."""
    if not match.mode:
        return False
    return abs(match.residual) > FAR if match.error > 0 else relative_distance(match) > FAR_RELATIVE


def numbers_table(adjusted: Adjusted) -> str:
    rows = []
    for name, value in adjusted.free.items():
        shown, error = display(name, adjusted.beam), adjusted.errors.get(name, math.nan)
        known = math.isfinite(error) and name not in adjusted.undetermined
        deviation = f"± {significant(shown.factor * error, 2)}" if known else "–"
        rows.append((escape(shown.label), significant(shown.factor * value, 5), deviation))
    if not adjusted.errors:
        return page.table("adjusted numbers", ("number", "value"), [row[:2] for row in rows])
    return page.table("adjusted numbers", ("number", "value", "standard deviation"), rows)


def doubts(adjusted: Adjusted) -> str:
    """What the data do not determine, strong correlations, bounds that were met, other answers."""
    names = {name: display(name, adjusted.beam).label for name in adjusted.free}
    texts = [
        f"The data do not determine {names[name]}: beams with other values fit as well."
        for name in adjusted.undetermined
    ]
    keys = [*adjusted.free]
    if adjusted.goal != "clear":
        for i, j in zip(*np.triu_indices(len(keys), 1), strict=True):
            r = float(adjusted.correlations[i, j])
            if abs(r) >= STRONG:
                both = f"{names[keys[i]]} and {names[keys[j]]}"
                texts.append(f"{both}: correlation {r:.3f}, hard to tell apart by these data.")
    texts += [f"{names[name]} is at the end of its range." for name in adjusted.at_bounds]
    for alternative in adjusted.alternatives:
        values = ", ".join(
            f"{names[name]} {significant(display(name, adjusted.beam).factor * value, 4)}"
            for name, value in alternative.items()
        )
        texts.append(f"Fits as well: {values}.")
    return "".join(map(page.note, texts))


# Sensitivities


def effects_of(case: Case) -> list[tuple[str, dict[str, float]]]:
    """Each mode, and the change of its frequency [%] for one hundredth of the range of the slider
    of each number. Raises the errors of `solve`."""
    solution = solve(case.beam, **case.options)
    steps = {}
    for name, slopes in solution.sensitivities.items():
        low, high = usual_bounds(solution.beam, name)
        width = solution.beam.root if name == "root" else high - low
        effects = slopes * width / solution.frequencies
        steps[name] = np.where(abs(effects) < ROUNDING, 0.0, effects)
    return [
        (label, {name: float(each[k]) for name, each in steps.items() if np.isfinite(each[k])})
        for k, label in enumerate(solution.labels)
    ]


def effects_html(snapshot: Snapshot) -> str:
    """The numbers that move the mode shown most, as bars."""
    answer = snapshot.job_answer(EFFECTS)
    if answer is None:
        return ""
    if answer.result is None:
        return page.note(answer.message)
    mode = int(np.argmax(snapshot.state.view.shares))
    label, effects = answer.result[min(mode, len(answer.result) - 1)]
    order = sorted(effects, key=lambda name: -abs(effects[name]))
    largest = max((abs(effects[name]) for name in order), default=0.0) or 1.0
    beam, rows = answer.request.nearest_beam(), []
    for name in order:
        effect = effects[name]
        kind = "adjust-bar" + (" falls" if effect < 0 else "")
        bar = f'<span class="{kind}" style="width:{100 * abs(effect) / largest:.1f}%"></span>'
        rows.append((escape(display(name, beam).label), bar, f"{effect:+.3g}" if effect else "0"))
    caption = f"What moves {escape(label)} most: % per hundredth of the range of each number"
    return page.table("sensitivities", ("number", "effect", "%"), rows, caption=caption)
