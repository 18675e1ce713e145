"""The paper's elements for a straight beam: cubic Hermite, stretching and bending apart.

The same forms and Gauss points as the full planar ANCF, with half the coordinates twice: r1 and
r1' of each node along the beam, r2 and r2' across it. Nothing is lost: at a straight state the
full tangent couples none of the one to the other.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from beamviz.beam import Beam
from beamviz.mechanics import assembly, inertia, straight
from beamviz.mechanics.ancf import AXIAL_DEGREE
from beamviz.mechanics.basis import gauss, hermite
from beamviz.mechanics.newton import Root, continue_load, newton
from beamviz.mechanics.strain import Curvature, StrainLaw

HELD_ALONG = (0,)  # the clamp holds r1(0) and leaves the length of r'(0) free
HELD_ACROSS = (0, 1)  # r2(0) and r2'(0)


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

    def residual(self, q: NDArray, load: float) -> NDArray:
        """int mu^2 n(f) S' - gamma^2 m (r1 + delta), eq. 40 along the beam, 0 at the clamp."""
        n = self.weights * self.beam.mu**2 * self.law.force(self.stretch(q))
        arm = pairs(q) + self.beam.delta * np.array([1.0, 0.0, 1.0, 0.0])
        parts = (n[:, None] @ self.dS)[:, 0] - load * (self.m @ arm[:, :, None])[..., 0]
        R = assembly.vector(parts)
        R[list(HELD_ALONG)] = 0
        return R

    def along(self, q: NDArray, load: float) -> NDArray:
        """Elements of the tangent for stretching: (n, 4, 4)."""
        rigidity = straight.stretching_rigidity(self.stretch(q), self.beam.mu, self.law)
        return form(self.dS, self.weights * rigidity) - load * self.m

    def across(self, q: NDArray, load: float, curvature: Curvature) -> NDArray:
        """Elements of the tangent for bending: (n, 4, 4); `load` is its softening."""
        f = self.stretch(q)
        df = (self.ddS @ pairs(q)[:, :, None])[..., 0]
        angle = self.dS / f[..., None]  # theta = w'/f
        slope = (self.ddS - df[..., None] * angle) / f[..., None]
        bending = self.weights * straight.bending_rigidity(f, curvature)
        tension = self.weights * straight.tension_rigidity(f, self.beam.mu, self.law)
        return form(slope, bending) + form(angle, tension) - load * self.m


def form(B: NDArray, density: NDArray) -> NDArray:
    """int B' density B of each element; B (n, p, 4), density with its weights (n, p)."""
    return B.transpose(0, 2, 1) @ (density[..., None] * B)


def pairs(q: NDArray) -> NDArray:
    """Value and slope at both ends of each element: (n, 4)."""
    q = q.reshape(-1, 2)
    return np.concatenate((q[:-1], q[1:]), axis=1)


def rest(nodes: NDArray) -> NDArray:
    """q = r1, r1' of node after node, of the unstretched beam."""
    return np.column_stack((nodes, np.ones_like(nodes))).ravel()


def equilibrium(cubics: Cubics) -> tuple[NDArray, int]:
    """q in equilibrium and the Newton iterations it took (paper, eq. 40).

    Raises NoEquilibrium with the limit in gamma, or NotConverged.
    """

    def solve_at(load: float, guess: NDArray) -> Root | None:
        root = newton(
            lambda q: -assembly.solve(factor(cubics, q, load), cubics.residual(q, load)), guess
        )
        return root if root is not None and margin(cubics, root.state, load) > 0 else None

    path = continue_load(
        solve_at, rest(cubics.nodes), cubics.beam.gamma**2, lambda load, q: margin(cubics, q, load)
    )
    if path.limit is not None:
        raise straight.no_equilibrium(cubics.beam, path.limit**0.5, cubics.law)
    return path.state, path.iterations


def factor(cubics: Cubics, q: NDArray, load: float) -> NDArray:
    """Cholesky factor of the tangent along the beam; LinAlgError off the stable branch."""
    return assembly.cholesky(assembly.held(assembly.band(cubics.along(q, load)), HELD_ALONG))


def margin(cubics: Cubics, q: NDArray, load: float) -> float:
    """How far a state is from its end: 1 at rest, falling to 0 (or below) there.

    The least of the stretch, the slope n' of the force law, and the force along the beam per
    displacement of the tip, relative to rest.
    """
    f = cubics.stretch(q)
    law_margin = min(f.min(), cubics.law.stiffness(f).min()) if f.min() > 0 else f.min()
    if law_margin <= 0:
        return law_margin
    tip = np.zeros_like(q)
    tip[-2] = 1
    try:
        compliance = assembly.solve(factor(cubics, q, load), tip)[-2]
    except np.linalg.LinAlgError:
        return 0.0
    return min(law_margin, 1 / (compliance * cubics.beam.mu**2))


def matrices(parts: NDArray, m: NDArray, held: tuple[int, ...]) -> tuple[NDArray, NDArray]:
    """K and M over the free coordinates of one family."""
    free = slice(len(held), None)
    return (
        assembly.dense(assembly.band(parts))[free, free],
        assembly.dense(assembly.band(m))[free, free],
    )
