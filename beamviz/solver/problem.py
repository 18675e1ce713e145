"""The problem that is solved for a beam: the options of `beamviz.solve` and the table of methods.

Each option is declared once, as a field of `Problem`. The keywords of `solve`, the command line,
links, scene files, JSON and the documentation follow from `OPTIONS`.
"""

import inspect
import math
from collections.abc import Callable, Collection, Mapping
from contextvars import ContextVar
from dataclasses import dataclass, field, fields
from functools import cached_property, lru_cache
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from beamviz.checks import check_choice, check_float, check_int, is_number
from beamviz.errors import InvalidInput, unknown_keyword
from beamviz.solver.constitutive import CURVATURES, STRAIN_LAWS, StrainLaw, Theory

MAX_MODES = 20
STRAIN_DESCRIPTIONS = "; ".join(f"{law.name}: {law.description}" for law in STRAIN_LAWS.values())

# Called before each beam or batch of beams and each step of an iteration: an exception that it
# raises ends the calculation. The default, bool(), does nothing.
interruption: ContextVar[Callable[..., Any]] = ContextVar("interruption", default=bool)


class Resolution(NamedTuple):
    """The option that is the resolution of a method, its default and its limits, and the number of
    modes for each element or term (without end for a series whose roots are sought)."""

    option: str
    default: int
    least: int
    most: int
    modes_each: float = 1


class Method(NamedTuple):
    """A row of the table of methods. package: the part of `beamviz.solver` that has it.
    unsupported: names of options. resolution: None where it refines to a tolerance. source:
    publication. choose: when to use it. rigid_tension: whether the tension is that of the
    unstretched beam (first-order coupling). blades: whether it takes beams that are not uniform.
    in_space: whether it solves for bending in both planes at once."""

    package: str
    unsupported: tuple[str, ...]
    resolution: Resolution | None
    source: str
    choose: str
    rigid_tension: bool = False
    blades: bool = False
    in_space: bool = False


SWITCHES = "stiffening", "softening"
HP = "hp", ("elements", "terms"), None
FEM = "fem", ("terms", *SWITCHES), Resolution("elements", 20, 1, 1000, 2)  # 20: the paper's
METHODS = {
    "auto": Method(
        *HP,
        "this program: high-order elements in gradient and curvature, split at the mass",
        "unless you are studying another method: fastest to any accuracy",
        blades=True,
        in_space=True,
    ),
    "ancf": Method(
        *FEM,
        "the paper's cubic elements (2017), stretching and bending solved separately",
        "to see the paper's own numbers; 20 elements are the paper's",
        blades=True,
        in_space=True,
    ),
    "linear": Method(
        *FEM,
        "linear finite elements with prestress and spin softening, as general codes do it",
        "to see what a linear prestressed analysis says; its limit is foac's",
        rigid_tension=True,
        blades=True,
        in_space=True,
    ),
    "foac": Method(
        *HP,
        "first-order coupling: tension of the rigid reference length (Hong et al.; Yoo & Shin)",
        "to see the classical model of slender rotating beams, right while f is near 1",
        rigid_tension=True,
        blades=True,
    ),
    "zoac": Method(
        *HP,
        "no coupling: the linear model without stiffening, the paradox of Kane et al. (1987)",
        "to see it fail: it falsely loses stability at gamma = 3.516",
        rigid_tension=True,
        blades=True,
    ),
    "assumed-modes": Method(
        "series",
        ("elements", *SWITCHES),
        Resolution("terms", 10, 1, 100),  # cosh overflows soon after
        "modes of the beam at rest as a basis, rigid tension (Yoo & Shin 1998)",
        "to see how the classical papers computed: few terms, 3 to 6 digits at low speed",
        rigid_tension=True,
    ),
    "power-series": Method(
        "series",
        ("elements", "coriolis", *SWITCHES),
        Resolution("terms", 80, 6, 1000, math.inf),
        "Frobenius series from the clamp, rigid tension (Wright et al. 1982)",
        "to check foac at low speed: converged there, without a digit left at high speed",
        rigid_tension=True,
    ),
    "chebyshev": Method(
        "series",
        ("elements", "coriolis", *SWITCHES),
        Resolution("terms", 32, 2, 200),
        "Chebyshev collocation of the differential equations (El-Gendi 1969; Greengard 1991)",
        "to check auto by other equations; wasteful where layers are thin",
    ),
}


def option(default: Any, text: str, **properties: Any) -> Any:
    """A field of `Problem` that is an option; see `Option`."""
    return field(default=default, metadata={"text": text, **properties})


@dataclass(frozen=True)
class Problem:
    """The theory, the method and its resolution, the same for all beams of a call."""

    modes: int = option(5, "Number of modes.", limits=(1, MAX_MODES), resolution=True)
    method: str = option(
        "auto",
        "auto: as accurate as the tolerance asks; ancf: the paper's cubic elements; linear:"
        " prestressed linear elements; foac, zoac: first-order and no coupling of stretch and"
        " bending; assumed-modes, power-series: classical solutions of foac; chebyshev:"
        " collocation.",
        choices=METHODS,
    )
    strain: str = option("green", f"Axial strain; {STRAIN_DESCRIPTIONS}.", choices=STRAIN_LAWS)
    curvature: str = option(
        "spatial", "Curvature measure; spatial is the paper's eq. 16.", choices=CURVATURES
    )
    coriolis: bool = option(
        False,
        "Coriolis forces, which the paper leaves out. They couple stretching and chordwise"
        " bending, and do not act out of the plane of rotation. In Python and files also a factor"
        " of them from 0 to 1, a thought experiment: no real beam has a part of them.",
        feature="Coriolis forces",
        partial=True,
    )
    plane: str = option(
        "chordwise",
        "Vibration in the plane of rotation (chordwise), out of it (flapwise), or in both at once,"
        " which a pitch or a twist of the section couples.",
        choices=("chordwise", "flapwise", "both"),
    )
    tolerance: float = option(
        1e-6,
        "Relative error of each frequency that auto, foac and zoac refine to; of one below"
        " 0.01/T*, relative to 0.01/T*.",
        limits=(1e-12, 0.1),
        resolution=True,
    )
    elements: int | None = option(
        None,
        "Number of elements of ancf and linear (default 20, as in the paper).",
        feature="number of elements",
        resolution=True,
    )
    terms: int | None = option(
        None,
        "Number of basis functions of assumed-modes (default 10), of powers of power-series (80),"
        " or the order of chebyshev (32).",
        feature="number of terms",
        resolution=True,
    )
    stiffening: bool = option(
        True, "The stiffening of bending by the tension.", feature="switched-off term"
    )
    softening: bool = option(
        True,
        "The softening of motion in the plane of rotation by the centrifugal force.",
        feature="switched-off term",
    )
    state: str = option(
        "straight",
        "Equilibrium to vibrate about. straight: with divergence where it is not stable; bent:"
        " the stable deflected equilibrium of lowest energy; stable: the straight one where that"
        " is stable, else the deflected one. A beam with a spin-up has no straight state.",
        choices=("straight", "bent", "stable"),
    )

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
        plane = "both planes" if self.in_space else self.plane
        parts = [f"{self.strain} strain", f"{self.curvature} curvature", plane]
        share = "" if self.coriolis_factor in (0, 1) else f"{self.coriolis_factor:g} of "
        parts.append(f"with {share}Coriolis" if self.gyroscopic else "without Coriolis")
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
        """Whether the beam bends in the plane of rotation only, where the centrifugal force
        softens."""
        return self.plane == "chordwise"

    @cached_property
    def in_space(self) -> bool:
        """Whether the beam bends in both planes."""
        return self.plane == "both"

    @cached_property
    def softened(self) -> NDArray:
        """Whether softening lowers every omega^2 of bending by the same, and of stretching (2, 1):
        not that of bending out of the plane of rotation, nor of bending in space."""
        return self.softening * np.array([[float(self.chordwise)], [1.0]])

    @cached_property
    def components_in_plane(self) -> tuple[bool, ...]:
        """Of each component of bending, whether it is in the plane of rotation."""
        return (True, False) if self.in_space else (self.chordwise,)

    @cached_property
    def theory(self) -> Theory:
        """The strain law, the curvature measure and the plane."""
        in_plane = self.chordwise or self.in_space
        return Theory(self.strain_law, self.curvature_power, in_plane, self.in_space)

    @cached_property
    def bending_property(self) -> str:
        """The property of a `Blade` that is its bending stiffness in this plane, or "both"."""
        return self.theory.bending_property

    @cached_property
    def gyroscopic(self) -> bool:
        """Whether Coriolis forces couple stretching and bending."""
        return bool(self.coriolis) and self.plane != "flapwise"

    @cached_property
    def coriolis_factor(self) -> float:
        """The factor of the Coriolis forces: 0 without, 1 with them, or in between in a thought
        experiment."""
        return float(self.coriolis) if self.gyroscopic else 0.0

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
        """The number of elements or terms of a method that has one, the default where none was
        given; InvalidInput where it is out of range, or too small for the number of modes."""
        resolution = METHODS[self.method].resolution
        assert resolution, f"{self.method} refines to a tolerance"
        option, default, least, most, modes_each = resolution
        given = getattr(self, option)
        number = check_int(option, default if given is None else given, least, most)
        if self.modes > modes_each * number:
            raise InvalidInput(
                f"modes = {self.modes}: at most {modes_each * number} with {option} = {number};"
                f" ask for more {option} or fewer modes"
            )
        return number

    def available(self, extra_modes: int) -> int:
        """The number of these modes, beyond those asked for, that the method has at its resolution;
        InvalidInput where it has fewer than those asked for."""
        resolution = METHODS[self.method].resolution
        if resolution is None:
            return extra_modes
        return int(min(extra_modes, resolution.modes_each * self.resolution - self.modes))


@dataclass(frozen=True)
class Option:
    """An option of `solve`, made of a field of `Problem`.

    kind: type of its values. text: documentation. choices: the values of a text. limits: least and
    greatest number. feature: of methods, what the option asks for; some methods do not support it.
    resolution: whether it refines the solution, and is no part of the model. partial: of one that
    is on or off, whether it may be a factor between 0 and 1, too.
    """

    name: str
    kind: Any
    default: Any
    text: str
    choices: Collection[str] = ()
    limits: tuple[float, float] | None = None
    feature: str = ""
    resolution: bool = False
    partial: bool = False

    @property
    def documentation(self) -> str:
        """The text, with the values allowed and the default."""
        values = ""
        if self.choices:
            values = f" One of {', '.join(self.choices)}."
        elif self.limits:
            values = " {:g} .. {:g}.".format(*self.limits)
        return f"{self.name}: {self.text}{values} Default {self.default!r}."

    @property
    def methods(self) -> list[str]:
        """The methods that support it."""
        return [name for name, row in METHODS.items() if self.name not in row.unsupported]

    def checked(self, value: Any) -> Any:
        """The value in the type of Python. Raises InvalidInput, which names the values allowed."""
        if self.choices:
            return check_choice(self.name, value, self.choices)
        if self.partial and is_number(value):
            factor = check_float(self.name, value, 0.0, 1.0)
            return factor if 0 < factor < 1 else bool(factor)
        if self.kind is bool:
            if not isinstance(value, bool | np.bool_):
                values = "True, False or a factor 0 .. 1" if self.partial else "True or False"
                raise InvalidInput(f"{self.name} = {value!r}: must be {values}")
            return bool(value)
        if self.limits is None:  # depends on the method; see Problem.resolution
            return value
        check: Callable[..., Any] = check_int if self.kind is int else check_float
        return check(self.name, value, *self.limits)


OPTIONS = {
    entry.name: Option(entry.name, entry.type, entry.default, **entry.metadata)
    for entry in fields(Problem)
}
CHOICES = {name: tuple(entry.choices) for name, entry in OPTIONS.items() if entry.choices}
MODEL = tuple(name for name, entry in OPTIONS.items() if not entry.resolution)


def options_in(attributes: Mapping[str, Any]) -> dict[str, Any]:
    """The options in the attributes of a dataset, which hold no None and 0 or 1 for a truth
    value."""
    given = {name: attributes.get(name) for name in OPTIONS}
    return {
        name: bool(value) if OPTIONS[name].kind is bool and value in (0, 1, None) else value
        for name, value in given.items()
    }


def parse_keywords(**values: Any) -> Problem:
    """The problem with these options by name, the others by default; raises InvalidInput. Problems
    are kept, as a slider or a sweep repeats them: to check the options takes 15 % of a solve."""
    try:
        return _checked_problem(**values)
    except TypeError:  # an unhashable option
        return _checked_problem.__wrapped__(**values)


@lru_cache(maxsize=256, typed=True)
def _checked_problem(**values: Any) -> Problem:
    """The problem with these options."""
    for name in values.keys() - OPTIONS.keys():
        raise unknown_keyword("option", name, OPTIONS)
    problem = Problem(**{name: OPTIONS[name].checked(value) for name, value in values.items()})
    if problem.in_space and not METHODS[problem.method].in_space:
        raise InvalidInput(
            f"method {problem.method}: bends in one plane, not in both at once",
            use={"method": [name for name, row in METHODS.items() if row.in_space]},
        )
    if problem.in_space and problem.state != "straight":
        raise InvalidInput(
            f"state = {problem.state!r}: a deflected state bends in the plane of rotation only",
            use={"plane": ("chordwise",)},
        )
    for name in METHODS[problem.method].unsupported:
        given, entry = getattr(problem, name), OPTIONS[name]
        if given != entry.default and (name != "coriolis" or problem.gyroscopic):
            raise InvalidInput(
                f"{name} = {given!r}: method {problem.method} takes no {entry.feature};"
                f" methods that do: {', '.join(entry.methods)}"
            )
    return problem


def supported_options(values: Mapping[str, Any]) -> dict[str, Any]:
    """Valid options, those that their method does not take by default."""
    try:
        parse_keywords(**values)
    except InvalidInput:
        unsupported = METHODS[values["method"]].unsupported
        return {**values, **{name: OPTIONS[name].default for name in unsupported}}
    return dict(values)


Function = TypeVar("Function", bound=Callable[..., Any])


def documents_options(function: Function) -> Function:
    """A decorator that appends the documentation of the options to that of a function."""
    texts = [entry.documentation for entry in OPTIONS.values()]
    function.__doc__ = "\n".join([inspect.cleandoc(function.__doc__ or ""), "", *texts])
    return function
