"""Values and messages as text, in the units the visitor sees: dimensionless, or kg, mm, rpm, Hz."""

import math
from typing import Any, NamedTuple

import numpy as np

from beamviz.beam import NUMBERS, Beam, Units
from beamviz.errors import BeamvizError, Cancelled, NoEquilibrium
from beamviz.solver import Solution

MILLIMETRES = 1000.0
LARGE_STRETCH = 0.5  # gamma / mu from which on a stable state is told to be far from a real beam


class Measure(NamedTuple):
    """How one number is shown: `factor` times it, in `unit` ("" for a dimensionless one)."""

    label: str  # of its slider and its axis
    symbol: str
    unit: str = ""
    factor: float = 1.0

    def plain(self, shown: Any) -> Any:
        """The dimensionless number of a shown one; anything else unchanged."""
        return shown / self.factor if isinstance(shown, int | float) else shown

    def field(self, name: str) -> str:
        """The label of a field for all digits: 'γ speed', or 'exact speed [rpm]'."""
        return f"exact {self.label}" if self.unit else f"{self.symbol} {name}"

    def range(
        self, low: float, high: float, step: float, limits: tuple[float, float]
    ) -> tuple[float, float, float]:
        """A range and its step as shown, in round numbers that keep the limits."""
        if not self.unit:
            return low, high, step
        least, most = (self.factor * limit for limit in limits)
        low, high = (min(max(rounded(self.factor * end), least), most) for end in (low, high))
        return low, high, neat(self.factor * step)

    def text(self, value: float, digits: int) -> str:
        """'γ = 4.464', or '42.63 rpm'."""
        shown = significant(self.factor * value, digits)
        return f"{shown} {self.unit}" if self.unit else f"{self.symbol} = {shown}"

    def number(self, value: float, decimals: int) -> str:
        """`decimals` decimals where dimensionless, one more significant digits in units."""
        shown = self.factor * value
        return significant(shown, decimals + 1) if self.unit else f"{shown:.{decimals}f}"

    @property
    def head(self) -> str:
        """'γ', or 'rpm': over a column of values."""
        return self.unit or self.symbol


def measure(name: str, units: Units | None) -> Measure:
    """How one of a beam's numbers is shown. mu has no unit, as T* itself depends on it, and alpha
    has none where the mass of the beam is not known."""
    parameter = NUMBERS[name]
    if units is None or name == "mu" or (name == "alpha" and units.mass is None):
        return Measure(parameter.slider_label, parameter.symbol)
    others = {
        "alpha": ("kg", units.mass or 1.0),
        "gamma": ("rpm", units.rpm(1.0)),
        "spin_up": ("rad/s²", 1 / units.time**2),
    }
    unit, factor = others.get(name, ("mm", MILLIMETRES * units.length))
    return Measure(f"{parameter.short_label} [{unit}]", parameter.symbol, unit, factor)


def frequencies(units: Units | None) -> Measure:
    """How frequencies are shown."""
    if units is None:
        return Measure("ω [1/T*]", "ω")
    return Measure("Hz", "f", "Hz", units.hertz(1.0))


def measures(units: Units | None) -> dict[str, Measure]:
    """How all numbers are shown."""
    return {name: measure(name, units) for name in NUMBERS}


def significant(value: float, digits: int) -> str:
    """A number with `digits` significant digits and all before the point, without exponent."""
    return f"{value:.0f}" if abs(value) >= 10.0 ** (digits - 1) else f"{value:.{digits}g}"


def rounded_to_error(value: float, error: float) -> str:
    """`value` with the decimals its error leaves, at most six."""
    decimals = 6 if error <= 0 else min(max(-math.ceil(math.log10(2 * error)), 0), 6)
    return f"{value:.{decimals}f}"


def rounded(value: float) -> float:
    """A number with two digits, away from zero."""
    if value == 0:
        return 0.0
    power = 10.0 ** (math.floor(math.log10(abs(value))) - 1)
    return math.copysign(power * math.ceil(round(abs(value) / power, 9)), value)


def neat(step: float) -> float:
    """The largest of 1, 2 or 5 times a power of ten that is no more than `step`."""
    power = 10.0 ** math.floor(math.log10(step))
    return power * max(digit for digit in (1, 2, 5) if digit * power <= step * (1 + 1e-9))


def places(step: float) -> int:
    """The decimals that a value in such steps is shown with."""
    return max(1 - math.floor(math.log10(step)), 0)


def stability_warning(solution: Solution) -> str:
    """How a disturbance of an unstable equilibrium grows, on two lines; "" for a stable one."""
    if solution.equilibrium.status == "stable":
        return ""
    fastest = int(np.argmax(solution.growth_rates))
    motion = "stretching" if solution.labels[fastest].startswith("S") else "bending"
    growth_rate = float(solution.growth_rates[fastest])
    return f"Unstable in {motion}\na disturbance {growth(growth_rate, solution.beam.units)}"


def growth(rate: float, units: Units | None) -> str:
    """How a growth rate [1/T*] is told: "grows 35-fold per T*", or in how many ms tenfold."""
    if rate <= 0:
        return "grows"
    if units is None and math.log(2) <= rate <= math.log(1000):
        return f"grows {significant(math.exp(rate), 2)}-fold per T*"
    return f"grows tenfold in {duration(math.log(10) / rate, units)}"


def stretch_caution(solution: Solution) -> str:
    """Why a stable equilibrium is far from a real beam, "" where it is not: its tip is nearly as
    fast as sound in it, gamma / mu = speed of the tip / sqrt(E / rho)."""
    ratio = solution.beam.gamma / solution.beam.mu
    if ratio < LARGE_STRETCH:
        return ""
    percent = significant(100 * (solution.equilibrium.max_stretch - 1), 2)
    return (
        f"Stretched by up to {percent} %: γ / μ = {ratio:.2g},"
        " speed of the tip over speed of sound. Real materials fail long before."
    )


def duration(time: float, units: Units | None) -> str:
    """A time [T*] with its unit: milliseconds for a beam in SI units."""
    return f"{significant(1000 * time * units.time, 3)} ms" if units else f"{time:.2g} T*"


def error_summary(error: BeamvizError | Cancelled, beam: Beam | None) -> str:
    """Why a beam has no solution, in one line; beam: the one that was asked for, None
    where its numbers are out of range."""
    if isinstance(error, NoEquilibrium) and beam is not None:
        speed = measure("gamma", beam.units)
        law = " with this material law" if beam.delta >= 0 else ""  # inward, thrust is the limit
        law = law if math.isfinite(error.limit) or not beam.spin_up else " with this spin-up"
        if math.isfinite(error.limit):
            return f"No equilibrium above {speed.text(error.limit, 4)}{law}"
        return f"No equilibrium at {speed.text(beam.gamma, 6)}{law}"
    return {
        "invalid-input": "A value is out of range",
        "not-converged": "The calculation did not converge",
        "cancelled": "The calculation was cancelled",
    }.get(error.kind, "No solution")
