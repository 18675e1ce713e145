"""The parts of loci that tables and charts use: these are below the results that call them, and do
not import them."""

from collections.abc import Sequence
from typing import Any, Protocol, Self

from numpy.typing import NDArray

from beamviz.beam import Beam, Units


class Branch(Protocol):
    """A locus: arrays (values,), nan or None where it has no solution."""

    @property
    def label(self) -> str: ...
    @property
    def frequency(self) -> NDArray: ...
    @property
    def family(self) -> Sequence[str | None]: ...
    @property
    def bending_fraction(self) -> NDArray: ...
    @property
    def mode_index(self) -> NDArray: ...


class Resonance(Protocol):
    """A frequency that is a multiple of the speed, at a value of the parameter."""

    @property
    def at(self) -> float: ...
    @property
    def frequency(self) -> float: ...


class Event(Protocol):
    """A crossing, a veering or another event of some branches at a value of the parameter."""

    @property
    def kind(self) -> str: ...
    @property
    def branches(self) -> Sequence[str]: ...
    @property
    def at(self) -> float: ...
    @property
    def frequency(self) -> float: ...
    @property
    def gap(self) -> float: ...
    @property
    def index(self) -> Any: ...


class Limit(Protocol):
    """A range of the parameter without a stable equilibrium."""

    @property
    def kind(self) -> str: ...
    @property
    def start(self) -> float: ...
    @property
    def stop(self) -> float: ...


class Problem(Protocol):
    """The model."""

    @property
    def described(self) -> str: ...


class Loci(Protocol):
    """Frequencies of a beam along one parameter."""

    @property
    def beam(self) -> Beam: ...
    @property
    def problem(self) -> Problem: ...
    @property
    def over(self) -> str: ...
    @property
    def values(self) -> NDArray: ...
    @property
    def units(self) -> Units | None: ...
    @property
    def branches(self) -> Sequence[Branch]: ...
    @property
    def events(self) -> Sequence[Event]: ...
    @property
    def limits(self) -> Sequence[Limit]: ...
    def close_up(self, event: Any) -> Self: ...
