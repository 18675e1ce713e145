"""Strain laws and curvature measures of a stretched, bent beam, as data.

With r(x) the position of the neutral axis and f = |r'| its stretch, the energy per reference
length is mu^2 e(f)^2 / 2 + k^2 / 2 with k = (r' x r'') / f^c. A law is the function e, a
curvature measure is the power c. Every function is vectorised and analytic: f may be complex.

About a straight state r = (u(x), 0) with f = u' the tangent of the paper (eq. 44) is exactly
    stretching: int mu^2 n'(f) du'^2             - gamma^2 int rho du^2
    bending:    int (f w'' - f' w')^2 / f^(2c) + mu^2 n(f) / f w'^2  [- gamma^2 int rho w^2],
the last term in the chordwise plane only. Written with the angle theta = w'/f, which stays
continuous where a concentrated mass makes f jump, bending becomes
    int f^(4 - 2c) theta'^2 + N f theta^2,   N = mu^2 n(f),
with c = 3 for the spatial curvature and c = 2 for the material one.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from beamviz.beam import Beam
from beamviz.errors import NoEquilibrium

Function = Callable[[Any], Any]  # of a number or an array, elementwise


@dataclass(frozen=True)
class StrainLaw:
    """An axial strain e(f) of the stretch f. A new law is a record in STRAIN_LAWS: the choices of
    `solve`, the documentation and the tests of random beams follow from these.

    force: n = e e', the axial force divided by mu^2. stiffness: n'. The force grows with the
    stretch between min_stretch and max_stretch only: outside, n' < 0 and a bar under dead load has
    no stable state. stretch: f of a force n in closed form, where there is one; that of the nearest
    limit for a force beyond it.
    """

    name: str
    description: str
    strain: Function
    force: Function
    stiffness: Function
    min_stretch: float
    max_stretch: float
    stretch: Function | None = None

    def __reduce__(self) -> tuple[Function, tuple[str]]:  # pickled by its name
        return strain_law, (self.name,)

    def stretch_from_force(self, n: NDArray) -> NDArray:
        """The stretch that carries a force n; that of the nearest limit for a force beyond it."""
        if self.stretch is not None:
            return self.stretch(n)
        least, most = ((1 - LIMIT) * limit for limit in self.force_limits)
        n = np.clip(n, least, most)
        f = np.ones_like(n)
        for _ in range(NEWTON_ITERATIONS):
            step = (n - self.force(f)) / self.stiffness(f)
            f = np.clip(f + np.clip(step, -f / 2, f), self.min_stretch, self.max_stretch)
            if np.all(abs(step) <= 1e-10 * f):
                break
        return f

    @cached_property
    def stiffens(self) -> bool:
        """Whether the stiffness grows with the stretch in tension: then an outward beam always has
        an equilibrium."""
        return bool((np.diff(self.stiffness(np.geomspace(1.0, 100.0, 50))) > 0).all())

    @cached_property
    def force_limits(self) -> tuple[float, float]:
        """The least and the greatest force n."""
        with np.errstate(all="ignore"):  # a force may have no limit
            least, most = map(float, self.force(np.array([self.min_stretch, self.max_stretch])))
        return least, most


LIMIT = 1e-6  # relative distance from a limit of the force, where the stiffness vanishes
NEWTON_ITERATIONS = 40
_ROOT3 = math.sqrt(3)


def _cubic(n: NDArray) -> NDArray:
    """The largest root of f^3 - f = 2 n; the least stretch where there is none."""
    x = np.maximum(3 * _ROOT3 * n, -1)
    below, above = np.arccos(np.minimum(x, 1)), np.arccosh(np.maximum(x, 1))  # one of them is 0
    return 2 / _ROOT3 * np.cos(below / 3) * np.cosh(above / 3)


STRAIN_LAWS = {
    law.name: law
    for law in (
        StrainLaw(
            name="green",
            description="Green-Lagrange (f^2 - 1) / 2, the paper's",
            strain=lambda f: (f - 1) * (f + 1) / 2,
            force=lambda f: (f - 1) * (f + 1) * f / 2,
            stiffness=lambda f: 1.5 * f * f - 0.5,
            min_stretch=1 / math.sqrt(3),
            max_stretch=math.inf,
            stretch=_cubic,
        ),
        StrainLaw(
            name="biot",
            description="engineering strain f - 1",
            strain=lambda f: f - 1,
            force=lambda f: f - 1,
            stiffness=np.ones_like,
            min_stretch=0.0,
            max_stretch=math.inf,
            stretch=lambda n: np.maximum(1 + n, 0),
        ),
        StrainLaw(
            name="hencky",
            description="logarithmic strain ln f, whose force has a maximum",
            strain=np.log,
            force=lambda f: np.log(f) / f,
            stiffness=lambda f: (1 - np.log(f)) / f**2,
            min_stretch=0.0,
            max_stretch=math.e,
        ),
    )
}


def strain_law(name: str) -> StrainLaw:
    """The strain law of a name."""
    return STRAIN_LAWS[name]


CURVATURES = {  # the power c of each curvature measure
    "spatial": 3,  # curvature of the deformed axis, per deformed length (paper, eq. 16)
    "material": 2,  # rotation per reference length, d theta / dx (Gerstmayr & Irschik 2008)
}


class Theory(NamedTuple):
    """What the energy of a beam follows from: the strain law, the power c of the curvature measure,
    and the plane of its bending."""

    law: StrainLaw
    curvature_power: int
    in_plane: bool = True  # whether it moves in the plane of rotation
    in_space: bool = False  # or in it and out of it

    @property
    def bending_property(self) -> str:
        """The property of a `Blade` that is its bending stiffness in this plane, or "both"."""
        if self.in_space:
            return "both"
        return "bending" if self.in_plane else "flap"


def axial_stiffness(f: np.ndarray, mu: float | np.ndarray, law: StrainLaw) -> np.ndarray:
    """mu^2 n'(f), the coefficient of du'^2."""
    return mu**2 * law.stiffness(f)


def bending_stiffness(f: np.ndarray, curvature_power: int) -> np.ndarray:
    """f^(4 - 2c), the coefficient of theta'^2."""
    return (f * f) ** (2 - curvature_power)  # powers of -1 and 0 are fast


def rigid_tension(beam: Beam, x: np.ndarray) -> np.ndarray:
    """N L^2 / (E I) at x (n,) of a beam that does not stretch; at the mass, the tension inboard."""
    distributed = (1 - x) * ((1 + x) / 2 + beam.delta)
    carried = np.where(x <= beam.beta, beam.alpha * (beam.beta + beam.delta), 0.0)
    return beam.gamma**2 * (distributed + carried)


def no_equilibrium(beam: Any, limit: float, law: StrainLaw) -> NoEquilibrium:
    """The error of a beam, or of its numbers, whose gamma is above `limit`, the greatest possible,
    or just below it."""
    where = f"no equilibrium beyond gamma = {limit:.9g}"
    if beam.gamma <= limit:
        where = f"too near the limit of equilibrium, gamma = {limit:.9g}, to be solved"
    return NoEquilibrium(
        f"gamma = {beam.gamma:.9g}: {where} ({law.name} strain, alpha = {beam.alpha:g},"
        f" beta = {beam.beta:g}, delta = {beam.delta:g}, mu = {beam.mu:g})",
        limit,
    )
