"""omega^2 along one parameter as Chebyshev interpolants on pieces, refined until they converge.

Within a family the k-th omega^2 is an analytic function of the parameter. Two that veer have branch
points near the real axis, but their mean and the square of their difference have none: these are
interpolated where omega^2 does not converge. Where a mode veers with both neighbours, as over beta,
a characteristic function of the family takes fewer solves.

Coupled modes have many narrow veerings: a characteristic function is interpolated, or the matrix of
a block of modes.

Solves at check points between the nodes measure the error of each interpolant.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from beamviz.frequency_loci import block, characteristic
from beamviz.frequency_loci.axis import Axis
from beamviz.frequency_loci.characteristic import Characteristic
from beamviz.frequency_loci.chebyshev import (
    CHECKS,
    EPS,
    LEAST,
    interpolated,
    lobatto,
    on_piece,
    tail_and_rates,
)
from beamviz.frequency_loci.pieces import Piece, of_root
from beamviz.frequency_loci.spectra import BENDING_ERROR, MISFIT, TAIL, Spectra, positive_shift
from beamviz.frequency_loci.sweep import Sweep
from beamviz.solver import is_small_strain

FIRST_ORDERS = {"gamma": 14, "alpha": 18, "delta": 8, "mu": 16}  # for a whole axis
STRETCHED_ORDER = 20  # over gamma, up to a large strain
PER_MODE = 4, 6  # over beta, per mode; the second where all modes couple
COUPLED_ORDERS = {"gamma": 20, "alpha": 18, "delta": 20, "mu": 32}  # where all modes couple
ORDERS = (LEAST, 32, 192)  # least; least and greatest for a whole axis before it is halved
FEW_NODES = 24  # order up to which a block is tried first: it is faster to evaluate
FEW = 64  # greatest order of a part of the axis; below it the convergence rate is inaccurate
MULTIPLES, EXPECTED = (2, 3, 4, 5, 6), 0.1  # of an order, for the next; error ratio to be expected
SHARE = 0.5  # accepted interpolation error, of the tolerance and of the solver's error
FLOOR = 1.0  # omega^2 below which the error is absolute, near the onset of instability
OUTSIDE = 1e3  # accepted error of the mode above the requested ones, relative to theirs
SHORTEST = 1e-8  # of the axis: length below which a piece is not halved
ISOLATED = 1 / 64  # of the axis: the same for a piece with a value without solution
AT_REST = 1e-7  # replaces gamma = 0 where all modes couple: omega^2 differs by its square
STALLED = (0.8, 3)  # reduction and number of halvings from which an error is not of interpolation


def _functions(spectra: Spectra, alone: bool) -> np.ndarray:
    """The functions interpolated, (functions, values, families, k): omega^2; unless `alone`, of
    coupled modes the bending fraction, else mean and squared difference of omega^2 and the next."""
    squares, _, bending = spectra
    if alone:
        return squares[None]
    if squares.shape[1] == 1:
        return np.stack((squares, bending))
    functions = np.full((3, *squares.shape), np.nan)
    functions[0] = squares
    functions[1, ..., :-1] = (squares[..., :-1] + squares[..., 1:]) / 2
    functions[2, ..., :-1] = (squares[..., 1:] - squares[..., :-1]) ** 2
    return functions


class _Attempt(NamedTuple):
    low: float  # of the variable t
    high: float
    order: int
    ratio: float = np.inf  # of the error to that accepted, before the piece was halved
    stalled: int = 0  # number of halvings that did not reduce it


@dataclass
class Interpolated:
    """A sweep with the modes of a piece instead of solves: interpolates the roots of characteristic
    functions again, by polynomials, which are faster."""

    sweep: Sweep
    axis: Axis
    piece: Piece
    modes: int
    tolerance: float
    coupled = False

    def spectra(self, values: np.ndarray) -> Spectra:
        """The interpolated modes; their errors are those of solver and interpolation."""
        squares, solver_error, bending, error = self.piece.at(self.axis.t(values))
        return Spectra(squares, solver_error + error, bending)

    def mesh_spectra(self, values: np.ndarray) -> None:
        """None."""

    def points(self, values: np.ndarray) -> Any:
        """Shapes, by solves."""
        return self.sweep.points(values)


Solves = Sweep | Interpolated


def interpolate(sweep: Sweep, axis: Axis) -> list[Piece]:
    """The pieces of an axis, ascending."""
    start, stop = axis.t_ends
    if start == stop:
        return [unresolved(axis, sweep.spectra(np.array([axis.low])))]
    return _interpolate(sweep, axis, _first(sweep, axis))


def _interpolate(sweep: Sweep, axis: Axis, first: _Attempt) -> list[Piece]:
    """The pieces of an attempt, ascending; the solves of each round are batched."""
    whole = first.high - first.low
    shortest = SHORTEST * whole
    pending = [first]
    pieces: list[Piece] = []
    while pending:
        values = [_values_of(axis, attempt) for attempt in pending]
        spectra, start, following = sweep.spectra(np.concatenate(values)), 0, []
        for attempt, own in zip(pending, values, strict=True):
            solved = spectra.take(slice(start, start := start + len(own)))
            piece, ratio, next_order = _fit(sweep, attempt, own, solved)
            low, high = attempt[:2]
            if high - low == whole and attempt.order < ORDERS[1]:
                next_order = max(next_order, 2 * attempt.order)
            worse = not ratio <= STALLED[0] * attempt.ratio
            stalled = attempt.stalled + 1 if worse else 0
            least = shortest if np.isfinite(ratio) else ISOLATED * whole
            short = high - low <= least or stalled >= STALLED[1]
            if piece.characteristics and not sweep.coupled:
                pieces.append(_faster(sweep, axis, piece))
            elif piece.errors is not None or sweep.exhausted or short:
                pieces.append(piece)
            elif next_order > attempt.order and (next_order <= FEW or high - low == whole):
                following.append(attempt._replace(order=next_order))
            else:
                middle = (low + high) / 2
                halves = (low, middle), (middle, high)
                following += [_Attempt(*half, ORDERS[0], ratio, stalled) for half in halves]
        pending = following
    return sorted(pieces, key=lambda piece: piece.low)


def _faster(sweep: Sweep, axis: Axis, piece: Piece) -> Piece:
    """The modes of a piece of characteristic functions as polynomials, where these converge."""
    found = Interpolated(sweep, axis, piece, sweep.modes, sweep.tolerance)
    attempt = _Attempt(piece.low, piece.high, ORDERS[2])
    values = _values_of(axis, attempt)
    other, *_ = _fit(found, attempt, values, found.spectra(values))
    return piece if other.errors is None else other


def first_values(sweep: Sweep, axis: Axis) -> np.ndarray:
    """The first values that the interpolation of an axis solves."""
    return _values_of(axis, _first(sweep, axis))


def _first(sweep: Sweep, axis: Axis) -> _Attempt:
    """The whole axis, of an order that often suffices: over beta in proportion to the number of
    modes, whose waves the mass passes."""
    start, stop = axis.t_ends
    orders = COUPLED_ORDERS if axis.coupled else FIRST_ORDERS
    order = orders.get(axis.over, PER_MODE[axis.coupled] * sweep.modes + 8)
    if axis.over == "gamma" and not is_small_strain(sweep.at(axis.high)):
        order = max(order, STRETCHED_ORDER)
    return _Attempt(start, stop, order)


def unresolved(axis: Axis, spectra: Spectra) -> Piece:
    """An axis as one piece without interpolation."""
    none = np.zeros(spectra.squares.shape[1:], bool)
    start, stop = axis.t_ends
    return Piece(start, stop, spectra, None, none, none)


def _values_of(axis: Axis, attempt: _Attempt) -> np.ndarray:
    """The nodes of a piece and its check points, as values of the parameter."""
    low, high, order, *_ = attempt
    points = lobatto(order)
    values = axis.p(on_piece(low, high, np.concatenate((points.nodes, points.check_nodes))))
    return np.maximum(values, AT_REST) if axis.over == "gamma" and axis.coupled else values


@np.errstate(all="ignore")  # modes not known at all values are nan
def _fit(
    sweep: Solves, attempt: _Attempt, values: np.ndarray, solved: Spectra
) -> tuple[Piece, float, int]:
    """The piece of an attempt, the ratio of its error to that accepted, and the next order."""
    low, high, order, *_ = attempt
    nodes = solved.take(slice(order + 1))
    rank = np.where(np.isfinite(solved.squares), solved.rank, np.inf).min(axis=0)
    needed = rank <= sweep.modes if not sweep.coupled else rank < sweep.modes
    none = np.zeros(needed.shape, bool)
    piece = Piece(low, high, nodes, None, needed, none)
    if not np.isfinite(solved.squares[:, needed]).all():
        return piece, np.inf, order
    accepted = _accepted(sweep, solved, rank)
    errors, rates = _estimates(order, _functions(solved, not sweep.coupled))
    alone, least = np.where(needed, errors[0] / accepted, 0.0), np.empty(0)
    if not sweep.coupled and not (alone <= 1).all():
        functions = _functions(solved, False)
        errors, rates = _estimates(order, functions)
        least = interpolated(lobatto(order).dense, functions[2, : order + 1]).min(axis=0)

    def cover(errors: np.ndarray) -> tuple[np.ndarray, float]:
        if sweep.coupled:
            errors = np.maximum(errors[0] / accepted, errors[-1] / BENDING_ERROR)
            return none, float(np.where(needed, errors, 0.0).max())
        return _cover(errors, least, needed, accepted)

    paired, ratio = cover(errors)
    if ratio <= 1:
        piece = replace(piece, errors=errors, needed=needed | _next(paired), paired=paired)
        return piece, ratio, order
    targets = [_next_order(order, lambda power: cover(errors * rates**power)[1])]
    fits = [_by_block, _by_characteristics] if sweep.coupled else [_by_characteristics]
    for fit in fits if order <= FEW_NODES else fits[::-1]:
        if more := fit(sweep, values, solved, replace(piece, errors=errors), accepted, alone):
            found, own, rate = more
            ratio = min(ratio, float(own.max()))
            if own.max() <= 1:
                return found, ratio, order
            targets.append(_next_order(order, partial(_largest, own, rate)))
    return piece, ratio, min({*targets} - {order}, default=order)


def _largest(ratios: np.ndarray, rate: Any, power: int) -> float:
    """The largest of ratios that fall by a power of a rate."""
    return float((ratios * rate**power).max())


def _by_block(
    sweep: Solves,
    values: np.ndarray,
    solved: Spectra,
    piece: Piece,
    accepted: np.ndarray,
    alone: np.ndarray,
) -> tuple[Piece, np.ndarray, Any] | None:
    """The piece with a block of coupled modes, the ratios of its errors to those accepted, and the
    factors by which they fall when the order grows by a half. None without shapes."""
    if not (fitted := block.fit(sweep.points(values), solved, piece.order)):
        return None
    found, errors, rates = fitted
    ratios = errors / accepted[0, : len(errors)]
    known = np.zeros(piece.needed.shape, bool)
    known[0, : len(errors)] = (ratios <= 1) & np.isfinite(accepted[0, : len(errors)])
    needed = piece.needed[0, : len(errors)]
    return replace(piece, needed=known, block=found), ratios[needed], rates[needed]


def _by_characteristics(
    sweep: Solves,
    values: np.ndarray,
    solved: Spectra,
    piece: Piece,
    accepted: np.ndarray,
    alone: np.ndarray,
) -> tuple[Piece, np.ndarray, Any] | None:
    """The piece with characteristic functions of the families with a ratio above 1 in `alone`, the
    error ratios (families, k) with them, and the factor by which the largest falls when the order
    grows by a half. None without the spectra of all meshes."""
    needed = np.isfinite(accepted)
    spectra, kinetic = sweep.mesh_spectra(values), None
    if spectra is None:
        return None
    nodes = len(values) - len(CHECKS)
    if sweep.coupled:
        kinetic = np.diagonal(sweep.points(values).kinetic, axis1=2, axis2=3)[:nodes]
        if not kinetic.size:
            return None
    found: list[Characteristic | None] = []
    ratios, rate = alone.copy(), EPS
    for f, own in enumerate(np.moveaxis(spectra, 1, 0)):
        modes = int(np.flatnonzero(needed[f]).max(initial=-1)) + 1
        if not sweep.coupled and (alone[f] <= 1).all():
            found.append(None)
            continue
        if not np.isfinite(own[:, :modes]).all():
            return None
        shift = positive_shift(own[:, :modes])
        one, bending, changes, falls = characteristic.fit(
            own[:nodes], own[nodes:, :modes], modes, shift, kinetic
        )
        errors = np.maximum(TAIL * changes, MISFIT * one.misfit)
        errors = np.where(np.isfinite(errors), errors, np.inf)
        if sweep.coupled:
            off = abs(bending - solved.bending[nodes:, f, :modes]).max(axis=0)
            off[sweep.modes :] = 0.0
            errors = np.maximum(errors, off / BENDING_ERROR * accepted[f, :modes])
        ratios[f, :modes] = np.where(needed[f, :modes], errors / accepted[f, :modes], 0.0)
        rate = max(rate, falls)
        found.append(one)
    return replace(piece, needed=needed, characteristics=tuple(found)), ratios, rate


def _next_order(order: int, ratio: Callable[[int], float]) -> int:
    """The least multiple of an order, which includes its nodes, with an expected error ratio of at
    most EXPECTED, or a step towards it; the order itself if there is none. ratio: of the power of
    the rates by which errors fall when the order grows by a half."""
    multiples = (m for m in MULTIPLES if m * order <= ORDERS[2])
    best = next((m for m in multiples if ratio(2 * (m - 1)) <= EXPECTED), 1)
    return order * (min(best, 2) if order < FEW else best)


def _accepted(sweep: Solves, solved: Spectra, rank: np.ndarray) -> np.ndarray:
    """The errors (families, k) of omega^2 that are accepted."""
    inside = solved.rank < sweep.modes
    size = np.where(inside, abs(solved.squares), np.inf).min(axis=0)
    own = np.where(inside & np.isfinite(solved.errors), solved.errors, np.inf).min(axis=0)
    accepted = SHARE * (sweep.tolerance * (size + FLOOR) + np.where(np.isfinite(own), own, 0.0))
    size = abs(solved.squares).min(axis=0)
    outside = SHARE * OUTSIDE * sweep.tolerance * (size + FLOOR)
    accepted = np.where(rank >= sweep.modes, outside, accepted)
    return np.where(rank <= sweep.modes, accepted, np.inf)


def _next(paired: np.ndarray) -> np.ndarray:
    """The modes (families, k) above paired ones."""
    return np.pad(paired[:, :-1], ((0, 0), (1, 0)))


def _estimates(order: int, functions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The errors (functions, families, k) of functions at the nodes and check points, and the
    factors by which they fall when the order grows by a half."""
    points, shape = lobatto(order), (len(functions), *functions.shape[2:])
    flat = np.moveaxis(functions, 1, 0).reshape(functions.shape[1], -1)
    nodes, checks = flat[: order + 1], flat[order + 1 :]
    tail, rates = tail_and_rates(abs(points.coefficients @ nodes), order)
    misfit = abs(points.checks @ nodes - checks).max(axis=0)
    errors = np.maximum(TAIL * tail, MISFIT * misfit) + EPS * abs(nodes).max(axis=0)
    return errors.reshape(shape), rates.reshape(shape)


def _cover(
    errors: np.ndarray, least: np.ndarray, needed: np.ndarray, accepted: np.ndarray
) -> tuple[np.ndarray, float]:
    """Whether modes (families, k) of uncoupled families are interpolated in a pair with the next
    one, for the least errors, and the largest ratio of an error to that accepted.

    least: least squared differences; not used where all modes converge alone."""
    alone = np.where(needed, errors[0] / accepted, 0.0)
    paired, worst = np.zeros(needed.shape, bool), 0.0
    if (alone <= 1).all():
        return paired, float(alone.max())
    together = (errors[1] + of_root(least, errors[2])) / np.fmin(
        accepted, np.pad(accepted[:, 1:], ((0, 0), (0, 1)), constant_values=np.inf)
    )
    together = np.where(np.isfinite(together), together, np.inf)
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
