"""From where on another stable deflected state exists; its lowest branch is "B1 (state 2)"."""

from collections.abc import Iterator
from contextlib import suppress

import numpy as np

from beamviz.errors import NotConverged
from beamviz.frequency_loci.events.record import Event, EventKind, Tracked
from beamviz.solver.bent import end_of_bent_state, other_stable_states
from beamviz.solver.solution import Solution

SOUGHT = 4  # number of values at which second states are searched for


def second_states(tracked: Tracked) -> Iterator[Event]:
    """The limit point, or else the first value, of the first other stable deflected state that is
    met with."""
    path, values = tracked.path, tracked.grid.tolist()
    if path.is_straight:
        return
    for k in np.unique(np.linspace(0, len(values) - 1, SOUGHT).astype(int)):
        first = path.outcomes[values[k]]
        if not isinstance(first, Solution):
            continue
        for second in other_stable_states(first)[:1]:
            end = None
            with suppress(NotConverged):
                end = end_of_bent_state(second, path.over, values[0])
            at = values[0] if end is None else end
            labels = first.labels[0], f"{second.labels[0]} (state 2)"
            yield Event("second state", labels, at, (None, float(second.frequencies[0])), (0, 0))
            return


SECOND_STATE = EventKind(
    name="second state",
    meaning="another stable deflected state begins there",
    sign="□",
    marker="s",
    filled=False,
    locate=second_states,
    of_single_state=False,
)
