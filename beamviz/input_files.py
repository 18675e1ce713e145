"""Small files that describe a beam or a scene: TOML, and stations along a blade as CSV."""

import contextlib
import csv
import io
import re
import tomllib
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

from beamviz.checks import check_float
from beamviz.errors import InvalidInput, did_you_mean, unknown_keyword

MAX_TOML_BYTES = 64_000
DELIMITERS = ";\t"  # of a heading without a comma


def read_small(path: str | Path) -> bytes:
    """The start of a file, a byte more than a file may have; InvalidInput if unreadable."""
    try:
        with Path(path).open("rb") as file:
            return file.read(MAX_TOML_BYTES + 1)
    except (OSError, ValueError) as error:  # ValueError: of a null character in the name
        raise InvalidInput(f"{path}: {getattr(error, 'strerror', None) or error}") from None


def decoded(text: bytes, name: str, kind: str) -> str:
    """The text of a file called `name`; InvalidInput if it is too large or not in UTF-8."""
    if len(text) > MAX_TOML_BYTES:
        raise InvalidInput(f"{name}: larger than {MAX_TOML_BYTES} bytes, not a file of beamviz")
    try:
        return text.decode("utf-8-sig")  # some editors write a byte-order mark
    except ValueError as error:
        raise InvalidInput(f"{name}: not a {kind} file ({error})") from None


def parse_toml(text: bytes, name: str) -> dict[str, Any]:
    """The contents of a TOML file called `name`; InvalidInput if it is too large or not TOML."""
    try:
        return tomllib.loads(decoded(text, name, "TOML"))
    except (ValueError, RecursionError) as error:
        if isinstance(error, InvalidInput):
            raise
        raise InvalidInput(f"{name}: not a TOML file ({error})") from None


@contextlib.contextmanager
def errors_of_file(name: str, units: Mapping[str, str] | None = None) -> Iterator[None]:
    """Within, the errors of values name the file they are from, and the units of their keys."""
    known = units or {}

    def with_unit(key: re.Match[str]) -> str:
        return f"{key[0]} [{known[key[0]]}]" if key[0] in known else key[0]

    try:
        yield
    except InvalidInput as error:
        message = error.args[0].removeprefix(f"{name}: ")
        text = re.sub(r"(?:(?<=^)|(?<=[:;] ))[a-z_]+(?= = )", with_unit, message)
        raise InvalidInput(f"{name}: {text}", error.use) from None


def check_keys(data: Collection[str], keys: Collection[str], source: str) -> None:
    """InvalidInput for the first key of `data` that is not among `keys`."""
    unknown = sorted(set(data) - set(keys))
    if unknown:
        hint = did_you_mean(unknown[0], keys)
        raise InvalidInput(f"{source}: unknown key {unknown[0]!r}; known: {', '.join(keys)}{hint}")


def read_columns(
    path: str | Path, units: Mapping[str, str], required: Collection[str]
) -> dict[str, tuple[float, ...]]:
    """The columns of numbers of a CSV file by name. Lines that are empty or begin with # are
    skipped; a name may have its unit in brackets, as "mass_per_length [kg/m]".

    units: of the columns that a file may have. Raises InvalidInput for a column that is unknown,
    missing, or in another unit, and for a cell that is no number.
    """
    text = decoded(read_small(path), str(path), "CSV")
    lines = [line for line in text.splitlines() if line.strip() and line.strip()[0] != "#"]
    heading = lines[0] if lines else ""
    delimiter = next((mark for mark in DELIMITERS if mark in heading and "," not in heading), ",")
    try:
        rows = [*csv.reader(io.StringIO("\n".join(lines)), delimiter=delimiter)]
    except csv.Error as error:
        raise InvalidInput(f"{path}: not a CSV file ({error})") from None
    names = [column_name(cell, units, path) for cell in rows[0]] if rows else []
    for name in required:
        if name not in names:
            raise InvalidInput(f"{path}: missing column {name!r} [{units[name]}]")
    if len(set(names)) < len(names):
        raise InvalidInput(f"{path}: a column is there twice: {', '.join(names)}")
    for number, row in enumerate(rows):
        if len(row) != len(names):
            raise InvalidInput(f"{path}: row {number} has {len(row)} cells, not {len(names)}")
    if len(rows) < 2:
        raise InvalidInput(f"{path}: has no stations, only names of columns")
    return {
        name: tuple(number_in(cell, f"{path}: {name}") for cell in cells)
        for name, *cells in zip(names, *rows[1:], strict=True)
    }


def column_name(cell: str, units: Mapping[str, str], path: str | Path) -> str:
    """The name of a column; InvalidInput if it is unknown or in another unit."""
    name, bracket, unit = (part.strip() for part in cell.partition("["))
    if name not in units:
        raise InvalidInput(f"{path}: {unknown_keyword('column', name, units, units=units)}")
    if bracket and unit.removesuffix("]") != units[name]:
        raise InvalidInput(f"{path}: {cell.strip()}: must be in {units[name]}")
    return name


def number_in(cell: str, name: str) -> float:
    """The number in a cell; InvalidInput with its name."""
    try:
        return check_float(name, float(cell))
    except ValueError as error:
        if isinstance(error, InvalidInput):
            raise
        raise InvalidInput(f"{name} = {cell!r}: must be a number") from None
