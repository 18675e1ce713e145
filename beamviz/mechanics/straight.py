"""Vibration of stretched straight beams.

The unknowns are coefficients of the trial functions of a few elements (`beamviz.space.trial`): of
the gradient s = du' for stretching, of the derivative kappa = theta' of the rotation for bending.
Displacements are integrals, u = J s and w = J (f J kappa), so the clamp is exact and no continuity
conditions between elements are needed: the jump of the stretch at a concentrated mass costs no
accuracy. Convergence is exponential in the order.

Bending has a component in the plane of rotation, one out of it, or both, coupled where the section
is turned by phi from the plane:

    U = 1/2 int f^p kappa' D kappa + N f theta' theta dx,   D = R(phi) diag(EI, EI_flap) R(phi)'.

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
    Matrices,
    errors_of_squares,
    quadrature_errors,
    rounding_errors,
    tail_energies,
)
from beamviz.mechanics.straight_properties import BeamStack
from beamviz.mechanics.straight_residual import (
    LEFT,
    lacking_energies,
    rotary_inertia,
    split_root,
    turn_of_bodies,
)
from beamviz.solver import pencil as pencils
from beamviz.solver.constitutive import axial_stiffness, bending_stiffness
from beamviz.solver.pencil.inverse import COMPRESSED
from beamviz.solver.pencil.matrices import EPS, TINY, Families, Family
from beamviz.solver.problem import Problem
from beamviz.solver.stability import (
    cancelled_softening,
    definiteness_of_bending,
    softening_of_families,
    turns_freely,
)
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
    # Derivative of the rotation (..., c n, modes) of c components. Where the root is not clamped
    # the angles there are more unknowns, (..., c n + c, modes).
    kappa: NDArray
    s: NDArray  # (..., n, modes) gradient of the displacement along the beam
    mode_order: NDArray | None  # (..., modes)
    bending_energy_fraction: NDArray  # (..., modes) share of the kinetic energy
    omega_squared: NDArray  # (..., modes) ascending
    truncation: NDArray  # (..., modes, elements) error of omega^2 from the order of each element
    rounding: NDArray  # (..., modes) error of omega^2 from rounding
    lowest_bending: NDArray  # (...) omega^2; with Coriolis forces of the lowest mode
    # (..., modes) share of the kinetic energy in the plane of rotation; None of one component
    in_plane_fraction: NDArray | None = None

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
    n, c, rows = f.shape[-1], trial.components, rows_with_root(trial, beams)
    stiffness = np.zeros((len(f), 2 * c * n))
    powers = bending_stiffness(f, problem.curvature_power)
    stiffness[:, : c * n] = trial.bending_weights * for_components(powers, c)
    if problem.stiffens:
        tension = beams.gamma**2 * (np.matvec(properties.G, f) + beams.delta * properties.g)
        stiffness[:, c * n :] = for_components(tension * f, c)
    K = rows.mT @ (stiffness[..., None] * rows)
    M, M_out = None, None
    for component, in_plane in enumerate(problem.components_in_plane):
        first = (c + component) * n
        across = f[..., None] * rows[..., first : first + n, :]  # w' = f theta
        mass = across.mT @ (properties.G @ across)
        if c > 1 and in_plane and problem.softening:
            K -= beams.gamma[..., None] ** 2 * mass
        if c > 1 and not in_plane:
            M_out = mass
        M = mass if M is None else M + mass
    assert M is not None
    if beams.hinged:
        at_root = np.arange(-c, 0)
        K[:, at_root, at_root] += beams.root
    if beams.has_inertia:
        add_rotary_inertia(K, M, M_out, axial, trial, problem)
    along = axial_stiffness(f, beams.mu, law)
    S = trial.stretch / np.sqrt(along)[..., None]
    return Matrices(K, M, S, stiffness, properties.axial * along, M_out)


def for_components(values: NDArray, c: int) -> NDArray:
    """Values (beams, n) at the points, the same for each of c components: (beams, c n)."""
    return values if c == 1 else np.tile(values, c)


def rows_with_root(trial: Trial, beams: BeamStack) -> NDArray:
    """`Trial.rows`. Where the root is not clamped, its angle of each component is one more unknown,
    the last."""
    if not beams.hinged:
        return trial.rows
    c = trial.components
    root = np.zeros((*trial.rows.shape[:-1], c))
    n = root.shape[-2] // (2 * c)
    for component in range(c):
        first = (c + component) * n
        root[..., first : first + n, component] = 1.0
    return np.concatenate((trial.rows, root), axis=-1)


def curvature(trial: Trial, coefficients: NDArray) -> NDArray:
    """kappa (..., c n, modes) of coefficients (..., unknowns, modes), and after it the angles at
    the root where these are unknowns."""
    r = trial.rows.shape[-1]
    kappa = trial.curvatures @ coefficients[..., :r, :]
    if coefficients.shape[-2] == r:
        return kappa
    return np.concatenate((kappa, coefficients[..., r:, :]), axis=-2)


def rotation(grid: Grid, kappa: NDArray) -> NDArray:
    """The rotation theta (..., c, n, modes) of kappa (..., c n, modes), perhaps with the angles at
    the root, (..., c n + c, modes)."""
    n = grid.points.shape[-1]
    curvatures, root = split_root(kappa, kappa.shape[-2] // n, n)
    if curvatures.shape[-3] == 1:
        angle: NDArray = grid.integrals(curvatures[..., 0, :, :])[..., None, :, :]
    else:
        angle = np.stack([grid.integrals(part) for part in np.moveaxis(curvatures, -3, 0)], -3)
    return angle + root


def rotations_of_bodies(axial: AxialProblem, trial: Trial) -> NDArray:
    """Coefficients -> the angles of each of the bodies `masses`: (1 or beams, c, masses, unknowns)
    of c components."""
    n, c = len(trial.J), trial.components
    functions = trial.curvatures.reshape(c, n, -1)
    rows = axial.properties.to_bodies[:, None, 1:] @ functions  # the first has no inertia
    if not axial.beams.hinged:
        return rows
    root = np.broadcast_to(np.eye(c)[:, None, :], (*rows.shape[:-1], c))
    return np.concatenate((rows, root), axis=-1)


def add_rotary_inertia(
    K: NDArray,
    M: NDArray,
    M_out: NDArray | None,
    axial: AxialProblem,
    trial: Trial,
    problem: Problem,
) -> None:
    """Add the rotary inertia of bodies, which turn with the beam, to K and M, and in space to the
    part of M that is out of the plane of rotation."""
    J, stiffness = rotary_inertia(axial.beams, problem)
    if problem.chordwise and problem.softening:
        stiffness = stiffness + J  # a balance: the softening of the family is that of all of M
    rows = rotations_of_bodies(axial, trial)

    def form(of_bodies: NDArray) -> NDArray:
        """The sum of quadratic forms (masses, c, c) of the angles of each body."""
        weighted = np.einsum("mij,bjmu->bimu", of_bodies, rows)
        return (rows.mT @ weighted).sum(axis=1)

    M += form(J)
    if M_out is not None:
        M_out += form(J * np.diag([0.0, 1.0]))
    K += axial.beams.gamma[..., None] ** 2 * form(stiffness)


def uncoupled_modes(
    axial: AxialProblem,
    trial: Trial,
    state: AxialState,
    matrices: Matrices,
    count: int,
    problem: Problem,
) -> StraightModes:
    """The lowest modes of uncoupled families."""
    beams, S = axial.beams, matrices.S
    softening = softening_of_families(beams, problem)
    pencil = Families(
        across=Family(matrices.K, matrices.M),
        along=Family(None, S.mT @ axial.properties.G @ S),
        softening=softening,
        definiteness=definiteness_of_bending(beams, problem),
        rigid=turns_freely(beams, problem) if beams.root == 0 else None,
        cancelled=cancelled_softening(beams, problem),
    )
    modes = pencils.lowest_modes(pencil, count)
    # Arrays of both families are (beams, 2, count), bending first.
    across, along = modes.V
    omega_squared = modes.omega_squared
    # Without softening, which shifts omega^2; in space it does not shift that across the beam.
    scale = abs(omega_squared + softening) + COMPRESSED
    if pencil.cancelled is not None:
        scale += pencil.cancelled
    s = S @ along
    kappa = curvature(trial, across)
    tail = tail_energies(trial, matrices, across, s)
    if trial.has_kinks:
        squares = omega_squared[:, 0], omega_squared[:, 1]
        shapes = kappa, s
        lack = lacking_energies(axial, trial, state.f, matrices, shapes, squares, None, problem)
        omega_squared = omega_squared - lack.sum(axis=-1)
        tail += LEFT * lack
    truncation = errors_of_squares(axial, trial, state, scale, tail)
    rounding = rounding_errors(state, scale, modes.rounding)
    if trial.quadrature:
        truncation += quadrature_errors(trial, across, along)
    if modes.rigid is not None:
        omega_squared[modes.rigid], truncation[modes.rigid] = 0.0, 0.0
        rounding[modes.rigid] = EPS**2
    # The two families in one list of 2 count modes.
    stack, in_family = len(omega_squared), omega_squared.shape[-1]
    listed = omega_squared.reshape(stack, -1)
    order = listed.argsort(axis=-1)[:, :count]
    beam = np.arange(stack)[:, None]
    in_plane = None
    if matrices.M_out is not None:
        shares = np.ones((stack, 2, in_family))
        shares[:, 0] -= (across * (matrices.M_out @ across)).sum(axis=1)
        in_plane = np.clip(shares, 0.0, 1.0).reshape(stack, -1)[beam, order]
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
        in_plane_fraction=in_plane,
    )


def gyroscopic_modes(
    axial: AxialProblem,
    trial: Trial,
    state: AxialState,
    matrices: Matrices,
    count: int,
    problem: Problem,
) -> StraightModes:
    """The lowest modes of both families coupled by Coriolis forces.

    An error e of a shape v changes omega^2 by e* T(s) e times 2 omega over |v* T'(s) v|, the
    pairing.
    """
    beams, S, gamma = axial.beams, matrices.S, axial.beams.gamma[..., None]
    Fa, Fb = weighted_displacements(axial, trial, state.f, S)
    pencil = Families(
        across=Family(matrices.K, matrices.M, Fb),
        along=Family(None, F=Fa),
        softening=softening_of_families(beams, problem),
        gamma=problem.coriolis_factor * gamma,
        rigid=turns_freely(beams, problem) if beams.root == 0 else None,
        tolerance=problem.tolerance,
    )
    modes = pencils.lowest_modes(pencil, count)
    (b, a), omega_squared = modes.V, modes.omega_squared
    assert modes.fraction is not None
    # Each shape is real or imaginary: real + imag is its size with its sign.
    across, along = b.real + b.imag, a.real + a.imag
    kappa, s = curvature(trial, b), S @ a
    squares = abs(omega_squared)
    scale = squares + gamma[..., 0] ** 2 + COMPRESSED
    share = 2 * np.sqrt(squares) / np.maximum(modes.pairing, TINY)
    tail = tail_energies(trial, matrices, across, S @ along)
    if trial.has_kinks:
        factor = 2 * problem.coriolis_factor
        coupling = factor * gamma[..., 0] * np.sqrt(-omega_squared + 0j)
        shapes, both = (kappa, s), (omega_squared, omega_squared)
        lack = lacking_energies(axial, trial, state.f, matrices, shapes, both, coupling, problem)
        omega_squared = omega_squared - share * lack.sum(axis=(1, 3))
        tail += LEFT * lack
    tail = tail.sum(axis=1) * share[..., None]
    truncation = errors_of_squares(axial, trial, state, scale, tail)
    rounding = rounding_errors(state, scale, modes.rounding)
    if trial.quadrature:
        truncation += quadrature_errors(trial, across, along).sum(axis=1)
    if modes.rigid is not None:
        omega_squared[modes.rigid], truncation[modes.rigid] = 0.0, 0.0
        rounding[modes.rigid] = EPS**2
    in_plane = None
    if matrices.M_out is not None:
        out_of_plane = (across * (matrices.M_out @ across)).sum(axis=1)
        in_plane = np.clip(1 - out_of_plane, 0.0, 1.0)
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
        in_plane_fraction=in_plane,
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
    c, rows = trial.components, rows_with_root(trial, beams)
    along, parts = F @ S, []
    for component in range(c):
        first = (c + component) * n
        parts.append(F @ (f[..., None] * rows[..., first : first + n, :]))
    if beams.has_inertia:
        turning = rotations_by_root_of_inertia(axial, trial)
        parts.append(np.broadcast_to(turning, (len(f), *turning.shape[1:])))
    across = np.hstack(parts) if len(parts) > 1 else parts[0]
    still = across.shape[1] - along.shape[1]
    if still:
        along = np.hstack((along, np.zeros((len(along), still, along.shape[-1]))))
    return along, across


def rotations_by_root_of_inertia(axial: AxialProblem, trial: Trial) -> NDArray:
    """Rotations of the bodies about their principal axes times the root of the inertia (1 or beams,
    c masses, unknowns), in the plane of rotation or in space."""
    beams, angles = axial.beams, rotations_of_bodies(axial, trial)
    _, Jy, Jz = np.array([mass.inertia for mass in beams.masses]).T[..., None]
    if trial.components == 1:
        return np.sqrt(Jz) * angles[:, 0]
    c, s = (part[:, None] for part in turn_of_bodies(beams))
    v, w = angles[:, 0], angles[:, 1]
    return np.concatenate((np.sqrt(Jz) * (c * v + s * w), np.sqrt(Jy) * (c * w - s * v)), axis=1)
