"""A chart's own grid, and the loci on it between the limits of equilibrium.

The grid does not depend on the values asked for. It is refined where the shapes of neighbouring
solves differ by more than an exchange of two neighbours, so that modes are told apart.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from beamviz.frequency_loci.mode_vectors import ModeVectors
from beamviz.frequency_loci.path import ParameterPath, PathModes
from beamviz.solver.solution import Solution

INTERVALS = 80  # of the grid: its values are the 81 points of a page
HALVINGS = 6  # most of an interval
RECOGNISED = 0.8  # least share of a shape that the same mode and a neighbour have at the next value
TOWARDS_LIMIT = np.array(
    [0.75, 0.5, 0.25, 0.1, 0.03, 0.01]
)  # roots of the relative distances from it


def grid_values(low: float, high: float) -> NDArray:
    """The values of the grid of a chart."""
    return np.linspace(low, high, INTERVALS + 1)


def values_towards(limit: float, last: float) -> NDArray:
    """Values from the last solution to a limit of equilibrium, near which the loci vary as the root
    of the distance."""
    return limit + (last - limit) * TOWARDS_LIMIT**2


class Continuity(NamedTuple):
    """How the modes at each value continue at the next one."""

    exchanged: NDArray  # (n - 1, families, k - 1) whether modes j and j + 1 exchange their shapes
    is_known: NDArray  # (n - 1,) whether each requested mode is recognised at the next value


@dataclass(frozen=True, eq=False)
class Track:
    """The loci between two limits of equilibrium, `low` and `high`, or ends of the grid.

    values: of the grid (n,), ascending, each with a solution.
    """

    path: ParameterPath
    low: float
    high: float
    values: NDArray

    @cached_property
    def modes(self) -> PathModes:
        """The modes at these values."""
        return self.path.modes(self.values)

    @cached_property
    def vectors(self) -> ModeVectors:
        """The mode vectors at these values."""
        return self.path.vectors(self.values)

    def release_vectors(self) -> None:
        """Free the mode vectors, most of the memory of a chart; they are computed again where they
        are asked for."""
        vars(self).pop("vectors", None)

    @cached_property
    def continuity(self) -> Continuity:
        """How the modes continue from one value to the next."""
        return continuity(self.modes, self.vectors, self.path.problem.modes)


def track_loci(path: ParameterPath, low: float, high: float, values: NDArray) -> Track:
    """The loci at values of the grid (n,), with more where modes are not recognised from one value
    to the next: intervals are halved. Values without a solution are left out."""
    track = Track(path, low, high, _with_solution(path, values))
    for _ in range(HALVINGS):
        unknown = ~track.continuity.is_known
        if not unknown.any():
            break
        middles = (track.values[1:] + track.values[:-1]) / 2
        more = np.union1d(track.values, _with_solution(path, middles[unknown]))
        track = Track(path, low, high, more)
    return track


def _with_solution(path: ParameterPath, values: NDArray) -> NDArray:
    """Those of some values that have a solution."""
    outcomes = path.solve(values)
    return values[[isinstance(outcome, Solution) for outcome in outcomes]]


def continuity(modes: PathModes, vectors: ModeVectors, count: int) -> Continuity:
    """How the modes on a grid continue, `count` of them requested, by the shares of each shape in
    those at the next value."""
    before, after = vectors.chosen(slice(None, -1)), vectors.chosen(slice(1, None))
    shares = abs(before.products(after)) ** 2  # (n - 1, m, m) among all modes, by frequency
    rank = modes.rank
    n, families, k = rank.shape
    place = np.minimum(rank, shares.shape[-1] - 1)
    known = modes.known & (rank < shares.shape[-1])
    row = np.arange(n - 1)[:, None, None]

    def share(shift: int) -> NDArray:
        """The share (n - 1, families, k) of mode j in mode j + shift of its family."""
        by_mode = np.zeros((n - 1, families, k))
        first, last = max(0, -shift), k - max(0, shift)
        now, then = slice(first, last), slice(first + shift, last + shift)
        both = known[:-1, :, now] & known[1:, :, then]
        by_mode[:, :, now] = both * shares[row, place[:-1, :, now], place[1:, :, then]]
        return by_mode

    def shifted(by_mode: NDArray, shift: int) -> NDArray:
        """What is known of mode j - shift, for each mode j; 0 where there is none."""
        known = np.zeros_like(by_mode)
        first, last = max(0, shift), k + min(0, shift)
        known[..., first:last] = by_mode[..., first - shift : last - shift]
        return known

    stays, rises, falls = share(0), share(1), share(-1)
    kept = stays[..., :-1] + stays[..., 1:]
    exchanged = rises[..., :-1] + falls[..., 1:] > kept
    requested = known & (rank < count)
    on_both_sides = requested[:-1] & requested[1:]
    on_one_side = (requested[:-1] & ~known[1:]) | (requested[1:] & ~known[:-1])
    # A mode that is one of two neighbours at the next value, and one that was one before.
    forward = stays + np.maximum(rises, falls)
    backward = stays + np.maximum(shifted(rises, 1), shifted(falls, -1))
    recognised = np.minimum(forward, backward) >= RECOGNISED
    is_known = (recognised | ~on_both_sides) & ~on_one_side
    return Continuity(exchanged, is_known.all(axis=(1, 2)))
