"""The numbers that `adjust` may change, their bounds, and the beam of a set of their values.

Each number is scaled to u in 0 .. 1 between its bounds, linearly or by its logarithm. A factor on a
property of the material or the section changes the unit of time T* of the beam:

    EI c:      T* / sqrt(c), gamma / sqrt(c), mu / sqrt(c), root stiffness / c
    EA c:      mu sqrt(c)
    rho A c:   T* sqrt(c), gamma sqrt(c), alpha / c

so speed and masses stay what they are in SI.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from beamviz.beam import NUMBERS, Beam
from beamviz.blade import Mass
from beamviz.checks import check_float
from beamviz.errors import InvalidInput, unknown_keyword
from beamviz.units import BY_NAME, parse_over

FACTORS = {  # what they multiply
    "bending_factor": "the bending stiffness E I",
    "axial_factor": "the axial stiffness E A",
    "mass_factor": "the mass of a unit of length rho A",
}
FACTOR_BOUNDS = (0.1, 10.0)
ROOT_BOUNDS = (0.01, 1e4)  # a hinge and a clamp to 1 % of the frequency
BY_LOGARITHM = ("mu", "flap", "root", *FACTORS)
MOST_FREE = 6


class FreeNumber(NamedTuple):
    """A number that may change. name: as given, in a unit too ("kg"); number: of the beam, or a
    factor; unit: the value of `name` where the number is 1; low, high: its bounds."""

    name: str
    number: str
    unit: float
    low: float
    high: float

    @property
    def by_logarithm(self) -> bool:
        return self.number in BY_LOGARITHM and self.low > 0

    def value(self, u: float) -> float:
        """The number at u in 0 .. 1."""
        u = min(max(float(u), 0.0), 1.0)
        if self.by_logarithm:
            value = self.low * (self.high / self.low) ** u
        else:
            value = self.low + (self.high - self.low) * u
        return min(max(value, self.low), self.high)

    def place(self, value: float) -> float:
        """The inverse of `value`, within the bounds."""
        value = min(max(value, self.low), self.high)
        if self.by_logarithm:
            return math.log(value / self.low) / math.log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)

    def slope(self, u: float) -> float:
        """d number / du."""
        if self.by_logarithm:
            return self.value(u) * math.log(self.high / self.low)
        return self.high - self.low


class BeamFamily(NamedTuple):
    """All beams that the free numbers make of a beam."""

    beam: Beam
    free: tuple[FreeNumber, ...]

    @property
    def start(self) -> NDArray:
        """The place u (free,) of the given beam, or the nearest within the bounds."""
        values = (getattr(self.beam, free.number, 1.0) for free in self.free)
        return np.array([free.place(v) for free, v in zip(self.free, values, strict=True)])

    def values(self, u: NDArray) -> dict[str, float]:
        """The values at u (free,), by name and in the units of the names."""
        return {
            free.name: free.value(each) * free.unit for free, each in zip(self.free, u, strict=True)
        }

    def at(self, u: NDArray, speed: float | None = None, **numbers: float) -> Beam:
        """The beam at u (free,), at a speed gamma and with other numbers in the time of the given
        beam. Raises InvalidInput where the numbers exclude each other."""
        values = {free.number: free.value(each) for free, each in zip(self.free, u, strict=True)}
        factors = {name: values.pop(name, 1.0) for name in FACTORS}
        values |= numbers | ({} if speed is None else {"gamma": speed})
        beam = self.beam.replace(**values)
        return beam if all(c == 1 for c in factors.values()) else multiplied(beam, **factors)

    def time_ratio(self, u: NDArray) -> float:
        """T* of the beam at u (free,) over that of the given beam."""
        values = {free.number: free.value(each) for free, each in zip(self.free, u, strict=True)}
        return math.sqrt(values.get("mass_factor", 1.0) / values.get("bending_factor", 1.0))


def multiplied(beam: Beam, bending_factor: float, axial_factor: float, mass_factor: float) -> Beam:
    """The beam with factors on E I, in both planes, E A and rho A, and the same speed, size and
    bodies in SI."""
    time = math.sqrt(mass_factor / bending_factor)
    units = beam.units
    if units is not None:
        mass = None if units.mass is None else units.mass * mass_factor
        units = replace(units, time=units.time * time, mass=mass)
    masses = tuple(
        Mass(
            body.alpha / mass_factor,
            body.beta,
            (Jx / mass_factor, Jy / mass_factor, Jz / mass_factor),
        )
        for body in beam.masses
        for Jx, Jy, Jz in [body.inertia]
    )
    low, high = NUMBERS["mu"].limits
    mu = beam.mu * math.sqrt(axial_factor / bending_factor)
    return beam.replace(
        alpha=beam.alpha / mass_factor,
        gamma=beam.gamma * time,
        spin_up=beam.spin_up * time**2,
        mu=beam.mu if beam.mu == high else min(max(mu, low), high),
        root=beam.root / bending_factor,
        masses=masses,
        units=units,
    )


def free_numbers(beam: Beam, free: Any) -> tuple[FreeNumber, ...]:
    """The free numbers of names, or of a table of their bounds by name; None for the usual bounds.
    Raises InvalidInput."""
    if isinstance(free, str):
        free = (free,)
    if not isinstance(free, Mapping | Iterable):
        raise InvalidInput(f"free = {free!r}: must be names, or bounds (low, high) by name")
    bounds = dict(free) if isinstance(free, Mapping) else dict.fromkeys(free)
    if not 1 <= len(bounds) <= MOST_FREE:
        raise InvalidInput(f"{len(bounds)} free numbers: must be 1 .. {MOST_FREE}")
    numbers = tuple(free_number(beam, str(name), ends) for name, ends in bounds.items())
    names = [each.number for each in numbers]
    for name in names:
        if names.count(name) > 1:
            raise InvalidInput(f"free: {name} is given twice")
    return numbers


def free_number(beam: Beam, name: str, bounds: Any) -> FreeNumber:
    """A free number with its bounds. Raises InvalidInput."""
    known = (*NUMBERS, "root", *FACTORS)
    if name not in known and name not in BY_NAME:
        raise unknown_keyword("free number", name, known)
    number, unit = parse_over(name, beam.units)
    if number in FACTORS and beam.units is None:
        raise InvalidInput(f"free {name}: the size of the beam is not known: give it in SI units")
    if number == "mu" and beam.units is not None:
        raise InvalidInput("free mu: T* depends on it; of a beam in SI free axial_factor")
    if number == "flap" and beam.blade is not None:
        raise InvalidInput("free flap: is that of a uniform beam; a blade has its own")
    limits = limits_of(number)
    if bounds is None:
        return FreeNumber(name, number, unit, *usual_bounds(beam, number))
    try:
        low, high = bounds
    except (TypeError, ValueError):
        raise InvalidInput(f"free {name} = {bounds!r}: must be two numbers, low and high") from None
    ends = [check_float(f"free {name}", end, *(x * unit for x in limits)) for end in (low, high)]
    if ends[0] >= ends[1]:
        raise InvalidInput(f"free {name} = {ends[0]:g}:{ends[1]:g}: the second must be larger")
    return FreeNumber(name, number, unit, ends[0] / unit, ends[1] / unit)


def limits_of(number: str) -> tuple[float, float]:
    """The limits of the bounds of a free number."""
    if number in NUMBERS:
        return NUMBERS[number].limits
    return (0.0, 1e9) if number == "root" else (1e-3, 1e3)


def usual_bounds(beam: Beam, number: str) -> tuple[float, float]:
    """The range of the slider of a number, with its value in the given beam."""
    if number in FACTORS:
        return FACTOR_BOUNDS
    low, high = ROOT_BOUNDS if number == "root" else NUMBERS[number].slider[:2]
    value = getattr(beam, number)
    return (min(low, value), max(high, value)) if math.isfinite(value) else (low, high)
