"""Switches for the terms of the equations, to see which of them bends which locus."""

import threading
from functools import partial
from typing import Any

from viser import GuiApi, GuiCheckboxHandle

from beamviz.explorer.page.inputs import Listener, Numbers, heard
from beamviz.explorer.request import Wanted

TERMS = {
    "stiffening": (
        "stiffening",
        "The tension in a turning beam pulls it straight, as in a string: bending gets faster",
    ),
    "softening": (
        "spin softening",
        "What is displaced outwards is pulled outwards more: motion in the plane of rotation"
        " gets slower",
    ),
    "coriolis": (
        "Coriolis",
        "The force on what moves along a turning beam; it couples bending and stretching",
    ),
}
MASS = "The concentrated mass; switched on again it is what it was"
FIRST_MASS = 1.0  # for a beam that never had one


class Terms:
    """A box for each term, and one for the mass."""

    def __init__(
        self,
        gui: GuiApi,
        wanted: Wanted,
        numbers: Numbers,
        listener: Listener,
        lock: threading.RLock,
    ):
        self.numbers, self.listener = numbers, listener
        self.alpha = wanted.numbers["alpha"]
        self.boxes = {
            name: gui.add_checkbox(label, wanted.switched_on(name), hint=hint)
            for name, (label, hint) in TERMS.items()
        }
        for name, box in self.boxes.items():
            heard(box, lock, partial(self.switch, name))
        self.mass = gui.add_checkbox("mass", self.alpha > 0, hint=MASS)
        heard(self.mass, lock, self.switch_mass)

    def switch(self, name: str, on: Any) -> None:
        """Switch a term; how the beam was stays to be seen."""
        self.listener.remember()
        self.listener.want(name, on)

    def switch_mass(self, on: Any) -> None:
        """Take the mass off, or put it back."""
        self.listener.remember()
        self.numbers.put("alpha", (self.alpha or FIRST_MASS) if on else 0.0)

    def show(self, wanted: Wanted) -> None:
        """Follow what is wanted."""
        alpha: Any = wanted.numbers["alpha"]
        if isinstance(alpha, int | float) and alpha > 0:
            self.alpha = alpha
        put(self.mass, alpha != 0)
        for name, box in self.boxes.items():
            put(box, wanted.switched_on(name))


def put(box: GuiCheckboxHandle, on: bool) -> None:
    """Show a switch as it is."""
    if box.value != on:
        box.value = on  # type: ignore[misc]  # as in sliders.assign
