"""Structural files (st) of HAWC2: sets of stations, of which one is chosen.

A set has 19 columns, or 30 with a stiffness matrix of the section. The twist of the blade stands in
another file; that of a set, `pitch`, turns the principal axes from there.
"""

import re
from typing import NamedTuple

from beamviz.blade_files.data import BladeData
from beamviz.blade_files.table import FileTable, Text, fixed_table
from beamviz.errors import InvalidInput

SECTION = ("r", "m", "x_cg", "y_cg", "ri_x", "ri_y")
CENTRE = ("pitch", "x_e", "y_e")
BY_MODULUS = (
    *SECTION,
    *("x_sh", "y_sh", "E", "G", "I_x", "I_y", "I_p", "k_x", "k_y", "A"),
    *CENTRE,
)
STIFFNESS_MATRIX = tuple(f"K_{i}{j}" for i in range(1, 7) for j in range(i, 7))
BY_MATRIX = (*SECTION, *CENTRE, *STIFFNESS_MATRIX)


class Subset(NamedTuple):
    """A set of stations: #1 $2 is set 1, subset 2."""

    name: str  # as "1.2"
    first: int  # index of the line of its first station
    stations: int


def is_structure(file: Text) -> bool:
    return bool(re.search(r"^\s*#\s*\d+", file.text, re.M)) and bool(subsets(file))


def subsets(file: Text) -> list[Subset]:
    """The sets of a file."""
    sets, main = list[Subset](), ""
    for k, line in enumerate(file.lines):
        if match := re.match(r"\s*#\s*(\d+)", line.text):
            main = match[1]
        elif main and (match := re.match(r"\s*\$\s*(\d+)\s+(\d+)", line.text)):
            sets.append(Subset(f"{main}.{match[1]}", k + 1, int(match[2])))
    return sets


def read_structure(file: Text, chosen: str = "") -> BladeData:
    """The blade of a set, chosen by its name; the first one where none is. Raises InvalidInput,
    which lists the sets."""
    known = {subset.name: subset for subset in subsets(file)}
    subset = known.get(chosen) if chosen else next(iter(known.values()))
    if subset is None:
        raise InvalidInput(f"{file.name}: no set {chosen!r}; it has {', '.join(known)}")
    lines = file.lines[subset.first :]
    width = len(lines[0].text.split(";")[0].split()) if lines else 0
    columns = BY_MATRIX if width >= len(BY_MATRIX) else BY_MODULUS
    table = fixed_table(file, lines, columns, subset.stations, f"stations of set {subset.name}")
    values = {"stations": table.column("r"), "mass_per_length": table.column("m", positive=True)}
    values |= stiffnesses(table)
    if any(twist := table.column("pitch")):
        values["twist"] = twist
    left_out = ["torsion", "shear", "the twist of the axis, which another file has"]
    most = max(map(abs, table.column("x_cg")))
    if most:
        left_out.append(f"the offset of the centre of mass, up to {most:g} m")
    if len(known) > 1 and not chosen:
        others = ", ".join(name for name in known if name != subset.name)
        left_out.append(f"the sets {others} (to choose one: {file.name}#{others.split(', ')[0]})")
    return BladeData(values, left_out=tuple(left_out))


def stiffnesses(table: FileTable) -> dict[str, tuple[float, ...]]:
    """EI in the direction of the chord and across it, and EA. The axis x is along the chord."""
    if "E" not in table.columns:
        columns = {"flap_stiffness": "K_44", "bending_stiffness": "K_55", "axial_stiffness": "K_33"}
        return {key: table.column(name, positive=True) for key, name in columns.items()}
    modulus = table.column("E", positive=True)
    columns = {"flap_stiffness": "I_x", "bending_stiffness": "I_y", "axial_stiffness": "A"}
    return {
        key: tuple(E * x for E, x in zip(modulus, table.column(name, positive=True), strict=True))
        for key, name in columns.items()
    }
