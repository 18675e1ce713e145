"""The error bars of random charts against direct solves, and their events against sorted gaps.

BEAMVIZ_CHARTS sets the number of charts (hundreds take minutes), BEAMVIZ_FIRST_CHART the first.
"""

import os
from collections import Counter

import numpy as np
import pytest

from beamviz import Beam, BeamvizError, loci, solve

FIRST, CHARTS = (
    int(os.environ.get(f"BEAMVIZ_{name}", default))
    for name, default in (("FIRST_CHART", 0), ("CHARTS", 20))
)
PLACES = 12  # of each chart, drawn anew: solved with a thousandth of the tolerance
GAMMA_OVER_MU = 4.99


def random_chart(seed):
    """A beam, what is swept, the values and the options: Coriolis forces, inward beams, strain laws
    with a limit of equilibrium, large stretch and few points included."""
    chance = np.random.default_rng(seed)
    names, shares = ["gamma", "alpha", "beta", "delta", "mu"], [0.4, 0.2, 0.1, 0.2, 0.1]
    over, stay = str(chance.choice(names, p=shares)), [0.4, 0.4, 0.2]
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


def outside(beam, over, found, places, options):
    """By how many of its error bars each frequency at some places is off."""
    ratios = []
    for value in places:
        k = int(np.searchsorted(found.values, value))
        try:
            exact = solve(beam.replace(**{over: value}), tolerance=1e-9, **options)
        except BeamvizError:
            continue
        rows = [branch for branch in found.branches if branch.mode_index[k] >= 0]
        if not rows:  # no answer within the tolerance of the chart
            continue
        assert sorted(branch.mode_index[k] for branch in rows) == list(range(options["modes"]))
        for branch in rows:
            i = branch.mode_index[k]
            if exact.omega_squared[i] > 0 and branch.omega_squared[k] > 0:
                off = abs(branch.frequency[k] - exact.frequencies[i])
                ratios.append(off / (branch.error[k] + exact.errors[i]))
    return ratios


@pytest.mark.slow
def test_error_bars_of_random_charts():
    """Every frequency of a chart lies within its error bar of that of a direct solve, at places
    that the chart did not choose."""
    worst, counts = {}, Counter()
    for seed in range(FIRST, FIRST + CHARTS):
        beam, over, values, places, options = random_chart(seed)
        try:
            found = loci(beam, over, values, **options)
        except BeamvizError as error:
            counts[error.kind] += 1
            continue
        ratios = outside(beam, over, found, places, options)
        counts["values"] += len(ratios)
        if max(ratios, default=0.0) > 1:
            worst[seed] = max(ratios), beam, over, options
            counts["outside"] += sum(ratio > 1 for ratio in ratios)
    print(dict(counts), worst)
    assert not worst
    assert counts["values"] > 10 * CHARTS


@pytest.mark.slow
def test_events_of_random_charts_are_those_of_many_points():
    """A chart of few points has the crossings and veerings of one of many, at the same places."""
    missed = {}
    for seed in range(FIRST, FIRST + CHARTS):
        beam, over, values, _, options = random_chart(seed)
        ends = values[[0, -1]]
        try:
            few, many = (loci(beam, over, np.linspace(*ends, n), **options) for n in (3, 401))
        except BeamvizError:
            continue
        a, b = ([(e.kind, e.branches) for e in one.events] for one in (few, many))
        places = [[e.at for e in one.events] for one in (few, many)]
        if a != b or not np.allclose(*places, rtol=0, atol=1e-5 * np.ptp(ends)):
            missed[seed] = [a, b], places
    print(missed)
    assert not missed
