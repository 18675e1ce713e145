"""The frequencies that are given in the tab Adjust, measured or targets, beside those of the beam:
the mode that each is matched to, which can be changed, and its residual."""

import math
from collections.abc import Mapping
from html import escape
from typing import Any, NamedTuple, Self

from beamviz.adjusting.fit import Comparison, compared
from beamviz.adjusting.result import Match
from beamviz.drawing.text import frequencies, in_words, measure
from beamviz.errors import InvalidInput
from beamviz.explorer import page
from beamviz.explorer.feature import Feature, fading
from beamviz.explorer.features.adjust import AdjustState, AdjustTab, targets_of
from beamviz.explorer.page import Content
from beamviz.explorer.snapshot import Snapshot
from beamviz.explorer.state import Case, State
from beamviz.explorer.visitor import Visitor
from beamviz.measured import (
    MeasuredFrequency,
    table_of_text,
    target_frequencies,
    with_mode,
)
from beamviz.units import Units

JOB, TABLE = "matches", "adjust-matches"
MOST_SETTINGS = 40  # of the beam, for each of which it is solved after every edit


class MatchRequest(NamedTuple):
    """A beam to compare with frequencies."""

    case: Case
    goal: str
    rows: tuple[MeasuredFrequency, ...]

    @classmethod
    def of(cls, state: State) -> Self | None:
        """That of a state; None where no frequencies are given. Raises InvalidInput for what is
        typed wrong."""
        chosen, beam = state.slice(AdjustState), state.case.beam
        if chosen.goal == "measured":
            return cls(state.case, chosen.goal, table_of_text(chosen.measured, beam.units).rows)
        if chosen.goal == "targets":
            targets = target_frequencies(beam, targets_of(chosen.targets))
            return cls(state.case, chosen.goal, tuple(targets))
        return None

    def comparison(self) -> Comparison:
        """Raises InvalidInput, for modes of another plane, and for too many settings."""
        count = len({row.numbers for row in self.rows})
        if count > MOST_SETTINGS:
            raise InvalidInput(
                f"measured at {count} speeds or other numbers: residuals are shown for up to"
                f" {MOST_SETTINGS}; Adjust fits all"
            )
        options = {name: value for name, value in self.case.options.items() if name != "modes"}
        return compared(self.case.beam, [*self.rows], options)


class Matches(Feature):
    """The table of the tab Adjust."""

    def __init__(self, visitor: Visitor):
        super().__init__(visitor)
        visitor.job(JOB, MatchRequest.comparison)
        self.page.on("adjust.match", self.match, str)

    def match(self, text: Any) -> None:
        """Match a row, counted from 0, to a mode: "2 B1", or without a mode to the nearest."""
        row, _, label = str(text).partition(" ")
        with self.visitor.reporting("The mode was not changed"):
            chosen = self.visitor.state.slice(AdjustState)
            if not row.isdecimal():
                raise InvalidInput(f"{text}: must be a row and a mode")
            measured = with_mode(chosen.measured, int(row), label)
            self.visitor.change(lambda state: state.with_values(AdjustState, measured=measured))

    def wanted(self, snapshot: Snapshot) -> Mapping[str, Any]:
        """The matches while the tab is open."""
        return {JOB: wanted_matches(snapshot)}

    def content(self, snapshot: Snapshot) -> Content:
        answer, is_wanted = snapshot.job_answer(JOB), wanted_matches(snapshot) is not None
        content = page.props(TABLE, hidden=not is_wanted)
        if not (answer and is_wanted):
            return content | page.html(TABLE, "")
        units = answer.request.case.units
        if answer.result is None:
            return content | page.html(TABLE, page.note(in_words(answer.message, units)))
        text = matches_table(answer.request, answer.result, units)
        return content | page.html(TABLE, text) | fading(snapshot, [JOB], TABLE)


def wanted_matches(snapshot: Snapshot) -> MatchRequest | None:
    """The matches of the tab while it is open; None while there is an error in what is typed."""
    if snapshot.state.tab != AdjustTab.tab.key:
        return None
    try:
        return MatchRequest.of(snapshot.state)
    except InvalidInput:
        return None


def matches_table(request: MatchRequest, comparison: Comparison, units: Units | None) -> str:
    """A row for each frequency; the modes of measured ones can be changed."""
    across = frequencies(units)
    has_errors = all(math.isfinite(match.error) for match in comparison.matches)
    rows = []
    for k, (row, match) in enumerate(zip(request.rows, comparison.matches, strict=True)):
        place = ", ".join(measure(name, units).text(v, 4) for name, v in match.numbers.items())
        mode = escape(match.mode)
        if request.goal == "measured":
            mode = mode_select(k, row, match, comparison.choices[k])
        pair = across.number(match.measured), across.number(match.predicted)
        rows.append((mode, escape(place), *pair, residual_text(match.residual, has_errors)))
    goal = "measured" if request.goal == "measured" else "target"
    residual = "residual [σ]" if has_errors else "residual [%]"
    heads = ("mode", "at", f"{goal} {across.label}", "beam", residual)
    squares = [match.residual**2 for match in comparison.matches if math.isfinite(match.residual)]
    caption = "Residuals of this beam"
    if squares:
        mean = math.sqrt(sum(squares) / len(squares))
        size = f"{mean:.3g} σ" if has_errors else f"{100 * mean:.3g} %"
        caption += f": {size} root mean square"
    return page.table("residuals", heads, rows, caption=caption)


def residual_text(residual: float, has_errors: bool) -> str:
    """A residual in units of the error, or in %; a dash where the beam has no such mode."""
    if not math.isfinite(residual):
        return "–"
    return f"{residual if has_errors else 100 * residual:+.2f}".replace("-", "−")


def mode_select(k: int, row: MeasuredFrequency, match: Match, labels: tuple[str, ...]) -> str:
    """The choice of the mode of a row: the nearest one, or one of those that the beam has."""
    nearest = f"auto: {match.mode}" if match.mode and not row.mode else "auto"
    names = dict.fromkeys([*labels, row.mode] if row.mode else labels)
    options = "".join(
        f"<option{page.attributes(value=f'{k} {label}'.strip(), selected=label == row.mode)}>"
        f"{escape(name)}</option>"
        for label, name in {"": nearest, **{label: label for label in names}}.items()
    )
    attributes = page.attributes(data_set="adjust.match", aria_label=f"mode of row {k + 1}")
    return f"<select{attributes}>{options}</select>"
