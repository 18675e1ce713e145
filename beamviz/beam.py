"""The beam: five dimensionless numbers, their limits, and the way from and to SI units."""

import math
import tomllib
from collections.abc import Collection
from dataclasses import dataclass
from numbers import Real
from pathlib import Path
from typing import Any, Self

from beamviz.errors import InvalidInput

LIMITS = {
    "alpha": (0.0, 100.0),
    "beta": (0.0, 1.0),
    "gamma": (0.0, 200.0),
    "delta": (-2.0, 20.0),
    "mu": (10.0, 10000.0),
}
MAX_GAMMA_OVER_MU = 5.0
ROUNDING = 1e-12  # so that mu = gamma / 5 is a beam

NAMES = {
    "alpha": "mass ratio",
    "beta": "mass location",
    "gamma": "speed",
    "delta": "hub radius",
    "mu": "slenderness",
}

FROM_SI = {
    "alpha": "mass / (density area length)",
    "beta": "mass_position / length",
    "gamma": "rotation_speed T*",
    "delta": "hub_radius / length",
    "mu": "length sqrt(area / second_moment)",
}


@dataclass(frozen=True)
class Units:
    """The physical size of a dimensionless beam: its length L [m], its time T* [s] and, where it
    is known, its mass rho A L [kg]."""

    length: float
    time: float
    mass: float | None = None

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
    """A uniform beam on a rotating hub with a concentrated mass (paper, eq. 45).

    alpha: mass ratio m / (rho A L), beta: mass location d / L, gamma: speed Omega T*,
    delta: hub radius a / L (negative: the beam points inward), mu: slenderness
    sqrt(A L^2 / I). T* = sqrt(rho A L^4 / (E I)). `units` is set for a beam given in SI.

    Raises InvalidInput (a ValueError) that names the number, its value and its limits.
    """

    alpha: float = 0.0
    beta: float = 1.0
    gamma: float = 0.0
    delta: float = 0.0
    mu: float = 70.0
    units: Units | None = None

    def __post_init__(self) -> None:
        for name, (low, high) in LIMITS.items():
            value = getattr(self, name)
            if not (type(value) is float and low <= value <= high and value):  # a sweep has many
                object.__setattr__(self, name, checked(name, value, low, high))
        if self.gamma > MAX_GAMMA_OVER_MU * self.mu * (1 + ROUNDING):
            raise InvalidInput(
                f"gamma / mu = {shown(self.gamma / self.mu)}: must be at most"
                f" {MAX_GAMMA_OVER_MU:g} (gamma = {shown(self.gamma)}, mu = {shown(self.mu)})"
            )

    def replace(self, **changes: Any) -> Self:
        """The same beam with some of its numbers changed."""
        return type(self)(**{**vars(self), **changes})

    @property
    def numbers(self) -> dict[str, float]:
        """The five numbers by name."""
        return {name: getattr(self, name) for name in LIMITS}

    @classmethod
    def from_si(
        cls,
        *,
        length: float,
        density: float,
        area: float,
        second_moment: float,
        youngs_modulus: float,
        hub_radius: float = 0.0,
        rotation_speed: float = 0.0,
        mass: float = 0.0,
        mass_position: float | None = None,
    ) -> Self:
        """A beam from SI values: length [m], density [kg/m^3], area [m^2], second moment [m^4],
        Young's modulus [Pa], hub radius [m], rotation speed [rad/s], mass [kg] and its
        position [m] from the root (the tip where none is given).
        """
        sizes = {
            "length": length,
            "density": density,
            "area": area,
            "second_moment": second_moment,
            "youngs_modulus": youngs_modulus,
        }
        L, rho, A, I, E = (checked(name, value, 0.0, math.inf) for name, value in sizes.items())
        for name, value in sizes.items():
            if value == 0:
                raise InvalidInput(f"{name} = 0: must be above 0")
        time = L * L * math.sqrt(rho / E) * math.sqrt(A / I)
        for name, value in {"T* [s]": time, "density area length [kg]": rho * A * L}.items():
            if not (math.isfinite(value) and value > 0):
                raise InvalidInput(f"{name} = {value:g}: the SI values are too extreme")
        if mass_position is None:
            mass_position = L
        numbers = {
            "alpha": checked("mass", mass, 0.0, math.inf) / (rho * A * L),
            "beta": checked("mass_position", mass_position, 0.0, L) / L,
            "gamma": checked("rotation_speed", rotation_speed, 0.0, math.inf) * time,
            "delta": checked("hub_radius", hub_radius, -math.inf, math.inf) / L,
            "mu": L * math.sqrt(A / I),
        }
        for name, formula in FROM_SI.items():
            checked(f"{formula} = {name}", numbers[name], *LIMITS[name])
        return cls(**numbers, units=Units(length=L, time=time, mass=rho * A * L))

    @classmethod
    def from_toml(cls, path: str | Path) -> Self:
        """A beam from a TOML file holding the keywords of `from_si`."""
        return cls.from_si(**read_si(Path(path)))


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
}
SI_REQUIRED = ("length", "density", "area", "second_moment", "youngs_modulus")
MAX_TOML_BYTES = 64_000


def read_si(path: Path) -> dict[str, float]:
    """The SI keywords in a TOML file; InvalidInput names the file and what is wrong in it."""
    return si_keywords(read_toml(path), str(path))


def si_keywords(data: dict[str, Any], where: str) -> dict[str, float]:
    """`data` as keywords of `from_si`; InvalidInput names the key that is unknown or missing."""
    known(data, SI_KEYS, where)
    missing = [key for key in SI_REQUIRED if key not in data]
    if missing:
        raise InvalidInput(f"{where}: missing key {missing[0]!r} [{SI_KEYS[missing[0]]}]")
    return data


def known(data: dict[str, Any], keys: Collection[str], where: str) -> None:
    """InvalidInput for the first key of `data` that is none of `keys`."""
    unknown = sorted(set(data) - set(keys))
    if unknown:
        raise InvalidInput(f"{where}: unknown key {unknown[0]!r}; known: {', '.join(keys)}")


def read_toml(path: Path) -> dict[str, Any]:
    """What a small TOML file holds; InvalidInput where it cannot be read, is large or no TOML."""
    try:
        with path.open("rb") as file:
            text = file.read(MAX_TOML_BYTES + 1)
    except OSError as error:
        raise InvalidInput(f"{path}: {error.strerror or error}") from None
    return parsed_toml(text, str(path))


def parsed_toml(text: bytes, name: str) -> dict[str, Any]:
    """What the TOML of a file called `name` holds."""
    if len(text) > MAX_TOML_BYTES:
        raise InvalidInput(f"{name}: larger than {MAX_TOML_BYTES} bytes, not a file of beamviz")
    try:
        return tomllib.loads(text.decode("utf-8-sig"))  # some editors begin with a mark
    except (ValueError, RecursionError) as error:
        raise InvalidInput(f"{name}: not a TOML file ({error})") from None


def checked(name: str, value: object, low: float, high: float) -> float:
    """`value` as a float within low .. high, or InvalidInput naming it."""
    if isinstance(value, bool) or not isinstance(value, (float, int, Real)):
        raise InvalidInput(f"{name} = {value!r}: must be a number and {allowed(low, high)}")
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not (math.isfinite(number) and low <= number <= high):
        raise InvalidInput(f"{name} = {shown(number)}: must {allowed(low, high)}")
    return number + 0.0  # -0.0 becomes 0.0


def whole(name: str, value: object, low: int, high: int) -> int:
    """`value` as an integer within low .. high, or InvalidInput naming it."""
    wanted = f"must be a whole number in {low} .. {high}"
    try:
        number = checked(name, value, low, high)
    except InvalidInput as error:
        raise InvalidInput(f"{str(error).split(': must')[0]}: {wanted}") from None
    if number != int(number):
        raise InvalidInput(f"{name} = {shown(number)}: {wanted}")
    return int(number)


def allowed(low: float, high: float) -> str:
    """The words for a range."""
    if math.isfinite(high):
        return f"lie in {low:g} .. {high:g}"
    return "be 0 or more" if low == 0 else "be finite"


def shown(number: float) -> str:
    """The shortest text of exactly this number, so that no value seems to be its own limit."""
    return repr(number).removesuffix(".0")
