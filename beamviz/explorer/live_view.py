"""What one visitor sees of a beam: drawn anew with every answer, and moved on as time goes on."""

import numpy as np
from viser import CameraHandle, SceneApi

from beamviz.drawing import colours
from beamviz.drawing.all_modes import Multiples, heights
from beamviz.drawing.beam_view import BeamView
from beamviz.drawing.modes import Clock, Shapes, amplitudes
from beamviz.drawing.subdivision import SCALE, Seen, between
from beamviz.explorer.features.comparison import Comparison
from beamviz.explorer.features.run_up import Ride
from beamviz.explorer.solver_job import Answer
from beamviz.explorer.visitor_camera import Viewing
from beamviz.scene import Scene, ViewOptions

ZOOMED = 1.25  # times larger or smaller: worth other pieces


class LivePicture:
    """The scene, or all modes in its place, with the beam compared with, on one clock: `show`
    takes up what is new, `move` lets time pass. answer, view: what was taken up last."""

    def __init__(
        self,
        api: SceneApi,
        camera: CameraHandle,
        first: Scene,
        comparison: Comparison,
        ride: Ride,
    ):
        self.comparison, self.ride, self.view = comparison, ride, first.view
        self.viewing = Viewing(camera, first.camera)
        self.scene, self.multiples = BeamView(api), Multiples(api)
        self.answer: Answer | None = None
        self.shapes = Shapes.at_rest(first.beam, first.options["plane"])
        self.clock = Clock()
        self.scale = SCALE  # that the picture was drawn for

    # What is drawn.

    def show(
        self, answer: Answer | None, view: ViewOptions, *, repace: bool, settled: bool
    ) -> None:
        """Draw an answer; repace: choose the pace anew; settled: it is the one to what is wanted,
        so that the camera need not move again."""
        self.answer, self.view = answer, view
        if answer and answer.shapes and not self.words:
            self.shapes = answer.shapes
        if self.ride.shown and answer and answer.solution:
            self.ride.drive(answer.solution, self.shapes, view.amplitude)
        self.clock.fit(self.swinging, self.shapes.beam.gamma, keep=not repace)
        self.scale = self.viewing.scale
        self.show_second()
        self.scene.show(self.shapes, view, self.shown, words=self.words, seen=self.sight)
        self.show_multiples()
        levels = heights(self.multiples.count) or self.comparison.levels
        self.viewing.look_at(self.shapes, view.rotating_frame, levels, settled=settled)

    def show_second(self) -> None:
        """The beam compared with."""
        if self.answer:
            self.comparison.follow(self.answer.wanted)
        self.comparison.show(self.shapes, self.clock, self.view, self.shown, self.scale)
        self.scene.height = self.comparison.levels[0]

    def show_multiples(self) -> None:
        """All modes in place of the one scene, where that is wanted."""
        together = self.view.all_modes and len(self.shapes.modes) > 0 and not self.words
        self.scene.stage.visible = not together
        if together:
            self.multiples.show(self.shapes, self.view, self.scale)
        else:
            self.multiples.hide()

    # What moves.

    def advance(self, time: float) -> None:
        """Let `time` [T*] pass on the clock."""
        self.clock.advance(time, self.shapes.frequencies, self.shapes.beam.gamma)

    def move(self, time: float) -> None:
        """Move all to where the clock is, `time` [T*] later than before."""
        if self.ride.driven:
            moved = self.ride.displaced(time, self.shapes.beam.gamma)
            moved = between(self.shapes.x, moved, self.scene.shapes.x)
            self.scene.displace(moved, self.largest, self.clock.angle)
        else:
            self.scene.move(self.clock.phases, self.amplitudes, self.clock.angle)
        self.comparison.move(time, self.shapes, self.amplitudes)
        self.multiples.move(self.clock.phases, self.view.amplitude, self.clock.angle)

    # What is to be seen in it.

    @property
    def words(self) -> str:
        """What is wrong with what is wanted, or ""."""
        return self.answer.words if self.answer else ""

    @property
    def zoomed(self) -> bool:
        """Whether the camera came so much nearer, or went, that the beam is to be cut anew."""
        return not 1 / ZOOMED < self.viewing.scale / self.scale < ZOOMED

    @property
    def pace(self) -> float:
        """Time [T*] that passes in one second."""
        return self.clock.rate * self.view.pace

    @property
    def shown(self) -> list[int]:
        """The modes (from 0) in the picture."""
        if self.ride.driven:
            return []
        if self.view.all_modes:
            return list(range(len(self.shapes.modes)))
        return [k for k in range(len(self.shapes.modes)) if self.amplitudes[k] > 0]

    @property
    def swinging(self) -> np.ndarray:
        """The frequencies in the picture."""
        if self.ride.driven:
            return np.array([self.ride.per_rev * self.shapes.beam.gamma])
        return self.shapes.frequencies[self.shown]

    @property
    def largest(self) -> float:
        """The value at the end of the colour map."""
        colouring = self.view.colouring
        if self.ride.driven:
            return self.ride.largest(self.shapes, colouring, self.view.amplitude)
        return colours.colour_range(self.shapes, colouring, self.amplitudes)

    @property
    def sight(self) -> Seen:
        """What the picture shows of the beam."""
        if self.ride.driven:
            return Seen(self.ride.field[None], self.scale, self.view.colouring, self.largest)
        return Seen.of(self.shapes, self.amplitudes, self.view.colouring, self.scale)

    @property
    def amplitudes(self) -> np.ndarray:
        """Amplitude (m,) of every mode; none while the beam is driven."""
        modes = len(self.shapes.modes)
        return np.zeros(modes) if self.ride.driven else amplitudes(self.view, modes)
