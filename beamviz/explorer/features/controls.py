"""The controls around the scene."""

import math
from dataclasses import replace
from functools import partial
from html import escape
from typing import Any

from beamviz.beam import NUMBERS, PARAMETERS, SECTION, Beam
from beamviz.drawing.text import measure
from beamviz.explorer import page
from beamviz.explorer.feature import Feature
from beamviz.explorer.page import Content
from beamviz.explorer.snapshot import Snapshot
from beamviz.explorer.state import CHOICES, RATES, Case, State
from beamviz.explorer.visitor import Visitor
from beamviz.scene import COLOURINGS, MAX_AMPLITUDE, MAX_PACE, MAX_SHARES, MODES
from beamviz.units import Units

PACE_HINT = "Speed of rotation and vibration on the screen, relative to a suitable one"
AMPLITUDE_HINT = "Largest displacement drawn, over the length of the beam"
MODEL = {
    "strain": "The relation of stretch and axial force; green is that of the paper",
    "curvature": "The measure of bending of a stretched beam; spatial is that of the paper",
    "state": "straight; bent: off its axis, as under spin-up; stable: straight if that is stable,"
    " else bent",
}
METHOD_HINT = "The method of solution; auto has converged to the error shown"
PLANES = {
    "chordwise": "in plane (chordwise)",
    "flapwise": "out of plane (flapwise)",
    "both": "both planes",
}
PICTURE = {
    "ghosts": ("undeformed beam", "The outline of the undeformed beam, and pale its equilibrium"),
    "nodes": ("nodes", "Points of the beam that a mode leaves at rest"),
    "tip_path": (
        "tip's path",
        "The curve that the free end runs through: a line in a mode, with Coriolis forces an"
        " ellipse; of several modes that of the last periods",
    ),
    "forces": (
        "forces",
        "The tension along the beam as a band, and what pulls and pushes on pieces of it as arrows",
    ),
    "thicken": ("draw thicker", "Draw a thin beam thicker than it is"),
}
CORIOLIS_HINT = (
    "Forces on parts that move within the rotating frame: they couple bending and stretching"
)
SWITCHES = {  # besides that of the Coriolis forces, which is in the head of the page
    "stiffening": (
        "stiffening",
        "Tension by the centrifugal force, as in a taut string: it raises bending frequencies",
    ),
    "softening": (
        "spin softening",
        "The centrifugal force grows with a displacement in the plane of rotation: it lowers the"
        " frequencies of motion in this plane",
    ),
    "mass": ("mass", "The concentrated mass; switched on again it has its last value"),
}
RESET_HINT = "Back to the scene as the page, a link, a file or the lesson opened it (R)"
MODES_HINT = (
    "The shapes of free vibration, each with its own frequency. Click one to see it alone; the"
    " sliders mix several. B: bending, S: stretching; in both planes F: flap, out of the plane of"
    " rotation, L: lag, in it. With all digits, the errors are estimates of the numerical error."
)
DIGITS_HINT = "All accurate digits, and the estimated error of each frequency"


ALIKE = "Pitch and twist have no effect: the section bends as easily in every direction"
REAL_ENDS = {"alpha": 2.0, "gamma": 12.0}  # of the sliders of real beams, which rotate slowly
ROUNDING = 1e-9


def number_slider(name: str) -> str:
    parameter = NUMBERS[name]
    low, high, step = parameter.slider
    return page.slider(name, parameter.slider_label, parameter.hint, min=low, max=high, step=step)


# The fixed content of the page by element id: what Python's tables of choices and limits determine.
CONTENT = {
    "status": (
        '<select class="quiet" data-set="plane" aria-label="Plane of vibration">'
        f"{page.options(PLANES)}</select>"
        '<button type="button" class="quiet switch" data-set="coriolis" data-key="c"'
        f' title="{CORIOLIS_HINT} (C)">Coriolis</button>'
        '<button type="button" class="quiet" id="units" data-point="real-beam">units</button>'
    ),
    "modes": (
        f'<div class="row"><h2>Natural modes</h2>{page.hint("natural modes", MODES_HINT)}'
        '<span class="space"></span>'
        + page.button("digits", id="digits", aria_pressed=False, class_="quiet", title=DIGITS_HINT)
        + page.button("All", data_set="all_modes", aria_label="All modes, one above the other")
        + '</div><div id="told" class="soft"></div><div id="mode-rows"></div>'
    ),
    "beam": (
        "".join(map(number_slider, (*PARAMETERS, *SECTION)))
        + '<div id="section-note"></div>'
        + f"<details><summary>Advanced</summary>{number_slider('spin_up')}</details>"
        + page.button("Reset the scene", data_do="reset", data_key="r", title=RESET_HINT)
    ),
    "playback": (
        page.slider("pace", "playback speed", PACE_HINT, min=0, max=MAX_PACE, step=0.05)
        + '<div id="pace-text" class="soft"></div>'
        + page.slider("amplitude", "amplitude", AMPLITUDE_HINT, min=0, max=MAX_AMPLITUDE, step=0.01)
        + '<div id="sound-row"></div>'  # see sound.py
    ),
    "picture": (
        page.select("colouring", "colour", COLOURINGS)
        + "".join(page.checkbox(key, label, text) for key, (label, text) in PICTURE.items())
        + page.button("Dark page", data_set="dark", data_key="d", title="Dark or light page (D)")
    ),
    "effects": "".join(page.checkbox(key, label, text) for key, (label, text) in SWITCHES.items()),
    "model": (
        page.select("method", "method", CHOICES["method"], METHOD_HINT)
        + "".join(page.select(name, name, CHOICES[name], text) for name, text in MODEL.items())
        + page.button("Compare the methods", data_panel="tab-methods")
    ),
}


def alone(mode: int, state: State) -> State:
    """With one mode (from 0) shown alone."""
    return state.only(mode)


def toggled(name: str, state: State) -> State:
    return state.changed(name, not state.values[name])


COMMANDS = {  # of the palette, besides those that begin a lesson
    "Play or pause": partial(toggled, "playing"),
    "Coriolis forces on or off": partial(toggled, "coriolis"),
    "Dark or light page": partial(toggled, "dark"),
    "Forces on or off": partial(toggled, "forces"),
    **{f"Show mode {k + 1} alone": partial(alone, k) for k in range(MODES)},
    "Rotating frame": partial(State.changed, name="rotating_frame", value=True),
    "Stationary frame": partial(State.changed, name="rotating_frame", value=False),
}


class Controls(Feature):
    """All controls except those of the tabs. Each number of the beam has a slider for its usual
    range and a field for its full range, in the units of the beam."""

    def __init__(self, visitor: Visitor):
        super().__init__(visitor)
        self.fixed = self.fixed_content()
        for name in NUMBERS:
            self.page.on(name, partial(self.edit, name), float)
        visitor.bind("mass", switch_mass, has_mass, bool)
        for mode in range(MODES):
            edit = partial(State.share, mode=mode)
            visitor.bind(f"share-{mode}", edit, partial(share_of, mode), float)
        self.page.on("only", self.show_alone, int)
        self.page.on("undo", lambda _: visitor.restore(visitor.history.undo))
        self.page.on("redo", lambda _: visitor.restore(visitor.history.redo))
        self.page.on("reset", lambda _: visitor.reset())
        self.page.on("forget_refused", lambda _: visitor.change(partial(replace, refused=None)))
        self.page.on("rate", self.lock, float | None)
        self.page.on("reset_view", lambda _: self.reset_view())
        self.page.on("tab", self.open_tab, str)
        self.page.on("preferences", self.take_preferences, str)
        self.page.on("cancel_jobs", lambda _: visitor.cancel_jobs())
        self.page.on("retry_jobs", lambda _: visitor.retry_jobs())
        for name, command in COMMANDS.items():
            visitor.command(name, partial(visitor.change, command))
        visitor.command("Reset the scene", visitor.reset)
        visitor.command("Fit the view", self.reset_view)

    def content(self, snapshot: Snapshot) -> Content:
        state = snapshot.state
        return (
            self.fixed
            | self.bound_content(state)
            | page.props("undo", disabled=not snapshot.undo)
            | page.props("redo", disabled=not snapshot.redo)
            | numbers_content(state.shown_case)
        )

    def fixed_content(self) -> Content:
        """What Python's tables of choices and limits determine."""
        follow = page.checkbox("following", "follow the presenter", FOLLOW_HINT)
        content = {("html", id): text for id, text in CONTENT.items()}
        shown = follow if self.visitor.may_follow else ""
        return content | page.html("presenter", PRESENTING if self.visitor.presents else shown)

    def bound_content(self, state: State) -> Content:
        """The values of all bound controls, the tab and the theme."""
        content = Content()
        for key, shown in self.visitor.controls.items():
            content |= page.value(key, shown(state))
        return content | {("open",): state.tab, ("dark",): state.view.dark}

    def edit(self, name: str, value: Any) -> None:
        """Set a number of the beam, as displayed."""
        self.visitor.change(partial(with_number, name=name, shown=value))

    def show_alone(self, mode: Any) -> None:
        """Show one mode (from 0) alone."""
        if mode in range(MAX_SHARES):
            self.visitor.change(partial(alone, int(mode)))

    def reset_view(self) -> None:
        self.visitor.change(partial(State.with_viewpoint, camera=None))

    def take_preferences(self, preferences: Any) -> None:
        self.visitor.update(lambda state: preferred(state, str(preferences)))

    def lock(self, rate: Any) -> None:
        """Lock the time [T*] that passes in a second on the screen, or let it suit the motion."""
        if rate is None or (isinstance(rate, float | int) and RATES[0] <= rate <= RATES[1]):
            self.visitor.change(partial(replace, rate=None if rate is None else float(rate)))

    def open_tab(self, tab: Any) -> None:
        """Store the open tab, which is no edit: it ends no presenter mode and cannot be undone."""
        if tab in self.visitor.tabs:
            self.visitor.update(lambda state: replace(state, tab=tab))


PRESENTING = '<span class="soft">You present: the others see this page.</span>'
FOLLOW_HINT = "Any control switches this off: you explore by yourself. Tick it to follow again"


def preferred(state: State, preferences: str) -> State:
    """With the preferences of the visitor's system: "dark" (the theme, unless the scene has its
    own) and "still" (reduced motion: paused, without transitions of the view)."""
    words = preferences.split()
    state = replace(state, still="still" in words)
    if state.still:
        state = state.changed("playing", False)
    return state if state.opened.view.dark else state.changed("dark", "dark" in words)


def numbers_content(case: Case) -> Content:
    """The numbers of the beam in its units, and the ranges of their sliders; of what is no number
    the nearest one."""
    units, content = case.units, page.props("mu-row", hidden=case.units is not None)
    in_space = case.options["plane"] == "both"
    for name in SECTION:
        of_blade = name == "flap" and case.blade is not None  # which has its own
        is_used = in_space or case.numbers[name] != getattr(Beam, name)
        content |= page.props(f"{name}-row", hidden=not is_used or of_blade)
    is_idle = in_space and case.nearest_beam().bends_alike
    reason = f'<p class="soft">{ALIKE}{" (κ = 1)" if case.blade is None else ""}.</p>'
    content |= page.html("section-note", reason if is_idle else "")
    for name, number in case.numbers.items():
        own = measure(name, units)
        content |= page.html(f"{name}-label", escape(own.label))
        content |= page.props(f"{name}-field", aria_label=own.label)
        content |= page.props(name, data_unit=own.unit)
        if not (isinstance(number, int | float) and math.isfinite(number)):
            number = getattr(case.nearest_beam(), name)
        low, high, step = slider_range(name, number, units)
        limits = {"min": low, "max": high, "step": step}
        content |= page.props(f"{name}-slider", **limits)
        content |= page.value(name, float(f"{own.factor * number:.8g}"))
    return content | page.html("units", "SI units" if units else "Real beam…")


def slider_range(name: str, number: float, units: Units | None) -> tuple[float, float, float]:
    """Ends and step of the slider of a number, as displayed: its usual range, or the full one if
    that lacks the number."""
    own, limits = measure(name, units), NUMBERS[name].limits
    low, high, step = NUMBERS[name].slider
    if units and name in REAL_ENDS:
        high, step = REAL_ENDS[name], REAL_ENDS[name] / 400
    low, high, step = own.range(low, high, step, limits)
    if not low <= own.factor * number <= high * (1 + ROUNDING):
        low, high = (own.factor * limit for limit in limits)
    return low, high, step


def with_number(state: State, name: str, shown: Any) -> State:
    """With another number of the beam, given in its units."""
    return state.changed(name, measure(name, state.case.units).plain(shown))


def switch_mass(state: State, on: Any) -> State:
    """Remove the mass, or restore its last value."""
    return state.keep_for_comparison().changed("alpha", state.last_alpha if on else 0.0)


def has_mass(state: State) -> bool:
    return bool(state.case.numbers["alpha"])


def share_of(mode: int, state: State) -> float:
    shares = state.view.shares
    return shares[mode] if mode < len(shares) else 0.0
