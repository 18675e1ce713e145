"""What a notebook needs of a result: labelled arrays, tables, drawings, pickling."""

import pickle
import sys

import numpy as np
import pytest
import xarray
from matplotlib.figure import Figure

from beamviz import Beam, Unavailable, __version__, loci, motion, solve, sweep
from beamviz.frequency_loci import Loci
from beamviz.installation import install_command
from beamviz.presets import PRESETS
from beamviz.sweeps import open_sweep
from beamviz.units import Units

BEAM = Beam(alpha=1, beta=1, gamma=5)


@pytest.fixture(scope="module")
def found():
    """Loci over the speed: S1 crosses B3."""
    return loci(BEAM, "gamma", np.linspace(0, 10, 11))


@pytest.mark.parametrize("coriolis", [False, True])
def test_a_solution_as_a_dataset(coriolis):
    """Labelled shapes and numbers; model, numbers and version as attributes."""
    solution = solve(BEAM, modes=4, coriolis=coriolis)
    data = solution.to_xarray()
    assert dict(data.sizes) == {"mode": 4, "x": 201, "component": 2}
    assert data["frequency"].values.tolist() == solution.frequencies.tolist()
    assert tuple(data["family"].values) == solution.families
    assert tuple(data["label"].values) == solution.labels
    shape = data["shape"].sel(mode=2, x=0.5, component="across")
    value = complex(solution.shape(1, 0.5)[0, 1])
    assert float(shape) == pytest.approx(value.real)
    assert ("shape_imag" in data) is coriolis
    if coriolis:
        imaginary = data["shape_imag"].sel(mode=1, x=0.5, component="along")
        assert float(imaginary) == pytest.approx(solution.shape(0, 0.5)[0, 0].imag)
    assert (data.gamma, data.strain, data.coriolis) == (5.0, "green", coriolis)
    assert data.beamviz_version == __version__


def test_datasets_can_be_kept_in_netcdf(tmp_path, found):
    """A file has the values, also of complex shapes, and the attributes of the dataset, which are
    texts and numbers: the backends of netCDF4 write no truth values, none writes None."""
    store = tmp_path / "sweep.zarr"
    blade = PRESETS["tapered-steel-blade"].beam
    sweep({"gamma": [0, 1], "alpha": [0, 1]}, store, 2, beam=blade, coriolis=True)
    for name, data in {
        "solution": solve(BEAM, coriolis=True).to_xarray(),
        "solution of a blade": solve(blade).to_xarray(),
        "loci": found.to_xarray(),
        "loci in SI": loci(blade, over="gamma", values=[0, 1]).to_xarray(),
        "motion": motion(BEAM, 0.1, start={"B1": 0.1}).to_xarray(),
        "sweep": open_sweep(store),
        "sweep read by xarray": xarray.open_zarr(store, chunks=None),
        "sweep in memory": sweep({"mu": [20, 30]}, None, 2, method="ancf", elements=3),
    }.items():
        data.to_netcdf(tmp_path / f"{name}.nc")
        with xarray.open_dataset(tmp_path / f"{name}.nc") as kept:
            xarray.testing.assert_equal(kept.load(), data)
            assert dict(kept.attrs) == data.attrs
        assert {type(value) for value in data.attrs.values()} <= {str, int, float}


def test_loci_and_sweeps_of_a_beam_in_si_have_its_units(tmp_path):
    """Frequencies in Hz, and the speed in rpm beside gamma; alpha in kg."""
    beam = PRESETS["tapered-steel-blade"].beam
    data = loci(beam, over="rpm", values=[0, 300]).to_xarray()
    assert data.rpm.values == pytest.approx([0, 300])
    assert data.rpm.units == "rpm"
    hertz = beam.units.hertz(data.frequency.values)
    np.testing.assert_allclose(data.hertz.values, hertz)
    swept = sweep({"rpm": [0, 300], "alpha": [0, 1]}, tmp_path / "s.zarr", 2, beam=beam)
    assert swept.rpm.values == pytest.approx([0, 300])
    assert swept.kg.values == pytest.approx([0, beam.units.mass])
    assert "rpm" not in loci(BEAM, over="gamma", values=[0, 1]).to_xarray().coords


def test_loci_as_a_dataset_and_tables(found):
    """By value and label; events and limits as tables."""
    data = found.to_xarray()
    assert data["frequency"].dims == ("gamma", "branch")
    assert data["frequency"].sel(branch="S1").values.tolist() == found["S1"].frequency.tolist()
    assert "gamma" not in data.attrs
    events = found.events_dataframe()
    assert events["at"][0] == pytest.approx(4.4641, abs=1e-4)
    beyond = loci(Beam(delta=1), "gamma", [10, 30, 40], strain="hencky").limits_dataframe()
    assert beyond["start"][0] == pytest.approx(31.4887, abs=1e-4)
    assert list(found.limits_dataframe().columns) == list(beyond.columns)


@pytest.mark.parametrize(
    ("over", "values", "options", "absent"),
    [
        ("spin_up", [-5, 0, 5], {"state": "stable"}, {"spin_up"}),
        ("mu", [20, 50], {}, {"mu", "unit_length_m", "unit_time_s"}),  # T* depends on mu
    ],
)
def test_what_varies_is_no_attribute(over, values, options, absent):
    """The fixed numbers are attributes, and the units where they do not vary."""
    data = loci(Beam(gamma=4, units=Units(1.0, 0.1)), over, values, 2, **options).to_xarray()
    names = {"gamma", "mu", "unit_length_m", "unit_time_s"}
    assert data.attrs.keys() & (names | absent) == names - absent
    assert data[over].values.tolist() == values


def test_drawn_onto_given_axes(found):
    """The axes are returned, with a line for each mode and the label of each branch."""
    one, two = Figure().subplots(1, 2)
    solution = solve(BEAM)
    assert solution.plot(one) is one
    assert found.plot(ax=two) is two
    assert [text.get_text()[:2] for text in one.get_legend().get_texts()] == list(solution.labels)
    assert {branch.label for branch in found.branches} <= {text.get_text() for text in two.texts}


def test_tables_in_a_notebook(found):
    """Each mode, and each crossing, is a row; every result pickles."""
    solution = solve(BEAM)
    table = solution._repr_html_()
    assert table.count("<tr>") == 6
    assert "<td>S1</td><td>stretching</td><td>" in table
    assert found._repr_html_().count("<td>crossing</td>") == len(found.events)
    assert pickle.loads(pickle.dumps(solution))._repr_html_() == table
    unstable = solve(Beam(delta=-1, gamma=6))
    assert f"<td>{unstable.growth_rates[0]:.4g}" in unstable._repr_html_()
    assert "growth rate" not in table


@pytest.mark.parametrize(
    ("package", "extra", "use"),
    [
        ("xarray", "xarray", Loci.to_xarray),
        ("pandas", "xarray", Loci.events_dataframe),
        ("xarray", "sweep", lambda _: sweep({"gamma": [0, 1]}, None)),
        ("zarr", "sweep", lambda _: sweep({"gamma": [0, 1]}, None)),
    ],
)
def test_a_missing_package_names_the_command_that_installs_it(
    package, extra, use, found, monkeypatch
):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(Unavailable) as caught:
        use(found)
    assert f"{package}: {install_command(extra, package)}" in str(caught.value)
