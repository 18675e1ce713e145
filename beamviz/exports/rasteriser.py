"""Triangles and lines to samples of a picture, in numpy: the same on every machine.

A pixel has `count` samples, each in a row of its own and all at different x (N rooks), so that an
edge of any direction is as smooth as with count x count samples on a grid.
"""

from dataclasses import dataclass

import numpy as np

NEAR = 0.02  # distance from the camera from which on everything is drawn
STRIDE = 0.381966  # of the sample offsets, the golden section: neighbouring rows differ by much


@dataclass(frozen=True)
class Samples:
    """The samples (n,) at which a triangle is seen.

    pixel: its index, row by row; owner: of the triangle; x, y: of the sample [pixels]; depth:
    (height, count, width) the inverse distance at every sample of the picture, or 0.
    """

    pixel: np.ndarray
    owner: np.ndarray
    x: np.ndarray
    y: np.ndarray
    depth: np.ndarray


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


@dataclass(frozen=True)
class Spans:
    """Lines of samples through triangles, n of them: owner: the triangle; row: counted in samples;
    start, stop: columns [pixels]; shift: the offset of the samples in x."""

    owner: np.ndarray
    row: np.ndarray
    start: np.ndarray
    stop: np.ndarray
    shift: np.ndarray


def spans(places: np.ndarray, width: int, height: int, count: int) -> Spans:
    """The samples of triangles (t, 3, 2), x and y in pixels, row by row."""
    x, y = places[..., 0], places[..., 1] * count
    first, last = (
        np.ceil(edge.clip(0, height * count) - 0.5).astype(int)
        for edge in (y.min(axis=1), y.max(axis=1))
    )
    owner, row = ranges(first, last)
    centre = row + 0.5
    left, right = np.full(len(row), np.inf), np.full(len(row), -np.inf)
    for a, b in ((0, 1), (1, 2), (2, 0)):
        slant = (x[:, b] - x[:, a]) / np.where(y[:, b] == y[:, a], np.inf, y[:, b] - y[:, a])
        base, ya, yb = x[:, a] - slant * y[:, a], y[owner, a], y[owner, b]
        crossed = (ya <= centre) != (yb <= centre)
        at = base[owner] + slant[owner] * centre
        left = np.where(crossed, np.minimum(left, at), left)
        right = np.where(crossed, np.maximum(right, at), right)
    shift = sample_offsets(count)[row % count]
    start, stop = (np.ceil(edge.clip(-1, width + 1) - shift) for edge in (left, right))
    start, stop = (edge.clip(0, width).astype(np.int32) for edge in (start, stop))
    return Spans(owner, row.astype(np.int32), start, np.maximum(start, stop), shift)


def rasterised(
    triangles: np.ndarray,
    width: int,
    height: int,
    count: int,
    behind: np.ndarray | None = None,
) -> Samples:
    """Samples of triangles (t, 3, 3): x and y in pixels, and the inverse distance, which is linear
    in the picture; behind: the depth of an earlier layer, which hides what is farther."""
    order = np.argsort(triangles[..., 2].sum(axis=1), kind="stable")  # far ones first
    places = triangles[order, :, :2]
    lines = spans(places, width, height, count)
    lengths = lines.stop - lines.start
    line, column = ranges(lines.start, lines.stop)
    constant, dx, dy = planes(places, triangles[order, :, 2:])[lines.owner, :, 0].T
    constant = constant + dx * lines.shift + dy * (lines.row + 0.5) / count
    value = np.repeat(dx.astype(np.float32), lengths) * column.astype(np.float32)
    value += np.repeat(constant.astype(np.float32), lengths)
    place = np.repeat(lines.row.astype(np.int64) * width, lengths) + column
    nearest = np.zeros(width * height * count, np.float32)
    if behind is not None:
        nearest[:] = behind.ravel()
    shown = np.empty(width * height * count, np.int32)
    left = np.flatnonzero(value > nearest[place])
    while len(left):  # of several values at one place the last is kept, mostly the nearest
        nearest[place[left]] = value[left]
        shown[place[left]] = line[left]
        left = left[value[left] > nearest[place[left]]]
    kept = np.flatnonzero(value == nearest[place])
    kept = kept[shown[place[kept]] == line[kept]]
    place, line = place[kept], line[kept]
    row, column = lines.row[line], place % width
    return Samples(
        pixel=row // count * width + column,
        owner=order[lines.owner[line]],
        x=column + lines.shift[line],
        y=(row + 0.5) / count,
        depth=nearest.reshape(height, count, width),
    )


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
