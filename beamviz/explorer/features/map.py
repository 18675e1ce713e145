"""The tab Map: a frequency, or the smallest gap between two frequencies, in colours over two of the
five numbers; a click on the map moves the beam there."""

import contextlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from html import escape
from typing import Any, Self

import numpy as np

from beamviz.beam import MAX_GAMMA_OVER_MU, NUMBERS, Beam
from beamviz.chart_ranges import CHART_AXES, chart_range
from beamviz.checks import check_float, check_int
from beamviz.drawing import colours
from beamviz.drawing.text import Measure, frequencies, measure, significant
from beamviz.errors import InvalidInput
from beamviz.explorer import page
from beamviz.explorer.computed_loci import axes_options
from beamviz.explorer.declarations import Key, Tab, choice, name_key
from beamviz.explorer.feature import Feature, fading, waiting
from beamviz.explorer.jobs import Answer
from beamviz.explorer.page import Content
from beamviz.explorer.snapshot import Snapshot
from beamviz.explorer.solutions import SOLUTION
from beamviz.explorer.state import Case, Slice, State
from beamviz.explorer.visitor import Visitor
from beamviz.scene import MODES
from beamviz.solver import interruption
from beamviz.sweeps.arrays import SOLVED, STATUSES, solve_in_memory
from beamviz.sweeps.plan import Plan, make_plan
from beamviz.sweeps.quantities import Quantity, frequency_of, smallest_gap

SIZE = (81, 41)  # columns and rows of beams in a map
SMALL_SIZE = (41, 21)  # where each beam takes as long as one alone
TOLERANCE = 1e-4  # relative: below one step of colour
QUANTITIES: dict[str | int, str] = {
    "gap": "smallest frequency gap",
    **{k: f"frequency of mode {k}" for k in range(1, MODES + 1)},
    1: "frequency of mode 1 (lowest)",
}
GAP_NOTE = (
    "Dark: two frequencies are nearly equal, as modes cross or veer. Lines separate regions in"
    " which other modes have the smallest gap."
)
MODE_NOTE = (
    "Modes are counted by frequency. Lines separate regions in which the mode is another one, or"
    " beams are not stable."
)
CLICK = "Click on the map, or move its ring by arrow keys, to give the beam these two numbers."


@dataclass(frozen=True)
class MapRequest:
    """The beams of a map; `beam` has the starts of the axes; options: keywords of `solve`."""

    beam: Beam
    over: tuple[str, str]  # along the horizontal and the vertical axis
    ranges: tuple[tuple[float, float], tuple[float, float]]
    options: dict[str, Any]

    @classmethod
    def around(
        cls, case: Case, over: tuple[str, str], upper_ends: tuple[float, float] | None = None
    ) -> Self:
        """The map around a case, with some upper ends of the axes if it contains the beam then.
        Raises InvalidInput for a number out of range."""
        beam = case.beam
        ends = {name: chart_range(beam, name) for name in over}
        for name, end in zip(over, upper_ends or (), strict=False):
            low, _ = ends[name]
            if max(low, getattr(beam, name)) <= end <= NUMBERS[name].limits[1]:
                ends[name] = low, end
        if "gamma" in ends and "mu" in ends:
            low, high = ends["mu"]
            ends["mu"] = max(low, ends["gamma"][1] / MAX_GAMMA_OVER_MU), high
        beam = beam.replace(**{name: end[1 if name == "mu" else 0] for name, end in ends.items()})
        return cls(beam, over, (ends[over[0]], ends[over[1]]), case.options)

    @property
    def measures(self) -> tuple[Measure, Measure, Measure]:
        """Display units of the axes and of frequencies; none over mu, on which T* depends."""
        units = None if "mu" in self.over else self.beam.units
        return *(measure(name, units) for name in self.over), frequencies(units)  # type: ignore[return-value]

    def solve(self) -> "BeamMap":
        """Solve the beams. Raises the errors of `solve_many`."""
        plan = self.plan(*SIZE)
        is_quick = plan.gains_by_stacks or (plan.is_stacked and self.beam.is_prismatic)
        plan = plan if is_quick else self.plan(*SMALL_SIZE)
        found = solve_in_memory(plan, interruption.get())
        arrays = (found[name].swapaxes(0, 1) for name in ("frequency", "family", "status"))
        return BeamMap(self, *plan.axes.values(), *arrays)

    def plan(self, *counts: int) -> Plan:
        """The sweep over equally spaced values along both axes."""
        axes = zip(self.over, self.ranges, counts, strict=True)
        values = {name: np.linspace(*ends, count) for name, ends, count in axes}
        return make_plan(values, self.beam, **{**self.options, "tolerance": TOLERANCE})


@dataclass(frozen=True, eq=False)
class BeamMap:
    """The solved beams of a map: the values of its axes, x (columns,) and y (rows,), and arrays
    (rows, columns, modes) as in the store of a sweep; status: (rows, columns)."""

    request: MapRequest
    x: np.ndarray
    y: np.ndarray
    frequency: np.ndarray
    family: np.ndarray
    status: np.ndarray


JOB = "map"
SHOWN = "map-chart", "map-text"  # ids of the map and of the text beside it
TOOLS = page.select("mapped", "colour", QUANTITIES)
TOOLS += page.select("over", "horizontal axis", (), id="map-over")
TOOLS += page.select("across", "vertical axis", (), id="map-across")


def read_mapped(value: Any) -> str | int:
    return value if value == "gap" else check_int("map", value, 1, MODES)


def read_ends(value: Any) -> tuple[float, float]:
    if not isinstance(value, list) or len(value) != 2:
        raise InvalidInput(f"ends = {value!r}: must be two numbers")
    first, second = (check_float("ends", end) for end in value)
    return first, second


@dataclass(frozen=True)
class MapState(Slice):
    """The choices of the map, besides its abscissa."""

    # The ordinate.
    across: str = field(
        default="alpha", metadata=choice(values=CHART_AXES, key=name_key("across", CHART_AXES))
    )
    # A mode or the gap.
    mapped: str | int = field(
        default="gap", metadata=choice(values=QUANTITIES, key=Key("map", read_mapped))
    )
    # The upper ends of the axes of the map in which a point was chosen.
    map_ends: tuple[float, float] | None = field(
        default=None,
        metadata=choice(key=Key("ends", read_ends, json.dumps), until=("scene", "over", "across")),
    )

    def settled(self, before: State, state: State) -> State:
        """A number that is chosen for both axes takes the place of the other one; in place of one
        that the beam has no chart over comes a usual one."""
        axes, present = state.case.axes, before.slice(MapState).across
        if self.across not in axes:
            free = MapState.across if state.over != MapState.across else State.over
            return state.with_values(MapState, across=free)
        if state.over != self.across:
            return state
        if present != self.across:
            return replace(state, over=present)
        other = before.over if before.over in axes else MapState.across
        return state.with_values(MapState, across=other)


class MapTab(Feature):
    """The choices, the map and its legend."""

    style = "map.css"
    tab = Tab(
        "Map",
        2,
        "A frequency, or the smallest gap, over two numbers: press it to go there",
        page.chart_tab(TOOLS, "map-chart", "map-text"),
        (SOLUTION, JOB),
        beside="Frequencies",
        view="map",
    )
    state = MapState

    def __init__(self, visitor: Visitor):
        super().__init__(visitor)
        visitor.job(JOB, MapRequest.solve)
        self.page.on("move_beam", self.move_beam, str)

    def move_beam(self, place: Any) -> None:
        """Give the beam the two numbers of a point "x y" of the map, in the units of its axes."""
        if answer := self.visitor.shown_answer(JOB):
            (along, up), (first, second, _) = answer.request.over, answer.request.measures
            ends = tuple(end for _, end in answer.request.ranges)
            with contextlib.suppress(ValueError):
                x, y = map(float, str(place).split())
                numbers = {along: first.plain(x), up: second.plain(y)}
                self.visitor.change(lambda state: moved(state, numbers, ends))

    def wanted(self, snapshot: Snapshot) -> Mapping[str, Any]:
        """The map while the tab is open; while it is closed, that of this beam goes on if it was
        begun."""
        state, case = snapshot.state, snapshot.drawn_case
        if case is None:
            return {}
        chosen = state.slice(MapState)
        request = MapRequest.around(case, (state.over, chosen.across), chosen.map_ends)
        goes_on = state.tab == self.tab.key or snapshot.jobs[JOB].latest == request
        return {JOB: request if goes_on else None}

    def content(self, snapshot: Snapshot) -> Content:
        answer = snapshot.job_answer(JOB)
        return (
            map_content(answer, snapshot.state.slice(MapState).mapped)
            | axes_options(snapshot.state.case, "map-over", "map-across")
            | place_content(answer, snapshot.entered_beam)
            | fading(snapshot, [JOB], *SHOWN)
            | waiting(snapshot, "map-chart-wait", self.tab)
        )


def moved(state: State, numbers: dict[str, float], ends: tuple[float, ...]) -> State:
    """With two numbers of a point of a map, whose axes keep their upper ends."""
    for name, number in numbers.items():
        state = state.changed(name, number)
    return state.with_values(MapState, map_ends=ends)


@lru_cache(32)  # for several visitors: the borders take 5 ms, of each frame with an edit
def map_content(answer: Answer[MapRequest, BeamMap] | None, mapped: str | int) -> Content:
    """The last map, or the reason why there is none."""
    if answer is None or answer.result is None:
        reason = page.note(answer.message) if answer else ""
        return page.props("map-chart", hidden=True) | page.html("map-text", reason)
    drawn = ShownMap(answer.result, mapped)
    content = page.props("map-chart", hidden=drawn.is_empty) | page.html("map-text", drawn.text())
    return content | page.chart("map-chart", drawn.data())


def place_content(answer: Answer[MapRequest, BeamMap] | None, beam: Beam | None) -> Content:
    """The place of the beam in the map; none where a number is out of range."""
    if answer is None or answer.result is None:
        return page.props("map-chart", hidden=True)
    if beam is None:
        return page.chart("map-chart", {"cursor": None})
    x, y = (
        float(one.factor * getattr(beam, name))
        for one, name in zip(answer.request.measures, answer.request.over, strict=False)
    )
    return page.chart("map-chart", {"cursor": {"action": "move_beam", "x": x, "y": y}})


# HTML and data for the page


class ShownMap:
    """A quantity of a map; low, high: the values at the ends of the colours."""

    def __init__(self, found: BeamMap, mapped: str | int):
        self.found, self.measures, self.label = found, found.request.measures, QUANTITIES[mapped]
        self.is_gap = mapped == "gap"
        arrays = found.frequency, found.family, found.status
        if self.is_gap:
            self.shown = smallest_gap(*arrays)
        else:
            self.shown = frequency_of(int(mapped), *arrays)
        known = self.shown.values[np.isfinite(self.shown.values)]
        self.is_empty = not known.size
        ends = np.array([0.0, 1.0]) if self.is_empty else known
        self.low, self.high = float(ends.min()), float(ends.max())

    def data(self) -> page.Data:
        """The data of the map (map.js)."""
        (along, up, across), found, shown = self.measures, self.found, self.shown
        low, high = (across.text(end, 3) for end in (self.low, self.high))
        x, y = along.factor * found.x, up.factor * found.y
        return {
            "name": f"Map: {self.label} over {along.label} and {up.label}, from {low} to {high}",
            "x": page.axis_data(along, found.request.ranges[0]),
            "y": page.axis_data(up, found.request.ranges[1]),
            "columns": len(x),
            "values": page.sent(across.factor * shown.values.ravel()),
            "colours": colours.SEQUENTIAL,
            "range": [float(across.factor * end) for end in (self.low, self.high)],
            "value": {"symbol": "gap" if self.is_gap else across.symbol, "unit": across.unit},
            "borders": borders(shown, x, y),
            "regions": [
                {"x": float(x[column]), "y": float(y[row]), "text": name}
                for name, row, column in shown.regions
            ],
        }

    def text(self) -> str:
        """The colours, the extremes, and the parts of the map whose beams are not stable."""
        across = self.measures[2]
        ends = (significant(across.factor * end, 3) for end in (self.low, self.high))
        title = f"{self.label} [{across.unit or '1/T*'}]"
        return (
            f'<div class="scale">{page.colour_scale(title, colours.SEQUENTIAL, *ends)}</div>'
            f"<p>{GAP_NOTE if self.is_gap else MODE_NOTE} {CLICK}</p>"
            + ("" if self.is_empty else self.extremes())
            + self.shares_not_stable()
        )

    def shares_not_stable(self) -> str:
        """The parts of the map whose beams are not stable, by status."""
        notes, has_value = "", np.isfinite(self.shown.values)
        for code in range(SOLVED + 1, len(STATUSES)):
            here = self.found.status == code
            for what, part in (("Grey", here & ~has_value), ("In colour, but", here & has_value)):
                if part.any():
                    percent = max(1, round(100 * float(part.mean())))
                    notes += page.note(f"{what}: {STATUSES[code]} ({percent} % of the map).")
        return notes

    def extremes(self) -> str:
        """The smallest and the largest value, each with a button that moves the beam there."""
        (along, up, across), found, shown = self.measures, self.found, self.shown
        rows = []
        for name, value in (("smallest", self.low), ("largest", self.high)):
            row, column = np.argwhere(np.isclose(shown.values, value, TOLERANCE, 0.0))[0]
            x, y = float(found.x[column]), float(found.y[row])
            place = f"{along.factor * x!r} {up.factor * y!r}"
            go_to = page.button(name, data_do="move_beam", data_value=place, class_="quiet")
            numbers = along.number(x), up.number(y), across.gap(value)
            rows.append((go_to, *numbers, escape(shown.names[int(shown.kinds[row, column])])))
        mapped = f"gap [{across.unit or '1/T*'}]" if self.is_gap else across.label
        heads = ("go to", along.head, up.head, mapped, "there")
        caption = f"Among the {len(found.x)} × {len(found.y)} beams of the map"
        return page.table("smallest and largest of the map", heads, rows, caption=caption)


def borders(shown: Quantity, x: np.ndarray, y: np.ndarray) -> list[list[list[float | None]]]:
    """The lines between regions, each as its x and its y, for the values of both axes."""
    from contourpy import contour_generator

    lines = (line for z in shown.borders for line in contour_generator(x, y, z).lines(0.5))
    return [[page.sent(ends) for ends in np.transpose(line)] for line in lines]  # type: ignore[arg-type]
