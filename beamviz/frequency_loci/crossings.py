"""Crossings and veerings: every meeting of two loci, located and measured."""

import math
from dataclasses import dataclass, replace
from typing import Generic, Literal, TypeVar

import numpy as np

from beamviz.frequency_loci.candidates import (
    Candidate,
    Columns,
    candidates,
    columns_of,
    hidden,
    unclear,
)
from beamviz.frequency_loci.tracking import Points, SolveAt, Track, follow
from beamviz.frequency_loci.two_mode_reduction import Place, Search, least_gap, together

# A veering is a least gap below CLOSE of the frequency, around which the shapes turn into each
# other by candidates.TURN or more, and whose veering index reaches INDEX.
CLOSE = 0.1
INDEX = 0.5

STEP = 0.02  # of the width of a veering: half the distance its rates are taken over
MAX_ROUNDS = 16

Name = TypeVar("Name")  # of a branch: its number in a track, or its label


@dataclass(frozen=True)
class Event(Generic[Name]):
    """Two branches that meet: the gap between their frequencies is least at `at`."""

    kind: Literal["crossing", "veering"]
    branches: tuple[Name, Name]
    at: float
    frequency: float  # mean of the two
    gap: float  # 0 for a crossing
    coupling: float  # s_ab = phi_a' (K' - lambda M') phi_b, lambda the mean of the pair
    index: float  # veering index MDF_ab CSQ_ab MDF_ba among the modes solved for: 0 .. 1
    width: float  # at this distance the gap is sqrt(2) times the least; 0 for a crossing


def chart(points: Points, window: int, solve_at: SolveAt) -> tuple[Track, list[Event[int]]]:
    """Follow the lowest `window` modes through a sweep and find every meeting of two of them."""
    track, loci = _seen(points, window, solve_at)
    for _ in range(MAX_ROUNDS):
        some = candidates(loci)
        found = together([_search(candidate, track.points, loci) for candidate in some], solve_at)
        odd = [
            (candidate, place)
            for candidate, (place, _) in zip(some, found, strict=True)
            if place and candidate.crosses != (place.gap == 0)
        ]
        if not odd:
            break
        track = _exchanged(track, loci, *odd[0])
        loci = columns_of(track, window)
    asked = set(track.branch[:, :window].ravel().tolist())
    events = [event for _, event in found if event and asked.issuperset(event.branches)]
    return track, sorted(events, key=lambda event: event.at)


def _seen(points: Points, window: int, solve_at: SolveAt) -> tuple[Track, Columns]:
    """The track, with points added until they show every meeting of two loci."""
    for _ in range(MAX_ROUNDS):
        track = follow(points, window, solve_at)
        loci = columns_of(track, window)
        more = np.union1d(hidden(loci), unclear(loci))
        if not len(more):
            break
        found = solve_at(more)
        if not len(found.at):
            break
        points = track.points.merged(found)
    return track, loci


def _exchanged(track: Track, loci: Columns, candidate: Candidate, place: Place) -> Track:
    """The track with two branches exchanged behind a place.

    Modes that couple elsewhere may cross where their coupling vanishes (Perkins & Mote 1986).
    """
    a, b = loci.branches[[candidate.a, candidate.b]]
    behind = (track.points.at > place.at)[:, None]
    is_a, is_b = behind & (track.branch == a), behind & (track.branch == b)
    return replace(track, branch=np.where(is_a, b, np.where(is_b, a, track.branch)))


def _search(
    candidate: Candidate, points: Points, loci: Columns
) -> Search[tuple[Place | None, Event[int] | None]]:
    """The place of a candidate's least gap, and the meeting if it is one."""
    a, b, low, high, _ = candidate
    shapes = points.shapes[low, loci.places[low, [a, b]]]
    around = points.take(slice(max(low - 2, 0), high + 3))
    place = yield from least_gap(around, shapes, points.at[low], points.at[high])
    if place is None or place.ranks[place.gap > 0] >= loci.window:
        return None, None  # outside what was asked for; a crossing on its edge is not
    numbers = int(loci.branches[a]), int(loci.branches[b])
    if place.gap == 0:
        return place, Event("crossing", numbers, *place[:3], 0.0, 0.0, 0.0)
    if place.gap > CLOSE * place.frequency:
        return place, None
    coupling, index = yield from _veering(place, shapes, points.at[0], points.at[-1])
    if index < INDEX:
        return place, None
    return place, Event("veering", numbers, *place[:3], coupling, index, place.width)


def _veering(
    place: Place, shapes: np.ndarray, start: float, stop: float
) -> Search[tuple[float, float]]:
    """s_ab and the veering index of a pair (du Bois, Adhikari & Lieven 2011), from how the modes
    turn about its least gap: at the rate s_ab / (lambda_b - lambda_a) into each other."""
    h = min(STEP * place.width, place.at - start, stop - place.at)
    beside = yield place.at + np.array([-h, h])
    if len(beside.at) < 2:
        return math.nan, 0.0
    O = beside.shapes[0].conj() @ beside.duals[1].T
    own = np.diagonal(O)
    O = O * own.conj() / np.maximum(abs(own), np.finfo(float).tiny)
    rates = abs(O - O.conj().T) / (4 * h)
    squares, slope = beside.squares.mean(axis=0), np.diff(beside.squares, axis=0)[0] / (2 * h)
    i, j = np.sort((abs(shapes.conj() @ beside.duals[0].T) ** 2).sum(axis=0).argsort()[-2:])
    s = rates[i, j] * (squares[j] - squares[i])
    if not s:
        return 0.0, 0.0
    mdf = rates[i, j] ** 2 / (rates[[i, j]] ** 2).sum(axis=1)
    csq = s**2 / (s**2 + ((slope[i] - slope[j]) / 2) ** 2)
    return float(s), float(mdf.prod() * csq)
