"""Vibration of stretched straight beams.

The unknowns are coefficients of the trial functions of a few elements (`beamviz.space.trial`): of
the gradient s = du' for stretching, of the derivative kappa = theta' of the rotation for bending.
Displacements are integrals, u = J s and w = J (f J kappa), so the clamp is exact and no continuity
conditions between elements are needed: the jump of the stretch at a concentrated mass costs no
accuracy. Convergence is exponential in the order.

The functions of stretch are divided by the root of the axial stiffness about the equilibrium: so
the stiffness of their coefficients is the identity.

All functions take a stack of beams, in the leading axis.
"""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from beamviz.mechanics.straight_equilibrium import AxialProblem, AxialState
from beamviz.mechanics.straight_errors import (
    ROUNDING_FACTOR,
    Matrices,
    quadrature_errors,
    rounding_errors,
    tail_energies,
    truncation_errors,
)
from beamviz.mechanics.straight_properties import BeamStack
from beamviz.mechanics.straight_residual import LEFT, lacking_energies, rotary_inertia
from beamviz.solver import eigen
from beamviz.solver.constitutive import axial_stiffness, bending_stiffness
from beamviz.solver.eigen import EPS
from beamviz.solver.problem import Problem
from beamviz.space.grid import Grid
from beamviz.space.trial import Trial


class StraightModes(NamedTuple):
    """Equilibria and the lowest modes of both families in one list: of a stack of beams, or of one
    beam without the leading axis.

    Without Coriolis forces mode k is column mode_order[k] of kappa and s, concatenated. With them
    mode_order is None, and column k of both, complex, is mode k.
    """

    grid: Grid
    orders: tuple[tuple[int, ...], tuple[int, ...]]  # of the elements, across the beam and along it
    f: NDArray  # (..., n) stretch at the Gauss points
    iterations: int
    margin: NDArray  # (...) of the equilibrium, 0 at a limit
    # Derivative of the rotation (..., n, modes). Where the root is not clamped the angle there is
    # one more unknown, (..., n + 1, modes).
    kappa: NDArray
    s: NDArray  # (..., n, modes) gradient of the displacement along the beam
    mode_order: NDArray | None  # (..., modes)
    bending_energy_fraction: NDArray  # (..., modes) share of the kinetic energy
    omega_squared: NDArray  # (..., modes) ascending
    truncation: NDArray  # (..., modes, elements) error of omega^2 from the order of each element
    rounding: NDArray  # (..., modes) error of omega^2 from rounding
    lowest_bending: NDArray  # (...) omega^2; with Coriolis forces of the lowest mode

    def of_each_beam(self) -> Iterator["StraightModes"]:
        """The modes of each beam of a stack."""
        grid, orders, f, iterations, *arrays = self
        for k in range(len(f)):
            grid_of_beam = grid if grid.breaks.ndim == 1 else grid[k]
            rows: list[Any] = [None if x is None else x[k] for x in arrays]
            yield StraightModes(grid_of_beam, orders, f[k], iterations, *rows)


def lowest_modes(
    axial: AxialProblem, trial: Trial, state: AxialState, count: int, problem: Problem
) -> StraightModes:
    """The `count` lowest modes about the equilibria of a stack of beams, on the mesh of the trial
    functions.

    With Coriolis forces no beam of several may be at rest or point inward; LinAlgError is raised
    where one of several is unstable.
    """
    matrices = stiffness_and_mass(axial, trial, state.f, problem)
    coupled = problem.gyroscopic and axial.beams.rotating
    solve = gyroscopic_modes if coupled else uncoupled_modes
    return solve(axial, trial, state, matrices, count, problem)


def stiffness_and_mass(axial: AxialProblem, trial: Trial, f: NDArray, problem: Problem) -> Matrices:
    """Vibration about the stretch f (beams, n).

    The tension N = gamma^2 int_x^1 rho (u + delta) is computed from equilibrium: mu^2 n(f) would
    cancel where f is near 1.
    """
    _, properties, beams, law = axial
    n, rows = f.shape[-1], rows_with_root(trial, beams)
    stiffness = np.zeros((len(f), 2 * n))
    stiffness[:, :n] = trial.bending_weights * bending_stiffness(f, problem.curvature_power)
    if problem.stiffens:
        tension = beams.gamma**2 * (np.matvec(properties.G, f) + beams.delta * properties.g)
        stiffness[:, n:] = tension * f
    K = rows.mT @ (stiffness[..., None] * rows)
    across = f[..., None] * rows[..., n:, :]  # w' = f theta
    M = across.mT @ (properties.G @ across)
    if beams.hinged:
        K[:, -1, -1] += beams.root
    if beams.has_inertia:
        add_rotary_inertia(K, M, axial, trial, problem)
    along = axial_stiffness(f, beams.mu, law)
    S = trial.stretch / np.sqrt(along)[..., None]
    return Matrices(K, M, S, stiffness, properties.axial * along)


def rows_with_root(trial: Trial, beams: BeamStack) -> NDArray:
    """`Trial.rows`. Where the root is not clamped, its angle is one more unknown, the last."""
    if not beams.hinged:
        return trial.rows
    root = np.zeros((*trial.rows.shape[:-1], 1))
    root[..., root.shape[-2] // 2 :, :] = 1.0
    return np.concatenate((trial.rows, root), axis=-1)


def curvature(trial: Trial, coefficients: NDArray) -> NDArray:
    """kappa (..., n, modes) of coefficients (..., unknowns, modes), and after it the angle at the
    root where that is an unknown."""
    r = trial.rows.shape[-1]
    kappa = trial.bending @ coefficients[..., :r, :]
    if coefficients.shape[-2] == r:
        return kappa
    return np.concatenate((kappa, coefficients[..., r:, :]), axis=-2)


def rotation(grid: Grid, kappa: NDArray) -> NDArray:
    """The rotation theta (..., n, modes) of kappa (..., n, modes), or (..., n + 1, modes) with the
    angle at the root."""
    n = grid.points.shape[-1]
    if kappa.shape[-2] == n:
        return grid.integrals(kappa)
    return grid.integrals(kappa[..., :n, :]) + kappa[..., n:, :]


def with_root(rows: NDArray) -> NDArray:
    """Rows (..., n) that integrate kappa to an angle, with the angle of the root: (..., n + 1)."""
    return np.concatenate((rows, np.ones((*rows.shape[:-1], 1))), axis=-1)


def rotations_of_bodies(axial: AxialProblem, trial: Trial) -> NDArray:
    """Coefficients -> the angle of each of the bodies `masses`: (1 or beams, masses, unknowns)."""
    rows = axial.properties.to_bodies[:, 1:] @ trial.bending  # the first has no inertia
    return with_root(rows) if axial.beams.hinged else rows


def add_rotary_inertia(
    K: NDArray, M: NDArray, axial: AxialProblem, trial: Trial, problem: Problem
) -> None:
    """Add the rotary inertia of bodies, which turn with the beam, to K and M."""
    J, stiffness = rotary_inertia(axial.beams, problem)
    rows = rotations_of_bodies(axial, trial)
    M += rows.mT @ (J[:, None] * rows)
    K += axial.beams.gamma[..., None] ** 2 * (rows.mT @ (stiffness[:, None] * rows))


def uncoupled_modes(
    axial: AxialProblem,
    trial: Trial,
    state: AxialState,
    matrices: Matrices,
    count: int,
    problem: Problem,
) -> StraightModes:
    """The lowest modes of uncoupled families.

    The softening is a multiple of M: it shifts every omega^2, does not change the modes, and is
    subtracted at the end. The lowest omega^2 of a beam that turns about its root may be as small as
    the spring there is weak or the speed is low. Beside it the others would be rounding errors:
    they are computed with a shift, and the lowest one is the Rayleigh quotient of its shape.
    """
    beams = axial.beams
    K, M, S, _, _ = matrices
    A = S.mT @ axial.properties.G @ S
    compressed = may_be_indefinite(beams, problem)
    shift = eigen.COMPRESSED if compressed or beams.hinged else 0.0
    # Arrays of both families are (beams, 2, count), bending first.
    across, along, shifted, added = eigen.family_modes(K, M, A, count, shift)
    omega_squared = shifted - added
    relative_rounding = shifted / shifted[..., :1]  # largest in the high modes
    size = shifted
    diagonal = np.linalg.diagonal(K)
    if compressed or beams.hinged:
        # Compression cancels against bending stiffness, and the rotation about the root against
        # bending in the motion of a heavy mass: sum of absolute terms.
        shifted_diagonal = diagonal + added[:, 0] * np.linalg.diagonal(M)
        size = np.stack((np.vecmat(shifted_diagonal, across**2), shifted[:, 1]), axis=1)
    if beams.hinged and not compressed:
        lowest = across[..., 0]
        omega_squared[:, 0, 0] = np.vecdot(lowest, np.matvec(K, lowest))
        size[:, 0, 0] = np.vecdot(diagonal, lowest**2)
    scale = abs(omega_squared) + eigen.COMPRESSED
    s = S @ along
    kappa = curvature(trial, across)
    tail = tail_energies(trial, matrices, across, s)
    if trial.has_kinks:
        squares = omega_squared[:, 0], omega_squared[:, 1]
        shapes = kappa, s
        lack = lacking_energies(axial, trial, state.f, matrices, shapes, squares, None, problem)
        omega_squared = omega_squared - lack.sum(axis=-1)
        tail += LEFT * lack
    truncation = truncation_errors(axial, trial, state, scale, tail)
    rounding = rounding_errors(state, scale, size, relative_rounding)
    if trial.quadrature:
        truncation += quadrature_errors(trial, across, along)
    omega_squared = omega_squared - softening_of_families(beams, problem)
    if beams.root == 0:
        free = turns_freely(beams, problem)
        omega_squared[free, 0, 0], truncation[free, 0, 0] = 0.0, 0.0
        rounding[free, 0, 0] = EPS**2
    # The two families in one list of 2 count modes.
    stack, in_family = len(omega_squared), omega_squared.shape[-1]
    listed = omega_squared.reshape(stack, -1)
    order = listed.argsort(axis=-1)[:, :count]
    beam = np.arange(stack)[:, None]
    return StraightModes(
        grid=trial.grid,
        orders=trial.elements.all_orders,
        f=state.f,
        iterations=state.iterations,
        margin=state.margin,
        kappa=kappa,
        s=s,
        mode_order=order,
        bending_energy_fraction=(order < in_family).astype(float),
        omega_squared=listed[beam, order],
        truncation=truncation.reshape(*listed.shape, -1)[beam, order],
        rounding=rounding.reshape(listed.shape)[beam, order],
        lowest_bending=omega_squared[:, 0, 0],
    )


def softening_of_families(beams: BeamStack, problem: Problem) -> NDArray:
    """gamma^2 (beams, 2, 1) by which softening lowers omega^2 of bending and of stretching; 0 of
    bending out of the plane of rotation."""
    softens = np.array([[problem.chordwise], [True]])
    return beams.gamma[..., None] ** 2 * (softens & problem.softening)


def may_be_indefinite(beams: BeamStack, problem: Problem) -> bool:
    """Whether the stiffness of bending, without softening, may not be positive definite."""
    free = beams.root == 0 and not (beams.rotating and problem.stiffens)
    # Flapwise, centrifugal forces turn a body that is long along the axis of rotation away from it.
    tilts = not problem.chordwise and any(Jx > Jz for Jx, _, Jz in inertias_of(beams))
    return beams.inward or free or tilts


def inertias_of(beams: BeamStack) -> list[tuple[float, float, float]]:
    """The principal moments of inertia of the bodies."""
    return [mass.inertia for mass in beams.masses]


def turns_freely(beams: BeamStack, problem: Problem) -> NDArray:
    """Whether the first mode of each beam (beams,) is a rigid rotation about a hinge that nothing
    holds: at rest; without stiffening; and in the plane of rotation about the axis of rotation."""
    gamma, delta = beams.gamma[:, 0], beams.delta[:, 0]
    if beams.root != 0:
        return np.zeros(len(gamma), bool)
    if not problem.chordwise:
        steady = problem.stiffens or any(Jz != Jx for Jx, _, Jz in inertias_of(beams))
        return (gamma == 0) | (not steady)
    return (gamma == 0) | ((delta == 0) & problem.stiffens & problem.softening)


def gyroscopic_modes(
    axial: AxialProblem,
    trial: Trial,
    state: AxialState,
    matrices: Matrices,
    count: int,
    problem: Problem,
) -> StraightModes:
    """The lowest modes of both families coupled by Coriolis forces.

    With T(omega) = K - omega^2 M + 2 gamma omega G, G the gyroscopic matrix, an error e of a shape
    z changes omega^2 by e' T e 2 omega / |z' dT/domega z|, where |z' dT/domega z| = omega +
    z' K z / omega.
    """
    gamma, S, Kb = axial.beams.gamma[..., None], matrices.S, matrices.K
    Fa, Fb = weighted_displacements(axial, trial, state.f, S)
    Ka = np.eye(S.shape[-1]) + np.zeros((len(S), 1, 1))
    if problem.softening:
        Ka, Kb = Ka - gamma**2 * (Fa.mT @ Fa), Kb - gamma**2 * matrices.M
    max_rounding = problem.tolerance / (10 * ROUNDING_FACTOR * EPS)
    free = turns_freely(axial.beams, problem)
    modes = eigen.gyroscopic_modes((Ka, Kb), (Fa, Fb), gamma, count, max_rounding, bool(free.any()))
    omega_squared = modes.omega_squared
    # Each shape is real or imaginary: real + imag is its size with its sign.
    across, along = modes.b.real + modes.b.imag, modes.a.real + modes.a.imag
    kappa, s = curvature(trial, modes.b), S @ modes.a
    size = abs(omega_squared) + gamma[..., 0] ** 2
    scale = size + eigen.COMPRESSED
    share = 2 * abs(omega_squared) / (abs(omega_squared) + abs(modes.stored))
    tail = tail_energies(trial, matrices, across, S @ along)
    if trial.has_kinks:
        square = omega_squared + gamma[..., 0] ** 2 * problem.softening
        coupling = 2 * gamma[..., 0] * np.sqrt(-omega_squared + 0j)
        shapes, squares = (kappa, s), (square, square)
        lack = lacking_energies(axial, trial, state.f, matrices, shapes, squares, coupling, problem)
        omega_squared = omega_squared - share * lack.sum(axis=(1, 3))
        tail += LEFT * lack
    tail = tail.sum(axis=1) * share[..., None]
    if not modes.definite:  # unstable: compression and a shift cancel, as in uncoupled_modes
        size = scale + np.vecmat(abs(np.linalg.diagonal(Kb)), across**2)
        size += (along**2).sum(axis=-2)
    truncation = truncation_errors(axial, trial, state, scale, tail)
    rounding = rounding_errors(state, scale, size, modes.relative_rounding)
    if trial.quadrature:
        truncation += quadrature_errors(trial, across, along).sum(axis=1)
    if free.any():
        lowest = abs(omega_squared[0]).argmin()
        omega_squared[0, lowest], truncation[0, lowest] = 0.0, 0.0
        rounding[0, lowest] = EPS**2
    return StraightModes(
        grid=trial.grid,
        orders=trial.elements.all_orders,
        f=state.f,
        iterations=state.iterations,
        margin=state.margin,
        kappa=kappa,
        s=s,
        mode_order=None,
        bending_energy_fraction=modes.fraction,
        omega_squared=omega_squared,
        truncation=truncation,
        rounding=rounding,
        lowest_bending=omega_squared[:, 0],
    )


def weighted_displacements(
    axial: AxialProblem, trial: Trial, f: NDArray, S: NDArray
) -> tuple[NDArray, NDArray]:
    """F of both families with M = F' F, along the beam in terms of c, s = S c (beams, m, r), and
    across it (beams, m, unknowns): displacements at the Gauss points and at the bodies, and the
    rotations of these, times the root of the mass or inertia."""
    _, properties, beams, _ = axial
    n, bodies = f.shape[-1], properties.alpha.shape[-1]
    F = np.empty((len(f), n + bodies, n))
    F[..., :n, :] = np.sqrt(properties.mass)[..., None] * trial.J
    F[..., n:, :] = properties.alpha[..., None] ** 0.5 * properties.to_bodies
    along, across = F @ S, F @ (f[..., None] * rows_with_root(trial, beams)[..., n:, :])
    if beams.has_inertia:
        Jz = np.array(inertias_of(beams))[:, 2]
        turning = np.sqrt(Jz)[:, None] * rotations_of_bodies(axial, trial)
        still = np.zeros((len(along), len(Jz), along.shape[-1]))
        turning = np.broadcast_to(turning, (len(across), *turning.shape[-2:]))
        along, across = np.hstack((along, still)), np.hstack((across, turning))
    return along, across
