"""Two modes near their meeting as a 2 x 2 problem in the shapes they have beside it.

Its entries are smooth however sharply the loci veer, so few points locate the least gap. With
half the difference d of its diagonal and its coupling c,

    omega_b^2 - omega_a^2 = 2 sqrt(d^2 + |c|^2).
"""

from collections.abc import Generator, Sequence
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.polynomial import polynomial
from scipy.optimize import brentq

from beamviz.study.tracking import Points, SolveAt

TOUCHING = 1e-8  # of omega^2: a smaller gap is rounding
NEAREST = 6  # points the entries are interpolated from
CAPTURED = 0.5  # least share of the two shapes in a point that is used
MAX_SOLVES = 8
SETTLED = 1e-3  # of the width of a meeting: a smaller shift of its place is not solved again
SAMPLES = 33

Result = TypeVar("Result")


class Place(NamedTuple):
    """Where two frequencies come closest."""

    at: float
    frequency: float  # mean of the two
    gap: float  # 0 where the loci touch
    width: float  # |c / d'|: at this distance the gap is sqrt(2) times the least


Search = Generator[np.ndarray, Points, Result]  # asks for points at some values


def together(searches: Sequence[Search[Result]], solve_at: SolveAt) -> list[Result]:
    """The results of several searches; what they ask for is solved for all of them at once."""
    results: dict[int, Result] = {}
    wanted: dict[int, np.ndarray] = {}

    def advance(k: int, found: Points | None) -> None:
        try:
            wanted[k] = searches[k].send(found)
        except StopIteration as end:
            results[k] = end.value

    for k in range(len(searches)):
        advance(k, None)
    while wanted:
        found = solve_at(np.unique(np.concatenate(list(wanted.values()))))
        asked, wanted = wanted, {}
        for k, values in asked.items():
            advance(k, found.take(np.isin(found.at, values)))
    return [results[k] for k in range(len(searches))]


def least_gap(
    points: Points, reference: np.ndarray, low: float, high: float
) -> Search[Place | None]:
    """The least gap within low .. high of the two modes that have the shapes `reference` (2, d).

    points: some around it. None where the gap is least at an end.
    """
    entries, place = _entries(reference, points), (low + high) / 2
    for _ in range(MAX_SOLVES):
        local = _interpolated(entries, place)
        previous, place = place, local.closest(low, high)
        width = local.width(place)
        if abs(place - previous) <= max(SETTLED * width, 1e-6 * (high - low)):
            break
        more = yield np.array([place])
        if not len(more.at):
            break
        entries = np.vstack((entries, _entries(reference, more)))
    if place in (low, high):
        return None
    frequency, gap = local.frequencies(place)
    touching = local.touching or gap <= TOUCHING * frequency
    return Place(place, float(frequency), 0.0 if touching else float(gap), width)


class Local(NamedTuple):
    """The entries as polynomials in (p - centre) / scale."""

    centre: float
    scale: float
    coefficients: np.ndarray  # (order, 3): mean, d, c
    touching: bool  # c vanishes everywhere

    def entries(self, p: float | np.ndarray) -> np.ndarray:
        """Mean, d and c at p: (3, ...)."""
        return polynomial.polyval((p - self.centre) / self.scale, self.coefficients)

    def frequencies(self, p: float | np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mean and difference of the two frequencies at p."""
        mean, d, c = self.entries(p)
        r = np.hypot(abs(d), 0.0 if self.touching else abs(c))
        low, high = (np.sqrt(np.maximum(mean.real + side * r, 0.0)) for side in (-1, 1))
        return (low + high) / 2, 2 * r / np.maximum(low + high, np.finfo(float).tiny)

    def closest(self, low: float, high: float) -> float:
        """Where the two frequencies come closest: at the root of d if nothing couples them."""
        if self.touching and self.difference(low) * self.difference(high) <= 0:
            return brentq(self.difference, low, high, xtol=1e-14 * (high - low))
        for _ in range(7):
            p = np.linspace(low, high, SAMPLES)
            k = int(self.frequencies(p)[1].argmin())
            low, high = p[max(k - 1, 0)], p[min(k + 1, SAMPLES - 1)]
        return float(p[k])

    def difference(self, p: float) -> float:
        """d at p."""
        return float(self.entries(p)[1].real)

    def width(self, p: float) -> float:
        """|c / d'| at p."""
        slope = polynomial.polyder(self.coefficients[:, 1].real)
        rate = polynomial.polyval((p - self.centre) / self.scale, slope) / self.scale
        return float(abs(self.entries(p)[2]) / max(abs(rate), np.finfo(float).tiny))


def _interpolated(entries: np.ndarray, place: float) -> Local:
    """The polynomials through the points nearest to a place."""
    p = entries[:, 0].real
    nearest = np.argsort(abs(p - place))[:NEAREST]
    p, values = p[nearest], entries[nearest, 1:]
    scale = np.ptp(p)
    coefficients = np.linalg.solve(polynomial.polyvander((p - place) / scale, len(p) - 1), values)
    touching = bool((abs(values[:, 2]) <= TOUCHING * abs(values[:, 0])).all())
    return Local(place, scale, coefficients, touching)


def _entries(reference: np.ndarray, points: Points) -> np.ndarray:
    """Parameter, mean, d and c (n, 4) of the two modes of each point nearest to two shapes.

    Points in which the shapes are not found again are left out.
    """
    B = reference.conj() @ points.duals.swapaxes(1, 2)
    picks = (abs(B) ** 2).sum(axis=1).argsort(axis=1)[:, :-3:-1]
    U, size, V = np.linalg.svd(np.take_along_axis(B, picks[:, None, :], axis=2))
    Q = U @ V
    squares = np.take_along_axis(points.squares, picks, axis=1)
    H = (Q * squares[:, None, :]) @ Q.conj().swapaxes(1, 2)
    mean, d = (H[:, 0, 0] + H[:, 1, 1]) / 2, (H[:, 0, 0] - H[:, 1, 1]) / 2
    entries = np.column_stack((points.at, mean, d, H[:, 0, 1]))
    return entries[size[:, 1] ** 2 > CAPTURED]
