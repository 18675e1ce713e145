"""The camera of a page: where it should be, and the one place that compares with where it is."""

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import astuple, dataclass, replace
from typing import Self

import numpy as np
from viser import CameraHandle

from beamviz.drawing.camera import fitted, place, scale
from beamviz.drawing.modes import SampledModes
from beamviz.scene import Camera

STEP = 1.15  # ratio of the distances from which the camera looks, so that it moves rarely
# Decimals of its target divided by that distance, for the same reason; the last one is 5 % of half
# the height of the picture.
TARGET_DIGITS = 2
ZOOM_STEP = 1.25  # ratio of the scales that the beam is subdivided for
# On a page less than NARROW [px] wide the legend is a strip above the buttons (page.css), together
# STRIP [px] high; the beam has at least 1 - MOST of half the height.
NARROW, STRIP, MOST = 640, 102, 0.6
TOLERANCE = 1e-3  # [beam lengths] largest distance of equal viewpoints
DIGITS = 4  # after the point, of a viewpoint that the visitor has chosen
# Viewpoints that the server has set and that the page may still tell: those of two seconds in which
# the view follows a slider, over a slow connection.
SET = 50
DEFAULT = Camera((3.0, 3.0, 3.0))  # of viser's page before it has another one
CHANGE_TIME = 0.9  # [s] of an eased change of view


def covered_below(width: int, height: int) -> float:
    """The fraction of half the height of a scene [px] that the page covers below."""
    return min(2 * STRIP / max(height, 1), MOST) if width < NARROW else 0.0


def viewpoint(
    shapes: SampledModes,
    rotating_frame: bool,
    aspect: float,
    heights: Sequence[float],
    covered: float = 0.0,
) -> Camera:
    """The viewpoint from which beams at `heights` fit into a page of this aspect ratio, at the next
    larger distance of those in steps, and with a target in steps; covered: see `covered_below`."""
    fit = fitted(shapes, rotating_frame, aspect, heights, covered)
    distance = math.dist(fit.position, fit.look_at)
    farther = stepped(distance, STEP, up=True)
    target = farther * np.round(np.divide(fit.look_at, distance), TARGET_DIGITS)
    position = target + farther * np.subtract(fit.position, fit.look_at) / distance
    return Camera(*(tuple(np.round(point, 9).tolist()) for point in (position, target)))


def stepped(value: float, step: float, *, up: bool = False) -> float:
    """The power of `step` nearest to a value, or the next larger one."""
    exponent = math.log(value) / math.log(step)
    return step ** (math.ceil(exponent - 1e-9) if up else round(exponent))


@dataclass(frozen=True)
class Transition:
    """An eased change of the view, also between the stationary and the rotating frame."""

    start: Camera
    end: Camera
    shares: tuple[float, float]  # of the rotating frame at the start and the end, 0 .. 1
    # Of the hub [rad]: at most half a turn at the start and continuous after it, so that the floor
    # turns back the shorter way.
    angle: float = 0.0
    elapsed: float = 0.0  # time since the start [s]

    def advanced(self, elapsed: float, angle: float) -> Self | None:
        """After `elapsed` [s], with the hub at an angle [rad]; None at its end."""
        if self.part == 1:
            return None
        after = self.elapsed + elapsed
        return replace(self, elapsed=after, angle=self.continued(angle))

    def continued(self, angle: float) -> float:
        """The angle [rad], plus whole turns, nearest to that of the hub."""
        return self.angle + math.remainder(angle - self.angle, 2 * math.pi)

    @property
    def part(self) -> float:
        """The completed fraction of the change, with speed zero at both ends."""
        time = min(self.elapsed / CHANGE_TIME, 1.0)
        return time**2 * (3 - 2 * time)

    @property
    def rotating_share(self) -> float:
        start, end = self.shares
        return start + self.part * (end - start)

    @property
    def camera(self) -> Camera:
        pairs = zip(astuple(self.start), astuple(self.end), strict=True)
        return Camera(*(np.add(a, self.part * np.subtract(b, a)).tolist() for a, b in pairs))


class PageCamera:
    """The camera of a page, which the visitor moves too.

    initial: set in every page that opens; placed: the last ones that the server set;
    rotating_frame: whether the page shows that, None before the first picture.
    """

    def __init__(self, view: CameraHandle, initial: Camera):
        self.view, self.initial = view, initial
        self.placed = deque([initial], maxlen=SET)
        self.rotating_frame: bool | None = None

    def look(
        self,
        camera: Camera,
        rotating_frame: bool,
        transition: Transition | None,
        *,
        eased: bool,
    ) -> Transition | None:
        """Look from a viewpoint, unless the page does, or is on its way there. Returns the
        transition to it, None where the page is there at once; eased: a change of the frame takes
        time."""
        changes = self.rotating_frame not in (None, rotating_frame)
        self.rotating_frame = rotating_frame
        is_there = camera == transition.end if transition else self.is_at(camera)
        if is_there and not changes:
            return transition
        if camera != self.placed[-1]:
            self.placed.append(camera)
        if changes and eased:
            return self.transition(camera, rotating_frame, transition)
        if transition:
            return replace(transition, end=camera)
        place(self.view, camera)
        return None

    def transition(self, end: Camera, rotating_frame: bool, last: Transition | None) -> Transition:
        """A change of view that starts at the present camera, also during another one."""
        share = float(rotating_frame)
        if last:
            return Transition(last.camera, end, (last.rotating_share, share), last.angle)
        return Transition(self.present, end, (1 - share, share))

    def followed(self, moved: np.ndarray, end: Camera, share: float) -> Transition:
        """A change of view after the scene was moved by `moved` (3,); share: of the rotating
        frame."""
        now = np.array([self.view.position, self.view.look_at])
        return Transition(Camera(*(now + moved).tolist()), end, (share, share))

    @property
    def present(self) -> Camera:
        return Camera(self.view.position.tolist(), self.view.look_at.tolist())

    @property
    def turned(self) -> Camera | None:
        """The viewpoint that the visitor has chosen; None before the first picture, and where it is
        one that the server set, also an earlier one, as a message of the page has crossed the last
        one, or a busy page has set the initial one after it; or parts of two, as position and
        target arrive one after the other. Raises InvalidInput for one that is too far away."""
        is_set = self.is_at(DEFAULT, self.initial, *self.placed)
        if self.rotating_frame is None or is_set:
            return None
        return Camera(*np.round([self.view.position, self.view.look_at], DIGITS).tolist())

    def is_at(self, *cameras: Camera) -> bool:
        """Whether the page has the position of one of these cameras, and the target of one."""
        position, target = tuple(self.view.position), tuple(self.view.look_at)
        return (
            min(math.dist(position, camera.position) for camera in cameras) < TOLERANCE
            and min(math.dist(target, camera.look_at) for camera in cameras) < TOLERANCE
        )

    @property
    def scale(self) -> float:
        """The scale [pixels per beam length] that the beam is subdivided for."""
        distance = math.dist(self.view.position, self.view.look_at)
        return stepped(scale(distance, self.view.image_height), ZOOM_STEP)
