"""The loci chart as data: its range, its lines, its marks; and the texts below it."""

from dataclasses import replace

import numpy as np
import pytest
from charts import TIP, case, chart_of
from hypothesis import given
from hypothesis import strategies as st

from beamviz.beam import MAX_GAMMA_OVER_MU, PARAMETERS, Beam
from beamviz.explorer.features.loci_chart import (
    FAMILIES,
    PER_REV,
    Chart,
    ChartRequest,
    enough_lanes,
    series,
    styles,
)
from beamviz.explorer.features.loci_tab import LANES, event_table, gap_notes, per_rev_labels
from beamviz.frequency_loci.sweep import chart_range
from beamviz.scene import MODES
from beamviz.solver import solve

LINES = len(FAMILIES) * LANES


@pytest.fixture(scope="module")
def tip() -> Chart:
    """The loci of TIP over the speed."""
    return chart_of(TIP)


def drawn(chart: Chart, beam: Beam = TIP, *, per_rev: bool = False) -> tuple[np.ndarray, ...]:
    """Its arrays, with a beam on it."""
    return series(chart, solve(beam), LANES, per_rev=per_rev)


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
    for family, rows in tip.lanes.items():
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
    ends = {int(np.flatnonzero(np.isfinite(row))[-1]) for row in chart.lanes["stretching"]}
    starts = {int(np.flatnonzero(np.isfinite(row))[0]) for row in chart.lanes["mixed"]}
    assert ends & starts - {0, len(chart.values) - 1}


def test_all_arrays_are_of_one_length_and_one_for_each_style(tip):
    """x ascends; there is an array for each line the page knows; so it is without any loci."""
    for arrays in (drawn(tip), drawn(tip, per_rev=True), drawn(Chart(tip.request, message="none"))):
        assert len(arrays) == len(styles(LANES))
        assert {len(array) for array in arrays} == {len(arrays[0])}
        assert (np.diff(arrays[0]) >= 0).all()


def test_between_its_values_a_chart_is_drawn_on_the_line(tip):
    """The x of marks are put in between; the lines there are interpolated, not interrupted."""
    x, *lines = drawn(tip, TIP.replace(gamma=3.21))
    k = int(np.searchsorted(x, 3.21))
    first = next(line for line in lines[:LINES] if np.isfinite(line[0]))
    assert first[k] == pytest.approx(np.interp(3.21, x[[k - 1, k + 2]], first[[k - 1, k + 2]]))


def test_the_number_of_lanes_is_doubled_until_it_suffices(tip):
    """And never shrinks."""
    assert enough_lanes(4, {family: [np.zeros(2)] * 9 for family in FAMILIES}) == 16
    assert enough_lanes(16, {family: [] for family in FAMILIES}) == 16
    assert len(series(tip, None, 32, per_rev=False)) == len(styles(32))


def test_the_mark_of_the_beam_is_where_its_modes_are(tip):
    """An upright line at its value, and a ring on each branch; none where it is not on the axis."""
    x, *lines = drawn(tip, TIP.replace(gamma=3.21))
    upright, *rings = lines[LINES + len(PER_REV) :][: 1 + MODES]
    assert x[np.isfinite(upright)].tolist() == [3.21, 3.21]
    assert upright[np.isfinite(upright)].tolist() == [0, tip.top]
    for ring, frequency in zip(rings, solve(TIP.replace(gamma=3.21)).frequencies, strict=True):
        assert ring[np.isfinite(ring)].tolist() == [frequency]
        assert x[np.isfinite(ring)].tolist() == [3.21]
    _, *elsewhere = drawn(tip, TIP.replace(gamma=30))
    assert not any(np.isfinite(line).any() for line in elsewhere[LINES:-2])


def test_crossings_and_veerings_are_marked_apart(tip):
    """One kind of mark each, at its place and frequency."""
    for chart, kind, other in ((tip, -2, -1), (chart_of(TIP, coriolis=True), -1, -2)):
        arrays = drawn(chart)
        marked = np.isfinite(arrays[kind])
        assert arrays[0][marked].tolist() == [event.at for event in chart.events]
        assert arrays[kind][marked].tolist() == [event.frequency for event in chart.events]
        assert not np.isfinite(arrays[other]).any()


def test_per_rev_lines_are_multiples_of_the_speed():
    """omega = k gamma as far as the picture goes; over any other axis there are none."""
    low = chart_of(TIP, modes=2)
    assert low.top < 100
    x, *lines = drawn(low, per_rev=True)
    for k, line in zip(PER_REV, lines[LINES:], strict=False):
        known = np.isfinite(line)
        assert line[known].tolist() == (k * x[known]).tolist()
        assert known.tolist() == (k * x <= low.top).tolist()
    over_alpha = drawn(chart_of(TIP, "alpha"), per_rev=True)
    assert not np.isfinite(np.array(over_alpha[1 + LINES :][: len(PER_REV)])).any()


def test_the_loci_compared_with_are_drawn_under_the_chart(tip):
    """They are those of the other beam at the same speeds, as far as the picture goes."""
    request = tip.request.same_axis(case(TIP.replace(alpha=2)))
    assert (request.start, request.stop, request.over) == (0, 20, "gamma")
    count = 4
    x, *lines = series(tip, None, LANES, per_rev=False, second=request.chart(), second_count=count)
    assert 1 + len(lines) == len(styles(LANES, count))
    k = int(np.searchsorted(x, 10.0))
    values = sorted(float(line[k]) for line in lines[-2 - 3 * count : -2] if np.isfinite(line[k]))
    expected = solve(TIP.replace(alpha=2, gamma=10)).frequencies
    assert values == pytest.approx(expected[expected <= tip.top], rel=1e-6)


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
    ends = [chart.values[np.isfinite(row)].max() for row in chart.lanes["bending"]]
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
