"""Eigenvalues along one parameter as the roots of a characteristic function.

Over all eigenvalues of a mesh, prod_k (lambda_k - lambda) / (lambda_k + shift) is a quotient of
determinants. At any lambda it is analytic in the parameter, also where two eigenvalues veer, at
whose branch points they themselves are not: so it is interpolated in their place. It is continuous
where the mass reaches an end, but differs between meshes of other orders: then its coefficients do
not fall, and it is not used.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from beamviz.frequency_loci.interpolation.chebyshev import (
    EPS,
    Lobatto,
    lobatto,
    on_piece,
    tail_and_rates,
)

PER_MODE, MORE = 5, 24  # greatest order of the interpolation in lambda: per mode, and in addition
TRUNCATED = 1e-14  # relative: terms of this interpolation below which it ends
FURTHER = 4  # number of terms after the last above that, which are still used
MARGIN = 0.02  # of the range of lambda, beyond the eigenvalues computed
STEPS = 12  # of Halley's method for roots, and of Newton's for extrema
SMOOTH = 3  # number of coefficients of the logarithms of the unit of lambda and of the size
WEIGHT = 3.0  # of the energies of modes: exp(-WEIGHT lambda), in that unit
FINE = 8  # order, relative, of the samples between which three roots cannot be missed
CURVED = (
    4.0  # sum of the slopes at two samples, relative to the chord, from which there may be three
)
SETTLED = 1e-8  # step of Newton's method below which iteration ends: the next is of its square
ROOT_ERROR = 1e-12  # expected error of a root below which iteration ends


@dataclass(frozen=True, eq=False)
class Characteristic:
    """The characteristic function of a family on a piece, as a function of x = -1 .. 1 that stands
    for s = ((lambda + shift) / unit)^(1/4), in which those of bending are about as far apart."""

    modes: int  # number of eigenvalues computed
    shift: float  # of lambda, so that all are positive
    low: float  # range of s
    high: float
    values: np.ndarray  # (nodes, k) at the points, divided by their size as a smooth function
    tail: np.ndarray  # (k,) of them, sum of the truncated coefficients of both variables
    misfit: np.ndarray  # (modes,) largest error of lambda at the check points
    scale: np.ndarray  # (nodes,) logarithm of the unit of lambda + shift, about its highest value
    energies: np.ndarray | None = None  # (nodes, 2, k) of the modes: see _energies

    @property
    def points(self) -> Lobatto:
        """The Chebyshev points of the interpolation in lambda."""
        return lobatto(len(self.tail) - 1)

    def roots(self, rows: np.ndarray) -> np.ndarray:
        """The lowest eigenvalues by interpolation `rows`, their change by the tail of the function,
        and their bending fractions, (3, n, modes); nan where there are fewer."""
        D, V = _derivative(len(self.tail) - 1), rows @ self.values
        functions = V, V @ D.T, V @ D.T @ D.T  # and their derivatives
        i, *brackets = _brackets(self.points, functions, self.modes)
        place = np.arange(len(i)) - np.searchsorted(i, i)
        kept = place < self.modes
        i, place = i[kept], place[kept]
        at, change = self.refined([one[kept] for one in brackets], [f[i] for f in functions])
        half = (self.high - self.low) / 2
        s, scale = self.low + half * (at + 1), np.exp(rows @ self.scale)[i]
        square = s * s  # powers above 2 are slow
        found = np.full((3, len(rows), self.modes), np.nan)
        found[0, i, place] = scale * square**2 - self.shift
        found[1, i, place] = scale * (4 * square * s * half * change)
        if self.energies is not None:
            energies = np.tensordot(rows, self.energies, 1)[i]
            across, whole = np.matvec(energies, self.points.rows(at)).T
            across, along = abs(across), abs(whole - across)
            found[2, i, place] = across / (across + along)
        return found

    def refined(
        self, brackets: list[np.ndarray], functions: list[np.ndarray]
    ) -> tuple[np.ndarray, np.ndarray]:
        """The root (n,) in each bracket by Halley's method, and its change by the tail of the
        function, as a simple or as a double root, the lesser, and by the end of the iteration."""
        low, high, at, below = brackets
        points, order = self.points, len(self.tail) - 1
        touching = np.where(low == high, abs(below), 0.0)
        left = np.arange(len(at))
        rates, expected = np.empty((2, len(at))), np.empty(len(at))  # derivatives; error of roots
        with np.errstate(divide="ignore", invalid="ignore"):
            for _ in range(STEPS):
                x = at[left]
                rows = points.rows(x)
                step, rate, curve = (np.vecdot(rows, f[left]) for f in functions)
                rates[:, left] = rate, curve
                same = (step < 0) == (below[left] < 0)  # as at the lower end: the root is above
                low[left], high[left] = np.where(same, (x, high[left]), (low[left], x))
                step = step / (rate - step * curve / (2 * rate))  # Halley's
                inside = (x - step >= low[left]) & (x - step <= high[left])
                step = np.where(inside, step, x - (low[left] + high[left]) / 2)
                at[left] = x - step
                expected[left] = abs(step) * step**2 * (order**2 + (curve / rate) ** 2)
                left = left[~(expected[left] <= ROOT_ERROR)]
                if not len(left):
                    break
            error = 2 * self.tail[np.rint(np.arccos(-at) * order / np.pi).astype(int)]
            slope, bend = abs(rates)
            double = np.sqrt(2 * (error + touching) / bend)
            return at, np.fmin(error / slope, double) + np.fmin(expected, ROOT_ERROR)


def _brackets(points: Lobatto, functions: Sequence[np.ndarray], count: int) -> list[np.ndarray]:
    """The roots of functions (n, k), given with two derivatives, in ascending order: index of the
    function, ends of an interval, first guess, value at the lower end. count: of the roots that
    each has at least; where fewer are found, or three may be as one, finer samples are taken."""
    found, unclear = _sampled_brackets(
        points, functions, points.dense_nodes[::2], points.dense[::2]
    )
    again = np.flatnonzero(unclear | (np.bincount(found[0], minlength=len(unclear)) < count))
    if len(again):
        fine = np.cos(np.linspace(np.pi, 0.0, FINE * len(points.nodes)))
        finer, _ = _sampled_brackets(points, [f[again] for f in functions], fine, points.rows(fine))
        kept = ~np.isin(found[0], again)
        columns = [np.append(old[kept], new) for old, new in zip(found, finer, strict=True)]
        columns[0][kept.sum() :] = again[finer[0]]
        order = columns[0].argsort(kind="stable")
        found = [column[order] for column in columns]
    return found


def _sampled_brackets(
    points: Lobatto, functions: Sequence[np.ndarray], x: np.ndarray, rows: np.ndarray
) -> tuple[list[np.ndarray], np.ndarray]:
    """`_brackets` by samples at x, values of the interpolation `rows`; and whether there may be
    three roots between two samples (n,). Two are separated by an extremum, or coincide with it."""
    f, slopes = (one @ rows.T for one in functions[:2])
    before, after, falls, rises = f[:, :-1], f[:, 1:], slopes[:, :-1], slopes[:, 1:]
    changes = (before < 0) != (after < 0)
    i, cell = changes.nonzero()
    low, length, below = x[cell], x[cell + 1] - x[cell], before[i, cell]
    rise = after[i, cell] - below
    first, last = (length * slope[i, cell] / rise for slope in (falls, rises))
    unclear = np.zeros(len(f), bool)
    unclear[i[first + last > CURVED]] = True
    guess = low + length * _inverse_cubic(-below / rise, first, last)
    single = [i, low, low + length, guess, below]
    i, cell = (~changes & (before * falls < 0) & (after * rises > 0)).nonzero()
    if not len(i):
        return single, unclear
    low, high, slope = x[cell], x[cell + 1], falls[i, cell]
    extremum = low + (high - low) * slope / (slope - rises[i, cell])
    own = [one[i] for one in functions]
    close = _close_roots(points, own, low, extremum, high, before[i, cell])
    pairs = zip(single, (np.append(i, i), *close), strict=True)
    columns = [np.concatenate(pair) for pair in pairs]
    order = np.lexsort((columns[3], columns[1], columns[0]))
    return [column[order] for column in columns], unclear


def _close_roots(
    points: Lobatto,
    functions: list[np.ndarray],
    low: np.ndarray,
    extremum: np.ndarray,
    high: np.ndarray,
    below: np.ndarray,
) -> tuple[np.ndarray, ...]:
    """The two roots, or none, on either side of an extremum of each function (n, k): ends (2 n,) of
    an interval, first guess, value at the lower end. extremum: its first guess between low and
    high. below: the value at low."""
    value, slope, bend = functions
    for _ in range(STEPS):
        local = points.rows(extremum)
        curve = np.vecdot(local, bend)
        step = np.vecdot(local, slope) / curve
        extremum = np.clip(extremum - step, low, high)
        if (abs(step) <= SETTLED).all():
            break
    least = np.vecdot(points.rows(extremum), value)
    apart = (least < 0) != (below < 0)
    low, high = np.where(apart, low, extremum), np.where(apart, high, extremum)
    away = np.where(apart, np.sqrt(abs(2 * least / curve)), 0.0)
    lows, highs = np.append(low, extremum), np.append(extremum, high)
    guesses = np.append(np.maximum(extremum - away, low), np.minimum(extremum + away, high))
    return lows, highs, guesses, np.append(np.where(apart, below, least), least)


def _inverse_cubic(t: np.ndarray, first: np.ndarray, last: np.ndarray) -> np.ndarray:
    """Guesses (n,) of roots in 0 .. 1 of functions with values -t and 1 - t and derivatives first
    and last at the ends: x as a cubic polynomial of the function, or where that is outside, t."""
    with np.errstate(divide="ignore", invalid="ignore"):
        x = t + t * (1 - t) * ((1 - t) * (1 / first - 1) - t * (1 / last - 1))
    return np.where((x > 0) & (x < 1), x, t)


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
    spectra: np.ndarray,
    known: np.ndarray,
    modes: int,
    shift: float,
    kinetic: np.ndarray | None = None,
) -> tuple[Characteristic, np.ndarray, np.ndarray, float]:
    """The characteristic function of all eigenvalues `spectra` (nodes, n) at the nodes.

    known: eigenvalues (checks, modes) at the check points, for the misfit. kinetic: energies
    (nodes, 2, m) of the lowest modes, across the beam and total. Returns also the bending fractions
    (checks, modes); the largest changes (modes,) of eigenvalues by the tail; and the factor by
    which these fall when the order grows by a half.
    """
    points = lobatto(len(spectra) - 1)
    smooth = _smoothing(points, SMOOTH)
    scale = smooth @ np.log(spectra[:, modes - 1] + shift)
    scaled = (spectra + shift) / np.exp(scale)[:, None]
    low, high = scaled[:, 0].min() ** 0.25, scaled[:, modes - 1].max() ** 0.25
    margin = MARGIN * high
    low, high = max(low - margin, 0.0), high + margin
    values, fourth, truncated = _sampled(scaled, low, high, PER_MODE * modes + MORE, smooth)
    energies = None if kinetic is None else _energies(values, fourth, scaled, kinetic)
    tail, rates = tail_and_rates(abs(points.coefficients @ values), len(spectra) - 1)
    tail = tail + truncated
    found = Characteristic(modes, shift, low, high, values, tail, np.zeros(modes), scale, energies)
    checks = len(known)
    eigenvalues, changes, bending = found.roots(np.concatenate((points.checks, points.dense[2::4])))
    found = replace(found, misfit=abs(eigenvalues[:checks] - known).max(axis=0))
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
    lambdas = on_piece(low, high, points.nodes) ** 4
    for ratio in 1 / known.T:
        values *= 1 - lambdas * ratio[:, None]
    size = abs(values)
    size[:, 1:-1] += size[:, 2:] + size[:, :-2]  # nowhere zero
    values *= np.exp(-smooth @ np.log(size) @ _smoothing(points, 2).T)
    terms = abs(points.coefficients @ values.T).max(axis=1)
    order = int(np.flatnonzero(terms > TRUNCATED * terms.max())[-1]) + FURTHER
    order = min(order + order % 2, most)
    fewer = lobatto(order)
    values = values @ points.rows(fewer.nodes).T
    return values, on_piece(low, high, fewer.nodes) ** 4, terms[order - 1 :].max()


def _smoothing(points: Lobatto, count: int) -> np.ndarray:
    """Matrix: values at the points -> the first `count` terms of their Chebyshev series there."""
    return np.cos(np.outer(np.arccos(points.nodes), range(count))) @ points.coefficients[:count]


def _energies(
    values: np.ndarray, fourth: np.ndarray, scaled: np.ndarray, kinetic: np.ndarray
) -> np.ndarray:
    """Two functions of lambda (nodes, 2, k) whose ratio at an eigenvalue is that of the energies of
    its mode: the characteristic function times sum_k energy_k weight_k / (1 - lambda / lambda_k).

    The sum over all modes is a trace, analytic in the parameter. The weights decrease with lambda_k
    so that modes beyond the known ones are negligible."""
    known = scaled[:, : kinetic.shape[2]]
    away = 1 - fourth[:, None] / known[:, None, :]
    away = np.where(abs(away) < EPS, EPS, away)
    weights = kinetic * np.exp(-WEIGHT * known)[:, None, :]
    return values[:, None, :] * (weights @ (1 / away).mT)
