"""Crossings and veerings of two loci: location, gap and veering index.

Loci of uncoupled families cross at the roots of differences of omega^2. Coupled modes do not cross,
however narrowly they veer (von Neumann & Wigner 1929).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from beamviz.frequency_loci.curves import Curves, Root, polish
from beamviz.frequency_loci.least_gaps import LeastGap, least_gaps
from beamviz.frequency_loci.mode_vectors import Points
from beamviz.frequency_loci.sweep import Sweep
from beamviz.frequency_loci.two_modes import TINY

# A veering is a least gap, below CLOSE of the frequency, with a veering index of at least MIN_INDEX
# and shapes that rotate into each other by ROTATED or more (a complete veering: 90 degrees) from
# before it to after it: see `least_gaps`.
ROTATED = math.radians(30)
MIN_INDEX = 0.5
OUTSIDE = 1e-2  # relative margin of omega^2 by which an interpolated mode is below a crossing

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
    width: float = 0.0  # distance at which the gap is sqrt(2) times the least, by its curvature


def locate_events(curves: Curves, sweep: Sweep) -> list[Event]:
    """All crossings and veerings of the lowest `sweep.modes` loci, by ascending value."""
    gaps = least_gaps(curves, sweep)
    found = [
        *([] if sweep.coupled else _crossings(curves, sweep)),
        *(Event("crossing", one.modes, *one.approach[:2]) for one in gaps if not one.approach.gap),
        *_veerings([one for one in gaps if one.approach.gap], sweep),
    ]
    events = {(event.branches, event.at): event for event in found}
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


def _veerings(gaps: Sequence[LeastGap], sweep: Sweep) -> list[Event]:
    """The veerings among least gaps of neighbours of a family."""
    if not gaps:
        return []
    near, ends = np.array([one.near for one in gaps]), np.array([one.ends for one in gaps])
    points = sweep.points(np.unique(np.concatenate((near, ends))))
    if not len(points.at):
        return []
    pair = np.array([sweep.ranks(one.near[:1], *one.modes[0])[0] for one in gaps])
    coupling, index = _veering_indices(points, near, pair)
    ranks = np.array([sweep.ranks(one.ends, *one.modes[0]) for one in gaps])
    kept = (index >= MIN_INDEX) & _rotates(points, ends, ranks)
    numbers = zip(gaps, coupling.tolist(), index.tolist(), kept.tolist(), strict=True)
    return [
        Event("veering", one.modes, *one.approach[:3], s, mdf, one.approach.width)
        for one, s, mdf, own in numbers
        if own
    ]


def _places(points: Points, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The indices (n, 2) of values among the points, and whether both are among them (n,)."""
    places = np.searchsorted(points.at, values).clip(max=len(points.at) - 1)
    return places, (points.at[places] == values).all(axis=1)


def _rotates(points: Points, ends: np.ndarray, ranks: np.ndarray) -> np.ndarray:
    """Whether the shapes of two modes, of these ranks (n, 2, 2) by frequency at two ends (n, 2),
    rotate into each other between them (n,); true where that is not known."""
    places, known = _places(points, ends)
    known &= (ranks < points.shapes.shape[1]).all(axis=(1, 2))  # else above the modes solved for
    places, ranks = places[..., None], np.where(known[:, None, None], ranks, 0)
    before = points.shapes[places[:, 0], ranks[:, 0]]
    O = abs(before.conj() @ points.duals[places[:, 1], ranks[:, 1]].mT)
    angles = np.arctan2(O[:, 0, 1] + O[:, 1, 0], O[:, 0, 0] + O[:, 1, 1])
    return (angles >= ROTATED) | ~known


def _veering_indices(
    points: Points, near: np.ndarray, pair: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """s_ab and the veering index (n,) of pairs of modes (n, 2) (du Bois, Adhikari & Lieven 2011),
    from the rates at which the modes rotate into each other at the least gap, s_ab / (lambda_b -
    lambda_a), by central differences of the points `near` (n, 2); index 0 where the points or
    the modes are not known."""
    places, known = _places(points, near)
    h, each = np.where(known, near[:, 1] - near[:, 0], 1.0)[:, None] / 2, np.arange(len(near))
    O = points.shapes[places[:, 0]].conj() @ points.duals[places[:, 1]].mT
    own = np.diagonal(O, axis1=1, axis2=2)[:, None]
    O = O * own.conj() / np.maximum(abs(own), TINY)
    rates = abs(O - O.conj().mT) / (4 * h[:, None])
    squares = points.omega_squared[places]  # (n, 2, modes)
    mean, slope = squares.mean(axis=1), np.diff(squares, axis=1)[:, 0] / (2 * h)
    known &= (pair < O.shape[1]).all(axis=1)  # else above the modes solved for
    pair = np.where(known[:, None], pair, 0)
    i, j = pair.T
    rate = rates[each, i, j]
    s = rate * (mean[each, j] - mean[each, i])
    csq = s**2 / np.maximum(s**2 + ((slope[each, i] - slope[each, j]) / 2) ** 2, TINY)
    totals = (rates[each[:, None], pair] ** 2).sum(axis=2)
    mdf = rate[:, None] ** 2 / np.maximum(totals, TINY)
    return s, np.where(known, mdf.prod(axis=1) * csq, 0.0)
