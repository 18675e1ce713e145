"""sweep() and `beamviz sweep`: the numbers of solve(), labelled, in a store that can be resumed."""

import json
import shutil

import numpy as np
import pytest
from helpers import contents

from beamviz import Beam, InvalidInput, NoEquilibrium, __version__, solve_many, sweep
from beamviz.beam import Units

STATUS = ("not computed", "solved", "unstable", "no equilibrium", "not converged")
FAMILIES = ("bending", "stretching", "mixed")
SPEEDS, MASSES, BUCKLING = np.linspace(0, 40, 161), np.linspace(0, 3, 61), np.linspace(0, 8, 81)
CORIOLIS = {"coriolis": True}
SWEEPS = {  # axes, fixed numbers, options; with lines long enough to be interpolated
    "speed": ({"gamma": SPEEDS, "alpha": [0, 1, 4], "beta": [0.3, 1]}, {}, {}),
    "all five": (
        {"gamma": [0, 9], "alpha": MASSES, "beta": [0.5], "delta": [0, 1.0], "mu": [50, 70]},
        *({}, {"modes": 3}),
    ),
    "position": ({"beta": np.linspace(0, 1, 121)}, {"alpha": 1, "gamma": 8}, {}),
    "slenderness": ({"mu": np.geomspace(20, 2000, 121)}, {"gamma": 3, "alpha": 1}, {}),
    "Coriolis": ({"gamma": SPEEDS, "delta": [0, 0.5]}, {"alpha": 1}, {**CORIOLIS, "modes": 4}),
    "Coriolis at rest": ({"alpha": MASSES}, {}, CORIOLIS),
    "limits": ({"gamma": SPEEDS, "delta": [0, 1]}, {}, {"strain": "hencky"}),
    "limits across": ({"delta": np.linspace(0, 2, 61)}, {"gamma": 40}, {"strain": "hencky"}),
    "inward": ({"gamma": BUCKLING}, {"delta": -1}, {"plane": "flapwise"}),
    "buckling": ({"gamma": BUCKLING, "alpha": [0, 1]}, {"delta": -1}, {}),
    "rigid tension": ({"gamma": SPEEDS}, {}, {"method": "zoac"}),
    "the paper's elements": ({"gamma": SPEEDS[:4]}, {}, {"method": "ancf", "modes": 2}),
    "bent": ({"gamma": [2, 4]}, {"delta": -1}, {"state": "stable"}),
    "spin-up": ({"spin_up": [0, 10.0]}, {"gamma": 5}, {"state": "stable"}),
}


@pytest.mark.parametrize("name", SWEEPS)
def test_numbers_are_those_of_solve(name):
    """At random places: status, limit, families; frequencies and errors within their bounds."""
    axes, fixed, options = SWEEPS[name]
    data = sweep(axes, None, beam=Beam(**fixed), workers=1, **options)
    assert data["frequency"].dims == (*axes, "mode")
    assert data["status"].min() > 0
    chance = np.random.default_rng(1)
    for _ in range(25):
        place = {key: float(chance.choice(values)) for key, values in axes.items()}
        found = data.sel(place)
        (exact,) = solve_many([Beam(**{**fixed, **place})], **options)
        if isinstance(exact, NoEquilibrium):
            assert STATUS[int(found["status"])] == "no equilibrium"
            assert float(found["limit"]) == pytest.approx(exact.limit, rel=1e-5)
            assert np.isnan(found["frequency"]).all()
            continue
        status = "solved" if exact.equilibrium.status == "stable" else "unstable"
        assert STATUS[int(found["status"])] == status
        assert [FAMILIES[k] for k in found["family"].values] == list(exact.families)
        allowed = found["error"].values + exact.errors
        assert (np.isnan(found["frequency"].values) == np.isnan(exact.frequencies)).all()
        here = ~np.isnan(exact.frequencies)
        assert (abs(found["frequency"].values - exact.frequencies) <= allowed)[here].all()
        assert (abs(found["growth_rate"].values - exact.growth_rates) <= allowed).all()
        if options.get("method") != "ancf":
            size = np.fmax(found["frequency"].values, found["growth_rate"].values)
            assert (found["error"].values <= 2e-6 * size + 10 * exact.errors).all()


@pytest.mark.parametrize(
    ("numbers", "values", "options"),
    [
        ({"alpha": 1}, np.linspace(20, 200, 121), {}),
        ({"gamma": 5}, np.linspace(36.4705, 300, 100), {"plane": "flapwise", "method": "foac"}),
    ],
)
def test_modes_that_are_among_the_lowest_at_some_values_only(numbers, values, options):
    """They are neither missed (S2) nor less accurate than asked for (B5)."""
    beam = Beam(**numbers)
    found = sweep({"mu": values}, None, beam=beam, workers=1, **options)
    exact = [
        one.frequencies for one in solve_many([beam.replace(mu=mu) for mu in values], **options)
    ]
    np.testing.assert_allclose(found["frequency"], exact, rtol=2e-6)
    assert (found["error"] <= 1.01e-6 * found["frequency"]).all()


def test_the_dataset_is_labelled(tmp_path):
    """Dimensions, units, codes with their meaning, arguments and version; read by xarray alone."""
    import xarray

    store = tmp_path / "a.zarr"
    made = sweep({"gamma": [0, 5, 10], "alpha": [0, 1]}, store, 4, beam=Beam(mu=100), workers=1)
    read = xarray.open_zarr(store, consolidated=False)
    assert dict(read.sizes) == {"gamma": 3, "alpha": 2, "mode": 4}
    assert read.identical(made.load())
    assert read["mode"].values.tolist() == [1, 2, 3, 4]
    assert {read[name].units for name in ("frequency", "error", "growth_rate")} == {"1/T*"}
    assert "rotation speed" in read["gamma"].long_name
    meanings = read["status"].flag_meanings.split()
    assert meanings == [status.replace(" ", "_") for status in STATUS]
    assert read["status"].flag_values == [0, 1, 2, 3, 4]
    assert read["family"].flag_meanings.split() == list(FAMILIES)
    assert read.attrs["beamviz_version"] == __version__
    assert (read.mu, read.beta, read.strain, read.coriolis) == (100.0, 1.0, "green", False)


@pytest.mark.parametrize(
    ("made", "arguments", "message"),
    [
        (True, {"modes": 4}, "modes = 3, not 4"),
        (True, {"coriolis": True}, "coriolis = False, not True"),
        (True, {"beam": Beam(mu=80)}, "mu = 70.0, not 80.0"),
        (True, {"beam": Beam(units=Units(2.0, 0.1))}, "unit_length_m = none, not 2.0"),
        (True, {"axes": {"gamma": [0, 5, 11]}}, r"values of gamma = 0, 5, 10, not 0, 5, 11"),
        (True, {"axes": {"gamma": [0, 5, 10], "alpha": [1]}}, "axes = gamma, not gamma, alpha"),
        (False, {"axes": {}}, "no axis"),
        (False, {"axes": {"speed": [1]}}, "axis 'speed': must be one of alpha"),
        (False, {"axes": {"gamma": [1, 0]}}, "values of gamma: must ascend, but 0 follows 1"),
        (False, {"axes": {"gamma": [0, 300]}}, r"gamma = 300: must lie in 0 \.\. 200"),
        (
            False,
            {"axes": {"gamma": [0, 150], "mu": [20, 70]}},
            "gamma / mu = 7.5: must be at most 5",
        ),
        (False, {"coriolois": True}, "did you mean 'coriolis'"),
        (False, {"worker": 2}, "did you mean 'workers'"),
        (False, {"method": "ancf", "elements": 2, "modes": 9}, "modes = 9: at most 4"),
        (False, {"out": "a.nc"}, r"a.nc: must end in .zarr"),
        (False, {"workers": 0}, r"workers = 0: must be a whole number"),
    ],
)
def test_wrong_arguments_make_and_change_no_store(made, arguments, message, tmp_path, monkeypatch):
    """The difference to the sweep of a store that is there, or the mistake in those of a new one,
    is named before anything is written."""
    monkeypatch.chdir(tmp_path)
    given = {"axes": {"gamma": [0, 5, 10]}, "out": "a.zarr", "modes": 3, "workers": 1}
    if made:
        sweep(**given)
    before = sorted(tmp_path.iterdir()), contents(tmp_path)
    with pytest.raises(InvalidInput, match=message):
        sweep(**{**given, **arguments})
    assert (sorted(tmp_path.iterdir()), contents(tmp_path)) == before


def test_numbers_of_a_file_are_no_options(tmp_path, steel, run):
    """An option that an axis replaces is noted; all numbers of a beam in SI are in its file."""
    axis, speeds = ["--over", "spin_up=0,1", "--state", "stable"], ["--over", "gamma=0,1"]
    _, _, err = run("sweep", str(tmp_path / "a.zarr"), *axis, "--spin-up", "3", "--workers", "1")
    assert err.startswith("beamviz: --spin-up 3 is not used: --over spin_up varies it\n")
    _, _, err = run("sweep", str(tmp_path / "b.zarr"), *speeds, "--si", steel, "--workers", "1")
    assert "is not used" not in err


def test_a_store_is_made_anew(tmp_path):
    """Deleted, its name is free for another sweep of the same process."""
    for speeds in ([0, 1], [0, 1, 2]):
        made = sweep({"gamma": speeds}, tmp_path / "a.zarr", workers=1).load()
        assert made["status"].values.tolist() == [1] * len(speeds)
        shutil.rmtree(tmp_path / "a.zarr")


def test_a_store_of_another_version_is_named(tmp_path, run):
    """One that lacks an option of this version; or an array."""
    store = tmp_path / "a.zarr"
    sweep({"gamma": [0, 1]}, store, workers=1)
    metadata = json.loads((store / "zarr.json").read_text())
    del metadata["attributes"]["softening"]
    metadata["attributes"]["beamviz_version"] = "0.0.1"
    (store / "zarr.json").write_text(json.dumps(metadata))
    code, _, err = run("loci", "--sweep", str(store), "--over", "gamma")
    assert code == 2
    assert f"'softening' is missing: damaged, or of beamviz 0.0.1, and this is {__version__}" in err
    damaged = tmp_path / "b.zarr"
    sweep({"gamma": [0, 1], "mu": [50, 70]}, damaged, workers=1)
    shutil.rmtree(damaged / "frequency")
    code, _, err = run("export", str(tmp_path / "a.png"), "--sweep", str(damaged))
    assert (code, "'frequency' is missing: damaged" in err) == (2, True)


def test_a_damaged_chunk_is_named(tmp_path, run):
    """In one line with the remedy, by all that reads it."""
    store, picture = tmp_path / "a.zarr", tmp_path / "a.png"
    again = ["sweep", str(store), "--workers", "1", "--over", "gamma=0,1", "--over", "mu=50,70"]
    commands = again, ["export", str(picture), "--sweep", str(store)]
    assert [run(*command)[0] for command in commands] == [0, 0]
    assert picture.stat().st_size > 10_000  # without --over, the map over both axes
    for name in ("frequency", "status"):
        for chunk in (store / name / "c").rglob("0"):
            if chunk.is_file():
                chunk.write_bytes(chunk.read_bytes()[:-4])
    for command in commands:
        code, _, err = run(*command)
        assert (code, err.count("\n")) == (1, 1)
        assert "a chunk of it is damaged: delete the store and run the sweep again" in err


def test_a_store_of_something_else_is_refused(tmp_path):
    """Nothing in it is touched."""
    store = tmp_path / "a.zarr"
    store.mkdir()
    (store / "zarr.json").write_text(json.dumps({"zarr_format": 3, "node_type": "group"}))
    before = contents(store)
    with pytest.raises(InvalidInput, match="no sweep"):
        sweep({"gamma": [0, 1]}, store, workers=1)
    assert contents(store) == before
