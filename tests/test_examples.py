"""The examples give the numbers that their docstrings state, with the sources named there."""

import ast
import shutil
import subprocess
import sys
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from helpers import contents, load_file, slow
from oracle import truth
from PIL import Image

from beamviz import Beam

FOLDER = Path(__file__).parents[1] / "assets" / "examples"
SCRIPTS = {file.stem: file for file in sorted(FOLDER.glob("*.py"))}
ANSWERS = {  # by script: what `main` returns, with the digits of the docstring
    "01_steel_beam": {
        "B1 at rest [Hz]": "1.6554",
        "B2 at rest [Hz]": "16.0711",
        "B1 at 60 rpm [Hz]": "1.71",
    },
    "02_veering": {
        "crossing at gamma": "4.464",
        "veering at gamma": "4.650",
        "gap [1/T*]": "0.241",
    },
    "03_resonances": {"B1, 2 per revolution": "0.79791", "B1, 1 per revolution": "1.71737"},
    "04_buckling": {"buckling at gamma": "2.996", "tip at gamma = 4 [L]": "0.858"},
    "05_map": {"third frequency [1/T*]": "76.86327"},
    "06_film": {"B2 [1/T*]": "22.0955"},
    "07_release": {"tip at t = 0 [L]": "0.4919", "tip at t = 2 [L]": "-0.3780"},
    "08_spin_up": {
        "greatest lag [m]": "0.574",
        "at [s]": "6.75",  # a sample each 0.01 s
        "swing afterwards [mm]": "3.64",
        "elongation [mm]": "0.5145",
    },
    "09_cluster": {"omega_1 without a mass": "13.170", "omega_1 with a tip mass": "12.48"},
    "10_paper_table": {"converged": "52.9425", "ancf, above [%]": "0.18", "foac": "61.59"},
    "11_tapered_blade": {
        "B1 at rest [Hz]": "30.288",
        "B2, 4 per revolution [rpm]": "2904.36",
    },
    "12_unknown_mass": {
        "mass [kg]": "0.248",
        "place [mm]": "390.4",
        "another mass, by two frequencies [kg]": "0.074",
    },
    "13_blade_file": {
        "F1 at 12.1 rpm [Hz]": "0.7294",
        "F1 at rest [Hz]": "0.6777",
        "L1 at rest [Hz]": "1.0864",
    },
    "14_both_planes": {
        "crossing at gamma": "3.0755",
        "gap at 5 degrees [1/T*]": "0.2196",
        "least distance at 30 degrees [1/T*]": "1.21",
        "flap above 1x [%]": "17.97",
        "its Southwell coefficient": "0.897",
    },
}
LONG = {  # motions, frames, processes, fits; a blade file, whose reader has tests of its own
    *("05_map", "06_film", "07_release", "08_spin_up", "09_cluster"),
    *("12_unknown_mass", "13_blade_file", "14_both_planes"),
}
MAX_BYTES = 150_000  # of a picture


def docstring(name: str) -> str:
    """The docstring of a script on one line."""
    text = ast.get_docstring(ast.parse(SCRIPTS[name].read_text()))
    assert text is not None
    return " ".join(text.split())


def picture(name: str) -> Path:
    """The committed picture beside a script."""
    (found,) = (file for file in FOLDER.glob(f"{name}.*") if file.suffix in (".png", ".webp"))
    return found


def size(file: Path) -> tuple[int, int]:
    """Width and height of a picture [pixels]."""
    with Image.open(file) as image:
        return image.size


@pytest.mark.filterwarnings("ignore::beamviz.LeftOut")  # of a blade file, which says so
@pytest.mark.parametrize("name", [*sorted(SCRIPTS.keys() - LONG), *slow(*sorted(LONG))])
def test_an_example_finds_what_its_docstring_states(name, tmp_path):
    """Within one unit of the last digit stated; and it draws a picture of the committed size."""
    matplotlib.use("agg")
    file = tmp_path / picture(name).name
    found = load_file(SCRIPTS[name]).main(file)
    assert found.keys() == ANSWERS[name].keys()
    for quantity, text in ANSWERS[name].items():
        assert text.removeprefix("-") in docstring(name)
        unit = 10.0 ** -len(text.partition(".")[2])
        assert found[quantity] == pytest.approx(float(text), abs=unit), quantity
    assert size(file) == size(picture(name))


@pytest.mark.slow
def test_a_run_leaves_the_committed_pictures(tmp_path):
    """Also one in the folder of the scripts."""
    script = tmp_path / SCRIPTS["01_steel_beam"].name
    for file in (SCRIPTS["01_steel_beam"], picture("01_steel_beam")):
        shutil.copy(file, tmp_path)
    before = contents(tmp_path)
    subprocess.run([sys.executable, script], cwd=tmp_path, check=True)
    (drawn,) = {*tmp_path.iterdir()} - {tmp_path / name for name in before}
    assert size(drawn) == size(picture("01_steel_beam"))
    assert contents(tmp_path).items() >= before.items()


@pytest.mark.slow
def test_the_resonances_are_those_of_an_independent_solution():
    """The oracle's frequency there is a multiple of the speed, to the digits that are stated."""
    for per_rev, text in ((2, "0.79791"), (1, "1.71737")):
        gamma = float(text)
        (frequency,) = truth(Beam(alpha=1, gamma=gamma), 1).frequencies
        assert frequency / per_rev == pytest.approx(gamma, abs=1e-5)


@pytest.mark.slow
def test_the_tapered_blade_is_that_of_an_independent_solution():
    """At rest with the published omega_1; the oracle's B2 is four times the speed stated."""
    example = load_file(SCRIPTS["11_tapered_blade"])
    rest = truth(Beam.from_si(**example.BLADE), 1, plane="flapwise")
    assert rest.frequencies[0] == pytest.approx(3.8238, abs=5e-5)
    blade = Beam.from_si(**example.BLADE, rotation_rpm=2904.36)
    second = truth(blade, 2, plane="flapwise").frequencies[1]
    assert blade.units.rpm(second) / 4 == pytest.approx(2904.36, abs=0.01)


@pytest.mark.slow
def test_the_measured_frequencies_are_those_of_an_independent_solution():
    """Of 0.25 kg at 390 mm, but for the errors that were added."""
    example = load_file(SCRIPTS["12_unknown_mass"])
    beam = Beam.from_si(**example.STRIP, mass=0.25, mass_position=0.39)
    hertz = beam.units.hertz(np.array(truth(beam, 5).frequencies))
    assert hertz == pytest.approx([7.600, 51.507, 139.692, 318.965, 462.384], abs=6e-4)
    assert example.MEASURED["hertz"] == pytest.approx(hertz, rel=5e-3)


@pytest.mark.slow
def test_flap_and_lag_meet_where_an_independent_solution_has_them():
    """At the crossing both have one frequency; with a pitch they are apart by the gap, and no less
    on either side; at the speed of the margins flap is above the line by its margin."""
    flat = load_file(SCRIPTS["14_both_planes"]).FLAT

    def apart(gamma: float, pitch: float) -> float:
        lower, upper = truth(flat.replace(gamma=gamma, pitch=pitch), 2, plane="both").frequencies
        return upper - lower

    assert apart(3.0755, 0) < 1e-4
    assert apart(3.0605, 5) == pytest.approx(0.2196, abs=5e-5)
    assert min(apart(2.96, 5), apart(3.16, 5)) > 0.22
    assert apart(2.55, 30) == pytest.approx(1.21, abs=5e-3)
    flap = truth(flat.replace(pitch=30), 2, plane="both").frequencies[1]
    assert 100 * (flap / 5 - 1) == pytest.approx(17.97, abs=5e-3)


def test_the_examples_are_on_their_page():
    """Each begins with a question and names a source; its picture is small; the page of thumbnails
    links both and asks the same question."""
    page = (FOLDER / "README.md").read_text()
    assert SCRIPTS.keys() == ANSWERS.keys()
    for name, file in SCRIPTS.items():
        question = file.read_text().splitlines()[0].removeprefix('"""')
        assert question.endswith("?")
        assert "Source: " in docstring(name)
        assert f"]({file.name})" in page
        assert f'src="{picture(name).name}"' in page
        assert page.count(question) == 2  # beside the picture, and in its place for a reader
        assert picture(name).stat().st_size < MAX_BYTES
