"""What is declared once, where it is used: choices of the visitor, and tabs.

A `Choice` says all that undo, links and controls know of a choice. One that several parts of the
page share is a field of `State` (see `choice`); one of a feature is an entry of its `choices`.
"""

from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass, fields
from typing import Any, ClassVar, Generic, Literal, NamedTuple, TypeVar

from beamviz.checks import check_choice, check_float, check_int
from beamviz.scene import check_bool

T = TypeVar("T")
Undo = Literal["changes", "keeps", "ends"]
FIRST_TAB = "frequencies"  # key of the tab that is open at first
SWITCH = (False, True)  # the values of a choice that is on or off


@dataclass(frozen=True)
class Key:
    """The key under which links have a choice."""

    name: str
    read: Callable[[Any], Any]  # the choice for a value of TOML; raises InvalidInput
    write: Callable[[Any], Any] = lambda value: value  # the value, or its text, for a choice
    is_table: bool = False  # the value has entries, each of which is checked alone
    is_long: bool = False  # it is left out where the link would be too long


def switch_key(name: str) -> Key:
    """The key of a choice that is true or false."""
    return Key(name, lambda value: check_bool(name, value))


def name_key(name: str, values: Collection[str]) -> Key:
    """The key of one of some names."""
    return Key(name, lambda value: check_choice(name, value, values))


def number_key(name: str, low: float, high: float) -> Key:
    """The key of a number in low .. high."""
    return Key(name, lambda value: check_float(name, value, low, high))


def whole_key(name: str, low: int, high: int) -> Key:
    """The key of a whole number in low .. high."""
    return Key(name, lambda value: check_int(name, value, low, high))


def count_key(name: str, most: int) -> Key:
    """The key of an index from 0, which a link counts from 1, up to `most`."""
    return Key(name, lambda value: check_int(name, value, 1, most) - 1, lambda index: index + 1)


@dataclass(frozen=True, eq=False)
class Choice(Generic[T]):
    """A choice of the visitor."""

    name: str  # of its controls (data-set="name"), unique in the page
    usual: T  # the value at first
    values: Collection[T] = ()  # that its controls choose from; () where its feature binds them
    key: Key | None = None  # in links; None where they do not have it
    # What undo does: "changes" it; "keeps" it, where it is not about the scene; or "ends" it, where
    # it is under way.
    undo: Undo = "changes"
    # Names of fields of the state, or "scene": a change of one of them resets it to `usual`.
    until: tuple[str, ...] = ()

    def picked(self, value: object, present: T) -> T:
        """The one of `values` that a control sent, as itself or as text; `present` for another."""
        return {str(known): known for known in self.values}.get(str(value), present)

    @property
    def sent(self) -> type:
        """The type of what a control sends."""
        return bool if {*self.values} == {*SWITCH} else str


def choice(
    *, values: Collection[Any] = (), key: Key | None = None, undo: Undo = "changes"
) -> dict[str, Any]:
    """The metadata of a field that holds a choice: see `Choice`, whose name and usual value are the
    name and the default of the field."""
    return {"values": values, "key": key, "undo": undo}


def choices_of(record: type[Any]) -> dict[str, Choice[Any]]:
    """The choices that fields of a record hold, by name."""
    entries = (entry for entry in fields(record) if entry.metadata)
    return {entry.name: Choice(entry.name, entry.default, **entry.metadata) for entry in entries}


class Tab(NamedTuple):
    """A tab of the page."""

    name: str
    place: int  # tabs are in ascending order of their places
    content: str = ""  # HTML; a feature may replace it by `html("tab-<key>", ...)`
    waits_for: tuple[str, ...] = ()  # the jobs, in their order, that its first result takes

    @property
    def key(self) -> str:
        """The key of the tab in links and in the ids of its elements."""
        return self.name.lower()


class Declared:
    """What a feature declares. tab: None for one around the scene; choices: those that belong to
    the feature alone."""

    tab: ClassVar[Tab | None] = None
    choices: ClassVar[tuple[Choice[Any], ...]] = ()


def tabs(features: Iterable[type[Declared]]) -> dict[str, Tab]:
    """The tabs of features by key, in their order."""
    declared = (kind.tab for kind in features if kind.tab)
    return {tab.key: tab for tab in sorted(declared, key=lambda tab: tab.place)}
