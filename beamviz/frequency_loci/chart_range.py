"""The range of a loci chart around a beam, and the loci over it."""

from typing import Any

import numpy as np

from beamviz.beam import MAX_GAMMA_OVER_MU, PARAMETERS, Beam
from beamviz.frequency_loci import Loci, loci

POINTS = 81
# Where an axis begins and ends at first. It is doubled until the beam lies in its lower 80 %,
# so that it stays as it is during most of a drag.
SPANS = {
    "alpha": (0.0, 2.0),
    "beta": (0.0, 1.0),
    "gamma": (0.0, 20.0),
    "delta": (0.0, 1.0),
    "mu": (10.0, 100.0),
}
REAL_SPEED = 5.0  # real beams turn slowly
FULL = 0.8


def chart_range(beam: Beam, over: str) -> tuple[float, float]:
    """Where the axis of a number begins and ends for a beam."""
    (least, most), (low, high) = PARAMETERS[over].limits, SPANS[over]
    if over == "gamma":
        high = REAL_SPEED if beam.units else high
        most = min(most, MAX_GAMMA_OVER_MU * beam.mu)
    if over == "mu":
        least = max(least, beam.gamma / MAX_GAMMA_OVER_MU)
    value = getattr(beam, over)
    while value > FULL * high and high < most:
        high *= 2
    while value < low and low > least:
        low = 2 * low - (low == 0)
    return max(low, least), min(high, most)


def loci_around(beam: Beam, over: str, **options: Any) -> Loci:
    """The loci of a beam along one of its numbers, over the range of its chart; raises what `loci`
    raises."""
    start, stop = chart_range(beam, over)
    return loci(beam, over, np.linspace(start, stop, POINTS), **options)
