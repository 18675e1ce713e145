"""The residual of modes of a straight blade at its Gauss points, and the energy that they lack.

An element that spans stations of a blade has many more Gauss points than functions. In the space of
all values at the points a mode satisfies D v = (lambda M - T) v with D, diagonal, the stiffness of
the section and T that of the tension. Of a mode in the smaller space of the trial functions the
residual is r = (D + T - lambda M) v, and omega^2 is too high by r' D^-1 r, but for shares T / D and
lambda M / D of this, which are small for shapes as short as those that polynomials do not resolve.
"""

import numpy as np
from numpy.typing import NDArray

from beamviz.mechanics.straight_equilibrium import AxialProblem
from beamviz.mechanics.straight_errors import Matrices
from beamviz.mechanics.straight_properties import BeamStack
from beamviz.solver.problem import Problem
from beamviz.space.trial import Trial

# Share of the energy lacking by which omega^2 may still be wrong when it is subtracted, before
# the safety factor of all truncation errors: at most 3 % of it was left in 80 solves of blades.
LEFT = 0.1


def lacking_energies(
    axial: AxialProblem,
    trial: Trial,
    f: NDArray,
    matrices: Matrices,
    shapes: tuple[NDArray, NDArray],
    squares: tuple[NDArray, NDArray],
    coupling: NDArray | None,
    problem: Problem,
) -> NDArray:
    """What omega^2 is too high by (beams, 2, k, elements) for the lack of each family in each
    element: of shapes of unit modal mass, kappa (beams, n, k) with the angle at the root where that
    is free, and s (beams, n, k).

    squares: lambda = omega^2 without softening, (beams, k), of each. coupling (beams, k): 2 gamma
    times the exponent of coupled modes, with kappa and s parts of one shape.
    """
    n, (kappa, s), G = f.shape[-1], shapes, axial.properties.G
    angle = trial.J @ kappa[:, :n] + kappa[:, n:].sum(axis=1, keepdims=True)
    moved, stretched = G @ (f[..., None] * angle), G @ s
    of_bending, of_stretching = (square[:, None] for square in squares)
    forces, pull = of_bending * moved, of_stretching * stretched  # of inertia
    if coupling is not None:
        forces = forces - coupling[:, None] * stretched
        pull = pull + coupling[:, None] * moved
    bent, turned = matrices.stiffness[:, :n, None], matrices.stiffness[:, n:, None]
    moments = trial.J.mT @ (turned * angle - f[..., None] * forces)
    if axial.beams.has_inertia:
        to_bodies = axial.properties.to_bodies[:, 1:]
        inertia, stiffness = rotary_inertia(axial.beams, problem)
        turns = to_bodies @ kappa[:, :n] + kappa[:, n:].sum(axis=1, keepdims=True)
        held = axial.beams.gamma[..., None] ** 2 * stiffness[:, None]
        moments = moments + to_bodies.mT @ ((held - of_bending * inertia[:, None]) * turns)
    along = matrices.axial_stiffness[..., None]
    return np.stack(
        (
            trial.of_kinked(abs(bent * kappa[:, :n] + moments) ** 2 / bent),
            trial.of_kinked(abs(along * s - pull) ** 2 / along),
        ),
        axis=1,
    )


def rotary_inertia(beams: BeamStack, problem: Problem) -> tuple[NDArray, NDArray]:
    """Rotary inertia of the bodies `masses`, which turn with the beam, and the stiffness over
    gamma^2 by which centrifugal forces turn them back, each (masses,).

    In the plane of rotation Jz theta'' does not soften, as a body turns with the hub: a stiffness
    gamma^2 Jz balances the softening of all of M. Out of it the inertia is Jy, and the centrifugal
    forces on a body have the stiffness gamma^2 (Jz - Jx).
    """
    Jx, Jy, Jz = np.array([mass.inertia for mass in beams.masses]).T
    return (Jz, Jz * problem.softening) if problem.chordwise else (Jy, Jz - Jx)
