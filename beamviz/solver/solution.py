"""The result of a solve: equilibrium, modes, error estimates and statistics.

Shapes and positions are functions of x: nothing above the solver needs the unknowns of a method.
"""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from beamviz.beam import Beam
from beamviz.solver.loads import Curve, Loads, Outboard
from beamviz.solver.problem import Problem
from beamviz.solver.stress import (
    GreatestStress,
    Stress,
    greatest_stress,
    stress,
)
from beamviz.solver.stress import stress_of_deformation as stress_of_deformation

BENDING, STRETCHING, MIXED = "bending", "stretching", "mixed"
PURE = 0.9  # share of the kinetic energy from which a mode belongs to one family
NODE_GRID = 401
STATIONS = 201  # equally spaced along the beam, of shapes in charts and files
VISIBLE = 1e-7  # share of its amplitude below which a mode near the clamp has no nodes
ROOT_ITERATIONS, ROOT_TOLERANCE = 40, 1e-14

# x -> displacements (len(x), 2, modes) along and across the beam, or (len(x), 3, modes) along it,
# in the plane of rotation and out of it
Fields = Callable[[NDArray], NDArray]


@dataclass
class Stats:
    """Cost and resolution of a solution."""

    dof: int  # unknowns of both families
    method: str  # discretisation
    elements: int
    order: int  # of the elements, the greatest, or number of terms
    seconds: float = math.nan  # wall time [s] of `solve`, or of `solve_many` for all its beams


Status = Literal["stable", "unstable", "growing"]  # see `beamviz.solver.stability`


@dataclass(frozen=True)
class Equilibrium:
    """The equilibrium about which the beam vibrates; lengths in units of L, x in [0, 1] along the
    unstretched beam. Its methods raise ValueError for x outside.

    status: "stable"; "unstable": with divergence, a disturbance grows without vibration; or
    "growing": with flutter, a vibration grows by more than the rounding error of its growth rate.
    `beamviz.solver.stability` decides. buckled_chordwise: of a straight beam that vibrates
    flapwise, whether it is unstable in the plane of rotation.
    """

    status: Status
    iterations: int
    loads: Loads
    bent_state: Any = None  # a `SavedState` of beamviz.solver.bent; None where it is straight
    buckled_chordwise: bool = False

    @property
    def curve(self) -> Curve:
        """x (k,) -> position (k, 2) from the clamp, stretch (k,) and angle (k,)."""
        return self.loads.curve

    @property
    def stable(self) -> bool:
        """Whether no disturbance in the plane of the vibration grows."""
        return self.status == "stable"

    @property
    def shape(self) -> Literal["straight", "bent"]:
        """The kind of state."""
        return "straight" if self.bent_state is None else "bent"

    def position(self, x: NDArray) -> NDArray:
        """Position (len(x), 2) of the points x, measured from the clamp."""
        return self.curve(_points(x))[0]

    def stretch(self, x: NDArray) -> NDArray:
        """Stretch f = |r'| (len(x),)."""
        return self.curve(_points(x))[1]

    def angle(self, x: NDArray) -> NDArray:
        """Angle [rad] of the beam's axis (len(x),), continuous, 0 where it is straight."""
        return self.curve(_points(x))[2]

    def force(self, x: NDArray) -> NDArray:
        """Axial force (len(x),) in units of E I / L^2 of the root section, tension positive. It has
        a step at a body; there it is the force on the side of the root."""
        return self.loads.at(_points(x)).axial

    def shear(self, x: NDArray) -> NDArray:
        """Shear force (len(x),) in units of E I / L^2 that the part outboard of x exerts across the
        beam, on the side of the root."""
        return self.loads.at(_points(x)).shear

    def moment(self, x: NDArray) -> NDArray:
        """Bending moment (len(x),) in units of E I / L that the part outboard of x exerts, positive
        where it turns the beam the way its angle grows, on the side of the root."""
        return self.loads.at(_points(x)).moment

    def stress(self, x: NDArray) -> Stress:
        """Stress [Pa] (len(x),): `axial`, tension positive; `bending` in the outermost fibres, None
        for a deflected beam whose section_height is not known; and the `greatest` of both. Raises
        InvalidInput for a beam whose material is not known."""
        return stress(self.loads, _points(x))

    @cached_property
    def greatest_stress(self) -> GreatestStress | None:
        """The greatest stress along the beam, `pascals`, its place x / L, `at`, and whether it
        `yields`; None for a beam whose material is not known."""
        return greatest_stress(self.loads)

    @cached_property
    def root(self) -> Outboard:
        """Axial force, shear force and moment that the beam exerts on the hub: the reaction is the
        opposite."""
        at_root = self.loads.at(np.zeros(1))
        return Outboard(*(float(value[0]) for value in at_root))

    @property
    def root_force(self) -> float:
        """Axial force on the hub, in units of E I / L^2."""
        return self.root.axial

    @property
    def root_shear(self) -> float:
        """Shear force on the hub, in units of E I / L^2."""
        return self.root.shear

    @property
    def root_moment(self) -> float:
        """Bending moment on the hub, in units of E I / L."""
        return self.root.moment

    @cached_property
    def tip(self) -> NDArray:
        """Position (2,) of the tip."""
        return read_only(self.position(np.ones(1))[0])

    @cached_property
    def max_stretch(self) -> float:
        """The largest stretch along the beam."""
        return float(self.stretch(np.linspace(0, 1, NODE_GRID)).max())


@dataclass(frozen=True, eq=False, repr=False)
class Solution:
    """Equilibrium and modes of one beam; frequencies in units of 1/T*. Arrays are read-only."""

    beam: Beam
    problem: Problem
    equilibrium: Equilibrium
    stats: Stats
    s: NDArray  # (modes,) growth rate + i frequency; by ascending frequency, then descending growth
    estimate_errors: Callable[[], NDArray]  # (modes,) of s^2; may take longer than a solve
    bending_energy_fraction: NDArray  # (modes,) share of the kinetic energy across the beam
    fields: Fields  # displacement up to a constant factor of modulus 1 of each mode
    # (modes,) share of the kinetic energy in the plane of rotation, that along the beam included;
    # None where the beam bends in one plane only
    in_plane_fraction: NDArray | None = None

    def __repr__(self) -> str:
        numbers = self.beam.summary
        lowest = ", ".join(f"{frequency:.6g}" for frequency in self.frequencies[:5])
        more = ", ..." if len(self.frequencies) > 5 else ""
        return (
            f"<Solution of Beam({numbers}) by {self.problem.method}:"
            f" {self.equilibrium.status}, frequencies [{lowest}{more}]>"
        )

    def to_xarray(self) -> Any:
        """An xarray.Dataset: frequency, error, growth_rate, family and shape by mode, position and
        stretch along x; the model, the numbers, units and version as attributes.

        Raises Unavailable where xarray is not installed.
        """
        from beamviz.datasets import attributes, mode_dataset

        described = attributes(self.beam, self.problem.model, self.beam.units)
        described["status"] = self.equilibrium.status
        return mode_dataset(self.columns, self.along_beam, described)

    def plot(self, ax: Any = None) -> Any:
        """Draw the shapes onto matplotlib axes (the current ones by default), and return these."""
        from beamviz.plotting import plot_shapes

        x = np.linspace(0.0, 1.0, STATIONS)
        larger = self._larger_components(x).T
        return plot_shapes(x, larger, self.labels, self.frequencies, ax, self.beam.units)

    def show(self, **options: Any) -> Any:
        """Open the live page of this beam with this model, and return its View; options: those of
        `beamviz.show`."""
        from beamviz.notebook import show

        return show(self, **options)

    def _repr_html_(self) -> str:
        from beamviz.tables import html_table, mode_columns

        caption = repr(self).strip("<").partition(", frequencies")[0]  # which are in the table
        return html_table(caption, mode_columns(self.columns, self.beam.units))

    @property
    def columns(self) -> dict[str, Any]:
        """The modes as columns (modes,), under the keys of the JSON; with Hz and rad/s for a beam
        in SI."""
        columns: dict[str, Any] = {
            "index": np.arange(1, len(self.s) + 1),
            "label": self.labels,
            "family": self.families,
            "frequency": self.frequencies,
            "growth_rate": self.growth_rates,
            "error": self.errors,
            "bending_fraction": self.bending_energy_fraction,
            "nodes": self.nodes,
        }
        if self.in_plane_fraction is not None:
            columns["in_plane_fraction"] = self.in_plane_fraction
        if units := self.beam.units:
            columns["hertz"] = units.hertz(self.frequencies)
            columns["rad_per_s"] = units.angular_frequency(self.frequencies)
        return columns

    @property
    def along_beam(self) -> dict[str, NDArray]:
        """The equilibrium and the shapes at equally spaced stations and the mass, x (n,): position
        (n, 2), stretch, force, shear and moment (n,), shape (modes, n, 2 or 3); lengths in L,
        forces in E I / L^2, unit modal mass."""
        bodies = [self.beam.beta, *(mass.beta for mass in self.beam.masses)]
        x = np.union1d(np.linspace(0.0, 1.0, STATIONS), bodies)
        loads = self.equilibrium.loads.at(x)
        return {
            "x": x,
            "position": self.equilibrium.position(x),
            "stretch": self.equilibrium.stretch(x),
            "force": loads.axial,
            "shear": loads.shear,
            "moment": loads.moment,
            "shape": np.moveaxis(self.displacement(x), 2, 0) + 0.0,  # -0.0 becomes 0.0
        }

    @cached_property
    def frequencies(self) -> NDArray:
        """Frequencies (modes,), ascending, in units of 1/T*; nan where a mode has none."""
        return read_only(frequencies_of(self.s))

    @cached_property
    def growth_rates(self) -> NDArray:
        """Growth rates (modes,) in units of 1/T*, negative where a mode decays; 0 where it neither
        grows nor decays. With a spin-up a mode may have both a frequency and a growth rate: the
        Euler force has no potential."""
        return read_only(self.s.real.copy())

    @cached_property
    def omega_squared(self) -> NDArray:
        """omega^2 (modes,), the squared frequency; of a mode without one, minus its squared growth
        rate."""
        return read_only(omega_squared_of(self.s))

    @cached_property
    def omega_squared_errors(self) -> NDArray:
        """Estimated absolute errors (modes,) of omega^2, or of a mode with a frequency and a growth
        rate of s^2, a complex distance; infinite where there is no estimate."""
        return read_only(self.estimate_errors())

    @cached_property
    def errors(self) -> NDArray:
        """Estimated absolute errors (modes,) of s: of frequency or growth rate, or of both as a
        distance in the complex plane."""
        size, error = abs(self.s) ** 2, self.omega_squared_errors
        root = np.sqrt(size) + np.sqrt(np.maximum(size - error, 0.0))
        return read_only(np.where(root > 0, error, np.sqrt(error)) / np.where(root > 0, root, 1.0))

    @cached_property
    def sensitivities(self) -> dict[str, NDArray]:
        """The derivative (modes,) of each frequency to each number of the beam that applies, by
        name: alpha, beta, gamma, delta, mu (unless inextensible), spin_up (of a beam that has one),
        flap (out of the plane of rotation), pitch, twist (in both planes), root (unless clamped).

        In units of 1/T* over that of the number; pitch and twist in degrees. Fourth-order
        differences of beams that are solved in one stack to a tolerance of 1e-10, on one side of a
        number at its limit; nan where a mode has no frequency.
        """
        from beamviz.sensitivities import sensitivities

        return {name: read_only(each) for name, each in sensitivities(self).items()}

    @cached_property
    def families(self) -> tuple[str, ...]:
        """Family of each mode by its share of kinetic energy: bending, stretching or mixed."""
        return tuple(map(family_of, self.bending_energy_fraction))

    @cached_property
    def labels(self) -> tuple[str, ...]:
        """B1, S1 ...: numbered within bending and stretching; a mixed mode by its larger share.
        In space F1, L1, S1 ...: flap, out of the plane of rotation, lag, in it, and stretching."""
        return labels_of(self.bending_energy_fraction, self.in_plane_fraction)

    def shape(self, k: int, x: NDArray) -> NDArray:
        """Displacement (len(x), 2) of mode k (from 0) along and across the beam at x in [0, 1]; of
        a beam that bends in both planes (len(x), 3): along it, in the plane of rotation, out of it.

        Of unit modal mass. Across the beam is in the plane of rotation (chordwise) or normal to it
        (flapwise). With Coriolis forces complex: the displacement at phase p is the real part of
        shape * exp(i p). The larger component, by kinetic energy (across the beam where that has at
        least half of it), is real and positive at the tip. Raises IndexError for a mode that was
        not solved for, ValueError for x outside [0, 1].
        """
        last = len(self.s) - 1
        if not 0 <= k <= last:
            raise IndexError(f"mode {k}: this solution has modes 0 .. {last}")
        return self.displacement(x)[:, :, k]

    def displacement(self, x: NDArray) -> NDArray:
        """`shape` of all modes: (len(x), 2 or 3, modes)."""
        return self.fields(_points(x)) * self._phase

    @cached_property
    def larger_component(self) -> NDArray:
        """The larger component (modes,) of each mode: 0 along the beam, 1 across it; in space 1 in
        the plane of rotation, 2 out of it."""
        kinds = kinds_of(self.bending_energy_fraction, self.in_plane_fraction)
        return np.array([{"S": 0, "B": 1, "L": 1, "F": 2}[kind] for kind in kinds], int)

    @cached_property
    def _phase(self) -> NDArray:
        """The factor (modes,) of modulus 1 that makes the larger component real and positive at the
        tip (where no uncoupled mode has a node)."""
        tip = np.take_along_axis(self.fields(np.ones(1))[0], self.larger_component[None], axis=0)[0]
        size = abs(tip)
        return np.where(size > 0, tip.conj(), 1.0) / np.where(size > 0, size, 1.0)

    @cached_property
    def nodes(self) -> tuple[NDArray, ...]:
        """Vibration nodes x of each mode: where its larger component is zero at all times."""
        # Dense where boundary layers may be thin: at the clamp, the mass and the tip.
        near = np.geomspace(1e-5, 0.01, 40)
        bodies = (mass.beta for mass in self.beam.masses)
        near = np.add.outer((0.0, self.beam.beta, *bodies, 1.0), np.append(near, -near))
        x = np.union1d(near, np.linspace(0, 1, NODE_GRID))
        x = x[(x > 0) & (x <= 1)]
        values = self._larger_components(x)
        seen = np.maximum.accumulate(abs(values)) > VISIBLE * abs(values).max(axis=0)
        mode, before = np.nonzero((np.diff(values > 0, axis=0) & seen[:-1]).T)
        each = np.arange(len(mode))
        roots = false_position(
            lambda x: self._larger_components(x)[each, mode], x[before], x[before + 1]
        )
        return tuple(read_only(roots[mode == k]) for k in range(len(self.s)))

    def _larger_components(self, x: NDArray) -> NDArray:
        """The larger component (len(x), modes) of each mode at x."""
        shapes = self.displacement(x).real
        return np.take_along_axis(shapes, self.larger_component[None, None], axis=1)[:, 0]


def omega_squared_of(s: NDArray) -> NDArray:
    """omega^2 of modes s = growth rate + i frequency (...); of a mode without a frequency minus its
    squared growth rate."""
    return np.where(s.imag > 0, s.imag**2, -(s.real**2))


def frequencies_of(s: NDArray) -> NDArray:
    """The frequencies of modes s (...): 0 of a rigid motion, nan of a mode without one."""
    return np.where(s.imag > 0, s.imag, np.where(s == 0, 0.0, np.nan))


def kinds_of(shares: Iterable[float], in_plane: Iterable[float] | None = None) -> list[str]:
    """The first letters of the labels of modes, by the larger shares of their kinetic energy:
    across the beam and, where it bends in both planes, in the plane of rotation."""
    if in_plane is None:
        return ["B" if share >= 0.5 else "S" for share in shares]
    kinds = []
    for share, inside in zip(shares, in_plane, strict=True):
        of_kinds = {"F": 1 - inside, "L": inside - (1 - share), "S": 1 - share}
        kinds.append(max(of_kinds, key=of_kinds.__getitem__))
    return kinds


def labels_of(shares: Iterable[float], in_plane: Iterable[float] | None = None) -> tuple[str, ...]:
    """The labels of the modes of a beam; see `kinds_of`."""
    letters = kinds_of(shares, in_plane)
    return tuple(f"{a}{letters[: k + 1].count(a)}" for k, a in enumerate(letters))


def family_of(share: float) -> str:
    """The family of a mode by the share of its kinetic energy across the beam."""
    return BENDING if share >= PURE else STRETCHING if share <= 1 - PURE else MIXED


def false_position(function: Callable[[NDArray], NDArray], low: NDArray, high: NDArray) -> NDArray:
    """The roots (k,) of a vectorised function that changes sign between low and high (k,), by false
    position with the Illinois rule (importing scipy.optimize would double the start-up time)."""
    if not len(low):
        return low
    a, b, fa, fb = low, high, function(low), function(high)
    for _ in range(ROOT_ITERATIONS):
        c = b - fb * (b - a) / np.where(fb == fa, np.inf, fb - fa)
        fc = function(c)
        crossed = np.sign(fc) * np.sign(fb) < 0
        a, fa = np.where(crossed, b, a), np.where(crossed, fb, fa / 2)
        done = (abs(c - b) <= ROOT_TOLERANCE * abs(c)) | (fc == 0)
        b, fb = c, fc
        if done.all():
            break
    return b


def straight(along: NDArray, stretch: NDArray | float = 1.0) -> tuple[NDArray, NDArray, NDArray]:
    """The curve of a straight beam."""
    zero = np.zeros_like(along)
    return np.column_stack((along, zero)), zero + stretch, zero


def _points(x: NDArray) -> NDArray:
    """x as an array of floats; ValueError outside [0, 1]."""
    x = np.atleast_1d(np.asarray(x, float))
    if x.size and not (x.min() >= 0 and x.max() <= 1):
        raise ValueError(f"x = {x.min():g} .. {x.max():g}: reference points must lie in 0 .. 1")
    return x


def read_only(array: NDArray) -> NDArray:
    """The array, made read-only: solutions and meshes are shared."""
    array.setflags(write=False)
    return array
