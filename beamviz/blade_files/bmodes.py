"""Files of BModes: section properties, and the main input file (.bmi)."""

from pathlib import Path
from typing import Any

from beamviz.blade_files.data import BladeData
from beamviz.blade_files.table import Text, entries_of, entry, fixed_table
from beamviz.errors import InvalidInput

COLUMNS = {
    "sec_loc": "stations",
    "str_tw": "twist",
    "mass_den": "mass_per_length",
    "edge_stff": "bending_stiffness",
    "flp_stff": "flap_stiffness",
    "axial_stff": "axial_stiffness",
}
FACTORS = {
    "mass_per_length": "sec_mass_mult",
    "bending_stiffness": "edge_stff_mult",
    "flap_stiffness": "flp_stff_mult",
    "axial_stiffness": "axial_stff_mult",
}
OFFSETS = {
    "cg_offst": "offset of the centre of mass",
    "sc_offst": "offset of the shear centre",
    "tc_offst": "offset of the tension centre",
}


def is_sections(file: Text) -> bool:
    return {"sec_loc", "mass_den", "flp_stff"} <= set(file.text.lower().split())


def read_sections(file: Text) -> BladeData:
    """The blade of a table of sec_loc, str_tw, ..., tc_offst."""
    lines = file.lines
    head = next(k for k, line in enumerate(lines) if "sec_loc" in line.text.lower().split())
    columns = lines[head].text.lower().split()
    for name in COLUMNS:
        if name not in columns:
            raise InvalidInput(f"{file.name}: line {lines[head].number}: missing column {name}")
    count = int(entry(file, entries_of(file), "n_secs"))
    table = fixed_table(file, lines[head + 2 :], columns, count, "sections of n_secs")
    values = {
        key: table.column(name, positive=key not in ("stations", "twist"))
        for name, key in COLUMNS.items()
    }
    left_out = ["torsion"]
    for name, text in OFFSETS.items():
        if name in columns and (most := max(map(abs, table.column(name)))):
            left_out.append(f"the {text}, up to {most:g} m")
    return BladeData(values, has_fractions=True, left_out=tuple(left_out))


def is_main(file: Text) -> bool:
    return {"romg", "hub_rad", "sec_props_file"} <= entries_of(file).keys()


def read_main(file: Text) -> BladeData:
    """Radii, speed, pitch, the mass at the tip and the file of sections of a .bmi."""
    entries = entries_of(file)

    def number(name: str, otherwise: float | None = None) -> float:
        return entry(file, entries, name, otherwise)

    if (kind := number("beam_type", 1.0)) != 1:
        raise InvalidInput(f"{file.name}: beam_type = {kind:g}: must be 1, a blade")
    hub, tip = number("hub_rad"), number("radius")
    values: dict[str, Any] = {
        "length": tip - hub,
        "hub_radius": hub,
        "rotation_rpm": number("romg") * number("romg_mult", 1.0),
        "pitch": number("bl_thp", 0.0),
    }
    left_out = []
    if mass := number("tip_mass", 0.0):
        # Of the tip: about the axis of the blade z, about y in the section, and about x.
        inertia = [number(f"{axis}_tip", 0.0) for axis in ("izz", "iyy", "ixx")]
        values["masses"] = [{"mass": mass, "position": tip - hub, "inertia": inertia}]
        if offset := number("cm_loc", 0.0):
            left_out.append(f"the offset of the tip mass, {offset:g} m")
    if cone := number("precone", 0.0):
        left_out.append(f"the cone of {cone:g} deg")
    factors = {key: number(name, 1.0) for key, name in FACTORS.items()}
    return BladeData(
        values,
        left_out=tuple(left_out),
        blade_file=Path(entries["sec_props_file"].text),
        factors={key: factor for key, factor in factors.items() if factor != 1},
    )
