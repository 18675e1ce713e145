"""A blade through the command line and files: what is printed and stored of it."""

import json

import numpy as np
import pytest
from helpers import strict

from beamviz import Beam, export, loci, solve
from beamviz.presets import PRESETS, preset
from beamviz.scene import Scene
from beamviz.sweeps import open_line, sweep

FILE = """\
stations_file = "stations.csv"
hub_radius = 0.1
rotation_rpm = 1200
root_stiffness = 1e5
[[masses]]
mass = 0.2
position = 0.45
inertia = [1e-5, 2e-5, 2.5e-5]
"""
STATIONS = """\
station [m], mass_per_length, bending_stiffness, axial_stiffness
0, 3.768, 1209.6, 1.008e8
0.3, 2.826, 680.4, 7.56e7
0.3, 2.5, 500, 6.7e7
0.6, 1.884, 302.4, 5.04e7
"""


@pytest.fixture
def blade(tmp_path) -> str:
    """A file of a blade with a jump, a body and a root spring."""
    (tmp_path / "stations.csv").write_text(STATIONS)
    file = tmp_path / "blade.toml"
    file.write_text(FILE)
    return str(file)


def test_modes_of_a_blade_print_what_it_is(run, blade):
    """The JSON has the five numbers, blade, masses and root, and makes the same beam; the table
    says it in words."""
    beam = Beam.from_toml(blade)
    data = strict(run("modes", "--si", blade, "--format", "json")[1])
    assert data["beam"].keys() == {*beam.numbers, "blade", "masses", "root"}
    assert Beam.from_record(data["beam"], beam.units) == beam
    assert [mode["hertz"] for mode in data["modes"]] == solve(beam).columns["hertz"].tolist()
    code, out, err = run("modes", "--si", blade)
    assert (code, err) == (0, "")
    assert "a blade of 4 stations, 1 mass, root stiffness 49.6" in out


def test_results_of_a_blade_keep_it(run, blade, tmp_path):
    """As attributes of datasets, in JSON of loci, and in NPZ."""
    beam = Beam.from_toml(blade)
    attributes = solve(beam).to_xarray().attrs
    names = (*beam.numbers, "blade", "masses", "root")
    assert Beam.from_record({name: attributes[name] for name in names}, beam.units) == beam
    line = ["loci", "--si", blade, "--over", "rpm", "--start", "0", "--stop", "2400"]
    data = strict(run(*line, "--points", "3", "--format", "json")[1])
    assert Beam.from_record(data["beam"] | {"gamma": beam.gamma}, beam.units) == beam
    found = loci(beam, "rpm", [0, 1200, 2400])
    for branch, record in zip(found.branches, data["branches"], strict=True):
        assert record["frequency"] == pytest.approx(branch.frequency.tolist(), rel=1e-12)
    export(tmp_path / "a.npz", Scene(beam))
    arrays = np.load(tmp_path / "a.npz", allow_pickle=False)
    assert json.loads(str(arrays["structure"])) == {
        name: value for name, value in beam.record.items() if name not in beam.numbers
    }


def test_a_sweep_of_a_blade_is_resumed_and_read(blade, tmp_path):
    """Its store has the blade: the same arguments resume it, another blade is refused, a line of it
    is one of the blade."""
    beam, store = Beam.from_toml(blade), tmp_path / "a.zarr"
    axes = {"rpm": [0, 1200], "kg": [0, 1]}
    made = sweep(axes, store, 2, beam=beam, workers=1)
    assert sweep(axes, store, 2, beam=beam).identical(made)
    with pytest.raises(ValueError, match="was made with blade"):
        sweep(axes, store, 2, beam=beam.replace(blade=None))
    read, values, options = open_line(store, "gamma", {"alpha": 0.0})
    assert read.replace(gamma=beam.gamma, alpha=0.0) == beam
    assert values == pytest.approx([0, beam.gamma], rel=1e-12)
    found = made["frequency"].sel(alpha=0.0).values[1]
    assert found == pytest.approx(solve(beam, **options).frequencies, rel=1e-5)


def test_a_preset_is_named_in_place_of_a_file(run, blade, tmp_path, monkeypatch):
    """Unless there is a file of that name; other numbers beside it are refused by its name."""
    data = strict(run("modes", "--si", "nrel-5mw-blade", "--format", "json")[1])
    assert data["modes"][0]["hertz"] == solve(preset("nrel-5mw-blade").beam).columns["hertz"][0]
    code, _, err = run("modes", "--si", "nrel-5mw-blade", "--gamma", "0")
    assert code == 2
    assert "--si nrel-5mw-blade exclude each other" in err
    monkeypatch.chdir(tmp_path)
    (tmp_path / "nrel-5mw-blade").write_text(FILE)
    assert "a blade of 4 stations" in run("modes", "--si", "nrel-5mw-blade")[1]


def test_a_mistyped_preset_is_answered_with_the_names(run):
    """A name without a suffix may be meant as one."""
    code, _, err = run("modes", "--si", "nrel")
    assert code == 2
    assert f"neither a file nor one of {', '.join(PRESETS)}" in err
