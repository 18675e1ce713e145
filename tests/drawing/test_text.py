"""Warnings of what grows: the motion, its rate, and for how long that holds."""

import math

import pytest

from beamviz import Beam, Scene, Units, solve
from beamviz.beam import NUMBERS
from beamviz.drawing.text import (
    described,
    duration,
    frequencies,
    length_text,
    measure,
    out_of_range,
    si_text,
    stability_warning,
    times,
)
from beamviz.exports.solved_scene import Loop, SolvedScene
from beamviz.presets import PRESETS
from beamviz.units import LADDERS, unit_for

SPUN_UP = Beam(gamma=0.1, mu=10000, spin_up=1000)
BUCKLED = Beam(gamma=5, delta=-1)
ROD = {
    "length": 2.0,
    "density": 7850,
    "area": 1e-4,
    "second_moment": 1e-9,
    "youngs_modulus": 2.1e11,
}


def test_a_vibration_that_grows_is_named_with_its_rate():
    """Of a beam that spins up B2 grows at 16.54 per T*, at this instant: its speed changes."""
    solution = solve(SPUN_UP, modes=2, state="stable")
    assert solution.growth_rates.max() == pytest.approx(16.54, abs=0.005)
    warning = stability_warning(solution)
    assert "Divergence" not in warning
    assert "B2 grows" in warning
    assert f"{math.log(10) / solution.growth_rates.max():.2g} T*" in warning
    assert warning.endswith("at this instant")


def test_a_disturbance_without_vibration_is_instability():
    """In T*, or in milliseconds for a beam in SI; it holds for ever while the speed is constant."""
    assert stability_warning(solve(Beam(gamma=5))) == ""
    rate = solve(BUCKLED).growth_rates.max()
    warning = stability_warning(solve(BUCKLED))
    assert warning.startswith("Divergence in bending\n")
    assert f"{math.exp(rate):.0f}-fold per T*" in warning
    assert "instant" not in warning
    slow = stability_warning(solve(BUCKLED.replace(units=Units(1.0, 0.01))))
    assert f"{10 * math.log(10) / rate:.3g} ms" in slow


def test_a_beam_whose_vibrations_grow_vibrates_in_pictures():
    """With the warning above it, coloured and in a film; an unstable one is grey and still."""
    grows = SolvedScene(Scene.of(SPUN_UP, mode=2, state="stable"))
    assert grows.drawn.warning == ""
    assert grows.drawn.note == stability_warning(grows.solution)
    assert Loop(grows).seconds > 0
    unstable = SolvedScene(Scene.of(BUCKLED, mode=2))
    assert unstable.drawn.warning == stability_warning(unstable.solution)


def test_a_number_out_of_range_is_named_in_its_own_unit():
    """With its limits in that unit, or without a unit; and so is each of several."""
    beam = Beam.from_si(**ROD)
    numbers, units = {name: getattr(beam, name) for name in NUMBERS}, beam.units
    assert out_of_range(numbers, units) == ""
    low, high = (2000 * limit for limit in NUMBERS["delta"].limits)
    named = out_of_range(numbers | {"delta": 30.0}, units)
    assert named == f"hub [mm] = 60000: must lie in {low:.0f} .. {high:.0f}"
    fast = out_of_range(numbers | {"gamma": 1e300}, units)
    assert fast.startswith("speed [rpm] = ")
    assert len(fast) < 100
    assert out_of_range(numbers | {"delta": 30.0}, None) == "hub δ = 30: must lie in -2 .. 20"
    several = out_of_range(numbers | {"alpha": 1e6, "gamma": None, "mu": 1.0}, units)
    for told in ("mass [kg] = ", "speed", "slenderness μ = 1: must lie in 10 .. 1e+06"):
        assert told in several
    assert out_of_range(numbers | {"alpha": 100.0, "mu": 10.0}, None) == ""


def test_a_beam_is_described_in_its_units():
    """By its numbers alone without."""
    beam = Beam.from_si(**ROD, mass=3.0)
    assert described(beam).startswith("mass 3 kg, position 2000 mm, speed 0 rpm, hub 0 mm, μ = ")
    assert described(Beam(alpha=1)).startswith("α = 1, β = 1, γ = 0")


@pytest.mark.parametrize("quantity", LADDERS)
def test_values_of_any_size_have_few_digits_before_and_behind_the_point(quantity):
    """Of the units that a quantity has one is chosen in which the number reads from 0.1 to 1e5, and
    the value does not change; 0 is in the SI unit."""
    sizes = {rung.unit: rung.size for rung in LADDERS[quantity]}
    assert sizes[quantity] == 1
    for exponent in range(-7, 9):
        for value in (10.0**exponent, -9.99 * 10.0**exponent):
            unit, size = unit_for(quantity, value)
            assert sizes[unit] == size
            if min(sizes.values()) <= abs(value) < 1000 * max(sizes.values()):
                assert 0.0999 < abs(value / size) < 1e5
    assert unit_for(quantity, 0.0) == (quantity, 1.0)


@pytest.mark.parametrize(
    ("value", "quantity", "text"),
    [
        (4789110.0, "N", "4.79 MN"),
        (-0.0312, "N m", "-31.2 mN m"),
        (17740.0, "kg", "17740 kg"),
        (3.2e5, "kg", "320 t"),
        (0.01, "kg", "10 g"),
        (0.1, "kg", "0.1 kg"),
        (1.2e-6, "kg", "1.2 mg"),
        (9330.0, "Hz", "9.33 kHz"),
        (0.133, "s", "133 ms"),
        (3e-7, "m", "0.3 µm"),
        (0.0, "N", "0 N"),
    ],
)
def test_a_value_in_si_has_the_prefix_that_suits_it(value, quantity, text):
    assert si_text(value, quantity, 3) == text


TINY = {  # a silicon cantilever of 3 mm
    "length": 3e-3,
    "density": 2330,
    "area": 0.5e-3 * 0.05e-3,
    "second_moment": 0.5e-3 * 0.05e-3**3 / 12,
    "youngs_modulus": 169e9,
}


def test_the_units_of_a_beam_suit_its_size():
    """A beam of 3 mm, one of 2 m and a blade of 61.5 m: each number of about 1 has the unit that
    its size asks for."""
    tiny, rod, blade = (
        beam.units
        for beam in (Beam.from_si(**TINY), Beam.from_si(**ROD), PRESETS["nrel-5mw-blade"].beam)
    )
    for name, units_of_each in {
        "alpha": ("mg", "kg", "kg"),
        "beta": ("mm", "mm", "m"),
        "delta": ("mm", "mm", "m"),
        "gamma": ("rpm", "rpm", "rpm"),
    }.items():
        assert tuple(measure(name, one).unit for one in (tiny, rod, blade)) == units_of_each
    assert [frequencies(one).unit for one in (tiny, rod, blade)] == ["kHz", "Hz", "Hz"]
    assert [times(one).unit for one in (tiny, rod, blade)] == ["µs", "s", "s"]
    assert length_text(1e-4, tiny, 2) == "0.3 µm"
    assert length_text(0.15, tiny, 2) == "0.45 mm"
    assert length_text(1e-7, blade, 1) == "6 µm"
    assert length_text(0.25, blade, 3) == "15.4 m"
    assert duration(10.0, blade).endswith(" s")
    assert duration(1.0, tiny).endswith(" µs")
