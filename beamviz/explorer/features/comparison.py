"""A second beam beside the one of the scene, on the same clock: as a ghost in it, or above it."""

from collections.abc import Callable
from typing import Any

import numpy as np
from viser import SceneApi

from beamviz.drawing.all_modes import Titled, add_title
from beamviz.drawing.modes import Clock, Shapes, amplitudes
from beamviz.drawing.overlay_beam import Ghost
from beamviz.drawing.subdivision import SCALE, Seen
from beamviz.explorer.features.comparison_cases import BEFORE, CHOICES, NOTHING, Against, against
from beamviz.explorer.jobs import stale
from beamviz.explorer.request import Wanted
from beamviz.explorer.solve_queue import Turns
from beamviz.explorer.solver_job import Answer, Solver
from beamviz.view_options import Look

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
        self, main: Shapes, clock: Clock, look: Look, shown: list[int], scale: float = SCALE
    ) -> None:
        """Draw the other beam beside `main`, the modes `shown` (from 0) of it; a length of the
        beam takes `scale` pixels."""
        new = self.drawn[:2] != self.state[:2]
        self.drawn, answer = self.state, self.answer
        good = answer.shapes if answer and not answer.words else None
        self.shapes = None if look.together else good
        if self.shapes is None or isinstance(self.other, str):
            self.hide()
            return
        if new or len(self.clock.phases) != len(self.shapes.modes):
            self.clock.phases = self.partner(main, clock.phases, np.pi / 2)
            self.clock.angle = clock.angle
        own = [self.shapes.labels.index(label) for label in self.common(main, shown)]
        sizes = self.partner(main, amplitudes(look, len(main.modes)), 0.0)
        seen = Seen.of(self.shapes, sizes, look.colouring, scale)
        self.draw(look, own, self.other.title, seen)

    def draw(self, look: Look, shown: list[int], title: str, seen: Seen) -> None:
        """In one of the two ways; what is needed for it is built when first needed."""
        assert self.shapes
        self.hide()
        if self.stacked:
            if self.scene is None:
                self.scene = Titled(self.api, "/other")
                self.name = add_title(self.api, "/stage", "this beam")
            self.scene.show(self.shapes, look, shown, title, self.levels[1], seen)
            self.name.visible, self.name.position = True, self.scene.title.position
        else:
            self.ghost = self.ghost or Ghost(self.api)
            self.ghost.show(self.shapes, look, shown, title, seen)

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
