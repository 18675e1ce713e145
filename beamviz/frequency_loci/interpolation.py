"""omega^2 along one parameter as Chebyshev interpolants on pieces, refined until they converge.

Within a family, or among modes that all couple, the k-th omega^2 is an analytic function of the
parameter. Two that veer have branch points near the real axis, but their mean and the square of
their difference have none: where one does not converge by itself, these are interpolated instead.
Solves between the nodes, which no interpolant uses, check the error of each.
"""

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple, Protocol

import numpy as np

from beamviz.frequency_loci.axis import Axis

ORDERS = (16, 64)  # of a piece, least and greatest: doubled where that promises to be enough
SHARE = 0.25  # of the tolerance, and of the solver's error: an interpolation error that is accepted
FLOOR = 1.0  # omega^2 below which the error is absolute, near the onset of instability
BENDING_ERROR = 1e-3  # accepted error of the bending fraction
OUTSIDE = 1e3  # times that of requested modes: accepted error of the mode above them
TAIL, MISFIT = 8.0, 8.0  # safety of the two estimates of error
SHORTEST = 1e-8  # of the axis: a shorter piece is not halved
STALLED = (0.8, 3)  # an error that falls by less, for so many halvings, is not interpolation's
CHECKS = np.array([1, 6, 11]) + 1 / 3  # numbers of the check points among the nodes of order 16


class Spectra(NamedTuple):
    """Modes at values of a parameter by family: bending, then stretching; or all as one."""

    squares: np.ndarray  # (values, families, k) omega^2, ascending; nan where not solved for
    errors: np.ndarray  # (values, families, k) estimated by the solver; nan where it does not
    bending: np.ndarray  # (values, families, k) bending fraction

    def take(self, index: slice) -> "Spectra":
        """The modes at the values of an index."""
        return Spectra(*(array[index] for array in (self.squares, self.errors, self.bending)))

    @property
    def rank(self) -> np.ndarray:
        """The place (values, families, k) of each mode by frequency among all, from 0."""
        flat = self.squares.reshape(len(self.squares), -1)
        return flat.argsort(axis=1).argsort(axis=1).reshape(self.squares.shape)


class Solves(Protocol):
    """What is interpolated."""

    modes: int

    @property
    def tolerance(self) -> float:
        """Relative error of a frequency that is asked for."""

    @property
    def coupled(self) -> bool:
        """Whether all modes couple; else the families are independent."""

    @property
    def exhausted(self) -> bool:
        """Whether no more solves are to be spent on refinement."""

    def spectra(self, values: np.ndarray) -> Spectra:
        """The modes at some values; nan where there is no solution."""


@dataclass(frozen=True)
class Lobatto:
    """Chebyshev points of the second kind on -1 .. 1, ascending."""

    nodes: np.ndarray  # (n,)
    weights: np.ndarray  # (n,) barycentric
    coefficients: np.ndarray  # (n, n) values -> Chebyshev coefficients
    checks: np.ndarray  # (checks, n) values -> the interpolant at the check points
    dense: np.ndarray  # (4 n - 3, n) values -> the interpolant at many points

    def rows(self, x: np.ndarray) -> np.ndarray:
        """Matrix (len(x), n): values at the nodes -> their interpolant at x."""
        away = x[:, None] - self.nodes
        hits = away == 0
        away[hits.any(axis=1)] = np.inf
        away[hits] = 1.0
        terms = self.weights / away
        return terms / terms.sum(axis=1, keepdims=True)


CHECK_X = -np.cos(np.pi * CHECKS / ORDERS[0])


@lru_cache(maxsize=4)
def lobatto(order: int) -> Lobatto:
    """The points of an order, one more than it."""
    j = np.arange(order + 1)
    nodes = -np.cos(np.pi * j / order)
    nodes[[0, order // 2, -1]] = -1.0, 0.0, 1.0
    ends = np.where(j % order == 0, 0.5, 1.0)
    T = np.cos(np.outer(j, np.arccos(nodes)))
    empty = np.empty((0, order + 1))
    points = Lobatto(nodes, ends * (-1.0) ** j, 2 / order * np.outer(ends, ends) * T, empty, empty)
    return replace(points, checks=points.rows(CHECK_X), dense=points.rows(dense_points(order)))


def dense_points(order: int) -> np.ndarray:
    """Points on -1 .. 1 at which a piece is sampled: the nodes, and three between each two."""
    return -np.cos(np.pi * np.arange(4 * order + 1) / (4 * order))


class Errors(NamedTuple):
    """Errors of the interpolation on a piece, by functions as in `_functions`: (families, k)."""

    square: np.ndarray
    mean: np.ndarray
    difference: np.ndarray
    bending: np.ndarray
    mean_bending: np.ndarray
    difference_bending: np.ndarray


def _functions(spectra: Spectra) -> np.ndarray:
    """What is interpolated, (6, values, families, k): omega^2; of it and the next one the mean and
    the square of their difference; the bending fraction; of it and the next the mean, and the
    difference times that of omega^2."""
    squares, _, bending = spectra
    functions = np.full((6, *squares.shape), np.nan)
    below, above = (..., slice(None, -1)), (..., slice(1, None))
    difference = squares[above] - squares[below]
    functions[0], functions[3] = squares, bending
    functions[1][below] = (squares[below] + squares[above]) / 2
    functions[2][below] = difference**2
    functions[4][below] = (bending[below] + bending[above]) / 2
    functions[5][below] = (bending[above] - bending[below]) * difference
    return functions


@dataclass(frozen=True)
class Piece:
    """A part of the axis with the modes at its nodes; `errors` is None where the interpolation did
    not converge: the modes at the solved values are all that is known there."""

    low: float  # of the variable t
    high: float
    spectra: Spectra
    errors: Errors | None
    needed: np.ndarray  # (families, k) whether the mode is interpolated
    paired: np.ndarray  # (families, k) whether with the next one

    @property
    def order(self) -> int:
        """One less than its nodes."""
        return len(self.spectra.squares) - 1

    @property
    def dense(self) -> np.ndarray:
        """Values of the variable at which the piece is sampled."""
        return _on(self.low, self.high, dense_points(self.order))

    def at(self, t: np.ndarray) -> tuple[Spectra, np.ndarray]:
        """The modes at values (n,) of the variable, and the errors (n, families, k) of omega^2 from
        interpolation, which come on top of the solver's; nan where it is not interpolated."""
        assert self.errors
        points = lobatto(self.order)
        rows = points.rows(2 * (t - self.low) / (self.high - self.low) - 1)
        functions = _functions(self.spectra)
        flat = functions.transpose(1, 0, 2, 3).reshape(self.order + 1, -1)
        found = (rows @ np.where(np.isfinite(flat), flat, 0.0)).reshape(
            len(t), *functions[:, 0].shape
        )
        found = found.transpose(1, 0, 2, 3)
        squares = found[0].copy()
        first = self.spectra.bending[0]  # 1 or 0 throughout where nothing couples the families
        bending = np.where((self.spectra.bending == first).all(axis=0), first, found[3])
        error = np.broadcast_to(self.errors.square, squares.shape).copy()
        for f, k in np.argwhere(self.paired).tolist():
            _, mean, square, _, mean_bending, difference_bending = found[:, :, f, k]
            difference = np.sqrt(np.maximum(square, 0.0))
            squares[:, f, k], squares[:, f, k + 1] = mean - difference / 2, mean + difference / 2
            error[:, f, k] = error[:, f, k + 1] = self.errors.mean[f, k] + _of_root(
                square, self.errors.difference[f, k]
            )
            half = difference_bending / np.maximum(2 * difference, np.finfo(float).tiny)
            bending[:, f, k], bending[:, f, k + 1] = mean_bending - half, mean_bending + half
        solved = self.spectra.errors
        after = np.clip(
            np.searchsorted(points.nodes, 2 * (t - self.low) / (self.high - self.low) - 1),
            1,
            self.order,
        )
        own = np.maximum(solved[after - 1], solved[after])
        kept = np.where(self.needed, 1.0, np.nan)
        return Spectra(squares * kept, own * kept, np.clip(bending, 0, 1) * kept), error * kept


def _of_root(square: np.ndarray, error: np.ndarray) -> np.ndarray:
    """The error of half the root of a square with an error."""
    square = np.maximum(square, 0.0)
    below = np.sqrt(square) + np.sqrt(square + error)
    return error / np.maximum(2 * below, np.finfo(float).tiny)


def _on(low: float, high: float, x: np.ndarray) -> np.ndarray:
    """Points x of -1 .. 1 on a piece; its ends exactly."""
    return np.where(x == 1, high, low + (high - low) * (x + 1) / 2)


class _Attempt(NamedTuple):
    low: float
    high: float
    order: int
    ratio: float = np.inf  # of the error to that accepted, before it was halved
    stalled: int = 0  # halvings that did not reduce it


def interpolate(sweep: Solves, axis: Axis) -> list[Piece]:
    """The pieces of an axis, ascending; in each round all of them are solved for at once."""
    start, stop = axis.t(np.array(axis.ends)).tolist()
    if start == stop:
        return [unresolved(axis, sweep.spectra(np.array([axis.low])))]
    shortest = SHORTEST * (stop - start)
    pending = [_Attempt(start, stop, ORDERS[0])]
    pieces: list[Piece] = []
    while pending:
        places = [_places(axis, attempt) for attempt in pending]
        spectra, start, following = sweep.spectra(np.concatenate(places)), 0, []
        for attempt, own in zip(pending, places, strict=True):
            solved = spectra.take(slice(start, start := start + len(own)))
            piece, ratio, next_order = _fit(sweep, attempt, solved)
            low, high = attempt[:2]
            worse = ratio > STALLED[0] * attempt.ratio
            stalled = attempt.stalled + 1 if worse else 0
            short = high - low <= shortest or stalled >= STALLED[1]
            if piece.errors or sweep.exhausted or short:
                pieces.append(piece)
            elif next_order > attempt.order:
                following.append(attempt._replace(order=2 * attempt.order))
            else:
                middle = (low + high) / 2
                halves = (low, middle), (middle, high)
                following += [_Attempt(*half, ORDERS[0], ratio, stalled) for half in halves]
        pending = following
    return sorted(pieces, key=lambda piece: piece.low)


def root_places(axis: Axis) -> np.ndarray:
    """The values that the interpolation of an axis begins with."""
    start, stop = axis.t(np.array(axis.ends)).tolist()
    return _places(axis, _Attempt(start, stop, ORDERS[0]))


def unresolved(axis: Axis, spectra: Spectra) -> Piece:
    """An axis as one piece that is not interpolated."""
    none = np.zeros(spectra.squares.shape[1:], bool)
    start, stop = axis.t(np.array(axis.ends)).tolist()
    return Piece(start, stop, spectra, None, none, none)


def _places(axis: Axis, attempt: _Attempt) -> np.ndarray:
    """The nodes of a piece and its check points, as values of the parameter."""
    low, high, order, *_ = attempt
    return axis.p(_on(low, high, np.concatenate((lobatto(order).nodes, CHECK_X))))


@np.errstate(all="ignore")  # of modes that are not known everywhere
def _fit(sweep: Solves, attempt: _Attempt, solved: Spectra) -> tuple[Piece, float, int]:
    """The piece of an attempt; the ratio of its error to that accepted; the next order to try."""
    low, high, order, *_ = attempt
    nodes, checks = solved.take(slice(order + 1)), solved.take(slice(order + 1, None))
    rank = np.where(np.isfinite(solved.squares), solved.rank, np.inf).min(axis=0)
    needed = rank <= sweep.modes if not sweep.coupled else rank < sweep.modes
    piece = Piece(low, high, nodes, None, needed, np.zeros(needed.shape, bool))
    if not np.isfinite(solved.squares[:, needed]).all():
        return piece, np.inf, order
    inside = solved.rank < sweep.modes
    size = np.where(inside, abs(solved.squares), np.inf).min(axis=0)
    own = np.where(inside & np.isfinite(solved.errors), solved.errors, np.inf).min(axis=0)
    accepted = SHARE * (sweep.tolerance * (size + FLOOR) + np.where(np.isfinite(own), own, 0.0))
    outside = rank >= sweep.modes
    size = abs(solved.squares).min(axis=0)
    accepted = np.where(outside, SHARE * OUTSIDE * sweep.tolerance * (size + FLOOR), accepted)
    accepted = np.where(needed, accepted, np.inf)
    errors, rates, least = _estimates(order, nodes, checks)
    paired, ratio = _cover(errors, least, needed, accepted, sweep.coupled)
    if ratio <= 1:
        return (
            replace(piece, errors=errors, needed=needed | _next(paired), paired=paired),
            ratio,
            order,
        )
    target, power = 2 * order, 2  # an error falls by its rate in half as many orders as there are
    while target <= ORDERS[1]:
        expected = Errors(*(error * rate**power for error, rate in zip(errors, rates, strict=True)))
        if _cover(expected, least, needed, accepted, sweep.coupled)[1] <= 1:
            return piece, ratio, 2 * order
        target, power = 2 * target, 2 * power + 2
    return piece, ratio, order


def _next(paired: np.ndarray) -> np.ndarray:
    """The modes (families, k) above those that are paired."""
    return np.pad(paired[:, :-1], ((0, 0), (1, 0)))


def _estimates(
    order: int, nodes: Spectra, checks: Spectra
) -> tuple[Errors, np.ndarray, np.ndarray]:
    """The errors of all functions, by what factors (6, families, k) they are expected to fall when
    the order is doubled, and the least square (families, k) of each difference."""
    points, functions = lobatto(order), _functions(nodes)
    shape = functions[:, 0].shape
    flat = functions.transpose(1, 0, 2, 3).reshape(order + 1, -1)
    coefficients = abs(points.coefficients @ flat)
    tail = coefficients[-3:].max(axis=0)
    off = abs(
        points.checks @ flat - _functions(checks).transpose(1, 0, 2, 3).reshape(len(CHECKS), -1)
    )
    misfit = off.max(axis=0)
    rounding = np.finfo(float).eps * abs(flat).max(axis=0)
    errors = np.maximum(TAIL * tail, MISFIT * misfit) + rounding
    middle = coefficients[order // 2 - 1 : order // 2 + 2].max(axis=0)
    rates = np.minimum(tail / np.maximum(middle, np.finfo(float).tiny), 1.0)
    least = (points.dense @ functions[2].reshape(order + 1, -1)).min(axis=0)
    return Errors(*errors.reshape(shape)), rates.reshape(shape), least.reshape(shape[1:])


def _cover(
    errors: Errors, least: np.ndarray, needed: np.ndarray, accepted: np.ndarray, coupled: bool
) -> tuple[np.ndarray, float]:
    """Which modes (families, k) are interpolated in a pair with the next one so that the errors of
    all are accepted, and the largest ratio of an error to that accepted."""
    alone = errors.square / accepted
    least = np.maximum(least, 0.0)
    together = (errors.mean + _of_root(least, errors.difference)) / np.fmin(
        accepted, np.pad(accepted[:, 1:], ((0, 0), (0, 1)), constant_values=np.inf)
    )
    if coupled:
        alone = np.maximum(alone, errors.bending / BENDING_ERROR)
        root = np.maximum(np.sqrt(least), np.finfo(float).tiny)
        of_bending = errors.difference_bending / (2 * root) + errors.difference / (4 * root**2)
        together = np.maximum(together, (errors.mean_bending + of_bending) / BENDING_ERROR)
    alone = np.where(needed, alone, 0.0)
    together = np.where(np.isfinite(together), together, np.inf)
    paired, worst = np.zeros(needed.shape, bool), 0.0
    for f, k in np.argwhere(~(alone <= 1)).tolist():  # those that do not converge alone
        free = not paired[f, k] and not (k and paired[f, k - 1])
        if not free:
            continue
        down = together[f, k - 1] if k and not (k > 1 and paired[f, k - 2]) else np.inf
        up = together[f, k] if k + 1 < needed.shape[1] and not paired[f, k + 1] else np.inf
        own = alone[f, k] if np.isfinite(alone[f, k]) else np.inf
        best = min(own, down, up)
        worst = max(worst, best)
        if up <= min(down, own):
            paired[f, k] = True
        elif down <= own:
            paired[f, k - 1] = True
    return paired, worst
