"""The tab Loads: axial force, shear force and bending moment along the beam at its equilibrium, and
what the hub has to hold."""

from collections.abc import Mapping
from html import escape
from typing import Any, NamedTuple

import numpy as np

from beamviz.drawing.text import Measure, lengths, si_measure, significant, stress_text
from beamviz.explorer import page
from beamviz.explorer.declarations import Tab
from beamviz.explorer.feature import Feature, fading, waiting
from beamviz.explorer.jobs import Answer
from beamviz.explorer.page import Content
from beamviz.explorer.snapshot import Snapshot
from beamviz.explorer.solutions import SOLUTION, SolverAnswer
from beamviz.explorer.visitor import Visitor
from beamviz.solver.solution import Solution
from beamviz.units import Units

POINTS = 101  # along the beam
NONE = 1e-12  # of the largest force, times the length: what rounding leaves of no load


class Load(NamedTuple):
    """A load along the beam: its name, symbol and style in the chart; is_moment: whether its unit
    is E I / L, else E I / L^2."""

    name: str
    symbol: str
    style: str
    is_moment: bool = False


LOADS = {
    "axial": Load("axial force", "N", "stretching"),
    "shear": Load("shear force", "V", "mixed"),
    "moment": Load("bending moment", "M", "bending", is_moment=True),
}
CHARTS = {name: f"loads-{name}" for name in LOADS}
SHOWN = "loads-text", *CHARTS.values()  # ids of the text and of the charts
TEXT = '<div id="loads-text" tabindex="0" role="group" aria-label="Loads"></div>'
SKELETON = (
    f'<div class="loads-tab">{page.waiting_place("loads-wait")}{TEXT}<div class="loads-charts">'
    + "".join(f'<div id="{id}" class="chart" data-chart hidden></div>' for id in CHARTS.values())
    + "</div></div>"
)
JOB = "loads"

Diagrams = tuple[np.ndarray, dict[str, np.ndarray]]  # points (n,) and the loads there (n,)


class LoadsTab(Feature):
    """The loads on the beam of the answer, computed in the background while the tab is open: those
    of a blade take as long as its modes."""

    style = "loads.css"
    tab = Tab(
        "Loads",
        5,
        "Axial force, shear force and bending moment along the beam, and the stress of a real one",
        SKELETON,
        (SOLUTION, JOB),
    )

    def __init__(self, visitor: Visitor):
        super().__init__(visitor)
        visitor.job(JOB, diagrams_of)

    def wanted(self, snapshot: Snapshot) -> Mapping[str, Any]:
        """The loads of the answer while the tab is open."""
        is_open = snapshot.state.tab == self.tab.key
        return {JOB: snapshot.answer} if snapshot.answer and is_open else {}

    def content(self, snapshot: Snapshot) -> Content:
        return (
            loads_content(snapshot.job_answer(JOB))
            | fading(snapshot, [JOB], *SHOWN)
            | waiting(snapshot, "loads-wait", self.tab)
        )


def diagrams_of(answer: SolverAnswer) -> Diagrams | None:
    return loads_along(answer.solution) if answer.solution else None


def loads_content(answer: Answer[SolverAnswer, Diagrams | None] | None) -> Content:
    """The loads, or the reason why there are none."""
    content: Content = {}
    solution = answer.request.solution if answer else None
    if answer is None or solution is None or answer.result is None:
        for id in CHARTS.values():
            content |= page.props(id, hidden=True)
        reason = (answer.message or answer.request.message) if answer else ""
        return content | page.html("loads-text", page.note(reason))
    x, loads = answer.result
    for name, values in loads.items():
        shown = has_load(values, loads)
        content |= page.props(CHARTS[name], hidden=not shown)
        if shown:
            content |= page.chart(CHARTS[name], chart_data(name, x, values, solution.beam.units))
    return content | page.html("loads-text", text(solution, loads))


def loads_along(solution: Solution) -> Diagrams:
    """Points along the beam, two at each body, where forces have a step; and the loads there."""
    bodies = np.array([body.beta for body in solution.beam.bodies if body.beta < 1])
    x = np.union1d(np.linspace(0, 1, POINTS), [*bodies, *np.nextafter(bodies, 1)])
    return x, solution.equilibrium.loads.at(x)._asdict()


def has_load(values: np.ndarray, loads: dict[str, np.ndarray]) -> bool:
    """Whether a load is more than rounding."""
    largest = max(float(np.abs(one).max()) for one in loads.values())
    return float(np.abs(values).max()) > NONE * largest


def load_measure(name: str, units: Units | None, largest: float) -> Measure:
    """The display of a load, whose unit has a prefix for the largest value."""
    load = LOADS[name]
    one = None
    if units:
        one = units.newton_metres(1.0) if load.is_moment else units.newtons(1.0)
    if one is None:
        unit = "EI/L" if load.is_moment else "EI/L²"
        return Measure(f"{load.name} {load.symbol} [{unit}]", load.symbol)
    quantity = "N m" if load.is_moment else "N"
    return si_measure(f"{load.name} {load.symbol}", load.symbol, quantity, one, largest)


def position_measure(units: Units | None) -> Measure:
    if units is None:
        return Measure("position x / L", "x / L")
    return lengths("position", "x", units)


def chart_data(name: str, x: np.ndarray, values: np.ndarray, units: Units | None) -> page.Data:
    """The chart of a load along the beam."""
    load, along = LOADS[name], position_measure(units)
    across = load_measure(name, units, float(np.abs(values).max()))
    low, high = min(float(values.min()), 0.0), max(float(values.max()), 0.0)
    margin = 0.06 * (high - low)
    ends = (low - margin if low else 0.0, high + margin if high else 0.0)
    runs = [[0, len(x) - 1, load.style, load.name]]
    return {
        "name": f"{load.name.capitalize()} along the beam",
        "x": page.axis_data(along, (0.0, 1.0)),
        "y": page.axis_data(across, ends),
        "at": page.sent(along.factor * x),
        "lines": [{"label": load.symbol, "y": page.sent(across.factor * values), "runs": runs}],
        "keys": [],
    }


# The text

PULLED = (
    "At each point the axial force keeps all the mass further out on its circle: it grows from the"
    " tip to the root."
)
STEPS = " It has a step at each body."
PRESSED = (
    "The beam points inward, and the mass beyond each point presses on it: an axial force below 0"
    " is compression, where the beam may buckle."
)
BENT = (
    " As the beam is bent, that mass also pushes sideways (the shear force) and turns (the bending"
    " moment)."
)
STRAIGHT = " A straight beam has no shear force and no bending moment."
ROUNDING = 1e-12  # of a stretch of 1
AT_REST = "The beam is at rest: nothing loads it."


def sentence(solution: Solution, loads: dict[str, np.ndarray]) -> str:
    """What loads the beam."""
    axial, is_bent = loads["axial"], solution.equilibrium.shape == "bent"
    if not any(np.abs(values).max() > 0 for values in loads.values()):
        return AT_REST
    pressed = axial.min() < -axial.max()
    steps = STEPS if any(0 < body.beta < 1 for body in solution.beam.bodies) else ""
    return (PRESSED if pressed else PULLED) + steps + (BENT if is_bent else STRAIGHT)


def text(solution: Solution, loads: dict[str, np.ndarray]) -> str:
    """The sentence, the reaction at the root with its stress, and the greatest stretch and
    stress."""
    units = solution.beam.units
    stress = stress_at_root(solution)
    rows = []
    for name, values in loads.items():
        if has_load(values, loads):
            measure = load_measure(name, units, values[0])
            unit = measure.label.partition("[")[2].removesuffix("]")
            row = (LOADS[name].name, value_text(measure, values[0], unit))
            rows.append((*row, stress.get(name, "")) if stress else row)
    heads = ("load", "value", "stress") if stress else ("load", "value")
    caption = "On the beam at its root; the hub feels the opposite"
    table = page.table("loads at the root", heads, rows, caption)
    sentences = stretch_text(solution), sentence(solution, loads)
    paragraphs = "".join(f"<p>{escape(one)}</p>" for one in sentences)
    strength = page.strength(solution.equilibrium.greatest_stress, units)
    return strength + (table if rows else "") + paragraphs


def value_text(measure: Measure, value: float, unit: str) -> str:
    return escape(f"{significant(measure.factor * value, 4)} {unit}")


def stress_at_root(solution: Solution) -> dict[str, str]:
    """The stress of the axial force and of the bending moment at the root, by their names; {}
    where the material is not known."""
    units = solution.beam.units
    if units is None or units.youngs_modulus is None:
        return {}
    found = solution.equilibrium.stress(np.zeros(1))
    texts = {"axial": stress_text(float(found.axial[0]))}
    if found.bending is None:
        return texts | {"moment": "not known"}
    return texts | {"moment": f"± {stress_text(float(found.bending[0]))}"}


def stretch_text(solution: Solution) -> str:
    """The greatest stretch, and where it is."""
    x, along = np.linspace(0, 1, POINTS), position_measure(solution.beam.units)
    strain = solution.equilibrium.stretch(x) - 1
    k = int(np.argmax(np.abs(strain)))
    if abs(strain[k]) < ROUNDING:
        return "No part of it is stretched."
    kind = "stretch" if strain[k] > 0 else "compression"
    return f"Greatest {kind}: {significant(100 * abs(strain[k]), 3)} % at {along.text(x[k], 3)}."
