"""What a page would draw of a scene, as triangles, lines, captions and lights."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from viser import SceneApi
from viser.transforms import SO3

from beamviz.drawing import colours
from beamviz.server.viser_private import VisibleNode, visible_nodes

LEVEL = 0.99  # vertical component of the normal of the top of the floor


@dataclass(frozen=True)
class Triangles:
    """corners and normals at them: (t, 3, 3); albedo: (t, 3), linear light; opacity: (t,); casts:
    whether it casts a shadow, (t,); double: whether it is seen from behind too, (t,)."""

    corners: np.ndarray
    normals: np.ndarray
    albedo: np.ndarray
    opacity: np.ndarray
    casts: np.ndarray
    double: np.ndarray

    def part(self, which: np.ndarray) -> "Triangles":
        """Some of them."""
        return Triangles(*(values[which] for values in vars(self).values()))


@dataclass
class Geometry:
    """All that is visible of a scene at one moment.

    lines: ends (n, 2, 3), colour (3,), linear, and thickness [pixels]; points: of frames, by name;
    lights: unit vectors (3,) towards them and their colour (3,), linear; ambient: (3,), linear.
    """

    triangles: Triangles
    lines: list[tuple[np.ndarray, np.ndarray, float]] = field(default_factory=list)
    points: dict[str, np.ndarray] = field(default_factory=dict)
    lights: list[tuple[np.ndarray, np.ndarray]] = field(default_factory=list)
    ambient: np.ndarray = field(default_factory=lambda: np.zeros(3))
    sun: np.ndarray | None = None  # the direction to the light that casts shadows
    floor: VisibleNode | None = None  # the cylinder whose top shows shadows and is no triangle


def geometry(scene: SceneApi) -> Geometry:
    """What a page would show of a scene now."""
    parts: list[Triangles] = []
    found = Geometry(triangles=None)  # type: ignore[arg-type]  # set below
    for node in visible_nodes(scene):
        props, place = node.props, node.rotation
        if node.kind == "BatchedMeshesProps":
            parts.append(instances(node))
        elif node.kind in SOLIDS:
            corners, normals = SOLIDS[node.kind](props)
            if node.kind == "CylinderProps" and props.receive_shadow:
                found.floor = node
                below = normals[:, 0, 2] < LEVEL
                corners, normals = corners[below], normals[below]
            moved = corners @ place.T + node.position
            parts.append(triangles(props, moved, normals @ place.T, linear(props.color)))
        elif node.kind == "LineSegmentsProps":
            ends = props.points @ place.T + node.position
            found.lines.append((ends, linear(props.colors.reshape(-1, 3)[0]), props.thickness))
        elif node.kind == "FrameProps":
            found.points[node.name] = node.position
        elif node.kind == "HemisphereLightProps":  # at the origin, so the same from everywhere
            both = linear(props.sky_color) + linear(props.ground_color)
            found.ambient = found.ambient + props.intensity * both / 2
        elif node.kind == "DirectionalLightProps":
            towards = node.position / np.linalg.norm(node.position)
            found.lights.append((towards, props.intensity * linear(props.color)))
            found.sun = towards if props.cast_shadow else found.sun
        elif node.kind:
            raise NotImplementedError(f"pictures have no {node.kind}")
    columns = zip(*(vars(part).values() for part in parts), strict=True)
    found.triangles = Triangles(*map(np.concatenate, columns))
    return found


def linear(rgb: Any) -> np.ndarray:
    """sRGB bytes (3,) as linear light."""
    return colours.linear(np.asarray(rgb) / 255)


def triangles(
    props: Any, corners: np.ndarray, normals: np.ndarray, albedo: np.ndarray
) -> Triangles:
    """Triangles with the material of a node."""
    count = len(corners)
    return Triangles(
        corners,
        normals,
        np.broadcast_to(albedo, (count, 3)),
        np.full(count, 1.0 if props.opacity is None else props.opacity),
        np.full(count, props.cast_shadow),
        np.full(count, props.side == "double" and not hasattr(props, "batched_scales")),
    )


def instances(node: VisibleNode) -> Triangles:
    """The triangles of all instances that have a size."""
    props = node.props
    shown = props.batched_scales.max(axis=1) > 1e-6
    corners, normals = mesh(props)
    wxyz = props.batched_wxyzs[shown].astype(float)
    turned = node.rotation @ SO3(wxyz).as_matrix()  # (n, 3, 3)
    scale = props.batched_scales[shown].astype(float)[:, None, None]
    at = props.batched_positions[shown] @ node.rotation.T + node.position
    moved = (corners * scale[:, None]).reshape(len(scale), 3 * len(corners), 3) @ turned.transpose(
        0, 2, 1
    )
    moved = (moved + at[:, None]).reshape(-1, 3, 3)
    directions = (normals.reshape(-1, 3) @ turned.transpose(0, 2, 1)).reshape(-1, 3, 3)
    albedo = np.repeat(props.batched_colors[shown] / 255, len(corners), axis=0)
    return triangles(props, moved, directions, albedo)


Corners = tuple[np.ndarray, np.ndarray]  # (t, 3, 3) and the normals there


def mesh(props: Any) -> Corners:
    """A mesh, flat: what is round is a cylinder."""
    corners = props.vertices[props.faces].astype(float)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    return corners, np.repeat(normals[:, None], 3, axis=1)


def cylinder(props: Any) -> Corners:
    """A cylinder around the z axis, round but for its edges."""
    angle = 2 * np.pi * np.arange(props.radial_segments) / props.radial_segments
    rim = np.stack([np.cos(angle), np.sin(angle), 0 * angle], 1)
    up = np.array([0.0, 0.0, 1.0])
    high = props.radius * rim + props.height / 2 * up
    low, middle = high - props.height * up, np.broadcast_to(props.height / 2 * up, high.shape)
    (high2, low2, rim2) = (np.roll(part, -1, axis=0) for part in (high, low, rim))
    faces = [(middle, high, high2), (-middle, low2, low), (high, low, low2), (high, low2, high2)]
    corners = np.concatenate([np.stack(face, 1) for face in faces])
    ups = np.broadcast_to(up, (len(rim), 3, 3))
    sides = np.stack([rim, rim, rim2], 1), np.stack([rim, rim2, rim2], 1)
    return corners, np.concatenate([ups, -ups, *sides])


SOLIDS = {"MeshProps": mesh, "CylinderProps": cylinder}
