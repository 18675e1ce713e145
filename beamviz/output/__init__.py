"""Results as the command line prints them: tables for a terminal, JSON and CSV."""

from beamviz.beam import Beam
from beamviz.units import Units


def described_numbers(beam: Beam, without: str = "") -> str:
    """The numbers of a beam by name, but one."""
    numbers = beam.numbers.items()
    return ", ".join(f"{name} {value:.7g}" for name, value in numbers if name != without)


def described_units(units: Units) -> str:
    """The line of the units of a beam in SI."""
    return f"SI units     L = {units.length:g} m, T* = {units.time:.7g} s"
