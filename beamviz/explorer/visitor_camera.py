"""From where a visitor looks: fitted to the beam, unless a viewpoint is given or was chosen."""

import math
from collections.abc import Sequence

import numpy as np
from viser import CameraHandle, InitialCameraConfig

from beamviz.drawing import camera
from beamviz.drawing.modes import Shapes
from beamviz.scene import Camera

SAME = 1e-3  # apart are two viewpoints that count as one
LIFT = 0.1  # of half the height of the picture
NEARER, FARTHER = 0.7, 1.15  # times the distance: the camera stays while the best one is between


class Viewing:
    """Moves the camera of one visitor when asked to, and when what is seen has changed."""

    def __init__(self, view: CameraHandle, given: Camera | None):
        self.view = view
        self.given = given  # a viewpoint that is given, until another is asked for
        self.placed = self.before = Camera((1.0, 1.0, 1.0))  # where it was put last, and before
        self.asked = True  # to be moved
        self.unsettled = False  # to be moved again when the answer has come
        self.seen: tuple = ()  # what the viewpoint was chosen for, and how far away it is
        self.distance = 0.0

    def take(self, given: Camera | None) -> None:
        """Look from a viewpoint, None for the one that fits."""
        self.given, self.asked = given, True

    def let_go(self) -> None:
        """No viewpoint is given any more."""
        self.given = None

    def look_at(
        self, shapes: Shapes, rotating_frame: bool, levels: Sequence[float], *, settled: bool
    ) -> None:
        """Move the camera where there is need to: scenes stand at heights `levels`. Until the
        answer is `settled`, the one to what is wanted, it has to be moved again."""
        aspect = self.view.aspect
        position = camera.viewpoint(shapes, rotating_frame, aspect, LIFT, levels)
        distance = float(np.linalg.norm(position))
        seen = (rotating_frame, shapes.plane, aspect, len(levels))
        stays = NEARER * self.distance < distance < FARTHER * self.distance
        moved = seen != self.seen or not stays
        if self.asked or self.unsettled or (moved and self.given is None):
            self.seen, self.distance = seen, distance
            self.asked, self.unsettled = False, not settled
            self.before, self.placed = self.placed, self.given or lifted(position)
            place(self.view, self.placed)

    @property
    def chosen(self) -> Camera | None:
        """Where the visitor looks from, or None where the beam has been fitted into the page."""
        if self.at(self.placed):
            return self.given
        return Camera(*np.round([self.view.position, self.view.look_at], 4).tolist())

    def at(self, camera: Camera) -> bool:
        """Whether the camera is there."""
        now, there = (self.view.position, self.view.look_at), (camera.position, camera.look_at)
        return np.allclose(now, there, atol=SAME)

    @property
    def scale(self) -> float:
        """Pixels that a length of the beam takes in the middle of the picture."""
        away = math.dist(self.view.position, self.view.look_at)
        return camera.scale(away, self.view.image_height)

    @property
    def reshaped(self) -> bool:
        """Whether the page has another shape than the viewpoint was chosen for."""
        return bool(self.seen) and self.view.aspect != self.seen[2] and self.given is None

    @property
    def overtaken(self) -> bool:
        """Whether the page has the camera where it was put before: it told so while it was put
        elsewhere, and viser does not send what the page seemed to have already."""
        return self.at(self.before) and not self.at(self.placed)


def lifted(position: np.ndarray) -> Camera:
    """A camera at `position` (3,) as seen from what it looks at: a point a little above the beam,
    where words about it stand."""
    lift = np.array(
        [0.0, 0.0, LIFT * math.tan(camera.FIELD_OF_VIEW / 2) * np.linalg.norm(position)]
    )
    return Camera((position + lift).tolist(), lift.tolist())


def place(view: CameraHandle | InitialCameraConfig, wanted: Camera) -> None:
    """Put a camera where it is wanted."""
    view.position, view.look_at = wanted.position, wanted.look_at
    view.fov = camera.FIELD_OF_VIEW
