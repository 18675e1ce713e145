"""The path of the tip: the curve that the free end runs through, in the frame of the hub.

Of one mode it is a line, and with Coriolis forces an ellipse. Several modes have no common period:
of them it is the part that the tip has run through last. `exports/offline.js` repeats this.
"""

import math

import numpy as np
from numpy.typing import NDArray

from beamviz.drawing import colours
from beamviz.drawing.beam_mesh import DrawnBeam, to_hub_frame
from beamviz.drawing.modes import AT_REST, SampledModes
from beamviz.drawing.scene_graph import DrawnScene

# Of several modes: periods of the slowest, at most so many of the fastest; points of each of these.
PERIODS, MOST, SAMPLES = 4, 24, 32
THICKNESS = 2.0  # [pixels]


class TipPath:
    """The path of the tip of a beam, a line in a scene, in the colour of texts; overlay: in that of
    a beam over another."""

    def __init__(self, scene: DrawnScene, root: str, *, overlay: bool):
        self.scene, self.points, self.is_shown = scene, np.zeros((0, 3)), False
        self.colours = [colours.BEFORE] * 2 if overlay else colours.LETTERS  # light and dark
        self.colour = self.colours[0]
        name, ends = f"{root}/rotor/tip_path", np.zeros((1, 2, 3))
        self.line = scene.add_line_segments(
            name, ends, self.colour, thickness=THICKNESS, thickness_units="screen", visible=False
        )

    def show(self, drawn: DrawnBeam) -> None:
        """Show the path of a beam if its view has one and the tip moves; `move` follows."""
        self.drawn, given = drawn, drawn.shapes.tip_path
        self.is_shown = self.line.visible = has_path(drawn)
        colour = self.colours[drawn.view.dark]
        if colour != self.colour:
            self.colour = colour
            self.scene.set_properties(self.line, colors=np.array(colour, np.uint8))
        if self.is_shown and given is not None:
            self.draw(to_hub_frame(drawn.shapes, given)[0])

    def move(self, phases: NDArray) -> None:
        """Let the path end at phases (m,) [rad] of the modes."""
        if self.is_shown and self.drawn.shapes.tip_path is None:
            drawn = self.drawn
            self.draw(tip_points(drawn.shapes, passed(drawn, phases), drawn.amplitudes))

    def draw(self, points: NDArray) -> None:
        """Draw the line through points (n, 3), which those of a single mode leave as they are."""
        if not np.array_equal(points, self.points):
            self.points = points
            self.scene.set_properties(self.line, points=np.stack([points[:-1], points[1:]], 1))


def has_path(drawn: DrawnBeam) -> bool:
    """Whether the path of a beam is shown: its view has one, and the tip moves."""
    moves = drawn.shapes.tip_path is not None or len(times_passed(rates(drawn)[drawn.shown])) > 0
    return drawn.view.tip_path and not drawn.warning and moves


def tip_points(shapes: SampledModes, phases: NDArray, amplitudes: NDArray) -> NDArray:
    """The tip (n, 3) in the frame of the hub at phases (n, m) [rad] of modes of amplitudes (m,)."""
    moved = ((amplitudes * np.exp(1j * phases)) @ shapes.modes[:, -1]).imag
    points, _ = to_hub_frame(shapes, shapes.centreline[-1] + moved)
    return points


def rates(drawn: DrawnBeam) -> NDArray:
    """The rates (m,) of the phases of its modes, 0 of those that do not vibrate."""
    return np.nan_to_num(drawn.shapes.frequencies if drawn.rates is None else drawn.rates)


def passed(drawn: DrawnBeam, phases: NDArray) -> NDArray:
    """The phases (n, m) on the path that ends at phases (m,); all of that of a single mode."""
    if len(drawn.shown) == 1:
        phases = phases - phases.real  # the same at each moment, but for its growth
    all_rates = rates(drawn)[: len(phases)]
    return phases + np.outer(times_passed(all_rates[drawn.shown]), all_rates)


def times_passed(rates: NDArray) -> NDArray:
    """The times (n,) up to 0 of the path in modes of some rates; none where nothing moves."""
    moving = rates[rates > AT_REST]
    if not len(moving):
        return np.zeros(0)
    slowest, fastest = 2 * math.pi / moving.min(), 2 * math.pi / moving.max()
    span = min(PERIODS * slowest, MOST * fastest) if len(moving) > 1 else slowest
    return np.linspace(-span, 0.0, math.ceil(SAMPLES * span / fastest - 1e-9) + 1)
