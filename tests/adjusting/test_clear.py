"""Beams that keep clear of per-rev lines, compared with all beams of a grid."""

import numpy as np
import pytest
from helpers import slow

from beamviz import Beam, InvalidInput, NoAnswer, adjust, loci, resonances, solve_many

BOUNDS = {"alpha": (0.0, 3.0), "beta": (0.2, 1.0), "delta": (0.0, 2.0)}
TASKS = [  # free, lines, range of gamma, margin
    (("alpha", "beta"), (2, 3), (2.0, 3.0), 0.15),
    (("beta",), (3,), (6.0, 7.0), 0.05),
    *slow(
        (("alpha", "beta"), (1, 2), (1.5, 3.0), 0.1),
        (("beta", "delta"), (2, 3), (4.0, 6.0), 0.05),
        (("alpha", "beta"), (1, 2, 3, 4, 5), (1.0, 8.0), 0.1),  # none
    ),
]
POINTS = 17


def margin_of(frequencies, speeds, lines):
    """The least relative distance of frequencies (speeds, modes) from the lines, 0 where they
    cross."""
    least = np.inf
    for line in lines:
        distance = frequencies / (line * speeds[:, None]) - 1
        crosses = (distance.min(axis=0) < 0) & (distance.max(axis=0) > 0)
        least = min(least, 0.0 if crosses.any() else abs(distance).min())
    return least


def margins(beam, points, speeds, lines):
    """The margins (len(points),) of the beams with these numbers."""
    beams = [beam.replace(**numbers, gamma=gamma) for numbers in points for gamma in speeds]
    answers = iter(solve_many(beams, modes=6))
    return np.array(
        [
            margin_of(np.array([next(answers).frequencies for _ in speeds]), speeds, lines)
            for _ in points
        ]
    )


def distance(beam, numbers):
    """The distance from a beam in the scale of the bounds."""
    shares = [
        (value - getattr(beam, name)) / np.ptp(BOUNDS[name]) for name, value in numbers.items()
    ]
    return np.sqrt(np.mean(np.square(shares)))


@pytest.mark.parametrize(("free", "lines", "between", "margin"), TASKS)
def test_the_nearest_clear_beam_is_that_of_a_map(free, lines, between, margin):
    """No beam of a grid that keeps the margin is nearer; where none does, none has a larger one."""
    beam = Beam(alpha=1, beta=0.7, delta=0.5)
    axes = np.meshgrid(*(np.linspace(*BOUNDS[name], POINTS) for name in free))
    points = [
        dict(zip(free, each, strict=True)) for each in np.stack(axes, -1).reshape(-1, len(free))
    ]
    of_grid = margins(beam, points, np.linspace(*between, 3), lines)
    bounds = {name: BOUNDS[name] for name in free}
    keywords = {"clear": lines, "between": between, "margin": margin}
    fine = np.linspace(*between, 41)
    clear = [numbers for numbers, each in zip(points, of_grid, strict=True) if each >= margin]
    if not clear:
        with pytest.raises(NoAnswer) as caught:
            adjust(beam, bounds, **keywords)
        assert of_grid.max() == 0 or caught.value.best.held.margin >= of_grid.max() - 1e-3
        return
    answer = adjust(beam, bounds, **keywords)
    (exact,) = margins(beam, [answer.free], fine, lines)
    assert exact >= margin - 1e-5
    nearest = min(distance(beam, numbers) for numbers in clear)
    assert distance(beam, answer.free) <= nearest + 1e-3


@pytest.mark.slow
def test_a_clear_beam_in_a_corner_of_the_bounds():
    """Those near delta = 0 and alpha = 3 alone are nearer than the many at delta above 0.6."""
    beam = Beam(alpha=2.4033, beta=0.21527, delta=0.13565)
    bounds = {name: BOUNDS[name] for name in ("alpha", "delta")}
    answer = adjust(beam, bounds, clear=(1, 2, 3), between=(5.73, 6.89), margin=0.12)
    assert answer.free == pytest.approx({"alpha": 2.92, "delta": 0}, abs=0.01)


def test_a_clear_beam_has_no_resonance():
    beam = Beam(alpha=1)
    before = loci(beam, "gamma", [1.5, 3], per_rev=2)
    assert resonances(before, 2)
    answer = adjust(beam, ["alpha"], clear=(1, 2), between=(1.5, 3))
    after = loci(answer.beam, "gamma", [1.5, 3], per_rev=2)
    assert not resonances(after, 2)
    assert answer.held.margin == pytest.approx(0.1, abs=1e-3)


def test_a_beam_that_is_clear_is_the_answer():
    beam = Beam(alpha=1)
    answer = adjust(beam, ["alpha", "beta"], clear=1, between=(3, 5), margin=0.1)
    assert answer.beam.replace(gamma=0) == beam


def test_without_a_clear_beam_the_best_margin_is_told():
    """And the mode and the line that hold it."""
    with pytest.raises(NoAnswer, match=r"best, at beta = .* held by B1 and the line") as caught:
        adjust(Beam(alpha=1), ["beta"], clear=(1, 2), between=(1.5, 3))
    held = caught.value.best.held
    assert 0 < held.margin < 0.1
    assert held.mode == "B1"


def test_a_frequency_above_a_line_is_moved_up():
    """The first flap mode is above one per revolution at every speed, the more so the larger the
    hub: the least hub with the margin is where the margin is that asked for."""
    speeds, bounds = (5.0, 6.0), {"delta": (0.0, 1.0)}
    answer = adjust(Beam(), bounds, clear=1, between=speeds, margin=0.3, plane="flapwise")
    assert 0 < answer.free["delta"] < 1
    beams = [answer.beam.replace(gamma=gamma) for gamma in np.linspace(*speeds, 41)]
    solutions = solve_many(beams, modes=1, plane="flapwise")
    ratios = [solution.frequencies[0] / solution.beam.gamma for solution in solutions]
    assert min(ratios) == pytest.approx(1.3, abs=1e-3)


def test_lines_above_more_modes_than_are_computed_are_refused():
    with pytest.raises(InvalidInput, match="20 modes and more lie below the line 60 per rev"):
        adjust(Beam(), ["beta"], clear=60, between=(40, 50), margin=0.01)
