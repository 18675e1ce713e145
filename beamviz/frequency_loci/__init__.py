"""loci(beam, over=..., values=...): frequencies along one of the five parameters, mode by mode."""

import math
import time
from dataclasses import dataclass, replace
from functools import cached_property
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from beamviz.beam import Beam, Units, check_int
from beamviz.errors import BeamvizError, InvalidInput
from beamviz.frequency_loci.crossings import Event, track_and_locate
from beamviz.frequency_loci.limits import Limit, locate_limits
from beamviz.frequency_loci.sweep import Sweep, check_values, mode_points
from beamviz.frequency_loci.tracking import Track
from beamviz.solver import MAX_MODES, Problem
from beamviz.solver.solution import Solution


@dataclass(frozen=True, eq=False, repr=False)
class Branch:
    """One mode along a sweep: it keeps its label while its family may change.

    All arrays have one entry for each value and are read-only. Where the branch is not among the
    requested modes mode_index is -1, family None and the numbers are nan.
    """

    label: str
    mode_index: np.ndarray  # (values,) which mode of each solution it is, from 0
    solutions: tuple[Solution | None, ...]  # per value, None where there is none

    @cached_property
    def frequency(self) -> np.ndarray:
        """Frequencies (values,) in units of 1/T*; nan also where unstable."""
        return _read_only(np.sqrt(np.where(self.omega_squared >= 0, self.omega_squared, np.nan)))

    @cached_property
    def growth_rate(self) -> np.ndarray:
        """Growth rates (values,) in units of 1/T*; 0 where stable."""
        return _read_only(np.sqrt(np.maximum(-self.omega_squared, 0.0)))

    @cached_property
    def omega_squared(self) -> np.ndarray:
        """Squared frequencies (values,); negative where unstable."""
        return self._collect("omega_squared")

    @cached_property
    def error(self) -> np.ndarray:
        """Estimated absolute errors (values,) of frequency or growth rate."""
        return self._collect("errors")

    @cached_property
    def bending_fraction(self) -> np.ndarray:
        """Share (values,) of the kinetic energy across the beam."""
        return self._collect("bending_energy_fraction")

    @cached_property
    def family(self) -> tuple[str | None, ...]:
        """Family per value: "bending", "stretching" or "mixed"."""
        return tuple(
            None if solution is None or k < 0 else solution.families[k]
            for solution, k in zip(self.solutions, self.mode_index, strict=True)
        )

    def __repr__(self) -> str:
        present = int((self.mode_index >= 0).sum())
        return f"Branch({self.label!r}, at {present} of {len(self.solutions)} values)"

    def _collect(self, quantity: str) -> np.ndarray:
        """An array of the solutions, of this mode at each value."""
        numbers = (
            math.nan if solution is None or k < 0 else getattr(solution, quantity)[k]
            for solution, k in zip(self.solutions, self.mode_index.tolist(), strict=True)
        )
        return _read_only(np.fromiter(numbers, float, len(self.solutions)))


@dataclass(frozen=True, eq=False, repr=False)
class Loci:
    """Frequencies along one parameter, mode by mode, with their crossings and veerings."""

    beam: Beam
    problem: Problem
    options: dict[str, Any]  # those of solve() that were given
    over: str
    values: np.ndarray  # (values,)
    branches: tuple[Branch, ...]
    events: tuple[Event, ...]  # crossings and veerings, by ascending value
    limits: tuple[Limit, ...]
    complete: bool  # False if the search for crossings stopped early
    confidence: np.ndarray  # (values - 1,) of each step: least MAC, nan across a gap
    solves: int  # number of values solved, those between the requested ones included
    seconds: float

    def __getitem__(self, label: str) -> Branch:
        """The branch with a label; KeyError lists the labels there are."""
        for branch in self.branches:
            if branch.label == label:
                return branch
        labels = ", ".join(branch.label for branch in self.branches)
        raise KeyError(f"no branch {label!r}; branches: {labels}")

    def __repr__(self) -> str:
        kinds = [event.kind for event in self.events]
        return (
            f"Loci(over {self.over} = {self.values[0]:g} .. {self.values[-1]:g},"
            f" {len(self.values)} values, branches {' '.join(one.label for one in self.branches)},"
            f" {kinds.count('crossing')} crossings, {kinds.count('veering')} veerings,"
            f" {len(self.limits)} limits)"
        )

    def to_xarray(self) -> Any:
        """An xarray.Dataset: frequency, error, growth_rate, bending_fraction and family by value
        and branch; the model, the fixed numbers, units and version as attributes.

        Raises Unavailable where xarray is not installed.
        """
        return import_module("beamviz.results").loci_dataset(self)

    def events_dataframe(self) -> Any:
        """The events as a pandas.DataFrame, a row for each."""
        return import_module("beamviz.results").records_dataframe(self.events)

    def limits_dataframe(self) -> Any:
        """The limits as a pandas.DataFrame, a row for each."""
        return import_module("beamviz.results").records_dataframe(self.limits)

    def plot(self, ax: Any = None) -> Any:
        """Draw the chart onto matplotlib axes (the current ones by default), and return these."""
        return import_module("beamviz.results").plot_loci(self, ax)

    def _repr_html_(self) -> str:
        return import_module("beamviz.results").loci_html(self)

    def labels_at(self, value: float) -> tuple[str, ...]:
        """The labels of the branches that the lowest modes at a value belong to, by frequency.

        At the values of the sweep this is the tracked assignment. Between them the order of the
        branches changes at the crossings only. Empty where neither neighbouring value has a
        solution. Raises InvalidInput for a value outside the sweep.
        """
        first, last = self.values[[0, -1]].tolist()
        if not first <= value <= last:
            raise InvalidInput(f"{self.over} = {value:g}: must lie in {first:g} .. {last:g}")
        crossings = [event for event in self.events if event.kind == "crossing"]
        found: list[tuple[float, list[str]]] = []
        after = int(np.searchsorted(self.values, value))
        for k in {after, after - int(self.values[after] > value)}:
            start = float(self.values[k])
            present = [branch for branch in self.branches if branch.mode_index[k] >= 0]
            labels = [one.label for one in sorted(present, key=lambda one: one.mode_index[k])]
            between = [e for e in crossings if min(start, value) < e.at < max(start, value)]
            for event in between if start < value else between[::-1]:
                a, b = event.branches
                labels = [{a: b, b: a}.get(label, label) for label in labels]
            # A crossing on a value of the sweep leaves the order there to rounding.
            clearance = min((abs(event.at - start) for event in crossings), default=math.inf)
            found.append((clearance if labels else -1.0, labels))
        return tuple(max(found)[1])

    @property
    def modes(self) -> int:
        """The number of modes at each value."""
        return 1 + max(int(branch.mode_index.max()) for branch in self.branches)

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
    """The lowest `modes` frequencies of a beam along ascending values of one of its parameters.

    over: "alpha", "beta", "gamma", "delta" or "mu"; the beam's own value of it is not used.
    values: 2 .. 10000 of them. modes: 1 .. 20. options: as for solve(). Values without equilibrium,
    or without a stable one, are reported in `limits`. Raises InvalidInput, and NoEquilibrium or
    NotConverged where that is the outcome at every value.
    """
    began = time.perf_counter()
    values = check_values(over, values)
    sweep = Sweep(beam, over, check_int("modes", modes, 1, MAX_MODES), options)
    outcomes = sweep.solve(values)
    solutions = tuple(outcome if isinstance(outcome, Solution) else None for outcome in outcomes)
    problem = next((solution.problem for solution in solutions if solution), None)
    if problem is None:
        raise next(outcome for outcome in outcomes if isinstance(outcome, BeamvizError))
    rows: dict[str, np.ndarray] = {}  # mode_index by label
    events: list[Event] = []
    confidence = np.full(len(values) - 1, np.nan)
    exists = np.array([False, *(solution is not None for solution in solutions), False])
    for first, end in np.flatnonzero(exists[1:] != exists[:-1]).reshape(-1, 2).tolist():
        run = slice(first, end)  # consecutive values with solutions
        points = mode_points(values[run], outcomes[run], sweep.gauss_points)
        track, located = track_and_locate(points, sweep.modes, sweep.points)
        steps = np.searchsorted(track.points.at, values[run])
        labels = _label_branches(rows, sweep, track, run, steps, len(values))
        for event in located:
            a, b = event.branches
            events.append(replace(event, branches=(labels[a], labels[b])))
        if end - first > 1:
            confidence[first : end - 1] = np.minimum.reduceat(track.confidence, steps[:-1])
    if options.get("state", "straight") != "straight":
        from beamviz.frequency_loci.buckling import state_events

        events = sorted([*events, *state_events(sweep, values, outcomes)], key=lambda one: one.at)
    return Loci(
        beam=beam,
        problem=problem,
        options=options,
        over=over,
        values=values,
        branches=tuple(Branch(label, _read_only(row), solutions) for label, row in rows.items()),
        events=tuple(events),
        limits=tuple(locate_limits(sweep, values)),
        complete=not sweep.exhausted,
        confidence=_read_only(confidence),
        solves=len(sweep.outcomes.keys() | sweep.added.keys()),
        seconds=time.perf_counter() - began,
    )


def close_up(found: Loci, event: Event, widths: float = 4.0, points: int = 41) -> Loci:
    """The loci within some widths of a veering, inside the range it was found in."""
    low = max(event.at - widths * event.width, found.values[0])
    high = min(event.at + widths * event.width, found.values[-1])
    values = np.linspace(low, high, points)
    return loci(found.beam, found.over, values, found.modes, **found.options)


def _label_branches(
    rows: dict[str, np.ndarray],
    sweep: Sweep,
    track: Track,
    run: slice,
    steps: np.ndarray,
    count: int,
) -> dict[int, str]:
    """The labels of the branches of a track by number; their mode_index (values,) is added to rows.

    A branch has the label of its mode where it first appears. It continues where a later branch
    appears under the same label, across a gap say; a second one beside it gets a prime.
    run: the values of the track among all `count`; steps: these values among its points.
    """
    labels: dict[int, str] = {}
    branch = track.branch[:, : sweep.modes]
    numbers, first = np.unique(branch, return_index=True)
    for i in first.argsort().tolist():
        number, (point, mode) = int(numbers[i]), divmod(int(first[i]), sweep.modes)
        label = sweep.labels(float(track.points.at[point]))[mode]
        here = branch[steps] == number
        row = np.full(count, -1)
        row[run] = np.where(here.any(axis=1), here.argmax(axis=1), -1)
        while label in rows and (np.minimum(rows[label], row) >= 0).any():
            label += "'"
        labels[number] = label
        rows[label] = np.maximum(rows.get(label, row), row)
    return labels


def _read_only(array: np.ndarray) -> np.ndarray:
    """The array, no longer writable."""
    array.flags.writeable = False
    return array
