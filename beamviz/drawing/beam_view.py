"""The scene itself: hub, beam, mass, ghosts, nodes, ground and light, in any viser scene."""

import numpy as np
from viser import BatchedMeshHandle, SceneApi

from beamviz.drawing import beam_mesh as tube
from beamviz.drawing import camera, colours, sizes
from beamviz.drawing import subdivision as pieces
from beamviz.drawing.instances import HIDDEN, add_bodies, ball, box, put, sleeve
from beamviz.drawing.modes import Shapes, amplitudes, displacement
from beamviz.drawing.objects import Ghosts, Ground, Hub, Nodes, light, placed, turned
from beamviz.drawing.subdivision import Seen, cut
from beamviz.scene import ViewOptions
from beamviz.server.viser_private import set_orientation, set_position, set_properties


class BeamView:
    """Draws one beam: `show` takes what changes with the beam, `move` what changes with time.

    root: where its nodes hang; alone: with light, ground and post, which a second scene beside it
    has no need of; height: where its middle is put.
    """

    def __init__(self, api: SceneApi, root: str = "/stage", *, alone: bool = True):
        if alone:
            light(api)
        self.alone, self.height = alone, 0.0
        self.stage = api.add_frame(root, show_axes=False)
        self.ground = Ground(api, root)
        self.wheel = api.add_frame(f"{root}/wheel", show_axes=False)
        self.hub = Hub(api, root)
        api.add_frame(f"{root}/wheel/beam", show_axes=False)
        self.beams = {
            count: add_bodies(
                api, f"{root}/wheel/beam/{count}", count, sleeve(), receive_shadow=False
            )
            for count in pieces.COUNTS  # a node keeps its count: the browser breaks it otherwise
        }
        self.count = 0  # of the pieces that are seen
        self.ends = add_bodies(api, f"{root}/wheel/ends", 2, box(), receive_shadow=False)
        self.mass = add_bodies(
            api, f"{root}/wheel/mass", 1, ball(), flat_shading=False, receive_shadow=False
        )
        self.ball: tuple = ()  # how the mass was drawn
        self.ghosts = Ghosts(api, root)
        self.nodes = Nodes(api, root)
        self.words = api.add_label(
            f"{root}/wheel/words", "", anchor="bottom-center", font_screen_scale=1.25, visible=False
        )

    def show(
        self,
        shapes: Shapes,
        view: ViewOptions,
        shown: list[int],
        *,
        words: str = "",
        seen: Seen | None = None,
    ) -> None:
        """Draw a beam and the nodes of its modes `shown`; `words` grey it and say why; it is cut
        for what is `seen` of it, if that is not what the view options say."""
        seen = seen or Seen.of(shapes, amplitudes(view, len(shapes.modes)), view.colouring)
        shapes = cut(shapes, seen, self.count)
        self.shapes, self.view, self.greyed = shapes, view, bool(words)
        beam = shapes.beam
        self.section = sizes.section(beam, view.thicken)
        middle = [0.0, 0.0, self.height] - camera.target(shapes, view.rotating_frame)
        set_position(self.stage, middle)
        self.ground.show(beam, rotating_frame=view.rotating_frame)
        self.hub.show(beam)
        self.ground.grid.visible = self.alone
        self.hub.post.visible = self.alone and beam.delta >= 0
        self.ghosts.show(shapes, self.section, visible=view.ghosts)
        self.nodes.show(
            shapes,
            self.section,
            shown if view.nodes and len(shown) == 1 and not words else [],
            labels=not view.all_modes,
            scale=seen.scale,
        )
        radius = sizes.mass_radius(beam, view.thicken) if beam.alpha > 0 else HIDDEN
        if (radius, self.greyed) != self.ball:
            self.ball = radius, self.greyed
            self.mass.batched_scales = np.full((1, 3), radius)
            self.mass.batched_colors = colours.instanced(
                np.array([colours.GREYED if words else colours.MASS]) / 255
            )
        self.words.visible = bool(words)
        if words:
            self.words.text = words
            set_position(self.words, (beam.delta + 0.5, 0.0, 0.12))

    def move(self, phases: np.ndarray, amplitudes: np.ndarray, angle: float) -> None:
        """Put the beam where it is at phases (m,) [rad] for amplitudes (m,), the hub turned by
        angle [rad]; seen from the hub, it is the ground that turns."""
        moved = displacement(self.shapes, phases, amplitudes)
        largest = colours.colour_range(self.shapes, self.view.colouring, amplitudes)
        self.displace(moved, largest, angle)

    def displace(self, moved: np.ndarray, largest: float, angle: float) -> None:
        """Put the beam where it is displaced by `moved` (n, 2), in colours up to `largest`."""
        shapes = self.shapes
        points, normal = placed(shapes, shapes.centreline + moved)
        body = tube.segments(points, normal, *self.section)
        paint = self.paint(moved, largest)
        self.clear(len(paint))
        put(self.beam, *body, paint)
        put(self.ends, *(part[:: len(paint) - 1] for part in (*body, paint)))  # sleeves are open
        self.nodes.move(points, body[1])
        place = points[shapes.mass : shapes.mass + 1].astype(np.float32)
        set_properties(self.mass, {"batched_positions": place})
        set_orientation(self.ground.grid, turned(-angle if self.view.rotating_frame else 0.0))
        set_orientation(self.wheel, turned(0.0 if self.view.rotating_frame else angle))

    @property
    def beam(self) -> BatchedMeshHandle:
        """The node of the pieces that are seen."""
        return self.beams[self.count]

    def clear(self, count: int) -> None:
        """Go on with another count of pieces: those of the last one vanish in the same frame."""
        if self.count and self.count != count:
            gone = np.full((self.count, 3), HIDDEN, np.float32)
            set_properties(self.beam, {"batched_scales": gone})
        self.count = count

    def paint(self, moved: np.ndarray, largest: float) -> np.ndarray:
        """Colour (n - 1, 3), bytes of linear light, of each piece displaced by `moved` (n, 2)."""
        if self.greyed:
            grey = np.array([colours.GREYED]) / 255
            return colours.instanced(np.tile(grey, (len(moved) - 1, 1)))
        return colours.painted(self.shapes, self.view.colouring, moved, largest)
