"""Cubic Hermite elements, and the paper's planar ANCF elements (eqs. 2-19, 29-44).

A beam between 0 and 1 is divided by `nodes`, ascending. Each node carries the value and the slope
of a field, so an element has 4 coordinates for each component: value, slope, value, slope.
Symmetric matrices are assembled as LAPACK's lower bands: A[k, j] is the entry in row j + k,
column j.

Planar elements in dimensionless form (EI = rho A = L = 1, EA = mu^2), with r' = S' q, r'' = S'' q:

    U = int mu^2 e(f)^2 / 2 + kappa^2 / 2 dx,    f = |r'|,    kappa = (r' x r'') / f^c,

for any strain law e and any curvature power c. At each Gauss point the strain state is
s = (r1', r2', r1'', r2'') = B q_e. The force is int B' g and the tangent int B' H B, where g and
H are the first and second derivative of the integrand by s.

Planar coordinates q: r1, r2, r1', r2' of node after node, measured from the clamp; even ones along
the beam, odd ones across it. The clamp holds r(0) and the direction of r'(0); the length of r'(0)
is free.
"""

from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import ArrayLike, NDArray

from beamviz.beam import Beam
from beamviz.blade import MAX_DEGREE, STIFFNESSES
from beamviz.solver.constitutive import StrainLaw, Theory
from beamviz.space.spans import ends_of_spans

# Green axial energy: (f^2 - 1)^2 with r' quadratic. 5 points; the tangent's degree is the same.
# The curvature and the other laws are not polynomials, and not integrated exactly.
AXIAL_DEGREE = 8

MASS_DEGREE = 6  # of the product of two cubics
# Least length of an element beside a body or a discontinuity. The rounding error of omega^2 grows
# with its inverse cube: beside a tip mass 1e-6 at this length, and 400 at a thousandth of it.
SHORTEST = 1e-3
CROSS = np.fliplr(np.diag([1.0, -1.0, -1.0, 1.0]))  # r' x r'' = s' CROSS s / 2


def nodes_of(beam: Beam, elements: int) -> NDArray:
    """The nodes of `elements` equal elements; of a beam that is not uniform also at bodies and
    where a property or its slope jumps, unless they would be nearer than SHORTEST to the node
    before or to the tip: as equal as these allow, one at least between two."""
    if beam.is_uniform:
        return np.linspace(0.0, 1.0, elements + 1)
    nodes = [0.0]
    for stop in ends_of_spans(beam)[1:]:
        start = nodes[-1]
        if stop - start >= SHORTEST and (stop == 1 or 1 - stop >= SHORTEST):
            count = max(1, round(elements * (stop - start)))
            nodes.extend(np.linspace(start, stop, count + 1)[1:])
    return np.array(nodes)


def gauss(degree: int) -> tuple[NDArray, NDArray]:
    """The fewest Gauss points in [0, 1] exact for a polynomial of `degree`, and their weights."""
    points, weights = legendre.leggauss(degree // 2 + 1)
    return (points + 1) / 2, weights / 2


class Quadrature(NamedTuple):
    """Gauss points in each of n elements."""

    xi: NDArray  # (p,) in 0 .. 1
    x: NDArray  # (n, p)
    weights: NDArray  # (n, p)


def quadrature(nodes: NDArray, beam: Beam, degree: int) -> Quadrature:
    """The quadrature that is exact for a polynomial of `degree` times a property of the beam."""
    xi, weights = gauss(degree if beam.blade is None else degree + MAX_DEGREE)
    lengths = np.diff(nodes)[:, None]
    return Quadrature(xi, nodes[:-1, None] + lengths * xi, lengths * weights)


def distributed_mass(nodes: NDArray, beam: Beam) -> Quadrature:
    """The quadrature of an integral over the mass of the beam without bodies."""
    points = quadrature(nodes, beam, MASS_DEGREE)
    if beam.blade is None:
        return points
    return points._replace(weights=points.weights * beam.blade.at("mass", points.x))


def hermite(xi: ArrayLike, length: ArrayLike) -> tuple[NDArray, NDArray, NDArray]:
    """S, S' and S'' of cubic elements (paper, eqs. 5-6), one component: (..., 4) each. xi = x /
    length in [0, 1] and length are broadcast; the derivatives are by x."""
    xi, l = np.broadcast_arrays(xi, length)
    rise = xi * xi * (3 - 2 * xi)
    S = [1 - rise, l * xi * (1 - xi) ** 2, rise, -l * xi * xi * (1 - xi)]
    dS = [-6 * xi * (1 - xi) / l, (1 - xi) * (1 - 3 * xi), 6 * xi * (1 - xi) / l, xi * (3 * xi - 2)]
    ddS = [(12 * xi - 6) / l**2, (6 * xi - 4) / l, (6 - 12 * xi) / l**2, (6 * xi - 2) / l]
    return np.stack(S, -1), np.stack(dS, -1), np.stack(ddS, -1)


def locate(nodes: NDArray, x: ArrayLike) -> tuple[NDArray, NDArray]:
    """The element of each x and xi in it; a node belongs to its right element (paper, eq. 30)."""
    element = np.clip(np.searchsorted(nodes, x, side="right") - 1, 0, len(nodes) - 2)
    return element, (x - nodes[element]) / np.diff(nodes)[element]


def element_coordinates(q: NDArray, per_node: int) -> NDArray:
    """Coordinates of each element, q_e = B_e q (paper, eqs. 2-4): (elements, 2 per_node, ...)."""
    q = q.reshape(-1, per_node, *q.shape[1:])
    return np.concatenate((q[:-1], q[1:]), axis=1)


def interpolate(nodes: NDArray, q: NDArray, x: ArrayLike, derivative: int = 0) -> NDArray:
    """A field or its derivative (1 or 2) at x (k,), from value and slope of node after node. q (2N,
    ...) of N nodes; the field (k, ...)."""
    element, xi = locate(nodes, x)
    S = hermite(xi, np.diff(nodes)[element])[derivative]
    return np.einsum("xi,xi...->x...", S, element_coordinates(q, 2)[element])


def mass(nodes: NDArray, beam: Beam) -> NDArray:
    """Mass matrix m_e of one component: (elements, 4, 4). int rho A S' S dx of each element (paper,
    eq. 8), and alpha S'(beta) S(beta) of each body in the element that holds it (eqs. 29-32)."""
    xi, _, weights = distributed_mass(nodes, beam)
    S, _, _ = hermite(xi, np.diff(nodes)[:, None])
    m = np.einsum("ep,epi,epj->eij", weights, S, S)
    for body in beam.bodies:
        element, xi = locate(nodes, body.beta)
        S, _, _ = hermite(xi, np.diff(nodes)[element])
        m[element] += body.alpha * np.outer(S, S)
    return m


def assemble(parts: NDArray) -> NDArray:
    """The sum (..., k (n + 1)) of the vectors (..., n, 2 k) of n elements whose nodes have k
    coordinates, sum_e B_e' parts_e (paper, eq. 19)."""
    *stack, elements, width = parts.shape
    total = np.zeros((*stack, elements + 1, width // 2), parts.dtype)
    total[..., :-1, :] += parts[..., : width // 2]  # neighbours share a node
    total[..., 1:, :] += parts[..., width // 2 :]
    return total.reshape(*stack, -1)


def assemble_band(parts: NDArray) -> NDArray:
    """The sum of symmetric element matrices (elements, w, w), sum_e B_e' parts_e B_e (paper,
    eqs. 10 and 43), as a lower band (w, n)."""
    elements, width, _ = parts.shape
    stride = width // 2
    A = np.zeros((width, stride * (elements + 1)))
    for j in range(width):
        A[: width - j, j : j + stride * elements : stride] += parts[:, j:, j].T
    return A


def dense(A: NDArray) -> NDArray:
    """The full matrix (n, n) of a lower band."""
    n = A.shape[1]
    full, j = np.zeros((n, n)), np.arange(n)
    for k, diagonal in enumerate(A[:n]):
        full[j[k:], j[: n - k]] = full[j[: n - k], j[k:]] = diagonal[: n - k]
    return full


class CubicElements:
    """A beam on n cubic elements, between `nodes` (n + 1,) from 0 to 1, with p Gauss points each:
    all that is independent of q and of the load gamma^2."""

    def __init__(self, nodes: NDArray, beam: Beam, theory: Theory):
        self.nodes, self.beam = nodes, beam
        self.law, self.curvature_power, in_plane, _ = theory
        xi, x, self.weights = quadrature(nodes, beam, AXIAL_DEGREE)  # weights (n, p)
        self.EI, self.EA = np.ones(1), np.ones(1)  # (n, p) of a blade
        self.in_space = theory.bending_property == "both"
        self.EI_in_space = np.ones(
            (3, 1)
        )  # (3, n, p) in the plane of rotation, coupling, out of it
        if beam.blade and self.in_space:
            turn = np.radians(beam.blade.at("twist", x))
            EI, flap = (beam.blade.at(name, x) for name in STIFFNESSES["both"])
            c, s = np.cos(turn), np.sin(turn)
            self.EI_in_space = np.stack(
                (c**2 * EI + s**2 * flap, c * s * (EI - flap), s**2 * EI + c**2 * flap)
            )
        if beam.blade:
            self.EI = beam.blade.at(theory.bending_property, x)
            self.EA = beam.blade.at("axial", x)
        _, self.dS, self.ddS = hermite(xi, np.diff(nodes)[:, None])  # (n, p, 4), of one component
        # Element coordinates -> (r1', r2', r1'', r2''): (n, p, 4, 8).
        B = np.einsum("dnpi,cb->npdcib", np.stack((self.dS, self.ddS)), np.eye(2))
        self.B = B.reshape(*self.dS.shape[:2], 4, 8)
        self.m = mass(nodes, beam)  # (n, 4, 4), of one component
        # m times the projection away from the axis of rotation: (n, 8, 8).
        axial = np.diag([1.0, float(in_plane)])
        self.C = np.einsum("eij,cd->eicjd", self.m, axial).reshape(-1, 8, 8)

    @property
    def unstressed(self) -> NDArray:
        """q of the straight, unstretched beam: (4 (n + 1),)."""
        q = np.zeros((len(self.nodes), 4))
        q[:, 0], q[:, 2] = self.nodes, 1
        return q.ravel()

    def slopes(self, q: NDArray) -> NDArray:
        """r' at each node and at the Gauss points after it, along the beam: (n (p + 1) + 1, 2)."""
        inside = self.strain_state(element_coordinates(q, 4))[0][..., :2]
        nodes = q.reshape(-1, 1, 4)[..., 2:]
        return np.vstack((np.hstack((nodes[:-1], inside)).reshape(-1, 2), nodes[-1]))

    def residual(self, q: NDArray, load: float) -> NDArray:
        """R = dU/dq - gamma^2 C (q + delta t) (paper, eq. 40): (4 (n + 1),), load = gamma^2."""
        q_e = element_coordinates(q, 4)
        return assemble(self.force(q_e) - self.centrifugal_force(q_e, load))

    def tangent(self, q: NDArray, load: float) -> NDArray:
        """K_T = K_a - gamma^2 C (paper, eq. 42), a lower band (8, 4 (n + 1))."""
        return assemble_band(self.stiffness(element_coordinates(q, 4)) - load * self.C)

    def centrifugal_force(self, q_e: NDArray, load: float) -> NDArray:
        """gamma^2 C (q + delta t) of each element: (n, 8). t is the unit translation along the
        beam, which cubics hold exactly, so that delta C t is the load of the hub radius (paper,
        eqs. 24-25, 33-34)."""
        arm = q_e.copy()
        arm[:, [0, 4]] += self.beam.delta
        return load * (self.C @ arm[..., None])[..., 0]

    def strain_state(self, q_e: NDArray) -> tuple[NDArray, NDArray]:
        """s = (r1', r2', r1'', r2'') (..., n, p, 4) and f (..., n, p) at the Gauss points, of q_e
        (..., n, 8)."""
        s = (self.B @ q_e[..., None, :, None])[..., 0]
        return s, np.hypot(s[..., 0], s[..., 1])

    def energy(self, q_e: NDArray) -> NDArray:
        """Strain energy (...) of all elements, of q_e (..., n, 8)."""
        s, f = self.strain_state(q_e)
        kappa, _ = bending(s, f, self.curvature_power)
        density = self.beam.mu**2 * self.EA * self.law.strain(f) ** 2 + self.EI * kappa**2
        return (self.weights * density).sum(axis=(-2, -1)) / 2

    def force(self, q_e: NDArray) -> NDArray:
        """Elastic force of each element, dU / dq_e = -Q_fe (paper, eq. 17): (..., n, 8) of q_e
        (..., n, 8)."""
        s, f = self.strain_state(q_e)
        kappa, dkappa = bending(s, f, self.curvature_power)
        g = (self.EI * kappa)[..., None] * dkappa
        g[..., :2] += (self.beam.mu**2 * self.EA * self.law.force(f) / f)[..., None] * s[..., :2]
        return self._integral(g[..., None])[..., 0]

    def stiffness(self, q_e: NDArray) -> NDArray:
        """Tangent of each element, K_e = d^2 U / dq_e^2 (paper, eqs. 43-44): (n, 8, 8)."""
        s, f = self.strain_state(q_e)
        EI, EA = self.EI[..., None, None], self.EA[..., None, None]
        H = self.beam.mu**2 * EA * axial_hessian(s, f, self.law)
        return self._integral((H + EI * bending_hessian(s, f, self.curvature_power)) @ self.B)

    def _integral(self, density: NDArray) -> NDArray:
        """int B' density dx over each element; density (..., n, p, 4, k), the integral (..., n, 8,
        k)."""
        *stack, n, p, _, k = density.shape
        weighted = self.weights[..., None, None] * density
        B = self.B.reshape(n, 4 * p, 8).transpose(0, 2, 1)
        return B @ weighted.reshape(*stack, n, 4 * p, k)


def bending(s: NDArray, f: NDArray, power: int) -> tuple[NDArray, NDArray]:
    """kappa (...) and its derivative by s (..., 4); s' CROSS is Gamma q_e of the paper's eq. 17,
    before S."""
    kappa = (s[..., 0] * s[..., 3] - s[..., 1] * s[..., 2]) / f**power
    dkappa = s @ CROSS / (f**power)[..., None]
    dkappa[..., :2] -= (power * kappa / f**2)[..., None] * s[..., :2]
    return kappa, dkappa


def axial_hessian(s: NDArray, f: NDArray, law: StrainLaw) -> NDArray:
    """The second derivative of e^2 / 2 by s (..., 4, 4): n' = e'^2 + e e'' along r' and
    n / f = e e' / f across it (the first two terms of the paper's eq. 44)."""
    along, across = law.stiffness(f), law.force(f) / f
    t = s[..., :2] / f[..., None]
    H = np.zeros((*s.shape, 4))
    H[..., :2, :2] = across[..., None, None] * np.eye(2)
    H[..., :2, :2] += (along - across)[..., None, None] * t[..., :, None] * t[..., None, :]
    return H


def bending_hessian(s: NDArray, f: NDArray, power: int) -> NDArray:
    """The second derivative of kappa^2 / 2 by s (..., 4, 4): dkappa dkappa' + kappa d^2 kappa (the
    other terms of the paper's eq. 44). Printed there, -6 Gamma q q' S'' S' / f^5 stands for -3
    times the product and its transpose: a second derivative is symmetric."""
    kappa, dkappa = bending(s, f, power)
    a = s[..., :2]
    kappa, scale, f2 = (field[..., None, None] for field in (kappa, f**-power, f**2))
    mixed = (power * scale / f2) * (s @ CROSS)[..., :, None] * a[..., None, :]  # (..., 4, 2)
    d2kappa = scale * CROSS
    d2kappa[..., :, :2] -= mixed
    d2kappa[..., :2, :] -= mixed.swapaxes(-1, -2)
    d2kappa[..., :2, :2] -= power * kappa / f2 * np.eye(2)
    d2kappa[..., :2, :2] += power * (power + 2) * kappa / f2**2 * a[..., :, None] * a[..., None, :]
    return dkappa[..., :, None] * dkappa[..., None, :] + kappa * d2kappa
