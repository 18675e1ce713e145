"""A second beam beside the one of the scene, on the same clock: as a ghost in it, or above it."""

import math
import threading
from collections.abc import Callable
from dataclasses import replace
from html import escape
from typing import Any, NamedTuple

import numpy as np
from viser import GuiApi, SceneApi

from beamviz.display_units import frequencies
from beamviz.drawing.all_modes import Titled, add_title
from beamviz.drawing.modes import Clock, Shapes, amplitudes
from beamviz.drawing.overlay_beam import Ghost
from beamviz.drawing.subdivision import SCALE, Seen
from beamviz.explorer.jobs import stale
from beamviz.explorer.page.html import SMALL, table
from beamviz.explorer.page.inputs import Listener, heard
from beamviz.explorer.request import SWITCHES, Wanted
from beamviz.explorer.solve_queue import Turns
from beamviz.explorer.solver_job import Answer, Solver
from beamviz.scene import ViewOptions
from beamviz.solver.solution import Solution

NOTHING, BEFORE = "nothing", "how it was before"


class Against(NamedTuple):
    """Another beam to compare with: what it is called, and what to solve for it."""

    title: str
    wanted: Wanted


def method(wanted: Wanted) -> Against:
    """The paper's elements, or the exact solution where these are chosen already."""
    if wanted.options.get("method", "auto") == "ancf":
        return Against("exact", with_options(wanted, method="auto"))
    return Against("paper's ANCF, 20 elements", with_options(wanted, method="ancf"))


def coriolis(wanted: Wanted) -> Against | str:
    """With Coriolis forces, or without where they are on."""
    if wanted.options["plane"] == "flapwise":
        return "Coriolis forces act in the plane of rotation only: choose chordwise under Model."
    on = not wanted.options.get("coriolis", False)
    return Against(f"Coriolis {'on' if on else 'off'}", with_options(wanted, coriolis=on))


def twice(wanted: Wanted) -> Against | str:
    """Twice the mass."""
    if wanted.numbers["alpha"] == 0:
        return "There is no mass to double: give the beam one first."
    double = replace(wanted, numbers={**wanted.numbers, "alpha": 2 * wanted.numbers["alpha"]})
    return Against("twice the mass", double)


def all_terms(wanted: Wanted) -> Against | str:
    """Every term of the equations."""
    terms = {"stiffening": True, "softening": True, "coriolis": True}
    whole = with_options(wanted, **terms)
    return "All terms are on already." if on(wanted) == on(whole) else Against("all terms", whole)


def on(wanted: Wanted) -> tuple[bool, ...]:
    """Which terms are on."""
    return tuple(wanted.switched_on(name) for name in SWITCHES)


def with_options(wanted: Wanted, **options: object) -> Wanted:
    """The same beam by other keywords of `solve`."""
    return replace(wanted, options={**wanted.options, **options})


RULES: dict[str, Callable[[Wanted], Against | str]] = {
    "the paper's elements": method,
    "Coriolis on / off": coriolis,
    "twice the mass": twice,
    "all terms on": all_terms,
}
CHOICES = (NOTHING, BEFORE, *RULES)


def against(choice: str, wanted: Wanted, kept: Wanted | None) -> Against | str:
    """What to compare a beam with; words where there is nothing ("" where nothing is chosen)."""
    if choice == NOTHING:
        return ""
    if choice != BEFORE:
        return RULES[choice](wanted)
    if kept is None:
        return "Nothing is kept yet: press the button below, then change the beam."
    return Against("before", kept)


OVERLAID, STACKED = "as a ghost", "side by side"
APART = 0.5  # of the two scenes, in lengths of the beam


class Comparison:
    """What to compare with, solved and drawn. Callbacks choose; the animator draws and moves."""

    def __init__(self, api: SceneApi, turns: Turns, wake: Callable[[], None]):
        self.api, self.turns, self.wake = api, turns, wake
        self.choice, self.stacked = NOTHING, False
        self.kept: Wanted | None = None
        self.other: Against | str = ""
        self.solver: Solver | None = None
        self.drawn: tuple = ()
        self.clock = Clock()
        self.shapes: Shapes | None = None
        self.ghost: Ghost | None = None
        self.scene: Titled | None = None

    # What the visitor chooses, from any thread.

    def choose(self, choice: Any) -> None:
        """Compare with something else."""
        if choice in CHOICES:
            self.choice = choice
            self.wake()

    def stack(self, layout: Any) -> None:
        """Side by side, or as a ghost."""
        self.stacked = layout == STACKED
        self.wake()

    def keep(self, wanted: Wanted) -> None:
        """Keep a beam as it is now, to see what comes of a change."""
        self.kept, self.choice = wanted, BEFORE
        self.wake()

    def forget(self) -> None:
        """Another scene begins: how the last one was is of no use."""
        self.kept = None
        if self.choice == BEFORE:
            self.choose(NOTHING)

    # What the animator does.

    @property
    def answer(self) -> Answer | None:
        """What came of the other beam, None while there is none."""
        if self.solver is None or isinstance(self.other, str):
            return None
        answer = self.solver.answer
        return answer if answer and answer.wanted == self.other.wanted else None

    @property
    def second(self) -> Wanted | None:
        """What is compared with, None where nothing is."""
        return None if isinstance(self.other, str) else self.other.wanted

    @property
    def state(self) -> tuple:
        """What the picture depends on."""
        return self.choice, self.stacked, self.kept, self.answer

    @property
    def fresh(self) -> bool:
        """Whether something waits to be drawn."""
        return stale(self.drawn, self.state)

    @property
    def levels(self) -> list[float]:
        """Heights of the scene and of the one above it."""
        return [-APART / 2, APART / 2] if self.shapes and self.stacked else [0.0]

    def follow(self, wanted: Wanted) -> None:
        """Solve what the wanted beam is to be compared with."""
        self.other = against(self.choice, wanted, self.kept)
        if isinstance(self.other, str):
            return
        if self.solver is None:
            self.solver = Solver(self.turns, self.other.wanted, self.wake)
        elif self.solver.wanted != self.other.wanted:
            self.solver.want(self.other.wanted)

    def show(
        self, main: Shapes, clock: Clock, view: ViewOptions, shown: list[int], scale: float = SCALE
    ) -> None:
        """Draw the other beam beside `main`, the modes `shown` (from 0) of it; a length of the
        beam takes `scale` pixels."""
        new = self.drawn[:2] != self.state[:2]
        self.drawn, answer = self.state, self.answer
        good = answer.shapes if answer and not answer.words else None
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
        self.draw(view, own, self.other.title, seen)

    def draw(self, view: ViewOptions, shown: list[int], title: str, seen: Seen) -> None:
        """In one of the two ways; what is needed for it is built when first needed."""
        assert self.shapes
        self.hide()
        if self.stacked:
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
        moving = self.scene.scene if self.stacked and self.scene else self.ghost
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

    def close(self) -> None:
        """Nothing more is solved."""
        if self.solver:
            self.solver.close()


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
