"""Estimated errors of s of modes about deflected states: truncation by the order of each element,
and rounding. The formula is that of straight beams, `beamviz.space.refinement`."""

import numpy as np
from numpy.typing import NDArray

from beamviz.solver.bent.beam import BentState
from beamviz.solver.bent.lack import lack_of_state
from beamviz.solver.pencil.matrices import TINY, Modes, product
from beamviz.space.refinement import TRUNCATION_FACTOR, truncation_errors


def errors_of_modes(state: BentState, modes: Modes, lack: NDArray) -> tuple[NDArray, NDArray]:
    """Estimated truncation errors (modes, elements) and rounding errors (modes,) of s. lack
    (elements, modes): what is left of that of the modes, see `lack`.

    The truncation error is what the highest functions of each element contribute to v* T(s) v,
    T(s) = s^2 M + s C + K: those of the state in the tangent, and those of the shapes; in elements
    that span stations what state and shapes lack. Divided by y* T'(s) v it is the change of s. The
    quadrature of the stretch adds what it adds for straight beams.
    """
    bent, s, V = state.beam, modes.s, modes.V
    energies = _energies(state, V)
    kinked = bent.trial.is_kinked
    truncation = np.where(kinked[:, None], lack, _contributions_to_shapes(state, modes))
    f, kappa = lack_of_state(state) if bent.trial.has_kinks else (0 * state.f, 0 * state.f)
    for k, highest in enumerate(bent.highest):
        if kinked[k]:
            here = bent.trial.element_of_points == k
            other = state.shifted(here * f, here * kappa)
        else:
            lower = state.q.copy()
            lower[highest] = 0.0
            other = BentState(bent, lower)
        dK, dC, dM = _energies(other, V) - energies
        truncation[k] += abs(dK + s * dC + s**2 * dM)
    quadrature = bent.trial.quadrature / (TRUNCATION_FACTOR * len(kinked))
    truncation += quadrature * abs(energies[0])
    slope = np.maximum(2 * abs(s), TINY)  # of s^2
    squared = slope * truncation / np.maximum(modes.pairing, TINY)
    rigid = (V.conj() * product(state.rigidity, V)).sum(axis=0).real / energies[2].real
    scale = np.maximum(abs(s) ** 2, rigid)  # of s^2 without any softening
    tails = [bent.Z[:, along] @ state.q[along] for along, _ in bent.trial.highest]
    lost = np.array([4 * bent.w @ tail**2 / (bent.w @ state.f) ** 2 for tail in tails])
    of_squares = truncation_errors(squared.T, scale, lost, np.maximum(state.f[0], 1.0))
    return of_squares / slope[:, None], modes.rounding_of_s


def _contributions_to_shapes(state: BentState, modes: Modes) -> NDArray:
    """What the highest functions t of each element in shapes v contribute to |v* T(s) v|
    (elements, modes): t* T v + v* T t - t* T t."""
    s, V, highest = modes.s, modes.V, state.beam.highest
    terms = [(state.stiffness, 1.0), (state.inertia, s**2)]
    if state.gyroscopic is not None:
        terms.append((state.gyroscopic, s))
    contributions = np.zeros((len(highest), len(s)), complex)
    for matrix, factor in terms:
        right, left = product(matrix, V), product(matrix.T, V.conj())
        for k, unknowns in enumerate(highest):
            t = V[unknowns]
            inside = matrix[np.ix_(unknowns, unknowns)] @ t
            parts = t.conj() * (right[unknowns] - inside) + left[unknowns] * t
            contributions[k] += factor * parts.sum(axis=0)
    return abs(contributions)


def _energies(state: BentState, V: NDArray) -> NDArray:
    """v' K v, v' C v with the Coriolis matrix C, and v' M v (3, modes) of shapes."""
    moved = state.displaced(V)  # (2, m, modes)
    coriolis = 2 * state.beam.beam.gamma * state.beam.problem.coriolis_factor
    swirl = (moved[1].conj() * moved[0] - moved[0].conj() * moved[1]).sum(axis=0)
    turned = (abs(state.turned(V)) ** 2).sum(axis=0)
    mass = (abs(moved) ** 2).sum(axis=(0, 1)) + turned
    return np.array([state.stiffness_of(V), coriolis * swirl, mass])
