"""The problem that is solved for a beam, and the table of methods."""

import math
from collections.abc import Callable, Collection
from contextvars import ContextVar
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any, NamedTuple

from beamviz.beam import check_int
from beamviz.errors import InvalidInput
from beamviz.solver.constitutive import CURVATURES, STRAIN_LAWS, StrainLaw

MODEL = ("method", "strain", "curvature", "coriolis", "plane", "stiffening", "softening")

# Called before each beam or batch of beams: an exception that it raises ends the calculation.
interruption: ContextVar[Callable[..., Any]] = ContextVar("interruption", default=bool)


@dataclass(frozen=True)
class Problem:
    """The theory, the method and its resolution, the same for all beams of a call.

    The fields are the options of `beamviz.solve`, which documents and validates them.
    """

    modes: int = 5
    method: str = "auto"
    strain: str = "green"
    curvature: str = "spatial"
    coriolis: bool = False
    plane: str = "chordwise"
    tolerance: float = 1e-6
    elements: int | None = None
    terms: int | None = None
    stiffening: bool = True
    softening: bool = True
    state: str = "straight"

    @property
    def options(self) -> dict[str, Any]:
        """The keywords of `beamviz.solve`."""
        return {name: getattr(self, name) for name in OPTIONS}

    @property
    def model(self) -> dict[str, Any]:
        """The method and the terms of the theory by name, without the resolution."""
        return {name: getattr(self, name) for name in MODEL}

    @property
    def described(self) -> str:
        """The terms of the theory in words."""
        parts = [f"{self.strain} strain", f"{self.curvature} curvature", self.plane]
        parts.append("with Coriolis" if self.gyroscopic else "without Coriolis")
        parts += ["without stiffening"] * (not self.stiffens)
        return ", ".join(parts + ["without softening"] * (not self.softening))

    @cached_property
    def strain_law(self) -> StrainLaw:
        """The axial strain e(f) and its derivatives."""
        return STRAIN_LAWS[self.strain]

    @cached_property
    def curvature_power(self) -> int:
        """The power c of the stretch in the curvature measure (r' x r'') / f^c."""
        return CURVATURES[self.curvature]

    @cached_property
    def chordwise(self) -> bool:
        """Whether the beam bends in the plane of rotation, where the centrifugal force softens."""
        return self.plane == "chordwise"

    @cached_property
    def gyroscopic(self) -> bool:
        """Whether Coriolis forces couple stretching and bending."""
        return self.coriolis and self.plane == "chordwise"

    @cached_property
    def stiffens(self) -> bool:
        """Whether the tension stiffens bending."""
        return self.stiffening and self.method != "zoac"

    @cached_property
    def rigid_tension(self) -> bool:
        """Whether the tension is that of the unstretched beam."""
        return METHODS[self.method].rigid_tension

    @property
    def resolution(self) -> int:
        """The number of elements or terms; InvalidInput where it is out of range, or too few."""
        option, default, least, most, modes_each = METHODS[self.method].resolution
        given = getattr(self, option)
        number = check_int(option, default if given is None else given, least, most)
        if self.modes > modes_each * number:
            raise InvalidInput(
                f"modes = {self.modes}: at most {modes_each * number} with {option} = {number};"
                f" ask for more {option} or fewer modes"
            )
        return number


FEATURES = {  # that some methods do not support, by the options that ask for them
    "elements": "number of elements",
    "terms": "number of terms",
    "coriolis": "Coriolis forces",
    "stiffening": "switched-off term",
    "softening": "switched-off term",
}
SWITCHES = "stiffening", "softening"


class Resolution(NamedTuple):
    """The option that is the resolution of a method, its default and its limits, and the number of
    modes for each element or term (without end for a series whose roots are sought)."""

    option: str
    default: int
    least: int
    most: int
    modes_each: float = 1


class Method(NamedTuple):
    """A row of the table of methods. package: "hp", or module and function under beamviz/solver,
    imported on first use. source: publication. choose: when to use it. rigid_tension: whether the
    tension is that of the unstretched beam (first-order coupling)."""

    package: str
    unsupported: tuple[str, ...]  # options
    resolution: Any  # a Resolution; None where a method refines to a tolerance
    source: str
    choose: str
    rigid_tension: bool = False


HP = "hp", ("elements", "terms"), None
FEM = "fem.solve", ("terms", *SWITCHES), Resolution("elements", 20, 1, 1000, 2)  # 20: the paper's
METHODS = {
    "auto": Method(
        *HP,
        "this program: high-order elements in gradient and curvature, split at the mass",
        "unless you are studying another method: fastest to any accuracy",
    ),
    "ancf": Method(
        *FEM,
        "the paper's cubic elements (2017), stretching and bending solved separately",
        "to see the paper's own numbers; 20 elements are the paper's",
    ),
    "ancf-planar": Method(
        *FEM,
        "the paper's cubic elements through the full planar tangent (eqs. 40-48)",
        "to check ancf: the same answer with all unknowns at once",
    ),
    "linear": Method(
        *FEM,
        "linear finite elements with prestress and spin softening, as general codes do it",
        "to see what a linear prestressed analysis says; its limit is foac's",
        rigid_tension=True,
    ),
    "foac": Method(
        *HP,
        "first-order coupling: tension of the rigid reference length (Hong et al.; Yoo & Shin)",
        "to see the classical model of slender rotating beams, right while f is near 1",
        rigid_tension=True,
    ),
    "zoac": Method(
        *HP,
        "no coupling: the linear model without stiffening, the paradox of Kane et al. (1987)",
        "to see it fail: it falsely loses stability at gamma = 3.516",
        rigid_tension=True,
    ),
    "assumed-modes": Method(
        "series.assumed_modes",
        ("elements", *SWITCHES),
        Resolution("terms", 10, 1, 100),  # cosh overflows soon after
        "modes of the beam at rest as a basis, rigid tension (Yoo & Shin 1998)",
        "to see how the classical papers computed: few terms, 3 to 6 digits at low speed",
        rigid_tension=True,
    ),
    "power-series": Method(
        "series.power_series",
        ("elements", "coriolis", *SWITCHES),
        Resolution("terms", 80, 6, 1000, math.inf),
        "Frobenius series from the clamp, rigid tension (Wright et al. 1982)",
        "to check foac at low speed: exact there, without a digit left at high speed",
        rigid_tension=True,
    ),
    "chebyshev": Method(
        "series.chebyshev_collocation",
        ("elements", "coriolis", *SWITCHES),
        Resolution("terms", 32, 2, 200),
        "Chebyshev collocation of the differential equations (El-Gendi 1969; Greengard 1991)",
        "to check auto by other equations; wasteful where layers are thin",
    ),
}

CHOICES: dict[str, Collection[str]] = {
    "method": METHODS,
    "strain": STRAIN_LAWS,
    "curvature": CURVATURES,
    "plane": ("chordwise", "flapwise"),
    "state": ("straight", "bent", "stable"),
}
OPTIONS = tuple(entry.name for entry in fields(Problem))
