"""The beam in the scene, which the visitor pulls aside and lets go: by the ball at its tip or by
keys, and at any place while the tab Motion is open or a motion is played."""

import itertools
import math
from dataclasses import replace
from functools import partial

import numpy as np
import trimesh
from viser import BatchedMeshHandle, SceneNodeDragEvent

from beamviz.drawing import colours
from beamviz.drawing.beam_mesh import NORMALS, segments
from beamviz.drawing.objects import add_instances
from beamviz.errors import InvalidInput
from beamviz.explorer import page
from beamviz.explorer.computed_motion import PULL_JOB, PullRequest, can_move
from beamviz.explorer.experiment import RANGES, Hold, MotionState, with_hold
from beamviz.explorer.feature import Feature
from beamviz.explorer.features.mass_drag import nearest
from beamviz.explorer.features.motion import MotionTab, begun
from beamviz.explorer.page import Content
from beamviz.explorer.snapshot import Snapshot
from beamviz.explorer.state import Ray, State
from beamviz.explorer.view import SceneView
from beamviz.explorer.visitor import Visitor

LEAST_PLACE = 0.1  # of the beam, at which it can be pulled
TIP = 0.93  # from which on it is pulled at its tip
LARGEST = 0.6  # [L] deflection
FLAT = 0.03  # sine of the angle between view and plane of rotation below which no point is defined
DIGITS = 3  # of a place or a force
PIECES = 12  # of the sleeve
SLEEVE = 0.1  # [L] its width, wide enough for a finger
BALL = 0.036  # [L] radius of the ball at the tip, seen beside a usual section
LEAST_PULL = 0.005  # [L] a smaller deflection is a click
KEY_STEP = 0.02  # [L] of the deflection by an arrow key
NUMBERS = itertools.count(1)  # of the pulls of all visitors
# The ball for keys: page.js sends `let_go`, true for Enter, false for Escape and on leaving it.
BY_KEYS = (
    '<label for="pull-slider">Pull the tip of the beam</label><input type="range"'
    + page.attributes(
        id="pull-slider",
        data_set="pull_tip",
        data_unit="of the length",
        min=-LARGEST,
        max=LARGEST,
        step=KEY_STEP,
        aria_describedby="pull-keys",
    )
    + '><div id="pull-keys" class="soft">← → pull it aside, Enter lets go, Esc puts it back</div>'
)


class BeamPull(Feature):
    """Holds the beam under the pointer. What is known of it is the `hold` of `MotionState`.

    ball: at the tip, seen wherever the beam can be pulled; sleeve: invisible boxes around the beam,
    always as many, that take the pointer: a drag of the beam itself would end whenever it is drawn
    in another number of pieces. All are of no size but the last, which is the ball's, where the
    beam is pulled at its tip alone, so that bodies are slid and elsewhere the view is turned.
    """

    style = "beam_pull.css"

    def __init__(self, visitor: Visitor):
        super().__init__(visitor)
        visitor.bind("pull_tip", with_tip_at, deflection_of, float)
        self.page.on("let_go", lambda lets: visitor.update(partial(out_of_hand, lets=lets)), bool)

    def content(self, snapshot: Snapshot) -> Content:
        shown = can_begin(snapshot) or snapshot.state.slice(MotionState).hold
        return page.html("pull-row", BY_KEYS) | page.props("pull-row", hidden=not shown)

    def add_to(self, view: SceneView) -> None:
        self.scene, self.view, self.offered = view, view.beam, False
        name, box = "/scene/rotor/sleeve", trimesh.creation.box()
        self.sleeve = add_instances(view.graph, name, box, PIECES, opacity=0.0)
        sphere = trimesh.creation.icosphere(subdivisions=3, radius=BALL)
        self.ball = add_instances(view.graph, "/scene/rotor/ball", sphere)
        self.sleeve.visible = self.ball.visible = False

    def move(self, snapshot: Snapshot) -> None:
        """Offer the beam to be pulled where it is drawn alone and has a motion, and until it is let
        go: put ball and sleeve around it as it was drawn last."""
        state, motion = snapshot.state, snapshot.state.slice(MotionState)
        chosen = motion.in_motion or state.tab == MotionTab.tab.key
        self.offer(offered=can_begin(snapshot) or motion.hold is not None)
        if not self.offered:
            return
        x = np.linspace(LEAST_PLACE, 1.0, PIECES + 1)
        columns = (np.interp(x, self.view.shapes.x, column) for column in self.view.line.T)
        line = np.column_stack([*columns])
        centres, wxyz, sizes = segments(line, NORMALS["chordwise"], (SLEEVE, SLEEVE))
        middle, places = (x[:-1] + x[1:]) / 2, [body.beta for body in self.view.bodies.shown]
        bare = abs(np.subtract.outer(middle, places)).min(axis=1, initial=1.0) > x[1] - x[0]
        sizes[~bare if chosen else slice(None)] = 0.0  # bodies are slid
        outward = (line[-1] - line[-2]) / np.linalg.norm(line[-1] - line[-2])
        centres[-1], sizes[-1] = line[-1] + BALL * outward, SLEEVE
        placed = {"batched_positions": centres, "batched_wxyzs": wxyz, "batched_scales": sizes}
        self.scene.graph.set_properties(self.sleeve, **placed)
        self.place_ball(centres[-1])

    def place_ball(self, centre: np.ndarray) -> None:
        """Put the ball at its centre (3,)."""
        placed = {
            "batched_positions": centre[None],
            "batched_wxyzs": np.array([[1.0, 0.0, 0.0, 0.0]]),
            "batched_scales": np.ones((1, 3)),
            "batched_colors": colours.instanced([colours.GRIP]),
        }
        self.scene.graph.set_properties(self.ball, **placed)

    async def dragged(self, event: SceneNodeDragEvent[BatchedMeshHandle]) -> None:
        """Handle a step of a drag, on the event loop, so that steps are handled in order."""
        visitor = self.visitor
        if event.phase == "end":
            visitor.update(partial(out_of_hand, lets=True))
            return
        hold = visitor.state.slice(MotionState).hold
        sight = self.scene.line_of_sight(np.asarray(event.end_position, float))
        deflection = in_plane(sight)
        if hold is None or not hold.held:
            x = nearest(self.view.line, self.view.shapes.x, *sight)
            if x is None:
                return
            x = 1.0 if x > TIP else max(round(x, DIGITS - 1), LEAST_PLACE)
            hold = Hold(x, 0.0, number=next(NUMBERS))
        if deflection is not None:
            visitor.change(partial(with_hold, hold=hold._replace(deflection=deflection)))

    def react(self, snapshot: Snapshot, elapsed: float) -> None:
        """Let go of the beam after a drag."""
        visitor, hold = self.visitor, snapshot.state.slice(MotionState).hold
        if hold is None or hold.held or visitor.state is not snapshot.state:
            return
        try:
            request = PullRequest.of(snapshot.state)
        except InvalidInput:  # the page says which number is out of range
            visitor.update(partial(with_hold, hold=None))
            return
        answer = snapshot.job_answer(PULL_JOB)
        if answer is None or answer.request != request:
            return
        if answer.result is None:
            visitor.page.say(answer.message, error=True)
            visitor.update(partial(with_hold, hold=None))
            return
        force = answer.result.force
        visitor.change(lambda state: let_go(state, hold, force))

    def offer(self, *, offered: bool) -> None:
        """Take drags of the beam, or leave them to the view of the scene."""
        if offered == self.offered:
            return
        self.offered = offered
        self.sleeve.visible = self.ball.visible = offered
        if offered:
            self.sleeve.on_drag(self.dragged)
        else:
            self.sleeve.remove_drag_callback(self.dragged)


def can_begin(snapshot: Snapshot) -> bool:
    """Whether the beam is drawn alone and has a motion."""
    return not snapshot.picture.drawn.in_rows and can_move(snapshot.state)


def deflection_of(state: State) -> float:
    """The deflection [L] of the point in the hand, 0 without one."""
    hold = state.slice(MotionState).hold
    return hold.deflection if hold and hold.held else 0.0


def with_tip_at(state: State, deflection: float) -> State:
    """With the tip held at a deflection [L]."""
    hold = state.slice(MotionState).hold
    if state.view.all_modes or not (can_move(state) and math.isfinite(deflection)):
        return state
    if hold is None or not (hold.held and hold.at == 1.0):
        hold = Hold(1.0, 0.0, number=next(NUMBERS))
    deflection = round(min(max(deflection, -LARGEST), LARGEST), DIGITS)
    return with_hold(state, hold._replace(deflection=deflection))


def out_of_hand(state: State, lets: bool) -> State:
    """With the beam out of the hand: it is released as soon as the force is known, unless it is not
    pulled; lets: False puts it back instead."""
    hold = state.slice(MotionState).hold
    if hold is None or not hold.held:
        return state
    pulled = lets and abs(hold.deflection) >= LEAST_PULL
    return with_hold(state, hold._replace(held=False) if pulled else None)


def let_go(state: State, hold: Hold, force: float) -> State:
    """With the motion that begins where the beam was held by a force."""
    low, high = RANGES["pull"].limits
    force = float(f"{min(max(force, low), high):.{DIGITS}g}")
    experiment = state.slice(MotionState).experiment
    pulled = replace(experiment, start="pulled", pull=force, pull_at=hold.at)
    # It plays at once, also where motion is reduced: the visitor has set it in motion.
    return begun(with_hold(state, None), pulled).changed("playing", True)


def in_plane(sight: Ray) -> float | None:
    """The deflection of the point of the plane of rotation on a line of sight; None where the plane
    is seen edge on."""
    eye, at = sight
    along = at - eye
    if not abs(along[2]) > FLAT * np.linalg.norm(along):
        return None
    y = float((eye - eye[2] / along[2] * along)[1])
    return round(min(max(y, -LARGEST), LARGEST), DIGITS)
