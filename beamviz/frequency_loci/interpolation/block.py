"""Coupled modes as those of a small symmetric matrix that is analytic across veerings.

In the basis of the shapes at the middle of a piece the lowest modes are those of a matrix H, smooth
however narrowly they veer. Its logarithm is interpolated, and diagonalised at each value. Unlike a
characteristic function it needs no spectra of whole meshes.
"""

from typing import Any, NamedTuple

import numpy as np

from beamviz.frequency_loci.interpolation.chebyshev import (
    CHECKS,
    EPS,
    interpolated,
    lobatto,
    tail_and_rates,
)
from beamviz.frequency_loci.spectra import BENDING_ERROR, MISFIT, TAIL, Spectra, positive_shift


class Block(NamedTuple):
    """The m lowest modes as symmetric matrices, in the basis of modes at the middle of a piece and
    elsewhere in one as close to it as possible."""

    matrices: np.ndarray  # (n, 3, m, m) at the nodes: logarithm of H + shift, energies as Points
    shift: float  # of omega^2, which may be negative
    solver_errors: np.ndarray  # (n, m) of omega^2 at the nodes
    tail: np.ndarray  # (m, m) of the logarithm: sum of the truncated coefficients
    misfit: np.ndarray  # (m,) largest error of omega^2 at the check points

    def squares(self, rows: np.ndarray) -> np.ndarray:
        """omega^2 (n, m) by interpolation `rows`."""
        return np.exp(np.linalg.eigvalsh(interpolated(rows, self.matrices[:, 0]))) - self.shift

    def at(self, rows: np.ndarray, after: np.ndarray) -> np.ndarray:
        """omega^2, its solver error, bending fraction, interpolation error of omega^2: (4, n, m).

        rows: (n, nodes) of the interpolation. after: indices (n,) of the next nodes."""
        logarithm, across, kinetic = np.moveaxis(interpolated(rows, self.matrices), 1, 0)
        f, y = np.linalg.eigh(logarithm)
        bending, whole = ((y * (form @ y)).sum(axis=1) for form in (across, kinetic))
        own = np.maximum(self.solver_errors[after - 1], self.solver_errors[after])
        solver_error = np.matvec((y**2).mT, own)
        error = np.maximum(TAIL * self.tails(f, y), MISFIT * self.misfit)
        shifted = np.exp(f)
        return np.array(
            [shifted - self.shift, solver_error, bending / whole, error + EPS * shifted]
        )

    def tails(self, f: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Change of omega^2 = exp(f) - shift by the tail, to first order."""
        return np.exp(f) * (abs(y) * (self.tail @ abs(y))).sum(axis=-2)


def fit(points: Any, spectra: Spectra, order: int) -> tuple[Block, np.ndarray, np.ndarray] | None:
    """The block by `mode_vectors.Points` and modes at the nodes and check points of a piece; the
    errors (m,) of its omega^2, and the factors by which they fall when the order grows by a half.
    None without shapes."""
    if len(points.at) < len(spectra.squares) or not points.kinetic.size:
        return None
    squares = points.omega_squared
    m = squares.shape[1]
    U, _, V = np.linalg.svd(points.shapes[order // 2] @ points.duals.mT)
    Q = U @ V  # (n, m, m): modes -> aligned with those of the middle
    shift = positive_shift(squares)
    f = np.log(squares + shift)
    forms = np.concatenate(((np.eye(m) * f[:, None, :])[:, None], points.kinetic), axis=1)
    matrices = (Q[:, None] @ forms @ Q[:, None].mT)[: order + 1]
    coefficients = abs(np.tensordot(lobatto(order).coefficients, matrices[:, 0], 1))
    tail, rates = tail_and_rates(coefficients, order)
    middle = tail / rates
    solver_errors = np.matvec(Q**2, spectra.errors[:, 0, :m])
    block = Block(matrices, shift, solver_errors[: order + 1], tail, np.zeros(m))
    tails, middles = (
        one.tails(f[: order + 1], Q.mT[: order + 1]).max(axis=0)
        for one in (block, block._replace(tail=middle))
    )
    after = np.ones(len(CHECKS), int)
    found, _, bending, _ = block.at(lobatto(order).checks, after)
    misfit = abs(found - squares[order + 1 :]).max(axis=0)
    off = abs(bending - spectra.bending[order + 1 :, 0, :m]).max(axis=0)
    errors = np.maximum(TAIL * tails, MISFIT * misfit)
    errors = np.maximum(errors, np.where(off > BENDING_ERROR, np.inf, 0.0))
    return block._replace(misfit=misfit), errors, np.minimum(tails / middles, 1.0)
