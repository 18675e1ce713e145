"""Triangles and lines to samples of a picture, in numpy: the same on every machine.

A pixel has `count` samples, each in a row of its own and all at different x (N rooks), so that an
edge of any direction is as smooth as with count x count samples on a grid.
"""

from typing import NamedTuple

import numpy as np

NEAR = 0.02  # distance from the camera from which on everything is drawn
STRIDE = 0.381966  # of the sample offsets, the golden section: neighbouring rows differ by much


def sample_offsets(count: int) -> np.ndarray:
    """Offsets (count,) in x of the samples of a pixel: all different and evenly spread."""
    order = np.argsort(np.arange(count) * STRIDE % 1)
    return (order + 0.5) / count


def clipped(corners: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The part of triangles (t, 3, 3), x y z in the camera's axes, beyond z = NEAR, with values
    (t, 3, k) at the corners; and the index of each new triangle's original."""
    inside = corners[..., 2] > NEAR
    count = inside.sum(axis=1)
    whole = np.flatnonzero(count == 3)
    both = np.concatenate([corners, values], -1)
    parts, origins = [both[whole]], [whole]
    for left in (1, 2):  # corners that are left
        cut = np.flatnonzero(count == left)
        if len(cut):
            lone = (inside[cut] == (left == 1)).argmax(axis=1)  # the corner on a side of its own
            turned = both[cut[:, None], (lone[:, None] + np.arange(3)) % 3]
            z = turned[..., 2:3]
            share = (NEAR - z[:, :1]) / (z[:, 1:] - z[:, :1])
            ends = turned[:, :1] + share * (turned[:, 1:] - turned[:, :1])
            b, c = ends[:, 0], ends[:, 1]
            if left == 1:
                new = [np.stack([turned[:, 0], b, c], 1)]
            else:
                new = [np.stack([b, turned[:, 1], turned[:, 2]], 1)]
                new += [np.stack([b, turned[:, 2], c], 1)]
            parts += new
            origins += [cut] * len(new)
    both = np.concatenate(parts)
    return both[..., :3], both[..., 3:], np.concatenate(origins)


class Spans(NamedTuple):
    """Lines of samples through triangles, n of them: owner: the triangle; row: counted in samples;
    start, stop: columns [pixels]; shift: the offset of the samples in x."""

    owner: np.ndarray
    row: np.ndarray
    start: np.ndarray
    stop: np.ndarray
    shift: np.ndarray


def spans(places: np.ndarray, width: int, height: int, count: int) -> Spans:
    """The samples of triangles (t, 3, 2), x and y in pixels, row by row: of the part of a triangle
    above its middle corner, and of the part below."""
    corners = np.take_along_axis(places, places[..., 1:].argsort(axis=1), axis=1)
    x, y = corners[..., 0], corners[..., 1] * count
    first, second = [0, 1, 0], [1, 2, 2]  # corners of an edge: the last one bounds both parts
    rise = y[:, second] - y[:, first]
    slant = (x[:, second] - x[:, first]) / np.where(rise == 0, np.inf, rise)
    base = x[:, first] + slant * (0.5 - y[:, first])
    left = x[:, 1] < base[:, 2] + slant[:, 2] * (y[:, 1] - 0.5)  # the middle corner
    ends = np.ceil(y.clip(0, height * count) - 0.5).astype(np.int32)
    part, row = ranges(ends[:, :2].ravel(), ends[:, 1:].ravel())
    shift = sample_offsets(count)[row % count]
    edges = [np.where(side[:, None], [0, 1], 2) for side in (left, ~left)]  # of both parts
    bases, slants = (
        [np.take_along_axis(v, e, 1).ravel()[part] for e in edges] for v in (base, slant)
    )
    start, stop = (
        np.ceil(b + s * row - shift).clip(0, width).astype(np.int32)
        for b, s in zip(bases, slants, strict=True)
    )
    owner = part // 2
    return Spans(owner, row, start, stop, shift)


def rasterised(triangles: np.ndarray, nearest: np.ndarray) -> tuple[Spans, np.ndarray, np.ndarray]:
    """The samples at which triangles (t, 3, 3) are seen, x and y in pixels and the inverse
    distance, which is linear in the picture: all lines, and the line and column of each sample.

    nearest: (height, count, width), for every sample the bits of the inverse distance of what is
    nearest, as a float, and behind them its line; the triangles are added.
    """
    height, count, width = nearest.shape
    places = triangles[..., :2]
    lines = spans(places, width, height, count)
    line, column = ranges(lines.start, lines.stop)
    constant, dx, dy = planes(places, triangles[..., 2:])[..., 0].T
    constant = constant[lines.owner] + dx[lines.owner] * lines.shift
    constant += dy[lines.owner] * ((lines.row + 0.5) / count)
    depth = dx.astype(np.float32)[lines.owner][line] * column.astype(np.float32)
    depth += constant.astype(np.float32)[line]
    place = (lines.row.astype(np.int64) * width)[line] + column
    key = depth.view(np.uint32).astype(np.uint64) << 32 | line.astype(np.uint64)
    np.maximum.at(nearest.reshape(-1), place, key)
    kept = np.flatnonzero(nearest.reshape(-1)[place] == key)
    return lines, line[kept], column[kept]


def ranges(start: np.ndarray, stop: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The integers of n ranges start .. stop - 1, one after the other, and the range of each."""
    lengths = stop - start
    owner = np.repeat(np.arange(len(start), dtype=np.int32), lengths)
    shift = (start - np.cumsum(lengths) + lengths).astype(np.int32)
    return owner, np.arange(len(owner), dtype=np.int32) + np.repeat(shift, lengths)


def planes(places: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Coefficients (t, 3, k) of 1, x and y of the linear functions with values (t, 3, k) at the
    corners (t, 3, 2) of triangles."""
    (ux, uy), (vx, vy) = (places[:, 1] - places[:, 0]).T, (places[:, 2] - places[:, 0]).T
    area = ux * vy - uy * vx
    area = np.where(np.abs(area) < 1e-12, np.inf, area)[:, None]
    u, v = values[:, 1] - values[:, 0], values[:, 2] - values[:, 0]
    dx = (u * vy[:, None] - v * uy[:, None]) / area
    dy = (v * ux[:, None] - u * vx[:, None]) / area
    constant = values[:, 0] - dx * places[:, 0, :1] - dy * places[:, 0, 1:]
    return np.stack([constant, dx, dy], 1)
