"""Where to look from so that the beam fills the picture."""

import math

import numpy as np

from beamviz.beam import Beam
from beamviz.show.sizes import hub_radius, mass_radius

FIELD_OF_VIEW = math.radians(24)  # vertical
RIDING_FROM = {"chordwise": (-0.3, -1.0, 0.8), "flapwise": (-0.3, -1.0, 0.45)}
BESIDE_FROM = (0.0, -1.0, 0.85)
ROOM = 0.2  # kept on both sides of the beam for its motion
HOOP = 0.1  # wall of the hoop that an inward beam is clamped to, and room
RIM = 0.3  # of a large hub, this much is kept in the picture


def span(beam: Beam) -> tuple[float, float]:
    """From where to where a picture reaches along the beam [from the clamp]: with the mass and
    some of the hub."""
    radius = mass_radius(beam) if beam.alpha > 0 else 0.0
    rim = min(2 * hub_radius(beam), RIM) if beam.delta >= 0 else HOOP
    return min(-rim, beam.beta - radius), max(1.0, beam.beta + radius)


def target(beam: Beam, riding: bool) -> np.ndarray:
    """The point (3,) of the hub's frame that is put in the middle of the picture: the middle of
    the beam when riding on the hub, the axis when standing beside it."""
    return np.array([beam.delta + sum(span(beam)) / 2 if riding else 0.0, 0.0, 0.0])


def corners(beam: Beam, riding: bool) -> np.ndarray:
    """Points (n, 3), relative to `target`, that must be inside the picture."""
    radius = mass_radius(beam) if beam.alpha > 0 else 0.0
    if riding:
        half = (span(beam)[1] - span(beam)[0]) / 2
        side, height = max(ROOM, radius), max(0.75 * ROOM, radius)
        return np.array(
            [(x, y, z) for x in (-half, half) for y in (-side, side) for z in (-height, height)]
        )
    reach = max(hub_radius(beam), abs(beam.delta + 1), abs(beam.delta + beam.beta) + radius) + HOOP
    turn = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    return np.stack([reach * np.cos(turn), reach * np.sin(turn), 0 * turn], 1)


def framing(points: np.ndarray, direction: tuple[float, float, float], aspect: float) -> np.ndarray:
    """Camera position (3,) along `direction` from the origin, looking at it with z up, as near
    as it can be with all `points` (n, 3) inside a picture of width / height = `aspect`."""
    back = np.array(direction) / np.linalg.norm(direction)
    right = np.cross([0.0, 0.0, 1.0], back)
    right /= np.linalg.norm(right)
    up = np.cross(back, right)
    tall = math.tan(FIELD_OF_VIEW / 2)
    wide = tall * aspect
    depth = points @ back
    distance = depth + np.maximum(np.abs(points @ right) / wide, np.abs(points @ up) / tall)
    return 1.06 * distance.max() * back


def axes(position: np.ndarray) -> np.ndarray:
    """Right, down and forward as columns (3, 3) of a camera at `position` that looks at the
    origin with z up."""
    forward = -position / np.linalg.norm(position)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(forward, right), forward], 1)


def viewpoint(beam: Beam, plane: str, riding: bool, aspect: float) -> np.ndarray:
    """Camera position (3,) for a beam that moves in `plane`; it looks at the origin, where the
    scene puts `target`."""
    direction = RIDING_FROM[plane] if riding else BESIDE_FROM
    return framing(corners(beam, riding), direction, aspect)
