"""The axis of loci, and the variable of their interpolation on it."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

SHORT_OF = 1e-4  # of an axis: distance from a limit of equilibrium at which the loci end
# Added before a logarithm is taken, see Axis; the second where all modes couple.
ALPHA_SHIFTS = 0.07, 0.15
GAMMA_SHIFTS = 24.0, 49.0  # of gamma^2 moment
MU_SHIFT = 5.0
COUPLED_MU_SHIFTS = 16.0, 1.0  # the second per gamma sqrt(moment)


@dataclass(frozen=True)
class Axis:
    """A range of the parameter, and the variable t of the interpolation on it, in which
    singularities of the loci are far away: log(alpha + 0.07), log(gamma^2 + 24 / moment),
    log(mu + 5), log(delta + 1) or beta itself.

    moment: tension at the clamp over gamma^2; the nearest singularities are at a tension of -24.
    gamma: of the beam, over other parameters.
    coupled: whether Coriolis forces, proportional to gamma, couple all modes. Then over gamma
    t = arsinh(gamma sqrt(moment) / 7), over mu t = -1 / (mu + 16 + gamma sqrt(moment)), over
    alpha t = log(alpha + 0.15).
    limited: whether an equilibrium ends at `low` and at `high`, where omega^2 has a square-root
    singularity, which t removes.
    """

    over: str
    low: float
    high: float
    moment: float
    gamma: float
    coupled: bool = False
    limited: tuple[bool, bool] = (False, False)

    @property
    def ends(self) -> tuple[float, float]:
        """The first and the last value of the loci, short of the limits."""
        reach = SHORT_OF * (self.high - self.low)
        return self.low + reach * self.limited[0], self.high - reach * self.limited[1]

    def t(self, p: np.ndarray) -> np.ndarray:
        """The variable at values of the parameter, beyond the axis that at its end."""
        y = self._stretched(np.clip(p, self.low, self.high))
        low, high = self._range
        match self.limited:
            case (True, True):
                return np.arcsin(np.clip(2 * (y - low) / (high - low) - 1, -1, 1))
            case (False, True):
                return -np.sqrt(np.maximum(high - y, 0.0))
            case (True, False):
                return np.sqrt(np.maximum(y - low, 0.0))
        return y

    def p(self, t: np.ndarray) -> np.ndarray:
        """The parameter at values of the variable, within the ends."""
        low, high = self._range
        match self.limited:
            case (True, True):
                y = low + (high - low) * (np.sin(t) + 1) / 2
            case (False, True):
                y = high - t**2
            case (True, False):
                y = low + t**2
            case _:
                y = t
        shift = self._shift
        if shift is None:
            p = y
        elif self.over == "gamma" and self.coupled:
            p = math.sqrt(shift) * np.sinh(y)
        elif self.over == "gamma":
            p = np.sqrt(np.maximum(np.exp(y) - shift, 0.0))
        elif self.over == "mu" and self.coupled:
            p = -1 / y - shift
        else:
            p = np.exp(y) - shift
        (start, stop), (first, last) = self.ends, self.t_ends
        return np.where(t == first, start, np.where(t == last, stop, np.clip(p, start, stop)))

    def scale(self, p: np.ndarray) -> np.ndarray:
        """A positive function by which omega^2 is divided before its interpolation: over gamma,
        with which omega^2 grows, gamma^2 + 24 / moment; else 1."""
        grows = self.over == "gamma" and not self.coupled
        return p**2 + GAMMA_SHIFTS[0] / self.moment if grows else np.ones_like(p)

    @cached_property
    def t_ends(self) -> tuple[float, float]:
        """The variable at the ends."""
        first, last = self.t(np.array(self.ends)).tolist()
        return first, last

    @property
    def length(self) -> float:
        """The length in the variable before the square root or arcsine at limits is taken."""
        return float(np.ptp(self._range))

    @cached_property
    def _range(self) -> np.ndarray:
        return self._stretched(np.array([self.low, self.high]))

    def _stretched(self, p: np.ndarray) -> np.ndarray:
        """The variable without regard to limits."""
        shift = self._shift
        if shift is None:
            return p
        if self.over == "gamma" and self.coupled:
            return np.arcsinh(p / math.sqrt(shift))
        if self.over == "mu" and self.coupled:
            return -1 / (p + shift)
        return np.log((p**2 if self.over == "gamma" else p) + shift)

    @property
    def _shift(self) -> float | None:
        """Number added before the logarithm; None where no logarithm is taken."""
        if self.over == "gamma":
            return GAMMA_SHIFTS[self.coupled] / self.moment
        if self.over == "mu" and self.coupled:
            least, each = COUPLED_MU_SHIFTS
            return least + each * self.gamma * math.sqrt(self.moment)
        if self.over == "delta":
            return 1 - min(self.low, 0.0)
        return {"alpha": ALPHA_SHIFTS[self.coupled], "mu": MU_SHIFT}.get(self.over)
