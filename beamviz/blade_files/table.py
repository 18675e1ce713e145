"""Tables of numbers in the text of a file, whose errors name line, station and column."""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from beamviz.errors import InvalidInput

VALUE_AND_NAME = re.compile(r"""\s*("[^"]*"|'[^']*'|\S+)\s+([A-Za-z]\w*(?:\(\d+\))?)""")
FORTRAN = str.maketrans("dD", "ee")  # of an exponent: 1.0D+05


class FileLine(NamedTuple):
    """A line of a file, and its number from 1."""

    number: int
    text: str

    @property
    def words(self) -> list[str]:
        return self.text.split()


class Text(NamedTuple):
    """The text of a file, and its name for messages."""

    name: str
    text: str

    @property
    def lines(self) -> list[FileLine]:
        return [FileLine(k, line) for k, line in enumerate(self.text.splitlines(), 1)]


class Row(NamedTuple):
    """A row of a table."""

    line: int
    cells: Sequence[str]


class FileTable(NamedTuple):
    """Rows of cells below names of columns."""

    file: str
    columns: Sequence[str]
    rows: Sequence[Row]

    def column(self, name: str, positive: bool = False) -> tuple[float, ...]:
        """The numbers of a column. Raises InvalidInput with file, line, station and column."""
        k, values = self.columns.index(name), []
        for station, row in enumerate(self.rows, 1):
            place = f"{self.file}: line {row.line}, station {station}, {name}"
            if k >= len(row.cells):
                raise InvalidInput(f"{place}: missing, the row has {len(row.cells)} cells")
            value = number_in(row.cells[k], place)
            if positive and value <= 0:
                raise InvalidInput(f"{place} = {row.cells[k]}: must be above 0")
            values.append(value)
        return tuple(values)


def is_number(cell: str) -> bool:
    """Whether a cell is a number, perhaps not a finite one."""
    try:
        float(cell.translate(FORTRAN))
    except ValueError:
        return False
    return True


def number_in(cell: str, place: str) -> float:
    """The number in a cell. Raises InvalidInput with its place."""
    try:
        value = float(cell.translate(FORTRAN))
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InvalidInput(f"{place} = {cell!r}: must be a number")
    return value


def fixed_table(
    file: Text, lines: Iterable[FileLine], columns: Sequence[str], count: int, what: str
) -> FileTable:
    """The next `count` lines as a table with these columns, separated by blanks. Raises
    InvalidInput where there are fewer, or one has too few cells."""
    rows: list[Row] = []
    for line in lines:
        if len(rows) == count:
            break
        if not line.text.strip():
            continue
        if line.text.lstrip().startswith("--"):  # the next section
            break
        cells = line.text.split(";")[0].split()
        if len(cells) < len(columns):
            raise InvalidInput(
                f"{file.name}: line {line.number}, station {len(rows) + 1}: {len(cells)} cells, not"
                f" {len(columns)}: {', '.join(columns)}"
            )
        rows.append(Row(line.number, cells))
    if len(rows) < count:
        raise InvalidInput(f"{file.name}: ends after {len(rows)} of {count} {what}")
    return FileTable(file.name, columns, rows)


class Entry(NamedTuple):
    """A value of an input file of the field, which stands before its name."""

    line: int
    text: str


def entries_of(file: Text) -> dict[str, Entry]:
    """The values of an input file by their names in small letters, each on a line "value name -
    description"."""
    entries: dict[str, Entry] = {}
    for line in file.lines:
        if match := re.match(
            r"""\s*("[^"]*"|'[^']*'|\S+)\s+([A-Za-z]\w*(?:\(\d+\))?)""", line.text
        ):
            value, name = match.groups()
            entries.setdefault(name.lower(), Entry(line.number, value.strip("\"'")))
    return entries


def entry(
    file: Text, entries: Mapping[str, Entry], name: str, otherwise: float | None = None
) -> float:
    """The number of a name. Raises InvalidInput where it is missing and there is none otherwise."""
    given = entries.get(name.lower())
    if given is None:
        if otherwise is None:
            raise InvalidInput(f"{file.name}: missing {name}")
        return otherwise
    return number_in(given.text, f"{file.name}: line {given.line}, {name}")
