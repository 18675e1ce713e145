"""The controls around the scene, and the mass in it, which is dragged."""

import math
from collections.abc import Mapping
from functools import partial
from html import escape
from typing import Any

import numpy as np
from viser import BatchedMeshHandle, SceneNodeDragEvent
from viser.transforms import SO3

from beamviz.beam import NUMBERS, PARAMETERS
from beamviz.drawing import BeamView
from beamviz.drawing.beam_mesh import to_hub_frame
from beamviz.drawing.text import Measure, measure
from beamviz.explorer import page
from beamviz.explorer.state import CHOICES, State
from beamviz.explorer.visitor import Feature, Visitor
from beamviz.scene import COLOURINGS, MAX_AMPLITUDE, MAX_PACE, MAX_SHARES, MODES

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
MODES_HINT = (
    "The shapes of free vibration, each with its own frequency. Click one to see it alone; the"
    " sliders mix several. B: bending, S: stretching. The errors are estimates of the numerical"
    " error."
)


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
        ' title="Coriolis forces (C)">Coriolis</button>'
        '<select class="quiet" data-set="method" aria-label="Method">'
        f"{page.options(CHOICES['method'])}</select>"
        '<button type="button" class="quiet" id="units" data-point="real-beam">units</button>'
    ),
    "modes": (
        f'<div class="row"><h2>Natural modes</h2>{page.hint("natural modes", MODES_HINT)}'
        '<span class="space"></span>'
        + page.button("All", data_set="all_modes", aria_label="All modes, one above the other")
        + '</div><div id="mode-rows"></div>'
    ),
    "beam": (
        "".join(map(number_slider, PARAMETERS))
        + f"<details><summary>Advanced</summary>{number_slider('spin_up')}</details>"
        + page.button("Reset the scene", data_do="reset", data_key="r", title=RESET_HINT)
    ),
    "motion": (
        page.slider("pace", "playback speed", PACE_HINT, min=0, max=MAX_PACE, step=0.05)
        + '<div id="pace-text" class="soft"></div>'
        + page.slider("amplitude", "amplitude", AMPLITUDE_HINT, min=0, max=MAX_AMPLITUDE, step=0.01)
    ),
    "picture": (
        page.select("colouring", "colour", COLOURINGS)
        + "".join(page.checkbox(key, label, text) for key, (label, text) in PICTURE.items())
        + page.button("Dark page", data_set="dark", data_key="d", title="Dark or light page (D)")
    ),
    "effects": "".join(page.checkbox(key, label, text) for key, (label, text) in SWITCHES.items()),
    "model": (
        "".join(page.select(name, name, CHOICES[name], text) for name, text in MODEL.items())
        + f'<p class="soft">Method {page.hint("the method", METHOD_HINT)}</p>'
    ),
}


def toggled(name: str, state: State) -> State:
    return state.changed(name, not state.values[name])


COMMANDS = {  # of the palette, besides those that begin a lesson
    "Play or pause": partial(toggled, "playing"),
    "Coriolis forces on or off": partial(toggled, "coriolis"),
    "Dark or light page": partial(toggled, "dark"),
    **{f"Show mode {k + 1} alone": partial(State.only, mode=k) for k in range(MODES)},
    "Rotating frame": partial(State.changed, name="rotating_frame", value=True),
    "Stationary frame": partial(State.changed, name="rotating_frame", value=False),
}


class Controls(Feature):
    """All controls except those of the tabs. Each number of the beam has a slider for its usual
    range and a field for its full range, in the units of the beam.

    ranges: of the sliders, in the units shown; alpha: the mass that is restored.
    """

    def __init__(self, visitor: Visitor):
        super().__init__(visitor)
        self.alpha = 1.0  # for a beam that never had a mass
        self.ranges: dict[str, tuple[float, float]] = {}
        for id, content in CONTENT.items():
            self.page.html(id, content)
        for name in NUMBERS:
            self.page.on(name, partial(self.edit, name))
        visitor.bind("mass", self.switch_mass, lambda values: bool(values["alpha"]))
        for mode in range(MODES):
            edit = partial(State.share, mode=mode)
            visitor.bind(f"share-{mode}", edit, partial(share_of, mode))
        self.page.on("only", self.show_alone)
        self.page.on("undo", lambda _: visitor.restore(visitor.history.undo))
        self.page.on("redo", lambda _: visitor.restore(visitor.history.redo))
        self.page.on("reset", lambda _: visitor.reset())
        self.page.on("reset_view", lambda _: visitor.reset_view())
        self.page.on("cancel_jobs", lambda _: visitor.cancel_jobs())
        self.page.on("retry_jobs", lambda _: visitor.retry_jobs())
        for name, command in COMMANDS.items():
            visitor.command(name, partial(visitor.change, command))
        visitor.command("Reset the scene", visitor.reset)
        visitor.command("Fit the view", visitor.reset_view)

    def edit(self, name: str, value: Any) -> None:
        number = measure(name, self.visitor.state.case.units).plain(value)
        self.visitor.change(lambda state: state.changed(name, number))

    def show(self) -> None:
        """Show the numbers; a slider gets the full range if the usual one lacks its number."""
        state, units = self.visitor.state, self.visitor.state.case.units
        is_new = self.redraws(state.scene)
        for name, number in state.case.numbers.items():
            own = measure(name, units)
            is_known = isinstance(number, int | float) and math.isfinite(number)
            if is_new:
                self.choose_range(name, own, number if is_known and units else 0.0)
            if not is_known:
                continue
            if name == "alpha" and number > 0:
                self.alpha = number
            shown, (low, high) = float(f"{own.factor * number:.8g}"), self.ranges[name]
            if not low <= shown <= high:
                low, high = (own.factor * limit for limit in NUMBERS[name].limits)
                self.page.props(f"{name}-slider", min=low, max=high)
            self.page.value(name, shown)
        self.page.props("mu-row", hidden=units is not None)
        self.page.html("units", "SI units" if units else "Real beam…")

    def choose_range(self, name: str, own: Measure, real: float) -> None:
        """Choose the label and the usual range of a number, four times the value of a real beam."""
        low, high, step = NUMBERS[name].slider
        if real > 0 and name in ("alpha", "gamma"):
            low, high, step = 0.0, 4 * real, real / 100
        low, high, step = own.range(low, high, step, NUMBERS[name].limits)
        self.ranges[name] = low, high
        self.page.props(f"{name}-slider", min=low, max=high, step=step, data_unit=own.unit)
        self.page.props(f"{name}-field", aria_label=own.label)
        self.page.html(f"{name}-label", escape(own.label))

    def show_alone(self, mode: Any) -> None:
        """Show one mode (from 0) alone."""
        if mode in range(MAX_SHARES):
            self.visitor.change(partial(State.only, mode=int(mode)))

    def switch_mass(self, state: State, on: Any) -> State:
        """Remove the mass, or restore its last value."""
        return state.keep_for_comparison().changed("alpha", self.alpha if on else 0.0)


def share_of(mode: int, values: Mapping[str, Any]) -> float:
    shares = values["shares"]
    return shares[mode] if mode < len(shares) else 0.0


# The mass in the scene

BETA_DIGITS = 3  # of beta: finer than a pointer
COORDINATES = np.linspace(0.0, 1.0, 2001)  # of points of the beam that may be under the pointer
SETTLED = 0.002  # change of beta below which the mass is under the pointer
PARALLEL = 0.03  # sine of the angle between view and beam below which no position is defined

Ray = tuple[np.ndarray, np.ndarray]  # a line of sight in the hub's frame: the eye, another point


class MassDrag:
    """Sets beta while the mass is dragged; meanwhile the clock stops and the scene keeps its place.

    offset: distance [beam lengths] from the centre of the mass to the point where it was picked up;
    sight: the line of sight that the mass is moved to, None once it is drawn there; case: the case
    with the mass at that position.
    """

    def __init__(self, visitor: Visitor, view: BeamView):
        self.visitor, self.view = visitor, view
        self.offset, self.case = 0.0, visitor.state.case
        self.sight: Ray | None = None
        view.mass.on_drag(self.dragged)
        view.mass.on_click(self.clicked)

    async def clicked(self, event: object) -> None:
        """Do nothing; with a handler, viser outlines the mass under the pointer."""

    async def dragged(self, event: SceneNodeDragEvent[BatchedMeshHandle]) -> None:
        """Handle a step of a drag, on the event loop, so that steps are handled in order."""
        visitor = self.visitor
        if event.phase == "end":
            visitor.dragging = False
            visitor.wake()
            return
        sight = self.line_of_sight(np.asarray(event.end_position, float))
        x = self.nearest_coordinate(sight)
        if x is None:
            return
        if not visitor.dragging:
            self.offset = x - self.view.shapes.beam.beta
            self.view.fixed = visitor.dragging = True
            visitor.change(State.keep_for_comparison)
        self.sight = sight
        self.move(x)

    def move(self, x: float) -> None:
        """Move the mass so that the point where it was picked up is at the coordinate x."""
        beta = min(max(round(x - self.offset, BETA_DIGITS), 0.0), 1.0)
        self.visitor.change(lambda state: state.changed("beta", beta))
        self.case = self.visitor.state.case

    def update(self) -> None:
        """Move the mass under the pointer again if the shape of the beam has changed since, unless
        something else was edited; after the drag, move the scene to its usual position."""
        visitor, case = self.visitor, self.visitor.state.case
        if self.sight is None:
            return
        if case is self.case:
            if visitor.answer is None or visitor.answer.request != case:
                return
            x = self.nearest_coordinate(self.sight)
            if x is not None and abs(x - self.offset - case.numbers["beta"]) > SETTLED:
                self.move(x)
                return
        if not visitor.dragging:
            self.sight, self.view.fixed = None, False
            before = np.array(self.view.frame.position)
            self.view.choose_frame(self.view.share)
            visitor.camera.follow(self.view.frame.position - before, self.view.share)

    def line_of_sight(self, point: np.ndarray) -> Ray:
        """The present line of sight through a point (3,) of the scene."""
        turn_back = SO3(np.array(self.view.rotor.wxyz)).inverse()
        eye, middle = np.array(self.visitor.client.camera.position), self.view.frame.position
        return turn_back.apply(eye - middle), turn_back.apply(point - middle)

    def nearest_coordinate(self, sight: Ray) -> float | None:
        """The reference coordinate of the point of the beam, straight or bent, that is nearest to a
        line of sight; None where that is not defined."""
        shapes = self.view.shapes
        points, _ = to_hub_frame(shapes, shapes.centreline)
        return nearest(points, shapes.x, *sight)


def nearest(points: np.ndarray, x: np.ndarray, eye: np.ndarray, at: np.ndarray) -> float | None:
    """The coordinate, x (n,) at `points` (n, 3), of the point of a line that is nearest to the line
    of sight from `eye` through `at`; None for a line seen end on and for non-finite numbers."""
    sight = at - eye
    length = float(np.linalg.norm(sight))
    if not (np.isfinite(length) and length > 0):
        return None
    sight = sight / length
    line = np.column_stack([np.interp(COORDINATES, x, column) for column in points.T]) - eye
    seen = line - np.outer(line @ sight, sight)  # projected along the line of sight
    size, seen_size = (np.linalg.norm(np.diff(one, axis=0), axis=1).sum() for one in (line, seen))
    if seen_size < PARALLEL * size:
        return None
    return float(COORDINATES[np.linalg.norm(seen, axis=1).argmin()])
