"""How long the steps of an integration are.

The length of an adaptive step follows from the polynomial of the step before: the size of its
highest coefficient, in the norm of the kinetic energy, is kept near a tolerance, as elements of a
mesh are chosen by the tails of their polynomials. A step that is not taken is tried again with the
length that the controller then proposes.
"""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Self

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from beamviz.dynamics.newton_step import Step

FIRST_STEP = 0.1  # [T*]; the next ones follow from the polynomials
HALF = 0.5  # of a step in which Newton's method failed
SAFETY, SHORTEST, LONGEST = 0.9, 0.3, 3.0  # of the next step over this one
REPEATED = 2.0  # times the tolerance: a step that is worse is repeated
RECOVERY = 1.02  # of the longest step, in each step after a failure
GROWS = 1.2  # a smaller growth is not worth new factors
# Of steps of equal length: it is the least median length of this many consecutive adaptive steps.
# Their longest would not do: an undamped vibration may be lost in it, and then no comparison of
# finer motions shows that it is missing.
SUSTAINED = 8
GROWING = 2.0  # ratio of two successive steps above which the first counts as a step of the start
LEAST_EXCESS = 1e-12  # of the error of a step over the tolerance


class Controller:
    """A choice of the lengths of steps."""

    divides = True  # whether a step is tried again with another length where Newton's method fails

    def __init__(self) -> None:
        self.longest = math.inf  # the longest step that Newton's method is tried with

    def begin(self) -> None:
        """Begin a part of the motion, with another equation."""
        self.longest = math.inf

    def length(self, t: float) -> float:
        """The length of the step to try from t."""
        raise NotImplementedError

    def takes(self, h: float, step: Step | None) -> bool:
        """Whether a step of length h, None where Newton's method failed, becomes a part of the
        motion; if not, it is tried again with the next `length`."""
        if step is None:
            self.longest = HALF * h
            return False
        self.longest *= RECOVERY
        return True


class AdaptiveSteps(Controller):
    """Lengths by the highest coefficients of the steps, which are kept near a tolerance [L]."""

    def __init__(self, tolerance: float):
        super().__init__()
        self.tolerance, self.next = tolerance, FIRST_STEP

    def length(self, t: float) -> float:
        return min(self.next, self.longest)

    def takes(self, h: float, step: Step | None) -> bool:
        if step is None:
            self.next = HALF * h
            return super().takes(h, step)
        excess = max(step.error / self.tolerance, LEAST_EXCESS)
        factor = min(max(SAFETY * excess ** (-1 / step.degree), SHORTEST), LONGEST)
        self.next = h if 1 <= factor < GROWS else h * factor
        return excess <= REPEATED and super().takes(h, step)


class GivenSteps(Controller):
    """Steps that end at given times (k,), divided further where Newton's method fails."""

    def __init__(self, ends: NDArray):
        super().__init__()
        self.ends = ends

    @classmethod
    def divided(cls, ends: NDArray, times: int) -> Self:
        """The steps between these ends, each divided into equal ones."""
        parts = np.linspace(ends[:-1], ends[1:], times, endpoint=False, axis=1)
        return cls(np.append(parts.ravel(), ends[-1]))

    @classmethod
    def of_equal_length(cls, ends: NDArray, corners: Sequence[float], times: int) -> Self:
        """Steps of equal length between two corners, which are the first and the last time and
        those at which the motion is not smooth; `times` as many as there would be of the shortest
        sustained length of the steps between these ends."""
        parts = [np.zeros(1)]
        for start, stop in pairwise(corners):
            inside = (ends[1:] > start) & (ends[1:] <= stop)
            length = shortest_sustained(np.diff(ends)[inside])
            count = math.ceil((stop - start) / length - 1e-6)
            parts.append(np.linspace(start, stop, times * count + 1)[1:])
        return cls(np.concatenate(parts))

    def length(self, t: float) -> float:
        index = np.searchsorted(self.ends[:-1], t * (1 + 1e-12), side="right")
        return min(float(self.ends[index]) - t, self.longest)


def shortest_sustained(lengths: NDArray) -> float:
    """The least median length of SUSTAINED steps in a row, without those at the start that only
    grow from a shorter one."""
    settled = lengths[np.append(lengths[1:] < GROWING * lengths[:-1], True)]
    rows = sliding_window_view(settled, min(SUSTAINED, len(settled)))
    return float(np.median(rows, axis=1).min())


class EqualSteps(Controller):
    """Steps of one length."""

    divides = False

    def __init__(self, step: float):
        super().__init__()
        self.step = step

    def length(self, t: float) -> float:
        return self.step
