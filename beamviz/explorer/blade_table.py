"""The tables of a blade as text: stations, bodies and root, from a beam and to one.

A table that is typed or pasted is kept as text until a beam has its rows, so nothing typed is lost.
"""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any, NamedTuple

from beamviz.beam import MAX_GAMMA_OVER_MU, PARAMETERS, Beam, exceeds_joint_limit
from beamviz.blade import MAX_STATIONS
from beamviz.blade_files import CSV, FORMATS, Text, delimited, parse_together
from beamviz.conversions import checked_unit_size
from beamviz.drawing.text import out_of_range
from beamviz.errors import InvalidInput
from beamviz.plausibility import doubts
from beamviz.si import MAX_MASSES, PhysicalBeam

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
    signed: bool = False  # its values may be below 0

    @property
    def head(self) -> str:
        return f"{self.label} [{self.unit}]"


STATIONS = (
    Column("stations", "position", "m", positive=False),
    Column("mass_per_length", "mass", "kg/m"),
    Column("bending_stiffness", "EI", "N m²"),
    Column("axial_stiffness", "EA", "N", optional=True),  # without it inextensible
    Column("flap_stiffness", "flap EI", "N m²", optional=True),
    Column("twist", "twist", "°", positive=False, optional=True, signed=True),
)
WITHOUT = {  # what a blade is without the values of an optional column
    "axial_stiffness": "where it does not stretch",
    "flap_stiffness": "where it is EI",
    "twist": "where it has none",
}
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
    nothing = (None,) * len(beam.stations)
    axial = nothing if beam.is_inextensible else beam.axial_stiffness
    columns = beam.stations, beam.mass_per_length, beam.bending_stiffness, axial
    stations = zip(*columns, beam.flap_stiffness or nothing, beam.twists or nothing, strict=True)
    masses = ((body.mass, body.position, *body.inertia) for body in beam.masses)
    root = "" if beam.root_stiffness == math.inf else text_of(beam.root_stiffness)
    return Draft(rows_of(stations), rows_of(masses), root)


def rows_of(values: Iterable[Iterable[float | None]]) -> Rows:
    return tuple(tuple("" if x is None else text_of(x) for x in row) for row in values)


# As one text, for links: a line for each row, the first cell of which names its table

HEADING = "blade"
WITHOUT_TWIST = 5  # cells of a station in the links of former versions


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
    if heading != HEADING or not counts[0] <= {WITHOUT_TWIST, len(STATIONS)} or len(root) != 1:
        return None
    if not counts[1] <= {len(MASSES)} or counts[2] != {1} or len(stations) < 2:
        return None
    padded = tuple((*row, "")[: len(STATIONS)] for row in stations)
    return Draft(padded, tuple(masses), root[0][0])


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
    if column.signed:
        return value
    if value < 0 or (column.positive and value == 0):
        raise InvalidInput("must be above 0" if column.positive else "must be 0 or more")
    return value


class Pasted(NamedTuple):
    """The stations in a text from elsewhere."""

    rows: Rows
    left_out: tuple[str, ...] = ()  # what the model leaves out
    others: Mapping[str, Any] = {}  # SI values beside the stations
    masses: Rows = ()
    stretched: float | None = None  # [m] the length of another beam, of which it has fractions


def parse_stations(files: Sequence[Text], length: float) -> Pasted:
    """The stations in a table, or in the texts of files of the field that are given at once;
    fractions are those of the length in one of them, else of a given one. Raises InvalidInput."""
    forms = [next((form for form in FORMATS if form.is_this(file)), CSV) for file in files]
    if forms == [CSV]:
        return Pasted(parse_table(files[0].text, STATIONS))
    data = parse_together(files)
    values = dict(data.values)
    whole = values.pop("length", None)
    if data.has_fractions:
        values["stations"] = [(whole or length) * fraction for fraction in values["stations"]]
    nothing = (None,) * len(values["stations"])
    columns = [values.pop(column.key, nothing) for column in STATIONS]
    bodies = values.pop("masses", ())
    masses = ((body["mass"], body["position"], *body["inertia"]) for body in bodies)
    return Pasted(
        rows=rows_of(zip(*columns, strict=True)),
        left_out=data.left_out,
        others=values,
        masses=rows_of(masses),
        stretched=length if data.has_fractions and not whole else None,
    )


def parse_table(text: str, columns: Sequence[Column]) -> Rows:
    """The cells of a table as text: separated by tabs, semicolons, commas or blanks, with or
    without a line of names, which may have units. Raises InvalidInput if it is none, or has an
    unknown column."""
    rows = [list(row.cells) for row in delimited.rows_of(Text("the table", text))]
    if not rows:
        raise InvalidInput("the table is empty")
    if all(len(row) == 1 for row in rows):
        heads = ", ".join(column.head for column in columns if not column.optional)
        raise InvalidInput(f"the table has one column; it needs {heads}")
    placed = [PlacedColumn(k) for k in range(len(columns))]
    if all(re.search("[A-Za-z]", cell) and not is_number(cell) for cell in rows[0]):
        placed = [column_of(cell, columns) for cell in delimited.names_with_units(rows)]
    for number, row in enumerate(rows, 1):
        if len(row) > len(placed):
            heads = ", ".join(column.head for column in columns)
            raise InvalidInput(
                f"row {number} has {len(row)} cells, more than {len(placed)}: {heads}"
            )
    if not rows:
        raise InvalidInput("the table has a line of names only")
    by_column = [
        {
            column.place: in_unit(cell, column.size)
            for column, cell in zip(placed, row, strict=False)
        }
        for row in rows
    ]
    return tuple(tuple(row.get(k, "") for k in range(len(columns))) for row in by_column)


def has_only_numbers(file: Text) -> bool:
    """Whether the first row of a table has no names, but numbers alone."""
    rows = delimited.rows_of(file)
    return bool(rows) and all(map(is_number, rows[0].cells))


def in_unit(cell: str, size: float) -> str:
    """The number of a cell in the unit of its column; another text as it is."""
    return text_of(size * number_of(cell)) if size != 1 and is_number(cell) else cell


def is_number(text: str) -> bool:
    try:
        number_of(text)
    except InvalidInput:
        return False
    return True


class PlacedColumn(NamedTuple):
    """Where the cells of a column belong, and the size of their unit."""

    place: int
    size: float = 1.0


def column_of(head: str, columns: Sequence[Column]) -> PlacedColumn:
    """The column of a name, which may have its unit in brackets. Raises InvalidInput if it is
    unknown or in a unit of another quantity."""
    name, _, unit = (part.strip() for part in re.split(r"([\[(])", f"{head}[", maxsplit=1))
    key = delimited.NAMES.get(name.lower(), name.lower())
    key = {"station": "stations"}.get(key, key)
    for k, column in enumerate(columns):
        if key in (column.key, column.label.lower()):
            unit = re.sub(r"[\])\[]", "", unit).strip()
            si_unit = column.unit.replace("²", "^2").replace("°", "deg")
            return PlacedColumn(k, checked_unit_size(head, unit, si_unit) if unit else 1.0)
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
    for k, column in enumerate(STATIONS):
        given = [bool(row[k].strip()) for row in draft.stations]
        if column.optional and any(given) and not all(given):
            missing = given.index(False)
            reason = f"give it at every station, or at none {WITHOUT[column.key]}"
            text = f"station {missing + 1}, {column.head} = nothing: {reason}"
            wrong.append(Wrong("stations", missing, k, text))
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
    for column in STATIONS:
        if columns[column.key][0] is None:
            del columns[column.key]
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
            "pitch": before.pitch,
        }
    )
    if before.twist:
        physical = replace(physical, twist=before.twist)
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
    values = getattr(before, "twists" if column.key == "twist" else column.key)
    known = dict(zip((row[k] for row in shown), values, strict=True)) if values else {}
    return [known[row[k]] if row[k] in known else cell_value(column, row[k]) for row in rows]


def mass_values(row: Cells) -> dict[str, Any]:
    """A row of the table of masses as values of SI."""
    mass, position, *inertia = (cell_value(*pair) for pair in zip(MASSES, row, strict=True))
    return {"mass": mass, "position": position, "inertia": [moment or 0.0 for moment in inertia]}


# Edits


def with_station(rows: Rows) -> tuple[Rows, int]:
    """With a station in the middle of the longest interval, of the mean values of its ends; and its
    row."""
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
    return (*rows[: k + 1], between, *rows[k + 1 :]), k + 1


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
