"""A straight beam needs half of everything: the tangent splits into stretching and bending.

At r = (u(x), 0) with f = u' the tangent of the paper (eq. 44) is exactly
    stretching: int mu^2 n'(f) du'^2             - gamma^2 int rho du^2
    bending:    int (f w'' - f' w')^2 / f^(2c) + mu^2 n(f) / f w'^2  [- gamma^2 int rho w^2],
the last term in the chordwise plane only. Written with the angle theta = w'/f, which stays
continuous where a concentrated mass makes f jump, bending becomes
    int f^(4 - 2c) theta'^2 + N f theta^2,   N = mu^2 n(f),
with c = 3 for the spatial curvature and c = 2 for the material one. These coefficients are
what every method for straight beams shares.
"""

import numpy as np

from beamviz.beam import Beam
from beamviz.errors import NoEquilibrium
from beamviz.solver.constitutive import Curvature, StrainLaw


def stretching_rigidity(f: np.ndarray, mu: float | np.ndarray, law: StrainLaw) -> np.ndarray:
    """mu^2 n'(f), the coefficient of du'^2."""
    return mu**2 * law.stiffness(f)


def bending_rigidity(f: np.ndarray, curvature: Curvature) -> np.ndarray:
    """f^(4 - 2c), the coefficient of theta'^2."""
    return f ** (4 - 2 * curvature.power)


def tension_rigidity(f: np.ndarray, mu: float | np.ndarray, law: StrainLaw) -> np.ndarray:
    """N f, the coefficient of theta^2."""
    return mu**2 * law.force(f) * f


def rigid_tension(beam: Beam, x: np.ndarray) -> np.ndarray:
    """N(x) / EI L^2 of a beam that does not stretch; at the mass itself, the tension inboard."""
    distributed = (1 - x) * ((1 + x) / 2 + beam.delta)
    carried = np.where(x <= beam.beta, beam.alpha * (beam.beta + beam.delta), 0.0)
    return beam.gamma**2 * (distributed + carried)


def no_equilibrium(beam: Beam, limit: float, law: StrainLaw) -> NoEquilibrium:
    """The error of a beam whose gamma lies beyond the `limit` up to which a state exists."""
    return NoEquilibrium(
        f"gamma = {beam.gamma:.6g}: no equilibrium beyond gamma = {limit:.6g}"
        f" ({law.name} strain, alpha = {beam.alpha:g}, beta = {beam.beta:g},"
        f" delta = {beam.delta:g}, mu = {beam.mu:g})",
        limit,
    )
