"""The five numbers, a slider and a field for each, and how a visitor's choices are heard."""

import math
import threading
from collections.abc import Callable
from functools import partial
from typing import Any, Protocol

from viser import GuiApi, GuiEvent, GuiInputHandle, GuiNumberHandle, GuiSliderHandle

from beamviz.beam import PARAMETERS, Beam
from beamviz.display_units import measures, places
from beamviz.scene import Scene
from beamviz.server.viser_private import set_value, stop_sync


class Listener(Protocol):
    """Who hears what the visitor chooses."""

    def want(self, name: str, value: Any) -> None:
        """A number or keyword of the solution."""

    def see(self, name: str, value: Any) -> None:
        """A choice of the picture."""

    def share(self, mode: int, value: Any) -> None:
        """How much of a mode (from 0) is in the picture."""

    def only(self, mode: int) -> None:
        """One mode (from 0) alone."""

    def reset(self) -> None:
        """The beam back to what it was."""

    def reset_view(self) -> None:
        """The camera back to where it was."""

    def sweep(self, over: str) -> None:
        """The number the loci chart runs over."""

    def show_per_rev(self, shown: bool) -> None:
        """Per-rev lines in the loci chart."""

    def meet(self, number: int) -> None:
        """A meeting (from 0) of the loci chart."""

    @property
    def comparison(self) -> Any:
        """What hears of the second beam."""

    @property
    def weighing(self) -> Any:
        """What hears whether to measure all methods."""

    def keep(self) -> None:
        """Keep the beam as it is, to compare with."""

    def remember(self) -> None:
        """Keep it unless it is compared with something else."""

    def saved(self) -> Scene:
        """All that is set, as a scene; InvalidInput where that is none."""

    def load(self, scene: Scene) -> None:
        """Show another scene."""

    @property
    def ride(self) -> Any:
        """What hears of the run-up."""

    def run_up(self) -> None:
        """Start the run-up, or stop it."""


class Numbers:
    """The five numbers, each with a slider for its everyday range and a field for all of it.
    They show the units of the beam; what they hand on is dimensionless."""

    def __init__(
        self,
        gui: GuiApi,
        beam: Beam,
        listener: Listener,
        lock: threading.RLock,
    ):
        self.listener, self.lock, self.measures = listener, lock, measures(beam.units)
        self.sliders = {name: self.add_slider(gui, name) for name in PARAMETERS}
        with gui.add_folder("Exact, over the full range", expand_by_default=False):
            self.fields = {name: self.add_field(gui, name) for name in PARAMETERS}
        self.show(beam)

    def add_slider(self, gui: GuiApi, name: str) -> GuiSliderHandle[float]:
        """The slider."""
        parameter = PARAMETERS[name]
        low, high, step = parameter.slider
        label, hint = parameter.slider_label, parameter.hint
        slider = gui.add_slider(label, low, high, step, low, hint=hint)
        heard(slider, self.lock, partial(self.moved, name))
        return slider

    def add_field(self, gui: GuiApi, name: str) -> GuiNumberHandle[float]:
        """The field."""
        low, high = PARAMETERS[name].limits
        field = gui.add_number(name, low, min=low, max=high, step=PARAMETERS[name].slider[2])
        heard(field, self.lock, partial(self.typed, name))
        return field

    def show(self, beam: Beam) -> None:
        """Show another beam, in its units; mu is given with these."""
        with self.lock:
            self.measures = measures(beam.units)
            for name, value in beam.numbers.items():
                self.fit(name, value, beam.units is not None)
            self.sliders["mu"].visible = self.fields["mu"].visible = beam.units is None

    def fit(self, name: str, value: float, real: bool) -> None:
        """Label and range of a slider and its field, and the value in them. The slider covers
        four times the value of a real beam, and the full range where it must."""
        slider, field, measure = self.sliders[name], self.fields[name], self.measures[name]
        slider.label, field.label = measure.label, measure.field(PARAMETERS[name].label)
        field.precision = 8 if measure.unit == "" else 4
        field.min, field.max = (measure.factor * limit for limit in PARAMETERS[name].limits)
        low, high, step = PARAMETERS[name].slider
        if real and value > 0 and name in ("alpha", "gamma"):
            low, high, step = 0.0, 4 * value, value / 100
        if not low <= value <= high:
            low, high = PARAMETERS[name].limits
        slider.min, slider.max, slider.step = measure.range(
            low, high, step, PARAMETERS[name].limits
        )
        slider.precision = 4 if measure.unit == "" else places(slider.step)
        for control in (slider, field):
            assign(control, measure.factor * value)

    def put(self, name: str, value: float) -> None:
        """Set a number, dimensionless, as if it had been typed."""
        with self.lock:
            assign(self.fields[name], self.measures[name].factor * value)
            self.typed(name, self.measures[name].factor * value)

    def follow(self, name: str, value: float) -> None:
        """Show a number, dimensionless, that is set elsewhere."""
        for control in (self.sliders[name], self.fields[name]):
            assign(control, self.measures[name].factor * value)

    def moved(self, name: str, value: float) -> None:
        """A slider was moved."""
        self.listener.want(name, self.measures[name].plain(value))
        assign(self.fields[name], value)

    def typed(self, name: str, value: float) -> None:
        """A field was changed; the slider widens for a value beyond its everyday range."""
        self.listener.want(name, self.measures[name].plain(value))
        slider = self.sliders[name]
        if not slider.min <= value <= slider.max:
            slider.min, slider.max = (
                self.measures[name].factor * end for end in PARAMETERS[name].limits
            )
        assign(slider, value)


def heard(control: GuiInputHandle, lock: threading.RLock, take: Callable[[Any], None]) -> None:
    """Hand what a visitor sets a control to on to `take`.

    viser runs plain callbacks on many threads in no order, where a change could be overtaken by
    the one before it; asynchronous ones run one after the other, as the changes came. What the
    program itself sets (no client) is not a choice; it must not set back what the visitor has
    moved on from.
    """

    async def hear(event: GuiEvent) -> None:
        if event.client is not None:
            with lock:
                take(control.value)

    control.on_update(hear)
    stop_sync(control)


def assign(control: GuiInputHandle, value: Any) -> None:
    """Show a value in a control."""
    if not isinstance(value, float) or math.isfinite(value):
        set_value(control, value)
