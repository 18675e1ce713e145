"""Cubic Hermite elements: exact for cubics, exact quadrature, points in the right element."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.polynomial import Polynomial

from beamviz.errors import InvalidInput
from beamviz.solver.fem.hermite import coordinates, gauss, hermite, interpolate, locate, uniform

lengths = st.floats(1e-3, 2.0)
coefficients = st.lists(st.floats(-3, 3), min_size=4, max_size=4)


@given(length=lengths, coefficients=coefficients, xi=st.floats(0, 1))
def test_hermite_holds_every_cubic(length, coefficients, xi):
    """A cubic, its slope and its curvature come back exactly from values and slopes at the ends."""
    cubic = Polynomial(coefficients)
    ends = [f(x) for x in (0, length) for f in (cubic, cubic.deriv())]
    for order, S in enumerate(hermite(xi, length)):
        exact = cubic.deriv(order) if order else cubic
        assert S @ ends == pytest.approx(exact(xi * length), abs=1e-12 / length**order)


def test_hermite_shape_functions_of_the_paper():
    """S is the paper's eq. 6, with the slopes multiplied by the element length."""
    xi, length = np.linspace(0, 1, 7), 0.4
    shapes, _, _ = hermite(xi, length)
    s1, s2 = 1 - 3 * xi**2 + 2 * xi**3, xi - 2 * xi**2 + xi**3
    s3, s4 = 3 * xi**2 - 2 * xi**3, -(xi**2) + xi**3
    assert shapes == pytest.approx(np.stack([s1, length * s2, s3, length * s4], -1), abs=1e-15)


@pytest.mark.parametrize("degree", range(13))
def test_gauss_is_exact_and_no_finer_than_needed(degree):
    """The points integrate the degree asked for, and fail within two degrees above it."""
    x, weights = gauss(degree)
    assert weights @ x**degree == pytest.approx(1 / (degree + 1), rel=1e-13)
    above = 2 * len(x)
    assert above <= degree + 2
    assert abs(weights @ x**above - 1 / (above + 1)) > 1e-9


@pytest.mark.parametrize("elements", [0, -3, 10_001])
def test_elements_out_of_range(elements):
    """A number of elements that makes no beam is named, with the numbers allowed."""
    with pytest.raises(InvalidInput, match=rf"elements = {elements}: must lie in 1 \.\. 10000"):
        uniform(elements)


def test_points_on_nodes():
    """A node belongs to the element right of it, the tip to the last element (paper, eq. 30)."""
    element, xi = locate(np.array([0, 0.25, 0.7, 1]), np.array([0, 0.25, 0.5, 0.7, 1]))
    assert element.tolist() == [0, 1, 1, 2, 2]
    assert xi == pytest.approx([0, 0, 0.25 / 0.45, 0, 1])


def test_interpolation_on_uneven_elements():
    """A planar cubic curve and its derivatives are reproduced between uneven nodes."""
    nodes = np.array([0, 0.1, 0.45, 1])
    curve = [Polynomial([0.2, 1, -0.5, 0.3]), Polynomial([0.1, 0, 2, -1])]
    q = np.column_stack([f(nodes) for f in (*curve, *(c.deriv() for c in curve))]).ravel()
    x = np.linspace(0, 1, 23)
    for derivative in range(3):
        exact = [c.deriv(derivative) if derivative else c for c in curve]
        expected = np.column_stack([c(x) for c in exact])
        assert interpolate(nodes, q, x, derivative) == pytest.approx(expected, abs=1e-12)


def test_element_coordinates_share_nodes():
    """Each element has the coordinates of its two nodes (paper, eqs. 2-4)."""
    q_e = coordinates(np.arange(12.0))
    assert q_e.tolist() == [list(range(8)), list(range(4, 12))]
