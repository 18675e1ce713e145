"""Where two loci cross: bending and stretching, which are not coupled, at a root of the difference
of their omega^2; modes of one family where their coupling vanishes (Perkins & Mote, J. Sound Vib.
106, 1986)."""

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from beamviz.frequency_loci.branches import LabelledTrack
from beamviz.frequency_loci.events.record import Event, EventKind, Tracked, is_asked_for
from beamviz.frequency_loci.limits import Limit, not_located
from beamviz.frequency_loci.path import ParameterPath
from beamviz.frequency_loci.roots import find_roots


def crossings(tracked: Tracked) -> Iterator[Event | Limit]:
    """The crossings of modes of one family, and of a bending and a stretching mode."""
    for part in tracked.parts:
        for lower, upper, at, frequency, modes in part.exchanges:
            if modes[0] < tracked.path.problem.modes:  # others are located for their labels
                labels = part.labels_of((lower, upper), at)
                yield Event("crossing", labels, at, (frequency, frequency), modes)
        if not tracked.path.is_coupled:
            yield from _crossings_of_families(tracked.path, part)


def _crossings_of_families(path: ParameterPath, part: LabelledTrack) -> Iterator[Event | Limit]:
    """The crossings of a bending and a stretching locus. Each pair of modes k and l of the two
    families is a function, number k count + l."""
    modes = part.track.modes
    squares, (n, _, count) = modes.omega_squared, modes.s.shape
    difference = squares[:, 0, :, None] - squares[:, 1, None, :]  # (n, count, count)

    def between(values: NDArray, pair: NDArray) -> NDArray:
        """The differences (n,) of omega^2 of pairs at values (n,)."""
        squares, row = path.modes(values).omega_squared, np.arange(len(values))
        return squares[row, 0, pair // count] - squares[row, 1, pair % count]

    asked = is_asked_for(modes.rank, path.problem.modes)
    either = asked[:, 0, :, None] | asked[:, 1, None, :]
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


CROSSING = EventKind(
    name="crossing",
    meaning="two loci cross: their modes are not coupled",
    sign="○",
    marker="o",
    filled=False,
    locate=crossings,
    exchanges_modes=True,
)
