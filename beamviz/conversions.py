"""Units in which values are typed or stand in files, and their sizes in SI."""

import math
import re
from typing import NamedTuple

from beamviz.errors import InvalidInput

INCH, FOOT = 0.0254, 0.3048  # [m]
POUND, POUND_FORCE = 0.45359237, 4.4482216152605  # [kg], [N]
DEGREE, TURN = math.pi / 180, 2 * math.pi

# Of each quantity, by its SI unit, the units it may be given in and their sizes. A pound is a mass
# or a force, as the quantity has it.
CONVERSIONS = {
    "m": {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "in": INCH, "ft": FOOT},
    "m^2": {"m^2": 1.0, "mm^2": 1e-6, "cm^2": 1e-4, "in^2": INCH**2, "ft^2": FOOT**2},
    "m^4": {"m^4": 1.0, "mm^4": 1e-12, "cm^4": 1e-8, "in^4": INCH**4, "ft^4": FOOT**4},
    "kg": {"kg": 1.0, "g": 1e-3, "t": 1e3, "lb": POUND},
    "kg/m": {
        "kg/m": 1.0,
        "g/m": 1e-3,
        "g/mm": 1.0,
        "t/m": 1e3,
        "lb/in": POUND / INCH,
        "lb/ft": POUND / FOOT,
        "slug/ft": POUND_FORCE / FOOT**2,
    },
    "kg/m^3": {"kg/m^3": 1.0, "g/cm^3": 1e3, "t/m^3": 1e3, "lb/in^3": POUND / INCH**3},
    "kg m^2": {"kg m^2": 1.0, "g mm^2": 1e-9, "kg mm^2": 1e-6, "lb in^2": POUND * INCH**2},
    "N": {"N": 1.0, "kN": 1e3, "MN": 1e6, "GN": 1e9, "lb": POUND_FORCE},
    "N m^2": {
        "N m^2": 1.0,
        "kN m^2": 1e3,
        "MN m^2": 1e6,
        "GN m^2": 1e9,
        "N mm^2": 1e-6,
        "lb in^2": POUND_FORCE * INCH**2,
        "lb ft^2": POUND_FORCE * FOOT**2,
    },
    "N m/rad": {
        "N m/rad": 1.0,
        "N m": 1.0,
        "kN m/rad": 1e3,
        "N m/deg": 1 / DEGREE,
        "lb in/rad": POUND_FORCE * INCH,
    },
    "Pa": {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "psi": POUND_FORCE / INCH**2},
    "s": {"s": 1.0, "ms": 1e-3, "min": 60.0},
    "Hz": {"Hz": 1.0, "kHz": 1e3, "1/min": 1 / 60},
    "rad/s": {"rad/s": 1.0, "rpm": TURN / 60, "1/min": TURN / 60, "deg/s": DEGREE, "Hz": TURN},
    "1/min": {"1/min": 1.0, "rpm": 1.0, "rad/s": 60 / TURN, "deg/s": 1 / 6, "Hz": 60.0},
    "rad/s^2": {"rad/s^2": 1.0, "deg/s^2": DEGREE},
    "deg": {"deg": 1.0, "rad": 1 / DEGREE},
}


class GivenQuantity(NamedTuple):
    """A number with the unit that was written beside it, "" without one."""

    value: float
    unit: str


def plain_unit(unit: str) -> str:
    """A unit in the one spelling that is compared: without blanks, points, signs of powers and of
    products; a pound of force is a pound."""
    spelled = unit.strip().replace("²", "2").replace("³", "3").replace("⁴", "4").replace("°", "deg")
    return re.sub(r"lb[fms]\b|lb[fm](?=[^a-z]|in|ft)", "lb", re.sub(r"[\s^*·.\-]", "", spelled))


def unit_size(unit: str, si_unit: str) -> float | None:
    """The size in SI of a unit of a quantity, by the SI unit of this; None for one of another
    quantity."""
    sizes = {plain_unit(name): size for name, size in CONVERSIONS.get(si_unit, {}).items()}
    return sizes.get(plain_unit(unit))


def checked_unit_size(name: str, unit: str, si_unit: str) -> float:
    """The size in SI of a unit. Raises InvalidInput, which lists the units of this quantity."""
    size = 1.0 if plain_unit(unit) == plain_unit(si_unit) else unit_size(unit, si_unit)
    if size is None:
        known = ", ".join(CONVERSIONS.get(si_unit, {si_unit: 1.0}))
        raise InvalidInput(f"{name}: unit {unit!r}: must be one of {known}")
    return size


def parse_quantity(text: str) -> GivenQuantity | None:
    """A number and its unit, as "300rpm" or "24 in"; None for a text that is neither."""
    match = re.fullmatch(r"\s*([-+]?[\d.][\d.]*(?:[eE][-+]?\d+)?)\s*([a-zA-Z°].*?)?\s*", text)
    if not match:
        return None
    try:
        return GivenQuantity(float(match[1]), match[2] or "")
    except ValueError:
        return None


def in_si(name: str, value: object, si_unit: str) -> object:
    """A text that is a number with its unit in SI; any other value as it is. Raises InvalidInput
    for a unit of another quantity."""
    quantity = parse_quantity(value) if isinstance(value, str) else None
    if quantity is None or not quantity.unit:
        return value
    size = checked_unit_size(f"{name} = {value!r}", quantity.unit, si_unit)
    return quantity.value * size
