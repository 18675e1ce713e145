"""Real beams: what their sources say of them, and the form to enter one."""

import math
import re

import pytest
from live.visitor import Visitor, frequency_text, visitor

from beamviz.beam import Beam
from beamviz.drawing.text import rounded_to_error, significant
from beamviz.errors import InvalidInput
from beamviz.explorer.features.real_beam import (
    ARM,
    BLADE,
    DIMENSIONLESS,
    FIELDS,
    REAL_BEAM,
    REAL_BEAMS,
    RPM,
    RULER,
    parse_beam,
)
from beamviz.solver import solve

CANTILEVER = 3.5160153  # omega_1 of a clamped beam at rest


def first(beam: Beam, **options: str) -> float:
    """The first frequency [Hz]."""
    assert beam.units
    return float(beam.units.hertz(solve(beam, **options).frequencies[0]))


# What the sources say


def test_the_arm_has_the_stiffness_and_mass_of_its_source():
    """EI 1.4e4 N m^2, EA 2.8e7 N, 1.2 kg/m, 10 m, 6 rad/s."""
    it = ARM.values
    assert it["youngs_modulus"] * it["second_moment"] == pytest.approx(1.4e4)
    assert it["youngs_modulus"] * it["area"] == pytest.approx(2.8e7)
    assert it["density"] * it["area"] == pytest.approx(1.2)
    assert (it["length"], it["rotation_speed"]) == (10, 6)
    assert ARM.beam.mu == pytest.approx(10 * math.sqrt(2.8e7 / 1.4e4))


def test_the_blade_has_mass_and_frequency_of_its_source():
    """17740 kg, 61.5 m, hub radius 1.5 m, 12.1 rpm, first flapwise frequency 0.67 Hz at rest."""
    beam = BLADE.beam
    assert beam.units
    assert beam.units.mass == pytest.approx(17740)
    assert beam.delta * beam.units.length == pytest.approx(1.5)
    assert beam.units.rpm(beam.gamma) == pytest.approx(12.1)
    at_rest = first(beam.replace(gamma=0), plane=BLADE.plane)
    assert at_rest == pytest.approx(0.67, abs=0.001)
    assert first(beam, plane=BLADE.plane) > at_rest


def test_the_ruler_is_a_rectangle_of_steel():
    """Without its clip f = 3.516 / (2 pi) sqrt(E / 12 rho) h / L^2, with h = 1 mm."""
    at_rest = Beam.from_si(**{**RULER.values, "mass": 0.0, "rotation_speed": 0.0})
    thick = CANTILEVER / (2 * math.pi) * math.sqrt(210e9 / 12 / 7850) * 1e-3 / 0.3**2
    assert first(at_rest) == pytest.approx(thick, rel=1e-6)
    assert at_rest.mu == pytest.approx(math.sqrt(12) * 300)


@pytest.mark.parametrize("real", REAL_BEAMS, ids=lambda real: real.name)
def test_each_real_beam_is_stable_and_slender(real):
    """And its speed is one of an everyday machine: gamma below 10."""
    solution = solve(real.beam, plane=real.plane)
    assert solution.equilibrium.status == "stable"
    assert real.beam.mu > 50
    assert 0 < real.beam.gamma < 10
    assert len(real.source) > 50


# The form


def entries(**changes: object) -> dict[str, object]:
    """The entries for the ruler, some of them changed."""
    units = {name: unit for name, (_, unit) in FIELDS.items()}
    texts = {name: f"{RULER.values.get(name, 0.0) / unit:g}" for name, unit in units.items()}
    return {**texts, **changes}


def test_entries_are_in_the_units_of_their_fields():
    """Millimetres, gigapascals and revolutions per minute; text that is no number is named."""
    beam = parse_beam(entries(rotation_speed="600", hub_radius=" 1.5e2 "))
    values = {**RULER.values, "rotation_speed": 20 * math.pi, "hub_radius": 0.15}
    assert beam.numbers == pytest.approx(Beam.from_si(**values).numbers)
    for text in ("1,5", "", "steel", None):
        with pytest.raises(InvalidInput, match=r"length L .mm. = .*must be a number"):
            parse_beam(entries(length=text))
    assert pytest.approx(2 * math.pi / 60) == RPM


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"area": "0"}, r"section area A \[mm²\] = 0: must be above 0"),
        ({"density": "-1"}, r"density ρ \[kg/m³\] = -1: must lie in 0 \.\."),
        ({"second_moment": "1e9"}, r"L √\(A / I\) = 0.04743: must lie in 10 \.\. 10000"),
        ({"rotation_speed": "1e6"}, r"rotation speed Ω \[rpm\] = 1000000: must lie in 0 \.\. \d+"),
        ({"mass": "1e3"}, r"mass m \[kg\] = 1000: must lie in 0 \.\. 5\.8875"),
        ({"mass_position": "400"}, r"mass at d \[mm\] = 400: must lie in 0 \.\. 300"),
        ({"hub_radius": "-700"}, r"hub radius a \[mm\] = -700: must lie in -600 \.\. 6000"),
        ({"rotation_speed": "nan"}, r"rotation speed Ω \[rpm\] = nan: must lie in"),
        ({"youngs_modulus": "inf"}, r"Young's modulus E \[GPa\] = inf: must lie in"),
    ],
)
def test_what_cannot_be_is_named_as_it_was_entered(changes, words):
    """A label, its unit and what is allowed in it; none of the five numbers nor of the keywords."""
    with pytest.raises(InvalidInput, match=words) as told:
        parse_beam(entries(**changes))
    assert not re.search(r"alpha|beta|gamma|delta|\bmu\b|_", str(told.value))


def test_large_numbers_have_no_power_of_ten():
    """48170 mm, not 4.817e+04 mm."""
    assert [significant(v, 4) for v in (48170.4, 1234.56, 123.456, 0.0123456)] == [
        "48170",
        "1235",
        "123.5",
        "0.01235",
    ]


def opened(guest: Visitor) -> None:
    """Open the form, another one where there was one."""
    guest.controls.pop("Show this beam", None)
    guest.choose("units", REAL_BEAM)
    guest.wait(lambda _: "Show this beam" in guest.controls)
    guest.says("laboratory rule")


def hertz(real: Beam, **options: str) -> str:
    """The first frequency as the table prints it."""
    assert real.units
    solution = solve(real, **options)
    frequency, error = solution.frequencies[0], solution.errors[0]
    return rounded_to_error(real.units.hertz(frequency), real.units.hertz(error))


def test_a_real_beam_is_entered_and_left_again(url):
    """The ruler as it is; then plain numbers; its fields changed; a blade out of the plane."""
    with visitor(url) as guest:
        opened(guest)
        guest.choose("Show this beam", True)
        guest.says(hertz(RULER.beam))
        guest.says("300 rpm")
        guest.wait(lambda _: guest.texts["gamma-label"] == "speed [rpm]")
        guest.choose("units", DIMENSIONLESS)
        guest.wait(lambda _: guest.texts["gamma-label"] == "speed γ")
        guest.says(frequency_text(RULER.beam))
        opened(guest)
        guest.choose("start from", BLADE.name)
        guest.says("5 MW")
        guest.choose("rotation speed Ω [rpm]", "6")
        guest.choose("Show this beam", True)
        slow = Beam.from_si(**{**BLADE.values, "rotation_speed": 6 * RPM})
        guest.says(hertz(slow, plane="flapwise"))


def test_wrong_sizes_are_named_and_lose_nothing(url):
    """The form stays open with the reason; the beam of the scene stays what it is."""
    with visitor(url) as guest:
        before = guest.text
        opened(guest)
        guest.choose("length L [mm]", "long")
        guest.choose("Show this beam", True)
        guest.says("length L [mm] = &#x27;long&#x27;: must be a number")
        guest.choose("length L [mm]", "0")
        guest.choose("Show this beam", True)
        guest.says("length L [mm] = 0: must be above 0")
        guest.choose("length L [mm]", "200")
        guest.choose("Show this beam", True)
        guest.says("mass at d [mm] = 300: must lie in 0 .. 200<")
        guest.choose("start from", "a broomstick")
        guest.choose("Cancel", True)
        guest.choose("gamma", 11.0)
        guest.says(frequency_text(Beam(alpha=1, beta=0.5, gamma=11)))
        assert "Stable equilibrium" in before
