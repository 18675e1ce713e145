"""The lowest modes about a stretched state: families apart, or coupled by Coriolis forces.

Everything here takes one beam or a stack of beams in leading axes.
"""

from typing import NamedTuple

import numpy as np

from beamviz.solver import eigen
from beamviz.solver.eigen import gyroscopic_modes
from beamviz.solver.hp import matrices as hp
from beamviz.solver.hp.matrices import EPS
from beamviz.solver.hp.mesh import Mesh
from beamviz.solver.problem import Problem


class Modes(NamedTuple):
    """The lowest modes of both families in one list.

    Without Coriolis `picks` (..., modes) orders the columns of kappa, then s, laid end to end;
    with it `picks` is None and column k of both, complex, is mode k.
    """

    kappa: np.ndarray  # (..., n, modes) slope of the rotation
    s: np.ndarray  # (..., n, modes) gradient along the beam
    picks: np.ndarray | None
    bending_energy_fraction: np.ndarray  # (..., modes) share of the kinetic energy
    omega_squared: np.ndarray  # (..., modes) omega^2, ascending
    truncation: np.ndarray  # (..., modes) error of omega^2 from the order of the mesh
    rounding: np.ndarray  # (..., modes) error of omega^2 from rounding

    def of(self, k: int) -> "Modes":
        """The modes of beam k of a stack."""
        picks = None if self.picks is None else self.picks[k]
        return Modes(self.kappa[k], self.s[k], picks, *(field[k] for field in self[3:]))


def apart(
    points: Mesh,
    stretch: hp.Stretch,
    softening: float | np.ndarray,
    forms: hp.Forms,
    modes: int,
    problem: Problem,
    shift: float,
) -> Modes:
    """The lowest modes of families that nothing couples.

    The softening is a multiple of M: it shifts every omega^2 and leaves the modes alone, so it
    is taken off here.
    """
    if shift:
        K, M = _both(forms.K, forms.d), _both(forms.M, forms.G)
        omega_squared, v, size = eigen.symmetric_modes(K, M, modes, shift)
    else:
        omega_squared, v, size = eigen.lowest_of_families(*forms[:4], modes)
    scale = abs(omega_squared) + eigen.COMPRESSED
    share = hp.share_lost(hp.lost_to_order(points, forms, v), scale)
    truncation = hp.truncation(points, stretch, scale, share)
    times = size / size[..., :1]  # rounding falls on the high ones
    if shift:  # compression cancels against the rest: what rounds is each unknown by itself
        added = (size - omega_squared)[..., :1]
        size = np.vecmat(hp.diagonal(K) + added * hp.diagonal(M), v**2)
    rounding = hp.rounding(size, times)
    if stretch.margin is not None:
        rounding += hp.rounding_near_end(stretch.margin, scale)
    if problem.softening:
        soft = omega_squared if problem.chordwise else omega_squared[..., 1:, :]
        soft -= softening
    kappa, s = v[..., 0, :, :], v[..., 1, :, :]
    picks, places = _ascending(omega_squared, modes)
    fractions = (picks < omega_squared.shape[-1]).astype(float)
    omega_squared, truncation = omega_squared.take(places), truncation.take(places)
    return Modes(kappa, s, picks, fractions, omega_squared, truncation, rounding.take(places))


def _ascending(omega_squared: np.ndarray, modes: int) -> tuple[np.ndarray, np.ndarray]:
    """Of two families' omega_squared (..., 2, k) the lowest `modes`: places (..., modes) among those of
    the beam, laid end to end, and among those of all beams."""
    stack, both = omega_squared.shape[:-2], 2 * omega_squared.shape[-1]
    picks = omega_squared.reshape(*stack, both).argsort(axis=-1)[..., :modes]
    if not stack:
        return picks, picks
    return picks, picks + both * np.arange(len(picks))[:, None]


def _both(bending: np.ndarray, stretching: np.ndarray) -> np.ndarray:
    """Matrices (..., 2, n, n) of both families; those of stretching may be diagonals (..., n)."""
    both = np.zeros((*bending.shape[:-2], 2, *bending.shape[-2:]))
    both[..., 0, :, :] = bending
    if stretching.ndim == bending.ndim:
        both[..., 1, :, :] = stretching
    else:
        hp.diagonal(both)[..., 1, :] = stretching
    return both


def coupled(
    points: Mesh,
    rho: hp.Inertia,
    stretch: hp.Stretch,
    gamma: float | np.ndarray,
    forms: hp.Forms,
    modes: int,
    softening: bool,
    tolerance: float,
) -> Modes:
    """The lowest modes of both families coupled by Coriolis forces; for a stack of beams gamma is
    (beams, 1).

    With T(omega) = K - omega^2 M + 2 gamma omega S, an error e of a shape z moves omega^2 by
    e'T e 2 omega / |z' T' z|, and |z' T' z| = omega + z' K z / omega.
    """
    speed = np.asarray(gamma)[..., None]
    K = _both(forms.K, forms.d)
    if softening:
        K -= speed[..., None] ** 2 * _both(forms.M, forms.G)
    F = hp.weighted_displacements(points, rho, stretch.f)
    (Kb, Ka), (Fb, Fa) = np.moveaxis(K, -3, 0), np.moveaxis(F, -3, 0)
    most = tolerance / (10 * hp.ROUNDING_FACTOR * EPS)
    omega_squared, s, kappa, times, definite = gyroscopic_modes(Ka, Fa, Kb, Fb, speed, modes, most)
    size = abs(omega_squared) + gamma**2
    v = np.stack((kappa, s), axis=-3)
    v = v.real + v.imag  # a family swings in one phase
    scale = size[..., None, :] + eigen.COMPRESSED
    share = hp.share_lost(hp.lost_to_order(points, forms, v), scale).sum(axis=-2, keepdims=True)
    stored = (v * (K @ v)).sum(axis=(-3, -2))
    share *= (2 * abs(omega_squared) / (abs(omega_squared) + abs(stored)))[..., None, :]
    fractions = ((Fb @ v[..., 0, :, :]) ** 2).sum(axis=-2)
    truncation = hp.truncation(points, stretch, scale, share)[..., 0, :]
    if not definite:  # as above
        size = size + np.vecmat(abs(hp.diagonal(K)), v**2).sum(axis=-2)
    rounding = hp.rounding(size, times)
    if stretch.margin is not None:
        rounding += hp.rounding_near_end(stretch.margin, scale[..., 0, :])
    return Modes(kappa, s, None, fractions, omega_squared, truncation, rounding)
