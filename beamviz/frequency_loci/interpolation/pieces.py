"""Modes on a part of an axis: Chebyshev interpolants of omega^2 or of characteristic functions, and
their estimated errors."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from beamviz.frequency_loci.axis import Axis
from beamviz.frequency_loci.interpolation.characteristic import Characteristic
from beamviz.frequency_loci.interpolation.chebyshev import (
    estimated_error,
    interpolated,
    lobatto,
    on_piece,
)
from beamviz.frequency_loci.sweep import Spectra


@dataclass(frozen=True)
class Piece:
    """A part of the axis with the modes at its nodes. `errors` is None where the interpolation did
    not converge."""

    axis: Axis
    low: float  # of the variable t
    high: float
    spectra: Spectra
    errors: np.ndarray | None  # (families, k) of omega^2 divided by the scale
    needed: np.ndarray  # (families, k) whether the mode is interpolated
    characteristics: tuple[Characteristic | None, ...] = ()  # of families, instead, if any

    @property
    def order(self) -> int:
        """Order of the interpolation."""
        return len(self.spectra.squares) - 1

    @property
    def dense(self) -> np.ndarray:
        """Values of the variable at which the piece is sampled."""
        return on_piece(self.low, self.high, lobatto(self.order).dense_nodes)

    def at(self, t: np.ndarray, most: int | None = None) -> np.ndarray:
        """omega^2, its error by the solver, bending fraction and interpolation error of omega^2,
        (4, n, families, k), at values (n,) of the variable; nan where not interpolated. most:
        number of modes of a family that suffice."""
        assert self.errors is not None
        points, x = lobatto(self.order), self._local(t)
        rows = points.rows(x)
        after = np.clip(np.searchsorted(points.nodes, x), 1, self.order)
        found = np.full((4, len(t), *self.needed.shape), np.nan)
        squares, solver_error, bending, error = found
        _, solved, fractions = self.spectra
        kept = np.where(self.needed, 1.0, np.nan)
        solver_error[:] = np.maximum(solved[after - 1], solved[after]) * kept
        scale = self._scale(t)
        squares[:] = self._squares(rows, scale)
        error[:] = self.errors * scale * kept
        if len(self.needed) == 2:
            bending[:] = fractions[0] * kept
        elif not self.characteristics:
            bending[:] = np.clip(interpolated(rows, fractions * kept), 0.0, 1.0)
        for f, one in enumerate(self.characteristics):
            if one:
                squares[:, f, : one.modes], change, fractions = one.roots(rows, len(t), most)
                error[:, f, : one.modes] = estimated_error(change, one.misfit)
                if len(self.needed) == 1:
                    bending[:, f, : one.modes] = fractions
        return found

    def squares(self, t: np.ndarray | None = None) -> np.ndarray:
        """omega^2 (n, families, k) alone; by default at the values `dense`."""
        points = lobatto(self.order)
        rows = points.dense if t is None else points.rows(self._local(t))
        squares = self._squares(rows, self._scale(self.dense if t is None else t))
        for f, one in enumerate(self.characteristics):
            if one:
                known = t is None and one.samples is not None
                squares[:, f, : one.modes] = one.samples if known else one.roots(rows)[0]
        return squares

    def _local(self, t: np.ndarray) -> np.ndarray:
        """Values of the variable mapped to -1 .. 1."""
        return 2 * (t - self.low) / (self.high - self.low) - 1

    def _scale(self, t: np.ndarray) -> np.ndarray:
        """`Axis.scale` (n, 1, 1) at values (n,) of the variable."""
        return self.axis.scale(self.axis.p(t))[:, None, None]

    @cached_property
    def _scaled(self) -> np.ndarray:
        """omega^2 (nodes, families, k) at the nodes, divided by the scale."""
        nodes = on_piece(self.low, self.high, lobatto(self.order).nodes)
        return self.spectra.squares / self._scale(nodes)

    def _squares(self, rows: np.ndarray, scale: np.ndarray) -> np.ndarray:
        return interpolated(rows, self._scaled * np.where(self.needed, 1.0, np.nan)) * scale
