"""The goal of `adjust` to keep clear of per-rev lines between two speeds."""

from collections.abc import Iterable
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from beamviz.beam import NUMBERS, Beam
from beamviz.checks import check_float, check_int
from beamviz.conversions import checked_unit_size, parse_quantity
from beamviz.errors import InvalidInput

MAX_PER_REV = 100
MARGIN_LIMITS = (1e-4, 1.0)


class ClearGoal(NamedTuple):
    """Per-rev lines, the range of gamma, in 1/T* of the given beam, and the least margin."""

    lines: tuple[int, ...]
    low: float
    high: float
    margin: float

    @classmethod
    def of(cls, beam: Beam, clear: Iterable[int] | int, between: Any, margin: float) -> Self:
        """The goal of the arguments of `adjust`. Raises InvalidInput."""
        lines, (low, high) = per_rev_lines(clear), speed_range(beam, between)
        return cls(lines, low, high, check_float("margin", margin, *MARGIN_LIMITS))

    def band(self, line: int) -> tuple[NDArray, NDArray]:
        """The corners of the band in which no frequency may be, for one of the lines: speeds gamma
        and frequencies (5,) in 1/T* of the given beam, the last corner being the first."""
        speeds = np.array([self.low, self.high, self.high, self.low, self.low])
        sides = 1 + self.margin * np.array([-1, -1, 1, 1, -1])
        return speeds, line * sides * speeds


def per_rev_lines(clear: Iterable[int] | int) -> tuple[int, ...]:
    """The multiples of the speed. Raises InvalidInput."""
    lines = clear if isinstance(clear, Iterable) else (clear,)
    checked = tuple(sorted({check_int("clear", line, 1, MAX_PER_REV) for line in lines}))
    if not checked:
        raise InvalidInput("clear: must be multiples of the speed, as (1, 2, 3)")
    return checked


def speed_range(beam: Beam, between: Any) -> tuple[float, float]:
    """The range of gamma, given as numbers or as texts in a unit. Raises InvalidInput."""
    if isinstance(between, str):
        between = between.split(":")
    try:
        low, high = (speed(beam, end) for end in between)
    except TypeError:
        raise InvalidInput(f"between = {between!r}: must be two speeds, as (2, 6)") from None
    except ValueError as error:
        if isinstance(error, InvalidInput):
            raise
        raise InvalidInput(f"between = {between!r}: must be two speeds, as (2, 6)") from None
    if not 0 < low < high:
        raise InvalidInput(f"between = {low:g}, {high:g}: must ascend, the first above 0")
    return low, high


def speed(beam: Beam, value: Any) -> float:
    """A speed gamma, given as a number or a text in a unit, as "200rpm". Raises InvalidInput."""
    quantity = parse_quantity(value) if isinstance(value, str) else None
    if quantity is None or not quantity.unit:
        value = quantity.value if quantity else value
        return check_float("between", value, *NUMBERS["gamma"].limits)
    size = checked_unit_size(f"between {value}", quantity.unit, "rad/s")
    if beam.units is None:
        raise InvalidInput(f"between {value}: the size of the beam is not known; give it in SI")
    gamma = quantity.value * size * beam.units.time
    return check_float("between", gamma, *NUMBERS["gamma"].limits)
