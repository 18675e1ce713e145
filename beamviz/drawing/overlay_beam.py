"""A pale second beam in the same place: how it was before, or how another model sees it."""

from dataclasses import replace
from typing import Any

import numpy as np
from viser import SceneApi

from beamviz.drawing import beam_mesh as tube
from beamviz.drawing import colours, sizes
from beamviz.drawing.modes import Shapes, displacement
from beamviz.drawing.objects import BOX, SIDES, Nodes, placed, reshape
from beamviz.drawing.subdivision import Seen, cut
from beamviz.scene import ViewOptions
from beamviz.server.viser_private import set_position

OPACITY = 0.3
ROOT = "/stage/wheel/ghost"
INSIDE = 0.95  # of its size: not in the same faces as the beam of the scene
ABOVE = np.array([0.0, 0.0, 0.1])


class Ghost:
    """Draws a beam, its mass and its nodes pale and see-through, in the frame of the hub."""

    def __init__(self, api: SceneApi):
        self.root = api.add_frame(ROOT, show_axes=False)
        pale: Any = {"opacity": OPACITY, "cast_shadow": False, "receive_shadow": False}
        self.body = api.add_mesh_simple(
            f"{ROOT}/beam", BOX, SIDES, color=colours.BEFORE, flat_shading=True, **pale
        )
        self.mass = api.add_icosphere(f"{ROOT}/mass", 1.0, color=colours.BEFORE, **pale)
        self.nodes = Nodes(api, ROOT, colours.BEFORE)
        self.title = api.add_label(f"{ROOT}/title", "", anchor="bottom-center")
        self.count = 0  # of its pieces

    def show(
        self, shapes: Shapes, view: ViewOptions, shown: list[int], title: str, seen: Seen
    ) -> None:
        """Draw a beam and the nodes of its modes `shown` (from 0), cut for what is `seen`."""
        shapes = cut(shapes, replace(seen, largest=np.inf), self.count)
        self.count = len(shapes.strain)
        thickness, breadth = sizes.section(shapes.beam, view.thicken)
        self.shapes, self.section = shapes, (INSIDE * thickness, INSIDE * breadth)
        self.root.visible = True
        self.mass.visible = shapes.beam.alpha > 0
        self.mass.radius = INSIDE * sizes.mass_radius(shapes.beam, view.thicken)
        self.nodes.show(shapes, self.section, shown if view.nodes else [], labels=False)
        self.title.text = title
        points, _ = placed(shapes, shapes.centreline)
        top = points[shapes.mass if shapes.beam.alpha > 0 else -1] + ABOVE
        set_position(self.title, top + [0.0, 0.0, self.mass.radius])

    def hide(self) -> None:
        """Draw nothing."""
        self.root.visible = False

    def move(self, phases: np.ndarray, amplitudes: np.ndarray, angle: float) -> None:
        """Put the beam where it is at phases (m,) [rad] for amplitudes (m,)."""
        shapes = self.shapes
        moved = displacement(shapes, phases, amplitudes)
        points, normal = placed(shapes, shapes.centreline + moved)
        reshape(self.body, *tube.swept(points, normal, *self.section))
        self.nodes.move(points, tube.segments(points, normal, *self.section)[1])
        set_position(self.mass, points[shapes.mass])
