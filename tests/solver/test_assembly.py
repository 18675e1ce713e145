"""Assembly: bands against plain sums, clamps, factors, and cost linear in the elements."""

import time

import numpy as np
import pytest

from beamviz.solver.constitutive import CURVATURES, STRAIN_LAWS
from beamviz.solver.fem import ancf, assembly
from beamviz.solver.fem.hermite import coordinates, uniform


@pytest.fixture
def rng():
    return np.random.default_rng(7)


def summed(parts):
    """The assembled matrix, entry by entry: sum_e B_e' parts_e B_e."""
    elements, width, _ = parts.shape
    total = np.zeros((width // 2 * (elements + 1),) * 2)
    for e, part in enumerate(parts):
        place = slice(width // 2 * e, width // 2 * e + width)
        total[place, place] += part
    return total


@pytest.mark.parametrize("width", [4, 8])
@pytest.mark.parametrize("elements", [1, 2, 5])
def test_band_is_the_sum_of_elements(rng, width, elements):
    """Band and full matrix hold exactly the sum over elements, symmetric or skew."""
    parts = rng.standard_normal((elements, width, width))
    symmetric, skew = parts + parts.swapaxes(1, 2), parts - parts.swapaxes(1, 2)
    assert assembly.dense(assembly.band(symmetric)) == pytest.approx(summed(symmetric), abs=1e-14)
    assert assembly.skew(skew) == pytest.approx(summed(skew), abs=1e-14)


def test_vector_is_the_sum_of_elements(rng):
    """Element vectors add where elements meet, complex ones too."""
    parts = rng.standard_normal((3, 8)) + 1j * rng.standard_normal((3, 8))
    total = np.zeros(16, complex)
    for e in range(3):
        total[4 * e : 4 * e + 8] += parts[e]
    assert assembly.vector(parts) == pytest.approx(total, abs=1e-15)


def test_held_coordinates_are_out_of_play(rng):
    """Held rows and columns become those of the identity; the rest stays."""
    parts = rng.standard_normal((3, 8, 8))
    A = assembly.band(parts + parts.swapaxes(1, 2))
    before = assembly.dense(A)
    expected = before.copy()
    for j in (0, 1, 3):
        expected[j, :] = expected[:, j] = 0
        expected[j, j] = 1
    assert np.array_equal(assembly.dense(assembly.held(A, (0, 1, 3))), expected)
    assert np.array_equal(assembly.dense(A), before)


def test_solve_and_definiteness(rng):
    """A positive definite band solves its system; an indefinite one is refused."""
    parts = rng.standard_normal((4, 8, 8))
    A = assembly.band(parts @ parts.swapaxes(1, 2) + np.eye(8))
    b = rng.standard_normal(20)
    x = assembly.solve(assembly.cholesky(A), b)
    assert assembly.dense(A) @ x == pytest.approx(b, abs=1e-9)
    A[0, 7] = -1
    assert not assembly.positive_definite(A)
    with pytest.raises(np.linalg.LinAlgError, match="not positive definite"):
        assembly.cholesky(A)


def test_cost_is_linear_in_the_elements():
    """Eight times the elements cost about eight times as long to a factored tangent."""
    material = ancf.Material(70.0, STRAIN_LAWS["green"], CURVATURES["spatial"])

    def seconds(count):
        elements = ancf.Elements.between(uniform(count))
        q = np.zeros((count + 1, 4))
        q[:, 0], q[:, 2] = elements.nodes, 1.1
        times = []
        for _ in range(5):
            start = time.perf_counter()
            K_e = ancf.tangent(elements, material, coordinates(q))
            assembly.cholesky(assembly.held(assembly.band(K_e), (0, 1, 3)))
            times.append(time.perf_counter() - start)
        return min(times)

    assert seconds(4000) / seconds(500) < 24  # linear: 8, quadratic: 64
