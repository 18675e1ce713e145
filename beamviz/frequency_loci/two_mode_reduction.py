"""Two modes near their meeting as a 2 x 2 problem in the shapes they have beside it.

Its entries are smooth however sharply the loci veer, so few points locate the least gap. With
half the difference d of its diagonal and its coupling c,

    omega_b^2 - omega_a^2 = 2 sqrt(d^2 + |c|^2).
"""

import math
from collections.abc import Callable, Generator, Sequence
from functools import partial
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.polynomial import polynomial
from scipy.optimize import brentq

from beamviz.frequency_loci.tracking import Points, SolveAt

TOUCHING = 1e-8  # of omega^2: a smaller gap is rounding
NEAREST = 6  # points the entries are interpolated from
CAPTURED = 0.7  # least share of the two shapes in a point that is used
MAX_SOLVES = 8
SETTLED = 1e-4  # of the width of a meeting: a smaller shift of its place is not solved again
FINEST = 1e-6  # of the stretch it was seen in: nor is a smaller shift than this
ROUGH = 1e-3  # of the stretch: a shift that no longer shrinks below this is rounding
SPACING = 1e-3  # of the stretch: least distance of the points interpolated from
SAME = 1e-3  # of a gap: a smaller change by the last solve is the last one
SAMPLES = 33  # of an interpolated gap, again and again around the least
MAX_ZOOMS = 12
FLAT = 1e-9  # of the gap: a difference that is left to rounding
FLOOR = 1e-12  # omega^2, where an interpolation falls below 0

Result = TypeVar("Result")


class Place(NamedTuple):
    """Where two frequencies come closest."""

    at: float
    frequency: float  # mean of the two
    gap: float  # 0 where the loci touch
    width: float  # |c / d'|: at this distance the gap is sqrt(2) times the least
    ranks: tuple[int, int]  # their places among all modes


Search = Generator[np.ndarray, Points, Result]  # asks for points at some values


def together(searches: Sequence[Search[Result]], solve_at: SolveAt) -> list[Result]:
    """The results of several searches; what they ask for is solved for all of them at once."""
    results: dict[int, Result] = {}
    wanted: dict[int, np.ndarray] = {}

    def advance(k: int, step: Callable[[], np.ndarray]) -> None:
        try:
            wanted[k] = step()
        except StopIteration as end:
            results[k] = end.value

    for k, search in enumerate(searches):
        advance(k, partial(next, search))
    while wanted:
        found = solve_at(np.unique(np.concatenate(list(wanted.values()))))
        asked, wanted = wanted, {}
        for k, values in asked.items():
            advance(k, partial(searches[k].send, found.take(np.isin(found.at, values))))
    return [results[k] for k in range(len(searches))]


def least_gap(
    points: Points, reference: np.ndarray, low: float, high: float
) -> Search[Place | None]:
    """The least gap within low .. high of the two modes that have the shapes `reference` (2, d).

    points: some around it. None where the gap is least at an end.
    """
    entries, room = _entries(reference, points), high - low
    place, shift = Place((low + high) / 2, 0.0, math.inf, 0.0, (0, 1)), math.inf
    for _ in range(MAX_SOLVES):
        if len(entries) < 2:
            return None
        previous, place = place, _closest(entries, place.at, low, high)
        last, shift = shift, abs(place.at - previous.at)
        fine = max(SETTLED * min(place.width, room), FINEST * room)
        settled = abs(place.gap - previous.gap) <= SAME * place.gap
        if settled and (shift <= fine or last / 2 < shift < ROUGH * room):
            break
        value = place.at
        if value in entries[:, 0]:  # at an end, or nothing new to be had there
            value = _widest(entries[:, 0].real, low, high)
        more = yield np.array([value])
        if not len(more.at):
            break
        entries = np.vstack((entries, _entries(reference, more)))
    return None if place.gap and place.at in (low, high) else place


def _closest(entries: np.ndarray, near: float, low: float, high: float) -> Place:
    """Where the two come closest by what is known so far."""
    local = _interpolated(entries, near, SPACING * (high - low))
    at = local.closest(low, high)
    frequency, gap = map(float, local.frequencies(at))
    touch = local.touching or gap <= TOUCHING * frequency
    ranks = entries[abs(entries[:, 0] - at).argmin(), -2:].real.astype(int)
    return Place(at, frequency, 0.0 if touch else gap, local.width(at), tuple(ranks.tolist()))


def _widest(p: np.ndarray, low: float, high: float) -> float:
    """The middle of the widest interval between points within low .. high."""
    p = np.unique(np.concatenate(([low, high], p[(p > low) & (p < high)])))
    k = int(np.diff(p).argmax())
    return float(p[k] + p[k + 1]) / 2


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
        low, high = (np.sqrt(np.maximum(mean.real + side * r, FLOOR)) for side in (-1, 1))
        return (low + high) / 2, 2 * r / (low + high)

    def closest(self, low: float, high: float) -> float:
        """Where the two frequencies come closest: at the root of d if nothing couples them."""
        if self.touching and self.difference(low) * self.difference(high) <= 0:
            return brentq(self.difference, low, high, xtol=1e-14 * (high - low))
        for _ in range(MAX_ZOOMS):
            p = np.linspace(low, high, SAMPLES)
            gap = self.frequencies(p)[1]
            k = int(gap.argmin())
            low, high = p[max(k - 1, 0)], p[min(k + 1, SAMPLES - 1)]
            if gap.max() - gap[k] <= FLAT * gap[k]:
                break
        return float(p[k])

    def difference(self, p: float) -> float:
        """d at p."""
        return float(self.entries(p)[1].real)

    def width(self, p: float) -> float:
        """|c / d'| at p."""
        slope = polynomial.polyder(self.coefficients[:, 1].real)
        rate = polynomial.polyval((p - self.centre) / self.scale, slope) / self.scale
        return float(abs(self.entries(p)[2]) / max(abs(rate), np.finfo(float).tiny))


def _interpolated(entries: np.ndarray, place: float, spacing: float) -> Local:
    """The polynomials through the points nearest to a place, of those closer together the one.

    Points in a cluster would make polynomials of what the solver rounds.
    """
    p = entries[:, 0].real
    nearest: list[int] = []
    for k in np.argsort(abs(p - place)).tolist():
        if len(nearest) < NEAREST and all(abs(p[k] - p[j]) >= spacing for j in nearest):
            nearest.append(k)
    p, values = p[nearest], entries[nearest, 1:4]
    scale = np.ptp(p)
    coefficients = np.linalg.solve(polynomial.polyvander((p - place) / scale, len(p) - 1), values)
    touching = bool((abs(values[:, 2]) <= TOUCHING * abs(values[:, 0])).all())
    return Local(place, scale, coefficients, touching)


def _entries(reference: np.ndarray, points: Points) -> np.ndarray:
    """Parameter, mean, d, c and the places (n, 6) of the two modes nearest to two shapes.

    Points in which the shapes are not found again are left out.
    """
    B = reference.conj() @ points.duals.swapaxes(1, 2)
    picks = (abs(B) ** 2).sum(axis=1).argsort(axis=1)[:, :-3:-1]
    U, size, V = np.linalg.svd(np.take_along_axis(B, picks[:, None, :], axis=2))
    Q = U @ V
    squares = np.take_along_axis(points.squares, picks, axis=1)
    H = (Q * squares[:, None, :]) @ Q.conj().swapaxes(1, 2)
    mean, d = (H[:, 0, 0] + H[:, 1, 1]) / 2, (H[:, 0, 0] - H[:, 1, 1]) / 2
    entries = np.column_stack((points.at, mean, d, H[:, 0, 1], np.sort(picks)))
    return entries[size[:, 1] ** 2 > CAPTURED]
