"""Dragging the mass along the beam with the pointer."""

import numpy as np
from viser import BatchedMeshHandle, SceneNodeDragEvent
from viser.transforms import SO3

from beamviz.drawing.beam_view import BeamView
from beamviz.explorer.state import State
from beamviz.explorer.visitor import Visitor

DIGITS = 3  # of beta: finer than a pointer
PARALLEL = 1e-3  # sin^2 of the angle between view and beam below which there is no position


class MassDrag:
    """Turns drags of the mass into values of beta; time stands still meanwhile."""

    def __init__(self, visitor: Visitor, view: BeamView):
        self.visitor, self.view = visitor, view
        self.offset: float | None = None  # from the centre of the mass to where it was picked up
        view.mass.on_drag(self.dragged)

    async def dragged(self, event: SceneNodeDragEvent[BatchedMeshHandle]) -> None:
        """Take a step of a drag; on the event loop, so that steps come in order."""
        visitor, shapes = self.visitor, self.view.shapes
        if event.phase == "end":
            self.offset, visitor.dragging = None, False
            visitor.wake()
            return
        x = self.distance_along_beam(np.asarray(event.end_position, float))
        if x is None:
            return
        if self.offset is None:
            self.offset, visitor.dragging = x - shapes.centreline[shapes.mass, 0], True
            visitor.change(State.keep_for_comparison)
        beta = self.beta(x - self.offset)
        visitor.change(lambda state: state.changed("beta", beta))

    def distance_along_beam(self, point: np.ndarray) -> float | None:
        """Distance from the clamp of the place on the beam that is nearest to the line of sight
        through a point (3,); None where that is not defined."""
        view = self.view
        axis = SO3(np.asarray(view.rotor.wxyz)).apply(np.array([1.0, 0.0, 0.0]))
        clamp = np.asarray(view.frame.position) + view.shapes.beam.delta * axis
        return nearest(clamp, axis, np.asarray(self.visitor.client.camera.position), point)

    def beta(self, x: float) -> float:
        """The reference coordinate of a place on the stretched beam."""
        shapes = self.view.shapes
        return round(float(np.interp(x, shapes.centreline[:, 0], shapes.x)), DIGITS)


def nearest(
    start: np.ndarray, direction: np.ndarray, eye: np.ndarray, point: np.ndarray
) -> float | None:
    """Distance along a line, from `start` (3,) in the unit `direction` (3,), of its place nearest
    to the line from `eye` through `point`; None where these are parallel or not finite."""
    sight = point - eye
    length = float(np.linalg.norm(sight))
    if not (np.isfinite(length) and length > 0):
        return None
    sight = sight / length
    cosine = float(direction @ sight)
    if 1 - cosine**2 < PARALLEL:
        return None
    return float((direction - cosine * sight) @ (eye - start)) / (1 - cosine**2)
