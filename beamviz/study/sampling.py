"""Solutions of beams along one parameter as points to track: shapes at common places."""

from collections.abc import Sequence
from functools import lru_cache
from operator import attrgetter

import numpy as np

from beamviz.mechanics.solution import Solution
from beamviz.mechanics.solve import displacements
from beamviz.study.tracking import Points

PLACES = 16  # plus two for each mode

_numbers = attrgetter("alpha", "beta", "gamma")


@lru_cache(maxsize=8)
def _gauss(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Gauss points in 0 .. 1 and their weights."""
    x, w = np.polynomial.legendre.leggauss(count)
    return (x + 1) / 2, w / 2


def sampled(at: np.ndarray, solutions: Sequence[Solution]) -> Points:
    """The modes of solutions, equal in number, as points.

    Shapes are taken at Gauss points of the whole beam and at the mass, times the roots of the
    weights and of the mass, so inner products are modal masses.
    """
    if not solutions:
        return Points(at, *(np.empty((0, 0, 0)[:d]) for d in (2, 3, 3)))
    squares = np.array([solution.squares for solution in solutions])
    x, w = _gauss(PLACES + 2 * squares.shape[1])

    alpha, beta, gamma = np.array([_numbers(solution.beam) for solution in solutions]).T
    places, masses = _with_own(x, beta), _with_own(w, alpha)
    fields = displacements(solutions, places)
    turning = np.iscomplexobj(fields) and gamma.any()
    if np.iscomplexobj(fields):
        fields = fields.real + fields.imag  # u is real and w imaginary: nothing is lost
    vectors = fields.swapaxes(1, 3) * np.sqrt(masses)[:, None, None, :]
    n, m = squares.shape
    if not turning:
        shapes = vectors.reshape(n, m, -1)
        return Points(at, squares, shapes, shapes)
    return Points(at, squares, *_gyroscopic(vectors, squares, gamma))


def _with_own(common: np.ndarray, own: np.ndarray) -> np.ndarray:
    """Numbers common to all (k,), and at their end the one that each has of its own: (n, k + 1)."""
    return np.column_stack((np.broadcast_to(common, (len(own), len(common))), own))


def _gyroscopic(
    vectors: np.ndarray, squares: np.ndarray, gamma: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Shapes and duals in the product in which modes of M q" + 2 gamma G q' + K q = 0 are
    orthogonal, (omega_i + omega_j) phi_i* M phi_j - 2 i gamma phi_i* G phi_j.

    It follows from the equation of mode j times phi_i*, less that of mode i times phi_j*.
    """
    n, m = squares.shape
    omega = np.sqrt(abs(squares))[:, :, None]
    root = np.sqrt(gamma)[:, None, None]
    flat, crossed = vectors.reshape(n, m, -1), vectors[:, :, ::-1].reshape(n, m, -1)
    shapes = np.concatenate((omega * flat, flat, root * flat), axis=2)
    duals = np.concatenate((flat, omega * flat, -2 * root * crossed), axis=2)
    norms = (shapes * duals).sum(axis=2, keepdims=True)
    size = np.sqrt(np.maximum(abs(norms), np.finfo(float).tiny))
    return shapes / size, duals / size * np.sign(norms)
