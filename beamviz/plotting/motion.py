"""The chart of a motion in time: the deflection of the tip, the speed, and the spectrum."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from beamviz.plotting import COLOURS, FAINT, INK, STYLE, current_axes, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH, HEIGHT = 7.0, 5.2  # [in]
DECADES = 5  # of amplitude shown below the highest peak
LEAST_LINES = 8  # of the spectrum that are shown


def plot_deflection(t: NDArray, deflection: NDArray, axes: "Axes | None" = None) -> "Axes":
    """Draw the deflection of the tip (n,) over time (n,)."""
    axes = axes or current_axes()
    axes.plot(t, deflection, color=COLOURS["bending"], lw=1.2)
    axes.axhline(0, color="0.7", lw=0.8, zorder=0)
    axes.set(xlim=(0, t[-1]), xlabel="time t [T*]", ylabel="deflection of the tip [L]")
    return axes


def plot_spectrum(frequency: NDArray, amplitude: NDArray, axes: "Axes") -> None:
    """Draw amplitudes (k,) over frequencies (k,), up to the last that is seen."""
    axes.set(xlabel="frequency ω [1/T*]", ylabel="amplitude [L]", yscale="log")
    top = amplitude.max()
    if top == 0:
        return
    seen = np.flatnonzero(amplitude > top / 10**DECADES)
    last = max(seen[-1], min(LEAST_LINES, len(frequency) - 1))
    axes.plot(frequency[1:], amplitude[1:], color=COLOURS["bending"], lw=1.0)
    axes.set(xlim=(0, frequency[last]), ylim=(top / 10**DECADES, 2 * top))


def draw_motion(
    t: NDArray, deflection: NDArray, gamma: NDArray, spectrum: tuple[NDArray, NDArray]
) -> "Figure":
    """A figure of the tip's deflection and the speed (n,) over time (n,), and of the spectrum."""
    from matplotlib import rc_context

    with rc_context(STYLE):
        figure = new_figure(WIDTH, HEIGHT, layout="constrained")
        above, below = figure.subplots(2, 1)
        plot_deflection(t, deflection, above)
        if np.ptp(gamma) > 0:
            right = above.twinx()
            right.plot(t, gamma, color=FAINT, lw=1.0, ls="--")
            right.set_ylabel("rotation speed γ = Ω T* (dashed)", color=INK)
            right.spines["right"].set_visible(True)
            right.set_ylim(bottom=min(0.0, float(gamma.min())))
        plot_spectrum(*spectrum, below)
    return figure
