"""Maps of where methods fail: verdicts over speed and one other number."""

from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from typing import NamedTuple

import numpy as np

from beamviz.beam import MAX_GAMMA_OVER_MU, Beam
from beamviz.failure_maps.verdicts import CONTENDERS, GREEN, MODES, OUTSIDE, Cell, attempt, cells
from beamviz.solver.solution import Solution

FULL, QUICK = (32, 20), (14, 9)  # cells along the speed and across
FASTEST = 200.0
BISECTIONS = 20
CAUSED = 0.95  # of the true onset: a model that buckles this late has its reason


class Plane(NamedTuple):
    """What is varied against the speed, and the beam that is held."""

    over: str
    beam: Beam
    start: float
    stop: float
    logarithmic: bool
    held: str  # in words


PLANES = (
    Plane("delta", Beam(), -1.5, 2.5, False, "no mass, μ = 70"),
    Plane("alpha", Beam(beta=0.5, delta=1), 0.01, 100, True, "mass at β = 0.5, δ = 1, μ = 70"),
    Plane("mu", Beam(delta=1), 10, 10000, True, "no mass, δ = 1"),
)
SLOWEST = 0.5


class Map(NamedTuple):
    """Verdicts over a plane: cells[row][column] is a list, one for each contender."""

    plane: Plane
    gammas: np.ndarray  # (columns,) middles of the cells
    values: np.ndarray  # (rows,)
    cells: list[list[list[Cell]]]
    buckling: np.ndarray  # (rows,) gamma from which the reference is unstable; nan: stable
    losses: np.ndarray  # (rows, contenders) gamma from which a model is, and the reference not

    def limits(self, contender: int) -> np.ndarray:
        """(rows,) gamma beyond which a contender's model has no equilibrium; nan: it has one."""
        found = [[cell[contender].limit for cell in row] for row in self.cells]
        return np.array([min((g for g in row if g == g), default=np.nan) for row in found])


def middles(start: float, stop: float, count: int, logarithmic: bool) -> np.ndarray:
    """Middles (count,) of cells of one size, to four digits, so that a command can name them."""
    places = edges(start, stop, count, logarithmic)
    found = np.sqrt(places[1:] * places[:-1]) if logarithmic else (places[1:] + places[:-1]) / 2
    return np.array([float(f"{value:.4g}") for value in found])


def edges(start: float, stop: float, count: int, logarithmic: bool) -> np.ndarray:
    """Edges (count + 1,) of cells of one size."""
    return (np.geomspace if logarithmic else np.linspace)(start, stop, count + 1)


def maps(size: tuple[int, int], say: Callable[[str], None]) -> list[Map]:
    """Every plane, its rows shared among the processors."""
    with ProcessPoolExecutor(mp_context=get_context("spawn")) as pool:
        return [one_map(plane, size, pool, say) for plane in PLANES]


def one_map(
    plane: Plane, size: tuple[int, int], pool: ProcessPoolExecutor, say: Callable[[str], None]
) -> Map:
    """The verdicts of one plane."""
    columns, rows = size
    gammas = middles(SLOWEST, FASTEST, columns, True)
    values = middles(plane.start, plane.stop, rows, plane.logarithmic)
    done = []
    for k, row in enumerate(pool.map(partial(one_row, plane, gammas), values)):
        done.append(row)
        say(f"gamma and {plane.over}: row {k + 1} of {rows}")
    found, buckling, losses = zip(*done, strict=True)
    return Map(plane, gammas, values, list(found), np.array(buckling), np.array(losses))


def one_row(
    plane: Plane, gammas: np.ndarray, value: float
) -> tuple[list[list[Cell]], float, list[float]]:
    """The verdicts along the speed, and the speeds at which the reference buckles and at which
    the models of the contenders lose their stability without cause."""
    beam = plane.beam.replace(**{plane.over: value})
    row = [
        cells(beam.replace(gamma=gamma))
        if accepted(gamma, beam.mu)
        else [Cell(OUTSIDE)] * len(CONTENDERS)
        for gamma in gammas
    ]
    buckling = onset(beam, gammas, GREEN)
    onsets = {str(c.model): onset(beam, gammas, c.model) for c in CONTENDERS}
    losses = [onsets[str(contender.model)] for contender in CONTENDERS]
    return row, buckling, [np.nan if loss >= CAUSED * buckling else loss for loss in losses]


def accepted(gamma: float, mu: float) -> bool:
    """Whether there is such a beam."""
    return gamma <= MAX_GAMMA_OVER_MU * mu


def onset(beam: Beam, gammas: np.ndarray, model: dict[str, str]) -> float:
    """The speed at which a beam becomes unstable in a model; nan where it stays stable."""

    def unstable(gamma: float) -> bool:
        found = attempt(beam.replace(gamma=gamma), modes=1, **model)
        return isinstance(found, Solution) and found.equilibrium.status == "unstable"

    first = next((g for g in gammas if accepted(g, beam.mu) and unstable(g)), None)
    if first is None:
        return np.nan
    low, high = 0.0, float(first)
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        low, high = (low, middle) if unstable(middle) else (middle, high)
    return high


def command(beam: Beam, contender: int) -> str:
    """The command that shows a cell again."""
    numbers = " ".join(f"--{name} {value:.10g}" for name, value in beam.numbers.items())
    options = " ".join(f"--{name} {value}" for name, value in CONTENDERS[contender].options.items())
    return f"beamviz modes {numbers} --modes {MODES} {options}".strip()
