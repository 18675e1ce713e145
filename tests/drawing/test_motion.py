"""What moves: modes at their phases on one clock, strain, nodes; and its colours."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from drawing.shapes import BEAMS, PAPER, sampled, single_mode
from hypothesis import given, settings

from beamviz.beam import Beam
from beamviz.drawing import colours
from beamviz.drawing.modes import Clock, SampledModes, axial_strain, largest_strain, playback_rate
from beamviz.solver import solve

# Motion


def test_a_quarter_of_a_period_shows_the_mode_itself():
    """Displacement is the solver's shape, scaled to the amplitude; nothing at phase 0."""
    solution = solve(PAPER)
    shapes = SampledModes.sampled(solution)
    for k in range(3):
        shape = solution.shape(k, shapes.x)
        scaled = 0.15 * shape / np.linalg.norm(shape, axis=1).max()
        drawn = single_mode(shapes, k, 0.25)
        assert np.allclose(drawn, scaled, atol=1e-12) or np.allclose(drawn, -scaled, atol=1e-12)
        assert np.allclose(single_mode(shapes, k, 0.0), 0, atol=1e-12)


def test_the_node_of_mode_2_stays_still():
    """gamma 0, no mass: x = 0.783445 (paper, omega 22.0345) does not move at any phase."""
    shapes = sampled(Beam())
    assert shapes.nodes[1] == pytest.approx([0.783445], abs=1e-5)
    for phase in np.linspace(0, 1, 7):
        moved = single_mode(shapes, 1, phase)[:, 1]
        assert abs(np.interp(0.783445, shapes.x, moved)) < 2e-5
    assert abs(single_mode(shapes, 1, 0.25)[:, 1]).max() == pytest.approx(0.15)


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
    assert 2 * math.pi / 3.5 / playback_rate(np.array([3.5]), 0.0) == pytest.approx(2.5)
    both = playback_rate(np.array([3.5, 200.0]), 0.0)
    assert 2 * math.pi / 200 / both == pytest.approx(0.6)
    assert 2 * math.pi / 200 / playback_rate(np.array([3.5]), 200.0) == pytest.approx(1.5)
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
            SampledModes.sampled(solve(Beam(alpha=1, beta=0.5, gamma=gamma)), shapes),
            shapes,
        )
        for new, old in zip(shapes.modes, before.modes, strict=True):
            same = np.stack([np.interp(shapes.x, before.x, column) for column in old.T], 1)
            assert np.vdot(same, new) > -1e-6


def test_signs_follow_a_flipped_picture():
    """The sign of a mode is free: it is taken from the picture before."""
    shapes = sampled()
    flipped = replace(shapes, modes=-shapes.modes)
    assert np.allclose(SampledModes.sampled(solve(PAPER), flipped).modes, flipped.modes)


def test_with_coriolis_a_point_goes_round():
    """Complex shapes: a quarter of a period apart the tip is displaced across, then along."""
    shapes = sampled(Beam(alpha=1, beta=0.5, gamma=10), coriolis=True)
    across, along = single_mode(shapes, 0, 0.25)[-1], single_mode(shapes, 0, 0.0)[-1]
    assert abs(across[1]) == pytest.approx(0.15, rel=0.01)
    assert abs(across[0]) < 1e-9
    assert abs(along[1]) < 1e-9
    assert abs(along[0]) > 1e-4


def test_signs_survive_switching_coriolis_on_and_off():
    """Real shapes take the sign of complex ones, and the other way round."""
    real = sampled()
    turning = SampledModes.sampled(solve(PAPER, coriolis=True), real)
    back = SampledModes.sampled(solve(PAPER), turning)
    assert np.allclose(back.modes[:2], real.modes[:2])
    assert not np.iscomplexobj(back.modes)


def test_strain_is_that_of_the_equilibrium_plus_that_of_the_motion():
    """At rest f - 1; bending adds none to first order; stretching adds u'."""
    solution = solve(PAPER)
    shapes = SampledModes.sampled(solution)
    middle = (shapes.x[:-1] + shapes.x[1:]) / 2
    still = np.zeros_like(shapes.centreline)
    assert np.allclose(axial_strain(shapes, still), solution.equilibrium.stretch(middle) - 1)
    assert np.allclose(axial_strain(shapes, single_mode(shapes, 0, 0.25)), shapes.strain, atol=1e-9)
    stretching = shapes.labels.index("S1")
    moved = single_mode(shapes, stretching, 0.25)
    slope = np.diff(moved[:, 0]) / np.diff(shapes.x)
    assert np.allclose(axial_strain(shapes, moved), shapes.strain + slope)
    bound = largest_strain(shapes, 0.15 * np.eye(5)[stretching])
    assert bound == pytest.approx(np.abs(shapes.strain + slope).max(), rel=1e-6)


def test_a_large_picture_of_stretching_never_folds():
    """At the largest amplitude every stretching mode keeps the points of the beam in order."""
    shapes = sampled(Beam(mu=12), modes=8)
    assert sum(label.startswith("S") for label in shapes.labels) >= 3
    for k in range(8):
        along = (shapes.centreline + single_mode(shapes, k, 0.75, 0.4))[:, 0]
        assert (np.diff(along) > 0).all()


@pytest.mark.parametrize("coriolis", [False, True])
@settings(max_examples=30)
@given(beam=BEAMS)
def test_marked_nodes_are_those_of_the_solver(coriolis, beam):
    """To the digits that a label shows."""
    solution = solve(beam, coriolis=coriolis)
    for x, exact in zip(SampledModes.sampled(solution).nodes, solution.nodes, strict=True):
        assert x == pytest.approx(exact, abs=2e-5)


@given(BEAMS)
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
    painted = colours.along(shapes, "displacement", single_mode(shapes, 0, 0.25), amplitudes)
    assert np.allclose(painted[0] * 255, colours.SEQUENTIAL[0], atol=3)
    assert np.allclose(painted[-1] * 255, colours.SEQUENTIAL[-1], atol=6)
    strained = colours.along(shapes, "axial strain", single_mode(shapes, 0, 0.25), amplitudes)
    assert np.allclose(strained * 255, colours.DIVERGING[2], atol=1)


def test_instanced_bodies_get_linear_light():
    """Mid-grey in sRGB is 0.2140 of full light."""
    assert colours.instanced(np.array([[0.5, 0.0, 1.0]])).tolist() == [[55, 0, 255]]
