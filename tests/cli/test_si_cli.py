"""Beams in SI on the command line: files, warnings, and values in rpm, kg and mm."""

import csv
import io
import re

import numpy as np
import pytest
from helpers import slow, strict
from matplotlib.figure import Figure

from beamviz import Beam, Ramp, loci, motion, solve
from beamviz.errors import InvalidInput
from beamviz.plotting.motion import draw_motion
from beamviz.sweeps import sweep

UNIFORM = """\
length = 2.0
mass_per_length = 3.14
bending_stiffness = 2520.0
axial_stiffness = 8.4e7
hub_radius = 0.25
rotation_rpm = 300
"""
STATIONS = "station,mass_per_length,bending_stiffness,axial_stiffness\n0,2,900,4e7\n1.5,2,900,4e7\n"


@pytest.fixture
def uniform(tmp_path) -> str:
    """A file of a uniform beam by its stiffnesses."""
    file = tmp_path / "uniform.toml"
    file.write_text(UNIFORM)
    return str(file)


def test_a_file_of_stations_alone_leaves_the_other_numbers_to_options(run, tmp_path):
    """All but mu, which it gives. The stations of a uniform beam make one."""
    file = tmp_path / "blade.csv"
    file.write_text(STATIONS)
    code, out, err = run("modes", "--si", str(file), "--gamma", "3", "--format", "json")
    data = strict(out)
    assert (code, err) == (0, "")
    assert data["beam"] == Beam.from_file(file, rotation_speed=0).replace(gamma=3).numbers
    assert data["units"]["length"] == 1.5
    code, _, err = run("modes", "--si", str(file), "--mu", "70")
    assert (code, "--mu 70" in err, "the file gives mu" in err) == (2, True, True)


def test_a_likely_mistake_is_a_line_on_stderr(run, tmp_path):
    """The answer is there all the same. Where there is none the error says it."""
    file = tmp_path / "steel.toml"
    file.write_text(UNIFORM.replace("rotation_rpm", "rotation_speed"))
    code, out, err = run("modes", "--si", str(file), "--modes", "1", "--format", "json")
    assert code == 0
    assert strict(out)["modes"][0]["label"] == "B1"
    assert err.startswith("beamviz: warning: speed of the tip = 675 m/s")
    assert err.count("\n") == 1
    file.write_text(UNIFORM.replace("length = 2.0", "length = 2000"))
    code, _, err = run("modes", "--si", str(file))
    assert code == 2
    assert "a length in mm, not m?" in err


@pytest.mark.parametrize(
    ("over", "number", "start", "stop", "key"),
    [
        ("rpm", "gamma", 0, 600, "rpm"),
        ("rad/s", "gamma", 0, 60, "rpm"),
        ("gamma:rpm", "gamma", 0, 600, "rpm"),
        ("kg", "alpha", 0, 3, "kg"),
        ("beta:mm", "beta", 500, 2000, "mm"),
        ("delta:m", "delta", 0, 1.5, "mm"),
        *slow(("rad/s^2", "spin_up", 0, 30, "rad_per_s2")),
    ],
)
def test_loci_over_a_unit(run, uniform, over, number, start, stop, key):
    """The numbers are the values over their unit, the loci those over them; JSON and CSV have both,
    and so does Python. Frequencies are in Hz, too."""
    state = "stable" if number == "spin_up" else "straight"
    beam, values = Beam.from_toml(uniform), np.linspace(start, stop, 3)
    units = beam.units
    sizes = {"gamma": units.rpm(1), "alpha": units.mass, "spin_up": units.time**-2}
    shown = values * {"rad/s": 30 / np.pi, "delta:m": 1000}.get(over, 1)
    numbers = shown / sizes.get(number, 1000 * units.length)
    line = ["loci", "--si", uniform, "--over", over, "--start", str(start), "--stop", str(stop)]
    line += ["--points", "3", "--modes", "2", "--state", state, "--format"]
    data = strict(run(*line, "json")[1])
    assert data["over"] == number
    assert data["values"] == pytest.approx(numbers.tolist(), rel=1e-12)
    assert data[key] == pytest.approx(shown.tolist(), rel=1e-12)
    rows = list(csv.DictReader(io.StringIO(run(*line, "csv")[1])))
    assert [float(row[key]) for row in rows] == data[key]
    for row in rows:
        assert float(row["B1_hertz"]) == pytest.approx(float(row["B1"]) / (2 * np.pi * units.time))
    found = loci(beam, over, values, 2, state=state)
    for branch, record in zip(found.branches, data["branches"], strict=True):
        assert record["frequency"] == branch.frequency.tolist()
        assert record["hertz"] == units.hertz(branch.frequency).tolist()
    assert found.values == pytest.approx(numbers, rel=1e-12)


def test_the_limit_of_a_number_in_a_unit(run, uniform, tmp_path):
    """The place of a mass at the tip of a beam of 2.01 m is 2010 mm, though 1000 * 2.01 is less."""
    assert 1000 * 2.01 < 2010
    file = tmp_path / "longer.toml"
    file.write_text(UNIFORM.replace("length = 2.0", "length = 2.01"))
    beam, values = Beam.from_toml(file).replace(alpha=1), [0, 2010]
    assert loci(beam, "beta:mm", values, 1).values.tolist() == [0, 1]
    assert sweep({"beta:mm": values}, None, 1, beam=beam, workers=1)["beta"].values[-1] == 1
    line = "loci --over beta:mm --start 0 --stop 2010 --points 2 --modes 1 --format json --si"
    assert strict(run(*line.split(), str(file))[1])["values"] == [0, 1]
    with pytest.raises(InvalidInput, match="beta = 1"):
        loci(beam, "beta:mm", [0, 2010.001], 1)


def test_a_resonance_is_in_rpm_and_hertz(run, uniform):
    """At a resonance with every revolution, Hz are rpm over 60."""
    line = ["loci", "--si", uniform, "--over", "rpm", "--start", "0", "--stop", "900"]
    data = strict(run(*line, "--points", "3", "--per-rev", "1", "--format", "json")[1])
    events = [event for event in data["events"] if event["per_rev"] == 1]
    assert events
    for event in events:
        assert event["hertz"] == pytest.approx(event["rpm"] / 60, rel=1e-9)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("loci --over rpm --start 0 --stop 9", "over rpm: the size of the beam is not known"),
        ("loci --si FILE --over m --start 0 --stop 9", "'m' is not one of"),
        (
            "loci --si FILE --over kg --start 0 --stop 1e4",
            "--stop: kg = 10000: must lie in 0",
        ),
        ("loci --si FILE --over kg --start 0 --stop 1 --per-rev 1", "need loci over gamma"),
        ("sweep a.zarr --over rpm=0:9:3", "over rpm: the size of the beam is not known"),
        ("sweep a.zarr --over rpm=0,9", "over rpm: the size of the beam is not known"),
        (
            "sweep a.zarr --si FILE --over beta:mm=0:9999:3",
            "--over beta:mm=0:9999:3: stop: beta",
        ),
    ],
)
def test_a_wrong_unit_is_named(run, uniform, line, words):
    code, _, err = run(*line.replace("FILE", uniform).split())
    assert code == 2
    assert words in err


def test_a_sweep_over_units_is_one_over_the_numbers(run, uniform, tmp_path, monkeypatch):
    """On the command line and in Python; the store has the size of the beam."""
    monkeypatch.chdir(tmp_path)
    line = "sweep a.zarr --si FILE --over rpm=0:600:3 --over beta:mm=500,1000 --workers 1"
    code, out, _ = run(*line.replace("FILE", uniform).split())
    assert (code, out) == (0, "6 solved\n")
    beam = Beam.from_toml(uniform)
    axes = {"rpm": [0, 300, 600], "beta:mm": [500, 1000]}
    made = sweep(axes, "a.zarr", beam=beam)  # the same: nothing is left to do
    assert made["gamma"].values == pytest.approx([0, beam.gamma, 2 * beam.gamma], rel=1e-12)
    assert made["beta"].values.tolist() == [0.25, 0.5]
    assert made.attrs["unit_mass_kg"] == beam.units.mass
    line = "loci --sweep a.zarr --over rpm --at beta:mm=500 --format json"
    data = strict(run(*line.split())[1])
    assert data["beam"]["beta"] == 0.25
    assert data["rpm"] == pytest.approx([0, 300, 600], rel=1e-12)
    line = "export a.png --sweep a.zarr --over rpm,beta --mode 1"
    assert run(*line.split()) == (0, "", "")
    code, _, err = run("loci", "--sweep", "a.zarr", "--over", "rpm", "--at", "beta:mm=501")
    assert (code, "the nearest is 0.25" in err) == (2, True)


def test_a_motion_is_in_si(run, uniform, tmp_path):
    """Seconds, rpm, metres and joules beside the dimensionless columns, in CSV, JSON and NPZ."""
    units = Beam.from_toml(uniform).units
    line = ["motion", "--si", uniform, "--until", "0.2", "--release", "0.1", "--points", "3"]
    rows = list(csv.DictReader(io.StringIO(run(*line, "--format", "csv")[1])))
    data = strict(run(*line, "--format", "json")[1])
    assert run(*line, str(tmp_path / "a.npz"))[0] == 0
    arrays = np.load(tmp_path / "a.npz")
    scales = {
        "seconds": ("t", units.time),
        "rpm": ("gamma", units.rpm(1)),
        "tip_y_m": ("tip_y", units.length),
        "energy_J": ("energy", units.force * units.length),
    }
    for name, (plain, scale) in scales.items():
        expected = [float(row[plain]) * scale for row in rows]
        assert [float(row[name]) for row in rows] == pytest.approx(expected, rel=1e-12)
        assert data["si"][name] == pytest.approx(expected, rel=1e-12)
        assert arrays[name].tolist() == pytest.approx(expected, rel=1e-12)


LONG = """\
length = 61.5
mass_per_length = 300
bending_stiffness = 5e9
axial_stiffness = 1e10
rotation_rpm = 12
mass = 1000
"""


def test_places_along_a_long_beam_are_in_metres(run, tmp_path):
    """In the files and on the axes of a beam of 61.5 m, as on the page; nowhere in mm."""
    file = tmp_path / "long.toml"
    file.write_text(LONG)
    beam = Beam.from_toml(file)
    line = f"loci --si {file} --over beta --start 0.5 --stop 1 --points 3 --modes 1 --format"
    rows = [*csv.DictReader(io.StringIO(run(*line.split(), "csv")[1]))]
    assert "mm" not in rows[0]
    assert [float(row["m"]) for row in rows] == pytest.approx([30.75, 46.125, 61.5])
    assert strict(run(*line.split(), "json")[1])["m"] == pytest.approx([30.75, 46.125, 61.5])
    for over, label in {"beta": "position of the mass [m]", "delta": "hub radius [m]"}.items():
        axes = loci(beam, over, [0.5, 1], 1).plot(Figure().subplots())
        assert axes.get_xlabel() == label
    moved = motion(beam, 0.1, release=0.1, points=3, tolerance=1e-3)
    figure = draw_motion(moved.t, moved.tip[:, 1], moved.gamma, moved.spectrum(), beam.units)
    assert figure.axes[0].get_ylabel() == "deflection of the tip [m]"
    drawn = figure.axes[0].lines[0].get_ydata()
    assert drawn == pytest.approx(61.5 * moved.tip[:, 1])


def test_tables_are_in_si(run, uniform):
    """Frequencies in Hz along a sweep in rpm; a motion in seconds, rpm, metres and joules."""
    units = Beam.from_toml(uniform).units
    assert units is not None
    code, sweep, _ = run(
        "loci", "--si", uniform, "--over", "rpm", "--start", "0", "--stop", "300", "--points", "3"
    )
    assert code == 0
    lines = sweep[sweep.index("Frequencies [Hz]") :].splitlines()
    assert lines[1].split()[:3] == ["gamma", "[rpm]", "B1"]
    still = solve(Beam.from_toml(uniform).replace(gamma=0.0)).frequencies[0]
    assert float(lines[2].split()[2]) == pytest.approx(units.hertz(still), abs=1e-5)

    options = ("motion", "--si", uniform, "--until", "0.2s", "--ramp-to", "120rpm")
    code, moved, _ = run(*options, "--within", "0.1s")
    assert code == 0
    header = next(line for line in moved.splitlines() if line.startswith("t [s]"))
    assert re.split(" {2,}", header.strip()) == [
        "t [s]", "speed [rpm]", "tip x [m]", "tip y [m]", "energy [J]",
    ]  # fmt: skip
    last = [line for line in moved.splitlines() if line.strip().startswith("0.2 ")][-1].split()
    assert float(last[1]) == pytest.approx(120)
    moved_tip = csv.DictReader(io.StringIO(run(*options, "--within", "0.1s", "--format", "csv")[1]))
    assert float(last[2]) == pytest.approx(float([*moved_tip][-1]["tip_x_m"]), abs=1e-4)


def test_charts_are_in_si(uniform):
    """The axes of loci over each number, of a motion, and the legend of shapes; nothing of T*."""
    beam = Beam.from_toml(uniform)
    labels = {"kg": "mass [kg]", "rpm": "rotation speed [rpm]", "delta:m": "hub radius [mm]"}
    for over, label in labels.items():
        axes = loci(beam, over, [0, 1], 2).plot(Figure().subplots())
        assert (axes.get_xlabel(), axes.get_ylabel()) == (label, "frequency [Hz]")
    shapes = solve(beam).plot(Figure().subplots())
    hertz = beam.units.hertz(solve(beam).frequencies[0])
    assert shapes.get_legend().get_texts()[0].get_text() == f"B1  {hertz:.5g} Hz"
    moved = motion(beam, 0.2, speed=Ramp(to=4, within=0.1, start=beam.gamma), points=3)
    figure = draw_motion(moved.t, moved.tip[:, 1], moved.gamma, moved.spectrum(), beam.units)
    texts = {text for ax in figure.axes for text in (ax.get_xlabel(), ax.get_ylabel())}
    assert texts >= {"time t [s]", "deflection of the tip [mm]", "frequency [Hz]"}
    assert not [text for text in texts if "T*" in text]
    assert figure.axes[0].get_xlim()[1] == pytest.approx(0.2 * beam.units.time)


def test_quantities_of_a_motion_may_have_units(run, uniform):
    """Seconds, rpm and newtons by suffix are what the dimensionless numbers say."""
    units = Beam.from_toml(uniform).units
    gamma = 600 * 2 * np.pi / 60 * units.time
    plain = {
        "--until": ("20ms", 0.02 / units.time),
        "--ramp-to": ("600rpm", gamma),
        "--within": ("0.01s", 0.01 / units.time),
        "--release": ("50N", 50 / units.force),
    }
    tips = []
    for k in range(2):
        words = [word for name, pair in plain.items() for word in (name, str(pair[k]))]
        line = ["motion", "--si", uniform, "--points", "3", "--format", "json", *words]
        tips.append(strict(run(*line)[1])["tip"])
    assert np.array(tips[0]) == pytest.approx(np.array(tips[1]), abs=1e-10)


@pytest.mark.parametrize(
    ("in_si", "words", "said"),
    [
        (True, ("--until", "2rpm"), "a time is in s, ms, min"),
        (True, ("--until", "1", "--release", "3kg"), "a force is in N, kN, MN"),
        (False, ("--until", "2s"), "--si"),
    ],
)
def test_a_unit_of_another_kind_is_named(run, uniform, in_si, words, said):
    code, _, err = run("motion", *(["--si", uniform] if in_si else []), *words)
    assert (code, said in err) == (2, True)
