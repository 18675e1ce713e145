"""Warnings of what grows: the motion, its rate, and for how long that holds."""

import math

import pytest

from beamviz import Beam, Scene, Units, solve
from beamviz.beam import NUMBERS
from beamviz.drawing.text import described, out_of_range, stability_warning
from beamviz.exports.solved_scene import Loop, SolvedScene

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
    assert "Unstable" not in warning
    assert "B2 grows" in warning
    assert f"{math.log(10) / solution.growth_rates.max():.2g} T*" in warning
    assert warning.endswith("at this instant")


def test_a_disturbance_without_vibration_is_instability():
    """In T*, or in milliseconds for a beam in SI; it holds for ever while the speed is constant."""
    assert stability_warning(solve(Beam(gamma=5))) == ""
    rate = solve(BUCKLED).growth_rates.max()
    warning = stability_warning(solve(BUCKLED))
    assert warning.startswith("Unstable in bending\n")
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
    """With its limits in that unit; a number without a unit is left to the error itself."""
    beam = Beam.from_si(**ROD)
    numbers, units = {name: getattr(beam, name) for name in NUMBERS}, beam.units
    assert out_of_range(numbers, units) == ""
    low, high = (2000 * limit for limit in NUMBERS["delta"].limits)
    named = out_of_range(numbers | {"delta": 30.0}, units)
    assert named == f"hub [mm] = 60000: must lie in {low:.0f} .. {high:.0f}"
    fast = out_of_range(numbers | {"gamma": 1e300}, units)
    assert fast.startswith("speed [rpm] = ")
    assert len(fast) < 100
    assert out_of_range(numbers | {"delta": 30.0}, None) == ""
    assert out_of_range(numbers | {"gamma": None, "mu": 1.0}, units) == ""


def test_a_beam_is_described_in_its_units():
    """By its numbers alone without."""
    beam = Beam.from_si(**ROD, mass=3.0)
    assert described(beam).startswith("mass 3 kg, position 2000 mm, speed 0 rpm, hub 0 mm, μ = ")
    assert described(Beam(alpha=1)).startswith("α = 1, β = 1, γ = 0")
