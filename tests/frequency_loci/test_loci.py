"""loci(): branches and their labels, crossings and veerings of random beams, wrong input, and the
result: branches by label, the branch of each mode, text, pickling."""

import math
import pickle
import re
from itertools import combinations

import numpy as np
import pytest
from helpers import slow, sorted_frequencies

from beamviz import Beam, InvalidInput, loci, solve, solve_many
from beamviz.beam import PARAMETERS
from beamviz.frequency_loci import Event, close_up, sweep
from beamviz.frequency_loci.crossings import CLOSE, ROTATED

TIP = Beam(alpha=1, beta=1)
FEW_TERMS = "modes = 5: at most 3 with terms = 3; ask for more"


@pytest.mark.parametrize("coriolis", [False, True])
@pytest.mark.parametrize(
    ("beam", "over", "stop"),
    [(TIP, "gamma", 40), (Beam(gamma=8), "alpha", 3), (Beam(alpha=2, gamma=5), "beta", 1)],
)
def test_branches_are_the_lowest_modes(beam, over, stop, coriolis):
    """At every value the branches together are exactly the modes of solve()."""
    values = np.linspace(0, stop, 15)
    found = loci(beam, over, values, modes=6, coriolis=coriolis)
    rows = sorted_frequencies(found)
    for value, row in zip(values, rows, strict=True):
        exact = solve(beam.replace(**{over: value}), modes=6, coriolis=coriolis).frequencies
        assert row[:6] == pytest.approx(exact, rel=2e-6)
        assert np.isnan(row[6:]).all()


def test_labels_without_coriolis():
    """Families are uncoupled: a branch has the label of its modes at every value."""
    found = loci(Beam(alpha=20, gamma=5), "beta", np.linspace(0, 1, 81), modes=8)
    for branch in found.branches:
        for solution, place in zip(branch.solutions, branch.mode_index, strict=True):
            assert place < 0 or solution.labels[place] == branch.label


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
    (Manconi & Mace 2017); at rest there is none. However narrow, a veering is not a crossing; at
    its width from the least gap, on either side, the gap is sqrt(2) times the least."""
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
    for alpha in (veering.at - veering.width, veering.at + veering.width):
        beside = solve(Beam(alpha=alpha, gamma=gamma), coriolis=True, tolerance=1e-10)
        assert np.diff(beside.frequencies).min() == pytest.approx(2**0.5 * veering.gap, rel=0.01)


@pytest.mark.parametrize("coriolis", [False, True])
@pytest.mark.parametrize(
    ("beam", "over", "stop"), [(TIP, "gamma", 20), (Beam(gamma=10), "alpha", 2)]
)
def test_events_do_not_depend_on_the_points(beam, over, stop, coriolis):
    """With two points or many, in as many solves: the same crossings and veerings."""
    charts = [
        loci(beam, over, np.linspace(0, stop, count), modes=6, coriolis=coriolis)
        for count in (2, 7, 201)
    ]
    few, *others = charts
    assert few.events
    assert max(chart.solves for chart in charts) < 75
    for other in others:
        for a, b in zip(few.events, other.events, strict=True):
            assert (a.kind, a.branches) == (b.kind, b.branches)
            assert (a.at, a.gap, a.index) == pytest.approx((b.at, b.gap, b.index), rel=1e-6)


def random_beam(chance):
    """A beam, what to sweep and from where to where."""
    over = chance.choice(list(PARAMETERS))
    beam = Beam(
        alpha=1 + chance.random()
        if over == "beta"
        else chance.choice([0, 10 ** chance.uniform(-1, 1.5)]),
        beta=chance.choice([1.0, chance.uniform(0.1, 1)]),
        gamma=chance.uniform(0, 40),
        delta=chance.choice([0, chance.uniform(0, 2)]),
        mu=10 ** chance.uniform(1.6, 2.5),
    )
    ranges = {
        "alpha": (0, 4),
        "beta": (0.05, 1),
        "gamma": (0, 50),
        "delta": (0, 2),
        "mu": (30, 250),
    }
    return beam, str(over), *ranges[over]


def truth(beam, over, values, modes):
    """The changes of the order of labels on a dense grid: no tracking, no shapes."""
    solutions = solve_many([beam.replace(**{over: value}) for value in values], modes=modes)
    orders = [{label: k for k, label in enumerate(one.labels)} for one in solutions]
    return [
        ({one, other}, value)
        for value, now, then in zip(values, orders, orders[1:], strict=False)
        for one, other in combinations(sorted({*now, *then}), 2)
        if np.prod([order.get(one, modes) - order.get(other, modes) for order in (now, then)]) < 0
    ]


@pytest.mark.parametrize("seed", range(12))
def test_crossings_of_random_beams(seed):
    """On a coarse grid: the crossings of a dense one, each within its step of that."""
    beam, over, low, high = random_beam(np.random.default_rng(seed))
    dense = np.linspace(low, high, 601)
    expected = truth(beam, over, dense, 5)
    found = [e for e in loci(beam, over, np.linspace(low, high, 31)).events if e.kind == "crossing"]
    assert [set(event.branches) for event in found] == [pair for pair, _ in expected]
    for event, (_, at) in zip(found, expected, strict=True):
        assert at - 1e-6 <= event.at <= at + (high - low) / 600 + 1e-6
        (two,) = {tuple(sorted(event.branches))}
        solution = solve(beam.replace(**{over: event.at}), modes=6, tolerance=1e-9)
        f = [solution.frequencies[solution.labels.index(label)] for label in two]
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


@pytest.mark.parametrize("seed", [2, 3, *slow(0, 1, 4, 5, 6, 7)])
def test_veerings_of_random_beams(seed):
    """With Coriolis, on a dense grid: a veering is where the gap of two neighbours has a small
    minimum and the shapes are exchanged between the greatest gaps before and after; there is none
    where they are clearly not exchanged."""
    beam, over, low, high = random_beam(np.random.default_rng(100 + seed))
    dense = np.linspace(low, high, 801)
    solutions = [solve(beam.replace(**{over: x}), modes=5, coriolis=True) for x in dense]
    f = np.array([solution.frequencies for solution in solutions])
    found = [e.at for e in loci(beam, over, np.linspace(low, high, 41), coriolis=True).events]
    for k in range(4):
        gap = f[:, k + 1] - f[:, k]
        for i in np.flatnonzero((gap[1:-1] < gap[:-2]) & (gap[1:-1] < gap[2:])) + 1:
            start, stop = i, i
            while start > 0 and gap[start - 1] >= gap[start]:
                start -= 1
            while stop < 800 and gap[stop + 1] >= gap[stop]:
                stop += 1
            share = exchanged(solutions[start], solutions[stop], k, 5)
            near = [at for at in found if dense[i - 1] <= at <= dense[i + 1]]
            if share > 0.6 and gap[i] < 0.8 * CLOSE * f[i, k]:
                assert near, (k, dense[i], share)
            if share < 0.5 * math.sin(ROTATED) ** 2 or gap[i] > 1.2 * CLOSE * f[i, k + 1]:
                assert not near, (k, dense[i], share)


def test_solutions_are_solved_for_when_asked(monkeypatch):
    """A chart takes fewer solves than values; then a solution takes one, and all are one batch."""
    solve_many, batches = sweep.solve_many, []

    def watched(beams, **options):
        batches.append(len(beams))
        return solve_many(beams, **options)

    monkeypatch.setattr(sweep, "solve_many", watched)
    values = np.linspace(0, 20, 201)
    found = loci(TIP, "gamma", values)
    assert sum(batches) == found.solves < 40
    batches.clear()
    branch = found["S1"]
    solution = branch.solutions[7]
    exact = solution.frequencies[branch.mode_index[7]]
    assert exact == pytest.approx(branch.frequency[7], rel=1e-6)
    assert solution is found["B1"].solutions[7]
    assert len(list(branch.solutions)) == 201
    assert batches == [1, 200]


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
        (TIP, "gamma", [0, math.nan, 1], {}, "gamma = nan: must lie in 0 .. 200"),
        (TIP, "gamma", [0, 201], {}, "gamma = 201: must lie in 0 .. 200"),
        (TIP, "gamma", ["fast", "slow"], {}, "must be numbers"),
        (TIP, "alpha", 10**400, {}, "must be numbers"),
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


@pytest.mark.parametrize(
    ("modes", "options"),
    [
        (1, {}),
        (20, {}),
        *((2, {"method": "ancf", "elements": count}) for count in (1, 2, 20)),
        (3, {"method": "assumed-modes", "terms": 3}),
    ],
)
def test_as_few_and_as_many_modes_as_there_can_be(modes, options):
    """At the most modes, or with as few elements or terms as modes, no extra ones are solved."""
    found = sorted_frequencies(loci(TIP, "gamma", np.linspace(0, 10, 11), modes=modes, **options))
    assert np.isfinite(found).sum(axis=1).tolist() == [modes] * 11
    assert found[0, :modes] == pytest.approx(solve(TIP, modes, **options).frequencies)


def test_flapwise():
    """Coriolis forces do not act out of the plane of rotation: the families cross."""
    events = loci(TIP, "gamma", np.linspace(0, 10, 41), plane="flapwise", coriolis=True).events
    assert {event.kind for event in events} == {"crossing"}


def test_close_up_of_a_veering():
    """Around its least gap, within four widths, with the same labels."""
    found = loci(TIP, "gamma", np.linspace(0, 10, 51), coriolis=True)
    (event,) = found.events
    near = close_up(found, event)
    assert near.events == (event,)
    assert near.values[[0, -1]] == pytest.approx(
        [event.at - 4 * event.width, event.at + 4 * event.width]
    )
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
    return loci(TIP, "gamma", np.linspace(0, 20, 21))


def test_a_branch_by_its_label(tip):
    """The frequencies of that mode; the error for an unknown label lists the labels."""
    assert tip["S1"].frequency[0] == pytest.approx(60.22335, abs=1e-5)
    assert tip["S1"] is tip.branches[3]
    with pytest.raises(KeyError, match="no branch 'B9'; branches: B1, B2, B3, S1, B4"):
        tip["B9"]


@pytest.mark.parametrize("modes", [3, 5])
def test_labels_at_any_value(modes):
    """Without Coriolis they are those of a solution there: bending and stretching, counted; at a
    value of the sweep they are the inverse of mode_index, also where a branch leaves the modes."""
    found = loci(TIP, "gamma", np.linspace(0, 20, 21), modes)
    for value in (0, 3.3, 4.4, 4.464, 4.465, 5, 16.3, 16.33, 17.5, 20):
        assert found.labels_at(value) == solve(TIP.replace(gamma=value), modes).labels
    for i, value in enumerate(found.values):
        indices = {branch.label: branch.mode_index[i] for branch in found.branches}
        here = {label: k for label, k in indices.items() if k >= 0}
        assert here == {label: k for k, label in enumerate(found.labels_at(value))}


def test_labels_at_a_value_where_shapes_are_exchanged():
    """With Coriolis a branch keeps its label through a veering, a solution numbers its modes by
    family: at gamma 4.65 the labels are those of the branches, each once."""
    found = loci(TIP, "gamma", np.linspace(0, 20, 81), coriolis=True)
    for value in (4.65, 4.7, 10.0):
        assert found.labels_at(value) == ("B1", "B2", "B3", "S1", "B4")
    assert solve(TIP.replace(gamma=10), coriolis=True).labels[2:4] == ("S1", "B3")


def test_labels_outside_and_without_a_solution(tip):
    """The range is named; beyond the last equilibrium, at 45.42, there are none."""
    with pytest.raises(InvalidInput, match=r"gamma = 21: must lie in 0 \.\. 20"):
        tip.labels_at(21)
    found = loci(Beam(), "gamma", [40, 50, 60], strain="hencky")
    assert [len(found.labels_at(value)) for value in (40, 45.4, 45.5, 55)] == [5, 5, 0, 0]


def test_repr_is_one_line(tip):
    """The range, the branches, and the number of events and limits."""
    assert repr(tip) == (
        "Loci(over gamma = 0 .. 20, 21 values, branches B1 B2 B3 S1 B4,"
        " crossings: 2, veerings: 0, limits: 0)"
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
