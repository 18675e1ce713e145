"""Triangles drawn in numpy: the same picture on every machine.

A cover is an array (3, n) of integers: triangle, row and column of the pixels that triangles touch.
"""

import numpy as np
from PIL import Image, ImageChops

NEAR = 0.02  # distance from the camera from which on everything is drawn
STRIDE = 0.381966  # of the sample offsets, the golden section: neighbouring rows differ by much
SLACK = 1e-5  # of a triangle's size: no sample on the edge between two triangles is in neither
CONTRAST = np.uint32(0xF8F8F8F8)  # bits of four bytes: of a difference that can be seen
SMALL = 1e-6  # in place of a divisor that may be 0


def sample_offsets(count: int) -> np.ndarray:
    """Offsets (count, 2) of the samples of a pixel: all different in x and in y (N rooks), so that
    an edge of any direction is as smooth as with count x count samples on a grid."""
    order = np.argsort(np.arange(count) * STRIDE % 1)
    return (np.stack([order, np.arange(count)], 1) + 0.5) / count


def clipped(corners: np.ndarray) -> np.ndarray:
    """The parts beyond z = NEAR of triangles (t, 3, 3 + k): x, y, z in the axes of the camera and
    further values at each corner."""
    inside = corners[..., 2] > NEAR
    count = inside.sum(axis=1)
    parts = [corners[count == 3]]
    for left in (1, 2):  # corners that are left
        cut = np.flatnonzero(count == left)
        lone = (inside[cut] == (left == 1)).argmax(axis=1)  # the corner on a side of its own
        order = (lone[:, None] + np.arange(3)) % 3
        a, b, c = corners[cut[:, None], order].transpose(1, 0, 2)
        ab, ac = (a + ((NEAR - a[:, 2]) / (d - a)[:, 2])[:, None] * (d - a) for d in (b, c))
        parts += [np.stack(new, 1) for new in ([(a, ab, ac)], [(ab, b, c), (ab, c, ac)])[left - 1]]
    return np.concatenate(parts)


def cover(places: np.ndarray, width: int, height: int) -> np.ndarray:
    """The pixels that triangles (t, 3, 2), x and y in pixels, may touch, as a cover: row by row
    from the left to the right end of the edges there."""
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
    return np.stack([triangle[line], row[line], column])


def at_pixels(places: np.ndarray, values: np.ndarray, covered: np.ndarray) -> np.ndarray:
    """Linear functions with values (t, 3, k) at the corners (t, 3, 2) of triangles: at the upper
    left corners of the pixels of a cover, and their derivatives in x and y, (3, k, n); nan for a
    triangle without an area."""
    (ux, uy), (vx, vy) = (places[:, 1] - places[:, 0]).T, (places[:, 2] - places[:, 0]).T
    area = ux * vy - uy * vx
    area[np.abs(area) < 1e-12] = np.nan
    first, u, v = values[:, 0].T, (values[:, 1] - values[:, 0]).T, (values[:, 2] - values[:, 0]).T
    tables = np.stack([first, (u * vy - v * uy) / area, (v * ux - u * vx) / area])
    triangle, row, column = covered
    found = np.take(tables.astype(np.float32), triangle, axis=2)
    x, y = np.take(np.ascontiguousarray(places[:, 0].T, np.float32), triangle, axis=1)
    found[0] += found[1] * (column.astype(np.float32) - x)
    found[0] += found[2] * (row.astype(np.float32) - y)
    return found


def samples(
    triangles: np.ndarray, covered: np.ndarray, count: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Which of the `count` samples of each pixel of a cover are in triangles (t, 3, 3), x and y in
    pixels and the inverse distance: for each its column in the cover, its number in the pixel and
    its inverse distance, which is linear in the picture."""
    barycentric = np.broadcast_to(np.eye(3)[:, 1:], (len(triangles), 3, 2))
    values = np.concatenate([barycentric, triangles[..., 2:]], -1)
    value, dx, dy = at_pixels(triangles[..., :2], values, covered)
    x, y = sample_offsets(count).astype(np.float32).T[..., None]
    b, c, depth = value[:, None] + dx[:, None] * x + dy[:, None] * y  # (s, n)
    inside = np.flatnonzero((b > -SLACK) & (c > -SLACK) & (b + c < 1 + SLACK)).astype(np.int32)
    number, pair = np.divmod(inside, np.int32(covered.shape[1]))
    return pair, number, depth.reshape(-1)[inside]


def ranges(start: np.ndarray, stop: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The range of each of the integers of n ranges start .. stop - 1, one after the other, and
    these integers."""
    lengths = stop - start
    owner = np.repeat(np.arange(len(start), dtype=np.int32), lengths)
    shift = (start - np.cumsum(lengths) + lengths).astype(np.int32)
    return owner, np.arange(len(owner), dtype=np.int32) + np.repeat(shift, lengths)


def draw(
    shown: np.ndarray, places: np.ndarray, colours: np.ndarray, covered: np.ndarray, count: int
) -> None:
    """Draw the pixels of a cover into a picture (h, w, 4) in bytes, from triangles (t, 3, 3) with
    colours (t, 3, 4) at their corners and `count` samples of each pixel."""
    height, width, _ = shown.shape
    pixel = covered[1] * width + covered[2]
    used = np.zeros(height * width, bool)
    used[pixel] = True
    where = np.flatnonzero(used)
    slots = np.zeros(height * width, np.int32)  # places of the pixels used in the arrays below
    slots[where] = np.arange(len(where))
    pair, number, depth = samples(places, covered, count)
    slot = number * len(where) + slots[pixel][pair]
    solid = (colours[:, 0, 3] == 1)[covered[0][pair]]
    colour, dx, dy = at_pixels(places[..., :2], colours, covered)
    colour += (dx + dy) / 2
    opacity, colour[3] = colour[3].copy(), 1.0
    nearest = np.zeros(count * len(where), np.float32)
    result = np.zeros((4, len(nearest)), np.float32)  # colours times opacity
    for part in (solid, ~solid):  # translucent ones over the others
        found = np.flatnonzero(part & (depth >= nearest[slot]))
        np.maximum.at(nearest, slot[found], depth[found])
        found = found[nearest[slot[found]] == depth[found]]
        of, at = pair[found], slot[found]
        alpha = opacity[of]
        for channel, value in zip(result, colour, strict=True):
            channel[at] = alpha * value[of] + (1 - alpha) * channel[at]
    mean = result.reshape(4, count, len(where)).mean(axis=1)
    mean[:3] /= np.maximum(mean[3], SMALL)
    shown.reshape(-1, 4)[where] = np.rint(255 * mean.clip(0, 1)).T


def edges(shown: np.ndarray) -> np.ndarray:
    """Where a picture (h, w, 4) in bytes differs visibly from a neighbouring pixel: (h, w)."""
    picture, found = Image.fromarray(shown), np.zeros(shown.shape[:2], bool)
    for axis, step in enumerate(((0, 1), (1, 0))):
        change = ImageChops.difference(picture, ImageChops.offset(picture, *step))
        differ = np.asarray(change).view(np.uint32)[..., 0] & CONTRAST > 0
        found |= differ | np.roll(differ, -1, axis)
    return found
