"""States that a motion starts from: an equilibrium, free, under a force or with a point held aside,
or amplitudes of modes about it."""

from collections.abc import Callable
from contextlib import suppress

import numpy as np
from numpy.typing import NDArray

from beamviz.beam import Beam
from beamviz.dynamics.equation import AnyBeam
from beamviz.errors import NotConverged
from beamviz.mechanics.inertia import Loading
from beamviz.solver import Solution
from beamviz.solver.continuation import (
    Root,
    balancing_step,
    bordered_step,
    continue_load,
    newton,
    newton_at,
)
from beamviz.solver.pencil.inverse import inverse_modes_with_shift
from beamviz.space.grid import Grid, make_grid
from beamviz.space.spans import ends_of_spans

# Gauss points of the shapes of modes, in proportion to the length of a span, and more in each.
MODE_ORDER, MORE_ORDER = 20, 8
SMALLEST_SHARE = 1e-4  # of a force or a deflection in one step, at which following is given up


def equilibrium(beam: AnyBeam, solution: Solution) -> NDArray:
    """q (n,) of the equilibrium of a solution, by Newton's method from its positions."""
    _, f, theta = solution.equilibrium.curve(beam.points)
    guess = beam.nearest(f, theta)
    loading = Loading(solution.beam.gamma)
    root = newton(lambda q: balancing_step(beam.state(q, loading)), guess)
    if root is None:
        raise NotConverged(
            "Newton's method leaves the equilibrium on the elements of the motion; ask for a"
            " smaller tolerance, or with method ancf for more elements"
        )
    return root.state


def under_force(beam: AnyBeam, q: NDArray, gamma: float, force: float) -> NDArray:
    """q (n,) of the equilibrium under a force [E I / L^2] across the unloaded beam at the point
    `force_at`, followed from the equilibrium q without it."""

    def increment(share: float, q: NDArray) -> NDArray:
        return balancing_step(beam.state(q, Loading(gamma, force=1j * share * force)))

    return followed(
        beam, increment, q, f"release = {force:g}: the equilibrium under this force", force
    )


def held_aside(beam: AnyBeam, q: NDArray, gamma: float, deflection: float) -> tuple[NDArray, float]:
    """q (n,) of the equilibrium in which the point `force_at` has a deflection y [L], followed from
    the equilibrium q without a force, and the force:

        R(q) - force dy/dq = 0,    y(q) = deflection.
    """
    at = np.array([beam.force_at])
    start = beam.state(q).positions(at)[0].imag
    n = len(q)

    def increment(share: float, z: NDArray) -> NDArray:
        q, force = z[:n], z[n]
        state = beam.state(q, Loading(gamma, force=1j * force))
        dy = state.displacement_at(beam.force_at).imag
        target = start + share * (deflection - start)
        missing = state.positions(at)[0].imag - target
        return bordered_step(state, -dy, np.append(dy, 0.0), missing)

    z = followed(beam, increment, np.append(q, 0.0), "pulled aside: the equilibrium", deflection)
    return z[:n], float(z[n])


def followed(
    beam: AnyBeam,
    increment: Callable[[float, NDArray], NDArray],
    start: NDArray,
    subject: str,
    target: float,
) -> NDArray:
    """The equilibrium at the whole of what is applied, followed from that at none of it: the
    unknowns, and what else a step of Newton's method changes."""
    reached, law = 0.0, beam.theory.law

    def margin(share: float, z: NDArray) -> float:
        """The least slope of the strain law, 0 at the end of its range."""
        nonlocal reached
        slope = float(law.stiffness(beam.state(z[: beam.size]).f).min())
        reached = max(reached, share) if slope > 0 else reached
        return slope

    with suppress(NotConverged):
        path: Root = continue_load(
            newton_at(increment), start, 1.0, margin, precision=SMALLEST_SHARE
        )
        if path.limit is None:
            return path.state
    raise NotConverged(
        f"{subject} was followed to {reached * target:.4g} of {target:.4g} only; ask for less"
    )


def with_modes(
    beam: AnyBeam,
    q: NDArray,
    solution: Solution,
    amplitudes: dict[int, float],
    turning: float = 1.0,
) -> tuple[NDArray, NDArray]:
    """q and v (n,) about the equilibrium q at the phase in which each mode has its amplitude.
    turning: -1 where the hub turns the other way, which gives the mirror image of the modes.

    The shapes, scaled to a largest displacement of 1, are taken as changes of stretch and angle,
    which bend the beam without stretching it however large they are.
    """
    grid = grid_of_spans(solution.beam)
    x = grid.points
    _, f, theta = solution.equilibrium.curve(x)
    e = np.exp(1j * theta)
    moved, rates = np.zeros((2, len(x)), complex)  # in the axes of the hub
    everywhere = np.linspace(0, 1, 201)
    for k, amplitude in amplitudes.items():
        size = np.linalg.norm(solution.shape(k, everywhere), axis=1).max()
        along, across = amplitude / size * solution.shape(k, x).T  # complex in time
        along = turning * along  # the mirror image, in the opposite phase
        rate = 1j * np.nan_to_num(solution.frequencies[k])
        moved += (along.real + 1j * across.real) * e
        rates += ((rate * along).real + 1j * (rate * across).real) * e
    slopes = np.linalg.solve(grid.integration_matrix, np.column_stack((moved, rates))) / e[:, None]
    rows = grid.at(beam.points)
    slope, slope_rate = (rows @ slopes).T
    _, f, theta = solution.equilibrium.curve(beam.points)
    moved_f, moved_theta = f + slope.real, theta + slope.imag / f
    angle_rate = slope_rate.imag / moved_f
    change = beam.nearest(moved_f, moved_theta) - beam.nearest(f, theta)
    return q + change, beam.nearest_rates(moved_f, moved_theta, slope_rate.real, angle_rate)


def grid_of_spans(beam: Beam) -> Grid:
    """A grid on which the displacements of low modes are differentiated."""
    ends = np.array(ends_of_spans(beam))
    orders = np.ceil(MODE_ORDER * np.diff(ends)).astype(int) + MORE_ORDER
    return make_grid(ends, tuple(orders.tolist()))


def damping_matrix(beam: AnyBeam, q: NDArray, gamma: float, ratio: float) -> NDArray:
    """D (n, n) that gives every mode without Coriolis forces about the equilibrium q the same
    damping ratio: the sum of 2 ratio omega (M phi)(M phi)', phi of unit modal mass."""
    state = beam.state(q, Loading(gamma))
    K, M = state.stiffness, state.inertia
    K = (K + K.T) / 2
    # Inverted, as M is singular where the root turns: an angle that is zero at all Gauss points
    # moves no mass. M phi is sqrt(nu) K v of a mode v of unit stiffness, and omega^2 is 1 / nu.
    nu, v, shift = inverse_modes_with_shift(M, K, len(M), 0.0)
    forces = (K + shift * M) @ v.T
    return (forces * (2 * ratio * np.sqrt(np.maximum(nu - shift * nu**2, 0.0)))) @ forces.T
