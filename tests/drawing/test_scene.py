"""The scene without a browser: its sizes, viewpoint and colours, and its motion, of modes at their
phases on one clock (see test_pictures.py for how it looks)."""

import math
from dataclasses import replace

import numpy as np
import pytest
from helpers import sampled
from hypothesis import example, given, settings
from hypothesis import strategies as st
from live.visitor import PAPER
from strategies import beams

from beamviz.beam import Beam
from beamviz.drawing import BeamView, camera, colours, stacked_heights
from beamviz.drawing.beam_mesh import DrawnBeam, to_hub_frame
from beamviz.drawing.modes import SampledModes, displacement, playback_rate
from beamviz.drawing.scene_graph import SceneGraph
from beamviz.drawing.sizes import collar_size, drawn_bodies, section_size
from beamviz.scene import MAX_AMPLITUDE, Camera, ViewOptions
from beamviz.solver import solve


def projected(points: np.ndarray, view: Camera) -> np.ndarray:
    """Points (n, 3) in front of a camera as (n, 2) to the right and down from the middle of the
    picture, in halves of its height."""
    position = np.array(view.position)
    seen = (points - position) @ camera.axes(position - view.look_at)
    assert (seen[:, 2] > 0).all()
    return seen[:, :2] / (seen[:, 2:] * math.tan(camera.FIELD_OF_VIEW / 2))


@pytest.fixture
def scene() -> BeamView:
    """A beam in a scene without a page."""
    return BeamView(SceneGraph())


@pytest.mark.parametrize("alpha", [1e-3, 1.0, 100.0])
def test_the_mass_has_the_density_of_the_beam_and_encloses_it(alpha):
    """Its volume is alpha times that of the beam."""
    beam = Beam(alpha=alpha)
    (length, radius), section = collar_size(beam, *drawn_bodies(beam)), section_size(beam)
    inside = math.prod(section)
    assert length * (math.pi * radius**2 - inside) == pytest.approx(alpha * inside)
    assert math.hypot(*section) / 2 < radius < 0.6


@given(
    beams(alpha=(0, 100), delta=(0, 5)),
    st.booleans(),
    st.floats(0.5, 3.0),
    st.sampled_from([1, 5]),
    st.sampled_from([0.0, 0.3, 0.6]),
)
def test_the_beam_is_inside_the_picture_and_fills_it(beam, rotating_frame, aspect, rows, covered):
    """Every corner of all rows is inside, the farthest within 10 % of an edge; a page has room
    above for labels, and below for what covers the picture there."""
    shapes, heights = SampledModes.at_rest(beam, "chordwise"), stacked_heights(rows)
    picture = camera.viewpoint(shapes, rotating_frame, aspect, heights=heights)
    page = camera.fitted(shapes, rotating_frame, aspect, heights, covered)
    for view, top, below in ((Camera(tuple(picture)), 1.0, 1.0), (page, 0.8, 1 - covered)):
        across, down = projected(camera.corners(shapes, rotating_frame, heights), view).T
        nearest = max(np.abs(across).max() / aspect, down.max() / below, -down.min() / top)
        assert 0.9 < nearest <= 1


@pytest.mark.parametrize("beam", [Beam(alpha=1), Beam(gamma=4, delta=-1)], ids=["straight", "bent"])
def test_the_title_of_a_row_is_beside_its_beam(scene, beam):
    """Not over one that is bent back past its clamp."""
    shapes = sampled(beam, state="stable")
    scene.show(DrawnBeam(shapes, ViewOptions(all_modes=True), title="B1"))
    points, _ = to_hub_frame(shapes, shapes.centreline)
    assert np.abs(points[:, 0] - scene.title.point.position[0]).min() > 0.15


def test_all_that_the_beam_sweeps_and_a_bent_beam_are_in_the_picture():
    """From outside the tip is inside it at every angle of the hub, its circle in the middle; in the
    rotating frame all of a bent beam, be the picture tall or wide."""
    turn = np.linspace(0, 2 * np.pi, 100)
    for delta in (-0.5, 0.0, 2.0):
        circle = max(abs(delta), abs(delta + 1)) * np.stack([np.cos(turn), np.sin(turn), 0 * turn])
        view = camera.fitted(SampledModes.at_rest(Beam(delta=delta), "chordwise"), False, 1.6)
        across, down = projected(circle.T, view).T
        assert -1.6 < across.min() < across.max() < 1.6
        assert -1 < down.min() < down.max() < 1
        assert abs(down.min() + down.max()) < 0.2
    shapes = sampled(Beam(delta=-1, gamma=4), state="bent")
    points, _ = to_hub_frame(shapes, shapes.centreline)
    for aspect in (0.6, 1.0, 1.8):
        view = camera.fitted(shapes, True, aspect)
        seen = np.abs(projected(points - camera.target(shapes, True), view))
        assert (seen < [aspect, 1]).all()


def test_the_floor_turns_in_the_rotating_frame_and_the_speed_is_never_near_the_beam(scene):
    """The floor turns backwards. From outside, the text of the speed changes its side instead."""
    around, rest = scene.surroundings, np.zeros(5)
    scene.show(DrawnBeam(sampled(Beam(gamma=3)), ViewOptions()))
    for share in (1.0, 0.0):
        scene.choose_frame(share)
        for hub in np.linspace(0, 2 * np.pi, 50):
            scene.move(rest, hub)
            half = share * hub / 2
            assert np.allclose(around.floor.wxyz, [math.cos(half), 0, 0, -math.sin(half)])
            x, y, _ = around.speed.point.position
            away = math.atan2(y, x) - (1 - share) * hub
            assert abs(math.remainder(away, 2 * math.pi)) > 0.8


# Motion


@pytest.mark.parametrize(
    ("options", "modes"), [({}, (0, 2)), ({}, (0, 1)), ({"coriolis": True}, (2,))]
)
def test_the_colours_end_at_the_largest_displacement(options, modes):
    """That of all points and times, which modes along and across the beam together do not reach by
    their sum."""
    shapes = sampled(PAPER, **options)
    drawn = DrawnBeam(shapes, ViewOptions(), sizes=np.where(np.isin(range(5), modes), 0.1, 0.0))
    turn = np.linspace(0, 2 * np.pi, 48, endpoint=False)
    farthest = 0.0
    for first in turn:
        for second in turn if len(modes) > 1 else [0.0]:
            phases = np.zeros(5)
            phases[list(modes)] = [first, second][: len(modes)]
            moved = displacement(shapes, phases, drawn.amplitudes)
            farthest = max(farthest, float(np.linalg.norm(moved, axis=1).max()))
    assert drawn.largest == pytest.approx(farthest, rel=0.01)
    if modes == (0, 2):
        assert drawn.largest < 0.15  # not 0.2


def test_the_playback_rate_suits_the_slowest_and_the_fastest_motion():
    """A period takes at least 0.6 s and, alone, 2.5 s; a rotation at least 1.5 s."""
    for frequencies, gamma, period in (([3.5], 0, 2.5), ([3.5, 200], 0, 0.6), ([3.5], 200, 1.5)):
        rate = playback_rate(np.array(frequencies), gamma)
        assert 2 * math.pi / max(*frequencies, gamma) / rate == pytest.approx(period)


def test_the_slowest_numbers_are_as_good_as_rest():
    """At which nothing moves; their own rate would be infinite."""
    at_rest = playback_rate(np.zeros(0), 0.0)
    assert playback_rate(np.array([0.0, 1e-320]), 5e-324) == at_rest
    assert playback_rate(np.array([3.5]), 5e-324) == playback_rate(np.array([3.5]), 0.0)


@pytest.mark.parametrize("coriolis", [False, True])
def test_signs_do_not_flip_while_a_slider_moves(coriolis):
    """For gamma 0 .. 30 each mode correlates with itself one step before, whatever its place."""
    shapes = sampled(Beam(alpha=1, beta=0.5), coriolis=coriolis)
    flipped = replace(shapes, modes=-shapes.modes)
    again = sampled(shapes.beam, flipped, coriolis=coriolis)
    assert np.allclose(again.modes, flipped.modes)
    swaps = 0
    for gamma in np.linspace(0.5, 30, 60):
        before = shapes
        shapes = sampled(shapes.beam.replace(gamma=gamma), before, coriolis=coriolis)
        swaps += shapes.labels != before.labels
        for label in {*shapes.labels} & {*before.labels}:
            old, new = (one.modes[one.labels.index(label)] for one in (before, shapes))
            overlap = np.vdot(old, new)
            assert overlap.real > 0.5 * abs(overlap)
    assert swaps


def test_with_coriolis_forces_a_point_moves_on_an_ellipse():
    """Complex shapes: a quarter of a period apart the tip is displaced across, then along. Real
    shapes take their sign from complex ones, and the other way round."""
    gyroscopic = sampled(PAPER, coriolis=True)
    phases = (np.full(5, phase) for phase in (math.pi / 2, 0.0))
    across, along = (displacement(gyroscopic, p, 0.15 * np.eye(5)[0])[-1] for p in phases)
    assert abs(across[1]) == pytest.approx(0.15, rel=0.01)
    assert abs(along[0]) > 1e-4
    assert np.abs([across[0], along[1]]).max() < 1e-9
    real = sampled(PAPER)
    back = sampled(PAPER, sampled(PAPER, real, coriolis=True))
    assert np.allclose(back.modes[:2], real.modes[:2])
    assert not np.iscomplexobj(back.modes)


def test_stretching_modes_never_fold_the_beam():
    """At the largest amplitude the points of the beam keep their order."""
    shapes = sampled(Beam(mu=12), modes=8)
    assert sum(label.startswith("S") for label in shapes.labels) >= 3
    for k in range(8):
        sizes = DrawnBeam(shapes, ViewOptions(amplitude=MAX_AMPLITUDE).only(k)).amplitudes
        moved = displacement(shapes, np.full(8, 1.5 * math.pi), sizes)
        assert (np.diff((shapes.centreline + moved)[:, 0]) > 0).all()


@pytest.mark.parametrize("coriolis", [False, True])
@settings(max_examples=30)
@given(beam=beams(alpha=(0, 100), gamma=(0, 50), delta=(0, 5)))
@example(beam=Beam(alpha=1, beta=1, gamma=4.65))  # at a veering axial and transverse motion mix
@example(beam=Beam(beta=2.4e-8, mu=26))  # so near the clamp that its motion is rounding error
def test_marked_nodes_are_those_of_the_solver(coriolis, beam):
    """To the three digits of a label, also in a layer at the mass as thin as two stations."""
    solution = solve(beam, coriolis=coriolis)
    for x, converged in zip(SampledModes.sampled(solution).nodes, solution.nodes, strict=True):
        assert x == pytest.approx(converged, abs=5e-4)


def test_colours_are_told_apart_without_their_hue():
    """Displacement gets lighter throughout; strain is lightest where there is none, and its two
    ends differ in blue against red, which all common colour blindness leaves apart."""
    part = np.linspace(0, 1, 50)
    maps = (colours.SEQUENTIAL, colours.DIVERGING)
    rising, falling = (colours.mapped(part, one) @ [0.2126, 0.7152, 0.0722] for one in maps)
    assert (np.diff(rising) > 0).all()
    assert abs(falling.argmax() - 24.5) < 2
    low, high = colours.mapped(np.array([0.0, 1.0]), colours.DIVERGING)
    assert min(low[2] - low[0], high[0] - high[2]) > 127
