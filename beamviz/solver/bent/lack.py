"""The residuals of a deflected state and of its modes at the Gauss points, and what they lack.

An element that spans stations of a blade has many more Gauss points than functions. In the space of
all values of f and kappa at the points the shortest deformations change the stored energy alone,
whose second derivative D is diagonal: a residual r is then balanced by the change - D^-1 r of f and
kappa, and of a mode v* T(s) v by - r* D^-1 r, as for straight blades
(`beamviz.mechanics.straight_residual`).
"""

import numpy as np
from numpy.typing import NDArray

from beamviz.mechanics.planar import MAX_STRETCH
from beamviz.solver.bent.beam import LEAST_RIGIDITY, BentState, product


def rigidities(state: BentState) -> tuple[NDArray, NDArray]:
    """D (n,) of f and of kappa, without softening by compression."""
    bent = state.beam
    axial = np.maximum(bent.section.law.stiffness(state.f), LEAST_RIGIDITY)
    bending = bent.section.bending * bent.section.power_of(state.f)
    return bent.w * bent.section.axial * axial, bent.w * bending


def lack_of_state(state: BentState) -> tuple[NDArray, NDArray]:
    """What f and kappa (n,) lack: D^-1 r of the residual of the equilibrium, times -1. That of f is
    bounded as in a step of Newton's method."""
    bent, loads = state.beam, state.section_loads
    force, moment = bent.section.forces(state.f, state.kappa)
    of_stretch = bent.w * force + loads.real
    of_angle = bent.w * moment + (state.f * loads.imag) @ bent.trial.J
    of_angle += state.body_moments @ bent.to_turning
    axial, bending = rigidities(state)
    bound = MAX_STRETCH * state.f
    return np.clip(-of_stretch / axial, -bound, bound), -of_angle / bending


def whole(state: BentState) -> BentState:
    """The state with what it lacks; see `BentState.shifted`."""
    return state.shifted(*lack_of_state(state)) if state.beam.trial.has_kinks else state


def lack_of_modes(state: BentState, s: NDArray, V: NDArray) -> NDArray:
    """r* D^-1 r (elements, modes) of modes with exponents s and vectors V (size, modes), r the
    residual T(s) v at the Gauss points: in the elements that span stations, 0 in the others."""
    bent, loads, r = state.beam, state.section_loads, state.beam.along
    f, w = state.f[:, None], bent.w[:, None]
    stretch, kappa, turn = (
        product(A, part) for A, part in ((bent.Z, V[:r]), (bent.B, V[r:]), (bent.S, V[r:]))
    )
    ff, fk, kk = (part[:, None] for part in bent.section.stiffness(state.f, state.kappa))
    along, across = section_loads_of_modes(state, s, V)
    along = along + loads.imag[:, None] * turn
    across = across - loads.real[:, None] * turn
    moment = f * across + loads.imag[:, None] * stretch
    of_stretch = w * (ff * stretch + fk * kappa) + along
    of_angle = w * (fk * stretch + kk * kappa) + product(bent.trial.J.T, moment)
    if len(bent.masses.rotary):
        restoring = bent.masses.restoring_stiffness(state.loading, state.body_angles)[:, None]
        turned = product(bent.turning, V[r:])
        moments = (restoring + s**2 * bent.masses.rotary[:, None]) * turned
        of_angle = of_angle + product(bent.to_turning.T, moments)
    axial, bending = (D[:, None] for D in rigidities(state))
    energies = abs(of_stretch) ** 2 / axial + abs(of_angle) ** 2 / bending
    return bent.trial.of_kinked(energies).T


def section_loads_of_modes(state: BentState, s: NDArray, V: NDArray) -> tuple[NDArray, NDArray]:
    """The forces of inertia of modes on all that lies further out than each Gauss point, times its
    weight, along the section and across it (n, modes)."""
    bent, (gamma, rate, in_plane, _) = state.beam, state.loading
    root = np.sqrt(bent.mass)[:, None]
    x, y = root * state.displaced(V)  # mass times the displacements (m, modes)
    swirl = rate + 2 * gamma * s * bent.problem.coriolis_factor
    force_x = (s**2 - gamma**2) * x - swirl * y
    force_y = (s**2 - gamma**2 * in_plane) * y + swirl * x
    n, cos, sin = len(bent.w), state.e.real[:, None], state.e.imag[:, None]
    total_x, total_y = (
        product(bent.trial.J.T, p[:n]) + product(bent.to_moving.T, p[n:])
        for p in (force_x, force_y)
    )
    return cos * total_x + sin * total_y, cos * total_y - sin * total_x
