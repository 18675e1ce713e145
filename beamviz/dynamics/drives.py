"""What turns the hub: a prescribed speed (constant, a ramp, samples) or a torque.

A prescribed speed is a function of time t (k,) that returns gamma and gamma' (k,) each. `angle` is
its integral, `first` its value at t = 0, `breaks` the times at which it is not smooth.
"""

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from beamviz.beam import Beam
from beamviz.checks import check_choice, check_float, check_positive
from beamviz.errors import InvalidInput

SHAPES = ("smooth", "linear")
MAX_SAMPLES = 100_000
MAX_INERTIA, MAX_TORQUE = 1e6, 1e6


@dataclass(frozen=True)
class Ramp:
    """A change of speed from `start` to `to` within a time [T*], constant after it.

    shape: "linear", or "smooth" by the law of Kane, Ryan & Banerjee (1987), whose acceleration
    begins and ends at 0. Raises InvalidInput.
    """

    to: float
    within: float
    shape: str = "smooth"
    start: float = 0.0

    def __post_init__(self) -> None:
        check = {
            "to": check_float("to", self.to),
            "within": check_positive("within", self.within),
            "shape": check_choice("shape", self.shape, SHAPES),
            "start": check_float("start", self.start),
        }
        for name, value in check.items():
            object.__setattr__(self, name, value)

    @property
    def record(self) -> dict[str, Any]:
        """Its kind and its arguments."""
        return {"kind": "ramp", **vars(self)}

    @property
    def described(self) -> str:
        """It in words."""
        return (
            f"{self.shape} ramp from {self.start:g} to gamma = {self.to:g} within {self.within:g}"
        )

    @property
    def first(self) -> float:
        return self.start

    @property
    def breaks(self) -> list[float]:
        return [self.within]

    @property
    def extremes(self) -> tuple[float, ...]:
        return self.start, self.to

    def __call__(self, t: NDArray) -> tuple[NDArray, NDArray]:
        change, part = self.to - self.start, np.minimum(t / self.within, 1.0)
        rate = np.where(t < self.within, change / self.within, 0.0)
        if self.shape == "linear":
            return self.start + change * part, rate
        turn = 2 * math.pi * part
        gamma = self.start + change * (part - np.sin(turn) / (2 * math.pi))
        return gamma, rate * (1 - np.cos(turn))

    def angle(self, t: NDArray) -> NDArray:
        change, part = self.to - self.start, np.minimum(t / self.within, 1.0)
        grown = part**2 / 2
        if self.shape == "smooth":
            grown = grown + (np.cos(2 * math.pi * part) - 1) / (2 * math.pi) ** 2
        after = np.maximum(t - self.within, 0.0)
        return self.start * t + change * (self.within * grown + after)


@dataclass(frozen=True, eq=False)
class Samples:
    """A speed given at times: linear between them, constant before the first and after the last.
    One sample is a constant speed."""

    t: NDArray
    gamma: NDArray

    @property
    def record(self) -> dict[str, Any]:
        if len(self.t) == 1:
            return {"kind": "constant", "gamma": float(self.gamma[0])}
        return {"kind": "samples", "t": self.t.tolist(), "gamma": self.gamma.tolist()}

    @property
    def described(self) -> str:
        if len(self.t) == 1:
            return f"constant gamma = {self.gamma[0]:g}"
        return f"{len(self.t)} samples, gamma = {self.gamma.min():g} .. {self.gamma.max():g}"

    @property
    def first(self) -> float:
        return float(self(np.zeros(1))[0][0])

    @property
    def breaks(self) -> list[float]:
        return self.t.tolist()

    @property
    def extremes(self) -> tuple[float, ...]:
        return float(self.gamma.min()), float(self.gamma.max())

    def __call__(self, t: NDArray) -> tuple[NDArray, NDArray]:
        rate = self.rates[np.searchsorted(self.t, t, side="right")]
        return np.interp(t, self.t, self.gamma), rate

    @cached_property
    def rates(self) -> NDArray:
        """gamma' before, between and after the samples."""
        return np.concatenate(([0.0], np.diff(self.gamma) / np.diff(self.t), [0.0]))

    def angle(self, t: NDArray) -> NDArray:
        return self.integral(t) - self.integral(np.zeros(1))

    def integral(self, t: NDArray) -> NDArray:
        """The integral of gamma from the first sample, or from 0 where that is earlier."""
        ends = np.concatenate(([min(0.0, self.t[0])], self.t))
        gamma, _ = self(ends)
        passed = np.concatenate(([0.0], np.cumsum(np.diff(ends) * (gamma[1:] + gamma[:-1]) / 2)))
        k = np.clip(np.searchsorted(ends, t, side="right") - 1, 0, len(ends) - 1)
        return passed[k] + (t - ends[k]) * (gamma[k] + self(t)[0]) / 2


@dataclass(frozen=True)
class Hub:
    """A hub that turns freely under a torque; it starts with the speed of the beam.

    inertia: [rho A L^3] about the axis, above 0. torque: [E I / L], a number, or a pair of arrays
    (t, torque), linear between samples and constant after the last. Raises InvalidInput.
    """

    inertia: float
    torque: Any = 0.0
    history: Samples = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        inertia = check_float("inertia", self.inertia, 0.0, MAX_INERTIA)
        object.__setattr__(self, "inertia", check_positive("inertia", inertia))
        history = samples("torque", self.torque, -MAX_TORQUE, MAX_TORQUE)
        object.__setattr__(self, "history", history)
        t, torque = history.t.tolist(), history.gamma.tolist()
        given = torque[0] if len(torque) == 1 else (tuple(t), tuple(torque))
        object.__setattr__(self, "torque", given)

    @property
    def record(self) -> dict[str, Any]:
        return {"kind": "hub", "inertia": self.inertia, "torque": self.torque}

    @property
    def described(self) -> str:
        torque = self.history.gamma
        span = f"{torque[0]:g}" if len(torque) == 1 else f"{torque.min():g} .. {torque.max():g}"
        return f"hub of inertia {self.inertia:g} under a torque of {span}"

    @property
    def breaks(self) -> list[float]:
        return self.history.breaks


def samples(name: str, given: Any, low: float, high: float) -> Samples:
    """A number or a pair of arrays as samples; raises InvalidInput."""
    if isinstance(given, np.ndarray) and given.ndim == 2:
        given = tuple(given)
    if not isinstance(given, tuple | list):
        return Samples(np.zeros(1), np.array([check_float(name, given, low, high)]))
    if len(given) != 2:
        raise InvalidInput(f"{name}: must be a number or a pair (times, values)")
    t, values = (as_array(name, part) for part in given)
    if len(t) != len(values) or not 1 <= len(t) <= MAX_SAMPLES:
        raise InvalidInput(
            f"{name}: {len(t)} times and {len(values)} values; must be as many, 1 .. {MAX_SAMPLES}"
        )
    if not (np.diff(t) > 0).all():
        raise InvalidInput(f"{name}: its times must ascend")
    for value in (values.min(), values.max()):
        check_float(name, value, low, high)
    return Samples(t, values)


def as_array(name: str, given: ArrayLike) -> NDArray:
    """A one-dimensional array of finite numbers; raises InvalidInput."""
    try:
        array = np.array(given, float)
    except (TypeError, ValueError):
        array = np.full((0, 0), np.nan)
    if array.ndim != 1 or not np.isfinite(array).all():
        raise InvalidInput(f"{name}: must be given by lists of finite numbers")
    return array


def drive_of(beam: Beam, speed: Any) -> Ramp | Samples | Hub:
    """The drive that the argument `speed` of `motion` stands for; raises InvalidInput where a speed
    is out of the range of the beam's, in either direction."""
    if isinstance(speed, Hub):
        return speed
    if speed is None:
        return Samples(np.zeros(1), np.array([beam.gamma]))
    drive = speed if isinstance(speed, Ramp) else samples("speed", speed, -math.inf, math.inf)
    for gamma in drive.extremes:
        beam.replace(gamma=abs(gamma))
    return drive
