"""Stress of beams of a known material, and their loads in N and N m, against hand calculations."""

import json
import math

import pytest

from beamviz import Beam, InvalidInput, Ramp, Scene, motion, solve
from beamviz.output.motion import motion_json, motion_table
from beamviz.output.solution import solution_json, solution_table
from beamviz.scene import parse_query

# A bar of steel, 1.2 m long, 50 mm wide and 10 mm thick, with 2 kg at 0.9 m.
BAR = {
    "length": 1.2,
    "density": 7850.0,
    "area": 5e-4,
    "second_moment": 0.05 * 0.01**3 / 12,
    "youngs_modulus": 210e9,
    "section_height": 0.01,
    "yield_stress": 235e6,
    "mass": 2.0,
    "mass_position": 0.9,
}


def test_the_axial_stress_is_the_pull_of_all_mass_beyond_over_the_area():
    """Omega^2 (rho A (L^2 - x^2) / 2 + m d) / A; 2e-4: the beam is stretched by 1e-4 at most."""
    speed = 60.0
    found = solve(Beam.from_si(**BAR, rotation_speed=speed)).equilibrium
    for x, carried in ((0.0, 2.0 * 0.9), (0.6, 2.0 * 0.9), (0.96, 0.0)):
        pull = speed**2 * (7850 * 5e-4 * (1.2**2 - x**2) / 2 + carried)
        stress = found.stress([x / 1.2])
        assert stress.axial[0] == pytest.approx(pull / 5e-4, rel=2e-4)
        assert (stress.bending[0], stress.greatest[0]) == (0, stress.axial[0])
    greatest = found.greatest_stress
    assert (greatest.pascals, greatest.at) == (found.stress([0.0]).greatest[0], 0)
    assert not greatest.yields


def test_a_stretch_of_258_megapascals_is_above_the_yield_stress():
    """Steel that is stretched by 0.123 %: E times the stretch."""
    values = BAR | {"length": 1.0, "mass": 0.0, "mass_position": 1.0}
    equilibrium = solve(Beam.from_si(**values, rotation_rpm=2450)).equilibrium
    assert equilibrium.max_stretch - 1 == pytest.approx(0.00123, rel=1e-3)
    assert equilibrium.greatest_stress.pascals == pytest.approx(210e9 * 0.00123, rel=3e-3)
    assert equilibrium.greatest_stress.yields


def test_a_beam_that_spins_up_bends_by_its_inertia():
    """At the root the moment of the Euler force, [N m] (rho A L^3 / 3 + m d^2) dOmega/dt, which at
    a low speed bends the beam by little, and the stress M h / (2 I) of a section of height h."""
    values = BAR | {"rotation_speed": 1.0, "angular_acceleration": 2.0}
    beam = Beam.from_si(**values)
    found = solve(beam, state="stable").equilibrium
    moment = 2.0 * (7850 * 5e-4 * 1.2**3 / 3 + 2.0 * 0.9**2)
    assert abs(beam.units.newton_metres(found.root_moment)) == pytest.approx(moment, rel=1e-3)
    stress = found.stress([0.0])
    in_fibre = moment * 0.005 / BAR["second_moment"]
    assert stress.bending[0] == pytest.approx(in_fibre, rel=1e-3)
    assert stress.greatest[0] == pytest.approx(in_fibre + abs(stress.axial[0]), rel=1e-3)
    assert found.greatest_stress.pascals == stress.greatest[0]
    without = {name: value for name, value in values.items() if name != "section_height"}
    unknown = solve(Beam.from_si(**without), state="stable").equilibrium
    assert unknown.stress([0.0]).bending is None
    assert unknown.greatest_stress.pascals == pytest.approx(abs(stress.axial[0]), rel=1e-3)
    assert not unknown.greatest_stress.with_bending


def test_an_inward_beam_is_compressed_most_where_its_force_is_greatest():
    """Root at 0.7 L, on the far side of the axis: the force is greatest on the axis, in tension and
    compression alike, (Omega^2 rho L^2 / 2) ((0.3)^2 .. 0.7^2 - 0.3^2)."""
    values = BAR | {"mass": 0.0, "hub_radius": -0.84, "rotation_speed": 20.0}
    found = solve(Beam.from_si(**values)).equilibrium
    unit = 20.0**2 * 7850 * 1.2**2 / 2
    assert found.stress([0.0]).axial[0] == pytest.approx(unit * (0.09 - 0.49), rel=1e-3)
    assert found.stress([0.7]).axial[0] == pytest.approx(unit * 0.09, rel=1e-3)
    assert found.greatest_stress.pascals == pytest.approx(unit * 0.4, rel=1e-3)
    assert found.greatest_stress.at == 0


def test_a_beam_that_is_pulled_bends_as_statics_says():
    """By a force F at its tip: F L h / (2 I) at the root, as it is let go; pulled aside by 0.4 m
    a bar 10 mm thick is far beyond its yield stress."""
    values = BAR | {"length": 1.0, "mass": 0.0, "mass_position": 1.0}
    beam = Beam.from_si(**values)
    unit = 210e9 * BAR["second_moment"]  # E I / L^2 [N]
    held = motion(beam, 1e-4, release=0.05, points=2).greatest_stress
    assert held.pascals == pytest.approx(0.05 * unit * 0.005 / BAR["second_moment"], rel=0.01)
    assert (held.at, held.yields) == (0, False)
    far = motion(beam, 1.0, release=1.5, tolerance=1e-2)
    assert abs(far.tip[0, 1]) > 0.4
    assert far.greatest_stress.yields
    assert "above the yield stress of 235 MPa" in motion_table(far)
    record = json.loads(motion_json(far))
    assert record["max_stress_pascals"] == far.greatest_stress.pascals > 1e9
    assert motion(Beam(), 0.1, release=0.1, points=2).greatest_stress is None


def test_a_beam_that_keeps_its_speed_has_the_stress_of_its_equilibrium():
    """To the difference of stretch and force over area, of the order of the stretch."""
    beam = Beam.from_si(**BAR, rotation_speed=100.0)
    found = motion(beam, 0.1, points=3).greatest_stress
    still = solve(beam).equilibrium.greatest_stress
    assert found.pascals == pytest.approx(still.pascals, rel=0.01)


def test_the_outputs_have_the_greatest_stress():
    """In JSON in Pa, beside the yield stress; in the table in MPa, with what it means."""
    solution = solve(Beam.from_si(**BAR, rotation_speed=200.0))
    record = json.loads(solution_json(solution))
    greatest = solution.equilibrium.greatest_stress.pascals
    assert record["equilibrium"]["max_stress_pascals"] == greatest
    assert record["equilibrium"]["max_stress_at"] == 0
    assert record["units"]["yield_stress"] == 235e6
    (line,) = (one for one in solution_table(solution).splitlines() if one.startswith("Stress"))
    assert f"{greatest / 1e6:.5g} MPa at x/L = 0, above the yield stress of 235 MPa" in line
    plain = solve(Beam(gamma=5))
    assert plain.equilibrium.greatest_stress is None
    assert "max_stress_pascals" not in json.loads(solution_json(plain))["equilibrium"]
    assert "Stress" not in solution_table(plain)


def test_without_a_material_there_is_no_stress():
    """Of a beam by its stiffnesses, or without a size: the remedy is named."""
    values = {"length": 1, "mass_per_length": 1, "bending_stiffness": 10, "axial_stiffness": 1e6}
    for beam in (Beam(gamma=1), Beam.from_si(**values)):
        with pytest.raises(InvalidInput, match="youngs_modulus"):
            solve(beam).equilibrium.stress([0.0])
    for name in ("yield_stress", "section_height"):
        with pytest.raises(InvalidInput, match=f"{name} needs density, area"):
            Beam.from_si(**values, **{name: 1})


def test_a_section_is_as_high_as_its_second_moment_needs():
    """A height in mm, say, or in another direction: that of a rectangle is sqrt(12 I / A), the
    least one of any section 2 sqrt(I / A)."""
    least = 2 * math.sqrt(BAR["second_moment"] / BAR["area"])
    assert least == pytest.approx(0.01 / math.sqrt(3))
    with pytest.raises(InvalidInput, match=r"section_height = 0\.001: must be at least .*0\.0057"):
        Beam.from_si(**BAR | {"section_height": 0.001})


def test_yield_stress_and_height_are_kept():
    """By a scene file, a link, and a beam with another number; their synonyms are named."""
    beam = Beam.from_si(**BAR)
    for scene in (
        Scene.from_bytes(Scene(beam).to_toml().encode(), "saved"),
        Scene.from_query(parse_query(Scene(beam).to_query())),
    ):
        assert scene.beam.units.yield_stress == 235e6
        assert scene.beam.units.section_height == 0.01
    assert beam.replace(gamma=3).si["yield_stress"] == 235e6
    with pytest.raises(InvalidInput, match="did you mean 'yield_stress'"):
        Beam.from_si(**BAR, yield_strength=1)


def test_the_greatest_stress_of_a_motion_is_looked_for_to_its_end():
    """A bar that turns ever faster is bent most by its swing back, after half of the time."""
    beam = Beam.from_si(**BAR, rotation_speed=10.0)
    faster = Ramp(3.0, 2.0, "linear", start=beam.gamma)
    greatest = motion(beam, 2.0, speed=faster, damping=0.3, points=1601).greatest_stress
    assert greatest.t > 1.0
