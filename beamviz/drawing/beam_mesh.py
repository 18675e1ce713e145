"""The beam as a body: its stations, and its surface along a centreline in space."""

import numpy as np
from scipy.integrate import cumulative_trapezoid, trapezoid

FINE = 600
CLOSE = 1e-9  # to an end of the beam: nobody sees the mass beside it
NORMALS = {"chordwise": np.array([0.0, 0.0, 1.0]), "flapwise": np.array([0.0, -1.0, 0.0])}


def stations(x: np.ndarray, curvature: np.ndarray, mass: float) -> np.ndarray:
    """Where to sample the beam: FINE + 1 points of 0 .. 1, closer where it bends more.

    x, curvature: (n,) samples along the beam; the point nearest to `mass` is moved onto it,
    since the stretch may jump there. Half of the points are spread evenly.
    """
    density = 1.0 + curvature / max(trapezoid(curvature, x), 1e-12)
    share = cumulative_trapezoid(density, x, initial=0.0)
    points = np.interp(np.linspace(0.0, share[-1], FINE + 1), share, x)
    points[0], points[-1] = 0.0, 1.0
    if CLOSE < mass < 1.0 - CLOSE:
        points[1 + np.argmin(np.abs(points[1:-1] - mass))] = mass
    return points


def frame(centreline: np.ndarray, plane: str) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 2) in the plane of motion as (n, 3) in space, and the normal of that plane.

    Across the beam is y (the plane of rotation) chordwise and z (along the axis) flapwise.
    """
    points = np.zeros((len(centreline), 3))
    points[:, 0] = centreline[:, 0]
    points[:, 1 if plane == "chordwise" else 2] = centreline[:, 1]
    return points, NORMALS[plane]


def crosswise(normal: np.ndarray) -> np.ndarray:
    """The direction (3,) across a straight beam in the plane of motion: normal x (1, 0, 0)."""
    return np.array([0.0, normal[2], -normal[1]])


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
    across = crosswise(normal)
    along, aside = points[1:, 0] - points[:-1, 0], (points[1:] - points[:-1]) @ across
    turn = np.arctan2(aside, along)
    bend = turn[1:] - turn[:-1]
    bend = np.abs(bend - 2 * np.pi * np.rint(bend / (2 * np.pi)))
    wedge = np.zeros(len(points))
    wedge[1:-1] = np.tan(np.minimum(bend, 1.0) / 2)  # a folded piece gets no endless wedge
    sizes = np.empty((len(turn), 3))
    sizes[:] = thickness * np.abs(across) + breadth * np.abs(normal)
    sizes[:, 0] = np.hypot(along, aside) + thickness / 2 * (wedge[:-1] + wedge[1:])
    wxyz = np.empty((len(turn), 4))
    wxyz[:, 0] = np.cos(turn / 2)
    wxyz[:, 1:] = np.sin(turn / 2)[:, None] * normal
    return (points[:-1] + points[1:]) / 2, wxyz, sizes
