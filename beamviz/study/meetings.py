"""Where loci meet: crossings and veerings, located between the points of a sweep.

Loci of modes that do not couple cross: their difference changes its sign. Loci of modes that do
couple veer: their difference has a least value, around which the shapes turn into each other.
"""

import math
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np

from beamviz.study.pairs import Place, least_gap
from beamviz.study.tracking import Points, SolveAt, Track, follow

# A veering is a least gap that is at least doubled on a side where the sweep goes on, across
# which the two shapes turn into each other by TURN at least (a clean one from gap to twice the
# gap, both sides: 60 degrees) and whose veering index reaches INDEX.
TURN = math.radians(30)
TIMES = 2.0
INDEX = 0.5

HIDDEN = 0.3  # of the gap seen: a least gap predicted between points below this is looked for
MAX_HIDDEN = 8  # rounds of looking
STEP = 0.1  # of the width of a veering: half the distance its rates are taken over


class Meeting(NamedTuple):
    """Two branches that meet: `gap` between their frequencies is least at `at`.

    coupling: s_ab = phi_a' (K' - lambda M') phi_b (units of omega^2 per parameter), lambda the
    mean of the pair; index: the veering index MDF_ab CSQ_ab MDF_ba (du Bois, Adhikari & Lieven
    2011) among the modes solved for, 0 for an uncoupled crossing, 1 for a clean veering.
    """

    kind: Literal["crossing", "veering"]
    a: int
    b: int
    at: float
    frequency: float
    gap: float
    coupling: float
    index: float


@dataclass(frozen=True)
class Loci:
    """Branches as columns: those among the lowest modes somewhere."""

    at: np.ndarray  # (n,)
    branches: np.ndarray  # (b,) their numbers in the track
    places: np.ndarray  # (n, b) place of each among the modes, m where it is not there
    frequencies: np.ndarray  # (n, b), nan where not there or unstable
    turns: np.ndarray  # (n - 1, b, b) angle by which two shapes turn into each other [rad]


def loci_of(track: Track, window: int) -> Loci:
    """The branches of a track that are among the lowest `window` modes somewhere."""
    points = track.points
    n, m = points.squares.shape
    branches = np.unique(track.branch[:, :window])
    there = track.branch[:, None, :] == branches[:, None]
    places = np.where(there.any(axis=2), there.argmax(axis=2), m)
    squares = np.column_stack((points.squares, np.full(n, np.nan)))
    squares = np.take_along_axis(squares, places, axis=1)
    frequencies = np.sqrt(np.where(squares >= 0, squares, np.nan))
    return Loci(points.at, branches, places, frequencies, _turns(track.overlaps, places))


def _turns(overlaps: np.ndarray, places: np.ndarray) -> np.ndarray:
    """The angles (n - 1, b, b) by which each two branches turn into each other in each step."""
    padded = np.pad(overlaps, ((0, 0), (0, 1), (0, 1)))
    step = np.arange(len(overlaps))[:, None, None]
    O = padded[step, places[:-1, :, None], places[1:, None, :]]
    own = np.diagonal(O, axis1=1, axis2=2)
    size = np.where(own == 0, 1, abs(own))
    phase = np.where(own == 0, 1, own.conj() / size).cumprod(axis=0)
    before = np.concatenate((np.ones_like(phase[:1]), phase[:-1]))
    O = before.conj()[:, :, None] * O * phase[:, None, :]
    exchanged = abs(O) + abs(O).swapaxes(1, 2)
    kept = abs(own)[:, :, None] + abs(own)[:, None, :]
    return np.arctan2(exchanged, kept) * np.sign((O - O.conj().swapaxes(1, 2)).real)


def chart(points: Points, window: int, solve_at: SolveAt) -> tuple[Track, list[Meeting]]:
    """Follow the lowest `window` modes through a sweep and find every meeting of two of them."""
    track = follow(points, window, solve_at)
    for _ in range(MAX_HIDDEN):
        hidden = _hidden(loci_of(track, window), window)
        if not len(hidden):
            break
        track = follow(track.points.merged(solve_at(hidden)), window, solve_at)
    return _meetings(track, window, solve_at)


def _pairs(loci: Loci) -> tuple[np.ndarray, np.ndarray]:
    """All pairs of branches, as two arrays of columns."""
    return np.triu_indices(len(loci.branches), 1)


def _hidden(loci: Loci, window: int) -> np.ndarray:
    """Where two loci may touch between points that do not show it: (k,) values to solve at.

    There the parabola through three points of their difference nearly reaches zero or passes it.
    """
    a, b = _pairs(loci)
    D = loci.frequencies[:, b] - loci.frequencies[:, a]
    if len(D) < 3:
        return np.empty(0)
    p = loci.at[:, None]
    first, second = np.diff(D, axis=0)[:-1] / np.diff(p, axis=0)[:-1], np.diff(D, axis=0)[1:]
    second = second / np.diff(p, axis=0)[1:]
    with np.errstate(divide="ignore", invalid="ignore"):
        curvature = (second - first) / (p[2:] - p[:-2])
        place = (p[:-2] + p[1:-1]) / 2 - first / (2 * curvature)
        least = D[1:-1] + (place - p[1:-1]) * (first + curvature * (place - p[:-2]))
    side = np.sign(D)
    same = (side[:-2] == side[1:-1]) & (side[1:-1] == side[2:])
    seen = np.minimum(np.minimum(abs(D[:-2]), abs(D[1:-1])), abs(D[2:]))
    inside = (place > p[:-2]) & (place < p[2:])
    low = np.minimum(loci.places[1:-1, a], loci.places[1:-1, b]) < window
    turned = abs(loci.turns[:, a, b])
    still = np.maximum(turned[:-1], turned[1:]) < 0.2
    wanted = same & inside & low & still & (side[1:-1] * least < HIDDEN * seen)
    values = np.sort(place[wanted])
    step = np.searchsorted(loci.at, values)
    return values[np.unique(step, return_index=True)[1]]


class Candidate(NamedTuple):
    """Two columns of the loci that may meet between two points."""

    a: int
    b: int
    low: int
    high: int
    crosses: bool


def _candidates(loci: Loci, window: int) -> list[Candidate]:
    """Where a difference of frequencies changes its sign, or is least between turning shapes."""
    a, b = _pairs(loci)
    D = loci.frequencies[:, b] - loci.frequencies[:, a]
    low = np.minimum(loci.places[:, a], loci.places[:, b]) < window
    turns = loci.turns[:, a, b]
    found = []
    for k in np.flatnonzero((low & np.isfinite(D)).any(axis=0)):
        crossings, minima = _sign_changes(D[:, k]), _minima(abs(D[:, k]), turns[:, k])
        brackets = [(*x, True) for x in crossings] + [(*x, False) for x in minima]
        found += [Candidate(a[k], b[k], *x) for x in brackets if low[x[0] : x[1] + 1, k].any()]
    return found


def _sign_changes(D: np.ndarray) -> list[tuple[int, int]]:
    """Neighbouring points between which D changes its sign."""
    side = np.sign(D)
    for i in np.flatnonzero(side[1:] == 0) + 1:
        side[i] = side[i - 1]
    return [(i, i + 1) for i in np.flatnonzero(side[:-1] * side[1:] < 0).tolist()]


def _minima(gap: np.ndarray, turn: np.ndarray) -> list[tuple[int, int]]:
    """Points around each least gap across which the shapes turn into each other."""
    last = len(gap) - 1
    middle = np.flatnonzero((gap[1:-1] <= gap[:-2]) & (gap[1:-1] < gap[2:])) + 1
    brackets = [(i - 1, i + 1) for i in middle.tolist()]
    # At an end of the sweep the least gap can hide in a step: the turning shapes show it.
    if gap[0] < gap[1] and gap[1] * math.cos(2 * turn[0]) < gap[0]:
        brackets.append((0, 1))
    if gap[last] < gap[last - 1] and gap[last - 1] * math.cos(2 * turn[-1]) < gap[last]:
        brackets.append((last - 1, last))
    angle = np.concatenate(([0.0], np.nancumsum(turn)))
    return [
        (i, j) for i, j in brackets if abs(angle[_top(gap, j, 1)] - angle[_top(gap, i, -1)]) >= TURN
    ]


def _top(gap: np.ndarray, start: int, way: int) -> int:
    """The point up to which a gap grows from `start` on."""
    i = start
    while 0 <= i + way < len(gap) and gap[i + way] >= gap[i]:
        i += way
    return i


def _meetings(track: Track, window: int, solve_at: SolveAt) -> tuple[Track, list[Meeting]]:
    """All meetings along a track."""
    loci = loci_of(track, window)
    found = []
    for candidate in _candidates(loci, window):
        place = _place(candidate, track.points, loci, solve_at)
        if place and place.gap == 0 and not candidate.crosses:
            return _meetings(_exchanged(track, loci, candidate, place.at), window, solve_at)
        if place:
            found.append(_meeting(candidate, place, track, loci, solve_at))
    meetings = [meeting for meeting in found if meeting]
    return track, sorted(meetings, key=lambda meeting: meeting.at)


def _place(candidate: Candidate, points: Points, loci: Loci, solve_at: SolveAt) -> Place | None:
    """Where the gap of a candidate is least."""
    a, b, low, high, _ = candidate
    both = points.shapes[low, loci.places[low, [a, b]]]
    around = points.take(slice(max(low - 2, 0), high + 3))
    return least_gap(around, both, points.at[low], points.at[high], solve_at)


def _exchanged(track: Track, loci: Loci, candidate: Candidate, at: float) -> Track:
    """The track with two branches exchanged from a place on: they couple, but not there."""
    a, b = loci.branches[[candidate.a, candidate.b]]
    branch = track.branch.copy()
    after = branch[track.points.at > at]
    branch[track.points.at > at] = np.where(after == a, b, np.where(after == b, a, after))
    return replace(track, branch=branch)


def _meeting(
    candidate: Candidate, place: Place, track: Track, loci: Loci, solve_at: SolveAt
) -> Meeting | None:
    """A located candidate as what it is, or None where the loci only pass at a distance."""
    a, b, low, high, crosses = candidate
    numbers = int(loci.branches[a]), int(loci.branches[b])
    if crosses:
        return Meeting("crossing", *numbers, place.at, place.frequency, 0.0, 0.0, 0.0)
    gap = abs(loci.frequencies[:, a] - loci.frequencies[:, b])
    start, stop = _top(gap, low, -1), _top(gap, high, 1)
    grown = [gap[start] >= TIMES * place.gap, gap[stop] >= TIMES * place.gap]
    goes_on = [
        start > 0 and np.isfinite(gap[start - 1]),
        stop < len(gap) - 1 and np.isfinite(gap[stop + 1]),
    ]
    if not any(grown) or any(g and not ok for g, ok in zip(goes_on, grown, strict=True)):
        return None
    coupling, index = _veering(place, track.points, low, loci.places[low, [a, b]], solve_at)
    if index < INDEX:
        return None
    return Meeting("veering", *numbers, place.at, place.frequency, place.gap, coupling, index)


def _veering(
    place: Place, points: Points, low: int, places: np.ndarray, solve_at: SolveAt
) -> tuple[float, float]:
    """s_ab and the veering index of a pair, from how the modes turn about its least gap."""
    room = min(place.at - points.at[0], points.at[-1] - place.at)
    h = min(STEP * place.width, room)
    beside = solve_at(place.at + np.array([-h, h]))
    if len(beside.at) < 2:
        return math.nan, 0.0
    O = beside.shapes[0].conj() @ beside.duals[1].T
    phase = np.diagonal(O) / np.maximum(abs(np.diagonal(O)), np.finfo(float).tiny)
    O = O * phase.conj()
    rates = (O - O.conj().T) / (4 * h)
    B = abs(points.shapes[low, places].conj() @ beside.duals[0].T) ** 2
    i, j = np.sort(B.sum(axis=0).argsort()[-2:])
    squares = beside.squares.mean(axis=0)
    slopes = (beside.squares[1] - beside.squares[0]) / (2 * h)
    s = abs(rates[i, j]) * (squares[j] - squares[i])
    share = abs(rates[i, j]) ** 2 / (abs(rates) ** 2).sum(axis=1)
    sensitivity = s**2 / (s**2 + ((slopes[i] - slopes[j]) / 2) ** 2)
    return float(s), float(share[i] * sensitivity * share[j])
