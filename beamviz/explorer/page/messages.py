"""Everything that travels between the server and the page, in both directions.

An update is checked against these types before it is sent. `messages.d.ts` has the same types for
the page's scripts, which TypeScript checks; `scripts/message_types.py` writes it.
"""

from typing import Any

import msgspec
from msgspec import UNSET, Struct, UnsetType

MAX_DIGITS = 15  # of an integer
Scalar = str | int | float | bool | None
Numbers = list[float | None]  # null: none there


class Message(Struct, forbid_unknown_fields=True):
    """A part of an update: what is not declared is refused, not left out."""


class Axis(Message):
    """An axis of a chart or a map."""

    label: str
    symbol: str
    unit: str  # "" for a dimensionless number
    range: tuple[float, float]
    log: bool = False  # logarithmic


class ChartLine(Message, omit_defaults=True):
    """A line of a chart."""

    label: str  # at its end, "" for none
    y: Numbers
    runs: list[tuple[int, int, str, str]]  # first point, last point, style and name of each part
    at: Numbers | UnsetType = UNSET  # x, where it is not that of the chart
    second: bool = False  # of a second beam
    dots: bool = False  # its points are marked


class Mark(Message, omit_defaults=True):
    """A mark of a chart, a sign; with an action it is a button that sends it with the value."""

    key: str
    kind: str
    sign: str
    style: str
    text: str
    x: float
    y: float
    action: str = ""
    value: Scalar = None


class KeyEntry(Message):
    """An entry of the key of a chart: a style of lines, or a sign of marks, and what it means."""

    style: str
    text: str
    sign: str = ""


class Cursor(Message, omit_defaults=True):
    """The place of the beam in a chart (x) or a map (x, y), and the action that moves it."""

    action: str
    x: float
    y: float | UnsetType = UNSET


class PerRev(Message):
    """Multiples of the speed, as lines of this slope times each."""

    slope: float
    multiples: list[int]


class Value(Message):
    """The quantity of a map."""

    symbol: str
    unit: str


class Region(Message):
    """The name of a region of a map, at a point."""

    x: float
    y: float
    text: str


class ChartUpdate(Message, omit_defaults=True):
    """A chart, or a map if it has `values`; what is not given stays."""

    name: str | UnsetType = UNSET  # accessible name
    message: str | UnsetType = UNSET  # why there are no lines
    x: Axis | UnsetType = UNSET
    y: Axis | UnsetType = UNSET
    at: Numbers | UnsetType = UNSET  # x of the lines
    lines: list[ChartLine] | UnsetType = UNSET
    keys: list[KeyEntry] | UnsetType = UNSET
    perRev: PerRev | UnsetType | None = UNSET
    gaps: list[tuple[float, float, str]] | UnsetType = UNSET  # of the x axis, without lines; text
    marks: list[Mark] | UnsetType = UNSET
    cursor: Cursor | UnsetType | None = UNSET  # at the beam shown
    chosen: str | UnsetType = UNSET  # the key of the mark at the beam shown
    columns: int | UnsetType = UNSET  # of a map
    values: Numbers | UnsetType = UNSET  # of a map, row by row from the bottom
    colours: list[tuple[int, int, int]] | UnsetType = UNSET  # from one end of `range` to the other
    range: tuple[float, float] | UnsetType = UNSET
    value: Value | UnsetType = UNSET
    borders: list[tuple[Numbers, Numbers]] | UnsetType = UNSET  # between regions: x, y
    regions: list[Region] | UnsetType = UNSET


class PlacedCaption(Message, omit_defaults=True):
    """A text at a node of the scene."""

    name: str
    text: str
    anchor: str  # the side of the text that is at the node
    hint: bool = False  # it is hidden where it would cover another text, and not in a picture


class Said(Message):
    """A text for screen readers; an error is also shown."""

    text: str
    error: bool


class Update(Message, omit_defaults=True):
    """A message to the page; what is not given stays."""

    bridge: str | UnsetType = UNSET  # id of the control that takes actions: a session begins
    handled: int | UnsetType = UNSET  # number of the last action whose effect is shown from now on
    html: dict[str, str] | UnsetType = UNSET  # contents of elements, by id
    values: dict[str, Scalar | list[float]] | UnsetType = UNSET  # shown by controls, by key
    props: dict[str, dict[str, Scalar]] | UnsetType = UNSET  # attributes, by key or id
    charts: dict[str, ChartUpdate] | UnsetType = UNSET  # by the id of their element
    captions: list[PlacedCaption] | UnsetType = UNSET  # over the scene
    open: str | UnsetType = UNSET  # the open tab
    point: list[str] | UnsetType = UNSET  # controls to highlight
    focus: str | UnsetType = UNSET  # id of the field that gets the focus
    dark: bool | UnsetType = UNSET  # the theme
    address: str | UnsetType = UNSET  # the query of the page's address
    met: list[str] | UnsetType = UNSET  # lessons whose challenge is met, for the browser to keep
    answers: list[str] | UnsetType = UNSET  # to questions of lessons, for the browser to keep
    used: list[str] | UnsetType = UNSET  # what was taken in the hand, for the browser to keep
    say: list[Said] | UnsetType = UNSET  # announcements
    ready: bool | UnsetType = UNSET  # all actions have handlers


Action = tuple[int, str, Scalar]  # its number, which grows, the name and the value
ACTIONS = msgspec.json.Decoder(Action)


def encode_update(update: dict[str, Any]) -> str:
    """A message as JSON. Raises msgspec.ValidationError if it has not the declared types."""
    return msgspec.json.encode(msgspec.convert(update, Update)).decode()


def decode_action(text: str) -> Action:
    """An action; an integer of more than MAX_DIGITS digits becomes a float. Raises
    msgspec.MsgspecError."""
    number, name, value = ACTIONS.decode(text)
    if isinstance(value, int) and abs(value) >= 10**MAX_DIGITS:
        value = float(str(value))
    return number, name, value
