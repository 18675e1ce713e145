"""Mass, centre and moments of a beam."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from scipy.integrate import quad
from strategies import physical_beams

from beamviz import Beam
from beamviz.presets import preset


@settings(max_examples=15)
@given(physical_beams(by_stations=True))
def test_they_are_integrals_of_the_mass(values):
    beam = Beam.from_si(**values)
    properties, L, hub = beam.mass_properties, beam.units.length, beam.delta * beam.units.length
    line_density = beam.units.mass / L
    blade = beam.blade
    breaks = (0.0, 1.0) if blade is None else blade.breaks

    def moment(power: int, offset: float = 0.0) -> float:
        def density(x: float) -> float:
            m = 1.0 if blade is None else float(blade.at("mass", np.array(x)))
            return line_density * m * (L * x + offset) ** power * L

        parts = pairwise(breaks)
        return sum(quad(density, a + 1e-12, b - 1e-12)[0] for a, b in parts)

    assert properties.mass == pytest.approx(moment(0), rel=1e-8)
    assert properties.centre == pytest.approx(moment(1) / moment(0), rel=1e-8)
    assert properties.second_moment_about_root == pytest.approx(moment(2), rel=1e-8)
    expected = [moment(1, hub), moment(2, hub)]
    about_axis = [properties.first_moment_about_axis, properties.second_moment_about_axis]
    scale = beam.units.mass * (L + abs(hub)) ** 2
    assert about_axis == pytest.approx(expected, rel=1e-8, abs=1e-9 * scale)


def test_those_of_the_reference_blade():
    """17 740 kg, centre 20.475 m from the root, 11.776e6 kg m^2 about it (NREL/TP-500-38060, table
    2-2), to the 1 % by which that table differs from its table of sections, linear between them."""
    properties = preset("nrel-5mw-blade").beam.mass_properties
    assert properties.mass == pytest.approx(17740, rel=0.01)
    assert properties.centre == pytest.approx(20.475, rel=0.01)
    assert properties.second_moment_about_root == pytest.approx(11.776e6, rel=0.01)
