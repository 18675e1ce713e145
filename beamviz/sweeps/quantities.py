"""The quantities of a map over two parameters: one frequency, or the smallest gap between two."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from scipy import ndimage

from beamviz.checks import check_int
from beamviz.errors import InvalidInput
from beamviz.sweeps.arrays import FAMILIES, SOLVED, STATUSES

LEAST_REGION = 0.03  # of the map: the smallest region that is named
SMOOTH = 0.7  # [columns and rows] by which borders are smoothed


class Quantity(NamedTuple):
    """A quantity over two parameters: values (rows, columns), nan where there is none; kinds (rows,
    columns): the family of the mode, or the modes of the gap and their families, and the status of
    the beam, as a code, -1 where there is none; names: of the kinds, in lines."""

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


def frequency_of(
    mode: int, frequency: np.ndarray, family: np.ndarray, status: np.ndarray
) -> Quantity:
    """The frequency of a mode (1 is the lowest); frequency, family: (rows, columns, modes);
    status: (rows, columns)."""
    check_int("mode", mode, 1, frequency.shape[-1])
    values = frequency[..., mode - 1]
    kinds, labels = classify(np.isfinite(values), status, family[..., mode - 1])
    names = {
        code: with_status(FAMILIES[family_code], status_code)
        for code, (status_code, family_code) in labels.items()
    }
    return Quantity(f"frequency of mode {mode}", values, kinds, names)


def smallest_gap(
    frequency: np.ndarray, family: np.ndarray, status: np.ndarray, families: bool = True
) -> Quantity:
    """The smallest gap between neighbouring frequencies (rows, columns, modes); its kinds are the
    two modes and, with `families`, theirs. status: (rows, columns)."""
    if frequency.shape[-1] < 2:
        raise InvalidInput("the sweep has one mode: a gap needs two, as with modes=5")
    gaps = np.diff(frequency, axis=-1)
    gaps[~np.isfinite(gaps)] = np.inf
    lower = gaps.argmin(axis=-1)
    smallest = gaps.min(axis=-1)
    known = np.isfinite(smallest)
    pair = (np.take_along_axis(family, (lower + side)[..., None], -1)[..., 0] for side in (0, 1))
    first, second = np.sort(np.stack(list(pair)), axis=0)
    if families:
        kinds, labels = classify(known, status, lower, first, second)
    else:
        kinds, labels = classify(known, status, lower)
    names = {}
    for code, (status_code, k, *pair_codes) in labels.items():
        name = f"modes {k + 1}, {k + 2}"
        if families:
            a, b = (FAMILIES[family_code] for family_code in pair_codes)
            name += f":\nboth\n{a}" if a == b else f":\n{a},\n{b}"
        names[code] = with_status(name, status_code)
    values = np.where(known, smallest, np.nan)
    return Quantity("smallest gap between frequencies", values, kinds, names)


def classify(
    known: np.ndarray, *labels: np.ndarray
) -> tuple[np.ndarray, dict[int, tuple[int, ...]]]:
    """Codes (rows, columns) of the different combinations of labels (rows, columns), -1 where the
    quantity is not known, and the labels of each code."""
    kinds = np.full(known.shape, -1)
    if not known.any():
        return kinds, {}
    rows = np.stack([label[known].astype(int) for label in labels], axis=1)
    different, kinds[known] = np.unique(rows, axis=0, return_inverse=True)
    return kinds, {code: tuple(row) for code, row in enumerate(different.tolist())}


def with_status(name: str, status: int) -> str:
    """The name of a kind, with the status of its beams unless they are stable."""
    return name if status == SOLVED else f"{name}\n({STATUSES[status]})"
