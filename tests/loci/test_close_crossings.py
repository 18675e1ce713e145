"""Crossings close together: of the same two modes, and of two pairs of modes at one place.

At rest the slenderness scales the frequencies of stretching and leaves those of bending alone: so
it is chosen to make them meet.
"""

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar

from beamviz import Beam, loci, solve

MU = 70.0


def by_label(**numbers):
    """The frequencies of a beam by their labels."""
    found = solve(Beam(mu=MU, **numbers), modes=9, tolerance=1e-11)
    return dict(zip(found.labels, found.frequencies.tolist(), strict=True))


def mu_of_meeting(modes):
    """The slenderness at which S1 meets B3."""
    return MU * modes["B3"] / modes["S1"]


@pytest.mark.parametrize("points", [2, 5, 201])
@pytest.mark.parametrize("depth", [1e-3, 1e-5])
def test_two_crossings_of_the_same_pair(depth, points):
    """Over the place of the mass B3 reaches S1 in a lens, as flat as wanted: both its ends are
    found, also by few points, and none where the two just miss each other."""
    top = minimize_scalar(
        lambda beta: -mu_of_meeting(by_label(alpha=1.0, beta=beta)),
        bounds=(0.49, 0.55),
        method="bounded",
        options={"xatol": 1e-7},
    )
    values = np.linspace(0.4, 0.6, points)
    above, below = (
        [
            event
            for event in loci(Beam(alpha=1, mu=-top.fun * scale), "beta", values, 6).events
            if set(event.branches) == {"B3", "S1"}
        ]
        for scale in (1 - depth, 1 + depth)
    )
    assert [event.kind for event in above] == ["crossing", "crossing"]
    first, last = above
    assert first.branches == last.branches[::-1]
    assert first.at < top.x < last.at
    for event in above:
        there = by_label(alpha=1.0, beta=event.at)
        assert there["B3"] == pytest.approx(there["S1"] * -top.fun * (1 - depth) / MU, rel=1e-8)
    assert [event for event in below if event.kind == "crossing"] == []


@pytest.mark.parametrize("points", [2, 5, 201])
def test_two_pairs_cross_at_one_place(points):
    """Over the mass S1 meets B3 where S2 meets B5."""

    def apart(alpha):
        there = by_label(alpha=alpha)
        return there["S2"] / there["S1"] - there["B5"] / there["B3"]

    at = brentq(apart, 0.02, 1.0, xtol=1e-12)
    mu = mu_of_meeting(by_label(alpha=at))
    events = loci(Beam(mu=mu), "alpha", np.linspace(0, 1, points), 8).events
    pairs = [event for event in events if event.at == pytest.approx(at, abs=1e-6)]
    assert {frozenset(event.branches) for event in pairs} == {
        frozenset(("B3", "S1")),
        frozenset(("B5", "S2")),
    }
    assert all(event.kind == "crossing" for event in pairs)
