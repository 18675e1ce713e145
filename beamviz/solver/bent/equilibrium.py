"""Bent equilibria at a constant speed: a mesh graded towards bending layers, stable states by
descent of the energy, and Newton's method.

Without a spin-up the loads have a potential, and a stable state is one of its minima: descent
finds one from any guess. Guesses are the straight state bent along its buckling modes, and a beam
folded over at the clamp, from where it points outward.
"""

import math
from collections.abc import Iterator
from contextlib import suppress
from itertools import pairwise
from operator import attrgetter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

from beamviz.beam import Beam
from beamviz.errors import NoEquilibrium, NotConverged
from beamviz.mechanics.planar import MAX_TURN
from beamviz.mechanics.straight_equilibrium import (
    axial_problem,
    coarse_equilibrium,
    has_unique_equilibrium,
    is_small_strain,
)
from beamviz.mechanics.straight_properties import stack_of
from beamviz.solver import continuation
from beamviz.solver.bent.beam import BentBeam, BentState
from beamviz.solver.problem import Problem, interruption
from beamviz.solver.stability import may_buckle
from beamviz.space.elements import Elements
from beamviz.space.grid import make_mesh
from beamviz.space.spans import Span, find_spans, unstretched_positions

FIRST_ORDER, LONGEST_ELEMENT = 10, 0.5
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


class Grading(NamedTuple):
    """How elements are graded towards a bending layer. layer: length of the first one, in widths
    of the layer; ratio: of neighbours; widest: layer that gets elements of its own, over the length
    of its part of the beam."""

    layer: float
    ratio: float
    widest: float


# The first elements of the straight beam folded over have half as many unknowns and solve spin-ups
# in half the time, but of 60 deflected beams two then had error bars a tenth too small and one a
# limit that was 0.2 % too low: they resolve the straight modes and leave little to spare.
LAYERS = Grading(layer=3.0, ratio=4.0, widest=math.inf)


def folded_over(beam: Beam) -> Beam:
    """The beam turned over at its clamp, to where the load pulls it: a straight outward one."""
    load = max(beam.gamma**2, abs(beam.spin_up))
    return beam.replace(gamma=math.sqrt(load), delta=abs(beam.delta), spin_up=0.0)


def layer_widths(beam: Beam, problem: Problem) -> list[tuple[Span, list[float]]]:
    """The parts of the beam folded over, and the widths of the bending layers at both ends of each:
    sqrt of bending stiffness over tension."""
    folded, law = folded_over(beam), problem.strain_law
    positions = unstretched_positions(folded)
    if not is_small_strain(folded, law):
        with suppress(NoEquilibrium, NotConverged):  # more force than the law has
            _, positions = coarse_equilibrium(folded, law)
    spans = find_spans(folded, positions, law, problem.bending_property)
    power = 2 * problem.curvature_power - 3
    return [
        (span, [math.sqrt(end.EI / (max(end.N, end.EI) * end.f**power)) for end in span])
        for span in spans
    ]


def graded_breaks(beam: Beam, problem: Problem, grading: Grading) -> list[float]:
    """Ends of elements graded towards the layers of bending at the clamp, at bodies and at jumps of
    a property."""
    breaks = {0.0}
    for span, (first, last) in layer_widths(beam, problem):
        start, end = span.start.x, span.end.x
        length = end - start
        if not span.start.smooth and first < grading.widest * length:
            away = distances(grading.layer * first, grading.ratio, length / 2)
            breaks |= {start + distance for distance in away}
        if end == 1 or not span.end.smooth:
            breaks.add(end)
        if end < 1 and not span.end.smooth and last < grading.widest * length:
            away = distances(grading.layer * last, grading.ratio, length / 2)
            breaks |= {end - distance for distance in away}
    return sorted(breaks)


def first_elements(beam: Beam, problem: Problem) -> Elements:
    """Elements graded towards the layers of bending."""
    starts: list[float] = []  # of the elements
    for a, b in pairwise(graded_breaks(beam, problem, LAYERS)):
        n = math.ceil((b - a) / LONGEST_ELEMENT)
        starts += [a + (b - a) * k / n for k in range(n)]
    orders = (FIRST_ORDER,) * len(starts)
    return Elements((*starts, 1.0), orders, orders)


def distances(first: float, ratio: float, longest: float) -> Iterator[float]:
    """Distances of graded breaks from the end of a span, below `longest`."""
    while first < longest:
        yield first
        first *= ratio


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
