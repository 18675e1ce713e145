"""Crossings and veerings of two loci: location, gap and veering index.

Loci of uncoupled families cross at the roots of differences of omega^2. Coupled modes do not cross,
however narrowly they veer (von Neumann & Wigner 1929).
"""

import math
from collections.abc import Generator, Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, TypeVar

import numpy as np

from beamviz.frequency_loci.curves import Curves, Root, polish
from beamviz.frequency_loci.interpolation.chebyshev import lobatto, on_piece
from beamviz.frequency_loci.interpolation.roots import derivative, extrema
from beamviz.frequency_loci.mode_vectors import Points
from beamviz.frequency_loci.sweep import Sweep
from beamviz.frequency_loci.two_modes import FLOOR, TINY, TOUCHING, Approach, closest, reduce

# A veering is a least gap below CLOSE of the frequency with a veering index of at least MIN_INDEX,
# and shapes that rotate into each other by ROTATED or more (a complete veering: 90 degrees) between
# the points of greatest gap before and after it.
CLOSE = 0.1
ROTATED = math.radians(30)
REACH = 10.0  # widths of a veering beyond which the shapes hardly rotate
MIN_INDEX = 0.5
DIFFERENCE_STEP = 0.01  # of the width of a veering: step of the central differences of its rates
OUTSIDE = 1e-2  # relative margin of omega^2 by which an interpolated mode is below a crossing
WIDER = 2.0  # of CLOSE: sampled gap below which a minimum is examined

MAX_SOLVES = 8  # for one veering
SETTLED = 1e-4  # of the width of a veering: shift below which the search ends
FINEST = 1e-6  # of the interval between samples: the same
ROUGH = 1e-3  # of the interval: shift below which one that no longer shrinks is rounding error
SAME = 1e-3  # relative change of the gap below which the search ends
ABOUT = 0.3, 4.0  # of REACH: distances of solved points that serve as well
NEAR = 0.02  # of the width: error of a guess at which its neighbouring points serve
GAP_ORDER = 6  # of the interpolant of a squared gap between three samples

Result = TypeVar("Result")
Search = Generator[np.ndarray, Any, Result]  # yields values at which Points are needed

Kind = Literal["crossing", "veering", "buckling", "limit point", "second state"]


@dataclass(frozen=True)
class Event:
    """A crossing or veering of two branches, with their least gap at `at`; or an event of the
    equilibrium (see `limits.state_events`), with the lowest branches before and after it,
    gap and width 0."""

    kind: Kind
    branches: tuple[Any, Any]  # labels; before these are known (family, index)
    at: float
    frequency: float  # mean of the two
    gap: float = 0.0  # of a crossing
    coupling: float = 0.0  # s_ab = phi_a' (K' - lambda M') phi_b, lambda the mean of the pair
    index: float = 0.0  # veering index MDF_ab CSQ_ab MDF_ba among the modes solved for: 0 .. 1
    width: float = 0.0  # distance at which the gap is sqrt(2) times the least


class Candidate(NamedTuple):
    """Modes k and k + 1 of a family whose gap is least at `at` among the samples."""

    family: int
    k: int
    low: float  # the samples before and after
    at: float
    high: float
    before: float  # where the gap is greatest on either side
    after: float
    smooth: bool  # whether the loci are interpolated there


def locate_events(curves: Curves, sweep: Sweep) -> list[Event]:
    """All crossings and veerings of the lowest `sweep.modes` loci, by ascending value."""
    crossings = [] if sweep.coupled else _crossings(curves, sweep)
    found = _candidates(curves, sweep.modes)
    guesses = _interpolated_gaps(curves, [one for one in found if one.smooth])
    solved = np.array(sorted(sweep.outcomes))
    searches = [_locate(one, guesses.get(one), curves, sweep, solved) for one in found]
    veerings = _run_together(searches, sweep)
    events = {(event.branches, event.at): event for event in [*crossings, *filter(None, veerings)]}
    return sorted(events.values(), key=lambda event: event.at)


def _crossings(curves: Curves, sweep: Sweep) -> list[Event]:
    """The crossings of the two families."""
    count = curves.table.squares.shape[2]

    def difference(p: np.ndarray, squares: np.ndarray) -> np.ndarray:
        return (squares[:, 0, :, None] - squares[:, 1, None, :]).reshape(len(p), -1)

    roots = curves.roots(difference)
    rough = curves.squares_at(np.array([root.at for root in roots]))
    kept = _lowest(rough, roots, sweep.modes, OUTSIDE)
    roots = [root for root, own in zip(roots, kept, strict=True) if own]
    polish(roots, sweep, difference)
    solved = sweep.spectra(np.array([root.at - root.shift for root in roots])).squares
    kept, events = _lowest(solved, roots, sweep.modes, 0.0), []
    for root, squares, own in zip(roots, solved, kept, strict=True):
        b, s = divmod(root.channel, count)
        square = (squares[0, b] + squares[1, s]) / 2
        if own and square >= 0:
            pair = ((0, b), (1, s)) if root.slope > 0 else ((1, s), (0, b))
            events.append(Event("crossing", pair, root.at, math.sqrt(square)))
    return events


def _lowest(squares: np.ndarray, roots: Sequence[Root], modes: int, margin: float) -> np.ndarray:
    """Whether crossings (n,) are of the lowest modes, or above them by less than the margin."""
    b, s = divmod(np.array([root.channel for root in roots], int), squares.shape[2])
    each = np.arange(len(roots))
    lower = np.minimum(squares[each, 0, b], squares[each, 1, s])[:, None, None]
    return (squares < lower - margin * abs(lower)).sum(axis=(1, 2)) < modes


def _candidates(curves: Curves, modes: int) -> list[Candidate]:
    """Minima, among the samples, of small gaps between neighbours of a family."""
    p, squares, rank, smooth = curves.table
    f = np.sqrt(np.where(squares >= 0, squares, np.nan))
    gap = f[..., 1:] - f[..., :-1]  # (n, families, k - 1)
    least = (gap[1:-1] <= gap[:-2]) & (gap[1:-1] < gap[2:])
    least &= (gap[1:-1] < WIDER * CLOSE * f[1:-1, :, 1:]) & (rank[1:-1, :, :-1] < modes)
    found = []
    for i, family, k in np.argwhere(least).tolist():
        own = gap[:, family, k]
        low, high = i, i + 2
        while low > 0 and own[low - 1] >= own[low]:  # as far as the gap grows
            low -= 1
        while high < len(p) - 1 and own[high + 1] >= own[high]:
            high += 1
        whole = bool(smooth[i] and smooth[i + 1])
        left, at, right, before, after = p[[i, i + 1, i + 2, low, high]].tolist()
        found.append(Candidate(family, k, left, at, right, before, after, whole))
    return found


def _run_together(searches: Sequence[Search[Result]], sweep: Sweep) -> list[Result]:
    """The results of several searches, whose solves are batched."""
    results: dict[int, Result] = {}
    active: dict[int, Points | None] = dict.fromkeys(range(len(searches)))
    while active:
        requests: dict[int, np.ndarray] = {}
        for k, reply in active.items():
            try:
                requests[k] = searches[k].send(reply)
            except StopIteration as end:
                results[k] = end.value
        if not requests:
            break
        found = sweep.points(np.unique(np.concatenate(list(requests.values()))))
        active = {k: found.among(values) for k, values in requests.items()}
    return [results[k] for k in range(len(searches))]


def _locate(
    candidate: Candidate, guess: Approach | None, curves: Curves, sweep: Sweep, solved: np.ndarray
) -> Search[Event | None]:
    """The crossing or veering of two neighbours of a family; None if it is neither. solved: values
    (n,) solved before."""
    family, k, low, at, high, *_ = candidate
    start, stop = curves.table.at[[0, -1]].tolist()
    found = None
    if guess:
        inside = guess.modes[1] < sweep.modes
        if guess.gap > 1.01 * CLOSE * guess.frequency or (not inside and guess.gap > 0):
            return None
        ends, near = _around(guess, candidate, solved), _near(guess, start, stop)
        points = yield np.concatenate((near, ends))
        beside = points.among(near)
        low, high = max(low, guess.at - guess.width), min(high, guess.at + guess.width)
        found = _corrected(guess, beside, candidate, sweep)
        if found is None:
            found = yield from _least_gap(points, candidate, sweep, low, high, guess)
    if found is None:
        guess, low, high = None, candidate.low, candidate.high
        points = yield np.array([low, at, high])
        unknown = Approach(at, 0.0, math.inf, 0.0, (0, 1))
        found = yield from _least_gap(points, candidate, sweep, low, high, unknown)
    if found is None:
        return None
    approach, shapes = found
    if approach.modes[approach.gap > 0] >= sweep.modes:
        return None  # above the requested modes; a crossing with the highest counts
    pair = (family, k), (family, k + 1)
    if approach.gap == 0:
        return Event("crossing", pair, approach.at, approach.frequency)
    if approach.gap > CLOSE * approach.frequency:
        return None
    off = max(abs(approach.at - guess.at), abs(approach.width - guess.width)) if guess else math.inf
    if off > NEAR * approach.width:  # else the points beside the guess serve as well
        ends, near = _around(approach, candidate, solved), _near(approach, start, stop)
        points = yield np.concatenate((ends, near))
        beside = points.among(near)
    if not _rotates(points.among(ends), sweep.ranks(ends, family, k)):
        return None
    coupling, index = _veering_index(beside, near, shapes)
    if index < MIN_INDEX:
        return None
    return Event("veering", pair, *approach[:3], coupling, index, approach.width)


def _rotates(ends: Points, ranks: np.ndarray) -> bool:
    """Whether the shapes of two modes, of these ranks (2, 2), rotate into each other between two
    points; true where that is not known."""
    if len(ends.at) < 2 or ranks.max() >= ends.duals.shape[1]:  # above the modes solved for
        return True
    O = abs(ends.shapes[0, ranks[0]].conj() @ ends.duals[1, ranks[1]].T)
    return math.atan2(O[0, 1] + O[1, 0], O[0, 0] + O[1, 1]) >= ROTATED


def _around(approach: Approach, candidate: Candidate, solved: np.ndarray) -> np.ndarray:
    """Points (2,) REACH widths before and after a least gap, or nearby ones that are solved."""
    found = []
    for side, end in ((-1, candidate.before), (1, candidate.after)):
        limit = side * (end - approach.at)
        reach = min(REACH * approach.width, limit)
        away = side * (solved - approach.at)
        near = solved[(away >= ABOUT[0] * reach) & (away <= min(ABOUT[1] * reach, limit))]
        at = approach.at + side * reach
        found.append(near[abs(near - at).argmin()] if len(near) else at)
    return np.array(found)


def _near(approach: Approach, start: float, stop: float) -> np.ndarray:
    """Points (2,) of the central differences at a least gap."""
    h = min(DIFFERENCE_STEP * approach.width, approach.at - start, stop - approach.at)
    return approach.at + np.array([-h, h])


def _interpolated_gaps(
    curves: Curves, candidates: Sequence[Candidate]
) -> dict[Candidate, Approach]:
    """The least gap of each candidate by interpolated loci. The square of a gap is analytic,
    least^2 (1 + ((p - at) / width)^2) near its minimum, however narrow that is."""
    if not candidates:
        return {}
    points, D = lobatto(GAP_ORDER), derivative(GAP_ORDER)
    family, k, low, _, high, *_ = map(np.array, zip(*candidates, strict=True))
    values = on_piece(low[:, None], high[:, None], points.nodes)  # (n, nodes)
    squares = curves.squares_at(values.ravel()).reshape(*values.shape, *curves.squares.shape[1:])
    each = np.arange(len(candidates))
    pair = squares[each, :, family, k], squares[each, :, family, k + 1]
    lower, upper = np.sqrt(np.maximum(pair, FLOOR))
    mean, square = (lower + upper) / 2, (upper - lower) ** 2
    slope = square @ D.T
    bend = slope @ D.T
    sampled = (square @ points.dense.T)[:, 1:-1].argmin(axis=1)
    bracket = tuple(points.dense_nodes[sampled + side] for side in range(3))
    x, curvature = extrema(points, slope, bend, bracket, np.ones(len(candidates), bool))
    rows, half = points.rows(x), (high - low) / 2
    gap = np.sqrt(np.maximum(np.vecdot(rows, square), 0.0))
    frequency = np.vecdot(rows, mean)
    width = gap * half / np.sqrt(np.maximum(curvature / 2, TINY))
    width = np.maximum(width, FINEST * (high - low))
    gap = np.where(gap > TOUCHING * frequency, gap, 0.0)
    own = squares[:, GAP_ORDER // 2]
    below = (own < own[each, family, k + 1][:, None, None]).sum(axis=(1, 2))
    numbers = (column.tolist() for column in (low + half * (x + 1), frequency, gap, width))
    modes = zip(k.tolist(), below.tolist(), strict=True)
    return dict(zip(candidates, map(Approach, *numbers, modes), strict=True))


def _corrected(
    guess: Approach, beside: Points, candidate: Candidate, sweep: Sweep
) -> tuple[Approach, np.ndarray] | None:
    """The least gap, if it is within SETTLED and SAME of the interpolated `guess`, by the gaps at
    two points `beside` it, and the shapes (2, d) of the two modes. Near its minimum the square of a
    gap is gap^2 (1 + ((p - at) / width)^2)."""
    if len(beside.at) < 2 or not guess.gap:
        return None
    family, k = candidate[:2]
    own = sweep.ranks(beside.at, family, k)
    lower, upper = np.sqrt(np.take_along_axis(beside.omega_squared, own, axis=1)).T
    squares, means = (upper - lower) ** 2, (upper + lower) / 2
    step, bend = float(np.diff(beside.at)[0]), (guess.gap / guess.width) ** 2
    shift = float(squares[0] - squares[1]) / (2 * step * bend)
    square = float(squares.mean()) - bend * ((step / 2) ** 2 + shift**2)
    gap = math.sqrt(max(square, 0.0))
    if abs(shift) > SETTLED * guess.width or abs(gap - guess.gap) > SAME * guess.gap:
        return None
    frequency = float(means.mean() + shift * np.diff(means)[0] / step)
    approach = Approach(guess.at + shift, frequency, gap, guess.width, tuple(own[0].tolist()))
    return approach, beside.shapes[0, own[0]]


def _veering_index(beside: Points, near: np.ndarray, shapes: np.ndarray) -> tuple[float, float]:
    """s_ab and the veering index of a pair (du Bois, Adhikari & Lieven 2011), from the rates at
    which the modes rotate into each other at the least gap, s_ab / (lambda_b - lambda_a)."""
    if len(beside.at) < 2:
        return math.nan, 0.0
    h = float(near[1] - near[0]) / 2
    O = beside.shapes[0].conj() @ beside.duals[1].T
    own = np.diagonal(O)
    O = O * own.conj() / np.maximum(abs(own), np.finfo(float).tiny)
    rates = abs(O - O.conj().T) / (4 * h)
    squares = beside.omega_squared.mean(axis=0)
    slope = np.diff(beside.omega_squared, axis=0)[0] / (2 * h)
    i, j = np.sort((abs(shapes.conj() @ beside.duals[0].T) ** 2).sum(axis=0).argsort()[-2:])
    s = rates[i, j] * (squares[j] - squares[i])
    if not s:
        return 0.0, 0.0
    mdf = rates[i, j] ** 2 / (rates[[i, j]] ** 2).sum(axis=1)
    csq = s**2 / (s**2 + ((slope[i] - slope[j]) / 2) ** 2)
    return float(s), float(mdf.prod() * csq)


def _least_gap(
    points: Points, candidate: Candidate, sweep: Sweep, low: float, high: float, guess: Approach
) -> Search[tuple[Approach, np.ndarray] | None]:
    """The least gap of a candidate within low .. high, and the shapes (2, d) of the two modes at
    the nearest of the solved `points`, the basis of their 2 x 2 problem. guess: estimate of the
    gap. None where the gap is least at an end, or has a kink, as where a beam buckles."""
    if not len(points.at):
        return None
    family, k = candidate[:2]
    nearest = abs(points.at - guess.at).argmin()
    reference = points.shapes[nearest, sweep.ranks(points.at[[nearest]], family, k)[0]]
    entries, interval = reduce(reference, points), high - low
    approach, shift = guess, math.inf
    for _ in range(MAX_SOLVES):
        if len(entries) < 2:
            return None
        previous, approach = approach, closest(entries, approach.at, low, high)
        last, shift = shift, abs(approach.at - previous.at)
        fine = max(SETTLED * min(approach.width, interval), FINEST * interval)
        settled = abs(approach.gap - previous.gap) <= SAME * approach.gap
        if settled and (shift <= fine or last / 2 < shift < ROUGH * interval):
            break
        value = approach.at
        if value in entries[:, 0]:  # at an end, or already solved: halve the widest interval
            p = entries[:, 0].real
            p = np.unique(np.concatenate(([low, high], p[(p > low) & (p < high)])))
            widest = int(np.diff(p).argmax())
            value = float(p[widest] + p[widest + 1]) / 2
        more = yield np.array([value])
        if not len(more.at):
            break
        entries = np.vstack((entries, reduce(reference, more)))
    else:
        return None
    if approach.gap and approach.at in (low, high):
        return None
    return approach, reference
