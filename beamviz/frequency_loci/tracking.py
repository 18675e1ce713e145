"""Mode tracking by mass-weighted shapes, and where two tracked branches come close.

A shape is a vector whose inner products are modal masses, so the modes of one point are
orthonormal, and the squared inner product across a step is the mass-weighted modal assurance
criterion, MAC (Allemang & Brown 1982). Gyroscopic modes are orthogonal in another product: the
shapes then come with duals, shape_i . dual_j = 1 for i = j and 0 otherwise.

Modes that couple keep their order: their loci cannot cross as one parameter varies (von Neumann
& Wigner 1929), however narrowly they veer. Modes that do not couple cross, shape by shape.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.optimize import linear_sum_assignment

CLEAR = 0.9  # MAC below which a step is ambiguous, and halved
LOST = 0.25  # MAC below which a mode has left the modes that were solved for
UNCOUPLED = 1e-18  # MAC of two modes coupled by nothing but rounding
SHORTEST = 1e-7  # of the whole range: an ambiguous step is not halved further
MAX_ADDED = 400  # points
# Least angle by which two shapes rotate into each other around a veering, between the points where
# the gap is widest before and after; 90 degrees for a complete one.
ROTATED = math.radians(30)
EXCHANGE = math.radians(45)  # in one step: the two shapes are more each other than themselves
NO_GAP = 1e-9  # a gap that is rounding: the solver may have mixed the two shapes
SAFETY = 4.0  # times the curvature seen: the most a difference is assumed to bend between points


class Points(NamedTuple):
    """Modes at n ascending values of one parameter, m at each."""

    at: np.ndarray  # (n,)
    omega_squared: np.ndarray  # (n, m) ascending in each row
    shapes: np.ndarray  # (n, m, d)
    duals: np.ndarray  # (n, m, d)

    def take(self, index: np.ndarray | slice) -> "Points":
        """The points of an index."""
        return Points(*(array[index] for array in self))

    def merge(self, other: "Points") -> "Points":
        """These points and others between them."""
        if not len(other.at):
            return self
        joined = Points(*map(np.concatenate, zip(self, other, strict=True)))
        return joined.take(np.unique(joined.at, return_index=True)[1])


SolveAt = Callable[[np.ndarray], Points]  # the solutions that exist at ascending values


@dataclass(frozen=True)
class Track:
    """Points with a branch number for each mode; a branch stays with its locus."""

    points: Points
    branch: np.ndarray  # (n, m)
    confidence: np.ndarray  # (n - 1,) least MAC of a step, a pair that veers taken together
    overlaps: np.ndarray  # (n - 1, m, m) inner products across each step


def follow(points: Points, window: int, solve_at: SolveAt) -> Track:
    """Follow the lowest `window` of m modes, halving every step whose assignment is ambiguous.

    The modes above the window are there for the branches that enter and leave it.
    """
    shortest = SHORTEST * np.ptp(points.at)
    count = followed_modes(window, points.omega_squared.shape[1])
    remaining = MAX_ADDED
    while True:
        # (n - 1, m, m) inner products of the modes before (rows) and after each step (columns)
        overlaps = points.shapes[:-1].conj() @ points.duals[1:].swapaxes(1, 2)
        mac = abs(overlaps) ** 2
        order = assignment(mac)
        recovered = _recovered(mac, order)
        followed = (np.arange(mac.shape[1]) < count) | (order < count)
        confidence = np.where(followed, recovered, 1.0).min(axis=1, initial=1.0)
        halved = np.flatnonzero((confidence < CLEAR) & (np.diff(points.at) > shortest))
        remaining -= len(halved)
        if not len(halved) or remaining < 0:
            break
        more = solve_at((points.at[halved] + points.at[halved + 1]) / 2)
        if not len(more.at):
            break
        points = points.merge(more)
    order = _keep_coupled_in_order(mac, order, recovered)
    return Track(points, _number_branches(order, recovered), confidence, overlaps)


def followed_modes(window: int, m: int) -> int:
    """How many of m modes are followed: those in the window and those that may enter it."""
    return max(window, m - 1)


def assignment(mac: np.ndarray) -> np.ndarray:
    """The mode after each step (n - 1, m) that continues each mode before it.

    Optimal: the sum of the MAC is the largest. In nearly all steps the order just stays.
    """
    m = mac.shape[1]
    order = mac.argmax(axis=2)
    for step in np.flatnonzero((order != np.arange(m)).any(axis=1)):
        order[step] = linear_sum_assignment(mac[step], maximize=True)[1]
    return order


def _recovered(mac: np.ndarray, order: np.ndarray) -> np.ndarray:
    """The share (n - 1, m) of each shape that is recovered after a step.

    Recovered by its own continuation, or by that and one other mode when both are recovered there:
    two modes that veer rotate into each other, and their order tells them apart.
    """
    kept = np.take_along_axis(mac, order[:, None, :], axis=2)
    pairs = _recovered_by_pairs(kept)
    diagonal = np.arange(mac.shape[1])
    pairs[:, diagonal, diagonal] = np.diagonal(kept, axis1=1, axis2=2)
    return pairs.max(axis=2, initial=0.0)


def _recovered_by_pairs(mac: np.ndarray) -> np.ndarray:
    """The least share (n - 1, b, b) of two shapes that is recovered in the two after a step."""
    both = np.diagonal(mac, axis1=1, axis2=2)[:, :, None] + mac
    return np.minimum(both, both.swapaxes(1, 2))


def _keep_coupled_in_order(mac: np.ndarray, order: np.ndarray, recovered: np.ndarray) -> np.ndarray:
    """The assignment with modes that couple put back in their order."""
    kept = order.copy()
    for step in np.flatnonzero((order != np.arange(order.shape[1])).any(axis=1)):
        after, row = order[step], kept[step]
        for j, i in np.argwhere(np.tril(after[:, None] < after[None, :], -1)).tolist():
            coupled = max(mac[step, i, after[j]], mac[step, j, after[i]]) > UNCOUPLED
            if coupled and min(recovered[step, [i, j]]) >= LOST and row[i] > row[j]:
                row[[i, j]] = row[[j, i]]
    return kept


def _number_branches(order: np.ndarray, recovered: np.ndarray) -> np.ndarray:
    """The branch (n, m) of each mode, numbered as at the first point; what enters is new."""
    steps, m = order.shape
    branch = np.tile(np.arange(m), (steps + 1, 1))
    lost = recovered < LOST
    new = m
    for step in np.flatnonzero((order != np.arange(m)).any(axis=1) | lost.any(axis=1)):
        after = np.empty(m, int)
        after[order[step]] = np.where(lost[step], new + np.arange(m), branch[step])
        new += m
        branch[step + 1 :] = after
    return branch


@dataclass(frozen=True)
class BranchTable:
    """Branches as columns: those among the lowest `window` modes somewhere, or next to them."""

    at: np.ndarray  # (n,)
    branches: np.ndarray  # (b,) their numbers in the track
    mode_index: np.ndarray  # (n, b) from 0, m where the branch is absent
    frequencies: np.ndarray  # (n, b), nan where absent or unstable
    rotation: np.ndarray  # (n - 1, b, b) angle by which two shapes rotate into each other [rad]
    recovered: np.ndarray  # (n - 1, b, b) least share of two shapes recovered in the two
    window: int

    @cached_property
    def pairs(self) -> "Pairs":
        """All pairs of branches."""
        a, b = np.triu_indices(len(self.branches), 1)
        difference = self.frequencies[:, b] - self.frequencies[:, a]
        in_window = np.minimum(self.mode_index[:, a], self.mode_index[:, b]) < self.window
        return Pairs(a, b, difference, self.rotation[:, a, b], in_window)


class Pairs(NamedTuple):
    """Pairs of columns of a branch table."""

    a: np.ndarray  # (pairs,)
    b: np.ndarray  # (pairs,)
    difference: np.ndarray  # (n, pairs) of the frequencies
    rotation: np.ndarray  # (n - 1, pairs)
    in_window: np.ndarray  # (n, pairs) whether one of the two is in the window


class Candidate(NamedTuple):
    """Two columns of a branch table that may cross or veer between two points."""

    a: int
    b: int
    low: int
    high: int
    crosses: bool  # the difference changes its sign


def branch_table(track: Track, window: int) -> BranchTable:
    """The branches of a track that are among the lowest `window` modes somewhere, or next to."""
    points = track.points
    n, m = points.omega_squared.shape
    branches = np.unique(track.branch[:, : followed_modes(window, m)])
    present = track.branch[:, None, :] == branches[:, None]
    index = np.where(present.any(axis=2), present.argmax(axis=2), m)
    squares = np.column_stack((points.omega_squared, np.full(n, np.nan)))
    squares = np.take_along_axis(squares, index, axis=1)
    frequencies = np.sqrt(np.where(squares >= 0, squares, np.nan))
    padded = np.pad(track.overlaps, ((0, 0), (0, 1), (0, 1)))
    step = np.arange(n - 1)[:, None, None]
    O = padded[step, index[:-1, :, None], index[1:, None, :]]
    mac = abs(O) ** 2
    recovered = np.minimum(_recovered_by_pairs(mac), _recovered_by_pairs(mac.swapaxes(1, 2)))
    return BranchTable(points.at, branches, index, frequencies, _rotation(O), recovered, window)


def _rotation(O: np.ndarray) -> np.ndarray:
    """The angles (n - 1, b, b) by which each two branches rotate into each other in each step."""
    own = np.diagonal(O, axis1=1, axis2=2)
    kept = abs(own)
    # The sign of each solved shape is arbitrary: choose it so that a branch keeps its own.
    phase = np.where(kept == 0, 1, own.conj() / np.where(kept == 0, 1, kept)).cumprod(axis=0)
    before = np.concatenate((np.ones_like(phase[:1]), phase[:-1]))
    O = before.conj()[:, :, None] * O * phase[:, None, :]
    exchanged = abs(O) + abs(O).swapaxes(1, 2)
    side = np.sign((O - O.conj().swapaxes(1, 2)).real)
    return side * np.arctan2(exchanged, kept[:, :, None] + kept[:, None, :])


def steps_to_halve(table: BranchTable) -> np.ndarray:
    """Middles of the steps in which more may happen than their ends show: two loci may touch, or
    one of two that cross or veer rotates into a third."""
    at = table.at
    ambiguous = {
        step
        for a, b, low, high, _ in candidates(table)
        for step in range(low, high)
        if table.recovered[step, a, b] < CLEAR
    }
    steps = np.union1d(_steps_of_contact(table), sorted(ambiguous)).astype(int)
    steps = steps[np.diff(at)[steps] > SHORTEST * np.ptp(at)]
    return (at[steps] + at[steps + 1]) / 2


def _steps_of_contact(table: BranchTable) -> np.ndarray:
    """Steps in which two loci may touch though their ends do not show it.

    Between two points a smooth difference strays from its chord by curvature / 8 times the
    square of the step; the curvature is taken from the points around.
    """
    pairs, step = table.pairs, np.diff(table.at)[:, None]
    if len(step) < 2:
        return np.empty(0, int)
    # Where shapes are exchanged the difference continues smoothly with the other sign.
    side = np.where(abs(pairs.rotation) > EXCHANGE, -1, 1).cumprod(axis=0)
    D = pairs.difference * np.concatenate((np.ones_like(side[:1]), side))
    with np.errstate(over="ignore", invalid="ignore"):  # steps as short as numbers get
        slope = np.diff(D, axis=0) / step
        half_curvature = abs(np.diff(slope, axis=0)) / (step[1:] + step[:-1])
        half_curvature = np.pad(half_curvature, ((1, 1), (0, 0)), mode="edge")
        strays = SAFETY * np.fmax(half_curvature[:-1], half_curvature[1:]) * step**2 / 4
    ends = abs(D[:-1]), abs(D[1:])
    bend = 4 * strays - abs(ends[1] - ends[0])  # what is left to turn the difference back
    same = (D[:-1] * D[1:] >= 0) & pairs.in_window[:-1]
    touch = same & (bend > 0) & (16 * strays * np.minimum(*ends) < bend**2)
    return np.flatnonzero(touch.any(axis=1))


def candidates(table: BranchTable) -> list[Candidate]:
    """Every two points between which two loci may cross or veer.

    Loci of modes that do not couple cross: their difference changes its sign. Loci of modes that
    do couple keep their order: their difference has a minimum, around which the shapes rotate into
    each other.
    """
    if len(table.at) < 2:
        return []
    pairs = table.pairs
    side = np.sign(pairs.difference)
    for i in np.flatnonzero((side[1:] == 0).any(axis=1)) + 1:
        side[i] = np.where(side[i] == 0, side[i - 1], side[i])
    found = [(k, i, i + 1, True) for i, k in np.argwhere(side[:-1] * side[1:] < 0).tolist()]
    found += [
        (k, low, high, False)
        for k, low, high in _minima(pairs)
        if _are_neighbours(table, pairs.a[k], pairs.b[k], low)
    ]
    return [
        Candidate(int(pairs.a[k]), int(pairs.b[k]), low, high, crosses)
        for k, low, high, crosses in found
        if pairs.in_window[low : high + 1, k].any()
    ]


def _minima(pairs: Pairs) -> list[tuple[int, int, int]]:
    """Pairs with a least gap across which the shapes rotate, and the points around it."""
    gap, rotation = abs(pairs.difference), abs(pairs.rotation)
    present = np.isfinite(gap[:-1]) & np.isfinite(gap[1:])  # a shape may rotate into a new one
    exchanges = np.argwhere((rotation > EXCHANGE) & present)
    found = [(k, i, i + 1) for i, k in exchanges.tolist()]
    middle = (gap[1:-1] <= gap[:-2]) & (gap[1:-1] < gap[2:])
    middle &= pairs.difference[:-2] * pairs.difference[2:] > 0
    middle &= np.maximum(rotation[:-1], rotation[1:]) <= EXCHANGE
    found += [(k, i, i + 2) for i, k in np.argwhere(middle).tolist()]
    # In the first and last step a minimum has no point on its other side: the rotation shows it.
    last = len(gap) - 1
    for low, end, inner in ((0, 0, 1), (last - 1, last, last - 1)):
        beyond = gap[inner] * np.cos(2 * rotation[low])
        hides = (gap[end] < gap[inner]) & (beyond < gap[end]) & (rotation[low] <= EXCHANGE)
        found += [(k, low, low + 1) for k in np.flatnonzero(hides).tolist()]
    return [(k, low, high) for k, low, high in found if _rotate_around(pairs, gap, k, low, high)]


def _rotate_around(pairs: Pairs, gap: np.ndarray, k: int, low: int, high: int) -> bool:
    """Whether two shapes rotate into each other around their least gap, or none is left of it."""
    if abs(pairs.rotation[low, k]) > EXCHANGE or gap[low : high + 1, k].min() <= NO_GAP:
        return True
    while low > 0 and gap[low - 1, k] >= gap[low, k]:  # as far as the gap grows on both sides
        low -= 1
    while high < len(gap) - 1 and gap[high + 1, k] >= gap[high, k]:
        high += 1
    return abs(pairs.rotation[low:high, k].sum()) >= ROTATED


def _are_neighbours(table: BranchTable, a: int, b: int, point: int) -> bool:
    """Whether no third branch that couples with one of two lies between them."""
    f = table.frequencies[point]
    between = (f > min(f[a], f[b])) & (f < max(f[a], f[b]))
    couples = table.rotation[:, [a, b]].any(axis=(0, 1))
    return not (between & couples).any()
