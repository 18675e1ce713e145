"""Strain laws: derivatives, limits, accuracy near f = 1, and the stretch of a force."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from beamviz.solver.constitutive import STRAIN_LAWS

STEP = 1e-30
laws = pytest.mark.parametrize("law", STRAIN_LAWS.values(), ids=STRAIN_LAWS.keys())


def slope(function, f):
    """The derivative of an analytic function by a complex step: exact to rounding."""
    return function(f + 1j * STEP).imag / STEP


@laws
@given(f=st.floats(0.2, 8.0))
def test_derivatives(law, f):
    """n = e e', and n' is the derivative of n."""
    f = np.float64(f)
    force = law.strain(f) * slope(law.strain, f)
    assert law.force(f) == pytest.approx(force, rel=1e-14, abs=1e-300)
    assert law.stiffness(f) == pytest.approx(slope(law.force, f), rel=1e-13, abs=1e-14)


@laws
@pytest.mark.parametrize("power", [20, 40, 52])
def test_no_cancellation_near_one(law, power):
    """A tiny stretch keeps its full relative accuracy: e = s + O(s^2) to the last digit."""
    small = 2.0**-power
    series = {"green": small + small**2 / 2, "biot": small, "hencky": math.log1p(small)}
    assert law.strain(np.float64(1 + small)) == pytest.approx(series[law.name], rel=3e-16, abs=0)


@laws
@given(n=st.floats(-0.15, 0.25))
def test_stretch_of_a_force(law, n):
    """The stretch a force gives carries that force; Hencky's roughly, near its greatest force."""
    assert law.force(law.stretch(n)) == pytest.approx(n, abs=3e-5)


@laws
def test_the_series_of_a_small_stretch(law):
    """Three terms: what is missing falls with the fourth power of the force."""
    n = np.array([0.02, 0.01])
    f = law.stretch_series(n)
    missing = abs(law.force(f) - n)
    assert np.all(missing < 16 * n**4)
    assert missing[1] < missing[0] / 14 + 1e-16


@given(n=st.floats(0.4, 1e6))
def test_hencky_stretches_no_further_than_its_law_goes(n):
    """More than its greatest force leaves it near the stretch where that is carried."""
    law = STRAIN_LAWS["hencky"]
    assert 2 < law.stretch(n) <= law.max_stretch
