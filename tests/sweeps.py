"""Small eigenproblems along a parameter, with known crossings and veerings, for tracking tests."""

from collections.abc import Callable

import numpy as np

from beamviz.frequency_loci import Event, Loci
from beamviz.frequency_loci.crossings import track_and_locate
from beamviz.frequency_loci.tracking import Points, Track, branch_table


class Problem:
    """K(p) v = lambda v for a symmetric K (m, m), solved wherever a search asks for it."""

    def __init__(self, K: Callable[[float], np.ndarray], modes: int | None = None):
        self.K, self.modes, self.solves = K, modes, 0
        self.chance = np.random.default_rng(1)

    def __call__(self, values: np.ndarray) -> Points:
        """The lowest modes at some values, each shape with a random sign."""
        self.solves += len(values)
        pairs = [np.linalg.eigh(self.K(float(p))) for p in values]
        squares = np.array([squares[: self.modes] for squares, _ in pairs])
        signs = self.chance.choice([-1.0, 1.0], (*squares.shape, 1))
        shapes = signs * np.array([V.T[: self.modes] for _, V in pairs])
        return Points(np.asarray(values, float), squares, shapes, shapes)

    def chart(self, values: np.ndarray, window: int) -> tuple[Track, list[Event]]:
        """The sweep over some values, with the crossings and veerings of its lowest modes."""
        return track_and_locate(self(values), window, self)


def crossing(at: float, coupling: float = 0.0) -> Problem:
    """Two modes that would cross at a value, kept apart by their coupling."""
    return Problem(
        lambda p: np.array([[100 + 20 * (p - at), coupling], [coupling, 100 - 20 * (p - at)]])
    )


def rotation(angle: float) -> np.ndarray:
    """The rotation (2, 2) by an angle."""
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def frequencies(track: Track, window: int) -> np.ndarray:
    """The frequencies (n, branches) of a track, branch by branch; nan where one is absent."""
    return branch_table(track, window).frequencies


def sorted_frequencies(found: Loci) -> np.ndarray:
    """The frequencies (values, branches) of loci in order, nan last."""
    return np.sort(np.column_stack([branch.frequency for branch in found.branches]), axis=1)
