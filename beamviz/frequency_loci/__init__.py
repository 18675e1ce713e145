"""Loci: frequencies along one parameter of a beam, mode by mode."""

import time
from collections.abc import Collection
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from beamviz.beam import Beam
from beamviz.checks import check_int
from beamviz.errors import InvalidInput, NotConverged
from beamviz.frequency_loci.branches import Branch, LabelledTrack, branches_at
from beamviz.frequency_loci.events import (
    EVENT_COLUMNS,
    EVENT_KINDS,
    checked_kinds,
    locate_events,
    record_of,
)
from beamviz.frequency_loci.events.coalescence import COALESCENCE
from beamviz.frequency_loci.events.record import Event, Tracked
from beamviz.frequency_loci.events.resonance import RESONANCE
from beamviz.frequency_loci.limits import (
    ExistenceSearch,
    Limit,
    Range,
    limits_of,
    stability_changes,
)
from beamviz.frequency_loci.margins import Margin, margins_at
from beamviz.frequency_loci.path import ParameterPath, check_values, first_error
from beamviz.frequency_loci.tracking import grid_values, track_loci, values_towards
from beamviz.solver import parse_keywords
from beamviz.solver.problem import Problem
from beamviz.units import Units, parse_over

MAX_POINTS = 10_000
MAX_HTML_ROWS = 20
MAX_PER_REV = 100


@dataclass(frozen=True, eq=False, repr=False)
class Loci:
    """Frequencies along one parameter, mode by mode, with their events."""

    beam: Beam
    problem: Problem
    over: str
    values: NDArray  # (values,)
    branches: tuple[Branch, ...]
    events: tuple[Event, ...]  # by ascending value
    kinds: tuple[str, ...]  # of the events that were looked for
    limits: tuple[Limit, ...]
    solves: int  # number of values solved
    seconds: float
    tracked: Tracked  # the loci on the chart's own grid, in which the events were located
    margins: tuple[Margin, ...] = ()  # to per-rev lines at the speed of the beam, by frequency

    def __getitem__(self, label: str) -> Branch:
        """The branch with this label; KeyError lists the labels."""
        named = {branch.label: branch for branch in self.branches}
        if label not in named:
            raise KeyError(f"no branch {label!r}; branches: {', '.join(named)}")
        return named[label]

    def __repr__(self) -> str:
        kinds = [event.kind for event in self.events]
        counts = [f"{kind}: {kinds.count(kind)}" for kind in EVENT_KINDS if kind in kinds]
        return (
            f"Loci(over {self.over} = {self.values[0]:g} .. {self.values[-1]:g},"
            f" {len(self.values)} values,"
            f" branches {' '.join(branch.label for branch in self.branches)},"
            f" events: {', '.join(counts) or 'none'}; limits: {len(self.limits)})"
        )

    def to_xarray(self) -> Any:
        """An xarray.Dataset: frequency, error, growth_rate, bending_fraction and family by value
        and branch; the model, the fixed numbers, units and version as attributes.

        Raises Unavailable where xarray is not installed.
        """
        from beamviz.datasets import attributes, loci_dataset

        described = attributes(self.beam, self.problem.model, self.units)
        return loci_dataset(self.over, self.values, self.branches, described, self.units)

    def events_dataframe(self) -> Any:
        """The events as rows of a pandas.DataFrame."""
        from beamviz.tables import dataframe

        return dataframe(EVENT_COLUMNS, [record_of(event) for event in self.events])

    def limits_dataframe(self) -> Any:
        """The limits as rows of a pandas.DataFrame."""
        from beamviz.tables import dataframe

        return dataframe(Limit._fields, self.limits)

    def plot(self, ax: Any = None) -> Any:
        """Draw the chart onto matplotlib axes (the current ones by default), and return these."""
        from beamviz.plotting.loci import plot_loci

        return plot_loci(self, ax)

    def _repr_html_(self) -> str:
        from beamviz.tables import event_columns, html_table

        events = self.events[:MAX_HTML_ROWS]
        return html_table(repr(self), event_columns(self.over, self.units, events))

    @property
    def path(self) -> ParameterPath:
        """The path of these loci, without the outcomes: each use solves anew."""
        return ParameterPath(self.beam, self.over, self.problem)

    @property
    def units(self) -> Units | None:
        """The units of a beam given in SI; none over mu, on which T* depends."""
        return None if self.over == "mu" else self.beam.units


def loci(
    beam: Beam,
    over: str,
    values: ArrayLike,
    modes: int = 5,
    per_rev: int = 0,
    kinds: Collection[str] | None = None,
    **options: Any,
) -> Loci:
    """The lowest `modes` frequencies of a beam along ascending values of one of its parameters.

    over: "alpha", "beta", "gamma", "delta", "mu", "spin_up", "flap", "pitch" or "twist", whose
    value in `beam` is not used. For a beam in SI also one of them in a unit, in which `values` are
    given: "rpm", "rad/s", "kg", "beta:mm", "delta:m" ... (those of the result are dimensionless).
    values: 2 to 10000 ascending
    numbers; events between the first and the last do not depend on how many there are. modes: 1 to
    20. per_rev: over gamma, multiples of the speed, 1 .. per_rev, whose resonances are among the
    events; a mode that vibrates with a multiple of the speed all along a range, as a hinged beam
    does flapwise, has one from `at` to `until`; the speed of `beam` is then the operating speed, at
    which `margins` has the distances of the modes to these lines. kinds: names of the kinds of
    events to look for, by default all but those on request (see EVENT_KINDS). options: as for
    solve(). Ranges without a stable equilibrium are reported in `limits`.
    Raises InvalidInput; and NoEquilibrium or NotConverged where no value has a solution.
    """
    began = time.perf_counter()
    over, factor = parse_over(over, beam.units)
    values = check_values("over =", over, values, 2, MAX_POINTS, factor)
    per_rev = check_int("per_rev", per_rev, 0, MAX_PER_REV)
    sought = checked_kinds(kinds, per_rev)
    path = ParameterPath(beam, over, parse_keywords(**options, modes=modes))
    low, high = values[[0, -1]].tolist()
    grid = grid_values(low, high)
    path.solve(np.union1d(grid, values))
    if any(isinstance(path.outcomes[value], NotConverged) for value in grid.tolist()):
        grid = np.union1d(grid, values)  # convergence may vary from value to value
    search = ExistenceSearch(path, grid)
    parts = tuple(_part(path, solved, grid) for solved in search.ranges)
    branches = branches_at(path, values, parts)
    if not branches:
        raise first_error(path.solve(values))
    tracked = Tracked(path, grid, parts, per_rev)
    events, unlocated = locate_events(tracked, sought)
    coalescences = [event.at for event in events if event.kind == COALESCENCE.name]
    limits = [*limits_of(search.changes, high, over), *unlocated]
    for part in parts:
        limits += limits_of(stability_changes(part.track, coalescences), part.track.high, over)
        part.track.release_vectors()
    margins = margins_at(path, parts, per_rev, events)
    solves = len(path.outcomes)
    path.outcomes.clear()  # the branches keep those at `values`
    return Loci(
        beam=beam,
        problem=path.problem,
        over=over,
        values=values,
        branches=branches,
        events=events,
        kinds=tuple(kind.name for kind in sought),
        limits=tuple(sorted(limits, key=lambda limit: limit.start)),
        solves=solves,
        seconds=time.perf_counter() - began,
        tracked=tracked,
        margins=margins,
    )


def _part(path: ParameterPath, solved: Range, grid: NDArray) -> LabelledTrack:
    """The loci on the grid in a range with solutions, with more values towards limits of
    equilibrium."""
    values = grid[(grid >= solved.low) & (grid <= solved.high)]
    towards = [values]
    if solved.ends_high:
        towards.append(values_towards(solved.high, values[-1]))
    if solved.ends_low:
        towards.append(values_towards(solved.low, values[0]))
    return LabelledTrack(
        track_loci(path, solved.low, solved.high, np.unique(np.concatenate(towards)))
    )


def resonances(tracked_loci: Loci, count: int = 1) -> list[Event]:
    """The intersections of loci over gamma with the per-rev lines omega = k gamma, k = 1 .. count,
    as events of the kind "resonance".

    Raises InvalidInput for loci over another parameter.
    """
    count = check_int("count", count, 0, MAX_PER_REV)
    if count and tracked_loci.over != "gamma":
        raise InvalidInput(f"per-rev lines need loci over gamma, not over {tracked_loci.over}")
    tracked = tracked_loci.tracked._replace(per_rev=count)
    located = RESONANCE.locate(tracked)
    events = [event for event in located if isinstance(event, Event)]
    return sorted(events, key=lambda event: event.at)


def at_values(loci: Loci, values: NDArray) -> Loci:
    """Loci at other values in their range, solved for, with the same branches."""
    branches = branches_at(loci.path, values, loci.tracked.parts)
    events = tuple(event for event in loci.events if values[0] <= event.at <= values[-1])
    return replace(loci, values=values, branches=branches, events=events)
