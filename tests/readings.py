"""Numbers as the explorer prints them."""

from typing import Any

from beamviz.beam import Beam
from beamviz.explorer.page.readout import significant
from beamviz.solver import solve

PAPER = Beam(alpha=1, beta=0.5, gamma=10)  # where visitors start


def frequency(beam: Beam, mode: int = 0, **options: Any) -> str:
    """A frequency as the table of modes prints it."""
    solution = solve(beam, **options)
    return significant(solution.frequencies[mode], solution.errors[mode])
