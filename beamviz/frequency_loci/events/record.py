"""An event of loci, and what a kind of event declares."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from beamviz.frequency_loci.branches import LabelledTrack
from beamviz.frequency_loci.limits import Limit
from beamviz.frequency_loci.path import ParameterPath


@dataclass(frozen=True)
class Event:
    """An event of the branches with these labels, at a value of the parameter, or all along a range
    of it. A new kind whose events have further numbers derives its record from this."""

    kind: str  # the name of an EventKind
    branches: tuple[str, ...]
    at: float  # of a range: its first value
    frequencies: tuple[float | None, ...]  # of each branch at this value; None where not known
    modes: tuple[int, ...]  # indices of these modes by frequency, from 0
    until: float | None = None  # of a range: its last value
    # Of a least gap of two loci:
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


class Tracked(NamedTuple):
    """The loci that events are located in, on the grid of the chart."""

    path: ParameterPath
    grid: NDArray  # (n,) values
    parts: tuple[LabelledTrack, ...]  # between limits of equilibrium, ascending
    per_rev: int = 0  # number of the multiples of the speed whose resonances are asked for


class Field(NamedTuple):
    """A number that the events of a kind have beside those of all events."""

    name: str  # the attribute of the record, the key in JSON and the column in CSV
    heading: str = ""  # of its column in tables for readers; without it these leave it out
    form: str = "{:.3f}"  # how these write the number


@dataclass(frozen=True, kw_only=True)
class EventKind:
    """A kind of event: what charts, tables and files have of it."""

    name: str
    meaning: str  # a sentence for readers
    sign: str  # its mark in charts and lists of the page, a character
    marker: str  # the same mark in pictures, as matplotlib names it
    filled: bool  # whether this is filled
    # The events of this kind, in any order, and the ranges of those that could not be located.
    locate: Callable[[Tracked], Iterator[Event | Limit]]
    fields: tuple[Field, ...] = ()
    plural: str = ""  # the name with an s where none is given
    on_request: bool = False  # whether `loci` looks for it only where it is named
    # Whether two modes exchange their order or their shapes there. Such events are magnified on the
    # page, and a chart without any says so.
    exchanges_modes: bool = False
    # Whether its branches are modes of one state. Else they are the lowest modes of two states.
    of_single_state: bool = True
    # Whether all loci end there, or jump to another state: the first branch of the event is before,
    # the second after it.
    jumps: bool = False

    def counted(self, count: int) -> str:
        """A number of events of this kind: "1 crossing", "2 crossings"."""
        return f"{count} {self.name if count == 1 else self.plural or f'{self.name}s'}"


def is_asked_for(rank: NDArray, modes: int) -> NDArray:
    """Whether each mode (n, families, k), of this rank by frequency, is one of the modes asked for
    at its value or at a neighbouring one."""
    asked = np.asarray(rank < modes)
    wider = asked.copy()
    wider[1:] |= asked[:-1]
    wider[:-1] |= asked[1:]
    return wider
