"""The tab Adjust: numbers of the beam are adjusted until it fits measured frequencies, or keeps
clear of per-rev lines. One press moves the scene to the answer, one undo brings it back.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from html import escape
from typing import Any, NamedTuple, Self

from beamviz.adjusting import adjust
from beamviz.adjusting.measured import columns_of_text
from beamviz.adjusting.result import Adjusted
from beamviz.beam import Beam
from beamviz.drawing.text import measure
from beamviz.errors import InvalidInput
from beamviz.explorer import page
from beamviz.explorer.declarations import SWITCH, Key, Tab, choice, name_key, switch_key
from beamviz.explorer.feature import Feature, cancelled, progress
from beamviz.explorer.jobs import Answer
from beamviz.explorer.page import Content
from beamviz.explorer.snapshot import Snapshot
from beamviz.explorer.state import Case, Slice, State
from beamviz.explorer.visitor import Visitor
from beamviz.output.adjusted import free_columns, match_columns, remarks_on

FREE = {  # the choices of what may change: the number, and its name on the page
    "free_alpha": ("alpha", "mass"),
    "free_beta": ("beta", "position"),
    "free_delta": ("delta", "hub"),
    "free_mu": ("mu", "slenderness"),
}
GOALS = {"measured": "fit measured frequencies", "clear": "keep clear of per-rev lines"}
MARGINS = {"0.05": "5 %", "0.1": "10 %", "0.2": "20 %"}
USUAL_LINES = (1, 2, 3)  # where the frequency chart shows none
MAX_TEXT = 20_000  # characters of measured data
JOB = "adjustment"
EXAMPLE = "mode, frequency, error\nB1, 3.4, 0.05\nB2, 16.2, 0.2\nB3, 60, 0.6"
CLEAR_HELP = "Two speeds gamma, as 2 .. 6, or in rpm for a real beam, as 200rpm .. 400rpm"
FREE_HELP = "The numbers that may change. The fewer they are, the better the data determine them"


def checked_text(value: Any) -> str:
    """A text of measured data from a link. Raises InvalidInput."""
    if not isinstance(value, str) or len(value) > MAX_TEXT:
        raise InvalidInput(f"measured: must be a text of at most {MAX_TEXT} characters")
    return value


@dataclass(frozen=True)
class AdjustState(Slice):
    """The data, the goal, and what may change."""

    # Measured frequencies as CSV, as they were entered.
    measured: str = field(
        default="", metadata=choice(key=Key("measured", checked_text, is_long=True))
    )
    adjust_goal: str = field(
        default="measured", metadata=choice(values=GOALS, key=name_key("goal", GOALS))
    )
    # The range of speeds to keep clear, as it was entered.
    clear_between: str = field(
        default="2 .. 6", metadata=choice(key=Key("between", checked_text, is_long=True))
    )
    clear_margin: str = field(
        default="0.1", metadata=choice(values=MARGINS, key=name_key("margin", MARGINS))
    )
    free_alpha: bool = field(
        default=True, metadata=choice(values=SWITCH, key=switch_key("free_alpha"))
    )
    free_beta: bool = field(
        default=True, metadata=choice(values=SWITCH, key=switch_key("free_beta"))
    )
    free_delta: bool = field(
        default=False, metadata=choice(values=SWITCH, key=switch_key("free_delta"))
    )
    free_mu: bool = field(default=False, metadata=choice(values=SWITCH, key=switch_key("free_mu")))
    # The answer is awaited, which then replaces the numbers of the beam.
    adjusting: bool = field(
        default=False, metadata=choice(undo="ends", until=("case", "scene", "opened"))
    )

    def free(self, case: Case) -> tuple[str, ...]:
        """The numbers that may change; the slenderness of a beam in SI is that of its section."""
        names = (number for key, (number, _) in FREE.items() if getattr(self, key))
        return tuple(name for name in names if name != "mu" or case.units is None)


class AdjustRequest(NamedTuple):
    """An adjustment to compute."""

    case: Case
    goal: str
    measured: str
    lines: tuple[int, ...]
    between: str
    margin: float
    free: tuple[str, ...]

    @classmethod
    def of(cls, state: State) -> Self:
        own = state.slice(AdjustState)
        return cls(
            state.case,
            own.adjust_goal,
            own.measured.strip(),
            state.per_rev or USUAL_LINES,
            own.clear_between,
            float(own.clear_margin),
            own.free(state.case),
        )

    @property
    def beam(self) -> Beam:
        return self.case.beam

    def adjusted(self) -> Adjusted:
        """The answer. Raises InvalidInput for an entry that cannot be read, NoAnswer, and the
        errors of `solve`."""
        if not self.free:
            raise InvalidInput("nothing may change: choose a number that may")
        options: dict[str, Any] = dict(self.case.options)
        if self.goal == "clear":
            low, _, high = self.between.partition("..")
            goal: dict[str, Any] = {"clear": self.lines, "margin": self.margin}
            goal["between"] = (low.strip(), high.strip())
        elif not self.measured:
            raise InvalidInput("no data: enter measured frequencies, or open a file of them")
        else:
            goal = {"measured": columns_of_text(self.measured, "data")}
        return adjust(self.beam, self.free, **goal, **options)


TOOLS = (
    page.select("adjust_goal", "goal", GOALS)
    + '<div id="adjust-data"><label for="measured-box">measured frequencies (CSV)</label>'
    f'<textarea id="measured-box" data-set="measured" rows="5" spellcheck="false" placeholder="'
    f'{escape(EXAMPLE)}"></textarea>'
    '<div class="row"><label class="button" for="measured-file">Open a file</label>'
    '<input type="file" id="measured-file" class="hidden" data-do="measured_file"'
    ' accept=".csv,.txt,.tsv"></div></div>'
    '<div id="adjust-clear" hidden><div class="row"><label for="clear-between">speeds</label>'
    f'<input type="text" id="clear-between" data-set="clear_between">'
    f"{page.hint('speeds to keep clear', CLEAR_HELP)}</div>"
    f"{page.select('clear_margin', 'margin', MARGINS)}"
    '<p id="adjust-lines" class="soft"></p></div>'
    f'<fieldset class="free"><legend>may change {page.hint("what may change", FREE_HELP)}</legend>'
    + "".join(page.checkbox(key, name) for key, (_, name) in FREE.items())
    + "</fieldset>"
    + page.button("Adjust", id="adjust-button", class_="main", data_do="adjust")
)


class AdjustTab(Feature):
    """The data and the goal; what the answer is, and how well the data determine it."""

    tab = Tab(
        "Adjust",
        7,
        "The beam that fits measured frequencies, or keeps clear of resonances",
        f'<div class="adjust-tab"><div class="tools">{TOOLS}</div>'
        '<div class="results"><div id="adjust-work" role="status"></div>'
        '<div id="adjust-result"></div><div id="adjust-sensitivities"></div></div></div>',
    )
    style = "adjust.css"
    state = AdjustState

    def __init__(self, visitor: Visitor):
        super().__init__(visitor)
        visitor.job(JOB, AdjustRequest.adjusted)
        visitor.bind("measured", with_text("measured"), shown_text("measured"), str)
        visitor.bind("clear_between", with_text("clear_between"), shown_text("clear_between"), str)
        self.page.on("measured_file", self.read, str, max_text=2 * MAX_TEXT)
        self.page.on("adjust", lambda _: visitor.update(begun))

    def read(self, file: Any) -> None:
        """Take the data of a file: its name, and its contents from line 2 on."""
        _, _, text = str(file).partition("\n")
        with self.visitor.reporting("The file was not read"):
            columns_of_text(text, "file")
            self.visitor.change(lambda state: with_text("measured")(state, text))

    def wanted(self, snapshot: Snapshot) -> Mapping[str, Any]:
        """The adjustment while it is awaited."""
        state = snapshot.state
        return {JOB: AdjustRequest.of(state)} if state.slice(AdjustState).adjusting else {}

    def react(self, snapshot: Snapshot, elapsed: float) -> None:
        """Move the scene to the answer."""
        answer = answer_of(snapshot)
        if answer is None or not snapshot.state.slice(AdjustState).adjusting:
            return
        with self.visitor.lock:
            if AdjustRequest.of(self.visitor.state) != answer.request:
                return
            self.visitor.update(ended)
            if (adjusted := answer.result) is not None:
                self.visitor.change(lambda state: moved(state, adjusted), loads=True)

    def content(self, snapshot: Snapshot) -> Content:
        own, job = snapshot.state.slice(AdjustState), snapshot.jobs[JOB]
        lines = ", ".join(f"{line} ×" for line in snapshot.state.per_rev or USUAL_LINES)
        told = progress([job]) if own.adjusting and job.late else cancelled([job])
        return (
            page.props("adjust-data", hidden=own.adjust_goal != "measured")
            | page.props("adjust-clear", hidden=own.adjust_goal != "clear")
            | page.html("adjust-lines", f"lines: {lines}, as in the frequency chart")
            | page.props("free_mu", disabled=snapshot.state.case.units is not None)
            | page.html("adjust-work", told)
            | page.html("adjust-result", result_text(answer_of(snapshot), snapshot.entered_beam))
            | page.html("adjust-sensitivities", sensitivities_text(snapshot))
        )


def answer_of(snapshot: Snapshot) -> Answer[AdjustRequest, Adjusted] | None:
    """The last answer; None before it, and where it was cancelled."""
    answer = snapshot.job_answer(JOB)
    return None if answer is None or answer.cancelled else answer


def with_text(name: str) -> Any:
    """The edit of a text of the slice."""

    def edit(state: State, value: Any) -> State:
        return state.with_values(AdjustState, **{name: str(value)[:MAX_TEXT]})

    return edit


def shown_text(name: str) -> Any:
    return lambda state: getattr(state.slice(AdjustState), name)


def begun(state: State) -> State:
    """With the answer awaited; unchanged for a number out of range."""
    return state.with_values(AdjustState, adjusting=True) if state.case.in_range else state


def ended(state: State) -> State:
    return state.with_values(AdjustState, adjusting=False)


def moved(state: State, adjusted: Adjusted) -> State:
    """With the numbers of the answer."""
    for name in adjusted.free:
        state = state.changed(name, getattr(adjusted.beam, name))
    return state


# What the tab shows


def result_text(answer: Answer[AdjustRequest, Adjusted] | None, beam: Beam | None) -> str:
    """The answer, or why there is none (HTML)."""
    if answer is None:
        return ""
    if answer.result is None:
        return page.note(answer.message)
    found = answer.result
    is_shown = beam is not None and all(
        getattr(beam, name) == getattr(found.beam, name) for name in found.free
    )
    title = "The scene shows it; undo brings the beam before it back."
    title = title if is_shown else "The beam has been changed since."
    remarks = "".join(page.note(text) for text in remarks_on(found))
    parts = [f"<p>{title}</p>", table_of("adjusted numbers", free_columns(found)), remarks]
    if found.matches:
        parts.append(table_of("measured frequencies", match_columns(found)))
    parts.append(correlation_text(found))
    return "".join(parts)


def table_of(name: str, columns: Mapping[str, Collection[str]]) -> str:
    """A table of columns of texts by their heads."""
    rows = (tuple(map(escape, row)) for row in zip(*columns.values(), strict=True))
    return page.table(name, tuple(map(escape, columns)), rows)


STRONG = 0.95  # a correlation that is told


def correlation_text(found: Adjusted) -> str:
    """The pairs of numbers that the data hardly tell apart (HTML)."""
    names = list(found.free)
    pairs = [
        f"{first} and {second} ({found.correlations[i, j]:+.3f})"
        for i, first in enumerate(names)
        for j, second in enumerate(names)
        if i < j and abs(found.correlations[i, j]) > STRONG
    ]
    return page.note(f"Hardly told apart by the data: {', '.join(pairs)}.") if pairs else ""


def sensitivities_text(snapshot: Snapshot) -> str:
    """What moves the mode that is shown most: bars of the relative change of its frequency with a
    relative change of each number (HTML); "" where it is not known, or the tab is closed."""
    solution = snapshot.answer.solution if snapshot.answer else None
    if snapshot.state.tab != AdjustTab.tab.key or solution is None or snapshot.answer is None:
        return ""
    k = next(iter(sorted(snapshot.picture.shown)), None)
    if k is None:
        return ""
    beam, frequency = solution.beam, float(solution.frequencies[k])
    shares = {}
    for name, values in solution.sensitivities.items():
        number = getattr(beam, name, None)
        if isinstance(number, float | int) and number and frequency:
            shares[name] = float(values[k]) * number / frequency
    shares = {name: share for name, share in shares.items() if abs(share) >= 5e-4}
    if not shares:
        return ""
    most = max(abs(share) for share in shares.values())
    rows = (
        (
            escape(measure(name, beam.units).label),
            f'<span class="bar {"up" if share > 0 else "down"}"'
            f' style="--size: {100 * abs(share) / most:.0f}%"></span>',
            f"{share:+.2f} %",
        )
        for name, share in sorted(shares.items(), key=lambda item: -abs(item[1]))
    )
    heads = ("1 % more of", "", "changes it by")
    return page.table("sensitivities", heads, rows, caption="What moves the mode shown most")
