"""Maps and lines of a sweep's store: `beamviz export --sweep`, `beamviz loci --sweep`."""

import numpy as np
import pytest
from helpers import slow, strict
from matplotlib.figure import Figure
from matplotlib.image import imread
from matplotlib.text import Text

from beamviz import Beam, solve, sweep
from beamviz.frequency_loci.identity import identify_modes
from beamviz.plotting.maps import draw_map
from beamviz.sweeps import open_sweep
from beamviz.sweeps.arrays import FAMILIES
from beamviz.sweeps.quantities import frequency_of, smallest_gap

SPEEDS = np.linspace(0, 40, 21)
MASSES = np.array([0, 0.5, 1, 2])
BEAM = Beam(gamma=SPEEDS[3], alpha=MASSES[2], beta=0.5, mu=60)
LINE, AT = "loci --over gamma --sweep STORE --at", "alpha=1,beta=0.5"
KEYS = ("frequency", "family", "status")
MAP = "--over gamma,alpha --at beta=0.5 --sweep STORE"


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    """A sweep that has beams without an equilibrium."""
    path = tmp_path_factory.mktemp("sweep") / "a.zarr"
    axes = {"gamma": SPEEDS, "alpha": MASSES, "beta": [0.5, 1]}
    sweep(axes, path, 3, beam=Beam(mu=60), workers=1, strain="hencky")
    return path


def command(line, store):
    """The words of a command line about a store."""
    return line.replace("STORE", str(store)).split()


def drawn(store, **options):
    """Axes of a map, the values (rows, columns) in its colours, and its texts."""
    ax = Figure().add_subplot()
    draw_map(open_sweep(store), ("gamma", "alpha"), at={"beta": 0.5}, ax=ax, **options)
    (mesh,) = (
        one for one in ax.collections if one.get_cmap().name == "viridis" and one.get_rasterized()
    )
    return ax, mesh.get_array(), {text.get_text() for text in ax.texts}


def test_a_map_shows_a_frequency(store):
    """Colours are the frequencies of solve; modes, parameters, unit and gaps are named."""
    ax, values, texts = drawn(store, mode=2)
    assert values.shape == (4, 21)
    assert values[2, 3] == pytest.approx(solve(BEAM, strain="hencky").frequencies[1], rel=1e-5)
    assert values.mask[3, -1]
    assert texts == {"B2", "S1"}
    assert ("rotation speed γ" in ax.get_xlabel(), "mass ratio α" in ax.get_ylabel()) == (True,) * 2
    assert "mode 2 at β = 0.5, δ = 0, μ = 60" in ax.get_title(loc="left")
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["no equilibrium"]
    assert ax.figure.axes[1].get_ylabel() == "frequency of mode 2 [1/T*]"


def test_a_map_shows_the_smallest_gap(store):
    """The smallest difference of neighbouring frequencies, between modes by their labels."""
    _, values, texts = drawn(store, gap=True)
    frequencies = solve(BEAM, modes=3, strain="hencky").frequencies
    assert values[2, 3] == pytest.approx(np.diff(frequencies).min(), rel=1e-4)
    assert "B1, B2" in texts


@pytest.mark.parametrize("coriolis", [False, True])
def test_modes_of_a_map_have_their_labels(coriolis):
    """Those of a solution: of each mode, of the two of the smallest gap, and also where Coriolis
    forces mix two modes, which are then those without these forces."""
    speeds, masses = np.linspace(0, 20, 9), np.array([0.5, 1.0])
    options = {"workers": 1, "coriolis": coriolis}
    data = sweep({"gamma": speeds, "alpha": masses}, None, 5, beam=Beam(beta=0.5), **options)
    frequency, family, status = (data[key].transpose("alpha", "gamma", ...).values for key in KEYS)
    shown = smallest_gap(frequency, family, status)
    modes = [frequency_of(mode, frequency, family, status) for mode in range(1, 6)]
    mixed = 0
    for row, column in np.ndindex(status.shape):
        beam = Beam(alpha=masses[row], beta=0.5, gamma=speeds[column])
        labels = identify_modes(solve(beam, coriolis=coriolis)).labels
        k = int(np.diff(frequency[row, column]).argmin())
        pair = sorted(labels[k : k + 2], key=lambda label: (label[0] != "S", label))
        assert shown.names[shown.kinds[row, column]] == ", ".join(pair)
        mixed += int((family[row, column] == FAMILIES.index("mixed")).sum())
        if (family[row, column] != FAMILIES.index("mixed")).all():
            assert [one.names[one.kinds[row, column]] for one in modes] == [*labels]
    assert (mixed > 0) is coriolis


def test_names_lie_within_the_frame_and_apart_from_each_other():
    """Where the regions are narrower than their names, too."""
    axes = {"gamma": np.linspace(0, 200, 21), "delta": np.linspace(0.3, 2, 5)}
    data = sweep(axes, None, 3, beam=Beam(mu=60), workers=1, strain="hencky")
    ax = draw_map(data, gap=True, ax=Figure().add_subplot())
    one, other = map(Text.get_window_extent, ax.texts)
    assert not one.overlaps(other)
    for box in (one, other):
        assert all(ax.bbox.contains(*corner) for corner in (box.min, box.max))


@pytest.mark.parametrize("options", [("--gap",), *slow((("--mode", "2"),))])
def test_the_map_is_a_file(options, store, tmp_path, run):
    """`beamviz export OUT.png --sweep` writes a picture in colours and greys. The hatches of beams
    without a number are lighter than the names and the borders of regions."""
    out = tmp_path / "map.png"
    assert run("export", str(out), *command(MAP, store), *options) == (0, "", "")
    pixels = (255 * imread(out)).round().astype(np.uint8)
    assert len(np.unique(pixels.view(np.uint32))) > 30
    assert (pixels[..., :3].max(axis=2) < 64).mean() < 0.03


def test_a_map_of_a_beam_in_si(tmp_path, steel, run):
    """Frequencies in Hz over the speed in rpm."""
    store = tmp_path / "si.zarr"
    sweep({"gamma": SPEEDS[:3], "alpha": [0, 1]}, store, 2, beam=Beam.from_toml(steel), workers=1)
    ax = draw_map(open_sweep(store), ("gamma", "alpha"), mode=1, ax=Figure().add_subplot())
    assert ax.get_xlabel() == "rotation speed [rpm]"
    assert ax.get_xlim()[1] == pytest.approx(Beam.from_toml(steel).units.rpm(SPEEDS[2]))
    assert "[Hz]" in ax.figure.axes[1].get_ylabel()
    code, out, err = run("loci", "--over", "gamma", "--at", "alpha=1", "--sweep", str(store))
    assert (code, err) == (0, "")
    assert "SI units     L = 2 m" in out


def test_the_loci_of_a_line(store, tmp_path, run):
    """Beam, values and model are those of the store, and so are the frequencies."""
    plot = tmp_path / "line.svg"
    code, out, err = run(*command(LINE, store), AT, "--format", "json", "--plot", str(plot))
    data = strict(out)
    assert (code, err) == (0, "")
    assert data["values"] == SPEEDS.tolist()
    assert data["beam"] == {"alpha": 1, "beta": 0.5, "delta": 0, "mu": 60}
    assert data["model"]["strain"] == "hencky"
    found = np.array([branch["frequency"] for branch in data["branches"]], float)
    line = open_sweep(store).sel(alpha=1, beta=0.5)
    np.testing.assert_allclose(np.sort(found, axis=0)[:3].T, line.frequency, rtol=1e-5)
    assert np.isnan(line.frequency[-1]).all()
    assert {one["kind"] for one in data["limits"]} == {"no-equilibrium"}
    assert plot.stat().st_size > 1000


@pytest.mark.parametrize("status", ["not computed", "divergence", "not converged"])
def test_beams_without_a_number_are_grey(status, store):
    """Exactly these, named in the legend."""
    data = open_sweep(store).load()
    code = data["status"].flag_meanings.split().index(status.replace(" ", "_"))
    data["status"] = data["status"].where(data["status"] == 1, code)
    ax = draw_map(data, ("gamma", "alpha"), mode=1, at={"beta": 1}, ax=Figure().add_subplot())
    assert [text.get_text() for text in ax.get_legend().get_texts()] == [status]
    colours, greys = (one.get_array() for one in ax.collections if one.get_rasterized())
    assert (greys.mask != colours.mask).all()
    assert (colours.mask == (data["status"].sel(beta=1) == code).T.values).all()
    assert 0 < colours.mask.sum() < colours.size


@pytest.mark.parametrize(
    ("axes", "numbers", "options", "status"),
    [
        (
            {"gamma": np.linspace(0, 5, 6), "delta": np.linspace(-1, 0, 4)},
            {"mu": 1000},
            {"plane": "flapwise"},
            "buckled chordwise",
        ),
        (
            {"spin_up": [0, 70.0, 100, 200], "gamma": [0, 1]},
            {"mu": 1e4},
            {"state": "stable"},
            "flutter",
        ),
    ],
)
def test_beams_that_are_not_plainly_stable_are_a_kind_of_their_own(axes, numbers, options, status):
    """They have a frequency, hence a colour, but a border, a name and a hatch tell what they are;
    the name of the others does not change."""
    data = sweep(axes, None, 2, beam=Beam(**numbers), workers=1, **options)
    for shown in ({"mode": 1}, {"gap": True}):
        ax = draw_map(data, **shown, ax=Figure().add_subplot())
        assert status in {text.get_text() for text in ax.get_legend().get_texts()}
        names = {text.get_text() for text in ax.texts}
        assert any(name.endswith(f"\n({status})") for name in names)
        assert any("(" not in name for name in names)
