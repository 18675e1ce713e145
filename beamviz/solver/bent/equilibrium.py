"""Bent equilibria at a constant speed: stable states by descent of the energy, and Newton's method.

Without a spin-up the loads have a potential, and a stable state is one of its minima: descent
finds one from any guess. Guesses are the straight state bent along its buckling modes, and a beam
folded over at the clamp, from where it points outward.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import lapack

from beamviz.solver.bent.beam import BentBeam, Tangent
from beamviz.solver.bent.mesh_design import folded_beam
from beamviz.solver.hp.mesh import make_mesh

DESCENT_STEPS, NEWTON_STEPS, STRAIGHT_STEPS = 120, 12, 40
MAX_TURN, MAX_STRETCH = 0.7, 0.3  # of a descent step: angle [rad], relative change of f
SMALLEST_SHIFT = 4.0**-12  # of the stiffness in a descent step, in units of the rigidities
QUADRATIC = 0.05  # a Newton step below this size needs no line search
CONVERGED = 1e-7  # size of a Newton step after which the next one is rounding error
RESOLVED = 1e-4  # relative change of the energy of a resolved state on a finer mesh
SAME_ENERGY = 1e-9  # relative difference of two descents to the same state
STRAIGHT = 1e-6  # largest angle [rad] of a state that counts as straight
ROUNDED = 1e-5  # size of a Newton step that, if it no longer shrinks, is rounding error
ENERGY_ROUNDING = 1e-12  # of its terms
STRETCHES = 1e-3, 1e3  # at which a descent ends
BEYOND = 4.0  # times past the ends of a strain law's force, where a descent ends as well


@dataclass(frozen=True, eq=False)
class State:
    """An equilibrium: its unknowns, and the iterations it took."""

    beam: BentBeam
    q: np.ndarray  # (2 n,)
    iterations: int

    @cached_property
    def tangent(self) -> Tangent:
        """Residual and tangent stiffness."""
        return self.beam.tangent(self.q)


def stable_states(beam: BentBeam) -> list[State]:
    """The stable states found from all guesses, lowest energy first, without mirror images."""
    states: list[State] = []
    for guess in guesses(beam):
        state = descend(beam, guess)
        if state and not any(is_same(state, other) for other in states):
            states.append(state)
    return sorted(states, key=lambda state: beam.energy(state.q))


def is_straight(state: State) -> bool:
    """Whether no point of the beam has turned."""
    return state.beam.largest_angle(state.q) <= STRAIGHT


def is_resolved(state: State) -> bool:
    """Whether halved elements have the same stable state: a long element may hide a loop."""
    coarse = state.beam
    breaks = np.array(coarse.mesh.breaks)
    halves = np.sort(np.concatenate((breaks, (breaks[1:] + breaks[:-1]) / 2)))
    mesh = make_mesh(tuple(halves.tolist()), tuple(np.repeat(coarse.mesh.orders, 2).tolist()))
    guess = coarse.resampled(state.q, mesh)
    finer = newton(coarse.changed(mesh), guess, stable=True)
    if finer is None:
        return False
    energy = coarse.energy(state.q)
    return abs(finer.beam.energy(finer.q) - energy) <= RESOLVED * abs(energy)


def is_same(a: State, b: State) -> bool:
    """Whether two states are one, or mirror images."""
    energy = b.beam.energy(b.q)
    return abs(a.beam.energy(a.q) - energy) <= SAME_ENERGY * (1 + abs(energy))


def guesses(beam: BentBeam) -> Iterator[np.ndarray]:
    """A stable straight state; folded over at the clamp; the straight state, bent along its two
    lowest buckling modes."""
    w, n = beam.w, len(beam.w)
    straight = straight_state(beam)
    if straight and is_stable(straight):
        yield straight.q
        if beam.beam.delta >= 0:
            return
    folded = folded_beam(beam.beam, beam.problem)
    decay = np.exp(-beam.mesh.points / folded.width[0])
    f = np.interp(beam.mesh.points, folded.x, folded.stretch)
    yield np.concatenate((f, math.pi * decay / (w @ decay)))
    if straight is None:
        return
    scale = beam.scale[n:]
    omega_squared, modes = np.linalg.eigh(scale[:, None] * straight.tangent.K[n:, n:] * scale)
    for k in range(min(2, int((omega_squared < 0).sum()))):
        kappa = scale * modes[:, k]
        yield np.concatenate((straight.q[:n], kappa * MAX_TURN / abs(beam.J @ kappa).max()))


def straight_state(beam: BentBeam) -> State | None:
    """The straight state, stable or not, by Newton's method; None where it does not converge."""
    n = len(beam.w)
    q = np.concatenate((np.ones(n), np.zeros(n)))
    for iteration in range(1, STRAIGHT_STEPS + 1):
        tangent = beam.tangent(q)
        step = np.linalg.solve(tangent.K[:n, :n], -tangent.residual[:n])
        size = abs(step / q[:n]).max()
        q[:n] += step * min(1.0, MAX_STRETCH / size if size else 1.0)
        if size < CONVERGED:
            return State(beam, q, iteration)
    return None


def descend(beam: BentBeam, q: np.ndarray) -> State | None:
    """The stable state that descent of the energy leads to; None where it finds none.

    Newton's method where the stiffness is positive definite and the step small; elsewhere a bounded
    step of descent, which leaves saddle points.
    """
    low = max(STRETCHES[0], beam.law.min_stretch / BEYOND)
    high = min(STRETCHES[1], beam.law.max_stretch * BEYOND)
    tangent, last, shift = beam.tangent(q), math.inf, 1.0
    for iteration in range(1, DESCENT_STEPS + 1):
        step, size = _newton_step(beam, q, tangent)
        stored, centrifugal = beam.energies(q)
        energy, rounding = stored - centrifugal, ENERGY_ROUNDING * (stored + centrifugal)
        # A fall of the energy that is below its rounding cannot be seen by a line search.
        unseen = size < 1 and -tangent.residual @ step < rounding
        near = size < QUADRATIC and (size <= last / 2 or unseen)
        if not near:
            if size > 1:
                step, shift = _bounded_step(beam, q, tangent, shift)
            shortened = _line_search(beam, q, step, energy + rounding, tangent.residual)
            if shortened is None:
                return None
            step = shortened
        q, tangent = q + step, beam.tangent(q + step)
        if near and (size < CONVERGED or ROUNDED > size > last / 2):
            stable = beam.local_stiffness(q).min() > 0
            return State(beam, q, iteration) if stable else None
        last = size
        f, _ = beam.split(q)
        if not low < f.min() <= f.max() < high:
            return None
    return None


def _newton_step(beam: BentBeam, q: np.ndarray, tangent: Tangent) -> tuple[np.ndarray, float]:
    """Newton's step and its size, infinite where the stiffness is not positive definite."""
    scale = beam.scale
    L, info = lapack.dpotrf(scale[:, None] * tangent.K * scale, lower=1)
    if info:
        return np.zeros_like(q), math.inf
    step = -scale * lapack.dpotrs(L, scale * tangent.residual, lower=1)[0]
    return step, step_size(beam, q, step)


def _bounded_step(
    beam: BentBeam, q: np.ndarray, tangent: Tangent, shift: float
) -> tuple[np.ndarray, float]:
    """A step of descent of size 1 at most: Newton's with a shift of the stiffness, in units of the
    present rigidities, that makes it positive definite and the step small enough; and that shift,
    a power of 4. shift: where to look for it."""
    scale = 1 / np.sqrt(beam.rigidities(q))
    K, i = scale[:, None] * tangent.K * scale, np.arange(len(q))
    found, lower = None, False
    for _ in range(60):
        A = K.copy()
        A[i, i] += shift
        L, info = lapack.dpotrf(A, lower=1, overwrite_a=1)
        step = None if info else -scale * lapack.dpotrs(L, scale * tangent.residual, lower=1)[0]
        if step is not None and step_size(beam, q, step) <= 1:
            found = step, shift
            if lower or shift <= SMALLEST_SHIFT:
                break
            shift /= 4
        elif found:
            break
        else:
            lower, shift = True, 4 * shift
    return found or (np.zeros_like(q), shift)


def step_size(beam: BentBeam, q: np.ndarray, step: np.ndarray) -> float:
    """The size of a step in units of the largest that descent takes."""
    (f, _), (df, dkappa) = beam.split(q), beam.split(step)
    return float(max(abs(beam.J @ dkappa).max() / MAX_TURN, abs(df / f).max() / MAX_STRETCH))


def _line_search(
    beam: BentBeam, q: np.ndarray, step: np.ndarray, energy: float, residual: np.ndarray
) -> np.ndarray | None:
    """The step, halved until the energy falls as it should; None where it does not."""
    for _ in range(40):
        if beam.energy(q + step) <= energy + 1e-4 * (residual @ step):
            return step
        step = step / 2
    return None


def newton(beam: BentBeam, q: np.ndarray, stable: bool = False) -> State | None:
    """The equilibrium near a guess, a `stable` one on demand; None where Newton's method fails."""
    scale = beam.scale
    for iteration in range(1, NEWTON_STEPS + 1):
        tangent = beam.tangent(q)
        step, size = _newton_step(beam, q, tangent)
        if size == math.inf or beam.beam.spin_up:  # not positive definite, or not symmetric
            K = scale[:, None] * tangent.K * scale
            step = -scale * np.linalg.solve(K, scale * tangent.residual)
            size = step_size(beam, q, step)
        q = q + step
        if not (size < 2 and q[: len(q) // 2].min() > 0):
            return None
        if size < CONVERGED:
            state = State(beam, q, iteration)
            return state if not stable or is_stable(state) else None
    return None


def is_stable(state: State) -> bool:
    """Whether the stiffness is positive definite, on the mesh and for deformations of any length
    (Legendre's condition)."""
    beam, K = state.beam, state.tangent.K
    _, info = lapack.dpotrf(beam.scale[:, None] * K * beam.scale, lower=1)
    return info == 0 and bool(beam.local_stiffness(state.q).min() > 0)


def upward(beam: BentBeam, q: np.ndarray) -> np.ndarray:
    """The state or its mirror image: that whose tip has y >= 0."""
    f, kappa = beam.split(q)
    if beam.w @ (f * beam.directions(q)[1]) < 0:
        return np.concatenate((f, -kappa))
    return q
