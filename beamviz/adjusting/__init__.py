"""The beam that fits a measurement, meets target frequencies, or keeps clear of resonances."""

import time
from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from beamviz.adjusting.free_numbers import BeamFamily, free_numbers
from beamviz.adjusting.measured import measured_frequencies, target_frequencies
from beamviz.adjusting.result import Adjusted
from beamviz.beam import NUMBERS, Beam
from beamviz.checks import check_float, check_int
from beamviz.conversions import checked_unit_size, parse_quantity
from beamviz.errors import InvalidInput
from beamviz.solver.problem import parse_keywords

MAX_PER_REV = 100
MARGIN_LIMITS = (1e-4, 1.0)


def adjust(
    beam: Beam,
    free: Any,
    *,
    measured: Any = None,
    clear: Iterable[int] | int | None = None,
    between: Any = None,
    margin: float = 0.1,
    targets: Any = None,
    **options: Any,
) -> Adjusted:
    """The beam whose free numbers meet one of three goals.

    free: names of one to six numbers, or their bounds by name, as {"beta": (0, 1)}, None for the
    usual range. Numbers are those of `Beam`, "root" (stiffness of the root) and, of a beam in SI, a
    "bending_factor", "axial_factor" or "mass_factor" on E I, E A or rho A; in SI also "kg",
    "beta:mm", ..., with bounds and values in this unit.
    measured: a CSV file or a table with the columns frequency [1/T*] or hertz, and, if known, mode
    ("B1", ...), error (a standard deviation in the same unit) and the numbers of the beam at which
    it was measured: gamma, rpm, alpha, ... Frequencies without a mode belong to the modes that are
    nearest, each to another one at the same speed. Least squares, weighted by the errors; relative
    without errors, whose size is then that of the residuals.
    targets: frequencies by mode, as {"B1": 3.6} or {"B1": "4.2 Hz"}.
    clear: multiples k of the speed; between: the range of gamma, or of texts as "200rpm"; the
    answer is the beam nearest to the given one (in the scale of the bounds) whose frequencies keep
    |omega - k gamma| >= margin k gamma in that range. `modes` among the options: the number of
    the lowest that count, by default all up to the highest line, at most 20.
    options: as for `solve`.

    Searches are seeded: the same call has the same answer.
    Raises InvalidInput; NoAnswer (with .best) where no beam in the bounds meets the goal.
    """
    began = time.perf_counter()
    goals = {"measured": measured, "clear": clear, "targets": targets}
    given = [name for name, value in goals.items() if value is not None]
    if len(given) != 1:
        raise InvalidInput(f"{' and '.join(given) or 'no goal'}: give one of {', '.join(goals)}")
    parse_keywords(**options)  # raises InvalidInput
    family = BeamFamily(beam, free_numbers(beam, free))
    if clear is not None:
        from beamviz.adjusting.clear import ClearGoal, cleared

        low, high = speed_range(beam, between)
        least = check_float("margin", margin, *MARGIN_LIMITS)
        answer = cleared(family, ClearGoal(per_rev_lines(clear), low, high, least), options)
    else:
        from beamviz.adjusting.fit import fitted

        if between is not None:
            raise InvalidInput("between: is the range of speeds of `clear`")
        if measured is not None:
            rows = measured_frequencies(beam, measured)
        else:
            rows = target_frequencies(beam, targets)
        answer = fitted(family, rows, options, given[0])
    return replace(answer, seconds=time.perf_counter() - began)


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
