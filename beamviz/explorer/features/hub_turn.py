"""The wheel on the hub, by which the visitor turns it: to the right faster, to the left slower."""

import math
from dataclasses import dataclass, field, replace
from functools import partial
from typing import NamedTuple

import numpy as np
import trimesh
from viser import BatchedMeshHandle, SceneNodeDragEvent

from beamviz.beam import Beam
from beamviz.drawing import colours
from beamviz.drawing.beam_mesh import NORMALS, segments
from beamviz.drawing.objects import add_instances
from beamviz.drawing.scene_graph import Node
from beamviz.drawing.surroundings import (
    HOOP,
    HOOP_HEIGHT,
    HUB_HEIGHT,
    direction,
    hub_radius,
)
from beamviz.drawing.text import measure
from beamviz.explorer.declarations import choice
from beamviz.explorer.feature import Feature
from beamviz.explorer.features.controls import slider_range
from beamviz.explorer.snapshot import Inputs, Snapshot
from beamviz.explorer.state import Case, Slice, State
from beamviz.explorer.view import Picture, SceneView

REACH = 1.5  # [L] across the screen, for the whole range of the slider of the speed
RIM = 0.095  # [L] least radius of the wheel: of a small hub it stands out
BAR = 0.018  # [L] diameter of its bars
KNOB = 0.027  # [L] radius
WHOLE = 0.2  # [L] largest radius of a whole wheel; of a larger hub it is a part of the rim
PART = 0.4  # [L] of the rim, around the knob
KNOB_PLACE = (2.1, 0.25)  # from the clamp: angle [rad] and distance along the rim [L], the smaller
HANDLE = (0.12, 0.08)  # [L] width and height of what takes the pointer, wide enough for a finger
PIECES = 60  # of the rim
SPOKES = 2


class HubGrip(NamedTuple):
    """The wheel in the hand, as it was taken."""

    gamma: float
    across: float  # place of the pointer across the screen [L]


@dataclass(frozen=True)
class HubState(Slice):
    """The hub in the hand. The beam's frame keeps its place in the scene meanwhile."""

    hub_grip: HubGrip | None = field(
        default=None, metadata=choice(undo="ends", led="ends", until=("viewpoint",))
    )

    @property
    def in_hand(self) -> bool:
        return self.hub_grip is not None


def with_grip(state: State, grip: HubGrip | None) -> State:
    return state.with_values(HubState, hub_grip=grip)


def grip_of(state: State) -> HubGrip | None:
    return state.slice(HubState).hub_grip


class HubTurn(Feature):
    """Sets the speed while the wheel is dragged. What is known of the drag is the `hub_grip` of the
    state.

    wheel: its rim and its spokes; knob: on the rim; handle: invisible boxes around the wheel that
    take the pointer; radius: [L] of the wheel as drawn last; rate: time [T*] per second on the
    screen at which modes were played last, None for another motion.
    """

    state = HubState

    def add_to(self, view: SceneView) -> None:
        self.scene, self.radius = view, math.nan
        self.rate: float | None = None
        bar = trimesh.creation.cylinder(0.5, 1.0, sections=16)
        bar.vertices = bar.vertices[:, [2, 0, 1]]
        ball, box = trimesh.creation.icosphere(subdivisions=3), trimesh.creation.box()
        bars, root = PIECES + SPOKES, "/scene/rotor/wheel"
        self.wheel = add_instances(view.graph, root, bar, bars)
        self.knob = add_instances(view.graph, f"{root}/knob", ball)
        self.handle = add_instances(view.graph, f"{root}/handle", box, bars, opacity=0.0)
        self.handle.on_drag(self.dragged)
        self.wheel.visible = self.handle.visible = False

    def move(self, snapshot: Snapshot) -> None:
        """Put the wheel on the hub of a beam that is drawn alone."""
        picture = snapshot.picture
        self.rate = None if picture.driven else snapshot.rate
        visible = not picture.drawn.in_rows
        if self.wheel.visible != visible:
            self.wheel.visible = self.handle.visible = visible
        if visible and wheel_radius(beam := picture.drawn.shapes.beam) != self.radius:
            self.radius = wheel_radius(beam)
            self.place(beam)

    def place(self, beam: Beam) -> None:
        """Put the wheel on the hub of a beam."""
        self.put(self.wheel, *bars(beam, (BAR, BAR)))
        self.put(self.handle, *bars(beam, HANDLE))
        centre, sizes = knob_place(beam), np.full((1, 3), KNOB)
        self.put(self.knob, centre[None], np.array([[1.0, 0.0, 0.0, 0.0]]), sizes)

    def put(self, node: Node, centres: np.ndarray, wxyz: np.ndarray, sizes: np.ndarray) -> None:
        """Place instances (n), in the colour of what is taken by the hand."""
        placed = {"batched_positions": centres, "batched_wxyzs": wxyz, "batched_scales": sizes}
        colour = colours.instanced(np.tile(colours.GRIP, (len(centres), 1)))
        self.scene.graph.set_properties(node, **placed, batched_colors=colour)

    async def dragged(self, event: SceneNodeDragEvent[BatchedMeshHandle]) -> None:
        """Handle a step of a drag, on the event loop, so that steps are handled in order."""
        visitor, grip = self.visitor, grip_of(self.visitor.state)
        if event.phase == "end":
            if grip:
                visitor.update(partial(with_grip, grip=None))
            return
        across = self.scene.across(np.asarray(event.end_position, float))
        if across is None:
            return
        if grip is None:
            gamma = visitor.state.case.nearest_beam().gamma
            grip = HubGrip(gamma, across)
        visitor.change(partial(turned, grip=grip, across=across, rate=self.rate))

    def picture(self, inputs: Inputs, picture: Picture) -> Picture:
        return replace(picture, held=True) if grip_of(inputs.state) else picture


def turned(state: State, grip: HubGrip, across: float, rate: float | None) -> State:
    """With the wheel in the hand, and the speed for the place of the pointer [L] across the screen.
    The rate [T*/s] at which modes are played is kept then: a hub that is faster turns faster in the
    picture."""
    state, gamma = with_grip(state, grip), turned_speed(state.case, grip, across)
    if gamma == state.case.numbers["gamma"]:
        return state
    return replace(state.changed("gamma", gamma), rate=state.rate or rate)


def turned_speed(case: Case, grip: HubGrip, across: float) -> float:
    """The speed for a place of the pointer [L] across the screen, by steps of its slider and within
    its range."""
    shown = measure("gamma", case.units)
    low, high, step = slider_range("gamma", grip.gamma, case.units)
    steps = round((high - low) * (across - grip.across) / REACH / step)
    if steps == 0:
        return grip.gamma
    speed = min(max(shown.factor * grip.gamma + steps * step, low), high)
    return float(shown.plain(float(f"{speed:.8g}")))


# The shape of the wheel, in the frame of the hub


def wheel_radius(beam: Beam) -> float:
    """The radius [L] of the wheel; negative for an inward beam, whose hub is a ring."""
    if beam.delta < 0:
        return -(hub_radius(beam) + HOOP / 2)
    return max(hub_radius(beam), RIM)


def wheel_height(beam: Beam) -> float:
    """The height [L] of its middle above the plane of rotation."""
    return (HOOP_HEIGHT if beam.delta < 0 else HUB_HEIGHT) / 2 + BAR / 2


def bars(beam: Beam, size: tuple[float, float]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Centres (n, 3), orientations wxyz (n, 4) and sizes (n, 3) of the bars of the wheel, with a
    width and a height [L]: the pieces of the rim and the spokes, of which a part has none."""
    radius, height = wheel_radius(beam), wheel_height(beam)
    is_whole = 0 < radius <= WHOLE
    half = np.pi if is_whole else min(PART / abs(radius), 2 * np.pi) / 2  # [rad]
    rim = np.full((PIECES + 1, 3), height)
    rim[:, :2] = radius * direction(knob_angle(radius) + np.linspace(-half, half, PIECES + 1))
    parts = [segments(rim, NORMALS["chordwise"], size)]
    for angle in np.pi * (np.arange(SPOKES) + 0.5) / SPOKES:
        end = np.append(radius * direction(angle), 0.0)
        ends = np.stack([-end, end]) + [0.0, 0.0, height]
        centres, wxyz, sizes = segments(ends, NORMALS["chordwise"], size)
        parts.append((centres, wxyz, sizes * is_whole))
    centres, wxyz, sizes = (np.concatenate(each) for each in zip(*parts, strict=True))
    return centres, wxyz, sizes


def knob_angle(radius: float) -> float:
    """The angle [rad] of the knob: near the clamp, where a large hub is in view, and in front."""
    angle, distance = KNOB_PLACE
    return math.copysign(min(angle, distance / abs(radius)), -radius)


def knob_place(beam: Beam) -> np.ndarray:
    """The centre (3,) of the knob on the rim."""
    radius = wheel_radius(beam)
    return np.append(radius * direction(knob_angle(radius)), wheel_height(beam) + KNOB)
