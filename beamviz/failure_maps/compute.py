"""Maps as data, over speed and one other number: does a method solve a beam correctly, and which
stable states has an inward beam.

Two errors are told apart. Discretisation error: the distance of a method from the exact
frequencies of its own model. Model error: the distance of these from the reference, the paper's
model (green strain, spatial curvature) as `auto` solves it.

A beam has more than one stable state where a search from other guesses, at every fourth speed, or
the other state of a neighbour in the row finds one that is resolved and no mirror image.
"""

import sys
from collections.abc import Sequence
from concurrent.futures import Executor
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from beamviz.beam import MAX_GAMMA_OVER_MU, Beam
from beamviz.errors import InvalidInput, NoEquilibrium
from beamviz.frequency_loci.equilibria import is_deflected
from beamviz.frequency_loci.mode_vectors import Outcome
from beamviz.plotting import FAINT, INK
from beamviz.solver import other_stable_states, solve_many
from beamviz.solver.solution import Solution

MODES, EXACT_MODES = 5, 10  # compared at the most; of the exact solution, where they may be higher
EXACT = 1e-8  # relative tolerance of a model's own frequencies
ACCURATE = 1e-3  # largest relative discretisation error of a correct method
FAITHFUL = 1e-2  # largest relative model error of a correct method
HELPFUL = 0.5  # more terms help if they leave less than this share of an error
SLOWEST, FASTEST = 0.5, 200.0  # gamma
BISECTIONS = 20
TRUE_LOSS = 0.95  # of the reference's buckling speed: a model that buckles later is right
STATE_TOLERANCE = 1e-3  # of the frequency, which the map of states does not show
SEARCHED = 4  # columns of the map from one search for a second state to the next


class Kind(NamedTuple):
    """A kind of cell, the colour and the hatch that it is drawn in, and the colour of its label."""

    name: str
    meaning: str
    face: str
    hatch: str = ""
    ink: str = INK


# Safe for the colour-blind and in grey: lightness falls, and hatches help.
RIGHT = Kind(
    "right", "right: within 0.001 of its own model's exact frequencies", "white", "", FAINT
)
INACCURATE = Kind("inaccurate", "inaccurate: a larger discretisation error", "#F7E98E")
OTHER_MODEL = Kind("other model", "its model is more than 1 % off the reference", "#A9D3F0")
TRULY_UNSTABLE = Kind("truly unstable", "truly unstable, and reported as such", "#C4C4C4", "////")
ROUNDING = Kind("rounding", "rounding error: more terms do not help", "#6FBFA6", "....")
NOT_CONVERGED = Kind("did not converge", "did not converge", "#A0508A", "xxx", "white")
FALSELY_UNSTABLE = Kind(
    "falsely unstable", "falsely unstable: the beam is stable", "#C44601", "", "white"
)
NO_EQUILIBRIUM = Kind(
    "no equilibrium", "no equilibrium in its model, reported as such", "#2B2B2B", "", "white"
)
OUTSIDE = Kind("outside", "not accepted: γ above 5 μ", "#F0F0F0")
KINDS: tuple[Kind, ...] = (RIGHT, INACCURATE, OTHER_MODEL, TRULY_UNSTABLE)
KINDS += (ROUNDING, NOT_CONVERGED, FALSELY_UNSTABLE, NO_EQUILIBRIUM)
CORRECT = (RIGHT, TRULY_UNSTABLE, OUTSIDE)

STRAIGHT = RIGHT._replace(name="straight", meaning="straight, and stable")
BENT = OTHER_MODEL._replace(name="bent", meaning="bent; the straight state is unstable")
SEVERAL = ROUNDING._replace(
    name="more than one", meaning="more than one stable state, mirror images apart"
)
NO_STATE = NO_EQUILIBRIUM._replace(name="no stable state", meaning="no stable state found")
STATES = (STRAIGHT, BENT, SEVERAL, NO_STATE, NOT_CONVERGED)

# Models: the options of `solve` that give their exact frequencies.
REFERENCE = "green"
MODELS = {strain: {"strain": strain} for strain in (REFERENCE, "biot", "hencky")}
MODELS |= {"rigid": {"method": "foac"}, "unstiffened": {"method": "zoac"}}


class Method(NamedTuple):
    """A method with its options of `solve`, its model, and a larger number of terms, if any."""

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


class Verdict(NamedTuple):
    """Its kind, the two errors behind it (nan where there are none), the message of an error, and
    the gamma beyond which the method reports no equilibrium."""

    kind: Kind
    discretisation: float = np.nan
    model: float = np.nan
    message: str = ""
    limit: float = np.nan


def answer(beam: Beam, **options: Any) -> Outcome:
    """A solution, or the error in its place."""
    return solve_many([beam], **options)[0]


def verdicts(beam: Beam) -> list[Verdict]:
    """The verdict on every method for one beam."""
    solve_exactly = partial(answer, beam, modes=EXACT_MODES, tolerance=EXACT)
    exact = {name: solve_exactly(**model) for name, model in MODELS.items()}
    return [verdict(beam, one, exact[one.model], exact[REFERENCE]) for one in METHODS]


def verdict(beam: Beam, method: Method, own: Outcome, reference: Outcome) -> Verdict:
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


def judge(found: Outcome, own: Outcome, reference: Outcome) -> Verdict:
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


def distance(one: Outcome, other: Outcome, labels: tuple[str, ...]) -> float:
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
    """The number that varies beside the speed, the beam of the others, its description, the kinds
    of its cells, and options of `solve` besides those of each method."""

    over: str
    beam: Beam
    start: float
    stop: float
    logarithmic: bool
    held: str
    kinds: tuple[Kind, ...] = KINDS
    options: dict[str, Any] = {}  # noqa: RUF012  never changed

    def at(self, gamma: float, value: float) -> Beam:
        """The beam at a place of the plane."""
        return self.beam.replace(gamma=float(gamma), **{self.over: float(value)})

    @property
    def states(self) -> bool:
        """Whether its map is of stable states instead of failures."""
        return self.kinds == STATES


PLANES = (
    Plane("delta", Beam(), -1.5, 2.5, False, "no mass, μ = 70"),
    Plane("alpha", Beam(beta=0.5, delta=1), 0.01, 100, True, "mass at β = 0.5, δ = 1, μ = 70"),
    Plane("mu", Beam(delta=1), 10, 10000, True, "no mass, δ = 1"),
)
INWARD = Plane(
    "delta", Beam(delta=-1), -2.0, 0.0, False, "no mass, μ = 70", STATES, {"state": "stable"}
)


class Row(NamedTuple):
    """One method along the speed: the verdict on each cell, and speeds, nan where there is none.
    refusal: its message, instead, where it has no bent states."""

    cells: Sequence[Verdict]
    limit: float = np.nan  # beyond which there is no equilibrium, or no stable state
    buckling: float = np.nan  # from which the reference, or its own straight state, is unstable
    loss: float = np.nan  # from which only the method's model is unstable
    refusal: str = ""


class MethodMap(NamedTuple):
    """A method over a plane, row by row."""

    method: Method
    rows: Sequence[Row]

    @property
    def kinds(self) -> np.ndarray:
        """Names of kinds (rows, columns)."""
        return np.array([[cell.kind.name for cell in row.cells] for row in self.rows])

    def speeds(self, name: str) -> np.ndarray:
        """Speeds (rows,) by their name in `Row`."""
        return np.array([getattr(row, name) for row in self.rows])

    @property
    def refusal(self) -> str:
        """The message of a method without bent states; empty where it has some."""
        return self.rows[0].refusal


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
    places = edges(start, stop, count, logarithmic)
    found = np.sqrt(places[1:] * places[:-1]) if logarithmic else (places[1:] + places[:-1]) / 2
    return np.array([float(f"{value:.4g}") for value in found])


def verdict_rows(plane: Plane, gammas: np.ndarray, value: float) -> list[Row]:
    """The verdicts of each method at one value."""
    beam = plane.beam.replace(**{plane.over: value})
    accepted = gammas[gammas <= MAX_GAMMA_OVER_MU * beam.mu]
    columns = [verdicts(beam.replace(gamma=gamma)) for gamma in accepted]
    columns += [[Verdict(OUTSIDE)] * len(METHODS)] * (len(gammas) - len(accepted))
    onsets = {name: onset(beam, accepted, model) for name, model in MODELS.items()}
    buckling, rows = onsets[REFERENCE], []
    for method, *cells in zip(METHODS, *columns, strict=True):
        limit = float(np.fmin.reduce([cell.limit for cell in cells]))
        loss = onsets[method.model]
        rows.append(Row(cells, limit, buckling, np.nan if loss >= TRUE_LOSS * buckling else loss))
    return rows


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


def state_rows(plane: Plane, gammas: np.ndarray, value: float) -> list[Row]:
    """The stable states by each method at one value."""
    beam, rows = plane.beam.replace(**{plane.over: value}), []
    for method in METHODS:
        options = {"modes": 1, "tolerance": STATE_TOLERANCE, **plane.options, **method.options}
        answers: list[Outcome] = []
        try:
            for gamma in gammas:
                answers.append(answer(beam.replace(gamma=gamma), **options))
                if isinstance(answers[-1], NoEquilibrium):
                    break  # faster beams have no stable state either
        except InvalidInput as error:
            rows.append(Row([], refusal=str(error)))
            continue
        limit = last.limit if isinstance(last := answers[-1], NoEquilibrium) else np.nan
        kinds = [state_kind(*pair) for pair in zip(answers, has_others(answers), strict=True)]
        kinds += [NO_STATE] * (len(gammas) - len(kinds))
        rows.append(Row([*map(Verdict, kinds)], limit, onset(beam, gammas, method.options)))
    return rows


def has_others(answers: Sequence[Outcome]) -> list[bool]:
    """Whether beams with neighbouring speeds have another stable state beside that of each: found
    by a search, or from one that a neighbour has."""
    found: list[list[Solution]] = [
        other_stable_states(one) if is_deflected(one) and k % SEARCHED == 0 else []
        for k, one in enumerate(answers)
    ]
    places = range(len(answers))
    for order in (places, reversed(places)):
        near: list[Solution] = []
        for k in order:
            own = answers[k]
            if near and not found[k] and is_deflected(own):
                found[k] = other_stable_states(own, near)
            near = found[k]
    return [bool(others) for others in found]


def state_kind(found: Outcome, several: bool) -> Kind:
    """The kind of a cell by its answer, and whether there is another stable state."""
    if isinstance(found, NoEquilibrium):
        return NO_STATE
    if not isinstance(found, Solution):
        return NOT_CONVERGED
    return SEVERAL if several else BENT if found.equilibrium.shape == "bent" else STRAIGHT


def compute_map(plane: Plane, size: tuple[int, int], pool: Executor) -> Map:
    """The map of one plane, whose rows are computed in parallel."""
    columns, rows = size
    gammas = middles(SLOWEST, FASTEST, columns, True)
    values = middles(plane.start, plane.stop, rows, plane.logarithmic)
    solve_row, subject = (state_rows, "stable states over ") if plane.states else (verdict_rows, "")
    done = []
    for k, row in enumerate(pool.map(partial(solve_row, plane, gammas), values.tolist())):
        done.append(row)
        print(f"{subject}gamma and {plane.over}: row {k + 1} of {rows}", file=sys.stderr)
    methods = [*map(MethodMap, METHODS, zip(*done, strict=True))]
    return Map(plane, gammas, values, methods)
