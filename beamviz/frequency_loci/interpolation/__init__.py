"""omega^2 along one parameter as interpolants on pieces of its range, refined until they converge:
the order grows, or the piece is halved."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from beamviz.frequency_loci.axis import Axis
from beamviz.frequency_loci.interpolation.chebyshev import LEAST, lobatto, on_piece
from beamviz.frequency_loci.interpolation.fits import Nodes, by_characteristics, by_squares
from beamviz.frequency_loci.interpolation.pieces import Piece
from beamviz.frequency_loci.sweep import Spectra, Sweep
from beamviz.solver.hp.equilibrium import is_small_strain
from beamviz.solver.hp.mesh_design import half_waves

# First order for a whole axis, per length of its variable and in addition; the second where all
# modes couple: over random charts the order needed is nearly a linear function of the length.
FIRST_ORDERS: dict[str, tuple[tuple[float, float], ...]] = {
    "gamma": ((3.2, 4.5), (7.5, 6.5)),
    "alpha": ((3.5, 5.0), (4.0, 7.0)),
    "delta": ((0.0, 8.0), (4.0, 6.5)),
    "mu": ((6.0, 4.0),),
}
STRETCHED_ORDERS = 24, 32  # over gamma, up to a large strain; the second with an inner mass
PER_MODE = (4, 6), (6, 8)  # over beta, and in addition; the second where all modes couple
# Over mu where all modes couple: per mode along the beam that leaves the lowest, and in addition.
PER_STRETCHING_MODE = 4, 14
ORDERS = (LEAST, 32, 192)  # least; least and greatest for a whole axis before it is halved
FEW = 64  # greatest order of a part of the axis; below it the convergence rate is inaccurate
MULTIPLES, EXPECTED = (2, 3, 4, 5, 6), 0.1  # of an order, for the next; error ratio to be expected
SHORTEST = 1 / 64  # of the axis: length below which a piece is not halved
AT_REST = 1e-7  # replaces gamma = 0 where all modes couple: omega^2 differs by its square


class _Attempt(NamedTuple):
    low: float  # of the variable t
    high: float
    order: int


def interpolate(sweep: Sweep, axis: Axis) -> list[Piece]:
    """The pieces of an axis, ascending; the solves of each round are batched."""
    start, stop = axis.t_ends
    whole = stop - start
    if not whole:
        return [unresolved(axis, sweep.spectra(np.array([axis.low])))]
    pending = [_first(sweep, axis)]
    pieces: list[Piece] = []
    while pending:
        values = [_values_of(axis, attempt) for attempt in pending]
        spectra, start, following = sweep.spectra(np.concatenate(values)), 0, []
        for attempt, own in zip(pending, values, strict=True):
            solved = spectra.take(slice(start, start := start + len(own)))
            low, high, order = attempt
            piece, next_order = _fit(Nodes(sweep, axis, low, high, order, own, solved))
            if high - low == whole and order < ORDERS[1]:
                next_order = max(next_order, 2 * order)
            short = high - low <= SHORTEST * whole
            if piece.characteristics and not sweep.coupled:
                pieces.append(_faster(sweep, axis, piece))
            elif piece.errors is not None or sweep.exhausted or short:
                pieces.append(piece)
            elif next_order > order and (next_order <= FEW or high - low == whole):
                following.append(attempt._replace(order=next_order))
            else:
                middle = (low + high) / 2
                halves = (low, middle), (middle, high)
                following += [_Attempt(*half, ORDERS[0]) for half in halves]
        pending = following
    return sorted(pieces, key=lambda piece: piece.low)


@np.errstate(all="ignore")  # modes not known at all values are nan
def _fit(nodes: Nodes) -> tuple[Piece, int]:
    """The piece, with errors if an interpolant was accepted, and the next order."""
    orders = []
    if np.isfinite(nodes.solved.squares[:, nodes.needed]).all():
        for fit in filter(None, (way(nodes) for way in (by_squares, by_characteristics))):
            if fit.ratio(0) <= 1:
                return fit.piece, nodes.order
            orders.append(_next_order(nodes.order, fit.ratio))
    return nodes.piece, min((order for order in orders if order > nodes.order), default=nodes.order)


@np.errstate(all="ignore")
def _faster(sweep: Sweep, axis: Axis, piece: Piece) -> Piece:
    """The modes of a piece of characteristic functions as polynomials, where these converge."""
    attempt = _Attempt(piece.low, piece.high, ORDERS[2])
    values = _values_of(axis, attempt)
    squares, solver_error, bending, error = piece.at(axis.t(values))
    spectra = Spectra(squares, solver_error + error, bending)
    fit = by_squares(Nodes(sweep, axis, *attempt, values, spectra))
    return fit.piece if fit.ratio(0) <= 1 else piece


def first_values(sweep: Sweep, axis: Axis) -> np.ndarray:
    """The first values that the interpolation of an axis solves."""
    return _values_of(axis, _first(sweep, axis))


def _first(sweep: Sweep, axis: Axis) -> _Attempt:
    """The whole axis, of an order that often suffices: over beta by the number of modes, whose
    waves the mass passes; over mu of coupled modes by the number of those along the beam that rise
    above the requested ones; else by the length of the axis."""
    start, stop = axis.t_ends
    if axis.over == "beta":
        each, more = PER_MODE[axis.coupled]
        order = each * sweep.modes + more
    elif axis.over == "mu" and axis.coupled:
        first, last = (half_waves(mu, sweep.modes + 1).along for mu in (axis.low, axis.high))
        order = PER_STRETCHING_MODE[0] * (first - last) + PER_STRETCHING_MODE[1]
    else:
        slope, least = FIRST_ORDERS[axis.over][axis.coupled]
        order = math.ceil(slope * axis.length + least)
    if axis.over == "gamma" and not is_small_strain(sweep.at(axis.high)):
        order = max(order, STRETCHED_ORDERS[sweep.beam.alpha > 0 and sweep.beam.beta < 1])
    return _Attempt(start, stop, order)


def unresolved(axis: Axis, spectra: Spectra) -> Piece:
    """An axis as one piece without interpolation."""
    start, stop = axis.t_ends
    return Piece(axis, start, stop, spectra, None, np.zeros(spectra.squares.shape[1:], bool))


def _values_of(axis: Axis, attempt: _Attempt) -> np.ndarray:
    """The nodes of a piece and its check points, as values of the parameter."""
    low, high, order = attempt
    points = lobatto(order)
    values = axis.p(on_piece(low, high, np.concatenate((points.nodes, points.check_nodes))))
    return np.maximum(values, AT_REST) if axis.over == "gamma" and axis.coupled else values


def _next_order(order: int, ratio: Callable[[int], float]) -> int:
    """The least multiple of an order, which includes its nodes, with an expected error ratio of at
    most EXPECTED, or a step towards it; the order itself if there is none. ratio: of the power of
    the rates by which errors fall when the order grows by a half."""
    multiples = (m for m in MULTIPLES if m * order <= ORDERS[2])
    best = next((m for m in multiples if ratio(2 * (m - 1)) <= EXPECTED), 1)
    return order * (min(best, 2) if order < FEW else best)
