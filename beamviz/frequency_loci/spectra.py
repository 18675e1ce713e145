"""Modes at values of a parameter, and constants of the errors of their interpolation."""

from typing import NamedTuple

import numpy as np

TAIL, MISFIT = 4.0, 8.0  # safety factors of the two error estimates
BENDING_ERROR = 1e-3  # accepted error of the bending fraction
SHIFT = 12.0  # omega^2 of bending at rest: added before a root or logarithm is taken


def positive_shift(squares: np.ndarray) -> float:
    """Number whose addition makes omega^2 positive."""
    return SHIFT + 2 * max(-float(squares.min()), 0.0)


def frequency_rank(squares: np.ndarray) -> np.ndarray:
    """Index (values, families, k) of each mode by frequency among all, from omega^2; nan last."""
    flat = squares.reshape(len(squares), -1)
    return flat.argsort(axis=1).argsort(axis=1).reshape(squares.shape)


class Spectra(NamedTuple):
    """Modes at values of a parameter by family, bending first; or all as one family."""

    squares: np.ndarray  # (values, families, k) omega^2, ascending; nan where not solved for
    errors: np.ndarray  # (values, families, k) of the solver; nan where not estimated
    bending: np.ndarray  # (values, families, k) bending fraction

    def take(self, index: slice) -> "Spectra":
        """The modes at the values with these indices."""
        return Spectra(*(array[index] for array in self))

    @property
    def rank(self) -> np.ndarray:
        """Index (values, families, k) of each mode by frequency among all."""
        return frequency_rank(self.squares)
