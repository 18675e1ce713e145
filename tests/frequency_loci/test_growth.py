"""Where vibrations grow: growth rates, coalescence of two frequencies, and the range in which a
vibration grows, of beams that spin up."""

import csv
import io
import json

import numpy as np
import pytest
from helpers import KNOWN_KINDS
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.text import Text
from oracle.bent import bent_truth

from beamviz import Beam, loci, solve
from beamviz.errors import NotConverged
from beamviz.frequency_loci import path
from beamviz.output.loci import loci_csv, loci_json, loci_table
from beamviz.plotting.loci import draw_chart

SLENDER = Beam(mu=10_000)
STABLE = {"state": "stable"}


@pytest.fixture(scope="module")
def spin_up():
    """Over the spin-up of a beam that does not turn yet: B1 and B2 merge between 84 and 86."""
    return loci(SLENDER, "spin_up", np.linspace(0, 200, 5), kinds=KNOWN_KINDS, **STABLE)


def test_growth_rates_along_the_spin_up(spin_up):
    """B1 grows as much as B2 decays, and both have one frequency; before that neither does."""
    first, second = spin_up["B1"], spin_up["B2"]
    assert first.growth_rate[[0, 1, 2, 4]] == pytest.approx([0, 0, 2.1203, 5.7037], abs=5e-5)
    assert second.growth_rate == pytest.approx(-first.growth_rate, abs=1e-6)
    assert first.frequency[2:] == pytest.approx(second.frequency[2:], rel=1e-6)
    assert spin_up.values[2] == 100
    truth = bent_truth_of(solve(SLENDER.replace(spin_up=100), **STABLE))
    assert abs(truth.omega[:2].imag).max() == pytest.approx(2.1203175, abs=1e-6)


def test_coalescence_is_an_event(spin_up):
    """It is named, with the range in which a vibration grows. Before it by a millionth the two
    frequencies differ, as the root of the distance; after it one of them grows."""
    (event,) = spin_up.events
    assert (event.kind, event.branches) == ("coalescence", ("B1", "B2"))
    assert 84 < event.at < 86
    (limit,) = spin_up.limits
    assert (limit.kind, limit.stop) == ("growing", 200)
    assert limit.start == event.at
    assert limit.message.startswith("flutter for spin_up = 85.67")
    before, after = (
        solve(SLENDER.replace(spin_up=event.at * factor), 2, **STABLE)
        for factor in (1 - 1e-6, 1 + 1e-6)
    )
    assert (before.equilibrium.status, after.equilibrium.status) == ("stable", "growing")
    assert np.diff(before.frequencies) > 1e-3
    assert after.growth_rates[0] > 1e-3


def bent_truth_of(solution):
    """The modes of the differential equations about the state of a solution."""
    state, problem = solution.equilibrium, solution.problem
    model = problem.strain, problem.curvature, problem.coriolis, problem.modes
    return bent_truth(
        solution.beam, *model, lambda x: (state.position(x), state.angle(x), state.stretch(x))
    )


@pytest.mark.slow
@settings(max_examples=1)
@given(st.floats(0, 1), st.floats(0.3, 1), st.floats(0.01, 2))
def test_coalescences_of_random_beams(alpha, beta, gamma):
    """By the differential equations no vibration grows just before a coalescence, and one grows
    just after it."""
    beam = Beam(alpha=alpha, beta=beta, gamma=gamma, mu=1000)
    found = loci(beam, "spin_up", [0.0, 150.0], modes=2, **STABLE)
    for event in (event for event in found.events if event.kind == "coalescence"):
        growth = []
        for factor in (1 - 1e-3, 1 + 1e-3):
            there = solve(beam.replace(spin_up=event.at * factor), modes=2, **STABLE)
            growth.append(float(abs(bent_truth_of(there).omega[:2].imag).max()))
        assert growth[0] < 1e-6 * event.frequency
        assert growth[1] > 1e-3 * event.frequency


def test_files_tell_growth(spin_up):
    """JSON, CSV, table and chart."""
    data = json.loads(loci_json(spin_up))
    first, second = (branch["growth_rate"] for branch in data["branches"][:2])
    assert first[2] == -second[2] == pytest.approx(2.1203, abs=5e-5)
    assert "coalescence" in {event["kind"] for event in data["events"]}
    assert data["limits"][0]["kind"] == "growing"
    rows = list(csv.DictReader(io.StringIO(loci_csv(spin_up))))
    assert float(rows[2]["B1_growth_rate"]) == pytest.approx(2.1203, abs=5e-5)
    table = loci_table(spin_up)
    assert "+5.7037" in table
    assert "coalescence" in table
    assert "flutter for spin_up" in table
    words = " ".join(text.get_text() for text in draw_chart(spin_up, ()).findobj(match=Text))
    assert "B1 +5.7" in words


def test_an_event_of_a_shown_locus_is_shown():
    """Three modes over the speed with Coriolis forces: B3 veers with S1, which is the fourth."""
    found = loci(Beam(1, 0.5), "gamma", np.linspace(0, 20, 5), modes=3, coriolis=True)
    assert [branch.label for branch in found.branches] == ["B1", "B2", "B3"]
    (event,) = found.events
    assert (event.kind, event.branches) == ("veering", ("B3", "S1"))
    assert (event.at, event.gap) == pytest.approx((10.5999, 0.644), abs=5e-4)


@pytest.mark.slow
def test_a_coalescence_beside_states_that_are_not_found_is_told_with_its_range(monkeypatch):
    """Solves fail around it, between two values of the chart."""
    solve_many = path.solve_many

    def failing(beams, **options):
        pairs = zip(beams, solve_many(beams, **options), strict=True)
        return [
            NotConverged("no") if abs(beam.spin_up - 85.67) < 0.01 else answer
            for beam, answer in pairs
        ]

    monkeypatch.setattr(path, "solve_many", failing)
    found = loci(SLENDER, "spin_up", [84.0, 87.0], modes=2, **STABLE)
    assert not found.events
    (limit,) = [limit for limit in found.limits if limit.kind == "not-located"]
    assert limit.start < 85.67 < limit.stop
