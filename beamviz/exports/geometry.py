"""What a page would draw of a scene, as triangles, lines, points and lights."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import trimesh
from viser import SceneApi
from viser.transforms import SO3

from beamviz.drawing import colours
from beamviz.server.viser_private import VisibleNode, visible_nodes

LEVEL = 0.99  # vertical component of the normal of the top of the floor
Body = tuple[np.ndarray, np.ndarray, np.ndarray]  # corners, normals and albedo, see Triangles


class Triangles(NamedTuple):
    """corners and normals at them: (t, 3, 3); albedo: (t, 3), linear light; opacity: (t,); casts:
    whether it casts a shadow, (t,); double: whether it is seen from behind too, (t,)."""

    corners: np.ndarray
    normals: np.ndarray
    albedo: np.ndarray
    opacity: np.ndarray
    casts: np.ndarray
    double: np.ndarray


@dataclass(frozen=True)
class Geometry:
    """All that is visible of a scene at one moment.

    lines: ends (n, 2, 3), colour (3,), linear, and thickness [pixels]; points: of frames, by name;
    lights: unit vectors (3,) towards them and their colour (3,), linear; ambient: (3,), linear;
    sun: the direction to the light that casts shadows; floor: the cylinder whose top shows shadows
    and is none of the triangles.
    """

    triangles: Triangles
    lines: list[tuple[np.ndarray, np.ndarray, float]]
    points: dict[str, np.ndarray]
    lights: list[tuple[np.ndarray, np.ndarray]]
    ambient: np.ndarray
    sun: np.ndarray | None
    floor: VisibleNode | None


def geometry(scene: SceneApi) -> Geometry:
    """What a page would show of a scene now."""
    parts, lines, points, lights = [], [], {}, []
    ambient, sun, floor = np.zeros(3), None, None
    for node in visible_nodes(scene):
        props, body = node.props, None
        match node.kind:
            case "BatchedMeshesProps":
                body = instances(node)
            case "MeshProps":
                body = solid(node, *flat(props.vertices[props.faces].astype(float)))
            case "CylinderProps":
                corners, normals = cylinder(props.radius, props.height, props.radial_segments)
                if props.receive_shadow:
                    floor, below = node, normals[:, 0, 2] < LEVEL
                    corners, normals = corners[below], normals[below]
                body = solid(node, corners, normals)
            case "LineSegmentsProps":
                ends = props.points @ node.rotation.T + node.position
                colour = linear(props.colors.reshape(-1, 3)[0])
                lines.append((ends, colour, props.thickness))
            case "FrameProps":
                points[node.name] = node.position
            case "HemisphereLightProps":  # at the origin, so the same from everywhere
                both = linear(props.sky_color) + linear(props.ground_color)
                ambient = ambient + props.intensity * both / 2
            case "DirectionalLightProps":
                towards = node.position / np.linalg.norm(node.position)
                lights.append((towards, props.intensity * linear(props.color)))
                sun = towards if props.cast_shadow else sun
            case "":  # the root
                pass
            case kind:
                raise NotImplementedError(f"pictures have no {kind}")
        if body:
            opacity = 1.0 if props.opacity is None else props.opacity
            double = props.side == "double" and node.kind != "BatchedMeshesProps"
            material = (np.full(len(body[0]), x) for x in (opacity, props.cast_shadow, double))
            parts.append((*body, *material))
    triangles = Triangles(*map(np.concatenate, zip(*parts, strict=True)))
    return Geometry(triangles, lines, points, lights, ambient, sun, floor)


def linear(rgb: Any) -> np.ndarray:
    """sRGB bytes (3,) as linear light."""
    return colours.linear(np.asarray(rgb) / 255)


def solid(node: VisibleNode, corners: np.ndarray, normals: np.ndarray) -> Body:
    """The triangles of a body of one colour."""
    corners, normals = corners @ node.rotation.T + node.position, normals @ node.rotation.T
    return corners, normals, np.broadcast_to(linear(node.props.color), (len(corners), 3))


def instances(node: VisibleNode) -> Body:
    """The triangles of all instances that have a size."""
    props = node.props
    corners, normals = flat(props.vertices[props.faces].astype(float))
    shown = props.batched_scales.max(axis=1) > 1e-6
    axes = (node.rotation @ SO3(props.batched_wxyzs[shown].astype(float)).as_matrix()).mT
    scale = props.batched_scales[shown].astype(float)[:, None]
    at = props.batched_positions[shown] @ node.rotation.T + node.position
    corners = (corners.reshape(-1, 3) * scale) @ axes + at[:, None]
    normals = normals.reshape(-1, 3) @ axes
    albedo = np.repeat(props.batched_colors[shown] / 255, len(props.faces), axis=0)
    return corners.reshape(-1, 3, 3), normals.reshape(-1, 3, 3), albedo


def flat(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Flat triangles (t, 3, 3) and the normals at their corners."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    return corners, np.repeat(normals[:, None], 3, axis=1)


@lru_cache(32)
def cylinder(radius: float, height: float, sections: int) -> tuple[np.ndarray, np.ndarray]:
    """A cylinder around the z axis, round but for its edges: corners (t, 3, 3) and normals."""
    body = trimesh.creation.cylinder(radius, height, sections=sections)
    corners, normals = flat(np.asarray(body.triangles))
    return corners, np.where(
        np.abs(normals[..., 2:]) > LEVEL, normals, corners * [1, 1, 0] / radius
    )
