"""The maps: planes over the speed and one other number, computed line by line in parallel."""

import sys
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Executor
from typing import Any, NamedTuple

import numpy as np

from beamviz.beam import PARAMETERS, Beam, Parameter
from beamviz.evidence.failure_maps import failures, kinds, states
from beamviz.evidence.failure_maps.kinds import Kind
from beamviz.evidence.failure_maps.lines import MethodLine
from beamviz.evidence.failure_maps.methods import METHODS, ComparedMethod
from beamviz.workers import completed

SLOWEST, FASTEST = 0.5, 200.0  # gamma


class Subject(NamedTuple):
    """The question of a map, and the texts of its picture."""

    lines: Callable[[Beam, np.ndarray], list[MethodLine]]  # of all methods at one value
    options: dict[str, Any]  # of `solve`, besides those of each method
    kinds: tuple[Kind, ...]
    correct: tuple[Kind, ...]  # the kinds of cells whose command is not listed
    size: tuple[int, int]  # cells along the speed and across
    quick_size: tuple[int, int]
    heading: str
    subtitle: str
    boundary: str  # the meaning of a line
    buckling: str  # the meaning of a dashed line


FAILURES = Subject(
    failures.method_lines,
    {},
    (
        kinds.RIGHT,
        kinds.INACCURATE,
        kinds.OTHER_MODEL,
        kinds.TRULY_UNSTABLE,
        kinds.ROUNDING,
        kinds.NOT_CONVERGED,
        kinds.FALSELY_UNSTABLE,
        kinds.NO_EQUILIBRIUM,
        kinds.OUTSIDE,
    ),
    (kinds.RIGHT, kinds.TRULY_UNSTABLE, kinds.OUTSIDE),
    (32, 20),
    (14, 9),
    "Where methods fail: speed γ and {}",
    "Five lowest modes in the plane of rotation, {}. Reference: the paper's model (green strain,"
    " spatial curvature), solved by auto.",
    "where a failure begins",
    "where the beam buckles",
)
STATES = Subject(
    states.method_lines,
    states.OPTIONS,
    (kinds.STRAIGHT, kinds.BENT, kinds.SEVERAL, kinds.NO_STATE, kinds.NOT_CONVERGED),
    (),
    (22, 12),
    (10, 6),
    "Stable states of an inward beam: speed γ and {}",
    "At constant speed, {}. Bent in the plane of rotation.",
    "end of the stable states",
    "where the straight beam buckles",
)


class Plane(NamedTuple):
    """The plane of a map: the speed and another number of a beam."""

    name: str
    subject: Subject
    over: str  # the other number, from `start` to `stop`
    start: float
    stop: float
    logarithmic: bool
    beam: Beam  # with the numbers that do not vary
    held: str  # these numbers in words

    def at(self, gamma: float, value: float) -> Beam:
        """The beam at a place of the plane."""
        return self.beam.replace(gamma=float(gamma), **{self.over: float(value)})

    @property
    def parameter(self) -> Parameter:
        """The symbol and the label of its number."""
        return PARAMETERS[self.over]


MASS, OUTWARD, INWARD = Beam(beta=0.5, delta=1), Beam(delta=1), Beam(delta=-1)
PLANES = (
    Plane("delta", FAILURES, "delta", -1.5, 2.5, False, Beam(), "no mass, μ = 70"),
    Plane("alpha", FAILURES, "alpha", 0.01, 100, True, MASS, "mass at β = 0.5, δ = 1, μ = 70"),
    Plane("mu", FAILURES, "mu", 10, 10000, True, OUTWARD, "no mass, δ = 1"),
    Plane("states", STATES, "delta", -2.0, 0.0, False, INWARD, "no mass, μ = 70"),
)


class MethodMap(NamedTuple):
    """A method over a plane, line by line."""

    method: ComparedMethod
    lines: Sequence[MethodLine]

    @property
    def name(self) -> str:
        return self.method.name

    @property
    def options(self) -> dict[str, Any]:
        """Options of `solve`."""
        return self.method.options

    @property
    def kinds(self) -> np.ndarray:
        """Names of kinds (rows, columns)."""
        names = [[cell.kind.name for cell in line.cells] for line in self.lines]
        return np.array(names, dtype=str)  # also of a method without cells

    @property
    def solved(self) -> np.ndarray:
        """Whether each cell was solved (rows, columns)."""
        return np.array([[cell.solved for cell in line.cells] for line in self.lines])

    def speeds(self, name: str) -> np.ndarray:
        """Speeds (rows,) by their name in `MethodLine`."""
        return np.array([getattr(line, name) for line in self.lines])

    @property
    def refusal(self) -> str:
        """The message of a method that cannot be asked; empty where it can."""
        return self.lines[0].refusal


class Map(NamedTuple):
    """A plane, and each method over it."""

    plane: Plane
    gammas: np.ndarray  # (columns,) middles of the cells
    values: np.ndarray  # (rows,)
    methods: Sequence[MethodMap]


def edges(start: float, stop: float, count: int, logarithmic: bool) -> np.ndarray:
    """Edges (count + 1,) of cells of one size."""
    return (np.geomspace if logarithmic else np.linspace)(start, stop, count + 1)


def middles(start: float, stop: float, count: int, logarithmic: bool) -> np.ndarray:
    """Middles (count,) of the cells, to four digits for the commands that name them."""
    ends = edges(start, stop, count, logarithmic)
    places = np.sqrt(ends[1:] * ends[:-1]) if logarithmic else (ends[1:] + ends[:-1]) / 2
    return np.array([float(f"{place:.4g}") for place in places])


class MapRow(NamedTuple):
    """A task: the lines of all methods at one value of a plane. place: the number of the plane, and
    of the row in it."""

    place: tuple[int, int]
    lines: Callable[[Beam, np.ndarray], list[MethodLine]]
    beam: Beam
    gammas: np.ndarray


def compute_maps(quick: bool, pool: Executor) -> list[Map]:
    """Every map; the lines of all of them are computed in parallel, with progress on stderr."""
    grids = [(plane, *grid(plane, quick)) for plane in PLANES]
    rows = [
        MapRow((number, row), plane.subject.lines, plane.at(0, value), gammas)
        for number, (plane, gammas, values) in enumerate(grids)
        for row, value in enumerate(values)
    ]
    lines = dict(with_progress(completed(pool, lines_of, iter(rows)), len(rows)))
    return [
        Map(*place, by_method([lines[number, row] for row in range(len(place[2]))]))
        for number, place in enumerate(grids)
    ]


def lines_of(
    place: tuple[int, int],
    lines: Callable[[Beam, np.ndarray], list[MethodLine]],
    beam: Beam,
    gammas: np.ndarray,
) -> list[MethodLine]:
    """The result of a MapRow."""
    return lines(beam, gammas)


def grid(plane: Plane, quick: bool) -> tuple[np.ndarray, np.ndarray]:
    """The middles of the cells of a plane along the speed (columns,) and across (rows,)."""
    columns, rows = plane.subject.quick_size if quick else plane.subject.size
    gammas = middles(SLOWEST, FASTEST, columns, True)
    return gammas, middles(plane.start, plane.stop, rows, plane.logarithmic)


def by_method(rows: Sequence[Sequence[MethodLine]]) -> list[MethodMap]:
    """The map of each method, from the lines of all of them at each value."""
    return [*map(MethodMap, METHODS, zip(*rows, strict=True))]


def with_progress(
    computed: Iterable[tuple[MapRow, list[MethodLine]]], count: int
) -> Iterator[tuple[tuple[int, int], list[MethodLine]]]:
    """The place of each of `count` rows and its lines, as they are computed; on stderr how many
    are, and the time left at their rate."""
    start = time.monotonic()
    for done, (row, lines) in enumerate(computed, 1):
        left = (time.monotonic() - start) * (count - done) / done
        print(f"{done} of {count} lines, {left:.0f} s left", file=sys.stderr)
        yield row.place, lines
