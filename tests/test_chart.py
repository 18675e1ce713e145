"""The loci chart of the explorer: its range, its lines, its marks, and the microscope."""

import contextlib
import math
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest
from browser import NO_BROWSER, Page, page
from hypothesis import given
from hypothesis import strategies as st
from visitor import Visitor, visitor

from beamviz.beam import LIMITS, MAX_GAMMA_OVER_MU, Beam
from beamviz.mechanics.solve import solve
from beamviz.scene_file import SavedScene
from beamviz.show import chart as charts
from beamviz.show import chart_tab, microscope_tab
from beamviz.show.browser import found_browser
from beamviz.show.chart import (
    FAMILIES,
    LANES,
    PER_REV,
    SPANS,
    Chart,
    Point,
    Question,
    computed,
    roomy,
    series,
    span,
    top,
)
from beamviz.show.controls import MODES, Wanted
from beamviz.show.latest import Latest
from beamviz.show.measures import frequencies, measure
from beamviz.show.microscope import Target, magnified
from beamviz.show.motion import Shapes
from beamviz.show.readout import significant
from beamviz.show.server import explorer

TIP = Beam(alpha=1, beta=1, gamma=3)  # S1 meets B3 at gamma = 4.4641
LINES = len(FAMILIES) * LANES
PLAIN = measure("gamma", None), frequencies(None)


def charted(beam: Beam, over: str = "gamma", **options: Any) -> Chart:
    """The chart of a beam."""
    question = Question.of(Wanted.of(beam, options), over)
    return Chart(question, computed(question))


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
        {name: st.floats(*LIMITS[name]) for name in LIMITS},
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
    assert f"no equilibrium for γ = {limit.start:.6g}" in chart_tab.gaps(chart)
    ends = [chart.loci.values[np.isfinite(row)].max() for row in chart.rows["bending"]]
    assert limit.start - 0.5 < max(ends) <= limit.start


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


# The microscope


def test_the_microscope_shows_crossing_and_veering_of_the_same_two(tip):
    """Off: gap 0 at 4.4641, every shape stays; on: gap 0.241 at 4.650, the shapes change places."""
    off, on = magnified(Target(tip.question, tip.events[0]))
    assert off.event
    assert on.event
    assert (off.event.kind, on.event.kind) == ("crossing", "veering")
    assert off.at == pytest.approx(4.4641, abs=1e-4)
    assert on.at == pytest.approx(4.650, abs=1e-3)
    assert on.event.gap == pytest.approx(0.241, abs=1e-3)
    for motions in off.motions:
        assert len({round(motion.share, 6) for motion in motions}) == 1
    for before, at, after in on.motions:
        assert abs(after.share - before.share) > 0.8
        assert at.share == pytest.approx(0.5, abs=0.05)
    words = microscope_tab.sentence(on, *PLAIN)
    assert "least gap 0.241 at γ 4.650" in words
    assert "exchange their shapes" in words
    assert "nothing couples them" in microscope_tab.sentence(off, *PLAIN)


def test_what_is_too_wide_for_a_veering_is_said(tip):
    """S1 and B2 cross at 16.32; with Coriolis forces they stay far apart."""
    off, on = magnified(Target(tip.question, tip.events[1]))
    assert off.event
    assert on.event is None
    assert "do not come close" in microscope_tab.sentence(on, *PLAIN)
    arrays = microscope_tab.series((off, on), microscope_tab.LANES)
    assert len(arrays) == len(microscope_tab.styles(microscope_tab.LANES))


def test_nodes_are_marked_in_the_middle_of_a_veering():
    """There the tip moves more along than across, out of step with the bending that has nodes."""
    solution = solve(TIP.replace(gamma=4.65), coriolis=True)
    for k in (2, 3):
        marked, _ = Shapes.sampled(solution).nodes[k]
        assert marked == pytest.approx(solution.nodes[k], abs=2e-5)
        assert len(marked) == 2


# In the explorer


@pytest.fixture(scope="module")
def url() -> Iterator[str]:
    """A running explorer; every visitor starts from TIP."""
    with explorer(SavedScene(TIP)) as address:
        yield address


def settled(guest: Visitor) -> None:
    """Pause, and take in what is still on its way."""
    guest.choose("playing", False)
    end = time.monotonic() + 20
    with contextlib.suppress(TimeoutError):
        while True:
            guest.receive(0.7)
            assert time.monotonic() < end


def test_the_chart_follows_the_sliders(url):
    """Another mass moves the meeting; the place of the beam follows the speed."""
    with visitor(url) as guest:
        guest.says("4.4641")
        guest.choose("mass α", 2.0)
        guest.says(f"{charted(TIP.replace(alpha=2)).events[0].at:.4f}")
        guest.choose("speed γ", 7.25)
        guest.says("this beam, γ = 7.25")


def test_moving_along_the_axis_computes_no_chart(url, monkeypatch):
    """Only the mark moves."""
    with visitor(url) as guest:
        guest.says("4.4641")
        settled(guest)
        monkeypatch.setattr(charts, "loci", None)  # a call would end in words
        guest.choose("speed γ", 6.5)
        guest.says("this beam, γ = 6.5")
        settled(guest)
        assert "unexpected" not in guest.text


def test_choosing_a_meeting_moves_the_scene_there(url):
    """The number is set, the beam solved again, and the microscope says what it sees."""
    with visitor(url) as guest:
        guest.says("4.4641")
        guest.choose("go to", "1")
        at = charted(TIP).events[0].at
        there = solve(TIP.replace(gamma=at))
        guest.says(significant(there.frequencies[0], there.errors[0]))
        guest.says("least gap 0.241 at γ 4.650")
        guest.choose("along", "mass α")
        guest.says("at α")


def test_nonsense_about_the_chart_changes_nothing(url):
    """Unknown axes and meetings are ignored, and the session goes on."""
    with visitor(url) as guest:
        guest.says("4.4641")
        guest.choose("along", "temperature")
        guest.choose("go to", "99")
        guest.choose("go to", 7)
        guest.choose("per-rev lines", "maybe")
        guest.choose("speed γ", 8.0)
        guest.says("this beam, γ = 8")
        guest.choose("mass α", math.nan)
        guest.says("alpha = nan")
        guest.choose("mass α", 1.5)
        guest.says(f"{charted(TIP.replace(alpha=1.5, gamma=8)).events[0].at:.4f}")


# The real page


CHART = "Object.values(window.__viserTestpoints?.uplots || {})[0]?.chart"


PICK = "Array.from(document.querySelectorAll('button')).filter(e => e.innerText === '1').pop()"


def control(label: str) -> str:
    """The element that a label of the panel belongs to."""
    return (
        "document.getElementById(Array.from(document.querySelectorAll('label'))"
        f".find(e => e.innerText === '{label}')?.htmlFor)"
    )


def pick(shown: Page, axis: str) -> None:
    """Choose another axis."""
    shown.click(control("along"))
    time.sleep(0.5)  # the list unfolds
    options = "Array.from(document.querySelectorAll('[role=option]'))"
    shown.click(f"{options}.find(e => e.innerText === '{axis}')")


def tab(name: str) -> str:
    """A tab, by its name."""
    return (
        "Array.from(document.querySelectorAll('[role=tab]'))"
        f".find(e => e.innerText.trim() === '{name}')"
    )


def mark_of(shown: Page) -> float:
    """Where the upright line of the chart is."""
    column = 1 + LINES + len(PER_REV)
    return shown.evaluate(
        f"(() => {{ const d = {CHART}.data;"
        f" return d[0][d[{column}].findIndex(y => !Number.isNaN(y))]; }})()"
    )


def reaches(shown: Page, value: float) -> None:
    """Wait until the mark of the beam is at a value."""
    end = time.monotonic() + 30
    while abs(mark_of(shown) - value) > 1e-6:
        assert time.monotonic() < end, (mark_of(shown), value)
        time.sleep(0.2)


@pytest.mark.browser
@pytest.mark.skipif(found_browser() is None, reason=NO_BROWSER)
def test_the_chart_on_the_page(url):
    """It is drawn with names on its lines; the mark follows the slider; a chosen meeting moves
    the scene; the microscope draws both cases; no console errors."""
    with page(url, 1280, 860) as shown:
        shown.wait("document.body?.innerText.includes('stretching')")
        shown.click(tab("Loci"))
        shown.wait(f"{CHART} && {CHART}.scales.y.max === 250")
        frame, names = shown.wait(
            f"""(() => {{
              const names = document.querySelector('[data-labels] > div');
              if (!names || !{CHART}.over.clientWidth) return null;
              return [{CHART}.over, names].map(e => {{
                const r = e.getBoundingClientRect(); return [r.left, r.top, r.right, r.bottom]; }});
            }})()"""
        )
        assert names == pytest.approx(frame, abs=2)  # names stand where their lines end
        reaches(shown, 3.0)
        slider = control("speed γ")
        shown.drag(slider, 0.06, 0.2)
        field = f"{slider}.parentElement.querySelector('input[type=text]').value"
        moved = float(shown.wait(f"{field} !== '3' && {field}"))
        assert moved > 4
        reaches(shown, float(shown.evaluate(field)))
        shown.click(PICK)
        reaches(shown, charted(TIP).events[0].at)
        shown.wait(f"{field} === '4.4641'")
        pick(shown, "position β")
        shown.wait(f"{CHART}.scales.x.min === 0 && {CHART}.scales.x.max === 1")
        pick(shown, "speed γ")
        shown.wait(f"{CHART}.scales.x.max === 20")
        shown.click(PICK)
        shown.click(tab("Microscope"))
        shown.wait("document.body.innerText.includes('least gap 0.241 at γ 4.650')")
        shown.wait("document.querySelectorAll('table[aria-label^=shapes] svg').length === 12")
        assert shown.problems == []
