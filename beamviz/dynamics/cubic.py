"""The paper's unknowns: position and slope of the nodes of cubic elements (eqs. 2-6).

r(x) = N(x) q, so that mass, Coriolis and centrifugal matrices are constant, and the strain energy
is U = int mu^2 e(f)^2 / 2 + kappa^2 / 2 dx with f = |r'| and kappa = (r' x r'') / f^c. The position
and its derivative are continuous, also at a concentrated mass. The clamp holds r(0) and the
direction of r'(0); the length of r'(0) is free.

q: r1 and r1' of one node after the other, then r2 and r2', without those that the clamp holds.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from beamviz.dynamics.coordinates import Derivatives
from beamviz.dynamics.elements import Elements
from beamviz.solver.constitutive import StrainLaw
from beamviz.mechanics.cubic_elements import (
    axial_hessian,
    bending,
    bending_hessian,
    hermite,
    locate,
)


class CubicPositions:
    """Positions of a beam with a strain law and a power c of its curvature measure; the attributes
    and methods of `StretchAndAngle`."""

    def __init__(
        self,
        elements: Elements,
        mu: float,
        law: StrainLaw,
        curvature_power: int,
        others: tuple[float, ...],
    ):
        self.elements, self.mu, self.law, self.power = elements, mu, law, curvature_power
        self.places = np.append(elements.points, others)
        count = 2 * len(elements.ends)
        self.free = np.setdiff1d(np.arange(2 * count), (0, count, count + 1))
        self.size = len(self.free)
        self.N = self.complex_rows(self.places, 0)  # (m + p, n)
        rows = [self.complex_rows(elements.points, k) for k in (1, 2)]
        B = np.stack([part for row in rows for part in (row.real, row.imag)], axis=1)
        self.B = B  # (m, 4, n): q -> (r1', r2', r1'', r2'') at the Gauss points
        self.flat = B.reshape(-1, self.size)

    def complex_rows(self, x: NDArray, derivative: int) -> NDArray:
        """q -> r1 + i r2 at points x, or a derivative by x: (len(x), n)."""
        nodes = self.elements.ends
        element, xi = locate(nodes, x)
        values = hermite(xi, np.diff(nodes)[element])[derivative]
        rows = np.zeros((len(x), 2 * len(nodes)))
        np.put_along_axis(rows, 2 * element[:, None] + np.arange(4), values, axis=1)
        return np.hstack((rows, 1j * rows))[:, self.free]

    def state(self, q: NDArray, v: NDArray, a: NDArray) -> "CubicState":
        return CubicState(self, q, v, a)

    def positions(self, q: NDArray, x: ArrayLike) -> NDArray:
        """r (k, len(x)) at points of the beam, complex."""
        return q @ self.complex_rows(np.atleast_1d(x), 0).T

    def stretch(self, q: NDArray, x: ArrayLike) -> NDArray:
        """f (k, len(x)) at points of the beam."""
        return abs(q @ self.complex_rows(np.atleast_1d(x), 1).T)

    def gauss_stretch(self, q: NDArray) -> NDArray:
        """f (m,) at the Gauss points of q (n,)."""
        return self.strain_state(q[None])[1][0]

    def strain_energy(self, q: NDArray) -> NDArray:
        """U (k,)."""
        s, f = self.strain_state(q)
        kappa, _ = bending(s, f, self.power)
        return ((self.mu * self.law.strain(f)) ** 2 + kappa**2) @ self.elements.weights / 2

    def strain_state(self, q: NDArray) -> tuple[NDArray, NDArray]:
        """(r1', r2', r1'', r2'') (k, m, 4) and f (k, m) at the Gauss points."""
        s = (q @ self.flat.T).reshape(len(q), -1, 4)
        return s, np.hypot(s[..., 0], s[..., 1])

    def fitted(self, theta: NDArray, f: NDArray) -> NDArray:
        """q (n,) nearest to an angle and a stretch (m,) at the Gauss points, in least squares."""
        return self.nearest(f * np.exp(1j * theta))

    def fitted_rates(
        self, theta: NDArray, f: NDArray, theta_rate: NDArray, f_rate: NDArray
    ) -> NDArray:
        """v (n,) nearest to the rates of an angle and a stretch (m,), in least squares."""
        return self.nearest((f_rate + 1j * f * theta_rate) * np.exp(1j * theta))

    def nearest(self, slope: NDArray) -> NDArray:
        """q (n,) whose r' is nearest to a complex one (m,)."""
        root = np.sqrt(self.elements.weights)
        rows = root[:, None] * self.complex_rows(self.elements.points, 1)
        parts = np.concatenate((rows.real, rows.imag))
        return np.linalg.lstsq(parts, np.concatenate(((root * slope).real, (root * slope).imag)))[0]


class CubicState:
    """The attributes and methods of `beamviz.dynamics.coordinates.State`."""

    def __init__(self, unknowns: CubicPositions, q: NDArray, v: NDArray, a: NDArray):
        self.of, self.q = unknowns, q
        self.r, self.v, self.a = (part @ unknowns.N.T for part in (q, v, a))
        self.s, self.f = unknowns.strain_state(q)

    def pulled_back(self, p: NDArray) -> NDArray:
        """Forces (k, n) on the unknowns of forces p (k, m + p) on the points."""
        return (p.conj() @ self.of.N).real

    def elastic(self) -> NDArray:
        """dU/dq (k, n)."""
        of, s, f = self.of, self.s, self.f
        kappa, dkappa = bending(s, f, of.power)
        g = kappa[..., None] * dkappa
        g[..., :2] += (of.mu**2 * of.law.force(f) / f)[..., None] * s[..., :2]
        g *= of.elements.weights[:, None]
        return g.reshape(len(s), -1) @ of.flat

    def derivatives(self) -> Derivatives:
        """Of a single state: positions are linear in q."""
        none = np.zeros_like(self.of.N)
        return Derivatives(self.of.N, none, none, none)

    def geometric(self, p: NDArray) -> NDArray:
        """No derivative: forces act on the unknowns by constants."""
        return np.zeros((self.of.size, self.of.size))

    def elastic_tangent(self) -> NDArray:
        """d^2 U / dq^2 (n, n) of one state."""
        of, s, f = self.of, self.s[0], self.f[0]
        H = of.mu**2 * axial_hessian(s, f, of.law) + bending_hessian(s, f, of.power)
        H *= of.elements.weights[:, None, None]
        return of.flat.T @ (H @ of.B).reshape(-1, of.size)
