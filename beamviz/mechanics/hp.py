"""The default discretisation: a straight beam in terms of what carries its energy.

The unknowns sit at Gauss points of a few elements of high order: the gradient s = du' for
stretching, the slope of the rotation kappa = theta' for bending. Displacements are integrals,
u = J s and w = J (f J kappa), so the clamp is exact and nothing must match between elements:
the jump of the stretch at a concentrated mass costs no accuracy. Convergence is exponential
in the order.
"""

from typing import NamedTuple

import numpy as np

from beamviz.beam import Beam
from beamviz.mechanics import eigen, straight
from beamviz.mechanics.mesh import Mesh
from beamviz.mechanics.strain import Curvature, StrainLaw

EPS = float(np.finfo(float).eps)
# Factors on the two estimates of error, set on random beams over all accepted scenes.
TRUNCATION_FACTOR = 12.0
ROUNDING_FACTOR = 30.0


class Numbers(NamedTuple):
    """The numbers of many beams at once, each (beams, 1); a Beam serves for one."""

    alpha: np.ndarray
    beta: np.ndarray
    gamma: np.ndarray
    delta: np.ndarray
    mu: np.ndarray


class Inertia(NamedTuple):
    """The line density rho = 1 + alpha Dirac(x - beta) in terms of a gradient on a mesh."""

    G: np.ndarray  # (..., n, n) mass matrix J' rho J
    G1: np.ndarray  # (..., n) G applied to the stretch of a beam at rest
    g: np.ndarray  # (..., n) static moment J' rho 1
    to_mass: np.ndarray | None  # (..., n) sqrt(alpha) times the integral from clamp to mass
    total: float | np.ndarray  # mass that pulls at the clamp


def inertia(mesh: Mesh, beam: Beam | Numbers) -> Inertia:
    """The inertia of a beam whose mass sits on a break of the mesh."""
    alpha, beta = beam.alpha, beam.beta
    if isinstance(beam, Beam) and not (alpha and beta):
        return Inertia(mesh.G, mesh.G1, mesh.g, None, 1.0)
    to_mass = np.where(mesh.points < beta, mesh.weights, 0.0)
    root = alpha**0.5 * to_mass
    G = mesh.G + root[..., :, None] * root[..., None, :]
    G1, g = mesh.G1 + (alpha * beta) * to_mass, mesh.g + alpha * to_mass
    return Inertia(G, G1, g, root, 1.0 + alpha)


def diagonal(A: np.ndarray) -> np.ndarray:
    """The diagonals of contiguous matrices (..., n, n), as a view (..., n) to write to."""
    return A.reshape(*A.shape[:-2], -1)[..., :: A.shape[-1] + 1]


class Forms(NamedTuple):
    """Stiffness (without softening) and displacements of one family on a mesh.

    M = F' F: the rows of F are displacements at the mesh points, and at the concentrated mass,
    times the root of the mass there.
    """

    K: np.ndarray  # (..., n, n) = diag(local) + J' diag(spread) J
    F: np.ndarray  # (..., m, n)
    local: np.ndarray  # (..., n) rigidity against the unknown itself
    spread: np.ndarray | None  # (..., n) rigidity against its integral: tension, in bending


def stretching(
    mesh: Mesh, rho: Inertia, beam: Beam | Numbers, f: np.ndarray, law: StrainLaw
) -> Forms:
    """Stretching about the stretch f (..., n), in terms of s = du'."""
    local = mesh.weights * straight.stretching_rigidity(f, beam.mu, law)
    K = np.zeros(f.shape + f.shape[-1:])
    diagonal(K)[:] = local
    return Forms(K, _with_mass(mesh.rooted, rho.to_mass), local, None)


def bending(
    mesh: Mesh,
    rho: Inertia,
    beam: Beam | Numbers,
    f: np.ndarray,
    curvature: Curvature,
    stiffening: bool = True,
) -> Forms:
    """Bending about the stretch f (..., n), in terms of kappa = theta'.

    The tension N = gamma^2 int_x^1 rho (u + delta) is taken from equilibrium: mu^2 n(f)
    cancels where a slender beam hardly stretches.
    """
    J = mesh.J
    load = beam.gamma**2 if stiffening else 0.0
    spread = load * (np.matvec(rho.G, f) + beam.delta * rho.g) * f
    local = mesh.weights * straight.bending_rigidity(f, curvature)
    K = (J.mT * spread[..., None, :]) @ J
    diagonal(K)[:] += local
    to_mass = None if rho.to_mass is None else np.vecmat(rho.to_mass * f, J)
    return Forms(K, _with_mass(mesh.rooted @ (f[..., None] * J), to_mass), local, spread)


def _with_mass(F: np.ndarray, to_mass: np.ndarray | None) -> np.ndarray:
    """F with the row of the concentrated mass below it."""
    if to_mass is None:
        return F
    rows = to_mass[..., None, :]
    if rows.ndim > F.ndim:
        F = np.broadcast_to(F, rows.shape[:-2] + F.shape)
    return np.concatenate((F, rows), axis=-2)


def energy(K: np.ndarray, v: np.ndarray) -> np.ndarray:
    """v' K v of each column of v (n, k): (k,)."""
    return (v.conj() * (K @ v)).sum(axis=-2).real


def lost_to_order(mesh: Mesh, forms: Forms, squares: np.ndarray, v: np.ndarray) -> np.ndarray:
    """The energy (..., k) that modes v (..., n, k) have in the two highest polynomials of each
    element, compression counted as tension: it bounds what a higher order would change.

    By chance it may all but vanish: no mode of a family is taken to lose a smaller share of its
    omega^2 (without softening, ascending) than the ones below it.
    """
    tail = mesh.T @ v
    lost = (forms.local[..., None] * abs(tail) ** 2).sum(axis=-2)
    if forms.spread is not None:
        lost += (abs(forms.spread)[..., None] * abs(mesh.J @ tail) ** 2).sum(axis=-2)
    size = abs(squares) + eigen.COMPRESSED
    return np.maximum.accumulate(lost / size, axis=-1) * size


def errors(
    mesh: Mesh, f: np.ndarray, squares: np.ndarray, lost: np.ndarray, first: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Estimated errors (..., k) of omega^2 (without softening): from the order, and from rounding,
    which falls on each mode as it is larger than the `first` (..., 1) of its eigenproblem."""
    tail = np.matvec(mesh.T, f)
    lost_stretch = ((tail * tail) @ mesh.weights) / (f @ mesh.weights) ** 2
    size = abs(squares)
    truncation = TRUNCATION_FACTOR * (lost + 4 * lost_stretch[..., None] * size)
    rounding = ROUNDING_FACTOR * EPS * size * (1 + size / first)
    return truncation, rounding
