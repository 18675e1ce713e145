"""Estimated errors of omega^2 of straight beams: truncation by the order of each element, rounding.

A mode and the stretch that it vibrates about are sums of polynomials in each element. What the two
highest of them carry, the tail, estimates what those left out would.
"""

import numpy as np
from numpy.typing import NDArray

from beamviz.mechanics.straight_equilibrium import AxialProblem, AxialState
from beamviz.solver.eigen import EPS
from beamviz.space.grid import Mesh
from beamviz.space.refinement import TRUNCATION_FACTOR

# Safety factor: twice the least for which the errors of 5000 random beams over the accepted domain
# were within their estimates (scripts/measure_error_bars.py).
ROUNDING_FACTOR = 30.0


def tail_energies(mesh: Mesh, stiffness: NDArray, v: NDArray) -> NDArray:
    """The energies (beams, 2, k, elements) of the two highest polynomials of each element in shapes
    v (beams, 2, n, k) of the families: an estimate of the change of omega^2 by a higher order. A
    polynomial of degree 1 or more has an integral in its own element only.

    stiffness (beams, 2, 2 n): `modes.Matrices.stiffness`; a tension counts by its absolute value.
    """
    n = mesh.points.shape[-1]
    of_unknown, of_integral = mesh.highest(v[..., :n, :])  # (beams, 2, n, k)
    weights = abs(stiffness)[..., None]
    energy = weights[..., :n, :] * of_unknown**2 + weights[..., n:, :] * of_integral**2
    firsts = np.cumsum([0, *mesh.orders[:-1]])  # points of the elements
    return np.add.reduceat(energy, firsts, axis=-2).mT


def truncation_errors(
    axial: AxialProblem, state: AxialState, scale: NDArray, tail: NDArray
) -> NDArray:
    """Estimated errors of omega^2 (..., k, elements) from the order of each element: what its two
    highest polynomials contribute to the energy of a mode, and to the stretch that it vibrates
    about.

    scale: of omega^2 without softening, (..., k), the leading axes those of the families. tail:
    `tail_energies` (..., k, elements).
    """
    margin = state.margin.reshape(-1, *[1] * scale.ndim)
    elements = tail.shape[-1]
    # The tail of a mode may nearly vanish by chance: it is at least that of each lower mode,
    # relative to its scale.
    relative = np.maximum.accumulate(tail / scale[..., None], axis=-2)
    # Near a limit of equilibrium a relative error of the load changes the stretch 1 / margin times
    # as much, and this the least omega^2, which vanishes at the limit, by the same factor.
    lost = stretch_errors(axial, state).reshape(*margin.shape[:-1], elements) / margin**2
    # A large stretch varies almost singularly along the beam: the error then exceeds the tail.
    stretch_at_clamp = np.maximum(state.f[:, 0].reshape(margin.shape), 1.0)
    return TRUNCATION_FACTOR * stretch_at_clamp * scale[..., None] * (relative + lost)


def stretch_errors(axial: AxialProblem, state: AxialState) -> NDArray:
    """Relative square errors (beams, elements) of the stretch: its two highest polynomials in each
    element, and what Newton's method leaves of it."""
    lost = lost_stretch(axial.mesh, state.f, axial.beams.blade is not None)
    return lost + state.error[:, None] / (2 * lost.shape[-1])


def lost_stretch(mesh: Mesh, f: NDArray, is_blade: bool) -> NDArray:
    """Relative errors (beams, elements) of integrals of a stretch f (beams, n), which is not a
    polynomial, by Gauss quadrature: squares of its two highest polynomials in each element."""
    tails = np.matvec(mesh.tails, f).reshape(len(f), -1, 2)
    lost = 4 * np.vecdot(tails, tails) / np.vecdot(mesh.weights, f)[:, None] ** 2
    if is_blade:
        # The stretch of a blade, 1 plus a force over E A, is no polynomial however small the
        # strain: what a quadrature loses is in proportion to the strain, not to its square.
        lost /= np.clip(abs(f - 1).max(axis=-1, keepdims=True), EPS, 1.0)
    return lost


def rounding_errors(state: AxialState, scale: NDArray, size: NDArray, relative: NDArray) -> NDArray:
    """Estimated errors of omega^2 (..., k) from rounding.

    scale: of omega^2 without softening. size: of the terms that are rounded. relative: the error of
    the eigenvalue problem in units of EPS, beside that of the terms.
    """
    margin = state.margin.reshape(-1, *[1] * (scale.ndim - 1))
    return ROUNDING_FACTOR * EPS * (size * (1 + relative) + scale * (1 / margin - 1))
