"""The loci chart as data: its range, its lines, its marks; and the texts below it."""

import re
from dataclasses import replace

import numpy as np
import pytest
from charts import TIP, case, chart_of
from hypothesis import given
from hypothesis import strategies as st

from beamviz.beam import MAX_GAMMA_OVER_MU, PARAMETERS, Beam
from beamviz.drawing.modes import SampledModes
from beamviz.explorer.features.loci_chart import (
    FAMILIES,
    PER_REV,
    STYLES,
    Chart,
    ChartRequest,
    Lines,
    chart_lines,
)
from beamviz.explorer.features.loci_tab import (
    event_table,
    gap_notes,
    line_labels,
    modes_here,
    per_rev_labels,
)
from beamviz.exports.html_page import solution_table
from beamviz.frequency_loci.sweep import chart_range
from beamviz.solver import solve


@pytest.fixture(scope="module")
def tip() -> Chart:
    """The loci of TIP over the speed."""
    return chart_of(TIP)


def drawn(chart: Chart, beam: Beam = TIP, *, per_rev: bool = False) -> tuple[np.ndarray, Lines]:
    """Its lines, with a beam on it."""
    return chart_lines(chart, solve(beam), per_rev=per_rev)


def points(x: np.ndarray, line: np.ndarray) -> list[tuple[float, float]]:
    """Where a line is drawn."""
    return [(a, b) for a, b in zip(x.tolist(), line.tolist(), strict=True) if np.isfinite(b)]


# The range of the axis


@given(
    st.fixed_dictionaries({name: st.floats(*PARAMETERS[name].limits) for name in PARAMETERS}),
    st.sampled_from(list(PARAMETERS)),
)
def test_every_beam_lies_on_its_axis_and_both_ends_are_beams(numbers, over):
    """Whatever the five numbers are, and whichever the chart runs over."""
    numbers["gamma"] = min(numbers["gamma"], MAX_GAMMA_OVER_MU * numbers["mu"])
    beam = Beam(**numbers)
    start, stop = chart_range(beam, over)
    assert start <= getattr(beam, over) <= stop
    assert start < stop
    beam.replace(**{over: start})
    beam.replace(**{over: stop})


def test_the_range_stays_during_most_of_a_drag_and_then_doubles():
    """Between rest and 80 % of the axis nothing changes; beyond, it is twice as long."""
    gammas = np.linspace(0, 16, 50)
    assert {chart_range(TIP.replace(gamma=gamma), "gamma") for gamma in gammas} == {(0, 20)}
    assert chart_range(TIP.replace(gamma=16.1), "gamma") == (0, 40)
    assert chart_range(TIP.replace(delta=-0.5), "delta") == (-1, 1)


# The lines


def test_the_lines_are_the_branches_and_have_no_holes(tip):
    """All finite frequencies are drawn, in the colour of their family; each line is in one piece,
    since a page would draw straight across a hole."""
    assert tip.loci
    for family, rows in tip.lines.items():
        for row in rows:
            known = np.flatnonzero(np.isfinite(row))
            assert len(known) == known[-1] - known[0] + 1
        for branch in tip.loci.branches:
            for k, own in enumerate(branch.family):
                if own == family and np.isfinite(branch.frequency[k]):
                    assert any(row[k] == branch.frequency[k] for row in rows)


def test_a_line_that_changes_its_family_has_no_gap():
    """With Coriolis forces S1 becomes mixed: the two colours share a point."""
    chart = chart_of(TIP, coriolis=True)
    ends = {int(np.flatnonzero(np.isfinite(row))[-1]) for row in chart.lines["stretching"]}
    starts = {int(np.flatnonzero(np.isfinite(row))[0]) for row in chart.lines["mixed"]}
    assert ends & starts - {0, len(chart.values) - 1}


def test_all_arrays_are_of_one_length_and_have_a_style(tip):
    """x ascends, also without any loci."""
    for x, lines in (drawn(tip), drawn(tip, per_rev=True), drawn(Chart(tip.request, message="no"))):
        assert (np.diff(x) >= 0).all()
        assert set(lines) <= set(STYLES)
        assert {len(line) for group in lines.values() for line in group} == {len(x)}


def test_between_its_values_a_chart_is_drawn_on_the_line(tip):
    """The x of marks are put in between; the lines there are interpolated, not interrupted."""
    x, lines = drawn(tip, TIP.replace(gamma=3.21))
    k = int(np.searchsorted(x, 3.21))
    first = next(line for line in lines["bending"] if np.isfinite(line[0]))
    assert first[k] == pytest.approx(np.interp(3.21, x[[k - 1, k + 2]], first[[k - 1, k + 2]]))


def test_the_mark_of_the_beam_is_where_its_modes_are(tip):
    """An upright line at its value, and a ring on each branch; none where it is not on the axis."""
    x, lines = drawn(tip, TIP.replace(gamma=3.21))
    assert points(x, lines["beam"][0]) == [(3.21, 0), (3.21, tip.top)]
    rings = [points(x, ring) for ring in lines["modes"]]
    assert rings == [[(3.21, one)] for one in solve(TIP.replace(gamma=3.21)).frequencies]
    assert not {"beam", "modes"} & drawn(tip, TIP.replace(gamma=30))[1].keys()


def test_crossings_and_veerings_are_marked_apart(tip):
    """One kind of mark each, at its place and frequency."""
    for chart, kinds in ((tip, ("crossing", "veering")),
                         (chart_of(TIP, coriolis=True), ("veering", "crossing"))):  # fmt: skip
        x, lines = drawn(chart)
        marked, others = (points(x, lines[kind][0]) for kind in kinds)
        assert marked == [(event.at, event.frequency) for event in chart.events]
        assert others == []


def test_per_rev_lines_are_multiples_of_the_speed():
    """omega = k gamma as far as the picture goes; over any other axis there are none."""
    low = chart_of(TIP, modes=2)
    assert low.top < 100
    x, lines = drawn(low, per_rev=True)
    for k, line in zip(PER_REV, lines["per-rev"], strict=True):
        assert points(x, line) == [(at, k * at) for at in x if k * at <= low.top]
    assert "per-rev" not in drawn(chart_of(TIP, "alpha"), per_rev=True)[1]


def test_the_loci_compared_with_are_drawn_under_the_chart(tip):
    """They are those of the other beam at the same speeds, as far as the picture goes."""
    request = tip.request.same_axis(case(TIP.replace(alpha=2)))
    assert (request.start, request.stop, request.over) == (0, 20, "gamma")
    x, lines = chart_lines(tip, None, per_rev=False, second=request.chart())
    k = int(np.searchsorted(x, 10.0))
    below = [line[k] for family in FAMILIES for line in lines[f"second {family}"]]
    expected = solve(TIP.replace(alpha=2, gamma=10)).frequencies
    assert sorted(one for one in below if np.isfinite(one)) == pytest.approx(
        expected[expected <= tip.top], rel=1e-6
    )


# Labels and texts


def test_the_labels_of_per_rev_lines_never_touch():
    """Flat lines end close to each other: every other one is named. Steep ones all are."""
    flat = per_rev_labels(stop=60.0, top=1600.0)
    assert [label[-9:-7] for label in flat] == ["1γ", "3γ", "5γ"]
    assert len(per_rev_labels(stop=20.0, top=150.0)) == len(PER_REV)


def test_gaps_are_explained_by_their_limit():
    """biot at mu = 10 has no equilibrium beyond 10.76: the lines end there."""
    chart = chart_of(TIP.replace(mu=10), strain="biot")
    assert chart.loci
    (limit,) = chart.loci.limits
    assert f"no equilibrium for γ = {limit.start:.6g}" in gap_notes(chart)
    ends = [chart.values[np.isfinite(row)].max() for row in chart.lines["bending"]]
    assert limit.start - 0.5 < max(ends) <= limit.start


def test_an_incomplete_search_is_told(tip):
    """Below the table of crossings and veerings, and in place of the text that there are none."""
    assert tip.loci
    for events in (tip.loci.events, ()):
        incomplete = replace(tip, loci=replace(tip.loci, complete=False, events=events))
        text = event_table(incomplete, None)
        assert "The search for crossings and veerings stopped" in text
        assert "No crossing or veering" not in text
    assert "stopped" not in event_table(tip, None)
    assert "No crossing or veering" in event_table(chart_of(TIP, modes=1), None)


def test_a_request_out_of_range_is_refused():
    """It names the number; the page goes on with the last chart."""
    with pytest.raises(ValueError, match="alpha = nan"):
        ChartRequest.around(case(TIP).changed("alpha", float("nan")), "gamma")


@pytest.mark.parametrize("gamma", [4.65, 20.0])
def test_a_mode_has_one_name_on_the_page(gamma):
    """At a veering and beyond it: in the table of modes, beside the chart, at the ends of its lines
    and in the scene. S1 is the mode that stretches, and where S1 and B3 are mixed it is told."""
    beam = Beam(alpha=1, beta=1, gamma=gamma)
    solution = solve(beam, coriolis=True)
    chart = replace(ChartRequest.around(case(beam, coriolis=True), "gamma"), stop=gamma).chart()
    table = solution_table(solution, [])
    names = re.findall(r"<b>([BS]\d)</b>", table)
    assert names == ["B1", "B2", "S1", "B3", "B4"]
    assert ("S1/B3 mixed 50:50" in table) == (gamma == 4.65)
    assert re.findall(r">([BS]\d)<", modes_here(chart, solution)) == names
    assert set(names) == set(re.findall(r">([BS]\d)<", line_labels(chart, per_rev=False)))
    assert SampledModes.sampled(solution).labels == tuple(names)
