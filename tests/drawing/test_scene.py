"""The scene without a browser: its sizes, its viewpoint, and its nodes in a server."""

import math
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from drawing.shapes import BEAMS, BENT, PAPER, projected, sampled, single_mode
from hypothesis import given
from hypothesis import strategies as st

from beamviz.beam import Beam
from beamviz.drawing import BeamView, camera, stacked_heights
from beamviz.drawing.beam_mesh import DrawnBeam, to_hub_frame
from beamviz.drawing.camera import CHANGE_TIME, PageCamera, initial
from beamviz.drawing.modes import SampledModes
from beamviz.drawing.objects import HIDDEN, mass_size, section_size
from beamviz.drawing.surroundings import floor_radius, hub_radius
from beamviz.scene import Camera, Scene, ViewOptions
from beamviz.server import run_server


@pytest.fixture
def scene() -> Iterator[BeamView]:
    """A beam in a server without visitors."""
    with run_server() as server:
        yield BeamView(server.scene)


def test_sizes_are_true_and_visible():
    """The thickness is h = sqrt(12) / mu, larger only on request. The volume of the mass is alpha
    times that of the beam, and it encloses the beam. The hub has the radius |delta|, at 0 a small
    one, and the floor reaches beyond the tip."""
    for mu, thicken, thickness in (
        (70, False, math.sqrt(12) / 70),
        (10000, False, math.sqrt(12) / 10000),
        (10000, True, 0.04),
        (10, True, math.sqrt(12) / 10),
    ):
        assert section_size(Beam(mu=mu), thicken)[0] == pytest.approx(thickness)
    for alpha in (1e-3, 1.0, 100.0):
        (length, radius), section = mass_size(Beam(alpha=alpha)), section_size(Beam())
        inside = math.prod(section)
        assert length * (math.pi * radius**2 - inside) == pytest.approx(alpha * inside)
        assert math.hypot(*section) / 2 < radius < 0.6
    assert all(floor_radius(Beam(delta=delta)) > abs(delta + 1) for delta in (-1.5, -0.5, 0, 2))
    assert [hub_radius(Beam(delta=delta)) for delta in (1.5, -1.5, 0)] == [1.5, 1.5, 0.05]


@given(BEAMS, st.booleans(), st.floats(0.5, 3.0), st.sampled_from([0.0, 0.25]))
def test_the_beam_is_inside_the_picture_and_fills_it(beam, rotating_frame, aspect, lift):
    """Every corner is inside; the nearest fit touches an edge to within 10 %."""
    shapes = SampledModes.at_rest(beam, "chordwise")
    view = Camera(tuple(camera.viewpoint(shapes, rotating_frame, aspect, lift)))
    seen = np.abs(projected(camera.corners(shapes, rotating_frame), view))
    assert 0.9 < (seen / [aspect, 1 - lift]).max() <= 1


def test_all_that_the_beam_sweeps_and_a_bent_beam_are_in_the_picture():
    """From outside the tip is inside it at every angle of the hub, its circle in the middle; in the
    rotating frame all of a bent beam, and all rows of modes, be the picture tall or wide."""
    turn = np.linspace(0, 2 * np.pi, 100)
    for delta in (-0.5, 0.0, 2.0):
        circle = max(abs(delta), abs(delta + 1)) * np.stack([np.cos(turn), np.sin(turn), 0 * turn])
        view = camera.fitted(SampledModes.at_rest(Beam(delta=delta), "chordwise"), False, 1.6)
        across, down = projected(circle.T, view).T
        assert np.abs(across).max() < 1.6
        assert np.abs(down).max() < 1
        assert abs(down.min() + down.max()) < 0.2
    shapes = sampled(BENT, state="bent")
    points, _ = to_hub_frame(shapes, shapes.centreline)
    for aspect in (0.6, 1.0, 1.8):
        view = camera.fitted(shapes, True, aspect)
        seen = np.abs(projected(points - camera.target(shapes, True), view))
        assert (seen < [aspect, 1]).all()
    straight, heights = SampledModes.at_rest(PAPER, "chordwise"), stacked_heights(5)
    for aspect in (0.6, 2.0):
        view = Camera(tuple(camera.viewpoint(straight, True, aspect, 0.1, heights)))
        for height in heights:
            corners = camera.corners(straight, True) + [0, 0, height]
            assert (np.abs(projected(corners, view)) <= [aspect, 1]).all()


def test_a_scene_draws_a_beam_and_greys_it(scene):
    """Pieces are on the beam, the mass at its station, rings around the section at nodes; below a
    warning all of it is grey."""
    shapes = sampled()
    for warning, thicken in (("", False), ("", True), ("No equilibrium", True)):
        scene.show(DrawnBeam.of(shapes, ViewOptions(thicken=thicken), warning=warning))
        scene.move(np.full(5, np.pi / 2), angle=0.3)
        drawn = scene.shapes
        points, _ = to_hub_frame(drawn, drawn.centreline + single_mode(drawn, 1, 0.25))
        middle = (points[:-1] + points[1:]) / 2
        assert np.allclose(scene.beam.batched_positions, middle, atol=1e-6)
        assert np.allclose(scene.mass.batched_positions, points[[drawn.mass]], atol=1e-6)
        ring = 1.3 * np.array(section_size(PAPER, thicken))
        assert warning or np.allclose(scene.nodes.collars.batched_scales[0, 1:], ring)
        colours = len(np.unique(scene.beam.batched_colors, axis=0))
        assert colours == 1 if warning else colours > 20
        node = f"B2 node at {shapes.nodes[1][0]:.3f}"
        speed = f"speed γ = {shapes.beam.gamma:.4g}"
        assert [one.text for one in scene.captions] == [warning or node, speed]


@pytest.mark.parametrize("rotating_frame", [True, False])
def test_the_frame_rotates_the_hub_or_the_floor(scene, rotating_frame):
    """In the rotating frame the floor rotates backwards, else the hub rotates."""
    scene.show(DrawnBeam.of(sampled(), ViewOptions(rotating_frame=rotating_frame)))
    scene.move(np.zeros(5), angle=0.3)
    half_angles = [-0.15, 0] if rotating_frame else [0, 0.15]
    for node, half in zip((scene.surroundings.floor, scene.rotor), half_angles, strict=True):
        assert np.allclose(node.wxyz, [math.cos(half), 0, 0, math.sin(half)])


@pytest.mark.parametrize(("plane", "axis"), [("chordwise", 1), ("flapwise", 2)])
def test_flapwise_motion_is_out_of_the_plane_of_rotation(scene, plane, axis):
    """Across is z flapwise and y chordwise, the direction of the thickness."""
    scene.show(DrawnBeam.of(sampled(PAPER, plane=plane), ViewOptions().only(0)))
    scene.move(np.full(5, np.pi / 2), angle=0.0)
    assert np.abs(scene.beam.batched_positions[:, axis]).max() > 0.1
    assert np.abs(scene.beam.batched_positions[:, 3 - axis]).max() == 0
    assert scene.beam.batched_scales is not None
    assert scene.beam.batched_scales[0, axis] == pytest.approx(section_size(PAPER)[0], rel=1e-6)


def test_the_hub_its_arrow_and_the_mass_are_those_of_the_beam(scene):
    """A beam without a mass has none; delta < 0 swaps the drum for a hoop, from whose rim the beam
    points to the axis. Arrow and speed are hidden at rest, and the text is never near the beam."""
    around = scene.surroundings
    scene.show(DrawnBeam.of(sampled(Beam()), ViewOptions()))
    assert np.allclose(np.asarray(scene.mass.batched_scales), HIDDEN)
    assert (around.drum.visible, around.hoop.visible) == (True, False)
    assert (around.arrow.visible, around.speed.text) == (False, "")
    scene.show(DrawnBeam.of(sampled(Beam(gamma=3)), ViewOptions()))
    assert (around.arrow.visible, around.speed.text) == (True, "speed γ = 3")
    scene.choose_frame(0.0)
    for hub in np.linspace(0, 2 * np.pi, 50):
        scene.move(np.zeros(5), hub)
        x, y, _ = around.speed.point.position
        assert abs(math.remainder(math.atan2(y, x) - hub, 2 * math.pi)) > 0.8
    assert (around.arrow.vertices[:, 0] < 0.05).all()
    inward = SampledModes.at_rest(Beam(delta=-0.5), "chordwise")
    points, _ = to_hub_frame(inward, inward.centreline)
    assert np.allclose(points[[0, -1]], [[-0.5, 0, 0], [0.5, 0, 0]], atol=1e-12)
    scene.show(DrawnBeam.of(inward, ViewOptions()))
    assert (around.arrow.visible, around.speed.text) == (False, "")
    assert (around.drum.visible, around.hoop.visible) == (False, True)
    inner = np.linalg.norm(around.hoop.vertices[:, :2], axis=1).min()
    assert inner == pytest.approx(0.5, rel=1e-3)


def test_a_camera_that_crossed_a_message_of_the_page_is_sent_again():
    """A page that reports its old viewpoint while it gets two others may end with the first of
    these, a busy one with the initial viewpoint; one chosen by the visitor is kept."""
    view: Any = SimpleNamespace(position=(0, 0, 3), look_at=(0, 0, 0), aspect=1.8, image_height=900)
    start = initial(Scene(Beam()))
    page_camera, shapes = PageCamera(view, start), SampledModes.at_rest(Beam(), "chordwise")
    page_camera.look_at(shapes, True, [0.0], settled=True)
    wide = view.position, view.look_at
    view.aspect = 1.3
    assert page_camera.reshaped
    page_camera.look_at(shapes, True, [0.0], settled=True)
    assert not page_camera.outdated
    for old in (wide, (start.position, start.look_at)):
        view.position, view.look_at = old
        assert page_camera.outdated
        assert page_camera.chosen is None
    view.position = (1.0, -2.0, 1.0)
    assert not page_camera.outdated
    assert page_camera.chosen.position == view.position


@pytest.mark.parametrize("back", [None, 15])
def test_a_change_of_view_is_eased(scene, back):
    """Camera, place and floor go from one view to the other in small steps, with the hub at more
    than half a turn, which passes a whole one meanwhile; also where the visitor turns back."""
    view: Any = SimpleNamespace(aspect=1.8, image_height=900)
    page_camera, shapes = PageCamera(view, Camera((1.0, 1.0, 1.0))), sampled(Beam(gamma=3))
    page_camera.eased = True
    page_camera.look_at(shapes, False, [0.0], settled=True)
    outside = np.array(view.position)
    scene.show(DrawnBeam.of(shapes, ViewOptions()))
    view.position, view.look_at = np.array(view.position), np.array(view.look_at)
    page_camera.look_at(shapes, True, [0.0], settled=True)
    assert np.allclose(view.position, outside)
    path, places, angle, rest = [], [], 6.0, np.zeros(len(shapes.modes))
    while page_camera.change:
        page_camera.step(CHANGE_TIME / 40, angle := (angle + 0.02) % (2 * np.pi))
        path.append(np.array(view.position))
        if change := page_camera.change:
            scene.choose_frame(change.rotating_share)
            scene.move(rest, change.angle)
            floor = scene.surroundings.floor.wxyz
            places.append([*scene.frame.position, 2 * math.atan2(floor[3], floor[0])])
        if len(path) == back:
            page_camera.look_at(shapes, False, [0.0], settled=True)
    inside = back is None
    assert np.allclose(path[-1], camera.fitted(shapes, inside, view.aspect).position)
    turn = (0.02 - angle) * inside
    assert np.allclose(places[-1], [*-camera.target(shapes, inside), turn], atol=1e-5)
    for points in (path, places):
        ways = np.abs(np.diff(points, axis=0))
        assert ways.max() < 0.05 * np.linalg.norm(np.ptp(points, axis=0)) * (1 if inside else 4)
