"""Camera positions from which the beam fills the picture."""

import itertools
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from beamviz.drawing.modes import SampledModes
from beamviz.drawing.sizes import drawn_bodies, largest_reach, reach
from beamviz.drawing.surroundings import hub_radius
from beamviz.scene import Camera, Scene

if TYPE_CHECKING:
    from viser import CameraHandle, InitialCameraConfig

FIELD_OF_VIEW = math.radians(24)  # vertical
TALL = math.tan(FIELD_OF_VIEW / 2)  # half the height of the picture at distance 1
# Directions from the middle of the picture to the camera, in the rotating and the stationary frame.
ROTATING_DIRECTIONS = {
    "chordwise": (-0.3, -1.0, 0.8),
    "flapwise": (-0.3, -1.0, 0.45),
    "both": (-0.3, -1.0, 0.6),
}
FIXED_DIRECTION = (0.0, -1.0, 0.85)
ROOM = 0.2  # [beam lengths] half the width that the picture contains for the motion of the beam
MARGIN = 0.1  # [beam lengths] width that the picture contains around the hub
SCALES = (100.0, 1e5)  # [pixels per beam length] limits of the scale
RIM = 0.3  # [beam lengths] largest part of the hub in the picture
TOP = 0.2  # of half the height of a page: left free above, for labels
MIN_SLOPE = 1e-3  # of a direction against the axis; of a smaller one, y is vertical in the picture
TURN = np.linspace(0, 2 * np.pi, 24, endpoint=False)
CIRCLE = np.stack([np.cos(TURN), np.sin(TURN), 0 * TURN], 1)
OCTANTS = np.array(list(itertools.product((-1, 1), repeat=3)))  # corners of a cube


def span(shapes: SampledModes) -> tuple[float, float]:
    """The range of x, from the clamp, in the picture: beam, bodies and a part of the hub."""
    beam, along = shapes.beam, shapes.centreline[:, 0]
    rim = min(2 * hub_radius(beam), RIM) if beam.delta >= 0 else MARGIN
    left, right = min(-rim, along.min()), along.max()
    for station, body in zip(shapes.bodies, drawn_bodies(beam), strict=True):
        radius = reach(beam, body)
        left, right = min(left, along[station] - radius), max(right, along[station] + radius)
    return left, right


def target(shapes: SampledModes, rotating_frame: bool) -> np.ndarray:
    """Middle (3,) of the picture in the hub's frame: of the beam if rotating, else on the axis."""
    if not rotating_frame:
        return np.zeros(3)
    y = shapes.centreline[:, 1]
    return np.array([shapes.beam.delta + sum(span(shapes)) / 2, (y.min() + y.max()) / 2, 0.0])


def corners(
    shapes: SampledModes, rotating_frame: bool, heights: Sequence[float] = (0.0,)
) -> np.ndarray:
    """Points (n, 3), relative to `target`, that a picture of beams at these heights contains."""
    beam, (left, right) = shapes.beam, span(shapes)
    radius = largest_reach(beam)
    if rotating_frame:
        side = max(ROOM, radius) + np.ptp(shapes.centreline[:, 1]) / 2
        points = OCTANTS * [(right - left) / 2, side, max(0.75 * ROOM, radius)]
    else:
        reach = max(hub_radius(beam), abs(beam.delta + right), abs(beam.delta + left)) + MARGIN
        points = reach * CIRCLE
    return np.concatenate([points + [0, 0, height] for height in heights])


def scale(distance: float, height: int) -> float:
    """The scale [pixels per beam length] at a distance from the camera; height: [pixels]."""
    pixels = height / (2 * TALL * max(distance, 1e-6))
    return min(max(SCALES[0], pixels), SCALES[1])


def axes(direction: Sequence[float] | np.ndarray) -> np.ndarray:
    """Right, down and forward of a camera in `direction` from its target, as columns (3, 3)."""
    x, y, z = np.divide(direction, -np.linalg.norm(direction)).tolist()
    across = math.hypot(x, y)
    right = (y / across, -x / across) if across > MIN_SLOPE else (1.0, 0.0)
    down = (-z * right[1], z * right[0], x * right[1] - y * right[0])
    return np.array([(*right, 0.0), down, (x, y, z)]).T


def viewpoint(
    shapes: SampledModes,
    rotating_frame: bool,
    aspect: float,
    heights: Sequence[float] = (0.0,),
    direction: tuple[float, float, float] | None = None,
) -> np.ndarray:
    """The nearest camera position (3,) whose picture contains the beam.

    aspect: width / height of the picture; heights: [beam lengths] of stacked beams; direction: to
    the camera, None for the default. The camera looks at the origin, where the scene places
    `target`.
    """
    usual = ROTATING_DIRECTIONS[shapes.plane] if rotating_frame else FIXED_DIRECTION
    view = axes(direction or usual)
    right, down, forward = (corners(shapes, rotating_frame, heights) @ view).T
    needed = np.maximum(np.abs(right) / (TALL * aspect), np.abs(down) / TALL)
    return -1.06 * (needed - forward).max() * view[:, 2]


def fitted(
    shapes: SampledModes,
    rotating_frame: bool,
    aspect: float,
    heights: Sequence[float] = (0.0,),
    covered: float = 0.0,
) -> Camera:
    """The camera that fits the beam into a page. covered: fraction of half the height left free
    below.

    It looks at the point above or below the middle of the beam, in the stationary frame of the hub,
    from which all, or the circle that the beam sweeps, is in the middle of what is free of the
    picture: what is nearer is larger.
    """
    view = axes(ROTATING_DIRECTIONS[shapes.plane] if rotating_frame else FIXED_DIRECTION)
    right, down, forward = (corners(shapes, rotating_frame, heights) @ view).T
    _, fall, slope = -view[2]  # of the axis, in the picture and along the line of sight
    bottom, top = TALL * (1 - covered), TALL * (1 - TOP)
    below, above = (down / bottom - forward).max(), (-down / top - forward).max()
    low = (below - above) / (fall * (1 / bottom + 1 / top))  # both edges are equally near
    high = below - low * fall / bottom
    distance = 1.06 * (low * slope + max(high, (abs(right) / (TALL * aspect) - forward).max()))
    target = np.array([0.0, 0.0, -low])
    return Camera((target - distance * view[:, 2]).tolist(), target.tolist())


def initial(scene: Scene) -> Camera:
    """The camera of a page whose shape is not known yet."""
    rest = SampledModes.at_rest(scene.beam, scene.options["plane"])
    return scene.camera or fitted(rest, scene.view.rotating_frame, aspect=1.0)


def place(view: "CameraHandle | InitialCameraConfig", camera: Camera) -> None:
    view.position, view.look_at = camera.position, camera.look_at
    view.fov = FIELD_OF_VIEW
