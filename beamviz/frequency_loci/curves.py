"""The loci of a part of a sweep as functions of the parameter, and roots of functions of them.

A `Measure` is such a function: the difference of two loci vanishes at a crossing,
omega^2 - (k gamma)^2 at a resonance, the lowest omega^2 at the onset of instability.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from beamviz.frequency_loci.axis import Axis
from beamviz.frequency_loci.interpolation.pieces import Piece
from beamviz.frequency_loci.sweep import Sweep, frequency_rank

Measure = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""Values (n,), omega^2 (n, families, k) -> functions (n, channels)."""

ZOOMS, SAMPLES = 6, 17  # of a measure around a minimum that may be zero
STEPS = 6  # of the secant method on interpolated loci
ALMOST = 1e-6  # of the bracket: correction of an interpolated root below which iteration ends
MAX_CORRECTIONS = 60  # by solves
MARGIN = 1e-3  # of the sweep: half-width of the bracket of a root to be corrected by solves
SETTLED = 1e-3  # of this margin: correction below which iteration ends, with interpolated loci
FINEST = 1e-12  # of the sweep: the same without


class Table(NamedTuple):
    """Samples of the loci, dense enough for every approach of two to appear."""

    at: np.ndarray  # (n,)
    squares: np.ndarray  # (n, families, k)
    rank: np.ndarray  # (n, families, k) index by frequency among all modes
    smooth: np.ndarray  # (n - 1,) whether the loci are interpolated between two samples


@dataclass
class Root:
    """A root of a measure, between two values."""

    channel: int
    low: float
    high: float
    at: float
    slope: float  # of the measure; its sign never changes
    settled: float  # correction below which iteration ends
    shift: float = np.inf  # the last correction
    residual: float = np.nan  # before it

    def correct(self, residual: float) -> None:
        """One step of the secant method; of bisection where that leaves the bracket."""
        if not np.isfinite(residual):
            self.shift = 0.0
            return
        if (residual < 0) == (self.slope > 0):
            self.low = self.at
        else:
            self.high = self.at
        if np.isfinite(self.shift) and self.shift and residual != self.residual:
            slope = (residual - self.residual) / self.shift
            self.slope = slope if slope * self.slope > 0 else self.slope
        corrected = self.at - residual / self.slope
        if not self.low <= corrected <= self.high:
            corrected = (self.low + self.high) / 2
        self.shift, self.residual, self.at = corrected - self.at, residual, corrected


@dataclass(frozen=True)
class Curves:
    """The loci on an axis, by interpolation where it converges, else by solves."""

    axis: Axis
    pieces: Sequence[Piece]
    solved: np.ndarray  # (n,) values, in pieces that did not converge
    squares: np.ndarray  # (n, families, k) omega^2 there

    def at(self, p: np.ndarray, most: int) -> np.ndarray:
        """`Piece.at` for values (n,) of the parameter, of at least the lowest `most` modes of each
        family; nan where they are not interpolated."""
        found = np.full((4, len(p), *self.squares.shape[1:]), np.nan)
        for piece, rows, t in self._by_piece(p):
            found[:, rows] = piece.at(t, most)
        return found

    def squares_at(self, p: np.ndarray) -> np.ndarray:
        """omega^2 (n, families, k) alone."""
        found = np.full((len(p), *self.squares.shape[1:]), np.nan)
        for piece, rows, t in self._by_piece(p):
            found[rows] = piece.squares(t)
        return found

    def _by_piece(self, p: np.ndarray) -> Iterator[tuple[Piece, Any, np.ndarray]]:
        """The interpolated pieces, the indices of the values (n,) in each, and their variable t."""
        t = self.axis.t(p)
        if len(self.pieces) == 1:
            owners = {0: slice(None)}
        else:
            owner = np.searchsorted([piece.high for piece in self.pieces[:-1]], t)
            owners = {k: owner == k for k in set(owner.tolist())}
        for k, rows in owners.items():
            if self.pieces[k].errors is not None:
                yield self.pieces[k], rows, t[rows]

    def uncertain(self, p: np.ndarray) -> np.ndarray:
        """Whether values (n,) are in pieces that did not converge."""
        t, found = self.axis.t(p), np.zeros(len(p), bool)
        for piece in self.pieces:
            if piece.errors is None:
                found |= (t >= piece.low) & (t <= piece.high)
        return found & (self.axis.low <= p) & (p <= self.axis.high)

    @cached_property
    def table(self) -> Table:
        """Samples of all pieces."""
        at, squares = [self.solved], [self.squares]
        for piece in self.pieces:
            if piece.errors is not None:
                at.append(self.axis.p(piece.dense))
                squares.append(piece.squares())
        values, first = np.unique(np.concatenate(at), return_index=True)
        found = np.concatenate(squares)[first]
        middles = (values[1:] + values[:-1]) / 2
        return Table(values, found, frequency_rank(found), ~self.uncertain(middles))

    def roots(self, measure: Measure) -> list[Root]:
        """The roots of a measure between the samples, by interpolation."""
        p, squares, _, smooth = self.table
        if len(p) < 2:
            return []
        with np.errstate(invalid="ignore"):
            G = measure(p, squares)
            side = np.sign(G)
            for i in (np.flatnonzero((side[1:] == 0).any(axis=1)) + 1).tolist():
                side[i] = np.where(side[i] == 0, side[i - 1], side[i])
            brackets = [
                (k, p[i], p[i + 1], G[i, k], G[i + 1, k], bool(smooth[i]))
                for i, k in np.argwhere(side[:-1] * side[1:] < 0).tolist()
            ]
            size = abs(G)
            middle = (size[1:-1] <= size[:-2]) & (size[1:-1] < size[2:])
            middle &= (side[:-2] * side[2:] > 0) & (side[:-2] * side[1:-1] > 0)
            # A parabola through three samples, with a factor of two, may reach zero.
            rise = np.maximum(size[:-2], size[2:]) - size[1:-1]
            middle &= (size[1:-1] < rise) & (smooth[1:] & smooth[:-1])[:, None]
        for i, k in np.argwhere(middle).tolist():
            brackets += self._touching(measure, k, p[i], p[i + 2])
        return self._refined(measure, brackets)

    def _touching(
        self, measure: Measure, k: int, low: float, high: float
    ) -> list[tuple[int, float, float, float, float, bool]]:
        """Brackets of two close roots around a minimum of the size of a measure; empty if none."""
        for _ in range(ZOOMS):
            p = np.linspace(low, high, SAMPLES)
            g = measure(p, self.squares_at(p))[:, k]
            changes = np.flatnonzero(g[:-1] * g[1:] < 0)
            if len(changes):
                return [(k, p[i], p[i + 1], g[i], g[i + 1], True) for i in changes.tolist()]
            i = int(np.nanargmin(abs(g)))
            low, high = p[max(i - 1, 0)], p[min(i + 1, SAMPLES - 1)]
        return []

    def _refined(self, measure: Measure, brackets: Sequence[tuple]) -> list[Root]:
        """Roots in brackets by the secant method, on interpolated loci where they are."""
        roots, length = [], float(np.ptp(self.table.at))
        for k, low, high, below, above, smooth in brackets:
            slope = float((above - below) / (high - low))
            settled = ALMOST * (high - low) if smooth else FINEST * length
            at = float(low - below / slope)
            roots.append(Root(k, low, high, at, slope, settled))
        interpolated = [root for root, (*_, smooth) in zip(roots, brackets, strict=True) if smooth]
        _correct(interpolated, measure, self.squares_at, STEPS)
        for root in interpolated:  # bracket for the correction by solves
            margin = MARGIN * length
            root.low = max(root.at - margin, self.table.at[0])
            root.high = min(root.at + margin, self.table.at[-1])
            root.shift, root.residual, root.settled = np.inf, np.nan, SETTLED * margin
        return roots


def polish(roots: Sequence[Root], sweep: Sweep, measure: Measure) -> None:
    """Correct roots by solves, in batches, until the corrections are small."""
    _correct(roots, measure, lambda at: sweep.spectra(at).squares, MAX_CORRECTIONS)


def _correct(
    roots: Sequence[Root],
    measure: Measure,
    squares_at: Callable[[np.ndarray], np.ndarray],
    steps: int,
) -> None:
    """At most `steps` steps of the secant method for the roots that have not converged."""
    for _ in range(steps):
        moving = [root for root in roots if abs(root.shift) > root.settled]
        if not moving:
            break
        at = np.array([root.at for root in moving])
        for root, row in zip(moving, measure(at, squares_at(at)), strict=True):
            root.correct(float(row[root.channel]))
