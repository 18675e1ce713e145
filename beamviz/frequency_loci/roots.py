"""Roots of functions of the modes along a path, located by solves.

A function vanishes where something happens: the difference of two omega^2 at a crossing,
omega^2 - (k gamma)^2 at a resonance. It is sampled at the values of a grid; between two samples of
different sign lies a root, and beside a minimum of its absolute value there may be two. All are
refined together, so that each iteration is one batch of solves.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import elementwise

REACH = 2.0  # a parabola through three samples may reach zero this many times as easily
TOLERANCES = {"xrtol": 1e-11, "fatol": 0.0, "frtol": 0.0}  # relative to the parameter

# Values of the parameter (k,) and channels (k,) -> values (k,) of the functions; nan where unknown.
Function = Callable[[NDArray, NDArray], NDArray]


class Roots(NamedTuple):
    """Roots of some functions, by ascending value of the parameter."""

    at: NDArray  # (roots,)
    channel: NDArray  # (roots,) number of the function
    rises: NDArray  # (roots,) whether it rises there


def find_roots(at: NDArray, samples: NDArray, function: Function) -> Roots:
    """The roots of functions known at ascending values (n,), samples (n, channels).

    A sample that is zero belongs to the interval before it.
    """
    sides = np.sign(samples)
    for i in range(1, len(sides)):
        sides[i] = np.where(sides[i] == 0, sides[i - 1], sides[i])
    brackets = [
        (at[i], at[i + 1], channel, sides[i + 1, channel] > 0)
        for i, channel in np.argwhere(sides[:-1] * sides[1:] < 0)
    ]
    brackets += _touching(at, samples, sides, function)
    if not brackets:
        return Roots(np.empty(0), np.empty(0, int), np.empty(0, bool))
    low, high, channel, rises = (np.array(column) for column in zip(*brackets, strict=True))
    found = elementwise.find_root(function, (low, high), args=(channel,), tolerances=TOLERANCES)
    located = np.isfinite(found.x) & np.isfinite(found.f_x)
    order = np.flatnonzero(located)[np.argsort(found.x[located])]
    return Roots(found.x[order], channel[order], rises[order])


def _touching(
    at: NDArray, samples: NDArray, sides: NDArray, function: Function
) -> list[tuple[float, float, int, bool]]:
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

    bracket = at[i], at[i + 1], at[i + 2]
    least = elementwise.find_minimum(distance, bracket, args=(channel, side))
    crossed = np.flatnonzero(least.f_x < 0)
    return [
        (float(start), float(stop), int(channel[k]), bool(rises))
        for k in crossed
        for start, stop, rises in (
            (at[i[k]], least.x[k], side[k] < 0),
            (least.x[k], at[i[k] + 2], side[k] > 0),
        )
    ]
