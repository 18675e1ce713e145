"""Modes at values of a parameter, and by how much their interpolation may be off."""

from typing import NamedTuple

import numpy as np

TAIL, MISFIT = 4.0, 8.0  # safety of the two estimates of error
BENDING_ERROR = 1e-3  # accepted error of the bending fraction
SHIFT = 12.0  # omega^2 of bending at rest: added before a root or logarithm is taken


def positive_shift(squares: np.ndarray) -> float:
    """What makes omega^2 positive when it is added."""
    return SHIFT + 2 * max(-float(squares.min()), 0.0)


class Spectra(NamedTuple):
    """Modes at values of a parameter by family: bending, then stretching; or all as one."""

    squares: np.ndarray  # (values, families, k) omega^2, ascending; nan where not solved for
    errors: np.ndarray  # (values, families, k) estimated by the solver; nan where it does not
    bending: np.ndarray  # (values, families, k) bending fraction

    def take(self, index: slice) -> "Spectra":
        """The modes at the values of an index."""
        return Spectra(*(array[index] for array in (self.squares, self.errors, self.bending)))

    @property
    def rank(self) -> np.ndarray:
        """The place (values, families, k) of each mode by frequency among all, from 0."""
        flat = self.squares.reshape(len(self.squares), -1)
        return flat.argsort(axis=1).argsort(axis=1).reshape(self.squares.shape)
