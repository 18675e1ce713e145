"""Properties that vary along the span, and bodies on the beam: the dimensionless description.

Stiffness and mass are relative to those of the root section, positions to the length of the beam.
NumPy is imported where properties are evaluated: most beams are uniform, and so `import beamviz`
stays fast.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, fields
from functools import cached_property, partial
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple, Self

from beamviz.checks import check_float, check_floats, check_int, together
from beamviz.errors import InvalidInput, unknown_keyword

if TYPE_CHECKING:
    from numpy.polynomial import Polynomial
    from numpy.typing import ArrayLike, NDArray

PROPERTIES = ("mass", "bending", "axial", "flap")
PROPERTY_LIMITS = (1e-9, 1e9)  # of a property over that of the root section: real tips have 1e-7
TWIST_LIMITS = (-720.0, 720.0)  # [deg]
# The properties that are bending stiffnesses, by the name of what `Blade.at` gives of them.
STIFFNESSES = {"bending": ("bending",), "flap": ("flap",), "both": ("bending", "flap")}
MAX_STATIONS = 200
MAX_DEGREE = 8
AT_ROOT = 1e-9  # rounding of a property at the root, relative to itself
SAMPLES = 33  # of a segment, at which a polynomial has to be above 0


@dataclass(frozen=True)
class Mass:
    """A body on the beam; rho A is that of the root section.

    alpha: mass m / (rho A L)
    beta: position d / L
    inertia: principal moments of inertia (Jx, Jy, Jz) over rho A L^3, about the axes along the
        beam, across it in the plane of rotation, and parallel to the axis of rotation

    Raises InvalidInput that names the number, its value and its limits.
    """

    alpha: float
    beta: float
    inertia: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        checks: dict[str, Callable[[], Any]] = {
            "alpha": partial(check_float, "alpha of a mass", self.alpha, 0.0, 100.0),
            "beta": partial(check_float, "beta of a mass", self.beta, 0.0, 1.0),
            "inertia": partial(check_inertia, "inertia of a mass", self.inertia, 100.0),
        }
        for name, value in zip(checks, together(checks.values()), strict=True):
            object.__setattr__(self, name, value)

    @property
    def record(self) -> dict[str, Any]:
        """The values by name in the types of JSON."""
        return {"alpha": self.alpha, "beta": self.beta, "inertia": list(self.inertia)}

    @classmethod
    def from_record(cls, record: Mapping[str, Any]) -> Self:
        """The mass of values by name. Raises InvalidInput."""
        return cls(**checked_keys(cls, "a mass", record, ("alpha", "beta")))


def check_inertia(name: str, values: object, most: float = math.inf) -> tuple[float, ...]:
    """Three principal moments of inertia from 0 to the largest, or InvalidInput."""
    inertia = check_floats(name, values, 0.0, most)
    if len(inertia) != 3:
        raise InvalidInput(f"{name} = {list(inertia)}: must be three numbers Jx, Jy, Jz")
    return inertia


def checked_keys(
    kind: type, name: str, record: Mapping[str, Any], required: Iterable[str]
) -> Mapping[str, Any]:
    """`record` if its keys are fields of a class; InvalidInput for one unknown or missing."""
    known = [field.name for field in fields(kind)]
    for key in record:
        if key not in known:
            raise unknown_keyword(f"key of {name}", str(key), known)
    for key in required:
        if key not in record:
            raise InvalidInput(f"{name}: missing key {key!r}")
    return record


class Segment(NamedTuple):
    """A part of the span on which each property is a polynomial of (x - start) / (stop - start)."""

    start: float
    stop: float
    polynomials: "dict[str, Polynomial]"


@dataclass(frozen=True, repr=False)
class Blade:
    """Properties along the span, relative to the root section, where each of them but flap is 1.

    x: stations from 0 to 1, ascending; a station named twice is a jump
    mass: mass of a unit of length
    bending: bending stiffness in the plane of rotation
    axial: axial stiffness
    flap: bending stiffness out of that plane, over `bending` at the root; None where it is
        `bending`
    degree: between two stations a property is linear; with a higher degree it is a polynomial
        through degree + 1 successive stations: 0 .. degree are a segment, degree .. 2 degree the
        next
    twist: angle [deg] by which a section is turned about the axis of the beam, from the plane of
        rotation towards the axis of rotation, beyond the pitch of the root; None without a twist

    Raises InvalidInput that names the property, its value and its limits.
    """

    x: tuple[float, ...]
    mass: tuple[float, ...]
    bending: tuple[float, ...]
    axial: tuple[float, ...]
    flap: tuple[float, ...] | None = None
    degree: int = 1
    twist: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        x = check_floats("x of a blade", self.x, 0.0, 1.0)
        if not 2 <= len(x) <= MAX_STATIONS:
            raise InvalidInput(f"{len(x)} stations of a blade: must be 2 .. {MAX_STATIONS}")
        if x[0] != 0 or x[-1] != 1 or any(after < before for before, after in pairwise(x)):
            raise InvalidInput("x of a blade: must ascend from 0 at the root to 1 at the tip")
        object.__setattr__(self, "x", x)
        object.__setattr__(self, "degree", check_int("degree", self.degree, 1, MAX_DEGREE))
        for name in (*PROPERTIES, "twist"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, self._checked(name))
        if self.degree > 1:
            self._check_sign()

    def _check_sign(self) -> None:
        """InvalidInput where a polynomial is not above 0."""
        import numpy as np

        for segment in self.segments:
            for name in PROPERTIES:
                polynomial = segment.polynomials[name]
                if not (polynomial(np.linspace(0, 1, SAMPLES)) > 0).all():
                    raise InvalidInput(
                        f"{name} of a blade: not above 0 everywhere in x = {segment.start:g} .."
                        f" {segment.stop:g}"
                    )

    def _checked(self, name: str) -> tuple[float, ...]:
        """The values of a property at the stations."""
        limits = TWIST_LIMITS if name == "twist" else PROPERTY_LIMITS
        values = check_floats(f"{name} of a blade", getattr(self, name), *limits)
        if len(values) != len(self.x):
            raise InvalidInput(f"{name} of a blade: {len(values)} values, {len(self.x)} stations")
        if name not in ("flap", "twist") and abs(values[0] - 1) > AT_ROOT:
            raise InvalidInput(
                f"{name} of a blade = {values[0]:g} at the root: must be 1, as it is relative to"
                " the root section"
            )
        return values

    def __repr__(self) -> str:
        rows = ((name, getattr(self, name)) for name in (*PROPERTIES, "twist"))
        ends = [f"{name} {row[0]:.4g} .. {row[-1]:.4g}" for name, row in rows if row]
        degree = f" of degree {self.degree}" if self.degree > 1 else ""
        return f"<Blade of {len(self.x)} stations{degree}: {', '.join(ends)}>"

    @property
    def record(self) -> dict[str, Any]:
        """The values by name in the types of JSON, without those of no effect."""
        record: dict[str, Any] = {
            name: list(row) for name in ("x", *PROPERTIES, "twist") if (row := getattr(self, name))
        }
        return record | ({"degree": self.degree} if self.degree > 1 else {})

    @classmethod
    def from_record(cls, record: Mapping[str, Any]) -> Self:
        """The blade of values by name. Raises InvalidInput."""
        return cls(**checked_keys(cls, "a blade", record, ("x", *PROPERTIES[:3])))

    @classmethod
    def tapered(cls, height: float = 0.0, width: float = 0.0) -> "Blade":
        """A solid rectangular section whose height, in the plane of bending, and width fall
        linearly to 1 - height and 1 - width of the root's at the tip: `mass` and `axial` are the
        area, `bending` and `flap` the width times the cube of the height."""
        import numpy as np

        x = np.linspace(0, 1, 5)
        h = 1 - check_float("height", height, 0.0, 0.99) * x
        b = 1 - check_float("width", width, 0.0, 0.99) * x
        area, bending = tuple((b * h).tolist()), tuple((b * h**3).tolist())
        return cls(tuple(x.tolist()), area, bending, area, degree=4)

    @cached_property
    def segments(self) -> tuple[Segment, ...]:
        """The segments from the root to the tip."""
        return tuple(self._segments())

    def _segments(self) -> Iterator[Segment]:
        import numpy as np
        from numpy.polynomial import Polynomial

        first, last = 0, len(self.x) - 1
        while first < last:
            if self.x[first] == self.x[first + 1]:  # a jump
                first += 1
                continue
            stations = slice(first, first + self.degree + 1)
            x = np.array(self.x[stations])
            if len(x) <= self.degree or not (np.diff(x) > 0).all():
                raise InvalidInput(
                    f"x of a blade: the segment from {x[0]:g} has fewer than {self.degree + 1}"
                    f" different stations, needed for degree = {self.degree}"
                )
            place = (x - x[0]) / (x[-1] - x[0])
            rows = {name: getattr(self, name) for name in PROPERTIES}
            rows["flap"] = rows["flap"] or rows["bending"]
            rows["twist"] = self.twist or (0.0,) * len(self.x)
            polynomials = {
                name: Polynomial(np.linalg.solve(np.vander(place, increasing=True), row[stations]))
                for name, row in rows.items()
            }
            yield Segment(float(x[0]), float(x[-1]), polynomials)
            first += self.degree

    @property
    def is_prismatic(self) -> bool:
        """Whether no property varies along the span: they may differ between the two planes."""
        rows = self.mass, self.bending, self.axial, self.flap or self.bending, self.twist or (0.0,)
        return all(len(set(row)) == 1 for row in rows)

    @property
    def breaks(self) -> tuple[float, ...]:
        """The ends of the segments, from 0 to 1, where a property or its slope may jump."""
        return (0.0, *(segment.stop for segment in self.segments))

    @cached_property
    def _coefficients(self) -> "dict[str, NDArray]":
        """Coefficients (segments, degree + 1) of each property, by ascending power."""
        import numpy as np

        return {
            name: np.array([segment.polynomials[name].coef for segment in self.segments])
            for name in (*PROPERTIES, "twist")
        }

    def at(self, name: str, x: "ArrayLike", inboard: bool = False) -> "NDArray":
        """A property ("mass", "bending", "axial", "flap" or "twist"), or of "both" bending
        stiffnesses the lesser, at points x in 0 .. 1, an array of their shape; where it jumps, its
        value toward the tip, or `inboard` toward the root."""
        import numpy as np

        if name == "both":
            rows = (self.at(part, x, inboard) for part in STIFFNESSES[name])
            return np.minimum(*rows)
        x, breaks = np.asarray(x, dtype=float), np.array(self.breaks)
        segment = np.searchsorted(breaks, x, side="left" if inboard else "right") - 1
        segment = np.clip(segment, 0, len(breaks) - 2)
        place = (x - breaks[segment]) / np.diff(breaks)[segment]
        values = np.zeros(x.shape)
        for coefficient in self._coefficients[name].T[::-1]:  # by Horner's rule
            values = values * place + coefficient[segment]
        return values
