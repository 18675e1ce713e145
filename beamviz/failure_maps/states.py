"""The map of an inward beam: which stable states it has over speed and hub radius.

A beam has more than one stable state where a search from other guesses, at every fourth speed, or
the other state of a neighbour in the row finds one that is resolved and no mirror image.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from functools import partial
from typing import Any, NamedTuple, TypeGuard

import numpy as np

from beamviz.beam import Beam
from beamviz.errors import BeamvizError, InvalidInput, NoEquilibrium
from beamviz.failure_maps.compute import (
    FASTEST,
    METHODS,
    SLOWEST,
    Method,
    Plane,
    answer,
    middles,
    onset,
)
from beamviz.solver import other_stable_states, solve
from beamviz.solver.solution import Solution

FULL_STATES, QUICK_STATES = (22, 12), (10, 6)  # cells along the speed and across
TOLERANCE = 1e-3  # of the frequency, which the map does not show
SEARCHED = 4  # columns of the map from one search for a second state to the next

STRAIGHT = "straight"
BENT = "bent"
SEVERAL = "more than one"
NO_STATE = "no stable state"
NOT_CONVERGED = "did not converge"

STATES = {
    STRAIGHT: "straight, and stable",
    BENT: "bent; the straight state is unstable",
    SEVERAL: "more than one stable state, mirror images apart",
    NO_STATE: "no stable state found",
    NOT_CONVERGED: "did not converge",
}

INWARD = Plane("delta", Beam(delta=-1), -2.0, 0.0, False, "no mass, μ = 70")


class States(NamedTuple):
    """The stable states by one method; `refusal` is its message where it has no bent ones."""

    kinds: np.ndarray  # (rows, columns)
    buckling: np.ndarray  # (rows,) gamma at which the straight state ceases to be stable
    limit: np.ndarray  # (rows,) gamma beyond which there is no stable state; nan: not reached
    refusal: str = ""


class StateMap(NamedTuple):
    """The states by every method, by its name."""

    plane: Plane
    gammas: np.ndarray  # (columns,) middles of the cells
    values: np.ndarray  # (rows,)
    methods: dict[str, States]


def compute_states(
    size: tuple[int, int], pool: Executor, progress: Callable[[str], None], plane: Plane = INWARD
) -> StateMap:
    """The map of one plane, its rows computed in parallel."""
    columns, rows = size
    gammas = middles(SLOWEST, FASTEST, columns, True)
    values = middles(plane.start, plane.stop, rows, plane.logarithmic)
    refusals = {method.name: refusal_of(plane.beam, method) for method in METHODS}
    able = [method for method in METHODS if not refusals[method.name]]
    done = []
    for k, row in enumerate(pool.map(partial(states_of_row, plane, able, gammas), values)):
        done.append(row)
        progress(f"stable states over gamma and {plane.over}: row {k + 1} of {rows}")
    nothing = np.empty((rows, 0)), np.empty(0), np.empty(0)
    found = {method.name: States(*nothing, refusals[method.name]) for method in METHODS}
    for method, parts in zip(able, zip(*done, strict=True), strict=True):
        kinds, buckling, limit = map(np.array, zip(*parts, strict=True))
        found[method.name] = States(kinds, buckling, limit)
    return StateMap(plane, gammas, values, found)


def refusal_of(beam: Beam, method: Method) -> str:
    """The message of a method without bent states; empty where it has some."""
    try:
        solve(beam, modes=1, state="stable", **method.options)
    except InvalidInput as error:
        return str(error)
    except BeamvizError:
        pass
    return ""


def states_of_row(
    plane: Plane, methods: Sequence[Method], gammas: np.ndarray, value: float
) -> list[tuple[list[str], float, float]]:
    """Of each method the kinds (columns,), and the speeds of buckling and of the limit."""
    beam = plane.beam.replace(**{plane.over: value})
    beams = [beam.replace(gamma=gamma) for gamma in gammas]
    found = []
    for method in methods:
        answers, limit = stable_states(beams, method.options)
        several = has_others(answers)
        kinds = [kind(one, more) for one, more in zip(answers, several, strict=True)]
        kinds += [NO_STATE] * (len(beams) - len(kinds))
        found.append((kinds, onset(beam, gammas, method.options), limit))
    return found


def stable_states(
    beams: list[Beam], options: dict[str, Any]
) -> tuple[list[Solution | BeamvizError], float]:
    """The stable state of each beam, or its error, and the speed beyond which there is none: faster
    beams need no solve."""
    answers: list[Solution | BeamvizError] = []
    for beam in beams:
        given = {"state": "stable", "modes": 1, "tolerance": TOLERANCE} | options
        answers.append(found := answer(beam, **given))
        if isinstance(found, NoEquilibrium):
            return answers, found.limit
    return answers, np.nan


def has_others(answers: Sequence[Solution | BeamvizError]) -> list[bool]:
    """Whether beams with neighbouring speeds have another stable state beside that of each: found
    by a search, or from one that a neighbour has."""
    found: list[list[Solution]] = [
        other_stable_states(one) if is_bent(one) and k % SEARCHED == 0 else []
        for k, one in enumerate(answers)
    ]
    places = range(len(answers))
    for order in (places, reversed(places)):
        near: list[Solution] = []
        for k in order:
            own = answers[k]
            if near and not found[k] and is_bent(own):
                found[k] = other_stable_states(own, near)
            near = found[k]
    return [bool(others) for others in found]


def is_bent(found: Solution | BeamvizError) -> TypeGuard[Solution]:
    """Whether an answer is a bent state."""
    return isinstance(found, Solution) and found.equilibrium.shape == "bent"


def kind(found: Solution | BeamvizError, several: bool) -> str:
    """The kind of a cell by its answer, and whether there is another stable state."""
    if isinstance(found, NoEquilibrium):
        return NO_STATE
    if not isinstance(found, Solution):
        return NOT_CONVERGED
    return SEVERAL if several else found.equilibrium.shape
