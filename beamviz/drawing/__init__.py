"""The beam in a viser scene: alone, with a second beam overlaid, or with each mode in a row."""

from dataclasses import replace
from typing import Any

import numpy as np
import trimesh
from viser import BatchedMeshHandle, SceneApi

from beamviz.drawing import beam_mesh, camera, colours
from beamviz.drawing.beam_mesh import DEFAULT_SCALE, DrawnMotion, subdivide, to_hub_frame
from beamviz.drawing.modes import SampledModes, amplitudes, displacement
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
        if alone:
            add_lights(api)
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
        shown: list[int],
        *,
        warning: str = "",
        title: str = "",
        motion: DrawnMotion | None = None,
    ) -> None:
        """Draw a beam and the nodes of its modes `shown` (0-based), with a warning above it in
        grey. motion: that the beam is subdivided for, by default that of `view`."""
        sizes = amplitudes(view, len(shapes.modes))
        motion = motion or DrawnMotion.of(shapes, sizes, view.colouring)
        shapes = subdivide(shapes, motion, self.count)
        self.shapes, self.view, self.greyed = shapes, view, bool(warning)
        beam = shapes.beam
        self.section = section_size(beam, view.thicken)
        self.choose_frame(float(view.rotating_frame))
        self.surroundings.show(beam, rotating_frame=view.rotating_frame, dark=view.dark)
        self.reference.show(shapes, self.section, visible=view.ghosts)
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

    def move(self, phases: np.ndarray, amplitudes: np.ndarray, angle: float) -> None:
        """Draw the beam at phases (m,) [rad] with amplitudes (m,), the hub rotated by angle [rad];
        in the rotating frame the ground rotates instead."""
        moved = displacement(self.shapes, phases, amplitudes)
        largest = colours.colour_range(self.shapes, self.view.colouring, amplitudes)
        self.displace(moved, largest, angle)

    def displace(self, moved: np.ndarray, largest: float, angle: float) -> None:
        """Draw the beam displaced by `moved` (n, 2), in colours that end at `largest`."""
        shapes = self.shapes
        points, normal = to_hub_frame(shapes, shapes.centreline + moved)
        centres, wxyz, sizes = beam_mesh.segments(points, normal, self.section)
        if self.greyed:
            paint = colours.instanced(np.tile(colours.GREYED, (len(points) - 1, 1)))
        else:
            paint = colours.painted(shapes, self.view.colouring, moved, largest)
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
        shown: list[int],
        title: str,
        motion: DrawnMotion,
    ) -> None:
        """Draw a beam and the nodes of its modes `shown` (0-based), subdivided for `motion`."""
        shapes = subdivide(shapes, replace(motion, largest=np.inf), self.count)
        self.count = len(shapes.strain)
        thickness, breadth = section_size(shapes.beam, view.thicken)
        self.shapes, self.section = shapes, (INSET * thickness, INSET * breadth)
        self.root.visible = True
        self.mass.visible = shapes.beam.alpha > 0
        length, radius = mass_size(shapes.beam, view.thicken)
        self.mass.scale = (INSET * length, INSET * radius, INSET * radius)
        self.nodes.show(shapes, self.section, shown if view.nodes else [], labels=False)
        points, _ = to_hub_frame(shapes, shapes.centreline)
        top = points[shapes.mass if shapes.beam.alpha > 0 else -1] + TITLE_OFFSET
        self.title.show(title, top + [0.0, 0.0, radius])

    @property
    def captions(self) -> list[Caption]:
        return [self.title] if self.root.visible else []

    def hide(self) -> None:
        self.root.visible = False

    def move(self, phases: np.ndarray, amplitudes: np.ndarray, angle: float) -> None:
        shapes = self.shapes
        moved = displacement(shapes, phases, amplitudes)
        points, normal = to_hub_frame(shapes, shapes.centreline + moved)
        set_surface(self.body, *beam_mesh.swept(points, normal, self.section))
        wxyz = beam_mesh.segments(points, normal, self.section)[1]
        self.nodes.move(points, wxyz)
        set_position(self.mass, points[shapes.mass])
        set_orientation(self.mass, wxyz[min(shapes.mass, len(wxyz) - 1)])


def stacked_heights(count: int) -> list[float]:
    """Heights [beam lengths] of `count` rows around the middle of the scene, the first on top."""
    return [ROW_SPACING * ((count - 1) / 2 - k) for k in range(count)]


class AllModesView:
    """Each mode in a row of its own, on one clock (paper, figs. 14-15)."""

    def __init__(self, api: SceneApi):
        self.api = api
        self.rows: list[BeamView] = []
        self.count = 0  # of the rows shown

    def show(self, shapes: SampledModes, view: ViewOptions, scale: float = DEFAULT_SCALE) -> None:
        """Draw one row for each mode, at `scale` [pixels per beam length]."""
        self.count = len(shapes.modes)
        while len(self.rows) < self.count:
            self.rows.append(BeamView(self.api, f"/mode {len(self.rows) + 1}", alone=False))
        frequency = frequencies(shapes.beam.units)
        for k, height in enumerate(stacked_heights(self.count)):
            alone = view.amplitude * np.eye(self.count)[k]
            motion = DrawnMotion.of(shapes, alone, view.colouring, scale)
            title = f"{shapes.labels[k]}   {frequency.text(shapes.frequencies[k], 5)}"
            self.rows[k].height = height
            self.rows[k].show(shapes, view, [k], title=title, motion=motion)
        for row in self.rows[self.count :]:
            row.hide()

    def hide(self) -> None:
        for row in self.rows[: self.count]:
            row.hide()
        self.count = 0

    def choose_frame(self, share: float) -> None:
        for row in self.rows[: self.count]:
            row.choose_frame(share)

    def move(self, phases: np.ndarray, amplitude: float, angle: float) -> None:
        """Draw the rows at phases (m,) [rad]."""
        for k, alone in enumerate(amplitude * np.eye(self.count)):
            self.rows[k].move(phases, alone, angle)
