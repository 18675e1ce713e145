"""The five numbers, a slider and a field for each, and how a visitor's choices are heard."""

import math
import threading
from collections.abc import Callable
from functools import partial
from typing import Any, Protocol

from viser import GuiApi, GuiEvent, GuiInputHandle, GuiNumberHandle, GuiSliderHandle

from beamviz.beam import LIMITS, NAMES

# For each number: label, everyday range and step of its slider, what it means.
NUMBERS = {
    "alpha": ("mass α", 0.0, 5.0, 0.01, "Mass on the beam, over the mass of the beam itself"),
    "beta": ("position β", 0.0, 1.0, 0.005, "Where that mass sits: 0 at the hub, 1 at the tip"),
    "gamma": ("speed γ", 0.0, 50.0, 0.1, "Speed of rotation, in radians per T*"),
    "delta": ("hub δ", -1.0, 3.0, 0.01, "Radius of the hub, over the length of the beam;"
              " below 0 the beam points inward from the rim"),
    "mu": ("slenderness μ", 10.0, 200.0, 1.0, "√12 times the length over the thickness;"
           " a large one makes stretching stiff"),
}  # fmt: skip


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

    def reset_view(self) -> None:
        """The camera back to where it was."""

    def darken(self, dark: bool) -> None:
        """A dark or a light page."""

    def sweep(self, over: str) -> None:
        """The number the loci chart runs over."""

    def show_per_rev(self, shown: bool) -> None:
        """Per-rev lines in the loci chart."""

    def meet(self, number: int) -> None:
        """A meeting (from 0) of the loci chart."""


class Numbers:
    """The five numbers, each with a slider for its everyday range and a field for all of it."""

    def __init__(
        self,
        gui: GuiApi,
        numbers: dict[str, float],
        listener: Listener,
        lock: threading.RLock,
    ):
        self.listener, self.lock = listener, lock
        self.sliders = {name: self.add_slider(gui, name, numbers[name]) for name in NUMBERS}
        with gui.add_folder("Exact, over the full range", expand_by_default=False):
            self.fields = {name: self.add_field(gui, name, numbers[name]) for name in NUMBERS}

    def add_slider(self, gui: GuiApi, name: str, value: float) -> GuiSliderHandle[float]:
        """The slider; it covers the full range where the value lies outside the everyday one."""
        label, low, high, step, hint = NUMBERS[name]
        if not low <= value <= high:
            low, high = LIMITS[name]
        slider = gui.add_slider(label, low, high, step, value, hint=hint)
        slider.precision = 4
        heard(slider, self.lock, partial(self.moved, name))
        return slider

    def add_field(self, gui: GuiApi, name: str, value: float) -> GuiNumberHandle[float]:
        """The field."""
        low, high = LIMITS[name]
        label = f"{NUMBERS[name][0][-1]} {NAMES[name]}"
        field = gui.add_number(label, value, min=low, max=high, step=NUMBERS[name][3])
        field.precision = 8
        heard(field, self.lock, partial(self.typed, name))
        return field

    def put(self, name: str, value: float) -> None:
        """Set a number as if it had been typed."""
        with self.lock:
            assign(self.fields[name], value)
            self.typed(name, value)

    def moved(self, name: str, value: float) -> None:
        """A slider was moved."""
        self.listener.want(name, value)
        assign(self.fields[name], value)

    def typed(self, name: str, value: float) -> None:
        """A field was changed; the slider widens for a value beyond its everyday range."""
        self.listener.want(name, value)
        slider = self.sliders[name]
        if not slider.min <= value <= slider.max:
            slider.min, slider.max = LIMITS[name]
        assign(slider, value)


def heard(control: GuiInputHandle, lock: threading.RLock, take: Callable[[Any], None]) -> None:
    """Hand what a visitor sets a control to on to `take`.

    Callbacks run on many threads in no order, so the value is read under the lock: whichever
    comes last reads the latest. What the program itself sets (no client) is not a choice; it
    must not set back what the visitor has moved on from.
    """

    def hear(event: GuiEvent) -> None:
        if event.client is not None:
            with lock:
                take(control.value)

    control.on_update(hear)


def assign(control: GuiInputHandle, value: float) -> None:
    """Show a number in a control."""
    if math.isfinite(value):
        control.value = value  # type: ignore[misc]  # viser puts a method before the setter
