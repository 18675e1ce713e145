"""The map of an inward beam: which stable states it has over speed and hub radius.

A beam has more than one stable state where a search from other guesses, at every fourth speed, or
the other state of a neighbour in the row finds one that is resolved and no mirror image.
"""

from collections.abc import Sequence
from concurrent.futures import Executor
from functools import partial
from typing import NamedTuple, TypeGuard

import numpy as np

from beamviz.beam import Beam
from beamviz.errors import InvalidInput, NoEquilibrium
from beamviz.failure_maps.compute import METHODS, Answer, Method, Plane, answer, compute_rows, onset
from beamviz.solver import other_stable_states
from beamviz.solver.solution import Solution

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


def compute_states(size: tuple[int, int], pool: Executor, plane: Plane = INWARD) -> StateMap:
    """The map of one plane."""
    refusals = {method.name: refusal_of(plane.beam, method) for method in METHODS}
    able = [method for method in METHODS if not refusals[method.name]]
    row = partial(states_of_row, plane, able)
    gammas, values, parts = compute_rows(plane, size, pool, row, "stable states over ")
    nothing = np.empty((0, 0)), np.empty(0), np.empty(0)
    found = {name: States(*nothing, refusal) for name, refusal in refusals.items()}
    for method, rows in zip(able, parts, strict=True):
        kinds, buckling, limit = map(np.array, zip(*rows, strict=True))
        found[method.name] = States(kinds, buckling, limit)
    return StateMap(plane, gammas, values, found)


def refusal_of(beam: Beam, method: Method) -> str:
    """The message of a method without bent states; empty where it has some."""
    try:
        answer(beam, modes=1, state="stable", **method.options)
    except InvalidInput as error:
        return str(error)
    return ""


def states_of_row(
    plane: Plane, methods: Sequence[Method], gammas: np.ndarray, value: float
) -> list[tuple[list[str], float, float]]:
    """Of each method the kinds (columns,), and the speeds of buckling and of the limit."""
    beam = plane.beam.replace(**{plane.over: value})
    found = []
    for method in methods:
        options = {"state": "stable", "modes": 1, "tolerance": TOLERANCE} | method.options
        answers: list[Answer] = []
        for gamma in gammas:
            answers.append(answer(beam.replace(gamma=gamma), **options))
            if isinstance(answers[-1], NoEquilibrium):
                break  # faster beams have no stable state either
        limit = last.limit if isinstance(last := answers[-1], NoEquilibrium) else np.nan
        kinds = [kind(*pair) for pair in zip(answers, has_others(answers), strict=True)]
        kinds += [NO_STATE] * (len(gammas) - len(kinds))
        found.append((kinds, onset(beam, gammas, method.options), limit))
    return found


def has_others(answers: Sequence[Answer]) -> list[bool]:
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


def is_bent(found: Answer) -> TypeGuard[Solution]:
    """Whether an answer is a bent state."""
    return isinstance(found, Solution) and found.equilibrium.shape == "bent"


def kind(found: Answer, several: bool) -> str:
    """The kind of a cell by its answer, and whether there is another stable state."""
    if isinstance(found, NoEquilibrium):
        return NO_STATE
    if not isinstance(found, Solution):
        return NOT_CONVERGED
    return SEVERAL if several else found.equilibrium.shape
