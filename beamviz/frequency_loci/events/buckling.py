"""Where the straight state loses its stability and a deflected one takes its place: there its
lowest omega^2 vanishes."""

from collections.abc import Iterator
from contextlib import suppress
from itertools import pairwise

import numpy as np
from scipy.optimize import brentq

from beamviz.errors import BeamvizError
from beamviz.frequency_loci.events.record import Event, EventKind, Tracked
from beamviz.solver import solve
from beamviz.solver.solution import Solution

PRECISION = 1e-9  # relative, of a buckling point


def bucklings(tracked: Tracked) -> Iterator[Event]:
    """The points between a straight and a deflected state."""
    path = tracked.path
    if path.is_straight:
        return
    options = path.problem.options | {"state": "straight", "coriolis": False, "modes": 1}

    def lowest(value: float) -> float:
        """omega^2 of the straight state, nearer to a straight line: that may be -1e9."""
        return float(np.arcsinh(solve(path.at(value), **options).omega_squared[0]))

    outcomes = zip(tracked.grid.tolist(), path.solve(tracked.grid), strict=True)
    for (low, before), (high, after) in pairwise(outcomes):
        if not (isinstance(before, Solution) and isinstance(after, Solution)):
            continue
        if before.equilibrium.shape == after.equilibrium.shape:
            continue
        # With a spin-up there is no straight state, nor is there one beyond a limit.
        with suppress(BeamvizError, ValueError):
            at = brentq(lowest, low, high, xtol=PRECISION * (high - low), rtol=PRECISION)
            labels = before.labels[0], after.labels[0]
            yield Event("buckling", labels, float(at), (0.0, 0.0), (0, 0))


BUCKLING = EventKind(
    name="buckling",
    meaning="the straight beam loses its stability and bends",
    sign="▽",
    marker="v",
    filled=False,
    locate=bucklings,
    of_single_state=False,
)
