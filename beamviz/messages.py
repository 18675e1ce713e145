"""Short messages for a scene: why its equilibrium is unstable, or why there is none."""

import math

import numpy as np

from beamviz.beam import Beam, Units
from beamviz.display_units import measure, significant
from beamviz.errors import BeamvizError, NoEquilibrium
from beamviz.solver import Solution


def stability_warning(solution: Solution) -> str:
    """How an unstable equilibrium diverges, in at most two lines; "" for a stable one."""
    if solution.equilibrium.status == "stable":
        return ""
    fastest = int(np.argmax(solution.growth_rates))
    motion = "stretching" if solution.labels[fastest].startswith("S") else "bending"
    warning = f"Unstable: the straight beam diverges in {motion}"
    growth_rate = float(solution.growth_rates[fastest])
    if growth_rate <= 0:
        return warning
    tenfold = duration(math.log(10) / growth_rate, solution.beam.units)
    return f"{warning}\na perturbation grows tenfold in {tenfold}"


def duration(time: float, units: Units | None) -> str:
    """A time [T*] with its unit: milliseconds for a beam in SI units."""
    return f"{significant(1000 * time * units.time, 3)} ms" if units else f"{time:.2g} T*"


def error_summary(error: BeamvizError, beam: Beam | None) -> str:
    """Why a beam has no solution, in at most two lines; beam: the one that was asked for, None
    where its numbers are out of range."""
    if isinstance(error, NoEquilibrium) and beam is not None:
        speed = measure("gamma", beam.units)
        summary = f"No equilibrium at {speed.text(beam.gamma, 6)}"
        if math.isfinite(error.limit):
            summary += f"\nthere is one up to {speed.text(error.limit, 4)}"
        return summary
    return {
        "invalid-input": "A value is out of range",
        "not-converged": "The calculation did not converge",
    }.get(error.kind, "No solution")
