"""Bending and stretching of a straight beam, solved apart and put into one list."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

Shapes = Callable[[np.ndarray], np.ndarray]  # x -> (len(x), modes), of unit modal mass


class Family(NamedTuple):
    """The lowest modes of one family."""

    omega_squared: np.ndarray  # (modes,) omega^2, ascending
    shapes: Shapes


class Modes(NamedTuple):
    """The lowest modes of both families."""

    omega_squared: np.ndarray  # (modes,) omega^2, ascending
    bending_energy_fraction: np.ndarray  # (modes,) share of the kinetic energy across the beam
    displacement: Callable[[np.ndarray], np.ndarray]  # x -> (len(x), 2, modes)


def merged(bending: Family, stretching: Family, modes: int) -> Modes:
    """The lowest `modes` of two families that nothing couples."""
    omega_squared = np.concatenate((bending.omega_squared, stretching.omega_squared))
    picks, first = omega_squared.argsort()[:modes], len(bending.omega_squared)

    def displacement(x: np.ndarray) -> np.ndarray:
        across, along = bending.shapes(x), stretching.shapes(x)
        fields = np.zeros((len(x), 2, len(omega_squared)))
        fields[:, 1, :first], fields[:, 0, first:] = across, along
        return fields[:, :, picks]

    return Modes(omega_squared[picks], (picks < first).astype(float), displacement)
