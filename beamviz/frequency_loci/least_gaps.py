"""The least gaps of neighbours of a family of loci: location, frequency, gap and width.

Each is interpolated and, by solves beside it, corrected. Where the correction is not small, or the
loci are not interpolated, it is sought by solves.
"""

import math
from collections.abc import Generator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from beamviz.frequency_loci.curves import Curves
from beamviz.frequency_loci.interpolation.chebyshev import lobatto, on_piece
from beamviz.frequency_loci.interpolation.roots import derivative, extrema
from beamviz.frequency_loci.mode_vectors import Points
from beamviz.frequency_loci.sweep import Sweep
from beamviz.frequency_loci.two_modes import FLOOR, TINY, TOUCHING, Approach, closest, reduce

CLOSE = 0.1  # of the frequency: greatest gap of interest
WIDER = 2.0  # of CLOSE: sampled gap below which a minimum is examined
GAP_ORDER = 6  # of the interpolant of a squared gap between three samples

DIFFERENCE_STEP = 0.01  # of the width: step of central differences
REACH = 10.0  # widths of a veering beyond which the shapes hardly rotate
ENOUGH = 0.3  # of REACH: distance from which on solved points serve as well
NEAR = 0.02  # of the width: error of a guess at which its neighbouring points serve

MAX_SOLVES = 8  # for one gap
SETTLED = 1e-4  # of the width: shift below which a search ends
FINEST = 1e-6  # of the interval between samples: the same
ROUGH = 1e-3  # of the interval: shift below which one that no longer shrinks is rounding error
SAME = 1e-3  # relative change of the gap below which a search ends

Search = Generator[np.ndarray, Points, Approach | None]  # yields values at which it needs Points


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


class LeastGap(NamedTuple):
    """The least gap of two neighbours of a family, and points about it."""

    modes: tuple[tuple[int, int], tuple[int, int]]  # (family, index) of both
    approach: Approach
    near: np.ndarray  # (2,) points of central differences
    ends: np.ndarray  # (2,) points before and after, between which the shapes of a veering rotate


def least_gaps(curves: Curves, sweep: Sweep) -> list[LeastGap]:
    """The least gaps of at most CLOSE of the frequency among the lowest `sweep.modes` loci; also
    where the highest of these touches the next (gap 0)."""
    start, stop = curves.table.at[[0, -1]].tolist()
    solved = np.array(sorted(sweep.outcomes))

    def located(candidate: Candidate, approach: Approach) -> LeastGap:
        family, k = candidate[:2]
        near, ends = _near(approach, start, stop), _around(approach, candidate, solved)
        return LeastGap(((family, k), (family, k + 1)), approach, near, ends)

    found = _candidates(curves, sweep.modes)
    interpolated = _interpolated(curves, [one for one in found if one.smooth])
    guesses = {
        one: located(one, approach)
        for one, approach in interpolated.items()
        if _is_wanted(approach, 1.01 * CLOSE, sweep.modes)
    }
    approaches: dict[Candidate, Approach | None] = {**_corrected(guesses, sweep)}
    left = [one for one in found if one not in approaches and (one in guesses or not one.smooth)]
    searches = [_search(one, guesses.get(one), sweep) for one in left]
    approaches.update(zip(left, _run_together(searches, sweep), strict=True))
    gaps = []
    for one, approach in approaches.items():
        if approach and _is_wanted(approach, CLOSE, sweep.modes):
            guess = guesses.get(one)
            if guess and _is_near(guess.approach, approach):  # whose neighbouring points are solved
                gaps.append(guess._replace(approach=approach))
            else:
                gaps.append(located(one, approach))
    return gaps


def _is_wanted(approach: Approach, close: float, modes: int) -> bool:
    """Whether a gap is small and of the lowest modes."""
    small = approach.gap <= close * approach.frequency
    return small and approach.modes[approach.gap > 0] < modes


def _is_near(guess: Approach, approach: Approach) -> bool:
    """Whether the points beside a guess serve as well."""
    off = max(abs(approach.at - guess.at), abs(approach.width - guess.width))
    return off <= NEAR * approach.width


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


def _around(approach: Approach, candidate: Candidate, solved: np.ndarray) -> np.ndarray:
    """Points (2,) before and after a least gap: REACH widths away, but no farther than the greatest
    gap; of the solved points from ENOUGH of that distance on, the nearest, if there is one."""
    found = []
    for side, end in ((-1, candidate.before), (1, candidate.after)):
        limit = side * (end - approach.at)
        reach = min(REACH * approach.width, limit)
        away = side * (solved - approach.at)
        near = solved[(away >= ENOUGH * reach) & (away <= limit)]
        at = approach.at + side * reach
        found.append(near[abs(near - at).argmin()] if len(near) else at)
    return np.array(found)


def _near(approach: Approach, start: float, stop: float) -> np.ndarray:
    """Points (2,) of the central differences at a least gap."""
    h = min(DIFFERENCE_STEP * approach.width, approach.at - start, stop - approach.at)
    return approach.at + np.array([-h, h])


def _interpolated(curves: Curves, candidates: Sequence[Candidate]) -> dict[Candidate, Approach]:
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


@np.errstate(divide="ignore", invalid="ignore")
def _corrected(guesses: Mapping[Candidate, LeastGap], sweep: Sweep) -> dict[Candidate, Approach]:
    """The interpolated gaps, corrected by the gaps solved at the points `near` them, where the
    correction is within SETTLED and SAME."""
    if not guesses or sweep.exhausted:
        return {}
    every = guesses.values()
    near = np.array([one.near for one in every])
    sweep.solve(np.concatenate((near, *(one.ends for one in every)), axis=None))
    spectra = sweep.spectra(near.ravel())
    family, k, *_ = map(np.array, zip(*guesses, strict=True))
    of_lower = np.arange(near.size), family.repeat(2), k.repeat(2)
    of_upper = (*of_lower[:2], of_lower[2] + 1)
    lower, upper = (np.sqrt(spectra.squares[own]).reshape(-1, 2) for own in (of_lower, of_upper))
    at, _, gap, width = np.array([one.approach[:4] for one in every]).T
    shift, frequency, least = _minimum(near[:, 1] - near[:, 0], (gap / width) ** 2, lower, upper)
    small = (abs(shift) <= SETTLED * width) & (abs(least - gap) <= SAME * gap) & (gap > 0)
    ranks = spectra.rank
    modes = zip(ranks[of_lower][::2].tolist(), ranks[of_upper][::2].tolist(), strict=True)
    numbers = (column.tolist() for column in (at + shift, frequency, least, width))
    corrected = zip(guesses, map(Approach, *numbers, modes), small.tolist(), strict=True)
    return {one: approach for one, approach, own in corrected if own}


def _minimum(
    step: np.ndarray, bend: np.ndarray, lower: np.ndarray, upper: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The shift (n,) of least gaps from the middle of two points a step apart, the mean frequency
    and the gap there, by the frequencies (n, 2) of the two modes at the points. The square of a
    gap is least^2 + bend (p - at)^2."""
    square, mean = (upper - lower) ** 2, (upper + lower) / 2
    shift = (square[:, 0] - square[:, 1]) / (2 * step * bend)
    least = square.mean(axis=1) - bend * ((step / 2) ** 2 + shift**2)
    frequency = mean.mean(axis=1) + shift * (mean[:, 1] - mean[:, 0]) / step
    return shift, frequency, np.sqrt(np.maximum(least, 0.0))


def _search(candidate: Candidate, guess: LeastGap | None, sweep: Sweep) -> Search:
    """The least gap of a candidate by solves: about a guess first, then between the samples."""
    _, _, low, at, high, *_ = candidate
    if guess:
        about = guess.approach
        points = yield np.concatenate((guess.near, guess.ends))
        nearer = max(low, about.at - about.width), min(high, about.at + about.width)
        found = yield from _least_gap(points, candidate, sweep, *nearer, about)
        if found:
            return found
    points = yield np.array([low, at, high])
    unknown = Approach(at, 0.0, math.inf, 0.0, (0, 1))
    return (yield from _least_gap(points, candidate, sweep, low, high, unknown))


def _run_together(searches: Sequence[Search], sweep: Sweep) -> list[Approach | None]:
    """The results of several searches, whose solves are batched."""
    results: dict[int, Approach | None] = {}
    active: dict[int, Any] = dict.fromkeys(range(len(searches)))
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


def _least_gap(
    points: Points, candidate: Candidate, sweep: Sweep, low: float, high: float, guess: Approach
) -> Search:
    """The least gap of a candidate within low .. high. guess: estimate of it. The basis of the
    2 x 2 problem are the shapes of the two modes at the nearest of the solved `points`. None where
    the gap is least at an end, or has a kink, as where a beam buckles."""
    if not len(points.at):
        return None
    nearest = abs(points.at - guess.at).argmin()
    reference = points.shapes[nearest, sweep.ranks(points.at[[nearest]], *candidate[:2])[0]]
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
    return approach
