"""`beamviz adjust` and `beamviz modes --sensitivities`."""

import csv
import io
from dataclasses import replace

import pytest
from helpers import strict

from beamviz import Beam, adjust, solve
from beamviz.measured import columns_of_file
from beamviz.scene import Scene

CLEAR = ["adjust", "--alpha", "1", "--free", "beta=0.4:0.6", "--clear", "1,2", "--between", "1.5:3"]


@pytest.fixture
def measured(tmp_path):
    """A file of two frequencies of a beam with a mass of 0.8 at 0.63."""
    file = tmp_path / "measured.csv"
    B1, B2 = solve(Beam(alpha=0.8, beta=0.63, gamma=2), 2, tolerance=1e-10).frequencies
    file.write_text(f"gamma,mode,frequency\n2,B1,{B1}\n2,B2,{B2}\n")
    return file


def test_sensitivities(run):
    """The same in the table, JSON and CSV."""
    arguments = ["modes", "--alpha", "1", "--gamma", "3", "--modes", "2", "--sensitivities"]
    rates = solve(Beam(alpha=1, gamma=3), 2).sensitivities
    code, out, err = run(*arguments)
    assert (code, err) == (0, "")
    assert f"{rates['alpha'][1]:.5g}" in out
    modes = strict(run(*arguments, "--format", "json")[1])["modes"]
    assert modes[1]["sensitivities"] == {
        name: pytest.approx(each[1], rel=1e-6, abs=1e-9) for name, each in rates.items()
    }
    rows = list(csv.DictReader(io.StringIO(run(*arguments, "--format", "csv")[1])))
    assert float(rows[1]["d_alpha"]) == pytest.approx(rates["alpha"][1])
    assert "sensitivities" not in strict(run("modes", "--format", "json")[1])["modes"][0]


def test_sensitivities_in_si(run):
    """Hz per kg, as 1 % more of the mass shows."""
    arguments = ["modes", "--si", "assets/beam.toml", "--sensitivities", "--format", "json"]
    modes = strict(run(*arguments)[1])["modes"]
    beam = Beam.from_toml("assets/beam.toml")
    hertz = [
        beam.units.hertz(solve(beam.replace(alpha=share * beam.alpha)).frequencies[0])
        for share in (0.99, 1.01)
    ]
    expected = (hertz[1] - hertz[0]) / (0.02 * beam.alpha * beam.units.mass)
    rates = modes[0]["sensitivities_hertz"]
    assert rates["kg"] == pytest.approx(expected, rel=1e-3)
    assert rates.keys() == {"kg", "beta:mm", "rpm", "delta:mm"}
    assert "[Hz] with each number in its unit" in run(*arguments[:-2])[1]


def test_a_fit(run, measured):
    """Of a file: the numbers of Python's answer, as a table and as JSON."""
    arguments = ["adjust", "--free", "alpha", "--free", "beta=0.3:1", "--measured", str(measured)]
    code, out, err = run(*arguments)
    assert (code, err) == (0, "")
    assert "fits measured frequencies" in out
    data = strict(run(*arguments, "--format", "json")[1])
    answer = adjust(Beam(), {"alpha": None, "beta": (0.3, 1)}, measured=measured)
    assert data["free"] == answer.free == pytest.approx({"alpha": 0.8, "beta": 0.63}, rel=1e-5)
    assert data["beam"] == answer.beam.record
    assert data["bounds"]["beta"] == [0.3, 1.0]
    assert [match["mode"] for match in data["matches"]] == ["B1", "B2"]
    assert data["sensitivities"].keys() == answer.sensitivities.keys()
    assert (data["goal"], data["undetermined"], data["margin"]) == ("measured", [], None)


@pytest.fixture
def scene(measured, tmp_path):
    """A file of a scene with these frequencies, and Coriolis forces."""
    file, begun = tmp_path / "scene.toml", Scene.of(gamma=2, coriolis=True)
    file.write_text(replace(begun, measured=columns_of_file(measured)).to_toml())
    return file


def test_a_fit_of_a_scene_file(run, scene):
    """With its measured frequencies, its beam and its model, which other options override."""
    free = ["--free", "alpha", "--free", "beta=0.3:1", "--no-coriolis", "--format", "json"]
    code, out, err = run("adjust", "--scene", str(scene), *free)
    assert (code, err) == (0, "")
    assert strict(out)["free"] == pytest.approx({"alpha": 0.8, "beta": 0.63}, rel=1e-5)


@pytest.mark.slow
def test_a_scene_file_keeps_its_model(run, scene, measured):
    """Without another option; another goal goes before its measured frequencies."""
    free = ["--free", "alpha", "--free", "beta=0.3:1"]
    code, out, err = run("adjust", "--scene", str(scene), *free, "--format", "json")
    assert (code, err) == (0, "")
    beam = Beam(gamma=2)
    answer = adjust(beam, {"alpha": None, "beta": (0.3, 1)}, measured=measured, coriolis=True)
    assert strict(out)["free"] == answer.free
    goal = ["--free", "alpha", "--target", "B1=3"]
    assert "has target frequencies" in run("adjust", "--scene", str(scene), *goal)[1]
    code, _, err = run("adjust", "assets/beam.toml", "--scene", str(scene), *goal)
    assert (code, "exclude each other" in err) == (2, True)


def test_what_is_not_determined_is_told(run, tmp_path):
    file = tmp_path / "measured.csv"
    file.write_text("frequency\n3\n")
    out = run("adjust", "--free", "alpha", "--free", "beta", "--measured", str(file))[1]
    assert "do not determine alpha, beta" in out
    assert "Another fit" in out


def test_targets(run):
    code, out, _ = run("adjust", "--alpha", "1", "--free", "beta", "--target", "B1=3")
    assert (code, "has target frequencies" in out) == (0, True)
    code, _, err = run("adjust", "--alpha", "1", "--free", "beta", "--target", "B1=5")
    assert (code, "no beam in the bounds has these frequencies" in err) == (3, True)


def test_clear(run):
    """With exit code 3, the best margin and what holds it where no beam keeps it. One that can be
    kept is in test_units_on_the_command_line."""
    code, out, err = run(*CLEAR, "--margin", "10%", "--format", "json")
    error = strict(out)["error"]
    assert (code, error["kind"]) == (3, "no-answer")
    assert error["best"]["beta"] == pytest.approx(0.518, abs=1e-3)
    assert "held by B1 and the line 2 per revolution" in err


def test_units_on_the_command_line(run):
    arguments = ["adjust", "--si", "assets/beam.toml", "--free", "kg=0.1:5", "--clear", "1,2"]
    code, out, _ = run(*arguments, "--between", "200rpm:300rpm", "--margin", "0.05")
    assert code == 0
    assert "kg" in out
    assert "Least margin" in out
    goal = ["--free", "kg=0.1:5", "--target", "B1=9Hz"]
    by_option = run("adjust", "--si", "assets/beam.toml", *goal)
    assert run("adjust", "assets/beam.toml", *goal) == by_option
    assert by_option[0] == 0
    code, _, err = run("adjust", "assets/beam.toml", "--si", "assets/beam.toml", *goal)
    assert (code, "exclude each other" in err) == (2, True)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("--free beta", "no goal: give one of --measured, --target, --clear"),
        ("--free beta --clear 1", "--clear and --between belong together"),
        ("--free beta --clear 1,x --between 1:2", "must be whole numbers"),
        ("--free beta --clear 1 --between 1:2 --margin ten", "must be a share"),
        ("--free beta --clear 1 --between 2", "must be two speeds"),
        ("--free beta=1 --target B1=3", "must be NAME or NAME=LOW:HIGH"),
        ("--free beta --free beta --target B1=3", "--free beta: is given twice"),
        ("--free beta --target B1", "must be MODE=FREQUENCY"),
        ("--free beta --target B1=x", "target B1"),
        ("--free beta --target B²=22", "mode = 'B²': must be a label"),
        ("--free betta --target B1=3", "did you mean 'beta'"),
        ("--target B1=3", "--free"),
        ("--free beta --measured none.csv", "none.csv"),
    ],
)
def test_wrong_input(run, arguments, message):
    code, _, err = run("adjust", *arguments.split())
    assert code == 2
    assert message in err
