"""Two modes near their least gap, as a 2 x 2 problem in the basis of their shapes away from it.

Its entries are smooth however sharply the loci veer, so few points suffice to locate the gap. With
half the difference d of its diagonal and the coupling c,

    omega_b^2 - omega_a^2 = 2 sqrt(d^2 + |c|^2).
"""

from typing import NamedTuple

import numpy as np
from numpy.polynomial.polynomial import Polynomial, polyvander
from scipy.optimize import brentq

from beamviz.frequency_loci.mode_vectors import Points

TOUCHING = 1e-8  # relative gap, of omega^2, below which it is rounding
NEAREST = 6  # most points from which the entries are interpolated
CAPTURED = 0.7  # least share of the reference shapes in the two modes of a point used
SPACING = 1e-3  # of the interval: least distance of the points interpolated from
SAMPLES = 33  # of an interpolated gap in each interval around the minimum
MAX_ZOOMS = 12
FLAT = 1e-9  # relative difference of gaps below which it is rounding
FLOOR = 1e-12  # replaces an interpolated omega^2 below it


class Approach(NamedTuple):
    """The least gap of two frequencies."""

    at: float
    frequency: float  # mean of the two
    gap: float  # 0 where the loci touch
    width: float  # |c / d'|: distance at which the gap is sqrt(2) times the least
    modes: tuple[int, int]  # indices of the two among all modes


def reduce(reference: np.ndarray, points: Points) -> np.ndarray:
    """Parameter, mean, d, c and the indices (n, 6) of the two modes most like two shapes (2, d).
    Points whose modes do not contain the shapes are left out."""
    B = reference.conj() @ points.duals.swapaxes(1, 2)
    modes = (abs(B) ** 2).sum(axis=1).argsort(axis=1)[:, :-3:-1]
    U, size, V = np.linalg.svd(np.take_along_axis(B, modes[:, None, :], axis=2))
    Q = U @ V
    squares = np.take_along_axis(points.omega_squared, modes, axis=1)
    H = (Q * squares[:, None, :]) @ Q.conj().swapaxes(1, 2)
    mean, d = (H[:, 0, 0] + H[:, 1, 1]) / 2, (H[:, 0, 0] - H[:, 1, 1]) / 2
    entries = np.column_stack((points.at, mean, d, H[:, 0, 1], np.sort(modes)))
    return entries[size[:, 1] ** 2 > CAPTURED]


class TwoModes(NamedTuple):
    """The 2 x 2 problem: its entries as functions of the parameter."""

    mean: Polynomial
    d: Polynomial
    c: Polynomial
    uncoupled: bool  # c vanishes everywhere

    def frequencies(self, p: float | np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mean and difference of the two frequencies at p."""
        d: np.ndarray = self.d(p)
        c: np.ndarray = np.zeros_like(d) if self.uncoupled else abs(self.c(p))
        r = np.hypot(d, c)
        low, high = (np.sqrt(np.maximum(self.mean(p) + side * r, FLOOR)) for side in (-1, 1))
        return (low + high) / 2, 2 * r / (low + high)

    def closest(self, low: float, high: float) -> float:
        """The parameter of the least gap: the root of d for uncoupled modes."""
        if self.uncoupled and self.d(low) * self.d(high) <= 0:
            return brentq(self.d, low, high, xtol=1e-14 * (high - low))
        for _ in range(MAX_ZOOMS):
            p = np.linspace(low, high, SAMPLES)
            gap = self.frequencies(p)[1]
            k = int(gap.argmin())
            low, high = p[max(k - 1, 0)], p[min(k + 1, SAMPLES - 1)]
            if gap.max() - gap[k] <= FLAT * gap[k]:
                break
        return float(p[k])


def closest(entries: np.ndarray, near: float, low: float, high: float) -> Approach:
    """The least gap by the `entries` (n, 6) from `reduce`. These are interpolated through the
    points nearest to `near` that are at least SPACING apart, as the difference of closer ones is
    rounding error."""
    p = entries[:, 0].real
    nearest: list[int] = []
    for k in np.argsort(abs(p - near)).tolist():
        if len(nearest) < NEAREST and (abs(p[k] - p[nearest]) >= SPACING * (high - low)).all():
            nearest.append(k)
    values, scale = entries[nearest, 1:4], np.ptp(p[nearest])
    powers = polyvander((p[nearest] - near) / scale, len(nearest) - 1)
    coefficients, domain = np.linalg.solve(powers, values).T, (near - scale, near + scale)
    mean, d = (Polynomial(one.real, domain) for one in coefficients[:2])
    c = Polynomial(coefficients[2], domain)
    uncoupled = bool((abs(values[:, 2]) <= TOUCHING * abs(values[:, 0])).all())
    local = TwoModes(mean, d, c, uncoupled)
    at = local.closest(low, high)
    frequency, gap = map(float, local.frequencies(at))
    touching = gap <= TOUCHING * frequency
    width = float(abs(local.c(at)) / max(abs(local.d.deriv()(at)), np.finfo(float).tiny))
    i, j = entries[abs(p - at).argmin(), -2:].real.astype(int).tolist()
    return Approach(at, frequency, 0.0 if touching else gap, width, (i, j))
