"""The objects on the beam: mass, reference shapes and nodes, and their sizes."""

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
import trimesh

from beamviz.beam import Beam
from beamviz.drawing import beam_mesh, colours
from beamviz.drawing.beam_mesh import EDGES, NORMALS, Section, extents, to_hub_frame
from beamviz.drawing.modes import SampledModes
from beamviz.drawing.scene_graph import DrawnScene, Node
from beamviz.drawing.text import measure

VISIBLE_THICKNESS = 0.04
COLLAR_LENGTH = 0.9  # over its radius, unless the mass is too small for that
COLLAR_HEIGHT = 0.62  # least radius, over the diagonal of the section that it encloses


def section_size(beam: Beam, thicken: bool = False) -> Section:
    """Thickness in the plane of motion, h = sqrt(12) / mu of a rectangle, and breadth along its
    normal, which the five numbers do not determine."""
    thickness = max(math.sqrt(12) / beam.mu, VISIBLE_THICKNESS if thicken else 0.0)
    return thickness, min(max(1.5 * thickness, 0.05), 0.1)


def mass_size(beam: Beam, thicken: bool = False) -> tuple[float, float]:
    """Length and radius of the mass, a collar around the beam with the density of the beam: its
    volume is alpha times that of the beam."""
    section = section_size(beam, thicken)
    inside = math.prod(section)  # area of the hole
    volume = beam.alpha * inside
    radius = max(
        (volume / (COLLAR_LENGTH * math.pi)) ** (1 / 3), COLLAR_HEIGHT * math.hypot(*section)
    )
    return volume / (math.pi * radius**2 - inside), radius


def collar() -> trimesh.Trimesh:
    """A collar of unit length and radius along the x axis, with chamfered edges."""
    outline = np.array([(0, -0.5), (0.9, -0.5), (1, -0.4), (1, 0.4), (0.9, 0.5), (0, 0.5)])
    ring = trimesh.creation.revolve(outline, sections=64)
    ring.vertices = ring.vertices[:, [2, 0, 1]]
    return ring


def add_instances(
    scene: DrawnScene,
    name: str,
    mesh: trimesh.Trimesh,
    count: int = 1,
    opacity: float | None = None,
) -> Node:
    """Add a node of instances of a mesh, each with position, orientation, size and colour; all four
    set in one message change their number. Browsers draw such nodes one frame late: all objects
    that move with the beam are of this kind."""
    wxyz, zeros = np.tile([1.0, 0.0, 0.0, 0.0], (count, 1)), np.zeros((count, 3))
    sizes: Any = {"batched_scales": zeros, "batched_colors": zeros.astype(np.uint8)}
    look: Any = {"side": "double", "lod": "off", "flat_shading": True, "receive_shadow": False}
    look |= {"opacity": opacity, "cast_shadow": opacity is None}
    return scene.add_batched_meshes_simple(
        name, mesh.vertices, mesh.faces, wxyz, zeros, **sizes, **look
    )


ENDS = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])  # of a beam of unit size
BOX, SIDES = beam_mesh.swept(ENDS, NORMALS["chordwise"], (1.0, 1.0))


def add_mesh(
    scene: DrawnScene,
    name: str,
    vertices: np.ndarray = BOX,
    faces: np.ndarray = SIDES,
    **options: Any,
) -> Node:
    """Add a mesh, without shadows unless `options` say otherwise; by default a box."""
    usual = {"flat_shading": True, "cast_shadow": False, "receive_shadow": False}
    return scene.add_mesh_simple(name, vertices, faces, **usual | options)


def set_surface(scene: DrawnScene, node: Node, vertices: np.ndarray, faces: np.ndarray) -> None:
    """Set vertices (v, 3) and triangles (t, 3) of a mesh, in one message so that they match."""
    changed = {"faces": faces} if len(faces) != len(node.faces) else {}
    scene.set_properties(node, vertices=vertices, **changed)


MAX_NODES = 10


class Caption:
    """A text at a point of the scene, which the page writes over the scene, as viser's labels have
    neither its font nor its colours; anchor: the side of the text at the point."""

    def __init__(self, scene: DrawnScene, name: str, anchor: str = "center"):
        self.scene, self.point = scene, scene.add_frame(name, show_axes=False)
        self.anchor, self.text = anchor, ""

    def show(self, text: str, position: Iterable[float]) -> None:
        """Show a text at a point (3,) in the parent frame; "" hides it."""
        self.text = text
        if text:
            self.scene.set_pose(self.point, position=position)

    @property
    def data(self) -> dict[str, str]:
        return {"name": self.point.name, "text": self.text, "anchor": self.anchor}


def equilibrium_body(shapes: SampledModes, section: Section) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (v, 3) and triangles (t, 3) of the beam in equilibrium."""
    inner = (0.97 * section[0], 0.97 * section[1])  # its faces do not coincide with the beam's
    points, normal = to_hub_frame(shapes, shapes.centreline)
    stations = slice(None) if shapes.centreline[:, 1].any() else slice(None, None, len(points) - 1)
    return beam_mesh.swept(points[stations], normal, inner)


class ReferenceShapes:
    """The outline of the undeformed beam, and a translucent body of the equilibrium."""

    def __init__(self, scene: DrawnScene, root: str):
        self.scene = scene
        name, edges = f"{root}/rotor/undeformed", np.zeros((12, 2, 3))
        thin: Any = {"thickness": 1.2, "thickness_units": "screen"}
        self.outline = scene.add_line_segments(name, edges, colours.GHOST, **thin)
        ghost: Any = {"color": colours.GHOST, "opacity": 0.1}
        self.equilibrium = add_mesh(scene, f"{root}/rotor/equilibrium", **ghost)

    def show(self, shapes: SampledModes, section: Section, *, visible: bool) -> None:
        self.outline.visible = self.equilibrium.visible = visible
        if visible:
            set_surface(self.scene, self.equilibrium, *equilibrium_body(shapes, section))
            corners, _ = beam_mesh.swept(*to_hub_frame(shapes, ENDS), section)
            self.outline.points = corners[EDGES]


class Nodes:
    """A ring and a caption at each node of the modes shown."""

    def __init__(self, scene: DrawnScene, root: str, colour: colours.RGB = colours.NODE):
        self.scene = scene
        self.at = self.x = np.zeros(0)  # positions of the nodes, and of the ends of pieces
        self.piece = np.zeros(0, int)  # the piece of the beam of each node
        self.size, self.colour = np.zeros(3), colours.instanced([colour])  # of a ring
        self.rings = add_instances(scene, f"{root}/rotor/nodes", trimesh.creation.box())
        self.captions = [Caption(scene, f"{root}/rotor/node {k}", "top") for k in range(MAX_NODES)]

    def show(
        self, shapes: SampledModes, section: Section, shown: list[int], *, labels: bool = True
    ) -> None:
        """Mark the nodes of the modes `shown` (0-based), at most MAX_NODES of them."""
        marks = [(shapes.labels[k], float(at)) for k in shown for at in shapes.nodes[k]][:MAX_NODES]
        self.at, self.x = np.array([at for _, at in marks]), shapes.x
        self.piece = np.searchsorted(self.x[1:-1], self.at, side="right")
        self.size = [0.007, 0.0, 0.0] + 1.3 * extents(section, NORMALS[shapes.plane])
        self.rings.visible = bool(marks)
        still, _ = to_hub_frame(shapes, shapes.centreline)
        places = self.on_beam(still) - [0.0, 0.0, self.size[2] / 2 + 0.03]
        units = shapes.beam.units
        for caption in self.captions:
            caption.text = ""
        for caption, (mode, at_x), place in zip(self.captions, marks, places, strict=False):
            position = measure("beta", units).text(at_x, 4) if units else f"{at_x:.3f}"
            caption.show(f"{mode} node at {position}" if labels else "", place)

    def on_beam(self, points: np.ndarray) -> np.ndarray:
        """The nodes (j, 3) on the line through `points` (n, 3)."""
        return np.stack([np.interp(self.at, self.x, axis) for axis in points.T], 1)

    def move(self, points: np.ndarray, wxyz: np.ndarray) -> None:
        """Move the rings onto the line through `points` (n, 3), its pieces oriented by wxyz."""
        if count := len(self.piece):
            sizes, paint = np.tile(self.size, (count, 1)), np.tile(self.colour, (count, 1))
            placed = {"batched_positions": self.on_beam(points), "batched_wxyzs": wxyz[self.piece]}
            self.scene.set_properties(
                self.rings, **placed, batched_scales=sizes, batched_colors=paint
            )
