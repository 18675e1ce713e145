"""The controls of the beam: the five numbers and the terms of the equations."""

import math
from functools import partial
from typing import Any

from viser import GuiApi, GuiNumberHandle, GuiSliderHandle

from beamviz.beam import PARAMETERS, Units
from beamviz.drawing.text import measures, places
from beamviz.explorer.state import State
from beamviz.explorer.visitor import Visitor, on_edit, show

TERMS = {
    "stiffening": (
        "stiffening",
        "The tension of a rotating beam straightens it, as in a string: bending gets faster",
    ),
    "softening": (
        "spin softening",
        "What is displaced outwards is pulled outwards more: motion in the plane of rotation"
        " gets slower",
    ),
    "coriolis": (
        "Coriolis",
        "The force on what moves along a rotating beam; it couples bending and stretching",
    ),
}
MASS = "The concentrated mass; switched on again it is what it was"
FIRST_MASS = 1.0  # for a beam that never had one


class NumberControls:
    """The five numbers, each with a slider for its everyday range and a field for all of it, in
    the units of the beam."""

    def __init__(self, visitor: Visitor):
        gui, self.visitor = visitor.client.gui, visitor
        self.sliders = {name: self.add_slider(gui, name) for name in PARAMETERS}
        with gui.add_folder("Exact, over the full range", expand_by_default=False):
            self.fields = {name: self.add_field(gui, name) for name in PARAMETERS}
        self.measures = measures(visitor.state.case.units)
        visitor.render(lambda state: state.scene, lambda _: self.choose_ranges(visitor.state))
        for name in PARAMETERS:
            visitor.render(partial(State.value, name=name), partial(self.show, name))

    def add_slider(self, gui: GuiApi, name: str) -> GuiSliderHandle[float]:
        """The slider of a number."""
        parameter = PARAMETERS[name]
        low, high, step = parameter.slider
        label, hint = parameter.slider_label, parameter.hint
        slider = gui.add_slider(label, low, high, step, low, hint=hint)
        on_edit(slider, lambda value: self.edit(name, value))
        return slider

    def add_field(self, gui: GuiApi, name: str) -> GuiNumberHandle[float]:
        """The field of a number."""
        low, high = PARAMETERS[name].limits
        step = PARAMETERS[name].slider[2]
        field = gui.add_number(name, low, min=low, max=high, step=step)
        on_edit(field, lambda value: self.edit(name, value))
        return field

    def edit(self, name: str, value: Any) -> None:
        """A number was set, in its unit."""
        number = self.measures[name].plain(value)
        self.visitor.change(lambda state: state.changed(name, number))

    def show(self, name: str, number: Any) -> None:
        """Show a number; the slider widens for one beyond its everyday range."""
        if not isinstance(number, int | float) or not math.isfinite(number):
            return
        slider, factor = self.sliders[name], self.measures[name].factor
        if not slider.min <= factor * number <= slider.max:
            slider.min, slider.max = (factor * limit for limit in PARAMETERS[name].limits)
        show(slider, factor * number)
        show(self.fields[name], factor * number)

    def choose_ranges(self, state: State) -> None:
        """Choose labels and ranges for another scene, and show its numbers."""
        units = state.case.units
        self.measures = measures(units)
        for name in self.sliders:
            number = state.case.numbers[name]
            self.choose_range(name, number, units)
            self.show(name, number)
        self.sliders["mu"].visible = self.fields["mu"].visible = units is None

    def choose_range(self, name: str, number: float, units: Units | None) -> None:
        """Label and range of a slider and its field. The slider covers four times the value of a
        real beam, and the full range where it must."""
        slider, field, measure = self.sliders[name], self.fields[name], self.measures[name]
        parameter = PARAMETERS[name]
        slider.label, field.label = measure.label, measure.field(parameter.label)
        field.precision = 8 if measure.unit == "" else 4
        field.min, field.max = (measure.factor * limit for limit in parameter.limits)
        low, high, step = parameter.slider
        if units and number > 0 and name in ("alpha", "gamma"):
            low, high, step = 0.0, 4 * number, number / 100
        if not low <= number <= high:
            low, high = parameter.limits
        slider.min, slider.max, slider.step = measure.range(low, high, step, parameter.limits)
        slider.precision = 4 if measure.unit == "" else places(slider.step)


def switch_term(name: str, state: State, on: Any) -> State:
    """With a term switched on or off; how the beam was is kept for comparison."""
    return state.keep_for_comparison().changed(name, on)


class TermControls:
    """A switch for each term of the equations, and one for the mass."""

    def __init__(self, visitor: Visitor):
        gui, self.alpha = visitor.client.gui, FIRST_MASS
        for name, (label, hint) in TERMS.items():
            box = gui.add_checkbox(label, False, hint=hint)
            visitor.bind(box, partial(State.value, name=name), partial(switch_term, name))
        visitor.bind(gui.add_checkbox("mass", False, hint=MASS), self.has_mass, self.switch_mass)

    def has_mass(self, state: State) -> bool:
        """Whether the beam has a mass; how large it is, is noted."""
        alpha: Any = state.case.numbers["alpha"]
        if isinstance(alpha, int | float) and alpha > 0:
            self.alpha = alpha
        return alpha != 0

    def switch_mass(self, state: State, on: Any) -> State:
        """Take the mass off, or put it back."""
        return state.keep_for_comparison().changed("alpha", self.alpha if on else 0.0)
