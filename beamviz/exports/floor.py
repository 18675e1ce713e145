"""The round floor below a beam, and the soft shadow on it.

points: a matrix (3, 3) from a place (x, y, 1) in a picture [pixels] to the point of the floor that
is seen there, in homogeneous coordinates; the last one is negative below the horizon.
"""

import numpy as np
from PIL import Image, ImageFilter

from beamviz.exports.geometry import Geometry
from beamviz.exports.rasteriser import cover, sample_offsets, samples

LINES = 8  # of samples in a pixel, for the edge of the floor
SHADOW_CELLS = 320  # of the larger side of a shadow
SHADOW_SAMPLES = 3
SHADOW_BLUR = 0.014  # [lengths of the beam] standard deviation


def covered_by_disc(points: np.ndarray, radius: float, size: tuple[int, int]) -> Image.Image:
    """The share of each pixel that a disc around the origin covers, in bytes, where the horizon is
    level: between the roots of a x^2 + 2 b x + c on lines of samples."""
    width, height = size
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
        np.add.at(steps, (row, column), sign * (1 - (x - column)))
        np.add.at(steps, (row, column + 1), sign * (x - column))
    return Image.fromarray((steps[:, :width].cumsum(axis=1) * (255 / LINES)).astype(np.uint8))


def shadow(
    scene: Geometry, centre: np.ndarray, points: np.ndarray, size: tuple[int, int], darkness: float
) -> Image.Image:
    """The shadow, of a darkness 0 .. 1, on the level of `centre` (3,), the origin of the points, as
    bytes in a picture of a size; none without a light that casts one."""
    bodies, sun = scene.triangles, scene.sun
    if sun is None:
        return Image.new("L", size)
    lit = bodies.casts & ((bodies.normals @ sun).mean(axis=1) > 0)
    corners = bodies.corners[lit] - centre
    fallen = (corners - corners[..., 2:] / sun[2] * sun)[..., :2]
    corner = fallen.min(axis=(0, 1)) - 4 * SHADOW_BLUR
    extent = fallen.max(axis=(0, 1)) + 4 * SHADOW_BLUR - corner
    cell = float(extent.max()) / SHADOW_CELLS
    columns, rows = (extent / cell).astype(int) + 2
    placed = np.insert((fallen - corner) / cell, 2, 1.0, axis=2)
    touched = cover(placed[..., :2], columns, rows)
    pair, number, _ = samples(placed, touched, sample_offsets(SHADOW_SAMPLES))
    covered = np.zeros((SHADOW_SAMPLES, rows, columns), np.float32)
    covered[number, touched.row[pair], touched.column[pair]] = 255 * darkness
    means = covered.mean(axis=0).astype(np.uint8)
    soft = Image.fromarray(means).filter(ImageFilter.GaussianBlur(SHADOW_BLUR / cell))
    matrix = np.array([[1, 0, -corner[0]], [0, 1, -corner[1]], [0, 0, cell]]) @ points
    data = (matrix / matrix[2, 2]).ravel()[:8].tolist()
    return soft.transform(size, Image.Transform.PERSPECTIVE, data, Image.Resampling.BILINEAR)
