"""Forces in the scene: a band below the beam, as high as the tension, and arrows on its pieces and
bodies.

The longest arrow of each kind has always the same length, and the band the same height where the
tension is greatest: what they stand for is in the legend.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray

from beamviz.beam import Beam
from beamviz.drawing import colours
from beamviz.drawing.beam_mesh import (
    NORMALS,
    DrawnBeam,
    bent,
    extents,
    orientations,
    segments,
)
from beamviz.drawing.forces import CORIOLIS, EULER, KINDS, PULL, SOFTENING, Forces, ForceSource
from beamviz.drawing.objects import Caption, add_instances, tube
from beamviz.drawing.scene_graph import DrawnScene, rotations
from beamviz.drawing.sizes import largest_height
from beamviz.drawing.text import force_text

BAND_HEIGHT, BAND_WIDTH = 0.1, 0.006  # [beam lengths]
GAP, ASIDE = 0.02, 0.05  # [beam lengths] between the beam, and band or arrows
# [beam lengths] of arrows on pieces of the beam, which reach to the next one, and on bodies.
LONGEST, LONGEST_ON_BODY = 0.11, 0.2
CLOSE = 1e-9  # [beam lengths] of two points at the same place
SHAFT, HEAD = 0.004, (0.03, 0.011)  # [beam lengths] radius; length and radius
HEAD_PART = 0.6  # of an arrow that is shorter
# [beam lengths] along the beam from the middle of a piece to its arrows: no two are on each other.
SHIFTS = {PULL: -0.03, SOFTENING: 0.0, CORIOLIS: -0.03, EULER: 0.03}


def along_x(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """A mesh along z, turned to x."""
    mesh.vertices = mesh.vertices[:, [2, 0, 1]]
    return mesh


def shaft() -> trimesh.Trimesh:
    """A cylinder of radius 1 from 0 to 1 on the x axis."""
    cylinder = trimesh.creation.cylinder(1.0, 1.0, sections=12)
    cylinder.vertices[:, 2] += 0.5
    return along_x(cylinder)


def head() -> trimesh.Trimesh:
    """A cone with a base of radius 1 at 0 and its tip at 1 on the x axis."""
    return along_x(trimesh.creation.cone(1.0, 1.0, sections=16))


def scales(largest: Mapping[str, tuple[float, float]]) -> dict[str, float]:
    """The lengths [beam lengths] of arrows of a unit force of each kind, of which the largest are
    given (see `ForceSource`)."""
    scales = {}
    for kind, (on_piece, on_body) in largest.items():
        lengths = [(LONGEST, on_piece), (LONGEST_ON_BODY, on_body)]
        scales[kind] = min(length / force for length, force in lengths if force > 0)
    return scales


class ForceArrows:
    """The band and the arrows of one beam."""

    def __init__(self, scene: DrawnScene, root: str):
        self.scene = scene
        self.band = add_instances(scene, f"{root}/rotor/tension", tube(), hollow=True)
        self.shafts = add_instances(scene, f"{root}/rotor/force shafts", shaft())
        self.heads = add_instances(scene, f"{root}/rotor/force heads", head())
        for node in (self.band, self.shafts, self.heads):
            node.cast_shadow = False
        self.caption = Caption(scene, f"{root}/rotor/tension text", "top")
        self.source: ForceSource | None = None

    def show(self, drawn: DrawnBeam, section: NDArray) -> None:
        """Show the forces on a beam, whose pieces have sections (n - 1, 2, 2), or none."""
        self.source = source = drawn.forces
        self.caption.text = ""
        if source is None:
            self.band.visible = self.shafts.visible = self.heads.visible = False
            return
        shapes = drawn.shapes
        beam, plane = shapes.beam, shapes.plane
        _, y, z = extents(section.max(axis=(0, 1)), NORMALS[plane]) / 2
        on_body = np.arange(len(source.pieces.x)) >= len(source.pieces.x) - source.pieces.bodies
        self.aside = np.where(on_body, max(y, largest_height(beam)), y)  # (k,) half the widths
        self.above = np.where(on_body, max(z, largest_height(beam)), z)
        self.below = z + GAP
        self.scales = scales(source.largest)
        self.kinds = [kind for kind in KINDS if kind in self.scales]
        paint = [colours.FORCES[kind] for kind in self.kinds]
        self.paint = np.repeat(colours.instanced(paint), len(on_body), axis=0) if paint else None
        self.band.visible = source.greatest_tension > 0
        self.shafts.visible = self.heads.visible = bool(self.kinds)
        if self.band.visible and source.at_root is not None:
            self.tell(beam, source.at_root)

    @property
    def depth(self) -> float:
        """How far down the band reaches [beam lengths]."""
        return GAP + BAND_HEIGHT if self.source and self.band.visible else 0.0

    def tell(self, beam: Beam, tension: float) -> None:
        """Say the tension at the root."""
        name = "tension" if tension > 0 else "compression"
        text = f"{name} at the root {force_text(abs(tension), beam.units)}"
        self.caption.show(text, (beam.delta + GAP, 0.0, -self.below - BAND_HEIGHT - GAP / 2))

    def move(self, x: NDArray, points: NDArray, forces: Forces | None) -> None:
        """Move band and arrows to the line through `points` (n, 3) at x (n,) of the beam, with the
        forces of a moment."""
        if self.source is None or forces is None:
            return
        if self.band.visible:
            self.move_band(on_line(self.source.band, x, points), forces.tension)
        if self.kinds:
            self.move_arrows(on_line(self.source.pieces.x, x, points), forces.on_pieces)

    def move_band(self, points: NDArray, tension: NDArray) -> None:
        """Hang the band below points (b, 3), with the tension (b,) there."""
        assert self.source
        steps = np.linalg.norm(np.diff(points, axis=0), axis=1) > CLOSE  # not between two at a body
        mean = (tension[:-1] + tension[1:])[steps] / 2
        line = points[np.append(True, steps)]
        tangents = np.gradient(line, axis=0)
        tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
        up = NORMALS["chordwise"]
        line = line - (self.below + BAND_HEIGHT / 2) * bent(np.tile(up, (len(line), 1)), tangents)
        centres, wxyz, sizes = segments(line, up, (BAND_WIDTH, BAND_HEIGHT))
        sizes[:, 2] = BAND_HEIGHT * np.abs(mean) / self.source.greatest_tension
        centres += rotations(wxyz)[:, :, 2] * (BAND_HEIGHT - sizes[:, 2:]) / 2
        paint = colours.instanced([colours.TENSION, colours.COMPRESSION])[(mean < 0).astype(int)]
        self.place(self.band, centres, wxyz, sizes, paint)

    def move_arrows(self, points: NDArray, on_pieces: Mapping[str, NDArray]) -> None:
        """Place the arrows of all kinds at points (k, 3), with the forces there."""
        starts, vectors = [], []
        for kind in self.kinds:
            force = self.scales[kind] * on_pieces[kind]
            vectors.append(np.stack([force.real, force.imag, 0 * force.real], 1))
            starts.append(points + self.offsets(kind, force))
        start, vector = np.concatenate(starts), np.concatenate(vectors)
        length = np.linalg.norm(vector, axis=1)
        ahead = np.where(length > 0, vector.T / np.maximum(length, 1e-300), [[1.0], [0.0], [0.0]]).T
        wxyz = orientations(ahead, np.zeros(len(ahead)), NORMALS["chordwise"])
        point = np.minimum(HEAD[0], HEAD_PART * length)
        wide = HEAD[1] * point / HEAD[0]
        thin = np.minimum(SHAFT, wide / 2)
        rod = length - point
        self.place(self.shafts, start, wxyz, np.stack([rod, thin, thin], 1), self.paint)
        tips = start + rod[:, None] * ahead
        self.place(self.heads, tips, wxyz, np.stack([point, wide, wide], 1), self.paint)

    def offsets(self, kind: str, force: NDArray) -> NDArray:
        """From the axis of the beam to the start of the arrows (k, 3) of forces (k,): of the pull
        above it, of Coriolis forces on the side y < 0, of the others at the side they point to."""
        offsets = np.zeros((len(force), 3))
        offsets[:, 0] = SHIFTS[kind]
        if kind == PULL:
            offsets[:, 2] = self.above + GAP
        elif kind == CORIOLIS:
            offsets[:, 1] = -self.aside - ASIDE
        else:
            offsets[:, 1] = np.copysign(self.aside, force.imag)
        return offsets

    def place(self, node: Any, at: NDArray, wxyz: NDArray, sizes: NDArray, paint: Any) -> None:
        """Place the instances of a node (k,)."""
        placed = {"batched_positions": at, "batched_wxyzs": wxyz, "batched_scales": sizes}
        self.scene.set_properties(node, **placed, batched_colors=paint)


def on_line(at: NDArray, x: NDArray, points: NDArray) -> NDArray:
    """The points (j, 3) at `at` (j,) of the line through `points` (n, 3) at x (n,)."""
    return np.stack([np.interp(at, x, axis) for axis in points.T], 1)
