"""What stands around the beam: light, ground, hub, ghosts and marks of the nodes."""

import math

import numpy as np
import trimesh
from viser import MeshHandle, SceneApi

from beamviz.beam import Beam, Units
from beamviz.display_units import measure
from beamviz.drawing import beam_mesh as tube
from beamviz.drawing import colours, sizes
from beamviz.drawing.instances import HIDDEN, add_bodies, box
from beamviz.drawing.modes import Shapes
from beamviz.drawing.subdivision import SCALE
from beamviz.server.viser_private import set_position, set_properties

HUB_HEIGHT = 0.14
HOOP = 0.05
MAX_NODES = 10
LETTERS = 13  # [pixels] high is a label, but not smaller than SMALLEST in lengths of the beam,
SMALLEST, CROWDED = 0.016, 0.09  # nor larger than its share of CROWDED
FADED = 2.2  # the ground is seen so far from the beam


def placed(shapes: Shapes, centreline: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A line (n, 2) measured from the clamp as points (n, 3) of the hub, and its plane's normal."""
    points, normal = tube.frame(centreline, shapes.plane)
    points[:, 0] += shapes.beam.delta
    return points, normal


def turned(angle: float) -> tuple[float, float, float, float]:
    """A turn about the axis by angle [rad] as wxyz."""
    return (math.cos(angle / 2), 0.0, 0.0, math.sin(angle / 2))


def light(api: SceneApi) -> None:
    """Soft light from above, behind the viewer's left shoulder; shadows fall on the ground."""
    api.configure_environment_map(hdri=None)
    api.configure_default_lights(enabled=False)
    api.add_light_hemisphere("/light/sky", ground_color=(200, 200, 210), intensity=1.6)
    api.add_light_directional(
        "/light/key", position=(-0.5, -1.0, 2.2), intensity=1.8, cast_shadow=True
    )
    api.add_light_directional("/light/fill", position=(1.5, -2.0, 0.6), intensity=0.5)


class Ground:
    """A grid with cells of a tenth of the beam that fades away from it and takes the shadows."""

    def __init__(self, api: SceneApi, root: str):
        self.known: tuple = ()  # what it was laid for
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
        """Lay it under `beam`, as far as one sees."""
        known = beam.delta, sizes.ground(beam), rotating_frame
        if known == self.known:
            return
        self.known, reach = known, 1.0 + abs(beam.delta) + FADED
        self.grid.width = self.grid.height = 2 * reach
        self.grid.fade_distance = FADED if rotating_frame else reach
        self.grid.position = (0.0, 0.0, sizes.ground(beam))


class Hub:
    """A drum (a hoop when the beam points inward) on a post, with a mark that shows it turn."""

    def __init__(self, api: SceneApi, root: str):
        self.known: tuple = ()  # what it was drawn for
        self.post = api.add_cylinder(
            f"{root}/wheel/post", 0.018, 1.0, color=colours.HUB, receive_shadow=False
        )
        self.drum = api.add_cylinder(
            f"{root}/wheel/drum",
            1.0,
            HUB_HEIGHT,
            color=colours.HUB,
            radial_segments=160,
            receive_shadow=False,
        )
        hoop = annulus(1.0)
        self.hoop = api.add_mesh_simple(
            f"{root}/wheel/hoop",
            hoop.vertices,
            hoop.faces,
            color=colours.HUB,
            flat_shading=True,
            receive_shadow=False,
        )
        self.mark = api.add_box(f"{root}/wheel/mark", color=colours.MARKER)

    def show(self, beam: Beam) -> None:
        """Draw the hub of `beam`: the clamp is on its rim, so its radius is |delta|."""
        known = beam.delta, sizes.ground(beam)
        if known == self.known:
            return
        self.known, radius, inward = known, sizes.hub_radius(beam), beam.delta < 0
        self.drum.visible, self.hoop.visible = not inward, inward
        self.drum.radius = radius
        if inward:
            self.hoop.vertices = annulus(radius).vertices
        self.post.height = -sizes.ground(beam)
        self.post.position = (0.0, 0.0, sizes.ground(beam) / 2)
        if inward:
            self.mark.dimensions = (HOOP, 0.03, 0.004)
            self.mark.position = (-radius - HOOP / 2, 0.0, HUB_HEIGHT / 2)
        else:
            self.mark.dimensions = (0.6 * radius, min(0.4 * radius, 0.03), 0.004)
            self.mark.position = (0.6 * radius, 0.0, HUB_HEIGHT / 2)


def annulus(radius: float) -> trimesh.Trimesh:
    """The hoop that an inward beam is clamped to from inside."""
    return trimesh.creation.annulus(radius, radius + HOOP, HUB_HEIGHT, sections=160)


class Ghosts:
    """Where the beam would be: an outline undeformed, a pale body stretched by the rotation."""

    def __init__(self, api: SceneApi, root: str):
        self.outline = api.add_line_segments(
            f"{root}/wheel/undeformed",
            np.zeros((12, 2, 3)),
            colours.GHOST,
            thickness=1.2,
            thickness_units="screen",
        )
        self.stretched = api.add_mesh_simple(
            f"{root}/wheel/equilibrium",
            BOX,
            SIDES,
            color=colours.GHOST,
            opacity=0.1,
            flat_shading=True,
            cast_shadow=False,
            receive_shadow=False,
        )

    def show(self, shapes: Shapes, section: tuple[float, float], *, visible: bool) -> None:
        """Draw both for one beam."""
        self.outline.visible = self.stretched.visible = visible
        if not visible:
            return
        normal = tube.NORMALS[shapes.plane]
        size = section[0] * np.abs(tube.crosswise(normal)) + section[1] * np.abs(normal)
        start, end = shapes.beam.delta + shapes.centreline[[0, -1], 0]  # it is straight
        body = 0.97 * size  # not in the same faces as the beam
        body[0], size[0] = end - start, 1.0
        vertices = BOX * body + [start, 0.0, 0.0]
        set_properties(self.stretched, {"vertices": vertices.astype(np.float32)})
        edges = EDGES * size + [shapes.beam.delta + 0.5, 0.0, 0.0]
        set_properties(self.outline, {"points": edges.astype(np.float32)})


def place_of(x: float, units: Units | None) -> str:
    """A place along the beam in words."""
    return measure("beta", units).text(x, 4) if units else f"{x:.3f}"


def unit_body() -> tuple[np.ndarray, np.ndarray]:
    """Vertices (8, 3) and triangles (12, 3) of a straight beam as thick and broad as long."""
    ends = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    return tube.swept(ends, tube.NORMALS["chordwise"], 1.0, 1.0)


def reshape(body: MeshHandle, vertices: np.ndarray, faces: np.ndarray) -> None:
    """Give a mesh another surface, in one message: vertices without their faces are none."""
    shape = {"vertices": vertices.astype(np.float32)}
    if len(faces) != len(body.faces):
        shape["faces"] = faces.astype(np.uint32)
    set_properties(body, shape)


def unit_edges() -> np.ndarray:
    """The twelve edges (12, 2, 3) of a unit box around the origin."""
    corners = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    return np.array(
        [(a, b) for a in corners for b in corners if (b - a).sum() == 1 and (a != b).sum() == 1]
    )


EDGES = unit_edges()
BOX, SIDES = unit_body()


class Nodes:
    """A collar and a label at each vibration node: a place of the beam that stays still."""

    def __init__(self, api: SceneApi, root: str, colour: colours.RGB = colours.NODE):
        self.piece = np.zeros(0, int)  # on which pieces of the beam they are
        self.share = np.zeros((0, 1))  # and how far along each
        self.count = 0  # of the labels that are seen
        self.collars = add_bodies(api, f"{root}/wheel/nodes", MAX_NODES, box())
        self.collars.batched_colors = colours.instanced(
            np.tile(np.array(colour) / 255, (MAX_NODES, 1))
        )
        self.labels = [
            api.add_label(
                f"{root}/wheel/node {k}",
                "",
                anchor="top-center",
                font_size_mode="scene",
                visible=False,
            )
            for k in range(MAX_NODES)
        ]

    def show(
        self,
        shapes: Shapes,
        section: tuple[float, float],
        shown: list[int],
        *,
        labels: bool = True,
        scale: float = SCALE,
    ) -> None:
        """Mark the nodes of the modes `shown` (0-based), at most MAX_NODES of them; a length of
        the beam takes `scale` pixels."""
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
        height = min(max(LETTERS / scale, SMALLEST), CROWDED / max(len(marks), 1))
        for k, (label, x, place) in enumerate(marks):
            self.labels[k].font_scene_height = height
            points, normal = placed(shapes, place[None])
            across = np.abs(tube.crosswise(normal))
            scales[k] = [0.007, 0.0, 0.0] + 1.3 * (
                section[0] * across + section[1] * np.abs(normal)
            )
            self.labels[k].text = f"{label} node at {place_of(x, shapes.beam.units)}"
            set_position(self.labels[k], points[0] - [0.0, 0.0, scales[k][2] / 2 + 0.05])
        set_properties(self.collars, {"batched_scales": scales})
        count = len(marks) if labels else 0
        for k in range(min(count, self.count), max(count, self.count)):
            self.labels[k].visible = k < count
        self.count = count

    def move(self, points: np.ndarray, wxyz: np.ndarray) -> None:
        """Put the collars on the line of `points` (n, 3), turned as its pieces are, wxyz
        (n - 1, 4)."""
        piece, share = self.piece, self.share
        if not piece.size:
            return
        turns, centres = np.zeros((MAX_NODES, 4), np.float32), np.zeros((MAX_NODES, 3), np.float32)
        turns[:, 0] = 1.0
        turns[: len(share)] = wxyz[piece]
        centres[: len(share)] = (1 - share) * points[piece] + share * points[piece + 1]
        set_properties(self.collars, {"batched_positions": centres, "batched_wxyzs": turns})
