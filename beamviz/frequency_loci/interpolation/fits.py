"""The interpolants of the modes on a piece, which are tried one after the other.

Within a family the k-th omega^2 is an analytic function of the parameter. Two that veer have branch
points near the real axis: where omega^2 does not converge, a characteristic function of the family
is interpolated. Coupled modes, which have many narrow veerings, are one family.

Solves at check points between the nodes measure the error of each interpolant.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from beamviz.frequency_loci.axis import Axis
from beamviz.frequency_loci.interpolation import characteristic
from beamviz.frequency_loci.interpolation.characteristic import Characteristic
from beamviz.frequency_loci.interpolation.chebyshev import (
    BENDING_ERROR,
    EPS,
    estimated_error,
    interpolated,
    lobatto,
    tail_and_rates,
)
from beamviz.frequency_loci.interpolation.pieces import Piece
from beamviz.frequency_loci.sweep import Spectra, Sweep

SHARE = 0.5  # accepted interpolation error, of the tolerance and of the solver's error
FLOOR = 1.0  # omega^2 below which the error is absolute, near the onset of instability
OUTSIDE = 1e3  # accepted error of the mode above the requested ones, relative to theirs


class Fit(NamedTuple):
    """An interpolant. ratio: the largest of its errors relative to those accepted, expected when
    the order has grown by a half some number of times."""

    piece: Piece
    ratio: Callable[[int], float]


@dataclass(frozen=True, eq=False)
class Nodes:
    """The modes at the nodes of a piece, followed by the check points."""

    sweep: Sweep
    axis: Axis
    low: float  # of the variable t
    high: float
    order: int
    values: np.ndarray  # (n,) of the parameter
    solved: Spectra  # (n, ...)

    @cached_property
    def rank(self) -> np.ndarray:
        """The lowest index (families, k) of each mode by frequency among all."""
        known = np.isfinite(self.solved.squares)
        return np.where(known, self.solved.rank, np.inf).min(axis=0)

    @cached_property
    def needed(self) -> np.ndarray:
        """The modes (families, k) that must be interpolated: those requested, and of uncoupled
        ones the next."""
        return self.rank < self.sweep.modes + (not self.sweep.coupled)

    @cached_property
    def scale(self) -> np.ndarray:
        """`Axis.scale` (n, 1, 1) at the values."""
        return self.axis.scale(self.values)[:, None, None]

    @cached_property
    def accepted(self) -> np.ndarray:
        """The errors (families, k) of omega^2 that are accepted."""
        return self._accepted(np.ones((1, 1, 1)))

    @cached_property
    def accepted_scaled(self) -> np.ndarray:
        """The same of omega^2 divided by the scale."""
        return self._accepted(self.scale)

    def _accepted(self, scale: np.ndarray) -> np.ndarray:
        squares, errors, _ = self.solved
        requested = self.solved.rank < self.sweep.modes
        relative = SHARE * self.sweep.problem.tolerance * (abs(squares) + FLOOR) / scale
        accepted = relative + SHARE * np.where(np.isfinite(errors), errors, 0.0) / scale
        accepted = np.where(requested, accepted, np.inf).min(axis=0)
        above = OUTSIDE * relative.min(axis=0)
        accepted = np.where(self.rank >= self.sweep.modes, above, accepted)
        return np.where(self.rank <= self.sweep.modes, accepted, np.inf)

    @cached_property
    def piece(self) -> Piece:
        """The piece without an interpolant."""
        nodes = self.solved.take(slice(self.order + 1))
        return Piece(self.axis, self.low, self.high, nodes, None, self.needed)

    @cached_property
    def estimates(self) -> tuple[np.ndarray, np.ndarray]:
        """The errors (functions, families, k) of interpolated scaled omega^2 and, of coupled modes,
        bending fraction, and the factors by which they fall when the order grows by a half."""
        functions = [self.solved.squares / self.scale]
        if self.sweep.coupled:
            functions.append(self.solved.bending)
        values, points = np.stack(functions, axis=1), lobatto(self.order)
        nodes, checks = np.split(values, [self.order + 1])
        tail, rates = tail_and_rates(abs(interpolated(points.coefficients, nodes)), self.order)
        misfit = abs(interpolated(points.checks, nodes) - checks).max(axis=0)
        return estimated_error(tail, misfit) + EPS * abs(nodes).max(axis=0), rates

    @cached_property
    def ratios(self) -> np.ndarray:
        """The errors (families, k) of scaled omega^2 relative to those accepted."""
        return np.where(self.needed, self.estimates[0][0] / self.accepted_scaled, 0.0)


def by_squares(nodes: Nodes) -> Fit:
    """Polynomials for scaled omega^2, and for the bending fraction of coupled modes."""
    errors, rates = nodes.estimates
    accepted = nodes.accepted_scaled
    limits = np.stack((accepted, np.full_like(accepted, BENDING_ERROR)))[: len(errors)]

    def ratio(power: int) -> float:
        ratios = (errors / limits * rates**power).max(axis=0)
        return float(np.where(nodes.needed, ratios, 0.0).max())

    return Fit(replace(nodes.piece, errors=errors[0]), ratio)


def by_characteristics(nodes: Nodes) -> Fit | None:
    """Characteristic functions of the families whose omega^2 do not converge; None where not all
    eigenvalues are known."""
    spectra = nodes.sweep.full_spectra(nodes.values)
    if spectra is None:
        return None
    ratios, needed = nodes.ratios.copy(), np.isfinite(nodes.accepted)
    found: list[Characteristic | None] = [None] * len(needed)
    rates = np.full((len(needed), 1), EPS)  # of families
    for f, own in enumerate(ratios):
        if nodes.sweep.coupled or not (own <= 1).all():
            modes = int(np.flatnonzero(needed[f]).max(initial=-1)) + 1
            fitted = _characteristic(nodes, f, spectra[:, f], modes)
            if not fitted:
                return None
            found[f], errors, falls = fitted
            own[:modes] = np.where(needed[f, :modes], errors / nodes.accepted[f, :modes], 0.0)
            if not (own <= 1).all():  # else its terms are rounding errors, which do not fall
                rates[f] = falls
    piece = replace(
        nodes.piece, errors=nodes.estimates[0][0], needed=needed, characteristics=tuple(found)
    )
    return Fit(piece, lambda power: float((ratios * rates**power).max()))


def _characteristic(
    nodes: Nodes, f: int, spectrum: np.ndarray, modes: int
) -> tuple[Characteristic, np.ndarray, float] | None:
    """The characteristic function of family f with the `spectrum` (n, all modes), the errors
    (modes,) of its lowest omega^2, and the factor by which the largest falls when the order grows
    by a half. None without these omega^2."""
    count, kinetic = nodes.order + 1, None
    if not np.isfinite(spectrum[:, :modes]).all():
        return None
    if nodes.sweep.coupled:
        kinetic = nodes.sweep.kinetic_energies(nodes.values[:count])
    found, bending, changes, falls = characteristic.fit(
        spectrum[:count], spectrum[count:, :modes], modes, nodes.sweep.over, kinetic
    )
    errors = estimated_error(changes, found.misfit)
    errors = np.where(np.isfinite(errors), errors, np.inf)
    if nodes.sweep.coupled:
        off = abs(bending - nodes.solved.bending[count:, f, :modes]).max(axis=0)
        off[nodes.sweep.modes :] = 0.0
        errors = np.maximum(errors, off / BENDING_ERROR * nodes.accepted[f, :modes])
    return found, errors, falls
