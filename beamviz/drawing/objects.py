"""The objects of a scene: their sizes, instanced meshes, light, ground, hub and vibration nodes."""

import math
from typing import Any

import numpy as np
import trimesh
from viser import BatchedMeshHandle, SceneApi

from beamviz.beam import Beam
from beamviz.drawing import beam_mesh, colours
from beamviz.drawing.beam_mesh import DEFAULT_SCALE, NORMALS, Section, extents, to_hub_frame
from beamviz.drawing.modes import SampledModes
from beamviz.drawing.text import measure
from beamviz.server.viser_private import set_position, set_properties

MIN_HUB = 0.05
VISIBLE_THICKNESS = 0.04
MASS_RADIUS = 0.08  # at alpha = 1


def section_size(beam: Beam, thicken: bool = False) -> Section:
    """Thickness in the plane of motion and breadth along its normal.

    The thickness is true: h = sqrt(12) / mu for a rectangle. The five numbers leave the
    breadth free; it is kept where it can be seen.
    """
    thickness = math.sqrt(12) / beam.mu
    if thicken:
        thickness = max(thickness, VISIBLE_THICKNESS)
    return thickness, min(max(1.5 * thickness, 0.05), 0.1)


def mass_radius(beam: Beam, thicken: bool = False) -> float:
    """Radius of the mass: its volume follows alpha, but it never hides inside the beam."""
    return max(MASS_RADIUS * beam.alpha ** (1 / 3), 0.8 * section_size(beam, thicken)[1])


def hub_radius(beam: Beam) -> float:
    """Radius of the hub: |delta|, but a small drum is left at delta = 0."""
    return max(abs(beam.delta), MIN_HUB)


def ground_height(beam: Beam) -> float:
    """Height of the ground below the beam."""
    return -max(0.3, 1.2 * mass_radius(beam)) if beam.alpha > 0 else -0.3


HIDDEN = 1e-6  # size of an instance that is not shown


def add_instances(
    api: SceneApi, name: str, count: int, mesh: trimesh.Trimesh, **options: Any
) -> BatchedMeshHandle:
    """`count` instances of a mesh in one node, each with a position, orientation, size and colour.

    A browser draws such nodes one frame late, so everything that moves with them is of this kind.
    """
    return api.add_batched_meshes_simple(
        name,
        mesh.vertices,
        mesh.faces,
        batched_wxyzs=np.tile([1.0, 0.0, 0.0, 0.0], (count, 1)),
        batched_positions=np.zeros((count, 3)),
        batched_scales=np.full((count, 3), HIDDEN),
        batched_colors=np.zeros((count, 3), np.uint8),
        side="double",
        lod="off",
        **{"flat_shading": True, **options},
    )


HUB_HEIGHT = 0.14
HOOP = 0.05
MAX_NODES = 10
LETTER_HEIGHT = 13  # [pixels] of labels
# In lengths of the beam: at least, and at most for all labels of a mode together.
MIN_LETTERS, MAX_LETTERS = 0.016, 0.09
FADE_DISTANCE = 2.2  # of the ground, from the beam


def axis_rotation(angle: float) -> tuple[float, float, float, float]:
    """The rotation about the axis by angle [rad] as a quaternion wxyz."""
    return (math.cos(angle / 2), 0.0, 0.0, math.sin(angle / 2))


def add_lights(api: SceneApi) -> None:
    """Soft light from above and behind the viewer on the left; shadows fall on the ground."""
    api.configure_environment_map(hdri=None)
    api.configure_default_lights(enabled=False)
    api.add_light_hemisphere("/light/sky", ground_color=(200, 200, 210), intensity=1.6)
    api.add_light_directional(
        "/light/key", position=(-0.5, -1.0, 2.2), intensity=1.8, cast_shadow=True
    )
    api.add_light_directional("/light/fill", position=(1.5, -2.0, 0.6), intensity=0.5)


class Surroundings:
    """A hub with a mark on a post, above a grid with cells of a tenth of the beam length.

    The hub is a drum, or a hoop for a beam that points inward; the grid fades with distance.
    """

    def __init__(self, api: SceneApi, root: str, *, alone: bool):
        self.alone = alone  # with grid and post, of which a scene has one
        self.drawn_for: tuple = ()  # the values they were last drawn for
        self.grid = api.add_grid(
            f"{root}/ground",
            cell_size=0.1,
            cell_thickness=0.7,
            cell_color=colours.GRID,
            section_size=0.5,
            section_thickness=1.1,
            section_color=colours.GRID,
            fade_from="origin",
            shadow_opacity=0.25,
        )
        hub: Any = {"color": colours.HUB, "receive_shadow": False}
        self.post = api.add_cylinder(f"{root}/rotor/post", 0.018, 1.0, **hub)
        self.drum = api.add_cylinder(
            f"{root}/rotor/drum", 1.0, HUB_HEIGHT, radial_segments=160, **hub
        )
        hoop = annulus(1.0)
        self.hoop = api.add_mesh_simple(
            f"{root}/rotor/hoop", hoop.vertices, hoop.faces, flat_shading=True, **hub
        )
        self.mark = api.add_box(f"{root}/rotor/mark", color=colours.MARKER)

    def show(self, beam: Beam, *, rotating_frame: bool) -> None:
        """Place them for `beam`: the clamp is on the rim, so the hub's radius is |delta|."""
        ground, inward, radius = ground_height(beam), beam.delta < 0, hub_radius(beam)
        drawn_for = beam.delta, ground, rotating_frame
        if drawn_for == self.drawn_for:
            return
        self.drawn_for, reach = drawn_for, 1.0 + abs(beam.delta) + FADE_DISTANCE
        self.grid.visible, self.post.visible = self.alone, self.alone and not inward
        self.grid.width = self.grid.height = 2 * reach
        self.grid.fade_distance = FADE_DISTANCE if rotating_frame else reach
        self.grid.position = (0.0, 0.0, ground)
        self.post.height = -ground
        self.post.position = (0.0, 0.0, ground / 2)
        self.drum.visible, self.hoop.visible = not inward, inward
        self.drum.radius = radius
        if inward:
            self.hoop.vertices = annulus(radius).vertices
            self.mark.dimensions = (HOOP, 0.03, 0.004)
            self.mark.position = (-radius - HOOP / 2, 0.0, HUB_HEIGHT / 2)
        else:
            self.mark.dimensions = (0.6 * radius, min(0.4 * radius, 0.03), 0.004)
            self.mark.position = (0.6 * radius, 0.0, HUB_HEIGHT / 2)


def annulus(radius: float) -> trimesh.Trimesh:
    """The hoop that an inward beam is clamped to from inside."""
    return trimesh.creation.annulus(radius, radius + HOOP, HUB_HEIGHT, sections=160)


# A beam of unit size, until a mesh gets the vertices of its own.
ENDS = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
BOX, SIDES = beam_mesh.swept(ENDS, NORMALS["chordwise"], (1.0, 1.0))


class ReferenceShapes:
    """The outline of the undeformed beam, and the beam in equilibrium as a translucent body."""

    def __init__(self, api: SceneApi, root: str):
        self.outline = api.add_line_segments(
            f"{root}/rotor/undeformed",
            np.zeros((12, 2, 3)),
            colours.GHOST,
            thickness=1.2,
            thickness_units="screen",
        )
        self.equilibrium = api.add_mesh_simple(
            f"{root}/rotor/equilibrium",
            BOX,
            SIDES,
            color=colours.GHOST,
            opacity=0.1,
            flat_shading=True,
            cast_shadow=False,
            receive_shadow=False,
        )

    def show(self, shapes: SampledModes, section: Section, *, visible: bool) -> None:
        """Draw both."""
        self.outline.visible = self.equilibrium.visible = visible
        if not visible:
            return
        inner = (0.97 * section[0], 0.97 * section[1])  # its faces do not coincide with the beam's
        ends = to_hub_frame(shapes, shapes.centreline[[0, -1]])  # it is straight
        vertices = beam_mesh.swept(*ends, inner)[0].astype(np.float32)
        set_properties(self.equilibrium, {"vertices": vertices})
        edges = beam_mesh.straight_edges(shapes, section).astype(np.float32)
        set_properties(self.outline, {"points": edges})


class Nodes:
    """A collar and a label at each vibration node."""

    def __init__(self, api: SceneApi, root: str, colour: colours.RGB = colours.NODE):
        self.piece = np.zeros(0, int)  # the piece of the beam of each node
        self.share = np.zeros((0, 1))  # and its relative position along the piece
        self.count = 0  # of the labels shown
        self.collars = add_instances(api, f"{root}/rotor/nodes", MAX_NODES, trimesh.creation.box())
        self.collars.batched_colors = colours.instanced(np.tile(colour, (MAX_NODES, 1)) / 255)
        style: Any = {"anchor": "top-center", "font_size_mode": "scene", "visible": False}
        self.labels = [
            api.add_label(f"{root}/rotor/node {k}", "", **style) for k in range(MAX_NODES)
        ]

    def show(
        self,
        shapes: SampledModes,
        section: Section,
        shown: list[int],
        *,
        labels: bool = True,
        scale: float = DEFAULT_SCALE,
    ) -> None:
        """Mark the nodes of the modes `shown` (0-based), at most MAX_NODES of them, at `scale`
        pixels per length of the beam."""
        marks = [(shapes.labels[k], float(at)) for k in shown for at in shapes.nodes[k]][:MAX_NODES]
        at, x = np.array([at for _, at in marks]), shapes.x
        self.piece = np.searchsorted(x, at, side="right").clip(1, len(x) - 1) - 1
        self.share = ((at - x[self.piece]) / (x[self.piece + 1] - x[self.piece]))[:, None]
        size = [0.007, 0.0, 0.0] + 1.3 * extents(section, NORMALS[shapes.plane])
        scales = np.full((MAX_NODES, 3), HIDDEN, np.float32)
        scales[: len(marks)] = size
        self.collars.visible = bool(marks)
        set_properties(self.collars, {"batched_scales": scales})
        height = min(max(LETTER_HEIGHT / scale, MIN_LETTERS), MAX_LETTERS / max(len(marks), 1))
        still, _ = to_hub_frame(shapes, shapes.centreline)
        places = self.on_beam(still) - [0.0, 0.0, size[2] / 2 + 0.05]
        units = shapes.beam.units
        for label, (mode, at_x), place in zip(self.labels, marks, places, strict=False):
            label.font_scene_height = height
            position = measure("beta", units).text(at_x, 4) if units else f"{at_x:.3f}"
            label.text = f"{mode} node at {position}"
            set_position(label, place)
        count = len(marks) if labels else 0
        for k in range(min(count, self.count), max(count, self.count)):
            self.labels[k].visible = k < count
        self.count = count

    def on_beam(self, points: np.ndarray) -> np.ndarray:
        """The nodes (j, 3) on the line of `points` (n, 3)."""
        return (1 - self.share) * points[self.piece] + self.share * points[self.piece + 1]

    def move(self, points: np.ndarray, wxyz: np.ndarray) -> None:
        """Move the collars onto the line of `points` (n, 3) whose pieces have the orientations
        wxyz (n - 1, 4)."""
        count = len(self.piece)
        if not count:
            return
        centres = np.zeros((MAX_NODES, 3), np.float32)
        orientations = np.tile(np.array([1.0, 0.0, 0.0, 0.0], np.float32), (MAX_NODES, 1))
        centres[:count], orientations[:count] = self.on_beam(points), wxyz[self.piece]
        set_properties(self.collars, {"batched_positions": centres, "batched_wxyzs": orientations})
