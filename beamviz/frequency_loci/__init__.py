"""loci(beam, over=..., values=...): frequencies along one of the five numbers, mode by mode."""

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from beamviz.beam import Beam, Units, check_int
from beamviz.errors import BeamvizError
from beamviz.frequency_loci.crossings import Event, chart
from beamviz.frequency_loci.limits import Limit, limits
from beamviz.frequency_loci.sweep import Sweep, checked_values
from beamviz.frequency_loci.tracking import Track
from beamviz.solver import MAX_MODES, Problem
from beamviz.solver.solution import Solution


@dataclass(frozen=True)
class Branch:
    """One mode along a sweep: it keeps its label while its family may change.

    All its arrays have a row for each value; where the branch is not among the modes asked for,
    mode_index is -1, family None and the numbers are nan.
    """

    label: str
    mode_index: np.ndarray  # (values,) which mode of each solution it is, from 0
    solutions: tuple[Solution | None, ...]  # per value, None where there is no equilibrium

    @cached_property
    def frequency(self) -> np.ndarray:
        """Frequencies (values,); nan also where unstable."""
        return np.sqrt(np.where(self._squares >= 0, self._squares, np.nan))

    @cached_property
    def growth_rate(self) -> np.ndarray:
        """Growth rates (values,); 0 where stable."""
        return np.sqrt(np.maximum(-self._squares, 0.0))

    @cached_property
    def _squares(self) -> np.ndarray:
        return self._each(lambda solution: solution.omega_squared)

    @cached_property
    def error(self) -> np.ndarray:
        """Estimated absolute errors (values,) of frequency or growth rate."""
        return self._each(lambda solution: solution.errors)

    @cached_property
    def bending_fraction(self) -> np.ndarray:
        """Share (values,) of the kinetic energy across the beam."""
        return self._each(lambda solution: solution.bending_energy_fraction)

    @cached_property
    def family(self) -> tuple[str | None, ...]:
        """Family per value."""
        return tuple(
            None if solution is None or place < 0 else solution.families[place]
            for solution, place in zip(self.solutions, self.mode_index, strict=True)
        )

    def _each(self, numbers: Callable[[Solution], np.ndarray]) -> np.ndarray:
        """A number of this branch for each value."""
        return np.array(
            [
                math.nan if solution is None or place < 0 else numbers(solution)[place]
                for solution, place in zip(self.solutions, self.mode_index, strict=True)
            ]
        )


@dataclass(frozen=True)
class Loci:
    """Frequencies along one number, mode by mode, and where they meet."""

    beam: Beam
    problem: Problem
    options: dict[str, Any]  # those of solve() that were given
    over: str
    values: np.ndarray
    branches: tuple[Branch, ...]
    events: tuple[Event[str], ...]
    limits: tuple[Limit, ...]
    complete: bool  # whether all meetings were looked for; the search has an end
    confidence: np.ndarray  # (values - 1,) of each step: least MAC, nan where there is a gap
    solves: int  # values solved: those asked for, and between them for meetings and limits
    seconds: float

    @property
    def warning(self) -> str:
        """Warning where the search for crossings and veerings was incomplete; else empty."""
        if self.complete:
            return ""
        return (
            f"The search for crossings and veerings stopped after {self.solves} solves: there may"
            " be more, and those listed are less accurate. Use a narrower range or fewer modes."
        )

    @property
    def units(self) -> Units | None:
        """The units of a beam given in SI; none over mu, on which T* depends."""
        return None if self.over == "mu" else self.beam.units


def loci(beam: Beam, over: str, values: ArrayLike, modes: int = 5, **options: Any) -> Loci:
    """The lowest `modes` frequencies of a beam along ascending `values` of one of its numbers.

    over: "alpha", "beta", "gamma", "delta" or "mu"; the beam's own value of it is not used.
    options: as for solve(). Values without equilibrium, or without a stable one, leave a gap
    that `limits` names. Raises InvalidInput, and NoEquilibrium or NotConverged where that is so
    for every value.
    """
    start = time.perf_counter()
    values = checked_values(over, values)
    sweep = Sweep(beam, over, check_int("modes", modes, 1, MAX_MODES), options)
    answers = sweep.solve(values)
    solutions = tuple(answer if isinstance(answer, Solution) else None for answer in answers)
    problem = next((solution.problem for solution in solutions if solution), None)
    if problem is None:
        raise next(answer for answer in answers if isinstance(answer, BeamvizError))
    parts = [_part(sweep, run, values[run]) for run in _runs(solutions)]
    names, places = _named(parts, sweep, len(values))
    return Loci(
        beam=beam,
        problem=problem,
        options=options,
        over=over,
        values=values,
        branches=tuple(Branch(label, row, solutions) for label, row in places.items()),
        events=tuple(
            _labelled(event, *(names[k, number] for number in event.branches))
            for k, part in enumerate(parts)
            for event in part.events
        ),
        complete=not sweep.spent,
        limits=tuple(limits(sweep, values)),
        confidence=_confidence(parts, len(values)),
        solves=sweep.solves,
        seconds=time.perf_counter() - start,
    )


def close_up(found: Loci, event: Event[str], widths: float = 4.0, points: int = 41) -> Loci:
    """The loci around a veering, within some of its widths and the values it was found in."""
    low = max(event.at - widths * event.width, found.values[0])
    high = min(event.at + widths * event.width, found.values[-1])
    modes = 1 + max(int(branch.mode_index.max()) for branch in found.branches)
    values = np.linspace(low, high, points)
    return loci(found.beam, found.over, values, modes, **found.options)


def _runs(solutions: Sequence[Solution | None]) -> list[slice]:
    """The stretches of values that have solutions."""
    exists = np.array([False, *(solution is not None for solution in solutions), False])
    edges = np.flatnonzero(exists[1:] != exists[:-1])
    return [slice(start, stop) for start, stop in edges.reshape(-1, 2).tolist()]


class Part(NamedTuple):
    """One stretch of values with solutions, tracked."""

    run: slice  # of the values
    rows: np.ndarray  # their places among the points of the track
    track: Track
    events: list[Event[int]]


def _part(sweep: Sweep, run: slice, values: np.ndarray) -> Part:
    """Track the modes over values that all have solutions."""
    track, events = chart(sweep.solved_points(values), sweep.modes, sweep.points)
    return Part(run, np.searchsorted(track.points.at, values), track, events)


def _named(
    parts: list[Part], sweep: Sweep, count: int
) -> tuple[dict[tuple[int, int], str], dict[str, np.ndarray]]:
    """A label for each branch (part, number), and for each label its places (count,).

    A branch has the label of its mode where it first appears. It goes on where a later branch
    appears under the same label, across a gap say; a second one beside it gets a prime.
    """
    names: dict[tuple[int, int], str] = {}
    places: dict[str, np.ndarray] = {}
    for k, part in enumerate(parts):
        branch = part.track.branch[:, : sweep.modes]
        numbers, first = np.unique(branch, return_index=True)
        for number, at in sorted(
            zip(numbers.tolist(), first.tolist(), strict=True), key=lambda x: x[1]
        ):
            value = part.track.points.at[at // sweep.modes]
            label = sweep.labels(float(value))[at % sweep.modes]
            here = branch[part.rows] == number
            row = np.full(count, -1)
            row[part.run] = np.where(here.any(axis=1), here.argmax(axis=1), -1)
            while label in places and (np.minimum(places[label], row) >= 0).any():
                label += "'"
            names[k, number] = label
            places[label] = np.maximum(places.get(label, row), row)
    return names, places


def _labelled(event: Event[int], a: str, b: str) -> Event[str]:
    """An event with the labels of its branches."""
    return Event(**{**vars(event), "branches": (a, b)})


def _confidence(parts: list[Part], count: int) -> np.ndarray:
    """The least MAC between neighbouring values (count - 1,), nan across a gap."""
    confidence = np.full(count - 1, np.nan)
    for part in parts:
        if len(part.rows) > 1:
            least = np.minimum.reduceat(part.track.confidence, part.rows[:-1])
            confidence[part.run.start : part.run.stop - 1] = least
    return confidence
