"""The Campbell diagram: the request for its loci, and its data for the page (chart.js)."""

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Any, Self

import numpy as np

from beamviz.beam import Beam
from beamviz.drawing.text import Measure, frequencies, measure
from beamviz.explorer.jobs import SolverAnswer
from beamviz.explorer.state import Case
from beamviz.frequency_loci import Branch, Event, Loci, loci
from beamviz.frequency_loci.forced_response import Resonance, resonances
from beamviz.frequency_loci.identity import names_of_branches
from beamviz.frequency_loci.limits import Limit
from beamviz.frequency_loci.sweep import CHART_POINTS, chart_range

DIGITS = 6  # significant, of the numbers sent to the page
ROUND = (1.0, 1.2, 1.4, 1.6, 1.8, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0)
FAILURES = {
    "no-equilibrium": "No equilibrium",
    "unstable": "Unstable",
    "not-converged": "The calculation did not converge",
}
Data = dict[str, Any]  # as chart.js takes it
Axes = tuple[Measure, Measure]


@dataclass(frozen=True)
class ChartRequest:
    """The loci to compute. beam: its number `over` is the start of the range; options: keywords of
    `solve`; per_rev: the largest multiple of the speed for resonances."""

    beam: Beam
    over: str
    start: float
    stop: float
    options: dict[str, Any]
    per_rev: int = 0

    @classmethod
    def around(cls, case: Case, over: str, per_rev: int = 0) -> Self:
        """The chart around a case. Raises InvalidInput where a number is out of range."""
        beam = case.beam()
        start, stop = chart_range(beam, over)
        beam = beam.replace(**{over: start})
        return cls(beam, over, start, stop, case.options, per_rev if over == "gamma" else 0)

    def same_axis(self, case: Case) -> Self:
        """The chart of another case over the same range."""
        beam = case.beam().replace(**{self.over: self.start})
        return replace(self, beam=beam, options=case.options, per_rev=0)

    @property
    def measures(self) -> tuple[Measure, Measure]:
        """Display units of the axis and of the frequencies; none over mu, on which T* depends."""
        units = None if self.over == "mu" else self.beam.units
        return measure(self.over, units), frequencies(units)

    def chart(self) -> "Chart":
        """The chart. Raises the errors of `loci`."""
        values = np.linspace(self.start, self.stop, CHART_POINTS)
        found = loci(self.beam, self.over, values, **self.options)
        return Chart(self, found, tuple(resonances(found, self.per_rev)))


@dataclass(frozen=True)
class Chart:
    """Computed loci and their resonances."""

    request: ChartRequest
    loci: Loci
    resonances: tuple[Resonance, ...]

    @cached_property
    def events(self) -> dict[str, Event]:
        """Crossings and veerings by key: the labels of their branches and a count, as 'B3 S1 1'.
        Keys remain valid when the beam or the model changes."""
        return numbered((" ".join(sorted(one.branches)), one) for one in self.loci.events)

    def resonances_at(self, multiples: Sequence[int]) -> dict[str, Resonance]:
        """Resonances with these multiples of the speed by key: multiple, branch and a count."""
        shown = (one for one in self.resonances if one.per_rev in multiples)
        return numbered((f"{one.per_rev} {one.branch}", one) for one in shown)

    @cached_property
    def top(self) -> float:
        """End of the frequency axis: a round number in display units, just above all loci."""
        factor = self.request.measures[1].factor
        found = np.concatenate([branch.frequency for branch in self.loci.branches])
        largest = 1.03 * factor * np.max(found, initial=0.0, where=np.isfinite(found)) or 1.0
        power = 10.0 ** math.floor(math.log10(largest))
        return power * next(step for step in ROUND if step * power >= largest) / factor


def numbered(named: Iterable[tuple[str, Any]]) -> dict[str, Any]:
    """Records with names by their names and a count from 1."""
    counts, found = Counter[str](), {}
    for name, record in named:
        counts[name] += 1
        found[f"{name} {counts[name]}"] = record
    return found


def limit_text(request: ChartRequest, limit: Limit) -> str:
    """The reason why loci end, and the range."""
    first, last = (request.measures[0].text(end, 4) for end in (limit.start, limit.stop))
    place = f"from {first} to {last}"
    if limit.stop == request.stop:
        place = f"above {first}"
    elif limit.start == request.start:
        place = f"below {last}"
    law = " with this material law" if limit.kind == "no-equilibrium" else ""
    return f"{FAILURES[limit.kind]} {place}{law}."


# Data for the page


def sent(values: np.ndarray) -> list[float | None]:
    """Numbers (n,) for JSON: rounded, None for nan and infinity."""
    return [float(f"{x:.{DIGITS}g}") if math.isfinite(x) else None for x in values.tolist()]


def axis_data(measure: Measure, ends: tuple[float, float], *, log: bool = False) -> Data:
    """An axis of a chart."""
    names = {"label": measure.label, "symbol": measure.symbol, "unit": measure.unit}
    return {**names, "range": [measure.factor * end for end in ends], "log": log}


def frequency_axis(measure: Measure, ends: tuple[float, float]) -> Data:
    """An axis of frequencies."""
    label = "frequency [Hz]" if measure.unit else f"frequency {measure.label}"
    return axis_data(measure._replace(label=label), ends)


def cursor(answer: SolverAnswer | None, over: str, along: Measure) -> Data | None:
    """The line at the beam of an answer, which sets the number along the axis."""
    if answer is None or answer.beam is None:
        return None
    return {"action": over, "x": along.factor * getattr(answer.beam, over)}


def mark(key: str, kind: str, axes: Axes, at: tuple[float, float], text: str, **to: Any) -> Data:
    """A mark of a chart at a point; action=, value=: what a click on it sends."""
    x, y = (measure.factor * place for measure, place in zip(axes, at, strict=True))
    return {"key": key, "kind": kind, "text": text, "x": x, "y": y, **to}


def loci_lines(
    found: Loci, x: np.ndarray, factor: float, branches: Sequence[Branch] | None = None
) -> list[Data]:
    """The loci, of all or some branches, interpolated at x (n,), in runs of one family with the
    name of the mode there; consecutive runs share a point, so that lines have no gaps."""
    lines = []
    last = len(x) - 1
    before = np.maximum(np.searchsorted(found.values, x, "right") - 1, 0)
    for branch in branches or found.branches:
        y = np.interp(x, found.values, branch.frequency)
        family = [branch.family[k] if math.isfinite(y[i]) else None for i, k in enumerate(before)]
        cuts = [k for k in range(1, len(x)) if family[k] != family[k - 1]]
        runs = []
        for start, stop in pairwise([0, *cuts, len(x)]):
            if own := family[start]:
                name = name_of(found, branch, float(x[(start + stop) // 2]))
                runs.append([start, min(stop, last), own, name])
        if runs:
            label = name_of(found, branch, float(x[runs[-1][1]]))
            lines.append({"label": label, "y": sent(factor * y), "runs": runs})
    return lines


def name_of(found: Loci, branch: Branch | str, value: float) -> str:
    """The name of the mode of a branch, given by itself or its label, near a value."""
    label = branch if isinstance(branch, str) else branch.label
    return names_of_branches(found, value).get(label, label)


def axes_data(request: ChartRequest, message: str, second: Chart | None) -> Data:
    """A chart without loci, for the reason `message`, and the loci of a second beam."""
    along, across = request.measures
    lines = []
    if second:
        x = second.loci.values
        own = {"second": True, "at": sent(along.factor * x)}
        lines = [line | own for line in loci_lines(second.loci, x, across.factor)]
    return {
        "name": f"Frequencies over {along.label}",
        "message": message,
        "x": axis_data(along, (request.start, request.stop)),
        "y": frequency_axis(across, (0.0, 1.0)),
        "lines": lines,
        "perRev": None,
        "gaps": [],
        "marks": [],
    }


def chart_data(chart: Chart, multiples: Sequence[int] = (), second: Chart | None = None) -> Data:
    """The chart with per-rev lines, and behind it the loci of a second beam."""
    data, (along, across) = axes_data(chart.request, "", second), chart.request.measures
    x = np.union1d(chart.loci.values, [event.at for event in chart.loci.events])
    if chart.request.over == "gamma":
        per_rev = {"slope": across.factor / along.factor, "multiples": list(multiples)}
        data |= {"name": "Campbell diagram", "perRev": per_rev if multiples else None}
    return data | {
        "y": frequency_axis(across, (0.0, chart.top)),
        "at": sent(along.factor * x),
        "lines": data["lines"] + loci_lines(chart.loci, x, across.factor),
        "gaps": [
            [along.factor * one.start, along.factor * one.stop, FAILURES[one.kind]]
            for one in chart.loci.limits
        ],
        "marks": marks(chart, multiples),
    }


def marks(chart: Chart, multiples: Sequence[int]) -> list[Data]:
    """Crossings, veerings and resonances as buttons."""
    axes = along, across = chart.request.measures
    places: dict[str, Event | Resonance] = {**chart.events, **chart.resonances_at(multiples)}
    found = []
    for key, one in places.items():
        kind = one.kind if isinstance(one, Event) else "resonance"
        force = f" with {one.per_rev} per revolution" if isinstance(one, Resonance) else ""
        name = f"{kind} of {' and '.join(event_names(chart, one))}{force}"
        text = f"{name}: {along.text(one.at, 4)}, {across.text(one.frequency, 4)}"
        action = {"action": "go_to_event", "value": key}
        found.append(mark(key, kind, axes, (one.at, one.frequency), text, **action))
    return found


def event_names(chart: Chart, event: Event | Resonance) -> list[str]:
    """The names of the modes of an event there, stretching modes first."""
    branches = (event.branch,) if isinstance(event, Resonance) else event.branches
    names = (name_of(chart.loci, one, event.at) for one in branches)
    return sorted(names, key=lambda name: (name[0] != "S", name))
