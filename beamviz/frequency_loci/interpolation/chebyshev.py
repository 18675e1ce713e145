"""Interpolation at Chebyshev points, and the estimate of its error by its coefficients."""

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from beamviz.solver.hp.mesh import interpolation_matrix

LEAST = 16  # order of the coarsest piece
CHECKS = np.array([0.08, 0.4, 0.7])  # positions relative to the order, moved between two nodes
FINE = 96  # order up to which there are three samples between two nodes; above it, one
HUGE = 1e100  # term at a node, beside which the others are negligible
EPS = float(np.finfo(float).eps)
TAIL, MISFIT = 4.0, 8.0  # safety factors of the two error estimates
BENDING_ERROR = 1e-3  # accepted error of the bending fraction


@dataclass(frozen=True)
class Lobatto:
    """Chebyshev points of the second kind on -1 .. 1, ascending."""

    nodes: np.ndarray  # (n,)
    weights: np.ndarray  # (n,) barycentric
    coefficients: np.ndarray  # (n, n) values -> Chebyshev coefficients
    check_nodes: np.ndarray  # (checks,) further points
    checks: np.ndarray  # (checks, n) values -> the interpolant at these
    dense: np.ndarray  # (samples, n) values -> the interpolant at many points
    dense_nodes: np.ndarray  # (samples,) these points: the nodes, and equally many between each two

    def rows(self, x: np.ndarray) -> np.ndarray:
        """Matrix (len(x), n): values at the nodes -> their interpolant at x."""
        return interpolation_matrix(x, self.nodes, self.weights)

    def terms(self, x: np.ndarray) -> np.ndarray:
        """`rows` (len(x), n) before each is divided by its sum: faster, where only ratios of sums
        are needed."""
        away = x[:, None] - self.nodes
        hits = away == 0
        if hits.any():
            away[hits] = 1 / HUGE
        return self.weights / away


def _extrema(j: np.ndarray, order: int) -> np.ndarray:
    """Extrema, numbered from -1, of the Chebyshev polynomial of an order; -1, 0 and 1 exactly."""
    return np.sin(np.pi * (2 * j - order) / (2 * order))


@lru_cache(maxsize=32)
def lobatto(order: int) -> Lobatto:
    """The order + 1 points of an order."""
    j = np.arange(order + 1)
    nodes = _extrema(j, order)
    ends = np.where(j % order == 0, 0.5, 1.0)
    T = np.cos(np.outer(j, np.arccos(nodes)))
    empty, samples = np.empty((0, order + 1)), order * (4 if order <= FINE else 2)
    dense = _extrema(np.arange(samples + 1), samples)
    coefficients = 2 / order * np.outer(ends, ends) * T
    checks = _extrema(np.floor(CHECKS * order) + 0.5, order)
    points = Lobatto(nodes, ends * (-1.0) ** j, coefficients, checks, empty, empty, dense)
    return replace(points, checks=points.rows(checks), dense=points.rows(dense))


def tail_and_rates(coefficients: np.ndarray, order: int) -> tuple[np.ndarray, np.ndarray]:
    """The sums of the truncated coefficients, extrapolated from coefficients (n, ...) as geometric
    series of at most `order` terms, and the factors by which these fall over half the order.

    Near a branch point the coefficients oscillate: the more slowly they fall, the more are used."""
    last = np.arange(max(3, order // 24))[::-1]
    tail = coefficients[-3:].max(axis=0)
    middle = coefficients[order // 2 - 1 : order // 2 + 2].max(axis=0)
    rates = np.clip(tail / np.maximum(middle, np.finfo(float).tiny), EPS, 1.0)
    ratios = rates ** (2 / order)
    powers = last.reshape(-1, *[1] * ratios.ndim)
    tail = (coefficients[-len(last) :] * ratios**powers).max(axis=0)
    return tail * ratios / np.maximum(1 - ratios, 1 / order), rates


def estimated_error(tail: np.ndarray, misfit: np.ndarray) -> np.ndarray:
    """The error of an interpolant by its truncated terms and by its misfit at the check points."""
    return np.maximum(TAIL * tail, MISFIT * misfit)


def interpolated(rows: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Values (n, ...) at the nodes interpolated by `rows` (m, n): (m, ...)."""
    return (rows @ values.reshape(len(values), -1)).reshape(len(rows), *values.shape[1:])


def on_piece(low: Any, high: Any, x: np.ndarray) -> np.ndarray:
    """Points x of -1 .. 1 mapped to low .. high, floats or arrays; the ends exactly."""
    return np.where(x == 1, high, low + (high - low) * (x + 1) / 2)
