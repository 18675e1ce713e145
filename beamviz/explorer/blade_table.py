"""The tables of a blade as text: stations, bodies and root, from a beam and to one.

A table that is typed or pasted is kept as text until it describes a beam, so nothing typed is lost.
"""

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any, NamedTuple

from beamviz.beam import MAX_GAMMA_OVER_MU, PARAMETERS, Beam, exceeds_joint_limit
from beamviz.blade import MAX_STATIONS
from beamviz.drawing.text import out_of_range
from beamviz.errors import InvalidInput
from beamviz.plausibility import doubts
from beamviz.si import MAX_MASSES, SI_SYNONYMS, PhysicalBeam

DIGITS = 6  # significant, of the numbers shown

Cells = tuple[str, ...]
Rows = tuple[Cells, ...]


class Column(NamedTuple):
    """A column of a table."""

    key: str  # of the SI values
    label: str
    unit: str
    positive: bool = True  # its values must be above 0
    optional: bool = False

    @property
    def head(self) -> str:
        return f"{self.label} [{self.unit}]"


STATIONS = (
    Column("stations", "position", "m", positive=False),
    Column("mass_per_length", "mass", "kg/m"),
    Column("bending_stiffness", "EI", "N m²"),
    Column("axial_stiffness", "EA", "N"),
    Column("flap_stiffness", "flap EI", "N m²", optional=True),
)
MASSES = (
    Column("mass", "mass", "kg", positive=False),
    Column("position", "position", "m", positive=False),
    *(Column(f"J{axis}", f"J{axis}", "kg m²", positive=False, optional=True) for axis in "xyz"),
)


class Draft(NamedTuple):
    """The tables as text, with a cell for each column."""

    stations: Rows
    masses: Rows = ()
    root: str = ""  # "": clamped, "0": hinged, or the stiffness of a spring [N m/rad]


class Wrong(NamedTuple):
    """What is wrong with a table."""

    table: str
    row: int  # -1: the whole table
    column: int  # -1: the whole table
    reason: str


def text_of(value: float) -> str:
    """A number with DIGITS significant digits: 18.1e9 is "1.81e10"."""
    return re.sub(r"e\+?(-?)0*", r"e\1", f"{value:.{DIGITS}g}")


def draft_of(beam: PhysicalBeam) -> Draft:
    """The tables of a beam."""
    flap = beam.flap_stiffness or (None,) * len(beam.stations)
    columns = beam.stations, beam.mass_per_length, beam.bending_stiffness, beam.axial_stiffness
    stations = zip(*columns, flap, strict=True)
    masses = ((body.mass, body.position, *body.inertia) for body in beam.masses)
    root = "" if beam.root_stiffness == math.inf else text_of(beam.root_stiffness)
    return Draft(rows_of(stations), rows_of(masses), root)


def rows_of(values: Iterable[Iterable[float | None]]) -> Rows:
    return tuple(tuple("" if x is None else text_of(x) for x in row) for row in values)


# As one text, for links: a line for each row, the first cell of which names its table

HEADING = "blade"


def text_of_draft(draft: Draft) -> str:
    rows: list[Cells] = [("root", draft.root)]
    rows += [("m", *row) for row in draft.masses]
    rows += [("s", *row) for row in draft.stations]
    return "\n".join([HEADING, *("\t".join(row) for row in rows)])


def draft_of_text(text: str) -> Draft | None:
    """The tables of `text_of_draft`; None for another text."""
    heading, *lines = text.split("\n")
    tables: dict[str, list[Cells]] = {"root": [], "m": [], "s": []}
    for line in lines:
        name, *cells = line.split("\t")
        if name not in tables:
            return None
        tables[name].append(tuple(cells))
    stations, masses, root = tables["s"], tables["m"], tables["root"]
    counts = {len(row) for row in stations}, {len(row) for row in masses}, {len(x) for x in root}
    if heading != HEADING or counts[0] != {len(STATIONS)} or len(root) != 1:
        return None
    if not counts[1] <= {len(MASSES)} or counts[2] != {1} or len(stations) < 2:
        return None
    return Draft(tuple(stations), tuple(masses), root[0][0])


# From text

GROUPED = re.compile(r"-?\d{1,3}(,\d{3})+")  # 1,500: thousands, or a decimal comma?


def number_of(text: str) -> float:
    """The number in a cell, with a decimal point or comma. Raises InvalidInput, with the remedy."""
    plain = text.strip().replace("\u2212", "-")
    if GROUPED.fullmatch(plain):
        remedy = f"write {plain.replace(',', '')}"
        if plain.count(",") == 1:
            remedy += f", or {plain.replace(',', '.')}"
        raise InvalidInput(remedy)
    try:
        number = float(plain.replace(",", ".").replace("_", "?"))
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise InvalidInput("must be a number, as 320 or 1.8e10")
    return number + 0.0


def cell_value(column: Column, text: str) -> float | None:
    """The value of a cell; None for an empty one that is optional. Raises InvalidInput."""
    if column.optional and not text.strip():
        return None
    value = number_of(text)
    if value < 0 or (column.positive and value == 0):
        raise InvalidInput("must be above 0" if column.positive else "must be 0 or more")
    return value


def parse_table(text: str, columns: Sequence[Column]) -> Rows:
    """The cells of a table as text: separated by tabs, semicolons, commas or blanks, with or
    without a line of names. Raises InvalidInput if it is none, or has an unknown column."""
    lines = [line for line in text.splitlines() if line.strip() and line.strip()[0] != "#"]
    if not lines:
        raise InvalidInput("the table is empty")
    mark = next((mark for mark in "\t;," if mark in lines[0]), None)
    rows = [[" ".join(cell.strip(' "').split()) for cell in line.split(mark)] for line in lines]
    order = list(range(len(rows[0])))
    if all(re.search("[A-Za-z]", cell) and not is_number(cell) for cell in rows[0]):
        order = [column_of(cell, columns) for cell in rows.pop(0)]
    for number, row in enumerate(rows, 1):
        if len(row) > len(columns) or len(row) > len(order):
            most = min(len(columns), len(order))
            heads = ", ".join(column.head for column in columns)
            raise InvalidInput(f"row {number} has {len(row)} cells, more than {most}: {heads}")
    if not rows:
        raise InvalidInput("the table has a line of names only")
    placed = [dict(zip(order, row, strict=False)) for row in rows]
    return tuple(tuple(row.get(k, "") for k in range(len(columns))) for row in placed)


def is_number(text: str) -> bool:
    try:
        number_of(text)
    except InvalidInput:
        return False
    return True


NAMES = {  # of columns of stations, in small letters; also those of blade files of FAST
    **{name.lower(): key for name, key in SI_SYNONYMS.items()},
    **{column.label.lower(): column.key for column in STATIONS},
    **dict.fromkeys(("r", "z", "radius"), "stations"),
    **dict.fromkeys(("m", "kg/m", "mass per length", "bmassden"), "mass_per_length"),
    **dict.fromkeys(("edgewise ei", "ei edge", "edgstff"), "bending_stiffness"),
    **dict.fromkeys(("flapwise ei", "ei flap", "flpstff"), "flap_stiffness"),
    "eastff": "axial_stiffness",
}


def column_of(head: str, columns: Sequence[Column]) -> int:
    """The number of the column with a name, which may have its unit in brackets. Raises
    InvalidInput if it is unknown or in another unit."""
    name, bracket, unit = (part.strip() for part in re.split(r"([\[(])", f"{head}[", maxsplit=1))
    key = NAMES.get(name.lower(), name.lower())
    for k, column in enumerate(columns):
        if key == column.key:
            unit = re.sub("[ ^*·]", "", re.split(r"[\])\[]", unit)[0]).replace("2", "²")
            if bracket and unit and unit != column.unit.replace(" ", ""):
                raise InvalidInput(f"{head}: must be in {column.unit}")
            return k
    known = ", ".join(column.head for column in columns)
    raise InvalidInput(f"column {head!r}: must be one of {known}; or leave out the line of names")


def sorted_rows(rows: Rows) -> Rows:
    """Stations by position; unchanged where one of them is no number."""
    if not all(is_number(row[0]) for row in rows):
        return rows
    return tuple(sorted(rows, key=lambda row: number_of(row[0])))


# To a beam


def wrong_cells(name: str, columns: Sequence[Column], rows: Rows) -> list[Wrong]:
    """The cells of a table that are no value of their column."""
    title = "station" if name == "stations" else "mass"
    wrong = []
    for i, row in enumerate(rows):
        for k, (column, text) in enumerate(zip(columns, row, strict=True)):
            try:
                cell_value(column, text)
            except InvalidInput as error:
                shown = text.strip() or "nothing"
                wrong.append(
                    Wrong(name, i, k, f"{title} {i + 1}, {column.head} = {shown}: {error}")
                )
    return wrong


def wrong_order(rows: Rows) -> list[Wrong]:
    """The positions of stations that are below the one before. They stay where they are typed: a
    mistyped one would else be in another row."""
    wrong = []
    for i, ((before, *_), (here, *_)) in enumerate(pairwise(rows), 1):
        if is_number(before) and is_number(here) and number_of(here) < number_of(before):
            reason = f"below that of station {i}, {before}: correct it, or sort the stations"
            text = f"station {i + 1}, {STATIONS[0].head} = {here}: {reason}"
            wrong.append(Wrong("stations", i, 0, text))
    return wrong


def wrong_entries(draft: Draft) -> list[Wrong]:
    """What is wrong in the tables, cell by cell, and with positions."""
    wrong = wrong_cells("stations", STATIONS, draft.stations)
    wrong += wrong_cells("masses", MASSES, draft.masses)
    flap = [bool(row[-1].strip()) for row in draft.stations]
    if any(flap) and not all(flap):
        missing = flap.index(False)
        reason = "give it at every station, or at none where it is EI"
        head = STATIONS[-1].head
        text = f"station {missing + 1}, {head} = nothing: {reason}"
        wrong.append(Wrong("stations", missing, len(STATIONS) - 1, text))
    wrong += wrong_order(draft.stations)
    if not wrong and (first := number_of(draft.stations[0][0])) > 0:
        reason = "must be 0, at the root; the distance from the axis to the root is the hub radius"
        wrong.append(Wrong("stations", 0, 0, f"station 1, position [m] = {first:g}: {reason}"))
    if draft.root:
        try:
            cell_value(Column("root", "root", "N m/rad", positive=False), draft.root)
        except InvalidInput as error:
            text = f"stiffness of the root [N m/rad] = {draft.root}: {error}"
            wrong.append(Wrong("root", -1, -1, text))
    return wrong


def beam_of(draft: Draft, before: PhysicalBeam) -> Beam:
    """The beam of the tables, with the hub, the speed and the concentrated mass of another one.
    Raises InvalidInput."""
    shown = draft_of(before)
    columns: dict[str, Any] = {
        column.key: column_values(column, k, draft.stations, shown.stations, before)
        for k, column in enumerate(STATIONS)
    }
    if columns["flap_stiffness"][0] is None:
        del columns["flap_stiffness"]
    same_count = len(draft.stations) == len(shown.stations)
    length = columns["stations"][-1]
    physical = PhysicalBeam.of(
        columns
        | {
            "degree": before.degree if same_count else 1,
            "hub_radius": before.hub_radius,
            "rotation_speed": before.rotation_speed,
            "mass": before.mass,
            "mass_position": min(before.mass_position / before.length, 1.0) * length,
            "masses": [mass_values(row) for row in draft.masses],
            "root_stiffness": number_of(draft.root) if draft.root else None,
            "angular_acceleration": before.angular_acceleration,
        }
    )
    if draft.root and draft.root == shown.root:
        physical = replace(physical, root_stiffness=before.root_stiffness)
    if draft.masses == shown.masses:
        physical = replace(physical, masses=before.masses)
    try:
        return Beam.of_physical(physical)
    except InvalidInput as error:
        raise InvalidInput(in_words(str(error), physical)) from None


def in_words(text: str, physical: PhysicalBeam) -> str:
    """An error of a beam in SI in the words and units of the page, with what is likely wrong."""
    for column in STATIONS[1:]:
        text = re.sub(rf"\b{column.key}\b", column.head, text)
    text = re.sub(r"\b(masses \d+), over [^:]*: ", r"\1, relative to the beam: ", text)
    text = text.replace("alpha of a mass", "mass").replace("inertia of a mass", "inertia")
    try:
        numbers, units = physical.numbers, physical.units
    except InvalidInput:  # the values are too extreme
        return text
    gamma, mu, (low, high) = numbers["gamma"], numbers["mu"], PARAMETERS["mu"].limits
    reasons = []
    if of_others := out_of_range(numbers | {"mu": high}, units):  # own sentences tell of mu
        too_fast = gamma > PARAMETERS["gamma"].limits[1]
        soft = ": this blade is too soft for more, with its EI and mass at the root"
        reasons.append(of_others + (soft if too_fast else ""))
    if not low <= mu <= high:
        reasons.append(f"L √(EA / EI) at the root = {mu:.4g}: must lie in {low:g} .. {high:g}")
    if exceeds_joint_limit(gamma, mu):
        ratio = f"speed of the tip over that of sound, √(EA / mass per length), = {gamma / mu:.3g}"
        reasons.append(f"{ratio}: must be at most {MAX_GAMMA_OVER_MU:g}")
    return "; ".join([*reasons, *doubts(physical)]) if reasons else text


def column_values(
    column: Column, k: int, rows: Rows, shown: Rows, before: PhysicalBeam
) -> list[float | None]:
    """The values in a column: a text that stands for a value of the beam shown is that value, with
    all its digits."""
    values = getattr(before, column.key)
    known = dict(zip((row[k] for row in shown), values, strict=True)) if values else {}
    return [known[row[k]] if row[k] in known else cell_value(column, row[k]) for row in rows]


def mass_values(row: Cells) -> dict[str, Any]:
    """A row of the table of masses as values of SI."""
    mass, position, *inertia = (cell_value(*pair) for pair in zip(MASSES, row, strict=True))
    return {"mass": mass, "position": position, "inertia": [moment or 0.0 for moment in inertia]}


# Edits


def with_station(rows: Rows) -> Rows:
    """With a station in the middle of the longest interval, of the mean values of its ends."""
    if len(rows) >= MAX_STATIONS:
        raise InvalidInput(f"{len(rows)} stations: must be at most {MAX_STATIONS}")
    known = [number_of(row[0]) if is_number(row[0]) else math.nan for row in rows]
    lengths = [b - a if b > a else 0.0 for a, b in pairwise(known)]
    k = max(range(len(lengths)), key=lengths.__getitem__, default=0)
    ends = zip(rows[k], rows[min(k + 1, len(rows) - 1)], strict=True)
    between = tuple(
        text_of((number_of(a) + number_of(b)) / 2) if is_number(a) and is_number(b) else a
        for a, b in ends
    )
    return (*rows[: k + 1], between, *rows[k + 1 :])


def with_mass(rows: Rows, beam: PhysicalBeam) -> Rows:
    """With a body at the tip, of a tenth of the mass of the beam."""
    if len(rows) >= MAX_MASSES:
        raise InvalidInput(f"{len(rows)} masses: must be at most {MAX_MASSES}")
    whole = sum(
        (b - a) * (m + n) / 2
        for (a, b), (m, n) in zip(
            pairwise(beam.stations), pairwise(beam.mass_per_length), strict=True
        )
    )
    return (*rows, (f"{whole / 10:.2g}", text_of(beam.length), "", "", ""))


def without(rows: Rows, k: Any) -> Rows:
    """Without row k; unchanged where there is none."""
    return tuple(row for i, row in enumerate(rows) if i != k)
