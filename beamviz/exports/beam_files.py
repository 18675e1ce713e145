"""A beam in SI as a file that `Beam.from_file` reads: all of it as TOML, its stations as CSV."""

from beamviz.beam import Beam
from beamviz.blade_files.delimited import COLUMNS
from beamviz.errors import InvalidInput
from beamviz.files import csv_text
from beamviz.scene import inline_toml
from beamviz.si import PhysicalBeam

STATIONS = ".stations.csv"  # the end of the name of a table of stations


def beam_toml(beam: Beam) -> str:
    """The keywords of `Beam.from_si` as TOML. Raises InvalidInput for a beam without a size."""
    physical_of(beam)
    return "".join(f"{key} = {inline_toml(value)}\n" for key, value in beam.si.items())


def stations_csv(beam: Beam) -> str:
    """The section at each station, by the columns of a file of stations. What has no column (hub,
    speed, pitch, bodies, root) is left out. Raises InvalidInput for a beam without a size, or one
    whose properties are not linear between stations."""
    physical = physical_of(beam)
    if physical.degree > 1:
        raise InvalidInput(
            f"a table of stations is linear between them, this blade has polynomials of degree"
            f" {physical.degree}: export it as .toml"
        )
    values = {
        "station": physical.stations,
        "mass_per_length": physical.mass_per_length,
        "bending_stiffness": physical.bending_stiffness,
        "axial_stiffness": None if physical.is_inextensible else physical.axial_stiffness,
        "flap_stiffness": physical.flap_stiffness,
        "twist": beam.si.get("twist") if physical.twists else None,
    }
    columns = {name: row for name in COLUMNS if (row := values[name]) is not None}
    return csv_text(columns, zip(*columns.values(), strict=True))


def physical_of(beam: Beam) -> PhysicalBeam:
    """The beam in SI. Raises InvalidInput where its size is not known."""
    if beam.physical is None:
        raise InvalidInput("the size of the beam is not known: give it in SI units (--si)")
    return beam.physical
