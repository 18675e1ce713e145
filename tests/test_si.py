"""Beams in SI: what may be given, what is warned about, and the way there and back."""

import json
import math
import warnings
from pathlib import Path

import numpy as np
import pytest
from helpers import same_beam
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import blades, physical_beams

from beamviz import Beam, Blade, ImplausibleInput, InvalidInput, Mass, motion, solve
from beamviz.plausibility import RULES
from beamviz.scene import Scene, parse_query
from beamviz.si import FILE_KEYS, FLAP, SECTION
from beamviz.units import BY_NAME, Units

BLADE = {  # a tapered steel blade, 600 mm long, a rectangle of 40 x 12 mm at its root
    "length": 0.6,
    "stations": [0.0, 0.3, 0.3, 0.6],
    "mass_per_length": [3.768, 2.826, 2.5, 1.884],
    "bending_stiffness": [1209.6, 680.4, 500.0, 302.4],
    "axial_stiffness": [1.008e8, 7.56e7, 6.7e7, 5.04e7],
    "flap_stiffness": [13440.0, 5670.0, 5000.0, 1680.0],
    "hub_radius": 0.1,
    "rotation_rpm": 3000.0,
    "masses": [{"mass": 0.2, "position": 0.45, "inertia": (1e-5, 2e-5, 2.5e-5)}],
    "root_stiffness": 1e5,
}
TUBE = {
    "length": 2.0,
    "density": 7850,
    "area": 4e-4,
    "second_moment": 1.2e-8,
    "youngs_modulus": 2.1e11,
}
PLAIN = {"length": 1.0, "mass_per_length": 1.2, "bending_stiffness": 44.0, "axial_stiffness": 3e7}


def changed(**changes):
    """BLADE with other values; without those that are None."""
    return {name: value for name, value in (BLADE | changes).items() if value is not None}


def test_a_blade_is_relative_to_its_root():
    """Each number by its definition, with the section at the root; a jump stays one."""
    beam = Beam.from_si(**BLADE)
    time = math.sqrt(3.768 * 0.6**4 / 1209.6)
    assert beam.units.time == pytest.approx(time, rel=1e-14)
    assert beam.units.mass == pytest.approx(3.768 * 0.6, rel=1e-14)
    assert beam.units.force == pytest.approx(1209.6 / 0.6**2, rel=1e-14)
    assert beam.mu == pytest.approx(0.6 * math.sqrt(1.008e8 / 1209.6), rel=1e-14)
    assert beam.gamma == pytest.approx(100 * math.pi * time, rel=1e-14)
    assert beam.delta == pytest.approx(1 / 6, rel=1e-14)
    assert beam.root == pytest.approx(1e5 * 0.6 / 1209.6, rel=1e-14)
    assert beam.blade == Blade(
        x=(0, 0.5, 0.5, 1),
        mass=[value / 3.768 for value in BLADE["mass_per_length"]],
        bending=[value / 1209.6 for value in BLADE["bending_stiffness"]],
        axial=[value / 1.008e8 for value in BLADE["axial_stiffness"]],
        flap=[value / 1209.6 for value in BLADE["flap_stiffness"]],
    )
    (mass,) = beam.masses
    assert mass.alpha == pytest.approx(0.2 / (3.768 * 0.6), rel=1e-14)
    assert mass.beta == pytest.approx(0.75, rel=1e-14)
    assert mass.inertia[2] == pytest.approx(2.5e-5 / (3.768 * 0.6**3), rel=1e-14)


def test_numbers_make_a_uniform_beam_and_arrays_a_blade():
    """The same beam by its material and by its stiffnesses; a flapwise stiffness of its own, or one
    that varies, is a blade; numbers and arrays may be mixed, and the stations give the length."""
    steel = Beam.from_si(
        length=1.0, density=7850, area=1e-4, second_moment=1e-9, youngs_modulus=2.1e11
    )
    direct = Beam.from_si(
        length=1.0, mass_per_length=0.785, bending_stiffness=210.0, axial_stiffness=2.1e7
    )
    assert direct.is_uniform
    assert direct.numbers == pytest.approx(steel.numbers, rel=1e-14)
    assert direct.units.time == pytest.approx(steel.units.time, rel=1e-14)
    assert (steel.units.youngs_modulus, direct.units.youngs_modulus) == (2.1e11, None)
    flap = Beam.from_si(**PLAIN, flap_stiffness=88.0).blade
    assert (flap.bending, flap.flap) == ((1, 1), (2, 2))
    mixed = PLAIN | {"stations": np.array([0, 0.5, 2]), "mass_per_length": np.array([2, 1, 1])}
    del mixed["length"]
    beam = Beam.from_si(**mixed)
    assert (beam.units.length, beam.blade.x) == (2.0, (0, 0.25, 1))
    assert beam.blade.mass == (1, 0.5, 0.5)


def test_a_bar_keeps_its_material_and_both_its_stiffnesses(tmp_path):
    """As keywords, in a TOML file, a scene file and a link; uniform in the plane of rotation, where
    every method solves it as the uniform beam that it is there. Out of it those for beams of one
    stiffness say so."""
    bar = {"length": 0.5, "density": 7850.0, "area": 5e-4, "youngs_modulus": 2.1e11}
    bar |= {"second_moment": 0.05 * 0.01**3 / 12, "flap_stiffness": 2.1e11 * 0.01 * 0.05**3 / 12}
    beam = Beam.from_si(**bar, rotation_rpm=1500)
    assert beam.is_prismatic
    assert not beam.is_uniform
    assert beam.structure == ["flapwise stiffness 25 E I"]
    assert bar.items() <= {k: pytest.approx(v) for k, v in beam.si.items()}.items()
    path = tmp_path / "bar.toml"
    path.write_text("".join(f"{name} = {value}\n" for name, value in beam.si.items()))
    scene = Scene(beam)
    for again in (
        Beam.from_toml(path),
        Scene.from_bytes(scene.to_toml().encode(), "bar").beam,
        Scene.from_query(parse_query(scene.to_query())).beam,
    ):
        assert again.si == pytest.approx(beam.si, rel=1e-12)
    uniform = Beam.from_si(**{**bar, "flap_stiffness": None}, rotation_rpm=1500)
    for method in ("auto", "assumed-modes", "power-series", "chebyshev"):
        own = solve(beam, method=method, modes=3).frequencies
        assert own == pytest.approx(solve(uniform, method=method, modes=3).frequencies, rel=1e-9)
        if method != "auto":
            with pytest.raises(InvalidInput, match="as stiff out of the plane"):
                solve(beam, method=method, plane="flapwise")
    ratio = solve(beam.replace(gamma=0.0), plane="flapwise", modes=1).frequencies[0] / 3.51602
    assert ratio == pytest.approx(5.0, rel=1e-5)
    held = motion(beam, 1.0, release=0.5, points=5, tolerance=1e-3)
    assert held.tip == pytest.approx(
        motion(uniform, 1.0, release=0.5, points=5, tolerance=1e-3).tip, abs=1e-6
    )


def test_a_speed_is_in_radians_per_second_or_in_rpm():
    beam = Beam.from_si(**PLAIN, rotation_speed=10 * math.pi)
    assert Beam.from_si(**PLAIN, rotation_rpm=300) == beam
    with pytest.raises(InvalidInput, match=r"\[rad/s\] and rotation_rpm \[1/min\] exclude"):
        Beam.from_si(**PLAIN, rotation_rpm=300, rotation_speed=1)


@settings(max_examples=20)
@given(physical_beams())
def test_si_and_back(values):
    """from_si(**beam.si) is the beam, to rounding."""
    beam = Beam.from_si(**values)
    same_beam(Beam.from_si(**beam.si), beam)


@settings(max_examples=20)
@given(physical_beams())
def test_a_toml_file_holds_the_keywords(tmp_path_factory, values):
    """With [[masses]] as tables."""
    masses = values.pop("masses", [])
    lines = [f"{name} = {json.dumps(value)}" for name, value in values.items()]
    for mass in masses:
        lines += ["[[masses]]", *(f"{name} = {json.dumps(v)}" for name, v in mass.items())]
    path = tmp_path_factory.mktemp("si") / "beam.toml"
    path.write_text("\n".join(lines))
    assert Beam.from_toml(path) == Beam.from_si(**values, masses=masses)


@settings(max_examples=20)
@given(physical_beams(by_stations=True))
def test_a_csv_file_holds_the_stations(tmp_path_factory, values):
    """Alone, or named in a TOML file beside it that has the rest; in any order, with units."""
    folder = tmp_path_factory.mktemp("si")
    names = [name for name in (*SECTION, *FLAP) if name in values]
    count = len(values["stations"])
    rows = [values["stations"], *(np.broadcast_to(values[name], count) for name in names)]
    text = "# stations of a blade\nstation [m]," + ", ".join(names) + "\n"
    text += "\n".join(
        ",".join(repr(float(cell)) for cell in row) for row in zip(*rows, strict=True)
    )
    (folder / "blade.csv").write_text(text)
    others = {name: v for name, v in values.items() if name not in (*names, "stations", "degree")}
    degree = {"degree": values["degree"]} if "degree" in values else {}
    beam = Beam.from_si(**values)
    assert Beam.from_file(folder / "blade.csv", **others, **degree) == beam
    plain = {name: v for name, v in (others | degree).items() if name != "masses"}
    lines = [f"{name} = {json.dumps(value)}" for name, value in plain.items()]
    (folder / "b.toml").write_text("\n".join(['stations_file = "blade.csv"', *lines]))
    assert Beam.from_toml(folder / "b.toml") == beam.replace(masses=())


@settings(max_examples=20)
@given(physical_beams())
def test_a_scene_file_and_a_link_hold_a_blade(values):
    """The file to the last bit, the link in SI to rounding."""
    scene = Scene(Beam.from_si(**values))
    assert Scene.from_bytes(scene.to_toml().encode(), "scene.toml") == scene
    same_beam(Scene.from_query(parse_query(scene.to_query())).beam, scene.beam)


@settings(max_examples=20)
@given(blades(), st.lists(st.builds(Mass, st.floats(0, 10), st.floats(0, 1)), max_size=3))
def test_a_scene_file_and_a_link_hold_a_dimensionless_blade(blade, masses):
    """To the last bit, also over a base with another blade."""
    for root in (math.inf, 0.0, 2.5):
        scene = Scene(Beam(gamma=3, blade=blade, masses=masses, root=root))
        assert Scene.from_bytes(scene.to_toml().encode(), "scene.toml") == scene
        for base in (Scene(), Scene(Beam(blade=Blade.tapered(0.5), root=1.0))):
            assert Scene.from_query(parse_query(scene.to_query(base)), base) == scene
            assert Scene.from_query(parse_query(base.to_query(scene)), scene) == base


def test_a_link_has_the_numbers_that_were_given():
    """Not those with the rounding of the way to dimensionless ones and back."""
    query = parse_query(Scene(Beam.from_si(**BLADE)).to_query())
    assert query["axial_stiffness"] == BLADE["axial_stiffness"]
    assert query["stations"] == BLADE["stations"]


def test_a_blade_of_many_stations_is_too_large_for_a_link():
    x = np.linspace(0, 1, 200)
    row = np.exp(-x)
    blade = Blade(x, row, row, row, row)
    with pytest.raises(InvalidInput, match="save it as a scene file"):
        Scene(Beam(blade=blade)).to_query()
    short = Blade(*(tuple(np.round(values[::10], 3)) for values in (x / x[190], row, row, row)))
    assert len(Scene(Beam(blade=short)).to_query()) < 2000


WRONG = [
    ({"length": None, "stations": None}, "missing value 'length' [m]"),
    ({"mass_per_length": None}, "missing value 'mass_per_length' [kg/m]"),
    ({"density": 7850}, "density and mass_per_length exclude each other"),
    ({"EA": 3}, "did you mean 'axial_stiffness' [N]?"),
    ({"flapstiffness": 3}, "did you mean 'flap_stiffness' [N m^2]?"),
    ({"stations": None}, "mass_per_length: 4 values need stations [m]"),
    ({"stations": [0, 0.3, 0.6]}, "mass_per_length: 4 values, 3 stations"),
    ({"stations": [0.1, 0.3, 0.3, 0.6]}, "must ascend from 0 at the root"),
    ({"stations": [0, 0.4, 0.3, 0.6]}, "must ascend from 0 at the root"),
    ({"stations": [0, 0.3, 0.3, 0.7]}, "stations end at 0.7 m: must end at length = 0.6 m"),
    ({"stations": "abcd"}, "stations = 'abcd': must be a sequence of numbers"),
    (
        {"mass_per_length": [1, -1, 1, 1]},
        "mass_per_length of station 2 at 0.3 m = -1: must be 0 or more",
    ),
    (
        {"axial_stiffness": [1e10, 1e10, 1e10, 1]},
        "axial_stiffness of station 4 at 0.6 m over that at the root = 1e-10",
    ),
    ({"degree": 2}, "segment"),
    ({"masses": {"mass": 1}}, "must be a list of tables"),
    ({"masses": [{"mass": 1}]}, "masses 1: missing 'position' [m]"),
    ({"masses": [{"mass": 1, "position": 2}]}, "masses 1: position = 2: must lie in 0 .. 0.6"),
    ({"masses": [{"mass": 1, "place": 2}]}, "masses 1: unknown key 'place'"),
    ({"masses": [{"mass": 1, "position": 0, "inertia": [1]}]}, "three numbers Jx, Jy, Jz"),
    ({"masses": [{"mass": 1e6, "position": 0}]}, "masses 1, over mass_per_length length"),
    ({"root_stiffness": -1}, "root_stiffness = -1: must be 0 or more"),
]


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("length = -2", "length [m] = -2: must be 0 or more"),
        ('area = "4 cm"', "area [m^2] = '4 cm': unit 'cm': must be one of m^2, mm^2, cm^2"),
        ("mass_position = 7", "mass_position [m] = 7: must lie in 0 .. 2"),
        ("[[masses]]\nmass = 1\nposition = 5", "masses 1: position [m] = 5"),
        ("lenght = 2", "unknown key 'lenght': did you mean 'length' [m]?"),
        ("length = 2,0", "not a TOML file"),
        ("degree = 9", "degree = 9: must be"),
    ],
)
def test_an_error_of_a_file_names_it_the_key_and_the_unit(tmp_path, line, message):
    """Of a beam, and of a beam in the table [si] of a scene."""
    key = line.partition(" ")[0]
    lines = [f"{name} = {value}" for name, value in TUBE.items() if name != key] + [line]
    beam, scene = tmp_path / "beam.toml", tmp_path / "scene.toml"
    beam.write_text("\n".join(lines))
    scene.write_text("[si]\n" + "\n".join(lines).replace("[[masses]]", "[[si.masses]]"))
    for read, file in ((Beam.from_toml, beam), (Scene.from_toml, scene)):
        with pytest.raises(InvalidInput) as refused:
            read(file)
        assert str(refused.value).startswith(f"{file}: ")
        assert message in str(refused.value)


def test_a_key_within_a_message_has_no_unit(tmp_path):
    """Nor one of a scene that is no quantity in SI."""
    beam, scene = tmp_path / "beam.toml", tmp_path / "scene.toml"
    lines = (f"{name} = {value}" for name, value in (TUBE | {"second_moment": 1e-20}).items())
    beam.write_text("\n".join(lines))
    with pytest.raises(InvalidInput, match=r"[^a-z]length sqrt"):
        Beam.from_toml(beam)
    scene.write_text("[camera]\nposition = [0, 0, 1e9]")
    with pytest.raises(InvalidInput, match="position = 1000000000"):
        Scene.from_toml(scene)


@pytest.mark.parametrize(("changes", "message"), WRONG)
def test_a_wrong_value_is_named_with_its_unit(changes, message):
    with pytest.raises(InvalidInput) as refused:
        Beam.from_si(**changed(**changes))
    assert message in str(refused.value)


WRONG_CSV = {
    "": "no file of a known format",
    "station,EI\n0,1": "missing column 'mass_per_length' [kg/m]",
    "station,stiff\n0,1": "unknown column 'stiff'",
    "station,mass_per_length\n": "missing column 'bending_stiffness' [N m^2]",
    "station [s],mass_per_length\n0,1": "column station: unit 's': must be one of m, mm",
    "HEAD\n0,1,2\n": "line 2, station 1: 3 cells, not 4",
    "HEAD\n0,1,x,3\n": "bending_stiffness = 'x': must be a number",
    "HEAD\n0,1,nan,3\n": "line 2, station 1, bending_stiffness = 'nan': must be a number",
    "HEAD": "has no stations",
    "station,station\n0,1": "missing column 'mass_per_length'",
}


@pytest.mark.parametrize("text", WRONG_CSV)
def test_a_wrong_table_of_stations_is_named(tmp_path, text):
    head = "station,mass_per_length,bending_stiffness,axial_stiffness"
    file = tmp_path / "blade.csv"
    file.write_text(text.replace("HEAD", head))
    with pytest.raises(InvalidInput) as refused:
        Beam.from_file(file)
    assert WRONG_CSV[text] in str(refused.value)


def test_a_scene_from_elsewhere_names_no_file_of_this_machine():
    """A scene that a visitor loads has no folder; one read from a folder has."""
    text = b'[si]\nlength = 1\nstations_file = "/etc/passwd"\n'
    with pytest.raises(InvalidInput, match="unknown key 'stations_file'"):
        Scene.from_bytes(text, "scene.toml")


STEEL = {
    "length": 1.0,
    "density": 7850.0,
    "area": 1.5e-4,
    "second_moment": 3.125e-10,
    "youngs_modulus": 2.1e11,
}
TAPERED = {
    "stations": (0.0, 20.0, 40.0),
    "mass_per_length": (600.0, 300.0, 20.0),
    "bending_stiffness": (9e9, 9e8, 3e7),
}
MISTAKES = [  # values in another unit, and words of the warning
    (STEEL, {"youngs_modulus": 2.1e5, "density": 7850.0}, "MPa"),
    (STEEL, {"density": 7.85}, "g/cm^3"),
    (STEEL, {"density": 7.85, "youngs_modulus": 210.0}, "GPa"),
    (PLAIN, {"axial_stiffness": 3e4, "bending_stiffness": 0.044}, "kN"),
    (PLAIN, {"mass_per_length": 1.2e-3}, "t/m"),
    (PLAIN, {"rotation_speed": 800.0}, "in rpm, not rad/s"),
    (PLAIN, {"mass": 50.0}, "a mass in g"),
    (PLAIN, {"masses": [{"mass": 0.1, "position": 1, "inertia": [1, 1, 1]}]}, "kg mm^2"),
    (PLAIN, {"flap_stiffness": 4.4e5}, "another unit"),
    (TAPERED, {"stations": (0, 0.5, 1)}, "fractions of the span, not in m"),
    (TAPERED, {"axial_stiffness": (9e15, 9e14, 3e13)}, "axial stiffness by rule"),
    (PLAIN, {"length": 400.0, "bending_stiffness": 1e6}, "in mm"),
]


@pytest.mark.parametrize(("values", "mistake", "words"), MISTAKES)
def test_a_value_in_another_unit_is_warned_about(values, mistake, words):
    """The beam is made all the same, and says it again."""
    with pytest.warns(ImplausibleInput) as caught:
        beam = Beam.from_si(**values | mistake)
    texts = [str(warning.message) for warning in caught]
    assert any(words in text for text in texts), texts
    assert beam.doubts == tuple(texts)


def test_an_impossible_value_names_the_likely_unit_too():
    """Lengths in mm make a beam that no method solves: the message says what was likely meant."""
    with pytest.raises(InvalidInput, match=r"mu = 3464101.*: must lie in .* a length in mm, not m"):
        Beam.from_si(**STEEL | {"length": 5000.0})


def test_usual_beams_are_not_warned_about():
    """Those of the presets, from a ruler to a wind turbine, and a blade of nylon."""
    from beamviz.explorer.features.real_beam import PRESETS

    nylon = STEEL | {"youngs_modulus": 2.7e9, "density": 1140.0, "rotation_speed": 30.0}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for values in (STEEL, PLAIN, BLADE, nylon, *(real.values for real in PRESETS.values())):
            assert Beam.from_si(**values).doubts == ()


def test_every_rule_has_a_reason_and_a_mistake():
    for rule in RULES:
        assert rule.reason
        assert rule.above
        assert rule.below or rule.least == 0


def test_the_reference_has_every_key_and_unit():
    """Keys with their units, and the names of `--over` that are in a unit."""
    text = (Path(__file__).parents[1] / "assets" / "reference.md").read_text()
    for key, unit in FILE_KEYS.items():
        assert f"| `{key}` | {unit} |" in text
    for name, scale in BY_NAME.items():
        assert f"`{name}`" in text or f"`{scale.unit}`" in text


def test_a_scene_of_a_file_warns_and_one_of_a_visitor_does_not(tmp_path):
    """Which has `doubts` to be shown."""
    text = "[si]\n" + "".join(
        f"{name} = {value}\n" for name, value in (STEEL | {"density": 7.85}).items()
    )
    file = tmp_path / "scene.toml"
    file.write_text(text)
    with pytest.warns(ImplausibleInput, match="a density in g/cm"):
        scene = Scene.from_toml(file)
    assert Scene.from_bytes(text.encode(), "scene.toml") == scene
    assert scene.beam.doubts


def test_polynomials_keep_their_degree():
    """A taper of a polynomial, by its stations and back, in a file and in a link."""
    beam = Beam(blade=Blade.tapered(0.5), mu=100, units=Units(0.6, 0.02, 2.0))
    links = Scene.from_query(parse_query(Scene(beam).to_query())).beam
    for found in (Beam.from_si(**beam.si), links):
        same_beam(found, beam)
        assert found.blade.degree == 4


@pytest.mark.filterwarnings("ignore::beamviz.ImplausibleInput")
def test_a_hinge_and_numbers_at_their_limits_come_back():
    """Whatever the size: rounding brings no number outside, and 0 is no default of the root."""
    for k in range(1, 40):
        units = Units(0.1 * k, 0.07 * k, 0.3 * k)
        beam = Beam(alpha=100, gamma=200, delta=20, mu=10000, spin_up=1000, root=0, units=units)
        same_beam(Beam.from_si(**beam.si), beam)
        same_beam(Scene.from_query(parse_query(Scene(beam).to_query())).beam, beam)
