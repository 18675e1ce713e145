"""Axial force, shear force and bending moment along the beam at an equilibrium.

What lies outboard of x exerts there the force P and the moment m,

    P(x) = int_x^1 rho q,    m(x) = int_x^1 (r(s) - r(x)) x rho q ds,
    q = gamma^2 (R - out-of-plane part) + lambda (R_y, -R_x),    R = r + delta e1,

with the concentrated forces and moments of bodies. They follow from the positions, with one
integration less than the shape, not from its derivatives: at a root the reaction has the digits of
the position.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from beamviz.beam import Beam

# x (k,) -> position (k, 2) from the clamp, stretch (k,) and angle (k,)
Curve = Callable[[NDArray], tuple[NDArray, NDArray, NDArray]]

# Gauss points of an element: exact for the force on a straight one, positions of degree 30 times a
# line density of degree 8.
POINTS = 24


class Outboard(NamedTuple):
    """Forces and moments of all that lies outboard of points x (k,), or of one point."""

    axial: Any  # (k,) N, tension positive
    shear: Any  # (k,) V, to the side where y grows, of a beam along x
    moment: Any  # (k,) m, positive where it turns the beam from x to y


@dataclass(frozen=True, eq=False)
class Loads:
    """The loads on a beam at an equilibrium `curve`.

    chordwise: whether it bends in the plane of rotation. breaks: ends of the elements, between
    which positions and properties are smooth.
    """

    beam: Beam
    chordwise: bool
    breaks: NDArray
    curve: Curve

    def at(self, x: NDArray) -> Outboard:
        """The loads at x (k,) on the side of the root: a body at x is outboard, but at the clamp,
        where the hub carries it."""
        element = np.clip(np.searchsorted(self.breaks, x, side="left") - 1, 0, len(self.breaks) - 2)
        stop = self.breaks[element + 1]
        xi, w = legendre.leggauss(POINTS)
        half = ((stop - x) / 2)[:, None]
        s = x[:, None] + half * (xi + 1)
        position, _, angle = self.curve(x)
        force, moment = self._integrals(s, half * w)
        # Moments are about the clamp, then about the point itself.
        force, moment = force + self._beyond[0][element], moment + self._beyond[1][element]
        for beta, of_body, about_clamp in self._bodies:
            outboard = (x <= beta) & (beta > 0)
            force, moment = force + outboard[:, None] * of_body, moment + outboard * about_clamp
        moment = moment - cross(position, force)
        c, s = np.cos(angle), np.sin(angle)
        (Px, Py) = force.T
        return Outboard(Px * c + Py * s, Py * c - Px * s, moment)

    @cached_property
    def _beyond(self) -> tuple[NDArray, NDArray]:
        """Force (elements, 2) and moment about the clamp (elements,) of all distributed mass beyond
        each element."""
        xi, w = legendre.leggauss(POINTS)
        half = np.diff(self.breaks)[:, None] / 2
        force, moment = self._integrals(self.breaks[:-1, None] + half * (xi + 1), half * w)
        none = np.zeros((1, 2)), np.zeros(1)
        force, moment = (
            np.concatenate((part[:0:-1].cumsum(axis=0)[::-1], zero))
            for part, zero in zip((force, moment), none, strict=True)
        )
        return force, moment

    def _integrals(self, s: NDArray, weights: NDArray) -> tuple[NDArray, NDArray]:
        """Force (k, 2) and moment about the clamp (k,) of the mass at points (k, p)."""
        position = self.curve(s.ravel())[0]
        rho = 1.0 if self.beam.blade is None else self.beam.blade.at("mass", s)
        q = self._distributed(position)
        mass = (weights * rho)[..., None]
        force = (mass * q.reshape(*s.shape, 2)).sum(axis=1)
        moment = (mass[..., 0] * cross(position, q).reshape(s.shape)).sum(axis=1)
        return force, moment

    def _distributed(self, position: NDArray) -> NDArray:
        """q (k, 2) at positions (k, 2) from the clamp."""
        x, y = position[:, 0] + self.beam.delta, position[:, 1]
        load, spin_up = self.beam.gamma**2, self.beam.spin_up
        return np.column_stack((load * x + spin_up * y, load * self.chordwise * y - spin_up * x))

    @cached_property
    def _bodies(self) -> list[tuple[float, NDArray, float]]:
        """Position, force (2,) and moment about the clamp of each body."""
        beam, loads = self.beam, []
        for body in beam.bodies:
            position, _, (angle,) = self.curve(np.array([body.beta]))
            force = body.alpha * self._distributed(position)
            Jx, _, Jz = body.inertia
            if self.chordwise:
                turning = -beam.spin_up * Jz
            else:
                turning = -(beam.gamma**2) * (Jz - Jx) * np.sin(2 * angle) / 2
            moment = float(cross(position, force)[0] + turning)
            loads.append((body.beta, force[0], moment))
        return loads


def cross(a: NDArray, b: NDArray) -> NDArray:
    """a x b (k,) of plane vectors (k, 2)."""
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
