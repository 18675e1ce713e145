"""Failure maps as data: verdicts on every method over speed and one other number."""

from collections.abc import Callable
from concurrent.futures import Executor, ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from typing import Any, NamedTuple

import numpy as np

from beamviz.beam import MAX_GAMMA_OVER_MU, Beam
from beamviz.failure_maps.verdicts import GREEN, METHODS, OUTSIDE, Verdict, answer, verdicts
from beamviz.solver.solution import Solution

FULL, QUICK = (32, 20), (14, 9)  # cells along the speed and across
SLOWEST, FASTEST = 0.5, 200.0  # gamma
BISECTIONS = 20
TRUE_LOSS = 0.95  # of the reference's buckling speed: a model that buckles later is right


class Plane(NamedTuple):
    """What varies beside the speed, the beam that is held, and its description."""

    over: str
    beam: Beam
    start: float
    stop: float
    logarithmic: bool
    held: str


PLANES = (
    Plane("delta", Beam(), -1.5, 2.5, False, "no mass, μ = 70"),
    Plane("alpha", Beam(beta=0.5, delta=1), 0.01, 100, True, "mass at β = 0.5, δ = 1, μ = 70"),
    Plane("mu", Beam(delta=1), 10, 10000, True, "no mass, δ = 1"),
)


class Map(NamedTuple):
    """Verdicts over a plane, verdicts[row][column][method]."""

    plane: Plane
    gammas: np.ndarray  # (columns,) middles of the cells
    values: np.ndarray  # (rows,)
    verdicts: list[list[list[Verdict]]]
    buckling: np.ndarray  # (rows,) gamma from which the reference is unstable; nan: stable
    losses: np.ndarray  # (rows, methods) gamma from which only the method's model is unstable

    def kinds(self, method: int) -> np.ndarray:
        """Kinds (rows, columns) of the verdicts on a method."""
        return np.array([[cell[method].kind for cell in row] for row in self.verdicts])

    def limits(self, method: int) -> np.ndarray:
        """(rows,) gamma beyond which a method's model has no equilibrium; nan: it has one."""
        found = np.array([[cell[method].limit for cell in row] for row in self.verdicts])
        lowest = np.where(np.isnan(found), np.inf, found).min(axis=1)
        return np.where(np.isinf(lowest), np.nan, lowest)


def edges(start: float, stop: float, count: int, logarithmic: bool) -> np.ndarray:
    """Edges (count + 1,) of cells of one size."""
    return (np.geomspace if logarithmic else np.linspace)(start, stop, count + 1)


def middles(start: float, stop: float, count: int, logarithmic: bool) -> np.ndarray:
    """Middles (count,) of the cells, to four digits for the commands that name them."""
    places = edges(start, stop, count, logarithmic)
    found = np.sqrt(places[1:] * places[:-1]) if logarithmic else (places[1:] + places[:-1]) / 2
    return np.array([float(f"{value:.4g}") for value in found])


def compute_maps(size: tuple[int, int], progress: Callable[[str], None]) -> list[Map]:
    """Every plane, its rows computed in parallel."""
    with ProcessPoolExecutor(mp_context=get_context("spawn")) as pool:
        return [compute_map(plane, size, pool, progress) for plane in PLANES]


def compute_map(
    plane: Plane, size: tuple[int, int], pool: Executor, progress: Callable[[str], None]
) -> Map:
    """The verdicts of one plane."""
    columns, rows = size
    gammas = middles(SLOWEST, FASTEST, columns, True)
    values = middles(plane.start, plane.stop, rows, plane.logarithmic)
    done = []
    for k, row in enumerate(pool.map(partial(compute_row, plane, gammas), values)):
        done.append(row)
        progress(f"gamma and {plane.over}: row {k + 1} of {rows}")
    found, buckling, losses = zip(*done, strict=True)
    return Map(plane, gammas, values, list(found), np.array(buckling), np.array(losses))


def compute_row(
    plane: Plane, gammas: np.ndarray, value: float
) -> tuple[list[list[Verdict]], float, list[float]]:
    """One row of the verdicts, of `buckling` and of `losses`."""
    beam = plane.beam.replace(**{plane.over: value})
    fastest = MAX_GAMMA_OVER_MU * beam.mu
    row = [
        verdicts(beam.replace(gamma=gamma))
        if gamma <= fastest
        else [Verdict(OUTSIDE)] * len(METHODS)
        for gamma in gammas
    ]
    accepted = gammas[gammas <= fastest]
    buckling = onset(beam, accepted, GREEN)
    onsets = {str(method.model): onset(beam, accepted, method.model) for method in METHODS}
    losses = [onsets[str(method.model)] for method in METHODS]
    return row, buckling, [np.nan if loss >= TRUE_LOSS * buckling else loss for loss in losses]


def onset(beam: Beam, gammas: np.ndarray, model: dict[str, Any]) -> float:
    """The speed at which a beam becomes unstable in a model; nan if it is stable at all gammas."""

    def unstable(gamma: float) -> bool:
        found = answer(beam.replace(gamma=gamma), modes=1, **model)
        return isinstance(found, Solution) and found.equilibrium.status == "unstable"

    high = float(next(filter(unstable, gammas), np.nan))
    low = 0.0
    for _ in range(BISECTIONS if np.isfinite(high) else 0):
        middle = (low + high) / 2
        low, high = (low, middle) if unstable(middle) else (middle, high)
    return high
