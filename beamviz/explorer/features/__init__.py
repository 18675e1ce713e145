"""Features of the page, one module each; in this one those without a tab: presenter mode, in which
visitors see the presenter's scene, the controls of the numbers of the beam, and dragging its mass
along it with the pointer."""

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from html import escape
from typing import Any

import numpy as np
from viser import BatchedMeshHandle, SceneNodeDragEvent
from viser.transforms import SO3

from beamviz.beam import NUMBERS, PARAMETERS, Units
from beamviz.drawing import BeamView
from beamviz.drawing.beam_mesh import to_hub_frame
from beamviz.drawing.text import Measure, measures
from beamviz.explorer import page
from beamviz.explorer.state import TERMS, State
from beamviz.explorer.visitor import Feature, Visitor

# Presenter mode

FOLLOW_LABEL = "follow the presenter"
FOLLOW_HINT = "Any control switches this off: you explore by yourself. Tick it to follow again"


class PresenterMode(Feature):
    """Shows a visitor the presenter's page while they follow; nothing is computed for it then.

    presenter: returns the presenter, None while there is none; itself None without a lecture; tab:
    the one that the presenter had open last, while visitors may open another.
    """

    def __init__(self, visitor: Visitor, presenter: Callable[[], Visitor | None] | None):
        super().__init__(visitor)
        self.presenter, self.tab = presenter, visitor.state.tab
        if presenter:
            self.page.html("presenter", page.checkbox("following", FOLLOW_LABEL, FOLLOW_HINT))
            visitor.bind("following")

    @property
    def followed(self) -> Visitor | None:
        """The presenter, while they are followed."""
        return self.presenter() if self.presenter and self.visitor.state.following else None

    @property
    def inputs(self) -> tuple[object, ...]:
        other = self.followed
        return (other.state, *(job.answer for job in other.jobs)) if other else ()

    def show(self) -> None:
        """Copy the answers and the state of the presenter, without the viewpoint."""
        own, other = self.visitor, self.followed
        for k, job in enumerate(own.jobs):
            job.follow(other.jobs[k] if other else None)
        if other is None:
            return
        with own.lock:
            state = replace(other.state, camera=own.state.camera, following=True)
            if self.tab == state.tab:
                state = replace(state, tab=own.state.tab)
            self.tab = other.state.tab
            if state != own.state:
                own.set_state(state)

    def update_clock(self) -> None:
        if (other := self.followed) and len(self.visitor.clock.phases) == len(other.clock.phases):
            clock, theirs = self.visitor.clock, other.clock
            clock.phases, clock.angle, clock.rate = theirs.phases, theirs.angle, theirs.rate


# The numbers of the beam

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


class BeamControls:
    """The numbers of the beam, each with a slider for its usual range and a field for its full
    range, in the units of the beam; and a switch for each term of the equations and for the mass.

    ranges: of the sliders, in the units shown; alpha: the mass that is restored.
    """

    def __init__(self, visitor: Visitor):
        self.visitor, self.page, self.alpha = visitor, visitor.page, FIRST_MASS
        self.ranges: dict[str, tuple[float, float]] = {}
        reset = page.button("Reset the scene", data_do="reset", data_key="r", title=RESET_HINT)
        more = f"<details><summary>Advanced</summary>{number_slider('spin_up')}</details>"
        sliders = "".join(number_slider(name) for name in PARAMETERS)
        self.page.html("beam", sliders + more + reset)
        switches = (page.checkbox(key, label, help) for key, (label, help) in SWITCHES.items())
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
        shown = float(f"{measure.factor * number:.{FIELD_DIGITS}g}")
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
    return page.slider(name, parameter.slider_label, parameter.hint, min=low, max=high, step=step)


def switched(name: str, state: State, value: Any) -> State:
    """With a term switched, or another mass; the case before is kept for comparison."""
    return state.keep_for_comparison().changed(name, value)


# Dragging the mass

DIGITS = 3  # of beta: finer than a pointer
SETTLED = 0.002  # change of beta below which the mass is under the pointer
PARALLEL = 0.03  # sine of the angle between view and beam below which no position is defined
TINY = 1e-300


Ray = tuple[np.ndarray, np.ndarray]  # a line of sight in the hub's frame: the eye, another point


class MassDrag:
    """Sets beta while the mass is dragged. During a drag the clock is stopped and the scene keeps
    its position.

    offset: distance [beam lengths] from the centre of the mass to the point where it was picked up;
    sight: the line of sight that the mass is moved to, None after the beam has been drawn with the
    mass there; case: the case with the mass at that position.
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
        begins = not visitor.dragging
        if begins:
            self.offset = x - self.view.shapes.beam.beta
            self.view.fixed = visitor.dragging = True
        self.sight = sight
        self.move(x, begins=begins)

    def move(self, x: float, *, begins: bool) -> None:
        """Move the mass so that the point where it was picked up is at the coordinate x; `begins`:
        of a drag, which keeps the case before for comparison."""
        beta = min(max(round(x - self.offset, DIGITS), 0.0), 1.0)

        def moved(state: State) -> State:
            return (state.keep_for_comparison() if begins else state).changed("beta", beta)

        self.visitor.change(moved)
        self.case = self.visitor.state.case

    @property
    def outdated(self) -> bool:
        """Whether the drag has ended, and the scene still keeps its position."""
        return self.sight is not None and not self.visitor.dragging

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
                self.move(x, begins=False)
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
    seen = points - eye
    seen = seen - np.outer(seen @ sight, sight)  # projected along the line of sight
    steps = np.diff(seen, axis=0)
    sizes = (steps**2).sum(axis=1)
    if np.sqrt(sizes).sum() < PARALLEL * np.linalg.norm(np.diff(points, axis=0), axis=1).sum():
        return None
    share = np.clip(-(seen[:-1] * steps).sum(axis=1) / np.maximum(sizes, TINY), 0.0, 1.0)
    k = int(np.argmin(((seen[:-1] + share[:, None] * steps) ** 2).sum(axis=1)))
    return float(x[k] + share[k] * (x[k + 1] - x[k]))
