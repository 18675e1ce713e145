"""Mode shapes as mass-weighted vectors: followed along a sweep, or matched between two beams."""

import math
from collections.abc import Sequence
from functools import lru_cache
from itertools import combinations
from operator import attrgetter
from typing import NamedTuple

import numpy as np
from scipy.optimize import linear_sum_assignment

from beamviz.frequency_loci.tracking import LOST, Points
from beamviz.solver import displacements
from beamviz.solver.solution import Solution

PLACES = 16  # plus two for each mode, and some for a buckled beam

_numbers = attrgetter("alpha", "beta")


@lru_cache(maxsize=8)
def _gauss(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Gauss points in 0 .. 1 and their weights."""
    x, w = np.polynomial.legendre.leggauss(count)
    return (x + 1) / 2, w / 2


def places(solutions: Sequence[Solution]) -> int:
    """How many Gauss points tell the modes of solutions apart.

    A beam under the thrust P that grows at the rate g ~ P / 2 has waves of numbers up to
    k = sqrt(P) = sqrt(2 g). Products of two are waves of number 2 k, which n points integrate from
    n = k / 2 on (they are exact to degree 2 n, and exp(2 i k x) over 0 .. 1 is a polynomial of
    degree k but for what falls off fast): sqrt(g / 2) points.
    """
    if not solutions:
        return 0
    growth = math.sqrt(max(-min(solution.omega_squared[0] for solution in solutions), 0.0))
    return PLACES + 2 * len(solutions[0].omega_squared) + math.ceil(math.sqrt(growth / 2))


def sampled(at: np.ndarray, solutions: Sequence[Solution], count: int) -> Points:
    """The modes of solutions, equal in number, as points.

    Shapes are taken at `count` Gauss points of the whole beam and at the mass, times the roots of
    the weights and of the mass, so inner products are modal masses.
    """
    if not solutions:
        return Points(at, *(np.empty((0, 0, 0)[:d]) for d in (2, 3, 3)))
    squares = np.array([solution.omega_squared for solution in solutions])
    vectors, gyroscopic = _mass_weighted(solutions, squares, count)
    gamma = np.array([solution.beam.gamma for solution in solutions])
    n, m = squares.shape
    if not (gyroscopic and gamma.any()):
        shapes = vectors.reshape(n, m, -1)
        return Points(at, squares, shapes, shapes)
    return Points(at, squares, *_gyroscopic(vectors, squares, gamma))


class ModeMatch(NamedTuple):
    """Correspondence of the modes of two solutions."""

    partner: (
        np.ndarray
    )  # (m1,) the mode of the second for each of the first, -1 where none is alike
    mac: np.ndarray  # (m1, m2) mass-weighted modal assurance criterion, 0 .. 1


def match_modes(first: Solution, second: Solution) -> ModeMatch:
    """Match the modes of two solutions by the correlation of their mass-weighted shapes.

    The solutions may differ in beam, model and number of modes. The assignment has the largest sum
    of the MAC; pairs below LOST are no pairs. Two modes that are mixtures of the same two shapes
    keep their order.
    """
    count = max(places([first]), places([second]))
    vectors = []
    for solution in (first, second):
        rows = _mass_weighted([solution], solution.omega_squared[None], count)[0][0]
        rows = rows.reshape(len(rows), -1)
        vectors.append(rows / np.linalg.norm(rows, axis=1, keepdims=True))
    mac = (vectors[0] @ vectors[1].T) ** 2
    partner = np.full(len(mac), -1)
    rows, columns = linear_sum_assignment(mac, maximize=True)
    alike = mac[rows, columns] >= LOST
    partner[rows[alike]] = columns[alike]
    for i, j in combinations(rows[alike], 2):
        a, b = partner[i], partner[j]
        if a > b and min(mac[i, b], mac[j, a]) >= LOST:
            partner[i], partner[j] = b, a
    return ModeMatch(partner, mac)


def _mass_weighted(
    solutions: Sequence[Solution], squares: np.ndarray, count: int
) -> tuple[np.ndarray, bool]:
    """u and w (n, m, 2, k) of all modes at `count` Gauss points and at the mass, times the roots of
    weights and masses; and whether the modes are those of a gyroscopic eigenproblem."""
    x, w = _gauss(count)
    alpha, beta = np.array([_numbers(solution.beam) for solution in solutions]).T
    here, masses = _with_own(x, beta), _with_own(w, alpha)
    fields = displacements(solutions, here)
    gyroscopic = np.iscomplexobj(fields)
    if gyroscopic:
        fields = _real(fields, squares)
    return fields.swapaxes(1, 3) * np.sqrt(masses)[:, None, None, :], gyroscopic


def _with_own(common: np.ndarray, own: np.ndarray) -> np.ndarray:
    """Numbers common to all (k,), and at their end the one that each has of its own: (n, k + 1)."""
    return np.column_stack((np.broadcast_to(common, (len(own), len(common))), own))


def _real(fields: np.ndarray, squares: np.ndarray) -> np.ndarray:
    """u and w (n, k, 2, m) of modes (u, i w) that swing, in whatever phase, or (u, w) that grow."""
    u, w = fields[:, :, 0], fields[:, :, 1]
    swings = (squares >= 0)[:, None, :]
    return np.stack((u.real + u.imag, np.where(swings, w.imag - w.real, w.real)), axis=2)


def _gyroscopic(
    vectors: np.ndarray, squares: np.ndarray, gamma: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Shapes and duals in the product in which modes of M q" + 2 gamma G q' + K q = 0 are
    orthogonal, (omega_i + omega_j) phi_i* M phi_j - 2 i gamma phi_i* G phi_j.

    It follows from the equation of mode j times phi_i*, less that of mode i times phi_j*. A mode
    that grows is (u, w) in place of (u, i w), its omega the rate. It is orthogonal to both modes of
    a pair +-omega: to their sum and to their difference, either half of the product. Those are
    added so that the product does not vanish where a mode begins to grow.
    """
    omega = np.sqrt(abs(squares))[:, :, None]
    root = np.sqrt(gamma)[:, None, None]
    swings = (squares >= 0)[:, :, None]
    u, w = vectors[:, :, 0], vectors[:, :, 1]
    across = (w**2).sum(axis=2, keepdims=True) > (u**2).sum(axis=2, keepdims=True)
    half = np.where(swings | ~across, 1.0, -1.0)
    fast_u, fast_w = omega * u, np.where(swings, omega, -omega) * w
    shapes, duals = (
        np.concatenate(parts, axis=2)
        for parts in (
            (fast_u, w, root * w, half * fast_w, half * u, half * root * u),
            (u, fast_w, -2 * root * u, half * w, half * fast_u, -2 * half * root * w),
        )
    )
    norms = (shapes * duals).sum(axis=2, keepdims=True)
    size = np.sqrt(np.maximum(abs(norms), np.finfo(float).tiny))
    return shapes / size, duals / size * np.sign(norms)
