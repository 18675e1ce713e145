"""The page around the scene, except the tabs: status, table of modes, controls, help."""

import math
import time
from collections.abc import Sequence
from functools import partial
from html import escape
from typing import Any

from beamviz.beam import NUMBERS, PARAMETERS, Units
from beamviz.drawing.text import Measure, measures
from beamviz.explorer.jobs import Job, Solved
from beamviz.explorer.page import html
from beamviz.explorer.page.html import button, checkbox, hint, select, slider
from beamviz.explorer.state import CHOICES, TERMS, Case, State
from beamviz.explorer.visitor import Visitor
from beamviz.scene import COLOURINGS, MAX_AMPLITUDE, MAX_PACE, MAX_SHARES, MODES

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
DIGITS = 8  # of a number in its field
FIRST_MASS = 1.0  # for a beam that never had one
PACE_HINT = "Speed of rotation and vibration on the screen, relative to a suitable one"
AMPLITUDE_HINT = "Largest displacement drawn, over the length of the beam"
MODEL = {
    "strain": "The relation of stretch and axial force; green is that of the paper",
    "curvature": "The measure of bending of a stretched beam; spatial is that of the paper",
    "state": "straight; bent: off its axis, as under spin-up; stable: straight if that is stable,"
    " else bent",
}
METHOD_HINT = "The method of solution; auto is exact to the error shown. It is chosen at the top."
PLANES = {"chordwise": "in plane (chordwise)", "flapwise": "out of plane (flapwise)"}
PICTURE = {
    "ghosts": ("undeformed beam", "The outline of the undeformed beam, and pale its equilibrium"),
    "nodes": ("nodes", "Points of the beam that a mode leaves at rest"),
    "thicken": ("draw thicker", "Draw a thin beam thicker than it is"),
}


# The fixed content of the page by element id: what Python's tables of choices and limits determine.
CONTENT = {
    "status": (
        '<select class="quiet" data-set="plane" aria-label="Plane of vibration">'
        f"{html.options(PLANES)}</select>"
        '<button type="button" class="quiet switch" data-set="coriolis" data-key="c"'
        ' title="Coriolis forces (C)">Coriolis</button>'
        '<select class="quiet" data-set="method" aria-label="Method">'
        f"{html.options(CHOICES['method'])}</select>"
        '<button type="button" class="quiet" id="units" data-point="real-beam">units</button>'
    ),
    "modes": html.HEADING,
    "motion": (
        slider("pace", "playback speed", PACE_HINT, min=0, max=MAX_PACE, step=0.05)
        + '<div id="pace-text" class="soft"></div>'
        + slider("amplitude", "amplitude", AMPLITUDE_HINT, min=0, max=MAX_AMPLITUDE, step=0.01)
    ),
    "picture": (
        select("colouring", "colour", COLOURINGS)
        + "".join(checkbox(key, label, text) for key, (label, text) in PICTURE.items())
        + button("Dark page", data_set="dark", data_key="d", title="Dark or light page (D)")
    ),
    "model": (
        "".join(select(name, name, CHOICES[name], text) for name, text in MODEL.items())
        + f'<p class="soft">Method {hint("the method", METHOD_HINT)}</p>'
    ),
}


def build(visitor: Visitor) -> None:
    """Fill the page of a visitor, except the tabs, and handle its actions."""
    page = visitor.page
    for id, content in CONTENT.items():
        page.html(id, content)
    BeamControls(visitor)
    for mode in range(MODES):
        edit = partial(State.share, mode=mode)
        visitor.bind(f"share-{mode}", edit, of="shares", shown=partial(share_of, mode))
    first = visitor.state.case
    visitor.render("case", lambda case: page.html("scene-caption", invitation(case, first)))
    visitor.render("dark", lambda dark: page.theme(dark=dark))
    page.on("only", partial(show_alone, visitor))
    page.on("undo", lambda _: visitor.restore(visitor.history.undo))
    page.on("redo", lambda _: visitor.restore(visitor.history.redo))
    page.on("reset", lambda _: visitor.reset())
    page.on("reset_view", lambda _: visitor.reset_view())
    page.on("cancel_jobs", lambda _: visitor.cancel_jobs())
    page.on("retry_jobs", lambda _: visitor.retry_jobs())


def show_alone(visitor: Visitor, mode: Any) -> None:
    """Show one mode (from 0) alone."""
    if mode in range(MAX_SHARES):
        visitor.change(partial(State.only, mode=int(mode)))


def add_commands(visitor: Visitor) -> None:
    """Add the commands of the page, except those that begin a lesson."""
    edits = {
        "Play or pause": partial(toggled, "playing"),
        "Coriolis forces on or off": partial(toggled, "coriolis"),
        "Dark or light page": partial(toggled, "dark"),
        **{f"Show mode {k + 1} alone": partial(State.only, mode=k) for k in range(MODES)},
        "Rotating frame": partial(State.changed, name="rotating_frame", value=True),
        "Stationary frame": partial(State.changed, name="rotating_frame", value=False),
    }
    for name, edit in edits.items():
        visitor.command(name, partial(visitor.change, edit))
    visitor.command("Reset the scene", visitor.reset)
    visitor.command("Fit the view", visitor.reset_view)


def show_answer(visitor: Visitor, solved: Solved | None, shown: list[int]) -> None:
    """Show the answer; if it has no solution, the faded modes of the last one."""
    page, answer = visitor.page, visitor.answer
    if answer:
        page.html("equilibrium", html.equilibrium_state(answer))
        page.html("mode-rows", html.mode_table(*solved, shown) if solved else html.NO_MODES)
        page.props("mode-rows", class_="faded" if solved and not answer.solution else None)


def work(jobs: Sequence[Job]) -> str:
    """The jobs that have been running for long, with a button that cancels them; or else those
    cancelled, with one that restarts them."""
    slow = [job for job in jobs if job.slow]
    names = ", ".join(job.name for job in slow or [job for job in jobs if job.cancelled])
    if slow:
        seconds = int(time.monotonic() - min(job.started for job in slow))
        percent = f" {100 * slow[0].done:.0f} %" if slow[0].done else ""
        state = f'computing: {names} <span aria-hidden="true">…{percent} {seconds} s</span>'
        return state + button("Cancel", data_do="cancel_jobs")
    return f"cancelled: {names}" + button("Compute again", data_do="retry_jobs") if names else ""


def invitation(case: Case, first: Case) -> str:
    """What can be dragged, the mass if there is one, and the speed; "" after the first edit."""
    mass = "the mass along the beam, or " if case.numbers["alpha"] else ""
    return f"Drag {mass}the line of the speed in the chart below." if case is first else ""


def share_of(mode: int, shares: Sequence[float]) -> float:
    return shares[mode] if mode < len(shares) else 0.0


def toggled(name: str, state: State) -> State:
    """With a switch toggled; a change of the equations keeps the case before for comparison."""
    state = state.keep_for_comparison() if name == "coriolis" else state
    return state.changed(name, not state.values[name])


# The beam


class BeamControls:
    """The numbers of the beam, each with a slider for its usual range and a field for its full
    range, in the units of the beam; and a switch for each term of the equations and for the mass.

    ranges: of the sliders, in the units shown; alpha: the mass that is restored.
    """

    def __init__(self, visitor: Visitor):
        self.visitor, self.page, self.alpha = visitor, visitor.page, FIRST_MASS
        self.ranges: dict[str, tuple[float, float]] = {}
        reset = button("Reset the scene", data_do="reset", data_key="r", title=RESET_HINT)
        more = f"<details><summary>Advanced</summary>{number_slider('spin_up')}</details>"
        self.page.html("beam", "".join(map(number_slider, PARAMETERS)) + more + reset)
        switches = (checkbox(key, label, help) for key, (label, help) in SWITCHES.items())
        self.page.html("effects", "".join(switches))
        self.measures = measures(visitor.state.case.units)
        visitor.render("scene", lambda _: self.choose_ranges(visitor.state))
        for name in NUMBERS:
            visitor.page.on(name, partial(self.edit, name))
            visitor.render(name, partial(self.show, name))
        for name in TERMS:
            visitor.bind(name, partial(switched, name))
        visitor.bind("mass", self.switch_mass, of="alpha", shown=bool)

    def edit(self, name: str, value: Any) -> None:
        number = self.measures[name].plain(value)
        self.visitor.change(lambda state: state.changed(name, number))

    def show(self, name: str, number: Any) -> None:
        """Show a number; a slider whose range does not contain it gets the full range."""
        if not is_finite(number):
            return
        if name == "alpha" and number > 0:
            self.alpha = number
        measure, (low, high) = self.measures[name], self.ranges[name]
        shown = float(f"{measure.factor * number:.{DIGITS}g}")
        if not low <= shown <= high:
            low, high = (measure.factor * limit for limit in NUMBERS[name].limits)
            self.page.props(f"{name}-slider", min=low, max=high)
        self.page.value(name, shown)

    def choose_ranges(self, state: State) -> None:
        """Choose labels and ranges for a scene that was loaded, and show its numbers."""
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
            self.show(name, number)
        self.page.props("mu-row", hidden=units is not None)
        self.page.html("units", "SI units" if units else "Real beam…")

    def switch_mass(self, state: State, on: Any) -> State:
        """Remove the mass, or restore its last value."""
        return switched("alpha", state, self.alpha if on else 0.0)


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
    return slider(name, parameter.slider_label, parameter.hint, min=low, max=high, step=step)


def switched(name: str, state: State, value: Any) -> State:
    """With a term switched, or another mass; the case before is kept for comparison."""
    return state.keep_for_comparison().changed(name, value)
