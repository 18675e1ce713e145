"""Ranges of charts and sliders: from where to where a number of a beam is shown."""

from typing import Any

from beamviz.beam import MAX_GAMMA_OVER_MU, NUMBERS, SECTION, Beam
from beamviz.units import ANGLES

CHART_POINTS = 81
CHART_RANGES = {  # the least ranges
    "alpha": (0.0, 2.0),
    "beta": (0.0, 1.0),
    "gamma": (0.0, 20.0),
    "delta": (0.0, 1.0),
    "mu": (10.0, 100.0),
    "spin_up": (0.0, 20.0),
    "flap": (0.05, 2.0),
    "pitch": (0.0, 90.0),
    "twist": (0.0, 90.0),
}
CHART_AXES = ("gamma", "alpha", "beta", "delta", "mu", *SECTION)
CHART_FILL = 0.8  # share of the range, which changes rarely while a slider moves
SI_GAMMA = 5.0  # upper end of gamma for beams in SI units, which rotate slowly


def chart_axes(plane: Any, *, is_blade: bool) -> tuple[str, ...]:
    """The numbers over which the loci of a beam are charted: those of its section only where it
    bends in both planes, and the ratio of its stiffnesses not of a blade, which has its own along
    the span."""
    others = ("flap",) if is_blade else ()
    without = others if plane == "both" else tuple(SECTION)
    return tuple(name for name in CHART_AXES if name not in without)


def chart_range(beam: Beam, over: str) -> tuple[float, float]:
    """Lower and upper end of a loci chart of a beam, within the limits of the parameter `over`. The
    upper end is doubled until the beam lies in the lower CHART_FILL of the range, of an angle in
    the range. Where the beam is below the lower end, that is halved if it is above 0, else as far
    below 0 as the usual upper end, and doubled from there."""
    (least, most), (low, high) = NUMBERS[over].limits, CHART_RANGES[over]
    if over == "gamma":
        high = SI_GAMMA if beam.units else high
        most = min(most, MAX_GAMMA_OVER_MU * beam.mu)
    if over == "mu":
        least = max(least, beam.gamma / MAX_GAMMA_OVER_MU)
    value, usual = getattr(beam, over), high
    fill = 1.0 if over in ANGLES else CHART_FILL
    while value > fill * high and high < most:
        high *= 2
    while value < low and low > least:
        low = -usual if low == 0 else low / 2 if low > 0 else 2 * low
    return max(low, least), min(high, most)
