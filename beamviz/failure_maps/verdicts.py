"""Verdicts on methods: does a method solve one beam correctly, and if not, why.

Two errors are told apart. Discretisation error: the distance of a method from the exact
frequencies of its own model. Model error: the distance of these from the reference, the paper's
model (green strain, spatial curvature) as `auto` solves it.
"""

from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from beamviz.beam import Beam
from beamviz.errors import BeamvizError, NoEquilibrium, NotConverged
from beamviz.solver import solve
from beamviz.solver.solution import Solution

MODES, EXACT_MODES = 5, 10  # compared at the most; of the exact solution, where they may be higher
EXACT = 1e-8  # relative tolerance of a model's own frequencies
ACCURATE = 1e-3  # largest relative discretisation error of a correct method
FAITHFUL = 1e-2  # largest relative model error of a correct method
HELPFUL = 0.5  # more terms help if they leave less than this share of an error

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
    TRULY_UNSTABLE: "truly unstable, and it says so",
    NO_EQUILIBRIUM: "no equilibrium in its model, and it says so",
    NOT_CONVERGED: "did not converge",
    ROUNDING: "rounding error: more terms do not help",
}


class Method(NamedTuple):
    """A method with its options of `solve`, the options that give the exact frequencies of its
    model, and options with more terms where it has terms."""

    name: str
    options: dict[str, Any]
    model: dict[str, Any]
    more_terms: dict[str, Any] | None = None

    @property
    def resolution(self) -> str:
        """Its number of elements or terms; empty for a method that chooses its own."""
        given = [(name, self.options.get(name)) for name in ("elements", "terms")]
        return "".join(f"{number} {name}" for name, number in given if number)


GREEN: dict[str, Any] = {"strain": "green"}
RIGID: dict[str, Any] = {"method": "foac"}
METHODS = (
    Method("auto", {}, GREEN),
    Method("auto, biot strain", {"strain": "biot"}, {"strain": "biot"}),
    Method("auto, hencky strain", {"strain": "hencky"}, {"strain": "hencky"}),
    Method("ancf", {"method": "ancf", "elements": 20}, GREEN),
    Method("ancf-planar", {"method": "ancf-planar", "elements": 20}, GREEN),
    Method("chebyshev", {"method": "chebyshev", "terms": 32}, GREEN, {"terms": 64}),
    Method("linear", {"method": "linear", "elements": 20}, RIGID),
    Method("foac", {"method": "foac"}, RIGID),
    Method("zoac", {"method": "zoac"}, {"method": "zoac"}),
    Method("assumed-modes", {"method": "assumed-modes", "terms": 10}, RIGID, {"terms": 15}),
    Method("power-series", {"method": "power-series", "terms": 80}, RIGID, {"terms": 160}),
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

    @lru_cache
    def exact_answer(model: tuple[tuple[str, Any], ...]) -> Answer:
        return answer(beam, modes=EXACT_MODES, tolerance=EXACT, **dict(model))

    def exact(model: dict[str, Any]) -> Answer:
        return exact_answer(tuple(model.items()))

    return [verdict(beam, method, exact) for method in METHODS]


def verdict(beam: Beam, method: Method, exact: Callable[[dict[str, Any]], Answer]) -> Verdict:
    """The verdict on one method; `exact` gives the exact answer of a model."""
    own, reference = exact(method.model), exact(GREEN)
    found = judge(answer(beam, modes=MODES, **method.options), own, reference)
    if method.more_terms and found.kind in (INACCURATE, NOT_CONVERGED):
        more = answer(beam, modes=MODES, **method.options | method.more_terms)
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
    ours, theirs = (
        dict(zip(found.labels, found.omega_squared, strict=True)) for found in (one, other)
    )
    return max(_difference(ours.get(label), theirs.get(label)) for label in labels)


def _difference(one: float | None, other: float | None) -> float:
    """The relative difference of two frequencies, given as omega^2."""
    if one is None or other is None or (one < 0) != (other < 0) or other == 0:
        return np.inf
    return float(abs(np.sqrt(one / other) - 1))
