"""loci(): branches and their labels, wrong input, and the result: branches by label, the branch of
each mode, text, pickling."""

import itertools
import math
import pickle
import re

import numpy as np
import pytest
from helpers import KNOWN_KINDS, sorted_frequencies

from beamviz import Beam, InvalidInput, loci, solve
from beamviz.frequency_loci import Event, at_values

TIP = Beam(alpha=1, beta=1)
FEW_TERMS = "modes = 5: at most 3 with terms = 3; ask for more"


def test_a_family_changes_along_a_branch_with_coriolis():
    """Through the veering branches keep their order; bending becomes stretching and vice versa."""
    found = loci(TIP, "gamma", np.linspace(0, 10, 101), coriolis=True)
    lower, upper = found["B3"], found["S1"]
    assert (lower.frequency < upper.frequency).all()
    assert (lower.family[0], lower.family[-1]) == ("bending", "stretching")
    assert (upper.family[0], upper.family[-1]) == ("stretching", "bending")
    assert lower.bending_fraction[40] > 0.9 > 0.5 > lower.bending_fraction[52]


@pytest.mark.parametrize("gamma", [1e-3, 0.05, 0.2])
def test_the_gap_is_the_gyroscopic_coupling(gamma):
    """To first order in the speed it is 2 gamma |int rho u w| of the uncoupled unit-mass shapes
    (Manconi & Mace 2017); at rest there is none. However narrow, a veering is not a crossing."""
    values = np.linspace(1, 2, 21)
    (crossing,) = loci(Beam(gamma=0), "alpha", values, coriolis=True).events
    there = solve(Beam(alpha=crossing.at))
    x, w = np.polynomial.legendre.leggauss(40)
    x, w = np.append((x + 1) / 2, 1.0), np.append(w / 2, crossing.at)
    bending, stretching = (there.shape(there.labels.index(label), x) for label in ("B3", "S1"))
    coupling = abs(w @ (bending[:, 1] * stretching[:, 0]))
    (veering,) = loci(Beam(gamma=gamma), "alpha", values, coriolis=True).events
    assert (crossing.kind, veering.kind) == ("crossing", "veering")
    assert veering.gap == pytest.approx(2 * gamma * coupling, rel=1e-3)
    assert veering.index == pytest.approx(1, abs=1e-3)


def test_the_solutions_of_one_mass_inside_and_one_at_the_tip():
    """A batch with a single inner mass has a mesh with a break there."""
    for solution in loci(TIP, "beta", [0.5, 1])["B1"].solutions:
        alone = solve(solution.beam, modes=len(solution.frequencies))
        assert solution.frequencies == pytest.approx(alone.frequencies, rel=1e-5)


@pytest.mark.parametrize(
    ("beam", "over", "values", "options", "message"),
    [
        (TIP, "gamma", [], {}, "must be 2 .. 10000 numbers, not 0"),
        (TIP, "gamma", [1], {}, "must be 2 .. 10000 numbers, not 1"),
        (TIP, "gamma", [[1, 2]], {}, "an array of 2 dimensions"),
        (TIP, "gamma", [2, 1], {}, "must ascend, but 1 follows 2"),
        (TIP, "gamma", [1, 1], {}, "must ascend, but 1 follows 1"),
        (TIP, "alpha", [1 + 2e-15, 1], {}, "but 1 follows 1.000000000000002"),
        (TIP, "gamma", [0, math.nan, 1], {}, "gamma = nan: must lie in 0 .. 200"),
        (TIP, "gamma", [0, 201], {}, "gamma = 201: must lie in 0 .. 200"),
        (TIP, "gamma", ["fast", "slow"], {}, "must be numbers"),
        (TIP, "alpha", 10**400, {}, "must be numbers"),
        (TIP, "gamma", itertools.count(), {}, "must be 2 .. 10000 numbers"),
        (TIP, "beta", [0, 1.5], {}, "beta = 1.5: must lie in 0 .. 1"),
        (TIP, "speed", [0, 1], {}, "over = 'speed': must be one of alpha, beta, gamma, delta, mu"),
        (Beam(gamma=150), "mu", [20, 100], {}, "gamma / mu = 7.5: must be at most 5"),
        *((TIP, "gamma", [0, 1], {"modes": n}, "modes = ") for n in (0, 21, 2.5, "many")),
        (TIP, "gamma", [0, 1], {"method": "assumed-modes", "terms": 3}, FEW_TERMS),
    ],
)
def test_wrong_input(beam, over, values, options, message):
    """The error names the value and the range, before anything is solved; or the remedy."""
    with pytest.raises(InvalidInput, match=re.escape(message)):
        loci(beam, over, values, **options)


def test_values_of_a_generator():
    """They are those of the list."""
    found = loci(TIP, "gamma", (float(gamma) for gamma in range(4)))
    assert found.values.tolist() == [0, 1, 2, 3]


@pytest.mark.parametrize(
    ("modes", "options"),
    [
        (1, {}),
        (20, {}),
        *((2, {"method": "ancf", "elements": count}) for count in (1, 2)),
        (3, {"method": "assumed-modes", "terms": 3}),
    ],
)
def test_as_few_and_as_many_modes_as_there_can_be(modes, options):
    """At the most modes, or with as few elements or terms as modes, no extra ones are solved."""
    found = sorted_frequencies(loci(TIP, "gamma", [0, 5, 10], modes=modes, **options))
    assert np.isfinite(found).sum(axis=1).tolist() == [modes] * 3
    assert found[0, :modes] == pytest.approx(solve(TIP, modes, **options).frequencies)


def test_flapwise():
    """Coriolis forces do not act out of the plane of rotation: the families cross."""
    options = {"plane": "flapwise", "coriolis": True, "kinds": KNOWN_KINDS}
    events = loci(TIP, "gamma", np.linspace(0, 10, 41), **options).events
    assert {event.kind for event in events} == {"crossing"}


def test_loci_at_other_values_have_the_same_branches():
    """Around the least gap of a veering, with the same labels and event."""
    found = loci(TIP, "gamma", np.linspace(0, 10, 51), coriolis=True)
    (event,) = found.events
    near = at_values(found, event.at + event.width * np.linspace(-4, 4, 41))
    assert near.events == (event,)
    apart = near["S1"].frequency - near["B3"].frequency
    assert near.values[apart.argmin()] == pytest.approx(event.at, abs=1e-4 * event.width)
    assert apart.min() == pytest.approx(event.gap, rel=1e-6)
    assert np.ptp(apart) > 2 * event.gap


@pytest.mark.parametrize("count", [41, 201])
def test_modes_that_enter_a_buckled_sweep_with_coriolis_do_not_veer(count):
    """A branch that begins has no shape to rotate into; beside the unstable mode two veer."""
    found = loci(Beam(alpha=1, gamma=10), "delta", np.linspace(-1, 1, count), coriolis=True)
    assert found.limits[0].kind == "unstable"
    (event,) = found.events
    assert (event.kind, event.branches) == ("veering", ("B3", "S1"))
    assert event.at == pytest.approx(-0.6658, abs=2e-4)


@pytest.fixture(scope="module")
def tip():
    """Over the speed: S1 crosses B3 at 4.4641 and B2 at 16.319."""
    return loci(TIP, "gamma", np.linspace(0, 20, 21), kinds=KNOWN_KINDS)


def test_a_branch_by_its_label(tip):
    """The frequencies of that mode; the error for an unknown label lists the labels."""
    assert tip["S1"].frequency[0] == pytest.approx(60.22335, abs=1e-5)
    assert tip["S1"] is tip.branches[3]
    with pytest.raises(KeyError, match="no branch 'B9'; branches: B1, B2, B3, S1, B4"):
        tip["B9"]


@pytest.mark.parametrize(
    ("beam", "over", "stop", "modes", "others"),
    [
        *((TIP, "gamma", 20, modes, [3.3, 4.4, 4.464, 4.465, 16.3, 16.33]) for modes in (3, 5)),
        (Beam(alpha=20, gamma=5), "beta", 1, 8, [0.333, 0.777]),
    ],
)
def test_labels_without_coriolis_are_those_of_solutions(beam, over, stop, modes, others):
    """Bending and stretching, counted, also beside crossings and where a branch leaves the
    modes."""
    values = np.union1d(np.linspace(0, stop, 41), others)
    found = loci(beam, over, values, modes)
    for i, value in enumerate(values):
        labels = solve(beam.replace(**{over: value}), modes).labels
        assert labels_by_mode(found, i) == dict(enumerate(labels))


def test_labels_where_shapes_are_exchanged():
    """With Coriolis a branch keeps its label through a veering, a solution numbers its modes by
    family."""
    found = loci(TIP, "gamma", np.linspace(0, 20, 81), coriolis=True)
    for i in np.flatnonzero((found.values >= 4.65) & (found.values <= 10)):
        assert labels_by_mode(found, i) == dict(enumerate(("B1", "B2", "B3", "S1", "B4")))
    assert solve(TIP.replace(gamma=10), coriolis=True).labels[2:4] == ("S1", "B3")


@pytest.mark.parametrize(
    ("beam", "over", "stop", "options", "branches"),
    [
        (TIP, "gamma", 20, {}, [("B3", "S1"), ("B2", "S1")]),
        (
            TIP.replace(delta=-0.5, gamma=6),
            "mu",
            100,
            {"plane": "flapwise"},
            [("S1", "B2"), ("S2", "B4"), ("S1", "B3")],
        ),
    ],
)
def test_the_lower_branch_of_a_crossing_is_named_first(beam, over, stop, options, branches):
    """The one below the other before the crossing; of states that may bend, whose modes are
    followed by their shapes, as of straight ones."""
    for state in ("straight", "stable"):
        found = loci(
            beam,
            over,
            np.linspace(20, stop, 21) if over == "mu" else [0, stop],
            state=state,
            **options,
        )
        crossings = [event for event in found.events if event.kind == "crossing"]
        assert [event.branches for event in crossings] == branches
        for event in crossings:
            for side in (-1, 1):
                there = solve(beam.replace(**{over: event.at * (1 + 1e-3 * side)}), 6, **options)
                lower, upper = (
                    there.frequencies[there.labels.index(label)] for label in event.branches
                )
                assert np.sign(lower - upper) == side


def labels_by_mode(found, i):
    """The labels of the branches at value i, by the index of the mode."""
    indices = {int(branch.mode_index[i]): branch.label for branch in found.branches}
    return {mode: label for mode, label in indices.items() if mode >= 0}


def test_repr_is_one_line(tip):
    """The range, the branches, and the number of events and limits."""
    assert repr(tip) == (
        "Loci(over gamma = 0 .. 20, 21 values, branches B1 B2 B3 S1 B4,"
        " events: crossing: 2; limits: 0)"
    )
    assert repr(tip["B3"]) == "Branch('B3', at 21 of 21 values)"


def test_results_are_compared_by_identity(tip):
    """Two charts of the same beam are two; comparing them raises nothing."""
    assert tip == tip
    assert tip != loci(TIP, "gamma", tip.values)
    assert tip["B1"] != tip["B2"]
    assert isinstance(tip.events[0], Event)


def test_arrays_are_read_only(tip):
    """Arrays that are cached cannot be changed."""
    branch = tip["B3"]
    arrays = branch.omega_squared, branch.mode_index, branch.frequency, branch.error
    for array in (tip.values, *arrays):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1


@pytest.mark.parametrize("method", ["auto", "ancf", "chebyshev"])
def test_pickling(method):
    """A chart comes back with all its numbers, events and shapes."""
    found = loci(TIP, "gamma", np.linspace(0, 6, 7), modes=4, method=method)
    again = pickle.loads(pickle.dumps(found))
    assert again.events == found.events
    assert again["B3"].frequency == pytest.approx(found["B3"].frequency, rel=1e-15)
    assert again["B3"].solutions[0].shape(2, np.ones(1)) == pytest.approx(
        found["B3"].solutions[0].shape(2, np.ones(1))
    )


def test_the_nearest_line_is_the_one_with_the_least_margin_above_or_below():
    """Modes between two lines, some of them nearer to the lower one, others to the upper one."""
    found = loci(Beam(alpha=1, beta=0.5, gamma=20), "gamma", [0.0, 20.0], modes=5, per_rev=6)
    speed, nearest = 20.0, []
    for margin in found.margins:
        away = [abs(margin.frequency - k * speed) / (k * speed) for k in range(1, 7)]
        assert margin.nearest == 1 + away.index(min(away))
        squares = found[margin.label].omega_squared
        assert margin.southwell == pytest.approx((squares[1] - squares[0]) / speed**2, rel=1e-6)
        nearest.append((margin.nearest, margin.frequency > margin.nearest * speed))
    assert {above for _, above in nearest} == {False, True}
    assert len({line for line, _ in nearest}) > 2
