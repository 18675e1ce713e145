"""Results as the command line prints them: tables for a terminal, JSON and CSV."""

from beamviz.beam import Beam
from beamviz.units import Units


def described_numbers(beam: Beam, without: str = "") -> str:
    """The numbers of a beam by name, but one; in words what is not uniform."""
    numbers = beam.numbers.items()
    texts = [f"{name} {value:.7g}" for name, value in numbers if name != without]
    return ", ".join([*texts, *beam.structure])


def units_record(units: Units) -> dict[str, float]:
    """The size of a beam in SI: length [m], time [s] and, where they are known, mass [kg] and yield
    stress [Pa]."""
    names = "length", "time", "mass", "yield_stress"
    sizes = {name: getattr(units, name) for name in names}
    return {name: size for name, size in sizes.items() if size is not None}


def described_units(beam: Beam, units: Units) -> str:
    """The line of the units of a beam in SI, and of its mass."""
    text = f"SI units     L = {units.length:g} m, T* = {units.time:.7g} s"
    properties = beam.mass_properties
    if properties is None:
        return text
    return f"{text}, mass {properties.mass:.7g} kg with its centre at {properties.centre:.7g} m"
