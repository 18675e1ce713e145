"""The record of a motion, its files and its command."""

import csv
import io
import pickle

import numpy as np
import pytest
from helpers import slow, strict
from matplotlib.figure import Figure
from PIL import Image

from beamviz import Beam, Hub, InvalidInput, Ramp, motion, solve
from beamviz.dynamics import result
from beamviz.exports import motion_scene
from beamviz.exports.motion_scene import MotionScene

BEAM = Beam(alpha=1, beta=0.5, gamma=3)
ARGUMENTS = ("--alpha", "1", "--beta", "0.5", "--gamma", "3", "--start", "B1:0.05", "--until", "1")


@pytest.fixture(scope="module")
def moved():
    return motion(BEAM, 1, start={"B1": 0.05}, points=41)


def test_shapes_of_its_arrays(moved):
    t, x = [0.0, 0.5, 1.0], np.linspace(0, 1, 5)
    assert moved.position(t, x).shape == (3, 5, 2)
    assert moved.stretch(t, x).shape == (3, 5)
    assert moved.position(t, [1.0])[:, 0] == pytest.approx(moved.tip[[0, 20, 40]], abs=1e-12)
    assert moved.position(t, [0.0]) == pytest.approx(0, abs=1e-15)
    assert not moved.tip.flags.writeable
    frequency, amplitude = moved.spectrum()
    assert frequency.shape == amplitude.shape


@pytest.mark.parametrize(("t", "x"), [([1.1], [0.5]), ([-0.1], [0.5]), ([0.5], [1.1])])
def test_outside_the_motion_is_an_error(moved, t, x):
    with pytest.raises(ValueError, match="must lie in"):
        moved.position(t, x)


def test_accuracy_does_not_depend_on_the_number_of_points(moved):
    few = motion(BEAM, 1, start={"B1": 0.05}, points=2)
    assert (few.error, few.stats.steps) == (moved.error, moved.stats.steps)


@pytest.mark.parametrize("since", [-0.1, 1.0, 1.1, float("nan"), "late"])
def test_a_spectrum_begins_within_the_motion(moved, since):
    with pytest.raises(InvalidInput, match="since"):
        moved.spectrum(since)


def test_a_long_motion_has_no_false_frequencies(monkeypatch):
    """A third mode alone, for so long that one block of samples would show it at a lower
    frequency: a block is short here, instead of the motion long."""
    monkeypatch.setattr(result, "BLOCK", 64)
    monkeypatch.setattr(result, "AT_ONCE", 64)
    beam = Beam(gamma=1)
    omega = solve(beam, coriolis=True).frequencies[2]
    moved = motion(beam, 10, start={"B3": 1e-4}, integrator="gauss", step=0.05)
    frequency, amplitude = moved.spectrum()
    assert frequency[amplitude.argmax()] == pytest.approx(omega, abs=frequency[1])


def test_hubs_are_compared_by_value():
    arrays = np.array([0.0, 1.0]), np.array([2.0, 3.0])
    assert Hub(1, arrays) == Hub(1.0, ([0, 1], [2, 3])) != Hub(1, ([0, 1], [2, 4]))
    assert len({Hub(1, 2), Hub(1, 2.0), Hub(1, ([0], [2]))}) == 1


def test_it_pickles(moved):
    again = pickle.loads(pickle.dumps(moved))
    assert again.tip.tolist() == moved.tip.tolist()
    assert again.position([0.3], [0.7]).tolist() == moved.position([0.3], [0.7]).tolist()


@pytest.mark.parametrize("speed", [None, Ramp(4, 0.5), ([0, 0.5], [3, 2]), Hub(1.0, 2.0)])
def test_every_drive_pickles_and_has_a_record(speed):
    done = motion(Beam(gamma=3), 0.5, speed=speed, points=5)
    again = pickle.loads(pickle.dumps(done))
    assert again.drive.record == done.drive.record
    assert again.gamma.tolist() == done.gamma.tolist()
    assert again.drive.described == done.drive.described
    assert any(digit in done.drive.described for digit in "1234")


def test_a_dataset(moved):
    data = moved.to_xarray()
    assert data["tip"].dims == ("t", "component")
    assert data["tip"].sel(component="across").values.tolist() == moved.tip[:, 1].tolist()
    assert data.attrs["error"] == moved.error
    assert data.attrs["alpha"] == 1


def test_one_line_a_table_and_a_drawing(moved):
    assert "\n" not in repr(moved)
    assert "<table>" in moved._repr_html_()
    axes = Figure().subplots()
    assert moved.plot(axes) is axes
    (line, _) = axes.lines
    assert line.get_ydata().tolist() == moved.tip[:, 1].tolist()


def test_the_angle_of_the_hub_is_the_integral_of_its_speed():
    ramps = Ramp(4, 0.3), Ramp(4, 0.3, "linear", start=1)
    for speed in (None, *ramps, ([0.1, 0.5], [3, 2]), ([-0.5, 0.5], [3, 2])):
        done = motion(Beam(gamma=3), 1, speed=speed, points=2001, tolerance=1e-3)
        steps = np.diff(done.t) * (done.gamma[1:] + done.gamma[:-1]) / 2
        assert done.angle == pytest.approx(np.append(0, np.cumsum(steps)), abs=1e-6)


def test_the_command_prints_what_python_computes(run, moved):
    code, out, err = run("motion", *ARGUMENTS, "--points", "41", "--format", "json")
    data = strict(out)
    assert (code, err) == (0, "")
    keys = {"beam", "model", "drive", "t", "gamma", "tip", "energy", "error", "stats"}
    assert data.keys() >= keys
    assert np.array(data["tip"]) == pytest.approx(moved.tip, abs=1e-12)
    assert data["beam"] == {"alpha": 1, "beta": 0.5, "gamma": 3, "delta": 0, "mu": 70}
    rows = list(csv.DictReader(io.StringIO(run("motion", *ARGUMENTS, "--format", "csv")[1])))
    assert len(rows) == 401
    assert float(rows[-1]["tip_y"]) == pytest.approx(moved.tip[-1, 1], abs=1e-9)
    assert "Drive" in run("motion", *ARGUMENTS)[1]


@pytest.mark.parametrize(
    ("arguments", "code", "kind"),
    [
        (("--until", "-1"), 2, "invalid-input"),
        (("--ramp-to", "5"), 2, "invalid-input"),
        (("--start", "B1"), 2, "invalid-input"),
        (("--start", "B1:0.1", "--start", "B1:0.2"), 2, "invalid-input"),
        (("--ramp", "linear"), 2, "invalid-input"),
        (("--within", "1"), 2, "invalid-input"),
        (("--release-at", "0.5"), 2, "invalid-input"),
        (("--plane", "flapwise"), 2, "invalid-input"),
        (("--no-coriolis",), 2, "invalid-input"),
        (("--gamma", "40", "--delta", "1", "--strain", "hencky"), 3, "no-equilibrium"),
        (("--release", "3", "--mu", "1000", "--step", "2"), 4, "not-converged"),
    ],
)
def test_failures_of_the_command(run, arguments, code, kind):
    found, out, err = run("motion", *arguments, "--format", "json")
    error = strict(out)["error"]
    assert (found, error["kind"]) == (code, kind)
    assert err.startswith("beamviz: ")
    assert "Traceback" not in err


@pytest.mark.parametrize("suffix", ["csv", "npz", "html", "svg", *slow("png", "pdf", "webp")])
def test_every_file(run, tmp_path, suffix, moved, monkeypatch):
    assert MotionScene(moved).seconds >= 3
    monkeypatch.setattr(motion_scene, "SECONDS", (0.6, 0.6))  # a film of 15 frames
    file = tmp_path / f"motion.{suffix}"
    code, out, _ = run("motion", str(file), *ARGUMENTS, "--points", "41")
    assert (code, out) == (0, "")
    if suffix == "npz":
        data = np.load(file)
        assert data["tip_y"] == pytest.approx(moved.tip[:, 1], abs=1e-12)
        assert data["positions"].shape == (41, 101, 2)
    elif suffix == "webp":
        with Image.open(file) as film:
            assert film.n_frames >= 15  # 25 frames per second
    else:
        assert file.stat().st_size > 1000


def test_a_file_of_another_kind_is_refused(run, tmp_path):
    code, _, err = run("motion", str(tmp_path / "motion.txt"), *ARGUMENTS)
    assert code == 2
    assert ".csv" in err


def test_a_place_that_cannot_be_written_is_told_before_the_motion_is_computed(run, tmp_path):
    """Of a beam that has no equilibrium, which would be exit code 3."""
    none = ("--gamma", "40", "--delta", "1", "--strain", "hencky")
    code, _, err = run("motion", str(tmp_path / "missing" / "a.csv"), *none)
    assert code == 1
    assert "missing" in err
