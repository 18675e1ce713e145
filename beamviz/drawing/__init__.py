"""The beam in a viser scene: alone, with a second beam overlaid, or with each mode in a row."""

import math
from typing import Any

import numpy as np
import trimesh

from beamviz.drawing import beam_mesh, camera, colours
from beamviz.drawing.beam_mesh import DrawnBeam, subdivide, to_hub_frame
from beamviz.drawing.comparison import pair_heights
from beamviz.drawing.force_arrows import ForceArrows
from beamviz.drawing.forces import Forces, ModeForces
from beamviz.drawing.modes import displacement
from beamviz.drawing.objects import (
    Bodies,
    Caption,
    Nodes,
    ReferenceShapes,
    add_instances,
    add_mesh,
    set_surface,
    tube,
)
from beamviz.drawing.root_joint import RootJoint
from beamviz.drawing.scene_graph import DrawnScene
from beamviz.drawing.sizes import largest_reach, sections
from beamviz.drawing.surroundings import Surroundings, add_lights, axis_rotation
from beamviz.drawing.text import Measure, frequencies
from beamviz.drawing.tip_path import TipPath
from beamviz.tables import plural

INSET, OPACITY = 0.95, 0.5  # of an overlay: relative size, so that no faces coincide
ROW_SPACING = 0.42  # [beam lengths] between rows
TITLE_PLACE = np.array([-0.2, 0.0, 0.12])  # of the title of a row, from the clamp
BELOW = np.array([-0.4, 0.0, -0.12])  # the same of the lowest beam, with its speed above it
OPPOSITE = np.array([0.5, 0.0, 0.12])  # the same, where a bent beam is there
OVERLAY = "/scene/rotor/overlay"


class BeamView:
    """One beam in a scene: `show` draws another beam or view, `move` another moment.

    root: name of its node; alone: the only or the lowest beam, with floor and post; overlay:
    translucent, of one colour, drawn over another beam in the frame of its hub and without
    surroundings; height: [beam lengths] of its middle; fixed: its frame stays when its shape
    changes, as in a drag of the mass; line: points (n, 3) of the beam as drawn last, in the frame
    of the hub, at the stations of `shapes`; section: of its pieces (n - 1, 2, 2), see `sections`;
    capped: the pieces with an end that is seen, see `capped`.
    """

    def __init__(
        self, scene: DrawnScene, root: str = "/scene", *, alone: bool = True, overlay: bool = False
    ):
        self.scene, self.height, self.fixed, self.overlay = scene, 0.0, overlay, overlay
        self.alone = alone
        self.frame = scene.add_frame(root, show_axes=False)
        self.rotor = scene.add_frame(f"{root}/rotor", show_axes=False)
        self.surroundings = None if overlay else Surroundings(scene, root, alone=alone)
        self.reference = None if overlay else ReferenceShapes(scene, root)
        pale: Any = {"color": colours.BEFORE, "opacity": OPACITY}
        # In one piece: the edges of translucent ones would be seen.
        self.body = add_mesh(scene, f"{root}/rotor/body", **pale) if overlay else None
        self.beam = add_instances(scene, f"{root}/rotor/beam", tube(), hollow=True)
        self.ends = add_instances(scene, f"{root}/rotor/ends", trimesh.creation.box())
        self.bodies = Bodies(scene, root, OPACITY if overlay else None)
        self.joint = None if overlay else RootJoint(scene, root)
        self.nodes = Nodes(scene, root, colours.BEFORE if overlay else colours.NODE)
        self.tip_path = TipPath(scene, root, overlay=overlay)
        self.forces: ForceArrows | None = None  # made when they are first shown
        self.warning = Caption(scene, f"{root}/rotor/warning", "bottom")
        self.title = Caption(scene, f"{root}/title", "bottom")
        self.line = np.zeros((0, 3))

    def show(self, drawn: DrawnBeam) -> None:
        """Draw a beam and the nodes of the mode that it moves in."""
        self.drawn, view, beam = drawn, drawn.view, drawn.shapes.beam
        self.shapes = shapes = subdivide(drawn, one_colour=self.overlay)
        inset = INSET if self.overlay else 1.0
        self.section = inset * sections(beam, shapes.plane, shapes.x, view.thicken)
        self.capped = capped(self.section)
        self.choose_frame(float(view.rotating_frame))
        if self.surroundings:
            self.surroundings.show(beam, rotating_frame=view.rotating_frame, dark=view.dark)
        if self.reference:
            self.reference.show(shapes, self.section, visible=view.ghosts)
        alone = len(drawn.shown) == 1 and not drawn.warning
        marked = drawn.shown if view.nodes and alone else []
        labels = not (view.all_modes or self.overlay)
        below = self.show_forces()
        self.nodes.show(shapes, self.section, marked, labels=labels, below=below)
        colour = colours.GREYED if drawn.warning else colours.MASS
        colour = colours.BEFORE if self.overlay else colour
        self.bodies.show(shapes, colour, thicken=view.thicken, inset=inset, labels=labels)
        if self.joint:
            self.joint.show(beam, shapes.plane, self.section[0, 0])
        self.tip_path.show(drawn)
        self.warning.show(drawn.warning or drawn.note, (beam.delta + 0.5, 0.0, 0.12))
        points, _ = to_hub_frame(shapes, shapes.centreline)
        if self.overlay:  # not at the clamp, which is that of the other beam
            at = self.bodies.at[0] if self.bodies.shown else -1
            above = 0.1 + largest_reach(beam)
            self.title.show(drawn.title, points[at] + [0.0, 0.0, above])
        else:
            clamp = points[0] if view.rotating_frame else np.zeros(3)
            folded = shapes.centreline[:, 0].min() < TITLE_PLACE[0]
            beside = BELOW if self.alone else TITLE_PLACE
            self.title.anchor = "bottom" if self.alone or folded else "right"
            self.title.show(drawn.title, clamp + (OPPOSITE if folded else beside))
        self.frame.visible = True

    def show_forces(self) -> float:
        """Show the forces, if any, on the only or the lowest beam. Returns how far down they
        reach [beam lengths]."""
        drawn = self.drawn
        if self.alone and (self.forces or drawn.forces):
            self.forces = self.forces or ForceArrows(self.scene, self.frame.name)
            self.forces.show(drawn, self.section)
        return self.forces.depth if self.forces else 0.0

    @property
    def captions(self) -> list[Caption]:
        """The texts that the page writes over the scene."""
        texts = [*self.nodes.captions, *self.bodies.captions, self.warning, self.title]
        texts += [self.surroundings.speed] if self.surroundings else []
        texts += [self.forces.caption] if self.forces else []
        return [caption for caption in texts if caption.text and self.frame.visible]

    def hide(self) -> None:
        self.frame.visible = False

    def choose_frame(self, share: float) -> None:
        """Choose the frame; share: 0 stationary .. 1 rotating with the hub, as an overlay does."""
        self.share = 1.0 if self.overlay else share
        if not self.fixed:
            middle = share * camera.target(self.shapes, rotating_frame=True)  # else the axis
            self.scene.set_pose(self.frame, position=[0.0, 0.0, self.height] - middle)

    def move(self, phases: np.ndarray, angle: float, forces: Forces | None = None) -> None:
        """Draw the beam at phases (m,) [rad] of its modes, the hub rotated by angle [rad]; in the
        rotating frame the ground rotates instead. forces: of this moment of a motion in time; those
        of modes follow from their phases."""
        shapes = self.shapes
        moved = displacement(shapes, phases, self.drawn.amplitudes)
        points, normal = to_hub_frame(shapes, shapes.centreline + moved)
        self.line = points
        centres, wxyz, sizes = beam_mesh.segments(points, normal, self.section)
        if self.body:
            set_surface(self.scene, self.body, *beam_mesh.swept(points, normal, self.section))
        else:
            paint = colours.painted(shapes, self.drawn.view.colouring, moved, self.drawn.largest)
            if self.drawn.warning:
                paint[:] = colours.instanced(colours.GREYED)
            placed = {"batched_positions": centres, "batched_wxyzs": wxyz, "batched_scales": sizes}
            placed["batched_colors"] = paint
            self.scene.set_properties(self.beam, **placed)
            caps = {name: values[self.capped] for name, values in placed.items()}  # pieces are open
            self.scene.set_properties(self.ends, **caps)
        self.nodes.move(points, wxyz)
        self.bodies.move(points, wxyz)
        self.tip_path.move(phases)
        if self.forces and (source := self.drawn.forces):
            now = source.at(phases) if isinstance(source, ModeForces) else forces
            self.forces.move(shapes.x, points, now)
        if self.surroundings:
            self.surroundings.rotate(angle, self.share)
        self.scene.set_pose(self.rotor, wxyz=axis_rotation((1 - self.share) * angle))

    def count_periods(self, phases: np.ndarray) -> None:
        """Say how many periods are over of the slowest mode that the beam moves in: each begins at
        the largest displacement."""
        if self.drawn.shown:
            k = min(self.drawn.shown, key=lambda k: self.drawn.shapes.frequencies[k])
            count = int((phases[k].real - math.pi / 2) / (2 * math.pi))
            label = self.drawn.shapes.labels[k]
            counted = f": {plural(count, 'period')} of {label}" if count else ""
            self.title.text = self.drawn.title + counted


def capped(section: np.ndarray) -> list[int]:
    """The pieces (0-based) with a section that another does not continue: the first, the last, and
    those where it jumps. Through the end of an open piece one sees its inside, which between
    others has the same shade as its outside."""
    jumps = (section[:-1, 1] != section[1:, 0]).any(axis=1)
    return np.flatnonzero(np.append(True, jumps) | np.append(jumps, True)).tolist()


def stacked_heights(count: int) -> list[float]:
    """Heights [beam lengths] of `count` rows around the middle of the scene, the first on top."""
    return [ROW_SPACING * ((count - 1) / 2 - k) for k in range(count)]


def row_title(label: str, frequency: float, measure: Measure) -> str:
    """The title of a mode in its row: its name and frequency."""
    return f"{label}   {measure.text(frequency, 5)}"


class BeamScene:
    """The beam in a scene, alone or with a second one; or each of its modes in a row of its own
    (paper, figs. 14-15). views: by number, 0 for the single beam, k for the row of mode k; rows:
    the views in the picture; others: those of a second beam, by whether it is above the first, made
    when needed; second: the one in the picture."""

    def __init__(self, scene: DrawnScene):
        self.scene = scene
        add_lights(scene)
        self.views: dict[int, BeamView] = {}
        self.rows: list[BeamView] = []
        self.others: dict[bool, BeamView] = {}
        self.second: BeamView | None = None

    def view(self, k: int) -> BeamView:
        """The view of number k, made when it is first needed."""
        if k not in self.views:
            self.views[k] = BeamView(self.scene, f"/mode {k}" if k else "/scene", alone=k == 0)
        return self.views[k]

    def other(self, *, stacked: bool) -> BeamView:
        """The view of a second beam."""
        if stacked not in self.others:
            root, overlay = ("/other", False) if stacked else (OVERLAY, True)
            self.others[stacked] = BeamView(self.scene, root, alone=False, overlay=overlay)
        return self.others[stacked]

    def show(
        self, drawn: DrawnBeam, second: DrawnBeam | None = None, *, stacked: bool = False
    ) -> None:
        """Draw a beam, or all its modes, and a second beam, overlaid or above the first."""
        heights = pair_heights(stacked=second is not None and stacked)
        for other in self.others.values():
            other.hide()
        self.view(0).height = 0.0 if drawn.in_rows else heights[0]
        self.show_first(drawn)
        self.second = None
        if second:
            self.second = self.other(stacked=stacked)
            self.second.height = heights[-1]
            self.second.show(second)

    def show_first(self, drawn: DrawnBeam) -> None:
        """Draw a beam, or all its modes."""
        shapes, view, count = drawn.shapes, drawn.view, len(drawn.shapes.modes)
        self.rows = [self.view(k + 1) for k in range(count)] if drawn.in_rows else [self.view(0)]
        for beam in self.views.values():
            if beam not in self.rows:
                beam.hide()
        if not drawn.in_rows:
            self.view(0).show(drawn)
            return
        frequency = frequencies(shapes.beam.units)
        for k, (row, height) in enumerate(zip(self.rows, stacked_heights(count), strict=True)):
            title = row_title(shapes.labels[k], shapes.frequencies[k], frequency)
            alone = view.amplitude * np.eye(count)[k]
            row.height = height
            row.show(DrawnBeam(shapes, view, drawn.scale, alone, title=title))

    @property
    def in_picture(self) -> list[BeamView]:
        """All views in the picture; a second beam above the first before that."""
        if self.second is None:
            return self.rows
        return [*self.rows, self.second] if self.second.overlay else [self.second, *self.rows]

    @property
    def captions(self) -> list[Caption]:
        """The texts over the scene, of which one that would cover another is moved down."""
        return [caption for beam in self.in_picture for caption in beam.captions]

    def choose_frame(self, share: float) -> None:
        for beam in self.in_picture:
            beam.choose_frame(share)

    def tell_speed(self, gamma: float) -> None:
        """Say the present speed of the single beam."""
        view = self.view(0)
        if view.surroundings:
            view.surroundings.tell_speed(gamma, view.drawn.shapes.beam.units)

    def move(
        self,
        phases: np.ndarray,
        angle: float,
        other_phases: Any = None,
        forces: Forces | None = None,
    ) -> None:
        """Draw a moment, with the phases of the second beam, and the forces in a motion in time."""
        for beam in self.rows:
            beam.move(phases, angle, forces)
        if self.second:
            self.second.move(other_phases, angle)
            if not self.second.overlay and self.second.drawn.shown:
                self.rows[0].count_periods(phases)
                self.second.count_periods(other_phases)
