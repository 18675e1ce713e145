"""Eigenvalues along one parameter as the roots of a characteristic function.

Over all eigenvalues of a mesh, prod_k (lambda_k - lambda) / (lambda_k + shift) is a quotient of
determinants. At any lambda it is analytic in the parameter, also where two eigenvalues veer, at
whose branch points they themselves are not: so it is interpolated in their place. It is continuous
where the mass reaches an end, but differs between meshes of other orders: then its coefficients do
not fall, and it is not used.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from beamviz.frequency_loci.interpolation.chebyshev import (
    EPS,
    Lobatto,
    lobatto,
    on_piece,
    tail_and_rates,
)
from beamviz.frequency_loci.interpolation.roots import lowest_roots, sums_of_terms

PER_MODE, MORE = 5, 24  # greatest order of the interpolation in lambda: per mode, and in addition
TRUNCATED = 1e-14  # relative: terms of this interpolation below which it ends
FURTHER = 4  # number of terms after the last above that, which are still used
MARGIN = 0.02  # of the range of lambda, beyond the eigenvalues computed
# By parameter: the shift of omega^2, by default omega^2 of bending at rest, and the numbers of
# coefficients of the logarithms of the unit of lambda and of the size. With these most random
# charts take fewest nodes.
SCALING = {"gamma": (200.0, 3, 3), "delta": (800.0, 2, 3), "mu": (200.0, 2, 2)}
DEFAULT_SCALING = 12.0, 2, 3
SIZE_TERMS = 3  # number of coefficients of the logarithm of the size in the variable of lambda
WEIGHT = 3.0  # of the energies of modes: exp(-WEIGHT lambda), in that unit


@dataclass(frozen=True, eq=False)
class Characteristic:
    """The characteristic function of a family on a piece, as a function of x = -1 .. 1 that stands
    for s = sqrt((lambda + shift) / unit), of which it is an even function."""

    modes: int  # number of eigenvalues computed
    shift: float  # of lambda, so that all are positive
    low: float  # range of s
    high: float
    values: np.ndarray  # (nodes, k) at the points, divided by their size as a smooth function
    tail: np.ndarray  # (k,) of them, sum of the truncated coefficients of both variables
    misfit: np.ndarray  # (modes,) largest error of lambda at the check points
    scale: np.ndarray  # (nodes,) logarithm of the unit of lambda + shift, about its highest value
    energies: np.ndarray | None = None  # (nodes, 2, k) of the modes: see _energies
    samples: np.ndarray | None = None  # (n, modes) of coupled modes: lambda at the dense points

    @property
    def points(self) -> Lobatto:
        """The Chebyshev points of the interpolation in lambda."""
        return lobatto(len(self.tail) - 1)

    def roots(self, rows: np.ndarray, fractions: int = 0, most: int | None = None) -> np.ndarray:
        """The lowest eigenvalues, at most `most`, by interpolation `rows`, their change by the tail
        of the function, and for the first `fractions` rows the bending fractions, (3, n, modes);
        else nan."""
        found = np.full((3, len(rows), self.modes), np.nan)
        count = min(self.modes, most or self.modes)
        i, place, at, error, slope, bend, least = lowest_roots(
            self.points, rows @ self.values, count
        )
        order = len(self.tail) - 1
        tail = 2 * self.tail[np.rint(np.arccos(-at) * order / np.pi).astype(int)]
        with np.errstate(divide="ignore", invalid="ignore"):  # as a simple or as a double root
            change = error + np.fmin(tail / slope, np.sqrt(2 * (tail + least) / bend))
        half = (self.high - self.low) / 2
        s, scale = self.low + half * (at + 1), np.exp(rows @ self.scale)[i]
        found[0, i, place] = scale * (s * s) - self.shift
        found[1, i, place] = scale * (2 * s * half * change)
        if self.energies is not None and fractions:
            end = np.searchsorted(i, fractions)
            energies = np.tensordot(rows[:fractions], self.energies, 1)
            terms = self.points.terms(at[:end])
            across, whole = sums_of_terms(terms, energies, i[:end], count).T
            across, along = abs(across), abs(whole - across)
            found[2, i[:end], place[:end]] = across / (across + along)
        return found


def fit(
    spectra: np.ndarray,
    known: np.ndarray,
    modes: int,
    over: str,
    kinetic: np.ndarray | None = None,
) -> tuple[Characteristic, np.ndarray, np.ndarray, float]:
    """The characteristic function of all eigenvalues `spectra` (nodes, n) at the nodes.

    known: eigenvalues (checks, modes) at the check points, for the misfit. over: the parameter.
    kinetic: energies (nodes, 2, m) of the lowest modes, across the beam and total. Returns also the
    bending fractions (checks, modes); the largest changes (modes,) of eigenvalues by the tail; and
    the factor by which these fall when the order grows by a half.
    """
    points = lobatto(len(spectra) - 1)
    shift, unit_terms, size_terms = SCALING.get(over, DEFAULT_SCALING)
    shift += 2 * max(-float(min(spectra[:, 0].min(), known[:, 0].min())), 0.0)
    smooth = _smoothing(points, size_terms)
    scale = _smoothing(points, unit_terms) @ np.log(spectra[:, modes - 1] + shift)
    scaled = (spectra + shift) / np.exp(scale)[:, None]
    low, high = math.sqrt(scaled[:, 0].min()), math.sqrt(scaled[:, modes - 1].max())
    margin = MARGIN * high
    low, high = max(low - margin, 0.0), high + margin
    values, squares, truncated = _sampled(scaled, low, high, PER_MODE * modes + MORE, smooth)
    energies = None if kinetic is None else _energies(values, squares, scaled, kinetic)
    tail, rates = tail_and_rates(abs(points.coefficients @ values), len(spectra) - 1)
    tail = tail + truncated
    found = Characteristic(modes, shift, low, high, values, tail, np.zeros(modes), scale, energies)
    checks, each = len(known), len(points.dense) // (len(spectra) - 1)
    after_node = np.arange(len(points.dense)) % each
    between = after_node == each // 2 if kinetic is None else after_node > 0
    rows = np.concatenate((points.checks, points.dense[between]))
    eigenvalues, changes, bending = found.roots(rows, checks)
    samples = None
    if kinetic is not None:
        samples = np.empty((len(between), modes))
        samples[~between], samples[between] = spectra[:, :modes], eigenvalues[checks:]
    misfit = abs(eigenvalues[:checks] - known).max(axis=0)
    found = replace(found, misfit=misfit, samples=samples)
    falls = float((tail * rates).max() / tail.max())
    return found, bending[:checks], changes[checks:].max(axis=0), falls


def _sampled(
    known: np.ndarray, low: float, high: float, most: int, smooth: np.ndarray
) -> tuple[np.ndarray, np.ndarray, float]:
    """The characteristic function (nodes, k) of eigenvalues known (nodes, n) at the points of the
    order it needs, at most `most`, on the range of s; lambda (k,) there; and its truncated terms.

    It is divided by its size, a smooth function of both variables, as it varies by orders of
    magnitude with the parameter, but the error of the interpolation does not."""
    points = lobatto(most)
    values = np.ones((len(known), most + 1))
    lambdas = on_piece(low, high, points.nodes) ** 2
    for ratio in 1 / known.T:
        values *= 1 - lambdas * ratio[:, None]
    size = abs(values)
    size[:, 1:-1] += size[:, 2:] + size[:, :-2]  # nowhere zero
    values *= np.exp(-smooth @ np.log(size) @ _smoothing(points, SIZE_TERMS).T)
    terms = abs(points.coefficients @ values.T).max(axis=1)
    order = int(np.flatnonzero(terms > TRUNCATED * terms.max())[-1]) + FURTHER
    order = min(order + order % 2, most)
    fewer = lobatto(order)
    values = values @ points.rows(fewer.nodes).T
    return values, on_piece(low, high, fewer.nodes) ** 2, terms[order - 1 :].max()


def _smoothing(points: Lobatto, count: int) -> np.ndarray:
    """Matrix: values at the points -> the first `count` terms of their Chebyshev series there."""
    return np.cos(np.outer(np.arccos(points.nodes), range(count))) @ points.coefficients[:count]


def _energies(
    values: np.ndarray, squares: np.ndarray, scaled: np.ndarray, kinetic: np.ndarray
) -> np.ndarray:
    """Two functions of lambda (nodes, 2, k) whose ratio at an eigenvalue is that of the energies of
    its mode: the characteristic function times sum_k energy_k weight_k / (1 - lambda / lambda_k).

    The sum over all modes is a trace, analytic in the parameter. The weights decrease with lambda_k
    so that modes beyond the known ones are negligible."""
    known = scaled[:, : kinetic.shape[2]]
    away = 1 - squares[:, None] / known[:, None, :]
    away = np.where(abs(away) < EPS, EPS, away)
    weights = kinetic * np.exp(-WEIGHT * known)[:, None, :]
    return values[:, None, :] * (weights @ (1 / away).mT)
