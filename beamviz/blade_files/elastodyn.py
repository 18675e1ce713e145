"""Blade and main input files of ElastoDyn (OpenFAST) and of FAST before it.

A blade file has stations as fractions of the span and no axial stiffness; the main file beside it
has radii and speed, and names the blade file.
"""

from pathlib import Path

from beamviz.blade_files.data import BladeData
from beamviz.blade_files.table import Text, entries_of, entry, fixed_table
from beamviz.errors import InvalidInput

COLUMNS = {
    "BlFract": "stations",
    "StrcTwst": "twist",
    "BMassDen": "mass_per_length",
    "EdgStff": "bending_stiffness",
    "FlpStff": "flap_stiffness",
}
AXIAL = "EAStff"  # a column of former versions, often without values
BLADE_FILE = ("bldfile(1)", "bldfile1")  # the entry that names it, by version
FACTORS = {
    "mass_per_length": "AdjBlMs",
    "flap_stiffness": "AdjFlSt",
    "bending_stiffness": "AdjEdSt",
}


def is_blade(file: Text) -> bool:
    return {"blfract", "bmassden"} <= set(file.text.lower().split())


def read_blade(file: Text) -> BladeData:
    """The blade of a file with a table of BlFract, StrcTwst, BMassDen, FlpStff, EdgStff."""
    lines, spelled = file.lines, {name.lower(): name for name in (*COLUMNS, AXIAL)}
    head = next(k for k, line in enumerate(lines) if "blfract" in line.text.lower().split())
    columns = [spelled.get(name.lower(), name) for name in lines[head].words]
    for name in COLUMNS:
        if name not in columns:
            raise InvalidInput(f"{file.name}: line {lines[head].number}: missing column {name}")
    entries = entries_of(file)
    count = int(entry(file, entries, "NBlInpSt"))
    table = fixed_table(file, lines[head + 2 :], columns, count, "stations of NBlInpSt")
    values = {
        key: table.column(name, positive=key not in ("stations", "twist"))
        for name, key in COLUMNS.items()
    }
    if AXIAL in columns and min(axial := table.column(AXIAL)) > 0:
        values["axial_stiffness"] = axial
    for key, name in FACTORS.items():
        factor = entry(file, entries, name, 1.0)
        values[key] = tuple(factor * value for value in values[key])
    return BladeData(values, has_fractions=True, left_out=("torsion", "offsets of the axes"))


def is_main(file: Text) -> bool:
    names = entries_of(file).keys()
    return {"tiprad", "hubrad"} <= names and not names.isdisjoint(BLADE_FILE)


def read_main(file: Text) -> BladeData:
    """Radii, speed, pitch and the name of the blade file of a main input file."""
    entries = entries_of(file)
    hub, tip = entry(file, entries, "HubRad"), entry(file, entries, "TipRad")
    values = {
        "length": tip - hub,
        "hub_radius": hub,
        "rotation_rpm": entry(file, entries, "RotSpeed", 0.0),
        "pitch": entry(file, entries, "BlPitch(1)", 0.0),
    }
    left_out = []
    cone = entry(file, entries, "PreCone(1)", 0.0)
    if cone:
        left_out.append(f"the cone of {cone:g} deg")
    if tip_mass := entry(file, entries, "TipMass(1)", 0.0):
        values["mass"] = tip_mass
    blade_file = next(entries[name].text for name in BLADE_FILE if name in entries)
    return BladeData(values, left_out=tuple(left_out), blade_file=Path(blade_file))
