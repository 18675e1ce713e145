"""The surroundings of the beam: lights, floor, hub, and an arrow for the rotation."""

import math
from typing import Any

import numpy as np
import trimesh

from beamviz.beam import Beam
from beamviz.drawing import colours
from beamviz.drawing.modes import AT_REST
from beamviz.drawing.objects import Caption, add_instances, add_mesh, set_surface
from beamviz.drawing.scene_graph import DrawnScene
from beamviz.drawing.sizes import largest_height
from beamviz.drawing.text import measure
from beamviz.units import Units

MIN_HUB = 0.05
HUB_HEIGHT = 0.14
HOOP, HOOP_HEIGHT = 0.05, 0.06  # the ring that an inward beam is clamped to: width, height
POST = 0.018  # radius
BOLTS = 6
BOLT_SIZE = (0.12, 0.01)  # radius over that of the hub, height
FLOOR_EDGE = 0.3  # of the floor beyond the tip of the beam
FLOOR_THICKNESS = 0.02
TICKS = 36  # of the scale of the floor, one every ten degrees
LARGE_HUB = 0.4  # radius from which on the arrow is on the hub
ARROW_LENGTH, ARROW_WIDTH, ARROW_HEAD = 0.38, 0.009, 0.06  # [beam lengths]; half the width
ARROW_GAP = 0.05  # from its end to the text of the speed
SPEED_GAP = 0.9  # [rad] smallest angle between the beam and this text
ARROW_HEIGHT = HUB_HEIGHT / 2 + 0.03
# White lights: intensity of the sky, and its colour from below; directions and intensities.
SKY, GROUND_LIGHT = 1.6, (200, 200, 210)
LIGHTS = {"key": ((-0.5, -1.0, 2.2), 1.8), "fill": ((1.5, -2.0, 0.6), 0.5)}


def hub_radius(beam: Beam) -> float:
    """Radius of the hub: |delta|, but at least MIN_HUB."""
    return max(abs(beam.delta), MIN_HUB)


def direction(angle: float | np.ndarray) -> np.ndarray:
    """The unit vectors (..., 2) in the plane of rotation at angles (...) [rad]."""
    return np.stack([np.cos(angle), np.sin(angle)], -1)


def axis_rotation(angle: float) -> tuple[float, float, float, float]:
    """The rotation about the axis by angle [rad] as a quaternion wxyz."""
    return (math.cos(angle / 2), 0.0, 0.0, math.sin(angle / 2))


def add_lights(scene: DrawnScene) -> None:
    """Add lights from above, left of the viewer, with shadows on the floor."""
    scene.configure_environment_map(hdri=None)
    scene.configure_default_lights(enabled=False)
    scene.add_light_hemisphere("/light/sky", ground_color=GROUND_LIGHT, intensity=SKY)
    for name, (position, intensity) in LIGHTS.items():
        scene.add_light_directional(
            f"/light/{name}", position=position, intensity=intensity, cast_shadow=name == "key"
        )


class Surroundings:
    """A bolted hub on a post above a round floor with a scale in degrees, and an arrow in the
    direction of rotation with the speed. The hub is a drum, for a beam that points inward a ring
    (hoop) around it. alone: the only beam of the scene."""

    def __init__(self, scene: DrawnScene, root: str, *, alone: bool):
        self.scene, self.alone = scene, alone  # with floor, post and arrow
        self.drawn_for: tuple = ()  # the values of the last drawing
        hub: Any = {"color": colours.HUB, "receive_shadow": False}
        self.post = scene.add_cylinder(f"{root}/rotor/post", POST, 1.0, **hub)
        self.hub = add_mesh(scene, f"{root}/rotor/hub", cast_shadow=True, **hub)
        head = trimesh.creation.cylinder(1.0, 1.0, sections=6)
        self.bolts = add_instances(scene, f"{root}/rotor/hub/bolts", head, BOLTS)
        self.bolts.batched_colors = colours.instanced(np.tile(colours.MASS, (BOLTS, 1)))
        self.floor = scene.add_frame(f"{root}/floor", show_axes=False, visible=alone)
        round_: Any = {"radial_segments": 160, "cast_shadow": False, "receive_shadow": 0.4}
        self.disc = scene.add_cylinder(f"{root}/floor/disc", 1.0, FLOOR_THICKNESS, **round_)
        thin: Any = {"thickness": 1.0, "thickness_units": "screen"}
        name = f"{root}/floor/scale"
        self.scale = scene.add_line_segments(name, scale_lines(1.0), colours.GRID, **thin)
        ribbon = arrow(1.0, 0.0)
        flat: Any = {"color": colours.ROTATION, "side": "double", "flat_shading": False}
        self.arrow = add_mesh(scene, f"{root}/arrow", ribbon.vertices, ribbon.faces, **flat)
        self.speed = Caption(scene, f"{root}/speed")
        self.speed_angle, self.speed_gap = 0.0, 0.0  # [rad] of its point, least one from the beam
        self.speed_place = np.zeros(3)

    def show(self, beam: Beam, *, rotating_frame: bool, dark: bool = False) -> None:
        """Draw the surroundings of a beam, which is clamped to the rim of the hub. In the
        stationary frame, where the picture contains the whole floor, the arrow is larger."""
        ground = -max(0.3, 1.2 * largest_height(beam))
        turning = self.alone and beam.gamma > 0
        drawn_for = beam.delta, ground, turning, rotating_frame, dark
        if drawn_for != self.drawn_for:
            self.drawn_for = drawn_for
            self.show_hub(beam, ground, rotating_frame=rotating_frame)
            # Below the beam at all angles.
            radius = max(hub_radius(beam) + HOOP, abs(beam.delta + 1)) + FLOOR_EDGE
            self.disc.color, self.disc.radius = colours.FLOOR[dark], radius
            self.scale.points = scale_lines(radius)
            self.scene.set_pose(self.floor, position=(0.0, 0.0, ground - FLOOR_THICKNESS / 2))
            self.show_arrow(beam, 1.0 if rotating_frame else max(1.0, hub_radius(beam)))
        self.speed.text = self.speed_text(beam.gamma, beam.units) if turning else ""
        self.turn_arrow(beam.gamma)

    def tell_speed(self, gamma: float, units: Units | None) -> None:
        """Say the speed of a beam that speeds up, slows down or turns back; at rest without an
        arrow."""
        if self.speed.text:
            self.speed.text = self.speed_text(gamma, units)
            self.turn_arrow(gamma)

    def turn_arrow(self, gamma: float) -> None:
        """Show the arrow in the direction of rotation: it is symmetrical but for its head."""
        visible, backward = bool(self.speed.text) and abs(gamma) > AT_REST, gamma < 0
        if self.arrow.visible != visible:
            self.arrow.visible = visible
        if visible:
            height = 2 * ARROW_HEIGHT if backward else 0.0
            wxyz = (0.0, 1.0, 0.0, 0.0) if backward else (1.0, 0.0, 0.0, 0.0)
            self.scene.set_pose(self.arrow, wxyz=wxyz, position=(0.0, 0.0, height))

    def speed_text(self, gamma: float, units: Units | None) -> str:
        """The text beside the arrow."""
        speed = measure("gamma", units).text(gamma, 4)
        return speed if units else f"speed {speed}"

    def show_hub(self, beam: Beam, ground: float, *, rotating_frame: bool) -> None:
        """Place the hub with its bolts, and the post on the floor. Where several beams are drawn,
        a hub that would cover another beam is replaced by a small one at the clamp."""
        inward, radius, centre = beam.delta < 0, hub_radius(beam), 0.0
        if not self.alone and (inward or rotating_frame):
            inward, radius, centre = False, MIN_HUB, beam.delta - min(abs(beam.delta), MIN_HUB)
        self.post.visible = self.alone and not inward
        self.post.height = -ground
        self.post.position = (0.0, 0.0, ground / 2)
        body = hub_body(radius, inward=inward)
        set_surface(self.scene, self.hub, body.vertices + [centre, 0.0, 0.0], body.faces)
        size = 0.2 * HOOP if inward else min(BOLT_SIZE[0] * radius, 0.02)
        place = radius + HOOP / 2 if inward else radius - 2.2 * size
        angle = np.linspace(0.0, 2 * np.pi, BOLTS, endpoint=False) + np.pi / BOLTS
        top = (HOOP_HEIGHT if inward else HUB_HEIGHT) / 2
        positions = np.full((BOLTS, 3), top + BOLT_SIZE[1] / 2)
        positions[:, :2] = place * direction(angle) + [centre, 0.0]
        sizes = np.tile([size, size, BOLT_SIZE[1]], (BOLTS, 1))
        self.scene.set_properties(self.bolts, batched_positions=positions, batched_scales=sizes)

    def show_arrow(self, beam: Beam, size: float) -> None:
        """Place the arrow and the speed beside the hub, or on a large one; size: relative."""
        radius, middle = arrow_place(beam, size)
        ribbon = arrow(radius, middle, size)
        self.scene.set_properties(self.arrow, vertices=np.asarray(ribbon.vertices))
        self.speed_angle = middle - arrow_turn(radius, size) / 2 - ARROW_GAP * size / radius
        self.speed_gap = SPEED_GAP if middle and beam.delta >= 0 else 0.0  # beside a small hub
        self.speed_place = np.append(radius * direction(self.speed_angle), ARROW_HEIGHT)
        self.scene.set_pose(self.speed.point, position=self.speed_place)

    def rotate(self, angle: float, share: float) -> None:
        """Show the hub at `angle` [rad]; share: of the rotating frame in the view, 0 .. 1. While
        the beam passes the point of the speed, that is on the other side of the hub."""
        self.scene.set_pose(self.floor, wxyz=axis_rotation(-share * angle))
        if self.speed.text:
            distance = math.remainder((1 - share) * angle - self.speed_angle, 2 * math.pi)
            side = -1 if abs(distance) < self.speed_gap else 1
            self.scene.set_pose(self.speed.point, position=side * self.speed_place)


def scale_lines(radius: float) -> np.ndarray:
    """Lines (n, 2, 3) on a floor: a circle every half beam length, a mark every ten degrees, a
    longer one every thirty."""
    angle = np.linspace(0.0, 2 * np.pi, TICKS, endpoint=False)
    inner = np.where(np.arange(TICKS) % 3 == 0, radius - 0.12, radius - 0.05)
    ends = np.stack([inner, np.full(TICKS, radius - 0.01)], 1)
    marks = ends[..., None] * direction(angle)[:, None]
    circle = direction(np.linspace(0.0, 2 * np.pi, 145))
    pieces = np.stack([circle[:-1], circle[1:]], 1)
    rings = [ring * pieces for ring in np.arange(0.5, radius - 0.13, 0.5)]
    flat = np.concatenate([marks, *rings])
    height = np.full((*flat.shape[:2], 1), FLOOR_THICKNESS / 2 + 0.002)
    return np.concatenate([flat, height], 2).astype(np.float32)


def arrow_place(beam: Beam, size: float) -> tuple[float, float]:
    """Radius of the arrow and angle [rad] of its middle."""
    radius = hub_radius(beam)
    if beam.delta < 0:
        return radius + HOOP + 0.06, math.pi
    if radius < LARGE_HUB:
        return radius + 0.09, math.pi
    return radius - 0.12 * size, 0.0


def arrow_turn(radius: float, size: float) -> float:
    """The angle [rad] between the ends of an arrow."""
    return min(size * ARROW_LENGTH / radius, 1.25 * math.pi)


def arrow(radius: float, middle: float, size: float = 1.0) -> trimesh.Trimesh:
    """A flat arrow, curved about the axis in the direction of rotation."""
    turn = arrow_turn(radius, size)
    head = min(size * ARROW_HEAD / radius, turn / 2)
    shaft = np.linspace(middle - turn / 2, middle + turn / 2 - head, 40)
    angle = np.append(np.repeat(shaft, 2), [shaft[-1], shaft[-1], middle + turn / 2])
    across = np.append(np.tile([-1.0, 1.0], len(shaft)), [-2.4, 2.4, 0.0])
    across = radius + size * ARROW_WIDTH * across
    vertices = np.full((len(angle), 3), ARROW_HEIGHT)
    vertices[:, :2] = across[:, None] * direction(angle)
    first = 2 * np.arange(len(shaft) - 1)[:, None]
    faces = np.concatenate([first + [0, 1, 3], first + [0, 3, 2], [np.arange(3) + 2 * len(shaft)]])
    return trimesh.Trimesh(vertices, faces, process=False)


def hub_body(radius: float, *, inward: bool) -> trimesh.Trimesh:
    """A drum, or the ring that an inward beam is clamped to from inside."""
    if inward:
        return trimesh.creation.annulus(radius, radius + HOOP, HOOP_HEIGHT, sections=160)
    return trimesh.creation.cylinder(radius, HUB_HEIGHT, sections=160)
