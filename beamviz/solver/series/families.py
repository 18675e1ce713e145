"""Bending and stretching of a straight beam, solved apart and put into one list."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

Shapes = Callable[[np.ndarray], np.ndarray]  # x -> (len(x), modes), of unit modal mass


class Family(NamedTuple):
    """The lowest modes of one family."""

    squares: np.ndarray  # (modes,) omega^2, ascending
    shapes: Shapes


class Modes(NamedTuple):
    """The lowest modes of both families."""

    squares: np.ndarray  # (modes,) omega^2, ascending
    bending_fractions: np.ndarray  # (modes,) share of the kinetic energy across the beam
    displacement: Callable[[np.ndarray], np.ndarray]  # x -> (len(x), 2, modes)


def merged(bending: Family, stretching: Family, modes: int) -> Modes:
    """The lowest `modes` of two families that nothing couples."""
    squares = np.concatenate((bending.squares, stretching.squares))
    picks, first = squares.argsort()[:modes], len(bending.squares)

    def displacement(x: np.ndarray) -> np.ndarray:
        across, along = bending.shapes(x), stretching.shapes(x)
        fields = np.zeros((len(x), 2, len(squares)))
        fields[:, 1, :first], fields[:, 0, first:] = across, along
        return fields[:, :, picks]

    return Modes(squares[picks], (picks < first).astype(float), displacement)
