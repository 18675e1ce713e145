"""The picture without a browser: its sizes, its viewpoint, and the scene in a server."""

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from drawing.shapes import BEAMS, PAPER, sampled, single_mode
from hypothesis import given
from hypothesis import strategies as st

from beamviz.beam import Beam
from beamviz.drawing import BeamView, camera
from beamviz.drawing.beam_mesh import DrawnMotion, to_hub_frame
from beamviz.drawing.camera import PageCamera
from beamviz.drawing.modes import SampledModes
from beamviz.drawing.objects import HIDDEN, hub_radius, mass_radius, section_size
from beamviz.scene import ViewOptions
from beamviz.server import run_server

# Sizes


def test_the_beam_is_as_thick_as_its_slenderness_says():
    """h = sqrt(12) / mu in the plane of motion, and thicker only when asked."""
    assert section_size(Beam(mu=70))[0] == pytest.approx(math.sqrt(12) / 70)
    assert section_size(Beam(mu=10000))[0] == pytest.approx(math.sqrt(12) / 10000)
    assert section_size(Beam(mu=10000), thicken=True)[0] == 0.04
    assert section_size(Beam(mu=10), thicken=True) == section_size(Beam(mu=10))


def test_the_volume_of_the_mass_follows_alpha():
    """Eight times the mass is twice as wide; a small one still shows; a large one is no planet."""
    assert mass_radius(Beam(alpha=8)) == pytest.approx(2 * mass_radius(Beam(alpha=1)))
    assert mass_radius(Beam(alpha=1e-3)) > section_size(Beam())[1] / 2
    assert mass_radius(Beam(alpha=100)) < 0.4


def test_the_hub_has_the_radius_delta_and_never_vanishes():
    """True to delta on both sides of 0; a small drum at 0."""
    assert hub_radius(Beam(delta=1.5)) == 1.5
    assert hub_radius(Beam(delta=-1.5)) == 1.5
    assert hub_radius(Beam(delta=0)) == 0.05


def test_an_inward_beam_points_from_the_rim_to_the_axis():
    """delta = -1: the clamp is at x = -1 on the rim, the tip at the axis."""
    shapes = SampledModes.at_rest(Beam(delta=-1), "chordwise")
    points, _ = to_hub_frame(shapes, shapes.centreline)
    assert np.allclose(points[0], [-1, 0, 0])
    assert np.allclose(points[-1], [0, 0, 0], atol=1e-12)


# Viewpoint


@given(BEAMS, st.booleans(), st.floats(0.5, 3.0), st.sampled_from([0.0, 0.25]))
def test_the_beam_is_inside_the_picture_and_fills_it(beam, rotating_frame, aspect, lift):
    """Every corner is inside; the nearest fit touches an edge to within 10 %."""
    shapes = SampledModes.at_rest(beam, "chordwise")
    position = camera.viewpoint(shapes, rotating_frame, aspect, lift)
    seen = (camera.corners(shapes, rotating_frame) - position) @ camera.axes(position)
    tall = math.tan(camera.FIELD_OF_VIEW / 2)
    wide = np.abs(seen[:, 0] / seen[:, 2]).max() / (tall * aspect)
    high = np.abs(seen[:, 1] / seen[:, 2]).max() / (tall * (1 - lift))
    assert (seen[:, 2] > 0).all()
    assert 0.9 < max(wide, high) <= 1


# The scene in a real (unwatched) server


def test_the_scene_draws_a_beam_and_greys_it():
    """Pieces lie on the beam, the mass on its station; words grey all of it and stand above."""
    shapes = sampled()
    with run_server() as server:
        scene = BeamView(server.scene)
        scene.show(shapes, ViewOptions(), [1])
        scene.move(np.full(5, np.pi / 2), 0.15 * np.eye(5)[1], angle=0.3)
        drawn = scene.shapes
        points, _ = to_hub_frame(drawn, drawn.centreline + single_mode(drawn, 1, 0.25))
        middle = (points[:-1] + points[1:]) / 2
        assert np.allclose(scene.beam.batched_positions, middle, atol=1e-6)
        assert np.allclose(scene.mass.batched_positions, points[[drawn.mass]], atol=1e-6)
        assert len(np.unique(scene.beam.batched_colors, axis=0)) > 20
        assert scene.nodes.labels[0].text == f"B2 node at {shapes.nodes[1][0]:.3f}"
        assert scene.warning.visible is False
        scene.show(shapes, ViewOptions(), [1], warning="No equilibrium")
        scene.move(np.full(5, np.pi / 2), 0.15 * np.eye(5)[1], angle=0.3)
        assert len(np.unique(scene.beam.batched_colors, axis=0)) == 1
        assert bool(scene.warning.visible) is not False
        assert scene.nodes.labels[0].visible is False


def test_labels_of_nodes_can_be_read_and_leave_room():
    """Thirteen pixels high on a laptop as on a phone; four of them share the beam."""
    shapes = sampled(Beam())
    with run_server() as server:
        scene = BeamView(server.scene)
        for scale in (250.0, 500.0):
            for mode in (1, 4):
                view = ViewOptions().only(mode)
                seen = DrawnMotion.of(shapes, 0.15 * np.eye(5)[mode], view.colouring, scale)
                scene.show(shapes, view, [mode], motion=seen)
                heights = {tag.font_scene_height for tag in scene.nodes.labels if tag.visible}
                (height,) = heights
                assert height * scale == pytest.approx(13) if mode == 1 else height <= 0.0301


def test_the_frame_of_view_turns_the_hub_or_the_ground():
    """Riding, the ground turns backwards under a still hub; beside it, the hub turns."""
    shapes = sampled()
    with run_server() as server:
        scene = BeamView(server.scene)
        for rotating_frame in (True, False):
            scene.show(shapes, ViewOptions(rotating_frame=rotating_frame), [0])
            scene.move(np.zeros(5), np.zeros(5), angle=0.3)
            still, moving = (
                (scene.rotor, scene.surroundings.grid)
                if rotating_frame
                else (scene.surroundings.grid, scene.rotor)
            )
            assert np.allclose(still.wxyz, [1, 0, 0, 0])
            assert moving.wxyz[3] == pytest.approx(math.sin(-0.15 if rotating_frame else 0.15))


def test_flapwise_motion_is_out_of_the_plane_of_rotation():
    """Across is z flapwise and y chordwise; the thickness turns with it."""
    for plane, axis in (("chordwise", 1), ("flapwise", 2)):
        shapes = sampled(PAPER, plane=plane)
        with run_server() as server:
            scene = BeamView(server.scene)
            scene.show(shapes, ViewOptions(), [0])
            scene.move(np.full(5, np.pi / 2), 0.15 * np.eye(5)[0], angle=0.0)
            assert np.abs(scene.beam.batched_positions[:, axis]).max() > 0.1
            assert np.abs(scene.beam.batched_positions[:, 3 - axis]).max() == 0
            lengths = scene.beam.batched_scales
            assert lengths is not None
            assert lengths[0, axis] == pytest.approx(section_size(PAPER)[0], rel=1e-6)


def test_there_is_no_mass_without_a_mass_and_a_hoop_for_an_inward_beam():
    """alpha = 0 hides the sphere; delta < 0 swaps the drum for a hoop."""
    with run_server() as server:
        scene = BeamView(server.scene)
        scene.show(sampled(Beam()), ViewOptions(), [0])
        assert scene.mass.batched_scales is not None
        assert np.allclose(scene.mass.batched_scales, HIDDEN)
        assert (scene.surroundings.drum.visible, scene.surroundings.hoop.visible) == (True, False)
        scene.show(SampledModes.at_rest(Beam(delta=-0.5), "chordwise"), ViewOptions(), [])
        assert (scene.surroundings.drum.visible, scene.surroundings.hoop.visible) == (False, True)
        inner = np.linalg.norm(scene.surroundings.hoop.vertices[:, :2], axis=1).min()
        assert inner == pytest.approx(0.5, rel=1e-3)


def test_a_viewpoint_that_a_page_overtook_is_chosen_again():
    """A page that tells of its old viewpoint while it is sent two others may end with the first
    of them; where a visitor has moved the camera, it stays."""
    view: Any = SimpleNamespace(position=(0, 0, 3), look_at=(0, 0, 0), aspect=1.8, image_height=900)
    page_camera, shapes = PageCamera(view), SampledModes.at_rest(Beam(), "chordwise")
    page_camera.look_at(shapes, True, [0.0], settled=True)
    wide = view.position, view.look_at
    view.aspect = 1.0
    assert page_camera.reshaped
    page_camera.look_at(shapes, True, [0.0], settled=True)
    assert not page_camera.overtaken
    view.position, view.look_at = wide
    assert page_camera.overtaken
    view.position = (1.0, -2.0, 1.0)
    assert not page_camera.overtaken
