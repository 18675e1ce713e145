"""Tables of stations as text: CSV files, and what is pasted from a spreadsheet.

The cells of a line are separated by semicolons, tabs, commas or blanks; where commas do not
separate, a comma is that of a decimal. Names of columns may have a unit, which may also stand in a
row of its own below them.
"""

import csv
import io
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import NamedTuple

from beamviz.blade_files.data import BladeData
from beamviz.blade_files.table import FileLine, FileTable, Row, Text, is_number
from beamviz.conversions import checked_unit_size
from beamviz.errors import InvalidInput, unknown_keyword

COLUMNS = {  # and their units
    "station": "m",
    "mass_per_length": "kg/m",
    "bending_stiffness": "N m^2",
    "axial_stiffness": "N",
    "flap_stiffness": "N m^2",
    "twist": "deg",
}
REQUIRED = ("station", "mass_per_length", "bending_stiffness")
FRACTIONS = ("blfract", "sec_loc", "r/r", "x/l", "eta", "fraction", "span fraction")
NAMES = {  # other names of the columns, in small letters; also those of files of the field
    **dict.fromkeys(("stations", "position", "span", "r", "x", "z", "radius", "s"), "station"),
    **dict.fromkeys(FRACTIONS, "station"),
    **dict.fromkeys(("m", "mass", "rhoa", "linear_density", "mass_density"), "mass_per_length"),
    **dict.fromkeys(
        ("kg/m", "mass per length", "m_per_length", "bmassden", "mass_den"), "mass_per_length"
    ),
    **dict.fromkeys(("ei", "ei_lag", "ei_edge", "chord_stiffness", "edgstff"), "bending_stiffness"),
    **dict.fromkeys(("edgewise ei", "ei edge", "ei_edgewise", "edge_stff"), "bending_stiffness"),
    **dict.fromkeys(("ei_flap", "flapwise_stiffness", "flap ei", "flpstff"), "flap_stiffness"),
    **dict.fromkeys(("flapwise ei", "ei flap", "ei_flapwise", "flp_stff"), "flap_stiffness"),
    **dict.fromkeys(("ea", "eastff", "axial_stff", "axial ea"), "axial_stiffness"),
    **dict.fromkeys(("structural_twist", "strctwst", "str_tw", "twist angle"), "twist"),
}
NOTES = "#!%"  # begin a line that is no row
FRACTION_UNITS = ("-", "1", "", "%")


class Heading(NamedTuple):
    """A column of the table."""

    key: str
    size: float  # of its unit, in SI
    is_fraction: bool = False


def filled_lines(file: Text) -> list[FileLine]:
    """The lines that are not empty and no notes."""
    return [line for line in file.lines if line.text.strip() and line.text.strip()[0] not in NOTES]


def rows_of(file: Text) -> list[Row]:
    """The cells of each line that is not empty and no note, with decimal points. Raises
    InvalidInput for quotes that do not end."""
    lines = filled_lines(file)
    if not lines:
        return []
    mark = delimiter_of([line.text for line in lines])
    rows = []
    for line in lines:
        if mark == " ":
            cells = line.words
        else:
            try:
                cells = next(csv.reader(io.StringIO(line.text), delimiter=mark))
            except (csv.Error, StopIteration) as error:
                reason = f"not a CSV file ({error})"
                raise InvalidInput(f"{file.name}: line {line.number}: {reason}") from None
        cells = [cell.strip() for cell in cells]
        rows.append(Row(line.number, cells if mark == "," else list(map(with_point, cells))))
    return rows


def delimiter_of(lines: Sequence[str]) -> str:
    """What separates the cells: semicolons or tabs where there are any, else commas, else blanks.
    Where lines of numbers have commas inside words that blanks separate, these are decimal."""
    last = lines[-1]
    for mark in ";\t":
        if mark in lines[0] or mark in last:
            return mark
    words = last.split()
    if "," in last and not (len(words) > 1 and all(map(is_decimal_comma, words))):
        return ","
    return "," if "," in lines[0] else " "


def is_decimal_comma(word: str) -> bool:
    return re.fullmatch(r"[-+]?\d+(,\d+)?([eE][-+]?\d+)?", word) is not None


def with_point(cell: str) -> str:
    """A cell whose decimal comma, if it has one, is a point."""
    return cell.replace(",", ".") if is_decimal_comma(cell) else cell


def is_text(cell: str) -> bool:
    """Whether a cell is no number: a name or a unit."""
    return not is_number(cell) and re.search(r"[A-Za-z°\[(\-]", cell) is not None


def named_columns(
    file: Text, units: Mapping[str, str], required: Collection[str]
) -> tuple[list[Heading], list[Row]]:
    """The columns of a table, and its rows below them. Raises InvalidInput for a column that is
    unknown, missing, there twice, or in a unit of another quantity, and for a row of another
    length."""
    rows = rows_of(file)
    if not rows:
        raise InvalidInput(f"{file.name}: has no rows")
    if not all(map(is_text, filter(None, rows[0].cells))):
        raise InvalidInput(
            f"{file.name}: line {rows[0].line}: must name the columns: {', '.join(units)}"
        )
    cells = [list(row.cells) for row in rows]
    names = names_with_units(cells)
    below = rows[len(rows) - len(cells) :]
    headings = [heading(file.name, name, units) for name in names]
    keys = [each.key for each in headings]
    for key in required:
        if key not in keys:
            raise InvalidInput(f"{file.name}: missing column {key!r} [{units[key]}]")
    if len(set(keys)) < len(keys):
        raise InvalidInput(f"{file.name}: a column is there twice: {', '.join(keys)}")
    if not below:
        raise InvalidInput(f"{file.name}: has no stations, only names of columns")
    for station, row in enumerate(below, 1):
        if len(row.cells) != len(names):
            raise InvalidInput(
                f"{file.name}: line {row.line}, station {station}: {len(row.cells)} cells, not"
                f" {len(names)}"
            )
    return headings, below


def names_with_units(rows: list[list[str]]) -> list[str]:
    """The names of columns, taken from the rows, with the units in a row of their own below them,
    if there is one, in brackets."""
    names = rows.pop(0)
    if not rows or len(rows[0]) != len(names) or not any(rows[0]):
        return names
    if not all(map(is_text, filter(None, rows[0]))):
        return names
    units = [re.sub(r"[\[\]()]", "", cell) for cell in rows.pop(0)]
    return [f"{name} [{unit}]" if unit else name for name, unit in zip(names, units, strict=True)]


def heading(file: str, cell: str, units: Mapping[str, str]) -> Heading:
    """The column of a name, which may have its unit in brackets. Raises InvalidInput."""
    name, _, unit = (part.strip() for part in re.split(r"([\[(])", f"{cell}[", maxsplit=1))
    unit = re.sub(r"[\])\[]", "", unit).strip()
    key = name if name in units else NAMES.get(name.lower(), name.lower())
    if key not in units:
        raise InvalidInput(f"{file}: {unknown_keyword('column', name, units, NAMES, units)}")
    if key == "station" and (name.lower() in FRACTIONS or unit in ("-", "1", "%")):
        return Heading(key, 0.01 if unit == "%" else 1.0, is_fraction=True)
    size = checked_unit_size(f"{file}: column {name}", unit, units[key]) if unit else 1.0
    return Heading(key, size)


def is_table(file: Text) -> bool:
    """Whether the first line has the name of a column."""
    lines = filled_lines(file)
    if not lines:
        return False
    cells = [cell.strip(' "') for cell in re.split(r"[;,\t]|\s{2,}", lines[0].text)]
    names = (re.split(r"[\[(]", cell)[0].strip() for cell in (*cells, *lines[0].words))
    return any(name in COLUMNS or name.lower() in NAMES for name in names)


def read_stations(file: Text) -> BladeData:
    """The blade of a table of stations. Raises InvalidInput with file, line, station and column."""
    headings, rows = named_columns(file, COLUMNS, REQUIRED)
    table = FileTable(file.name, [each.key for each in headings], rows)
    values: dict[str, Iterable[float]] = {}
    for each in headings:
        numbers = table.column(each.key, positive=each.key not in ("station", "twist"))
        key = "stations" if each.key == "station" else each.key
        values[key] = tuple(each.size * number for number in numbers)
    has_fractions = next(each for each in headings if each.key == "station").is_fraction
    return BladeData(values, has_fractions)
