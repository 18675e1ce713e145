"""Tracking and classification on small problems whose answers are known in closed form."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import block_diag, expm
from scipy.optimize import minimize_scalar

from beamviz.frequency_loci.tracking import (
    CLEAR,
    assignment,
    follow,
)
from tests.sweeps import Problem, crossing, frequencies, rotation


def spinning() -> Problem:
    """Three modes far apart whose shapes rotate fast about one axis."""
    K, axis = np.diag([100.0, 900.0, 2500.0]), np.cross(np.eye(3), np.ones(3) / math.sqrt(3))
    return Problem(lambda p: expm(5 * p * axis) @ K @ expm(-5 * p * axis))


def grid(count: int) -> np.ndarray:
    """Values of the parameter."""
    return np.linspace(-1.0, 1.0, count)


@pytest.mark.parametrize("coupling", [0.0, 1e-5, 1e-3, 0.1, 1.0, 4.0])
@pytest.mark.parametrize("count", [2, 3, 20, 21, 201])
def test_two_modes_cross_or_veer(count, coupling):
    """lambda = 100 +- sqrt((20 p)^2 + c^2): gap, width, coupling s = 20 and index 1 of a veering,
    in closed form, and branches that keep their order; a crossing to rounding, no gap, and branches
    that change places."""
    track, (event,) = crossing(0.137, coupling).chart(grid(count), 2)
    assert event.kind == ("veering" if coupling else "crossing")
    assert event.at == pytest.approx(0.137, abs=1e-3 * coupling / 20 or 1e-12)
    assert track.branch[0].tolist() == [0, 1]
    assert track.branch[-1].tolist() == ([0, 1] if coupling else [1, 0])
    numbers = event.coupling, event.index, event.width
    if not coupling:
        assert event.frequency == pytest.approx(10, abs=1e-12)
        assert (event.gap, *numbers) == (0, 0, 0, 0)
        return
    assert event.gap == pytest.approx(
        math.sqrt(100 + coupling) - math.sqrt(100 - coupling), rel=1e-6
    )
    assert numbers == pytest.approx((20, 1, coupling / 20), rel=1e-4)
    assert (track.branch == [0, 1]).all()


@pytest.mark.slow
@given(
    st.floats(-0.9, 0.9),
    st.floats(-30, 30),
    st.floats(3, 30),
    st.one_of(st.just(0.0), st.floats(-4, 0).map(lambda power: 10.0**power)),
    st.integers(8, 60),
)
def test_any_two_modes_have_one_event(at, slope, difference, coupling, count):
    """A straight crossing, or veering, at any place and slope, on any grid: one event, located as
    by direct minimisation."""

    def stiffness(p):
        low, high = slope * (p - at), (slope + difference) * (p - at)
        return np.array([[400 + low, coupling], [coupling, 400 + high]])

    def gap(p):
        low, high = np.linalg.eigvalsh(stiffness(p))
        return math.sqrt(high) - math.sqrt(low)

    _, events = Problem(stiffness).chart(grid(count), 2)
    (event,) = events
    width = coupling / difference
    near = minimize_scalar(
        gap,
        bounds=(at - 3 * width - 1e-9, at + 3 * width + 1e-9),
        method="bounded",
        options={"xatol": 1e-12},
    )
    assert event.kind == ("veering" if coupling else "crossing")
    assert event.at == pytest.approx(near.x, abs=0.1 * width + 1e-8)
    assert event.gap == pytest.approx(near.fun if coupling else 0, rel=1e-3, abs=1e-9)


def test_few_solves():
    """A crossing takes one solve beside the grid, a veering one and two for its index."""
    problem = crossing(0.137)
    problem.chart(grid(201), 2)
    assert problem.solves == 202
    problem = crossing(0.137, 0.01)
    problem.chart(grid(201), 2)
    assert problem.solves <= 206


@pytest.mark.parametrize("count", [4, 11, 12, 101])
@pytest.mark.parametrize("depth", [1e-4, 1e-2, 0.1, -1e-4, -1e-2, -0.1])
def test_two_crossings_between_two_points_are_seen(count, depth):
    """A lens narrower than the grid: the difference 20 ((p - 0.05)^2 - depth) of uncoupled modes
    has two roots; with a negative depth they nearly touch, and no event is made up."""
    problem = Problem(lambda p: np.diag([100.0, 100 + 20 * ((p - 0.05) ** 2 - depth)]))
    _, events = problem.chart(grid(count), 2)
    roots = [0.05 - math.sqrt(depth), 0.05 + math.sqrt(depth)] if depth > 0 else []
    assert [event.kind for event in events] == ["crossing"] * len(roots)
    assert [event.at for event in events] == pytest.approx(roots, abs=1e-9)


@pytest.mark.parametrize("count", [12, 31, 201])
def test_two_veerings_close_together(count):
    """A lens of two coupled modes: both veerings, and no exchange from end to end."""

    def stiffness(p):
        return np.array([[100.0, 0.01], [0.01, 100 + 20 * ((p - 0.05) ** 2 - 0.01)]])

    track, events = Problem(stiffness).chart(grid(count), 2)
    assert [event.kind for event in events] == ["veering", "veering"]
    assert [event.at for event in events] == pytest.approx([-0.05, 0.15], abs=1e-4)
    assert (track.branch == [0, 1]).all()


@pytest.mark.parametrize(
    ("problem", "values"),
    [
        (Problem(lambda p: np.array([[100 - p * p, 0.5], [0.5, 108 + p * p]])), grid(101)),
        (crossing(0.0, 15.0), 4 * grid(101)),
    ],
    ids=["shapes hardly rotate", "gap of a good part of the frequency"],
)
def test_a_least_gap_that_is_no_veering(problem, values):
    """Two coupled modes that pass at a distance, or exchange their shapes over a wide range."""
    assert problem.chart(values, 2)[1] == []


@pytest.mark.parametrize("count", [7, 40, 201])
def test_three_modes_one_of_them_apart(count):
    """Two modes veer while a third, which couples with neither, crosses both."""

    def stiffness(p):
        pair = np.array([[100 + 20 * p, 0.2], [0.2, 100 - 20 * p]])
        return block_diag(pair, [[101 - 3 * p]])

    _, events = Problem(stiffness).chart(grid(count), 3)
    veering, *crossings = sorted(events, key=lambda event: event.kind, reverse=True)
    assert [event.kind for event in crossings] == ["crossing", "crossing"]
    assert (veering.kind, veering.at) == ("veering", pytest.approx(0, abs=1e-4))
    assert veering.branches in {(0, 1), (0, 2)}
    for event in crossings:
        squares = np.linalg.eigvalsh(stiffness(event.at))
        assert np.diff(squares).min() < 1e-9 * squares[0]


@pytest.mark.parametrize("count", [15, 40, 201])
def test_three_modes_that_all_couple(count):
    """A third mode veers with two others one after the other; all branches keep their order."""

    def stiffness(p):
        return np.array([[100.0, 0.02, 0.1], [0.02, 104.0, 0.2], [0.1, 0.2, 102 + 10 * p]])

    def gap(k):
        def at(p):
            squares = np.linalg.eigvalsh(stiffness(p))
            return math.sqrt(squares[k + 1]) - math.sqrt(squares[k])

        return at

    track, events = Problem(stiffness).chart(grid(count), 3)
    assert (track.branch == [0, 1, 2]).all()
    assert [(event.kind, event.branches) for event in events] == [
        ("veering", (0, 1)),
        ("veering", (1, 2)),
    ]
    for k, event in enumerate(events):
        truth = minimize_scalar(gap(k), bounds=(event.at - 0.1, event.at + 0.1), method="bounded")
        assert event.at == pytest.approx(truth.x, abs=1e-5)
        assert event.gap == pytest.approx(truth.fun, rel=1e-5)
        assert 0.9 < event.index < 1


def test_three_crossings_at_one_place():
    """Three uncoupled modes that meet in one point: each two of them cross."""
    problem = Problem(lambda p: np.diag([100 + 5 * p, 100 - 5 * p, 100 + p]))
    track, events = problem.chart(np.linspace(-1, 1, 20), 3)
    assert sorted(event.branches for event in events) == [(0, 1), (0, 2), (1, 2)]
    assert {event.kind for event in events} == {"crossing"}
    assert track.branch[-1].tolist() == [2, 1, 0]


def test_modes_that_couple_cross_where_their_coupling_vanishes():
    """Perkins & Mote (1986): modes rotated by a fixed angle couple everywhere but at the crossing;
    there is no gap, and the branches go through each other."""

    def stiffness(p):
        return (
            100 * np.eye(2) + rotation(0.3 + 0.2 * p) @ np.diag([p, -p]) @ rotation(0.3 + 0.2 * p).T
        )

    track, (event,) = Problem(stiffness).chart(np.linspace(-1.03, 1, 41), 2)
    assert (event.kind, event.gap) == ("crossing", 0)
    assert event.at == pytest.approx(0, abs=1e-7)
    assert track.branch[0].tolist() == [0, 1]
    assert track.branch[-1].tolist() == [1, 0]


def test_a_point_of_the_grid_on_the_crossing():
    """Two equal frequencies, whose shapes the solver may mix at will, are one crossing."""

    def stiffness(p):
        apart = np.diag([100 + p, 100 - p])
        return apart + (1e-13 * np.ones((2, 2)) if p == 0 else 0)

    _, events = Problem(stiffness).chart(grid(21), 2)
    assert [(event.kind, event.gap) for event in events] == [("crossing", 0)]
    assert events[0].at == pytest.approx(0, abs=1e-9)


def test_ambiguous_steps_are_halved():
    """Shapes that all rotate by a large angle from point to point: points between tell them."""
    problem = spinning()
    track = follow(problem(grid(11)), 3, problem)
    assert len(track.points.at) > 11
    assert track.confidence.min() >= CLEAR
    assert (track.branch == [0, 1, 2]).all()


def test_ambiguity_that_remains_shows_in_the_confidence():
    """Shapes without any order end the search, and the confidence says so."""
    chance = np.random.default_rng(1)

    def stiffness(p):
        Q, _ = np.linalg.qr(chance.normal(size=(6, 6)))
        return Q @ np.diag(np.arange(1.0, 7.0)) @ Q.T

    problem = Problem(stiffness)
    track = follow(problem(grid(11)), 4, problem)
    assert track.confidence.min() < CLEAR
    assert problem.solves < 1000


def test_a_solver_with_holes_ends_the_search():
    """Where nothing exists between two points, the steps stay as they are."""
    points = spinning()(grid(11))
    track = follow(points, 3, lambda values: points.take(slice(0)))
    assert len(track.points.at) == 11
    assert track.confidence.min() < CLEAR


def test_a_mode_that_enters_and_leaves_the_window():
    """Of four modes three are solved for and two asked for: one dives into them and out again."""
    K = np.diag([100.0, 200.0, 300.0])
    problem = Problem(lambda p: block_diag(K, [[150 + 900 * p * p]]), modes=4)
    track, events = problem.chart(grid(41), 2)
    assert [event.kind for event in events] == ["crossing", "crossing"]
    assert [event.at for event in events] == pytest.approx([-1 / math.sqrt(18), 1 / math.sqrt(18)])
    lowest = np.sort(track.points.omega_squared, axis=1)[:, :2]
    found = frequencies(track, 2) ** 2
    assert [
        set(np.round(row[~np.isnan(row)], 6)) >= set(np.round(low, 6))
        for row, low in zip(found, lowest, strict=True)
    ]


def test_a_mode_not_solved_for_before_is_a_new_branch():
    """A mode that dives from beyond all modes solved for has a number of its own."""
    problem = Problem(lambda p: np.diag([100.0, 200.0, 300.0, 400.0, 650.0 - 600 * p]), 3)
    track, events = problem.chart(grid(41), 2)
    assert track.branch[0].tolist() == [0, 1, 2]
    new = track.branch[-1][0]
    assert new > 2
    assert track.branch[-1][1] == 0
    assert [new in event.branches for event in events] == [True, True]


def test_assignment_is_the_best_in_sum():
    """Not the greedy one: 0.6 + 0.5 is more than 0.7 + 0.1."""
    mac = np.array([[[0.7, 0.6], [0.5, 0.1]]])
    assert assignment(mac).tolist() == [[1, 0]]
    assert assignment(np.eye(3)[None]).tolist() == [[0, 1, 2]]
