"""What is declared once, where it is used: choices of the visitor, and tabs.

A `Choice` says all that undo, links, presenters and controls know of a choice. It is a field of a
record: of `State`, where several parts of the page share it, or of the `Slice` of a feature.
"""

from collections.abc import Callable, Collection
from dataclasses import dataclass, fields, replace
from typing import Any, Generic, Literal, NamedTuple, TypeVar

from beamviz.checks import check_choice, check_float, check_int
from beamviz.scene import check_bool

T = TypeVar("T")
R = TypeVar("R", bound=Any)  # a record
# What another state does to a choice: "changes" it to its own; "keeps" it as it is now; or "ends"
# it, so that it is as usual.
Effect = Literal["changes", "keeps", "ends"]
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

    record: type[Any]  # of which it is a field
    name: str  # of the field and of its controls (data-set="name"), unique in the page
    usual: T  # the value at first
    values: Collection[T] = ()  # that its controls choose from; () where its feature binds them
    key: Key | None = None  # in links; None where they do not have it
    # What undo and redo do: "keeps" for what is not about the scene, "ends" for what is under way.
    undo: Effect = "changes"
    # What a presenter's state does to that of a visitor who follows them.
    led: Effect = "changes"
    # Events that reset it to `usual`: names of choices that change, or those of EVENTS.
    until: tuple[str, ...] = ()

    def picked(self, value: object, present: T) -> T:
        """The one of `values` that a control sent, as itself or as text; `present` for another."""
        return {str(known): known for known in self.values}.get(str(value), present)

    @property
    def sent(self) -> type:
        """The type of what a control sends."""
        return bool if {*self.values} == {*SWITCH} else str


EVENTS = {  # after which choices are as usual
    "opened": "a scene from outside is opened, to which a reset returns",
    "scene": "another scene is loaded",
    "case": "a number of the beam or an option of the model is edited",
    "structure": "the same, but for the speed",
    "modes": "modes are chosen for the scene",
    "motion": "a motion in time is chosen for the scene",
    "viewpoint": "the camera is placed",
}


def choice(
    *,
    values: Collection[Any] = (),
    key: Key | None = None,
    undo: Effect = "changes",
    led: Effect = "changes",
    until: tuple[str, ...] = (),
) -> dict[str, Any]:
    """The metadata of a field that holds a choice: see `Choice`, whose name and usual value are the
    name and the default of the field."""
    return {"values": values, "key": key, "undo": undo, "led": led, "until": until}


KNOWN: dict[type[Any], dict[str, Choice[Any]]] = {}  # the choices of records


def choices_of(record: type[Any]) -> dict[str, Choice[Any]]:
    """The choices that fields of a record hold, by name."""
    if record not in KNOWN:
        KNOWN[record] = {
            entry.name: Choice(record, entry.name, entry.default, **entry.metadata)
            for entry in fields(record)
            if entry.metadata
        }
    return KNOWN[record]


def usual_after(record: type[Any], event: str) -> dict[str, Any]:
    """The values of those choices of a record that an event resets, by name."""
    choices = choices_of(record).values()
    return {choice.name: choice.usual for choice in choices if event in choice.until}


def under(own: R, other: R, effect: Callable[[Choice[Any]], Effect]) -> R:
    """A record with the values of another one, but for the choices to which that does something
    else; effect: what it does to a choice."""
    values = {}
    for name, choice in choices_of(type(own)).items():
        if effect(choice) != "changes":
            values[name] = getattr(own, name) if effect(choice) == "keeps" else choice.usual
    return replace(other, **values) if values else other


class Tab(NamedTuple):
    """A tab of the page."""

    name: str
    place: int  # tabs are in ascending order of their places
    help: str  # what it shows, and what can be done there: a sentence of the help
    content: str = ""  # HTML; a feature may replace it by `html("tab-<key>", ...)`
    waits_for: tuple[str, ...] = ()  # the jobs, in their order, that its first result takes
    # The name of the tab of which it is another view, in the place of that; "" for a tab alone.
    beside: str = ""
    view: str = ""  # what it is called as such
    is_aside: bool = False  # it is among the tabs only while it is open

    @property
    def key(self) -> str:
        """The key of the tab in links and in the ids of its elements."""
        return self.name.lower()
