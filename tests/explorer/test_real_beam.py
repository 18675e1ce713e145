"""Real beams: what their sources say of them, and the panel to enter one."""

import contextlib
import json
import math
import re
import threading
from functools import partial
from html import escape
from typing import Any

import pytest
from helpers import slow
from hypothesis import assume, given
from hypothesis import strategies as st
from live.offline import Desk, offline
from live.visitor import Visitor

from beamviz.beam import Beam
from beamviz.errors import InvalidInput
from beamviz.explorer.features import real_beam
from beamviz.explorer.state import Case, State
from beamviz.presets import PRESETS as BLADES
from beamviz.scene import Scene
from beamviz.solver import solve
from beamviz.solver.problem import CHOICES

SIZES = {size for section in real_beam.SECTIONS.values() for size in section.sizes}


def first(beam: Beam, **options: str) -> float:
    """The first frequency [Hz]."""
    return float(beam.units.hertz(solve(beam, **options).frequencies[0]))


def test_the_arm_has_the_stiffness_and_mass_of_its_source():
    """EI 1.4e4 N m^2, EA 2.8e7 N, 1.2 kg/m, 10 m, 6 rad/s."""
    it = real_beam.ARM.values
    assert it["youngs_modulus"] * it["second_moment"] == pytest.approx(1.4e4)
    assert it["youngs_modulus"] * it["area"] == pytest.approx(2.8e7)
    assert it["density"] * it["area"] == pytest.approx(1.2)
    assert (it["length"], it["rotation_speed"]) == (10, 6)


def test_the_blade_has_mass_and_frequency_of_its_source():
    """17740 kg, 61.5 m, hub radius 1.5 m, 12.1 rpm, first flapwise frequency 0.67 Hz at rest."""
    beam = real_beam.BLADE.beam
    assert beam.units.mass == pytest.approx(17740)
    assert beam.delta * beam.units.length == pytest.approx(1.5)
    assert beam.units.rpm(beam.gamma) == pytest.approx(12.1)
    at_rest = first(beam.replace(gamma=0), plane="flapwise")
    assert at_rest == pytest.approx(0.67, abs=0.001)
    assert first(beam, plane="flapwise") > at_rest


def test_the_ruler_is_a_rectangle_of_steel():
    """Without its clip f = 3.516 / (2 pi) sqrt(E / 12 rho) h / L^2, with h = 1 mm."""
    at_rest = Beam.from_si(**{**real_beam.RULER.values, "mass": 0.0, "rotation_speed": 0.0})
    thick = 3.5160153 / (2 * math.pi) * math.sqrt(210e9 / 12 / 7850) * 1e-3 / 0.3**2
    assert first(at_rest) == pytest.approx(thick, rel=1e-6)
    assert at_rest.mu == pytest.approx(math.sqrt(12) * 300)


@pytest.mark.parametrize("real", real_beam.PRESETS.values(), ids=real_beam.PRESETS)
def test_each_real_beam_is_stable_and_slender(real):
    """In both planes, with a usual speed: gamma below 10."""
    for plane in CHOICES["plane"]:
        assert solve(real.beam, plane=plane).equilibrium.status == "stable"
    assert real.beam.mu > 50
    assert 0 < real.beam.gamma < 10
    assert len(real.source) > 50


BAR = {"length": 0.5, "density": 7850.0, "youngs_modulus": 210e9}
B, H = 0.05, 0.01  # [m] sizes of the bar


def desk_of(beam: Beam, **view: Any) -> Desk:
    """The page of a beam that stands still."""
    return Desk(Scene(beam).changed(playing=False, **view))


def bar_at(gamma: float) -> dict[str, Any]:
    """The values of a bar of 50 x 10 mm on its edge, at a speed of gamma / T* of bending over h."""
    T = BAR["length"] ** 2 * math.sqrt(7850 * 12 / 210e9) / H
    return real_beam.in_si(BAR | real_beam.on_edge(B, H) | {"rotation_speed": gamma / T})


def test_a_bar_is_as_stiff_in_each_plane_as_it_lies():
    """E b h^3 / 12 over h, E h b^3 / 12 over b, which is 25 times as much. Bending out of the plane
    has 4.7973 / T* at gamma = 3 for the one (Wright et al., J. Appl. Mech. 49, 1982, table 1), and
    sqrt(3.5160^2 + 1.1933 gamma^2) / T* at gamma = 0.6 for the other, whose T* is a fifth (the
    coefficient is Southwell's); in the plane omega^2 is less by Omega^2. 5e-4, as the
    stretch of the beam, 2e-4, is in none of these."""
    edge = Beam.from_si(**bar_at(3.0))
    flat = real_beam.with_section(edge, "flat")
    assert flat.si["second_moment"] == pytest.approx(H * B**3 / 12)
    assert flat.si["flap_stiffness"] == pytest.approx(210e9 * B * H**3 / 12)
    stiff = 5 * math.sqrt(3.51602**2 + 1.1933 * 0.6**2)
    expected = {
        (edge, "flapwise"): stiff,
        (edge, "chordwise"): math.sqrt(4.7973**2 - 3**2),
        (flat, "flapwise"): 4.7973,
        (flat, "chordwise"): math.sqrt(stiff**2 - 3**2),
    }
    hertz = edge.units.hertz(1.0)
    for (beam, plane), omega in expected.items():
        assert first(beam, plane=plane) == pytest.approx(omega * hertz, rel=5e-4), plane
    assert real_beam.with_section(flat, "rectangle", "flat").si == pytest.approx(edge.si)


def test_a_bar_stands_as_it_lies_and_its_link_and_files_keep_that():
    """In the scene it has its sizes in the plane of rotation and out of it, whichever it moves in;
    the fields keep b and h. A visitor who opens the link or the file sees the same."""

    def drawn(desk: Desk) -> list[float]:
        """The smallest sizes of a piece along and across the beam, in the frame of the hub."""
        desk.guest.visitor.receive()
        return desk.guest.visitor.nodes["/scene/rotor/beam"]["batched_scales"][0][1:].tolist()

    def fields(desk: Desk) -> tuple[str, float, float]:
        desk.guest.visitor.receive()
        values = desk.guest.visitor.values
        names = ("real.section", "real.width", "real.thickness")
        return tuple(values[name] for name in names)  # type: ignore[return-value]

    with offline():
        desk = desk_of(Beam.from_si(**bar_at(3.0)), shares=[0.0])
        for kind, sizes in (("rectangle", [H, B]), ("flat", [B, H])):
            desk.do("real.section", kind)
            desk.frame(2)
            assert fields(desk) == (kind, pytest.approx(50), pytest.approx(10))
            for plane in ("flapwise", "chordwise"):
                desk.edit("plane", plane)
                assert drawn(desk) == pytest.approx([one / 0.5 for one in sizes], rel=1e-6), plane
        linked, filed = desk_of(Beam()), desk_of(Beam())
        linked.do("link", f"?{desk.address}")
        filed.do("load", f"bar.toml\n{desk.visitor.scene_to_save().to_toml()}")
        for other in (linked, filed):
            other.frame(3)
            assert fields(other) == ("flat", pytest.approx(50), pytest.approx(10))
            assert other.state.case.beam.si == pytest.approx(desk.state.case.beam.si)


def test_a_section_is_shown_as_what_it_is():
    """A bar by its stiffnesses, a section as stiff in both planes by its values: no rectangle is,
    but a square; a tube where one was chosen."""
    square = real_beam.own_section(1e-4, 1e-8 / 12)
    values = BAR | {"rotation_speed": 0.0, "area": 2e-4, "second_moment": 4e-9}
    beam = Beam.from_si(**values)
    assert real_beam.kind_of(beam, "rectangle") == real_beam.kind_of(beam, "") == "own"
    assert real_beam.kind_of(beam, "tube") == "tube"
    as_edge = real_beam.with_section(beam, "rectangle")  # of the same values in the plane
    assert as_edge.si["area"] == pytest.approx(2e-4)
    assert as_edge.si["second_moment"] == pytest.approx(4e-9)
    assert "flap_stiffness" in as_edge.si
    assert real_beam.kind_of(Beam.from_si(**real_beam.in_si(BAR | square)), "") == "rectangle"


def test_a_beam_whose_material_is_not_known_has_its_stiffnesses_in_a_table():
    """Its numbers are in SI: it is not said to be dimensionless."""
    si = {"length": 1.0, "mass_per_length": 1.2, "bending_stiffness": 60.0, "axial_stiffness": 3e7}
    with offline():
        desk = desk_of(Beam.from_si(**si, rotation_rpm=300))
        desk.guest.visitor.receive()
        assert desk.guest.visitor.texts["real-beam"] == ""
        table = desk.guest.visitor.values["blade.stations"]
        assert [row.split("\t")[:3] for row in table.split("\n")] == [
            ["0", "1.2", "60"],
            ["1", "1.2", "60"],
        ]


def test_an_own_material_is_typed():
    """The choice of one brings the field of its modulus; the values stay until then."""
    with offline():
        desk = desk_of(real_beam.STEEL_BEAM.beam)
        desk.do("real.material", "own")
        desk.frame(2)
        desk.guest.visitor.receive()
        focus = desk.guest.visitor.parts["focus"]
        assert f'id="{focus}"' in desk.guest.visitor.texts["real-beam"]
        assert focus.startswith("real.youngs_modulus")
        assert desk.state.case.beam.si == pytest.approx(real_beam.STEEL_BEAM.beam.si)


def fill(guest: Visitor, **values: Any) -> None:
    """Fill fields of the panel."""
    guest.set(**{f"real.{name}": value for name, value in values.items()})


def test_a_steel_beam_is_entered_in_one_panel(guest, caplog):
    """1.2 m x 30 mm x 5 mm at 600 rpm in Hz; the mass of the first scene is removed. Values are
    kept when others are edited, and can be undone. A field that is not there changes nothing."""
    values = {"area": 30e-3 * 5e-3, "second_moment": 30e-3 * 5e-3**3 / 12, "length": 1.2}
    values |= {"density": 7850.0, "youngs_modulus": 210e9, "rotation_speed": 600 * real_beam.RPM}
    guest.do("real.preset", "steel beam")
    fill(guest, length=1200, thickness=5)
    guest.set(gamma=600)  # rpm, by the slider of the speed
    guest.shows(Beam.from_si(**values))
    shown = {name: guest.values[f"real.{name}"] for name in real_beam.FIELDS.keys() - SIZES}
    expected = {"length": 1200, "youngs_modulus": 210, "density": 7850, "rotation_speed": 600}
    expected |= {"yield_stress": 235}  # MPa
    expected = dict.fromkeys(shown, 0) | expected | {real_beam.PERCENT: 100}
    assert shown == pytest.approx(expected, rel=1e-7)
    assert (guest.values["real.width"], guest.values["real.material"]) == (30, "steel")
    assert guest.text.count('data-set="plane"') == 1  # no choice stands twice on the page
    fill(guest, length=1000)
    guest.set(alpha=0.5, beta=500)  # kg, mm
    values |= {"length": 1.0, "mass": 0.5, "mass_position": 0.5}
    guest.shows(half := Beam.from_si(**values))
    fill(guest, material="aluminium")
    guest.shows(Beam.from_si(**values | {"density": 2700.0, "youngs_modulus": 70e9}))
    guest.choose("plane", "flapwise")
    guest.do("undo")
    guest.do("undo")
    guest.shows(half)
    guest.wait(lambda _: guest.values["real.material"] == "steel")
    guest.do("dimensionless")
    guest.shows(half.replace(units=None))
    for name, value in (("length", 900), ("material", "titanium"), ("section", "tube")):
        guest.do(f"real.{name}", value)
    guest.edit(gamma=half.gamma + 1)
    guest.do("real.preset", "wind blade")
    guest.shows(real_beam.BLADE.beam)
    guest.do("real.diameter", 20)
    guest.choose("real.length", 61)  # of this size in m
    guest.shows(Beam.from_si(**real_beam.BLADE.values | {"length": 61.0}))
    assert not caplog.records


MARKED = ["steel beam", "wind blade", "tapered-steel-blade", "nrel-5mw-twisted-blade"]
OTHERS = [name for name in (*real_beam.PRESETS, *BLADES) if name not in MARKED]


@pytest.mark.parametrize("name", [*MARKED, *slow(*OTHERS)])
def test_the_preset_with_the_numbers_of_the_beam_is_marked(guest, name):
    """Also one that is reached by other edits, and by a link; no other one, and none else."""
    key, preset = ("blade", BLADES[name]) if name in BLADES else ("real", real_beam.PRESETS[name])
    is_marked, speed = f"{key}.preset", preset.beam.si["rotation_speed"] / real_beam.RPM
    guest.do("link", "")  # from now on the page has an address
    guest.do(is_marked, name, until=lambda _: guest.values[is_marked] == name)
    (panel,) = (text for text in guest.texts.values() if f'data-set="{is_marked}"' in text)
    value = f'value="{name}"' if name in BLADES else f'data-value="{escape(json.dumps(name))}"'
    assert value in panel
    guest.choose("gamma", speed + 1, until=lambda _: not guest.values[is_marked])
    guest.wait(lambda _: "rotation_speed" in guest.parts["address"])
    address = guest.parts["address"]
    guest.choose("gamma", float(f"{speed:.8g}"), until=lambda _: guest.values[is_marked] == name)
    guest.wait(lambda _: guest.parts["address"] != address)
    link = f"?{guest.parts['address']}"
    guest.do("dimensionless", until=lambda _: not guest.values[is_marked])
    guest.do("link", link, until=lambda _: guest.values[is_marked] == name)
    guest.do("gamma", 1e12, until=lambda _: not guest.values[is_marked])  # out of range


def test_no_edit_is_lost_while_a_field_is_set():
    """As that of a command, which comes on another thread."""
    with offline():
        visitor = Desk(Scene(real_beam.STEEL_BEAM.beam).changed(playing=False)).visitor
        faster = partial(State.changed, name="gamma", value=2.0)
        other = threading.Thread(target=visitor.change, args=(faster,))

        def longer(beam: Beam) -> Beam:
            other.start()
            other.join(0.2)
            return real_beam.edited(beam, "length", 2000.0)

        real_beam.load(visitor, "real.length", longer)
        other.join()
        assert visitor.state.case.numbers["gamma"] == 2.0
        assert visitor.state.case.beam.si["length"] == pytest.approx(2.0)


def test_the_table_of_an_own_blade_is_offered_beside_every_real_beam(guest):
    """A visitor who tried another beam first finds it where it stood before."""
    offered = 'data-do="blade.begin"'
    guest.wait(lambda _: offered in guest.texts["real-beam"])
    guest.do("real.preset", "steel beam")
    guest.wait(lambda _: 'data-set="real.length"' in guest.texts["real-beam"])
    assert offered in guest.texts["real-beam"]


def test_a_section_is_a_rectangle_a_tube_or_two_values(guest):
    """A rod of 20 mm; the tube of this beam; the same beam by area and second moment. Invalid
    values are named and change nothing, nor do unknown presets, sections and fields."""
    guest.do("real.preset", "steel beam")
    guest.shows(real_beam.STEEL_BEAM.beam)
    guest.do("real.section", "tube")
    fill(guest, diameter=20, wall=10)
    rod = math.pi * 0.02**2 / 4, math.pi * 0.02**4 / 64
    guest.do("real.section", "own")
    guest.wait(lambda _: guest.values.get("real.area") == pytest.approx(1e6 * rod[0]))
    assert guest.values["real.second_moment"] == pytest.approx(1e12 * rod[1])
    guest.do("real.section", "tube")
    guest.choose("real.wall", 2)
    area = math.pi * (0.02**2 - 0.016**2) / 4
    guest.wait(lambda _: guest.values["real.area"] == pytest.approx(1e6 * area, rel=1e-6))
    for field, value in (("section", "triangle"), ("preset", "a broomstick"), ("colour", 3)):
        guest.do(f"real.{field}", value)
    guest.choose("real.wall", 11, until="wall t [mm] = 11: the wall is at most half the diameter")
    guest.choose("real.length", 0, until="length L [mm] = 0: must be above 0")
    assert guest.values["real.length"] == "0"  # as typed, with the reason below
    assert re.search(r'data-set="real.length"[^>]*aria-invalid="true"', guest.text)
    guest.choose("playing", False, until=lambda _: guest.values["playing"] is False)
    assert "must be above 0" in guest.text  # it is no edit of the beam
    guest.choose("real.length", 900, until=lambda _: "must be above 0" not in guest.text)
    guest.wait(lambda _: guest.values["real.length"] == 900)
    assert guest.values["real.wall"] == pytest.approx(2)


def test_the_height_is_that_of_the_section_and_the_yield_stress_that_of_the_material():
    """Of a rectangle the thickness, of a tube the diameter, of A and I none; other edits keep it.
    Glass fibre has no yield stress, and 0 means none."""

    def strength(beam: Beam) -> tuple[float | None, float | None]:
        assert beam.units
        return beam.units.section_height, beam.units.yield_stress

    bar = real_beam.STEEL_BEAM.beam
    assert strength(bar) == (5e-3, 235e6)
    thick = real_beam.edited(real_beam.edited(bar, "thickness", 8), "length", 900)
    assert strength(thick) == (pytest.approx(8e-3), 235e6)
    pipe = real_beam.edited(real_beam.with_section(thick, "tube"), "diameter", 30, "tube")
    assert strength(pipe) == (pytest.approx(30e-3), 235e6)
    assert strength(real_beam.with_section(pipe, "own", "tube")) == (None, 235e6)
    assert strength(real_beam.edited(pipe, "area", 200, "own")) == (None, 235e6)
    strong = real_beam.edited(bar, "yield_stress", 355)
    assert strength(strong)[1] == 355e6
    assert real_beam.material(strong) == "steel"
    assert strength(real_beam.with_material(strong, "titanium"))[1] == 828e6
    for other in (
        real_beam.with_material(strong, "glass fibre"),
        real_beam.edited(strong, "yield_stress", 0),
    ):
        assert strength(other) == (5e-3, None)


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("area", 0, r"area A \[mm²\] = 0: must be above 0"),
        ("density", -1, r"density ρ \[kg/m³\] = -1: must lie in 0 \.\."),
        (
            "second_moment",
            1e9,
            r"too thick .* 0.04743 must be at least 10\): make it longer or thinner",
        ),
        ("rotation_speed", 1e6, r"rotation speed Ω \[rpm\] = 1000000: must lie in 0 \.\. \d+"),
        ("mass", 1e6, r"mass m \[g\] = 1000000: must lie in 0 \.\. 5887\.5"),
        (real_beam.PERCENT, 101, r"mass at \[% of L\] = 101: must lie in 0 \.\. 100"),
        ("hub_radius", -700, r"hub radius a \[mm\] = -700: must lie in -600 \.\. 6000"),
        ("rotation_speed", math.nan, r"rotation speed Ω \[rpm\] = nan: must lie in"),
        ("youngs_modulus", math.inf, r"Young's modulus E \[GPa\] = inf: must lie in"),
        ("length", "long", r"length L \[mm\] = 'long': must be a number"),
        ("width", None, r"width b \[mm\] = None: must be a number"),
        ("width", 5e-324, r"width b \[mm\] = 4\.94066e-324: must be above 1e-30"),
        ("thickness", 1e-120, r"thickness h \[mm\] = 1e-120: must be above 1e-30"),
    ],
)
def test_errors_name_the_field_and_its_unit(name, value, words):
    """With the values allowed, not the five numbers or keywords."""
    with pytest.raises(InvalidInput, match=words) as told:
        real_beam.edited(real_beam.RULER.beam, name, value)
    assert not re.search(r"alpha|beta|gamma|delta|\bmu\b|_", str(told.value))


@given(
    st.sampled_from(sorted(real_beam.FIELDS)),
    st.floats(0.5, 2),
    st.sampled_from([*real_beam.PRESETS.values()]),
)
def test_an_edit_changes_one_field(name, factor, real):
    """All others keep their values, except those of other kinds of section; the spin-up too."""
    beam = real.beam.replace(spin_up=0.1)
    kind = real_beam.kind_of(beam, real.section)
    sizes = {*real_beam.SECTIONS[kind].sizes}
    shown = {*real_beam.FIELDS} - SIZES | sizes
    assume(name in shown)
    before = real_beam.entries(beam, kind)
    value = before[name] / real_beam.field_of(name, beam.units, beam.mu)[1] * factor
    with contextlib.suppress(InvalidInput):
        after = real_beam.entries(real_beam.edited(beam, name, value, kind), kind)
        assert after[name] == pytest.approx(before[name] * factor)
        for other in shown - {name}:
            assert after[other] == pytest.approx(before[other], rel=1e-9, abs=1e-12)


def test_a_value_in_another_unit_gets_a_note(guest):
    """A density in g/cm³ is possible, and said to be unusual."""
    guest.do("real.preset", "steel beam")
    guest.shows(real_beam.STEEL_BEAM.beam)
    assert "g/cm³" not in guest.text
    fill(guest, density=7.85)
    assert guest.says("a density in g/cm³")


@pytest.mark.parametrize("mu", [20.0, 500.0])
def test_a_slenderness_changes_the_height_of_the_section(mu):
    """Of the same shape: its link is read again, and a rectangle stays one."""
    case = Case.of(Scene(real_beam.STEEL_BEAM.beam)).changed("mu", mu)
    beam = case.beam
    assert beam.units.section_height / beam.units.length == pytest.approx(math.sqrt(12) / mu)
    again = Scene.from_bytes(Scene(beam).to_toml().encode(), "scene").beam
    assert again.mu == pytest.approx(mu)
