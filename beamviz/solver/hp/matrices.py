"""The default discretisation: a straight beam in terms of what carries its energy.

The unknowns sit at Gauss points of a few elements of high order: the gradient s = du' for
stretching, the slope of the rotation kappa = theta' for bending. Displacements are integrals,
u = J s and w = J (f J kappa), so the clamp is exact and nothing must match between elements:
the jump of the stretch at a concentrated mass costs no accuracy. Convergence is exponential
in the order.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from beamviz.beam import Beam
from beamviz.solver import constitutive
from beamviz.solver.constitutive import Curvature, StrainLaw
from beamviz.solver.hp.mesh import Mesh

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
    to_mass: np.ndarray | None  # (..., n) integrates from the clamp to the mass
    alpha: float | np.ndarray  # (..., 1)
    total: float | np.ndarray  # mass that pulls at the clamp


def inertia(mesh: Mesh, beam: Beam | Numbers) -> Inertia:
    """The inertia of a beam, or of many, whose mass sits on a break of the mesh."""
    if not isinstance(beam, Beam):
        return _with_mass(mesh, beam.alpha, beam.beta)
    if beam.alpha and beam.beta:
        return _with_one_mass(mesh, beam.alpha, beam.beta)
    return Inertia(mesh.G, mesh.G1, mesh.g, None, 0.0, 1.0)


def _with_mass(mesh: Mesh, alpha: float | np.ndarray, beta: float | np.ndarray) -> Inertia:
    """A concentrated mass added to the inertia of the mesh."""
    to_mass = np.where(mesh.points < beta, mesh.weights, 0.0)
    carried = alpha * to_mass
    G = mesh.G + carried[..., None] * to_mass[..., None, :]
    total = 1.0 + alpha * (beta > 0)
    return Inertia(G, mesh.G1 + beta * carried, mesh.g + carried, to_mass, alpha, total)


@lru_cache(maxsize=64)
def _with_one_mass(mesh: Mesh, alpha: float, beta: float) -> Inertia:
    """`_with_mass` of one beam: a slider of anything else leaves the mass as it is."""
    rho = _with_mass(mesh, alpha, beta)
    for array in (rho.G, rho.G1, rho.g, rho.to_mass):
        assert array is not None
        array.setflags(write=False)
    return rho


class Stretch(NamedTuple):
    """An equilibrium: the stretch f at the mesh points, the Newton iterations it took, how far f
    may be off, relative, and its margin: 1 at rest, 0 at the end, None where there is no end."""

    f: np.ndarray  # (..., n)
    iterations: int
    off: float
    margin: float | np.ndarray | None = None  # (...)


def diagonal(A: np.ndarray) -> np.ndarray:
    """The diagonals of contiguous matrices (..., n, n), as a view (..., n) to write to."""
    return A.reshape(*A.shape[:-2], -1)[..., :: A.shape[-1] + 1]


class Forms(NamedTuple):
    """Stiffness (without softening) and mass of the two families.

    Bending: K = IJ' diag(rigidity) IJ and M. Stretching: diag(d) and G, the mass of a gradient.
    """

    K: np.ndarray  # (..., n, n)
    M: np.ndarray  # (..., n, n)
    d: np.ndarray  # (..., n)
    G: np.ndarray  # (..., n, n)
    rigidity: np.ndarray  # (..., 2, 2 n) against the unknown, then against its integral: tension


def forms(
    mesh: Mesh,
    rho: Inertia,
    beam: Beam | Numbers,
    f: np.ndarray,
    law: StrainLaw,
    curvature: Curvature,
    stiffening: bool = True,
) -> Forms:
    """Vibration about the stretch f (..., n), in terms of kappa = theta' and s = du'.

    The tension N = gamma^2 int_x^1 rho (u + delta) is taken from equilibrium: mu^2 n(f)
    cancels where a slender beam hardly stretches.
    """
    w, n = mesh.weights, f.shape[-1]
    bent = w * constitutive.bending_stiffness(f, curvature)
    d = w * constitutive.axial_stiffness(f, beam.mu, law)
    across = f[..., None] * mesh.J  # kappa -> w' = f theta
    rigidity = np.zeros((*f.shape[:-1], 2, 2 * n))
    rigidity[..., 0, :n], rigidity[..., 1, :n] = bent, d
    if stiffening:
        tension = beam.gamma**2 * (np.matvec(rho.G, f) + beam.delta * rho.g)
        rigidity[..., 0, n:] = tension * f
        K = across.mT @ (tension[..., None] * mesh.J)
    else:
        K = np.zeros_like(across)
    on_diagonal = diagonal(K)
    on_diagonal += bent
    return Forms(K, across.mT @ (rho.G @ across), d, rho.G, rigidity)


def weighted_displacements(mesh: Mesh, rho: Inertia, f: np.ndarray) -> np.ndarray:
    """F (..., 2, m, n), bending first, with M = F' F: displacements at the mesh points, and at the
    concentrated mass, times the root of the mass there."""
    across = f[..., None] * mesh.J
    rows = [np.stack(np.broadcast_arrays(mesh.rooted @ across, mesh.rooted), axis=-3)]
    if rho.to_mass is not None:
        to_mass = (rho.alpha**0.5 * rho.to_mass)[..., None, :]
        rows.append(np.stack(np.broadcast_arrays(to_mass @ across, to_mass), axis=-3))
    return np.concatenate(rows, axis=-2)


def lost_to_order(mesh: Mesh, forms: Forms, v: np.ndarray) -> np.ndarray:
    """The energy (..., 2, k) that shapes v (..., 2, n, k) of the two families have in the two
    highest polynomials of each element, compression counted as tension: it bounds what a higher
    order would change."""
    left = v.mT @ mesh.IJT[..., None, :, :].mT
    return np.matvec(left * left, abs(forms.rigidity))


def share_lost(lost: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """The energies lost (..., k) of modes in ascending order, as shares of the `scale` of their
    omega^2 (without softening). None loses a smaller one than those below it: by chance an
    estimate may all but vanish."""
    return np.maximum.accumulate(lost / scale, axis=-1)


def truncation(mesh: Mesh, stretch: Stretch, scale: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Estimated errors (..., families, k) of omega^2 from the order of the mesh, and from a stretch
    that is off.

    A large stretch falls off all but singularly: more is lost then than what is seen to be. Near
    the end of an equilibrium a load that is off moves the stretch by 1 / margin times as much, and
    that the least omega^2, which falls to zero with the margin, as many times again.
    """
    f = stretch.f
    tail = np.matvec(mesh.tails, f)
    lost = 4 * np.vecdot(tail, tail) / np.vecdot(mesh.weights, f) ** 2 + stretch.off / 2
    if stretch.margin is not None:
        lost = lost / stretch.margin**2
    factor = TRUNCATION_FACTOR * np.maximum(f[..., 0], 1.0)
    return ((share.T + lost) * (scale.T * factor)).T  # the stack comes last, where f is a number


def rounding_near_end(margin: float | np.ndarray, scale: np.ndarray) -> np.ndarray:
    """Estimated errors (..., families, k) of omega^2 from a stretch that rounding moves the more,
    the nearer the end of its equilibrium is."""
    return (scale.T * (ROUNDING_FACTOR * EPS * (1 / margin - 1))).T


def rounding(size: np.ndarray, times: np.ndarray | float) -> np.ndarray:
    """Estimated errors (..., k) of omega^2 from rounding a number of this `size` so many times."""
    return size * (ROUNDING_FACTOR * EPS * (1 + times))
