"""The force of inertia of the mass of a beam that moves in a rotating frame (paper, eqs. 20-35).

Positions in the plane of the vibration are complex, r = r1 + i r2 from the clamp, in the axes of
the hub, and R = r + delta from the axis of rotation. A unit of mass has the force of inertia

    p = r" + 2 i gamma r' + i gamma' R - gamma^2 P R,

its own, the Coriolis, the Euler and the centrifugal one. In the plane of rotation P = 1. Out of it
(flapwise) r2 is parallel to the axis of rotation: P R is the real part of R, at a constant speed,
and Coriolis forces vanish.

A body that turns by the angle theta of the beam has the moment of inertia J theta" + J gamma' in
the plane of rotation. Out of it, with the principal moments Jx along the beam, Jy and Jz along the
axis of rotation, it has Jy theta" + gamma^2 (Jz - Jx) sin(2 theta) / 2.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from beamviz.beam import Beam

Number = float | NDArray  # of one instant, or (k, 1) of k


class Loading(NamedTuple):
    """What acts on the beam from outside, at one instant or at k: the rotation of its frame, and a
    force at one point."""

    gamma: Number
    rate: Number = 0.0  # gamma'
    in_plane: bool = True  # whether the beam moves in the plane of rotation
    force: complex = 0.0  # [E I / L^2]

    def inertia(self, r: NDArray, v: Number | NDArray = 0.0, a: Number | NDArray = 0.0) -> NDArray:
        """p (..., m) of positions from the axis, velocities and accelerations in the frame. It is
        linear: with derivatives of these, its derivative."""
        axial = r if self.in_plane else r.real
        return a + 2j * self.gamma * v + 1j * self.rate * r - self.gamma**2 * axial


class Masses(NamedTuple):
    """The mass of a beam: distributed mass at the n Gauss points, then the bodies that move."""

    x: NDArray  # (m,)
    mass: NDArray  # (m,) times the weight of the integration
    moving: NDArray  # (bodies that move,) numbers of these among all bodies of the beam
    rotary: NDArray  # (masses,) J of the bodies that have moments of inertia
    restoring: (
        NDArray  # (masses,) Jz - Jx where the beam moves out of the plane of rotation, else 0
    )

    def moments(self, loading: Loading, angles: NDArray, turning: Number | NDArray) -> NDArray:
        """The moments (..., masses) of inertia of the bodies, at their angles and with the
        accelerations `turning` of these."""
        moments = self.rotary * (turning + loading.in_plane * loading.rate)
        return moments + loading.gamma**2 * self.restoring * np.sin(2 * angles) / 2

    def restoring_stiffness(self, loading: Loading, angles: NDArray) -> NDArray:
        """The derivative (masses,) of the moments by the angles."""
        return loading.gamma**2 * self.restoring * np.cos(2 * angles)


def masses_of(beam: Beam, x: NDArray, mass: NDArray, in_plane: bool) -> Masses:
    """The mass of a beam, of which the distributed part is `mass` (n,) at points x (n,)."""
    bodies = [(beam.alpha, beam.beta), *((body.alpha, body.beta) for body in beam.masses)]
    alpha, beta = np.array(bodies).T
    moving = np.flatnonzero((alpha > 0) & (beta > 0))
    Jx, Jy, Jz = np.array([body.inertia for body in beam.masses]).reshape(-1, 3).T
    return Masses(
        x=np.append(x, beta[moving]),
        mass=np.append(mass, alpha[moving]),
        moving=moving,
        rotary=Jz if in_plane else Jy,
        restoring=0 * Jz if in_plane else Jz - Jx,
    )
