"""The roots of many functions at once, each given by its values at Chebyshev points."""

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from beamviz.frequency_loci.interpolation.chebyshev import Lobatto, lobatto

STEPS = 20  # of Halley's method for roots, and of Newton's for extrema
ROOT_ERROR = 1e-12  # expected error of a root below which iteration ends
SETTLED = 1e-6  # step of Newton's method below which iteration ends: the next is of its square
# A cubic function has three roots between two samples only if the slopes there have a sum of more
# than 3 times that of the chord. Samples of FINE times the order separate the roots.
CURVED, FINE = 3.0, 8


class Roots(NamedTuple):
    """The m lowest roots of functions, in ascending order for each function."""

    function: np.ndarray  # (m,) index of the function
    place: np.ndarray  # (m,) index of the root among those of its function
    at: np.ndarray  # (m,) on -1 .. 1
    error: np.ndarray  # (m,) expected after the last step of the iteration
    slope: np.ndarray  # (m,) absolute value of the derivative
    bend: np.ndarray  # (m,) of the second derivative
    least: np.ndarray  # (m,) of the function; 0 but at an extremum that is taken for two roots


def lowest_roots(points: Lobatto, values: np.ndarray, count: int) -> Roots:
    """The `count` lowest roots of functions with values (n, k) at the points, by Halley's method;
    fewer where a function has fewer."""
    D = derivative(len(points.nodes) - 1)
    functions = values, values @ D.T, values @ D.T @ D.T  # and their derivatives
    i, *brackets = _brackets(points, functions, count)
    place = np.arange(len(i)) - np.searchsorted(i, i)
    kept = place < count
    i, place = i[kept], place[kept]
    low, high, at, below = (one[kept] for one in brackets)
    touching = low == high
    own = np.stack((*functions, np.ones_like(values)), axis=1)
    left = np.arange(len(at))
    rates, error = np.empty((2, len(at))), np.empty(len(at))
    with np.errstate(divide="ignore", invalid="ignore"):
        for _ in range(STEPS):
            x = at[left]
            *sums, total = sums_of_terms(points.terms(x), own, i[left], count).T
            value, rate, curve = sums / total
            rates[:, left] = rate, curve
            same = (value < 0) == (below[left] < 0)  # as at the lower end: the root is above
            low[left], high[left] = np.where(same, (x, high[left]), (low[left], x))
            step = value / (rate - value * curve / (2 * rate))  # Halley's
            good = (x - step >= low[left]) & (x - step <= high[left])
            good &= abs(value * curve) <= rate**2  # not beside an extremum, where steps are short
            step = np.where(good, step, x - (low[left] + high[left]) / 2)
            at[left] = x - step
            error[left] = abs(step) * step**2 * (len(D) ** 2 + (curve / rate) ** 2)
            left = left[~(error[left] <= ROOT_ERROR)]
            if not len(left):
                break
    slope, bend = abs(rates)
    least = np.where(touching, abs(below), 0.0)
    return Roots(i, place, at, np.where(touching, 0.0, error), slope, bend, least)


def sums_of_terms(
    terms: np.ndarray, functions: np.ndarray, i: np.ndarray, count: int
) -> np.ndarray:
    """Sums (m, c) over the nodes: at point j terms[j] (k,) times each of the c functions (k,) of
    functions[i[j]]. i (m,) ascends; at most `count` points for each i."""
    if len(i) and len(i) == count * len(functions):  # for each: without a copy
        return (terms.reshape(len(functions), count, -1) @ functions.mT).reshape(len(i), -1)
    return np.matvec(functions[i], terms)


def _brackets(points: Lobatto, functions: Sequence[np.ndarray], count: int) -> list[np.ndarray]:
    """The roots of functions (n, k), given with two derivatives, in ascending order: index of the
    function, ends of an interval, first guess, value at the lower end. count: of the roots that
    each has at least; where fewer are found, or three may be as one, finer samples are taken."""
    found, unclear = _sampled_brackets(points, functions, points.dense_nodes, points.dense)
    again = np.flatnonzero(unclear | (np.bincount(found[0], minlength=len(unclear)) < count))
    if len(again):
        fine = _fine(len(points.nodes) - 1)
        finer, _ = _sampled_brackets(points, [f[again] for f in functions], *fine)
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
    f, slopes = ((one @ rows.T).ravel() for one in functions[:2])
    below, falling = f < 0, slopes < 0
    changes = below[:-1] != below[1:]
    turns = (falling[:-1] != below[:-1]) & (falling[1:] == below[1:]) & ~changes
    changes[len(x) - 1 :: len(x)] = turns[len(x) - 1 :: len(x)] = False  # to the next function
    k = changes.nonzero()[0]
    i, cell = np.divmod(k, len(x))
    low, length, before = x[cell], x[cell + 1] - x[cell], f[k]
    rise = f[k + 1] - before
    first, last = length * slopes[k] / rise, length * slopes[k + 1] / rise
    unclear = np.zeros(len(functions[0]), bool)
    unclear[i[first + last > CURVED]] = True
    guess = low + length * _inverse_cubic(-before / rise, first, last)
    single = [i, low, low + length, guess, before]
    k = turns.nonzero()[0]
    if not len(k):
        return single, unclear
    i, cell = np.divmod(k, len(x))
    low, high, slope = x[cell], x[cell + 1], slopes[k]
    extremum = low + (high - low) * slope / (slope - slopes[k + 1])
    own = [one[i] for one in functions]
    close = _close_roots(points, own, low, extremum, high, f[k])
    pairs = zip(single, (np.append(i, i), *close), strict=True)
    columns = [np.concatenate(pair) for pair in pairs]
    order = (3.0 * columns[0] + columns[1]).argsort(kind="stable")  # by function, then lower end
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
    extremum, curve = extrema(points, slope, bend, (low, extremum, high), below > 0)
    least = np.vecdot(points.rows(extremum), value)
    apart = (least < 0) != (below < 0)
    low, high = np.where(apart, low, extremum), np.where(apart, high, extremum)
    away = np.where(apart, np.sqrt(abs(2 * least / curve)), 0.0)
    lows, highs = np.append(low, extremum), np.append(extremum, high)
    guesses = np.append(np.maximum(extremum - away, low), np.minimum(extremum + away, high))
    return lows, highs, guesses, np.append(np.where(apart, below, least), least)


def extrema(
    points: Lobatto,
    slope: np.ndarray,
    bend: np.ndarray,
    bracket: tuple[np.ndarray, np.ndarray, np.ndarray],
    least: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """The extremum (n,) in a bracket of each function, and the second derivative there, by Newton's
    method. slope, bend: the derivatives (n, k) at the points. bracket: lower end, guess and upper
    end. least: whether it is a minimum."""
    first, at, last = bracket
    curve = np.zeros(len(at))
    for _ in range(STEPS):
        rows = points.rows(at)
        rate, curve = np.vecdot(rows, slope), np.vecdot(rows, bend)
        before = (rate < 0) == least  # the extremum is above
        first, last = np.where(before, (at, last), (first, at))
        with np.errstate(divide="ignore", invalid="ignore"):
            newton = at - rate / curve
        inside = (newton >= first) & (newton <= last)
        step = np.where(inside, newton, (first + last) / 2) - at
        at = at + step
        if (abs(step) <= SETTLED).all():
            break
    return at, curve


def _inverse_cubic(t: np.ndarray, first: np.ndarray, last: np.ndarray) -> np.ndarray:
    """Guesses (n,) of roots in 0 .. 1 of functions with values -t and 1 - t and derivatives first
    and last at the ends: x as a cubic polynomial of the function, or where that is outside, t."""
    with np.errstate(divide="ignore", invalid="ignore"):
        x = t + t * (1 - t) * ((1 - t) * (1 / first - 1) - t * (1 / last - 1))
    return np.where((x > 0) & (x < 1), x, t)


@lru_cache(maxsize=8)
def _fine(order: int) -> tuple[np.ndarray, np.ndarray]:
    """Points that separate the roots of functions, and the interpolation there."""
    x = np.cos(np.linspace(np.pi, 0.0, FINE * (order + 1)))
    return x, lobatto(order).rows(x)


@lru_cache
def derivative(order: int) -> np.ndarray:
    """Matrix: values at the Chebyshev points -> the derivative of their interpolant there."""
    points = lobatto(order)
    away = points.nodes[:, None] - points.nodes + np.eye(order + 1)
    D = points.weights / points.weights[:, None] / away
    np.fill_diagonal(D, 0.0)
    np.fill_diagonal(D, -D.sum(axis=1))
    return D
