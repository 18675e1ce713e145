"""The paper's rotating beam on ANCF elements: residual, tangent and modes (eqs. 35-48).

Planar coordinates q: r1, r2, r1', r2' of node after node, measured from the clamp. Even
coordinates run along the beam, odd ones across. The clamp holds r(0) and the direction of r'(0);
the length of r'(0) is free.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from beamviz.beam import Beam
from beamviz.solver import eigen
from beamviz.solver.constitutive import Curvature, StrainLaw
from beamviz.solver.fem import ancf, assembly, inertia
from beamviz.solver.fem.hermite import coordinates

CLAMPED = (0, 1, 3)  # r1, r2 and r2' of the first node


@dataclass(frozen=True)
class Model:
    """A beam on its elements: everything that does not change with q or the load gamma^2."""

    beam: Beam
    elements: ancf.Elements
    material: ancf.Material
    m: NDArray  # (n, 4, 4) scalar mass of each element
    C: NDArray  # (n, 8, 8) centrifugal matrix of each element

    @property
    def unstressed(self) -> NDArray:
        """q of the straight, unstretched beam: (4 (n + 1),)."""
        nodes = self.elements.nodes
        q = np.zeros((len(nodes), 4))
        q[:, 0], q[:, 2] = nodes, 1
        return q.ravel()

    @cached_property
    def mass(self) -> NDArray:
        """The constant mass matrix (paper, eqs. 10 and 36), a lower band (8, 4 (n + 1))."""
        return assembly.band(inertia.planar(self.m, inertia.IDENTITY))

    @property
    def gyroscopic(self) -> NDArray:
        """The gyroscopic matrix of M q" + 2 gamma G q' + K q = 0, skew: dense (N, N)."""
        return assembly.skew(inertia.planar(self.m, inertia.TURN))

    def slopes(self, q: NDArray) -> NDArray:
        """r' along the beam, at each node and the Gauss points after it: (n (p + 1) + 1, 2)."""
        inside = ancf.strain_state(self.elements, coordinates(q))[..., :2]
        nodes = q.reshape(-1, 1, 4)[..., 2:]
        return np.vstack((np.hstack((nodes[:-1], inside)).reshape(-1, 2), nodes[-1]))

    def residual(self, q: NDArray, load: float) -> NDArray:
        """R = dU/dq - gamma^2 C (q + delta t) (paper, eq. 40), 0 at the clamped coordinates."""
        q_e = coordinates(q)
        arm = inertia.lever_arm(q_e, self.beam.delta)
        elastic = ancf.force(self.elements, self.material, q_e)
        R = assembly.vector(elastic - load * (self.C @ arm[..., None])[..., 0])
        R[list(CLAMPED)] = 0
        return R

    def tangent(self, q: NDArray, load: float, strain: NDArray | None = None) -> NDArray:
        """K_T = K_a - gamma^2 C (paper, eq. 42), a lower band, 1 on the clamped diagonal.

        `strain` (n, p) as in ancf.tangent.
        """
        K_e = ancf.tangent(self.elements, self.material, coordinates(q), strain)
        return assembly.held(assembly.band(K_e - load * self.C), CLAMPED)


def model(
    beam: Beam, nodes: NDArray, law: StrainLaw, curvature: Curvature, plane: str = "chordwise"
) -> Model:
    """The beam on cubic elements between `nodes` (elements + 1,), from 0 to 1 ascending."""
    m = inertia.scalar_mass(nodes, beam.alpha, beam.beta)
    C = inertia.planar(m, inertia.PROJECTIONS[plane])
    material = ancf.Material(beam.mu, law, curvature)
    return Model(beam, ancf.Elements.between(nodes), material, m, C)


def modes(model: Model, q: NDArray, count: int) -> tuple[NDArray, NDArray]:
    """omega^2 (count,) ascending and unit-mass shapes (4 (n + 1), count) about q (paper, eq. 48).

    About a straight state the two families are solved apart: what a bending shape has along the
    beam is exactly 0, and what a stretching one has across it, also where frequencies meet.
    """
    K = assembly.dense(model.tangent(q, model.beam.gamma**2))
    M = assembly.dense(model.mass)
    free = np.delete(np.arange(len(q)), CLAMPED)
    families = [free] if q[1::2].any() else [free[free % 2 == 0], free[free % 2 == 1]]
    omega_squared, shapes = [], []
    for family in families:
        block = np.ix_(family, family)
        values, V, _ = eigen.symmetric_modes(K[block], M[block], count)
        omega_squared.append(values)
        shapes.append(np.zeros((len(q), V.shape[1])))
        shapes[-1][family] = V
    order = np.argsort(np.concatenate(omega_squared))[:count]
    return np.concatenate(omega_squared)[order], np.hstack(shapes)[:, order]


def along(A: NDArray) -> NDArray:
    """The part of a planar band that acts along a straight beam (even coordinates)."""
    return A[::2, ::2]


def across(A: NDArray) -> NDArray:
    """The part of a planar band that acts across a straight beam (odd coordinates)."""
    return A[::2, 1::2]
