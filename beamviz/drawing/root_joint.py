"""The hinge at the root of a beam that is not clamped: a fork, a pin, and a spring if there is one.

The pin is parallel to the normal of the plane of motion, in which the beam rotates about it.
"""

import math
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray

from beamviz.beam import Beam
from beamviz.drawing import beam_mesh, colours
from beamviz.drawing.beam_mesh import NORMALS
from beamviz.drawing.objects import add_mesh, set_surface
from beamviz.drawing.scene_graph import DrawnScene
from beamviz.drawing.surroundings import HOOP_HEIGHT, HUB_HEIGHT, MIN_HUB

EYES = (0.028, 0.042)  # [beam lengths] least and largest radius of the ends of the fork
LUG = 0.012  # thickness of a side of the fork
PIN = 0.5  # radius over that of the eye
HEAD = 0.012  # of the pin beyond the fork, and at its upper end beyond the hub
TURNS, SPRING_RADIUS, WIRE = 2.75, 1.9, (0.006, 0.012)  # radius over that of the eye
POINTS = 100  # of the spring


class RootJoint:
    """The hinge of a beam, hidden where that is clamped."""

    def __init__(self, scene: DrawnScene, root: str):
        self.scene = scene
        look: Any = {"cast_shadow": True, "visible": False}
        self.fork = add_mesh(scene, f"{root}/rotor/fork", color=colours.HUB, **look)
        self.pin = add_mesh(scene, f"{root}/rotor/pin", color=colours.MASS, **look)
        self.spring = add_mesh(scene, f"{root}/rotor/spring", color=colours.MASS, **look)

    @property
    def nodes(self) -> list[Any]:
        """The nodes that are shown."""
        return [node for node in (self.fork, self.pin, self.spring) if node.visible]

    def show(self, beam: Beam, plane: str, section: NDArray) -> None:
        """Show the hinge of a beam, with the section (2,) at its root."""
        self.fork.visible = self.pin.visible = beam.root < math.inf
        self.spring.visible = 0 < beam.root < math.inf
        if beam.root == math.inf:
            return
        thickness, breadth = section
        eye = min(max(0.9 * thickness, EYES[0]), EYES[1])
        half = breadth / 2 + LUG
        top = max(half, half_hub(beam, plane)) + HEAD
        axes = np.stack([[1.0, 0.0, 0.0], np.cross(NORMALS[plane], [1, 0, 0]), NORMALS[plane]], 1)
        parts = (
            (self.fork, fork(eye, half)),
            (self.pin, pin(PIN * eye, -half - HEAD, top)),
            (self.spring, spring(eye, top - WIRE[1] / 2)),
        )
        for node, mesh in parts:
            if node.visible:
                vertices = mesh.vertices @ axes.T + [beam.delta, 0.0, 0.0]
                set_surface(self.scene, node, vertices, np.asarray(mesh.faces))


def half_hub(beam: Beam, plane: str) -> float:
    """Half the size of the hub along the pin, where that may be inside it."""
    if plane == "flapwise":
        return MIN_HUB if 0 <= beam.delta < MIN_HUB else 0.0
    return (HOOP_HEIGHT if beam.delta < 0 else HUB_HEIGHT) / 2


def fork(eye: float, half: float) -> trimesh.Trimesh:
    """Two sides with an eye around the z axis, up to a height of `half`, that begin at -x."""
    arm = trimesh.creation.box([eye, 2 * eye, LUG])
    arm.apply_translation([-eye / 2, 0.0, 0.0])
    side = arm + trimesh.creation.cylinder(eye, LUG, sections=32)
    both = []
    for height in (half - LUG / 2, LUG / 2 - half):
        both.append(side.copy())
        both[-1].apply_translation([0.0, 0.0, height])
    return both[0] + both[1]


def pin(radius: float, bottom: float, top: float) -> trimesh.Trimesh:
    """A cylinder around the z axis between two heights."""
    ends = [[0.0, 0.0, bottom], [0.0, 0.0, top]]
    return trimesh.creation.cylinder(radius, segment=ends, sections=32)


def spring(eye: float, height: float) -> trimesh.Trimesh:
    """A flat spiral around the z axis at a height."""
    angle = np.linspace(0.0, 2 * math.pi * TURNS, POINTS)
    radius = np.linspace(PIN * eye, SPRING_RADIUS * eye, POINTS)
    points = np.stack([radius * np.cos(angle), radius * np.sin(angle), 0 * angle + height], 1)
    vertices, faces = beam_mesh.swept(points, NORMALS["chordwise"], WIRE)
    return trimesh.Trimesh(vertices, faces, process=False)
