"""The beam: its dimensionless numbers and their limits, from and to SI units and plain records."""

import json
import math
import warnings
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple, Self

from beamviz.blade import Blade, Mass
from beamviz.blade_files import read_blade_file
from beamviz.checks import as_float, check_float, full_text, is_number, together
from beamviz.errors import ImplausibleInput, InvalidInput, unknown_keyword
from beamviz.input_files import errors_of_file, parse_toml, read_small
from beamviz.mass_properties import MassProperties, mass_properties
from beamviz.plausibility import doubts
from beamviz.si import (
    INEXTENSIBLE,
    TURN_LIMITS,
    VALUE_UNITS,
    PhysicalBeam,
    check_si_table,
    physical_beam,
)
from beamviz.units import Units


class Parameter(NamedTuple):
    """One of the dimensionless numbers of a beam, for every place that describes it."""

    symbol: str
    label: str  # its name
    short_label: str  # its name beside a slider
    formula: str  # the paper's definition
    limits: tuple[float, float]  # the range accepted
    slider: tuple[float, float, float]  # usual range and step
    hint: str  # its meaning and its effect

    @property
    def axis_label(self) -> str:
        """The label of a chart's axis: "rotation speed γ = Ω T*"."""
        return f"{self.label} {self.symbol} = {self.formula}"

    @property
    def slider_label(self) -> str:
        """The label of a slider: "speed γ"."""
        return f"{self.short_label} {self.symbol}"


PARAMETERS = {  # in brackets: symbol, label, short label, formula
    "alpha": Parameter(
        *("α", "mass ratio", "mass", "m / (ρ A L)"),
        limits=(0.0, 100.0),
        slider=(0.0, 5.0, 0.01),
        hint="The concentrated mass over the mass of the beam. Larger: lower frequencies, except of"
        " modes with a node at the mass",
    ),
    "beta": Parameter(
        *("β", "mass location", "position", "d / L"),
        limits=(0.0, 1.0),
        slider=(0.0, 1.0, 0.005),
        hint="Position of the mass: 0 at the hub, 1 at the tip. You can drag the mass itself, too",
    ),
    "gamma": Parameter(
        *("γ", "rotation speed", "speed", "Ω T*"),
        limits=(0.0, 200.0),
        slider=(0.0, 50.0, 0.1),
        hint="Rotation speed in radians per T*. Higher: more tension in the beam, a longer beam and"
        " higher bending frequencies",
    ),
    "delta": Parameter(
        *("δ", "hub radius", "hub", "a / L"),
        limits=(-2.0, 20.0),
        slider=(-1.0, 3.0, 0.01),
        hint="Radius of the hub over the length of the beam. Larger: more tension. Below 0 the beam"
        " points inward and is compressed",
    ),
    "mu": Parameter(
        *("μ", "slenderness", "slenderness", "√(A L² / I)"),
        limits=(10.0, INEXTENSIBLE),
        slider=(10.0, 200.0, 1.0),
        hint="√12 times length over thickness of a rectangular section. Larger: higher stretching"
        " frequencies beside bending, and less stretch at the same speed",
    ),
}
SPIN_UP = Parameter(
    *("λ", "spin-up", "spin-up", "T*² dΩ/dt"),
    limits=(-1000.0, 1000.0),
    slider=(-20.0, 20.0, 0.1),
    hint="How fast the speed grows. The beam lags behind its hub and is bent; below 0, where the"
    " speed falls, it runs ahead",
)
SECTION = {  # of bending in space
    "flap": Parameter(
        *("κ", "flapwise stiffness", "flap", "EI_flap / EI"),
        limits=(1e-4, 1e4),
        slider=(0.01, 4.0, 0.01),
        hint="Stiffness for bending out of the plane of rotation over that in it. 1: a round or a"
        " square section, below 1: a flat one that lies in the plane",
    ),
    "pitch": Parameter(
        *("θ", "pitch", "pitch", "angle of the section at the root [deg]"),
        limits=TURN_LIMITS,
        slider=(-90.0, 90.0, 0.5),
        hint="Angle in degrees by which the section at the root is turned about the beam, from the"
        " plane of rotation towards its axis. It couples bending in and out of the plane",
    ),
    "twist": Parameter(
        *("φ", "twist", "twist", "turn of the section, root to tip [deg]"),
        limits=TURN_LIMITS,
        slider=(-90.0, 90.0, 0.5),
        hint="Angle in degrees by which the section at the tip is turned from that at the root, in"
        " proportion to x between them",
    ),
}
NUMBERS = {**PARAMETERS, "spin_up": SPIN_UP, **SECTION}
MAX_GAMMA_OVER_MU = 5.0
TOML_SUFFIXES = (".toml", "")
ROUNDING = 1e-12  # relative, so that mu = gamma / 5 is accepted


@dataclass(frozen=True, repr=False)
class Beam:
    """A beam on a rotating hub with a concentrated mass (paper, eq. 45), by dimensionless numbers:
    lengths in L, times in T* = sqrt(rho A L^4 / (E I)). Of a beam that is not uniform rho A, E I
    and E A are those of its root section.

    alpha: mass ratio m / (rho A L)
    beta: mass location d / L
    gamma: speed Omega T*
    delta: hub radius a / L; negative: the beam points inward
    mu: slenderness sqrt(A L^2 / I)
    units: of a beam given in SI
    spin_up: lambda = T*^2 dOmega/dt of a beam whose speed changes
    blade: properties along the span
    masses: more bodies
    root: stiffness [E I / L] of a rotational spring at the root: 0 for a hinge, infinite for a
        clamp
    flap: of a uniform beam: stiffness for bending out of the plane of rotation over E I, that in
        it; a blade has its own
    pitch: angle [deg] by which the section at the root is turned about the beam, from the plane of
        rotation towards its axis; a turned section needs plane="both"
    twist: angle [deg] of the tip beyond the root, in proportion to x between them

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
    flap: float = 1.0
    pitch: float = 0.0
    twist: float = 0.0

    def __new__(cls, *_: Any, **numbers: Any) -> Self:
        for name in numbers.keys() - cls.__dataclass_fields__.keys():
            raise unknown_keyword("number", name, NUMBERS)
        return super().__new__(cls)

    def __post_init__(self) -> None:
        checks: list[Callable[[], None]] = [partial(self._check, name) for name in NUMBERS]
        checks.append(lambda: check_joint_limit(self.gamma, self.mu))
        together(checks)
        if not isinstance(self.blade, Blade | None):
            raise InvalidInput(f"blade = {self.blade!r}: must be a Blade")
        if self.blade is not None and self.flap != 1:
            raise InvalidInput(
                f"flap = {self.flap:g}: is that of a uniform beam; a blade has its own `flap`"
            )
        masses: Any = self.masses
        bodies = tuple(masses) if isinstance(masses, Iterable) else (masses,)
        if not all(isinstance(body, Mass) for body in bodies) or isinstance(masses, Mass):
            raise InvalidInput(f"masses = {masses!r}: must be a sequence of Mass")
        object.__setattr__(self, "masses", bodies)
        root: Any = self.root
        if not (isinstance(root, float) and math.isinf(root) and root > 0):
            object.__setattr__(self, "root", check_float("root", root, 0.0))

    def _check(self, name: str) -> None:
        """InvalidInput for a number out of range; one that is valid becomes a float."""
        (low, high), value = NUMBERS[name].limits, getattr(self, name)
        valid = type(value) is float and low <= value <= high  # fast
        if not valid or (value == 0 and math.copysign(1.0, value) < 0):
            object.__setattr__(self, name, check_float(name, value, low, high))

    @property
    def is_uniform(self) -> bool:
        """Whether it is the beam of the paper: the same section along the span, at most one
        concentrated mass, clamped."""
        return self.blade is None and not self.masses and self.root == math.inf

    @property
    def is_prismatic(self) -> bool:
        """Whether it is uniform but for the bending stiffness out of the plane of rotation, which
        has no effect in that plane."""
        one_section = self.blade is None or self.blade.is_prismatic
        return one_section and not self.masses and self.root == math.inf

    @property
    def is_turned(self) -> bool:
        """Whether a turned section couples bending in the plane of rotation and out of it: one that
        does not bend as easily in every direction, or carries a body that does not turn so."""
        blade = self.blade
        if self.pitch == 0 and self.twist == 0 and (blade is None or blade.twist is None):
            return False
        stations: tuple[float, ...] = (0.0, 1.0)
        twists: tuple[float, ...] = (0.0, 0.0)
        if blade is not None:
            stations, twists = blade.x, blade.twist or (0.0,) * len(blade.x)
        pairs = zip(stations, twists, strict=True)
        turns = {self.pitch + self.twist * x + twist for x, twist in pairs}
        if len(turns) == 1 and turns.pop() % 180 == 0:
            return False
        return not self.bends_alike

    @property
    def bends_alike(self) -> bool:
        """Whether the section bends as easily in every direction, and bodies turn so: pitch and
        twist have no effect then."""
        differ, blade = self.flap != 1, self.blade
        if blade is not None:
            differ = blade.flap is not None and blade.flap != blade.bending
        return not differ and all(Jy == Jz for _, Jy, Jz in (mass.inertia for mass in self.masses))

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
        """The five numbers by name, and the others where they differ from those by default."""
        values = {name: getattr(self, name) for name in NUMBERS}
        return {
            name: value
            for name, value in values.items()
            if name in PARAMETERS or value != getattr(type(self), name)
        }

    def __repr__(self) -> str:
        values = {name: getattr(self, name) for name in ("units", "blade", "masses", "root")}
        given = {name: x for name, x in values.items() if x != getattr(type(self), name)}
        texts = (f"{name}={value!r}" for name, value in (self.numbers | given).items())
        return f"Beam({', '.join(texts)})"

    @property
    def summary(self) -> str:
        """The numbers, rounded, and in words what is not uniform: alpha=1, beta=0.5, ..."""
        numbers = [f"{name}={value:g}" for name, value in self.numbers.items()]
        return ", ".join([*numbers, *self.structure])

    @property
    def structure(self) -> list[str]:
        """What is not uniform, in words: a blade of 5 stations, 2 more masses, hinged root."""
        texts = []
        if self.blade and self.blade.is_prismatic:
            stiffness = f"{self.blade.flap[0]:g} E I" if self.blade.flap else "E I"
            texts.append(f"flapwise stiffness {stiffness}")
        elif self.blade:
            texts.append(f"a blade of {len(self.blade.x)} stations")
        if self.masses:
            more, s = " more" if self.alpha else "", "" if len(self.masses) == 1 else "es"
            texts.append(f"{len(self.masses)}{more} mass{s}")
        if self.root != math.inf:
            texts.append(f"root stiffness {self.root:g}" if self.root else "hinged root")
        if self.mu == INEXTENSIBLE:
            texts.append("inextensible")
        return texts

    def described(self, names: Iterable[str]) -> str:
        """Some of the numbers, and in words what is not uniform: α = 1, β = 0.5, hinged root."""
        numbers = (f"{NUMBERS[name].symbol} = {getattr(self, name):g}" for name in names)
        return ", ".join([*numbers, *self.structure])

    @property
    def record(self) -> dict[str, Any]:
        """The numbers, and of a beam that is not uniform its blade, masses and root, in the types
        of JSON."""
        record: dict[str, Any] = dict(self.numbers)
        if self.blade:
            record["blade"] = self.blade.record
        if self.masses:
            record["masses"] = [mass.record for mass in self.masses]
        return record | ({"root": self.root} if self.root != math.inf else {})

    @property
    def attributes(self) -> dict[str, float | str]:
        """The record as attributes of a dataset, which hold numbers and texts: blade and masses as
        JSON."""
        return {
            name: value if isinstance(value, float) else json.dumps(value)
            for name, value in self.record.items()
        }

    @classmethod
    def from_record(cls, record: Mapping[str, Any], units: Units | None = None) -> Self:
        """The beam of a record, or of the attributes of a dataset. Raises InvalidInput."""
        return cls(**from_record(record), units=units)

    @classmethod
    def from_si(cls, **values: Any) -> Self:
        """A beam from SI values.

        Values are numbers, or texts with a unit, as length="24 in". length [m]. The section:
        mass_per_length [kg/m], bending_stiffness [N m^2] and axial_stiffness [N], without which the
        beam is inextensible; each a number, or a sequence of one for each of the stations [m] from
        0 at the root to the length. Between stations they are linear (or polynomials of a `degree`,
        see `Blade`); a station named twice is a jump. Or, of a uniform beam: density [kg/m^3], area
        [m^2], second_moment [m^4] and youngs_modulus [Pa]; then, for its stress, also yield_stress
        [Pa] and section_height [m], its size in the plane of bending. All bend in the plane of
        rotation; flap_stiffness [N m^2]: out of it, where it is another one, as E h b^3 / 12 of a
        bar b x h whose h is in the plane.
        pitch [deg]: angle by which the section is turned at the root, from the plane of rotation
        towards its axis; twist [deg]: that of the tip beyond the root, or one for each station.

        hub_radius [m]; rotation_speed [rad/s] or rotation_rpm [1/min]; angular_acceleration
        [rad/s^2]; mass [kg] and mass_position [m] from the root, by default the tip; masses: more
        bodies, each a dict of mass [kg], position [m] and inertia (Jx, Jy, Jz) [kg m^2] along the
        beam, across it in the plane of rotation, and parallel to the axis of rotation;
        root_stiffness [N m/rad] of a spring at the root, 0 for a hinge, by default a clamp.

        Warns with ImplausibleInput of a value that is likely in another unit. Raises InvalidInput,
        which names for a mistyped keyword the nearest, with its unit.
        """
        beam = cls.of_physical(PhysicalBeam.of(values))
        beam.warn_of_doubts(stacklevel=3)
        return beam

    @classmethod
    def of_physical(cls, physical: PhysicalBeam) -> Self:
        """The dimensionless beam of a physical one, without warnings. Raises InvalidInput."""
        numbers, checks = physical.numbers, list[Callable[[], object]]()
        for name, parameter in NUMBERS.items():
            numbers[name] = rounded_into(numbers[name], *parameter.limits)
            named = f"{physical.formulas[name]} = {name}"
            checks.append(partial(check_float, named, numbers[name], *parameter.limits))
        checks.append(partial(check_joint_limit, numbers["gamma"], numbers["mu"]))
        try:
            together(checks)
        except InvalidInput as error:
            raise InvalidInput("; ".join([str(error), *doubts(physical)])) from None
        return cls(
            **numbers,
            units=physical.units,
            blade=physical.blade,
            masses=physical.bodies,
            root=physical.root,
        )

    @property
    def si(self) -> dict[str, Any]:
        """The keywords of `from_si` for this beam; {} where its mass is not known."""
        return self.physical.values if self.physical else {}

    @property
    def doubts(self) -> tuple[str, ...]:
        """A sentence for each value of a beam in SI that is likely in another unit."""
        return doubts(self.physical) if self.physical else ()

    def warn_of_doubts(self, stacklevel: int = 2) -> None:
        """Warn of each value that is likely in another unit; stacklevel: as in `warnings.warn`."""
        for text in self.doubts:
            warnings.warn(text, ImplausibleInput, stacklevel)

    @property
    def mass_properties(self) -> MassProperties | None:
        """Mass, centre of mass and moments of the beam itself; None where its mass is not known."""
        return mass_properties(self.blade, self.units, self.delta) if self.units else None

    @property
    def physical(self) -> PhysicalBeam | None:
        """The beam in SI; None where its mass is not known."""
        if self.units is None:
            return None
        return physical_beam(self.numbers, self.units, self.blade, self.masses, self.root)

    @classmethod
    def from_toml(cls, path: str | Path) -> Self:
        """A beam from a TOML file of `from_si` keywords, with [[masses]] as tables, and
        stations_file = "blade.csv", relative to it, in place of stations and properties: a file of
        any format that `from_file` reads.
        InvalidInput names the file, the key and its unit."""
        table = parse_toml(read_small(path), str(path))
        with errors_of_file(str(path), VALUE_UNITS):
            return cls.from_si(**check_si_table(table, str(path), Path(path).parent))

    @classmethod
    def from_file(cls, path: str | Path, **values: Any) -> Self:
        """A beam from a file: TOML (`from_toml`), or a blade as CSV, ElastoDyn blade or main input
        file (.dat), BModes section properties or .bmi, HAWC2 structure (st; "blade_st.dat#1.2" is
        its set 1, subset 2) or FLEX (.bld).

        A CSV file has the columns station, mass_per_length, bending_stiffness, and optionally
        axial_stiffness, flap_stiffness and twist, in any order, with units in the names or in a row
        below; separated by commas, semicolons, tabs or blanks; with decimal points or commas.

        values: other keywords of `from_si`, as length, hub_radius and rotation_rpm, which replace
        those of the file. Warns with LeftOut of what the model leaves out. InvalidInput names the
        file, line, station and column.
        """
        if Path(path).suffix.lower() in TOML_SUFFIXES:
            if values:
                name, value = next(iter(values.items()))
                raise InvalidInput(f"{name} = {value!r} and {path}: give it in the file")
            return cls.from_toml(path)
        with errors_of_file(str(path), VALUE_UNITS):
            return cls.from_si(**(read_blade_file(path, values) | values))


def exceeds_joint_limit(gamma: Any, mu: Any) -> bool:
    """Whether a speed is too high for the slenderness, each of them at the nearest value in its own
    range: that of one out of range is told beside. False where one is no number."""
    if not (is_number(gamma) and is_number(mu)):
        return False
    (_, most), (least, largest) = PARAMETERS["gamma"].limits, PARAMETERS["mu"].limits
    nearest = min(max(mu, least), largest)
    return mu > 0 and min(gamma, most) > MAX_GAMMA_OVER_MU * nearest * (1 + ROUNDING)


def check_joint_limit(gamma: Any, mu: Any) -> None:
    """InvalidInput for a speed too high for the slenderness."""
    if exceeds_joint_limit(gamma, mu):
        gamma, mu = as_float(gamma), as_float(mu)
        raise InvalidInput(
            f"gamma / mu = {full_text(gamma / mu)}: must be at most {MAX_GAMMA_OVER_MU:g}"
            f" (gamma = {full_text(gamma)}, mu = {full_text(mu)})"
        )


def rounded_into(value: float, low: float, high: float) -> float:
    """A number that rounding has brought just outside its limits, at the limit."""
    slack = ROUNDING * max(abs(low), abs(high))
    return min(max(value, low), high) if low - slack <= value <= high + slack else value


def from_json(name: str, value: Any) -> Any:
    """The value of a text of JSON; any other value as it is. Raises InvalidInput."""
    if not isinstance(value, str):
        return value
    try:
        return json.loads(value)
    except (ValueError, RecursionError):
        raise InvalidInput(f"{name} = {value!r}: must be a table, or JSON of one") from None


def from_record(record: Mapping[str, Any]) -> dict[str, Any]:
    """The keywords of `Beam` in a record, its blade and masses made of plain values, or of JSON.
    Raises InvalidInput."""
    values = {
        name: from_json(name, value) if name in ("blade", "masses") else value
        for name, value in record.items()
    }
    if isinstance(blade := values.get("blade"), Mapping):
        values["blade"] = Blade.from_record(blade) if blade else None
    masses = values.get("masses", ())
    if isinstance(masses, list | tuple):
        masses = tuple(Mass.from_record(m) if isinstance(m, Mapping) else m for m in masses)
    return values | ({"masses": masses} if "masses" in values else {})
