"""The default discretisation: a straight beam in terms of what carries its energy.

The unknowns sit at Gauss points of a few elements of high order: the gradient s = du' for
stretching, the slope of the rotation kappa = theta' for bending. Displacements are integrals,
u = J s and w = J (f J kappa), so the clamp is exact and nothing must match between elements:
the jump of the stretch at a concentrated mass costs no accuracy. Convergence is exponential
in the order.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import lapack

from beamviz.beam import Beam
from beamviz.mechanics import eigen, straight
from beamviz.mechanics.mesh import Mesh
from beamviz.mechanics.strain import Curvature, StrainLaw

EPS = float(np.finfo(float).eps)
NEWTON_ITERATIONS = 12
# Factors on the two estimates of error, set on random beams over all accepted scenes.
TRUNCATION_FACTOR = 8.0
ROUNDING_FACTOR = 30.0


@dataclass(frozen=True)
class Inertia:
    """The line density rho = 1 + alpha Dirac(x - beta) in terms of a gradient on a mesh."""

    G: np.ndarray  # (n, n) mass matrix J' rho J
    g: np.ndarray  # (n,) static moment J' rho 1
    to_mass: np.ndarray | None  # (n,) sqrt(alpha) times the integral from clamp to mass
    total: float  # mass that pulls at the clamp


def inertia(mesh: Mesh, alpha: float, beta: float) -> Inertia:
    """The inertia of a beam whose mass sits on a break of the mesh."""
    if not (alpha and beta):
        return Inertia(mesh.G, mesh.g, None, 1.0)
    to_mass = np.where(mesh.points < beta, mesh.weights, 0.0)
    root = np.sqrt(alpha) * to_mass
    return Inertia(mesh.G + root[:, None] * root, mesh.g + alpha * to_mass, root, 1.0 + alpha)


def newton(
    mesh: Mesh, rho: Inertia, delta: float, law: StrainLaw, load: float, f: np.ndarray
) -> tuple[np.ndarray | None, int]:
    """The stretch f (n,) in equilibrium at load = (gamma / mu)^2, by Newton-Raphson from f.

    The residual is n(f) w - load (G f + delta g), the paper's eq. 40 for a straight beam.
    Returns None for f where an iterate leaves the stable branch, and the iterations done.
    """
    diagonal = slice(None, None, len(f) + 1)
    for iteration in range(1, NEWTON_ITERATIONS + 1):
        tangent = -load * rho.G
        tangent.flat[diagonal] += mesh.weights * law.stiffness(f)
        residual = mesh.weights * law.force(f) - load * (rho.G @ f + delta * rho.g)
        _, step, info = lapack.dposv(tangent, residual)
        if info:
            return None, iteration
        f = f - step
        if f.min() <= law.min_stretch or f.max() >= law.max_stretch:
            return None, iteration
        if abs(step).max() < 1e-9 * f.max():  # quadratic: the next step is below rounding
            return (f if _clamp_holds(rho, delta, law, load, f) else None), iteration
    return None, iteration


def _clamp_holds(
    rho: Inertia, delta: float, law: StrainLaw, load: float, f: np.ndarray
) -> bool:
    """Whether the law bears the force at the clamp, the largest one and never a Gauss point."""
    force = load * (rho.g @ f + delta * rho.total)
    return law.force(law.min_stretch) < force < law.force(law.max_stretch)


@dataclass(frozen=True)
class Modes:
    """The lowest modes of one family, unit modal mass, ascending.

    `errors` are those of omega^2: from the order of the mesh, and from rounding.
    """

    squares: np.ndarray  # (k,) omega^2
    unknowns: np.ndarray  # (n, k)
    truncation: np.ndarray  # (k,)
    rounding: np.ndarray  # (k,)


def stretching(
    mesh: Mesh, rho: Inertia, beam: Beam, f: np.ndarray, law: StrainLaw, count: int
) -> Modes:
    """The lowest stretching modes about the stretch f; their unknowns are s = du'."""
    K = np.diag(mesh.weights * straight.stretching_rigidity(f, beam.mu, law))
    return _modes(mesh, K, rho.G, f, count, beam.gamma**2)


def bending(
    mesh: Mesh,
    rho: Inertia,
    beam: Beam,
    f: np.ndarray,
    curvature: Curvature,
    chordwise: bool,
    count: int,
) -> Modes:
    """The lowest bending modes about the stretch f; their unknowns are kappa = theta'.

    The tension N = gamma^2 int_x^1 rho (u + delta) is taken from equilibrium: mu^2 n(f)
    cancels where a slender beam hardly stretches.
    """
    J, w = mesh.J, mesh.weights
    wN = beam.gamma**2 * (rho.G @ f + beam.delta * rho.g)
    K = (J.T * (wN * f)) @ J
    K.flat[:: len(f) + 1] += w * straight.bending_rigidity(f, curvature)
    W = J @ (f[:, None] * J)
    M = (W.T * w) @ W
    if rho.to_mass is not None:
        row = (rho.to_mass * f) @ J
        M += row[:, None] * row
    return _modes(mesh, K, M, f, count, beam.gamma**2 if chordwise else 0.0)


def _modes(
    mesh: Mesh, K: np.ndarray, M: np.ndarray, f: np.ndarray, count: int, softening: float
) -> Modes:
    """Modes of K - softening M. The softening is a multiple of M: it shifts every eigenvalue
    and leaves the modes alone."""
    squares, v = eigen.lowest(K, M, count)
    tail = mesh.tail(v)
    lost = abs((tail * (K @ tail - M @ tail * squares)).sum(axis=0))
    tail = mesh.tail(f)
    lost_stretch = (mesh.weights @ (tail * tail)) / (mesh.weights @ f) ** 2
    truncation = TRUNCATION_FACTOR * (lost + lost_stretch * abs(squares))
    rounding = ROUNDING_FACTOR * EPS * abs(squares) * (1 + abs(squares / squares[0]))
    return Modes(squares - softening, v, truncation, rounding)
