"""Events of loci: where two loci cross, veer or merge, where a state ends, where a force resonates.

A kind of event is one module with an EventKind: a new kind is such a module and its name in KINDS,
and a row in assets/reference.md. Charts, tables, files and the page have all kinds from there.
"""

from collections.abc import Collection
from typing import Any

from beamviz.checks import check_choice
from beamviz.errors import InvalidInput
from beamviz.frequency_loci.events.buckling import BUCKLING
from beamviz.frequency_loci.events.close_approach import CLOSE_APPROACH
from beamviz.frequency_loci.events.coalescence import COALESCENCE
from beamviz.frequency_loci.events.crossing import CROSSING
from beamviz.frequency_loci.events.limit_point import LIMIT_POINT
from beamviz.frequency_loci.events.record import Event, EventKind, Tracked
from beamviz.frequency_loci.events.resonance import RESONANCE
from beamviz.frequency_loci.events.second_state import SECOND_STATE
from beamviz.frequency_loci.events.veering import VEERING
from beamviz.frequency_loci.limits import Limit

KINDS = (  # in the order of tables and keys
    CROSSING,
    VEERING,
    CLOSE_APPROACH,
    COALESCENCE,
    BUCKLING,
    LIMIT_POINT,
    SECOND_STATE,
    RESONANCE,
)
EVENT_KINDS = {kind.name: kind for kind in KINDS}
EXCHANGES = tuple(kind.name for kind in KINDS if kind.exchanges_modes)
FIELDS = {field.name: field for kind in KINDS for field in kind.fields}
EVENT_COLUMNS = ("kind", "branches", "at", "until", "frequency", "gap", *FIELDS)


def record_of(event: Event) -> dict[str, Any]:
    """The columns of an event in files and tables, by EVENT_COLUMNS; 0 for a number that its kind
    has not."""
    return {name: getattr(event, name, 0.0) for name in EVENT_COLUMNS}


def checked_kinds(kinds: Collection[str] | None, per_rev: int) -> tuple[EventKind, ...]:
    """The kinds of these names, by default all but those on request; resonances where multiples of
    the speed are asked for. Raises InvalidInput for an unknown name, which lists the names, and for
    resonances without multiples."""
    if kinds is None:
        kinds = [kind.name for kind in KINDS if not kind.on_request]
    names = {check_choice("kind", name, EVENT_KINDS) for name in kinds}
    if RESONANCE.name in names and not per_rev:
        raise InvalidInput("kind resonance: needs per_rev = 1 or more (--per-rev)")
    if per_rev:
        names.add(RESONANCE.name)
    return tuple(kind for kind in KINDS if kind.name in names)


def locate_events(
    tracked: Tracked, kinds: Collection[EventKind]
) -> tuple[tuple[Event, ...], list[Limit]]:
    """The events of some kinds, by ascending value of the parameter, and the ranges of those that
    could not be located."""
    located = [each for kind in kinds for each in kind.locate(tracked)]
    events = [event for event in located if isinstance(event, Event)]
    unlocated = [limit for limit in located if isinstance(limit, Limit)]
    return tuple(sorted(events, key=lambda event: event.at)), unlocated
