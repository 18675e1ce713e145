"""The controls of the numbers of the beam, and of the terms of its equations."""

import math
from functools import partial
from html import escape
from typing import Any

from beamviz.beam import NUMBERS, PARAMETERS, Units
from beamviz.drawing.text import Measure, measures
from beamviz.explorer import page
from beamviz.explorer.state import State
from beamviz.explorer.visitor import Feature, Visitor

SWITCHES = {
    "stiffening": (
        "stiffening",
        "Tension by the centrifugal force, as in a taut string: it raises bending frequencies",
    ),
    "softening": (
        "spin softening",
        "The centrifugal force grows with a displacement in the plane of rotation: it lowers the"
        " frequencies of motion in this plane",
    ),
    "coriolis": (
        "Coriolis",
        "Forces on parts that move within the rotating frame: they couple bending and stretching",
    ),
    "mass": ("mass", "The concentrated mass; switched on again it has its last value"),
}
RESET_HINT = "Back to the scene as the page, a link, a file or the lesson opened it (R)"
FIELD_DIGITS = 8
FIRST_MASS = 1.0  # for a beam that never had one


class BeamControls(Feature):
    """The numbers of the beam, each with a slider for its usual range and a field for its full
    range, in the units of the beam; and a switch for each term of the equations and for the mass.

    ranges: of the sliders, in the units shown; alpha: the mass that is restored.
    """

    def __init__(self, visitor: Visitor):
        super().__init__(visitor)
        self.alpha = FIRST_MASS
        self.ranges: dict[str, tuple[float, float]] = {}
        reset = page.button("Reset the scene", data_do="reset", data_key="r", title=RESET_HINT)
        more = f"<details><summary>Advanced</summary>{number_slider('spin_up')}</details>"
        sliders = "".join(number_slider(name) for name in PARAMETERS)
        self.page.html("beam", sliders + more + reset)
        switches = (page.checkbox(key, label, help) for key, (label, help) in SWITCHES.items())
        self.page.html("effects", "".join(switches))
        self.measures = measures(visitor.state.case.units)
        for name in NUMBERS:
            self.page.on(name, partial(self.edit, name))
        visitor.bind("mass", self.switch_mass, lambda values: bool(values["alpha"]))

    def edit(self, name: str, value: Any) -> None:
        number = self.measures[name].plain(value)
        self.visitor.change(lambda state: state.changed(name, number))

    def show(self) -> None:
        """Show the numbers; a slider gets the full range if the usual one lacks its number."""
        state = self.visitor.state
        if self.redraws(state.scene):
            self.choose_ranges(state)
        for name, number in state.case.numbers.items():
            if not is_finite(number):
                continue
            if name == "alpha" and number > 0:
                self.alpha = number
            measure, (low, high) = self.measures[name], self.ranges[name]
            shown = float(f"{measure.factor * number:.{FIELD_DIGITS}g}")
            if not low <= shown <= high:
                low, high = (measure.factor * limit for limit in NUMBERS[name].limits)
                self.page.props(f"{name}-slider", min=low, max=high)
            self.page.value(name, shown)

    def choose_ranges(self, state: State) -> None:
        """Choose labels and ranges for a scene that was loaded."""
        units = state.case.units
        self.measures = measures(units)
        for name, number in state.case.numbers.items():
            measure, known = self.measures[name], number if is_finite(number) else 0.0
            low, high, step = slider_range(name, known, measure, units)
            self.ranges[name] = low, high
            values = {"min": low, "max": high, "step": step, "data_unit": measure.unit}
            self.page.props(f"{name}-slider", **values)
            self.page.props(f"{name}-field", aria_label=measure.label)
            self.page.html(f"{name}-label", escape(measure.label))
        self.page.props("mu-row", hidden=units is not None)
        self.page.html("units", "SI units" if units else "Real beam…")

    def switch_mass(self, state: State, on: Any) -> State:
        """Remove the mass, or restore its last value."""
        return state.keep_for_comparison().changed("alpha", self.alpha if on else 0.0)


def slider_range(
    name: str, number: float, measure: Measure, units: Units | None
) -> tuple[float, float, float]:
    """The range of a slider and its step as displayed: up to four times the value of a real beam,
    or the full range if the usual one does not contain the value."""
    parameter = NUMBERS[name]
    low, high, step = parameter.slider
    if units and number > 0 and name in ("alpha", "gamma"):
        low, high, step = 0.0, 4 * number, number / 100
    if not low <= number <= high:
        low, high = parameter.limits
    return measure.range(low, high, step, parameter.limits)


def is_finite(number: Any) -> bool:
    return isinstance(number, int | float) and math.isfinite(number)


def number_slider(name: str) -> str:
    parameter = NUMBERS[name]
    low, high, step = parameter.slider
    return page.slider(name, parameter.slider_label, parameter.hint, min=low, max=high, step=step)
