"""The paper's elements for a straight beam: cubic Hermite, stretching and bending apart.

The same forms and Gauss points as the full planar ANCF, with half the coordinates twice: r1 and
r1' of each node along the beam, r2 and r2' across it. Nothing is lost: at a straight state the
full tangent couples none of the one to the other.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from beamviz.beam import Beam
from beamviz.solver import constitutive
from beamviz.solver.constitutive import Curvature, StrainLaw
from beamviz.solver.fem import inertia
from beamviz.solver.fem.ancf import AXIAL_DEGREE
from beamviz.solver.fem.hermite import gauss, hermite


@dataclass(frozen=True)
class Cubics:
    """A beam on cubic elements between `nodes`; p Gauss points in each of n elements."""

    beam: Beam
    law: StrainLaw
    nodes: NDArray  # (n + 1,)
    weights: NDArray  # (n, p)
    dS: NDArray  # (n, p, 4)
    ddS: NDArray  # (n, p, 4)
    m: NDArray  # (n, 4, 4) mass of each element, one component (paper, eqs. 8 and 32)

    @classmethod
    def between(cls, nodes: NDArray, beam: Beam, law: StrainLaw) -> "Cubics":
        points, weights = gauss(AXIAL_DEGREE)
        lengths = np.diff(nodes)[:, None]
        _, dS, ddS = hermite(points, lengths)
        m = inertia.scalar_mass(nodes, beam.alpha, beam.beta)
        return cls(beam, law, nodes, weights * lengths, dS, ddS, m)

    def stretch(self, q: NDArray) -> NDArray:
        """f = r1' at the Gauss points (n, p), from q = r1, r1' of node after node."""
        return (self.dS @ pairs(q)[:, :, None])[..., 0]

    def along(self, q: NDArray, load: float) -> NDArray:
        """Elements of the tangent for stretching: (n, 4, 4)."""
        rigidity = constitutive.axial_stiffness(self.stretch(q), self.beam.mu, self.law)
        return form(self.dS, self.weights * rigidity) - load * self.m

    def across(self, q: NDArray, load: float, curvature: Curvature) -> NDArray:
        """Elements of the tangent for bending: (n, 4, 4); `load` is its softening."""
        f = self.stretch(q)
        df = (self.ddS @ pairs(q)[:, :, None])[..., 0]
        angle = self.dS / f[..., None]  # theta = w'/f
        slope = (self.ddS - df[..., None] * angle) / f[..., None]
        bending = self.weights * constitutive.bending_stiffness(f, curvature)
        tension = self.weights * constitutive.tension_stiffness(f, self.beam.mu, self.law)
        return form(slope, bending) + form(angle, tension) - load * self.m

    def prestressed(self, u: NDArray, load: float) -> NDArray:
        """Elements for bending of the unstretched beam under the tension mu^2 u' of a linear
        bar: (n, 4, 4)."""
        tension = self.weights * self.beam.mu**2 * self.stretch(u)
        return form(self.ddS, self.weights) + form(self.dS, tension) - load * self.m


def form(B: NDArray, density: NDArray) -> NDArray:
    """int B' density B of each element; B (n, p, 4), density with its weights (n, p)."""
    return B.transpose(0, 2, 1) @ (density[..., None] * B)


def pairs(q: NDArray) -> NDArray:
    """Value and slope at both ends of each element: (n, 4)."""
    q = q.reshape(-1, 2)
    return np.concatenate((q[:-1], q[1:]), axis=1)
