"""Dragging the mass along the beam with the pointer."""

import numpy as np
from viser import BatchedMeshHandle, SceneNodeDragEvent
from viser.transforms import SO3

from beamviz.drawing import BeamView
from beamviz.drawing.beam_mesh import to_hub_frame
from beamviz.explorer.state import State
from beamviz.explorer.visitor import Visitor

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
