"""The round floor below a beam, and the soft shadow on it.

points: a matrix (3, 3) from a place (x, y, 1) in a picture [pixels] to the point of the floor that
is seen there, in homogeneous coordinates; the last one is negative below the horizon.
"""

import math
from collections.abc import Iterator

import numpy as np
from PIL import Image

from beamviz.exports.geometry import Geometry
from beamviz.exports.rasteriser import rasterised

LINES = 8  # of samples in a pixel, for the edge of the floor
SHADOW_CELLS = 320  # of the larger side of a shadow
SHADOW_SAMPLES = 3
SHADOW_BLUR = 0.014  # [lengths of the beam] standard deviation
Box = tuple[slice, slice]  # rows and columns


def covered_by_disc(points: np.ndarray, radius: float, width: int, height: int) -> np.ndarray:
    """The share (height, width) of each pixel that a disc around the origin covers, where the
    horizon is level: between the roots of a x^2 + 2 b x + c on lines of samples."""
    y = (np.arange(LINES * height) + 0.5) / LINES
    slope, constant = points[:2, 0], points[:, 1:2] * y + points[:, 2:]
    a, b = slope @ slope, slope @ constant[:2]
    c = (constant[:2] ** 2).sum(axis=0) - (radius * constant[2]) ** 2
    half = np.sqrt(np.where(constant[2] < 0, b * b - a * c, 0).clip(0))
    steps = np.zeros((height, width + 2), np.float32)  # of the share from pixel to pixel
    row = np.arange(LINES * height) // LINES
    for sign in (1, -1):
        x = ((-b - sign * half) / a).clip(0, width)
        column = x.astype(int)
        np.add.at(steps, (row, column), sign * (1 - (x - column)) / LINES)
        np.add.at(steps, (row, column + 1), sign * (x - column) / LINES)
    return steps[:, :width].cumsum(axis=1)


def shadow(
    scene: Geometry, centre: np.ndarray, points: np.ndarray, width: int, height: int
) -> Iterator[tuple[Box, np.ndarray]]:
    """The part of a picture with the shadow on the level of `centre` (3,), the origin of the
    points, and the darkness (h, w, 1) there; nothing without a light that casts one."""
    bodies, sun = scene.triangles, scene.sun
    if sun is None:
        return
    lit = bodies.casts & ((bodies.normals @ sun).mean(axis=1) > 0)
    corners = bodies.corners[lit] - centre
    fallen = (corners - corners[..., 2:] / sun[2] * sun)[..., :2]
    corner = fallen.min(axis=(0, 1)) - 4 * SHADOW_BLUR
    extent = fallen.max(axis=(0, 1)) + 4 * SHADOW_BLUR - corner
    size = float(extent.max()) / SHADOW_CELLS
    cells = np.zeros(
        (int(extent[1] / size) + 2, SHADOW_SAMPLES, int(extent[0] / size) + 2), np.uint64
    )
    rasterised(np.insert((fallen - corner) / size, 2, 1.0, axis=2), cells)
    covered = (cells > 0).mean(axis=1)
    rows, columns = (np.fft.fftfreq(n) for n in covered.shape)
    spread = 2 * (math.pi * SHADOW_BLUR / size) ** 2
    damped = np.fft.fft2(covered) * np.exp(-spread * (rows[:, None] ** 2 + columns**2))
    soft = Image.fromarray(np.fft.ifft2(damped).real.astype(np.float32))
    matrix = np.array([[1, 0, -corner[0]], [0, 1, -corner[1]], [0, 0, size]]) @ points
    ends = [[0, 0, 1], [soft.width, 0, 1], [0, soft.height, 1], [soft.width, soft.height, 1]]
    x, y, scale = np.linalg.inv(matrix) @ np.transpose(ends)
    left, top, right, bottom = 0, 0, width, height
    if (scale < 0).all() or (scale > 0).all():  # else the shadow passes below the camera
        (left, right), (top, bottom) = (
            np.array([(v / scale).min(), (v / scale).max() + 1]).clip(0, most).astype(int).tolist()
            for v, most in ((x, width), (y, height))
        )
    matrix @= np.array([[1, 0, left], [0, 1, top], [0, 0, 1]])
    data = (matrix / matrix[2, 2]).ravel()[:8].tolist()
    shape, bilinear = (right - left, bottom - top), Image.Resampling.BILINEAR
    if min(shape) > 0:
        seen = soft.transform(shape, Image.Transform.PERSPECTIVE, data, bilinear)
        yield (slice(top, bottom), slice(left, right)), np.asarray(seen)[..., None]
