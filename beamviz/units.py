"""The physical size of a beam, and its dimensionless numbers in SI units."""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import NamedTuple, Self

from beamviz.errors import InvalidInput

# Significant digits, on pages and in charts: of the places and frequencies of events and limits;
# of the gap between two frequencies, whose digits cancel.
PLACE_DIGITS, GAP_DIGITS = 5, 3
RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
ATTRIBUTES = {  # of datasets, by field
    "length": "unit_length_m",
    "time": "unit_time_s",
    "mass": "unit_mass_kg",
    "youngs_modulus": "youngs_modulus_Pa",
    "yield_stress": "yield_stress_Pa",
    "section_height": "section_height_m",
}


@dataclass(frozen=True)
class Units:
    """The physical size of a dimensionless beam: its length L [m], its time T* [s] and, where it is
    known, its mass rho A L [kg], of the section at the root. Of a uniform beam whose material is
    known also Young's modulus E [Pa], and if given the yield stress [Pa] and the height of its
    section in the plane of bending [m]."""

    length: float
    time: float
    mass: float | None = None
    youngs_modulus: float | None = None
    yield_stress: float | None = None
    section_height: float | None = None

    @property
    def force(self) -> float | None:
        """The unit of force E I / L^2 = rho A L^2 / T*^2 [N], where the mass is known."""
        return None if self.mass is None else self.mass * self.length / self.time**2

    @property
    def attributes(self) -> dict[str, float]:
        """The sizes that are known as attributes of a dataset."""
        sizes = {name: getattr(self, field) for field, name in ATTRIBUTES.items()}
        return {name: size for name, size in sizes.items() if size is not None}

    @classmethod
    def from_attributes(cls, attributes: Mapping[str, float]) -> Self | None:
        """The units in the attributes of a dataset, None where it has none."""
        sizes = {
            field: attributes[name] for field, name in ATTRIBUTES.items() if name in attributes
        }
        return cls(**sizes) if {"length", "time"} <= sizes.keys() else None

    def angular_frequency(self, frequency):
        """Frequency [rad/s] of a dimensionless one (units of 1/T*)."""
        return frequency / self.time

    def hertz(self, frequency):
        """Frequency [Hz] of a dimensionless one (units of 1/T*)."""
        return frequency / (2 * math.pi * self.time)

    def newtons(self, force):
        """Force [N] of a dimensionless one (units of E I / L^2); None where the mass is unknown."""
        return None if self.force is None else force * self.force

    def newton_metres(self, moment):
        """Moment [N m] of a dimensionless one (units of E I / L); None as in `newtons`."""
        return None if self.force is None else moment * self.force * self.length

    def rpm(self, gamma):
        """Rotation speed [1/min] of a dimensionless one."""
        return 60 * self.hertz(gamma)


class Rung(NamedTuple):
    """A unit of a quantity: `size` in SI, used for values from `least` on, both in SI."""

    unit: str
    size: float
    least: float


PREFIXES = {"G": 1e9, "M": 1e6, "k": 1e3, "": 1.0, "m": 1e-3, "µ": 1e-6, "n": 1e-9}


def prefixed(unit: str, prefixes: Iterable[str]) -> tuple[Rung, ...]:
    """An SI unit with each of some prefixes, from large to small."""
    return tuple(Rung(f"{prefix}{unit}", PREFIXES[prefix], PREFIXES[prefix]) for prefix in prefixes)


LONG = 5.0  # [m] length from which on that of a beam, and every place on it, is in m, else in mm
SMALL = 0.1  # [m] below which a single length is in mm in any case
# The units that values are shown in, of each quantity by its SI unit, from large to small.
LADDERS = {
    "N": prefixed("N", PREFIXES),
    "N m": prefixed("N m", PREFIXES),
    "J": prefixed("J", PREFIXES),
    "Hz": prefixed("Hz", ("G", "M", "k", "")),
    "s": prefixed("s", ("", "m", "µ", "n")),
    "m": (
        Rung("m", 1.0, SMALL),
        Rung("mm", 1e-3, 1e-4),
        Rung("µm", 1e-6, 1e-7),
        Rung("nm", 1e-9, 0.0),
    ),
    "kg": (
        Rung("t", 1e3, 1e5),
        Rung("kg", 1.0, 0.1),
        Rung("g", 1e-3, 1e-4),
        Rung("mg", 1e-6, 1e-7),
        Rung("µg", 1e-9, 0.0),
    ),
    "kg m²": (
        Rung("t m²", 1e3, 1e5),
        Rung("kg m²", 1.0, 0.1),
        Rung("g m²", 1e-3, 1e-4),
        Rung("kg mm²", 1e-6, 1e-7),
        Rung("g mm²", 1e-9, 1e-10),
        Rung("mg mm²", 1e-12, 0.0),
    ),
}


def unit_for(quantity: str, value: float) -> tuple[str, float]:
    """The unit in which a value in SI reads well, and its size in SI. quantity: the SI unit, which
    is also that of 0."""
    size = abs(value)
    if not (math.isfinite(size) and size > 0):
        return quantity, 1.0
    ladder = LADDERS[quantity]
    rung = next((step for step in ladder if size >= step.least * (1 - ROUNDING)), ladder[-1])
    return rung.unit, rung.size


ROUNDING = 1e-9  # relative, of a value that was meant to be at the end of a rung


class Scale(NamedTuple):
    """A unit of a number of a beam."""

    number: str
    unit: str
    quantity: str  # in SI
    key: str  # the name of a column of values
    # Its value where the number is 1, None where the size of the beam is not known that far.
    of: Callable[[Units], float | None]


SCALES = (  # of each number; mu has none, as T* depends on it
    Scale("gamma", "rpm", "rotation speed", "rpm", lambda units: units.rpm(1.0)),
    Scale("gamma", "rad/s", "rotation speed", "rad_per_s", lambda units: 1 / units.time),
    Scale("alpha", "kg", "mass", "kg", lambda units: units.mass),
    Scale("beta", "mm", "position of the mass", "mm", lambda units: 1000 * units.length),
    Scale("beta", "m", "position of the mass", "m", lambda units: units.length),
    Scale("delta", "mm", "hub radius", "mm", lambda units: 1000 * units.length),
    Scale("delta", "m", "hub radius", "m", lambda units: units.length),
    Scale("spin_up", "rad/s^2", "spin-up", "rad_per_s2", lambda units: 1 / units.time**2),
)


# By the name of a number in one of its units, as "gamma:rpm", its unit; by the unit alone, as
# "rpm", where only one number has it.
BY_NAME = {f"{scale.number}:{scale.unit}": scale for scale in SCALES}
BY_NAME |= {
    scale.unit: scale for scale in SCALES if [other.unit for other in SCALES].count(scale.unit) == 1
}


class Measured(NamedTuple):
    """A number in a unit: `factor` is its value where the number is 1."""

    scale: Scale
    factor: float


def usual_measure(number: str, units: Units | None) -> Measured | None:
    """A number in the unit of tables and files: rpm, kg, rad/s^2, mm, or m along a long beam; None
    without one."""
    if units is None:
        return None
    avoided = "mm" if units.length >= LONG else "m"
    known = (scale for scale in SCALES if scale.number == number and scale.unit != avoided)
    sizes = ((scale, scale.of(units)) for scale in known)
    return next((Measured(scale, of) for scale, of in sizes if of is not None), None)


ANGLES = ("pitch", "twist")  # numbers of a beam in degrees


class DisplayUnit(NamedTuple):
    """A unit to show values in: `factor` is the value in it of a dimensionless 1."""

    unit: str
    factor: float


def display_unit(number: str, units: Units | None) -> DisplayUnit | None:
    """The unit that a number of a beam, its "frequency" or a "time" is shown in, on pages and in
    charts; None without one. Angles are in degrees in any case."""
    if number in ANGLES:
        return DisplayUnit("deg", 1.0)
    if units is None:
        return None
    if number == "frequency":
        return suited_unit("Hz", units.hertz(1.0))
    if number == "time":
        return suited_unit("s", units.time, typical=10.0)
    usual = usual_measure(number, units)
    if usual is None:
        return None
    if usual.scale.unit == "kg":
        return suited_unit("kg", usual.factor)
    return DisplayUnit(usual.scale.unit.replace("^2", "²"), usual.factor)


def suited_unit(quantity: str, unit_size: float, typical: float = 1.0) -> DisplayUnit:
    """A quantity, by its SI unit, whose dimensionless 1 is `unit_size` in SI, in the unit for a
    typical dimensionless value."""
    unit, size = unit_for(quantity, unit_size * typical)
    return DisplayUnit(unit, unit_size / size)


def number_of(name: str) -> str:
    """The number of a name in a unit: gamma of "rpm"; any other name is returned as it is."""
    return BY_NAME[name].number if name in BY_NAME else name


def parse_over(name: str, units: Units | None) -> tuple[str, float]:
    """The number of a name in a unit, as "rpm", "kg" or "beta:mm" (see BY_NAME), and its value in
    this unit where it is 1; any other name, as "gamma", with 1. Raises InvalidInput where the size
    of the beam is not known."""
    scale = BY_NAME.get(name)
    if scale is None:
        return name, 1.0
    factor = scale.of(units) if units else None
    if factor is None:
        unknown = "the mass of the beam" if units else "the size of the beam"
        raise InvalidInput(f"over {name}: {unknown} is not known: give the beam in SI units")
    return scale.number, factor


def significant(value: float, digits: int) -> str:
    """A number with `digits` significant digits, or more before the point: '1234', '0.00012',
    '1.2 × 10⁻⁵'."""
    if abs(value) >= 10.0 ** (digits - 1):
        return f"{value:.0f}"
    mantissa, _, exponent = f"{value:.{digits}g}".partition("e")
    return f"{mantissa} × 10{str(int(exponent)).translate(RAISED)}" if exponent else mantissa


def place_number(value: float) -> str:
    """A place or a frequency of an event or a limit, with zeros at its end: '10.600'."""
    text = f"{value:#.{PLACE_DIGITS}g}"
    return significant(value, PLACE_DIGITS) if "e" in text or not value else text.removesuffix(".")


def gap_number(value: float) -> str:
    """The gap between two frequencies: '0.644'."""
    return significant(value, GAP_DIGITS)
