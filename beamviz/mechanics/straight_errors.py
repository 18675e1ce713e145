"""Estimated errors of omega^2 of straight beams: truncation by the order of each element, rounding.

A mode and the stretch that it vibrates about are sums of functions in each element. What the
highest of them carry, the tail, estimates what those left out would.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from beamviz.mechanics.straight_equilibrium import AxialProblem, AxialState
from beamviz.solver.pencil.families import ROUNDING_FACTOR
from beamviz.solver.pencil.matrices import EPS
from beamviz.space.refinement import truncation_errors
from beamviz.space.trial import Trial


class Matrices(NamedTuple):
    """Stiffness, without softening, and mass of the two families.

    Bending, r coefficients, r + 1 unknowns where the root is not clamped: K and M. Stretching,
    coefficients of the functions S: the stiffness is the identity.
    """

    K: NDArray  # (beams, unknowns, unknowns); in space less the softening
    M: NDArray  # (beams, unknowns, unknowns)
    S: NDArray  # (beams, n, functions)
    # (beams, 2 c n) of kappa, then of its integral (tension), at the points, of c components
    stiffness: NDArray
    axial_stiffness: NDArray  # (beams, n) of s
    M_out: NDArray | None = None  # in space: the part of M that is out of the plane of rotation


def tail_energies(trial: Trial, matrices: Matrices, across: NDArray, s: NDArray) -> NDArray:
    """The energies (beams, 2, k, elements) of the highest functions of each element in shapes with
    coefficients across (beams, r, k) and a gradient s along the beam (beams, n, k): an estimate of
    the change of omega^2 by a higher order, 0 in the elements of several pieces, of which it is
    known (`straight_residual`). A tension counts by its absolute value."""
    stiffness = np.vecmat(abs(matrices.stiffness), trial.tail_squares)[..., None]
    axial_stiffness = np.vecmat(matrices.axial_stiffness, trial.stretch_tail_squares)[..., None]
    energies = np.empty((len(s), 2, axial_stiffness.shape[-2], s.shape[-1]))
    if trial.components == 1:
        np.multiply(stiffness, across[:, trial.highest_of_all[1]] ** 2, out=energies[:, 0])
    else:  # functions of the same degree are neighbours
        bending = stiffness * across[:, trial.highest_of_all[1]] ** 2
        bending.reshape(len(s), -1, 2, s.shape[-1]).sum(axis=2, out=energies[:, 0])
    np.multiply(axial_stiffness, (trial.stretch_tails @ s) ** 2, out=energies[:, 1])
    tails = trial.by_element(energies)
    return tails * ~trial.is_kinked if trial.has_kinks else tails


def quadrature_errors(trial: Trial, across: NDArray, along: NDArray) -> NDArray:
    """What the quadrature of the elastic energy may change omega^2 by (beams, 2, k, 1), in each
    element, of shapes with these coefficients (beams, functions, k) and perhaps an angle at the
    root, which stores none."""
    bending = across[:, : trial.components * sum(trial.elements.orders)]
    energies = np.stack([(c**2).sum(axis=-2) for c in (bending, along)], axis=1)
    return trial.quadrature / len(trial.blocks) * energies[..., None]


def errors_of_squares(
    axial: AxialProblem, trial: Trial, state: AxialState, scale: NDArray, tail: NDArray
) -> NDArray:
    """`truncation_errors` of omega^2 (..., k, elements) of straight beams. scale: of omega^2
    without softening, (..., k), the leading axes those of the families. tail: `tail_energies`
    (..., k, elements)."""
    margin = state.margin.reshape(-1, *[1] * scale.ndim)
    # Near a limit of equilibrium a relative error of the load changes the stretch 1 / margin times
    # as much, and this the least omega^2, which vanishes at the limit, by the same factor.
    lost = stretch_errors(axial, trial, state)
    lost = lost.reshape(*margin.shape[:-1], tail.shape[-1]) / margin**2
    stretch = np.maximum(state.f[:, 0].reshape(margin.shape), 1.0)
    return truncation_errors(tail, scale, lost, stretch)


def stretch_errors(axial: AxialProblem, trial: Trial, state: AxialState) -> NDArray:
    """Relative square errors (beams, elements) of the stretch: its highest functions in each
    element, and what Newton's method leaves of it."""
    lost = lost_stretch(trial, state.f, axial.beams.blade is not None)
    return lost + state.error[:, None] / (2 * lost.shape[-1])


def lost_stretch(trial: Trial, f: NDArray, is_blade: bool) -> NDArray:
    """Relative errors (beams, elements) of integrals of a stretch f (beams, n), which is not a
    polynomial, by Gauss quadrature: squares of its highest functions in each element."""
    tails = np.matvec(trial.force_tails, f - 1)
    length = np.vecdot(trial.grid.weights, f)[:, None]
    lost = 4 * np.add.reduceat(tails**2, trial.tail_starts, axis=-1) / length**2
    if is_blade:
        # The stretch of a blade, 1 plus a force over E A, is no polynomial however small the
        # strain: what a quadrature loses is in proportion to the strain, not to its square.
        lost /= np.clip(abs(f - 1).max(axis=-1, keepdims=True), EPS, 1.0)
    return lost


def rounding_errors(state: AxialState, scale: NDArray, of_pencil: NDArray) -> NDArray:
    """Estimated errors of omega^2 (..., k) from rounding: those of the eigenvalue problem, and near
    a limit of equilibrium of the state. scale: of omega^2 without softening."""
    margin = state.margin.reshape(-1, *[1] * (scale.ndim - 1))
    return of_pencil + ROUNDING_FACTOR * EPS * scale * (1 / margin - 1)
