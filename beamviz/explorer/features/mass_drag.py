"""The bodies in the scene, which the visitor drags along the beam."""

from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from viser import BatchedMeshHandle, SceneNodeDragEvent

from beamviz.drawing.beam_mesh import to_hub_frame
from beamviz.drawing.modes import SampledModes
from beamviz.explorer.declarations import choice
from beamviz.explorer.feature import Feature
from beamviz.explorer.snapshot import Inputs, Snapshot
from beamviz.explorer.state import Case, Ray, Slice, State
from beamviz.explorer.view import Picture, SceneView

BETA_DIGITS = 3  # of a position in the hand: finer than a pointer
COORDINATES = np.linspace(0.0, 1.0, 2001)  # of points of the beam that may be under the pointer
SETTLED = 0.002  # change of beta below which the mass is under the pointer
PARALLEL = 0.03  # sine of the angle between view and beam below which no position is defined


@dataclass(frozen=True, eq=False)
class Grip:
    """A body that the visitor drags. The beam's frame keeps its place in the scene meanwhile."""

    sight: Ray  # the line of sight that the body is moved to
    # Distance [L] along the beam from the centre of the body to the point where it was picked up.
    offset: float
    body: int | None = None  # index in `Beam.masses`; None for the concentrated mass
    held: bool = True  # by the pointer; False: the body is only moved under it once more

    def position(self, x: float) -> float:
        """The position, on the beam, of a body whose point in the hand is at the coordinate x."""
        return min(max(round(x - self.offset, BETA_DIGITS), 0.0), 1.0)

    def beta(self, case: Case) -> float | None:
        """The position of the body; None where the case does not have it any more."""
        if self.body is None:
            return case.numbers["beta"]
        return case.masses[self.body].beta if self.body < len(case.masses) else None


@dataclass(frozen=True)
class DragState(Slice):
    """The body in the hand."""

    grip: Grip | None = field(
        default=None, metadata=choice(undo="ends", led="ends", until=("viewpoint",))
    )

    @property
    def in_hand(self) -> bool:
        return self.grip is not None


def with_grip(state: State, grip: Grip | None) -> State:
    return state.with_values(DragState, grip=grip)


def grip_of(state: State) -> Grip | None:
    return state.slice(DragState).grip


class MassDrag(Feature):
    """Sets the position of a body while it is dragged; meanwhile the clock stops and the scene
    keeps its place. What is known of the drag is the `grip` of the state."""

    state = DragState

    def add_to(self, view: SceneView) -> None:
        self.scene, self.view = view, view.beam
        for node in self.view.bodies.nodes:
            node.on_drag(self.dragged)
            node.on_click(self.clicked)

    async def clicked(self, event: object) -> None:
        """Do nothing; with a handler, viser outlines the body under the pointer."""

    async def dragged(self, event: SceneNodeDragEvent[BatchedMeshHandle]) -> None:
        """Handle a step of a drag, on the event loop, so that steps are handled in order."""
        visitor, grip = self.visitor, grip_of(self.visitor.state)
        if event.phase == "end":
            if grip:
                visitor.update(let_go)
            return
        sight = self.scene.line_of_sight(np.asarray(event.end_position, float))
        x = nearest_coordinate(self.view.shapes, sight)
        if x is None:
            return
        if grip is None or not grip.held:
            number = self.view.bodies.number(event.target, event.instance_index)
            if number is None:
                return
            beam = self.view.shapes.beam
            visitor.change(State.keep_for_comparison)
            body = number - 1 if beam.alpha > 0 else number  # the concentrated mass is the first
            at = self.view.bodies.shown[number].beta
            grip = Grip(sight, x - at, body if body >= 0 else None)
        grip = replace(grip, sight=sight)
        visitor.change(lambda state: moved(with_grip(state, grip), x))

    def picture(self, inputs: Inputs, picture: Picture) -> Picture:
        grip = grip_of(inputs.state)
        if grip is None:
            return picture
        return replace(picture, held=True, plays=False if grip.held else picture.plays)

    def react(self, snapshot: Snapshot, elapsed: float) -> None:
        """Move the body under the pointer again if the shape of the beam has changed since; after
        the drag once more, and let go of it."""
        visitor, grip = self.visitor, grip_of(snapshot.state)
        if grip is None or not snapshot.settled or visitor.state is not snapshot.state:
            return
        x = nearest_coordinate(snapshot.picture.modes, grip.sight)
        beta = grip.beta(snapshot.state.case)
        if x is not None and beta is not None and abs(grip.position(x) - beta) > SETTLED:
            visitor.change(lambda state: moved(state, x))
        if not grip.held:
            visitor.update(partial(with_grip, grip=None))


def let_go(state: State) -> State:
    """With the body only moved under the pointer once more."""
    grip = grip_of(state)
    return with_grip(state, replace(grip, held=False)) if grip else state


def moved(state: State, x: float) -> State:
    """With the body moved so that the point where it was picked up is at the coordinate x."""
    grip = grip_of(state)
    if grip is None or grip.beta(state.case) is None:
        return state
    if grip.body is None:
        return state.changed("beta", grip.position(x))
    return state.with_body_at(grip.body, grip.position(x))


def nearest_coordinate(shapes: SampledModes, sight: Ray) -> float | None:
    """The reference coordinate of the point of the beam, straight or bent, that is nearest to a
    line of sight; None where that is not defined."""
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
    size, seen_size = (np.linalg.norm(np.diff(path, axis=0), axis=1).sum() for path in (line, seen))
    if seen_size < PARALLEL * size:
        return None
    return float(COORDINATES[np.linalg.norm(seen, axis=1).argmin()])
