"""The beam as a body: where to cut it, and its surface along a centreline in space."""

import numpy as np
from scipy.integrate import cumulative_trapezoid, trapezoid

SEGMENTS = 128


def stations(x: np.ndarray, curvature: np.ndarray, mass: float) -> np.ndarray:
    """Where to cut the beam: SEGMENTS + 1 points of 0 .. 1, closer where it bends more.

    x, curvature: (n,) samples along the beam; the point nearest to `mass` is moved onto it,
    since the stretch may jump there. Half of the points are spread evenly.
    """
    density = 1.0 + curvature / max(trapezoid(curvature, x), 1e-12)
    share = cumulative_trapezoid(density, x, initial=0.0)
    points = np.interp(np.linspace(0.0, share[-1], SEGMENTS + 1), share, x)
    points[0], points[-1] = 0.0, 1.0
    if 0.0 < mass < 1.0:
        points[1 + np.argmin(np.abs(points[1:-1] - mass))] = mass
    return points


def frame(centreline: np.ndarray, plane: str) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 2) in the plane of motion as (n, 3) in space, and the normal of that plane.

    Across the beam is y (the plane of rotation) chordwise and z (along the axis) flapwise.
    """
    zero = np.zeros(len(centreline))
    along, across = centreline.T
    if plane == "chordwise":
        return np.stack([along, across, zero], 1), np.array([0.0, 0.0, 1.0])
    return np.stack([along, zero, across], 1), np.array([0.0, -1.0, 0.0])


def tangents(points: np.ndarray) -> np.ndarray:
    """Unit tangents (n, 3) of a polyline (n, 3)."""
    step = np.gradient(points, axis=0)
    return step / np.linalg.norm(step, axis=1, keepdims=True)


def swept(
    points: np.ndarray, normal: np.ndarray, thickness: float, breadth: float
) -> tuple[np.ndarray, np.ndarray]:
    """The closed surface of a rectangular section swept along `points` (n, 3).

    `thickness` lies in the plane of motion, `breadth` along its `normal`.
    Returns vertices (4 n, 3) and triangles (8 n - 4, 3), facing outwards.
    """
    side = np.cross(normal, tangents(points)) * thickness / 2
    up = normal * breadth / 2
    corners = np.stack(
        [points + side + up, points - side + up, points - side - up, points + side - up], 1
    )
    ring = np.arange(4)
    first = 4 * np.arange(len(points) - 1)[:, None] + ring  # (n - 1, 4)
    second = 4 * np.arange(len(points) - 1)[:, None] + np.roll(ring, -1)
    walls = np.stack([first, second, second + 4, first, second + 4, first + 4], -1)
    last = 4 * (len(points) - 1)
    caps = [(0, 2, 1), (0, 3, 2), (last, last + 1, last + 2), (last, last + 2, last + 3)]
    return corners.reshape(-1, 3), np.concatenate([walls.reshape(-1, 3), caps])


def segments(
    points: np.ndarray, normal: np.ndarray, thickness: float, breadth: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The same surface as one unit box for each of the n - 1 pieces, so that each has a colour.

    Returns centres (n - 1, 3), orientations wxyz (n - 1, 4) and sizes (n - 1, 3). Each box is
    longer by what closes the wedge to its neighbours on the outside of a bend.
    """
    step = np.diff(points, axis=0)
    along, across = np.array([1.0, 0.0, 0.0]), np.cross(normal, [1.0, 0.0, 0.0])
    turn = np.unwrap(np.arctan2(step @ across, step @ along))
    wedge = np.zeros(len(points))
    bend = np.minimum(np.abs(np.diff(turn)), 1.0)  # a folded piece gets no endless wedge
    wedge[1:-1] = np.tan(bend / 2) * thickness / 2
    length = np.linalg.norm(step, axis=1) + wedge[:-1] + wedge[1:]
    sizes = length[:, None] * along + thickness * np.abs(across) + breadth * np.abs(normal)
    wxyz = np.concatenate([np.cos(turn / 2)[:, None], np.sin(turn / 2)[:, None] * normal], 1)
    return (points[:-1] + points[1:]) / 2, wxyz, sizes
