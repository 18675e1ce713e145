"""Triangles drawn in numpy: the same picture on every machine.

Corners are homogeneous: (x w, y w, w) at the place x, y [pixels] and the distance w, so that
triangles that reach behind the camera need no clipping. A pixel has `count` samples, one in each of
as many rows, all at different x (N rooks): an edge of any direction is as smooth as with
count x count samples on a grid.
"""

import numpy as np

NEAR = 0.02  # distance from the camera up to which a triangle may be anywhere in the picture
STRIDE = 0.381966  # of the offsets of samples, the golden section: neighbours differ by much
SLACK = 1e-4  # [pixels]: no sample on the edge between two triangles is in neither
CONTRAST = np.uint32(0xF8F8F8F8)  # bits of four bytes whose difference can be seen
SMALL = 1e-6  # in place of a divisor that may be 0


def samples(
    corners: np.ndarray, drawn: np.ndarray, count: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The samples of the pixels `drawn` (h, w) that are in triangles (t, 3, 3): the triangle, the
    place in an array (pixels drawn, count), and 1 / w of each."""
    (height, width), (a, b, c) = drawn.shape, corners.transpose(1, 2, 0)
    # Functions of (x, y, 1) that are 0 on an edge, and 1 / w at the opposite corner: (3, 3, t).
    edges = np.stack([np.cross(*pair, axis=0) for pair in ((b, c), (c, a), (a, b))], 1)
    volume = (a * edges[:, 0]).sum(axis=0)
    seen = np.flatnonzero(np.abs(volume) > 1e-12)
    edges, w = edges[..., seen] / volume[seen], corners[seen, :, 2].T
    y = count * corners[seen, :, 1].T / w - 0.5
    anywhere = w.min(axis=0) < NEAR
    rows = np.where(anywhere, 0, y.min(axis=0)), np.where(anywhere, count * height, y.max(axis=0))
    top, end = bounded(rows, count * height)
    face, row = ranges(top, end)
    slope, rise, constant = edges
    with np.errstate(divide="ignore", invalid="ignore"):  # x of each edge in the first row
        edge = np.array([-(constant + rise * (top + 0.5) / count), -rise / count]) / slope
    down, ends = (row - top[face]).astype(np.float32), []
    for side in (1, -1):  # left and right ends of rows
        none = np.array([-side * np.inf, 0.0])[:, None, None]
        limits = side * np.where(side * slope > 0, edge, none)
        first, step = np.take(limits.astype(np.float32), face, axis=2)
        ends.append(side * (first + step * down).max(axis=0))
    order = np.argsort(np.arange(count) * STRIDE % 1)
    offset = ((order + 0.5) / count).astype(np.float32)[row % count]
    start, stop = bounded((ends[0] - offset - SLACK, ends[1] - offset + SLACK), width)
    places = np.insert(drawn.cumsum(dtype=np.int32), 0, 0)
    first = row // count * width
    line, place = ranges(places[first + start], places[first + stop])
    row = row[line]
    x = np.flatnonzero(drawn)[place] % width + offset[line]
    face = face[line]
    slope, rise, constant = np.take(edges.sum(axis=1), face, axis=1)
    depth = slope * x + rise * ((row + 0.5) / count) + constant
    return seen[face], place * count + row % count, depth.astype(np.float32)


def bounded(ends: tuple[np.ndarray, np.ndarray], size: int) -> tuple[np.ndarray, np.ndarray]:
    """Start and stop of the whole numbers between two ends, of those in 0 .. size - 1."""
    start, last = np.ceil(ends[0]).clip(0, size), np.floor(ends[1]).clip(-1, size - 1)
    return start.astype(np.int32), np.maximum(last + 1, start).astype(np.int32)


def ranges(start: np.ndarray, stop: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The range of each of the integers of n ranges start .. stop - 1, one after the other, and
    these integers."""
    lengths = stop - start
    owner = np.repeat(np.arange(len(start), dtype=np.int32), lengths)
    shift = (start - np.cumsum(lengths) + lengths).astype(np.int32)
    return owner, np.arange(len(owner), dtype=np.int32) + shift[owner]


def draw(
    shown: np.ndarray, pixels: np.ndarray, corners: np.ndarray, colours: np.ndarray, count: int
) -> None:
    """Draw some `pixels` (h, w) of a picture (h, w, 4) in bytes, of triangles (t, 3, 3) with
    colours (t, 4), multiplied by their opacity, and `count` samples of each pixel."""
    triangle, slot, depth = samples(corners, pixels, count)
    solid = (colours[:, 3] == 1)[triangle]
    nearest = np.zeros(count * np.count_nonzero(pixels), np.float32)
    result = np.zeros((len(nearest), 4), np.float32)
    for part in (solid, ~solid):  # translucent ones over the others
        found = np.flatnonzero(part & (depth >= nearest[slot]))
        np.maximum.at(nearest, slot[found], depth[found])
        found = found[nearest[slot[found]] == depth[found]]
        at, colour = slot[found], np.take(colours, triangle[found], axis=0)
        result[at] = colour if part is solid else colour + (1 - colour[:, 3:]) * result[at]
    touched = np.flatnonzero(nearest.reshape(-1, count).any(axis=1))
    mean = result.reshape(-1, count, 4)[touched].mean(axis=1)
    mean[:, :3] /= np.maximum(mean[:, 3:], SMALL)
    shown.reshape(-1, 4)[np.flatnonzero(pixels)[touched]] = np.rint(255 * mean)


def edges(shown: np.ndarray) -> np.ndarray:
    """Where a picture (h, w, 4) in bytes differs visibly from a neighbouring pixel: (h, w)."""
    visible, found = shown.view(np.uint32)[..., 0] & CONTRAST, np.zeros(shown.shape[:2], bool)
    for axis in (0, 1):
        differ = visible != np.roll(visible, 1, axis)
        found |= differ | np.roll(differ, -1, axis)
    return found
