"""The solver against closed forms, published effects.

The published values themselves are the rows of the validation page (tests/evidence/paper).
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

from beamviz import Beam, solve

RIGID = 10000.0  # slenderness; stretch is (gamma / mu)^2 = 1e-6 at most in the rigid tables


@pytest.mark.parametrize("alpha", [0.0, 0.01, 1.0, 100.0])
def test_tip_mass_at_rest_in_closed_form(alpha):
    """Blevins's characteristic equation of a cantilever with a tip mass, omega = b^2 with 1 + cos b
    cosh b = alpha b (sin b cosh b - cos b sinh b)."""

    def characteristic(b):  # divided by cosh b
        tip = alpha * b * (np.sin(b) - np.cos(b) * np.tanh(b))
        return 1 / np.cosh(b) + np.cos(b) - tip

    solution, b = solve(Beam(alpha=alpha, mu=RIGID), 4), np.linspace(0.05, 14, 4000)
    places = np.flatnonzero(np.diff(np.sign(characteristic(b))))[:4]
    exact = [brentq(characteristic, b[i], b[i + 1], xtol=1e-14) ** 2 for i in places]
    assert np.all(abs(solution.frequencies - exact) <= solution.errors)


@pytest.mark.parametrize("alpha", [0.0, 0.3, 1.0, 30.0])
def test_stretching_at_rest_in_closed_form(alpha):
    """omega = mu z with z tan z = 1 / alpha: 109.9557 and 60.2234 at alpha 0 and 1, mu 70."""
    solution = solve(Beam(alpha=alpha), tolerance=1e-8)
    found = solution.frequencies[solution.labels.index("S1")]
    z = brentq(lambda z: alpha * z * np.sin(z) - np.cos(z), 1e-6, np.pi / 2 + 1e-9)
    assert found == pytest.approx(70 * z, rel=1e-8)


def test_diverging_iterations_give_no_warnings():
    """A step of the continuation that diverges is halved; numpy does not warn of it."""
    assert solve(Beam(0.5, 0, 120, -1), strain="hencky").equilibrium.status == "unstable"


@given(st.floats(0, 100), st.sampled_from([(2, 0), (3, 0), (3, 1), (4, 0), (4, 1), (4, 2)]))
def test_a_mass_at_a_node_changes_nothing(alpha, place):
    """At rest, a mass at a node of mode k leaves omega_k alone (paper, figs. 16-19)."""
    k, which = place
    free = solve(Beam(mu=RIGID), 4, tolerance=1e-9)
    node = float(free.nodes[k - 1][which])
    laden = solve(Beam(alpha=alpha, beta=node, mu=RIGID), 6, tolerance=1e-9)
    near = np.min(np.abs(laden.frequencies - free.frequencies[k - 1]))
    assert near <= 1e-8 * free.frequencies[k - 1]
