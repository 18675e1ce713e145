"""Triangles to samples of a picture, in numpy: the same on every machine."""

from typing import NamedTuple

import numpy as np

NEAR = 0.02  # distance from the camera from which on everything is drawn
STRIDE = 0.381966  # of the sample offsets, the golden section: neighbouring rows differ by much
SLACK = 1e-5  # of a triangle's size: no sample on the edge between two triangles is in neither
CENTRE = np.array([[0.5, 0.5]])


def sample_offsets(count: int) -> np.ndarray:
    """Offsets (count, 2) of the samples of a pixel: all different in x and in y (N rooks), so that
    an edge of any direction is as smooth as with count x count samples on a grid."""
    order = np.argsort(np.arange(count) * STRIDE % 1)
    return (np.stack([order, np.arange(count)], 1) + 0.5) / count


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


class Cover(NamedTuple):
    """Pairs (n,) of a triangle and a pixel that it may touch."""

    triangle: np.ndarray
    row: np.ndarray
    column: np.ndarray

    def part(self, which: np.ndarray) -> "Cover":
        """Some of them."""
        return Cover(*(values[which] for values in self))


def cover(places: np.ndarray, width: int, height: int) -> Cover:
    """The pixels that triangles (t, 3, 2), x and y in pixels, may touch: row by row from the left
    to the right end of the edges there."""
    y = places[..., 1]
    rows = np.floor(y.min(axis=1)), np.floor(y.max(axis=1)) + 1
    triangle, row = ranges(*(end.clip(0, height).astype(np.int32) for end in rows))
    left, right = np.full((2, len(row)), np.inf)
    for k in range(3):  # the edges
        first, step = places[:, k], places[:, k - 1] - places[:, k]
        rise = np.where(step[:, 1] == 0, 1e-9, step[:, 1])
        up = (row - first[triangle, 1]) / rise[triangle]
        down = up + (1 / rise)[triangle]
        beside = (np.maximum(up, down) < 0) | (np.minimum(up, down) > 1)  # not in this row
        for share in (up, down):
            x = first[triangle, 0] + share.clip(0, 1) * step[triangle, 0]
            left = np.where(beside, left, np.minimum(left, x))
            right = np.where(beside, right, np.minimum(right, -x))
    ends = left.clip(0, width), (1 - right).clip(0, width)
    line, column = ranges(*(end.astype(np.int32) for end in ends))
    return Cover(triangle[line], row[line], column)


def at_pixels(
    places: np.ndarray, values: np.ndarray, covered: Cover
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Linear functions with values (t, 3, k) at the corners (t, 3, 2) of triangles, at the upper
    left corners of pixels, and their derivatives in x and y: (k, n) each."""
    tables = planes(places - places[:, :1], values).transpose(1, 2, 0)
    value, dx, dy = np.take(np.ascontiguousarray(tables, np.float32), covered.triangle, axis=2)
    x, y = np.take(np.ascontiguousarray(places[:, 0].T, np.float32), covered.triangle, axis=1)
    value += dx * (covered.column.astype(np.float32) - x)
    value += dy * (covered.row.astype(np.float32) - y)
    return value, dx, dy


class Samples(NamedTuple):
    """The samples (n,) in triangles: the pair of a cover, the number of the sample in its pixel,
    and the inverse distance, which is linear in the picture."""

    pair: np.ndarray
    number: np.ndarray
    depth: np.ndarray


def samples(triangles: np.ndarray, covered: Cover, offsets: np.ndarray) -> Samples:
    """Which samples at `offsets` (s, 2) of the pixels are in triangles (t, 3, 3), x and y in pixels
    and the inverse distance."""
    barycentric = np.broadcast_to(np.eye(3)[:, 1:], (len(triangles), 3, 2))
    values = np.concatenate([barycentric, triangles[..., 2:]], -1)
    value, dx, dy = at_pixels(triangles[..., :2], values, covered)
    x, y = offsets.astype(np.float32).T[..., None]
    b, c, depth = value[:, None] + dx[:, None] * x + dy[:, None] * y  # (s, n)
    inside = np.flatnonzero((b > -SLACK) & (c > -SLACK) & (b + c < 1 + SLACK)).astype(np.int32)
    number, pair = np.divmod(inside, np.int32(len(covered.row)))
    return Samples(pair, number, depth.reshape(-1)[inside])


def ranges(start: np.ndarray, stop: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The integers of n ranges start .. stop - 1, one after the other, and the range of each."""
    lengths = stop - start
    owner = np.repeat(np.arange(len(start), dtype=np.int32), lengths)
    shift = (start - np.cumsum(lengths) + lengths).astype(np.int32)
    return owner, np.arange(len(owner), dtype=np.int32) + np.repeat(shift, lengths)


def planes(places: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Coefficients (t, 3, k) of 1, x and y of the linear functions with values (t, 3, k) at the
    corners (t, 3, 2) of triangles; nan for a triangle without an area."""
    (ux, uy), (vx, vy) = (places[:, 1] - places[:, 0]).T, (places[:, 2] - places[:, 0]).T
    area = ux * vy - uy * vx
    area = np.where(np.abs(area) < 1e-12, np.nan, area)[:, None]
    u, v = values[:, 1] - values[:, 0], values[:, 2] - values[:, 0]
    dx = (u * vy[:, None] - v * uy[:, None]) / area
    dy = (v * ux[:, None] - u * vx[:, None]) / area
    constant = values[:, 0] - dx * places[:, 0, :1] - dy * places[:, 0, 1:]
    return np.stack([constant, dx, dy], 1)
