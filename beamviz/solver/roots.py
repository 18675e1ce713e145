"""Roots by bisection, many at once: scipy.optimize would double the time a command starts in."""

from collections.abc import Callable

import numpy as np

HALVINGS = 52


def bisect(
    function: Callable[[np.ndarray], np.ndarray],
    low: float | np.ndarray,
    high: float | np.ndarray,
    halvings: int = HALVINGS,
) -> np.ndarray:
    """The roots of `function` between low and high (k,), where it changes sign."""
    low, high = np.array(low, float), np.array(high, float)
    sign = np.sign(function(low))
    for _ in range(halvings):
        middle = (low + high) / 2
        same = np.sign(function(middle)) == sign
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return (low + high) / 2
