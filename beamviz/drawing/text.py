"""Values and messages as text, in display units: dimensionless, or kg, mm or m, rpm, Hz."""

import math
import re
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from beamviz.beam import NUMBERS, Beam, check_joint_limit
from beamviz.checks import check_float
from beamviz.errors import BeamvizError, Cancelled, InvalidInput, NoEquilibrium
from beamviz.solver.problem import OPTIONS
from beamviz.solver.solution import GreatestStress, Solution
from beamviz.units import (
    RAISED as RAISED,
)
from beamviz.units import (
    DisplayUnit,
    Units,
    display_unit,
    gap_number,
    place_number,
    suited_unit,
    unit_for,
)
from beamviz.units import (
    significant as significant,
)

NUMBER = re.compile(rf"\b({'|'.join(NUMBERS)})\b(?: = (-?[\d.]+(?:e[-+]?\d+)?))?")  # in a message
OPTION = re.compile(rf"\b({'|'.join(OPTIONS)}) ?= ?('[\w-]+'|True|False)")  # in a message
TERMS = {"softening": "spin softening", "coriolis": "Coriolis"}  # as the page calls them
SWITCHED = {"True": "on", "False": "off"}
LARGE_STRETCH = 0.5  # gamma / mu from which on a stable state has a caution


class Measure(NamedTuple):
    """The display of a number, multiplied by `factor`; label: of its slider and axis."""

    label: str
    symbol: str
    unit: str = ""
    factor: float = 1.0

    def plain(self, shown: Any) -> Any:
        """The dimensionless number of a displayed one; other values are returned unchanged."""
        return shown / self.factor if isinstance(shown, int | float) else shown

    def range(
        self, low: float, high: float, step: float, limits: tuple[float, float]
    ) -> tuple[float, float, float]:
        """A range and its step as displayed, in round numbers within the limits."""
        if not self.unit or self.factor == 1.0:
            return low, high, step
        least, most = (self.factor * limit for limit in limits)
        low, high = (min(max(rounded(self.factor * end), least), most) for end in (low, high))
        return low, high, neat(self.factor * step)

    def text(self, value: float, digits: int) -> str:
        """The number as 'γ = 4.464' or '42.63 rpm'."""
        shown = significant(self.factor * value, digits)
        return f"{shown} {self.unit}" if self.unit else f"{self.symbol} = {shown}"

    def number(self, value: float) -> str:
        """The number of an event or a limit, without its unit: '4.4640'."""
        return place_number(self.factor * value)

    def place(self, value: float) -> str:
        """The same with its symbol or its unit: 'γ = 4.4640' or '42.630 rpm'."""
        shown = self.number(value)
        return f"{shown} {self.unit}" if self.unit else f"{self.symbol} = {shown}"

    def gap(self, value: float) -> str:
        """The gap between two frequencies, without its unit: '0.644'."""
        return gap_number(self.factor * value)

    @property
    def head(self) -> str:
        """The head of a column of values: 'γ' or 'rpm'."""
        return self.unit or self.symbol


def measure(name: str, units: Units | None) -> Measure:
    """The display of a number of the beam. mu has no unit, as T* depends on it; alpha has none if
    the mass of the beam is not known."""
    parameter = NUMBERS[name]
    if display := display_unit(name, units):
        return in_unit(parameter.short_label, parameter.symbol, display)
    return Measure(parameter.slider_label, parameter.symbol)


def in_unit(label: str, symbol: str, display: DisplayUnit) -> Measure:
    """The display of a quantity in a unit, which its label names."""
    return Measure(f"{label} [{display.unit}]", symbol, *display)


def si_measure(
    label: str, symbol: str, quantity: str, unit_size: float, typical: float = 1.0
) -> Measure:
    """The display of a quantity, by its SI unit, whose dimensionless 1 is `unit_size` in SI; with
    the prefix that suits a typical dimensionless value."""
    return in_unit(label, symbol, suited_unit(quantity, unit_size, typical))


def lengths(label: str, symbol: str, units: Units | None) -> Measure:
    """The display of lengths along a beam or beside it: in mm, in m where it is long, in its own
    length [L] where its size is not known."""
    display = display_unit("beta", units)
    return in_unit(label, symbol, display) if display else Measure(f"{label} [L]", symbol)


def times(units: Units | None) -> Measure:
    """The display of times."""
    display = display_unit("time", units)
    return in_unit("time", "t", display) if display else Measure("time t [T*]", "t")


def si_text(value: float, quantity: str, digits: int) -> str:
    """A value in SI of a quantity, by its SI unit, in the unit that suits it: '4.79 MN'."""
    unit, size = unit_for(quantity, value)
    return f"{significant(value / size, digits)} {unit}"


def force_text(force: float, units: Units | None) -> str:
    """A force [E I / L^2] with its unit: '2.5 E I / L²', '12.5 N'."""
    newtons = units.newtons(force) if units else None
    return f"{significant(force, 3)} E I / L²" if newtons is None else si_text(newtons, "N", 3)


def energy_text(energy: float, units: Units | None) -> str:
    """An energy [E I / L] with its unit: '0.25 E I / L', '12.5 J'."""
    joules = units.newton_metres(energy) if units else None
    return f"{significant(energy, 3)} E I / L" if joules is None else si_text(joules, "J", 3)


def length_text(length: float, units: Units | None, digits: int) -> str:
    """A length [L] with its unit: '0.15 L', '150 mm', '18 m'."""
    if units is None:
        return f"{length:.{digits}g} L"
    unit, size = unit_for("m", length * units.length)
    along = lengths("", "", units)
    if unit == "m" or not length:
        return f"{significant(along.factor * length, digits)} {along.unit}"
    return f"{significant(length * units.length / size, digits)} {unit}"


def described(beam: Beam) -> str:
    """The numbers of a beam and what is not uniform: 'α = 1, hinged root', or 'mass 2 kg'."""
    if beam.units is None:
        return beam.described(beam.numbers)
    texts = []
    for name, value in beam.numbers.items():
        shown = measure(name, beam.units)
        text = shown.text(value, 6)
        texts.append(f"{NUMBERS[name].short_label} {text}" if shown.unit else text)
    return ", ".join([*texts, *beam.structure])


def out_of_range(numbers: Mapping[str, Any], units: Units | None) -> str:
    """The numbers of a beam that are out of range, as the page calls them, each with its limits in
    its own unit, and the joint limit of two; "" for none."""
    errors = [range_error(name, numbers[name], units) for name in NUMBERS]
    try:
        check_joint_limit(numbers["gamma"], numbers["mu"])
    except InvalidInput as error:
        errors.append(in_words(str(error), units))
    return "; ".join(filter(None, errors))


def range_error(name: str, value: Any, units: Units | None) -> str:
    """A number that is out of range or none, with its limits; "" for a valid one."""
    shown, limits = measure(name, units), NUMBERS[name].limits
    try:
        check_float(name, value, *limits)
    except InvalidInput as error:
        if shown.unit and isinstance(value, int | float):
            low, high = (significant(shown.factor * end, 6) for end in limits)
            return f"{shown.label} = {shown.factor * value:.6g}: must lie in {low} .. {high}"
        return in_words(str(error), units)
    return ""


def in_words(text: str, units: Units | None) -> str:
    """A message in the words of the page: 'speed γ = 5' for 'gamma = 5', or 'speed 42.63 rpm' where
    the size of the beam is known; 'state bent' for "state = 'bent'", and 'stiffening off'."""

    def named(match: re.Match[str]) -> str:
        name, value = match.groups()
        shown, parameter = measure(name, units), NUMBERS[name]
        if not shown.unit:
            return match[0].replace(name, parameter.slider_label)
        number = f" {shown.text(float(value), 6)}" if value else ""
        return f"{parameter.short_label}{number}"

    def chosen(match: re.Match[str]) -> str:
        name, value = match.groups()
        return f"{TERMS.get(name, name)} {SWITCHED.get(value) or value[1:-1]}"

    return NUMBER.sub(named, OPTION.sub(chosen, text))


def frequencies(units: Units | None) -> Measure:
    display = display_unit("frequency", units)
    return Measure(display.unit, "f", *display) if display else Measure("ω [1/T*]", "ω")


def rounded_to_error(value: float, error: float) -> str:
    """`value` with the decimals that are accurate, at most six."""
    decimals = 6 if error <= 0 else min(max(-math.ceil(math.log10(2 * error)), 0), 6)
    return f"{value:.{decimals}f}"


def five_digits(value: float, error: float) -> str:
    """`value` in five digits, or as many as are accurate."""
    accurate = rounded_to_error(value, error)
    decimals = max(4 - math.floor(math.log10(abs(value))), 0) if value else 6
    return accurate if len(accurate.partition(".")[2]) <= decimals else f"{value:.{decimals}f}"


def rounded(value: float) -> float:
    """A number with two digits, away from zero."""
    if value == 0:
        return 0.0
    power = 10.0 ** (math.floor(math.log10(abs(value))) - 1)
    return math.copysign(power * math.ceil(round(abs(value) / power, 9)), value)


def neat(step: float) -> float:
    """The largest of 1, 2 or 5 times a power of ten up to `step`."""
    power = 10.0 ** math.floor(math.log10(step))
    return power * max(digit for digit in (1, 2, 5) if digit * power <= step * (1 + 1e-9))


def error_digits(error: float) -> str:
    """An estimated error with its one digit: '3e-8'."""
    return f"{error:.0e}".replace("e-0", "e-").replace("e+0", "e+")


def stability_warning(solution: Solution) -> str:
    """Divergence or flutter of an unstable state, and how fast what grows, in two lines; "" for a
    stable one. While the speed changes, a growth rate holds at this instant only."""
    status, beam = solution.equilibrium.status, solution.beam
    if status == "stable":
        return ""
    fastest = int(np.argmax(solution.growth_rates))
    label, rate = solution.labels[fastest], float(solution.growth_rates[fastest])
    instant = ", at this instant" if beam.spin_up else ""
    if status == "growing":
        name = label if rate > 0 else "one beyond the modes shown"
        return f"Flutter\n{name} {growth(rate, beam.units)}{instant}"
    motion = "stretching" if label.startswith("S") else "bending"
    return f"Divergence in {motion}\na disturbance {growth(rate, beam.units)}{instant}"


def growth(rate: float, units: Units | None) -> str:
    """A growth rate [1/T*] as text: "grows 35-fold per T*", or the time of tenfold growth."""
    if rate <= 0:
        return "grows"
    if units is None and math.log(2) <= rate <= math.log(1000):
        return f"grows {significant(math.exp(rate), 2)}-fold per T*"
    return f"grows tenfold in {duration(math.log(10) / rate, units)}"


def stretch_caution(solution: Solution) -> str:
    """The caution that no real beam has a stable equilibrium, as its tip is nearly as fast as sound
    in the beam, gamma / mu = speed of the tip / sqrt(E / rho); "" for a slower one."""
    ratio = solution.beam.gamma / solution.beam.mu
    if ratio < LARGE_STRETCH:
        return ""
    percent = significant(100 * (solution.equilibrium.max_stretch - 1), 2)
    meaning = "speed of the tip over speed of sound"
    named = f"γ / μ = {ratio:.2g}, {meaning}"
    if solution.beam.units:
        named = f"{meaning} = {ratio:.2g}"
    return f"Stretched by up to {percent} %: {named}. Real materials fail long before."


def yield_caution(solution: Solution) -> str:
    """The caution that the material of a beam yields; "" where it does not, or is not known."""
    stress = solution.equilibrium.greatest_stress
    if not (stress and stress.yields and stress.yield_stress):
        return ""
    greatest, limit = (stress_text(value) for value in (stress.pascals, stress.yield_stress))
    return (
        f"Stress up to {greatest}, above the yield stress, {limit}: the deformation would remain."
    )


def strength_text(stress: GreatestStress, units: Units | None) -> str:
    """The greatest stress beside the yield stress."""
    place = "the root"
    if stress.at:
        along = lengths("position", "x", units)
        place = along.text(stress.at, 3)
    told = f"Greatest stress: {stress_text(stress.pascals)} at {place}"
    if stress.t is not None:
        told += f" after {duration(stress.t, units)}"
    if not stress.with_bending:
        told += ", without that of bending, for which the height of the section is not known"
    if stress.yield_stress is None:
        return f"{told}."
    share = significant(100 * stress.pascals / stress.yield_stress, 2)
    told += f": {share} % of the yield stress, {stress_text(stress.yield_stress)}."
    return f"{told} A real beam would not return to its shape." if stress.yields else told


def stress_text(pascals: float) -> str:
    """A stress as text: '258 MPa'."""
    return f"{significant(pascals / 1e6, 3)} MPa"


def mode_value(solution: Solution, k: int) -> tuple[str, float]:
    """The frequency of mode k (0-based), or its growth, and the error, in display units."""
    units, error = solution.beam.units, float(solution.errors[k])
    if math.isfinite(solution.frequencies[k]):
        factor = frequencies(units).factor
        error *= factor
        return rounded_to_error(factor * solution.frequencies[k], error), error
    return growth(float(solution.growth_rates[k]), units), error / (units.time if units else 1.0)


def duration(time: float, units: Units | None) -> str:
    """A time [T*] with its unit: seconds, or a part of one, for a beam in SI."""
    return si_text(time * units.time, "s", 3) if units else f"{time:.2g} T*"


def error_summary(error: BeamvizError | Cancelled, beam: Beam | None) -> str:
    """The reason why a beam has no solution, in one line; beam: None for a number out of range."""
    if isinstance(error, NoEquilibrium) and beam is not None:
        speed = measure("gamma", beam.units)
        law = " with this material law" if beam.delta >= 0 else ""  # inward, thrust is the limit
        law = law if math.isfinite(error.limit) or not beam.spin_up else " with this spin-up"
        if math.isfinite(error.limit):
            return f"No equilibrium above {speed.place(error.limit)}{law}"
        return f"No equilibrium at {speed.text(beam.gamma, 6)}{law}"
    return {
        "invalid-input": "Out of range",
        "not-converged": "The calculation did not converge",
        "cancelled": "The calculation was cancelled",
    }.get(error.kind, "No solution")


def error_text(error: BeamvizError | Cancelled, beam: Beam) -> str:
    """An error of a beam in the words and units of the page; a known limit of its equilibrium as
    the scene tells it."""
    if isinstance(error, NoEquilibrium) and math.isfinite(error.limit):
        return error_summary(error, beam)
    return in_words(str(error), beam.units)
