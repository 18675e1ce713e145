"""Where to look from so that the beam fills the picture."""

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from viser import CameraHandle, InitialCameraConfig

from beamviz.drawing.modes import SampledModes
from beamviz.drawing.objects import hub_radius, mass_radius
from beamviz.scene import Camera

FIELD_OF_VIEW = math.radians(24)  # vertical
RIDING_FROM = {"chordwise": (-0.3, -1.0, 0.8), "flapwise": (-0.3, -1.0, 0.45)}
BESIDE_FROM = (0.0, -1.0, 0.85)
ROOM = 0.2  # kept on both sides of the beam for its motion
HOOP = 0.1  # wall of the hoop that an inward beam is clamped to, and room
SCALES = (100.0, 1e5)  # [pixels] of a length of the beam that are told apart
RIM = 0.3  # of a large hub, this much is kept in the picture
LIFT = 0.1  # of half the height of a page: free above the beam, for a label
NEARER, FARTHER = 0.7, 1.15  # times the distance: a camera stays while the best one is between
SAME = 1e-3  # distance of two viewpoints that count as one
DIRECTIONS = 16  # from which one looks, of which the unit vectors are kept


def span(shapes: SampledModes) -> tuple[float, float]:
    """From where to where a picture reaches along the beam [from the clamp]: with the mass and
    some of the hub."""
    beam = shapes.beam
    along = shapes.centreline[:, 0]
    radius = mass_radius(beam) if beam.alpha > 0 else 0.0
    rim = min(2 * hub_radius(beam), RIM) if beam.delta >= 0 else HOOP
    mass = along[shapes.mass]
    return min(-rim, mass - radius), max(along[-1], mass + radius)


def target(shapes: SampledModes, rotating_frame: bool) -> np.ndarray:
    """The point (3,) of the hub's frame that is put in the middle of the picture: the middle of
    the beam when riding on the hub, the axis when standing beside it."""
    return np.array(
        [shapes.beam.delta + sum(span(shapes)) / 2 if rotating_frame else 0.0, 0.0, 0.0]
    )


def corners(shapes: SampledModes, rotating_frame: bool) -> np.ndarray:
    """Points (n, 3), relative to `target`, that must be inside the picture."""
    beam, (left, right) = shapes.beam, span(shapes)
    radius = mass_radius(beam) if beam.alpha > 0 else 0.0
    if rotating_frame:
        half, side, height = (right - left) / 2, max(ROOM, radius), max(0.75 * ROOM, radius)
        return np.array(
            [(x, y, z) for x in (-half, half) for y in (-side, side) for z in (-height, height)]
        )
    reach = max(hub_radius(beam), abs(beam.delta + right), abs(beam.delta + left)) + HOOP
    turn = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    return np.stack([reach * np.cos(turn), reach * np.sin(turn), 0 * turn], 1)


def scale(distance: float, height: int) -> float:
    """Pixels of a length of the beam, seen from a distance in a picture of so many pixels."""
    pixels = height / (2 * math.tan(FIELD_OF_VIEW / 2) * max(distance, 1e-6))
    return min(max(SCALES[0], pixels), SCALES[1])


def framing(
    points: np.ndarray, direction: tuple[float, float, float], wide: float, tall: float
) -> np.ndarray:
    """Camera position (3,) along `direction` from the origin, looking at it with z up, as near
    as it can be with all `points` (n, 3) inside a picture whose half width and half height are
    `wide` and `tall` at distance 1."""
    back, right, up = seen_from(direction)
    distance = points @ back
    distance += np.maximum(np.abs(points @ right) / wide, np.abs(points @ up) / tall)
    return 1.06 * distance.max() * back


@lru_cache(DIRECTIONS)
def seen_from(direction: tuple[float, float, float]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Unit vectors (3,) to the camera, to the right of its picture and up in it."""
    back = np.array(direction) / np.linalg.norm(direction)
    right = np.cross([0.0, 0.0, 1.0], back)
    right /= np.linalg.norm(right)
    return back, right, np.cross(back, right)


def axes(position: np.ndarray) -> np.ndarray:
    """Right, down and forward as columns (3, 3) of a camera at `position` that looks at the
    origin with z up."""
    forward = -position / np.linalg.norm(position)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(forward, right), forward], 1)


def viewpoint(
    shapes: SampledModes,
    rotating_frame: bool,
    aspect: float,
    lift: float = 0.0,
    heights: Sequence[float] = (0.0,),
    direction: tuple[float, float, float] | None = None,
) -> np.ndarray:
    """Camera position (3,) for a picture with width / height = `aspect`. It looks at the origin,
    where the scene puts `target`, and is free in its upper part: `lift` of half its height.
    heights: of the scenes that stand above each other, where there are several; direction: the
    usual one where none is given."""
    direction = direction or (RIDING_FROM[shapes.plane] if rotating_frame else BESIDE_FROM)
    tall = math.tan(FIELD_OF_VIEW / 2)
    points = np.concatenate(
        [corners(shapes, rotating_frame) + [0, 0, height] for height in heights]
    )
    return framing(points, direction, tall * aspect, tall * (1 - lift))


def fitted(
    shapes: SampledModes, rotating_frame: bool, aspect: float, heights: Sequence[float] = (0.0,)
) -> Camera:
    """The camera of a page: it looks at a point a little above the beam, where labels stand."""
    position = viewpoint(shapes, rotating_frame, aspect, LIFT, heights)
    lift = LIFT * math.tan(FIELD_OF_VIEW / 2) * float(np.linalg.norm(position))
    target = np.array([0.0, 0.0, lift])
    return Camera((position + target).tolist(), target.tolist())


def place(view: CameraHandle | InitialCameraConfig, camera: Camera) -> None:
    """Move a camera of viser."""
    view.position, view.look_at = camera.position, camera.look_at
    view.fov = FIELD_OF_VIEW


class PageCamera:
    """The camera of a page: it stays where the visitor moves it, and is fitted again when asked
    to and when what it shows has changed."""

    def __init__(self, view: CameraHandle):
        self.view = view
        self.given: Camera | None = None  # a viewpoint in place of the one that fits
        self.placed = self.before = Camera((1.0, 1.0, 1.0))  # where it was put last, and before
        self.asked = True  # to be moved
        self.unsettled = False  # to be moved again when the answer has come
        self.fitted_to: tuple = ()  # what the viewpoint was chosen for, and its distance
        self.distance = 0.0

    def take(self, given: Camera | None) -> None:
        """Look from a viewpoint, None for the one that fits."""
        self.given, self.asked = given, True

    def look_at(
        self, shapes: SampledModes, rotating_frame: bool, heights: Sequence[float], *, settled: bool
    ) -> None:
        """Move the camera where there is need to: scenes stand at `heights`. Until the answer is
        `settled`, the one to the latest request, it has to be moved again."""
        camera = fitted(shapes, rotating_frame, self.view.aspect, heights)
        distance = math.dist(camera.position, camera.look_at)
        fitted_to = (rotating_frame, shapes.plane, self.view.aspect, len(heights))
        stays = NEARER * self.distance < distance < FARTHER * self.distance
        moved = fitted_to != self.fitted_to or not stays
        if self.asked or self.unsettled or (moved and self.given is None):
            self.fitted_to, self.distance = fitted_to, distance
            self.asked, self.unsettled = False, not settled
            self.before, self.placed = self.placed, self.given or camera
            place(self.view, self.placed)

    @property
    def chosen(self) -> Camera | None:
        """Where the visitor looks from, or None where the beam has been fitted into the page."""
        if self.is_at(self.placed):
            return self.given
        return Camera(*np.round([self.view.position, self.view.look_at], 4).tolist())

    def is_at(self, camera: Camera) -> bool:
        """Whether the page has its camera there."""
        now, there = (self.view.position, self.view.look_at), (camera.position, camera.look_at)
        return np.allclose(now, there, atol=SAME)

    @property
    def scale(self) -> float:
        """Pixels that a length of the beam takes in the middle of the picture."""
        return scale(math.dist(self.view.position, self.view.look_at), self.view.image_height)

    @property
    def reshaped(self) -> bool:
        """Whether the page has another shape than the viewpoint was chosen for."""
        return bool(self.fitted_to) and self.view.aspect != self.fitted_to[2] and self.given is None

    @property
    def overtaken(self) -> bool:
        """Whether the page has the camera where it was put before: it told so while it was put
        elsewhere, and viser does not send what the page seemed to have already."""
        return self.is_at(self.before) and not self.is_at(self.placed)
