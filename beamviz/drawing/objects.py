"""The objects on the beam: bodies, reference shapes and nodes."""

from collections.abc import Iterable
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray

from beamviz.blade import Mass
from beamviz.drawing import beam_mesh, colours
from beamviz.drawing.beam_mesh import NORMALS, extents, normals, to_hub_frame
from beamviz.drawing.modes import SampledModes
from beamviz.drawing.scene_graph import DrawnScene, Node
from beamviz.drawing.sizes import box_size, collar_size, drawn_bodies, has_box
from beamviz.drawing.text import measure

CHAMFER = 0.1  # of a box, over its size


def collar() -> trimesh.Trimesh:
    """A collar of unit length and radius along the x axis, with chamfered edges."""
    outline = np.array([(0, -0.5), (0.9, -0.5), (1, -0.4), (1, 0.4), (0.9, 0.5), (0, 0.5)])
    ring = trimesh.creation.revolve(outline, sections=64)
    ring.vertices = ring.vertices[:, [2, 0, 1]]
    return ring


def chamfered_box() -> trimesh.Trimesh:
    """A box of unit size with chamfered edges."""
    inner = 1 - 2 * CHAMFER
    cube = trimesh.creation.box().vertices
    corners = [cube * np.where(np.arange(3) == axis, 1.0, inner) for axis in range(3)]
    return trimesh.convex.convex_hull(np.concatenate(corners))


def tube() -> trimesh.Trimesh:
    """A box of unit size without its ends along x, which would stick out at a bend."""
    box = trimesh.creation.box()
    box.update_faces(np.abs(box.face_normals[:, 0]) < 0.5)
    return box


def add_instances(
    scene: DrawnScene,
    name: str,
    mesh: trimesh.Trimesh,
    count: int = 1,
    opacity: float | None = None,
    *,
    hollow: bool = False,
) -> Node:
    """Add a node of instances of a mesh, each with position, orientation, size and colour; all four
    set in one message change their number. Browsers draw such nodes one frame late: all objects
    that move with the beam are of this kind. hollow: their inside is seen."""
    wxyz, zeros = np.tile([1.0, 0.0, 0.0, 0.0], (count, 1)), np.zeros((count, 3))
    sizes: Any = {"batched_scales": zeros, "batched_colors": zeros.astype(np.uint8)}
    side = "front" if opacity is None and not hollow else "double"
    look: Any = {"side": side, "lod": "off", "flat_shading": True, "receive_shadow": False}
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
RING = (0.007, 1.3)  # [beam lengths] of a node along the beam; its size over that of the section
EQUILIBRIUM_SIZE = 0.97  # of the equilibrium, whose faces do not coincide with the beam's
LABEL_GAP = 0.03  # [beam lengths] of a body from its label


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


def equilibrium_body(shapes: SampledModes, section: NDArray) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (v, 3) and triangles (t, 3) of the beam in equilibrium, with sections
    (n - 1, 2, 2)."""
    points, normal = to_hub_frame(shapes, shapes.centreline)
    if is_prism(shapes) and not shapes.centreline[:, 1].any():
        points, section = points[[0, -1]], section[:1]
        normal = normal if normal.ndim == 1 else normal[[0, -1]]
    return beam_mesh.swept(points, normal, EQUILIBRIUM_SIZE * section)


def is_prism(shapes: SampledModes) -> bool:
    """Whether all sections of the undeformed beam are alike."""
    return shapes.beam.blade is None and not (shapes.plane == "both" and shapes.beam.twist)


class ReferenceShapes:
    """The outline of the undeformed beam, and a translucent body of the equilibrium.

    outlined: points, normal and sections of the outline, which most edits leave as they are: to
    compute and send it takes an eighth of a frame.
    """

    def __init__(self, scene: DrawnScene, root: str):
        self.scene, self.outlined = scene, np.zeros(0)
        name, edges = f"{root}/rotor/undeformed", np.zeros((12, 2, 3))
        thin: Any = {"thickness": 1.2, "thickness_units": "screen"}
        self.outline = scene.add_line_segments(name, edges, colours.GHOST, **thin)
        ghost: Any = {"color": colours.GHOST, "opacity": 0.1}
        self.equilibrium = add_mesh(scene, f"{root}/rotor/equilibrium", **ghost)

    def show(self, shapes: SampledModes, section: NDArray, *, visible: bool) -> None:
        self.outline.visible = self.equilibrium.visible = visible
        if visible:
            set_surface(self.scene, self.equilibrium, *equilibrium_body(shapes, section))
            x = np.array([0.0, 1.0]) if is_prism(shapes) else shapes.x
            points, normal = np.outer(x, [1.0, 0.0, 0.0]), normals(shapes, x)
            points[:, 0] += shapes.beam.delta
            section = section[: len(x) - 1]
            outlined = np.concatenate([points.ravel(), normal.ravel(), section.ravel()])
            if not np.array_equal(outlined, self.outlined):
                self.outlined = outlined
                self.outline.points = beam_mesh.outline(points, normal, section)


class Nodes:
    """A ring and a caption at each node of the modes shown."""

    def __init__(self, scene: DrawnScene, root: str, colour: colours.RGB = colours.NODE):
        self.scene = scene
        self.at = self.x = np.zeros(0)  # positions of the nodes, and of the ends of pieces
        self.piece = np.zeros(0, int)  # the piece of the beam of each node
        self.size, self.colour = np.zeros((0, 3)), colours.instanced([colour])  # of rings
        self.rings = add_instances(scene, f"{root}/rotor/nodes", trimesh.creation.box())
        self.captions = [Caption(scene, f"{root}/rotor/node {k}", "top") for k in range(MAX_NODES)]

    def show(
        self,
        shapes: SampledModes,
        section: NDArray,
        shown: list[int],
        *,
        labels: bool = True,
        below: float = 0.0,
    ) -> None:
        """Mark the nodes of the modes `shown` (0-based), at most MAX_NODES of them; below: [beam
        lengths] the room between the beam and its labels for something else."""
        marks = [(shapes.labels[k], float(at)) for k in shown for at in shapes.nodes[k]][:MAX_NODES]
        self.at, self.x = np.array([at for _, at in marks]), shapes.x
        self.piece = np.searchsorted(self.x[1:-1], self.at, side="right")
        here = section[self.piece].mean(axis=1)
        self.size = [RING[0], 0.0, 0.0] + RING[1] * extents(here, NORMALS[shapes.plane])
        self.rings.visible = bool(marks)
        still, _ = to_hub_frame(shapes, shapes.centreline)
        places = self.on_beam(still)
        places[:, 2] -= self.size[:, 2] / 2 + 0.03 + below
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
            placed = {"batched_positions": self.on_beam(points), "batched_wxyzs": wxyz[self.piece]}
            placed |= {
                "batched_scales": self.size,
                "batched_colors": np.tile(self.colour, (count, 1)),
            }
            self.scene.set_properties(self.rings, **placed)


MAX_LABELS = 20


class Bodies:
    """The bodies on the beam: those with inertia are boxes, the others collars. With several, each
    has a label.

    shown: `drawn_bodies` of the beam; numbers: which of them the instances of `collars` and of
    `boxes` are.
    """

    def __init__(self, scene: DrawnScene, root: str, opacity: float | None = None):
        self.scene = scene
        self.collars = add_instances(scene, f"{root}/rotor/mass", collar(), opacity=opacity)
        self.boxes = add_instances(scene, f"{root}/rotor/boxes", chamfered_box(), opacity=opacity)
        self.captions = [
            Caption(scene, f"{root}/rotor/body {k}", "bottom") for k in range(MAX_LABELS)
        ]
        self.shown: tuple[Mass, ...] = ()
        self.at = np.zeros(0, int)  # stations of the bodies
        self.sizes, self.colour = np.zeros((0, 3)), np.zeros((1, 3), np.uint8)
        self.above = np.zeros((0, 3))  # from each body to its label
        self.numbers: tuple[list[int], list[int]] = [], []

    @property
    def nodes(self) -> tuple[Node, Node]:
        """Those of the collars and of the boxes."""
        return self.collars, self.boxes

    def show(
        self,
        shapes: SampledModes,
        colour: colours.RGB,
        *,
        thicken: bool,
        inset: float = 1.0,
        labels: bool = True,
    ) -> None:
        """Show the bodies of a beam in a colour; inset: relative size."""
        beam, plane = shapes.beam, shapes.plane
        self.shown, self.at = drawn_bodies(beam), np.array(shapes.bodies, int)
        self.colour = colours.instanced([colour])
        sizes = []
        for body in self.shown:
            if has_box(body):
                sizes.append(box_size(beam, body, thicken, plane))
            else:
                length, radius = collar_size(beam, body, thicken, plane)
                sizes.append((length, radius, radius))
        self.sizes = inset * np.reshape(sizes, (-1, 3))
        boxed = [has_box(body) for body in self.shown]
        collars, boxes = (
            [k for k, box in enumerate(boxed) if box == kind] for kind in (False, True)
        )
        self.numbers = collars, boxes
        self.collars.visible, self.boxes.visible = bool(collars), bool(boxes)
        halves = self.sizes[:, 2] * np.where(boxed, 0.5, 1.0)
        self.above = np.outer(halves + LABEL_GAP, [0.0, 0.0, 1.0])
        mass = measure("alpha", beam.units)
        texts = [mass.text(body.alpha, 4) for body in self.shown] if labels and beam.masses else []
        for k, caption in enumerate(self.captions):
            caption.text = texts[k] if k < len(texts) else ""

    def move(self, points: np.ndarray, wxyz: np.ndarray) -> None:
        """Move the bodies onto the line through `points` (n, 3), its pieces oriented by wxyz."""
        for node, numbers in zip(self.nodes, self.numbers, strict=True):
            if numbers:
                at = self.at[numbers]
                self.scene.set_properties(
                    node,
                    batched_positions=points[at],
                    batched_wxyzs=wxyz[np.minimum(at, len(wxyz) - 1)],
                    batched_scales=self.sizes[numbers],
                    batched_colors=np.tile(self.colour, (len(numbers), 1)),
                )
        for caption, place in zip(self.captions, points[self.at] + self.above, strict=False):
            if caption.text:
                self.scene.set_pose(caption.point, position=place)

    def places(self) -> tuple[NDArray, NDArray]:
        """Positions (k, 3) and orientations wxyz (k, 4) of the bodies, as moved last."""
        positions, wxyzs = np.zeros((len(self.shown), 3)), np.zeros((len(self.shown), 4))
        for node, numbers in zip(self.nodes, self.numbers, strict=True):
            if numbers:
                positions[numbers], wxyzs[numbers] = node.batched_positions, node.batched_wxyzs
        return positions, wxyzs

    def meshes(self) -> list[tuple[Node, NDArray]]:
        """The node and the size (3,) of each of the bodies."""
        return [
            (self.boxes if has_box(body) else self.collars, size)
            for body, size in zip(self.shown, self.sizes, strict=True)
        ]

    def number(self, node: Node, instance: int | None) -> int | None:
        """Which of `shown` an instance of one of the nodes is; None if it is not shown any more."""
        collars, boxes = self.numbers
        numbers = boxes if node.name == self.boxes.name else collars
        return numbers[instance] if instance is not None and instance < len(numbers) else None
