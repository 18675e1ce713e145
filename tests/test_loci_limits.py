"""Sweeps beyond what exists, is stable, or converges: the gaps, and where they begin and end."""

import numpy as np
import pytest
from sweeps import sorted_frequencies

from beamviz import loci
from beamviz.beam import Beam
from beamviz.errors import NoEquilibrium, NotConverged
from beamviz.mechanics.solve import solve
from beamviz.study import sweep

TIP = Beam(alpha=1, beta=1)


def test_beyond_the_limit_of_equilibrium():
    """physics: hencky, delta 0 ends at gamma 45.420; what exists before it is all there."""
    found = loci(Beam(), "gamma", np.linspace(0, 60, 61), strain="hencky")
    (limit,) = found.limits
    assert (limit.kind, limit.stop) == ("no-equilibrium", 60)
    assert limit.start == pytest.approx(45.420, abs=5e-4)
    assert limit.message == "no equilibrium for gamma = 45.4203 .. 60"
    exists = np.isfinite(sorted_frequencies(found)[:, :5]).all(axis=1)
    assert exists.tolist() == [value < limit.start for value in found.values]
    assert all(branch.family[-1] is None for branch in found.branches)
    assert np.isnan(found.confidence[45:]).all()
    assert (found.confidence[:45] > 0.9).all()


@pytest.mark.parametrize(
    ("beam", "over", "values"),
    [
        (Beam(gamma=30), "delta", np.linspace(0, 2, 11)),
        (Beam(gamma=40, beta=0.9), "alpha", np.linspace(0, 1, 11)),
        (Beam(gamma=40), "mu", np.linspace(40, 80, 11)),
    ],
)
def test_limits_over_other_numbers(beam, over, values):
    """The end of existence is found between two values: on one side of it there is one."""
    (limit,) = loci(beam, over, values, strain="hencky").limits
    edge = limit.stop if limit.start == values[0] else limit.start
    sides = [beam.replace(**{over: edge * (1 + step)}) for step in (-1e-7, 1e-7)]
    there = []
    for side in sides:
        try:
            solve(side, strain="hencky")
            there.append(True)
        except NotConverged:  # so close to the end that numbers fail, physics does not
            there.append(True)
        except NoEquilibrium:
            there.append(False)
    assert sorted(there) == [False, True]


def test_a_limit_at_zero_is_found_in_a_few_solves(monkeypatch):
    """A heavy mass ends the equilibrium wherever it is, but at the clamp itself it is held: the
    change is at beta = 0, where nothing is exact relative to it."""
    solve_many, solved = sweep.solve_many, []

    def counted(beams, **options):
        solved.extend(beams)
        assert len(solved) < 60
        return solve_many(beams, **options)

    monkeypatch.setattr(sweep, "solve_many", counted)
    heavy = Beam(alpha=3.9, gamma=37, delta=2.7, mu=115)
    found = loci(heavy, "beta", np.linspace(0, 1, 5), 1, strain="hencky")
    (limit,) = found.limits
    assert (limit.kind, limit.stop) == ("no-equilibrium", 1.0)
    assert 0 <= limit.start < 1e-11


def test_loss_of_stability():
    """physics: an inward beam, delta -1, buckles near gamma 2.97; the branch goes on, growing."""
    found = loci(Beam(delta=-1), "gamma", np.linspace(0, 6, 61))
    (limit,) = found.limits
    assert (limit.kind, limit.stop) == ("unstable", 6)
    assert limit.start == pytest.approx(2.97, abs=0.03)
    below, above = (solve(Beam(delta=-1, gamma=limit.start * x)) for x in (1 - 1e-7, 1 + 1e-7))
    assert (below.equilibrium.status, above.equilibrium.status) == ("stable", "unstable")
    first = found.branches[0]
    unstable = found.values > limit.start
    assert np.isnan(first.frequency[unstable]).all()
    assert (first.growth_rate[unstable] > 0).all()
    assert (first.growth_rate[~unstable] == 0).all()
    assert first.family[-1] == "bending"


def test_modes_are_followed_through_buckling_with_coriolis():
    """They turn into growing ones without a jump, whichever number is varied."""
    found = loci(Beam(delta=-1), "gamma", np.linspace(0, 6, 61), coriolis=True)
    assert found.limits[0].start == pytest.approx(2.996, abs=1e-3)
    assert found.confidence.min() > 0.999
    found = loci(
        Beam(alpha=1, beta=0.6, gamma=20), "delta", np.linspace(-1.5, 1, 61), coriolis=True
    )
    assert found.confidence.min() > 0.9
    assert found.solves < 130


def test_a_state_between_two_others_is_named():
    """Stable at rest, not resolved at gamma 50: in between the beam buckles, and is solved."""
    found = loci(Beam(alpha=100, beta=0.2, delta=-2, mu=10000), "gamma", [0, 50, 100], 1)
    unstable, unresolved = found.limits
    assert [unstable.kind, unresolved.kind] == ["unstable", "not-converged"]
    assert unstable.start == pytest.approx(0.55, abs=1e-3)
    assert 20 < unstable.stop == unresolved.start < 30
    assert unresolved.stop == 100


def test_a_gap_in_the_middle(monkeypatch):
    """Branches go on behind values that did not converge, and these are named."""
    solve_many = sweep.solve_many

    def failing(beams, **options):
        answers = solve_many(beams, **options)
        return [
            NotConverged("no") if 4.9 < beam.gamma < 7.1 else answer
            for beam, answer in zip(beams, answers, strict=True)
        ]

    monkeypatch.setattr(sweep, "solve_many", failing)
    found = loci(TIP, "gamma", np.linspace(0, 10, 21))
    assert [branch.label for branch in found.branches] == ["B1", "B2", "B3", "S1", "B4"]
    (limit,) = found.limits
    assert limit.kind == "not-converged"
    assert (limit.start, limit.stop) == pytest.approx((4.9, 7.1), abs=1e-6)
    assert [event.branches for event in found.events] == [("B3", "S1")]


def test_one_value_between_gaps(monkeypatch):
    """A single value with a solution is still returned."""
    solve_many = sweep.solve_many

    def failing(beams, **options):
        answers = solve_many(beams, **options)
        pairs = zip(beams, answers, strict=True)
        return [
            answer if abs(beam.gamma - 5) < 0.1 else NotConverged("no") for beam, answer in pairs
        ]

    monkeypatch.setattr(sweep, "solve_many", failing)
    found = loci(TIP, "gamma", np.linspace(0, 10, 11))
    assert np.isfinite(sorted_frequencies(found)).sum() == 5
    assert len(found.limits) == 2


def test_nowhere_an_equilibrium():
    """The error of the first value, with the limit."""
    with pytest.raises(NoEquilibrium) as caught:
        loci(Beam(), "gamma", [100, 110], strain="hencky")
    assert caught.value.limit == pytest.approx(45.42, abs=0.01)
