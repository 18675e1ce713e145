"""Roots of functions of the modes along a path, located by solves.

A function vanishes where something happens: the difference of two omega^2 at a crossing,
omega^2 - (k gamma)^2 at a resonance. It is sampled at the values of a grid; between two samples of
different sign lies a root, and beside a minimum of its absolute value there may be two. All are
refined together, so that each iteration is one batch of solves.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import elementwise

REACH = 2.0  # times the fall of a parabola through three samples: distance examined for two roots
NEAREST = 5  # most values from which a root is interpolated
LAST_STEP = 1e-4  # relative to the first bracket: the next step would be its square, or smaller
SMALL = 1e-3  # value of the function before the last step, relative to that at the ends
MAX_STEPS = 60  # bisection alone would need 53 to the last digit

# Values of the parameter (k,) and channels (k,) -> values (k,) of the functions; nan where unknown.
Function = Callable[[NDArray, NDArray], NDArray]


class Roots(NamedTuple):
    """Roots of some functions, by ascending value of the parameter."""

    at: NDArray  # (roots,)
    channel: NDArray  # (roots,) number of the function
    rises: NDArray  # (roots,) whether it rises there
    unlocated: list["Bracket"]  # with roots that were not located


def find_roots(at: NDArray, samples: NDArray, function: Function) -> Roots:
    """The roots of functions known at ascending values (n,), samples (n, channels).

    A sample that is zero belongs to the interval before it; a root at the first value is none.
    """
    sides = np.sign(samples)
    for i in np.flatnonzero((sides == 0).any(axis=1)).tolist():
        if i:
            sides[i] = np.where(sides[i] == 0, sides[i - 1], sides[i])
    brackets = []
    for i, channel in np.argwhere(sides[:-1] * sides[1:] < 0).tolist():
        near = slice(max(i - 2, 0), i + 4)
        brackets.append(Bracket(channel, at[near], samples[near, channel], at[i], at[i + 1]))
    brackets += _brackets_of_two(at, samples, sides, function)
    _locate(brackets, function)
    located = sorted(
        (bracket for bracket in brackets if bracket.is_located), key=lambda bracket: bracket.root
    )
    return Roots(
        np.array([bracket.root for bracket in located]),
        np.array([bracket.channel for bracket in located], int),
        np.array([bracket.rises for bracket in located], bool),
        [bracket for bracket in brackets if not bracket.is_located],
    )


class Bracket:
    """An interval low .. high with one root of a function, known with values y (n,) at some x (n,)
    in and around it. It is lost where the function is not known at an estimated root."""

    def __init__(self, channel: int, x: NDArray, y: NDArray, low: float, high: float):
        self.channel = channel
        self.x, self.y = list(x[np.isfinite(y)]), list(y[np.isfinite(y)])
        self.low, self.high = float(low), float(high)
        self.rises = bool(self.y[self.x.index(high)] > 0)
        self.last_step = LAST_STEP * (self.high - self.low)
        self.small = SMALL * max(abs(self.y[self.x.index(end)]) for end in (low, high))
        self.is_located = self.is_lost = False
        self.root = self._estimate()

    def _estimate(self) -> float:
        """Where the function, inverted, is interpolated to vanish; the middle of the bracket where
        that lies outside it."""
        order = np.argsort(np.abs(self.y))[:NEAREST]
        x, y = np.array(self.x)[order], np.array(self.y)[order]
        apart = y - y[:, None] + np.eye(len(y))
        with np.errstate(divide="ignore", invalid="ignore"):  # where two values are equal
            value = x @ ((y + np.diag(1 - y)) / apart).prod(axis=1)  # Lagrange's form, at y = 0
        return float(value) if self.low < value < self.high else (self.low + self.high) / 2

    def add(self, y: float) -> None:
        """Take in the value of the function at the estimated root, and estimate it again."""
        self.is_lost = not math.isfinite(y)
        self.is_located = y == 0
        if self.is_lost or self.is_located:
            return
        value = self.root
        if (y > 0) == self.rises:
            self.high = value
        else:
            self.low = value
        self.x.append(value)
        self.y.append(y)
        self.root = self._estimate()
        self.is_located = abs(self.root - value) <= self.last_step and abs(y) <= self.small


def _locate(brackets: list[Bracket], function: Function) -> None:
    """Locate the roots in brackets, with one batch of solves for a step of all."""
    for _ in range(MAX_STEPS):
        active = [bracket for bracket in brackets if not (bracket.is_located or bracket.is_lost)]
        if not active:
            break
        roots = np.array([bracket.root for bracket in active])
        channels = np.array([bracket.channel for bracket in active])
        for bracket, y in zip(active, function(roots, channels).tolist(), strict=True):
            bracket.add(y)


def _brackets_of_two(
    at: NDArray, samples: NDArray, sides: NDArray, function: Function
) -> list[Bracket]:
    """Brackets of two roots between three samples of one sign: their function comes closest to zero
    at the middle one, and by a parabola it may reach it."""
    size = abs(samples)
    before, middle, after = size[:-2], size[1:-1], size[2:]
    one_sign = (sides[:-2] == sides[1:-1]) & (sides[1:-1] == sides[2:])
    closest = (middle <= before) & (middle < after) & one_sign
    rise = np.maximum(before, after) - middle  # a parabola falls by at most 1/4 of it
    candidates = np.argwhere(closest & (4 * middle <= REACH * rise))
    if not len(candidates):
        return []
    i, channel = candidates.T
    side = sides[i + 1, channel]

    def distance(value: NDArray, channel: NDArray, side: NDArray) -> NDArray:
        return side * function(value, channel)

    ends = at[i], at[i + 1], at[i + 2]
    least = elementwise.find_minimum(distance, ends, args=(channel, side))
    brackets = []
    for k in np.flatnonzero(least.f_x < 0).tolist():
        x = np.array([at[i[k]], least.x[k], at[i[k] + 2]])
        y = np.array(
            [samples[i[k], channel[k]], side[k] * least.f_x[k], samples[i[k] + 2, channel[k]]]
        )
        brackets += [
            Bracket(int(channel[k]), x[:2], y[:2], *x[:2]),
            Bracket(int(channel[k]), x[1:], y[1:], *x[1:]),
        ]
    return brackets
