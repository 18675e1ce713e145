"""Paths of bent equilibria: along the speed from a slower beam, and along the spin-up."""

import math
from contextlib import suppress
from itertools import product
from typing import NamedTuple

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from beamviz.beam import SPIN_UP
from beamviz.errors import NoEquilibrium, NotConverged
from beamviz.mechanics.planar_mesh import first_elements
from beamviz.solver import continuation
from beamviz.solver.bent.beam import BentBeam, BentState
from beamviz.solver.bent.equilibrium import (
    descend,
    folded_state,
    guesses,
    newton,
    stable_states,
)
from beamviz.solver.continuation import LIMIT_PRECISION, Root, continue_load
from beamviz.space.elements import Elements

FIRST_STEP = 0.4  # of a speed, relative: the first increase
SLOWER, SLOWEST = 0.8, 30  # ratio and number of lower speeds at which a stable state is sought
PAST_BUCKLING = 1.002  # times the speed at which the straight state ends
FIRST_ARC, SMALLEST_ARC, LONGEST_ARC = 0.01, 1e-6, 0.3  # arc lengths of steps around limit points
MAX_ARCS = 300  # number of these steps
MAX_MESHES = 3  # on which a limit in speed is located
FINER = 16.0  # ratio of the first elements of two successive ones
MAX_ORDER = 14  # of their elements
# Relative difference of the limits on two meshes from which the last is taken as it is; and the
# error that is assumed of one extrapolated.
LIMIT_ACCURACY = 1e-3
SPEED_PRECISION = 1e-5  # relative, of a limit on one mesh


class Path(NamedTuple):
    """The last of the stable states that continue one, and the value of the number beyond which
    there are none; None where the path was followed to its end."""

    state: BentState
    limit: float | None


def follow_speed(bent: BentBeam) -> BentState:
    """A stable state followed to the speed of a beam from that of a slower one that has one. Raises
    NoEquilibrium with the largest speed that has one, or NotConverged."""
    start, gamma = _slower(bent), bent.beam.gamma
    limits: list[float] = []
    for _ in range(MAX_MESHES):
        start = _finer(start) or start
        path = follow(start, "gamma", gamma, FIRST_STEP, SPEED_PRECISION)
        if path.limit is not None and start.is_straight:
            bifurcated = _bifurcated(bent, start.beam.elements, path.limit)
            if bifurcated:
                start = bifurcated
                path = follow(start, "gamma", gamma, FIRST_STEP, SPEED_PRECISION)
        if path.limit is None:
            return path.state
        limits.append(path.limit)
        if len(limits) > 1 and abs(limits[-1] / limits[-2] - 1) < LIMIT_ACCURACY:
            break
    limit = _limit_of_meshes(limits)
    raise NoEquilibrium(
        f"gamma = {gamma:.6g}: no stable state beyond gamma = {limit:g}, towards which one was"
        f" followed from gamma = {start.beam.beam.gamma:.5g} ({bent.problem.strain} strain)",
        limit,
    )


def _limit_of_meshes(limits: list[float]) -> float:
    """The limit of those on successive meshes, rounded to the digits that are certain. Where it has
    not settled it is extrapolated: each mesh reduces the error by about the same factor, as a layer
    at the clamp is resolved."""
    before, last = limits[-2:]
    error = abs(last / before - 1)
    if error >= LIMIT_ACCURACY:
        first_step, last_step = before - limits[-3], last - before
        if abs(last_step) < abs(first_step):  # Aitken's delta-squared process
            last += last_step**2 / (first_step - last_step)
            error = LIMIT_ACCURACY
    digits = max(1, int(-math.log10(max(error, SPEED_PRECISION))))
    return float(f"{last:.{digits}g}")


def _finer(state: BentState) -> BentState | None:
    """The same state with a higher order, up to MAX_ORDER, and shorter elements where a strain law
    reaches its end first: at the clamp, and of a blade between the stations beside its weakest
    section. None where it has none there."""
    breaks, orders, _ = state.beam.elements
    more = {breaks[1] / FINER, *_stations_beside(state)}
    ends = sorted({*breaks, *more})
    starts = np.searchsorted(breaks, ends[:-1], side="right") - 1  # the element that each is in
    finer_orders = tuple(min(orders[k] + 2, MAX_ORDER) for k in starts.tolist())
    beam = state.beam.on(Elements(tuple(ends), finer_orders, finer_orders))
    q = state.resampled(beam)
    return newton(beam, q, stable=True) or descend(beam, q)


def _stations_beside(state: BentState) -> tuple[float, ...]:
    """The ends of the segments of a blade beside its weakest section."""
    blade = state.beam.beam.blade
    if blade is None:
        return ()
    k = int(np.searchsorted(blade.breaks, state.weakest))
    return tuple(blade.breaks[max(k - 1, 0) : k + 2])


def _slower(bent: BentBeam) -> BentState:
    """A stable state at the highest of some lower speeds that has one, also on a finer mesh, found
    by bisection: far above its limit a descent takes longest."""
    state, low, high = None, 1, SLOWEST + 1
    while low < high:
        k = (low + high) // 2
        beam = bent.beam.replace(gamma=bent.beam.gamma * SLOWER**k)
        slower = BentBeam(first_elements(beam, bent.problem), beam, bent.problem)
        stable = None
        if folded_state(slower):
            stable = next(filter(None, (descend(slower, guess) for guess in guesses(slower))), None)
        if stable and (finer := _finer(stable)):
            state, high = finer, k
        else:
            low = k + 1
    if state is None:
        raise NotConverged(
            f"gamma = {bent.beam.gamma:.6g}: no stable state was found by descent of the energy,"
            f" nor at lower speeds down to gamma = {bent.beam.gamma * SLOWER**SLOWEST:.3g}"
        )
    return state


def _bifurcated(bent: BentBeam, elements: Elements, gamma: float) -> BentState | None:
    """A deflected equilibrium just beyond the speed at which the straight one loses stability."""
    beyond = bent.on(elements).changed(gamma=PAST_BUCKLING * gamma)
    for guess in list(guesses(beyond))[1:]:  # those along buckling modes
        state = descend(beyond, guess)
        if state and not state.is_straight:
            return state
    return None


def follow(
    start: BentState,
    over: str,
    stop: float,
    first_step: float = math.inf,
    precision: float = LIMIT_PRECISION,
) -> Path:
    """Follow the stable states from that at the start to another value of the beam's number `over`.
    first_step: relative to the first value. precision: relative to the distance. Raises
    NotConverged."""
    bent, first = start.beam, float(getattr(start.beam.beam, over))
    sign = math.copysign(1.0, stop - first)

    def at(distance: float) -> BentBeam:
        return bent.changed(**{over: first + sign * distance})

    def solve_at(distance: float, guess: NDArray) -> Root | None:
        state = newton(at(distance), guess)
        return Root(state.q, state.iterations) if state else None

    margins_at_start = _margins(start)

    def margin(distance: float, q: NDArray) -> NDArray:
        return _margins(BentState(at(distance), q)) / margins_at_start

    step = first_step * abs(first) if first_step < math.inf else math.inf
    path = continue_load(solve_at, start.q, abs(stop - first), margin, step, precision)
    value = stop if path.limit is None else first + sign * path.limit
    state = BentState(bent.changed(**{over: value}), path.state, path.iterations)
    return Path(state, None if path.limit is None else value)


def _margins(state: BentState) -> NDArray:
    """Margins of stability (4,), positive for a stable state: the lowest eigenvalue of the
    stiffness, the least stretch, the inverse of the largest, which may grow without bound towards a
    limit of the speed, and the least local stiffness."""
    if state.beam.beam.spin_up:
        lowest = np.linalg.eigvals(state.stiffness).real.min()
    else:
        lowest = scipy.linalg.eigvalsh(state.stiffness, subset_by_index=(0, 0))[0]
    return np.array([lowest, state.f.min(), 1 / state.f.max(), state.local_stiffness.min()])


def spin_up_state(beam: BentBeam, rest: BentState) -> BentState:
    """The state of a beam that spins up, followed from the stable state without the spin-up.

    Of two mirror images the one is followed that the Euler force bends further. Where the spin-up
    has a limit point on the way, the path is followed around it by its arc length. Raises
    NoEquilibrium where no state beyond is stable for short deformations, else NotConverged, with
    the spin-ups reached.
    """
    target = beam.beam.spin_up
    start = _on_the_side_of_the_force(rest, target)
    state = newton(beam, start.q)
    if state is None or state.collapses:
        path = follow(start, "spin_up", target)
        state = path.state
        if path.limit is not None:
            state = _around_limit_points(path.state, target)
    return BentState(beam, state.q, rest.iterations + state.iterations)


def states_on_both_sides(beam: BentBeam) -> list[BentState]:
    """The stable states of a beam that spins up on the side to which the Euler force bends it, and
    on the other one: of those none is left once it has snapped through."""
    target = beam.beam.spin_up
    states = []
    for rest, side in product(stable_states(beam.changed(spin_up=0.0)), (target, -target)):
        with suppress(NotConverged):
            path = follow(_on_the_side_of_the_force(rest, side), "spin_up", target)
            if path.limit is None and not rest.is_straight:
                states.append(path.state)
    return states


def _on_the_side_of_the_force(state: BentState, spin_up: float) -> BentState:
    """The state or its mirror image: that on which the Euler force of a spin-up does work."""
    R = state.R
    return state.mirrored if -spin_up * (state.beam.mass @ (R.real * R.imag)) < 0 else state


def _around_limit_points(start: BentState, target: float) -> BentState:
    """The state at a spin-up, followed from one at a limit point by the arc length of the path
    (Riks): R(q, p) = 0, p the share of the target, with one more equation, that of a plane across
    the path. Raises NoEquilibrium where the beam collapses or winds around its clamp, and
    NotConverged."""

    bent, size = start.beam, start.beam.size

    def at(z: NDArray) -> BentState:
        """The state of z (size + 1,): q, and p."""
        spin_up = float(np.clip(z[-1] * target, *SPIN_UP.limits))
        return BentState(bent.changed(spin_up=spin_up), z[:-1])

    def by_share(state: BentState) -> NDArray:
        """dR/dp (size,): R is linear in the spin-up."""
        none, all_of_it = (
            bent.state(state.q, bent.loading._replace(rate=rate)).residual for rate in (0.0, target)
        )
        return all_of_it - none

    def corrected(z: NDArray, across: NDArray) -> NDArray | None:
        """The point of the path in the plane through z, None if it is far off."""

        def increment(z: NDArray) -> NDArray:
            state = at(z)
            return continuation.bordered_step(state, by_share(state), across)

        root = continuation.newton(increment, z)
        return root.state if root else None

    largest_share = bent.beam.spin_up / target
    # Arc lengths are in the mean squares of the stretch and, relative to the start, of kappa.
    w = bent.w
    of_kappa = w / max(1.0, w @ start.kappa**2)
    metric = np.eye(size + 1)
    metric[:size, :size] = bent.local(w, np.zeros_like(w), of_kappa, 1.0)
    along_p = np.append(np.zeros(size), 1.0)
    z, direction = np.append(start.q, largest_share), along_p  # and the tangent before it
    arc, steps = FIRST_ARC, 0
    failure, largest_angle = "", start.largest_angle + 2 * math.pi
    while not failure and steps < MAX_ARCS and arc > SMALLEST_ARC:
        state = at(z)
        A = continuation.bordered(state, by_share(state), metric @ direction)
        tangent = np.linalg.solve(A, along_p)
        tangent /= np.sqrt(tangent @ metric @ tangent)
        ahead = corrected(z + arc * tangent, metric @ tangent)
        if ahead is None:
            arc /= 2
            continue
        share, state = float(ahead[-1]), at(ahead)
        if state.collapses:
            failure = f"collapses ({bent.problem.strain} strain)"
        elif state.largest_angle > largest_angle:
            failure = "winds around its clamp"
        elif share >= 1 and (last := newton(bent.changed(spin_up=target), state.q)):
            return last
        z, direction = ahead, tangent
        arc, steps = min(1.5 * arc, LONGEST_ARC), steps + 1
        largest_share = max(largest_share, share)
    reached = largest_share * target
    if failure:
        raise NoEquilibrium(
            f"spin_up = {target:.6g}: no stable state beyond spin_up = {reached:.6g}, to"
            f" which one was followed from 0; then the beam {failure}",
            math.nan,
        )
    raise NotConverged(
        f"spin_up = {target:.6g}: the equilibrium was followed up to {reached:.6g}, and on"
        f" around a limit point in {steps} steps"
    )
