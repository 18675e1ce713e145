"""sweep() and `beamviz sweep`: the numbers of solve(), labelled, in a store that can be resumed."""

import json
import shutil

import numpy as np
import pytest
from helpers import contents, slow

from beamviz import Beam, InvalidInput, NoEquilibrium, __version__, solve_many, sweep
from beamviz.units import Units

STATUS = (
    *("not computed", "solved", "divergence", "no equilibrium", "not converged"),
    *("flutter", "buckled chordwise"),
)
FAMILIES = ("bending", "stretching", "mixed")
SPEEDS, MASSES, BUCKLING = np.linspace(0, 40, 41), np.linspace(0, 3, 16), np.linspace(0, 8, 21)
CORIOLIS = {"coriolis": True}
SWEEPS = {  # axes, fixed numbers, options
    "speed": ({"gamma": SPEEDS, "alpha": [0, 1, 4], "beta": [0.3, 1]}, {}, {}),
    "all five": (
        {"gamma": [0, 9], "alpha": MASSES, "beta": [0.5], "delta": [0, 1.0], "mu": [50, 70]},
        *({}, {"modes": 3}),
    ),
    "position": ({"beta": np.linspace(0, 1, 31)}, {"alpha": 1, "gamma": 8}, {}),
    "slenderness": ({"mu": np.geomspace(20, 2000, 31)}, {"gamma": 3, "alpha": 1}, {}),
    "Coriolis": ({"gamma": SPEEDS, "delta": [0, 0.5]}, {"alpha": 1}, {**CORIOLIS, "modes": 4}),
    "Coriolis at rest": ({"alpha": MASSES}, {}, CORIOLIS),
    "limits": ({"gamma": SPEEDS, "delta": [0, 1]}, {}, {"strain": "hencky"}),
    "limits of few speeds": (
        {"delta": [0, 0.5, 1], "gamma": [5, 30, 45]},
        *({}, {"strain": "hencky"}),
    ),
    "limits across": ({"delta": np.linspace(0, 2, 7)}, {"gamma": 40}, {"strain": "hencky"}),
    "too near a limit": ({"gamma": [1, 45.4203]}, {}, {"strain": "hencky"}),
    "inward": ({"gamma": BUCKLING}, {"delta": -1}, {"plane": "flapwise"}),
    "buckling": ({"gamma": BUCKLING, "alpha": [0, 1]}, {"delta": -1}, {}),
    "rigid tension": ({"gamma": SPEEDS}, {}, {"method": "zoac"}),
    "the paper's elements": ({"gamma": SPEEDS[:4]}, {}, {"method": "ancf", "modes": 2}),
    "bent": ({"gamma": [2, 4]}, {"delta": -1}, {"state": "stable"}),
    "position across": ({"gamma": SPEEDS, "beta": [0.2, 0.5], "alpha": [0, 1]}, {}, {}),
    "flutter": (
        {"spin_up": [0, 50, 100, 200.0]},
        {"mu": 1e4},
        {"state": "stable", "coriolis": True},
    ),
    "spin-up": ({"spin_up": [0, 10.0]}, {"gamma": 5}, {"state": "stable"}),
}


def expected_status(equilibrium):
    """The meaning of the status of a beam that has been solved."""
    if equilibrium.status == "stable":
        return "buckled chordwise" if equilibrium.buckled_chordwise else "solved"
    return {"unstable": "divergence", "growing": "flutter"}[equilibrium.status]


OFTEN = (
    *("speed", "all five", "position", "Coriolis", "limits", "limits across", "buckling"),
    *("the paper's elements", "bent", "inward"),
)


@pytest.mark.parametrize("name", [*OFTEN, *slow(*(name for name in SWEEPS if name not in OFTEN))])
def test_numbers_are_those_of_solve(name):
    """At random places: status, limit, families; frequencies and errors within their bounds."""
    axes, fixed, options = SWEEPS[name]
    data = sweep(axes, None, beam=Beam(**fixed), workers=1, **options)
    assert data["frequency"].dims == (*axes, "mode")
    assert data["status"].min() > 0
    chance = np.random.default_rng(1)
    for _ in range(5):
        place = {key: float(chance.choice(values)) for key, values in axes.items()}
        found = data.sel(place)
        (alone,) = solve_many([Beam(**{**fixed, **place})], **options)
        if isinstance(alone, NoEquilibrium):
            assert STATUS[int(found["status"])] == "no equilibrium"
            assert float(found["limit"]) == pytest.approx(alone.limit, rel=1e-5)
            assert np.isnan(found["frequency"]).all()
            continue
        assert STATUS[int(found["status"])] == expected_status(alone.equilibrium)
        assert [FAMILIES[k] for k in found["family"].values] == list(alone.families)
        allowed = found["error"].values + alone.errors
        assert (np.isnan(found["frequency"].values) == np.isnan(alone.frequencies)).all()
        here = ~np.isnan(alone.frequencies)
        assert (abs(found["frequency"].values - alone.frequencies) <= allowed)[here].all()
        assert (abs(found["growth_rate"].values - alone.growth_rates) <= allowed).all()
        if options.get("method") != "ancf":
            size = np.fmax(found["frequency"].values, found["growth_rate"].values)
            assert (found["error"].values <= 2e-6 * size + 10 * alone.errors).all()


@pytest.mark.parametrize(
    ("axes", "numbers", "options", "met"),
    [
        (
            {"spin_up": [0, 100, 200.0]},
            {"mu": 1e4},
            {"state": "stable"},
            ["solved", "flutter", "flutter"],
        ),
        (
            {"gamma": [1, 4, 10.0]},
            {"delta": -1, "mu": 1000},
            {"plane": "flapwise"},
            ["solved", "buckled chordwise", "divergence"],
        ),
    ],
)
def test_what_is_not_plainly_stable_has_a_status_of_its_own(axes, numbers, options, met):
    """Vibrations that grow; a flapwise beam that is stable in its own plane only."""
    data = sweep(axes, None, beam=Beam(**numbers), workers=1, **options)
    assert [STATUS[code] for code in data["status"].values] == met
    grows = (data["growth_rate"] > 0).any("mode")
    assert grows.values.tolist() == [status in ("flutter", "divergence") for status in met]


def test_growth_rates_of_either_sign_are_stored():
    """Published with issue 36 of this project: 2.1203 and 5.7037, and their decaying partners."""
    beam = Beam(mu=1e4)
    data = sweep({"spin_up": [100, 200.0]}, None, 2, beam=beam, workers=1, state="stable")
    np.testing.assert_allclose(
        data["growth_rate"], [[2.1203, -2.1203], [5.7037, -5.7037]], atol=5e-5
    )


def test_the_dataset_is_labelled(tmp_path):
    """Dimensions, units, codes with their meaning, arguments and version; read by xarray alone,
    without an option and without a warning, which here would be an error."""
    import xarray

    store = tmp_path / "a.zarr"
    made = sweep({"gamma": [0, 5, 10], "alpha": [0, 1]}, store, 4, beam=Beam(mu=100), workers=1)
    read = xarray.open_zarr(store)
    assert dict(read.sizes) == {"gamma": 3, "alpha": 2, "mode": 4}
    assert read.identical(made.load())
    assert read["mode"].values.tolist() == [1, 2, 3, 4]
    assert {read[name].units for name in ("frequency", "error", "growth_rate")} == {"1/T*"}
    assert "rotation speed" in read["gamma"].long_name
    meanings = read["status"].flag_meanings.split()
    assert meanings == [status.replace(" ", "_") for status in STATUS]
    assert read["status"].flag_values == list(range(len(STATUS)))
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
        (False, {"executor": 3}, "executor = 3"),
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


def flipped(data: bytes) -> bytes:
    """One bit of the last value, or of its checksum, is another."""
    return data[:-1] + bytes([data[-1] ^ 1])


def test_a_damaged_chunk_is_computed_again(tmp_path):
    """Missing, truncated, empty or with a wrong bit: by the same call, of whatever array or
    coordinate, even if no beam of it has a number: the same store, byte by byte."""
    damages = (None, lambda data: data[:-4], lambda data: b"", flipped)
    store = tmp_path / "a.zarr"
    arguments = {"axes": {"gamma": [1, 2], "alpha": [1]}, "modes": 2, "workers": 1}
    sweep(out=store, **arguments)
    before = contents(store)
    chunks = {name for name in before if "/c/" in name}
    arrays = {"frequency", "error", "growth_rate", "family", "limit", "status"}
    assert {name.partition("/")[0] for name in chunks} == arrays | {"gamma", "alpha", "mode"}
    for k, name in enumerate(sorted(chunks)):
        path, damage = store / name, damages[k % len(damages)]
        path.write_bytes(damage(path.read_bytes())) if damage else path.unlink()
        sweep(out=store, **arguments)
        assert contents(store) == before, name


@pytest.mark.parametrize(
    ("name", "missing"),
    [
        ("frequency/c/0/0/0", False),
        ("frequency/c/0/0/0", True),
        ("status/c/0/0", False),
        ("gamma/c/0", True),
    ],
)
def test_a_damaged_chunk_is_named(name, missing, tmp_path, run):
    """In one line, by what reads it: it never looks like a beam without a frequency."""
    store = tmp_path / "a.zarr"
    sweep({"gamma": [1, 2], "mu": [50, 70]}, store, workers=1)
    chunk = store / name
    chunk.unlink() if missing else chunk.write_bytes(chunk.read_bytes()[:-4])
    code, _, err = run("export", str(tmp_path / "a.png"), "--sweep", str(store))
    assert (code, err.count("\n")) == (1, 1)
    assert str(store) in err


def test_a_sweep_of_two_axes_has_one_map(tmp_path, run):
    """Without --over it is over both."""
    store, picture = tmp_path / "a.zarr", tmp_path / "a.png"
    sweep({"gamma": [1, 2], "mu": [50, 70]}, store, workers=1)
    assert run("export", str(picture), "--sweep", str(store)) == (0, "", "")
    assert picture.stat().st_size > 10_000


def test_a_store_of_something_else_is_refused(tmp_path):
    """Nothing in it is touched."""
    store = tmp_path / "a.zarr"
    store.mkdir()
    (store / "zarr.json").write_text(json.dumps({"zarr_format": 3, "node_type": "group"}))
    before = contents(store)
    with pytest.raises(InvalidInput, match="no sweep"):
        sweep({"gamma": [0, 1]}, store, workers=1)
    assert contents(store) == before
