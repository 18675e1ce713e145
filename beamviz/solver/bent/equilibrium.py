"""Bent equilibria: the stable state of lowest energy, and the states of a beam that spins up.

Without a spin-up the loads have a potential, and a stable state is one of its minima: descent
finds one from any guess. Guesses are the straight state bent along its buckling modes, and a beam
folded over at the clamp, from where it points outward. A spin-up is applied in steps, by Newton's
method from the stable state without it.
"""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from scipy.linalg import lapack

from beamviz.beam import Beam
from beamviz.errors import NotConverged
from beamviz.solver.bent.tangent import BentBeam, Tangent

DESCENT_STEPS, NEWTON_STEPS = 150, 12
MAX_TURN, MAX_STRETCH = 0.7, 0.3  # of a descent step: angle [rad], relative change of f
QUADRATIC = 0.05  # a Newton step below this size needs no line search
CONVERGED = 1e-7  # size of a Newton step after which the next one is rounding
SAME_ENERGY = 1e-9  # relative difference of two descents to the same state
SMALLEST_STEP = 1e-4  # of the spin-up
COLLAPSED, TORN = 1e-3, 1e3  # stretch where a descent ends: the strain law carries no more
SLOWER = 0.8  # ratio of speeds when a beam with a stable state is looked for
LIMIT_ACCURACY = 1e-5  # of a limit, relative; a mesh that is too coarse moves it more


class State(NamedTuple):
    """An equilibrium: its unknowns, its tangent, and the iterations it took."""

    beam: BentBeam
    q: np.ndarray  # (2 n,)
    tangent: Tangent
    iterations: int


def stable_states(beam: BentBeam) -> list[State]:
    """The stable states found from all guesses, lowest energy first, without mirror images."""
    states: list[State] = []
    for guess in _guesses(beam):
        state = descend(beam, guess)
        if state and not any(_same(state, other) for other in states):
            states.append(state)
    return sorted(states, key=lambda state: beam.energy(state.q))


def _same(a: State, b: State) -> bool:
    """Whether two states are one, or mirror images."""
    energy = b.beam.energy(b.q)
    return abs(a.beam.energy(a.q) - energy) <= SAME_ENERGY * (1 + abs(energy))


def _guesses(beam: BentBeam) -> Iterator[np.ndarray]:
    """Folded over at the clamp; the straight state, bent along its two lowest buckling modes."""
    w, n = beam.w, len(beam.w)
    width = 1 / max(1.0, beam.beam.gamma * math.sqrt(1 + abs(beam.beam.delta)))
    decay = np.exp(-beam.mesh.points / width)
    lever = beam.R @ np.ones(n) + abs(beam.beam.delta)
    force = (beam.beam.gamma / beam.beam.mu) ** 2 * ((beam.mass * lever) @ beam.R) / w
    f = np.clip(beam.law.stretch(force), 1.0, beam.law.max_stretch)
    yield np.concatenate((f, math.pi * decay / (w @ decay)))
    straight = straight_state(beam)
    if straight is None:
        return
    scale = beam.scale[n:]
    omega_squared, modes = np.linalg.eigh(scale[:, None] * straight.tangent.K[n:, n:] * scale)
    for k in range(min(2, int((omega_squared < 0).sum()))):
        kappa = scale * modes[:, k]
        yield np.concatenate((straight.q[:n], kappa * MAX_TURN / abs(beam.J @ kappa).max()))


def straight_state(beam: BentBeam) -> State | None:
    """The straight state, stable or not, by Newton's method in the stretch alone; None where it
    does not converge."""
    n = len(beam.w)
    q = np.concatenate((np.ones(n), np.zeros(n)))
    for iteration in range(1, DESCENT_STEPS + 1):
        tangent = beam.tangent(q)
        step = np.linalg.solve(tangent.K[:n, :n], -tangent.residual[:n])
        size = abs(step / q[:n]).max()
        q[:n] += step * min(1.0, MAX_STRETCH / size if size else 1.0)
        if size < CONVERGED:
            return State(beam, q, beam.tangent(q), iteration)
    return None


def descend(beam: BentBeam, q: np.ndarray) -> State | None:
    """The stable state that descent of the energy leads to; None where it finds none.

    Newton's method where the stiffness is positive definite and the step small; elsewhere a bounded
    step of descent, which leaves saddle points.
    """
    tangent, energy, last = beam.tangent(q), beam.energy(q), math.inf
    for iteration in range(1, DESCENT_STEPS + 1):
        step, size = _newton_step(beam, q, tangent)
        near = size < QUADRATIC and size <= last / 2
        if not near:
            if size > 1:
                step = _bounded_step(beam, q, tangent)
            shortened = _line_search(beam, q, step, energy, tangent.residual)
            if shortened is None:
                return None
            step = shortened
        q, last = q + step, size
        tangent, energy = beam.tangent(q), beam.energy(q)
        if near and size < CONVERGED:
            return State(beam, q, tangent, iteration)
        f, _ = beam.split(q)
        if f.min() < COLLAPSED or f.max() > TORN:
            return None
    return None


def _newton_step(beam: BentBeam, q: np.ndarray, tangent: Tangent) -> tuple[np.ndarray, float]:
    """Newton's step where the stiffness is positive definite, and its size, which is infinite
    elsewhere."""
    scale = beam.scale
    L, info = lapack.dpotrf(scale[:, None] * tangent.K * scale, lower=1)
    if info:
        return np.zeros_like(q), math.inf
    step = -scale * lapack.dpotrs(L, scale * tangent.residual, lower=1)[0]
    return step, _size(beam, q, step)


def _bounded_step(beam: BentBeam, q: np.ndarray, tangent: Tangent) -> np.ndarray:
    """A step of descent of size 1 at most: the eigenvalues of the stiffness, in units of the
    present rigidities, by their absolute values, with a shift as small as the size allows."""
    scale = 1 / np.sqrt(beam.rigidities(q))
    eigenvalues, U = np.linalg.eigh(scale[:, None] * tangent.K * scale)
    g = U.T @ (scale * tangent.residual)
    shift = 0.0
    for _ in range(60):
        step = -scale * (U @ (g / (abs(eigenvalues) + shift + 1e-12)))
        if _size(beam, q, step) <= 1:
            break
        shift = 2 * shift or 1e-6
    return step


def _size(beam: BentBeam, q: np.ndarray, step: np.ndarray) -> float:
    """The size of a step in units of the largest that descent takes."""
    (f, _), (df, dkappa) = beam.split(q), beam.split(step)
    return float(max(abs(beam.J @ dkappa).max() / MAX_TURN, abs(df / f).max() / MAX_STRETCH))


def _line_search(
    beam: BentBeam, q: np.ndarray, step: np.ndarray, energy: float, residual: np.ndarray
) -> np.ndarray | None:
    """The step, halved until the energy falls as it should; None where it does not."""
    rounding = 1e-13 * abs(energy)
    for _ in range(40):
        if beam.energy(q + step) <= energy + 1e-4 * (residual @ step) + rounding:
            return step
        step = step / 2
    return None


def newton(beam: BentBeam, q: np.ndarray) -> State | None:
    """The equilibrium near a guess, stable or not; None where Newton's method finds none."""
    scale = beam.scale
    for iteration in range(1, NEWTON_STEPS + 1):
        tangent = beam.tangent(q)
        K = scale[:, None] * tangent.K * scale
        step = -scale * np.linalg.solve(K, scale * tangent.residual)
        size = _size(beam, q, step)
        if not size < 2:
            return None
        q = q + step
        if size < CONVERGED:
            return State(beam, q, beam.tangent(q), iteration)
    return None


def limit_of_stability(beam: BentBeam) -> float:
    """The largest gamma up to which a stable state exists, for a beam that has none at its own.

    The state is followed upward from a slower beam that has one.
    """

    def slowed(gamma: float) -> BentBeam:
        return BentBeam(beam.mesh, beam.beam.replace(gamma=gamma), beam.problem)

    low = high = beam.beam.gamma
    found: State | None = None
    while found is None:
        low, high = SLOWER * low, low
        found = descend(slowed(low), next(_guesses(slowed(low))))
    q = found.q
    while high - low > LIMIT_ACCURACY * high:
        gamma = (low + high) / 2
        found = descend(slowed(gamma), q)
        if found is None:
            high = gamma
        else:
            low, q = gamma, found.q
    return low


def spin_up_state(beam: BentBeam, rest: State) -> State:
    """The state of a beam that spins up, followed from the stable state without the spin-up.

    Of two mirror images the one is followed that the Euler force bends further. Raises
    NotConverged with the spin-up reached.
    """
    target = beam.beam.spin_up
    state = rest._replace(q=_on_the_side_of_the_force(rest, target))
    reached, step = 0.0, 1.0
    while reached < 1:
        share = min(1.0, reached + step)
        loaded = BentBeam(beam.mesh, beam.beam.replace(spin_up=share * target), beam.problem)
        found = newton(loaded, state.q)
        if found is None:
            step /= 2
            if step < SMALLEST_STEP:
                raise NotConverged(
                    f"spin_up = {target:g}: the equilibrium was followed up to"
                    f" {reached * target:.6g}, not further; ask for a smaller spin_up"
                )
            continue
        state = found._replace(iterations=state.iterations + found.iterations)
        reached, step = share, 1.5 * step
    return state._replace(beam=beam)


def _on_the_side_of_the_force(state: State, spin_up: float) -> np.ndarray:
    """The state or its mirror image: that on which the Euler force of a spin-up does work."""
    beam, q = state.beam, state.q.copy()
    (f, kappa), (c, s) = beam.split(q), beam.directions(q)
    x, y = beam.R @ (f * c) + beam.beam.delta, beam.R @ (f * s)
    if -spin_up * (beam.mass @ (x * y)) < 0:
        q[len(f) :] = -kappa
    return q


def upward(beam: BentBeam, q: np.ndarray) -> np.ndarray:
    """The state or its mirror image: that whose tip has y >= 0."""
    f, kappa = beam.split(q)
    if beam.w @ (f * beam.directions(q)[1]) < 0:
        return np.concatenate((f, -kappa))
    return q


def without_spin_up(beam: Beam) -> Beam:
    """The same beam at a constant speed."""
    return beam.replace(spin_up=0.0) if beam.spin_up else beam
