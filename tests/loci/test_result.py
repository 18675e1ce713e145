"""The result of loci(): branches by label, the branch of each mode, text, pickling."""

import pickle

import numpy as np
import pytest

from beamviz import Beam, InvalidInput, loci, solve
from beamviz.frequency_loci import Event

TIP = Beam(alpha=1, beta=1)


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
