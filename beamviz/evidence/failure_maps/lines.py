"""Cells along the speed: where they are solved, and the speeds at which something begins."""

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq

from beamviz.beam import Beam
from beamviz.evidence.failure_maps.kinds import Kind
from beamviz.solver import Answer, Solution, solve, solve_many

STRIDE = 4  # columns: 9 of 22,000 cells differ from maps in which every cell is solved
PRECISION = 1e-8  # relative, of a speed at which a beam becomes unstable


class Cell(NamedTuple):
    """A cell of a map."""

    kind: Kind
    discretisation: float = np.nan  # error, relative; nan where there are no frequencies
    model: float = np.nan  # error, relative; nan likewise
    message: str = ""  # of the error that was raised
    limit: float = np.nan  # gamma beyond which no equilibrium is reported
    solved: bool = True  # False: not computed, but between two cells of its kind


class MethodLine(NamedTuple):
    """One method along the speed. A speed is nan where there is none."""

    cells: Sequence[Cell]
    limit: float = np.nan  # speed beyond which there is no equilibrium, or no stable state
    buckling: float = np.nan  # from which the reference, or its straight state, is unstable
    loss: float = np.nan  # from which only the method's model is unstable
    refusal: str = ""  # the message of a method that does not treat the beam; it has no cells


def subdivided(count: int, cell: Callable[[int], Cell]) -> list[Cell]:
    """The cells 0 .. count - 1: every STRIDE-th is solved, then the middle between two that differ
    in kind, until they are neighbours; the others have the kind of the two around them."""
    cells: dict[int, Cell] = {}

    def fill(low: int, high: int) -> None:
        if cells[low].kind == cells[high].kind:
            between = Cell(cells[low].kind, solved=False)
            cells.update(dict.fromkeys(range(low + 1, high), between))
        elif high - low > 1:
            middle = (low + high) // 2
            cells[middle] = cell(middle)
            fill(low, middle)
            fill(middle, high)

    coarse = [*range(0, count - 1, STRIDE), count - 1]
    for place in coarse:
        cells[place] = cell(place)
    for low, high in pairwise(coarse):
        fill(low, high)
    return [cells[place] for place in range(count)]


def answer_of(beam: Beam, **options: Any) -> Answer:
    """A solution, or the error in its place."""
    return solve_many([beam], **options)[0]


def is_unstable(answer: Answer) -> bool:
    """Whether an answer is an equilibrium with divergence: a growing mode without a frequency."""
    return isinstance(answer, Solution) and answer.equilibrium.status == "unstable"


def onset(beam: Beam, stable: float, unstable: float, **options: Any) -> float:
    """The speed, between two, at which the straight state becomes unstable: there the lowest
    omega^2 changes its sign."""

    def lowest(gamma: float) -> float:
        return float(solve(beam.replace(gamma=gamma), modes=1, **options).omega_squared[0])

    return float(brentq(lowest, stable, unstable, rtol=PRECISION))
