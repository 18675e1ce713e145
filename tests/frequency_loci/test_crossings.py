"""Crossings: those of the paper, of the same two modes, and of two pairs of modes at one value.

The paper's are of Nonlinear Dynamics 2017, section 4, figures 5-11: mu 70, delta 0. The values for
both curvature measures were computed independently of this project, in the digits given here. The
paper calls them veerings, but without Coriolis forces bending and stretching modes are uncoupled.

At rest the frequencies of stretching are proportional to the slenderness and those of bending do
not depend on it: it is chosen such that they cross.
"""

from itertools import combinations

import numpy as np
import pytest
from helpers import KNOWN_KINDS, slow
from scipy.optimize import brentq, minimize_scalar

from beamviz import Beam, loci, solve
from beamviz.errors import NotConverged
from beamviz.frequency_loci import path

MU = 70.0
TIP = Beam(alpha=1, beta=1)


@pytest.mark.parametrize(("column", "curvature"), [(0, "material"), (1, "spatial")])
@pytest.mark.parametrize(
    ("beam", "over", "stop", "expected"),  # of each crossing the value by both and bending branch
    [
        (Beam(alpha=1, beta=0.5), "gamma", 20, [(9.206, 9.373, "B3")]),
        (Beam(alpha=1, beta=0.8), "gamma", 20, [(6.662, 6.824, "B3"), (17.343, 17.589, "B2")]),
        (TIP, "gamma", 20, [(4.406, 4.464, "B3"), (16.215, 16.319, "B2")]),
        (Beam(), "alpha", 2, [(1.570, 1.570, "B3")]),
        (Beam(gamma=5), "alpha", 2, [(0.921, 0.929, "B3")]),
        (Beam(gamma=10), "alpha", 2, [(0.477, 0.485, "B3"), (1.747, 1.758, "B2")]),
        (Beam(0.5, gamma=5), "beta", 1, [(0.0877, 0.0872, "B4"), (0.2234, 0.2242, "B4")]),
    ],
)
def test_crossings_of_the_paper(beam, over, stop, expected, column, curvature):
    """Each printed crossing of a bending locus with the stretching one, and no other event."""
    values = np.linspace(0, stop, 81)
    events = loci(beam, over, values, curvature=curvature, kinds=KNOWN_KINDS).events
    for event, row in zip(events, expected, strict=True):
        assert (event.kind, set(event.branches), event.gap) == ("crossing", {row[2], "S1"}, 0)
        half_a_digit = 0.51e-4 if over == "beta" else 0.51e-3
        assert event.at == pytest.approx(row[column], abs=half_a_digit)


def test_elements_of_the_paper():
    """Its own 20 cubic elements move its crossings by less than a printed digit."""
    values = np.linspace(0, 20, 21)
    events = loci(TIP, "gamma", values, method="ancf", kinds=KNOWN_KINDS).events
    assert [event.at for event in events] == pytest.approx([4.464, 16.319], abs=2e-3)


def test_with_coriolis_they_veer():
    """alpha = beta = 1: the crossing at 4.4641 becomes a least gap of 0.241 at gamma 4.650."""
    values = np.linspace(0, 8, 81)
    (event,) = loci(TIP, "gamma", values, coriolis=True, kinds=KNOWN_KINDS).events
    assert (event.kind, event.branches) == ("veering", ("B3", "S1"))
    assert (event.at, event.gap) == pytest.approx((4.650, 0.241), abs=5e-4)
    assert event.index > 0.99


@pytest.mark.parametrize(
    ("over", "start", "stop"), [("gamma", 0, 20), ("mu", 10, 200), ("beta", 0, 1)]
)
def test_place_and_width_of_a_veering(over, start, stop):
    """By direct solves the gap is least at the place, and sqrt(2) times as large, to the second
    order, at a distance of the width."""
    beam = Beam(alpha=1, beta=0.5, gamma=10)
    events = loci(beam, over, np.linspace(start, stop, 21), 6, coriolis=True).events
    veerings = [event for event in events if event.kind == "veering"]
    assert veerings
    for event in veerings:
        step, squares = 0.02 * event.width, []
        for at in event.at + step * np.array([-1, 0, 1]):
            there = solve(beam.replace(**{over: at}), 7, coriolis=True, tolerance=1e-11).frequencies
            squares.append(min(np.diff(there), key=lambda gap: abs(gap - event.gap)) ** 2)
        before, least, after = squares
        bend = before + after - 2 * least
        assert least**0.5 == pytest.approx(event.gap, rel=1e-6)
        assert step * abs(before - after) / (2 * bend) < 1e-4 * event.width
        assert step * (2 * least / bend) ** 0.5 == pytest.approx(event.width, rel=0.02)


def by_label(**numbers):
    """The frequencies of a beam by their labels."""
    found = solve(Beam(mu=MU, **numbers), modes=9, tolerance=1e-11)
    return dict(zip(found.labels, found.frequencies.tolist(), strict=True))


def mu_of_crossing(modes):
    """The slenderness at which S1 crosses B3."""
    return MU * modes["B3"] / modes["S1"]


@pytest.mark.parametrize(("depth", "points"), [(1e-3, 2), (1e-5, 5), *slow((1e-5, 201))])
def test_two_crossings_of_the_same_pair(depth, points):
    """Over beta B3 crosses S1 and crosses back, at any small distance: both crossings are found,
    also by few points, and none where the two just do not reach each other."""
    top = minimize_scalar(
        lambda beta: -mu_of_crossing(by_label(alpha=1.0, beta=beta)),
        bounds=(0.49, 0.55),
        method="bounded",
        options={"xatol": 1e-7},
    )
    values = np.linspace(0.4, 0.6, points)
    charts = (
        loci(Beam(alpha=1, mu=-top.fun * x), "beta", values, 6) for x in (1 - depth, 1 + depth)
    )
    above, below = ([e for e in one.events if set(e.branches) == {"B3", "S1"}] for one in charts)
    assert [event.kind for event in above] == ["crossing", "crossing"]
    first, last = above
    assert first.branches == last.branches[::-1]
    assert first.at < top.x < last.at
    for event in above:
        there = by_label(alpha=1.0, beta=event.at)
        assert there["B3"] == pytest.approx(there["S1"] * -top.fun * (1 - depth) / MU, rel=1e-8)
    assert [event for event in below if event.kind == "crossing"] == []


@pytest.mark.parametrize("points", [2, 201])
def test_two_pairs_cross_at_one_value(points):
    """Over alpha S1 crosses B3 where S2 crosses B5."""

    def apart(alpha):
        there = by_label(alpha=alpha)
        return there["S2"] / there["S1"] - there["B5"] / there["B3"]

    at = brentq(apart, 0.02, 1.0, xtol=1e-12)
    mu = mu_of_crossing(by_label(alpha=at))
    events = loci(Beam(mu=mu), "alpha", np.linspace(0, 1, points), 8).events
    pairs = [event for event in events if event.at == pytest.approx(at, abs=1e-6)]
    assert {frozenset(event.branches) for event in pairs} == {
        frozenset(("B3", "S1")),
        frozenset(("B5", "S2")),
    }
    assert all(event.kind == "crossing" for event in pairs)


@pytest.mark.parametrize(
    ("coriolis", "points"), [(False, 2), (True, 201), *slow((False, 201), (True, 2))]
)
def test_three_modes_close_together(coriolis, points):
    """B3 and B4 of a beam with a heavy mass veer, and S1 lies between them there: all three are
    within 3 % of each other. Both crossings of S1 are found; with Coriolis forces both veer."""
    beam = Beam(alpha=100, beta=0.85382006, delta=1, mu=9339.19)
    found = loci(beam, "gamma", np.linspace(18, 22, points), 5, coriolis=coriolis)
    if coriolis:
        assert [event.kind for event in found.events] == ["veering", "veering"]
    else:
        assert [(event.kind, *sorted(event.branches)) for event in found.events] == [
            ("crossing", "B4", "S1"),
            ("veering", "B3", "B4"),
            ("crossing", "B3", "S1"),
        ]
    for event in found.events:
        there = solve(beam.replace(gamma=event.at), 5, coriolis=coriolis, tolerance=1e-11)
        gaps = [b - a for a, b in combinations(there.frequencies.tolist(), 2)]
        off = min(abs(gap - event.gap) for gap in gaps)
        assert off < 1e-8 * event.frequency + 1e-3 * event.gap
    assert np.ptp([event.frequency for event in found.events]) < 0.05 * event.frequency


@pytest.mark.parametrize(
    ("beam", "options", "k", "places"),
    [
        # Two narrow ones of one pair in neighbouring intervals of the chart's grid.
        (
            Beam(alpha=4.405385057193533, gamma=0.57234, delta=2.8526, mu=412.88464),
            {"strain": "hencky", "modes": 9},
            6,
            [(0.2358, 0.2359), (0.2460, 0.2461)],
        ),
        *slow(
            # A wide one: the upper mode veers with the next one where their gap begins to shrink.
            (
                Beam(alpha=2.41905799, gamma=2.0829447, mu=20.33692185),
                {"strain": "biot", "modes": 5},
                4,
                [(0.65, 0.67)],
            ),
            # Two of one pair with the greatest gap between them in half an interval.
            (
                Beam(alpha=0.071239045, gamma=200, delta=1.80749973, mu=268.34366377),
                {"modes": 6},
                4,
                [(0.95, 0.962), (0.965, 0.98)],
            ),
        ),
    ],
)
def test_veerings_beside_others(beam, options, k, places):
    """Of random charts: the least gaps of modes k and k + 1 are those that direct solves have."""
    events = loci(beam, "beta", [0, 1], coriolis=True, **options).events
    precise = options | {"coriolis": True, "modes": k + 2, "tolerance": 1e-9}

    def pair(beta):
        return solve(beam.replace(beta=beta), **precise).frequencies[k:]

    for ends in places:
        least = minimize_scalar(
            lambda beta: np.diff(pair(beta))[0],
            bounds=ends,
            method="bounded",
            options={"xatol": 1e-8},
        )
        lower, upper = pair(least.x)
        (event,) = [
            event
            for event in events
            if ends[0] < event.at < ends[1]
            and lower - least.fun < event.frequency < upper + least.fun
        ]
        assert event.kind == "veering"
        assert event.gap == pytest.approx(least.fun, rel=1e-4)
        assert event.at == pytest.approx(least.x, abs=0.05 * event.width)


@pytest.mark.parametrize("points", [2, 201])
def test_a_pair_of_a_family_leaves_the_modes_solved(points):
    """S2 and S3 veer among the modes solved; on one side so many bending modes are below S3 that it
    is not solved. All events are those of a chart of more modes."""
    beam = Beam(alpha=2.7350654217994324, beta=0.7777072529582892, gamma=14.592521611544475)
    few, more = (loci(beam, "mu", np.linspace(15, 150, points), modes=n) for n in (7, 9))
    places = [event.at for event in more.events]
    assert few.events
    assert all(np.isclose(event.at, places, rtol=1e-6).any() for event in few.events)


def test_solutions_may_be_missing_beside_a_veering(monkeypatch):
    """All other events are as without them."""
    beam, values = Beam(alpha=2.7, gamma=3, mu=20), np.linspace(0, 1, 11)
    whole = loci(beam, "beta", values, 6).events
    (veering,) = (event for event in whole if event.gap)
    assert veering.branches == ("S2", "S3")
    solve_many = path.solve_many

    def failing(beams, **options):
        found = solve_many(beams, **options)
        beside = [0 < veering.at - one.beta < 0.02 * veering.width for one in beams]
        return [NotConverged("") if own else one for own, one in zip(beside, found, strict=True)]

    monkeypatch.setattr(path, "solve_many", failing)
    found = loci(beam, "beta", values, 6).events
    assert [event.branches for event in found] == [
        event.branches for event in whole if not event.gap
    ]


def test_a_mode_that_passes_two_others_within_an_interval():
    """B4 passes S5 and S4 between two values of the chart's grid: each veering is that of a chart
    with a grid 500 times as fine."""
    beam = Beam(alpha=1.54, beta=0.287, gamma=1.49, delta=0.835)

    def veerings(low: float, high: float) -> list:
        found = loci(beam, "mu", np.linspace(low, high, 3), 9, coriolis=True)
        return [event for event in found.events if 16.5 < event.at < 18]

    coarse, fine = veerings(10, 500), veerings(16.5, 18)
    assert len(coarse) == len(fine) == 2
    for event, reference in zip(coarse, fine, strict=True):
        assert event.at == pytest.approx(reference.at, rel=1e-4)
        assert event.gap == pytest.approx(reference.gap, rel=1e-3)


@pytest.mark.parametrize(("gamma", "modes"), [(1e-6, 5), (1e-3, 14), (1e-3, 20)])
def test_gaps_that_do_not_vary_have_no_least_one(gamma, modes):
    """At so low a speed the radius of the hub changes no frequency: what is left of the gaps'
    variation is rounding error, whose minima were ranges of events that could not be located."""
    found = loci(Beam(gamma=gamma), "delta", [0, 1], modes, coriolis=True)
    assert (found.events, found.limits) == ((), ())


@pytest.mark.parametrize("gamma", [0.001, 0.1])
def test_a_weak_veering_is_found(gamma):
    """In a chart of 20 of its widths and in one of 2. The gap is in proportion to the speed."""
    (crossing,) = loci(Beam(beta=1), "alpha", [1, 2], 4).events
    wide = loci(Beam(gamma=gamma), "alpha", [1, 2], 4, coriolis=True)
    (veering,) = wide.events
    assert veering.at == pytest.approx(crossing.at, abs=0.02)
    for widths in (10, 1):
        ends = veering.at + widths * veering.width * np.array([-1, 1])
        (near,) = loci(Beam(gamma=gamma), "alpha", ends, 4, coriolis=True).events
        assert near.at == pytest.approx(veering.at, abs=1e-3 * veering.width)
        assert near.gap == pytest.approx(veering.gap, rel=1e-3)


def test_loci_that_come_close_and_keep_their_shapes():
    """By direct solves the gap of two modes is least there, and each has the same shape before and
    after it: it is neither a crossing nor a veering."""
    beam, options = Beam(alpha=0.5, gamma=6, delta=0.5, mu=40), {"coriolis": True, "modes": 9}
    found = loci(beam, "beta", np.linspace(0.37, 0.47, 21), **options)
    (event,) = (event for event in found.events if event.kind == "close approach")
    assert not [
        other for other in found.events if abs(other.at - event.at) < 0.01 and other != event
    ]
    assert event.modes[1] == event.modes[0] + 1

    def solved(beta):
        return solve(beam.replace(beta=beta), **options)

    def gap(beta):
        return np.diff(solved(beta).frequencies[list(event.modes)]).item()

    least = minimize_scalar(
        gap,
        (event.at - 0.01, event.at + 0.01),
        method="bounded",
        bounds=(event.at - 0.01, event.at + 0.01),
        options={"xatol": 1e-8},
    )
    assert event.at == pytest.approx(least.x, abs=1e-4)
    assert event.gap == pytest.approx(least.fun, rel=1e-6)
    assert 0 < event.gap < 0.1 * event.frequency
    x = np.linspace(0, 1, 201)
    before, after = (solved(event.at + step).displacement(x) for step in (-0.01, 0.01))
    for mode in event.modes:
        a, b = before[..., mode].ravel(), after[..., mode].ravel()
        assert abs(np.vdot(a, b)) > 0.9 * np.linalg.norm(a) * np.linalg.norm(b)
