"""Two loci magnified around their crossing or veering, without and with Coriolis forces."""

from dataclasses import replace

import numpy as np
import pytest
from charts import TIP, chart_of

from beamviz.drawing.modes import SampledModes
from beamviz.explorer.features.veering import (
    LociPair,
    VeeringRequest,
    mode_shape,
    pairs_data,
    sentence,
    shape_table,
)
from beamviz.solver import solve

CHART = chart_of(TIP)


@pytest.fixture(scope="module")
def pairs() -> tuple[LociPair, LociPair]:
    """The crossing of S1 and B3, and their veering with Coriolis forces."""
    return request(0).pairs()


def request(number: int) -> VeeringRequest:
    """The request for an event of the chart."""
    return VeeringRequest(CHART.request, list(CHART.events.values())[number])


def test_a_crossing_becomes_a_veering_with_coriolis_forces(pairs):
    """Without: gap 0 at 4.4641, modes keep their shapes; with: gap 0.241 at 4.650, they exchange
    them."""
    off, on = pairs
    assert (off.kind, on.kind) == ("crossing", "veering")
    assert off.at == pytest.approx(4.4641, abs=1e-4)
    assert on.at == pytest.approx(4.650, abs=1e-3)
    assert on.event.gap == pytest.approx(0.241, abs=1e-3)
    for shapes in off.shapes:
        assert len({round(shape.bending_fraction, 6) for shape in shapes}) == 1
    for before, at, after in on.shapes:
        assert abs(after.bending_fraction - before.bending_fraction) > 0.8
        assert at.bending_fraction == pytest.approx(0.5, abs=0.05)
    measures = request(0).chart.measures
    assert "at γ 4.650 (gap 0.241)" in sentence(on, *measures)
    assert "exchange their shapes" in sentence(on, *measures)
    assert "uncoupled (gap 0)" in sentence(off, *measures)
    assert "S1/B3 mixed 50:50" in shape_table(on, "")
    assert "mixed" not in shape_table(off, "")


def test_both_events_and_all_of_the_gap_are_in_view(pairs):
    """At the ends of the view the distance of the loci is more than twice the gap; the view is a
    small part of the chart."""
    for pair in pairs:
        assert pair.found.values[0] < pair.at < pair.found.values[-1]
        assert np.ptp(pair.found.values) < 0.2 * (request(0).chart.stop - request(0).chart.start)
    a, b = pairs[1].branches
    assert abs(b.frequency - a.frequency)[[0, -1]].min() > 2 * pairs[1].event.gap


def test_shapes_keep_their_signs_across_the_view(pairs):
    """Shapes at the ends correlate with that at the event; at a crossing, where shapes are not
    unique, this is taken beside it."""
    for pair in pairs:
        for first, middle, last in pair.shapes:
            for end in (first, last):
                assert (end.displacement * middle.displacement).sum() >= 0
    assert pairs[0].at not in pairs[0].found.values


def test_a_branch_has_no_shape_where_it_is_not_solved():
    """Above the modes solved for."""
    branch = replace(CHART.loci.branches[0], mode_index=np.full(len(CHART.loci.values), -1))
    assert np.isnan(mode_shape(branch, 0).displacement).all()


def test_loci_that_stay_far_apart_are_no_veering():
    """S1 and B2 cross at 16.32; with Coriolis forces their gap is large."""
    pairs = request(1).pairs()
    assert (pairs[0].kind, pairs[1].event) == ("crossing", None)
    assert "the gap is too large for a veering" in sentence(pairs[1], *request(1).chart.measures)
    lines = pairs_data(pairs, request(1).chart)["lines"]
    assert not [line for line in lines if line["runs"][0][2] == "measure"]


def test_the_chart_shows_both_cases_the_gap_and_the_crossing(pairs):
    """Dashed without Coriolis forces; the gap as a vertical line of its length; the crossing."""
    data = pairs_data(pairs, request(0).chart)
    styles = [{run[2].split()[-1] for run in line["runs"]} for line in data["lines"]]
    assert styles == [{"dashed"}, {"dashed"}, {"thick"}, {"thick"}, {"measure"}]
    assert abs(np.diff(data["lines"][-1]["y"])[0]) == pytest.approx(0.241, abs=1e-3)
    (crossing,) = data["marks"]
    assert crossing["x"] == pytest.approx(4.4641, abs=1e-4)
    assert len(data["at"]) == len(data["lines"][0]["y"])


def test_nodes_are_marked_in_the_middle_of_a_veering():
    """There the axial displacement of the tip is larger, out of phase with the bending that has
    nodes."""
    solution = solve(TIP.replace(gamma=4.65), coriolis=True)
    for k in (2, 3):
        marked = SampledModes.sampled(solution).nodes[k]
        assert marked == pytest.approx(solution.nodes[k], abs=2e-5)
        assert len(marked) == 2
