"""Blade files of FLEX5 (.bld): a line that may name a version, the number of stations, a row for
each. They have no axial stiffness."""

import re

from beamviz.blade_files.data import BladeData
from beamviz.blade_files.table import Text, fixed_table, is_number
from beamviz.errors import InvalidInput

BEFORE_3 = ("r", "EI flap", "EI edge", "mass", "twist")
COLUMNS = {  # the leading ones, by version
    0: BEFORE_3,
    1: BEFORE_3,
    2: BEFORE_3,
    3: ("r", "EI flap", "EI edge", "GKt", "mass", "Jxx", "bend flap", "bend edge", "twist"),
}
WIDTHS = {0: 8, 1: 8, 2: 9, 3: 13}  # of a row


def version(file: Text) -> int:
    """That in the first line, as V003; 0 without one."""
    match = re.match(r"\s*[vV]\s*0*(\d+)", file.text)
    return int(match[1]) if match else 0


def is_blade(file: Text) -> bool:
    lines = file.lines
    if len(lines) < 4 or not re.match(r"\s*\d+(\s|$)", lines[1].text):
        return False
    rows = [line.words for line in lines[2:4]]
    width = WIDTHS.get(version(file), 8)
    return all(len(row) >= width and all(map(is_number, row[:5])) for row in rows)


def read_blade(file: Text) -> BladeData:
    """The blade of a file of version 0 .. 3."""
    number, lines = version(file), file.lines
    if number not in COLUMNS:
        raise InvalidInput(f"{file.name}: version {number}: must be one of 0 .. {max(COLUMNS)}")
    count = int(lines[1].words[0])
    table = fixed_table(file, lines[2:], COLUMNS[number], count, "stations")
    values = {
        "stations": table.column("r"),
        "mass_per_length": table.column("mass", positive=True),
        "bending_stiffness": table.column("EI edge", positive=True),
        "flap_stiffness": table.column("EI flap", positive=True),
        "twist": table.column("twist"),
    }
    return BladeData(values, left_out=("torsion", "the bend of the unloaded blade", "the cone"))
