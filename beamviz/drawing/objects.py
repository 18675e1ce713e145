"""The objects of a scene: their sizes, instanced meshes, light, ground, hub and vibration nodes."""

import math

import numpy as np
import trimesh
from viser import BatchedMeshHandle, MeshHandle, SceneApi

from beamviz.beam import Beam, Units
from beamviz.drawing import beam_mesh, colours
from beamviz.drawing.beam_mesh import DEFAULT_SCALE
from beamviz.drawing.modes import SampledModes
from beamviz.drawing.text import measure
from beamviz.server.viser_private import set_position, set_properties

MIN_HUB = 0.05
VISIBLE_THICKNESS = 0.04
MASS_RADIUS = 0.08  # at alpha = 1


def section_size(beam: Beam, thicken: bool = False) -> tuple[float, float]:
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
    api: SceneApi,
    name: str,
    count: int,
    mesh: trimesh.Trimesh,
    *,
    flat_shading: bool = True,
    receive_shadow: bool = True,
) -> BatchedMeshHandle:
    """`count` instances of a mesh in one node, each with a place, rotation, size and colour.

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
        flat_shading=flat_shading,
        receive_shadow=receive_shadow,
        side="double",
        lod="off",
    )


def box() -> trimesh.Trimesh:
    """A unit box."""
    return trimesh.creation.box((1.0, 1.0, 1.0))


def open_box() -> trimesh.Trimesh:
    """A unit box without its ends, which would stick out where a row of boxes bends."""
    whole = box()
    walls = np.abs(whole.face_normals[:, 0]) < 0.5
    return trimesh.Trimesh(whole.vertices, whole.faces[walls], process=False)


def sphere() -> trimesh.Trimesh:
    """A sphere of radius 1."""
    return trimesh.creation.icosphere(subdivisions=4)


def place_instances(
    bodies: BatchedMeshHandle,
    centres: np.ndarray,
    wxyz: np.ndarray,
    lengths: np.ndarray,
    paint: np.ndarray,
) -> None:
    """Set centres (n, 3), orientations (n, 4), sizes (n, 3) and colours (n, 3) of all instances."""
    placed = {
        "batched_positions": centres.astype(np.float32),
        "batched_wxyzs": wxyz.astype(np.float32),
        "batched_scales": lengths.astype(np.float32),
        "batched_colors": paint,
    }
    set_properties(bodies, placed)


HUB_HEIGHT = 0.14
HOOP = 0.05
MAX_NODES = 10
LETTER_HEIGHT = 13  # [pixels] of labels
# In lengths of the beam: at least, and at most for all labels of a mode together.
MIN_LETTERS, MAX_LETTERS = 0.016, 0.09
FADE_DISTANCE = 2.2  # of the ground, from the beam


def to_hub_frame(shapes: SampledModes, centreline: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A line (n, 2) measured from the clamp as points (n, 3) in the hub's frame, and the normal of
    the plane of motion."""
    points, normal = beam_mesh.frame(centreline, shapes.plane)
    points[:, 0] += shapes.beam.delta
    return points, normal


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


class Ground:
    """A grid with cells of a tenth of the beam length, with shadows, fading with distance."""

    def __init__(self, api: SceneApi, root: str):
        self.drawn_for: tuple = ()  # the values it was last drawn for
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

    def show(self, beam: Beam, *, rotating_frame: bool) -> None:
        """Place it under `beam`."""
        drawn_for = beam.delta, ground_height(beam), rotating_frame
        if drawn_for == self.drawn_for:
            return
        self.drawn_for, reach = drawn_for, 1.0 + abs(beam.delta) + FADE_DISTANCE
        self.grid.width = self.grid.height = 2 * reach
        self.grid.fade_distance = FADE_DISTANCE if rotating_frame else reach
        self.grid.position = (0.0, 0.0, ground_height(beam))


class Hub:
    """A drum on a post (a hoop when the beam points inward), with a mark to show its rotation."""

    def __init__(self, api: SceneApi, root: str):
        self.drawn_for: tuple = ()  # the values it was last drawn for
        self.post = api.add_cylinder(
            f"{root}/rotor/post", 0.018, 1.0, color=colours.HUB, receive_shadow=False
        )
        self.drum = api.add_cylinder(
            f"{root}/rotor/drum",
            1.0,
            HUB_HEIGHT,
            color=colours.HUB,
            radial_segments=160,
            receive_shadow=False,
        )
        hoop = annulus(1.0)
        self.hoop = api.add_mesh_simple(
            f"{root}/rotor/hoop",
            hoop.vertices,
            hoop.faces,
            color=colours.HUB,
            flat_shading=True,
            receive_shadow=False,
        )
        self.mark = api.add_box(f"{root}/rotor/mark", color=colours.MARKER)

    def show(self, beam: Beam) -> None:
        """Draw the hub of `beam`: the clamp is on its rim, so its radius is |delta|."""
        drawn_for = beam.delta, ground_height(beam)
        if drawn_for == self.drawn_for:
            return
        self.drawn_for, radius, inward = drawn_for, hub_radius(beam), beam.delta < 0
        self.drum.visible, self.hoop.visible = not inward, inward
        self.drum.radius = radius
        if inward:
            self.hoop.vertices = annulus(radius).vertices
        self.post.height = -ground_height(beam)
        self.post.position = (0.0, 0.0, ground_height(beam) / 2)
        if inward:
            self.mark.dimensions = (HOOP, 0.03, 0.004)
            self.mark.position = (-radius - HOOP / 2, 0.0, HUB_HEIGHT / 2)
        else:
            self.mark.dimensions = (0.6 * radius, min(0.4 * radius, 0.03), 0.004)
            self.mark.position = (0.6 * radius, 0.0, HUB_HEIGHT / 2)


def annulus(radius: float) -> trimesh.Trimesh:
    """The hoop that an inward beam is clamped to from inside."""
    return trimesh.creation.annulus(radius, radius + HOOP, HUB_HEIGHT, sections=160)


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
        self.stretched = api.add_mesh_simple(
            f"{root}/rotor/equilibrium",
            BOX,
            SIDES,
            color=colours.GHOST,
            opacity=0.1,
            flat_shading=True,
            cast_shadow=False,
            receive_shadow=False,
        )

    def show(self, shapes: SampledModes, section: tuple[float, float], *, visible: bool) -> None:
        """Draw both."""
        self.outline.visible = self.stretched.visible = visible
        if not visible:
            return
        normal = beam_mesh.NORMALS[shapes.plane]
        size = section[0] * np.abs(beam_mesh.crosswise(normal)) + section[1] * np.abs(normal)
        start, end = shapes.beam.delta + shapes.centreline[[0, -1], 0]  # it is straight
        body = 0.97 * size  # not in the same faces as the beam
        body[0], size[0] = end - start, 1.0
        vertices = BOX * body + [start, 0.0, 0.0]
        set_properties(self.stretched, {"vertices": vertices.astype(np.float32)})
        edges = EDGES * size + [shapes.beam.delta + 0.5, 0.0, 0.0]
        set_properties(self.outline, {"points": edges.astype(np.float32)})


def position_text(x: float, units: Units | None) -> str:
    """A position along the beam as text."""
    return measure("beta", units).text(x, 4) if units else f"{x:.3f}"


def unit_beam() -> tuple[np.ndarray, np.ndarray]:
    """Vertices (8, 3) and triangles (12, 3) of a unit cube along x from 0 to 1."""
    ends = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    return beam_mesh.swept(ends, beam_mesh.NORMALS["chordwise"], 1.0, 1.0)


def set_surface(mesh: MeshHandle, vertices: np.ndarray, faces: np.ndarray) -> None:
    """Replace vertices and faces of a mesh in one message, so that they always fit each other."""
    shape = {"vertices": vertices.astype(np.float32)}
    if len(faces) != len(mesh.faces):
        shape["faces"] = faces.astype(np.uint32)
    set_properties(mesh, shape)


def unit_edges() -> np.ndarray:
    """The twelve edges (12, 2, 3) of a unit box around the origin."""
    corners = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    return np.array(
        [(a, b) for a in corners for b in corners if (b - a).sum() == 1 and (a != b).sum() == 1]
    )


EDGES = unit_edges()
BOX, SIDES = unit_beam()


class Nodes:
    """A collar and a label at each vibration node."""

    def __init__(self, api: SceneApi, root: str, colour: colours.RGB = colours.NODE):
        self.piece = np.zeros(0, int)  # the piece of the beam of each node
        self.share = np.zeros((0, 1))  # and its relative position along the piece
        self.count = 0  # of the labels shown
        self.collars = add_instances(api, f"{root}/rotor/nodes", MAX_NODES, box())
        self.collars.batched_colors = colours.instanced(
            np.tile(np.array(colour) / 255, (MAX_NODES, 1))
        )
        self.labels = [
            api.add_label(
                f"{root}/rotor/node {k}",
                "",
                anchor="top-center",
                font_size_mode="scene",
                visible=False,
            )
            for k in range(MAX_NODES)
        ]

    def show(
        self,
        shapes: SampledModes,
        section: tuple[float, float],
        shown: list[int],
        *,
        labels: bool = True,
        scale: float = DEFAULT_SCALE,
    ) -> None:
        """Mark the nodes of the modes `shown` (0-based), at most MAX_NODES of them, at `scale`
        pixels per length of the beam."""
        marks = [
            (shapes.labels[k], x, place)
            for k in shown
            for x, place in zip(*shapes.nodes[k], strict=True)
        ][:MAX_NODES]
        self.collars.visible = bool(marks)
        at, x = np.array([x for _, x, _ in marks]), shapes.x
        self.piece = np.searchsorted(x, at, side="right").clip(1, len(x) - 1) - 1
        self.share = ((at - x[self.piece]) / (x[self.piece + 1] - x[self.piece]))[:, None]
        scales = np.full((MAX_NODES, 3), HIDDEN, np.float32)
        height = min(max(LETTER_HEIGHT / scale, MIN_LETTERS), MAX_LETTERS / max(len(marks), 1))
        for k, (label, x, place) in enumerate(marks):
            self.labels[k].font_scene_height = height
            points, normal = to_hub_frame(shapes, place[None])
            across = np.abs(beam_mesh.crosswise(normal))
            scales[k] = [0.007, 0.0, 0.0] + 1.3 * (
                section[0] * across + section[1] * np.abs(normal)
            )
            self.labels[k].text = f"{label} node at {position_text(x, shapes.beam.units)}"
            set_position(self.labels[k], points[0] - [0.0, 0.0, scales[k][2] / 2 + 0.05])
        set_properties(self.collars, {"batched_scales": scales})
        count = len(marks) if labels else 0
        for k in range(min(count, self.count), max(count, self.count)):
            self.labels[k].visible = k < count
        self.count = count

    def move(self, points: np.ndarray, wxyz: np.ndarray) -> None:
        """Move the collars onto the line of `points` (n, 3) whose pieces have the orientations
        wxyz (n - 1, 4)."""
        piece, share = self.piece, self.share
        if not piece.size:
            return
        turns, centres = np.zeros((MAX_NODES, 4), np.float32), np.zeros((MAX_NODES, 3), np.float32)
        turns[:, 0] = 1.0
        turns[: len(share)] = wxyz[piece]
        centres[: len(share)] = (1 - share) * points[piece] + share * points[piece + 1]
        set_properties(self.collars, {"batched_positions": centres, "batched_wxyzs": turns})
