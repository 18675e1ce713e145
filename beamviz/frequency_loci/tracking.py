"""Which mode is which: modes followed from point to point by their mass-weighted shapes.

A shape is a vector whose inner products are modal masses, so the modes of one point are
orthonormal, and the squared inner product across a step is the mass-weighted modal assurance
criterion, MAC (Allemang & Brown 1982). Gyroscopic modes are orthogonal in another product: the
shapes then come with duals, shape_i . dual_j = 1 for i = j and 0 otherwise.

Modes that couple keep their order: their loci cannot cross as one parameter varies (von Neumann
& Wigner 1929), however narrowly they veer. Modes that do not couple cross, shape by shape.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Self

import numpy as np
from scipy.optimize import linear_sum_assignment

CLEAR = 0.9  # MAC below which a step is in doubt, and halved
LOST = 0.25  # MAC below which a mode has left the modes that were solved for
UNCOUPLED = 1e-18  # MAC of two modes that share nothing but rounding
SHORTEST = 1e-7  # of the whole range: a step in doubt is not halved further
MAX_ADDED = 400  # points


@dataclass(frozen=True)
class Points:
    """Modes at n ascending values of one parameter, m at each."""

    at: np.ndarray  # (n,)
    squares: np.ndarray  # (n, m) omega^2, ascending in each row
    shapes: np.ndarray  # (n, m, d)
    duals: np.ndarray  # (n, m, d)

    def take(self, index: np.ndarray | slice) -> Self:
        """Some of the points."""
        return type(self)(
            self.at[index], self.squares[index], self.shapes[index], self.duals[index]
        )

    def merged(self, other: Self) -> Self:
        """These points and others between them."""
        if not len(other.at):
            return self
        joined = type(self)(
            np.concatenate((self.at, other.at)),
            np.concatenate((self.squares, other.squares)),
            np.concatenate((self.shapes, other.shapes)),
            np.concatenate((self.duals, other.duals)),
        )
        _, index = np.unique(joined.at, return_index=True)
        return joined.take(index)


SolveAt = Callable[[np.ndarray], Points]  # what exists at ascending values of the parameter


@dataclass(frozen=True)
class Track:
    """Points with a branch for each mode; a branch is a number that stays with its locus."""

    points: Points
    branch: np.ndarray  # (n, m)
    confidence: np.ndarray  # (n - 1,) least MAC of a step, a pair that veers taken together
    overlaps: np.ndarray  # (n - 1, m, m) inner products across each step


def follow(points: Points, window: int, solve_at: SolveAt) -> Track:
    """Follow the lowest `window` of m modes, halving every step whose assignment is in doubt.

    The modes above the window are there for the branches that enter and leave it.
    """
    shortest = SHORTEST * np.ptp(points.at)
    room = MAX_ADDED
    while True:
        overlaps = inner_products(points)
        mac = abs(overlaps) ** 2
        order = assignment(mac)
        found = _found(mac, order)
        confidence = _confidence(found, order, window)
        halved = np.flatnonzero((confidence < CLEAR) & (np.diff(points.at) > shortest))
        room -= len(halved)
        if not len(halved) or room < 0:
            break
        more = solve_at((points.at[halved] + points.at[halved + 1]) / 2)
        if not len(more.at):
            break
        points = points.merged(more)
    order = _coupled_in_order(mac, order, found)
    return Track(points, _threaded(order, found), confidence, overlaps)


def followed(window: int, m: int) -> int:
    """How many of m modes are followed: those in the window and what may enter it."""
    return max(window, m - 1)


def inner_products(points: Points) -> np.ndarray:
    """Inner products (n - 1, m, m) of the modes before (rows) and after each step (columns)."""
    return points.shapes[:-1].conj() @ points.duals[1:].swapaxes(1, 2)


def assignment(mac: np.ndarray) -> np.ndarray:
    """The mode after each step (n - 1, m) that continues each mode before it.

    Optimal: the sum of the MAC is the largest. In nearly all steps the order just stays.
    """
    m = mac.shape[1]
    order = mac.argmax(axis=2)
    for step in np.flatnonzero((order != np.arange(m)).any(axis=1)):
        order[step] = linear_sum_assignment(mac[step], maximize=True)[1]
    return order


def _found(mac: np.ndarray, order: np.ndarray) -> np.ndarray:
    """The share (n - 1, m) of each shape that is found again after a step.

    Found in its own continuation, or in that and one other mode when both are found there: two
    modes that veer turn into each other, and their order says which is which.
    """
    kept = np.take_along_axis(mac, order[:, None, :], axis=2)
    own = np.diagonal(kept, axis1=1, axis2=2)
    with_one = own[:, :, None] + kept
    pairs = np.minimum(with_one, with_one.swapaxes(1, 2))
    diagonal = np.arange(mac.shape[1])
    pairs[:, diagonal, diagonal] = own
    return pairs.max(axis=2, initial=0.0)


def _confidence(found: np.ndarray, order: np.ndarray, window: int) -> np.ndarray:
    """The least share found (n - 1,) of the modes in the window, or next to it, at a step."""
    m = order.shape[1]
    count = followed(window, m)
    seen = (np.arange(m) < count) | (order < count)
    return np.where(seen, found, 1.0).min(axis=1, initial=1.0)


def _changed(order: np.ndarray) -> np.ndarray:
    """The steps in which the order of the modes changes."""
    return np.flatnonzero((order != np.arange(order.shape[1])).any(axis=1))


def _inversions(order: np.ndarray) -> list[tuple[int, int]]:
    """The pairs (i, j), i < j, of modes that pass each other."""
    later, earlier = np.nonzero(np.tril(order[:, None] < order[None, :], -1))
    return list(zip(earlier.tolist(), later.tolist(), strict=True))


def _couple(mac: np.ndarray, order: np.ndarray, i: int, j: int) -> bool:
    """Whether two modes share anything across a step."""
    return max(mac[i, order[j]], mac[j, order[i]]) > UNCOUPLED


def _coupled_in_order(mac: np.ndarray, order: np.ndarray, found: np.ndarray) -> np.ndarray:
    """The assignment with the modes that couple back in their order."""
    kept = order.copy()
    for step in _changed(order):
        for i, j in _inversions(order[step]):
            both = min(found[step, i], found[step, j]) >= LOST
            if both and kept[step, i] > kept[step, j] and _couple(mac[step], order[step], i, j):
                kept[step, [i, j]] = kept[step, [j, i]]
    return kept


def _threaded(order: np.ndarray, found: np.ndarray) -> np.ndarray:
    """The branch (n, m) of each mode, numbered as at the first point; what enters is new."""
    steps, m = order.shape
    branch = np.tile(np.arange(m), (steps + 1, 1))
    lost = found < LOST
    fresh = m
    for step in np.flatnonzero((order != np.arange(m)).any(axis=1) | lost.any(axis=1)):
        after = np.empty(m, int)
        after[order[step]] = np.where(lost[step], fresh + np.arange(m), branch[step])
        fresh += m
        branch[step + 1 :] = after
    return branch
