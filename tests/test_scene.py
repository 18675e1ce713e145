"""The picture without a browser: sizes, bodies, motion, colours, viewpoint, words."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from beamviz.beam import Beam, Units
from beamviz.errors import NoEquilibrium
from beamviz.look import Look, within
from beamviz.mechanics.solve import solve
from beamviz.show import camera, colours, readout, sizes, tube, words
from beamviz.show.bodies import HIDDEN
from beamviz.show.controls import Wanted
from beamviz.show.hosting import hosted
from beamviz.show.motion import (
    Clock,
    Shapes,
    axial_strain,
    displacement,
    fitted_rate,
    largest_strain,
)
from beamviz.show.pieces import Seen
from beamviz.show.scene import Scene
from beamviz.show.stage import placed

PAPER = Beam(alpha=1, beta=0.5, gamma=10)
beams = st.builds(
    Beam,
    alpha=st.floats(0, 100),
    beta=st.floats(0, 1),
    gamma=st.floats(0, 50),
    delta=st.floats(0, 5),
    mu=st.floats(20, 500),
)


def sampled(beam: Beam = PAPER, **options: Any) -> Shapes:
    """The shapes of a beam."""
    return Shapes.sampled(solve(beam, **options))


def alone(shapes: Shapes, mode: int, phase: float, size: float = 0.15) -> np.ndarray:
    """Displacement with one mode (from 0) at `phase` of its period."""
    m = len(shapes.modes)
    return displacement(shapes, np.full(m, 2 * math.pi * phase), size * np.eye(m)[mode])


# Bodies


@given(st.floats(0.1, 2.0), st.floats(0.01, 0.2), st.sampled_from(["chordwise", "flapwise"]))
def test_the_swept_body_of_a_straight_beam_is_its_box(length, thickness, plane):
    """Closed, facing outwards, with the volume of the box."""
    x = np.linspace(0, length, 9)
    points, normal = tube.frame(np.stack([x, 0 * x], 1), plane)
    body = trimesh.Trimesh(*tube.swept(points, normal, thickness, 0.1), process=False)
    assert body.is_watertight
    assert body.is_winding_consistent
    assert body.volume == pytest.approx(length * thickness * 0.1, rel=1e-9)


def test_a_bent_body_stays_closed():
    """A section swept along two waves has no holes and keeps its volume to a per cent."""
    x = np.linspace(0, 1, 129)
    points, normal = tube.frame(np.stack([x, 0.1 * np.sin(2 * np.pi * x)], 1), "chordwise")
    length = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
    body = trimesh.Trimesh(*tube.swept(points, normal, 0.05, 0.08), process=False)
    assert body.is_watertight
    assert body.is_winding_consistent
    assert body.volume == pytest.approx(length * 0.05 * 0.08, rel=0.01)


@pytest.mark.parametrize("plane", ["chordwise", "flapwise"])
def test_pieces_follow_the_line_and_meet_outside_a_bend(plane):
    """Each piece runs along its part of the line; on an arc the outer edges touch."""
    angle = np.linspace(0, 1.5, 31)
    points, normal = tube.frame(np.stack([np.sin(angle), 1 - np.cos(angle)], 1), plane)
    centres, wxyz, lengths = tube.segments(points, normal, 0.1, 0.2)
    along = np.stack([rotated(q, [1, 0, 0]) for q in wxyz])
    across = np.stack([rotated(q, np.cross(normal, [1, 0, 0])) for q in wxyz])
    step = np.diff(points, axis=0)
    assert np.allclose(along, step / np.linalg.norm(step, axis=1, keepdims=True))
    outside = centres - 0.05 * across
    ends = outside + lengths[:, :1] / 2 * along
    starts = outside - lengths[:, :1] / 2 * along
    assert np.allclose(ends[1:-2], starts[2:-1], atol=1e-12)  # the first and last are cut square
    breadth = np.abs(normal).argmax()
    assert np.allclose(lengths[:, breadth], 0.2)
    assert np.allclose(np.delete(lengths, [0, breadth], axis=1), 0.1)


def rotated(wxyz: np.ndarray, vector: Any) -> np.ndarray:
    """A vector turned by a unit quaternion."""
    w, v = wxyz[0], wxyz[1:]
    return vector + 2 * np.cross(v, np.cross(v, vector) + w * np.asarray(vector))


@given(st.floats(0, 1), st.floats(0.005, 0.2))
def test_stations_follow_curvature_and_hold_the_mass(mass, layer):
    """They rise from 0 to 1, the mass, if not at an end, is one, and a bending layer gets more."""
    x = np.linspace(0, 1, 401)
    points = tube.stations(x, np.exp(-x / layer), mass)
    assert len(points) == tube.FINE + 1
    assert points[0] == 0
    assert points[-1] == 1
    assert (np.diff(points) > 0).all()
    assert np.abs(points - mass).min() < 1e-8
    assert (points < layer).sum() > 1.2 * layer * tube.FINE


@pytest.mark.parametrize("plane", ["chordwise", "flapwise"])
@given(
    alpha=st.floats(0, 100), beta=st.floats(0, 1), gamma=st.floats(0, 200), delta=st.floats(0, 5)
)
@settings(max_examples=30)
def test_nothing_is_seen_to_happen_between_stations(plane, alpha, beta, gamma, delta):
    """Even in the thin layers of the fastest beams, straight lines between stations are less than
    a fifth of a pixel off, where the beam takes 1000 and swings as far as it does at first."""
    beam = Beam(alpha, beta, gamma, delta, mu=200)
    try:
        solution = solve(beam, plane=plane)
    except NoEquilibrium:
        return
    shapes, x = Shapes.sampled(solution), np.linspace(0, 1, 4001)
    bends = solution.bending_fractions > 0.5
    exact, there = (solution.displacement(at)[:, 1, bends].T for at in (x, shapes.x))
    across = shapes.modes[bends, :, 1]
    far = np.abs(there).argmax(axis=1)[:, None]
    scale = np.take_along_axis(across, far, 1) / np.take_along_axis(there, far, 1)
    between = np.stack([np.interp(x, shapes.x, mode) for mode in across])
    off = np.abs(between - scale * exact).max(axis=1)
    assert (off * np.minimum(0.15, shapes.limits[bends]) < 2e-4).all()


# Sizes


def test_the_beam_is_as_thick_as_its_slenderness_says():
    """h = sqrt(12) / mu in the plane of motion, and thicker only when asked."""
    assert sizes.section(Beam(mu=70))[0] == pytest.approx(math.sqrt(12) / 70)
    assert sizes.section(Beam(mu=10000))[0] == pytest.approx(math.sqrt(12) / 10000)
    assert sizes.section(Beam(mu=10000), thicken=True)[0] == sizes.VISIBLE_THICKNESS
    assert sizes.section(Beam(mu=10), thicken=True) == sizes.section(Beam(mu=10))


def test_the_volume_of_the_mass_follows_alpha():
    """Eight times the mass is twice as wide; a small one still shows; a large one is no planet."""
    assert sizes.mass_radius(Beam(alpha=8)) == pytest.approx(2 * sizes.mass_radius(Beam(alpha=1)))
    assert sizes.mass_radius(Beam(alpha=1e-3)) > sizes.section(Beam())[1] / 2
    assert sizes.mass_radius(Beam(alpha=100)) < 0.4


def test_the_hub_has_the_radius_delta_and_never_vanishes():
    """True to delta on both sides of 0; a small drum at 0."""
    assert sizes.hub_radius(Beam(delta=1.5)) == 1.5
    assert sizes.hub_radius(Beam(delta=-1.5)) == 1.5
    assert sizes.hub_radius(Beam(delta=0)) == sizes.MIN_HUB > 0


def test_an_inward_beam_points_from_the_rim_to_the_axis():
    """delta = -1: the clamp is at x = -1 on the rim, the tip at the axis."""
    shapes = Shapes.at_rest(Beam(delta=-1), "chordwise")
    points, _ = placed(shapes, shapes.centreline)
    assert np.allclose(points[0], [-1, 0, 0])
    assert np.allclose(points[-1], [0, 0, 0], atol=1e-12)


# Motion


def test_a_quarter_of_a_period_shows_the_mode_itself():
    """Displacement is the solver's shape, scaled to the amplitude; nothing at phase 0."""
    solution = solve(PAPER)
    shapes = Shapes.sampled(solution)
    for k in range(3):
        shape = solution.shape(k, shapes.x)
        scaled = 0.15 * shape / np.linalg.norm(shape, axis=1).max()
        drawn = alone(shapes, k, 0.25)
        assert np.allclose(drawn, scaled, atol=1e-12) or np.allclose(drawn, -scaled, atol=1e-12)
        assert np.allclose(alone(shapes, k, 0.0), 0, atol=1e-12)


def test_the_node_of_mode_2_stays_still():
    """gamma 0, no mass: x = 0.783445 (paper, omega 22.0345) does not move at any phase."""
    shapes = sampled(Beam())
    x, place = shapes.nodes[1]
    assert x == pytest.approx([0.783445], abs=1e-5)
    assert np.allclose(place, [[0.783445, 0.0]], atol=1e-5)
    for phase in np.linspace(0, 1, 7):
        moved = alone(shapes, 1, phase)[:, 1]
        assert abs(np.interp(0.783445, shapes.x, moved)) < 2e-5
    assert abs(alone(shapes, 1, 0.25)[:, 1]).max() == pytest.approx(0.15)


def test_one_clock_keeps_the_ratio_of_frequencies():
    """While mode 1 goes through one period, mode 2 goes through omega_2 / omega_1 of its own
    and the hub through gamma / omega_1 turns."""
    frequencies = solve(PAPER).frequencies
    clock = Clock(phases=np.zeros(5))
    turns = np.zeros(6)
    for _ in range(400):
        before = np.append(clock.phases, clock.angle)
        clock.advance(2 * math.pi / frequencies[0] / 400, frequencies, PAPER.gamma)
        turns += (np.append(clock.phases, clock.angle) - before) % (2 * math.pi)
    expected = np.append(frequencies, PAPER.gamma) / frequencies[0]
    assert turns / (2 * math.pi) == pytest.approx(expected, rel=1e-9)


def test_phases_go_on_when_frequencies_change():
    """A slider moves the frequencies, not the beam: no jump."""
    clock = Clock()
    clock.advance(0.3, np.array([3.0, 20.0]), 5.0)
    before = clock.phases.copy()
    clock.advance(0.0, np.array([4.0, 25.0]), 6.0)
    assert np.array_equal(clock.phases, before)


def test_the_pace_shows_the_slowest_and_does_not_blur_the_fastest():
    """At the fitted pace a swing takes 0.6 s or more and, alone, 2.5 s; a turn 1.5 s or more."""
    assert 2 * math.pi / 3.5 / fitted_rate(np.array([3.5]), 0.0) == pytest.approx(2.5)
    both = fitted_rate(np.array([3.5, 200.0]), 0.0)
    assert 2 * math.pi / 200 / both == pytest.approx(0.6)
    assert 2 * math.pi / 200 / fitted_rate(np.array([3.5]), 200.0) == pytest.approx(1.5)
    clock = Clock(rate=0.1)
    clock.fit(np.array([22.0]), 0.0, keep=True)
    assert clock.rate == 0.1
    clock.fit(np.array([2200.0]), 0.0, keep=True)
    assert clock.rate < 0.01


def test_signs_do_not_flip_while_a_slider_moves():
    """Along gamma 0 .. 30 each mode overlaps positively with itself one step before."""
    shapes = sampled(Beam(alpha=1, beta=0.5))
    for gamma in np.linspace(0.5, 30, 60):
        shapes, before = (
            Shapes.sampled(solve(Beam(alpha=1, beta=0.5, gamma=gamma)), shapes),
            shapes,
        )
        for new, old in zip(shapes.modes, before.modes, strict=True):
            same = np.stack([np.interp(shapes.x, before.x, column) for column in old.T], 1)
            assert np.vdot(same, new) > -1e-6


def test_signs_follow_a_flipped_picture():
    """The sign of a mode is free: it is taken from the picture before."""
    shapes = sampled()
    flipped = replace(shapes, modes=-shapes.modes)
    assert np.allclose(Shapes.sampled(solve(PAPER), flipped).modes, flipped.modes)


def test_with_coriolis_a_point_goes_round():
    """Complex shapes: a quarter of a period apart the tip is displaced across, then along."""
    shapes = sampled(Beam(alpha=1, beta=0.5, gamma=10), coriolis=True)
    across, along = alone(shapes, 0, 0.25)[-1], alone(shapes, 0, 0.0)[-1]
    assert abs(across[1]) == pytest.approx(0.15, rel=0.01)
    assert abs(across[0]) < 1e-9
    assert abs(along[1]) < 1e-9
    assert abs(along[0]) > 1e-4


def test_signs_survive_switching_coriolis_on_and_off():
    """Real shapes take the sign of complex ones, and the other way round."""
    real = sampled()
    turning = Shapes.sampled(solve(PAPER, coriolis=True), real)
    back = Shapes.sampled(solve(PAPER), turning)
    assert np.allclose(back.modes[:2], real.modes[:2])
    assert not np.iscomplexobj(back.modes)


def test_strain_is_that_of_the_equilibrium_plus_that_of_the_motion():
    """At rest f - 1; bending adds none to first order; stretching adds u'."""
    solution = solve(PAPER)
    shapes = Shapes.sampled(solution)
    middle = (shapes.x[:-1] + shapes.x[1:]) / 2
    still = np.zeros_like(shapes.centreline)
    assert np.allclose(axial_strain(shapes, still), solution.equilibrium.stretch(middle) - 1)
    assert np.allclose(axial_strain(shapes, alone(shapes, 0, 0.25)), shapes.strain, atol=1e-9)
    stretching = shapes.labels.index("S1")
    moved = alone(shapes, stretching, 0.25)
    slope = np.diff(moved[:, 0]) / np.diff(shapes.x)
    assert np.allclose(axial_strain(shapes, moved), shapes.strain + slope)
    bound = largest_strain(shapes, 0.15 * np.eye(5)[stretching])
    assert bound == pytest.approx(np.abs(shapes.strain + slope).max(), rel=1e-6)


def test_a_large_picture_of_stretching_never_folds():
    """At the largest amplitude every stretching mode keeps the points of the beam in order."""
    shapes = sampled(Beam(mu=12), modes=8)
    assert sum(label.startswith("S") for label in shapes.labels) >= 3
    for k in range(8):
        along = (shapes.centreline + alone(shapes, k, 0.75, 0.4))[:, 0]
        assert (np.diff(along) > 0).all()


@pytest.mark.parametrize("coriolis", [False, True])
@settings(max_examples=30)
@given(beam=beams)
def test_marked_nodes_are_those_of_the_solver(coriolis, beam):
    """To the digits that a label shows."""
    solution = solve(beam, coriolis=coriolis)
    for (x, _), exact in zip(Shapes.sampled(solution).nodes, solution.nodes, strict=True):
        assert x == pytest.approx(exact, abs=2e-5)


@given(beams)
def test_the_mass_sits_on_the_beam_where_beta_says(beam):
    """The station of the mass is beta itself."""
    shapes = sampled(beam)
    assert shapes.x[shapes.mass] == pytest.approx(beam.beta, abs=1e-8)


# Colours


def luminance(anchors: Any) -> np.ndarray:
    """Perceived lightness along a map."""
    return colours.mapped(np.linspace(0, 1, 50), anchors) @ [0.2126, 0.7152, 0.0722]


def test_the_maps_can_be_read_without_telling_hues_apart():
    """Displacement gets lighter throughout; strain is lightest where there is none, and its two
    ends differ in blue against red, which all common colour blindness leaves apart."""
    assert (np.diff(luminance(colours.SEQUENTIAL)) > 0).all()
    light = luminance(colours.DIVERGING)
    assert abs(light.argmax() - 24.5) < 2
    low, high = colours.mapped(np.array([0.0, 1.0]), colours.DIVERGING)
    assert low[2] - low[0] > 0.5
    assert high[0] - high[2] > 0.5


def test_colours_tell_how_far_and_how_long():
    """Still is the low end, the farthest point the high end; unstrained is the middle."""
    shapes = sampled(Beam())
    amplitudes = 0.15 * np.eye(5)[0]
    painted = colours.along(shapes, "displacement", alone(shapes, 0, 0.25), amplitudes)
    assert np.allclose(painted[0] * 255, colours.SEQUENTIAL[0], atol=3)
    assert np.allclose(painted[-1] * 255, colours.SEQUENTIAL[-1], atol=6)
    strained = colours.along(shapes, "axial strain", alone(shapes, 0, 0.25), amplitudes)
    assert np.allclose(strained * 255, colours.DIVERGING[2], atol=1)


def test_instanced_bodies_get_linear_light():
    """Mid-grey in sRGB is 0.2140 of full light."""
    assert colours.instanced(np.array([[0.5, 0.0, 1.0]])).tolist() == [[55, 0, 255]]


# Viewpoint


@given(beams, st.booleans(), st.floats(0.5, 3.0), st.sampled_from([0.0, 0.25]))
def test_the_beam_is_inside_the_picture_and_fills_it(beam, riding, aspect, lift):
    """Every corner is inside; the nearest fit touches an edge to within 10 %."""
    shapes = Shapes.at_rest(beam, "chordwise")
    position = camera.viewpoint(shapes, riding, aspect, lift)
    seen = (camera.corners(shapes, riding) - position) @ camera.axes(position)
    tall = math.tan(camera.FIELD_OF_VIEW / 2)
    wide = np.abs(seen[:, 0] / seen[:, 2]).max() / (tall * aspect)
    high = np.abs(seen[:, 1] / seen[:, 2]).max() / (tall * (1 - lift))
    assert (seen[:, 2] > 0).all()
    assert 0.9 < max(wide, high) <= 1


# The scene in a real (unwatched) server


def test_the_scene_draws_a_beam_and_greys_it():
    """Pieces lie on the beam, the mass on its station; words grey all of it and stand above."""
    shapes = sampled()
    with hosted() as server:
        scene = Scene(server.scene)
        scene.show(shapes, Look(), [1])
        scene.move(np.full(5, np.pi / 2), 0.15 * np.eye(5)[1], angle=0.3)
        drawn = scene.shapes
        points, _ = placed(drawn, drawn.centreline + alone(drawn, 1, 0.25))
        middle = (points[:-1] + points[1:]) / 2
        assert np.allclose(scene.beam.batched_positions, middle, atol=1e-6)
        assert np.allclose(scene.mass.batched_positions, points[[drawn.mass]], atol=1e-6)
        assert len(np.unique(scene.beam.batched_colors, axis=0)) > 20
        assert scene.nodes.labels[0].text == f"B2 node at {shapes.nodes[1][0][0]:.3f}"
        assert scene.words.visible is False
        scene.show(shapes, Look(), [1], words="No equilibrium")
        scene.move(np.full(5, np.pi / 2), 0.15 * np.eye(5)[1], angle=0.3)
        assert len(np.unique(scene.beam.batched_colors, axis=0)) == 1
        assert bool(scene.words.visible) is not False
        assert scene.nodes.labels[0].visible is False


def test_labels_of_nodes_can_be_read_and_leave_room():
    """Thirteen pixels high on a laptop as on a phone; four of them share the beam."""
    shapes = sampled(Beam())
    with hosted() as server:
        scene = Scene(server.scene)
        for scale in (250.0, 500.0):
            for mode in (1, 4):
                look = Look().only(mode)
                seen = Seen.of(shapes, 0.15 * np.eye(5)[mode], look.colouring, scale)
                scene.show(shapes, look, [mode], seen=seen)
                heights = {tag.font_scene_height for tag in scene.nodes.labels if tag.visible}
                (height,) = heights
                assert height * scale == pytest.approx(13) if mode == 1 else height <= 0.0301


def test_the_frame_of_view_turns_the_hub_or_the_ground():
    """Riding, the ground turns backwards under a still hub; beside it, the hub turns."""
    shapes = sampled()
    with hosted() as server:
        scene = Scene(server.scene)
        for riding in (True, False):
            scene.show(shapes, Look(riding=riding), [0])
            scene.move(np.zeros(5), np.zeros(5), angle=0.3)
            still, moving = (
                (scene.wheel, scene.ground.grid) if riding else (scene.ground.grid, scene.wheel)
            )
            assert np.allclose(still.wxyz, [1, 0, 0, 0])
            assert moving.wxyz[3] == pytest.approx(math.sin(-0.15 if riding else 0.15))


def test_flapwise_motion_is_out_of_the_plane_of_rotation():
    """Across is z flapwise and y chordwise; the thickness turns with it."""
    for plane, axis in (("chordwise", 1), ("flapwise", 2)):
        shapes = sampled(PAPER, plane=plane)
        with hosted() as server:
            scene = Scene(server.scene)
            scene.show(shapes, Look(), [0])
            scene.move(np.full(5, np.pi / 2), 0.15 * np.eye(5)[0], angle=0.0)
            assert np.abs(scene.beam.batched_positions[:, axis]).max() > 0.1
            assert np.abs(scene.beam.batched_positions[:, 3 - axis]).max() == 0
            lengths = scene.beam.batched_scales
            assert lengths is not None
            assert lengths[0, axis] == pytest.approx(sizes.section(PAPER)[0], rel=1e-6)


def test_there_is_no_mass_without_a_mass_and_a_hoop_for_an_inward_beam():
    """alpha = 0 hides the sphere; delta < 0 swaps the drum for a hoop."""
    with hosted() as server:
        scene = Scene(server.scene)
        scene.show(sampled(Beam()), Look(), [0])
        assert scene.mass.batched_scales is not None
        assert np.allclose(scene.mass.batched_scales, HIDDEN)
        assert (scene.hub.drum.visible, scene.hub.hoop.visible) == (True, False)
        scene.show(Shapes.at_rest(Beam(delta=-0.5), "chordwise"), Look(), [])
        assert (scene.hub.drum.visible, scene.hub.hoop.visible) == (False, True)
        inner = np.linalg.norm(scene.hub.hoop.vertices[:, :2], axis=1).min()
        assert inner == pytest.approx(0.5, rel=1e-3)


# Words and choices


def test_the_table_shows_what_the_error_leaves():
    """Digits beyond the error are not printed; SI beams get hertz; shown modes are marked."""
    assert readout.significant(22.034491561, 3e-12) == "22.034492"
    assert readout.significant(120.9019161, 7e-5) == "120.902"
    solution = solve(PAPER)
    html = readout.table(solution, [1])
    assert html.count("<tr") == 6
    assert html.count("rgba(") == 1
    assert "stretching" in html
    units = Units(length=1.0, time=0.01)
    html = readout.table(solve(PAPER.replace(units=units)), [1])
    hertz = units.hertz(solution.frequencies[0])
    assert readout.significant(hertz, units.hertz(solution.errors[0])) in html


def test_trouble_is_told_apart():
    """No equilibrium names the limit, an unstable state its growth, a stable one says nothing."""
    told = words.refused(NoEquilibrium("no equilibrium beyond gamma = 15.7", 15.7), Beam(gamma=20))
    assert "γ = 20" in told
    assert "15.7" in told
    assert words.unstable(solve(PAPER)) == ""
    buckled = solve(Beam(gamma=5, delta=-1))
    assert buckled.equilibrium.status == "unstable"
    assert "Unstable" in words.unstable(buckled)
    assert "bending" in words.unstable(buckled)
    assert f"{math.log(10) / buckled.growth_rates.max():.2g} T*" in words.unstable(buckled)


def test_choices_that_make_no_sense_change_nothing():
    """A browser may send anything: not-a-number, too much, the wrong kind, an unknown choice."""
    look = Look()
    assert look.changed("pace", math.nan) == look
    assert look.changed("pace", "fast") == look
    assert look.changed("colouring", "rainbow") == look
    assert look.changed("amplitude", 1e9).amplitude == within(1e9, 0.4, 0.0) == 0.4
    assert look.share(3, -5).shares == (0.0, 1.0, 0.0, 0.0)
    assert look.only(2).shares == (0.0, 0.0, 1.0)
    wanted = Wanted.of(PAPER, {})
    assert wanted.changed("strain", "rubber") is wanted
    assert wanted.changed("nothing", 1.0) is wanted
    assert wanted.changed("strain", "hencky").options["strain"] == "hencky"
