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
    """An axis of a chart or a map. unit: "" for a dimensionless number; log: logarithmic."""

    label: str
    symbol: str
    unit: str
    range: tuple[float, float]
    log: bool = False


class Line(Message, omit_defaults=True):
    """A line of a chart in runs [first point, last point, style, name]. label: at its end, "" for
    none; at: its own x, else that of the chart; second: of another beam; dots: marked points."""

    label: str
    y: Numbers
    runs: list[tuple[int, int, str, str]]
    at: Numbers | UnsetType = UNSET
    second: bool = False
    dots: bool = False


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


class Key(Message):
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


class Chart(Message, omit_defaults=True):
    """A chart, or a map if it has `values`; what is not given stays.

    name: accessible name; message: why there are no lines; x, y: axes; at: x of the lines; keys: of
    lines and marks; gaps: parts of the x axis without lines, with a text; cursor: the beam shown;
    chosen: the key of the mark at the beam; columns, values: of a map, row by row from the bottom;
    colours: from the smallest to the largest of `range`; borders: between regions.
    """

    name: str | UnsetType = UNSET
    message: str | UnsetType = UNSET
    x: Axis | UnsetType = UNSET
    y: Axis | UnsetType = UNSET
    at: Numbers | UnsetType = UNSET
    lines: list[Line] | UnsetType = UNSET
    keys: list[Key] | UnsetType = UNSET
    perRev: PerRev | UnsetType | None = UNSET
    gaps: list[tuple[float, float, str]] | UnsetType = UNSET
    marks: list[Mark] | UnsetType = UNSET
    cursor: Cursor | UnsetType | None = UNSET
    chosen: str | UnsetType = UNSET
    columns: int | UnsetType = UNSET
    values: Numbers | UnsetType = UNSET
    colours: list[tuple[int, int, int]] | UnsetType = UNSET
    range: tuple[float, float] | UnsetType = UNSET
    value: Value | UnsetType = UNSET
    borders: list[tuple[Numbers, Numbers]] | UnsetType = UNSET
    regions: list[Region] | UnsetType = UNSET


class Caption(Message):
    """A text at a node of the scene; anchor: the side of the text that is there."""

    name: str
    text: str
    anchor: str


class Said(Message):
    """A text for screen readers; an error is also shown."""

    text: str
    error: bool


class Update(Message, omit_defaults=True):
    """A message to the page; what is not given stays.

    bridge: the id of the control that takes actions, first in a session, which begins anew;
    handled: the number of the last action whose effect is shown from now on; html: of elements, by
    id; values: shown by controls, by key; props: attributes of controls and elements; charts: by
    the id of their element; captions: over the scene; open: the open tab; point: controls to
    highlight; focus: the id of the field that gets the focus; dark: the theme; address: the query
    of the page's address; met: lessons whose challenge is met, for the browser to keep; say:
    announcements; ready: all actions have handlers.
    """

    bridge: str | UnsetType = UNSET
    handled: int | UnsetType = UNSET
    html: dict[str, str] | UnsetType = UNSET
    values: dict[str, Scalar | list[float]] | UnsetType = UNSET
    props: dict[str, dict[str, Scalar]] | UnsetType = UNSET
    charts: dict[str, Chart] | UnsetType = UNSET
    captions: list[Caption] | UnsetType = UNSET
    open: str | UnsetType = UNSET
    point: list[str] | UnsetType = UNSET
    focus: str | UnsetType = UNSET
    dark: bool | UnsetType = UNSET
    address: str | UnsetType = UNSET
    met: list[str] | UnsetType = UNSET
    say: list[Said] | UnsetType = UNSET
    ready: bool | UnsetType = UNSET


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
