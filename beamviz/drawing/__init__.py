"""The beam in a viser scene: alone, with a second beam overlaid, or with each mode in a row."""

from dataclasses import replace
from typing import Any

import numpy as np
import trimesh
from viser import BatchedMeshHandle, SceneApi

from beamviz.drawing import beam_mesh, camera, colours
from beamviz.drawing.beam_mesh import DrawnMotion, subdivide, to_hub_frame
from beamviz.drawing.modes import SampledModes, displacement
from beamviz.drawing.objects import (
    BOX,
    HIDDEN,
    SIDES,
    Caption,
    Nodes,
    ReferenceShapes,
    add_instances,
    add_mesh,
    collar,
    mass_size,
    section_size,
    set_surface,
)
from beamviz.drawing.surroundings import Surroundings, add_lights, axis_rotation
from beamviz.drawing.text import frequencies
from beamviz.scene import ViewOptions
from beamviz.server.viser_private import set_orientation, set_position, set_properties

INSET = 0.95  # relative size of an overlaid beam, so that no faces coincide
TITLE_OFFSET = np.array([0.0, 0.0, 0.1])  # of an overlaid beam, from its mass or tip
ROW_SPACING = 0.42  # [beam lengths] between rows
TITLE_PLACE = np.array([-0.12, 0.0, 0.12])  # of a title, from the clamp
OVERLAY = "/scene/rotor/overlay"


class BeamView:
    """One beam in a scene: `show` draws another beam or view, `move` another moment.

    root: name of its node; alone: the only beam of the scene, with lights, floor and post; height:
    [beam lengths] of its middle; fixed: `frame` keeps its position when the shape of the beam
    changes, as during a drag of the mass.
    """

    def __init__(self, api: SceneApi, root: str = "/scene", *, alone: bool = True):
        self.height, self.fixed = 0.0, False
        self.frame = api.add_frame(root, show_axes=False)
        self.rotor = api.add_frame(f"{root}/rotor", show_axes=False)
        self.surroundings = Surroundings(api, root, alone=alone)
        api.add_frame(f"{root}/rotor/beam", show_axes=False)
        box = trimesh.creation.box()
        tube = trimesh.creation.box()  # without ends, which would stick out at a bend
        tube.update_faces(np.abs(tube.face_normals[:, 0]) < 0.5)
        self.beams = {
            count: add_instances(api, f"{root}/rotor/beam/{count}", count, tube)
            for count in beam_mesh.PIECE_COUNTS  # one node each: the page cannot change a count
        }
        self.count = 0  # of the pieces drawn
        self.ends = add_instances(api, f"{root}/rotor/ends", 2, box)
        self.mass = add_instances(api, f"{root}/rotor/mass", 1, collar())
        self.mass_drawn: tuple = ()  # size and colour
        self.reference = ReferenceShapes(api, root)
        self.nodes = Nodes(api, root)
        self.warning = Caption(api, f"{root}/rotor/warning", "bottom")
        self.title = Caption(api, f"{root}/title", "bottom")

    def show(
        self,
        shapes: SampledModes,
        view: ViewOptions,
        motion: DrawnMotion | None = None,
        *,
        warning: str = "",
        title: str = "",
    ) -> None:
        """Draw a beam and the nodes of the mode that it moves in, with a warning above it in grey.
        motion: by default that of `view`."""
        self.motion = motion or DrawnMotion.of(shapes, view)
        self.shapes = shapes = subdivide(shapes, self.motion, self.count)
        self.greyed = bool(warning)
        beam = shapes.beam
        self.section = section_size(beam, view.thicken)
        self.choose_frame(float(view.rotating_frame))
        self.surroundings.show(beam, rotating_frame=view.rotating_frame, dark=view.dark)
        self.reference.show(shapes, self.section, visible=view.ghosts)
        shown = self.motion.shown
        marked = shown if view.nodes and len(shown) == 1 and not warning else []
        self.nodes.show(shapes, self.section, marked, labels=not view.all_modes)
        size = mass_size(beam, view.thicken) if beam.alpha > 0 else (HIDDEN, HIDDEN)
        if (size, self.greyed) != self.mass_drawn:
            self.mass_drawn = size, self.greyed
            self.mass.batched_scales = np.array([[size[0], size[1], size[1]]])
            colour = colours.GREYED if warning else colours.MASS
            self.mass.batched_colors = colours.instanced([colour])
        self.warning.show(warning, (beam.delta + 0.5, 0.0, 0.12))
        clamp = np.array([beam.delta if view.rotating_frame else 0.0, 0.0, 0.0])
        self.title.show(title, clamp + TITLE_PLACE)
        self.frame.visible = True

    @property
    def captions(self) -> list[Caption]:
        """The texts that the page writes over the scene."""
        texts = [*self.nodes.captions, self.warning, self.title, self.surroundings.speed]
        return [caption for caption in texts if caption.text and self.frame.visible]

    def hide(self) -> None:
        self.frame.visible = False

    def choose_frame(self, share: float) -> None:
        """Choose the frame; share: 0 stationary, 1 rotating with the hub, or in between."""
        self.share = share
        if not self.fixed:
            middle = share * camera.target(self.shapes, rotating_frame=True)  # else the axis
            set_position(self.frame, [0.0, 0.0, self.height] - middle)

    def move(self, phases: np.ndarray, angle: float) -> None:
        """Draw the beam at phases (m,) [rad] of its modes, the hub rotated by angle [rad]; in the
        rotating frame the ground rotates instead."""
        self.displace(displacement(self.shapes, phases, self.motion.amplitudes), angle)

    def displace(self, moved: np.ndarray, angle: float) -> None:
        """Draw the beam displaced by `moved` (n, 2)."""
        shapes = self.shapes
        points, normal = to_hub_frame(shapes, shapes.centreline + moved)
        centres, wxyz, sizes = beam_mesh.segments(points, normal, self.section)
        if self.greyed:
            paint = colours.instanced(np.tile(colours.GREYED, (len(points) - 1, 1)))
        else:
            paint = colours.painted(shapes, self.motion.colouring, moved, self.motion.largest)
        if self.count not in (0, len(paint)):  # hide the last pieces in the same frame
            set_properties(self.beam, batched_scales=np.full((self.count, 3), HIDDEN))
        self.count = len(paint)
        placed = {"batched_positions": centres, "batched_wxyzs": wxyz, "batched_scales": sizes}
        placed["batched_colors"] = paint
        set_properties(self.beam, **placed)
        ends = {name: values[[0, -1]] for name, values in placed.items()}  # caps: pieces are open
        set_properties(self.ends, **ends)
        self.nodes.move(points, wxyz)
        along = wxyz[[min(shapes.mass, len(paint) - 1)]]
        set_properties(self.mass, batched_positions=points[[shapes.mass]], batched_wxyzs=along)
        self.surroundings.rotate(angle, self.share)
        set_orientation(self.rotor, axis_rotation((1 - self.share) * angle))

    @property
    def beam(self) -> BatchedMeshHandle:
        return self.beams[self.count]


class OverlayBeam:
    """A second beam with its mass and nodes, translucent, in the hub's frame of the first."""

    def __init__(self, api: SceneApi):
        self.root = api.add_frame(OVERLAY, show_axes=False)
        pale: Any = {"color": colours.BEFORE, "opacity": 0.3}
        self.body = add_mesh(api, f"{OVERLAY}/beam", BOX, SIDES, **pale)
        ring = collar()
        self.mass = add_mesh(api, f"{OVERLAY}/mass", ring.vertices, ring.faces, **pale)
        self.nodes = Nodes(api, OVERLAY, colours.BEFORE)
        self.title = Caption(api, f"{OVERLAY}/title", "bottom")
        self.count = 0  # of the pieces drawn

    def show(
        self,
        shapes: SampledModes,
        view: ViewOptions,
        motion: DrawnMotion,
        title: str,
    ) -> None:
        """Draw a beam and the nodes of the modes that it moves in."""
        shapes = subdivide(shapes, replace(motion, largest=np.inf), self.count)
        self.count = len(shapes.strain)
        thickness, breadth = section_size(shapes.beam, view.thicken)
        self.shapes, self.section = shapes, (INSET * thickness, INSET * breadth)
        self.amplitudes = motion.amplitudes
        self.root.visible = True
        self.mass.visible = shapes.beam.alpha > 0
        length, radius = mass_size(shapes.beam, view.thicken)
        self.mass.scale = (INSET * length, INSET * radius, INSET * radius)
        self.nodes.show(shapes, self.section, motion.shown if view.nodes else [], labels=False)
        points, _ = to_hub_frame(shapes, shapes.centreline)
        top = points[shapes.mass if shapes.beam.alpha > 0 else -1] + TITLE_OFFSET
        self.title.show(title, top + [0.0, 0.0, radius])

    @property
    def captions(self) -> list[Caption]:
        return [self.title] if self.root.visible else []

    def hide(self) -> None:
        self.root.visible = False

    def move(self, phases: np.ndarray, angle: float) -> None:
        shapes = self.shapes
        moved = displacement(shapes, phases, self.amplitudes)
        points, normal = to_hub_frame(shapes, shapes.centreline + moved)
        set_surface(self.body, *beam_mesh.swept(points, normal, self.section))
        wxyz = beam_mesh.segments(points, normal, self.section)[1]
        self.nodes.move(points, wxyz)
        set_position(self.mass, points[shapes.mass])
        set_orientation(self.mass, wxyz[min(shapes.mass, len(wxyz) - 1)])


def stacked_heights(count: int) -> list[float]:
    """Heights [beam lengths] of `count` rows around the middle of the scene, the first on top."""
    return [ROW_SPACING * ((count - 1) / 2 - k) for k in range(count)]


class BeamScene:
    """The beam in a scene; or each of its modes in a row of its own, on one clock (paper, figs.
    14-15). views: by number, 0 for the single beam, k for the row of mode k; rows: the views
    in the picture."""

    def __init__(self, api: SceneApi):
        self.api = api
        add_lights(api)
        self.views: dict[int, BeamView] = {}
        self.rows: list[BeamView] = []

    def view(self, k: int) -> BeamView:
        """The view of number k, made when it is first needed."""
        if k not in self.views:
            self.views[k] = BeamView(self.api, f"/mode {k}" if k else "/scene", alone=k == 0)
        return self.views[k]

    def show(
        self,
        shapes: SampledModes,
        view: ViewOptions,
        motion: DrawnMotion,
        warning: str = "",
        title: str = "",
    ) -> None:
        """Draw a beam as `BeamView.show` does, or all its modes."""
        rows = in_rows(shapes, view, warning)
        self.rows = [self.view(k + 1) for k in range(len(shapes.modes))] if rows else [self.view(0)]
        for beam in self.views.values():
            if beam not in self.rows:
                beam.hide()
        if not rows:
            self.view(0).show(shapes, view, motion, warning=warning, title=title)
            return
        frequency = frequencies(shapes.beam.units)
        for k, height in enumerate(stacked_heights(len(self.rows))):
            alone = view.amplitude * np.eye(len(self.rows))[k]
            own = DrawnMotion.of(shapes, view, motion.scale, alone)
            title = f"{shapes.labels[k]}   {frequency.text(shapes.frequencies[k], 5)}"
            self.rows[k].height = height
            self.rows[k].show(shapes, view, own, title=title)

    @property
    def captions(self) -> list[Caption]:
        return [caption for beam in self.rows for caption in beam.captions]

    def choose_frame(self, share: float) -> None:
        for beam in self.rows:
            beam.choose_frame(share)

    def move(self, phases: np.ndarray, angle: float) -> None:
        for beam in self.rows:
            beam.move(phases, angle)


def in_rows(shapes: SampledModes, view: ViewOptions, warning: str) -> bool:
    """Whether each mode is drawn in a row of its own: not for an unstable beam."""
    return view.all_modes and len(shapes.modes) > 0 and not warning
