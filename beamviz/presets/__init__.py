"""Blades to start from, by name: a file of SI values each, and what to know about it."""

from functools import cache
from pathlib import Path
from typing import NamedTuple

from beamviz.beam import Beam
from beamviz.checks import check_choice

FOLDER = Path(__file__).parent


class Preset(NamedTuple):
    """A blade to start from."""

    title: str  # its name for readers
    file: Path  # its SI values (TOML)
    source: str  # where they are from
    left_out: str = ""  # what this model leaves out
    is_twisted: bool = True  # whether it has the twist of the file

    @property
    def beam(self) -> Beam:
        return read(self.file, self.is_twisted)


@cache
def read(file: Path, is_twisted: bool) -> Beam:
    """The beam of a file, which is read once, or the same without its twist."""
    beam = Beam.from_toml(file)
    if is_twisted:
        return beam
    return Beam.from_si(**{key: value for key, value in beam.si.items() if key != "twist"})


NREL_SOURCE = (
    "The blade of the NREL 5 MW reference wind turbine: mass and stiffnesses at 49 stations"
    " (Jonkman et al., NREL/TP-500-38060, 2009, table 2-1), at its rated 12.1 rpm."
)
TASK_37 = "Bortolotti et al., IEA Wind TCP Task 37, NREL/TP-5000-73492, 2019"
LEFT_OUT = (
    "This model leaves out torsion, the coupling of bending with it, offsets of the axes, prebend,"
    " the cone of the rotor, air and weight."
)
NO_STRETCH = f"{LEFT_OUT} The table has no axial stiffness: the blade does not stretch."


def iea_blade(power: str, name: str, source: str, rpm: str) -> Preset:
    """A reference blade of IEA Wind Task 37."""
    return Preset(
        f"IEA {power} MW blade",
        FOLDER / f"{name}.toml",
        f"The blade of the IEA {power} MW reference wind turbine: twist, mass and stiffnesses"
        f" of its ElastoDyn file ({source}), at its rated {rpm} rpm.",
        NO_STRETCH,
    )


PRESETS = {
    "tapered-steel-blade": Preset(
        "tapered steel blade",
        FOLDER / "tapered_steel_blade.toml",
        "A bar of steel, 1 m long and 40 mm wide; its thickness falls from 12 mm at the root to"
        " 6 mm at the tip, the taper of Ozdemir Ozgumus & Kaya (J. Sound Vib. 289, 2006). 600 rpm.",
    ),
    "nrel-5mw-blade": Preset(
        "NREL 5 MW blade, untwisted",
        FOLDER / "nrel_5mw_blade.toml",
        NREL_SOURCE,
        "This model leaves out the twist of the blade (13° at the root), so that each plane of"
        " bending is by itself, as a motion in time needs it; torsion, the coupling of bending with"
        " it, offsets of the axes, prebend, the cone of the rotor, air and weight. A real blade"
        " vibrates flapwise and edgewise at once.",
        is_twisted=False,
    ),
    "nrel-5mw-twisted-blade": Preset(
        "NREL 5 MW blade", FOLDER / "nrel_5mw_blade.toml", NREL_SOURCE, LEFT_OUT
    ),
    "iea-3.4mw-blade": iea_blade("3.4", "iea_3_4mw_blade", TASK_37, "11.75"),
    "iea-10mw-blade": iea_blade("10", "iea_10mw_blade", TASK_37, "8.68"),
    "iea-15mw-blade": iea_blade(
        "15", "iea_15mw_blade", "Gaertner et al., NREL/TP-5000-75698, 2020", "7.56"
    ),
}


def preset(name: str) -> Preset:
    """The preset of a name. Raises InvalidInput, which lists the names."""
    return PRESETS[check_choice("preset", name, PRESETS)]
