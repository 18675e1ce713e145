"""Cubic Hermite elements: exact for cubics, exact quadrature, mass, and assembly."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.polynomial import Polynomial

from beamviz.solver.fem.hermite import (
    assemble_band,
    assemble_vector,
    dense,
    element_coordinates,
    gauss,
    hermite,
    interpolate,
    locate,
    mass,
    positive_definite,
)

NODES = np.array([0, 0.2, 0.5, 0.6, 1])
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


@pytest.mark.parametrize("degree", range(13))
def test_gauss_is_exact_and_no_finer_than_needed(degree):
    """The points integrate the degree asked for, and fail within two degrees above it."""
    x, weights = gauss(degree)
    assert weights @ x**degree == pytest.approx(1 / (degree + 1), rel=1e-13)
    above = 2 * len(x)
    assert above <= degree + 2
    assert abs(weights @ x**above - 1 / (above + 1)) > 1e-9


def test_points_on_nodes():
    """A node belongs to the element right of it, the tip to the last element (paper, eq. 30)."""
    element, xi = locate(np.array([0, 0.25, 0.7, 1]), np.array([0, 0.25, 0.5, 0.7, 1]))
    assert element.tolist() == [0, 1, 1, 2, 2]
    assert xi == pytest.approx([0, 0, 0.25 / 0.45, 0, 1])


def test_interpolation_on_uneven_elements():
    """Cubics and their derivatives are reproduced between uneven nodes, several at once."""
    cubics = [Polynomial([0.2, 1, -0.5, 0.3]), Polynomial([0.1, 0, 2, -1])]
    q = np.stack([np.column_stack((c(NODES), c.deriv()(NODES))).ravel() for c in cubics], axis=1)
    x = np.linspace(0, 1, 23)
    for order in range(3):
        exact = np.column_stack([(c.deriv(order) if order else c)(x) for c in cubics])
        assert interpolate(NODES, q, x, order) == pytest.approx(exact, abs=1e-12)
        assert interpolate(NODES, q[:, 0], x, order) == pytest.approx(exact[:, 0], abs=1e-12)


@pytest.mark.parametrize("width", [4, 8])
@pytest.mark.parametrize("elements", [1, 2, 5])
def test_assembly_is_the_sum_of_elements(width, elements):
    """Band and vector hold exactly the sum over elements (paper, eqs. 2-4, 10 and 19), complex
    vectors too; the definiteness of a band is recognised."""
    rng = np.random.default_rng(7)
    parts = rng.standard_normal((elements, width, width))
    parts = parts @ parts.swapaxes(1, 2) + np.eye(width)
    vectors = parts[..., 0] + 1j * parts[..., 1]
    K, F = np.zeros((2, width // 2 * (elements + 1), width // 2 * (elements + 1)), complex)
    for e in range(elements):
        place = slice(width // 2 * e, width // 2 * e + width)
        K[place, place] += parts[e]
        F[0, place] += vectors[e]
    band = assemble_band(parts)
    assert dense(band) == pytest.approx(K.real, abs=1e-13)
    assert assemble_vector(vectors) == pytest.approx(F[0], abs=1e-14)
    q = np.arange(float(len(K)))
    assert element_coordinates(q, width // 2)[-1].tolist() == q[-width:].tolist()
    assert positive_definite(band)
    band[0, -1] = -1
    assert not positive_definite(band)


def test_mass_matrix_of_the_paper():
    """The consistent mass is the integral of eq. 8: the textbook matrix of a cubic element."""
    l = 0.3
    textbook = [
        [156, 22 * l, 54, -13 * l],
        [22 * l, 4 * l**2, 13 * l, -3 * l**2],
        [54, 13 * l, 156, -22 * l],
        [-13 * l, -3 * l**2, -22 * l, 4 * l**2],
    ]
    (m,) = mass(np.array([0.4, 0.7]), 0.0, 0.5)
    assert m == pytest.approx(l / 420 * np.array(textbook), rel=1e-13)


def point_mass(beta, alpha=3.0):
    """The mass matrix of each element with a concentrated mass, less that without."""
    return mass(NODES, alpha, beta) - mass(NODES, 0.0, beta)


@pytest.mark.parametrize("beta", NODES)
def test_mass_on_a_node(beta):
    """On a node the mass acts on the position of that node only, and from both sides alike."""
    m = dense(assemble_band(point_mass(beta)))
    expected = np.zeros_like(m)
    node = 2 * NODES.tolist().index(beta)
    expected[node, node] = 3.0
    assert m == pytest.approx(expected, abs=1e-14)
    left = dense(assemble_band(point_mass(max(0.0, beta - 1e-9))))
    assert left == pytest.approx(expected, abs=1e-8)


def test_mass_inside_an_element():
    """Inside an element the mass is m S'S at its place (paper, eq. 32), nothing elsewhere."""
    m = point_mass(0.275)
    S, _, _ = hermite(0.25, 0.3)
    assert m[1] == pytest.approx(3 * np.outer(S, S), rel=1e-12, abs=1e-15)
    assert not m[[0, 2, 3]].any()
