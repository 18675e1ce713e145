"""The problem of a motion: the arguments of `motion`, validated, and the parts between the
moments at which the body docks or is released."""

import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from beamviz.beam import Beam
from beamviz.checks import check_choice, check_float, check_int, check_positive
from beamviz.dynamics.drives import Hub, Ramp, Samples, drive_of
from beamviz.dynamics.schemes import INTEGRATORS
from beamviz.errors import InvalidInput, unknown_keyword
from beamviz.solver.constitutive import CURVATURES, STRAIN_LAWS
from beamviz.solver.problem import Problem

METHODS = {
    "auto": "stretch and angle, polynomials of high order on few elements, split at the mass",
    "ancf": "the paper's cubic elements, as many as `elements` says",
}
STATES = ("straight", "bent", "stable")
TIMES = (1e-6, 1e5)
FORCES = (-1000.0, 1000.0)
DAMPING = (0.0, 0.5)
TOLERANCES = (1e-9, 1e-2)
AMPLITUDES = (-0.5, 0.5)
VELOCITIES = (-1e4, 1e4)
CLOSEST = 1e-9  # times of samples, over the whole time; those 1e-11 apart give a wrong motion
MAX_POINTS, MAX_ELEMENTS = 100_000, 200
DEFAULT_ELEMENTS = 20  # the paper's


class MotionPart(NamedTuple):
    """A part of the motion, from the end of the part before it."""

    end: float  # [T*]
    with_mass: bool  # whether the concentrated mass is on the beam


@dataclass(frozen=True, kw_only=True)
class MotionProblem:
    """The arguments of `beamviz.motion`, which documents them. Raises InvalidInput."""

    beam: Beam
    until: float
    speed: Any = None
    release: float = 0.0
    release_at: float = 1.0
    start: Mapping[str, float] | None = None
    damping: float = 0.0
    tolerance: float = 1e-4
    points: int = 401
    method: str = "auto"
    strain: str = "green"
    curvature: str = "spatial"
    state: str = "straight"
    elements: int | None = None
    integrator: str = "radau"
    step: float | None = None
    catch: float | None = None
    drop: float | None = None
    body_velocity: tuple[float, float] = (0.0, 0.0)
    progress: Callable[[float], object] | None = None

    @classmethod
    def of(cls, **given: Any) -> "MotionProblem":
        """The problem of keywords; InvalidInput names an unknown keyword."""
        for name in given.keys() - cls.__dataclass_fields__.keys():
            if name in ("coriolis", "plane"):
                raise InvalidInput(
                    f"{name} = {given[name]!r}: motion in time is in the plane of rotation, with"
                    " Coriolis forces; leave the option out"
                )
            raise unknown_keyword("option", name, list(cls.__dataclass_fields__)[2:])
        return cls(**given)

    def __post_init__(self) -> None:
        set_to = self.__dict__.__setitem__
        if self.beam.spin_up:
            raise InvalidInput(
                f"spin_up = {self.beam.spin_up:g} (an angular acceleration): a motion in time takes"
                " its speed from `speed`, as Ramp(to, within); on the command line from --ramp-to"
                " and --within"
            )
        if self.beam.is_turned:
            raise InvalidInput(
                f"pitch = {self.beam.pitch:g}, twist = {self.beam.twist:g}: a turned section leaves"
                " the plane of rotation, in which a motion in time is"
            )
        turning = any(any(body.inertia) for body in self.beam.masses)
        if self.cubic and (turning or self.beam.root < math.inf):
            raise InvalidInput(
                "method ancf: the beam has to be clamped, its bodies without moments of inertia;"
                " method auto takes this one"
            )
        set_to("until", check_float("until", self.until, *TIMES))
        set_to("release", check_float("release", self.release, *FORCES))
        set_to("release_at", check_float("release_at", self.release_at, 0.0, 1.0))
        set_to("damping", check_float("damping", self.damping, *DAMPING))
        set_to("tolerance", check_float("tolerance", self.tolerance, *TOLERANCES))
        set_to("points", check_int("points", self.points, 2, MAX_POINTS))
        choices: dict[str, Collection[str]] = {
            "method": METHODS,
            "strain": STRAIN_LAWS,
            "curvature": CURVATURES,
            "state": STATES,
            "integrator": INTEGRATORS,
        }
        for name, known in choices.items():
            check_choice(name, getattr(self, name), known)
        if self.elements is not None:
            if self.method != "ancf":
                raise InvalidInput(
                    f"elements = {self.elements!r}: only method ancf takes a number of elements"
                )
            set_to("elements", check_int("elements", self.elements, 1, MAX_ELEMENTS))
        if self.step is not None:
            step = check_positive("step", self.step)
            set_to("step", check_float("step", step, 1e-7 * self.until, self.until))
        set_to("speed", drive_of(self.beam, self.speed))
        set_to("start", self.checked_start())
        self.check_body()
        self.check_samples()

    def checked_start(self) -> dict[str, float]:
        """The amplitudes by mode as floats. That the modes exist is checked once they are solved
        for."""
        given = {} if self.start is None else self.start
        if not isinstance(given, Mapping):
            raise InvalidInput(f"start = {given!r}: must give amplitudes by mode, as {{'B1': 0.1}}")
        if given and self.release:
            raise InvalidInput(
                f"start = {dict(given)} and release = {self.release:g} exclude each other"
            )
        if not all(isinstance(name, str) for name in given):
            raise InvalidInput(f"start = {dict(given)}: must name modes, as {{'B1': 0.1}}")
        return {name: check_float(f"start {name}", a, *AMPLITUDES) for name, a in given.items()}

    def check_body(self) -> None:
        """The times at which the body docks and is released, and its velocity, as floats."""
        for name in ("catch", "drop"):
            moment = getattr(self, name)
            if moment is None:
                continue
            if not self.beam.alpha:
                raise InvalidInput(f"{name} = {moment!r}: the beam has no body, alpha = 0")
            self.__dict__[name] = check_float(name, moment, 0.0, self.until)
        if self.catch is not None and self.catch == self.drop:
            raise InvalidInput(f"catch = drop = {self.catch:g}: must be at different times")
        try:
            vx, vy = self.body_velocity
        except (TypeError, ValueError):
            raise InvalidInput(
                f"body_velocity = {self.body_velocity!r}: must be two numbers"
            ) from None
        checked = tuple(check_float("body_velocity", v, *VELOCITIES) for v in (vx, vy))
        self.__dict__["body_velocity"] = checked

    def check_samples(self) -> None:
        """Samples of a speed or a torque, and the two ends of a ramp, must be so far apart that
        rounding errors of the time do not hide the change between two of them."""
        least = CLOSEST * self.until
        if isinstance(self.drive, Ramp) and self.drive.within < least:
            raise InvalidInput(
                f"within = {self.drive.within!r}: must be {least:g} or more, {CLOSEST:g} of the"
                " time of the motion"
            )
        for first, second in pairwise(t for t in self.drive.breaks if 0 <= t <= self.until):
            if second - first < least:
                raise InvalidInput(
                    f"speed: its times {first!r} and {second!r}: must be {least:g} apart or more"
                )

    @property
    def drive(self) -> Ramp | Samples | Hub:
        """`speed` as a record."""
        return self.speed

    @property
    def report(self) -> Callable[[float], object]:
        """`progress`, or a function that does nothing."""
        return self.progress or float

    @property
    def first_speed(self) -> float:
        """gamma at t = 0."""
        return self.beam.gamma if isinstance(self.drive, Hub) else self.drive.first

    @property
    def greatest_speed(self) -> float:
        """The size of gamma that the first mesh resolves: of a hub that turns freely that at
        t = 0, as what it will reach is not known."""
        if isinstance(self.drive, Hub):
            return self.beam.gamma
        return max(map(abs, self.drive.extremes))

    @property
    def times(self) -> NDArray:
        """The times (points,) of the results."""
        return np.linspace(0.0, self.until, self.points)

    @property
    def parts(self) -> list[MotionPart]:
        """The motion divided at the moments at which the body docks or is released."""
        moments = sorted(
            (t, name) for name in ("catch", "drop") if (t := getattr(self, name)) is not None
        )
        if not moments:
            return [MotionPart(self.until, bool(self.beam.alpha))]
        with_mass = moments[0][1] == "drop"
        parts = []
        for t, _ in moments:
            parts.append(MotionPart(t, with_mass))
            with_mass = not with_mass
        return [*parts, MotionPart(self.until, with_mass)]

    @property
    def amplitudes(self) -> Mapping[str, float]:
        """`start`, {} where there is none."""
        return self.start or {}

    @property
    def corners(self) -> list[float]:
        """The times within the motion at which it is not smooth."""
        moments = {*self.drive.breaks, *(part.end for part in self.parts)}
        return sorted(t for t in moments if 0 < t < self.until)

    @property
    def studied(self) -> bool:
        """Whether the resolution is given: nothing is refined then."""
        return self.cubic or self.step is not None

    @cached_property
    def statics(self) -> Problem:
        """The problem of an equilibrium by the same theory."""
        return Problem(strain=self.strain, curvature=self.curvature)

    @property
    def cubic(self) -> bool:
        """Whether the unknowns are those of the paper's elements."""
        return self.method == "ancf"

    @property
    def model(self) -> dict[str, Any]:
        """The method and the terms of the theory, by name."""
        names = ("method", "strain", "curvature", "integrator", "damping")
        return {name: getattr(self, name) for name in names}
