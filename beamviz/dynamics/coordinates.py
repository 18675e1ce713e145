"""The default unknowns: stretch and angle, as polynomials on a few elements.

With the angle theta(x) and the stretch f(x) of the axis, in complex numbers r1 + i r2,

    r' = f e^(i theta),    r(x) = int_0^x f e^(i theta),
    U = int mu^2 e(f)^2 / 2 + kappa^2 / 2 dx,    kappa = theta' f^(2 - c).

The stiffness is nearly constant in these unknowns, however far the beam bends, and the mass matrix
varies; with positions as unknowns it is the reverse, and mu^2 multiplies what the stiffness varies
by. The angle begins with 0 at the clamp and is continuous; the stretch may jump between elements,
as it does at a concentrated mass.

q: coefficients of theta', then of f - 1. Arrays have the instants of time in their first axis.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from beamviz.dynamics.elements import Elements
from beamviz.solver.constitutive import StrainLaw


class Derivatives(NamedTuple):
    """Derivatives of the position, velocity and acceleration of the points (m, n), complex: r by q,
    which is also that of r' by v and of r" by a; r' by q; r" by q; r" by v."""

    r_q: NDArray
    v_q: NDArray
    a_q: NDArray
    a_v: NDArray


class StretchAndAngle:
    """Stretch and angle of a beam with a strain law and a power c of its curvature measure.

    places: (m + p,), the Gauss points, at which the beam has its distributed mass, then some other
    points of the beam.
    """

    def __init__(
        self,
        elements: Elements,
        mu: float,
        law: StrainLaw,
        curvature_power: int,
        others: tuple[float, ...],
    ):
        self.elements, self.mu, self.law = elements, mu, law
        self.power = 2 * (2 - curvature_power)  # kappa^2 = theta'^2 f^power
        self.places = np.append(elements.points, others)
        self.bending_counts = elements.orders
        self.stretch_counts = tuple(order // 2 + 1 for order in elements.orders)
        points = elements.points
        self.dS, self.S = elements.polynomials(self.bending_counts, points)  # of theta', theta
        self.Z, _ = elements.polynomials(self.stretch_counts, points)  # of f - 1
        self.bends, stretches = self.S.shape[1], self.Z.shape[1]
        self.size = self.bends + stretches
        self.I = elements.integration(self.places).astype(complex)

    def state(self, q: NDArray, v: NDArray, a: NDArray) -> "State":
        """Position, velocity and acceleration of the points, of q, v and a (k, n) each."""
        return State(self, q, v, a)

    def positions(self, q: NDArray, x: ArrayLike) -> NDArray:
        """r (k, len(x)) at points of the beam, complex."""
        theta, f = self.angle_and_stretch(q)
        return (f * np.exp(1j * theta)) @ self.elements.integration(x).T

    def stretch(self, q: NDArray, x: ArrayLike) -> NDArray:
        """f (k, len(x)) at points of the beam; at a jump the one inboard."""
        Z, _ = self.elements.polynomials(self.stretch_counts, np.atleast_1d(x))
        return 1 + q[:, self.bends :] @ Z.T

    def angle_and_stretch(self, q: NDArray) -> tuple[NDArray, NDArray]:
        """theta and f (k, m) at the Gauss points."""
        return q[:, : self.bends] @ self.S.T, 1 + q[:, self.bends :] @ self.Z.T

    def gauss_stretch(self, q: NDArray) -> NDArray:
        """f (m,) at the Gauss points of q (n,)."""
        return 1 + self.Z @ q[self.bends :]

    def strain_energy(self, q: NDArray) -> NDArray:
        """U (k,)."""
        _, f = self.angle_and_stretch(q)
        bent = q[:, : self.bends] @ self.dS.T
        density = (self.mu * self.law.strain(f)) ** 2 + bent**2 * f**self.power
        return density @ self.elements.weights / 2

    def fitted(self, theta: NDArray, f: NDArray) -> NDArray:
        """q (n,) nearest to an angle and a stretch (m,) at the Gauss points, in least squares."""
        return self.fitted_rates(theta, f, theta, f - 1)

    def fitted_rates(
        self, theta: NDArray, f: NDArray, theta_rate: NDArray, f_rate: NDArray
    ) -> NDArray:
        """v (n,) nearest to the rates of an angle and a stretch (m,), in least squares."""
        root = np.sqrt(self.elements.weights)
        bends = np.linalg.lstsq(root[:, None] * self.S, root * theta_rate)[0]
        stretches = np.linalg.lstsq(root[:, None] * self.Z, root * f_rate)[0]
        return np.concatenate((bends, stretches))


class State:
    """Positions r from the clamp, velocities v and accelerations a in the rotating frame of the
    points (k, m + p), complex, and the forces on the unknowns."""

    def __init__(self, unknowns: StretchAndAngle, q: NDArray, v: NDArray, a: NDArray):
        self.of = unknowns
        k, n = len(q), unknowns.bends
        both = np.concatenate((q, v, a))
        angles, stretches = both[:, :n] @ unknowns.S.T, both[:, n:] @ unknowns.Z.T
        theta, self.w, turn = angles[:k], angles[k : 2 * k], angles[2 * k :]  # w = theta'
        self.f, self.g, growth = 1 + stretches[:k], stretches[k : 2 * k], stretches[2 * k :]
        self.bent = q[:, :n] @ unknowns.dS.T
        self.e = np.exp(1j * theta)
        f, g, w = self.f, self.g, self.w
        self.turn = turn
        self.slope = f * self.e  # r', and its first two derivatives by time
        self.slope_rate = (g + 1j * f * w) * self.e
        self.slope_rate2 = (growth - f * w * w + 1j * (f * turn + 2 * g * w)) * self.e
        moved = np.concatenate((self.slope, self.slope_rate, self.slope_rate2)) @ unknowns.I.T
        self.r, self.v, self.a = moved[:k], moved[k : 2 * k], moved[2 * k :]

    def pulled_back(self, p: NDArray) -> NDArray:
        """Forces (k, n) on the unknowns of forces p (k, m + p) on the points: with the resultant Q
        of those outboard of each Gauss point, int Q . d(f e^(i theta))."""
        Q = self.resultant(p)
        return np.concatenate(((self.f * Q.imag) @ self.of.S, Q.real @ self.of.Z), axis=1)

    def resultant(self, p: NDArray) -> NDArray:
        """The resultant of forces on the points outboard of each Gauss point, times its weight, in
        the axes of the beam: (k, m)."""
        return (p @ self.of.I) * self.e.conj()

    def elastic(self) -> NDArray:
        """dU/dq (k, n)."""
        of, f, bent = self.of, self.f, self.bent
        force, moment = of.mu**2 * of.law.force(f), bent
        if of.power:
            moment = bent * f**of.power
            force = force + of.power / 2 * moment * bent / f
        w = of.elements.weights
        return np.concatenate(((w * moment) @ of.dS, (w * force) @ of.Z), axis=1)

    def derivatives(self) -> Derivatives:
        """Of a single state."""
        f, g, w, e, turn = (part[0] for part in (self.f, self.g, self.w, self.e, self.turn))

        def moved(by_angle: NDArray, by_stretch: NDArray) -> NDArray:
            """r of a change of the slope by the angle and the stretch."""
            S, Z = self.of.S, self.of.Z
            return self.of.I @ np.hstack((by_angle[:, None] * S, by_stretch[:, None] * Z))

        return Derivatives(
            r_q=moved(1j * self.slope[0], e),
            v_q=moved(1j * self.slope_rate[0], 1j * w * e),
            a_q=moved(1j * self.slope_rate2[0], (1j * turn - w * w) * e),
            a_v=moved(2 * (1j * g - f * w) * e, 2j * w * e),
        )

    def geometric(self, p: NDArray) -> NDArray:
        """The derivative (n, n) by q of the forces of constant p on the unknowns, of one state."""
        S, Z, n = self.of.S, self.of.Z, self.of.bends
        Q, f = self.resultant(p)[0], self.f[0]
        mixed = (S.T * Q.imag) @ Z
        K = np.zeros((self.of.size, self.of.size))
        K[:n, :n] = -(S.T * (f * Q.real)) @ S
        K[:n, n:], K[n:, :n] = mixed, mixed.T
        return K

    def elastic_tangent(self) -> NDArray:
        """d^2 U / dq^2 (n, n) of one state."""
        of, f, bent = self.of, self.f[0], self.bent[0]
        dS, Z, n, c, w = of.dS, of.Z, of.bends, of.power, of.elements.weights
        along = of.mu**2 * of.law.stiffness(f) + c * (c - 1) / 2 * bent**2 * f ** (c - 2)
        mixed = (dS.T * (w * c * bent * f ** (c - 1))) @ Z
        K = np.zeros((of.size, of.size))
        K[:n, :n] = (dS.T * (w * f**c)) @ dS
        K[:n, n:], K[n:, :n] = mixed, mixed.T
        K[n:, n:] = (Z.T * (w * along)) @ Z
        return K
