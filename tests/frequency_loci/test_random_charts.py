"""Random charts: error bars, events and resonances against direct solves and charts of many points.

BEAMVIZ_CHARTS sets the number of charts (hundreds take minutes).
"""

import math
import os
from itertools import combinations

import numpy as np
import pytest
from helpers import slow

from beamviz import Beam, BeamvizError, loci, resonances, solve, solve_many
from beamviz.frequency_loci.avoided_crossings import CLOSE
from beamviz.frequency_loci.events.least_gaps import ROTATED

SEEDS = [1, *slow(0, *range(2, int(os.environ.get("BEAMVIZ_CHARTS", "6"))))]
PLACES = 12  # of each chart, drawn anew: solved with a thousandth of the tolerance
GAMMA_OVER_MU = 4.99


def random_chart(seed, *names):
    """A beam, what is swept, the values and the options: Coriolis forces, inward beams, strain laws
    with a limit of equilibrium, large stretch and few points included."""
    chance, stay = np.random.default_rng(seed), [0.4, 0.4, 0.2]
    over = str(chance.choice(names or ["gamma", "gamma", "alpha", "beta", "delta", "mu"]))
    mu = 10 ** chance.uniform(1.2, 2.8)
    beam = {
        "alpha": chance.choice([0.0, 10 ** chance.uniform(-1.5, 1.3)]),
        "beta": chance.choice([1.0, chance.uniform(0.05, 1)]),
        "gamma": chance.choice([10 ** chance.uniform(-1, 1.3), chance.uniform(0, 2) * mu]),
        "delta": chance.choice([0.0, chance.uniform(0, 3), chance.uniform(-1.5, 0)], p=stay),
        "mu": mu,
    }
    low, high = {
        "alpha": (0.0, 5.0),
        "beta": (0.0, 1.0),
        "gamma": (0.0, min(10 ** chance.uniform(0.5, 2.2), GAMMA_OVER_MU * mu)),
        "delta": (-1.0 * chance.choice([0, 1], p=[0.7, 0.3]), 3.0),
        "mu": (10.0, 500.0),
    }[over]
    beam["gamma"] = min(beam["gamma"], 200.0, GAMMA_OVER_MU * mu)
    if over == "mu":
        low = max(10.0, beam["gamma"] / GAMMA_OVER_MU)
    count = int(chance.choice([2, 5, 21, 201]))
    options = {
        "coriolis": bool(chance.random() < 0.4),
        "strain": str(chance.choice(["green", "green", "biot", "hencky"])),
        "plane": str(chance.choice(["chordwise", "chordwise", "flapwise"])),
        "modes": int(chance.choice([3, 5, 6, 9])),
    }
    inner = np.sort(chance.uniform(low, high, min(count - 2, PLACES)))
    grid = np.linspace(low, high, count)
    return Beam(**beam), over, np.unique(np.concatenate((grid, inner))), inner, options


def charts(beam, over, *points, **options):
    """The charts of a beam over some values each, none of them where it has no answer."""
    try:
        return [loci(beam, over, values, **options) for values in points]
    except BeamvizError:
        return []


@pytest.mark.parametrize("seed", SEEDS)
def test_frequencies_lie_within_their_error_bars(seed):
    """Of those of a direct solve, at places that the chart did not choose; all modes are there."""
    beam, over, values, places, options = random_chart(seed)
    for found in charts(beam, over, values, **options):
        beams = [beam.replace(**{over: value}) for value in places]
        for value, converged in zip(
            places, solve_many(beams, tolerance=1e-9, **options), strict=True
        ):
            k = int(np.searchsorted(found.values, value))
            rows = {branch.mode_index[k]: branch for branch in found.branches}
            rows.pop(-1, None)
            if isinstance(converged, BeamvizError) or not rows:  # within the tolerance of the chart
                continue
            assert sorted(rows) == list(range(options["modes"]))
            for i, branch in rows.items():
                if converged.omega_squared[i] > 0 and branch.omega_squared[k] > 0:
                    off = abs(branch.frequency[k] - converged.frequencies[i])
                    assert off <= branch.error[k] + converged.errors[i]


@pytest.mark.slow
def test_most_random_charts_have_answers():
    """Otherwise the other tests would show nothing."""
    drawn = (random_chart(seed) for seed in range(6))
    found = [charts(beam, over, values[[0, -1]], **o) for beam, over, values, _, o in drawn]
    assert sum(map(len, found)) > 3


@pytest.mark.parametrize("seed", SEEDS)
def test_few_points_have_the_events_of_many(seed):
    """Crossings and veerings of the same branches, at the same places, with the same gaps."""
    beam, over, values, _, options = random_chart(seed)
    points = (np.linspace(*values[[0, -1]], count) for count in (2, 101))
    few, *more = charts(beam, over, *points, **options) or [None]
    for many in more:
        for a, b in zip(few.events, many.events, strict=True):
            assert (a.kind, a.branches) == (b.kind, b.branches)
            assert (a.at, a.gap, a.index) == pytest.approx((b.at, b.gap, b.index), rel=1e-6)


def outward_chart(seed, *names):
    """A beam in tension, what is swept, and from where to where: all beams have a stable state."""
    beam, over, values, *_ = random_chart(seed, *names)
    return beam.replace(delta=abs(beam.delta)), over, *abs(values[[0, -1]])


def exchanges_of_order(beam, over, values, modes):
    """The changes of the order of labels on a dense grid: no tracking, no shapes."""
    solutions = solve_many([beam.replace(**{over: value}) for value in values], modes=modes)
    orders = [{label: k for k, label in enumerate(one.labels)} for one in solutions]
    return [
        ({one, other}, value)
        for value, now, then in zip(values, orders, orders[1:], strict=False)
        for one, other in combinations(sorted({*now, *then}), 2)
        if np.prod([order.get(one, modes) - order.get(other, modes) for order in (now, then)]) < 0
    ]


@pytest.mark.parametrize("seed", [3, 8, *slow(6, 7, 11, 13)])
def test_crossings_of_random_beams(seed):
    """On a coarse grid: the crossings of a dense one, each within its step of that."""
    beam, over, low, high = outward_chart(seed)
    dense = np.linspace(low, high, 301)
    expected = exchanges_of_order(beam, over, dense, 5)
    found = [e for e in loci(beam, over, np.linspace(low, high, 31)).events if e.kind == "crossing"]
    assert [set(event.branches) for event in found] == [pair for pair, _ in expected]
    for event, (_, at) in zip(found, expected, strict=True):
        assert at - 1e-6 <= event.at <= at + (high - low) / 300 + 1e-6
        solution = solve(beam.replace(**{over: event.at}), modes=6, tolerance=1e-9)
        f = [solution.frequencies[solution.labels.index(label)] for label in event.branches]
        assert f[0] == pytest.approx(f[1], rel=1e-5)
        assert event.frequency == pytest.approx(f[0], rel=1e-5)


def exchanged(first, last, k, modes):
    """The share of mode k that is mode k + 1 at the other end, by mass-weighted shapes."""
    x, w = np.polynomial.legendre.leggauss(40)
    x, w = (x + 1) / 2, w / 2
    shapes = []
    for solution, mode in ((first, k), (last, k + 1)):
        mass = solution.beam.alpha**0.5 * solution.shape(mode, np.array([solution.beam.beta]))
        shapes.append(np.concatenate((np.sqrt(w)[:, None] * solution.shape(mode, x), mass)))
    return abs((shapes[0].conj() * shapes[1]).sum()) ** 2


def peaks(y):
    """The numbers of values that are greater than both neighbours."""
    return 1 + np.flatnonzero((y[1:-1] > y[:-2]) & (y[1:-1] > y[2:]))


@pytest.mark.parametrize("seed", [7, *slow(0, 6, 14)])
def test_veerings_of_random_beams(seed):
    """With Coriolis, on a dense grid: a veering is where the gap of two neighbours has a small
    minimum and the shapes are exchanged between the greatest gaps before and after; there is none
    where they are clearly not exchanged."""
    beam, over, low, high = outward_chart(seed, "gamma", "alpha", "beta", "delta")
    dense = np.linspace(low, high, 401)
    beams = [beam.replace(**{over: x}) for x in dense]
    solutions = solve_many(beams, modes=5, coriolis=True)
    f = np.array([solution.frequencies for solution in solutions])
    events = loci(beam, over, np.linspace(low, high, 41), coriolis=True).events
    found = [event.at for event in events if event.kind == "veering"]
    for k in range(4):
        gap = f[:, k + 1] - f[:, k]
        greatest = np.array([0, *peaks(gap), 400])
        for i in peaks(-gap):
            start, stop = greatest[greatest < i][-1], greatest[greatest > i][0]
            share = exchanged(solutions[start], solutions[stop], k, 5)
            near = [at for at in found if dense[i - 1] <= at <= dense[i + 1]]
            if share > 0.6 and gap[i] < 0.8 * CLOSE * f[i, k]:
                assert near, (k, dense[i], share)
            if share < 0.5 * math.sin(ROTATED) ** 2 or gap[i] > 1.2 * CLOSE * f[i, k + 1]:
                assert not near, (k, dense[i], share)


def dense_resonances(beam, stop, modes, **options):
    """Intersections of sorted frequencies on a dense grid of direct solves: no tracking, no
    interpolation; for each (per_rev, speed before, speed after)."""
    speeds = np.linspace(0, stop, 401)[:-1]
    f = np.full((400, modes), np.nan)
    outcomes = solve_many([beam.replace(gamma=x) for x in speeds], modes=modes, **options)
    for row, outcome in zip(f, outcomes, strict=True):
        if not isinstance(outcome, BeamvizError):
            row[:] = np.nan_to_num(outcome.frequencies, nan=0.0)
    for k in (1, 2, 3):
        above = f > k * speeds[:, None]
        changes = (above[1:] != above[:-1]) & np.isfinite(f[1:] + f[:-1])
        for i, _ in np.argwhere(changes):
            yield k, speeds[i], speeds[i + 1]


@pytest.mark.parametrize("seed", SEEDS)
def test_resonances_are_those_of_direct_solves(seed):
    """Every intersection on a dense grid is found within its step, for any sweep."""
    beam, _, speeds, _, options = random_chart(seed, "gamma")
    for found in charts(beam, "gamma", speeds, **options):
        remaining = [(one.per_rev, one.at) for one in resonances(found, 3)]
        ends = [limit.start for limit in found.limits if limit.kind == "no-equilibrium"]
        for k, low, high in dense_resonances(beam, min([speeds[-1], *ends]), **options):
            here = [one for one in remaining if one[0] == k and low - 1e-6 <= one[1] <= high + 1e-6]
            assert here, (k, low, high)
            remaining.remove(here[0])
        for k, at in remaining:  # closer together than the dense grid, or just before a limit
            frequencies = solve(beam.replace(gamma=at), **options).frequencies
            assert np.nanmin(abs(frequencies - k * at)) < 1e-5 * k * at
