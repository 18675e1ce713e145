"""The beam that fits a measurement, meets target frequencies, or keeps clear of resonances."""

import time
from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from beamviz.adjusting.free_numbers import BeamFamily, free_numbers
from beamviz.adjusting.goals import ClearGoal
from beamviz.adjusting.result import Adjusted
from beamviz.beam import Beam
from beamviz.errors import InvalidInput
from beamviz.measured import measured_frequencies, target_frequencies
from beamviz.solver.problem import parse_keywords


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
        from beamviz.adjusting.clear import cleared

        answer = cleared(family, ClearGoal.of(beam, clear, between, margin), options)
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
