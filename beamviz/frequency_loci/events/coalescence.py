"""Where two frequencies merge and one of the two vibrations begins to grow (flutter): there
(s_a^2 - s_b^2)^2, which is real, changes its sign. Uncoupled modes do not merge: theirs is never
negative."""

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from beamviz.errors import NotConverged
from beamviz.frequency_loci.branches import LabelledTrack
from beamviz.frequency_loci.events.record import Event, EventKind, Tracked
from beamviz.frequency_loci.limits import Limit, not_located
from beamviz.frequency_loci.path import ParameterPath


def coalescences(tracked: Tracked) -> Iterator[Event | Limit]:
    """The points at which two neighbouring modes merge."""
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


def _coalescence(
    path: ParameterPath, part: LabelledTrack, k: int, low: float, high: float
) -> Event | Limit:
    """The point between two values where modes k and k + 1 merge; or that range, where a value in
    it has no solution."""

    def difference(value: float) -> float:
        pair = path.modes(np.array([value])).s[:, 0, k : k + 2]
        squared = float(_squared_difference(pair)[0])
        if math.isnan(squared):
            raise NotConverged(f"{path.over} = {value:g}: no solution")
        return squared

    try:
        at = brentq(difference, low, high, rtol=1e-9)
    except NotConverged:
        return not_located("coalescence", path.over, low, high)
    frequency = float(path.modes(np.array([at])).s[0, 0, k : k + 2].imag.mean())
    labels = part.labels_of(((0, k), (0, k + 1)), at)
    return Event("coalescence", labels, at, (frequency, frequency), (k, k + 1))


COALESCENCE = EventKind(
    name="coalescence",
    meaning="two frequencies merge: beyond it one of the two vibrations grows (flutter)",
    sign="★",
    marker="*",
    filled=True,
    locate=coalescences,
)
