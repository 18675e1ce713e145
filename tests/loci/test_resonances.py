"""Resonances: all intersections of loci with per-rev lines, for any speeds of the sweep."""

import numpy as np
import pytest
from helpers import slow

from beamviz import Beam, InvalidInput, loci, solve
from beamviz.errors import BeamvizError
from beamviz.frequency_loci.forced_response import resonances
from beamviz.solver import solve_many

TIP = Beam(alpha=1, beta=1)


def located(found, per_rev, label):
    """The speeds of the resonances of one branch with one line, of four."""
    return [one.at for one in resonances(found, 4) if (one.per_rev, one.branch) == (per_rev, label)]


def test_resonances():
    """Each lies on a locus and on a line of a multiple of the speed."""
    found = resonances(loci(TIP, "gamma", np.linspace(0, 30, 16), coriolis=True), 4)
    assert [(one.per_rev, one.branch) for one in found][:4] == [(k, "B1") for k in (4, 3, 2, 1)]
    for one in found:
        frequencies = solve(TIP.replace(gamma=one.at), coriolis=True, tolerance=1e-9).frequencies
        assert one.frequency == one.per_rev * one.at
        assert abs(frequencies - one.frequency).min() < 1e-6 * one.frequency


CLOSE_PAIR = 0.0007236814724  # hub radius at which a locus nearly touches its line


@pytest.mark.parametrize(
    ("delta", "points", "expected"),
    [
        *((0.0, points, [73.591, 85.314]) for points in (2, 5, 201)),
        *((CLOSE_PAIR, points, [79.102, 79.238]) for points in (5, 401)),
        (0.00073, 101, []),
    ],
)
def test_few_speeds_are_enough(delta, points, expected):
    """4x B3 has two resonances, closer together than the speeds of the sweep; with a little more
    hub radius the locus misses its line."""
    found = loci(Beam(delta=delta), "gamma", np.linspace(0, 200, points), modes=6)
    assert located(found, 4, "B3") == pytest.approx(expected, abs=1e-3)


def test_up_to_the_end_of_an_equilibrium():
    """With Hencky strain it ends at gamma 45.420. Between the last speed of the sweep and that S2
    falls below B3 and intersects the 4x line."""
    found = loci(Beam(), "gamma", np.linspace(0, 60, 61), modes=6, strain="hencky")
    (at,) = located(found, 4, "S2")
    assert 45 < at < found.limits[0].start
    there = solve(Beam(gamma=at), 6, strain="hencky")
    assert there.frequencies[there.labels.index("S2")] == pytest.approx(4 * at, rel=1e-6)


def test_a_resonance_at_a_speed_of_the_sweep_is_found_once():
    """At a value of the sweep exactly, and with a rounding error."""
    (at,) = located(loci(TIP, "gamma", np.linspace(0, 5, 6)), 2, "B1")
    for value in (at, np.nextafter(at, 0), np.nextafter(at, 9)):
        again = located(loci(TIP, "gamma", [0.0, 0.5, value, 3.0]), 2, "B1")
        assert again == pytest.approx([at], rel=1e-9)


def test_resonances_need_the_speed():
    """Over another parameter there are no per-rev lines; a mistyped keyword is named."""
    with pytest.raises(InvalidInput, match="per-rev lines need loci over gamma, not over alpha"):
        resonances(loci(TIP, "alpha", [0, 1]), 3)
    with pytest.raises(InvalidInput, match="unknown keyword 'per_rev': known: count"):
        resonances(loci(TIP, "gamma", [0, 1]), per_rev=3)


def random_sweep(seed):
    """A beam, the end of its sweep, the number of speeds and the options."""
    chance = np.random.default_rng(seed)
    beam = Beam(
        alpha=chance.choice([0, 10 ** chance.uniform(-1, 1)]),
        beta=chance.choice([1.0, chance.uniform(0.1, 1)]),
        delta=chance.choice([0, chance.uniform(0, 1), -chance.uniform(0, 0.5)]),
        mu=10 ** chance.uniform(1.6, 2.5),
    )
    options = {
        "coriolis": bool(chance.integers(2)),
        "strain": str(chance.choice(["green", "green", "hencky", "biot"])),
    }
    return beam, float(chance.uniform(10, 150)), int(chance.choice([3, 6, 21, 81])), options


def dense_resonances(beam, stop, options, count=1501, modes=5, lines=3):
    """Intersections of sorted frequencies on a dense grid of direct solves: no tracking, no
    interpolation; for each (per_rev, speed before, speed after)."""
    speeds = np.linspace(0, stop, count)[:-1]
    f = np.full((count - 1, modes), np.nan)
    for row, outcome in zip(
        f, solve_many([beam.replace(gamma=x) for x in speeds], modes=modes, **options), strict=True
    ):
        if not isinstance(outcome, BeamvizError):
            row[:] = np.nan_to_num(outcome.frequencies, nan=0.0)
    for k in range(1, lines + 1):
        above = f > k * speeds[:, None]
        changes = (above[1:] != above[:-1]) & np.isfinite(f[1:] + f[:-1])
        for i, _ in np.argwhere(changes):
            yield k, speeds[i], speeds[i + 1]


@pytest.mark.parametrize("seed", [4, 5, *slow(0, 1, 2, 3)])
def test_against_direct_solves(seed):
    """Every intersection on a dense grid is found within its step, for any sweep."""
    beam, stop, points, options = random_sweep(seed)
    found = loci(beam, "gamma", np.linspace(0, stop, points), **options)
    remaining = [(one.per_rev, one.at) for one in resonances(found, 3)]
    ends = [limit.start for limit in found.limits if limit.kind == "no-equilibrium"]
    for k, low, high in dense_resonances(beam, min([stop, *ends]), options):
        here = [one for one in remaining if one[0] == k and low - 1e-6 <= one[1] <= high + 1e-6]
        assert here, (k, low, high)
        remaining.remove(here[0])
    for k, at in remaining:  # closer together than the dense grid, or just before a limit
        frequencies = solve(beam.replace(gamma=at), **options).frequencies
        assert np.nanmin(abs(frequencies - k * at)) < 1e-5 * k * at
