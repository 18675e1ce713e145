"""What is wrong with a scene, in words a student understands."""

import math

import numpy as np

from beamviz.beam import Beam, Units
from beamviz.display_units import measure, significant
from beamviz.errors import BeamvizError, NoEquilibrium
from beamviz.solver import Solution


def unstable(solution: Solution) -> str:
    """Why an equilibrium does not last, or "" where it is stable."""
    if solution.equilibrium.status == "stable":
        return ""
    worst = int(np.argmax(solution.growth_rates))
    what = "stretching" if solution.labels[worst].startswith("S") else "bending"
    growth = float(solution.growth_rates[worst])
    if growth <= 0:
        return f"Unstable: the straight beam runs away in {what}"
    tenfold = duration(math.log(10) / growth, solution.beam.units)
    return (
        f"Unstable: the straight beam runs away in {what}\na small push grows tenfold in {tenfold}"
    )


def duration(time: float, units: Units | None) -> str:
    """A time [T*] in words."""
    return f"{significant(1000 * time * units.time, 3)} ms" if units else f"{time:.2g} T*"


def refused(error: BeamvizError, beam: Beam | None) -> str:
    """Why there is no solution, for a label where the beam was (`beam`: the one asked for)."""
    if isinstance(error, NoEquilibrium) and beam is not None:
        speed = measure("gamma", beam.units)
        held = (
            f"\nit holds up to {speed.text(error.limit, 4)}" if math.isfinite(error.limit) else ""
        )
        return f"No equilibrium: the beam does not hold at {speed.text(beam.gamma, 6)}{held}"
    return {
        "invalid-input": "A value is out of range",
        "not-converged": "The calculation did not converge",
    }.get(error.kind, "No solution")
