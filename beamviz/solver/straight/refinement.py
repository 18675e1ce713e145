"""Refinement to the tolerance: where the highest polynomials of an element carry more of the energy
than is allowed, it gets a higher order, or is halved.

Beams are solved in stacks whose meshes have the same orders.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from beamviz.beam import Beam
from beamviz.errors import BeamvizError, NoEquilibrium, NotConverged, to_keep
from beamviz.mechanics.straight import StraightModes, lowest_modes
from beamviz.mechanics.straight_equilibrium import (
    AxialProblem,
    AxialState,
    StretchOnGrid,
    axial_problem,
    is_small_strain,
    limit_error,
)
from beamviz.mechanics.straight_mesh import first_elements
from beamviz.mechanics.straight_properties import stack_of
from beamviz.solver.continuation import LIMIT_MARGIN
from beamviz.solver.problem import Problem, interruption
from beamviz.solver.stability import is_certain_to_be_stable
from beamviz.space.elements import Elements
from beamviz.space.refinement import quadrature_share, refined
from beamviz.space.spans import ends_of_spans
from beamviz.space.trial import Trial, cached_trial, uniform_trial

# The quadrature of a blade in each further attempt: its error, a share of the elastic energy, may
# be all that is wrong where softening leaves little of that. Without this a blade is not solved
# whose frequency vanishes; 80 blades with dips take as long with it and without.
SHARPER = 1e-2
MAX_ATTEMPTS = 12  # for each beam
MAX_UNKNOWNS = 300  # of one family: a dense eigenproblem of more takes longer than a second
MORE_UNKNOWNS = 30  # for each discontinuity of a blade, with a layer on either side
MOST_UNKNOWNS = 1200  # of a blade: two seconds
MAX_STACK = 48  # beams: more take more memory than the processor's cache has
MAX_ENTRIES = 2**16  # of a matrix of each beam: larger stacks are slower, and take more memory
SHARED = 4  # beams of the same elements from which they share one mesh
VANISHING = 1e-4  # omega^2 below which the tolerance is that of this one: it may be zero
GREATEST_ERROR = 0.01  # of a frequency near a limit where the tolerance cannot be met, relative


class Attempt(NamedTuple):
    """What a beam is to be solved with: alone or in a stack, by Newton's method from a state on
    another mesh, if any."""

    beam: Beam
    elements: Elements
    share: float  # of the energy of a mode that the quadrature of a blade may lose
    small: bool  # of small strain, so that a rough equilibrium suffices
    alone: bool  # whether it may not be in a stack
    start: StretchOnGrid | None = None


ModesOrError = StraightModes | BeamvizError


def converged_modes(beams: Sequence[Beam], problem: Problem, count: int) -> list[ModesOrError]:
    """`count` lowest modes of each beam, those of the problem to its tolerance; or its error."""
    outcomes: list[Attempt | ModesOrError] = [first_attempt(beam, problem) for beam in beams]
    for _ in range(MAX_ATTEMPTS):
        attempts = {k: each for k, each in enumerate(outcomes) if isinstance(each, Attempt)}
        if not attempts:
            break
        for stack in stacks(attempts):
            interruption.get()()
            solved = solve_stack([attempts[k] for k in stack], problem, count)
            for k, outcome in zip(stack, solved, strict=True):
                outcomes[k] = outcome
    ended = NotConverged(f"errors exceed the tolerance after {MAX_ATTEMPTS} meshes")
    return [
        failure(each.beam, problem, ended) if isinstance(each, Attempt) else each
        for each in outcomes
    ]


def first_attempt(beam: Beam, problem: Problem) -> Attempt | ModesOrError:
    """The attempt on the first mesh, or an error."""
    small = problem.rigid_tension or is_small_strain(beam, problem.strain_law)
    try:
        elements, start = first_elements(beam, problem)
        check_unknowns(elements, beam)
    except (NoEquilibrium, NotConverged) as error:
        return failure(beam, problem, error)
    # See `mechanics.straight.lowest_modes`.
    in_stacks = beam.gamma > 0 and is_certain_to_be_stable(beam)
    alone = start is not None or (problem.gyroscopic and not in_stacks)
    return Attempt(beam, elements, quadrature_share(problem.tolerance), small, alone, start)


def stacks(attempts: dict[int, Attempt]) -> Iterator[list[int]]:
    """The numbers of the beams to be solved together: those with the same elements, which share
    one mesh, where there are at least SHARED; of the others those whose elements have the same
    orders."""

    if len(attempts) == 1:
        yield list(attempts)
        return

    def properties(k: int) -> object:
        beam = attempts[k].beam
        return None if beam.is_uniform else (beam.blade, beam.masses, beam.root, beam.alpha > 0)

    def space(attempt: Attempt) -> object:
        """The elements of a blade, whose trial functions depend on them; else the orders."""
        elements = attempt.elements
        return elements.all_orders if attempt.beam.blade is None else (elements, attempt.share)

    together = (k for k, attempt in attempts.items() if not attempt.alone)
    by_elements = grouped(
        (k, (attempts[k].elements, attempts[k].share, properties(k))) for k in together
    )
    shared = [group for group in by_elements if len(group) >= SHARED]
    others = (k for group in by_elements if len(group) < SHARED for k in group)
    by_orders = grouped((k, (space(attempts[k]), properties(k))) for k in others)
    alone = [[k] for k, attempt in attempts.items() if attempt.alone]
    for group in [*shared, *by_orders, *alone]:
        unknowns = sum(attempts[group[0]].elements.orders)
        size = max(1, min(MAX_STACK, MAX_ENTRIES // unknowns**2))
        for first in range(0, len(group), size):
            yield group[first : first + size]


def grouped(keys: Iterable[tuple[int, object]]) -> list[list[int]]:
    """The numbers of (number, key), in groups of the same key."""
    groups: dict[object, list[int]] = {}
    for number, key in keys:
        groups.setdefault(key, []).append(number)
    return list(groups.values())


def common_trial(attempts: list[Attempt], problem: Problem) -> Trial:
    """The trial functions of beams with the same elements, or a stack of those of uniform beams
    whose elements have the same orders."""
    elements = [attempt.elements for attempt in attempts]
    first, blade = elements[0], attempts[0].beam.blade
    if all(each.breaks == first.breaks for each in elements):
        return cached_trial(first, blade, problem.bending_property, attempts[0].share)
    return uniform_trial(np.array([each.breaks for each in elements]), first)


def solve_stack(
    attempts: list[Attempt], problem: Problem, count: int
) -> Sequence[Attempt | ModesOrError]:
    """The modes of each beam of a stack, its error, or another attempt."""
    beams = [attempt.beam for attempt in attempts]
    trial = common_trial(attempts, problem)
    axial = axial_problem(trial.mesh, stack_of(beams), problem.strain_law)
    try:
        state = equilibria(axial, attempts, problem)
        modes = lowest_modes(axial, trial, state, count, problem)
    except (NoEquilibrium, NotConverged, np.linalg.LinAlgError) as error:
        if len(beams) > 1:  # an unstable beam among them
            return [attempt._replace(alone=True) for attempt in attempts]
        if isinstance(error, BeamvizError):
            return [failure(beams[0], problem, error)]
        raise
    # The tolerance is that of the frequency: omega^2 has twice its relative error. Rounding error
    # is exempt: refinement cannot reduce it, and the reported error contains it.
    size = np.maximum(abs(modes.omega_squared), VANISHING)
    allowed = 2 * problem.tolerance * size + modes.rounding
    excess = (modes.truncation / allowed[..., None])[:, : problem.modes]
    worst = np.add.reduce(excess, axis=-1).max(axis=-1)
    modes.omega_squared.setflags(write=False)
    modes.bending_energy_fraction.setflags(write=False)
    rows = zip(attempts, modes.of_each_beam(), excess, worst.tolist(), strict=True)
    return [
        modes_of_beam
        if total <= 1
        else next_attempt(attempt, modes_of_beam, excess_of_beam, problem)
        for attempt, modes_of_beam, excess_of_beam, total in rows
    ]


def equilibria(axial: AxialProblem, attempts: list[Attempt], problem: Problem) -> AxialState:
    """The equilibria of a stack, with an infinite error where there is none of one of several.
    Raises NoEquilibrium and NotConverged."""
    if problem.rigid_tension or not any(attempt.beam.gamma for attempt in attempts):
        return axial.at_rest()
    small = all(attempt.small for attempt in attempts)
    state = axial.solve(small, problem.tolerance, attempts[0].start)
    return axial.followed() if len(attempts) == 1 and math.isinf(state.error[0]) else state


def next_attempt(
    attempt: Attempt, modes: StraightModes, excess: NDArray, problem: Problem
) -> Attempt | ModesOrError:
    """Another attempt on a finer mesh; near a limit of equilibrium, where the rounding error of the
    stretch is large on any mesh, the modes, if their errors are not large.

    excess: truncation errors (modes, elements) relative to what is allowed for all elements.
    """
    totals = excess.sum(axis=-1)
    worst = totals.argmax()
    if math.isinf(totals[worst]):  # the equilibrium was not found in a stack
        return attempt._replace(alone=True)
    elements = refined(attempt.elements, excess[worst].tolist(), attempt.beam.blade)
    try:
        check_unknowns(elements, attempt.beam)
    except NotConverged as error:
        near_limit = modes.margin < LIMIT_MARGIN
        if near_limit and totals[worst] * problem.tolerance < GREATEST_ERROR:
            return modes
        return failure(attempt.beam, problem, error)
    start = StretchOnGrid(modes.grid, modes.f) if attempt.start else None
    return attempt._replace(
        elements=elements, share=attempt.share * SHARPER, small=False, start=start
    )


def check_unknowns(elements: Elements, beam: Beam) -> None:
    """NotConverged with a remedy for too many unknowns."""
    unknowns, most = sum(elements.orders), MAX_UNKNOWNS
    if unknowns > most and not beam.is_uniform:
        most = min(most + MORE_UNKNOWNS * len(ends_of_spans(beam)), MOST_UNKNOWNS)
    if unknowns <= most:
        return
    reason = f"{unknowns} unknowns needed in a family, at most {most}"
    remedy = "a larger tolerance or fewer modes"
    if beam.delta < 0:
        reason += ": the straight beam buckles in many half-waves"
        remedy = "a lower gamma or a larger delta"
    raise NotConverged(f"{reason}; ask for {remedy}")


def failure(beam: Beam, problem: Problem, error: BeamvizError) -> BeamvizError:
    """The error to report for a beam: NoEquilibrium with the limit, beyond it or near it, else the
    error given."""
    with suppress(NotConverged):
        if not problem.rigid_tension:
            error = limit_error(beam, problem.strain_law) or error
    return to_keep(error)
