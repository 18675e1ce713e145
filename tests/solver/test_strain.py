"""Strain laws: derivatives, limits, accuracy near f = 1, and the stretch of a force."""

import math
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from oracle.equilibrium import BY_HAND, law_of_energy

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
    """A tiny stretch keeps its full relative accuracy: the slope of every strain at f = 1 is 1, and
    its curvature, by a complex step of the slope's secant, is all that is left."""
    small = 2.0**-power
    curvature = (slope(law.strain, 1 + small) - 1) / small if power < 30 else 0.0
    expected = small + curvature * small**2 / 2
    assert law.strain(np.float64(1 + small)) == pytest.approx(expected, rel=2e-12)


@laws
@given(share=st.floats(0.001, 0.999))
def test_stretch_of_a_force(law, share):
    """The stretch a force gives carries that force, up to the limits of the law."""
    for limit in law.force_limits:
        n = np.array([share * limit if math.isfinite(limit) else math.copysign(10 * share, limit)])
        f = law.stretch_from_force(n)
        assert law.min_stretch <= f[0] <= law.max_stretch
        assert law.force(f) == pytest.approx(n, rel=1e-7, abs=1e-12)


@laws
def test_beyond_its_limits_a_force_has_the_stretch_there(law):
    """So that a first guess of the stretch is one."""
    for limit, end in zip(law.force_limits, (law.min_stretch, law.max_stretch), strict=True):
        if math.isfinite(limit):
            assert law.stretch_from_force(np.array([2 * limit]))[0] == pytest.approx(end, abs=0.01)


@laws
def test_a_law_survives_pickling(law):
    """Solutions hold their law, and are sent between processes."""
    assert pickle.loads(pickle.dumps(law)) is law


@pytest.mark.parametrize("name", BY_HAND)
def test_the_oracle_derives_a_law_from_its_energy(name):
    """As the formulas by hand: random beams are drawn with a law that has none, too."""
    derived, by_hand = law_of_energy(STRAIN_LAWS[name].strain), BY_HAND[name]
    f = np.linspace(0.7, 2.5, 37)
    assert derived.force(f) == pytest.approx(by_hand.force(f), rel=1e-12, abs=1e-13)
    assert derived.stiffness(f) == pytest.approx(by_hand.stiffness(f), rel=1e-11, abs=1e-12)
    assert derived.stretch(by_hand.force(f)) == pytest.approx(f, rel=1e-11)
    assert derived.hardens == by_hand.hardens
    beyond = 2 * np.array(STRAIN_LAWS[name].force_limits)
    assert np.isnan(derived.stretch(beyond[np.isfinite(beyond) & (beyond != 0)])).all()
