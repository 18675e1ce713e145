"""The Campbell diagram as data: its range, its lines, its marks, and the lists beside it; and two
loci magnified around their crossing or veering, without and with Coriolis forces."""

import re
from dataclasses import replace

import numpy as np
import pytest
from charts import TIP, case, chart_of
from helpers import traced_memory
from hypothesis import given
from hypothesis import strategies as st

from beamviz.beam import MAX_GAMMA_OVER_MU, NUMBERS, Beam
from beamviz.chart_ranges import CHART_AXES, CHART_POINTS, chart_range
from beamviz.drawing.modes import SampledModes
from beamviz.drawing.text import frequencies, measure
from beamviz.explorer import page
from beamviz.explorer.computed_loci import Chart, ChartRequest, chart_data
from beamviz.explorer.computed_veering import (
    LociPair,
    ModeShape,
    VeeringRequest,
    X,
    mode_shape,
    uncoupled,
)
from beamviz.explorer.features import loci_chart, veering
from beamviz.exports.html_page import solution_table
from beamviz.frequency_loci import Loci, loci
from beamviz.frequency_loci.events import EVENT_KINDS
from beamviz.frequency_loci.identity import identify_modes
from beamviz.solver import solve

INWARD = Beam(delta=-1)


@pytest.fixture(scope="module")
def tip() -> Chart:
    """The loci of TIP over the speed."""
    return chart_of(TIP)


def loci_of(chart: Chart) -> Loci:
    """The loci that a chart is drawn from."""
    request = chart.request
    values = np.linspace(request.start, request.stop, CHART_POINTS)
    return loci(request.beam, request.over, values, **request.options)


@given(
    st.fixed_dictionaries({name: st.floats(*NUMBERS[name].limits) for name in CHART_AXES}),
    st.sampled_from(CHART_AXES),
)
def test_every_axis_contains_the_beam_and_ends_at_valid_beams(numbers, over):
    """For any numbers, over each of them."""
    numbers["gamma"] = min(numbers["gamma"], MAX_GAMMA_OVER_MU * numbers["mu"])
    beam = Beam(**numbers)
    start, stop = chart_range(beam, over)
    assert start <= getattr(beam, over) <= stop
    assert start < stop
    beam.replace(**{over: start})
    beam.replace(**{over: stop})


def test_the_range_is_constant_up_to_80_percent_and_then_doubles():
    """So that it does not change during most of a drag. A number out of range is named."""
    gammas = np.linspace(0, 16, 50)
    assert {chart_range(TIP.replace(gamma=gamma), "gamma") for gamma in gammas} == {(0, 20)}
    assert chart_range(TIP.replace(gamma=16.1), "gamma") == (0, 40)
    assert chart_range(TIP.replace(delta=-0.5), "delta") == (-1, 1)
    pitches = (-80, (-90, 90)), (0, (0, 90)), (90, (0, 90)), (100, (0, 180))
    assert all(chart_range(Beam(pitch=pitch), "pitch") == ends for pitch, ends in pitches)
    assert chart_range(Beam(flap=0.02), "flap") == (0.0125, 2)
    with pytest.raises(ValueError, match="alpha = nan"):
        ChartRequest.around(case(TIP).changed("alpha", float("nan")), "gamma")


@pytest.mark.parametrize("coriolis", [False, True])
def test_the_lines_are_the_branches_in_their_families(coriolis):
    """All finite frequencies; runs share a point: no line has a gap where its colour changes."""
    chart = chart_of(TIP, coriolis=coriolis)
    data, found = chart_data(chart), loci_of(chart)
    at = np.searchsorted(data["at"], np.round(found.values, 12))
    for branch, line in zip(found.branches, data["lines"], strict=True):
        known = np.isfinite(branch.frequency)
        y = np.array(line["y"], float)
        assert np.isfinite(y[at]).tolist() == known.tolist()
        assert y[at][known] == pytest.approx(branch.frequency[known], rel=1e-5)
        runs = line["runs"]
        assert [first for first, *_ in runs[1:]] == [last for _, last, *_ in runs[:-1]]
        for first, last, family, _ in runs:
            inside = [k for k, i in enumerate(at) if first <= i < last]
            assert {branch.family[k] for k in inside} <= {family}
    families = {run[2] for line in data["lines"] for run in line["runs"]}
    assert families == {"bending", "stretching"} | ({"mixed"} if coriolis else set())


@pytest.mark.parametrize(
    ("beam", "options", "event"),
    [
        (INWARD, {"state": "stable"}, "buckling of B1: "),
        (Beam(alpha=1, beta=0.5), {"coriolis": True}, "veering of S1 and B3: "),
    ],
)
def test_lines_have_the_names_and_colours_of_the_table_of_modes(beam, options, event):
    """At each speed, as both change along the loci of a bent beam, and within mixed modes."""
    data = chart_data(chart_of(beam, **options))
    for gamma in data["at"][10:-1:30]:
        solution, found = solve(beam.replace(gamma=gamma), **options), []
        for line in data["lines"]:
            k = data["at"].index(gamma)
            (run,) = (run for run in line["runs"] if run[0] <= k < run[1])
            found.append((line["y"][k], run[3], run[2]))
        labels = identify_modes(solution).labels
        expected = zip(solution.frequencies, labels, solution.families, strict=False)
        for one, other in zip(sorted(found), expected, strict=False):
            assert one[0] == pytest.approx(other[0], rel=1e-4)
            assert one[1:] == other[1:]
    assert any(mark["text"].startswith(event) for mark in data["marks"])


def test_the_loci_compared_with_are_drawn_behind_the_chart(tip):
    """Those of the other beam at the same speeds."""
    request = tip.request.same_axis(case(TIP.replace(alpha=2)))
    assert (request.start, request.stop, request.over) == (0, 20, "gamma")
    second = [one for one in chart_data(tip, (), request.chart())["lines"] if one.get("second")]
    behind = [line["y"][line["at"].index(10.0)] for line in second]
    expected = solve(TIP.replace(alpha=2, gamma=10)).frequencies
    assert sorted(y for y in behind if y) == pytest.approx(expected, rel=1e-5)


def test_marks_are_buttons_with_names(tip):
    """The key of an event is the same if Coriolis forces make a crossing a veering."""
    crossing, *_ = chart_data(tip)["marks"]
    assert crossing["text"] == "crossing of S1 and B3: γ = 4.4641, ω = 60.559"
    veering, *_ = chart_data(chart_of(TIP, coriolis=True))["marks"]
    assert veering["text"] == "veering of S1 and B3: γ = 4.6502, ω = 61.298"
    assert crossing["value"] == veering["value"] == "B3 S1 1"
    assert (crossing["kind"], veering["kind"]) == ("crossing", "veering")


def test_an_event_with_a_mode_above_those_asked_for():
    """It has both names of the table, and both modes: going there shows one mode more."""
    chart = chart_of(TIP, coriolis=True, modes=3)
    (event,) = chart.pairs.values()
    assert event.at == pytest.approx(4.65, rel=1e-3)
    assert chart.names_of(event) == ["S1", "B3"]
    assert chart.modes_of(event) == (2, 3)


@pytest.mark.parametrize(
    ("beam", "over", "options"),
    [
        (TIP, "gamma", {}),
        (TIP, "gamma", {"coriolis": True, "modes": 7}),
        # It crosses just beyond a limit of equilibrium: there is none at the nearest value.
        (TIP.replace(gamma=18, mu=40), "mu", {"strain": "hencky", "modes": 6}),
    ],
)
def test_the_modes_of_an_event_have_its_frequency_there(beam, over, options):
    """By direct solves, one for each of its branches."""
    chart = chart_of(beam, over, 3 if over == "gamma" else 0, **options)
    assert chart.located
    for event in chart.located:
        modes = chart.modes_of(event)
        assert len(modes) == len(event.branches)
        there = solve(beam.replace(**{over: event.at}), **{**options, "modes": max(modes) + 1})
        half = event.gap / 2 + 1e-5 * event.frequency
        assert (abs(there.frequencies[[*modes]] - event.frequency) <= half).all()


def test_a_second_state_has_the_names_of_its_branches():
    """Both are lowest modes, of two states: the second is not the next mode of the first."""
    chart = chart_of(TIP.replace(delta=-1, spin_up=3), state="stable")
    (event,) = (event for event in chart.located if event.kind == "second state")
    assert chart.names_of(event) == ["B1", "B1 (state 2)"]
    assert chart.modes_of(event) == (0,)


@pytest.mark.slow
def test_a_chart_keeps_lines_not_solutions():
    """The solutions would take 0.6 MB, those of a blade 10 MB."""
    with traced_memory() as memory:
        chart = ChartRequest.around(case(Beam(alpha=1), coriolis=True), "gamma").chart()
        kept, _ = memory()
    assert len(chart.lines) == 5
    assert kept < 0.4


def test_resonances_are_the_intersections_with_the_per_rev_lines(tip):
    """omega = k gamma for the chosen k, listed in order of speed; none over another axis."""
    assert chart_data(tip)["perRev"] is None
    assert chart_data(tip, (2, 4))["perRev"] == {"slope": 1.0, "multiples": [2, 4]}
    chart = chart_of(TIP, per_rev=6)
    (mark,) = (one for one in chart_data(chart, (2,))["marks"] if one["kind"] == "resonance")
    assert mark["x"] == pytest.approx(0.79791, abs=1e-5)
    assert mark["y"] == pytest.approx(2 * mark["x"])
    table = loci_chart.resonance_table(chart, (1, 2, 3, 4, 5, 6))
    speeds = re.findall(r"×</td><td>([\d.]+)", table)
    assert len(speeds) == len(chart.resonances_at((1, 2, 3, 4, 5, 6))) > 5
    assert speeds == sorted(speeds, key=float)
    over_alpha = chart_of(TIP, "alpha", per_rev=5)
    assert (chart_data(over_alpha, (2,))["perRev"], over_alpha.resonances_at((2,))) == (None, {})
    assert "No line 2 × speed" in loci_chart.resonance_table(over_alpha, (2,))


def test_a_locus_on_a_per_rev_line_is_told():
    """In words, and by a wide line behind it, where that line is chosen; no speed is that of the
    resonance, so that there is no mark to go to."""
    chart = chart_of(Beam(root=0, gamma=3), per_rev=2, plane="flapwise")
    stop = chart.request.stop
    words = loci_chart.resonance_table(chart, (1, 2))
    assert "<b>B1</b> lies on the line 1 × speed" in words
    assert f"from γ = 0 to γ = {stop:.0f}" in words
    assert "No line 2 × speed" in loci_chart.resonance_table(chart, (2,))
    solution = solve(Beam(root=0, gamma=3), plane="flapwise")
    margins = loci_chart.margin_table(solution, (1, 2), chart)
    assert "<td>B1</td><td>on it</td><td>−50.0</td>" in margins
    data = chart_data(chart, (1,))
    (band,) = (line for line in data["lines"] if line["runs"][0][2] == "band")
    assert (band["at"], band["y"]) == ([0, stop], [0, stop])
    assert data["lines"][0] is band
    assert [mark for mark in data["marks"] if mark["kind"] == "resonance"] == []
    assert "line band" in [key["style"] for key in data["keys"]]
    assert not any(one["runs"][0][2] == "band" for one in chart_data(chart, (2,))["lines"])


@pytest.mark.parametrize(("delta", "law"), [(0, " with this material law"), (-0.5, "")])
def test_gaps_are_explained_by_their_limit(delta, law):
    """biot at mu = 10: none beyond 8.603, where the lines end; inward, thrust is the limit."""
    chart = chart_of(TIP.replace(mu=10, delta=delta), strain="biot")
    limit, found = chart.limits[-1], loci_of(chart)
    sentence = f"No equilibrium above γ = {limit.start:#.5g}{law}."
    assert sentence in loci_chart.notes(chart)
    assert chart_data(chart)["gaps"][-1] == [limit.start, limit.stop, "No equilibrium"]
    ends = [found.values[np.isfinite(one.frequency)].max() for one in found.branches]
    assert limit.start - 0.5 < max(ends) <= limit.start


def test_a_range_that_a_chart_ends_in_is_not_said_to_go_on():
    """An inward beam is unstable in bending as far as the chart goes, or up to a value in it;
    beyond a limit of equilibrium there is none at any speed."""
    inward = TIP.replace(delta=-1)
    plain, thick = chart_of(inward), chart_of(inward.replace(mu=10), strain="biot")
    ((buckled,), (first, lost)) = plain.limits, thick.limits
    assert buckled.stop == plain.request.stop
    told = loci_chart.range_of(buckled, plain.request)
    assert told == f"from γ = {buckled.start:#.5g} to the end of the chart"
    told = [loci_chart.range_of(one, thick.request) for one in (first, lost)]
    unstable, none = (f"γ = {one:#.5g}" for one in (first.start, lost.start))
    assert told == [f"from {unstable} to γ = {first.stop:#.5g}", f"above {none}"]


def test_a_chart_without_events_says_so():
    """In the place of the list, and beside one of other events."""
    for chart in (chart_of(TIP, modes=1), chart_of(INWARD, state="stable", modes=1)):
        assert "No crossing or veering in this range" in loci_chart.event_table(chart)
    assert "Buckling" in loci_chart.event_table(chart)
    assert "No crossing" not in loci_chart.event_table(chart_of(TIP))


@pytest.mark.parametrize("gamma", [4.65, 20.0])
def test_a_mode_has_one_name_on_the_page(gamma):
    """At a veering and beyond it: in the table of modes, along the lines, at their ends and in the
    scene. S1 is the stretching mode; where S1 and B3 are mixed, all name the mixture."""
    beam = Beam(alpha=1, beta=1, gamma=gamma)
    solution = solve(beam, coriolis=True)
    chart = replace(ChartRequest.around(case(beam, coriolis=True), "gamma"), stop=gamma).chart()
    table = solution_table(solution, [])
    names = re.findall(r"<b>([BS]\d)</b>", table)
    assert names == ["B1", "B2", "S1", "B3", "B4"]
    assert ("S1/B3 mixed 50:50" in table) == (gamma == 4.65)
    assert SampledModes.sampled(solution).labels == tuple(names)
    lines = chart_data(chart)["lines"]
    ends = sorted((line["y"][-1], line["label"]) for line in lines if line["y"][-1])
    assert [label for _, label in ends] == names
    starts = sorted((line["y"][0], line["runs"][0][3]) for line in lines if line["y"][0])
    assert [label for _, label in starts] == list(solve(beam.replace(gamma=0)).labels)


@pytest.fixture(scope="module")
def pairs(tip) -> tuple[LociPair, LociPair]:
    """The crossing of S1 and B3, and their veering with Coriolis forces."""
    return request(tip, 0).pairs()


def request(chart: Chart, number: int) -> VeeringRequest:
    """The request for a crossing or a veering of a chart."""
    on = replace(chart.request, options=chart.request.options | {"coriolis": True})
    return VeeringRequest(on, list(chart.pairs.values())[number])


def test_buckling_is_no_veering():
    """It is in the list and its key, but is not magnified."""
    chart = chart_of(INWARD, state="stable")
    (buckling,) = (key for key, event in chart.events.items() if event.kind == "buckling")
    assert "Buckling ▽" in loci_chart.event_table(chart)
    assert buckling not in chart.pairs
    assert f'data-value="{buckling}"' not in loci_chart.event_buttons(chart)


def test_every_kind_of_event_has_styles_of_its_own():
    """A limit point is no "point", which the page hides, and a second state no "second" line: a
    mark has one class for its kind, the same at its place and in the key of the chart."""
    axes = measure("gamma", None), frequencies(None)
    for kind in EVENT_KINDS:
        mark = page.mark("B1 1", kind, axes, (1.0, 2.0), "a mark")
        first, *classes = mark["style"].split()
        assert first == "mark"
        assert len(classes) == 1
        assert not {"point", "second", "line", "here"} & set(classes)
        (key,) = page.keys([], [mark])
        assert (key["style"], key["sign"]) == (mark["style"], EVENT_KINDS[kind].sign)


def test_a_crossing_becomes_a_veering_with_coriolis_forces(tip, pairs):
    """Without: gap 0 at 4.4641, shapes are kept; with: gap 0.241 at 4.650, they are exchanged."""
    off, on = pairs
    assert (off.event.kind, on.event.kind) == ("crossing", "veering")
    assert off.at == pytest.approx(4.4641, abs=1e-4)
    assert on.at == pytest.approx(4.650, abs=1e-3)
    assert on.event.gap == pytest.approx(0.241, abs=1e-3)
    for shapes in off.shapes:
        assert len({round(shape.bending_fraction, 6) for shape in shapes}) == 1
    for before, at, after in on.shapes:
        assert abs(after.bending_fraction - before.bending_fraction) > 0.8
        assert at.bending_fraction == pytest.approx(0.5, abs=0.05)
    asked = request(tip, 0)
    assert "exchange their shapes" in veering.told(on, asked)
    assert "uncoupled (gap 0)" in veering.told(off, asked)
    assert "S1/B3 mixed 50:50" in veering.shape_table((on,), asked)
    assert "mixed" not in veering.shape_table((off,), asked)


def test_the_view_shows_both_events_the_gap_and_shapes_of_one_sign(tip, pairs):
    """It is a part of the chart, at whose ends the distance is more than twice the gap, and shapes
    correlate with that at the event. A branch has no shape above the modes solved for."""
    chart = request(tip, 0).chart
    for pair in pairs:
        assert pair.values[0] < pair.at < pair.values[-1]
        assert np.ptp(pair.values) < 0.2 * (chart.stop - chart.start)
        for first, middle, last in pair.shapes:
            for end in (first, last):
                assert (end.displacement * middle.displacement).sum() >= 0
    assert pairs[0].at not in pairs[0].values
    a, b = pairs[1].lines
    found = loci_of(tip)
    assert abs(b.frequency - a.frequency)[[0, -1]].min() > 2 * pairs[1].event.gap
    branch = replace(found.branches[0], mode_index=np.full(len(found.values), -1))
    assert np.isnan(mode_shape(branch, 0).displacement).all()


def test_the_view_of_an_event_near_the_start_of_a_chart_is_a_part_of_it():
    """Below mu = 12, where this chart starts, there is no beam with the speed of this one."""
    chart = chart_of(TIP.replace(gamma=60, mu=300), "mu")
    first, *_ = chart.pairs.values()
    for pair in VeeringRequest(chart.request, first).pairs():
        assert chart.request.start == 12
        assert 12 <= pair.values[0] < first.at < pair.values[-1]


def test_the_chart_shows_both_cases_the_gap_and_the_crossing(tip, pairs):
    """Dashed without Coriolis forces; the gap as a vertical line of its length; the crossing. S1
    and B2, which cross at 16.32, stay too far apart with Coriolis forces for a veering."""
    data = veering.pairs_data(pairs, request(tip, 0))
    styles = [{run[2].split()[-1] for run in line["runs"]} for line in data["lines"]]
    assert styles == [{"dashed"}, {"dashed"}, {"thick"}, {"thick"}, {"measure"}]
    assert abs(np.diff(data["lines"][-1]["y"])[0]) == pytest.approx(0.241, abs=1e-3)
    (crossing,) = veering.pairs_data(pairs[:1], request(tip, 0))["marks"]
    assert crossing["x"] == pytest.approx(4.4641, abs=1e-4)
    assert len(data["at"]) == len(data["lines"][0]["y"])
    far = request(tip, 1)
    off, on = far.pairs()
    assert (off.event.kind, on.event) == ("crossing", None)
    assert "the gap is too large for a veering" in veering.told(on, far)
    lines = veering.pairs_data((off, on), far)["lines"]
    assert not [line for line in lines if line["runs"][0][2] == "measure"]


def test_the_shapes_beside_a_veering_have_both_planes():
    """Flap and lag as lines of their own; a mode that is missing at a value is a dash."""
    beam = Beam(flap=0.25, pitch=3, gamma=5)
    found = loci(beam, "gamma", [0.0, 5.0], plane="both", modes=3)
    shape = mode_shape(found["L1"], 0)
    drawn = veering.drawing(mode_shape(found["L1"], 1, shape))
    assert all(f'class="{name}"' in drawn for name in ("stretching", "lag", "flap"))
    assert drawn.endswith("F1")  # beyond the veering
    assert re.search(r'<polyline[^>]*class="flap"[^>]*stroke-width="2.5"', drawn), drawn
    missing = ModeShape(np.full((len(X), 1), np.nan), np.nan, "")
    assert veering.drawing(missing) == "–"
    assert mode_shape(found["L1"], 1, missing).displacement.shape == (len(X), 3)


def test_flap_and_lag_exchange_their_shapes_where_they_veer():
    """In a chart of both planes, whose lines have the colours of flap and lag: they cross without a
    pitch, which is what couples them."""
    beam = Beam(flap=0.25, pitch=3)
    asked = ChartRequest(beam, "gamma", 0.0, 10.0, {"plane": "both", "coriolis": False})
    chart = uncoupled(asked).chart()
    styles = {style for line in asked.chart().lines for *_, style, _ in line.runs}
    assert {"flap", "lag"} <= styles
    event = next(e for e in chart.pairs.values() if {*e.branches} == {"F1", "L1"})
    around = VeeringRequest(asked, event)
    off, on = pairs = around.pairs()
    assert (around.kind, off.event.kind, on.event.kind) == ("pitch", "crossing", "veering")
    assert all(np.isfinite(s.displacement).all() for p in pairs for row in p.shapes for s in row)
    assert "exchange their shapes" in veering.told(on, around)
    before, _, after = (veering.parts_of(shape, around) for shape in on.shapes[0])
    assert {*before} == {"flap", "lag"}
    assert abs(after["lag"] - before["lag"]) > 0.8


def test_the_gap_opens_with_the_coupling_in_one_view(tip):
    """In proportion to it while it is small; the range of the axes stays, so that it is seen to."""
    whole = request(tip, 0)
    gaps, views = [], []
    for factor in (0.0, 0.1, 0.2, 1.0):
        options = whole.chart.options | {"coriolis": factor}
        pairs = replace(whole, chart=replace(whole.chart, options=options)).pairs()
        low, high = pairs[-1].gap
        gaps.append(high - low)
        views.append([pairs[0].values[0], pairs[0].values[-1]])
    assert gaps[0] == pytest.approx(0, abs=2e-3)  # beside the crossing, where shapes are unique
    assert gaps[2] == pytest.approx(2 * gaps[1], rel=0.01)
    assert gaps[3] == pytest.approx(0.241, abs=1e-3)
    np.testing.assert_allclose(views, [views[0]] * 4, rtol=1e-6)


def test_a_model_without_coriolis_forces_has_a_crossing_alone(tip):
    """Out of the plane of rotation nothing couples."""
    options = tip.request.options | {"plane": "flapwise"}
    asked = replace(tip.request, options=options)
    event = next(iter(asked.chart().pairs.values()))
    (alone,) = VeeringRequest(asked, event).pairs()
    assert alone.event.kind == "crossing"


def test_the_inset_of_the_chart_at_an_event(guest):
    """It says the gap, opens the view, and leaves when the beam does."""
    guest.edit(alpha=1.0, beta=1.0, coriolis=True)
    guest.wait(lambda _: "B3 S1 1" in guest.texts["loci-events"])
    assert guest.texts["loci-inset"] == ""
    guest.do("go_to_event", "B3 S1 1")
    guest.wait(lambda _: "gap 0.241" in guest.texts["loci-inset"])
    assert 'data-panel="tab-veering"' in guest.texts["loci-inset"]
    assert guest.props["loci-inset"]["data-side"] == "right"
    guest.do("gamma", 6.0)
    guest.wait(lambda _: guest.texts["loci-inset"] == "")


def test_the_slider_of_the_coupling_and_the_shapes_of_the_page(guest):
    """The slider sets the factor of the model, and keeps no beam to compare with; a shape brings
    its mode into the scene, on its side of the event."""
    guest.do("alpha", 1.0)
    guest.do("beta", 1.0)
    guest.do("tab", "veering")
    guest.wait(lambda _: guest.charts["veering-chart"].get("lines"))
    assert guest.props["pitch_here-row"]["hidden"]
    guest.do("coriolis_percent", 30.0)
    guest.wait(lambda _: "30 % of Coriolis" in guest.texts["veering-told"])
    assert guest.props["coriolis"]["data-part"] == "30 %"
    assert (guest.values["coriolis"], guest.values["comparison"]) == (0.3, "nothing")
    guest.do("coriolis_percent", 100.0)
    guest.wait(lambda _: "with Coriolis forces" in guest.texts["veering-told"])
    guest.do("show_shape", "0 before")
    before = guest.wait(lambda _: 3 < guest.values["gamma"] < 4.65 and guest.values["gamma"])
    guest.do("show_shape", "0 after")
    guest.wait(lambda _: guest.values["gamma"] > 4.65)
    assert before < 4.65
    guest.do("show_shape", "9 nowhere")
    guest.do("plane", "flapwise")
    guest.wait(lambda _: guest.props["coriolis_percent-row"]["hidden"])
