"""Paths of bent equilibria: along the speed from a slower beam, and along the spin-up."""

import math
from collections.abc import Callable
from contextlib import suppress
from itertools import product
from typing import NamedTuple

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from beamviz.beam import SPIN_UP
from beamviz.errors import NoEquilibrium, NotConverged
from beamviz.solver import continuation
from beamviz.solver.bent.beam import BentBeam, State
from beamviz.solver.bent.equilibrium import (
    descend,
    first_mesh,
    folded_state,
    guesses,
    newton,
    stable_states,
)
from beamviz.solver.continuation import LIMIT_PRECISION, Root, continue_load
from beamviz.solver.hp.mesh import Mesh, make_mesh

FIRST_STEP = 0.4  # of a speed, relative: the first increase
SLOWER, SLOWEST = 0.8, 30  # ratio of speeds, and their number, where a stable state is looked for
PAST_BUCKLING = 1.002  # times the speed at which the straight state ends
FIRST_ARC, SMALLEST_ARC, LONGEST_ARC, MAX_ARCS = 0.01, 1e-6, 0.3, 300  # steps around limit points
DIFFERENCE = 1e-4  # step of a derivative by the load
MAX_MESHES, FINER, ORDER = 3, 16.0, 14  # on which a limit is located; ratio of first elements
LIMIT_ACCURACY, SPEED_PRECISION = 1e-3, 1e-5  # relative: of the limit, and on one mesh


class Path(NamedTuple):
    """The last of the stable states that continue one, and the value of the number beyond which
    there are none; None where the path was followed to its end."""

    state: State
    limit: float | None


def follow_speed(bent: BentBeam) -> State:
    """A stable state followed to the speed of a beam from that of a slower one that has one. Raises
    NoEquilibrium with the largest speed that has one, or NotConverged."""
    start, gamma = _slower(bent), bent.beam.gamma
    limits: list[float] = []
    for _ in range(MAX_MESHES):
        start = _finer(start)
        path = follow(start, "gamma", gamma, FIRST_STEP, SPEED_PRECISION)
        if path.limit is not None and start.is_straight:
            bifurcated = _bifurcated(bent, start.beam.mesh, path.limit)
            if bifurcated:
                start = bifurcated
                path = follow(start, "gamma", gamma, FIRST_STEP, SPEED_PRECISION)
        if path.limit is None:
            return path.state
        limits.append(path.limit)
        if len(limits) > 1 and abs(limits[-1] / limits[-2] - 1) < LIMIT_ACCURACY:
            break
    raise NoEquilibrium(
        f"gamma = {gamma:.6g}: no stable state beyond gamma = {limits[-1]:.4g}, to which"
        f" one was followed from gamma = {start.beam.beam.gamma:.5g}"
        f" ({bent.problem.strain} strain)",
        limits[-1],
    )


def _finer(state: State) -> State:
    """The same state with a higher order, up to ORDER, and a shorter first element: a strain law
    reaches its end first at the clamp."""
    mesh = state.beam.mesh
    breaks = (0.0, mesh.breaks[1] / FINER, *mesh.breaks[1:])
    orders = (mesh.orders[0], *mesh.orders)
    finer = make_mesh(tuple(breaks), tuple(min(order + 2, ORDER) for order in orders))
    return newton(state.beam.changed(finer), state.resampled(finer), stable=True) or state


def _slower(bent: BentBeam) -> State:
    """A stable state at the highest of some lower speeds that has one, found by bisection: far
    above its limit a descent takes longest."""
    state, low, high = None, 1, SLOWEST + 1
    while low < high:
        k = (low + high) // 2
        beam = bent.beam.replace(gamma=bent.beam.gamma * SLOWER**k)
        slower, found = BentBeam(first_mesh(beam, bent.problem), beam, bent.problem), None
        if folded_state(slower):
            found = next(filter(None, (descend(slower, guess) for guess in guesses(slower))), None)
        if found:
            state, high = found, k
        else:
            low = k + 1
    if state is None:
        raise NotConverged(
            f"gamma = {bent.beam.gamma:.6g}: no stable state was found by descent of the energy,"
            f" nor at lower speeds down to gamma = {bent.beam.gamma * SLOWER**SLOWEST:.3g}"
        )
    return state


def _bifurcated(bent: BentBeam, mesh: Mesh, gamma: float) -> State | None:
    """A deflected equilibrium just beyond the speed at which the straight one loses stability."""
    beyond = bent.changed(mesh, gamma=PAST_BUCKLING * gamma)
    for guess in list(guesses(beyond))[1:]:  # those along buckling modes
        found = descend(beyond, guess)
        if found and not found.is_straight:
            return found
    return None


def follow(
    start: State,
    over: str,
    stop: float,
    first_step: float = math.inf,
    precision: float = LIMIT_PRECISION,
) -> Path:
    """Follow the stable states from one to another value of the beam's number `over`. first_step:
    relative to its own value. precision: relative to the distance. Raises NotConverged."""
    bent, own = start.beam, float(getattr(start.beam.beam, over))
    sign = math.copysign(1.0, stop - own)

    def at(distance: float) -> BentBeam:
        return bent.changed(**{over: own + sign * distance})

    def solve_at(distance: float, guess: NDArray) -> Root | None:
        found = newton(at(distance), guess)
        return Root(found.q, found.iterations) if found else None

    first = _margins(start)

    def margin(distance: float, q: NDArray) -> NDArray:
        return _margins(State(at(distance), q)) / first

    step = first_step * abs(own) if first_step < math.inf else math.inf
    path = continue_load(solve_at, start.q, abs(stop - own), margin, step, precision)
    value = stop if path.limit is None else own + sign * path.limit
    state = State(bent.changed(**{over: value}), path.state, path.iterations)
    return Path(state, None if path.limit is None else value)


def _margins(state: State) -> NDArray:
    """Margins of stability, positive for a stable state: the lowest eigenvalue of the stiffness,
    the least stretch, and the least local stiffness."""
    if state.beam.beam.spin_up:
        lowest = np.linalg.eigvals(state.scaled_stiffness).real.min()
    else:
        lowest = scipy.linalg.eigvalsh(state.scaled_stiffness, subset_by_index=(0, 0))[0]
    return np.array([lowest, state.f.min(), state.local_stiffness.min()])


def spin_up_state(beam: BentBeam, rest: State) -> State:
    """The state of a beam that spins up, followed from the stable state without the spin-up.

    Of two mirror images the one is followed that the Euler force bends further. Where the spin-up
    has a limit point on the way, the path is followed around it by its arc length. Raises
    NoEquilibrium where no state beyond is stable for short deformations, else NotConverged, with
    the spin-ups reached.
    """
    target = beam.beam.spin_up
    start = _on_the_side_of_the_force(rest, target)
    found = newton(beam, start.q)
    if found is None or found.collapses:
        path = follow(start, "spin_up", target)
        found = _around_limit_points(path.state, target) if path.limit else path.state
    return State(beam, found.q, rest.iterations + found.iterations)


def states_on_both_sides(beam: BentBeam) -> list[State]:
    """The stable states of a beam that spins up on the side to which the Euler force bends it, and
    on the other one: of those none is left once it has snapped through."""
    target = beam.beam.spin_up
    found = []
    for rest, side in product(stable_states(beam.changed(spin_up=0.0)), (target, -target)):
        with suppress(NotConverged):
            path = follow(_on_the_side_of_the_force(rest, side), "spin_up", target)
            if path.limit is None and not rest.is_straight:
                found.append(path.state)
    return found


def _on_the_side_of_the_force(state: State, spin_up: float) -> State:
    """The state or its mirror image: that on which the Euler force of a spin-up does work."""
    x, y = state.arms
    return state.mirrored if -spin_up * (state.beam.mass @ (x * y)) < 0 else state


def _around_limit_points(start: State, target: float) -> State:
    """The state at a spin-up, followed from one at a limit point by the arc length of the path
    (Riks): R(q, p) = 0, p the share of the target, with one more equation, that of a plane across
    the path. Raises NoEquilibrium where the beam collapses or winds around its clamp, and
    NotConverged."""

    def at(p: float) -> BentBeam:
        return start.beam.changed(spin_up=float(np.clip(p * target, *SPIN_UP.limits)))

    n, w, limit = len(start.q), np.sqrt(start.beam.w), start.beam.beam.spin_up / target
    unit = np.concatenate((w, w / max(1.0, np.linalg.norm(w * start.kappa)), [1.0]))
    direction, arc, z = np.append(np.zeros(n), 1.0), FIRST_ARC, np.append(start.q, limit)
    steps, end, most = 0, "", start.largest_angle + 2 * math.pi
    while not end and steps < MAX_ARCS and arc > SMALLEST_ARC:
        ahead = np.linalg.solve(_bordered(at, z, direction * unit**2)[0], np.append(np.zeros(n), 1))
        ahead /= np.linalg.norm(ahead * unit)
        found = _corrected(at, z + arc * ahead, ahead * unit**2)
        if found is None:
            arc /= 2
            continue
        state = State(at(float(found[-1])), found[:-1])
        if state.collapses:
            end = f"collapses ({start.beam.problem.strain} strain)"
        elif state.largest_angle > most:
            end = "winds around its clamp"
        elif found[-1] >= 1 and (last := newton(at(1.0), found[:-1])):
            return last
        direction, z, arc = ahead, found, min(1.5 * arc, LONGEST_ARC)
        steps, limit = steps + 1, max(limit, float(z[-1]))
    if end:
        raise NoEquilibrium(
            f"spin_up = {target:.6g}: no stable state beyond spin_up = {limit * target:.6g}, to"
            f" which one was followed from 0; then the beam {end}",
            math.nan,
        )
    raise NotConverged(
        f"spin_up = {target:.6g}: the equilibrium was followed up to {limit * target:.6g}, and on"
        f" around a limit point in {steps} steps"
    )


def _bordered(
    at: Callable[[float], BentBeam], z: NDArray, across: NDArray
) -> tuple[NDArray, NDArray]:
    """The tangent of R(q, p) by q and p with the row `across` below it, and R."""
    p, h = float(z[-1]), DIFFERENCE
    state, before, beyond = (State(at(load), z[:-1]) for load in (p, p - h, p + h))
    slope = (beyond.residual - before.residual) / (2 * h)
    return np.vstack((np.column_stack((state.stiffness, slope)), across)), state.residual


def _corrected(at: Callable[[float], BentBeam], z: NDArray, across: NDArray) -> NDArray | None:
    """The point of the path in the plane through z, by Newton's method; None if it is far off."""

    def increment(z: NDArray) -> NDArray:
        A, residual = _bordered(at, z, across)
        step = -np.linalg.solve(A, np.append(residual, 0.0))
        if not State(at(float(z[-1])), z[:-1]).step_size(step[:-1]) < 1:
            raise np.linalg.LinAlgError
        return step

    root = continuation.newton(increment, z)
    return root.state if root else None
