"""Where methods fail: one beam, one method, one verdict.

Two errors are told apart. Discretisation: how far a method is from the exact frequencies of its
own model. Model: how far these are from the reference, the paper's model (green strain, spatial
curvature) as `auto` solves it.
"""

from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from beamviz.beam import Beam
from beamviz.errors import BeamvizError, NoEquilibrium, NotConverged
from beamviz.solver import solve
from beamviz.solver.solution import Solution

MODES, MORE_MODES = 5, 10  # the most that are compared, and those they may have to be looked for in
EXACT = 1e-8  # relative tolerance of a model's own frequencies
ACCURATE = 1e-3  # relative: a method is right this close to its own model
FAITHFUL = 1e-2  # relative: and its model this close to the reference
HELPED = 0.5  # more terms that leave more than this of an error do not help

RIGHT = "right"
INACCURATE = "inaccurate"
OTHER_MODEL = "other model"
FALSELY_UNSTABLE = "falsely unstable"
TRULY_UNSTABLE = "truly unstable"
NO_EQUILIBRIUM = "no equilibrium"
NOT_CONVERGED = "did not converge"
ROUNDED = "rounding"
OUTSIDE = "outside"  # not an accepted beam

KINDS = {
    RIGHT: "right: within 0.001 of its own model's exact frequencies",
    INACCURATE: "inaccurate: further off than that",
    OTHER_MODEL: "its model itself is more than 1 % off the reference",
    FALSELY_UNSTABLE: "falsely unstable: the beam is stable",
    TRULY_UNSTABLE: "truly unstable, and it says so",
    NO_EQUILIBRIUM: "no equilibrium in its model, and it says so",
    NOT_CONVERGED: "did not converge",
    ROUNDED: "rounding has eaten the digits: more terms do not help",
}


class Contender(NamedTuple):
    """A method as it is run, the model it converges to, and more terms where it has terms."""

    name: str
    options: dict[str, Any]
    model: dict[str, Any]  # keywords of `solve` for its exact frequencies
    more: dict[str, Any] | None = None

    @property
    def resolution(self) -> str:
        """Its number of elements or terms, in words; empty for a method that chooses its own."""
        given = [(name, self.options.get(name)) for name in ("elements", "terms")]
        return "".join(f"{number} {name}" for name, number in given if number)


GREEN: dict[str, Any] = {"strain": "green"}
RIGID: dict[str, Any] = {"method": "foac"}
CONTENDERS = (
    Contender("auto", {}, GREEN),
    Contender("auto, biot strain", {"strain": "biot"}, {"strain": "biot"}),
    Contender("auto, hencky strain", {"strain": "hencky"}, {"strain": "hencky"}),
    Contender("ancf", {"method": "ancf", "elements": 20}, GREEN),
    Contender("ancf-planar", {"method": "ancf-planar", "elements": 20}, GREEN),
    Contender("chebyshev", {"method": "chebyshev", "terms": 32}, GREEN, {"terms": 64}),
    Contender("linear", {"method": "linear", "elements": 20}, RIGID),
    Contender("foac", {"method": "foac"}, RIGID),
    Contender("zoac", {"method": "zoac"}, {"method": "zoac"}),
    Contender("assumed-modes", {"method": "assumed-modes", "terms": 10}, RIGID, {"terms": 15}),
    Contender("power-series", {"method": "power-series", "terms": 80}, RIGID, {"terms": 160}),
)

Answer = Solution | BeamvizError


class Cell(NamedTuple):
    """A verdict, the two errors behind it (nan where there are none), and what was said."""

    kind: str
    discretisation: float = np.nan
    model: float = np.nan
    says: str = ""
    limit: float = np.nan  # gamma beyond which the method says there is no equilibrium


def attempt(beam: Beam, **options: Any) -> Answer:
    """A solution, or the error in its place."""
    try:
        return solve(beam, **options)
    except (NoEquilibrium, NotConverged) as error:
        return error


def cells(beam: Beam) -> list[Cell]:
    """The verdict on every contender, for one beam."""

    @lru_cache
    def exact(model: tuple[tuple[str, Any], ...]) -> Answer:
        return attempt(beam, modes=MORE_MODES, tolerance=EXACT, **dict(model))

    def of(model: dict[str, Any]) -> Answer:
        return exact(tuple(model.items()))

    return [cell(beam, contender, of) for contender in CONTENDERS]


def cell(beam: Beam, contender: Contender, exact: Callable[[dict[str, Any]], Answer]) -> Cell:
    """The verdict on one; `exact` answers for a model."""
    found = attempt(beam, modes=MODES, **contender.options)
    own, reference = exact(contender.model), exact(GREEN)
    verdict = judged(found, own, reference)
    if contender.more and verdict.kind in (INACCURATE, NOT_CONVERGED):
        again = attempt(beam, modes=MODES, **contender.options | contender.more)
        if not helped(verdict, judged(again, own, reference)):
            return verdict._replace(kind=ROUNDED)
    return verdict


def helped(before: Cell, after: Cell) -> bool:
    """Whether more terms brought a method nearer to its own model."""
    if after.kind == NOT_CONVERGED:
        return False
    if before.kind == NOT_CONVERGED:
        return after.kind != INACCURATE
    return not after.discretisation > HELPED * before.discretisation


def judged(found: Answer, own: Answer, reference: Answer) -> Cell:
    """The verdict on an answer, with the exact ones of its own model and of the reference."""
    if isinstance(found, NoEquilibrium):
        true = isinstance(own, NoEquilibrium)
        kind = NO_EQUILIBRIUM if true else NOT_CONVERGED
        return Cell(kind, says=str(found), limit=found.limit if true else np.nan)
    if not isinstance(found, Solution):
        return Cell(NOT_CONVERGED, says=str(found))
    errors = distance(found, own, found), distance(own, reference, found)
    if found.equilibrium.status == "unstable" and isinstance(reference, Solution):
        unstable = reference.equilibrium.status == "unstable"
        return Cell(TRULY_UNSTABLE if unstable else FALSELY_UNSTABLE, *errors)
    return Cell(spoilt_by(*errors), *errors)


def spoilt_by(discretisation: float, model: float) -> str:
    """What takes a method further beyond its bound, if anything does."""
    inaccurate, unfaithful = discretisation / ACCURATE, model / FAITHFUL
    if max(inaccurate, unfaithful) <= 1:
        return RIGHT
    return INACCURATE if inaccurate > unfaithful else OTHER_MODEL


def distance(one: Answer, other: Answer, listed: Solution) -> float:
    """The largest relative difference in frequency (or rate of growth) of the modes listed, each
    with its namesake; infinite where one has an answer and the other none, or one is unstable."""
    if not (isinstance(one, Solution) and isinstance(other, Solution)):
        return np.inf
    ours, theirs = (
        dict(zip(answer.labels, answer.omega_squared, strict=True)) for answer in (one, other)
    )
    return max(apart(ours.get(label), theirs.get(label)) for label in listed.labels)


def apart(one: float | None, other: float | None) -> float:
    """The relative difference of two frequencies, given as omega^2."""
    if one is None or other is None or (one < 0) != (other < 0) or other == 0:
        return np.inf
    return float(abs(np.sqrt(one / other) - 1))
