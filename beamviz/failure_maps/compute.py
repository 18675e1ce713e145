"""Failure maps as data: does a method solve a beam correctly, over speed and one other number.

Two errors are told apart. Discretisation error: the distance of a method from the exact
frequencies of its own model. Model error: the distance of these from the reference, the paper's
model (green strain, spatial curvature) as `auto` solves it.
"""

import sys
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from beamviz.beam import MAX_GAMMA_OVER_MU, Beam
from beamviz.errors import BeamvizError, NoEquilibrium, NotConverged
from beamviz.solver import solve
from beamviz.solver.solution import Solution

MODES, EXACT_MODES = 5, 10  # compared at the most; of the exact solution, where they may be higher
EXACT = 1e-8  # relative tolerance of a model's own frequencies
ACCURATE = 1e-3  # largest relative discretisation error of a correct method
FAITHFUL = 1e-2  # largest relative model error of a correct method
HELPFUL = 0.5  # more terms help if they leave less than this share of an error
SLOWEST, FASTEST = 0.5, 200.0  # gamma
BISECTIONS = 20
TRUE_LOSS = 0.95  # of the reference's buckling speed: a model that buckles later is right

RIGHT = "right"
INACCURATE = "inaccurate"
OTHER_MODEL = "other model"
FALSELY_UNSTABLE = "falsely unstable"
TRULY_UNSTABLE = "truly unstable"
NO_EQUILIBRIUM = "no equilibrium"
NOT_CONVERGED = "did not converge"
ROUNDING = "rounding"
OUTSIDE = "outside"  # not an accepted beam

KINDS = {
    RIGHT: "right: within 0.001 of its own model's exact frequencies",
    INACCURATE: "inaccurate: a larger discretisation error",
    OTHER_MODEL: "its model is more than 1 % off the reference",
    FALSELY_UNSTABLE: "falsely unstable: the beam is stable",
    TRULY_UNSTABLE: "truly unstable, and reported as such",
    NO_EQUILIBRIUM: "no equilibrium in its model, and reported as such",
    NOT_CONVERGED: "did not converge",
    ROUNDING: "rounding error: more terms do not help",
}
CORRECT = (RIGHT, TRULY_UNSTABLE, OUTSIDE)

# Models: the options of `solve` that give their exact frequencies.
REFERENCE = "green"
MODELS: dict[str, dict[str, Any]] = {
    REFERENCE: {"strain": "green"},
    "biot": {"strain": "biot"},
    "hencky": {"strain": "hencky"},
    "rigid": {"method": "foac"},
    "unstiffened": {"method": "zoac"},
}


class Method(NamedTuple):
    """A method with its options of `solve`, its model, and a larger number of terms where it has
    terms."""

    name: str
    options: dict[str, Any]
    model: str = REFERENCE
    more_terms: int = 0


METHODS = (
    Method("auto", {}),
    Method("auto, biot strain", {"strain": "biot"}, "biot"),
    Method("auto, hencky strain", {"strain": "hencky"}, "hencky"),
    Method("ancf", {"method": "ancf", "elements": 20}),
    Method("ancf-planar", {"method": "ancf-planar", "elements": 20}),
    Method("chebyshev", {"method": "chebyshev", "terms": 32}, more_terms=64),
    Method("linear", {"method": "linear", "elements": 20}, "rigid"),
    Method("foac", {"method": "foac"}, "rigid"),
    Method("zoac", {"method": "zoac"}, "unstiffened"),
    Method("assumed-modes", {"method": "assumed-modes", "terms": 10}, "rigid", 15),
    Method("power-series", {"method": "power-series", "terms": 80}, "rigid", 160),
)

Answer = Solution | BeamvizError


class Verdict(NamedTuple):
    """Its kind, the two errors behind it (nan where there are none), the message of an error, and
    the gamma beyond which the method reports no equilibrium."""

    kind: str
    discretisation: float = np.nan
    model: float = np.nan
    message: str = ""
    limit: float = np.nan


def answer(beam: Beam, **options: Any) -> Answer:
    """A solution, or the error in its place."""
    try:
        return solve(beam, **options)
    except (NoEquilibrium, NotConverged) as error:
        return error


def verdicts(beam: Beam) -> list[Verdict]:
    """The verdict on every method for one beam."""
    exact = {
        name: answer(beam, modes=EXACT_MODES, tolerance=EXACT, **model)
        for name, model in MODELS.items()
    }
    return [verdict(beam, one, exact[one.model], exact[REFERENCE]) for one in METHODS]


def verdict(beam: Beam, method: Method, own: Answer, reference: Answer) -> Verdict:
    """The verdict on one method, from the exact answers of its own model and of the reference."""
    found = judge(answer(beam, modes=MODES, **method.options), own, reference)
    if method.more_terms and found.kind in (INACCURATE, NOT_CONVERGED):
        more = answer(beam, modes=MODES, **method.options | {"terms": method.more_terms})
        if not improved(found, judge(more, own, reference)):
            return found._replace(kind=ROUNDING)
    return found


def improved(before: Verdict, after: Verdict) -> bool:
    """Whether more terms brought a method closer to its own model."""
    if after.kind == NOT_CONVERGED:
        return False
    if before.kind == NOT_CONVERGED:
        return after.kind != INACCURATE
    return not after.discretisation > HELPFUL * before.discretisation


def judge(found: Answer, own: Answer, reference: Answer) -> Verdict:
    """The verdict on an answer, from the exact ones of its own model and of the reference."""
    if isinstance(found, NoEquilibrium) and isinstance(own, NoEquilibrium):
        return Verdict(NO_EQUILIBRIUM, message=str(found), limit=found.limit)
    if not isinstance(found, Solution):
        return Verdict(NOT_CONVERGED, message=str(found))
    errors = distance(found, own, found.labels), distance(own, reference, found.labels)
    if found.equilibrium.status == "unstable" and isinstance(reference, Solution):
        unstable = reference.equilibrium.status == "unstable"
        return Verdict(TRULY_UNSTABLE if unstable else FALSELY_UNSTABLE, *errors)
    inaccurate, unfaithful = errors[0] / ACCURATE, errors[1] / FAITHFUL
    if max(inaccurate, unfaithful) <= 1:
        return Verdict(RIGHT, *errors)
    return Verdict(INACCURATE if inaccurate > unfaithful else OTHER_MODEL, *errors)


def distance(one: Answer, other: Answer, labels: tuple[str, ...]) -> float:
    """The largest relative difference in frequency (or rate of growth) of the modes with these
    labels; infinite where only one has the mode, or only one is stable."""
    if not (isinstance(one, Solution) and isinstance(other, Solution)):
        return np.inf
    squares = [dict(zip(found.labels, found.omega_squared, strict=True)) for found in (one, other)]
    ours, theirs = (np.array([found.get(label, np.nan) for label in labels]) for found in squares)
    if not np.all(ours * theirs > 0):
        return np.inf
    return float(abs(np.sqrt(ours / theirs) - 1).max())


class Plane(NamedTuple):
    """The number that varies beside the speed, the beam of the others, and its description."""

    over: str
    beam: Beam
    start: float
    stop: float
    logarithmic: bool
    held: str

    def at(self, gamma: float, value: float) -> Beam:
        """The beam at a place of the plane."""
        return self.beam.replace(gamma=float(gamma), **{self.over: float(value)})


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
        return np.fmin.reduce(found, axis=1)


def edges(start: float, stop: float, count: int, logarithmic: bool) -> np.ndarray:
    """Edges (count + 1,) of cells of one size."""
    return (np.geomspace if logarithmic else np.linspace)(start, stop, count + 1)


def middles(start: float, stop: float, count: int, logarithmic: bool) -> np.ndarray:
    """Middles (count,) of the cells, to four digits for the commands that name them."""
    places = edges(start, stop, count, logarithmic)
    found = np.sqrt(places[1:] * places[:-1]) if logarithmic else (places[1:] + places[:-1]) / 2
    return np.array([float(f"{value:.4g}") for value in found])


def compute_rows(
    plane: Plane, size: tuple[int, int], pool: Executor, row: Callable[..., Any], name: str
) -> tuple[np.ndarray, np.ndarray, Iterator[Any]]:
    """The middles of the cells along the speed and across, and what row(gammas, value) returns for
    each row, transposed; the rows are computed in parallel."""
    columns, rows = size
    gammas = middles(SLOWEST, FASTEST, columns, True)
    values = middles(plane.start, plane.stop, rows, plane.logarithmic)
    done = []
    for k, one in enumerate(pool.map(partial(row, gammas), values.tolist())):
        done.append(one)
        print(f"{name}gamma and {plane.over}: row {k + 1} of {rows}", file=sys.stderr)
    return gammas, values, zip(*done, strict=True)


def compute_map(plane: Plane, size: tuple[int, int], pool: Executor) -> Map:
    """The verdicts of one plane."""
    gammas, values, parts = compute_rows(plane, size, pool, partial(compute_row, plane), "")
    verdicts, buckling, losses = parts
    return Map(plane, gammas, values, list(verdicts), np.array(buckling), np.array(losses))


def compute_row(
    plane: Plane, gammas: np.ndarray, value: float
) -> tuple[list[list[Verdict]], float, list[float]]:
    """One row of the verdicts, of `buckling` and of `losses`."""
    beam = plane.beam.replace(**{plane.over: value})
    accepted = gammas[gammas <= MAX_GAMMA_OVER_MU * beam.mu]
    row = [verdicts(beam.replace(gamma=gamma)) for gamma in accepted]
    row += [[Verdict(OUTSIDE)] * len(METHODS)] * (len(gammas) - len(accepted))
    onsets = {name: onset(beam, accepted, model) for name, model in MODELS.items()}
    buckling, losses = onsets[REFERENCE], [onsets[method.model] for method in METHODS]
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
