"""Where omega = per_rev gamma: a force of per_rev periods per revolution excites the mode."""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from beamviz.frequency_loci.branches import LabelledTrack
from beamviz.frequency_loci.events.record import Event, EventKind, Field, Tracked, is_asked_for
from beamviz.frequency_loci.limits import Limit, not_located
from beamviz.frequency_loci.path import ParameterPath
from beamviz.frequency_loci.roots import find_roots

SAME = 1e-9  # of 1 + omega^2: distance from a line below which a locus lies on it


def resonances(tracked: Tracked) -> Iterator[Event | Limit]:
    """The resonances with the multiples 1 .. per_rev of the speed, over gamma."""
    if tracked.per_rev and tracked.path.over == "gamma":
        multiples = np.arange(1, tracked.per_rev + 1)
        for part in tracked.parts:
            yield from _resonances_of(tracked.path, part, multiples)


def _resonances_of(
    path: ParameterPath, part: LabelledTrack, multiples: NDArray
) -> Iterator[Event | Limit]:
    """The resonances with some multiples of the speed. Each pair of a multiple and a mode is a
    function, number (index of the multiple) x modes + mode. A locus that lies on a line has one
    resonance all along: out of the plane of rotation a hinged beam on the axis vibrates with the
    frequency gamma at every speed."""
    modes = part.track.modes
    n, families, count = modes.s.shape
    size = families * count  # number of modes
    lines = (multiples * modes.at[:, None]) ** 2  # (n, multiples) omega^2 on each line
    above = modes.omega_squared.reshape(n, 1, size) - lines[..., None]  # (n, multiples, modes)
    asked = is_asked_for(modes.rank, path.problem.modes).reshape(n, 1, size)
    touches = asked & (abs(above) <= SAME * (1 + lines[..., None]))
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

    sought = np.where(asked & ~lies_on_line, above, np.nan)
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
    part: LabelledTrack, multiples: NDArray, lies_on_line: NDArray
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


RESONANCE = EventKind(
    name="resonance",
    meaning="a multiple of the speed equals a frequency",
    sign="×",
    marker="x",
    filled=False,
    locate=resonances,
    fields=(Field("per_rev"),),
    on_request=True,
)
