"""A beam in SI units: its keywords, their checks, and its dimensionless numbers, both ways.

With rho A, EI and EA of the section at the root and the length L:

    T*    = sqrt(rho A L^4 / (EI))          mu    = L sqrt(EA / EI)
    alpha = mass / (rho A L)                gamma = rotation_speed T*

The section is given by its mass and stiffnesses, as numbers or at stations, or by a material and
the area and second moment of a uniform beam.
"""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, Self

from beamviz.blade import PROPERTY_LIMITS, TWIST_LIMITS, Blade, Mass, check_inertia
from beamviz.blade_files import read_blade_file
from beamviz.checks import check_float, check_floats, check_int, check_positive, together
from beamviz.conversions import in_si
from beamviz.errors import InvalidInput, unknown_keyword
from beamviz.units import Units

MATERIAL = {
    "density": "kg/m^3",
    "area": "m^2",
    "second_moment": "m^4",
    "youngs_modulus": "Pa",
}
STRENGTH = {"yield_stress": "Pa", "section_height": "m"}  # optional, beside the material
SECTION = {"mass_per_length": "kg/m", "bending_stiffness": "N m^2", "axial_stiffness": "N"}
FLAP = {"flap_stiffness": "N m^2"}
TURN = {"pitch": "deg", "twist": "deg"}
SI_KEYS = {  # and their units
    "length": "m",
    **MATERIAL,
    **STRENGTH,
    **SECTION,
    **FLAP,
    **TURN,
    "stations": "m",
    "degree": "1",
    "hub_radius": "m",
    "rotation_speed": "rad/s",
    "rotation_rpm": "1/min",
    "mass": "kg",
    "mass_position": "m",
    "masses": "a list of tables of mass, position and inertia",
    "root_stiffness": "N m/rad",
    "angular_acceleration": "rad/s^2",
}
SIZE_KEYS = (
    "length",
    *MATERIAL,
    *STRENGTH,
    *SECTION,
    *FLAP,
    *TURN,
    "stations",
    "degree",
)  # of the beam alone
FILE_KEYS = {**SI_KEYS, "stations_file": "a file of a blade"}
MASS_KEYS = {"mass": "kg", "position": "m", "inertia": "kg m^2"}
VALUE_UNITS = {  # of the keys whose values have one
    name: unit
    for name, unit in {**SI_KEYS, **MASS_KEYS}.items()
    if name not in ("degree", "masses")
}
SI_SYNONYMS = {  # other names of these values
    **dict.fromkeys(("rpm", "n"), "rotation_rpm"),
    **dict.fromkeys(("speed", "omega", "Omega", "angular_velocity"), "rotation_speed"),
    **dict.fromkeys(("E", "modulus", "elastic_modulus"), "youngs_modulus"),
    **dict.fromkeys(("I", "inertia", "moment_of_inertia"), "second_moment"),
    **dict.fromkeys(("EI", "EI_lag", "EI_edge", "chord_stiffness"), "bending_stiffness"),
    **dict.fromkeys(("EI_flap", "flapwise_stiffness"), "flap_stiffness"),
    **dict.fromkeys(("rhoA", "linear_density", "mass_density", "m_per_length"), "mass_per_length"),
    **dict.fromkeys(("a", "radius", "offset"), "hub_radius"),
    **dict.fromkeys(("d", "position"), "mass_position"),
    **dict.fromkeys(("hinge_stiffness", "spring"), "root_stiffness"),
    **dict.fromkeys(("station", "span", "x"), "stations"),
    **dict.fromkeys(("structural_twist", "StrcTwst", "str_tw"), "twist"),
    **dict.fromkeys(("collective", "setting_angle", "pitch_angle"), "pitch"),
    "bodies": "masses",
    "EA": "axial_stiffness",
    **dict.fromkeys(("yield_strength", "sigma_y", "R_e", "Rp02"), "yield_stress"),
    **dict.fromkeys(("height", "thickness", "h"), "section_height"),
    "L": "length",
    "rho": "density",
    "A": "area",
    "m": "mass",
    "spin_up": "angular_acceleration",
}
SI_REQUIRED = ("length", *MATERIAL)  # of a uniform beam by its material
OPTIONAL = ("axial_stiffness",)  # of SECTION: without it the beam is inextensible
INEXTENSIBLE = 1e6  # mu: the stretch, about (gamma / mu)^2, is below 1e-8 up to gamma = 100
MAX_MASSES = 20
TURN_LIMITS = (-180.0, 180.0)  # [deg] of pitch and twist
ROUNDING = 1e-9  # relative, of the height of a section
AT_TIP = 1e-9  # rounding of the last station, relative to the length
RPM = math.pi / 30  # [rad/s]

Row = tuple[float, ...]  # of a property, at each station


@dataclass(frozen=True)
class Body:
    """A body on a beam: mass [kg], position [m] from the root, principal inertias (Jx, Jy, Jz)
    [kg m^2]."""

    mass: float
    position: float
    inertia: Row = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class PhysicalBeam:
    """A beam in SI units; properties of the section at the stations, which are 0 and the length
    where it is uniform.

    density and youngs_modulus are known of a beam by its material, whose section does not vary,
    yield_stress and section_height if they were given beside these.
    """

    length: float
    stations: Row
    mass_per_length: Row
    bending_stiffness: Row
    axial_stiffness: Row
    flap_stiffness: Row | None = None
    degree: int = 1
    density: float | None = None
    youngs_modulus: float | None = None
    yield_stress: float | None = None
    section_height: float | None = None
    hub_radius: float = 0.0
    rotation_speed: float = 0.0
    mass: float = 0.0
    mass_position: float = 0.0
    masses: tuple[Body, ...] = ()
    root_stiffness: float = math.inf
    angular_acceleration: float = 0.0
    pitch: float = 0.0  # [deg]
    twist: float = 0.0  # [deg] from the root to the tip, in proportion to the distance
    twists: Row | None = None  # [deg] more of it, at the stations

    @property
    def is_prismatic(self) -> bool:
        """Whether no property varies along the span."""
        rows = (getattr(self, name) for name in (*SECTION, *FLAP, "twists"))
        return all(row is None or len(set(row)) == 1 for row in rows)

    @property
    def is_inextensible(self) -> bool:
        """Whether its axial stiffness stands for that of a beam that does not stretch."""
        is_constant = len(set(self.axial_stiffness)) == 1
        return is_constant and math.isclose(self.slenderness, INEXTENSIBLE, rel_tol=ROUNDING)

    @property
    def slenderness(self) -> float:
        """mu of the section at the root."""
        return self.length * math.sqrt(self.axial_stiffness[0] / self.bending_stiffness[0])

    @property
    def is_uniform(self) -> bool:
        """Whether no property varies along the span, nor with the plane of bending."""
        return self.flap_stiffness is None and self.twists is None and self.is_prismatic

    @property
    def time(self) -> float:
        """T* [s]."""
        L, m, EI = self.length, self.mass_per_length[0], self.bending_stiffness[0]
        return L * L * math.sqrt(m / EI)

    @property
    def units(self) -> Units:
        """The sizes of the dimensionless beam; InvalidInput where they are 0 or infinite."""
        whole, time = self.mass_per_length[0] * self.length, self.time
        for name, value in {"T* [s]": time, f"{self.formulas['mass']} [kg]": whole}.items():
            if not (math.isfinite(value) and value > 0):
                raise InvalidInput(f"{name} = {value:g}: the SI values are too extreme")
        strength: tuple[float | None, ...] = ()
        if self.is_prismatic:
            strength = self.youngs_modulus, self.yield_stress, self.section_height
        return Units(self.length, time, whole, *strength)

    @property
    def formulas(self) -> dict[str, str]:
        """The dimensionless numbers in the keywords that were given, and the mass of the beam."""
        by_material = self.density is not None
        mass = "density area length" if by_material else "mass_per_length length"
        gyration = "area / second_moment" if by_material else "axial_stiffness / bending_stiffness"
        return {
            "mass": mass,
            "alpha": f"mass / ({mass})",
            "beta": "mass_position / length",
            "gamma": "rotation_speed T*",
            "delta": "hub_radius / length",
            "mu": f"length sqrt({gyration})",
            "spin_up": "angular_acceleration T*^2",
            "flap": "flap_stiffness / bending_stiffness",
            "pitch": "pitch",
            "twist": "twist",
        }

    @property
    def numbers(self) -> dict[str, float]:
        """The dimensionless numbers; InvalidInput where the values are too extreme."""
        units, L = self.units, self.length
        assert units.mass
        return {
            "alpha": self.mass / units.mass,
            "beta": self.mass_position / L,
            "gamma": self.rotation_speed * units.time,
            "delta": self.hub_radius / L,
            "mu": INEXTENSIBLE if self.is_inextensible else self.slenderness,
            "spin_up": self.angular_acceleration * units.time * units.time,
            "flap": 1.0,  # a flapwise stiffness is that of a blade
            "pitch": self.pitch,
            "twist": self.twist,
        }

    @property
    def blade(self) -> Blade | None:
        """The properties relative to the root, None for a uniform beam."""
        if self.is_uniform:
            return None

        def relative(name: str, row: Row, base: float) -> Row:
            ratios = [value / base for value in row]
            low, high = PROPERTY_LIMITS
            wrong = next((k for k, ratio in enumerate(ratios) if not low <= ratio <= high), None)
            if wrong is not None:
                place = f"station {wrong + 1} at {self.stations[wrong]:g} m"
                check_float(f"{name} of {place} over that at the root", ratios[wrong], low, high)
            return tuple(ratios)

        m, EI, EA = self.mass_per_length, self.bending_stiffness, self.axial_stiffness
        flap = self.flap_stiffness
        return Blade(
            x=tuple(station / self.length for station in self.stations),
            mass=relative("mass_per_length", m, m[0]),
            bending=relative("bending_stiffness", EI, EI[0]),
            axial=relative("axial_stiffness", EA, EA[0]),
            flap=relative("flap_stiffness", flap, EI[0]) if flap else None,
            degree=self.degree,
            twist=self.twists,
        )

    @property
    def bodies(self) -> tuple[Mass, ...]:
        """The bodies besides the concentrated mass."""
        units, L = self.units, self.length
        assert units.mass
        J = units.mass * L * L
        bodies = []
        for k, body in enumerate(self.masses, 1):
            Jx, Jy, Jz = (value / J for value in body.inertia)
            try:
                bodies.append(Mass(body.mass / units.mass, body.position / L, (Jx, Jy, Jz)))
            except InvalidInput as error:
                raise InvalidInput(f"masses {k}, over {self.formulas['mass']}: {error}") from None
        return tuple(bodies)

    @property
    def root(self) -> float:
        """Stiffness [E I / L] of the spring at the root."""
        return self.root_stiffness * self.length / self.bending_stiffness[0]

    @property
    def values(self) -> dict[str, Any]:
        """The keywords that describe this beam; those of no effect are left out."""
        values: dict[str, Any] = {"length": self.length}
        if self.density is not None and self.youngs_modulus is not None and self.is_prismatic:
            area = self.mass_per_length[0] / self.density
            values["density"] = self.density
            values["area"] = area
            values["second_moment"] = self.bending_stiffness[0] / self.youngs_modulus
            values["youngs_modulus"] = self.youngs_modulus
            strength = {name: getattr(self, name) for name in STRENGTH}
            values |= {name: value for name, value in strength.items() if value is not None}
            if self.flap_stiffness:
                values["flap_stiffness"] = self.flap_stiffness[0]
        else:
            values |= self.section_values
        values["hub_radius"] = self.hub_radius
        values["rotation_speed"] = self.rotation_speed
        values["mass"] = self.mass
        values["mass_position"] = self.mass_position
        values["angular_acceleration"] = self.angular_acceleration
        if self.masses:
            values["masses"] = [
                vars(body) | {"inertia": list(body.inertia)} for body in self.masses
            ]
        values |= {name: getattr(self, name) for name in TURN if getattr(self, name)}
        if self.twists:
            along = zip(self.stations, self.twists, strict=True)
            values["twist"] = [self.twist * x / self.length + twist for x, twist in along]
        if self.root_stiffness != math.inf:
            values["root_stiffness"] = self.root_stiffness
        return values

    @property
    def section_values(self) -> dict[str, Any]:
        """The keywords of the section: numbers, or lists with the stations where they vary."""
        rows = {name: getattr(self, name) for name in (*SECTION, *FLAP)}
        if self.is_inextensible:
            del rows["axial_stiffness"]
        if len(self.stations) == 2 and self.is_prismatic and self.twists is None:
            return {name: row[0] for name, row in rows.items() if row is not None}
        values: dict[str, Any] = {name: list(row) for name, row in rows.items() if row is not None}
        values["stations"] = list(self.stations)
        return values | ({"degree": self.degree} if self.degree > 1 else {})

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> Self:
        """The beam of some keywords. Raises InvalidInput, which names for an unknown keyword the
        nearest, for a missing one its unit."""
        for name in values:
            if name not in SI_KEYS:
                raise unknown_keyword("value", name, SI_KEYS, SI_SYNONYMS, SI_KEYS)
        given = {name: in_si(name, plain(value), SI_KEYS[name]) for name, value in values.items()}
        if missing := missing_key(given):
            raise InvalidInput(f"missing value {missing}")
        L, stations = span(given)
        beam = cls(L, stations, **section(given, stations), **turn(given, stations))
        position = given.get("mass_position")
        return replace(
            beam,
            hub_radius=check_float("hub_radius", given.get("hub_radius", 0.0)),
            rotation_speed=speed(given),
            mass=check_float("mass", given.get("mass", 0.0), 0.0),
            mass_position=L if position is None else check_float("mass_position", position, 0.0, L),
            masses=bodies(given.get("masses", ()), L),
            root_stiffness=stiffness_of_root(given.get("root_stiffness")),
            angular_acceleration=check_float(
                "angular_acceleration", given.get("angular_acceleration", 0.0)
            ),
        )


def plain(value: Any) -> Any:
    """Arrays as lists."""
    return value.tolist() if hasattr(value, "tolist") else value


# A beam that any one value fits, by its material and by its stiffnesses.
BY_MATERIAL = dict.fromkeys(("length", *MATERIAL), 1.0)
BY_SECTION = dict.fromkeys(("length", *SECTION), 1.0)


def wrong_values(values: Mapping[str, Any]) -> list[InvalidInput]:
    """The errors of the keywords that are wrong each by itself, in a beam that is valid without
    them."""
    valid: dict[str, Any] = dict(BY_MATERIAL if values.keys() & MATERIAL.keys() else BY_SECTION)
    errors: dict[str, InvalidInput] = {}
    for name in dict.fromkeys(("length", "stations", *SI_KEYS)):
        if name not in values or ("stations" in errors and isinstance(values[name], list)):
            continue  # a list has no meaning without stations
        if name == "section_height" and {"area", "second_moment"} & errors.keys():
            continue  # which it is compared with
        trial = valid | {name: values[name]}
        if name == "stations" and ("length" not in values or "length" in errors):
            del trial["length"]  # it is that of the last one
        try:
            PhysicalBeam.of(trial)
        except InvalidInput as error:
            errors[name] = error
        else:
            valid = trial
    return list(errors.values())


def missing_key(values: Mapping[str, Any]) -> str:
    """The first keyword that is missing, with its unit; "" if none is."""
    given = {name for name, value in values.items() if value is not None}
    if not given & {"length", "stations"}:
        return "'length' [m]"
    by_material, by_section = given & MATERIAL.keys(), given & {*SECTION, *FLAP, "stations"}
    if by_material and given & SECTION.keys():
        return ""  # which exclude each other
    if not (by_section or by_material):
        section = ", ".join(f"{name!r} [{unit}]" for name, unit in SECTION.items())
        return f"'density' [kg/m^3], and others of the material; or {section}"
    needed = MATERIAL if by_material else [name for name in SECTION if name not in OPTIONAL]
    return next((f"{name!r} [{VALUE_UNITS[name]}]" for name in needed if name not in given), "")


def span(values: Mapping[str, Any]) -> tuple[float, Row]:
    """The length and the stations, 0 and the length where none are given."""
    stations = values.get("stations")
    if stations is None:
        L = check_positive("length", values["length"])
        return L, (0.0, L)
    stations = check_floats("stations", stations)
    if len(stations) < 2 or stations[0] != 0 or sorted(stations) != list(stations):
        raise InvalidInput(
            f"stations = {list(stations)[:3]} ...: must ascend from 0 at the root to the length;"
            " the radius of the root is hub_radius"
        )
    given = values.get("length")
    L = check_positive("length", stations[-1] if given is None else given)
    if not math.isclose(stations[-1], L, rel_tol=AT_TIP):
        raise InvalidInput(f"stations end at {stations[-1]:g} m: must end at length = {L:g} m")
    return L, tuple(L if station == stations[-1] else station for station in stations)


def section(values: Mapping[str, Any], stations: Row) -> dict[str, Any]:
    """The fields of a beam that describe its section, of its material or of its stiffnesses."""
    by_material = [name for name in MATERIAL if values.get(name) is not None]
    by_section = [name for name in SECTION if values.get(name) is not None]
    if by_material and by_section:
        raise InvalidInput(
            f"{by_material[0]} and {by_section[0]} exclude each other: give {', '.join(MATERIAL)},"
            f" or {', '.join(SECTION)}"
        )
    fields: dict[str, Any] = {}
    if by_material:
        rho, A, I, E = (check_positive(name, values[name]) for name in MATERIAL)
        rows = {"mass_per_length": rho * A, "bending_stiffness": E * I, "axial_stiffness": E * A}
        for name, value in rows.items():
            if not (math.isfinite(value) and value > 0):
                text = MATERIAL_FORMULAS[name]
                raise InvalidInput(f"{text} = {value:g}: the SI values are too extreme")
        fields |= {"density": rho, "youngs_modulus": E, **strength(values, A, I)}
        fields |= {name: (value,) * len(stations) for name, value in rows.items()}
    elif given := [name for name in STRENGTH if values.get(name) is not None]:
        raise InvalidInput(
            f"{given[0]} needs {', '.join(MATERIAL)}: the stress of a beam by its stiffnesses is"
            " not known"
        )
    else:
        given = [name for name in SECTION if values.get(name) is not None]
        fields |= {name: along(name, values[name], values, stations) for name in given}
        if "axial_stiffness" not in fields:
            stiffness = fields["bending_stiffness"][0] * (INEXTENSIBLE / stations[-1]) ** 2
            fields["axial_stiffness"] = (stiffness,) * len(stations)
    if (flap := values.get("flap_stiffness")) is not None:
        fields["flap_stiffness"] = along("flap_stiffness", flap, values, stations)
    if (degree := values.get("degree")) is not None:
        fields["degree"] = check_int("degree", degree, 1, 8)
    return fields


def strength(values: Mapping[str, Any], area: float, second_moment: float) -> dict[str, float]:
    """The yield stress and the height of a section, those that are given. No part of a section is
    farther from its axis than half its height, so its radius of gyration is at most that."""
    given = {
        name: check_positive(name, values[name])
        for name in STRENGTH
        if values.get(name) is not None
    }
    height, least = given.get("section_height"), 2 * math.sqrt(second_moment / area)
    if height is not None and height < least * (1 - ROUNDING):
        raise InvalidInput(
            f"section_height = {height:g}: must be at least 2 sqrt(second_moment / area) ="
            f" {least:.6g} m"
        )
    return given


MATERIAL_FORMULAS = {
    "mass_per_length": "density area [kg/m]",
    "bending_stiffness": "youngs_modulus second_moment [N m^2]",
    "axial_stiffness": "youngs_modulus area [N]",
}


def along(name: str, value: Any, values: Mapping[str, Any], stations: Row) -> Row:
    """A property at the stations, of a number or of one number for each."""
    if isinstance(value, str) or not isinstance(value, Iterable):
        return (check_positive(name, value),) * len(stations)
    numbers = list(value)
    if values.get("stations") is None:
        raise InvalidInput(f"{name}: {len(numbers)} values need stations [m], one for each")
    if len(numbers) != len(stations):
        raise InvalidInput(f"{name}: {len(numbers)} values, {len(stations)} stations")
    places = (f"{name} of station {k} at {x:g} m" for k, x in enumerate(stations, 1))
    checks = (partial(check_positive, *pair) for pair in zip(places, numbers, strict=True))
    return tuple(together(checks))


def turn(values: Mapping[str, Any], stations: Row) -> dict[str, Any]:
    """The fields of a beam that describe how its section is turned."""
    fields: dict[str, Any] = {"pitch": check_float("pitch", values.get("pitch", 0.0), *TURN_LIMITS)}
    twist = values.get("twist", 0.0)
    if isinstance(twist, str) or not isinstance(twist, Iterable):
        return fields | {"twist": check_float("twist", twist, *TURN_LIMITS)}
    row = check_floats("twist", twist, *TWIST_LIMITS)
    if values.get("stations") is None:
        raise InvalidInput(f"twist: {len(row)} values need stations [m], one for each")
    if len(row) != len(stations):
        raise InvalidInput(f"twist: {len(row)} values, {len(stations)} stations")
    return fields | {"twists": row if any(row) else None}


def speed(values: Mapping[str, Any]) -> float:
    """The rotation speed [rad/s]."""
    rpm = values.get("rotation_rpm")
    if rpm is None:
        return check_float("rotation_speed", values.get("rotation_speed", 0.0), 0.0)
    if values.get("rotation_speed") is not None:
        raise InvalidInput("rotation_speed [rad/s] and rotation_rpm [1/min] exclude each other")
    return check_float("rotation_rpm", rpm, 0.0) * RPM


def bodies(records: Any, length: float) -> tuple[Body, ...]:
    """The bodies of a list of tables; InvalidInput names the numbers of wrong ones, from 1."""
    if isinstance(records, str | Mapping) or not isinstance(records, Iterable):
        raise InvalidInput(f"masses = {records!r}: must be {SI_KEYS['masses']}")
    records = list(records)
    if len(records) > MAX_MASSES:
        raise InvalidInput(f"{len(records)} masses: must be at most {MAX_MASSES}")
    checks = (partial(body, record, f"masses {k}", length) for k, record in enumerate(records, 1))
    return tuple(together(checks))


def body(record: Any, name: str, length: float) -> Body:
    """A body of a table."""
    if not isinstance(record, Mapping):
        raise InvalidInput(f"{name} = {record!r}: must be a table of mass, position and inertia")
    for key in record:
        if key not in MASS_KEYS:
            synonyms = {"mass_position": "position", "J": "inertia", "m": "mass", "x": "position"}
            error = unknown_keyword("key", str(key), MASS_KEYS, synonyms, MASS_KEYS)
            raise InvalidInput(f"{name}: {error}")
    inertia = plain(record.get("inertia", (0.0,) * 3))
    checks: tuple[Callable[[], Any], ...] = (
        partial(required_float, name, "mass", record),
        partial(required_float, name, "position", record, length),
        partial(check_inertia, f"{name}: inertia", inertia),
    )
    return Body(*together(checks))


def required_float(name: str, key: str, record: Mapping[str, Any], most: float = math.inf) -> float:
    """The number of a key in the table of a body, from 0 to the largest, or InvalidInput."""
    if record.get(key) is None:
        raise InvalidInput(f"{name}: missing {key!r} [{MASS_KEYS[key]}]")
    full_name = f"{name}: {key}"
    return check_float(full_name, in_si(full_name, record[key], MASS_KEYS[key]), 0.0, most)


def stiffness_of_root(value: Any) -> float:
    """The stiffness [N m/rad] of the spring at the root, infinite for a clamp."""
    return math.inf if value in (None, math.inf) else check_float("root_stiffness", value, 0.0)


def physical_beam(
    numbers: Mapping[str, float],
    units: Units,
    blade: Blade | None,
    masses: Iterable[Mass],
    root: float,
) -> PhysicalBeam | None:
    """The beam of dimensionless numbers; None where its mass is not known, or for sizes beyond
    floating-point numbers."""
    L, T, whole = units.length, units.time, units.mass
    if not whole:
        return None
    m, EI = whole / L, whole * L * (L / T) * (L / T)
    EA = EI * (numbers["mu"] / L) * (numbers["mu"] / L)
    if not all(math.isfinite(value) and value > 0 for value in (m, EI, EA)):
        return None
    constant, flap = (1.0, 1.0), numbers.get("flap", 1.0)
    shape = blade or Blade((0.0, 1.0), constant, constant, constant)
    strength: dict[str, float | None] = {}
    if shape.is_prismatic:
        names = ("youngs_modulus", *STRENGTH)
        strength = {name: getattr(units, name) for name in names}
    E = strength.get("youngs_modulus")

    def row(base: float, relative: Row) -> Row:
        return tuple(base * value for value in relative)

    return PhysicalBeam(
        length=L,
        stations=row(L, shape.x),
        mass_per_length=row(m, shape.mass),
        bending_stiffness=row(EI, shape.bending),
        axial_stiffness=row(EA, shape.axial),
        flap_stiffness=row(EI, shape.flap or (flap,) * len(shape.x))
        if shape.flap or flap != 1
        else None,
        degree=shape.degree,
        density=m / EA * E if E else None,
        **strength,
        hub_radius=numbers["delta"] * L,
        rotation_speed=numbers["gamma"] / T,
        mass=numbers["alpha"] * whole,
        mass_position=numbers["beta"] * L,
        masses=tuple(
            Body(mass.alpha * whole, mass.beta * L, row(whole * L * L, mass.inertia))
            for mass in masses
        ),
        root_stiffness=root * EI / L,
        angular_acceleration=numbers.get("spin_up", 0.0) / T / T,
        pitch=numbers.get("pitch", 0.0),
        twist=numbers.get("twist", 0.0),
        twists=shape.twist,
    )


def check_si_table(
    data: Mapping[str, Any], source: str, folder: Path | None = None
) -> dict[str, Any]:
    """The keywords in a table of a file or a link, with those of its file of stations, relative to
    its folder. InvalidInput for an unknown or missing key."""
    known = FILE_KEYS if folder else SI_KEYS
    for key in data:
        if key not in known:
            error = unknown_keyword("key", key, known, SI_SYNONYMS, known)
            raise InvalidInput(f"{source}: {error}")
    values = dict(data)
    if (file := values.pop("stations_file", None)) is not None and folder:
        if not isinstance(file, str):
            raise InvalidInput(
                f"{source}: stations_file = {file!r}: must be the name of a file of a blade"
            )
        read = read_blade_file(folder / file, values)
        if both := sorted(read.keys() & values.keys()):
            raise InvalidInput(f"{source}: {both[0]} is also in {file}: give it once")
        values |= read
    if missing := missing_key(values):
        raise InvalidInput(f"{source}: missing key {missing}")
    return values
