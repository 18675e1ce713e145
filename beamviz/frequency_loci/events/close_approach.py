"""Where two loci come close and turn away, and each mode keeps its shape, or exchanges it in part;
of the modes asked for, as nothing happens to a mode that comes close to one that is not."""

from collections.abc import Iterator

from beamviz.frequency_loci.events.least_gaps import GAP_FIELDS, event_at, is_veering, least_gaps
from beamviz.frequency_loci.events.record import Event, EventKind, Tracked


def close_approaches(tracked: Tracked) -> Iterator[Event]:
    """The least gaps at which the shapes are not exchanged."""
    for part in tracked.parts:
        for gap in least_gaps(part):
            if not is_veering(gap) and gap.least.ranks[1] < tracked.path.problem.modes:
                yield event_at(gap, "close approach", part)


CLOSE_APPROACH = EventKind(
    name="close approach",
    meaning="two loci come close and turn away, but do not exchange their shapes",
    sign="◇",
    marker="D",
    filled=False,
    locate=close_approaches,
    fields=GAP_FIELDS,
    plural="close approaches",
)
