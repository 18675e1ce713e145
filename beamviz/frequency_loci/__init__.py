"""Loci: frequencies along one parameter of a beam, mode by mode."""

import time
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from beamviz.beam import Beam, Units
from beamviz.errors import BeamvizError, InvalidInput
from beamviz.frequency_loci.branches import Branch, Part, branches_of, trace
from beamviz.frequency_loci.crossings import Event
from beamviz.frequency_loci.limits import Limit, LimitSearch, state_events
from beamviz.frequency_loci.sweep import Sweep, check_values
from beamviz.solver import Problem, parse_keywords

MAX_POINTS = 10_000
MAX_HTML_ROWS = 20


@dataclass(frozen=True, eq=False, repr=False)
class Loci:
    """Frequencies along one parameter, mode by mode, with their crossings and veerings."""

    beam: Beam
    problem: Problem
    over: str
    values: np.ndarray  # (values,)
    branches: tuple[Branch, ...]
    events: tuple[Event, ...]  # crossings and veerings, by ascending value
    limits: tuple[Limit, ...]
    complete: bool  # False if the search for crossings stopped early
    solves: int  # number of values solved
    seconds: float
    parts: tuple[Part, ...]  # between the limits

    def __getitem__(self, label: str) -> Branch:
        """The branch with this label; KeyError lists the labels."""
        named = {branch.label: branch for branch in self.branches}
        if label not in named:
            raise KeyError(f"no branch {label!r}; branches: {', '.join(named)}")
        return named[label]

    def __repr__(self) -> str:
        kinds = [event.kind for event in self.events]
        return (
            f"Loci(over {self.over} = {self.values[0]:g} .. {self.values[-1]:g},"
            f" {len(self.values)} values, branches {' '.join(one.label for one in self.branches)},"
            f" crossings: {kinds.count('crossing')}, veerings: {kinds.count('veering')},"
            f" limits: {len(self.limits)})"
        )

    def to_xarray(self) -> Any:
        """An xarray.Dataset: frequency, error, growth_rate, bending_fraction and family by value
        and branch; the model, the fixed numbers, units and version as attributes.

        Raises Unavailable where xarray is not installed.
        """
        from beamviz.datasets import attributes, loci_dataset

        described = attributes(self.beam.numbers, self.problem.model, self.units)
        return loci_dataset(self.over, self.values, self.branches, described)

    def events_dataframe(self) -> Any:
        """The events as rows of a pandas.DataFrame."""
        from beamviz.tables import dataframe

        return dataframe(Event, self.events)

    def limits_dataframe(self) -> Any:
        """The limits as rows of a pandas.DataFrame."""
        from beamviz.tables import dataframe

        return dataframe(Limit, self.limits)

    def plot(self, ax: Any = None) -> Any:
        """Draw the chart onto matplotlib axes (the current ones by default), and return these."""
        from beamviz.plotting.loci import plot_loci

        return plot_loci(self, ax)

    def _repr_html_(self) -> str:
        from beamviz.tables import event_columns, html_table

        return html_table(repr(self), event_columns(self.over, self.events[:MAX_HTML_ROWS]))

    def close_up(self, event: Event, widths: float = 4.0, points: int = 41) -> "Loci":
        """These loci within `widths` widths of a veering and their own range, at `points` values,
        which are solved for."""
        low = max(event.at - widths * event.width, self.values[0])
        high = min(event.at + widths * event.width, self.values[-1])
        return at_values(self, np.linspace(low, high, points))

    def labels_at(self, value: float) -> tuple[str, ...]:
        """The labels of the branches of the lowest modes at a value, by ascending frequency; empty
        where there is no solution. Raises InvalidInput for a value outside the sweep."""
        first, last = self.values[[0, -1]].tolist()
        if not first <= value <= last:
            raise InvalidInput(f"{self.over} = {value:g}: must lie in {first:g} .. {last:g}")
        sweep = Sweep(self.beam, self.over, self.problem)
        found = branches_of(sweep, np.array([float(value)]), self.parts)
        ranks = {int(branch.mode_index[0]): branch.label for branch in found}
        return tuple(ranks[k] for k in sorted(ranks) if k >= 0)

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

    over: "alpha", "beta", "gamma", "delta", "mu" or "spin_up", whose value in `beam` is not used.
    values: 2 to 10000 ascending numbers. modes: 1 to 20. options: as for solve(). Ranges without a
    stable equilibrium are reported in `limits`. Raises InvalidInput; and NoEquilibrium or
    NotConverged where no value has a solution.
    """
    began = time.perf_counter()
    values = check_values("over =", over, values, 2, MAX_POINTS)
    problem = parse_keywords(**options, modes=modes)
    sweep = Sweep(beam, over, problem)
    search = LimitSearch(sweep, float(np.ptp(values)))
    parts = trace(sweep, values, search)
    branches = branches_of(sweep, values, parts)
    if not branches:
        raise next(one for one in sweep.solve(values) if isinstance(one, BeamvizError))
    events = [event for part in parts for event in part.labelled_events]
    if problem.state != "straight":
        events += state_events(sweep, values)
    return Loci(
        beam=beam,
        problem=problem,
        over=over,
        values=values,
        branches=branches,
        events=tuple(sorted(events, key=lambda event: event.at)),
        limits=tuple(search.limits(values[0], values[-1])),
        complete=not sweep.exhausted,
        solves=len(sweep.outcomes),
        seconds=time.perf_counter() - began,
        parts=tuple(parts),
    )


def at_values(found: Loci, values: np.ndarray) -> Loci:
    """`found` at other values in its range, solved for, with the same branches."""
    sweep = Sweep(found.beam, found.over, found.problem)
    branches = branches_of(sweep, values, found.parts)
    events = tuple(one for one in found.events if values[0] <= one.at <= values[-1])
    return replace(found, values=values, branches=branches, events=events)
