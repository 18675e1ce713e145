"""All modes at once as small multiples: one above the other, on one clock (paper, figs. 14-15)."""

import numpy as np
from viser import LabelHandle, SceneApi

from beamviz.display_units import frequencies
from beamviz.drawing.beam_view import BeamView
from beamviz.drawing.modes import Shapes
from beamviz.drawing.subdivision import SCALE, Seen
from beamviz.scene import ViewOptions

SPACING = 0.42  # of two beams above each other, in lengths of the beam
ABOVE = 0.14  # of the hub: its title


def heights(count: int) -> list[float]:
    """Heights of so many scenes around the middle of the picture, the first on top."""
    return [SPACING * ((count - 1) / 2 - k) for k in range(count)]


def add_title(api: SceneApi, root: str, text: str) -> LabelHandle:
    """A title for the scene under `root`, over its hub: from whatever side, not over its beam."""
    return api.add_label(f"{root}/title", text, anchor="bottom-center", font_screen_scale=1.1)


class Titled:
    """A scene above or below others, with a title."""

    def __init__(self, api: SceneApi, root: str):
        self.scene = BeamView(api, root, alone=False)
        self.title = add_title(api, root, "")

    def show(
        self,
        shapes: Shapes,
        view: ViewOptions,
        shown: list[int],
        title: str,
        height: float,
        seen: Seen,
    ) -> None:
        """Draw a beam at a height, cut for what is `seen` of it."""
        self.scene.height = height
        self.scene.show(shapes, view, shown, seen=seen)
        self.scene.stage.visible = True
        self.title.text = title
        self.title.position = (shapes.beam.delta if view.rotating_frame else 0.0, 0.0, ABOVE)

    def hide(self) -> None:
        """Draw nothing."""
        self.scene.stage.visible = False


class Multiples:
    """A scene for each mode; they are built when they are first asked for."""

    def __init__(self, api: SceneApi):
        self.api = api
        self.scenes: list[Titled] = []
        self.count = 0  # of the scenes shown

    def show(self, shapes: Shapes, view: ViewOptions, scale: float = SCALE) -> None:
        """One scene for each mode; a length of the beam takes `scale` pixels."""
        self.count = len(shapes.modes)
        while len(self.scenes) < self.count:
            self.scenes.append(Titled(self.api, f"/mode {len(self.scenes) + 1}"))
        for k, own in enumerate(view.amplitude * np.eye(self.count)):
            seen = Seen.of(shapes, own, view.colouring, scale)
            height = heights(self.count)[k]
            self.scenes[k].show(shapes, view, [k], title(shapes, k), height, seen)
        for scene in self.scenes[self.count :]:
            scene.hide()

    def hide(self) -> None:
        """Show none of them."""
        if self.count:
            self.count = 0
            for scene in self.scenes:
                scene.hide()

    def move(self, phases: np.ndarray, amplitude: float, angle: float) -> None:
        """Put every beam where it is at phases (m,) [rad] of its mode."""
        for k, own in enumerate(amplitude * np.eye(self.count)):
            self.scenes[k].scene.move(phases, own, angle)


def title(shapes: Shapes, k: int) -> str:
    """The name of a mode with its frequency."""
    across = frequencies(shapes.beam.units)
    return f"{shapes.labels[k]}   {across.text(shapes.frequencies[k], 5)}"
