"""Where two loci come close, turn away and exchange their shapes."""

from collections.abc import Iterator

from beamviz.frequency_loci.events.least_gaps import GAP_FIELDS, event_at, is_veering, least_gaps
from beamviz.frequency_loci.events.record import Event, EventKind, Tracked
from beamviz.frequency_loci.limits import Limit, not_located


def veerings(tracked: Tracked) -> Iterator[Event | Limit]:
    """The veerings, and the ranges of least gaps that could not be located."""
    for part in tracked.parts:
        for low, high in part.unlocated:
            yield not_located("least gap", tracked.path.over, low, high)
        for gap in least_gaps(part):
            if is_veering(gap) and gap.least.ranks[0] < tracked.path.problem.modes:
                yield event_at(gap, "veering", part)


VEERING = EventKind(
    name="veering",
    meaning="two loci come close, turn away and exchange their shapes",
    sign="◆",
    marker="D",
    filled=True,
    locate=veerings,
    fields=GAP_FIELDS,
    exchanges_modes=True,
)
