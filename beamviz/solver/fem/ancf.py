"""The planar ANCF element: energy, elastic force and full tangent (paper, eqs. 14-19, 43-44).

In numbers without dimension (EI = rho A = L = 1, EA = mu^2), with r' = S' q and r'' = S'' q,

    U = int mu^2 e(f)^2 / 2 + kappa^2 / 2 dx,    f = |r'|,    kappa = (r' x r'') / f^c,

for any strain law e and any curvature power c. At each Gauss point the strain state is
s = (r1', r2', r1'', r2'') = B q_e. The force is int B' g and the tangent int B' H B, where g and
H are the first and second derivative of the integrand by s.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from beamviz.solver.constitutive import Curvature, StrainLaw
from beamviz.solver.fem.hermite import gauss, hermite

# Green axial energy: (f^2 - 1)^2 with r' quadratic. 5 points; the tangent's degree is the same.
# The curvature and the other laws are not polynomials: their rule is this one, not an exact one.
AXIAL_DEGREE = 8

CROSS = np.array([[0.0, 1.0], [-1.0, 0.0]])  # r' x r'' = r' CROSS r''; the paper's I~ transposed


@dataclass(frozen=True)
class Elements:
    """Cubic elements between `nodes`, and what their integrals need at p Gauss points each."""

    nodes: NDArray  # (n + 1,)
    weights: NDArray  # (n, p)
    B: NDArray  # (n, p, 4, 8): element coordinates -> (r1', r2', r1'', r2'')

    @classmethod
    def between(cls, nodes: NDArray) -> "Elements":
        points, weights = gauss(AXIAL_DEGREE)
        lengths = np.diff(nodes)[:, None]
        _, dS, ddS = hermite(points, lengths)
        B = np.einsum("dnpi,cb->npdcib", np.stack((dS, ddS)), np.eye(2))
        return cls(nodes, weights * lengths, B.reshape(*dS.shape[:2], 4, 8))


@dataclass(frozen=True)
class Material:
    """What the beam is made of: its slenderness, strain law and curvature measure."""

    mu: float
    law: StrainLaw
    curvature: Curvature


def energy(elements: Elements, material: Material, q_e: NDArray) -> NDArray:
    """U, a number, at element coordinates q_e (n, 8)."""
    s = strain_state(elements, q_e)
    f = stretch(s)
    e = material.law.strain(f)
    kappa = cross(s) / f**material.curvature.power
    return np.sum(elements.weights * (material.mu**2 * e**2 + kappa**2)) / 2


def force(elements: Elements, material: Material, q_e: NDArray) -> NDArray:
    """Elastic force of each element, dU / dq_e = -Q_fe (paper, eq. 17): (n, 8)."""
    s = strain_state(elements, q_e)
    f = stretch(s)
    kappa, dkappa = bending(s, f, material.curvature.power)
    g = kappa[..., None] * dkappa
    g[..., :2] += (material.mu**2 * material.law.force(f) / f)[..., None] * s[..., :2]
    return integrated(elements, g[..., None])[..., 0]


def tangent(
    elements: Elements, material: Material, q_e: NDArray, strain: NDArray | None = None
) -> NDArray:
    """Tangent of each element, K_e = d^2 U / dq_e^2 (paper, eqs. 43-44): (n, 8, 8).

    With `strain` (n, p) the prestress is that of a strain given at the Gauss points instead of
    the strain q_e has: what a mixed Newton iteration needs.
    """
    s = strain_state(elements, q_e)
    f = stretch(s)
    e = material.law.strain(f) if strain is None else strain
    H = axial_hessian(s, f, e, material) + bending_hessian(s, f, material.curvature.power)
    return integrated(elements, H @ elements.B)


def strain_state(elements: Elements, q_e: NDArray) -> NDArray:
    """s = (r1', r2', r1'', r2'') at the Gauss points: (n, p, 4)."""
    return (elements.B @ q_e[:, None, :, None])[..., 0]


def integrated(elements: Elements, density: NDArray) -> NDArray:
    """int B' density dx over each element; density (n, p, 4, k), the integral (n, 8, k)."""
    n, p, _, k = density.shape
    weighted = elements.weights[..., None, None] * density
    B = elements.B.reshape(n, 4 * p, 8)
    return B.transpose(0, 2, 1) @ weighted.reshape(n, 4 * p, k)


def stretch(s: NDArray) -> NDArray:
    """f = |r'|."""
    return np.sqrt(s[..., 0] ** 2 + s[..., 1] ** 2)


def cross(s: NDArray) -> NDArray:
    """r' x r''."""
    return s[..., 0] * s[..., 3] - s[..., 1] * s[..., 2]


def bending(s: NDArray, f: NDArray, power: int) -> tuple[NDArray, NDArray]:
    """kappa (...) and its derivative by s (..., 4)."""
    kappa = cross(s) / f**power
    dkappa = cross_gradient(s) / (f**power)[..., None]
    dkappa[..., :2] -= (power * kappa / f**2)[..., None] * s[..., :2]
    return kappa, dkappa


def cross_gradient(s: NDArray) -> NDArray:
    """The derivative of r' x r'' by s (..., 4): (Gamma q_e of the paper's eq. 17, before S)."""
    return np.stack((s[..., 3], -s[..., 2], -s[..., 1], s[..., 0]), axis=-1)


def axial_hessian(s: NDArray, f: NDArray, e: NDArray, material: Material) -> NDArray:
    """mu^2 times the second derivative of e^2 / 2 by s (..., 4, 4): n' = e'^2 + e e'' along r'
    and n / f = e e' / f across it (the first two terms of the paper's eq. 44)."""
    law = material.law
    along = law.first(f) ** 2 + e * law.second(f)
    across = e * law.first(f) / f
    t = s[..., :2] / f[..., None]
    H = np.zeros((*s.shape, 4))
    H[..., :2, :2] = across[..., None, None] * np.eye(2)
    H[..., :2, :2] += (along - across)[..., None, None] * t[..., :, None] * t[..., None, :]
    return material.mu**2 * H


def bending_hessian(s: NDArray, f: NDArray, power: int) -> NDArray:
    """The second derivative of kappa^2 / 2 by s (..., 4, 4): dkappa dkappa' + kappa d^2 kappa
    (the other terms of the paper's eq. 44).

    Printed there, -6 Gamma q q' S'' S' / f^5 stands for -3 times the product and its transpose:
    a second derivative is symmetric.
    """
    kappa, dkappa = bending(s, f, power)
    a = s[..., :2]
    kappa, scale, f2 = (field[..., None, None] for field in (kappa, f**-power, f**2))
    mixed = (power * scale / f2) * cross_gradient(s)[..., :, None] * a[..., None, :]  # (..., 4, 2)
    d2kappa = np.zeros((*s.shape, 4))
    d2kappa[..., :2, 2:] = scale * CROSS
    d2kappa[..., 2:, :2] = scale * CROSS.T
    d2kappa[..., :, :2] -= mixed
    d2kappa[..., :2, :] -= mixed.swapaxes(-1, -2)
    d2kappa[..., :2, :2] -= power * kappa / f2 * np.eye(2)
    d2kappa[..., :2, :2] += power * (power + 2) * kappa / f2**2 * a[..., :, None] * a[..., None, :]
    return dkappa[..., :, None] * dkappa[..., None, :] + kappa * d2kappa
