"""The map of the stable states of an inward beam, as each method computes them.

A beam has more than one stable state where a search from other guesses finds a second one that is
resolved and no mirror image.
"""

from collections.abc import Sequence

import numpy as np

from beamviz.beam import Beam
from beamviz.errors import InvalidInput, NoEquilibrium
from beamviz.evidence.failure_maps.kinds import (
    BENT,
    NO_STATE,
    NOT_CONVERGED,
    SEVERAL,
    STRAIGHT,
    Kind,
)
from beamviz.evidence.failure_maps.lines import (
    Cell,
    MethodLine,
    answer_of,
    is_unstable,
    onset,
    subdivided,
)
from beamviz.evidence.failure_maps.methods import METHODS, ComparedMethod
from beamviz.solver import Answer, Solution
from beamviz.solver.bent import other_stable_states

OPTIONS = {"state": "stable"}
ACCURACY = {"modes": 1, "tolerance": 1e-3}  # of a frequency, which the map does not show


def method_lines(beam: Beam, gammas: np.ndarray) -> list[MethodLine]:
    """The line of each method: the stable states of the beam at ascending speeds."""
    return [method_line(beam, gammas.tolist(), method) for method in METHODS]


def method_line(beam: Beam, gammas: Sequence[float], method: ComparedMethod) -> MethodLine:
    """The line of one method; its refusal where it has no bent states."""
    limit = np.inf  # of the stable states, as far as it is known

    def cell(k: int) -> Cell:
        nonlocal limit
        if gammas[k] > limit:
            return Cell(NO_STATE, limit=limit, solved=False)
        answer = answer_of(beam.replace(gamma=gammas[k]), **ACCURACY, **OPTIONS, **method.options)
        if not isinstance(answer, NoEquilibrium):
            return Cell(kind_of(answer))
        limit = float(np.fmin(answer.limit, gammas[k]))
        return Cell(NO_STATE, limit=limit)

    try:
        cells = subdivided(len(gammas), cell)
    except InvalidInput as error:
        return MethodLine([], refusal=str(error))
    buckling = end_of_straight_state(beam, gammas, cells, method)
    return MethodLine(cells, limit if np.isfinite(limit) else np.nan, buckling)


def end_of_straight_state(
    beam: Beam, gammas: Sequence[float], cells: Sequence[Cell], method: ComparedMethod
) -> float:
    """The speed beyond the last straight cell at which the straight state becomes unstable; nan
    where that is stable, or has no equilibrium, in the next cell too."""
    count = max((k for k, cell in enumerate(cells, 1) if cell.kind == STRAIGHT), default=0)
    low, *beyond = [0.0, *gammas][count:]
    if beyond and is_unstable(answer_of(beam.replace(gamma=beyond[0]), modes=1, **method.options)):
        return onset(beam, low, beyond[0], **method.options)
    return np.nan


def kind_of(answer: Answer) -> Kind:
    """The kind of a cell, from the answer for its beam."""
    if isinstance(answer, NoEquilibrium):
        return NO_STATE
    if not isinstance(answer, Solution):
        return NOT_CONVERGED
    if answer.equilibrium.shape == "straight":
        return STRAIGHT
    return SEVERAL if other_stable_states(answer) else BENT
