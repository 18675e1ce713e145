"""Modes about bent states, to a tolerance: meshes, refinement, error estimates.

Imported when a bent state is asked for, or a beam has a spin-up: a straight beam needs none of it.
"""

import math
import time
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from typing import Literal

import numpy as np

from beamviz.beam import Beam
from beamviz.errors import BeamvizError, InvalidInput, NoEquilibrium, NotConverged
from beamviz.solver.bent.equilibrium import (
    State,
    descend,
    limit_of_stability,
    newton,
    spin_up_state,
    stable_states,
    upward,
    without_spin_up,
)
from beamviz.solver.bent.modes import BentModes, bent_modes
from beamviz.solver.bent.tangent import BentBeam, Tangent
from beamviz.solver.hp import solve_hp
from beamviz.solver.hp.mesh import Mesh, make_mesh, reference
from beamviz.solver.problem import Problem
from beamviz.solver.solution import Equilibrium, Solution, Stats

FIRST_ORDER, HIGHEST_ORDER, LONGEST_ELEMENT = 10, 16, 0.5
LAYER, GRADING = 3.0, 4.0  # first element in widths of a bending layer; ratio of neighbours
REFINEMENTS, MAX_UNKNOWNS = 14, 1000
TRUNCATION_FACTOR, ROUNDING_FACTOR = 4.0, 100.0  # of the two error estimates, see the tests
STRAIGHT = 1e-6  # largest angle [rad] of a state that counts as straight
EPS = float(np.finfo(float).eps)


@dataclass(frozen=True, eq=False)
class BentEquilibrium(Equilibrium):
    """A bent state, as functions of the reference coordinate x."""

    state: State

    @property
    def shape(self) -> Literal["straight", "bent"]:
        """The kind of state: "bent"."""
        return "bent"

    def position(self, x: np.ndarray) -> np.ndarray:
        """Position (len(x), 2) of the points x, measured from the clamp."""
        return self.state.beam.position(self.state.q, np.atleast_1d(np.asarray(x, float)))

    def stretch(self, x: np.ndarray) -> np.ndarray:
        """Stretch f = |r'| (len(x),)."""
        f, _ = self.state.beam.split(self.state.q)
        return self.state.beam.mesh.grid.at(np.atleast_1d(np.asarray(x, float))) @ f

    def angle(self, x: np.ndarray) -> np.ndarray:
        """Angle theta [rad] of the beam's axis (len(x),)."""
        _, kappa = self.state.beam.split(self.state.q)
        return self.state.beam.mesh.grid.from_clamp(np.atleast_1d(np.asarray(x, float))) @ kappa


@dataclass(frozen=True, eq=False)
class Fields:
    """Displacements along and across the bent beam as functions of x."""

    state: State
    V: np.ndarray  # (2 n, modes)

    def __call__(self, x: np.ndarray) -> np.ndarray:
        """Displacements (len(x), 2, modes)."""
        beam, n = self.state.beam, len(self.state.q) // 2
        f, kappa = beam.split(self.state.q)
        c, s = (direction[:, None] for direction in beam.directions(self.state.q))
        df, turn = self.V[:n], f[:, None] * (beam.J @ self.V[n:])
        rows = beam.mesh.grid.from_clamp(x)
        dx, dy = rows @ (c * df - s * turn), rows @ (s * df + c * turn)
        theta = (rows @ kappa)[:, None]
        c, s = np.cos(theta), np.sin(theta)
        return np.stack((c * dx + s * dy, c * dy - s * dx), axis=1)


def solve_states(
    beams: list[Beam], problem: Problem, start: float, extra_modes: int = 0
) -> list[Solution | BeamvizError]:
    """Solutions of beams about the states that the problem asks for, or their errors: straight
    where that is stable and "stable" is asked for, else bent. Each bent state is the first guess
    for the next beam."""
    answers: list[Solution | BeamvizError] = []
    near: State | None = None
    for beam in beams:
        _check(beam, problem)
        answer: Solution | BeamvizError | None = None
        if problem.state == "stable" and not beam.spin_up:
            answer = solve_hp([beam], replace(problem, state="straight"), start, extra_modes)[0]
        if not (isinstance(answer, Solution) and answer.equilibrium.stable):
            try:
                answer, near = solve_bent(beam, problem, start, near, extra_modes)
            except (NoEquilibrium, NotConverged) as error:
                answer, near = error, None
        answers.append(answer)
    return answers


def _check(beam: Beam, problem: Problem) -> None:
    """InvalidInput where a bent state is not what the options describe."""
    wanted = f"spin_up = {beam.spin_up:g}" if beam.spin_up else f"state = {problem.state!r}"
    if beam.spin_up and problem.state == "straight":
        raise InvalidInput(f"{wanted}: there is no straight state; use state = 'bent' or 'stable'")
    if problem.method != "auto":
        raise InvalidInput(f"{wanted}: method {problem.method} has no bent states; use auto")
    if not (problem.stiffening and problem.softening):
        raise InvalidInput(f"{wanted}: stiffening and softening cannot be switched off")
    if beam.spin_up and not problem.chordwise:
        raise InvalidInput(f"{wanted}: bends the beam in the plane of rotation; use chordwise")


def solve_bent(
    beam: Beam, problem: Problem, start: float, near: State | None = None, extra_modes: int = 0
) -> tuple[Solution, State]:
    """The lowest modes about the stable bent state of lowest energy, or about the state of a beam
    that spins up; and that state.

    near: a state of a neighbouring beam, to start from. Raises NoEquilibrium where the stable
    states are straight, NotConverged where refinement does not reach the tolerance.
    """
    count = problem.modes + extra_modes
    state = _state_near(beam, problem, near) or _first_state(beam, problem)
    coarser: np.ndarray | None = None  # omega^2 on the mesh before; a neighbour's mesh is known
    verified = near is not None and state.beam.mesh is near.beam.mesh
    for _ in range(REFINEMENTS):
        modes = _modes(state, count)
        omega_squared = modes.frequencies**2
        truncation, rounding = _errors(state, modes)
        if coarser is not None:
            truncation = np.maximum(truncation, abs(omega_squared - coarser))
        allowed = 2 * problem.tolerance * omega_squared + rounding
        excess = float((truncation / allowed)[: problem.modes].max())
        if excess <= 1 and (verified or coarser is not None):
            return _solution(beam, problem, state, modes, truncation + rounding, start), state
        state = _on_mesh(state, _refined(state, modes, problem.tolerance))
        coarser = omega_squared
    raise NotConverged(
        f"errors are still {excess:.1e} times the tolerance {problem.tolerance:g} with"
        f" {len(state.q)} unknowns; ask for a larger tolerance or fewer modes"
    )


def _first_state(beam: Beam, problem: Problem) -> State:
    """A state found from nothing, on the first mesh."""
    still = without_spin_up(beam)
    bent = BentBeam(first_mesh(beam), still, problem)
    states = stable_states(bent)
    if not states:
        raise _no_stable_state(bent)
    if beam.spin_up:
        return spin_up_state(BentBeam(bent.mesh, beam, problem), states[0])
    for state in states:
        if abs(bent.J @ bent.split(state.q)[1]).max() > STRAIGHT:
            return state._replace(
                q=upward(bent, state.q), tangent=bent.tangent(upward(bent, state.q))
            )
    raise NoEquilibrium(
        f"gamma = {beam.gamma:.6g}: no bent state found, the straight one is stable", math.nan
    )


def _no_stable_state(bent: BentBeam) -> NoEquilibrium:
    """The error of a beam without a stable state, with the limit found on a finer mesh."""
    mesh, beam = bent.mesh, bent.beam
    finer = make_mesh(tuple(mesh.breaks), tuple(order + 6 for order in mesh.orders))
    limit = limit_of_stability(BentBeam(finer, beam, bent.problem))
    return NoEquilibrium(
        f"gamma = {beam.gamma:.6g}: no stable state beyond gamma = {limit:.6g}: there the"
        f" {bent.problem.strain} strain law carries no more force",
        limit,
    )


def _state_near(beam: Beam, problem: Problem, near: State | None) -> State | None:
    """The state that a neighbour's leads to, on its mesh; None where that fails."""
    if near is None or (beam.alpha and near.beam.beam.beta != beam.beta):
        return None
    bent = BentBeam(near.beam.mesh, beam, problem)
    return newton(bent, near.q) if beam.spin_up else descend(bent, near.q)


def _modes(state: State, count: int) -> BentModes:
    beam, problem = state.beam.beam, state.beam.problem
    return bent_modes(
        state.tangent,
        state.beam.scale,
        beam.gamma,
        problem.gyroscopic,
        beam.spin_up,
        count,
    )


def first_mesh(beam: Beam) -> Mesh:
    """Elements graded towards the clamp and the concentrated mass, where bending is confined to a
    layer of width sqrt(EI / N)."""
    tension = (1 + beam.alpha) * (1 + abs(beam.delta)) * max(beam.gamma**2, abs(beam.spin_up))
    width = LAYER / math.sqrt(tension) if tension else 1.0
    ends = [0.0, beam.beta, 1.0] if beam.alpha and 0 < beam.beta < 1 else [0.0, 1.0]
    breaks = set(ends)
    for a, b in pairwise(ends):
        distance = width
        while 2 * distance < b - a:
            breaks.add(a + distance)
            if b < 1:
                breaks.add(b - distance)
            distance *= GRADING
    spread = [0.0]
    for a, b in pairwise(sorted(breaks)):
        parts = math.ceil((b - a) / LONGEST_ELEMENT)
        spread += [a + (b - a) * k / parts for k in range(1, parts + 1)]
    return make_mesh(tuple(spread), (FIRST_ORDER,) * (len(spread) - 1))


def _on_mesh(state: State, refined: Mesh) -> State:
    """The same state on another mesh."""
    old = state.beam
    if 2 * len(refined.points) > MAX_UNKNOWNS:
        raise NotConverged(
            f"a bent state needs more than {MAX_UNKNOWNS} unknowns here; ask for a larger tolerance"
        )
    rows = old.mesh.grid.at(refined.points)
    q = np.concatenate([rows @ part for part in old.split(state.q)])
    beam = BentBeam(refined, old.beam, old.problem)
    found = newton(beam, q) or (None if beam.beam.spin_up else descend(beam, q))
    if found is None and old.beam.spin_up:
        raise NotConverged("Newton's method left a bent state when its mesh was refined")
    if found is None:
        raise _no_stable_state(beam)
    return found._replace(iterations=state.iterations + found.iterations)


def _tails(bent: BentBeam, Q: np.ndarray, parity: int) -> np.ndarray:
    """The part of values Q (2 n, ...) in the two highest polynomials of every second element."""
    tails = np.zeros_like(Q)
    for half in (0, len(bent.w)):
        end = half
        for k, order in enumerate(bent.mesh.orders):
            block = slice(end, end + order)
            if k % 2 == parity:
                tails[block] = reference(order).last_two @ Q[block]
            end += order
    return tails


def _errors(state: State, modes: BentModes) -> tuple[np.ndarray, np.ndarray]:
    """Estimated truncation and rounding errors (modes,) of omega^2.

    What the two highest polynomials of each element contribute: those of the state to its tangent,
    and those of the shapes to their energies; neighbouring elements apart, since they may cancel.
    """
    bent, omega, V = state.beam, modes.frequencies, modes.V
    exact = _energies(state, state.tangent, V)
    stiffness, _, inertia = exact
    size = omega**2 * inertia + abs(stiffness)
    truncation = np.zeros_like(omega)
    for parity in (0, 1):
        lower = bent.tangent(state.q - _tails(bent, state.q, parity))
        for energies in (
            _energies(state, lower, V),
            _energies(state, state.tangent, V - _tails(bent, V, parity)),
        ):
            dK, dG, dM = energies - exact
            truncation += abs(dK + omega * dG - omega**2 * dM) * 2 * omega**2 / size
    rounding = (abs(np.diag(state.tangent.K))[:, None] * abs(V) ** 2).sum(axis=0)
    return TRUNCATION_FACTOR * truncation, ROUNDING_FACTOR * EPS * rounding


def _energies(state: State, tangent: Tangent, V: np.ndarray) -> np.ndarray:
    """Stiffness v' K v, gyroscopic and inertia terms (3, modes) of shapes."""
    moved = tangent.B @ V  # (2, m, modes)
    stiffness = (V.conj() * (tangent.K @ V)).sum(axis=0).real
    coriolis = 2 * state.beam.beam.gamma if state.beam.problem.gyroscopic else 0.0
    swirl = (moved[1].conj() * moved[0] - moved[0].conj() * moved[1]).sum(axis=0)
    inertia = (abs(moved) ** 2).sum(axis=(0, 1))
    return np.array([stiffness, (1j * coriolis * swirl).real, inertia])


def _refined(state: State, modes: BentModes, tolerance: float) -> Mesh:
    """A mesh with a higher order, or halves, where the tails of the state or of a shape are."""
    bent, n = state.beam, len(state.beam.w)
    q = _tails(bent, state.q, 0) + _tails(bent, state.q, 1)
    V = abs(_tails(bent, modes.V, 0)) ** 2 + abs(_tails(bent, modes.V, 1)) ** 2
    stiffness = 1 / bent.scale**2
    breaks, orders, start = [0.0], [], 0
    lengths = np.diff(bent.mesh.breaks)
    for order, length, end in zip(bent.mesh.orders, lengths, bent.mesh.breaks[1:], strict=True):
        block = slice(start, start + order)
        angle = math.sqrt(length * (bent.w[block] @ q[n:][block] ** 2))
        stretch = math.sqrt(length * (bent.w[block] @ q[:n][block] ** 2))
        strain = stiffness[block] @ V[block] + stiffness[n:][block] @ V[n:][block]
        shapes = strain / modes.frequencies**2
        needed = max(max(angle, stretch) * 10, math.sqrt(shapes.max())) / math.sqrt(tolerance)
        start += order
        if needed > 1 and order >= HIGHEST_ORDER:
            breaks += [end - length / 2, end]
            orders += [order, order]
        else:
            breaks.append(end)
            orders.append(order + (6 if needed > 10 else 4 if needed > 1 else 2))
    return make_mesh(tuple(breaks), tuple(orders))


def _solution(
    beam: Beam,
    problem: Problem,
    state: State,
    modes: BentModes,
    errors: np.ndarray,
    start: float,
) -> Solution:
    bent, grid = state.beam, state.beam.mesh.grid
    moved = state.tangent.B @ modes.V
    theta = (bent.R @ bent.split(state.q)[1])[:, None]
    across = np.cos(theta) * moved[1] - np.sin(theta) * moved[0]
    return Solution(
        beam=beam,
        problem=problem,
        equilibrium=BentEquilibrium(modes.definite, state.iterations, None, state),
        stats=Stats(
            len(state.q), time.perf_counter() - start, "hp", len(grid.orders), max(grid.orders)
        ),
        omega_squared=modes.frequencies**2,
        estimate_errors=partial(np.array, errors),
        bending_energy_fraction=(abs(across) ** 2).sum(axis=0),
        fields=Fields(state, modes.V),
        spin_up_growth=modes.growth_rates if beam.spin_up else None,
    )
