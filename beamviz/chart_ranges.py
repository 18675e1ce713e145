"""Ranges of charts and sliders: from where to where a number of a beam is shown."""

from beamviz.beam import MAX_GAMMA_OVER_MU, NUMBERS, Beam

CHART_POINTS = 81
CHART_RANGES = {  # the least ranges
    "alpha": (0.0, 2.0),
    "beta": (0.0, 1.0),
    "gamma": (0.0, 20.0),
    "delta": (0.0, 1.0),
    "mu": (10.0, 100.0),
    "spin_up": (0.0, 20.0),
}
CHART_FILL = 0.8  # share of the range, which changes rarely while a slider moves
SI_GAMMA = 5.0  # upper end of gamma for beams in SI units, which rotate slowly


def chart_range(beam: Beam, over: str) -> tuple[float, float]:
    """Lower and upper end of a loci chart of a beam, within the limits of the parameter `over`. The
    upper end is doubled until the beam lies in the lower CHART_FILL of the range, and a lower end
    of 0 becomes -1, -2, ... until it is below the beam."""
    (least, most), (low, high) = NUMBERS[over].limits, CHART_RANGES[over]
    if over == "gamma":
        high = SI_GAMMA if beam.units else high
        most = min(most, MAX_GAMMA_OVER_MU * beam.mu)
    if over == "mu":
        least = max(least, beam.gamma / MAX_GAMMA_OVER_MU)
    value = getattr(beam, over)
    while value > CHART_FILL * high and high < most:
        high *= 2
    while value < low and low > least:
        low = 2 * low if low else -1.0
    return max(low, least), min(high, most)
