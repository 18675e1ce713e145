"""Blades to start from: against what their sources say of them."""

import math

import numpy as np
import pytest

from beamviz.beam import Beam
from beamviz.errors import InvalidInput
from beamviz.presets import PRESETS, preset
from beamviz.solver import solve

NREL, STEEL = PRESETS["nrel-5mw-blade"], PRESETS["tapered-steel-blade"]


def hertz(beam: Beam, count: int, **options: str) -> np.ndarray:
    """The first frequencies [Hz]."""
    assert beam.units
    return beam.units.hertz(solve(beam, modes=count, **options).frequencies)


def test_the_wind_turbine_blade_has_the_mass_and_size_of_its_source():
    """NREL/TP-500-38060, section 2: 61.5 m, 17740 kg, 1.5 m from the axis, 12.1 rpm. 1 % for the
    mass: the report does not say how it interpolates between the stations."""
    it = NREL.beam.physical
    assert np.trapezoid(it.mass_per_length, it.stations) == pytest.approx(17740, rel=0.01)
    assert (it.length, it.hub_radius) == pytest.approx((61.5, 1.5))
    assert NREL.beam.units.rpm(NREL.beam.gamma) == pytest.approx(12.1)
    assert len(it.stations) == 49


@pytest.mark.parametrize(
    ("plane", "published", "reason"),
    [
        ("flapwise", (0.6296, 0.7019), "asymmetric with yaw, by ADAMS, to collective, by ADAMS"),
        ("chordwise", (1.0740, 1.0898), "asymmetric with pitch, by ADAMS, to yaw, by FAST"),
    ],
)
def test_the_wind_turbine_blade_vibrates_as_published_at_rest(plane, published, reason):
    """NREL/TP-500-38060, table 9-1, rotor at rest: first flapwise and edgewise frequencies of the
    blades on the turbine. 1 %: the twist, 13 degrees at the root, turns a share of sin(13)^2 = 5 %
    of the edgewise stiffness near the root into flapwise, and tower and shaft move a little."""
    low, high = published
    first = hertz(NREL.beam.replace(gamma=0.0), 1, plane=plane)[0]
    assert 0.99 * low < first < 1.01 * high, reason


TWISTED = {  # mass [kg] (tolerance: stations are linear here), twist at root and tip [deg]
    "nrel-5mw-twisted-blade": (17740, 0.01, 13.308, 0),
    "iea-3.4mw-blade": (16441, 0.12, 20, -4.64),  # of another release in the report
    "iea-10mw-blade": (47700, 0.04, 12, -0.04),  # the same
    "iea-15mw-blade": (65250, 0.001, 15.59, -1.24),
}


@pytest.mark.parametrize(("name", "values"), TWISTED.items())
def test_the_blades_with_twist_have_the_mass_and_the_twist_of_their_sources(name, values):
    mass, tolerance, root, tip = values
    it = preset(name).beam.physical
    assert np.trapezoid(it.mass_per_length, it.stations) == pytest.approx(mass, rel=tolerance)
    assert (it.twists[0], it.twists[-1]) == pytest.approx((root, tip), abs=0.01)


def test_the_iea_15_mw_blade_vibrates_as_published_at_rest():
    """NREL/TP-5000-75698, table 2-1: first flapwise 0.555 Hz, first edgewise 0.642 Hz."""
    beam = preset("iea-15mw-blade").beam.replace(gamma=0.0)
    assert hertz(beam, 2, plane="both") == pytest.approx([0.555, 0.642], abs=0.001)


def test_the_nrel_blade_has_its_twist_or_none():
    assert preset("nrel-5mw-twisted-blade").beam.is_turned
    assert not NREL.beam.is_turned


def test_the_steel_blade_is_the_taper_of_its_source():
    """Ozdemir Ozgumus & Kaya (2006), c = 0.5: 3.8238, 18.3173, 47.2648 at rest, in units of
    sqrt(E I / rho A L^4) of flapwise bending at the root, for a beam that is not stretched."""
    E, rho, b, h, L = 210e9, 7850.0, 0.04, 0.012, 1.0
    unit = math.sqrt(E * h * h / 12 / rho) / L**2 / (2 * math.pi)
    found = hertz(STEEL.beam.replace(gamma=0.0), 3, plane="flapwise")
    assert found / unit == pytest.approx([3.82378, 18.31726, 47.26483], rel=2e-6)
    it = STEEL.beam.physical
    assert it.mass_per_length[0] == pytest.approx(rho * b * h)
    assert it.axial_stiffness[-1] == pytest.approx(E * b * h / 2)
    assert it.bending_stiffness[-1] == pytest.approx(E * h / 2 * b**3 / 12)


@pytest.mark.parametrize("one", PRESETS.values(), ids=PRESETS)
def test_each_preset_is_stable_in_both_planes_and_plausible(one):
    assert one.beam.doubts == ()
    assert len(one.source) > 50
    for plane in ("both",) if one.beam.is_turned else ("chordwise", "flapwise"):
        assert solve(one.beam, plane=plane).equilibrium.status == "stable"


def test_an_unknown_preset_is_refused_with_the_names():
    assert preset("nrel-5mw-blade") is NREL
    with pytest.raises(InvalidInput, match=r"'rotor': must be one of .*nrel-5mw-blade"):
        preset("rotor")
