"""Avoided crossings: least gaps of neighbouring loci of one family, however narrow.

Candidates are the minima of the gaps on the grid, and pairs whose shapes are exchanged from one
value of the grid to the next: such a gap is narrower than the grid. The 2 x 2 reduction onto the
two modes (see `two_modes`) locates the least gap from a few solves; those of all candidates are
made together.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from beamviz.frequency_loci.mode_vectors import ModeVectors
from beamviz.frequency_loci.path import ParameterPath, PathModes
from beamviz.frequency_loci.tracking import Track
from beamviz.frequency_loci.two_modes import TINY, LeastGap, closest, reduce

# Of the frequency: the greatest gap that is an event. Bending mode k at rest and the next one are
# about 2 / k apart: a wider gap would be an ordinary distance.
CLOSE = 0.1
WIDER = 2.0  # of CLOSE: gap on the grid below which a minimum is examined
FLAT = 1e-10  # of the frequency: depth of a minimum on the grid that may be rounding error
ROUNDS = 10  # of solves for one gap
SETTLED = 1e-4  # of the width: shift below which a search ends
FINEST = 1e-6  # of the bracket: the same
ROUGH = 1e-3  # of the bracket: shift below which one that no longer shrinks is rounding error
SAME = 1e-3  # relative change of the gap below which a search ends
DIFFERENCE_STEP = 0.01  # of the width: step of central differences
REACH = 2.0  # widths from a veering, where its shapes have rotated by 63 of 90 degrees


class Candidate(NamedTuple):
    """Modes k and k + 1 of a family whose gap is least within low .. high."""

    family: int
    k: int
    low: float
    high: float
    before: float  # where the gap is greatest below low
    after: float  # where it is greatest above high


class AvoidedCrossing(NamedTuple):
    """The least gap of modes k and k + 1 of a family; gap 0 where they cross all the same."""

    family: int
    k: int
    least: LeastGap
    coupling: float  # s_ab = phi_a' (K' - lambda M') phi_b, lambda the mean of the pair
    veering_index: float  # MDF_ab CSQ_ab MDF_ba among the modes solved for: 0 .. 1; nan: not known
    rotation: float  # [rad] of the shapes into each other from before to after it; 90 degrees: all


def avoided_crossings(track: Track) -> tuple[list[AvoidedCrossing], list[tuple[float, float]]]:
    """The least gaps of at most CLOSE of the frequency of which a mode is one of the requested, and
    the intervals with one that could not be located. Where a beam buckles, loci have kinks: a gap
    that is least at one does not settle, and is none of these."""
    searches = [Search(track, candidate) for candidate in candidates(track)]
    locate(searches, track.path)
    wanted = [search for search in searches if search.is_wanted(track.path.followed_modes)]
    located = [search for search in wanted if search.is_settled]
    brackets = [
        (search.candidate.low, search.candidate.high)
        for search in wanted
        if not search.is_settled and search.is_wanted(track.path.problem.modes)
    ]
    unlocated = [ends for ends in brackets if not track.path.buckles_between(*ends)]
    return _measured(track, located), unlocated


def candidates(track: Track) -> list[Candidate]:
    """Minima of small gaps on the grid, and exchanges of shapes."""
    at, modes = track.values, track.modes
    if len(at) < 3:
        return []
    f, requested = modes.frequencies, modes.rank < track.path.followed_modes
    gap = f[..., 1:] - f[..., :-1]  # (n, families, k - 1)
    least = (gap[1:-1] <= gap[:-2]) & (gap[1:-1] < gap[2:])
    least &= (gap[1:-1] < WIDER * CLOSE * f[1:-1, :, 1:]) & requested[1:-1, :, :-1]
    least &= np.maximum(gap[:-2], gap[2:]) - gap[1:-1] > FLAT * f[1:-1, :, 1:]
    exchanged = (
        track.continuity.exchanged & requested[:-1, :, :-1] & np.isfinite(gap[:-1] + gap[1:])
    )
    least &= ~(exchanged[:-1] & exchanged[1:])  # else there are two, one in either interval
    # First and last value of the grid, family and k of each candidate.
    places = {(i, i + 2, family, k) for i, family, k in np.argwhere(least).tolist()}
    for i, family, k in np.argwhere(exchanged).tolist():
        if not {(i - 1, i + 1, family, k), (i, i + 2, family, k)} & places:
            places.add((i, i + 1, family, k))
    minima = []
    for low, high, family, k in sorted(places):
        pair = gap[:, family, k]
        others = [ends for *ends, other_family, j in places if (other_family, j) == (family, k)]
        first = _end_of_growth(pair, low, -1, {last for _, last in others})
        last = _end_of_growth(pair, high, 1, {first for first, _ in others})
        minima.append(Candidate(family, k, *at[[low, high, first, last]].tolist()))
    return minima


def _end_of_growth(gap: NDArray, start: int, step: int, others: set[int]) -> int:
    """The index up to which the gaps (n,) of a pair grow from `start`, in steps of 1 or -1, and not
    beyond where another candidate of the pair begins."""
    i = start
    while 0 <= i + step < len(gap) and gap[i + step] >= gap[i] and i not in others:
        i += step
    return i


class Search:
    """The search for the least gap of a candidate: its 2 x 2 problem, from more and more solves.
    The basis are the shapes of the two modes in the middle of the bracket."""

    def __init__(self, track: Track, candidate: Candidate):
        self.candidate, vectors = candidate, track.vectors
        middle = (candidate.low + candidate.high) / 2
        i = int(abs(track.values - middle).argmin())
        rank = track.modes.rank[i, candidate.family, candidate.k : candidate.k + 2]
        near = slice(max(i - 2, 0), i + 3)
        self.reference = vectors.chosen(np.array([i]), rank)
        self.reduced = reduce(self.reference, vectors.chosen(near))
        self.least = LeastGap(float(track.values[i]), 0.0, math.inf, 0.0, (0, 1))
        self.shift = math.inf  # of the place of the least gap by the last solve
        self.is_settled = False
        self.estimate()

    @property
    def is_hopeless(self) -> bool:
        """Whether the two shapes are in the modes of too few solves."""
        return len(self.reduced.at) < 2

    def estimate(self) -> None:
        """Locate the least gap by the solves so far; it is settled once it no longer moves."""
        if self.is_hopeless:
            return
        low, high = self.candidate.low, self.candidate.high
        previous, last_shift = self.least, self.shift
        self.least = closest(self.reduced, previous.at, low, high)
        self.shift = abs(self.least.at - previous.at)
        fine = max(SETTLED * min(self.least.width, high - low), FINEST * (high - low))
        steady = abs(self.least.gap - previous.gap) <= SAME * self.least.gap
        rounding = last_shift / 2 < self.shift < ROUGH * (high - low)
        self.is_settled = bool(steady and (self.shift <= fine or rounding))

    @property
    def next_value(self) -> float:
        """Where to solve next: at the least gap, or where it was solved already in the middle of
        the widest interval without a solve."""
        low, high, solved = self.candidate.low, self.candidate.high, self.reduced.at
        if self.least.at not in solved:
            return self.least.at
        inside = np.unique(solved[(solved > low) & (solved < high)])
        ends = np.concatenate(([low], inside, [high]))
        widest = int(np.diff(ends).argmax())
        return float(ends[widest] + ends[widest + 1]) / 2

    def add(self, vectors: ModeVectors) -> None:
        """Take in further solves; where none succeeded there are no vectors."""
        if len(vectors.at):
            self.reduced = self.reduced.joined(reduce(self.reference, vectors))
            self.estimate()

    def is_wanted(self, modes: int) -> bool:
        """Whether the least gap, as far as it is known, is a small one of at least one of the
        lowest modes between the ends of the bracket. A gap that is least at an end has a kink
        there, as where a beam buckles."""
        least = self.least
        inside = not least.gap or least.at not in (self.candidate.low, self.candidate.high)
        is_small = least.gap <= CLOSE * least.frequency
        return inside and is_small and least.ranks[0] < modes


def locate(searches: list[Search], path: ParameterPath) -> None:
    """Run searches to their ends, their solves in batches."""
    for _ in range(ROUNDS):
        active = [search for search in searches if not (search.is_settled or search.is_hopeless)]
        if not active:
            break
        values = [search.next_value for search in active]
        vectors = path.vectors(np.unique(values))
        for search, value in zip(active, values, strict=True):
            search.add(vectors.among(np.array([value])))


def _measured(track: Track, searches: list[Search]) -> list[AvoidedCrossing]:
    """The located gaps with their coupling and veering index, from solves close to each, and the
    rotation of the shapes between values of the grid before and after it."""
    if not searches:
        return []
    path = track.path
    at = np.array([search.least.at for search in searches])
    width = np.array([search.least.width for search in searches])
    before = np.array([search.candidate.before for search in searches])
    after = np.array([search.candidate.after for search in searches])
    step = np.minimum(DIFFERENCE_STEP * width, np.minimum(at - before, after - at))
    near = at[:, None] + np.column_stack((-step, step))
    first = _nearest(track.values, at - REACH * width, before, at)
    last = _nearest(track.values, at + REACH * width, at, after)
    ends = np.column_stack((first, last))
    family = np.array([search.candidate.family for search in searches])
    k = np.array([search.candidate.k for search in searches])
    pair = np.stack((k, k + 1), axis=1)

    def ranks(modes: PathModes, at: NDArray) -> NDArray:
        """The indices (n, 2, 2) among all modes of both modes at two of the values (n, 2)."""
        value = np.searchsorted(modes.at, at)
        return modes.rank[value[..., None], family[:, None, None], pair[:, None]]

    values = np.unique(near)
    ranks_there = ranks(path.modes(values), near)[:, 0]
    coupling, index = veering_indices(path.vectors(values), near, ranks_there)
    rotation = rotations(track.vectors, ends, ranks(track.modes, ends))
    return [
        AvoidedCrossing(
            search.candidate.family,
            search.candidate.k,
            search.least,
            coupling=float(coupling[i]),
            veering_index=float(index[i]),
            rotation=float(rotation[i]),
        )
        for i, search in enumerate(searches)
    ]


def _nearest(grid: NDArray, wanted: NDArray, low: NDArray, high: NDArray) -> NDArray:
    """Of the grid (n,) the values (k,) nearest to those wanted (k,), between two others (k,) of
    which one is a value of the grid."""
    apart = abs(grid - wanted[:, None])
    apart[(grid < low[:, None]) | (grid > high[:, None])] = np.inf
    return grid[apart.argmin(axis=1)]


def _places(vectors: ModeVectors, values: NDArray) -> tuple[NDArray, NDArray]:
    """The indices (n, 2) of values among those of the vectors; whether both are there (n,)."""
    places = np.searchsorted(vectors.at, values).clip(max=max(len(vectors.at) - 1, 0))
    return places, (vectors.at[places] == values).all(axis=1)


def rotations(vectors: ModeVectors, ends: NDArray, ranks: NDArray) -> NDArray:
    """The angles (n,) by which the shapes of two modes, of these ranks (n, 2, 2) by frequency at
    two ends (n, 2), rotate into each other between them; 90 degrees where that is not known."""
    places, known = _places(vectors, ends)
    known &= (ranks < vectors.omega_squared.shape[1]).all(axis=(1, 2))  # else not solved for
    ranks = np.where(known[:, None, None], ranks, 0)
    before, after = (vectors.chosen(places[:, end], ranks[:, end]) for end in (0, 1))
    O = abs(before.products(after))
    angles = np.arctan2(O[:, 0, 1] + O[:, 1, 0], O[:, 0, 0] + O[:, 1, 1])
    return np.where(known, angles, math.pi / 2)


def veering_indices(vectors: ModeVectors, near: NDArray, pair: NDArray) -> tuple[NDArray, NDArray]:
    """s_ab and the veering index (n,) of pairs of modes (n, 2) (du Bois, Adhikari & Lieven 2011),
    from the rates at which the modes rotate into each other at the least gap, s_ab / (lambda_b -
    lambda_a), by central differences between the values `near` (n, 2), 2 h apart; index nan where
    the vectors or the modes are not known."""
    places, known = _places(vectors, near)
    known &= near[:, 1] > near[:, 0]
    h, each = np.where(known, near[:, 1] - near[:, 0], 1.0)[:, None] / 2, np.arange(len(near))
    before, after = vectors.chosen(places[:, 0]), vectors.chosen(places[:, 1])
    O = before.products(after)  # (n, modes, modes)
    diagonal = np.diagonal(O, axis1=1, axis2=2)[:, None]
    O = O * diagonal.conj() / np.maximum(abs(diagonal), TINY)  # phases: real on the diagonal
    rates = abs(O - O.conj().mT) / (4 * h[:, None])
    squares = vectors.omega_squared[places]  # (n, 2, modes)
    mean, slope = squares.mean(axis=1), np.diff(squares, axis=1)[:, 0] / (2 * h)
    known &= (pair < O.shape[1]).all(axis=1)  # else above the modes solved for
    pair = np.where(known[:, None], pair, 0)
    i, j = pair.T
    rate = rates[each, i, j]
    s = rate * (mean[each, j] - mean[each, i])
    csq = s**2 / np.maximum(s**2 + ((slope[each, i] - slope[each, j]) / 2) ** 2, TINY)
    totals = (rates[each[:, None], pair] ** 2).sum(axis=2)
    mdf = rate[:, None] ** 2 / np.maximum(totals, TINY)
    return s, np.where(known, mdf.prod(axis=1) * csq, np.nan)
