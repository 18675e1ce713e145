"""The tab Map: a frequency, or the smallest gap between two, in colours over two of the five
numbers; a press on the map moves the beam there."""

import contextlib
from dataclasses import dataclass
from html import escape
from typing import Any, Self

import numpy as np

from beamviz.beam import MAX_GAMMA_OVER_MU, Beam
from beamviz.drawing import colours
from beamviz.drawing.text import Measure, frequencies, measure, significant
from beamviz.errors import InvalidInput
from beamviz.explorer.features.loci_chart import Data, axis_data, sent
from beamviz.explorer.features.loci_tab import AXES
from beamviz.explorer.jobs import Answer, check_cancelled
from beamviz.explorer.page.html import button, select, table
from beamviz.explorer.state import Case
from beamviz.explorer.visitor import Feature, Visitor
from beamviz.frequency_loci.sweep import chart_range
from beamviz.sweeps.chunks import solve_in_memory
from beamviz.sweeps.plan import make_plan
from beamviz.sweeps.quantities import Quantity, frequency_of, smallest_gap
from beamviz.sweeps.store import STATUSES

TAB = "tab-map"
COLUMNS, ROWS = 81, 41  # beams of a map
FEW = (41, 21)  # where each of them is solved by itself
TOLERANCE = 1e-4  # relative: finer than a colour
ROOM = 2.0  # the axes stay while the beam is on them and they are at most so many times too long
QUANTITIES = {
    "gap": "smallest frequency gap",
    "1": "frequency of mode 1 (lowest)",
    **{str(k): f"frequency of mode {k}" for k in range(2, 6)},
}
GAP_NOTE = (
    "Dark: two frequencies nearly meet, where modes cross or veer. Lines separate regions by which"
    " two modes are nearest to each other."
)
MODE_NOTE = (
    "Modes are counted by frequency. Across a line another shape takes this place in the order."
)
PRESS = "Press on the map, or move its ring by arrow keys: the beam takes these two numbers."


@dataclass(frozen=True)
class MapRequest:
    """The beams of a map: `beam` has the starts of the axes as its numbers `over`."""

    beam: Beam
    over: tuple[str, str]  # along the horizontal and the vertical axis
    ranges: tuple[tuple[float, float], tuple[float, float]]
    options: dict[str, Any]

    @classmethod
    def around(cls, case: Case, over: tuple[str, str], last: Self | None) -> Self:
        """The map around a case, on the axes of the last one as long as they fit. Raises
        InvalidInput where a number is out of range."""
        beam = case.beam()
        first, second = (chart_range(beam, name) for name in over)
        if last and last.over == over and last.beam.units == beam.units:
            first, second = (
                old if old[0] <= getattr(beam, name) <= old[1] <= ROOM * new[1] else new
                for name, old, new in zip(over, last.ranges, (first, second), strict=True)
            )
        ends = dict(zip(over, (first, second), strict=True))
        if "gamma" in ends and "mu" in ends:
            low, high = ends["mu"]
            ends["mu"] = max(low, ends["gamma"][1] / MAX_GAMMA_OVER_MU), high
        beam = beam.replace(**{name: end[1 if name == "mu" else 0] for name, end in ends.items()})
        return cls(beam, over, (ends[over[0]], ends[over[1]]), case.options)

    @property
    def measures(self) -> tuple[Measure, Measure, Measure]:
        """Display units of the axes and of frequencies; T* itself depends on mu."""
        units = None if "mu" in self.over else self.beam.units
        return *(measure(name, units) for name in self.over), frequencies(units)  # type: ignore[return-value]

    def solve(self) -> "BeamMap":
        """Solve the beams. Raises the errors of `solve_many`."""
        options = {**self.options, "tolerance": TOLERANCE}
        plan = make_plan(axes(self, COLUMNS, ROWS), self.beam, **options)
        if not plan.smooth:
            plan = make_plan(axes(self, *FEW), self.beam, **options)
        found = solve_in_memory(plan, check_cancelled)
        x, y = plan.axes.values()
        arrays = (found[name].swapaxes(0, 1) for name in ("frequency", "family", "status"))
        return BeamMap(self, x, y, *arrays)


@dataclass(frozen=True, eq=False)
class BeamMap:
    """The solved beams of a map: the values of its axes, and arrays (rows, columns, modes) as in a
    store of a sweep."""

    request: MapRequest
    x: np.ndarray
    y: np.ndarray
    frequency: np.ndarray
    family: np.ndarray
    status: np.ndarray

    def quantity(self, mapped: str) -> Quantity:
        """The quantity to show."""
        if mapped == "gap":
            return smallest_gap(self.frequency, self.family, families=False)
        return frequency_of(int(mapped), self.frequency, self.family)


class MapTab(Feature):
    """The choices, the map and its legend."""

    def __init__(self, visitor: Visitor):
        super().__init__(visitor)
        self.job = visitor.job("map", MapRequest.solve)
        self.drawn: tuple[object, ...] = ()
        visitor.page.html(TAB, skeleton())
        for key in ("across", "mapped"):
            visitor.bind(key)
        visitor.on("move_beam", self.move_beam)

    def move_beam(self, place: Any) -> None:
        """Take the two numbers of a place "x y" on the map, in the units of its axes."""
        answer = self.job.answer
        with contextlib.suppress(ValueError):
            numbers = [float(part) for part in str(place).split()]
            if answer and len(numbers) == 2:
                (along, up), (first, second, _) = answer.request.over, answer.request.measures
                x, y = first.plain(numbers[0]), second.plain(numbers[1])
                self.visitor.change(lambda state: state.changed(along, x).changed(up, y))

    @property
    def inputs(self) -> tuple[object, ...]:
        """The open tab, the beam, the choices, and the map."""
        visitor, state = self.visitor, self.visitor.state
        return (
            visitor.page.tab, visitor.chart_answer, state.over, state.across, state.mapped,
            self.job.answer, self.job.slow,
        )  # fmt: skip

    def show(self) -> None:
        """Request the map while the tab is open, and draw the last one."""
        if self.visitor.page.tab != TAB:
            return
        page, state, request = self.visitor.page, self.visitor.state, self.request()
        if request:
            self.job.request(request)
        self.fade("map-chart", self.job)
        answer = None if self.job.cancelled else self.job.answer
        if answer and self.drawn != (drawn := (answer, state.mapped)):
            self.drawn = drawn
            self.draw(answer, state.mapped)
        if answer and self.visitor.chart_answer and self.visitor.chart_answer.beam:
            beam, (first, second, _) = self.visitor.chart_answer.beam, answer.request.measures
            x, y = (getattr(beam, name) for name in answer.request.over)
            page.chart("map-chart", {"beam": [first.factor * x, second.factor * y]})

    def draw(self, answer: Answer[MapRequest, BeamMap], mapped: str) -> None:
        """Draw a map, or say why there is none."""
        page, found = self.visitor.page, answer.result
        shown = found.quantity(mapped) if found else None
        page.props("map-chart", hidden=shown is None or not np.isfinite(shown.values).any())
        if found is None or shown is None:
            page.html("map-text", f'<p class="note">{escape(answer.message)}</p>')
            return
        page.html("map-text", legend(found, shown, mapped) + extremes(found, shown) + notes(found))
        page.chart("map-chart", map_data(found, shown, mapped))

    def request(self) -> MapRequest | None:
        """The map of the beam shown; None where there is none."""
        state, answer = self.visitor.state, self.visitor.chart_answer
        with contextlib.suppress(InvalidInput):  # the page says so; the last map stays
            if answer:
                over = state.over, state.across
                return MapRequest.around(answer.request, over, self.job.latest)
        return None


def axes(request: MapRequest, *counts: int) -> dict[str, np.ndarray]:
    """Equally spaced values along both axes."""
    return {
        name: np.linspace(*ends, count)
        for name, ends, count in zip(request.over, request.ranges, counts, strict=True)
    }


# What the page shows


def skeleton() -> str:
    """The tab without its contents."""
    across = "".join(
        f'<option value="{name}">{escape(text)}</option>' for name, text in AXES.items()
    )
    return (
        '<div class="chart-tab"><div class="tools">'
        + select("mapped", "colour", QUANTITIES)
        + '<div class="field"><label for="map-over">horizontal axis</label>'
        f'<select id="map-over" data-set="over">{across}</select></div>'
        + select("across", "vertical axis", AXES)
        + '</div><div id="map-chart" class="chart" data-chart hidden></div>'
        '<div id="map-text" class="lists"></div></div>'
    )


def colour_range(shown: Quantity) -> tuple[float, float]:
    """The values at the ends of the colours."""
    known = shown.values[np.isfinite(shown.values)]
    return (float(known.min()), float(known.max())) if known.size else (0.0, 1.0)


def map_data(found: BeamMap, shown: Quantity, mapped: str) -> Data:
    """The map as map.js takes it."""
    request = found.request
    along, up, across = request.measures
    return {
        "name": f"Map: {summary(found, shown, mapped)}",
        "x": axis_data(along, request.ranges[0]),
        "y": axis_data(up, request.ranges[1]),
        "columns": len(found.x),
        "values": sent(across.factor * shown.values.ravel()),
        "colours": colours.SEQUENTIAL,
        "range": [across.factor * end for end in colour_range(shown)],
        "value": {"symbol": "gap" if mapped == "gap" else across.symbol, "unit": across.unit},
        "borders": borders(found, shown),
        "regions": [
            {"x": along.factor * found.x[column], "y": up.factor * found.y[row], "text": name}
            for name, row, column in shown.regions
        ],
    }


def borders(found: BeamMap, shown: Quantity) -> list[list[list[float | None]]]:
    """Lines, each as its x and its y, between regions, in the units of the axes."""
    from contourpy import contour_generator

    along, up, _ = found.request.measures
    x, y = along.factor * found.x, up.factor * found.y
    lines = (line for z in shown.borders for line in contour_generator(x, y, z).lines(0.5))
    return [[sent(ends) for ends in np.transpose(line)] for line in lines]  # type: ignore[arg-type]


def summary(found: BeamMap, shown: Quantity, mapped: str) -> str:
    """What the map shows, in a sentence."""
    along, up, across = found.request.measures
    low, high = (across.text(end, 3) for end in colour_range(shown))
    return f"{QUANTITIES[mapped]} over {along.label} and {up.label}, from {low} to {high}"


def legend(found: BeamMap, shown: Quantity, mapped: str) -> str:
    """The colours with the values at their ends."""
    across = found.request.measures[2]
    ends = [significant(across.factor * end, 3) for end in colour_range(shown)]
    unit = across.unit or "1/T*"
    return (
        f'<div class="scale"><span>{escape(QUANTITIES[mapped])} [{unit}]</span>'
        f'<div class="colours" style="background:{colours.gradient(colours.SEQUENTIAL)}"></div>'
        f'<div class="ends"><span>{ends[0]}</span><span>{ends[1]}</span></div></div>'
        f"<p>{GAP_NOTE if mapped == 'gap' else MODE_NOTE} {PRESS}</p>"
    )


def extremes(found: BeamMap, shown: Quantity) -> str:
    """Where the quantity is smallest and largest, each with a button that moves the beam there."""
    if not np.isfinite(shown.values).any():
        return ""
    along, up, across = found.request.measures
    rows = []
    for name, flat in (
        ("smallest", np.nanargmin(shown.values)),
        ("largest", np.nanargmax(shown.values)),
    ):
        row, column = np.unravel_index(flat, shown.values.shape)
        x, y = float(found.x[column]), float(found.y[row])
        kind = shown.names[int(shown.kinds[row, column])]
        place = f"{along.factor * x!r} {up.factor * y!r}"
        rows.append(
            (
                button(name, data_do="move_beam", data_value=place, class_="quiet"),
                along.number(x, 3),
                up.number(y, 3),
                significant(across.factor * float(shown.values[row, column]), 3),
                escape(kind),
            )
        )
    heads = ("go to", along.head, up.head, across.label, "there")
    caption = f"Among the {len(found.x)} × {len(found.y)} beams of the map"
    return table("smallest and largest of the map", heads, rows, caption=caption)


def notes(found: BeamMap) -> str:
    """Parts of the map without a stable beam."""
    texts = []
    for code in (2, 3, 4):
        share = float((found.status == code).mean())
        if share:
            percent = max(1, round(100 * share))
            texts.append(f'<p class="note">Grey: {STATUSES[code]} ({percent} % of the map).</p>')
    return "".join(texts)
