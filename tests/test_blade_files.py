"""Files of blades in the formats of the field."""

import json
import warnings

import blade_texts
import numpy as np
import pytest
from blade_texts import BLADE, KEYWORDS

from beamviz import Beam, InvalidInput, LeftOut, solve
from beamviz.cli import main
from beamviz.conversions import unit_size
from beamviz.exports import export
from beamviz.scene import Scene

SPEED = {"hub_radius": BLADE.hub_radius, "rotation_rpm": 12.1}


def written(folder, name: str, text: str):
    file = folder / name
    file.write_text(text)
    return file


def read(file, **values) -> Beam:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return Beam.from_file(file, **values)


def assert_same_beam(beam: Beam, expected: Beam, tolerance: float = 1e-12) -> None:
    for name, value in expected.numbers.items():
        assert getattr(beam, name) == pytest.approx(value, rel=tolerance), name
    assert beam.blade
    assert expected.blade
    for name in ("x", "mass", "bending", "axial", "flap", "twist"):
        row, expected_row = getattr(beam.blade, name), getattr(expected.blade, name)
        np.testing.assert_allclose(row, expected_row, rtol=tolerance, atol=1e-15, err_msg=name)


WITHOUT_AXIAL = {
    "elastodyn.dat": blade_texts.elastodyn(),
    "flex.bld": blade_texts.flex(),
    "commas.csv": blade_texts.delimited(","),
    "semicolons.csv": blade_texts.delimited(";", comma=True),
    "tabs.txt": blade_texts.delimited("\t"),
}


@pytest.mark.parametrize("name", WITHOUT_AXIAL)
def test_the_same_blade_is_read_from_each_format(tmp_path, name):
    """Without axial stiffness it is inextensible."""
    beam = read(written(tmp_path, name, WITHOUT_AXIAL[name]), length=BLADE.length, **SPEED)
    assert_same_beam(beam, Beam.from_si(**KEYWORDS, **SPEED))
    assert "inextensible" in beam.summary


@pytest.mark.parametrize(
    ("name", "text"), [("a.dat", blade_texts.bmodes()), ("st.dat", blade_texts.hawc2())]
)
def test_formats_with_axial_stiffness(tmp_path, name, text):
    beam = read(written(tmp_path, name, text), length=BLADE.length, **SPEED)
    expected = Beam.from_si(**KEYWORDS, axial_stiffness=BLADE.axial, **SPEED)
    assert_same_beam(beam, expected)


def test_a_main_file_of_elastodyn_says_all(tmp_path):
    written(tmp_path, "blade.dat", blade_texts.elastodyn())
    main_file = written(tmp_path, "main.dat", blade_texts.elastodyn_main("blade.dat"))
    with pytest.warns(LeftOut, match="cone of -2.5 deg, torsion"):
        beam = Beam.from_file(main_file)
    assert_same_beam(beam, Beam.from_si(**KEYWORDS, **SPEED, pitch=1))


def test_a_main_file_of_bmodes_says_all(tmp_path):
    """Its factors multiply the sections, and the tip has a mass with inertia."""
    written(tmp_path, "sections.dat", blade_texts.bmodes())
    main_file = written(tmp_path, "blade.bmi", blade_texts.bmodes_main("sections.dat"))
    with pytest.warns(LeftOut, match="offset of the centre of mass, up to 0.25 m"):
        beam = Beam.from_file(main_file)
    values = KEYWORDS | {"mass_per_length": [1.5 * m for m in BLADE.mass]}
    tip = {"mass": 40, "position": 40, "inertia": (2.5, 1.75, 10)}
    expected = Beam.from_si(
        **values,
        axial_stiffness=BLADE.axial,
        masses=[tip],
        pitch=3,
        hub_radius=1.5,
        rotation_rpm=24,
    )
    assert_same_beam(beam, expected)
    assert beam.masses[0].inertia == pytest.approx(expected.masses[0].inertia)


def test_a_set_of_a_file_is_chosen(tmp_path):
    written(tmp_path, "st.dat", blade_texts.hawc2())
    heavy = read(tmp_path / "st.dat#1.2")
    assert heavy.units.mass == pytest.approx(2 * read(tmp_path / "st.dat").units.mass)
    with pytest.raises(InvalidInput, match=r"no set '7.1'; it has 1.1, 1.2"):
        read(tmp_path / "st.dat#7.1")


@pytest.mark.parametrize("name", ["elastodyn.dat", "flex.bld", "tabs.txt"])
def test_a_toml_file_names_a_file_of_any_format(tmp_path, name):
    written(tmp_path, name, WITHOUT_AXIAL[name])
    text = f'stations_file = "{name}"\nlength = "4000 cm"\nhub_radius = 1.5\n'
    text += 'rotation_speed = "12.1 rpm"'
    beam = read(written(tmp_path, "beam.toml", text))
    assert_same_beam(beam, Beam.from_si(**KEYWORDS, **SPEED))


def test_the_command_line_reads_them(tmp_path, capsys):
    written(tmp_path, "sections.dat", blade_texts.bmodes())
    file = written(tmp_path, "blade.bmi", blade_texts.bmodes_main("sections.dat"))
    assert main(["modes", "--si", str(file), "--plane", "both", "--format", "json"]) == 0
    out, err = capsys.readouterr()
    frequencies = [mode["frequency"] for mode in json.loads(out)["modes"]]
    assert frequencies == pytest.approx(list(solve(read(file), plane="both").frequencies))
    assert "the model leaves out" in err


WRONG = {
    "length": ("b.dat", blade_texts.elastodyn(), {}, "fractions of the length: give length [m]"),
    "cell": (
        *("b.dat", blade_texts.elastodyn().replace("9.0  ", "9.x  "), {"length": 40}),
        "line 14, station 2, StrcTwst = '9.x': must be a number",
    ),
    "negative": (
        *("b.dat", blade_texts.bmodes().replace("2000000000.0", "-2e9"), {"length": 40}),
        "line 7, station 2, flp_stff = -2e9: must be above 0",
    ),
    "rows": (
        *("b.dat", blade_texts.elastodyn().replace("4   NBlInpSt", "9   NBlInpSt"), {"length": 40}),
        "ends after 4 of 9 stations of NBlInpSt",
    ),
    "format": ("b.dat", "nothing\nto see\n", {}, "looked for columns BlFract, BMassDen (ElastoDyn"),
    "unit": ("b.csv", "x [s],m,EI\n0,1,1\n1,1,1", {}, "unit 's': must be one of m, mm, cm, in, ft"),
    "missing": ("b.csv", "x;m\n0;1\n1;1", {}, "missing column 'bending_stiffness' [N m^2]"),
    "ragged": ("b.csv", "x;m;EI\n0;1;1\n1;1", {}, "line 3, station 2: 2 cells, not 3"),
    "no names": ("b.csv", "0;1;1\n1;1;1", {}, "no file of a known format"),
    "sections": ("b.bmi", blade_texts.bmodes_main("gone.dat"), {}, "gone.dat: No such file"),
}


@pytest.mark.parametrize("kind", WRONG)
def test_what_is_wrong_is_named_with_its_place(tmp_path, kind):
    name, text, values, message = WRONG[kind]
    with pytest.raises(InvalidInput) as refused:
        read(written(tmp_path, name, text), **values)
    assert message in str(refused.value)
    assert str(tmp_path) in str(refused.value)


def test_the_tip_may_be_soft():
    """That of the IEA 10 MW blade has 2e-7 of the stiffness of the root."""
    values = KEYWORDS | {
        "bending_stiffness": (9e9, 5e9, 1.5e9, 9.0),
        "flap_stiffness": (9e9, 2e9, 2e8, 9.0),
    }
    solution = solve(Beam.from_si(**values, **SPEED), modes=4, plane="both")
    assert (solution.errors <= 1e-6 * solution.frequencies).all()


def test_an_inextensible_beam_stays_one_in_its_own_values(tmp_path):
    beam = Beam.from_si(**KEYWORDS, **SPEED)
    assert "axial_stiffness" not in beam.si
    again = Beam.from_si(**beam.si)
    assert_same_beam(again, beam)
    assert "inextensible" in again.summary


@pytest.mark.parametrize(
    ("text", "si_unit", "size"),
    [
        *(("Nm2", "N m^2", 1.0), ("N·m²", "N m^2", 1.0), ("lbf-in^2", "N m^2", 0.00286980)),
        *(("lb.in2", "N m^2", 0.00286980), ("lbm/in", "kg/m", 17.8580), ("in", "m", 0.0254)),
        *(("lbf", "N", 4.44822), ("kg-m^2", "kg m^2", 1.0), ("rpm", "rad/s", 0.104720)),
        *(("°", "deg", 1.0), ("deg/s", "rad/s", 0.0174533)),
    ],
)
def test_units_are_read_as_people_write_them(text, si_unit, size):
    assert unit_size(text, si_unit) == pytest.approx(size, rel=1e-5)


def test_a_file_in_an_older_encoding_is_read(tmp_path):
    file = tmp_path / "blade.csv"
    file.write_bytes("x [m];m;EI;twist [°]\n0;1;100;3\n1;1;100;0\n".encode("latin-1"))
    assert read(file).blade.twist == (3.0, 0.0)


def test_values_of_a_mass_may_have_units():
    masses = [{"mass": "250 g", "position": "10 in", "inertia": (0, 0, 0)}]
    beam = Beam.from_si(length=1, mass_per_length=1, bending_stiffness=100, masses=masses)
    assert (beam.masses[0].alpha, beam.masses[0].beta) == pytest.approx((0.25, 0.254))


@pytest.mark.filterwarnings("ignore::beamviz.ImplausibleInput")  # of such stiffnesses
def test_an_inextensible_beam_is_the_limit_of_stiff_ones():
    values = KEYWORDS | SPEED

    def frequencies(**stiffness: float) -> np.ndarray:
        beam = Beam.from_si(**values, **stiffness)
        return solve(beam, plane="both", tolerance=1e-10).frequencies

    limit = frequencies()
    near, far = frequencies(axial_stiffness=1e13), frequencies(axial_stiffness=1e11)
    assert near == pytest.approx(limit, rel=2e-6)
    assert abs(far - limit).max() > 10 * abs(near - limit).max()


@pytest.mark.parametrize("kind", ["elastodyn", "bmodes", "hawc2"])
def test_what_was_read_is_written_and_read_again(tmp_path, kind):
    """As TOML all of it, as CSV the stations: the frequencies are the same."""
    file = written(tmp_path, "in.dat", getattr(blade_texts, kind)())
    beam = read(file, length=BLADE.length, **SPEED)
    scene = Scene(beam)
    export(tmp_path / "out.toml", scene)
    export(tmp_path / "out.stations.csv", scene)
    expected = solve(beam, plane="both").frequencies
    for again in (read(tmp_path / "out.toml"), read(tmp_path / "out.stations.csv", **SPEED)):
        assert_same_beam(again, beam)
        assert solve(again, plane="both").frequencies == pytest.approx(expected, rel=1e-10)


def test_bodies_and_the_root_are_written_too(tmp_path):
    tip = {"mass": 40, "position": 39, "inertia": (2.5, 1.75, 10)}
    beam = Beam.from_si(**KEYWORDS, **SPEED, masses=[tip], root_stiffness=1e8, pitch=3)
    export(tmp_path / "out.toml", Scene(beam))
    again = read(tmp_path / "out.toml")
    assert_same_beam(again, beam)
    assert again.root == pytest.approx(beam.root)
    assert again.masses[0].beta == pytest.approx(39 / 40)
    with pytest.raises(InvalidInput, match="size of the beam is not known"):
        export(tmp_path / "no.toml", Scene(Beam()))


def test_a_flapwise_stiffness_that_is_missing_is_told(tmp_path, capsys):
    """As another stiffness is taken in its place; and a speed in rpm that is typed as gamma."""
    names = "station,mass_per_length,bending_stiffness"
    file = written(tmp_path, "blade.csv", f"{names}\n0,600,9e9\n20,300,9e8\n40,20,3e7\n")
    assert main(["modes", "--si", str(file), "--plane", "flapwise"]) == 0
    assert "no flap_stiffness is given: bending_stiffness is taken" in capsys.readouterr().err
    assert main(["modes", "--si", str(file)]) == 0
    assert capsys.readouterr().err == ""
    toml = written(tmp_path, "b.toml", 'stations_file = "blade.csv"\nrotation_speed = 20')
    assert main(["modes", "--si", str(toml)]) == 0
    assert "in rpm, not rad/s, or as gamma" in capsys.readouterr().err
