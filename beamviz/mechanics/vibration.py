"""The lowest modes about a stretched state: families apart, or coupled by Coriolis forces.

Everything here takes one beam or a stack of beams in leading axes.
"""

from typing import NamedTuple

import numpy as np

from beamviz.mechanics import eigen, hp
from beamviz.mechanics.gyroscopic import gyroscopic
from beamviz.mechanics.hp import EPS
from beamviz.mechanics.mesh import Mesh
from beamviz.mechanics.physics import Physics


class Modes(NamedTuple):
    """The lowest modes of both families in one list.

    Without Coriolis `picks` (..., modes) orders the columns of kappa, then s, laid end to end;
    with it `picks` is None and column k of both, complex, is mode k.
    """

    kappa: np.ndarray  # (..., n, modes) slope of the rotation
    s: np.ndarray  # (..., n, modes) gradient along the beam
    picks: np.ndarray | None
    bending_fractions: np.ndarray  # (..., modes) share of the kinetic energy
    squares: np.ndarray  # (..., modes) omega^2, ascending
    truncation: np.ndarray  # (..., modes) error of omega^2 from the order of the mesh
    rounding: np.ndarray  # (..., modes) error of omega^2 from rounding

    def of(self, k: int) -> "Modes":
        """The modes of beam k of a stack."""
        picks = None if self.picks is None else self.picks[k]
        return Modes(self.kappa[k], self.s[k], picks, *(field[k] for field in self[3:]))


def apart(
    points: Mesh,
    f: np.ndarray,
    softening: float | np.ndarray,
    forms: hp.Forms,
    modes: int,
    physics: Physics,
    shift: float,
) -> Modes:
    """The lowest modes of families that nothing couples.

    The softening is a multiple of M: it shifts every omega^2 and leaves the modes alone, so it
    is taken off here.
    """
    if shift:
        K, M = _both(forms.K, forms.d), _both(forms.M, forms.G)
        squares, v, added = eigen.lowest(K, M, modes, shift)
    else:
        squares, v, added = _definite(forms, modes)
    share = hp.share_lost(hp.lost_to_order(points, forms, v), squares)
    size = squares + added  # of what was solved: rounding falls on the high ones
    times = size / size[..., :1]
    if shift:  # compression cancels against the rest: what rounds is each unknown by itself
        size = np.vecmat(hp.diagonal(K) + added * hp.diagonal(M), v**2)
    rounding = hp.rounding(size, times)
    softened = squares.copy()
    if physics.softening:
        softened[..., 0 if physics.chordwise else 1 :, :] -= softening
    both = (*squares.shape[:-2], 2 * modes)
    picks = softened.reshape(both).argsort(axis=-1)[..., :modes]
    places = picks if picks.ndim == 1 else (np.arange(len(picks))[:, None], picks)
    softened, squares, share, rounding = (
        each.reshape(both)[places] for each in (softened, squares, share, rounding)
    )
    truncation = hp.truncation(points, f, squares, share)
    fractions = (picks < modes).astype(float)
    kappa, s = v[..., 0, :, :], v[..., 1, :, :]
    return Modes(kappa, s, picks, fractions, softened, truncation, rounding)


def _both(bending: np.ndarray, stretching: np.ndarray) -> np.ndarray:
    """Matrices (..., 2, n, n) of both families; those of stretching may be diagonals (..., n)."""
    both = np.zeros((*bending.shape[:-2], 2, *bending.shape[-2:]))
    both[..., 0, :, :] = bending
    if stretching.ndim == bending.ndim:
        both[..., 1, :, :] = stretching
    else:
        hp.diagonal(both)[..., 1, :] = stretching
    return both


def _definite(forms: hp.Forms, modes: int) -> eigen.Lowest:
    """Both families' lowest modes where nothing is compressed."""
    squares, v, added = eigen.lowest(forms.K, forms.M, modes)
    stretching, s = eigen.lowest_of_diagonal(forms.d, forms.G, modes)
    return eigen.Lowest(
        np.concatenate((squares[..., None, :], stretching[..., None, :]), axis=-2),
        np.concatenate((v[..., None, :, :], s[..., None, :, :]), axis=-3),
        added if isinstance(added, float) else added[..., None],
    )


def coupled(
    points: Mesh,
    rho: hp.Inertia,
    f: np.ndarray,
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
    F = hp.displacements(points, rho, f)
    (Kb, Ka), (Fb, Fa) = np.moveaxis(K, -3, 0), np.moveaxis(F, -3, 0)
    most = tolerance / (10 * hp.ROUNDING_FACTOR * EPS)
    squares, s, kappa, times, definite = gyroscopic(Ka, Fa, Kb, Fb, speed, modes, most)
    size = abs(squares) + gamma**2
    v = np.stack((kappa, s), axis=-3)
    v = v.real + v.imag  # a family swings in one phase
    share = hp.share_lost(hp.lost_to_order(points, forms, v), size[..., None, :]).sum(axis=-2)
    stored = (v * (K @ v)).sum(axis=(-3, -2))
    share *= 2 * abs(squares) / (abs(squares) + abs(stored))
    fractions = ((Fb @ v[..., 0, :, :]) ** 2).sum(axis=-2)
    truncation = hp.truncation(points, f, size, share)
    if not definite:  # as above
        size = size + np.vecmat(abs(hp.diagonal(K)), v**2).sum(axis=-2)
    rounding = hp.rounding(size, times)
    return Modes(kappa, s, None, fractions, squares, truncation, rounding)
