"""Motion: modes at their phases on one clock, strain, nodes; and its colours."""

import math
from dataclasses import replace

import numpy as np
import pytest
from helpers import sampled
from hypothesis import example, given, settings
from live.visitor import PAPER
from strategies import beams

from beamviz.beam import Beam
from beamviz.drawing import colours
from beamviz.drawing.beam_mesh import DrawnBeam
from beamviz.drawing.modes import Clock, SampledModes, displacement, playback_rate
from beamviz.scene import MAX_AMPLITUDE, ViewOptions
from beamviz.solver import solve

BEAMS = beams(alpha=(0, 100), gamma=(0, 50), delta=(0, 5))


def test_one_clock_keeps_the_ratio_of_frequencies():
    """In a period of mode 1, mode 2 has omega_2 / omega_1 periods and the hub gamma / omega_1
    turns; phases are continuous when frequencies change."""
    frequencies = solve(PAPER).frequencies
    clock = Clock(phases=np.zeros(5))
    total = np.zeros(6)
    for _ in range(400):
        before = np.append(clock.phases, clock.angle)
        clock.advance(2 * math.pi / frequencies[0] / 400, frequencies, PAPER.gamma)
        total += (np.append(clock.phases, clock.angle) - before) % (2 * math.pi)
    expected = np.append(frequencies, PAPER.gamma) / frequencies[0]
    assert total / (2 * math.pi) == pytest.approx(expected, rel=1e-9)
    before = clock.phases
    clock.advance(0.0, 1.2 * frequencies, 6.0)
    assert np.array_equal(clock.phases, before)


def test_the_playback_rate_suits_the_slowest_and_the_fastest_motion():
    """A period takes at least 0.6 s and, alone, 2.5 s; a rotation at least 1.5 s. A clock keeps its
    rate unless it is much too fast or too slow."""
    for frequencies, gamma, period in (([3.5], 0, 2.5), ([3.5, 200], 0, 0.6), ([3.5], 200, 1.5)):
        rate = playback_rate(np.array(frequencies), gamma)
        assert 2 * math.pi / max(*frequencies, gamma) / rate == pytest.approx(period)
    clock = Clock(rate=0.1)
    for frequency, low, high in ((22.0, 0.1, 0.1), (2200.0, 0.0, 0.01)):
        clock.fit(np.array([frequency]), 0.0, keep=True)
        assert low <= clock.rate <= high


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
        sizes = DrawnBeam.of(shapes, ViewOptions(amplitude=MAX_AMPLITUDE).only(k)).amplitudes
        moved = displacement(shapes, np.full(8, 1.5 * math.pi), sizes)
        assert (np.diff((shapes.centreline + moved)[:, 0]) > 0).all()


@pytest.mark.parametrize("coriolis", [False, True])
@settings(max_examples=30)
@given(beam=BEAMS)
@example(beam=Beam(alpha=1, beta=1, gamma=4.65))  # at a veering axial and transverse motion mix
@example(beam=Beam(beta=2.4e-8, mu=26))  # so near the clamp that its motion is rounding error
def test_marked_nodes_are_those_of_the_solver(coriolis, beam):
    """To the three digits of a label, also in a layer at the mass as thin as two stations."""
    solution = solve(beam, coriolis=coriolis)
    for x, exact in zip(SampledModes.sampled(solution).nodes, solution.nodes, strict=True):
        assert x == pytest.approx(exact, abs=5e-4)


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
