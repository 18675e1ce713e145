"""`beamviz loci`: tables, JSON, CSV and charts."""

import csv
import io
import math
from itertools import combinations

import numpy as np
import pytest
from helpers import slow, strict
from matplotlib.image import imread

from beamviz import Beam, Units, loci
from beamviz.plotting.loci import draw_chart

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
    header = run(*line, "csv")[1].splitlines()[0]
    assert header.startswith("gamma,rpm,B1,")
    assert ",B1_hertz," in header


def test_plot_of_loci(run, tmp_path):
    """A picture of its kind beside the data on stdout, with blue bending, vermilion stretching."""
    starts = {"svg": b"<?xml", "pdf": b"%PDF", "PNG": b"\x89PNG", "png": b"\x89PNG"}
    for ending, start in starts.items():
        file = tmp_path / f"loci.{ending}"
        code, out, err = run(*SWEEP, "--points", "21", "--plot", str(file), "--format", "csv")
        assert (code, err, out[:8]) == (0, "", "gamma,B1")
        assert file.read_bytes().startswith(start)
    picture = np.rint(255 * imread(file)[:, :, :3]).astype(int)
    for colour in ((0, 114, 178), (213, 94, 0)):
        assert (abs(picture - colour).max(axis=2) <= 2).sum() > 1000
    assert (picture == 255).all(axis=2).mean() > 0.8


IN_SI = Beam(alpha=1, units=Units(length=1.0, time=0.5))


@pytest.mark.parametrize(
    ("beam", "over", "stop", "options", "shown"),
    [
        (Beam(alpha=1), "gamma", 20, {}, ""),
        (Beam(alpha=1), "gamma", 20, {"coriolis": True}, "veering\nγ = 4.6502\ngap 0.241"),
        (IN_SI, "gamma", 20, {"coriolis": True}, "veering\n88.812 rpm\ngap 0.0767 Hz"),
        (Beam(delta=-1), "gamma", 10, {}, "unstable\nbeyond γ = 2.9960"),
        (Beam(), "gamma", 60, {"strain": "hencky"}, "no equilibrium\nbeyond γ = 45.420"),
        *slow(
            (Beam(), "gamma", 60, {"strain": "hencky", "modes": 6}, ""),
            (Beam(alpha=0.5, gamma=5), "beta", 1, {}, ""),
            (Beam(gamma=10), "alpha", 2, {"coriolis": True}, ""),
        ),
    ],
)
def test_labels_in_the_plot_do_not_overlap(beam, over, stop, options, shown):
    """No label on another, none outside the picture. Each event is marked, each limit is named in
    its range, and a veering is labelled with its gap."""
    per_rev = 3 if over == "gamma" else 0
    found = loci(beam, over, np.linspace(0, stop, 101), per_rev=per_rev, **options)
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
        (x,) = (x for text, x in places.items() if text.startswith(limit.kind.replace("-", " ")))
        assert limit.start < x < limit.stop
    assert shown in {"", *places}


@pytest.mark.parametrize("modes", [1, 2])
def test_a_plot_of_modes_that_do_not_vibrate(run, tmp_path, modes):
    """A buckled beam: its only mode has a growth rate and no frequency; with two one has."""
    chart = tmp_path / "chart.svg"
    line = ("loci", "--over", "gamma", "--delta=-1", "--start", "4", "--stop", "6", "--points", "5")
    code, _, err = run(*line, "--modes", str(modes), "--plot", chart)
    assert (code, err) == (0, "")
    assert "unstable" in chart.read_text()


def test_an_option_without_effect_is_noted(run):
    line, note = (*SWEEP, "--points", "3", "--format", "csv"), "--gamma 5 is not used: --over gamma"
    assert run(*line, "--gamma", "5") == (0, run(*line)[1], f"beamviz: {note} varies it\n")
