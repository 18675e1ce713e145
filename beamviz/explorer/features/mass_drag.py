"""The mass as a handle: where along the beam a pointer drags it."""

import numpy as np
from viser import BatchedMeshHandle, SceneNodeDragEvent
from viser.transforms import SO3

from beamviz.drawing.beam_view import BeamView
from beamviz.explorer.state import State
from beamviz.explorer.visitor import Visitor

DIGITS = 3  # of the position: finer than a pointer is
PARALLEL = 1e-3  # a line of sight so nearly along the beam tells no place on it


class MassDrag:
    """Turns a drag of the mass into places along the beam."""

    def __init__(self, visitor: Visitor, scene: BeamView):
        self.scene, self.visitor = scene, visitor
        self.offset: float | None = None  # from the middle of the mass to where it was taken
        scene.mass.on_drag(self.dragged)

    async def dragged(self, event: SceneNodeDragEvent[BatchedMeshHandle]) -> None:
        """A step of a drag; on the server's loop, so that steps come in order."""
        if event.phase == "end":
            self.offset = None
            self.visitor.dragging = False
            self.visitor.wake()
            return
        place = self.place(np.asarray(event.end_position, float))
        if place is None:
            return
        if self.offset is None:
            shapes = self.scene.shapes
            self.offset = place - shapes.centreline[shapes.mass, 0]
            self.visitor.dragging = True
            self.visitor.change(State.keep_for_comparison)
        beta = self.position(place - self.offset)
        self.visitor.change(lambda state: state.changed("beta", beta))

    def place(self, seen: np.ndarray) -> float | None:
        """How far from the clamp, along the beam, a line of sight through a point (3,) passes
        the beam nearest; None where it does so nowhere."""
        turn = SO3(np.asarray(self.scene.wheel.wxyz))
        along = turn.apply(np.array([1.0, 0.0, 0.0]))
        clamp = np.asarray(self.scene.stage.position) + self.scene.shapes.beam.delta * along
        return nearest(clamp, along, np.asarray(self.visitor.client.camera.position), seen)

    def position(self, place: float) -> float:
        """The beta whose place in the stretched beam is `place`."""
        shapes = self.scene.shapes
        beta = np.interp(place, shapes.centreline[:, 0], shapes.x)
        return round(float(beta), DIGITS)


def nearest(
    start: np.ndarray, along: np.ndarray, eye: np.ndarray, seen: np.ndarray
) -> float | None:
    """How far along a line, from `start` in the unit direction `along`, it is nearest to the line
    from `eye` through `seen`; None where these are parallel or no lines."""
    sight = seen - eye
    length = float(np.linalg.norm(sight))
    if not (np.isfinite(length) and length > 0):
        return None
    sight = sight / length
    cosine = float(along @ sight)
    if 1 - cosine**2 < PARALLEL:
        return None
    return float((along - cosine * sight) @ (eye - start)) / (1 - cosine**2)
