"""Measured frequencies: of a CSV file, a table or targets, in the T* of the given beam."""

import math
import re
from collections.abc import Iterable, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from beamviz.beam import NUMBERS, Beam
from beamviz.blade_files.delimited import delimiter_of, filled_lines, names_with_units, rows_of
from beamviz.blade_files.table import Row, Text
from beamviz.checks import check_float
from beamviz.conversions import parse_quantity, unit_size
from beamviz.errors import InvalidInput, unknown_keyword
from beamviz.input_files import decoded, read_small
from beamviz.solver.problem import MAX_MODES
from beamviz.units import BY_NAME, Units, parse_over

FREQUENCIES = ("frequency", "hertz")
NAMES = {  # other names of the columns, in small letters
    **dict.fromkeys(("hz", "freq", "f"), "hertz"),
    **dict.fromkeys(("label", "branch"), "mode"),
    **dict.fromkeys(("sigma", "uncertainty", "std", "standard_deviation"), "error"),
    **dict.fromkeys(("speed", "1/min"), "rpm"),
    "omega": "frequency",
}
COLUMNS = (*FREQUENCIES, "error", "mode", *NUMBERS, *BY_NAME)
LABEL = re.compile(r"[BSFL]([1-9][0-9]?)")  # of a mode
MOST_ROWS = 1000
HEADS = 2  # at most, the lines of names and of units
HELD = 1e-6  # distance of a number of a measured frequency from that of a chart
WHOLE = 1e15  # below it whole numbers are exact in their digits


class MeasuredFrequency(NamedTuple):
    """A frequency [1/T*], its standard deviation, nan where it is not known, the label of its mode,
    "" where it is not known, and the numbers of the beam at which it was measured."""

    frequency: float
    error: float
    mode: str
    numbers: tuple[tuple[str, float], ...]


class MeasuredTable(NamedTuple):
    """Measured frequencies as columns by name, and as rows."""

    columns: Mapping[str, list[Any]]
    rows: tuple[MeasuredFrequency, ...]


def measured_frequencies(beam: Beam, measured: Any) -> list[MeasuredFrequency]:
    """The rows of a CSV file, or of a table: a mapping of columns, a DataFrame, or a sequence of
    mappings. Raises InvalidInput."""
    name = str(measured) if isinstance(measured, str | Path) else "measured"
    return rows_of_columns(columns_of(measured), beam.units, name)


def rows_of_columns(
    columns: Mapping[str, list[Any]], units: Units | None, name: str
) -> list[MeasuredFrequency]:
    """The rows of columns of a beam of this size; name: for messages. Raises InvalidInput."""
    count = len(next(iter(columns.values()), []))
    if not 1 <= count <= MOST_ROWS:
        raise InvalidInput(f"{name}: {count} frequencies: must be 1 .. {MOST_ROWS}")
    frequencies = [f for f in FREQUENCIES if f in columns]
    if len(frequencies) != 1:
        raise InvalidInput(f"{name}: must have one of the columns {', '.join(FREQUENCIES)}")
    rows = []
    for k, cells in enumerate(zip(*columns.values(), strict=True), 1):
        row = dict(zip(columns, cells, strict=True))
        rows.append(measured_row(units, row, frequencies[0], f"{name}: row {k}"))
    if len({math.isnan(row.error) for row in rows}) > 1:
        raise InvalidInput(f"{name}: give the error of every frequency, or of none")
    return rows


def table_of_text(text: str, units: Units | None) -> MeasuredTable:
    """The measured frequencies of the text of a CSV file, which is parsed once. Raises
    InvalidInput."""
    answer = parsed_text(text, units)
    if isinstance(answer, str):
        raise InvalidInput(answer)
    return answer


@lru_cache(32)
def parsed_text(text: str, units: Units | None) -> MeasuredTable | str:
    """A table, or what is wrong in the text."""
    try:
        columns = columns_of_text(text)
        return MeasuredTable(columns, tuple(rows_of_columns(columns, units, "measured")))
    except InvalidInput as error:
        return str(error)


def measured_columns(beam: Beam, measured: Any) -> dict[str, list[float | str]]:
    """The columns of measured frequencies by name, as a scene file has them: numbers, and labels of
    modes, without empty columns. Raises InvalidInput, as `measured_frequencies`."""
    columns = columns_of(measured)
    measured_frequencies(beam, columns)
    return {
        name: [label_in(cell) if name == "mode" else float(cell) for cell in cells]
        for name, cells in columns.items()
        if not all(map(is_empty, cells))
    }


def points_over(
    beam: Beam, over: str, rows: Iterable[MeasuredFrequency]
) -> list[tuple[float, MeasuredFrequency]]:
    """The measured frequencies of a chart of a beam over one of its numbers, each at its value of
    that number, by default that of the beam. Those at other numbers than the beam has belong to
    another chart."""
    points = []
    for row in rows:
        numbers = dict(row.numbers)
        at = numbers.pop(over, getattr(beam, over))
        held = (
            math.isclose(getattr(beam, name), value, rel_tol=HELD, abs_tol=HELD)
            for name, value in numbers.items()
        )
        if all(held):
            points.append((at, row))
    return points


def columns_of(measured: Any) -> dict[str, list[Any]]:
    """The columns of a CSV file or of a table by name. Raises InvalidInput."""
    if isinstance(measured, str | Path):
        return columns_of_file(Path(measured))
    return columns_of_table(measured)


def columns_of_file(path: Path) -> dict[str, list[Any]]:
    """The columns of a CSV file by name. Raises InvalidInput."""
    return columns_of_text(decoded(read_small(path), path.name, "CSV"), path.name)


def columns_of_text(text: str, source: str = "measured") -> dict[str, list[Any]]:
    """The columns of the text of a CSV file by name; source: its name, for messages. Raises
    InvalidInput."""
    file = Text(source, text)
    count = len(filled_lines(file))
    if not count:
        raise InvalidInput(f"{source}: has no rows")
    if count > MOST_ROWS + HEADS:
        raise InvalidInput(f"{source}: {count} lines: must be 1 .. {MOST_ROWS} frequencies")
    rows = rows_of(file)
    cells = [list(row.cells) for row in rows]
    names = [column_name(name, source) for name in names_with_units(cells)]
    below: list[Row] = rows[len(rows) - len(cells) :]
    if len(set(names)) < len(names):
        raise InvalidInput(f"{source}: a column is there twice: {', '.join(names)}")
    for row in below:
        if len(row.cells) != len(names):
            raise InvalidInput(
                f"{source}: line {row.line}: {len(row.cells)} cells, not {len(names)}"
            )
    return {name: [row.cells[k] for row in below] for k, name in enumerate(names)}


def text_of_columns(columns: Mapping[str, list[Any]]) -> str:
    """The text of a CSV file that `columns_of_text` reads."""
    lines = zip(*columns.values(), strict=True)
    texts = [columns.keys(), *(map(cell_text, line) for line in lines)]
    return "\n".join(", ".join(text).rstrip() for text in texts)


def cell_text(cell: Any) -> str:
    """The text of a cell; whole numbers without a decimal point."""
    if isinstance(cell, float):
        return f"{cell:.0f}" if cell.is_integer() and abs(cell) < WHOLE else repr(cell)
    return str(cell)


def with_mode(text: str, row: int, label: str) -> str:
    """The text of a CSV file with another mode of a row, counted from 0, and all else as it is;
    label: "" for the nearest one. Raises InvalidInput."""
    columns = columns_of_text(text)
    count = len(next(iter(columns.values())))
    if not 0 <= row < count:
        raise InvalidInput(f"row {row + 1}: must lie in 1 .. {count}")
    label = check_label(label, f"row {row + 1}") if label else ""
    names, file, lines = [*columns], Text("measured", text), text.splitlines()
    mark = delimiter_of([line.text for line in filled_lines(file)])
    rows = rows_of(file)
    chosen, has_modes = rows[len(rows) - count + row], "mode" in names
    place = names.index("mode") if has_modes else len(names)
    for each in [chosen] if has_modes and mark != " " else rows:
        cells = raw_cells(lines[each.line - 1], each, mark)
        if not has_modes:
            cells.append(" mode" if each is rows[0] else " ")
        if each is chosen:
            blanks = len(cells[place]) - len(cells[place].lstrip())
            cells[place] = cells[place][:blanks] + label
        lines[each.line - 1] = (mark.strip(" ") or ",").join(cells).rstrip(" ")
    return "\n".join(lines)


def raw_cells(line: str, row: Row, mark: str) -> list[str]:
    """The cells of a line with the blanks around them, as they are typed; without them where blanks
    separate them, or some are in quotes."""
    return list(row.cells) if mark == " " or '"' in line else line.split(mark)


def columns_of_table(table: Any) -> dict[str, list[Any]]:
    """The columns of a table by name. Raises InvalidInput."""
    if hasattr(table, "to_dict"):  # of pandas
        table = {name: list(column) for name, column in table.to_dict("list").items()}
    if not isinstance(table, Mapping):
        records = list(table) if isinstance(table, Iterable) else []
        if not records or not all(isinstance(record, Mapping) for record in records):
            raise InvalidInput("measured: must be a file, a table of columns, or a list of records")
        table = {name: [record.get(name) for record in records] for name in records[0]}
    columns = {
        column_name(str(name), "measured"): cells_of(column) for name, column in table.items()
    }
    if len({len(column) for column in columns.values()}) > 1:
        raise InvalidInput("measured: the columns must be of the same length")
    return columns


def cells_of(column: Any) -> list[Any]:
    """The cells of a column: a list, an array, or one number."""
    if isinstance(column, list | tuple):
        return list(column)
    return list(np.atleast_1d(np.asarray(column, object)))


def column_name(text: str, source: str) -> str:
    """The column of a name, which may have its unit in brackets: "speed [rpm]", "frequency [Hz]".
    Raises InvalidInput."""
    name, _, unit = (part.strip(" ])") for part in text.replace("(", "[").partition("["))
    key = name if name in COLUMNS else NAMES.get(name.lower(), name.lower())
    if unit and key in FREQUENCIES:
        key = "hertz" if unit.lower() == "hz" else key if unit == "1/T*" else unit
    elif unit and key not in ("error", "mode") and unit not in ("-", "deg"):
        unit = NAMES.get(unit.lower(), unit)
        key = unit if unit in BY_NAME else f"{key}:{unit}"
    if key not in COLUMNS:
        raise InvalidInput(f"{source}: {unknown_keyword('column', text, COLUMNS, NAMES)}")
    return key


def measured_row(
    units: Units | None, row: dict[str, Any], frequency: str, place: str
) -> MeasuredFrequency:
    """The measured frequency of a row; its error is in the unit of the frequency."""
    unit = frequency_unit(units, place) if frequency == "hertz" else 1.0
    numbers = []
    for name, cell in row.items():
        if name not in (*FREQUENCIES, "error", "mode"):
            number, factor = parse_over(name, units)
            value = number_in(cell, f"{place}, {name}") / factor
            low, high = NUMBERS[number].limits
            numbers.append((number, check_float(f"{place}, {number}", value, low, high)))
    error = row.get("error")
    return MeasuredFrequency(
        positive_in(row[frequency], f"{place}, {frequency}") * unit,
        math.nan if is_empty(error) else positive_in(error, f"{place}, error") * unit,
        check_label(label, place) if (label := label_in(row.get("mode"))) else "",
        tuple(sorted(numbers)),
    )


def frequency_unit(units: Units | None, place: str) -> float:
    """The frequency [1/T*] of 1 Hz. Raises InvalidInput where the size is not known."""
    if units is None:
        raise InvalidInput(f"{place}: hertz needs the size of the beam: give it in SI units")
    return float(1 / units.hertz(1.0))


def label_in(cell: Any) -> str:
    """The label of a mode in a cell, "" for none."""
    return "" if is_empty(cell) else str(cell).strip()


def is_empty(cell: Any) -> bool:
    return cell is None or cell != cell or not str(cell).strip()


def number_in(cell: Any, place: str) -> float:
    """The number of a cell. Raises InvalidInput."""
    try:
        return check_float(place, float(cell))
    except (TypeError, ValueError):
        raise InvalidInput(f"{place} = {cell!r}: must be a finite number") from None


def positive_in(cell: Any, place: str) -> float:
    """The number above 0 of a cell. Raises InvalidInput."""
    value = number_in(cell, place)
    if value <= 0:
        raise InvalidInput(f"{place} = {cell}: must be above 0")
    return value


def check_label(label: str, place: str) -> str:
    """A label of a mode, as B1. Raises InvalidInput."""
    label = label.strip()
    match = LABEL.fullmatch(label)
    if match is None or int(match[1]) > MAX_MODES:
        raise InvalidInput(f"{place}, mode = {label!r}: must be a label, as B1, S1, F1 or L1")
    return label


def target_frequencies(beam: Beam, targets: Any) -> list[MeasuredFrequency]:
    """The frequencies of modes by their labels, in 1/T* or a text with a unit, as "4.2 Hz". Raises
    InvalidInput."""
    if not isinstance(targets, Mapping) or not targets:
        raise InvalidInput(f"targets = {targets!r}: must be frequencies by mode, as {{'B1': 3.6}}")
    rows = []
    for label, value in targets.items():
        place = f"target {label}"
        quantity = parse_quantity(value) if isinstance(value, str) else None
        unit = 1.0
        if quantity is not None:
            value = quantity.value
            if quantity.unit:
                size = unit_size(quantity.unit, "Hz")
                if size is None:
                    raise InvalidInput(f"{place}: unit {quantity.unit!r}: must be Hz, kHz or 1/min")
                unit = size * frequency_unit(beam.units, place)
        frequency = positive_in(value, place) * unit
        rows.append(MeasuredFrequency(frequency, math.nan, check_label(str(label), place), ()))
    return rows
