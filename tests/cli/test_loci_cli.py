"""`beamviz loci`: tables, JSON, CSV and charts."""

import csv
import io
import math
import re
from dataclasses import replace
from itertools import combinations

import numpy as np
import pandas
import pytest
from helpers import slow, strict
from matplotlib.figure import Figure
from matplotlib.image import imread

from beamviz import Beam, Units, loci, solve
from beamviz.plotting.loci import LociDrawing, draw_chart
from beamviz.scene import Scene

SWEEP = ("loci", "--over", "gamma", "--start", "0", "--stop", "10", "--alpha", "1")
INWARD = (*SWEEP[:6], "8", "--delta", "-1", "--points", "5")


def test_loci_as_json(run):
    """The keys of the contract, one entry for each value of loci(), the crossing of physics 3.1."""
    code, out, err = run(*SWEEP, "--points", "21", "--format", "json")
    data = strict(out)
    assert (code, err) == (0, "")
    values = np.linspace(0, 10, 21)
    assert (data["over"], data["values"]) == ("gamma", pytest.approx(values.tolist()))
    assert [branch["label"] for branch in data["branches"]] == ["B1", "B2", "B3", "S1", "B4"]
    for branch, row in zip(
        loci(Beam(alpha=1), "gamma", values).branches, data["branches"], strict=True
    ):
        assert row["frequency"] == branch.frequency.tolist()
        assert row["family"] == 21 * ["bending" if row["label"][0] == "B" else "stretching"]
        assert len(row["error"]) == len(row["growth_rate"]) == 21
    (event,) = data["events"]
    assert (event["kind"], event["branches"], event["gap"]) == ("crossing", ["B3", "S1"], 0)
    assert event["at"] == pytest.approx(4.4641, abs=5e-5)
    assert event["frequency"] == pytest.approx(60.559, abs=1e-3)
    assert data["beam"] == {"alpha": 1, "beta": 1, "delta": 0, "mu": 70}
    assert (data["model"]["coriolis"], data["limits"]) == (False, [])


def test_loci_without_equilibrium_or_stability(run):
    """null, and the limit in a row of its own: no equilibrium, or growth instead of vibration."""
    arguments = "loci --over gamma --start 40 --stop 50 --points 11 --strain hencky --format json"
    code, out, _ = run(*arguments.split())
    for branch in strict(out)["branches"]:
        assert (branch["frequency"][-1], branch["family"][-1]) == (None, None)
    (limit,) = strict(out)["limits"]
    assert (code, limit["kind"]) == (0, "no-equilibrium")
    assert limit["start"] == pytest.approx(45.420, abs=1e-3)
    first = strict(run(*INWARD, "--format", "json")[1])["branches"][0]
    assert (first["frequency"][-1], first["family"][-1]) == (None, "bending")
    assert first["growth_rate"][-1] > 0


def test_loci_as_csv_for_numpy(run):
    """Numbers in all columns, nan where there is none; numpy and csv read it as it is."""
    code, out, _ = run(*INWARD, "--format", "csv")
    heading = next(csv.reader(io.StringIO(out)))
    columns = np.loadtxt(io.StringIO(out), delimiter=",", skiprows=1, unpack=True)
    table = dict(zip(heading, columns.tolist(), strict=True))
    assert (code, len(heading), heading[:3]) == (0, 12, ["gamma", "B1", "B2"])
    assert table["gamma"] == [0, 2, 4, 6, 8]
    assert np.isnan(table["B1"]).tolist() == [False, False, True, True, True]
    assert [rate > 0 for rate in table["B1_growth_rate"]] == [False, False, True, True, True]
    assert table["B1_bending"] == 5 * [1]


def test_loci_in_si_units(run, steel):
    """rpm and Hz beside the numbers without dimension."""
    line = (*SWEEP[:6], "20", "--si", steel, "--points", "3", "--format")
    data = strict(run(*line, "json", "--per-rev", "2")[1])
    time = data["units"]["time"]
    assert data["rpm"] == pytest.approx([0, 300 / math.pi / time, 600 / math.pi / time])
    first = data["branches"][0]
    assert first["hertz"] == pytest.approx([f / (2 * math.pi * time) for f in first["frequency"]])
    first = data["events"][0]
    assert (first["kind"], first["branches"], first["per_rev"]) == ("resonance", ["B1"], 2)
    rows = list(csv.DictReader(io.StringIO(run(*line, "csv")[1])))
    assert list(rows[0])[:3] == ["gamma", "rpm", "B1"]
    for branch in data["branches"]:
        name = branch["label"]
        cells = [float(row[f"{name}_hertz"]) for row in rows]
        known = [f / (2 * math.pi * time) for f in branch["frequency"] if f is not None]
        assert [x for x in cells if not math.isnan(x)] == pytest.approx(known, rel=1e-12)


ARM = """length = 2
mass_per_length = 3
bending_stiffness = 500
axial_stiffness = 1e6
mass = 6
rotation_speed = 3
"""


def test_events_as_csv_for_pandas(run, tmp_path):
    """They are a table of their own, with the values of JSON, so that both tables are read as they
    are; without events it has a heading. Who does not ask for it is told of it."""
    file, beam = tmp_path / "events.csv", tmp_path / "arm.toml"
    beam.write_text(ARM)
    line = (*SWEEP[:6], "20", "--points", "3", "--per-rev", "1", "--coriolis", "--si", str(beam))
    line += ("--format",)
    code, out, err = run(*line, "csv", "--events", str(file))
    assert (code, err) == (0, "")
    assert {dtype.kind for dtype in pandas.read_csv(io.StringIO(out)).dtypes} == {"f"}
    table = pandas.read_csv(file)
    events = strict(run(*line, "json")[1])["events"]
    assert {"resonance", "veering"} <= {event["kind"] for event in events}
    assert {"until", "until_rpm"} <= {*table.columns}
    for row, event in zip(table.to_dict("records"), events, strict=True):
        found = {name: value for name, value in row.items() if not pandas.isna(value)}
        known = {name: value for name, value in event.items() if value is not None}
        assert found == known | {"branches": " ".join(known["branches"])}
    assert "--events" in run(*line, "csv")[2]
    run(*SWEEP, "--points", "3", "--modes", "1", "--events", str(file))
    assert file.read_text().startswith("kind,branches,at,")
    assert len(pandas.read_csv(file)) == 0


HINGED = """length = 6
mass_per_length = 10
bending_stiffness = 2e6
flap_stiffness = 5e4
axial_stiffness = 1e8
rotation_speed = 30
root_stiffness = 0
"""


def test_a_mode_on_a_per_rev_line_is_told(run, tmp_path):
    """A beam hinged on the axis turns about the hinge, out of the plane of rotation, with the
    frequency of the rotation: in the table, JSON, CSV and chart."""
    beam, file, chart = (tmp_path / name for name in ("hinged.toml", "events.csv", "chart.svg"))
    beam.write_text(HINGED)
    line = ["loci", "--si", str(beam), "--plane", "flapwise", "--over", "rad/s"]
    line += ["--start", "0", "--stop", "40", "--points", "5"]
    table = run(*line, "--per-rev", "2", "--events", str(file), "--plot", str(chart))[1]
    stop = 40 * 30 / math.pi  # [rpm]
    assert re.search(rf"resonance 1x +B1 .* 0 \.\. {stop:.6g} ", table)
    assert "B1 lies on the line 1x" in table
    assert "No crossing or veering in this range" in table
    data = strict(run(*line, "--per-rev", "2", "--format", "json")[1])
    (event,) = data["events"]
    assert (event["kind"], event["branches"], event["per_rev"]) == ("resonance", ["B1"], 1)
    assert (event["rpm"], event["until_rpm"]) == (0, pytest.approx(stop, rel=1e-12))
    assert data["branches"][0]["frequency"] == pytest.approx(data["values"], abs=1e-9)
    (row,) = pandas.read_csv(file).to_dict("records")
    assert (row["branches"], row["per_rev"], row["until"]) == ("B1", 1, event["until"])
    assert "resonance" in chart.read_text()
    assert "resonan" not in run(*line)[1]


def test_a_chart_answers_what_it_was_asked(run):
    """No crossing, no resonance, each for itself; a resonance is no answer to the first."""
    line, crossing = (*SWEEP[:6], "2", "--points", "3"), "No crossing or veering in this range."
    bare = run(*line)[1]
    assert crossing in bare
    assert "resonance" not in bare
    none = run(*line[:3], "--start", "0.1", "--stop", "0.2", "--points", "3", "--per-rev", "2")[1]
    assert crossing in none
    assert "No resonance with 1x .. 2x in this range." in none
    found = run(*line, "--per-rev", "3")[1]
    assert "resonance 3x" in found
    assert crossing in found
    assert "No resonance" not in found


@pytest.mark.parametrize(
    ("beam", "over", "values", "options"),
    [
        (Beam(alpha=1), "gamma", np.linspace(0, 20, 21), {"coriolis": True, "per_rev": 2}),
        (Beam(alpha=1), "gamma", np.linspace(0, 20, 21), {"per_rev": 2}),
        # Where a second state begins its frequency is that of no branch.
        *slow(
            (
                Beam(alpha=1, delta=-1, spin_up=3),
                "gamma",
                np.linspace(0, 3, 4),
                {"state": "stable", "modes": 2},
            )
        ),
    ],
)
def test_loci_are_drawn_through_their_own_frequencies(beam, over, values, options):
    """At each event, which is a point between the values: the two of a veering on either side of
    its mark. So are those of another model drawn beside them, which have other events."""
    found = loci(beam, over, values, **options)
    assert found.events
    axes = Figure().subplots()
    chart = LociDrawing(found, axes, (1, 2))
    check_drawn(found, axes)
    if options.get("state") != "stable":
        axes.clear()
        other = loci(beam, over, values, curvature="material", **options)
        for branch in other.branches:
            chart.draw_branch(axes, other, branch)
        check_drawn(other, axes)


def check_drawn(found, axes):
    """Check that lines have frequencies of solves at all their points, and one at each event."""
    points = {tuple(xy) for line in axes.lines for xy in line.get_xydata() if xy[1] == xy[1]}
    model = {name: value for name, value in found.problem.options.items() if name != "modes"}
    for at, y in points:
        near = solve(found.beam.replace(**{found.over: float(at)}), modes=7, **model).frequencies
        assert np.nanmin(abs(near - y)) < 1e-5 * (1 + y), (at, y)
    drawn = {x for x, _ in points}
    assert drawn >= {e.at for e in found.events if e.kind != "second state"}


def test_a_resonance_all_along_is_drawn_behind_its_locus():
    """A wide line over all speeds, where that per-rev line is drawn."""
    found = loci(Beam(root=0), "gamma", np.linspace(0, 12, 13), 3, per_rev=4, plane="flapwise")
    for multiples, count in (((1, 2), 1), ((2,), 0)):
        lines = draw_chart(found, multiples).axes[0].lines
        wide = [line for line in lines if line.get_linewidth() > 4]
        assert [line.get_xydata().tolist() for line in wide] == count * [[[0, 0], [12, 12]]]


@pytest.mark.parametrize(
    ("ending", "start"),
    [("PNG", b"\x89PNG"), *slow(("pdf", b"%PDF"), ("svg", b"<?xml"))],
)
def test_plot_of_loci(run, tmp_path, ending, start):
    """A picture of its kind beside the data on stdout, with blue bending, vermilion stretching."""
    file = tmp_path / f"loci.{ending}"
    code, out, err = run(*SWEEP, "--points", "9", "--plot", str(file), "--format", "csv")
    assert (code, out[:8]) == (0, "gamma,B1"), err
    assert file.read_bytes().startswith(start)
    if ending != "PNG":
        return
    picture = np.rint(255 * imread(file)[:, :, :3]).astype(int)
    for colour in ((0, 114, 178), (213, 94, 0)):
        assert (abs(picture - colour).max(axis=2) <= 2).sum() > 1000
    assert (picture == 255).all(axis=2).mean() > 0.8


IN_SI = Beam(alpha=1, units=Units(length=1.0, time=0.5))


@pytest.mark.parametrize(
    ("beam", "over", "stop", "options", "shown"),
    [
        (Beam(alpha=1), "gamma", 20, {}, ""),
        (IN_SI, "gamma", 20, {"coriolis": True}, "veering\n88.812 rpm\ngap 0.0767 Hz"),
        (Beam(delta=-1), "gamma", 10, {}, "divergence\nbeyond γ = 2.9960"),
        (Beam(), "gamma", 60, {"strain": "hencky"}, "no equilibrium\nbeyond γ = 45.420"),
        *slow(
            (Beam(alpha=1), "gamma", 20, {"coriolis": True}, "veering\nγ = 4.6502\ngap 0.241"),
            (Beam(alpha=0.5, gamma=5), "beta", 1, {}, ""),
            (Beam(gamma=10), "alpha", 2, {"coriolis": True}, ""),
        ),
    ],
)
def test_labels_in_the_plot_do_not_overlap(beam, over, stop, options, shown):
    """No label on another, none outside the picture. Each event is marked, each limit is named in
    its range, and a veering is labelled with its gap."""
    per_rev = 3 if over == "gamma" else 0
    found = loci(beam, over, np.linspace(0, stop, 41), per_rev=per_rev, **options)
    figure = draw_chart(found, range(1, per_rev + 1))
    figure.draw_without_rendering()
    axes = figure.axes[0]
    boxes = {text: text.get_window_extent() for text in axes.texts if text.get_text()}
    assert {branch.label for branch in found.branches} <= {text.get_text() for text in boxes}
    for (one, a), (other, b) in combinations(boxes.items(), 2):
        assert not a.overlaps(b), (one.get_text(), other.get_text())
    for text, box in boxes.items():
        assert 0 <= box.x0 <= box.x1 <= figure.bbox.x1, text.get_text()
    drawn = [line.get_marker() for line in axes.lines]
    for kind, mark in {"crossing": "o", "veering": "D"}.items():
        assert drawn.count(mark) == sum(event.kind == kind for event in found.events)
    places = {text.get_text(): text.get_position()[0] for text in boxes}
    for limit in found.limits:
        (x,) = (x for text, x in places.items() if text.startswith(limit.name))
        assert limit.start < x < limit.stop
    assert shown in {"", *places}


@pytest.mark.parametrize("modes", [1, 2])
def test_a_plot_of_modes_that_do_not_vibrate(run, tmp_path, modes):
    """A buckled beam: its only mode has a growth rate and no frequency; with two one has."""
    chart = tmp_path / "chart.svg"
    line = ("loci", "--over", "gamma", "--delta=-1", "--start", "4", "--stop", "6", "--points", "5")
    code, _, err = run(*line, "--modes", str(modes), "--plot", chart)
    assert (code, err) == (0, "")
    assert "divergence" in chart.read_text()


def test_an_option_without_effect_is_noted(run):
    line, note = (*SWEEP, "--points", "3", "--format", "csv"), "--gamma 5 is not used: --over gamma"
    code, out, err = run(*line, "--gamma", "5")
    assert (code, out) == (0, run(*line)[1])
    assert err.startswith(f"beamviz: {note} varies it\n")


def test_margins_at_the_operating_speed(run, tmp_path):
    """Of each mode to each per-rev line in percent, with its Southwell coefficient, in the table,
    JSON and CSV: of a hinged flap mode, which lies on the line 1x, too."""
    file = tmp_path / "margins.csv"
    line = ["loci", "--over", "gamma", "--start", "0", "--stop", "10", "--points", "3"]
    line += ["--plane", "flapwise", "--gamma", "5", "--per-rev", "2"]
    code, table, err = run(*line, "--margins", str(file))
    assert (code, err) == (0, "")
    assert "Margins to per-rev lines at the operating speed, gamma = 5" in table
    records = strict(run(*line, "--format", "json")[1])["margins"]
    rest, spinning = (solve(Beam(gamma=gamma), plane="flapwise") for gamma in (0, 5))
    for k, record in enumerate(records):
        frequency = spinning.frequencies[k]
        assert record["frequency"] == pytest.approx(frequency, rel=1e-6)
        assert record["percent"] == pytest.approx([20 * frequency - 100, 10 * frequency - 100])
        growth = (spinning.omega_squared[k] - rest.omega_squared[k]) / 25
        assert record["southwell"] == pytest.approx(growth, rel=1e-4)
    rows = pandas.read_csv(file)
    assert rows["margin_2x"].tolist() == [record["percent"][1] for record in records]
    hinged = tmp_path / "hinged.toml"
    hinged.write_text(HINGED)
    line = ["loci", "--si", str(hinged), "--plane", "both", "--over", "rad/s", "--per-rev", "2"]
    text = run(*line, "--start", "0", "--stop", "40", "--points", "5", "--margins", str(file))[1]
    assert re.search(r"F1 .* on it", text)
    assert pandas.read_csv(file)["on_lines"].tolist()[1] == 1


def test_measured_frequencies_in_the_plot(run, tmp_path):
    """As points with error bars, over the number at which they were measured; those at another
    mass belong to another chart."""
    file, chart = tmp_path / "measured.csv", tmp_path / "chart.svg"
    rows = "gamma,alpha,frequency,error\n0,0,3.4,0.1\n5,0,4.2,0.1\n5,1,2,0.1\n"
    file.write_text(rows)
    line = ["loci", "--over", "gamma", "--start", "0", "--stop", "8", "--points", "9"]
    measured = ["--measured", str(file)]
    assert run(*line, "--plot", str(chart), *measured)[0] == 0
    assert 'id="measured"' in chart.read_text()
    axes = Figure().subplots()
    loci(Beam(), "gamma", [0, 4, 8]).plot(axes, measured=file)
    points = next(each for each in axes.lines if each.get_gid() == "measured")
    assert points.get_xydata().tolist() == [[0, 3.4], [5, 4.2]]
    code, _, err = run(*line, *measured)
    assert (code, "--plot" in err) == (2, True)
    code, _, err = run(*line, "--alpha", "2", "--plot", str(chart), *measured)
    assert (code, "no frequency is at the numbers" in err) == (2, True)


def test_a_scene_and_bands_in_the_plot(run, tmp_path):
    """The beam, the model and the measured frequencies are those of the scene, and are left out of
    a chart that has none of their values; the band of each line is shaded."""
    scene, chart = tmp_path / "scene.toml", tmp_path / "chart.svg"
    table = {"gamma": [0, 5], "frequency": [3.4, 4.2]}
    scene.write_text(replace(Scene.of(alpha=1, coriolis=True), measured=table).to_toml())
    given, bands = ["--scene", str(scene)], ["--clear", "1,2", "--between", "2:6"]
    line, plot = [*SWEEP[:6], "8", "--points", "9", "--format", "json"], ["--plot", str(chart)]
    code, out, err = run(*line, *given, *bands, "--margin", "5%", *plot)
    assert (code, err) == (0, "")
    plain = run(*line, "--alpha", "1", "--coriolis")[1]
    assert strict(out)["branches"] == strict(plain)["branches"]
    svg = chart.read_text()
    assert all(f'id="{name}"' in svg for name in ("measured", "band 1", "band 2"))
    over_alpha = ["loci", "--over", "alpha", "--start", "2", "--stop", "3", "--points", "3", *plot]
    assert run(*over_alpha, *given)[0] == 0
    assert 'id="measured"' not in chart.read_text()
    code, _, err = run(*over_alpha, *bands)
    assert (code, "--clear needs loci over gamma" in err) == (2, True)
    code, _, err = run(*line, *bands)
    assert (code, "--clear 1,2: is drawn in a chart" in err) == (2, True)
