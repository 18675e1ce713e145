"""A second beam beside the one of the scene, on the same clock: as a ghost in it, or above it."""

import math
from collections.abc import Callable
from dataclasses import replace
from html import escape
from typing import Any, NamedTuple

import numpy as np

from beamviz.display_units import frequencies
from beamviz.drawing.all_modes import Titled, add_title
from beamviz.drawing.modes import Clock, Shapes, amplitudes
from beamviz.drawing.overlay_beam import Ghost
from beamviz.drawing.subdivision import SCALE, Seen
from beamviz.explorer.jobs import SolveJob, SolverAnswer
from beamviz.explorer.page.html import SMALL
from beamviz.explorer.state import EARLIER, NO_COMPARISON, TERMS, Case, State
from beamviz.explorer.visitor import Feature, Visitor, on_press
from beamviz.exports.html_tables import table
from beamviz.scene import ViewOptions
from beamviz.solver.solution import Solution


class Against(NamedTuple):
    """Another beam to compare with: what it is called, and what to solve for it."""

    title: str
    case: Case


def method(case: Case) -> Against:
    """The paper's elements, or the exact solution where these are chosen already."""
    if case.options.get("method", "auto") == "ancf":
        return Against("exact", case.with_options(method="auto"))
    return Against("paper's ANCF, 20 elements", case.with_options(method="ancf"))


def coriolis(case: Case) -> Against | str:
    """With Coriolis forces, or without where they are on."""
    if case.options["plane"] == "flapwise":
        return "Coriolis forces act in the plane of rotation only: choose chordwise under Model."
    on = not case.options.get("coriolis", False)
    return Against(f"Coriolis {'on' if on else 'off'}", case.with_options(coriolis=on))


def twice(case: Case) -> Against | str:
    """Twice the mass."""
    if case.numbers["alpha"] == 0:
        return "There is no mass to double: give the beam one first."
    double = replace(case, numbers={**case.numbers, "alpha": 2 * case.numbers["alpha"]})
    return Against("twice the mass", double)


def all_terms(case: Case) -> Against | str:
    """Every term of the equations."""
    terms = {"stiffening": True, "softening": True, "coriolis": True}
    whole = case.with_options(**terms)
    return "All terms are on already." if on(case) == on(whole) else Against("all terms", whole)


def on(case: Case) -> tuple[bool, ...]:
    """Which terms are on."""
    return tuple(case.is_on(name) for name in TERMS)


RULES: dict[str, Callable[[Case], Against | str]] = {
    "the paper's elements": method,
    "Coriolis on / off": coriolis,
    "twice the mass": twice,
    "all terms on": all_terms,
}
CHOICES = (NO_COMPARISON, EARLIER, *RULES)


def against(state: State, case: Case | None = None) -> Against | str:
    """What to compare a case with, that of the state if none is given; words where there is
    nothing ("" where nothing is chosen)."""
    if state.comparison == NO_COMPARISON:
        return ""
    if state.comparison != EARLIER:
        return RULES[state.comparison](case or state.case)
    if state.kept is None:
        return "Nothing is kept yet: press the button below, then change the beam."
    return Against("before", state.kept)


OVERLAID, STACKED = "as a ghost", "side by side"
APART = 0.5  # of the two scenes, in lengths of the beam


class Comparison(Feature):
    """What to compare with, solved and drawn. The scene draws and moves it."""

    def __init__(self, visitor: Visitor):
        super().__init__(visitor)
        self.api = visitor.client.scene
        self.other: Against | str = ""
        self.solver: SolveJob | None = None
        self.clock = Clock()
        self.shapes: Shapes | None = None
        self.ghost: Ghost | None = None
        self.scene: Titled | None = None

    @property
    def answer(self) -> SolverAnswer | None:
        """What came of the other beam, None while there is none."""
        if self.solver is None or isinstance(self.other, str):
            return None
        answer = self.solver.answer
        return answer if answer and answer.request == self.other.case else None

    @property
    def inputs(self) -> tuple:
        """What the picture depends on."""
        state = self.visitor.state
        return state.comparison, state.side_by_side, state.kept, self.answer

    @property
    def levels(self) -> list[float]:
        """Heights of the scene and of the one above it."""
        return [-APART / 2, APART / 2] if self.shapes and self.visitor.state.side_by_side else [0.0]

    def draw(self, main: Shapes, clock: Clock, shown: list[int], scale: float = SCALE) -> None:
        """Draw the other beam beside `main`, the modes `shown` (from 0) of it; a length of the
        beam takes `scale` pixels."""
        state = self.visitor.state
        self.other = against(state)
        if not isinstance(self.other, str):
            self.solver = self.solver or self.visitor.solve_job()
            self.solver.request(self.other.case)
        new, self.shown = self.shown[:2] != self.inputs[:2], self.inputs
        good = self.answer.shapes if self.answer and not self.answer.warning else None
        view = state.view
        self.shapes = None if view.all_modes else good
        if self.shapes is None or isinstance(self.other, str):
            self.hide()
            return
        if new or len(self.clock.phases) != len(self.shapes.modes):
            self.clock.phases = self.partner(main, clock.phases, np.pi / 2)
            self.clock.angle = clock.angle
        own = [self.shapes.labels.index(label) for label in self.common(main, shown)]
        sizes = self.partner(main, amplitudes(view, len(main.modes)), 0.0)
        seen = Seen.of(self.shapes, sizes, view.colouring, scale)
        self.draw_other(view, own, self.other.title, seen)

    def draw_other(self, view: ViewOptions, shown: list[int], title: str, seen: Seen) -> None:
        """In one of the two ways; what is needed for it is built when first needed."""
        assert self.shapes
        self.hide()
        if self.visitor.state.side_by_side:
            if self.scene is None:
                self.scene = Titled(self.api, "/other")
                self.name = add_title(self.api, "/stage", "this beam")
            self.scene.show(self.shapes, view, shown, title, self.levels[1], seen)
            self.name.visible, self.name.position = True, self.scene.title.position
        else:
            self.ghost = self.ghost or Ghost(self.api)
            self.ghost.show(self.shapes, view, shown, title, seen)

    def hide(self) -> None:
        """Draw nothing."""
        if self.ghost:
            self.ghost.hide()
        if self.scene:
            self.scene.hide()
            self.name.visible = False

    def move(self, time: float, main: Shapes, amplitudes: np.ndarray) -> None:
        """Go on by `time` [T*] on the clock of the scene, with the amplitudes (m,) of `main`."""
        shapes = self.shapes
        if shapes is None:
            return
        self.clock.advance(time, shapes.frequencies, shapes.beam.gamma)
        moving = self.scene.scene if self.visitor.state.side_by_side and self.scene else self.ghost
        assert moving
        moving.move(self.clock.phases, self.partner(main, amplitudes, 0.0), self.clock.angle)

    def common(self, main: Shapes, shown: list[int]) -> list[str]:
        """The names of the modes shown that the other beam has too."""
        labels = self.shapes.labels if self.shapes else ()
        return [main.labels[k] for k in shown if main.labels[k] in labels]

    def partner(self, main: Shapes, values: np.ndarray, otherwise: float) -> np.ndarray:
        """Values of the modes of `main` for the modes of the other beam, by their names."""
        known = dict(zip(main.labels, values, strict=False))
        labels = self.shapes.labels if self.shapes else ()
        return np.array([known.get(label, otherwise) for label in labels])


THIS = "this beam"
INVITATION = (
    "A second beam on the same clock: see what one change does. "
    "Or drag the mass in the picture: how it was before stays as a ghost."
)


class CompareTab(Feature):
    """Chooses what to compare with, and shows both beams' frequencies."""

    def __init__(self, visitor: Visitor, comparison: Comparison):
        super().__init__(visitor)
        self.comparison, gui = comparison, visitor.client.gui
        choice = gui.add_dropdown("compare with", CHOICES, hint="The second beam")
        visitor.bind(choice, lambda state: state.comparison, choose)
        layout = gui.add_button_group("drawn", (OVERLAID, STACKED))
        on_press(layout, lambda name: visitor.change(
            lambda state: state.changed("side_by_side", name == STACKED)
        ))  # fmt: skip
        self.table = gui.add_html("")
        keep = gui.add_button("Keep this beam", hint="Then change it: the kept one stays as it was")
        on_press(keep, lambda _: visitor.change(State.keep))

    @property
    def inputs(self) -> tuple:
        """Both answers, and what is compared with."""
        return self.visitor.answer, self.comparison.answer, self.comparison.other

    def show(self) -> None:
        """Tell both beams' frequencies, or why there are none."""
        answer, other, second = self.visitor.answer, self.comparison.other, self.comparison.answer
        if isinstance(other, str):
            self.table.content = note(other or INVITATION)
        elif second and second.solution is None:
            self.table.content = note(f"{other.title}: {second.message}")
        elif second and second.solution and answer and answer.solution:
            pair = [(THIS, answer.solution), (escape(other.title), second.solution)]
            before = self.visitor.state.comparison == EARLIER
            self.table.content = compared(*(pair[::-1] if before else pair))


def choose(state: State, choice: Any) -> State:
    """Compare with something else."""
    return replace(state, comparison=choice) if choice in CHOICES else state


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
