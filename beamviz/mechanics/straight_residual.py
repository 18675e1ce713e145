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
    element: of shapes of unit modal mass, kappa (beams, c n, k) of c components with the angles at
    the root where these are free, and s (beams, n, k).

    squares: omega^2 (beams, k) of each family. coupling (beams, k): 2 gamma times the exponent of
    coupled modes, with kappa and s parts of one shape.
    """
    n, (kappa, s), G, c = f.shape[-1], shapes, axial.properties.G, trial.components
    curvatures, root = split_root(kappa, c, n)
    angle = trial.J[..., None, :, :] @ curvatures + root  # (beams, c, n, k)
    moved, stretched = G[:, None] @ (f[:, None, :, None] * angle), G @ s
    of_bending, of_stretching = (square[:, None] for square in squares)
    load = axial.beams.gamma[..., None] ** 2  # (beams, 1, 1)
    softens = [in_plane and problem.softening for in_plane in problem.components_in_plane]
    softening = load[:, None] * np.array(softens)[:, None, None]
    forces = (of_bending[:, None] + softening) * moved  # of inertia
    pull = (of_stretching + load * problem.softening) * stretched
    if coupling is not None:
        forces[:, 0] -= coupling[:, None] * stretched
        pull = pull + coupling[:, None] * moved[:, 0]
    turned = matrices.stiffness[:, c * n :].reshape(-1, c, n, 1)
    moments = trial.J[..., None, :, :].mT @ (turned * angle - f[:, None, :, None] * forces)
    if axial.beams.has_inertia:
        to_bodies = axial.properties.to_bodies[:, None, 1:]
        inertia, stiffness = rotary_inertia(axial.beams, problem)
        turns = to_bodies @ curvatures + root  # (beams, c, masses, k)
        held = load[:, None] * np.einsum("mij,bjmk->bimk", stiffness, turns)
        turning = of_bending[:, None] * np.einsum("mij,bjmk->bimk", inertia, turns)
        moments = moments + to_bodies.mT @ (held - turning)
    bent, along = matrices.stiffness[:, : c * n, None], matrices.axial_stiffness[..., None]
    bends = trial.turned(kappa[:, : c * n], back=True)
    residual = bent * bends + trial.turned(moments.reshape(bends.shape), back=True)
    lack = (abs(residual) ** 2 / bent).reshape(curvatures.shape).sum(axis=1)
    return np.stack(
        (trial.of_kinked(lack), trial.of_kinked(abs(along * s - pull) ** 2 / along)), axis=1
    )


def split_root(kappa: NDArray, components: int, n: int) -> tuple[NDArray, NDArray | float]:
    """Curvatures (..., components, n, k) and angles at the root (..., components, 1, k), 0 where it
    is clamped, of both in one axis."""
    curvatures = kappa[..., : components * n, :]
    curvatures = curvatures.reshape(*kappa.shape[:-2], components, n, kappa.shape[-1])
    root = kappa[..., components * n :, :]
    return curvatures, root[..., None, :] if root.shape[-2] else 0.0


def rotary_inertia(beams: BeamStack, problem: Problem) -> tuple[NDArray, NDArray]:
    """Rotary inertia of the bodies `masses`, which turn with the beam, and the stiffness over
    gamma^2 by which centrifugal forces turn them back, each (masses, c, c) of c components.

    In the plane of rotation a body turns with the hub: Jz theta", without a stiffness. Out of it
    the inertia is Jy, and the centrifugal forces have the stiffness gamma^2 (Jz - Jx). In space
    the principal axes of a body are turned with the section. (The moment of the centrifugal forces
    about the axis of the beam twists it, and has no part in bending.)
    """
    Jx, Jy, Jz = np.array([mass.inertia for mass in beams.masses]).T
    if not problem.in_space:
        J, held = (Jz, 0.0 * Jz) if problem.chordwise else (Jy, Jz - Jx)
        return J[:, None, None], held[:, None, None]
    c, s = turn_of_bodies(beams)
    J, held = np.zeros((2, len(Jx), 2, 2))
    J[:, 0, 0] = c**2 * Jz + s**2 * Jy
    J[:, 1, 1] = s**2 * Jz + c**2 * Jy
    J[:, 0, 1] = J[:, 1, 0] = c * s * (Jz - Jy)
    held[:, 1, 1] = J[:, 0, 0] - Jx
    return J, held


def turn_of_bodies(beams: BeamStack) -> tuple[NDArray, NDArray]:
    """Cosine and sine (masses,) of the angle of the section that carries each body."""
    assert beams.blade is not None
    turn = np.radians(beams.blade.at("twist", [mass.beta for mass in beams.masses]))
    return np.cos(turn), np.sin(turn)
