"""Two modes near their least gap, as a 2 x 2 problem in a basis that is constant along the loci.

Its entries are smooth however sharply the loci veer, so few solves suffice to locate the gap. With
half the difference d of its diagonal and the entry c beside it,

    omega_b^2 - omega_a^2 = 2 sqrt(d^2 + |c|^2).
"""

import math
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq

from beamviz.frequency_loci.mode_vectors import ModeVectors

TOUCHING = 1e-8  # relative gap, of omega^2, below which it is rounding error
NEAREST = 6  # most values from which the entries are interpolated
CAPTURED = 0.7  # least share of the reference shapes in the two modes at a value used
SPACING = 1e-3  # of the interval: least distance of the values interpolated from
SAMPLES = 33  # of an interpolated gap, between two of which is the minimum
FLOOR = 1e-12  # replaces an interpolated omega^2 below it, whose root is taken
TINY = float(np.finfo(float).tiny)


class LeastGap(NamedTuple):
    """The least gap of two frequencies, where their loci cross or avoid to."""

    at: float
    frequency: float  # mean of the two
    gap: float  # 0 where the loci touch
    width: float  # |(d, c)| / |(d', c')|; for a constant c there the gap is sqrt(2) times the least
    ranks: tuple[int, int]  # indices of the two among all modes


class Reduced(NamedTuple):
    """The 2 x 2 problem at some values of the parameter, in any order."""

    at: np.ndarray  # (n,)
    entries: np.ndarray  # (n, 3) mean, d and c
    ranks: np.ndarray  # (n, 2) indices of the two modes among all, ascending

    def joined(self, other: "Reduced") -> "Reduced":
        """With the values of another one."""
        return Reduced(*map(np.concatenate, zip(self, other, strict=True)))


def reduce(reference: ModeVectors, vectors: ModeVectors) -> Reduced:
    """The 2 x 2 problem of the two modes of each point most like the two of a reference, at one
    value. ModeVectors whose modes do not contain these are left out."""
    B = reference.products(vectors)
    modes = (abs(B) ** 2).sum(axis=1).argsort(axis=1)[:, :-3:-1]
    U, size, V = np.linalg.svd(np.take_along_axis(B, modes[:, None, :], axis=2))
    Q = U @ V
    squares = np.take_along_axis(vectors.omega_squared, modes, axis=1)
    H = (Q * squares[:, None, :]) @ Q.conj().swapaxes(1, 2)
    mean, d = (H[:, 0, 0] + H[:, 1, 1]) / 2, (H[:, 0, 0] - H[:, 1, 1]) / 2
    entries = np.column_stack((mean, d, H[:, 0, 1]))
    captured = size[:, 1] ** 2 > CAPTURED
    return Reduced(vectors.at[captured], entries[captured], np.sort(modes)[captured])


class TwoModes(NamedTuple):
    """The 2 x 2 problem: its entries as polynomials of x = (p - origin) / scale. Its functions take
    a float or an array; of floats, because brentq calls them with one number at a time."""

    origin: float
    scale: float
    coefficients: list[list[Any]]  # (powers, 3) of mean, d and c, the highest power first
    uncoupled: bool  # c vanishes everywhere

    def entries(self, p: Any) -> tuple[list[Any], list[Any]]:
        """Mean, d and c at p, a float or an array, and their derivatives."""
        x, values, rates = (p - self.origin) / self.scale, [0.0] * 3, [0.0] * 3
        for row in self.coefficients:
            rates = [rate * x + value for rate, value in zip(rates, values, strict=True)]
            values = [value * x + term for value, term in zip(values, row, strict=True)]
        return values, [rate / self.scale for rate in rates]

    def frequencies(self, p: Any) -> tuple[Any, Any]:
        """Mean and difference of the two frequencies at p."""
        (mean, d, c), _ = self.entries(p)
        r = abs(d) if self.uncoupled else np.hypot(abs(d), abs(c))
        low, high = (np.sqrt(np.maximum(mean.real + side * r, FLOOR)) for side in (-1, 1))
        return (low + high) / 2, 2 * r / (low + high)

    def slope(self, p: float) -> float:
        """Twice the derivative of the difference of the two frequencies at p; for uncoupled modes
        d, which is zero at the least gap too."""
        (mean, *pair), (mean_rate, *rates) = self.entries(p)
        if self.uncoupled:
            return pair[0].real
        r = max(math.hypot(*map(abs, pair)), FLOOR)
        r_rate = sum((v.conjugate() * rate).real for v, rate in zip(pair, rates, strict=True)) / r
        low, high = (math.sqrt(max(mean.real + side * r, FLOOR)) for side in (-1, 1))
        return (mean_rate.real + r_rate) / high - (mean_rate.real - r_rate) / low

    def closest(self, low: float, high: float) -> float:
        """The parameter of the least gap: the root of d for uncoupled modes."""
        p = np.linspace(low, high, SAMPLES)
        k = int(self.frequencies(p)[1].argmin())
        low, at, high = p[[max(k - 1, 0), k, min(k + 1, SAMPLES - 1)]].tolist()
        if self.slope(low) * self.slope(high) > 0:
            return at
        return brentq(self.slope, low, high, xtol=1e-14 * (high - low))


def closest(reduced: Reduced, near: float, low: float, high: float) -> LeastGap:
    """The least gap within low .. high. The entries are interpolated through the values nearest to
    `near` that are at least SPACING apart, as the difference of closer ones is rounding error."""
    p = reduced.at
    nearest: list[int] = []
    for k in np.argsort(abs(p - near)).tolist():
        if len(nearest) < NEAREST and (abs(p[k] - p[nearest]) >= SPACING * (high - low)).all():
            nearest.append(k)
    values, scale = reduced.entries[nearest], float(np.ptp(p[nearest]))
    powers = np.vander((p[nearest] - near) / scale)  # the highest first
    coefficients = np.linalg.solve(powers, values).tolist()
    mean, c = values[:, 0], values[:, 2]
    uncoupled = bool((abs(c) <= TOUCHING * abs(mean)).all())
    local = TwoModes(near, scale, coefficients, uncoupled)
    at = local.closest(low, high)
    frequency, gap = map(float, local.frequencies(at))
    touching = gap <= TOUCHING * frequency
    (_, *pair), (_, *rates) = local.entries(at)
    width = math.hypot(*map(abs, pair)) / max(math.hypot(*map(abs, rates)), TINY)
    lower, upper = reduced.ranks[abs(p - at).argmin()].tolist()
    return LeastGap(at, frequency, 0.0 if touching else gap, width, (lower, upper))
