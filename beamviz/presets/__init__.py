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

    @property
    def beam(self) -> Beam:
        return read(self.file)


@cache
def read(file: Path) -> Beam:
    """The beam of a file, which is read once."""
    return Beam.from_toml(file)


PRESETS = {
    "tapered-steel-blade": Preset(
        "tapered steel blade",
        FOLDER / "tapered_steel_blade.toml",
        "A bar of steel, 1 m long and 40 mm wide; its thickness falls from 12 mm at the root to"
        " 6 mm at the tip, the taper of Ozdemir Ozgumus & Kaya (J. Sound Vib. 289, 2006). 600 rpm.",
    ),
    "nrel-5mw-blade": Preset(
        "NREL 5 MW blade",
        FOLDER / "nrel_5mw_blade.toml",
        "The blade of the NREL 5 MW reference wind turbine: mass and stiffnesses at 49 stations"
        " (Jonkman et al., NREL/TP-500-38060, 2009, table 2-1), at its rated 12.1 rpm.",
        "This model leaves out the twist of the blade (13° at the root), torsion, the coupling of"
        " bending with both, offsets of its axes, the cone of the rotor, air and weight. A real"
        " blade vibrates flapwise and edgewise at once.",
    ),
}


def preset(name: str) -> Preset:
    """The preset of a name. Raises InvalidInput, which lists the names."""
    return PRESETS[check_choice("preset", name, PRESETS)]
