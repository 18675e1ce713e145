"""Modes about deflected equilibria, to a tolerance: first states, refinement, error estimates.

Imported when a deflected equilibrium is asked for, or a beam has a spin-up: a straight beam needs
none of it.
"""

import math
import time
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial

import numpy as np

from beamviz.beam import Beam
from beamviz.errors import NoEquilibrium, NotConverged
from beamviz.mechanics.planar_mesh import first_elements
from beamviz.mechanics.straight_residual import LEFT
from beamviz.solver.bent import paths
from beamviz.solver.bent.beam import BentBeam, BentState
from beamviz.solver.bent.equilibrium import (
    descend,
    newton,
    resolved,
    stable_states,
)
from beamviz.solver.bent.errors import errors_of_modes
from beamviz.solver.bent.lack import lack_of_modes, whole
from beamviz.solver.bent.modes import bent_modes
from beamviz.solver.bent.profile import (
    SavedState,
    curve,
    fields,
    profile_of,
    saved,
)
from beamviz.solver.build import SolvedState, Vibration, build_solution
from beamviz.solver.pencil.matrices import TINY, Modes
from beamviz.solver.problem import Problem, interruption
from beamviz.solver.solution import Solution, Stats
from beamviz.solver.stability import may_buckle
from beamviz.solver.straight import solve_hp
from beamviz.solver.straight.refinement import MAX_ATTEMPTS
from beamviz.space.elements import Elements
from beamviz.space.refinement import refined

REFERENCE_TOLERANCE = 1e-8  # of states beside limit points
NEARER = 1e-4  # of the way to a limit point: distance from it of the second start
MAX_UNKNOWNS = 2000  # two for each point: ten seconds


def solve_bent(
    beam: Beam, problem: Problem, near: SavedState | None = None, extra_modes: int = 0
) -> Solution:
    """The lowest modes about the stable deflected equilibrium of lowest energy, or about the state
    of a beam that spins up.

    near: a state of a neighbouring beam, to start from. Raises NoEquilibrium where the stable
    states are straight, NotConverged where refinement does not reach the tolerance.
    """
    count = problem.modes + extra_modes
    state = _state_near(beam, problem, near) or _first_state(beam, problem)
    for _ in range(MAX_ATTEMPTS):
        interruption.get()()
        modes, lack = _without_lack(state, bent_modes(state, count))
        truncation, rounding = errors_of_modes(state, modes, lack)
        allowed = problem.tolerance * abs(modes.s) + rounding
        excess = (truncation / allowed[:, None])[: problem.modes]
        totals = excess.sum(axis=-1)
        worst = totals.argmax()
        if totals[worst] <= 1:
            return _solution(state, modes, truncation.sum(axis=-1) + rounding)
        finer = refined(state.beam.elements, excess[worst].tolist(), beam.blade)
        state = saved(state).restored()  # its matrices would be in memory beside the larger ones
        state = _on_elements(state, finer)
    raise NotConverged(
        f"errors are still {totals[worst]:.1e} times the tolerance"
        f" {problem.tolerance:g} with {state.beam.size} unknowns; ask for a larger one or fewer"
        " modes"
    )


def other_stable_states(solution: Solution, near: Sequence[Solution] = ()) -> list[Solution]:
    """The other stable deflected equilibria of the beam of a solution that are found, with their
    modes and without mirror images, ordered by energy, or to match the states `near` of a
    neighbouring beam."""
    beam, problem = solution.beam, solution.problem
    seen = bent_states([solution])
    others: list[Solution] = []
    bent = seen[0].beam if seen else BentBeam(first_elements(beam, problem), beam, problem)
    guesses: Iterable[BentState | None]
    if near:
        guesses = (_state_near(beam, problem, saved(state)) for state in bent_states(near))
    else:
        guesses = paths.states_on_both_sides(bent) if beam.spin_up else stable_states(bent)
    for guess in guesses:
        with suppress(NoEquilibrium, NotConverged):
            if guess is None or any(map(guess.is_same, seen)):
                continue
            if (first := resolved(guess)) is None:
                continue
            start = time.perf_counter()
            other = solve_bent(beam, problem, saved(first))
            other.stats.seconds = time.perf_counter() - start
            (state,) = bent_states([other])
            if not (state.is_straight or any(map(state.is_same, seen))):
                seen.append(state)
                others.append(other)
    return others


def end_of_bent_state(solution: Solution, over: str, stop: float) -> float | None:
    """The limit point of a deflected equilibrium: the value of the parameter `over`, between that
    of the beam and `stop`, beyond which the state does not exist; None where it exists up to
    `stop`. It is located again on the mesh that resolves the state there; of a blade it is not, as
    that takes up to 20 times as long and changes the limit by 3e-10 at most (four blades)."""
    (state,) = bent_states([solution])
    end = paths.follow(state, over, stop).limit
    if end is None or solution.beam.blade is not None:
        return end
    beside = paths.follow(state, over, end - NEARER * (end - getattr(solution.beam, over)))
    if beside.limit is None:
        problem = replace(state.beam.problem, modes=1, tolerance=REFERENCE_TOLERANCE)
        with suppress(NoEquilibrium, NotConverged):  # at the end of a strain law
            nearer = solve_bent(beside.state.beam.beam, problem, saved(beside.state))
            (state,) = bent_states([nearer])
            end = paths.follow(state, over, stop).limit or end
    return end


def bent_states(solutions: Iterable[Solution]) -> list[BentState]:
    """The deflected states of those solutions that have one."""
    states = (solution.equilibrium.bent_state for solution in solutions)
    return [state.restored() for state in states if state is not None]


def _first_state(beam: Beam, problem: Problem) -> BentState:
    """A state without a neighbour to start from, on the first mesh."""
    if beam.spin_up and beam.root == 0 and not (beam.gamma and beam.delta):
        raise NoEquilibrium(
            f"spin_up = {beam.spin_up:g}: nothing holds the beam, root = 0, against the Euler force"
            f" at gamma = {beam.gamma:g}, delta = {beam.delta:g}",
            math.nan,
        )
    still = beam.replace(spin_up=0.0)
    if not may_buckle(beam):  # its straight state is the only one
        straight = solve_hp([still], replace(problem, state="straight"))[0]
        if isinstance(straight, NoEquilibrium):
            raise straight
    elements = first_elements(beam, problem)
    _check_unknowns(elements)
    return _state_from_guesses(BentBeam(elements, beam, problem))


def _state_from_guesses(bent: BentBeam) -> BentState:
    """A state without a neighbour to start from, on the elements of the beam, where it has one
    there."""
    still, spin_up = bent.changed(spin_up=0.0), bent.beam.spin_up
    states = stable_states(still) or [paths.follow_speed(still)]
    if spin_up:
        return paths.spin_up_state(states[0].beam.changed(spin_up=spin_up), states[0])
    for state in states:
        if not state.is_straight:
            return state.upward
    raise NoEquilibrium(
        f"gamma = {bent.beam.gamma:.6g}: no bent state found, the straight one is stable", math.nan
    )


def _state_near(beam: Beam, problem: Problem, near: SavedState | None) -> BentState | None:
    """The state reached from that of a neighbour, on its elements; None where that fails."""
    if near is None or (beam.alpha and near.beam.beta != beam.beta):
        return None
    other = near.beam
    if (other.blade, other.masses, other.root) != (beam.blade, beam.masses, beam.root):
        return None
    bent = BentBeam(near.elements, beam, problem)
    q = near.restored().resampled(bent)  # the points of a blade depend on the tolerance
    return newton(bent, q) if beam.spin_up else descend(bent, q)


def _check_unknowns(elements: Elements) -> None:
    """NotConverged for too many elements."""
    unknowns = 2 * sum(elements.orders)
    if unknowns > MAX_UNKNOWNS:
        raise NotConverged(
            f"a bent state needs {unknowns} unknowns here, at most {MAX_UNKNOWNS}; ask for a larger"
            " tolerance, or give the blade fewer stations"
        )


def _on_elements(state: BentState, refined: Elements) -> BentState:
    """The same state on other elements."""
    _check_unknowns(refined)
    old = state.beam
    beam, steady = old.on(refined), not old.beam.spin_up
    q = whole(state).resampled(beam)
    finer = newton(beam, q, stable=steady)
    if finer is None:
        finer = (descend(beam, q) if steady else None) or _state_from_guesses(beam)
    # A state followed from a slower beam is on a mesh of its own.
    return BentState(finer.beam, finer.q, state.iterations + finer.iterations)


def _without_lack(state: BentState, modes: Modes) -> tuple[Modes, np.ndarray]:
    """The modes, with s about a stable state less what it is too high by, as the elements that span
    stations lack functions; and the lack (elements, modes) of v* T(s) v that may be left."""
    if not state.beam.trial.has_kinks:
        return modes, np.zeros((len(state.beam.elements.orders), len(modes.s)))
    lack = lack_of_modes(state, modes.s, modes.V)
    if state.beam.beam.spin_up:
        return modes, lack
    shift = lack.sum(axis=0) / np.maximum(modes.pairing, TINY)
    left = np.where(shift < modes.s.imag, LEFT, 1.0)  # just past buckling it may be more than s
    s = modes.s - 1j * np.where(left < 1, shift, 0.0)
    return modes._replace(omega_squared=-np.square(s)), left * lack


def _solution(state: BentState, modes: Modes, errors: np.ndarray) -> Solution:
    """The Solution of modes with these errors of s."""
    bent, orders = state.beam, state.beam.elements.orders
    V = modes.V
    moved = state.displaced(V)
    theta = (bent.to_masses(state.kappa) + state.root_angle)[:, None]
    across = np.cos(theta) * moved[1] - np.sin(theta) * moved[0]
    turned = (abs(state.turned(V)) ** 2).sum(axis=0)
    profile = profile_of(whole(state))
    return build_solution(
        bent.beam,
        bent.problem,
        SolvedState(partial(curve, profile), bent.grid.breaks, state.iterations, saved(state)),
        Vibration(
            s=modes.s,
            fraction=(abs(across) ** 2).sum(axis=0) + turned,
            fields=partial(fields, profile, state.gradients(V)),
            # errors of s^2
            estimate_errors=partial(np.array, (2 * abs(modes.s) + errors) * errors),
            all_s=modes.all_s,
        ),
        Stats(bent.size, "hp", len(orders), max(orders)),
    )
