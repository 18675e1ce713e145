"""Eigenvalues along one parameter as the roots of a characteristic function.

Over all eigenvalues of a mesh, prod_k (lambda_k - lambda) / (lambda_k + shift) is a quotient of
determinants. At any lambda it is analytic in the parameter, also where two eigenvalues veer, at
whose branch points they themselves are not: so it is interpolated in their place. It is continuous
where the mass reaches an end, but differs between meshes of other orders: then its coefficients do
not fall, and it is not used.
"""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from beamviz.frequency_loci.chebyshev import LEAST, Lobatto, lobatto, tail_and_rates

PER_MODE = 3  # order of the interpolation in lambda for each mode, beyond LEAST
MARGIN = 0.02  # of the range of lambda, beyond the eigenvalues looked for
STEPS = 8
SETTLED = 1e-6  # a smaller step, cubic in the one before it, is the last


@dataclass(frozen=True, eq=False)
class Characteristic:
    """The characteristic function of a family on a piece, as a function of x = -1 .. 1 that stands
    for s = (lambda + shift)^(1/4), in which eigenvalues of bending are about equally far apart."""

    modes: int  # the number of eigenvalues that are looked for
    shift: float  # of lambda, so that all are positive
    low: float  # range of s
    high: float
    values: np.ndarray  # (nodes, k) divided by exp(s), at the points
    tail: np.ndarray  # (k,) of them, sum of the coefficients that are left out
    misfit: np.ndarray  # (modes,) largest error of lambda at the check points

    @property
    def points(self) -> Lobatto:
        """The Chebyshev points of the interpolation in lambda."""
        return lobatto(len(self.tail) - 1)

    def roots(self, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The lowest eigenvalues (n, modes) by interpolation `rows`, and by how much they change
        with the function by the tail; nan where there are fewer."""
        D, V = _derivative(len(self.tail) - 1), rows @ self.values
        functions = V, V @ D.T, V @ D.T @ D.T  # and their derivatives
        i, *brackets = _brackets(self.points, functions)
        at, change = self.refined(brackets, [f[i] for f in functions])
        half = (self.high - self.low) / 2
        s = self.low + half * (at + 1)
        place = np.arange(len(i)) - np.searchsorted(i, i)
        kept = place < self.modes
        found = np.full((2, len(rows), self.modes), np.nan)
        square = s * s  # powers above 2 are slow
        eigenvalues = np.stack((square**2 - self.shift, 4 * square * s * half * change))
        found[:, i[kept], place[kept]] = eigenvalues[:, kept]
        return found[0], found[1]

    def refined(
        self, brackets: list[np.ndarray], functions: list[np.ndarray]
    ) -> tuple[np.ndarray, np.ndarray]:
        """The root (n,) in each bracket by Halley's method, and by how much it changes with the
        function by the tail: as one of two close roots where that is less."""
        (low, high, below, above), (value, slope, bend) = brackets, functions
        points, order = self.points, len(self.tail) - 1
        with np.errstate(divide="ignore", invalid="ignore"):
            at = np.where(below == above, low, low - below * (high - low) / (above - below))
            for _ in range(STEPS):
                local = points.rows(at)
                step, curve = (np.vecdot(local, f) for f in (value, bend))
                rate = np.vecdot(local, slope)
                step = step / (rate - step * curve / (2 * rate))  # Halley's
                step = np.where((at - step >= low) & (at - step <= high), step, 0.0)
                at = at - step
                if not abs(step).max(initial=0.0) > SETTLED:
                    break
            error = 2 * self.tail[np.rint(np.arccos(-at) * order / np.pi).astype(int)]
            left, slope, bend = (abs(np.vecdot(local, f)) for f in (value, slope, bend))
            double = np.sqrt(2 * (error + np.where(below == above, left, 0.0)) / bend)
            return at, np.fmin(error / slope, double)


def _brackets(points: Lobatto, functions: tuple[np.ndarray, ...]) -> list[np.ndarray]:
    """Of every root of some functions (n, k), given with two derivatives, ascending: the number of
    the function, an interval, the values at its ends. Two close roots are on both sides of an
    extremum, or at it."""
    x = points.dense_nodes
    f = functions[0] @ points.dense.T
    size, negative = abs(f), f < 0
    changes = negative[:, 1:] != negative[:, :-1]
    least = (size[:, 1:-1] < size[:, :-2]) & (size[:, 1:-1] <= size[:, 2:])
    i, cell = changes.nonzero()
    brackets = [(i, x[cell], x[cell + 1], f[i, cell], f[i, cell + 1])]
    i, cell = (least & ~changes[:, 1:] & ~changes[:, :-1]).nonzero()
    if len(i):
        low, high, extremum = x[cell], x[cell + 2], x[cell + 1]
        left, right = f[i, cell], f[i, cell + 2]
        value, slope, bend = (one[i] for one in functions)
        for _ in range(STEPS):
            local = points.rows(extremum)
            step = np.vecdot(local, slope) / np.vecdot(local, bend)
            extremum = np.clip(extremum - step, low, high)
        middle = np.vecdot(points.rows(extremum), value)
        apart = (middle < 0) != (left < 0)
        start, end = np.where(apart, low, extremum), np.where(apart, high, extremum)
        left, right = np.where(apart, left, middle), np.where(apart, right, middle)
        brackets += [(i, start, extremum, left, middle), (i, extremum, end, middle, right)]
    columns = [np.concatenate(column) for column in zip(*brackets, strict=True)]
    order = np.lexsort((columns[2], columns[1], columns[0]))
    return [column[order] for column in columns]


@lru_cache
def _derivative(order: int) -> np.ndarray:
    """Matrix: values at the Chebyshev points -> the derivative of their interpolant there."""
    points = lobatto(order)
    away = points.nodes[:, None] - points.nodes + np.eye(order + 1)
    D = points.weights / points.weights[:, None] / away
    np.fill_diagonal(D, 0.0)
    np.fill_diagonal(D, -D.sum(axis=1))
    return D


def fit(
    spectra: np.ndarray, known: np.ndarray, modes: int, shift: float
) -> tuple[Characteristic, np.ndarray, float]:
    """The characteristic function by all eigenvalues (nodes, n) at the nodes, with its misfit to
    those known (checks, modes) at the check points; the largest changes (modes,) of eigenvalues by
    its tail; by what factor these are expected to fall when the order grows by a half."""
    points = lobatto(len(spectra) - 1)
    low = (spectra[:, 0].min() + shift) ** 0.25
    high = (spectra[:, modes - 1].max() + shift) ** 0.25
    margin = MARGIN * high
    low, high = max(low - margin, 0.0), high + margin
    s = low + (high - low) / 2 * (lobatto(PER_MODE * modes + LEAST).nodes + 1)
    values, fourth = np.tile(np.exp(-s), (len(spectra), 1)), s**4
    for ratio in 1 / (spectra + shift).T:
        values *= 1 - fourth * ratio[:, None]
    tail, rates = tail_and_rates(abs(points.coefficients @ values), len(spectra) - 1)
    found = Characteristic(modes, shift, low, high, values, tail, np.zeros(modes))
    checks = len(known)
    eigenvalues, changes = found.roots(np.concatenate((points.checks, points.dense[2::4])))
    misfit, changes = abs(eigenvalues[:checks] - known).max(axis=0), changes[checks:].max(axis=0)
    return replace(found, misfit=misfit), changes, float(rates.max())
