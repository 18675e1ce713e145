"""The quantities of a map over two parameters: one frequency, or the smallest gap between two."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from scipy import ndimage

from beamviz.beam import check_int
from beamviz.errors import InvalidInput
from beamviz.sweeps.store import FAMILIES

LEAST_REGION = 0.03  # of the map: the smallest region that is named
SMOOTH = 0.7  # [columns and rows] by which borders are smoothed


class Quantity(NamedTuple):
    """A quantity over two parameters: values (rows, columns), nan where there is none; kinds (rows,
    columns): the family of the mode, or the modes of the gap and their families, as a code, -1
    where there is none; names: of the kinds, in lines."""

    name: str
    values: np.ndarray
    kinds: np.ndarray
    names: dict[int, str]

    @property
    def borders(self) -> Iterator[np.ndarray]:
        """For each kind, numbers (rows, columns) that are 1/2 at the borders of its regions."""
        kinds = np.unique(self.kinds[self.kinds >= 0]).tolist()
        for kind in kinds if len(kinds) > 1 else ():
            yield ndimage.gaussian_filter(
                (self.kinds == kind).astype(float), SMOOTH, mode="nearest"
            )

    @property
    def regions(self) -> Iterator[tuple[str, int, int]]:
        """The name, and the row and column of the middle, of each of the larger regions of one
        kind."""
        rows, columns = self.kinds.shape
        for kind in np.unique(self.kinds[self.kinds >= 0]).tolist():
            for share, row, column in connected(self.kinds == kind, (1 / rows, 1 / columns)):
                if share >= LEAST_REGION:
                    yield self.names[kind], row, column


def connected(mask: np.ndarray, size: tuple[float, float]) -> Iterator[tuple[float, int, int]]:
    """Of each connected region of a mask its share of the whole, and the row and column of its
    place farthest from the border. size: of a cell, down and across."""
    parts, count = ndimage.label(mask)
    for part in (parts == number for number in range(1, count + 1)):
        inside = ndimage.distance_transform_edt(np.pad(part, 1), sampling=size)[1:-1, 1:-1]
        row, column = np.unravel_index(inside.argmax(), inside.shape)
        yield float(part.mean()), int(row), int(column)


def frequency_of(mode: int, frequency: np.ndarray, family: np.ndarray) -> Quantity:
    """The frequency of a mode (1 is the lowest); frequency, family: (rows, columns, modes)."""
    check_int("mode", mode, 1, frequency.shape[-1])
    values, kinds = frequency[..., mode - 1], family[..., mode - 1].astype(int)
    kinds = np.where(np.isfinite(values), kinds, -1)
    return Quantity(f"frequency of mode {mode}", values, kinds, dict(enumerate(FAMILIES)))


def smallest_gap(frequency: np.ndarray, family: np.ndarray, families: bool = True) -> Quantity:
    """The smallest gap between neighbouring frequencies (rows, columns, modes); its kinds are the
    two modes and, with `families`, theirs."""
    if frequency.shape[-1] < 2:
        raise InvalidInput("the sweep has one mode: a gap needs two, as with modes=5")
    gaps = np.diff(frequency, axis=-1)
    gaps[~np.isfinite(gaps)] = np.inf
    lower = gaps.argmin(axis=-1)[..., None]
    smallest = np.take_along_axis(gaps, lower, -1)[..., 0]
    known = np.isfinite(smallest)
    pair = (np.take_along_axis(family.astype(int), lower + side, -1)[..., 0] for side in (0, 1))
    first, second = np.sort(np.stack(list(pair)), axis=0) if families else (0, 0)
    base = len(FAMILIES)
    codes = np.where(known, (lower[..., 0] * base + first) * base + second, -1)
    names = {}
    for code in np.unique(codes[known]).tolist():
        k, a, b = code // base**2, FAMILIES[code // base % base], FAMILIES[code % base]
        both = f"both\n{a}" if a == b else f"{a},\n{b}"
        names[code] = f"modes {k + 1}, {k + 2}" + (f":\n{both}" if families else "")
    values = np.where(known, smallest, np.nan)
    return Quantity("smallest gap between frequencies", values, codes, names)
