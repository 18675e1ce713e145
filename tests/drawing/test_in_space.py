"""A beam that bends in both planes at once in the scene: its motion and its turned section."""

import math
from dataclasses import replace

import numpy as np
import pytest
from helpers import sampled
from viser.transforms import SO3

from beamviz.beam import Beam
from beamviz.blade import Blade, Mass
from beamviz.drawing import BeamView
from beamviz.drawing.beam_mesh import DrawnBeam, outline, segments, swept
from beamviz.drawing.scene_graph import SceneGraph
from beamviz.drawing.sizes import section_size
from beamviz.scene import ViewOptions
from beamviz.solver import solve

PITCHED = Beam(flap=0.25, pitch=30, gamma=5, delta=0.2)
TWISTED = Beam(flap=0.25, pitch=-20, twist=60, gamma=5)
FLAT = Blade((0, 1), (1, 1), (1, 1), (1, 1), flap=(0.25, 0.25), twist=(10.0, 70.0))


def show(beam: Beam, mode: int, plane: str = "both", **view: bool) -> BeamView:
    """A beam in a mode (0-based) at its largest displacement."""
    drawn, shapes = BeamView(SceneGraph()), sampled(beam, plane=plane)
    drawn.show(DrawnBeam(shapes, replace(ViewOptions(), **view).only(mode)))
    drawn.move(np.full(len(shapes.modes), math.pi / 2), 0.0)
    return drawn


@pytest.mark.parametrize("beam", [PITCHED, TWISTED, Beam(blade=FLAT, gamma=3)])
@pytest.mark.parametrize("mode", [0, 1, 2])
def test_the_beam_is_drawn_where_the_solution_has_it(beam, mode):
    """Along the beam, in the plane of rotation (y) and out of it (z), with the amplitude chosen."""
    drawn, solution = show(beam, mode), solve(beam, plane="both")
    shape = solution.shape(mode, drawn.shapes.x)
    shape *= drawn.drawn.amplitudes[mode] / np.linalg.norm(shape, axis=1).max()
    rest = solution.equilibrium.position(drawn.shapes.x)[:, 0] + beam.delta
    moved = drawn.line - np.stack([rest, 0 * rest, 0 * rest], 1)
    assert moved == pytest.approx(shape, abs=1e-5)
    assert np.ptp(moved[:, 1]) > 1e-3
    assert np.ptp(moved[:, 2]) > 1e-3


def test_the_corners_of_a_turned_section():
    """At the root by the pitch, at the tip by pitch and twist, from the plane of rotation towards
    its axis; pieces, outline and equilibrium have the same section."""
    drawn = show(TWISTED, 0)
    y, z = np.array(section_size(TWISTED)) / 2
    for vertices, turn in zip(
        np.reshape(drawn.reference.equilibrium.vertices, (-1, 4, 3))[[0, -1]],
        np.radians([-20, 40]),
        strict=True,
    ):
        c, s = math.cos(turn), math.sin(turn)
        corners = [[a * y * c - b * z * s, a * y * s + b * z * c] for a, b in CORNERS]
        expected = 0.97 * np.array(corners)  # so that no faces coincide
        assert vertices[:, 1:] == pytest.approx(expected, abs=1e-6)
    for k, turn in ((0, -20), (-1, 40)):
        piece = SO3(drawn.beam.batched_wxyzs[k]).as_matrix()
        level = math.degrees(math.atan2(piece[2, 1], piece[1, 1]))
        assert level == pytest.approx(turn, abs=2)
    assert drawn.beam.batched_scales[:, 1] == pytest.approx(2 * y)
    assert drawn.beam.batched_scales[:, 2] == pytest.approx(2 * z)


CORNERS = [(1, 1), (-1, 1), (-1, -1), (1, -1)]


def test_pitch_of_90_degrees_is_the_other_plane():
    """The pieces of a section on edge are those of one that is flat, as bodies in space."""
    points = np.stack([np.linspace(0, 1, 30), 0.1 * np.linspace(0, 1, 30) ** 2, np.zeros(30)], 1)
    edge = np.tile([0.0, -1.0, 0.0], (30, 1))
    flat = swept(points, np.array([0.0, 0.0, 1.0]), (0.1, 0.02))[0].reshape(-1, 4, 3)
    turned = swept(points, edge, (0.02, 0.1))[0].reshape(-1, 4, 3)
    assert np.roll(turned, 1, axis=1) == pytest.approx(flat, abs=1e-12)
    assert len(outline(points, edge, (0.02, 0.1))) == len(outline(points, edge[0], (0.02, 0.1)))
    _, wxyz, sizes = segments(points, edge, (0.02, 0.1))
    _, plain, others = segments(points, np.array([0.0, 0.0, 1.0]), (0.1, 0.02))
    boxes = SO3(wxyz).as_matrix() * sizes[:, None]
    same = SO3(plain).as_matrix() * others[:, None]
    assert boxes[..., [0, 2, 1]] * [1, -1, 1] == pytest.approx(same, abs=1e-12)


def test_a_body_turns_with_the_section():
    """Its box is as the piece of the beam that carries it."""
    beam = TWISTED.replace(masses=(Mass(0.3, 1.0, (0.001, 0.004, 0.004)),), alpha=0)
    drawn = show(beam, 0)
    _, wxyz = drawn.bodies.places()
    assert wxyz[0] == pytest.approx(drawn.beam.batched_wxyzs[-1])


def test_a_section_that_is_not_turned_is_drawn_as_in_one_plane():
    """A mode in the plane of rotation, and one out of it."""
    beam = Beam(flap=0.25, gamma=5)
    solution = solve(beam, plane="both")
    for label, plane in (("L1", "chordwise"), ("F1", "flapwise")):
        drawn = show(beam, solution.labels.index(label))
        single = show(beam, 0, plane)
        tip, expected = drawn.line[-1], single.line[-1]
        assert tip == pytest.approx(expected, abs=1e-5)
        ends = (drawn, single)
        breadths = [
            np.ptp(np.reshape(one.reference.equilibrium.vertices, (-1, 3)), axis=0) for one in ends
        ]
        assert breadths[0] == pytest.approx(breadths[1], abs=1e-6)
