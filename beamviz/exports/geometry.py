"""What a page would draw of a scene, as triangles, lines and points."""

from typing import Any

import numpy as np
import trimesh
from viser import SceneApi
from viser.transforms import SO3

from beamviz.drawing.colours import linear
from beamviz.server.viser_private import VisibleNode, visible_nodes

CYLINDER = np.array(trimesh.creation.cylinder(1.0, 1.0, sections=160).triangles)  # looks round


class Geometry:
    """All that a page would show of a scene now. Colours are linear light.

    corners: of triangles (t, 3, 3); normals: outwards (t, 3); colours: (t, 4), with opacity;
    casts: whether each casts a shadow (t,); lines: ends (n, 2, 3), colour (3,) and thickness
    [pixels]; points: of frames, by name; floor: the cylinder whose top shows shadows and is none of
    the triangles.
    """

    def __init__(self, scene: SceneApi):
        self.lines: list[tuple[np.ndarray, np.ndarray, float]] = []
        self.points: dict[str, np.ndarray] = {}
        self.floor: VisibleNode | None = None
        parts = []
        for node in visible_nodes(scene):
            props, corners = node.props, None
            match node.kind:
                case "BatchedMeshesProps":
                    corners, colour = instances(props)
                case "MeshProps":
                    corners, colour = props.vertices[props.faces], linear(props.color)
                    if props.side == "double":
                        corners = np.concatenate([corners, corners[:, ::-1]])
                case "CylinderProps":
                    size = [props.radius, props.radius, props.height]
                    corners, colour = CYLINDER * size, linear(props.color)
                    if props.receive_shadow:
                        self.floor, corners = node, corners[corners[..., 2].min(axis=1) < 0]
                case "LineSegmentsProps":
                    ends = props.points @ node.rotation.T + node.position
                    colour = linear(props.colors.reshape(-1, 3)[0])
                    self.lines.append((ends, colour, props.thickness))
                case "FrameProps":
                    self.points[node.name] = node.position
                case "" | "HemisphereLightProps" | "DirectionalLightProps":  # the root; see LIGHTS
                    pass
                case kind:
                    raise NotImplementedError(f"pictures have no {kind}")
            if corners is not None:
                opacity = 1.0 if props.opacity is None else props.opacity
                rgba = np.full((len(corners), 4), opacity, float)
                rgba[:, :3] = colour
                placed = corners @ node.rotation.T + node.position
                parts.append((placed, rgba, np.full(len(corners), props.cast_shadow)))
        self.corners, self.colours, self.casts = map(np.concatenate, zip(*parts, strict=True))
        self.normals = trimesh.unitize(trimesh.triangles.cross(self.corners))


def instances(props: Any) -> tuple[np.ndarray, np.ndarray]:
    """The triangles of all instances, and their colours."""
    axes = SO3(props.batched_wxyzs.astype(float)).as_matrix()
    sized = props.vertices[props.faces].reshape(-1, 3) * props.batched_scales[:, None]
    corners = sized @ axes.mT + props.batched_positions[:, None]
    colour = np.repeat(props.batched_colors / 255, len(props.faces), axis=0)
    return corners.reshape(-1, 3, 3), colour
