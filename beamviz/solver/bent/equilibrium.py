"""Deflected equilibria at a constant speed: stable states by descent of the energy, and those near
a guess by Newton's method.

Without a spin-up the loads have a potential, and a stable state is one of its minima: descent
finds one from any guess. It is a method of its own, for from most guesses Newton's method leads to
saddle points or nowhere; its last steps are Newton's, and end by the same rule. Guesses are the
straight state bent along its buckling modes, and a beam folded over at the clamp, from where it
points outward.
"""

import math
from collections.abc import Iterator
from operator import attrgetter

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

from beamviz.errors import NoEquilibrium, NotConverged
from beamviz.mechanics.planar import MAX_TURN
from beamviz.mechanics.planar_mesh import folded_over, layer_widths
from beamviz.mechanics.straight_equilibrium import (
    axial_problem,
    has_unique_equilibrium,
)
from beamviz.mechanics.straight_properties import stack_of
from beamviz.solver import continuation
from beamviz.solver.bent.beam import BentBeam, BentState
from beamviz.solver.problem import interruption
from beamviz.solver.stability import may_buckle
from beamviz.space.grid import make_mesh

SOFT_ROOT = 5.0  # stiffness of a root spring below which a beam folds over at its root
DESCENT_TRIALS = 500
SMALLEST_SHIFT = 4.0**-12  # of the stiffness in a descent step, in units of the rigidities
QUADRATIC = 0.05  # a Newton step below this size needs no check of the energy
LARGER, SMALLER = 4.0, 16.0  # ratios of successive shifts: after a failure, after a success
FALL = 1e-4  # of the energy in a step, as a share of what its slope promises
HALVINGS = 3  # of elements, after which a state whose energy still changes is none
RESOLVED_ANGLE = 0.01  # relative change of its largest angle
SHRINKS = 0.2  # the same of a loop hidden by a long element; it was at least 0.3 in 4000 beams
RESOLVED = 1e-4  # change of the energy of a resolved state on shorter elements, of its terms
ROUNDED = 1e-5  # size of a Newton step that, if it no longer shrinks, is rounding error
ENERGY_ROUNDING = 1e-12  # of its terms
STRETCHES = 1e-3, 1e3  # at which a descent ends
BEYOND = 4.0  # times past the ends of a strain law's force, where a descent ends as well


def stable_states(beam: BentBeam) -> list[BentState]:
    """The stable states found from all guesses, lowest energy first, without mirror images."""
    states: list[BentState] = []
    for guess in guesses(beam):
        state = descend(beam, guess)
        if state and not any(map(state.is_same, states)):
            states.append(state)
    return sorted(states, key=attrgetter("energy"))


def resolved(state: BentState) -> BentState | None:
    """The state, on shorter elements where it needs them, if elements half as long have one of the
    same energy and the same largest angle; else None, as a long element may hide a loop, which
    shrinks when the element is halved."""
    for _ in range(HALVINGS):
        halved = state.beam.on(state.beam.elements.halved)
        finer = newton(halved, state.resampled(halved), stable=True)
        if finer is None:
            return None
        change = abs(finer.energy - state.energy)
        turn = abs(finer.largest_angle - state.largest_angle)
        if turn > SHRINKS * state.largest_angle:
            return None
        same = change <= RESOLVED * sum(finer.energies)  # which are 0 where nothing loads the beam
        if same and turn <= RESOLVED_ANGLE * state.largest_angle:
            return state
        state = finer
    return None


def guesses(beam: BentBeam) -> Iterator[NDArray]:
    """A stable straight state; folded over at the clamp; the straight state, bent along its two
    lowest buckling modes."""
    w, n = beam.w, len(beam.w)
    straight = straight_state(beam)
    if straight and straight.is_stable:
        yield straight.q
        if not may_buckle(beam.beam):
            return
    _, (at_clamp, _) = layer_widths(beam.beam, beam.problem)[0]
    decay = np.exp(-beam.grid.points / at_clamp)
    folded = folded_state(beam)
    f = folded.f if folded else np.ones(n)
    if beam.beam.root < SOFT_ROOT:  # turned over at the root
        yield beam.fitted(f, np.zeros(n), math.pi)
    else:
        yield beam.fitted(f, math.pi * decay / (w @ decay))
    if straight is None:
        return
    r = beam.along
    omega_squared, modes = np.linalg.eigh(straight.stiffness[r:, r:])
    for k in range(min(2, int((omega_squared < 0).sum()))):
        turning = modes[:, k] * MAX_TURN / abs(beam.S @ modes[:, k]).max()
        yield np.append(straight.q[:r], turning)


def straight_state(bent: BentBeam) -> BentState | None:
    """The straight state that is stable along the beam; None where there is none."""
    grid = bent.grid
    mesh = make_mesh(tuple(grid.breaks.tolist()), grid.orders)
    problem = axial_problem(mesh, stack_of([bent.beam]), bent.section.law)
    try:
        axial = problem.stable_state(has_unique_equilibrium(bent.beam, bent.section.law))
    except (NoEquilibrium, NotConverged):
        return None
    return BentState(bent, bent.fitted(axial.f[0], np.zeros(len(bent.w))), axial.iterations)


def folded_state(bent: BentBeam) -> BentState | None:
    """The state of the beam folded over; None where its strain law cannot carry the load."""
    return straight_state(BentBeam(bent.elements, folded_over(bent.beam), bent.problem))


def descend(beam: BentBeam, q: NDArray) -> BentState | None:
    """The stable state that descent of the energy leads to; None where it finds none.

    A step is that of Newton's method with a multiple of the rigidities, the shift, added to the
    stiffness. The larger the shift, the shorter the step: it grows until the matrix is positive
    definite, the step is bounded and the energy falls, so that the descent leaves saddle points.
    After such a step it falls again, near the state to 0, where Newton's method converges.
    """
    low = max(STRETCHES[0], beam.section.law.min_stretch / BEYOND)
    high = min(STRETCHES[1], beam.section.law.max_stretch * BEYOND)
    state, shift, last_shift, last_size = BentState(beam, q), 0.0, 1.0, math.inf
    for _ in range(DESCENT_TRIALS):
        interruption.get()()
        step, size = _shifted_step(state, shift)
        trial = BentState(beam, state.q + step, state.iterations + 1)
        # Near the state, where the energy changes by its rounding error, steps need no check.
        converges = not shift and size < min(QUADRATIC, last_size / 2)
        if not (converges or (size <= 1 and _falls(state, trial, step))):
            shift = LARGER * shift if shift else last_shift
            continue
        if not low < trial.f.min() <= trial.f.max() < high:
            return None
        state = trial
        if not shift and continuation.is_last(size, last_size, ROUNDED):
            return None if state.collapses else state
        last_size, last_shift = size, max(shift, SMALLEST_SHIFT)
        shift = shift / SMALLER if shift > SMALLER * SMALLEST_SHIFT else 0.0
    return None


def _falls(state: BentState, trial: BentState, step: NDArray) -> bool:
    """Whether the energy falls as it should in a step, or by less than its rounding."""
    allowed = state.energy + ENERGY_ROUNDING * sum(state.energies)
    return trial.energy <= allowed + FALL * (state.residual @ step)


def _shifted_step(state: BentState, shift: float) -> tuple[NDArray, float]:
    """Newton's step and its size, infinite where the stiffness is not positive definite. shift:
    added to the stiffness, in units of the present rigidities."""
    K = state.stiffness + shift * state.rigidity if shift else state.stiffness
    L, info = lapack.dpotrf(K, lower=1)
    if info:
        return np.zeros_like(state.q), math.inf
    step = -lapack.dpotrs(L, state.residual, lower=1)[0]
    return step, state.step_size(step)


def newton(beam: BentBeam, q: NDArray, stable: bool = False) -> BentState | None:
    """The equilibrium near a guess, a `stable` one on demand; None where Newton's method fails."""

    def increment(q: NDArray) -> NDArray:
        interruption.get()()
        return continuation.balancing_step(BentState(beam, q))

    root = continuation.newton(increment, q)
    state = BentState(beam, root.state, root.iterations) if root else None
    if state is None or not state.f.min() > 0:
        return None
    return state if not stable or state.is_stable else None
