"""The paper's figures, computed: what each one shows, as numbers."""

import csv
import io
from collections.abc import Iterator
from itertools import product
from typing import NamedTuple

import numpy as np

from beamviz.frequency_loci import Event, Loci, loci
from beamviz.paper.data import LociFigure, Meeting, ShapeFigure
from beamviz.solver import solve
from beamviz.solver.solution import Solution

POINTS = 201
EQ_16, OTHER = "spatial", "material"  # the curvature measures


class Met(NamedTuple):
    """A crossing by curvature measure, and what the paper prints of it."""

    events: dict[str, Event]
    printed: Meeting | None


class Curve(NamedTuple):
    """One mode shape of unit modal mass: its larger component, rising from the clamp."""

    solution: Solution
    mode: int  # counted from 1
    x: np.ndarray
    y: np.ndarray

    @property
    def family(self) -> str:
        """bending or stretching."""
        return self.solution.families[self.mode - 1]

    @property
    def label(self) -> str:
        """B1, S1 ..."""
        return self.solution.labels[self.mode - 1]

    @property
    def nodes(self) -> np.ndarray:
        """Where it stands still."""
        return self.solution.nodes[self.mode - 1]


def charts(figure: LociFigure) -> dict[str, Loci]:
    """The loci of a figure by curvature measure; at rest the measures are the same."""
    values = np.linspace(0, figure.stop, POINTS)
    at_rest = figure.over != "gamma" and figure.beam.gamma == 0
    return {
        name: loci(figure.beam, figure.over, values, figure.modes, curvature=name)
        for name in ((EQ_16,) if at_rest else (EQ_16, OTHER))
    }


def meetings(figure: LociFigure, found: dict[str, Loci]) -> list[Met]:
    """Every crossing of the charts."""
    printed = {_nearest(found[EQ_16], _pair(row), float(row.at)): row for row in figure.meetings}
    return [
        Met(
            {name: _nearest(chart, set(event.branches), event.at) for name, chart in found.items()},
            printed.get(event),
        )
        for event in found[EQ_16].events
    ]


def _pair(meeting: Meeting) -> set[str]:
    """The branches of a printed meeting: locus k is bending mode k until S1 crosses it."""
    return {f"B{meeting.loci[0]}", "S1"}


def _nearest(chart: Loci, pair: set[str], at: float) -> Event:
    """The event of two branches nearest to a value."""
    events = (event for event in chart.events if set(event.branches) == pair)
    return min(events, key=lambda event: abs(event.at - at))


def curves(figure: ShapeFigure) -> list[Curve]:
    """The mode shapes of a figure."""
    solutions = [
        solve(figure.beam.replace(alpha=alpha), max(figure.modes), tolerance=1e-9)
        for alpha in figure.alphas
    ]
    return [_curve(solution, mode) for solution, mode in product(solutions, figure.modes)]


def _curve(solution: Solution, mode: int) -> Curve:
    x = np.linspace(0, 1, POINTS)
    shape = solution.shape(mode - 1, x)[:, int(solution.families[mode - 1] == "bending")]
    return Curve(solution, mode, x, np.sign(shape[1]) * shape + 0.0)


def loci_csv(found: dict[str, Loci]) -> str:
    """One line for each value and curvature measure, one column for each branch."""
    first = found[EQ_16]
    labels = [branch.label for branch in first.branches]
    return _csv([first.over, "curvature", *labels], _loci_lines(found))


def _loci_lines(found: dict[str, Loci]) -> Iterator[list[str]]:
    for name, chart in found.items():
        for value, *row in zip(
            chart.values, *(branch.frequency for branch in chart.branches), strict=True
        ):
            yield [f"{value:.10g}", name, *(f"{omega:.10g}" for omega in row)]


def shapes_csv(found: list[Curve]) -> str:
    """One line for each point, one column for each curve."""
    heading = [f"mode{c.mode}_{c.label}_alpha{c.solution.beam.alpha:g}" for c in found]
    table = np.column_stack([found[0].x, *(curve.y for curve in found)])
    return _csv(["x", *heading], ([f"{value:.10g}" for value in row] for row in table))


def _csv(heading: list[str], rows: Iterator[list[str]]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(heading)
    writer.writerows(rows)
    return text.getvalue()
