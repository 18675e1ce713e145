"""The quantities of a map over two parameters: one frequency, or the smallest gap between two."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from scipy import ndimage

from beamviz.checks import check_int
from beamviz.errors import InvalidInput
from beamviz.sweeps.arrays import FAMILIES, SOLVED, STATUSES

LEAST_REGION = 0.03  # of the map: the smallest region that is named
BENDING, STRETCHING, MIXED = range(len(FAMILIES))
SMOOTH = 0.7  # [columns and rows] by which borders are smoothed


class Quantity(NamedTuple):
    """A quantity over two parameters: values (rows, columns), nan where there is none; kinds (rows,
    columns): the label of the mode, or those of the two modes of the gap, and the status of the
    beam, as a code, -1 where there is none; names: of the kinds, in lines."""

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


def mode_labels(frequency: np.ndarray, family: np.ndarray) -> np.ndarray:
    """Codes (rows, columns, modes) of the labels of modes, for `label_text`: 2 k of Bk, 2 k + 1 of
    Sk, 0 where there is no mode. frequency, family: (rows, columns, modes).

    Stretching and bending mix where their frequencies are close. Of two mixed modes the lower one
    counts as stretching; one alone is of the family that the nearest mode is not of.
    """
    codes, counts = np.zeros(family.shape, int), np.zeros((2, *family.shape[:-1]), int)
    alone = ((family == MIXED).sum(axis=-1) % 2).astype(bool)
    waiting = np.zeros_like(alone)  # a mixed mode waits for its other one
    nearest = family_of_nearest(frequency, family)
    for mode in range(family.shape[-1]):
        is_mixed = family[..., mode] == MIXED
        first = np.where(alone & (nearest[..., mode] == STRETCHING), waiting, ~waiting)
        is_stretching = (family[..., mode] == STRETCHING) | (is_mixed & first)
        is_bending = (family[..., mode] == BENDING) | (is_mixed & ~first)
        waiting ^= is_mixed
        for kind, has in ((0, is_bending), (1, is_stretching)):
            counts[kind] += has
            codes[..., mode][has] = (2 * counts[kind] + kind)[has]
    return codes


def family_of_nearest(frequency: np.ndarray, family: np.ndarray) -> np.ndarray:
    """The family of the mode that is nearest in frequency to each one (rows, columns, modes)."""
    ends = [(0, 0)] * (frequency.ndim - 1) + [(1, 1)]
    gaps = np.pad(np.diff(frequency, axis=-1), ends, constant_values=np.inf)
    gaps[~np.isfinite(gaps)] = np.inf
    around = np.pad(family, ends, constant_values=-1)
    return np.where(gaps[..., :-1] <= gaps[..., 1:], around[..., :-2], around[..., 2:])


def label_text(code: int) -> str:
    """The label of a code of `mode_labels`: "B3"."""
    return f"{'BS'[code % 2]}{code // 2}"


def frequency_of(
    mode: int, frequency: np.ndarray, family: np.ndarray, status: np.ndarray
) -> Quantity:
    """The frequency of a mode (1 is the lowest), whose kinds are its labels; frequency, family:
    (rows, columns, modes); status: (rows, columns)."""
    check_int("mode", mode, 1, frequency.shape[-1])
    values = frequency[..., mode - 1]
    kinds, labels = classify(
        np.isfinite(values), status, mode_labels(frequency, family)[..., mode - 1]
    )
    names = {
        code: with_status(label_text(label), status_code)
        for code, (status_code, label) in labels.items()
    }
    return Quantity(f"frequency of mode {mode}", values, kinds, names)


def smallest_gap(frequency: np.ndarray, family: np.ndarray, status: np.ndarray) -> Quantity:
    """The smallest gap between neighbouring frequencies (rows, columns, modes), whose kinds are the
    labels of the two modes; family: (rows, columns, modes); status: (rows, columns)."""
    if frequency.shape[-1] < 2:
        raise InvalidInput("the sweep has one mode: a gap needs two, as with modes=5")
    gaps = np.diff(frequency, axis=-1)
    gaps[~np.isfinite(gaps)] = np.inf
    lower = gaps.argmin(axis=-1)[..., None]
    smallest = gaps.min(axis=-1)
    known, labels = np.isfinite(smallest), mode_labels(frequency, family)
    pair = [np.take_along_axis(labels, lower + side, -1)[..., 0] for side in (0, 1)]
    kinds, pairs = classify(known, status, *np.sort(pair, axis=0))
    names = {}
    for code, (status_code, *two) in pairs.items():
        named = sorted(map(label_text, two), key=lambda name: (name[0] != "S", name))
        names[code] = with_status(", ".join(named), status_code)
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
