"""The physical size of a beam, and its dimensionless numbers in SI units."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple, Self

from beamviz.errors import InvalidInput

ATTRIBUTES = {  # of datasets, by field
    "length": "unit_length_m",
    "time": "unit_time_s",
    "mass": "unit_mass_kg",
    "youngs_modulus": "youngs_modulus_Pa",
}


@dataclass(frozen=True)
class Units:
    """The physical size of a dimensionless beam: its length L [m], its time T* [s] and, where it is
    known, its mass rho A L [kg], of the section at the root. Young's modulus E [Pa] is that of a
    uniform beam whose material is known."""

    length: float
    time: float
    mass: float | None = None
    youngs_modulus: float | None = None

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

    def rpm(self, gamma):
        """Rotation speed [1/min] of a dimensionless one."""
        return 60 * self.hertz(gamma)


class Scale(NamedTuple):
    """A unit of one of the numbers of a beam. of: its value where the number is 1, None where the
    size of the beam is not known so far; key: the name of a column of values in it."""

    number: str
    unit: str
    of: Callable[[Units], float | None]
    key: str


SCALES = (  # of each number the usual one first; mu has none, as T* depends on it
    Scale("gamma", "rpm", lambda units: units.rpm(1.0), "rpm"),
    Scale("gamma", "rad/s", lambda units: 1 / units.time, "rad_per_s"),
    Scale("alpha", "kg", lambda units: units.mass, "kg"),
    Scale("beta", "mm", lambda units: 1000 * units.length, "mm"),
    Scale("beta", "m", lambda units: units.length, "m"),
    Scale("delta", "mm", lambda units: 1000 * units.length, "mm"),
    Scale("delta", "m", lambda units: units.length, "m"),
    Scale("spin_up", "rad/s^2", lambda units: 1 / units.time**2, "rad_per_s2"),
)


def usual_scale(number: str, units: Units | None) -> tuple[Scale, float] | None:
    """The usual unit of a number, and its value in it where it is 1; None without one."""
    if units is None:
        return None
    known = ((scale, scale.of(units)) for scale in SCALES if scale.number == number)
    return next(((scale, factor) for scale, factor in known if factor is not None), None)


def parse_over(text: str, units: Units | None) -> tuple[str, float]:
    """The number that varies, and the value of its unit in that of the number.

    text: a number alone, as "gamma" (then 1); a number with one of its units, as "gamma:rpm",
    "beta:mm"; or a unit that only one number has, as "rpm", "rad/s", "kg", "rad/s^2". Any other
    text is returned as it is. Raises InvalidInput for a unit of no or of two numbers, and where the
    size of the beam is not known.
    """
    number, colon, unit = text.partition(":") if ":" in text else ("", "", text)
    meant = [
        scale for scale in SCALES if scale.unit == unit and (not colon or scale.number == number)
    ]
    choices = [f"{scale.number}:{scale.unit}" for scale in meant or SCALES]
    if not meant and not colon:
        return text, 1.0
    if len(meant) != 1:
        known = " or ".join(choices) if meant else ", ".join(choices)
        raise InvalidInput(f"over {text}: must be {known}, or a number alone")
    factor = meant[0].of(units) if units else None
    if not factor:
        known = "the mass of the beam" if units else "the size of the beam"
        raise InvalidInput(f"over {text}: {known} is not known; give the beam in SI units")
    return meant[0].number, 1 / factor
