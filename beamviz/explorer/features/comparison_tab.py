"""The tab that compares: with what, how to see it, and both beams' frequencies."""

import math
import threading
from html import escape

from viser import GuiApi

from beamviz.display_units import frequencies
from beamviz.explorer.features.comparison import OVERLAID, STACKED, Comparison
from beamviz.explorer.features.comparison_cases import BEFORE, CHOICES
from beamviz.explorer.page.html import SMALL, table
from beamviz.explorer.page.inputs import Listener, heard
from beamviz.explorer.solver_job import Answer
from beamviz.solver.solution import Solution

THIS = "this beam"
INVITATION = (
    "A second beam on the same clock: see what one change does. "
    "Or drag the mass in the picture: how it was before stays as a ghost."
)


class CompareTab:
    """Hands on what to compare with, and shows both beams' frequencies."""

    def __init__(self, gui: GuiApi, lock: threading.RLock, listener: Listener):
        comparison = listener.comparison
        self.choice = gui.add_dropdown("compare with", CHOICES, hint="The second beam")
        heard(self.choice, lock, comparison.choose)
        layout = gui.add_button_group("drawn", (OVERLAID, STACKED))
        layout.on_click(lambda event: comparison.stack(event.target.value))
        self.table = gui.add_html("")
        gui.add_button(
            "Keep this beam", hint="Then change it: the kept one stays as it was"
        ).on_click(lambda _: listener.keep())

    def show(self, answer: Answer | None, comparison: Comparison) -> None:
        """Tell both beams' frequencies, or why there are none."""
        if self.choice.value != comparison.choice:
            self.choice.value = comparison.choice  # type: ignore[misc]  # as in sliders.assign
        other, second = comparison.other, comparison.answer
        if isinstance(other, str):
            self.table.content = note(other or INVITATION)
        elif second and second.solution is None:
            self.table.content = note(f"{other.title}: {second.message}")
        elif second and second.solution and answer and answer.solution:
            pair = [(THIS, answer.solution), (escape(other.title), second.solution)]
            self.table.content = compared(*(pair[::-1] if comparison.choice == BEFORE else pair))


def note(words: str) -> str:
    """Words in place of a table."""
    return f'<div role="note" style="{SMALL}">{escape(words)}</div>'


def compared(first: tuple[str, Solution], second: tuple[str, Solution]) -> str:
    """The modes by name: frequencies of two beams with their titles, and the change in per cent."""
    (one, this), (two, other) = first, second
    head = frequencies(this.beam.units).label
    heads = ("mode", f"{one}<br>{head}", f"{two}<br>{head}", "change")
    labels = dict.fromkeys((*this.labels, *other.labels))
    rows = [row(label, value(this, label), value(other, label)) for label in labels]
    return table("comparison", heads, rows)


def row(label: str, first: float, second: float) -> tuple[str, ...]:
    """One mode."""
    change = 100 * (second / first - 1) if first > 0 else math.nan
    changed = f"{change:+.2g} %" if math.isfinite(change) else "–"
    return f"<b>{label}</b>", number(first), number(second), changed


def value(solution: Solution, label: str) -> float:
    """The frequency of a mode as shown, nan where it has none or is not among those solved."""
    if label not in solution.labels:
        return math.nan
    factor = frequencies(solution.beam.units).factor
    return factor * float(solution.frequencies[solution.labels.index(label)])


def number(frequency: float) -> str:
    """A frequency, or a dash."""
    return f"{frequency:.6g}" if math.isfinite(frequency) else "–"
