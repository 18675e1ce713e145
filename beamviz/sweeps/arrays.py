"""The arrays of a sweep: numbers and codes of every beam, as `solve_many` answers.

A chunk is solved in batches along its lines. Beams with their mass at one place share their meshes,
so that they are solved together; bent states are followed from each beam to the next.
"""

from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from beamviz.errors import NoEquilibrium
from beamviz.solver import solve_many
from beamviz.solver.solution import PURE, Equilibrium, Solution
from beamviz.sweeps.plan import Plan

STATUSES = (
    "not computed",
    "solved",  # and stable
    "divergence",  # a static instability
    "no equilibrium",
    "not converged",
    "flutter",  # a vibration grows
    "buckled chordwise",  # a flapwise beam, itself stable, that is unstable in the other plane
)
NOT_COMPUTED, SOLVED, DIVERGENCE, NO_EQUILIBRIUM, NOT_CONVERGED, FLUTTER, BUCKLED_CHORDWISE = range(
    len(STATUSES)
)
FAMILIES = ("bending", "stretching", "mixed")
BATCH = 1024  # beams solved at a time, which bounds the memory of their solutions
FEW = 16  # beams with their mass at one place, below which a batch has several places

Arrays = dict[str, np.ndarray]


class Array(NamedTuple):
    """An array of a sweep."""

    dtype: str
    extra: tuple[str, ...]  # its dimensions beyond the axes
    empty: float  # the value where there is no number
    label: str
    units: str | None = None
    codes: tuple[str, ...] = ()  # the meanings of 0, 1, ...

    @property
    def attributes(self) -> dict[str, Any]:
        """Its attributes by the CF conventions."""
        attributes: dict[str, Any] = {"long_name": self.label}
        if self.units:
            attributes["units"] = self.units
        if self.codes:
            attributes["flag_values"] = list(range(len(self.codes)))
            attributes["flag_meanings"] = " ".join(code.replace(" ", "_") for code in self.codes)
        return attributes


ERROR = "estimated absolute error of frequency or growth rate"
ARRAYS = {
    "frequency": Array("f8", ("mode",), np.nan, "frequency", "1/T*"),
    "error": Array("f4", ("mode",), np.nan, ERROR, "1/T*"),
    "growth_rate": Array("f8", ("mode",), np.nan, "growth rate", "1/T*"),
    "family": Array("i1", ("mode",), -1, "family", codes=FAMILIES),
    "limit": Array("f8", (), np.nan, "largest gamma with an equilibrium"),
    "status": Array("i1", (), NOT_COMPUTED, "status", codes=STATUSES),
}


def empty_arrays(plan: Plan) -> Arrays:
    """The arrays of a sweep, without results."""
    return {
        name: np.full(
            plan.shape + (plan.problem.modes,) * len(array.extra), array.empty, array.dtype
        )
        for name, array in ARRAYS.items()
    }


def solve_in_memory(plan: Plan, report: Callable[[float], None]) -> Arrays:
    """The arrays of a small sweep. report: called with the share that is done, before each chunk;
    what it raises ends the sweep."""
    arrays = empty_arrays(plan)
    for k, chunk in enumerate(plan.chunks):
        report(k / len(plan.chunks))
        for name, part in solve_chunk(plan.part(chunk)).items():
            arrays[name][plan.region(chunk)] = part
    return arrays


def solve_chunk(plan: Plan) -> Arrays:
    """The arrays of a sweep that is solved as one chunk."""
    arrays = empty_arrays(plan)
    rows = {
        name: array.reshape(plan.size, *array.shape[len(plan.shape) :])
        for name, array in arrays.items()
    }
    beams = plan.beams()

    def solve(places: np.ndarray) -> None:
        batch = [beams[k] for k in places.tolist()]
        record(rows, places, solve_many(batch, **plan.problem.options))

    if plan.is_stacked and "gamma" in plan.axes:
        axis = list(plan.axes).index("gamma")
        places = np.arange(plan.size).reshape(plan.shape)
        solve(places.take(-1, axis).ravel())
        fill_beyond_limits(arrays, plan.axes["gamma"], axis)
    for places in batches(plan):
        left = places[rows["status"][places] == NOT_COMPUTED]
        for start in range(0, len(left), BATCH):
            solve(left[start : start + BATCH])
    return arrays


def fill_beyond_limits(arrays: Arrays, gamma: np.ndarray, axis: int) -> None:
    """Enter all beams beyond a limit of equilibrium that is known from the fastest beam, so that
    they need no solve. Without this, a sweep of whose beams a quarter have no equilibrium takes 15
    times as long. axis: of gamma."""
    limit = arrays["limit"].take([-1], axis)
    shape = [1] * limit.ndim
    shape[axis] = len(gamma)
    beyond = gamma.reshape(shape) > limit
    arrays["limit"][...] = np.where(beyond, limit, arrays["limit"])
    arrays["status"][beyond] = NO_EQUILIBRIUM


def batches(plan: Plan) -> Iterator[np.ndarray]:
    """The places (n,) of the beams of a chunk, in a flattened array, that are solved together."""
    places = np.arange(plan.size).reshape(plan.shape)
    if not plan.is_stacked:
        lines = np.moveaxis(places, plan.longest, -1)
        return iter(lines.reshape(-1, lines.shape[-1]))
    if "beta" in plan.axes:
        by_beta = np.moveaxis(places, list(plan.axes).index("beta"), 0)
        if plan.size >= FEW * len(by_beta):
            return iter(by_beta.reshape(len(by_beta), -1))
    return iter(places.reshape(1, -1))


def record(rows: Arrays, places: np.ndarray, outcomes: Sequence[Any]) -> None:
    """Enter the outcomes (n,) of `solve_many`. rows: arrays (beams, ...); places: (n,) of these
    beams in them."""
    solved = [isinstance(outcome, Solution) for outcome in outcomes]
    solutions = [outcome for outcome in outcomes if isinstance(outcome, Solution)]
    if solutions:
        where = places[solved]
        rows["frequency"][where] = [solution.frequencies for solution in solutions]
        rows["growth_rate"][where] = [solution.growth_rates for solution in solutions]
        rows["error"][where] = [solution.errors for solution in solutions]
        rows["family"][where] = family_codes(
            np.array([solution.bending_energy_fraction for solution in solutions])
        )
        rows["status"][where] = [status_code(solution.equilibrium) for solution in solutions]
    for place, outcome in zip(places.tolist(), outcomes, strict=True):
        if isinstance(outcome, NoEquilibrium):
            rows["status"][place], rows["limit"][place] = NO_EQUILIBRIUM, outcome.limit
        elif not isinstance(outcome, Solution):
            rows["status"][place] = NOT_CONVERGED


def family_codes(bending_energy_fraction: np.ndarray) -> np.ndarray:
    """Codes of the families of modes, by the share of their kinetic energy across the beam."""
    return np.select(
        [bending_energy_fraction >= PURE, bending_energy_fraction <= 1 - PURE],
        [FAMILIES.index("bending"), FAMILIES.index("stretching")],
        FAMILIES.index("mixed"),
    )


def status_code(equilibrium: Equilibrium) -> int:
    """The code of the status of a solved beam."""
    if equilibrium.stable:
        return BUCKLED_CHORDWISE if equilibrium.buckled_chordwise else SOLVED
    return DIVERGENCE if equilibrium.status == "unstable" else FLUTTER
