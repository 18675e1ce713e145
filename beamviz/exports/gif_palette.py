"""The 256 colours of a GIF, one palette for all of its frames so that nothing flickers.

The colours are the means of groups of colours of some frames, as in k-means. There are few groups
at first; those whose colours are farthest from their mean are divided. A colour counts by a power
of its number of pixels: so the many shades of a soft shadow have means enough that no steps are
seen, and small areas keep their colours.
"""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from scipy.spatial import cKDTree

SIZE = 256
POWER = 0.7  # with 0.5 shades of a shadow differ by 1.1 levels from theirs, with 0.7 by 0.8
FIRST, GROWTH = 16, 3  # groups at first; a GROWTH-th of them is divided at a time
ROUNDS = 3  # of k-means after each division
CHANNELS = np.array([1 << 16, 1 << 8, 1], np.uint32)


class Palette:
    """The colours (up to 256, 3) of some frames in RGB, 0 .. 255."""

    def __init__(self, sample: Iterable[Image.Image]):
        pixels = np.concatenate([np.asarray(frame) for frame in sample])
        colours, _, counts = distinct(pixels)
        self.colours = np.rint(means_of(colours, counts**POWER)).astype(np.uint8)
        self.tree = cKDTree(self.colours)

    def indexed(self, frame: Image.Image) -> Image.Image:
        """A frame in the nearest of these colours."""
        colours, place, _ = distinct(np.asarray(frame))
        nearest = self.tree.query(colours)[1].astype(np.uint8)
        picture = Image.fromarray(nearest[place].reshape(frame.size[::-1]))
        picture.putpalette(self.colours.tobytes())
        return picture


def distinct(pixels: NDArray) -> tuple[NDArray, NDArray, NDArray]:
    """The different colours (n, 3) of pixels (h, w, 3), the number of its colour for each pixel
    (h w,), and how many pixels have each."""
    packed = pixels.reshape(-1, 3).astype(np.uint32) @ CHANNELS
    packed, place, counts = np.unique(packed, return_inverse=True, return_counts=True)
    return packed[:, None] // CHANNELS % 256, place, counts


def means_of(colours: NDArray, weights: NDArray) -> NDArray:
    """The means (up to 256, 3) of groups of colours (n, 3) with weights (n,)."""
    means = colours[np.argsort(-weights)[:FIRST]].astype(float)
    while True:
        for _ in range(ROUNDS):
            _, group = cKDTree(means).query(colours)
            total = np.bincount(group, weights)
            sums = [np.bincount(group, weights * channel) for channel in colours.T]
            means = np.transpose(sums)[total > 0] / total[total > 0, None]
        if len(means) == SIZE:
            return means
        distance, group = cKDTree(means).query(colours)
        apart = weights * distance**2
        most = min(max(len(means) // GROWTH, 1), SIZE - len(means))
        divided = np.argsort(-np.bincount(group, apart))[:most]
        farthest = [int(np.argmax(np.where(group == number, apart, 0.0))) for number in divided]
        if not (more := [k for k in farthest if apart[k] > 0]):
            return means
        means = np.concatenate([means, colours[more]])
