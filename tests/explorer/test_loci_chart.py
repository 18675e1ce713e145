"""The loci chart of the explorer: its range, its lines, its marks."""

import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from beamviz.explorer.request import MODES
from charts import TIP, charted
from hypothesis import given
from hypothesis import strategies as st

from beamviz.beam import MAX_GAMMA_OVER_MU, PARAMETERS, Beam
from beamviz.explorer.features import loci_tab as chart_tab
from beamviz.explorer.features import loci_tab as chart_words
from beamviz.explorer.features.loci_chart import (
    FAMILIES,
    LANES,
    PER_REV,
    SPANS,
    Chart,
    Point,
    roomy,
    series,
    span,
    top,
)
from beamviz.explorer.jobs import Latest
from beamviz.solver import solve

LINES = len(FAMILIES) * LANES


@pytest.fixture(scope="module")
def tip() -> Chart:
    """The loci of TIP over the speed."""
    return charted(TIP)


def drawn(chart: Chart, beam: Beam = TIP, *, per_rev: bool = False) -> tuple[np.ndarray, ...]:
    """Its arrays, with a beam on it."""
    return series(chart, Point.of(solve(beam), chart.question.over), LANES, per_rev=per_rev)


# The range of the axis


@given(
    st.fixed_dictionaries(
        {name: st.floats(*PARAMETERS[name].limits) for name in PARAMETERS},
    ),
    st.sampled_from(list(SPANS)),
)
def test_every_beam_lies_on_its_axis_and_both_ends_are_beams(numbers, over):
    """Whatever the five numbers are, and whichever the chart runs over."""
    numbers["gamma"] = min(numbers["gamma"], MAX_GAMMA_OVER_MU * numbers["mu"])
    beam = Beam(**numbers)
    start, stop = span(beam, over)
    assert start <= getattr(beam, over) <= stop
    assert start < stop
    beam.replace(**{over: start})
    beam.replace(**{over: stop})


def test_the_range_stays_during_most_of_a_drag_and_then_doubles():
    """Between rest and 80 % of the axis nothing changes; beyond, there is twice the room."""
    assert {span(TIP.replace(gamma=gamma), "gamma") for gamma in np.linspace(0, 16, 50)} == {
        (0, 20)
    }
    assert span(TIP.replace(gamma=16.1), "gamma") == (0, 40)
    assert span(TIP.replace(delta=-0.5), "delta") == (-1, 1)


# The lines


def test_the_lines_are_the_branches_and_have_no_holes(tip):
    """All finite frequencies are drawn, in the colour of their family; each line is in one piece,
    since a page would draw straight across a hole."""
    assert tip.loci
    for family, rows in tip.rows.items():
        for row in rows:
            seen = np.flatnonzero(np.isfinite(row))
            assert len(seen) == seen[-1] - seen[0] + 1
        for branch in tip.loci.branches:
            for k, own in enumerate(branch.family):
                if own == family and np.isfinite(branch.frequency[k]):
                    assert any(row[k] == branch.frequency[k] for row in rows)


def test_a_line_that_changes_its_family_has_no_gap():
    """With Coriolis forces S1 becomes mixed: the two colours share a point."""
    chart = charted(TIP, coriolis=True)
    assert chart.loci
    ends = {int(np.flatnonzero(np.isfinite(row))[-1]) for row in chart.rows["stretching"]}
    starts = {int(np.flatnonzero(np.isfinite(row))[0]) for row in chart.rows["mixed"]}
    assert ends & starts - {0, len(chart.loci.values) - 1}


def test_all_arrays_are_of_one_length_and_one_for_each_style(tip):
    """x ascends; there is an array for each line the page knows; so it is without any loci."""
    for arrays in (drawn(tip), drawn(tip, per_rev=True), drawn(Chart(tip.question, words="none"))):
        assert len(arrays) == len(chart_tab.styles(LANES))
        assert {len(array) for array in arrays} == {len(arrays[0])}
        assert (np.diff(arrays[0]) >= 0).all()


def test_between_its_values_a_chart_is_drawn_on_the_line(tip):
    """The x of marks are put in between; the lines there are interpolated, not interrupted."""
    x, *lines = drawn(tip, TIP.replace(gamma=3.21))
    k = int(np.searchsorted(x, 3.21))
    first = next(line for line in lines[:LINES] if np.isfinite(line[0]))
    assert np.isfinite(first[k])
    assert first[k] == pytest.approx(np.interp(3.21, x[[k - 1, k + 2]], first[[k - 1, k + 2]]))


def test_room_for_lines_is_doubled_until_it_suffices(tip):
    """And never shrinks."""
    rows = {family: [np.zeros(2)] * 9 for family in FAMILIES}
    assert roomy(4, rows) == 16
    assert roomy(16, {family: [] for family in FAMILIES}) == 16
    assert len(series(tip, None, 32, per_rev=False)) == len(chart_tab.styles(32))


def test_the_mark_of_the_beam_is_where_its_modes_are(tip):
    """An upright line at its value, and a ring on each branch; none where it is not on the axis."""
    x, *lines = drawn(tip, TIP.replace(gamma=3.21))
    upright, rings = lines[LINES + len(PER_REV)], lines[LINES + len(PER_REV) + 1 :][:MODES]
    seen = np.flatnonzero(np.isfinite(upright))
    assert x[seen].tolist() == [3.21, 3.21]
    assert upright[seen].tolist() == [0, top(tip.loci)]
    for ring, frequency in zip(rings, solve(TIP.replace(gamma=3.21)).frequencies, strict=True):
        assert ring[np.isfinite(ring)].tolist() == [frequency]
        assert x[np.isfinite(ring)].tolist() == [3.21]
    _, *elsewhere = drawn(tip, TIP.replace(gamma=30))
    assert not any(np.isfinite(line).any() for line in elsewhere[LINES:-2])


def test_crossings_and_veerings_are_marked_apart(tip):
    """One kind of mark each, at the place and frequency of the meeting."""
    for chart, kind, other in ((tip, -2, -1), (charted(TIP, coriolis=True), -1, -2)):
        arrays = drawn(chart)
        marked = np.isfinite(arrays[kind])
        assert arrays[0][marked].tolist() == [event.at for event in chart.events]
        assert arrays[kind][marked].tolist() == [event.frequency for event in chart.events]
        assert not np.isfinite(arrays[other]).any()


def test_the_names_of_per_rev_lines_never_touch():
    """Flat lines end close to each other: every other one is named. Steep ones all are."""
    flat = chart_words.per_rev_labels(stop=60.0, high=1600.0)
    assert [name[-9:-7] for name in flat] == ["1γ", "3γ", "5γ"]
    assert len(chart_words.per_rev_labels(stop=20.0, high=150.0)) == len(PER_REV)


def test_per_rev_lines_are_multiples_of_the_speed():
    """omega = k gamma as far as the picture goes; over any other axis there are none."""
    low = charted(TIP, modes=2)
    assert low.loci
    high = top(low.loci)
    assert high < 100
    x, *lines = drawn(low, per_rev=True)
    for k, line in zip(PER_REV, lines[LINES:], strict=False):
        seen = np.isfinite(line)
        assert line[seen].tolist() == (k * x[seen]).tolist()
        assert seen.tolist() == (k * x <= high).tolist()
    over_alpha = drawn(charted(TIP, "alpha"), per_rev=True)
    assert not np.isfinite(np.array(over_alpha[1 + LINES :][: len(PER_REV)])).any()


def test_gaps_are_named_with_their_limit():
    """biot at mu = 10 has no equilibrium beyond 10.76: the lines end there, words say why."""
    chart = charted(TIP.replace(mu=10), strain="biot")
    assert chart.loci
    (limit,) = chart.loci.limits
    assert f"no equilibrium for γ = {limit.start:.6g}" in chart_words.gaps(chart)
    ends = [chart.loci.values[np.isfinite(row)].max() for row in chart.rows["bending"]]
    assert limit.start - 0.5 < max(ends) <= limit.start


def test_a_search_for_meetings_that_was_ended_is_told(tip):
    """Beneath the meetings found, and in place of the word that there are none."""
    assert tip.loci
    for events in (tip.loci.events, ()):
        ended = replace(tip, loci=replace(tip.loci, complete=False, events=events))
        told = chart_words.meetings(ended, None)
        assert "The search for crossings and veerings stopped" in told
        assert "No two" not in told
    assert "ended" not in chart_words.meetings(tip, None)


# The latest wish


def test_only_the_latest_of_many_wishes_is_answered():
    """While one is answered, all that come in are skipped but for the last; none after the end."""
    begun, go = threading.Event(), threading.Event()
    answered, ready = [], threading.Semaphore(0)

    class Slow(Latest[int, int]):
        def answered(self, wanted: int) -> int:
            begun.set()
            go.wait(5)
            answered.append(wanted)
            return wanted

    with ThreadPoolExecutor(2) as pool:
        slow = Slow(pool, ready.release)
        slow.want(0)
        begun.wait(5)
        for k in range(1, 50):
            slow.want(k)
        go.set()
        assert ready.acquire(timeout=5)
        assert ready.acquire(timeout=5)
        assert answered == [0, 49]
        assert slow.answer == 49
        assert not slow.busy
        slow.close()
        slow.want(50)
    assert answered == [0, 49]
