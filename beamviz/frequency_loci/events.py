"""Events of loci: where two loci cross, veer or merge, where a state ends, where a force resonates.

A kind of event is one record of EVENT_KINDS: what it means, its mark in charts, and the function
that locates it. A new kind is a function and a record here.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from beamviz.errors import NotConverged
from beamviz.frequency_loci import equilibria
from beamviz.frequency_loci.branches import Part
from beamviz.frequency_loci.limits import Limit, not_located
from beamviz.frequency_loci.path import Path
from beamviz.frequency_loci.roots import find_roots

SAME = 1e-9  # of 1 + omega^2: distance from a line below which a locus lies on it
# Which least gap is a veering. Loci may also come close and turn away by chance, as those of modes
# that a moving mass slows one after the other, without any exchange. The veering index of du Bois,
# Adhikari & Lieven (Proc. R. Soc. A 467, 2011) is 1 where at the gap two modes rotate into each
# other and no third one does, and their difference comes from their coupling alone; 0 where nothing
# rotates, as at a crossing. Beside it the rotation of the shapes that the chart shows, of which 90
# degrees are a complete exchange (Perkins & Mote, J. Sound Vib. 106, 1986): a veering at its end is
# not finished there. Of 2423 least gaps in 1000 charts of random beams 98 % have an index above 0.9
# or below 0.2 and only 12 one of 0.3 .. 0.7; 30 have a rotation of 20 .. 40 degrees: other limits
# there would change few answers.
MIN_INDEX = 0.5
ROTATED = math.radians(30)


@dataclass(frozen=True)
class Event:
    """An event of the branches with these labels, at a value of the parameter, or all along a range
    of it."""

    kind: str  # a key of EVENT_KINDS
    branches: tuple[str, ...]
    at: float  # of a range: its first value
    frequencies: tuple[float | None, ...]  # of each branch at this value; None where not known
    modes: tuple[int, ...]  # indices of these modes by frequency, from 0
    until: float | None = None  # of a range: its last value
    # Of a veering or a close approach:
    gap: float = 0.0  # the least
    coupling: float = 0.0  # s_ab = phi_a' (K' - lambda M') phi_b, lambda their mean
    index: float = 0.0  # veering index MDF_ab CSQ_ab MDF_ba, 0 .. 1
    width: float = 0.0  # distance at which the gap is sqrt(2) times the least
    per_rev: int = 0  # of a resonance: periods of the force per revolution

    @property
    def frequency(self) -> float:
        """The mean of the frequencies that are known."""
        known = [frequency for frequency in self.frequencies if frequency is not None]
        return math.fsum(known) / len(known)

    @property
    def frequency_until(self) -> float | None:
        """Of a range, which is one of resonance: the frequency at its last value."""
        return None if self.until is None else self.per_rev * self.until

    @property
    def name(self) -> str:
        """The kind; of a resonance with the multiple of the speed, as "resonance 2x"."""
        return f"{self.kind} {self.per_rev}x" if self.per_rev else self.kind

    @property
    def mark(self) -> tuple[str, bool]:
        """The marker in charts, and whether it is filled."""
        return EVENT_KINDS[self.kind].marker, EVENT_KINDS[self.kind].filled

    @property
    def jumps(self) -> bool:
        """Whether all loci end there, or jump to another state."""
        return EVENT_KINDS[self.kind].jumps

    @property
    def record(self) -> dict[str, Any]:
        """What files and tables have of it, by EVENT_COLUMNS."""
        return {name: getattr(self, name) for name in EVENT_COLUMNS}


EVENT_COLUMNS = (
    "kind",
    "branches",
    "at",
    "until",
    "frequency",
    "gap",
    "coupling",
    "index",
    "width",
    "per_rev",
)


class Tracked(NamedTuple):
    """The loci that events are located in, on the grid of the chart.

    parts: between limits of equilibrium, ascending. per_rev: number of the multiples of the speed
    whose resonances are sought.
    """

    path: Path
    grid: NDArray  # values (n,)
    parts: tuple[Part, ...]
    per_rev: int = 0


class EventKind(NamedTuple):
    """A kind of event.

    meaning: a sentence for readers. sign: its mark in the charts and lists of the page, a
    character. marker, filled: the same mark in pictures, as matplotlib names it. locate: the events
    of this kind, in any order, and the ranges of those that could not be located. jumps: whether
    all loci end there, or jump to another state; the first branch of the event is before, the
    second after it.
    """

    meaning: str
    sign: str
    marker: str
    filled: bool
    locate: Callable[[Tracked], Iterator[Event | Limit]]
    jumps: bool = False


def locate_events(tracked: Tracked) -> tuple[tuple[Event, ...], list[Limit]]:
    """The events of all kinds, by ascending value of the parameter, and the ranges of those that
    could not be located."""
    found = [each for kind in EVENT_KINDS.values() for each in kind.locate(tracked)]
    events = [event for event in found if isinstance(event, Event)]
    unlocated = [limit for limit in found if isinstance(limit, Limit)]
    return tuple(sorted(events, key=lambda event: event.at)), unlocated


def crossings(tracked: Tracked) -> Iterator[Event | Limit]:
    """Where two loci cross: bending and stretching, which are not coupled, at a root of the
    difference of their omega^2; modes of one family where their coupling vanishes (Perkins & Mote
    1986)."""
    for part in tracked.parts:
        for lower, upper, at, frequency, modes in part.exchanges:
            if modes[0] >= tracked.path.problem.modes:
                continue
            labels = part.labels_of((lower, upper), at)
            yield Event("crossing", labels, at, (frequency, frequency), modes)
        if not tracked.path.is_coupled:
            yield from _crossings_of_families(tracked.path, part)


def _crossings_of_families(path: Path, part: Part) -> Iterator[Event | Limit]:
    """The crossings of a bending and a stretching locus. Each pair of modes k and l of the two
    families is a function, number k count + l."""
    modes = part.track.modes
    squares, (n, _, count) = modes.omega_squared, modes.s.shape
    difference = squares[:, 0, :, None] - squares[:, 1, None, :]  # (n, count, count)

    def between(values: NDArray, pair: NDArray) -> NDArray:
        """The differences (n,) of omega^2 of pairs at values (n,)."""
        squares, row = path.modes(values).omega_squared, np.arange(len(values))
        return squares[row, 0, pair // count] - squares[row, 1, pair % count]

    shown = _is_shown(modes.rank, path.problem.modes)
    either = shown[:, 0, :, None] | shown[:, 1, None, :]
    roots = find_roots(modes.at, np.where(either, difference, np.nan).reshape(n, -1), between)
    for bracket in roots.unlocated:
        yield not_located("crossing", path.over, bracket.low, bracket.high)
    solved = path.modes(roots.at)
    for i, at in enumerate(roots.at.tolist()):
        k, l = divmod(int(roots.channel[i]), count)
        square = solved.omega_squared[i, [0, 1], [k, l]].mean()
        lower, upper = np.sort(solved.rank[i, [0, 1], [k, l]]).tolist()
        if lower < path.problem.modes and square >= 0:
            bending, stretching = (0, k), (1, l)
            lower_first = (bending, stretching) if roots.rises[i] else (stretching, bending)
            labels = part.labels_of(lower_first, at)
            yield Event("crossing", labels, at, (math.sqrt(square),) * 2, (lower, upper))


def _is_shown(rank: NDArray, modes: int) -> NDArray:
    """Whether each mode (n, families, k) is a requested one here or at a neighbouring value."""
    shown = np.asarray(rank < modes)
    wider = shown.copy()
    wider[1:] |= shown[:-1]
    wider[:-1] |= shown[1:]
    return wider


def veerings(tracked: Tracked) -> Iterator[Event | Limit]:
    """Where two loci come close, turn away and exchange their shapes."""
    for part in tracked.parts:
        for low, high in part.unlocated:
            yield not_located("least gap", tracked.path.over, low, high)
        for event in _least_gaps("veering", part):
            if event.modes[0] < tracked.path.problem.modes:
                yield event


def close_approaches(tracked: Tracked) -> Iterator[Event | Limit]:
    """Where two loci come close and turn away, and each mode keeps its shape, or exchanges it in
    part; of the modes asked for, as nothing happens to one that comes close to a hidden one."""
    for part in tracked.parts:
        for event in _least_gaps("close approach", part):
            if event.modes[1] < tracked.path.problem.modes:
                yield event


def _least_gaps(kind: str, part: Part) -> Iterator[Event]:
    """The least gaps of this kind; none of which too little is known."""
    for avoided in part.avoided_crossings:
        least, index = avoided.least, avoided.veering_index
        veers = index >= MIN_INDEX and avoided.rotation >= ROTATED
        if (
            least.gap
            and not math.isnan(index)
            and kind == ("veering" if veers else "close approach")
        ):
            pair = (avoided.family, avoided.k), (avoided.family, avoided.k + 1)
            yield Event(
                kind,
                part.labels_of(pair, least.at),
                least.at,
                (least.frequency - least.gap / 2, least.frequency + least.gap / 2),
                least.ranks,
                gap=least.gap,
                coupling=avoided.coupling,
                index=index,
                width=least.width,
            )


def coalescences(tracked: Tracked) -> Iterator[Event | Limit]:
    """Where two frequencies merge and one of the two vibrations begins to grow (flutter): there
    (s_a^2 - s_b^2)^2, which is real, changes its sign. Uncoupled modes do not merge: theirs is
    never negative."""
    for part in tracked.parts:
        modes = part.track.modes
        vibrating = np.asarray(modes.s.imag > 0)
        for k in range(modes.s.shape[2] - 1):
            difference = _squared_difference(modes.s[:, 0, k : k + 2])
            valid = vibrating[:, 0, k] & vibrating[:, 0, k + 1]
            changes = valid[:-1] & valid[1:] & (difference[:-1] * difference[1:] < 0)
            for i in np.flatnonzero(changes).tolist():
                yield _coalescence(tracked.path, part, k, *modes.at[i : i + 2].tolist())


def _squared_difference(s: NDArray) -> NDArray:
    """(s_a^2 - s_b^2)^2 (n,) of pairs (n, 2): negative for a pair that grows and decays."""
    return ((s[:, 0] ** 2 - s[:, 1] ** 2) ** 2).real


def _coalescence(path: Path, part: Part, k: int, low: float, high: float) -> Event | Limit:
    """The point between two values where modes k and k + 1 merge; or that range, where a value in
    it has no solution."""

    def difference(value: float) -> float:
        pair = path.modes(np.array([value])).s[:, 0, k : k + 2]
        found = float(_squared_difference(pair)[0])
        if math.isnan(found):
            raise NotConverged(f"{path.over} = {value:g}: no solution")
        return found

    try:
        at = brentq(difference, low, high, rtol=1e-9)
    except NotConverged:
        return not_located("coalescence", path.over, low, high)
    frequency = float(path.modes(np.array([at])).s[0, 0, k : k + 2].imag.mean())
    labels = part.labels_of(((0, k), (0, k + 1)), at)
    return Event("coalescence", labels, at, (frequency, frequency), (k, k + 1))


def resonances(tracked: Tracked) -> Iterator[Event | Limit]:
    """Where omega = per_rev gamma: a force of per_rev periods per revolution excites the mode."""
    if tracked.per_rev and tracked.path.over == "gamma":
        multiples = np.arange(1, tracked.per_rev + 1)
        for part in tracked.parts:
            yield from _resonances_of(tracked.path, part, multiples)


def _resonances_of(path: Path, part: Part, multiples: NDArray) -> Iterator[Event | Limit]:
    """The resonances with some multiples of the speed. Each pair of a multiple and a mode is a
    function, number (index of the multiple) x modes + mode. A locus that lies on a line has one
    resonance all along: out of the plane of rotation a hinged beam on the axis vibrates with the
    frequency gamma at every speed."""
    modes = part.track.modes
    n, families, count = modes.s.shape
    size = families * count  # number of modes
    lines = (multiples * modes.at[:, None]) ** 2  # (n, multiples) omega^2 on each line
    above = modes.omega_squared.reshape(n, 1, size) - lines[..., None]  # (n, multiples, modes)
    shown = _is_shown(modes.rank, path.problem.modes).reshape(n, 1, size)
    touches = shown & (abs(above) <= SAME * (1 + lines[..., None]))
    stays = touches[1:] & touches[:-1]  # from one value to the next
    lies_on_line = np.zeros_like(touches)
    lies_on_line[1:] |= stays
    lies_on_line[:-1] |= stays
    yield from _resonances_all_along(part, multiples, lies_on_line)

    def above_line(values: NDArray, pair: NDArray) -> NDArray:
        """omega^2 (n,) above that on a line, of pairs at values (n,)."""
        squares = path.modes(values).omega_squared.reshape(len(values), size)
        frequency = multiples[pair // size] * values
        return squares[np.arange(len(values)), pair % size] - frequency**2

    sought = np.where(shown & ~lies_on_line, above, np.nan)
    roots = find_roots(modes.at, sought.reshape(n, -1), above_line)
    for bracket in roots.unlocated:
        yield not_located("resonance", path.over, bracket.low, bracket.high)
    ranks = path.modes(roots.at).rank.reshape(-1, size)
    for at, pair, rank in zip(roots.at.tolist(), roots.channel.tolist(), ranks, strict=True):
        index, mode = divmod(pair, size)
        if rank[mode] < path.problem.modes:
            labels, per_rev = part.labels_of((divmod(mode, count),), at), int(multiples[index])
            place = at, (per_rev * at,), (int(rank[mode]),)
            yield Event("resonance", labels, *place, per_rev=per_rev)


def _resonances_all_along(
    part: Part, multiples: NDArray, lies_on_line: NDArray
) -> Iterator[Event | Limit]:
    """The resonances of loci that lie on a line, one for each range of values of the grid.
    lies_on_line: (n, multiples, modes) for modes by family."""
    modes = part.track.modes
    numbers = part.numbers(modes.at)  # (n, modes) of their branches
    for index, per_rev in enumerate(multiples.tolist()):
        for number, label in part.labels.items():
            row, mode = (lies_on_line[:, index] & (numbers == number)).nonzero()
            ends = np.flatnonzero(np.diff(row, prepend=-2, append=-2) != 1)
            for first, end in pairwise(ends.tolist()):
                at, until = modes.at[row[[first, end - 1]]].tolist()
                rank = int(modes.rank.reshape(len(modes.at), -1)[row[first], mode[first]])
                place = at, (per_rev * at,), (rank,)
                yield Event("resonance", (label,), *place, until=until, per_rev=per_rev)


def bucklings(tracked: Tracked) -> Iterator[Event]:
    """Where the straight state loses its stability and a deflected one takes its place."""
    for at, before, after, _ in equilibria.bucklings(tracked.path, tracked.grid):
        yield Event("buckling", (before.labels[0], after.labels[0]), at, (0.0, 0.0), (0, 0))


def limit_points(tracked: Tracked) -> Iterator[Event]:
    """Where a deflected state ends; the branches end too, or continue on another state."""
    for at, before, after, ended in equilibria.limit_points(tracked.path, tracked.grid):
        states = before, after
        frequencies = tuple(0.0 if state is ended else None for state in states)
        labels = before.labels[0], after.labels[0]
        yield Event("limit point", labels, at, frequencies, (0, 0))


def second_states(tracked: Tracked) -> Iterator[Event]:
    """From where on another stable deflected state exists; its lowest branch is "B1 (state 2)"."""
    for at, first, second, _ in equilibria.second_states(tracked.path, tracked.grid):
        labels = first.labels[0], f"{second.labels[0]} (state 2)"
        yield Event("second state", labels, at, (None, float(second.frequencies[0])), (0, 0))


EVENT_KINDS = {
    "crossing": EventKind(
        meaning="two loci cross: their modes are not coupled",
        sign="○",
        marker="o",
        filled=False,
        locate=crossings,
    ),
    "veering": EventKind(
        meaning="two loci come close, turn away and exchange their shapes",
        sign="◆",
        marker="D",
        filled=True,
        locate=veerings,
    ),
    "close approach": EventKind(
        meaning="two loci come close and turn away, but do not exchange their shapes",
        sign="◇",
        marker="D",
        filled=False,
        locate=close_approaches,
    ),
    "coalescence": EventKind(
        meaning="two frequencies merge: beyond it one of the two vibrations grows (flutter)",
        sign="★",
        marker="*",
        filled=True,
        locate=coalescences,
    ),
    "buckling": EventKind(
        meaning="the straight beam loses its stability and bends",
        sign="▽",
        marker="v",
        filled=False,
        locate=bucklings,
    ),
    "limit point": EventKind(
        meaning="a deflected state ends there",
        sign="△",
        marker="^",
        filled=False,
        locate=limit_points,
        jumps=True,
    ),
    "second state": EventKind(
        meaning="another stable deflected state begins there",
        sign="□",
        marker="s",
        filled=False,
        locate=second_states,
    ),
    "resonance": EventKind(
        meaning="a multiple of the speed equals a frequency",
        sign="×",
        marker="x",
        filled=False,
        locate=resonances,
    ),
}
