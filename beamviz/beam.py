"""The beam: its dimensionless numbers, their limits, and conversion from and to SI units."""

import math
import tomllib
from collections.abc import Collection, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple, Self

from beamviz.blade import Blade, Mass
from beamviz.checks import check_float, check_positive, full_text
from beamviz.errors import InvalidInput, unknown_keyword


class Parameter(NamedTuple):
    """One of the dimensionless numbers of a beam, for every place that describes it.

    label: its name; short_label: its name beside a slider; formula: the paper's definition;
    si_formula: the same in the keywords of `Beam.from_si`; limits: the range accepted; slider:
    usual range and step; hint: its meaning and its effect.
    """

    symbol: str
    label: str
    short_label: str
    formula: str
    si_formula: str
    limits: tuple[float, float]
    slider: tuple[float, float, float]
    hint: str

    @property
    def axis_label(self) -> str:
        """The label of a chart's axis: "rotation speed γ = Ω T*"."""
        return f"{self.label} {self.symbol} = {self.formula}"

    @property
    def slider_label(self) -> str:
        """The label of a slider: "speed γ"."""
        return f"{self.short_label} {self.symbol}"


PARAMETERS = {  # in brackets: symbol, label, short label, formula, formula in SI
    "alpha": Parameter(
        *("α", "mass ratio", "mass", "m / (ρ A L)", "mass / (density area length)"),
        limits=(0.0, 100.0),
        slider=(0.0, 5.0, 0.01),
        hint="The concentrated mass over the mass of the beam. Larger: lower frequencies, except of"
        " modes with a node at the mass",
    ),
    "beta": Parameter(
        *("β", "mass location", "position", "d / L", "mass_position / length"),
        limits=(0.0, 1.0),
        slider=(0.0, 1.0, 0.005),
        hint="Position of the mass: 0 at the hub, 1 at the tip. You can drag the mass itself, too",
    ),
    "gamma": Parameter(
        *("γ", "rotation speed", "speed", "Ω T*", "rotation_speed T*"),
        limits=(0.0, 200.0),
        slider=(0.0, 50.0, 0.1),
        hint="Rotation speed in radians per T*. Higher: more tension in the beam, a longer beam and"
        " higher bending frequencies",
    ),
    "delta": Parameter(
        *("δ", "hub radius", "hub", "a / L", "hub_radius / length"),
        limits=(-2.0, 20.0),
        slider=(-1.0, 3.0, 0.01),
        hint="Radius of the hub over the length of the beam. Larger: more tension. Below 0 the beam"
        " points inward and is compressed",
    ),
    "mu": Parameter(
        *("μ", "slenderness", "slenderness", "√(A L² / I)", "length sqrt(area / second_moment)"),
        limits=(10.0, 10000.0),
        slider=(10.0, 200.0, 1.0),
        hint="√12 times length over thickness of a rectangular section. Larger: higher stretching"
        " frequencies beside bending, and less stretch at the same speed",
    ),
}
SPIN_UP = Parameter(
    *("λ", "spin-up", "spin-up", "T*² dΩ/dt", "angular_acceleration T*^2"),
    limits=(-1000.0, 1000.0),
    slider=(-20.0, 20.0, 0.1),
    hint="How fast the speed grows. The beam lags behind its hub and is bent; below 0, where the"
    " speed falls, it runs ahead",
)
NUMBERS = {**PARAMETERS, "spin_up": SPIN_UP}  # the five and the spin-up
MAX_GAMMA_OVER_MU = 5.0
ROUNDING = 1e-12  # relative, so that mu = gamma / 5 is accepted


@dataclass(frozen=True)
class Units:
    """The physical size of a dimensionless beam: its length L [m], its time T* [s] and, where they
    are known, its mass rho A L [kg] and Young's modulus E [Pa]."""

    length: float
    time: float
    mass: float | None = None
    youngs_modulus: float | None = None

    @property
    def attributes(self) -> dict[str, float]:
        """Length and time as attributes of a dataset."""
        return {"unit_length_m": self.length, "unit_time_s": self.time}

    def angular_frequency(self, frequency):
        """Frequency [rad/s] of a dimensionless one (units of 1/T*)."""
        return frequency / self.time

    def hertz(self, frequency):
        """Frequency [Hz] of a dimensionless one (units of 1/T*)."""
        return frequency / (2 * math.pi * self.time)

    def rpm(self, gamma):
        """Rotation speed [1/min] of a dimensionless one."""
        return 60 * self.hertz(gamma)


@dataclass(frozen=True)
class Beam:
    """A beam on a rotating hub with a concentrated mass (paper, eq. 45).

    alpha: mass ratio m / (rho A L), beta: mass location d / L, gamma: speed Omega T*,
    delta: hub radius a / L (negative: the beam points inward), mu: slenderness
    sqrt(A L^2 / I). T* = sqrt(rho A L^4 / (E I)). `units` is set for a beam given in SI. spin_up:
    lambda = T*^2 dOmega/dt of a beam whose speed changes.

    Of a beam that is not uniform (rho A, E I and E A are those of its root section): blade: its
    properties along the span; masses: more bodies on it; root: stiffness [E I / L] of a rotational
    spring at the root, 0 for a hinge, infinite for a clamp.

    Raises InvalidInput (a ValueError) that names the number, its value and its limits, or for a
    mistyped keyword the nearest.
    """

    alpha: float = 0.0
    beta: float = 1.0
    gamma: float = 0.0
    delta: float = 0.0
    mu: float = 70.0
    units: Units | None = None
    spin_up: float = 0.0
    blade: Blade | None = None
    masses: tuple[Mass, ...] = ()
    root: float = math.inf

    def __new__(cls, *_: Any, **numbers: Any) -> Self:
        for name in numbers.keys() - cls.__dataclass_fields__.keys():
            raise unknown_keyword("number", name, NUMBERS)
        return super().__new__(cls)

    def __post_init__(self) -> None:
        for name, parameter in NUMBERS.items():
            (low, high), value = parameter.limits, getattr(self, name)
            valid = type(value) is float and low <= value <= high  # fast
            if not valid or (value == 0 and math.copysign(1.0, value) < 0):
                object.__setattr__(self, name, check_float(name, value, low, high))
        if self.gamma > MAX_GAMMA_OVER_MU * self.mu * (1 + ROUNDING):
            gamma, mu = full_text(self.gamma), full_text(self.mu)
            raise InvalidInput(
                f"gamma / mu = {full_text(self.gamma / self.mu)}: must be at most"
                f" {MAX_GAMMA_OVER_MU:g} (gamma = {gamma}, mu = {mu})"
            )

        if not isinstance(self.blade, Blade | None):
            raise InvalidInput(f"blade = {self.blade!r}: must be a Blade")
        object.__setattr__(self, "masses", tuple(self.masses))
        if not all(isinstance(mass, Mass) for mass in self.masses):
            raise InvalidInput(f"masses = {self.masses!r}: must be a sequence of Mass")
        if self.root != math.inf:
            object.__setattr__(self, "root", check_float("root", self.root, 0.0))

    @property
    def is_uniform(self) -> bool:
        """Whether it is the beam of the paper: the same section along the span, at most one
        concentrated mass, clamped."""
        return self.blade is None and not self.masses and self.root == math.inf

    @property
    def bodies(self) -> tuple[Mass, ...]:
        """All bodies on the beam: the concentrated mass and `masses`, from the root outward."""
        first = (Mass(self.alpha, self.beta),) if self.alpha else ()
        return tuple(sorted((*first, *self.masses), key=lambda body: body.beta))

    def replace(self, **changes: Any) -> Self:
        """The same beam with some of its numbers changed."""
        return type(self)(**{**vars(self), **changes})

    @property
    def numbers(self) -> dict[str, float]:
        """The five numbers by name, and spin_up where it is not 0."""
        names = NUMBERS if self.spin_up else PARAMETERS
        return {name: getattr(self, name) for name in names}

    def described(self, names: Iterable[str]) -> str:
        """Some of the numbers: α = 1, β = 0.5."""
        return ", ".join(f"{NUMBERS[name].symbol} = {getattr(self, name):g}" for name in names)

    @classmethod
    def from_si(
        cls,
        *,
        length: float | None = None,
        density: float | None = None,
        area: float | None = None,
        second_moment: float | None = None,
        youngs_modulus: float | None = None,
        hub_radius: float = 0.0,
        rotation_speed: float = 0.0,
        mass: float = 0.0,
        mass_position: float | None = None,
        angular_acceleration: float = 0.0,
        **unknown: Any,
    ) -> Self:
        """A beam from SI values: length [m], density [kg/m^3], area [m^2], second moment [m^4],
        Young's modulus [Pa], hub radius [m], rotation speed [rad/s], mass [kg] and its
        position [m] from the root (the tip where none is given), angular acceleration [rad/s^2].
        The first five are required. Raises InvalidInput, which names for a mistyped keyword the
        nearest, with its unit.
        """
        for name in unknown:
            raise unknown_keyword("value", name, SI_KEYS, SI_SYNONYMS, SI_KEYS)
        sizes = (length, density, area, second_moment, youngs_modulus)
        for name, size in zip(SI_REQUIRED, sizes, strict=True):
            if size is None:
                raise InvalidInput(f"missing value {name!r} [{SI_KEYS[name]}]")
        L, rho, A, I, E = map(check_positive, SI_REQUIRED, sizes)
        time = L * L * math.sqrt(rho / E) * math.sqrt(A / I)
        for name, value in {"T* [s]": time, "density area length [kg]": rho * A * L}.items():
            if not (math.isfinite(value) and value > 0):
                raise InvalidInput(f"{name} = {value:g}: the SI values are too extreme")
        position = L if mass_position is None else mass_position
        acceleration = check_float("angular_acceleration", angular_acceleration)
        numbers: dict[str, Any] = {
            "alpha": check_float("mass", mass, 0.0) / (rho * A * L),
            "beta": check_float("mass_position", position, 0.0, L) / L,
            "gamma": check_float("rotation_speed", rotation_speed, 0.0) * time,
            "delta": check_float("hub_radius", hub_radius) / L,
            "mu": L * math.sqrt(A / I),
            "spin_up": acceleration * time**2,
        }
        for name, parameter in NUMBERS.items():
            check_float(f"{parameter.si_formula} = {name}", numbers[name], *parameter.limits)
        units = Units(length=L, time=time, mass=rho * A * L, youngs_modulus=E)
        return cls(**numbers, units=units)

    @property
    def si(self) -> dict[str, float]:
        """The keywords of `from_si` for this beam; {} where its size is not known in full."""
        sizes: Any = vars(self.units).values() if self.units else [None]
        if None in sizes:
            return {}
        L, T, mass, E = sizes
        density = E * (T / (L * self.mu)) ** 2
        area = mass / (density * L)
        return {
            "length": L,
            "density": density,
            "area": area,
            "second_moment": area * (L / self.mu) ** 2,
            "youngs_modulus": E,
            "hub_radius": self.delta * L,
            "rotation_speed": self.gamma / T,
            "mass": self.alpha * mass,
            "mass_position": self.beta * L,
            "angular_acceleration": self.spin_up / T**2,
        }

    @classmethod
    def from_toml(cls, path: str | Path) -> Self:
        """A beam from a TOML file of `from_si` keywords; InvalidInput names file and mistake."""
        return cls.from_si(**check_si_keys(parse_toml(read_small(path), str(path)), str(path)))


SI_KEYS = {
    "length": "m",
    "density": "kg/m^3",
    "area": "m^2",
    "second_moment": "m^4",
    "youngs_modulus": "Pa",
    "hub_radius": "m",
    "rotation_speed": "rad/s",
    "mass": "kg",
    "mass_position": "m",
    "angular_acceleration": "rad/s^2",
}
SI_SYNONYMS = {  # other names of these values
    **dict.fromkeys(("rpm", "speed", "omega", "Omega", "angular_velocity"), "rotation_speed"),
    **dict.fromkeys(("E", "modulus", "elastic_modulus"), "youngs_modulus"),
    **dict.fromkeys(("I", "inertia", "moment_of_inertia"), "second_moment"),
    **dict.fromkeys(("a", "radius", "offset"), "hub_radius"),
    **dict.fromkeys(("d", "position"), "mass_position"),
    "L": "length",
    "rho": "density",
    "A": "area",
    "m": "mass",
    "spin_up": "angular_acceleration",
}
SI_REQUIRED = ("length", "density", "area", "second_moment", "youngs_modulus")
MAX_TOML_BYTES = 64_000


def check_si_keys(data: dict[str, Any], source: str) -> dict[str, float]:
    """`data` if its keys are those of `from_si`, else InvalidInput for one unknown or missing."""
    check_keys(data, SI_KEYS, source)
    missing = [key for key in SI_REQUIRED if key not in data]
    if missing:
        raise InvalidInput(f"{source}: missing key {missing[0]!r} [{SI_KEYS[missing[0]]}]")
    return data


def read_small(path: str | Path) -> bytes:
    """The start of a file, a byte more than `parse_toml` accepts; InvalidInput if unreadable."""
    try:
        with Path(path).open("rb") as file:
            return file.read(MAX_TOML_BYTES + 1)
    except OSError as error:
        raise InvalidInput(f"{path}: {error.strerror or error}") from None


def parse_toml(text: bytes, name: str) -> dict[str, Any]:
    """The contents of a TOML file called `name`; InvalidInput if it is too large or not TOML."""
    if len(text) > MAX_TOML_BYTES:
        raise InvalidInput(f"{name}: larger than {MAX_TOML_BYTES} bytes, not a file of beamviz")
    try:
        return tomllib.loads(text.decode("utf-8-sig"))  # some editors write a byte-order mark
    except (ValueError, RecursionError) as error:
        raise InvalidInput(f"{name}: not a TOML file ({error})") from None


def check_keys(data: Collection[str], keys: Collection[str], source: str) -> None:
    """InvalidInput for the first key of `data` that is not among `keys`; SI values have units."""
    unknown = sorted(set(data) - set(keys))
    if unknown:
        names = [f"{key} [{SI_KEYS[key]}]" if key in SI_KEYS else key for key in keys]
        raise InvalidInput(f"{source}: unknown key {unknown[0]!r}; known: {', '.join(names)}")
