"""Hints in the scene at what is taken by the hand, one at a time, each until the visitor has taken
it once. Their browser keeps which they have."""

from collections.abc import Callable, Collection
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from beamviz.drawing.beam_mesh import to_hub_frame
from beamviz.drawing.modes import SampledModes
from beamviz.drawing.objects import Caption
from beamviz.explorer.computed_motion import can_move
from beamviz.explorer.declarations import choice
from beamviz.explorer.experiment import MotionState
from beamviz.explorer.feature import Feature
from beamviz.explorer.features.hub_turn import RIM, HubState, knob_place, wheel_radius
from beamviz.explorer.features.lessons import LessonState
from beamviz.explorer.page import Content
from beamviz.explorer.snapshot import Snapshot
from beamviz.explorer.state import Slice, State
from beamviz.explorer.view import SceneView
from beamviz.explorer.visitor import Visitor

ABOVE = np.array([0.0, 0.0, 0.07])  # [L] the tip
BELOW = np.array([0.0, 0.0, -0.3])  # [L] the wheel


class Hint(NamedTuple):
    """A hint. place: its point (3,) in the frame of the hub."""

    text: str
    anchor: str  # the side of the text at its point
    is_offered: Callable[[State], bool]
    is_taken: Callable[[State], bool]
    place: Callable[[SampledModes], np.ndarray]


def above_tip(shapes: SampledModes) -> np.ndarray:
    """A point (3,) above the tip of the beam at rest, which the text does not swing with."""
    points, _ = to_hub_frame(shapes, shapes.centreline)
    return np.asarray(points[-1]) + ABOVE


def below_wheel(shapes: SampledModes) -> np.ndarray:
    """A point (3,) below the wheel: on its axis, of a large one below its knob."""
    beam = shapes.beam
    is_small = 0 < wheel_radius(beam) <= RIM
    return BELOW if is_small else knob_place(beam) + BELOW / 2


HINTS = {  # by name, the first one first
    "pull": Hint(
        "pull the ball",
        "bottom",
        can_move,
        lambda state: state.slice(MotionState).hold is not None,
        above_tip,
    ),
    "turn": Hint(
        "turn the wheel ↔",
        "top",
        lambda state: True,
        lambda state: state.slice(HubState).hub_grip is not None,
        below_wheel,
    ),
}


@dataclass(frozen=True)
class HintState(Slice):
    """What the visitor has taken in the hand, by the names of the hints."""

    # None until the browser has told.
    used: frozenset[str] | None = field(default=None, metadata=choice(undo="keeps", led="keeps"))


class Hints(Feature):
    """captions: of the hints, by name."""

    state = HintState

    def __init__(self, visitor: Visitor):
        super().__init__(visitor)
        self.page.on("used", self.keep_used, str)

    def add_to(self, view: SceneView) -> None:
        self.captions = {
            name: Caption(view.graph, f"/scene/rotor/hint {name}", hint.anchor)
            for name, hint in HINTS.items()
        }
        view.hints += self.captions.values()

    def keep_used(self, names: Any) -> None:
        """Take what was taken in the same browser before."""
        self.visitor.update(partial(with_used, names=HINTS.keys() & str(names).split()))

    def react(self, snapshot: Snapshot, elapsed: float) -> None:
        """Remember what is taken."""
        used = snapshot.state.slice(HintState).used
        taken = {name for name, hint in HINTS.items() if hint.is_taken(snapshot.state)}
        if used is not None and taken - used:
            self.visitor.update(partial(with_used, names=taken))

    def move(self, snapshot: Snapshot) -> None:
        shown, modes = hint_of(snapshot), snapshot.picture.modes
        for name, caption in self.captions.items():
            caption.show(HINTS[name].text if name == shown else "", HINTS[name].place(modes))

    def content(self, snapshot: Snapshot) -> Content:
        used = snapshot.state.slice(HintState).used
        return {} if used is None else {("used",): sorted(used)}


def with_used(state: State, names: Collection[str]) -> State:
    """With the hints of these names used, too."""
    used = state.slice(HintState).used or frozenset()
    return state.with_values(HintState, used=used | {*names})


def hint_of(snapshot: Snapshot) -> str:
    """The name of the hint to show, "" for none: in lessons, which say what to do, in the scene of
    a presenter, in a motion, and where modes are drawn one above the other there is none."""
    state, picture = snapshot.state, snapshot.picture
    used = state.slice(HintState).used
    is_told = state.slice(LessonState).before_lesson is not None or snapshot.is_led
    is_busy = state.in_hand or is_told or picture.driven
    if used is None or is_busy or picture.drawn.in_rows or snapshot.solved is None:
        return ""
    left = (name for name, hint in HINTS.items() if name not in used and hint.is_offered(state))
    return next(left, "")
