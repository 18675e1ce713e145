"""What is wrong with a scene, in words a student understands."""

import math

import numpy as np

from beamviz.beam import Beam
from beamviz.errors import BeamvizError, NoEquilibrium
from beamviz.mechanics.solve import Solution


def unstable(solution: Solution) -> str:
    """Why an equilibrium does not last, or "" where it is stable."""
    if solution.equilibrium.status == "stable":
        return ""
    worst = int(np.argmax(solution.growth_rates))
    what = "stretching" if solution.labels[worst].startswith("S") else "bending"
    growth = float(solution.growth_rates[worst])
    grown = f"\na small push grows tenfold in {math.log(10) / growth:.2g} T*" if growth > 0 else ""
    return f"Unstable: the straight beam runs away in {what}{grown}"


def refused(error: BeamvizError, beam: Beam | None) -> str:
    """Why there is no solution, for a label where the beam was (`beam`: the one asked for)."""
    if isinstance(error, NoEquilibrium) and beam is not None:
        held = f"\nit holds up to \u03b3 = {error.limit:.4g}" if math.isfinite(error.limit) else ""
        return f"No equilibrium: the beam does not hold at \u03b3 = {beam.gamma:g}{held}"
    return {
        "invalid-input": "These numbers describe no beam",
        "not-converged": "The calculation did not converge",
    }.get(error.kind, "No solution")
