"""Where loci may meet, read off the points of a sweep.

Loci of modes that do not couple cross: their difference changes its sign. Loci of modes that do
couple keep their order: their difference has a least value, around which the shapes turn into
each other.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from beamviz.frequency_loci.tracking import CLEAR, SHORTEST, Track, followed

TURN = math.radians(30)  # least angle by which two shapes turn into each other around a veering,
# between the places where the gap is widest before and after; 90 degrees for a complete one
EXCHANGE = math.radians(45)  # in one step: the two shapes are more each other than themselves
NOTHING = 1e-9  # a gap that is rounding: the solver may have mixed the two shapes
SURE = 4.0  # times the curvature seen: the most a difference is trusted to bend between points


@dataclass(frozen=True)
class Columns:
    """Branches as columns: those among the lowest modes somewhere, or next to them."""

    at: np.ndarray  # (n,)
    branches: np.ndarray  # (b,) their numbers in the track
    places: np.ndarray  # (n, b) place of each among the modes, m where it is not there
    frequencies: np.ndarray  # (n, b), nan where not there or unstable
    turns: np.ndarray  # (n - 1, b, b) angle by which two shapes turn into each other [rad]
    held: np.ndarray  # (n - 1, b, b) least share of two shapes found again in the two
    window: int  # how many modes are asked for


class Candidate(NamedTuple):
    """Two columns of the loci that may meet between two points."""

    a: int
    b: int
    low: int
    high: int
    crosses: bool  # the difference changes its sign


class Pairs(NamedTuple):
    """All pairs of columns of the loci."""

    a: np.ndarray  # (pairs,)
    b: np.ndarray  # (pairs,)
    difference: np.ndarray  # (n, pairs) of the frequencies
    turns: np.ndarray  # (n - 1, pairs)
    asked: np.ndarray  # (n, pairs) whether one of the two is in the window


def columns_of(track: Track, window: int) -> Columns:
    """The branches of a track that are among the lowest `window` modes somewhere, or next to."""
    points = track.points
    n, m = points.squares.shape
    branches = np.unique(track.branch[:, : followed(window, m)])
    there = track.branch[:, None, :] == branches[:, None]
    places = np.where(there.any(axis=2), there.argmax(axis=2), m)
    squares = np.column_stack((points.squares, np.full(n, np.nan)))
    squares = np.take_along_axis(squares, places, axis=1)
    frequencies = np.sqrt(np.where(squares >= 0, squares, np.nan))
    padded = np.pad(track.overlaps, ((0, 0), (0, 1), (0, 1)))
    step = np.arange(n - 1)[:, None, None]
    O = padded[step, places[:-1, :, None], places[1:, None, :]]
    return Columns(points.at, branches, places, frequencies, _turns(O), _held(O), window)


def _held(O: np.ndarray) -> np.ndarray:
    """The least share (n - 1, b, b) of two shapes that is found again in the two."""
    mac = abs(O) ** 2
    own = np.diagonal(mac, axis1=1, axis2=2)[:, :, None]
    forward, back = own + mac, own + mac.swapaxes(1, 2)
    both = np.minimum(forward, back)
    return np.minimum(both, both.swapaxes(1, 2))


def _turns(O: np.ndarray) -> np.ndarray:
    """The angles (n - 1, b, b) by which each two branches turn into each other in each step."""
    own = np.diagonal(O, axis1=1, axis2=2)
    kept = abs(own)
    # Each solve chooses the signs of its shapes: turn them so that a branch keeps its own.
    phase = np.where(kept == 0, 1, own.conj() / np.where(kept == 0, 1, kept)).cumprod(axis=0)
    before = np.concatenate((np.ones_like(phase[:1]), phase[:-1]))
    O = before.conj()[:, :, None] * O * phase[:, None, :]
    exchanged = abs(O) + abs(O).swapaxes(1, 2)
    side = np.sign((O - O.conj().swapaxes(1, 2)).real)
    return side * np.arctan2(exchanged, kept[:, :, None] + kept[:, None, :])


def _pairs(loci: Columns) -> Pairs:
    """All pairs of branches."""
    a, b = np.triu_indices(len(loci.branches), 1)
    difference = loci.frequencies[:, b] - loci.frequencies[:, a]
    asked = np.minimum(loci.places[:, a], loci.places[:, b]) < loci.window
    return Pairs(a, b, difference, loci.turns[:, a, b], asked)


def hidden(loci: Columns) -> np.ndarray:
    """Middles of the steps in which two loci may touch though their ends do not show it.

    Between two points a smooth difference strays from its chord by curvature / 8 times the
    square of the step; the curvature is taken from the points around.
    """
    pairs, step = _pairs(loci), np.diff(loci.at)[:, None]
    if len(step) < 2:
        return np.empty(0)
    # Where shapes are exchanged the difference goes on smoothly with the other sign.
    side = np.where(abs(pairs.turns) > EXCHANGE, -1, 1).cumprod(axis=0)
    D = pairs.difference * np.concatenate((np.ones_like(side[:1]), side))
    with np.errstate(over="ignore", invalid="ignore"):  # steps as short as numbers get
        slope = np.diff(D, axis=0) / step
        half_curvature = abs(np.diff(slope, axis=0)) / (step[1:] + step[:-1])
        half_curvature = np.pad(half_curvature, ((1, 1), (0, 0)), mode="edge")
        strays = SURE * np.fmax(half_curvature[:-1], half_curvature[1:]) * step**2 / 4
    ends = abs(D[:-1]), abs(D[1:])
    bend = 4 * strays - abs(ends[1] - ends[0])  # what is left to turn the difference back
    same = (D[:-1] * D[1:] >= 0) & pairs.asked[:-1]
    may = same & (bend > 0) & (16 * strays * np.minimum(*ends) < bend**2)
    steps = np.flatnonzero(may.any(axis=1) & (step[:, 0] > SHORTEST * np.ptp(loci.at)))
    return (loci.at[steps] + loci.at[steps + 1]) / 2


def unclear(loci: Columns) -> np.ndarray:
    """Middles of the steps of candidates in which one of the two turns into a third mode."""
    steps = {
        step
        for a, b, low, high, _ in candidates(loci)
        for step in range(low, high)
        if loci.held[step, a, b] < CLEAR
    }
    at = loci.at
    wide = [i for i in sorted(steps) if at[i + 1] - at[i] > SHORTEST * np.ptp(at)]
    return (at[wide] + at[[i + 1 for i in wide]]) / 2 if wide else np.empty(0)


def candidates(loci: Columns) -> list[Candidate]:
    """Every two points between which two loci may meet."""
    if len(loci.at) < 2:
        return []
    pairs = _pairs(loci)
    found = [(k, i, i + 1, True) for i, k in _sign_changes(pairs.difference)]
    found += [
        (k, low, high, False)
        for k, low, high in _minima(pairs)
        if _neighbours(loci, pairs.a[k], pairs.b[k], low)
    ]
    return [
        Candidate(int(pairs.a[k]), int(pairs.b[k]), low, high, crosses)
        for k, low, high, crosses in found
        if pairs.asked[low : high + 1, k].any()
    ]


def _sign_changes(D: np.ndarray) -> list[tuple[int, int]]:
    """Points (and pairs) after which a difference changes its sign."""
    side = np.sign(D)
    for i in np.flatnonzero((side[1:] == 0).any(axis=1)) + 1:
        side[i] = np.where(side[i] == 0, side[i - 1], side[i])
    return [(i, k) for i, k in np.argwhere(side[:-1] * side[1:] < 0).tolist()]


def _minima(pairs: Pairs) -> list[tuple[int, int, int]]:
    """Pairs with a least gap across which the shapes turn, and the points around it."""
    gap = abs(pairs.difference)
    there = np.isfinite(gap[:-1]) & np.isfinite(gap[1:])  # a shape may turn into one that enters
    exchanges = np.argwhere((abs(pairs.turns) > EXCHANGE) & there)
    found = [(k, i, i + 1) for i, k in exchanges.tolist()]
    middle = (gap[1:-1] <= gap[:-2]) & (gap[1:-1] < gap[2:])
    middle &= pairs.difference[:-2] * pairs.difference[2:] > 0
    middle &= np.maximum(abs(pairs.turns[:-1]), abs(pairs.turns[1:])) <= EXCHANGE
    found += [(k, i, i + 2) for i, k in np.argwhere(middle).tolist()]
    # In a step at the end of the sweep a least gap hides; the turning shapes show it.
    last = len(gap) - 1
    for low, end, inner in ((0, 0, 1), (last - 1, last, last - 1)):
        seen = gap[inner] * np.cos(2 * pairs.turns[low])
        hides = (gap[end] < gap[inner]) & (seen < gap[end]) & (abs(pairs.turns[low]) <= EXCHANGE)
        found += [(k, low, low + 1) for k in np.flatnonzero(hides).tolist()]
    return [(k, low, high) for k, low, high in found if _turns_around(pairs, gap, k, low, high)]


def _turns_around(pairs: Pairs, gap: np.ndarray, k: int, low: int, high: int) -> bool:
    """Whether two shapes turn into each other around their least gap, or nothing is left of it."""
    if abs(pairs.turns[low, k]) > EXCHANGE or gap[low : high + 1, k].min() <= NOTHING:
        return True
    start, stop = _slopes(gap[:, k], low, high)
    return abs(pairs.turns[start:stop, k].sum()) >= TURN


def _slopes(gap: np.ndarray, low: int, high: int) -> tuple[int, int]:
    """The points up to which a gap grows on both sides of low .. high."""
    start, stop = low, high
    while start > 0 and gap[start - 1] >= gap[start]:
        start -= 1
    while stop < len(gap) - 1 and gap[stop + 1] >= gap[stop]:
        stop += 1
    return start, stop


def _neighbours(loci: Columns, a: int, b: int, point: int) -> bool:
    """Whether no third branch that couples with one of two lies between them."""
    f = loci.frequencies[point]
    between = (f > min(f[a], f[b])) & (f < max(f[a], f[b]))
    couples = loci.turns[:, [a, b]].any(axis=(0, 1))
    return not (between & couples).any()
