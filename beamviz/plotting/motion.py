"""The chart of a motion in time: the deflection of the tip, the speed, and the spectrum."""

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from beamviz.plotting import COLOURS, FAINT, INK, STYLE, axis_of, current_axes, new_figure
from beamviz.units import Units, display_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH, HEIGHT = 7.0, 5.2  # [in]
DECADES = 5  # of amplitude shown below the highest peak
SECOND: dict[str, Any] = {"color": "#A8A8A8", "lw": 1.1, "zorder": 1}
LEAST_LINES = 8  # of the spectrum that are shown


class Scales(NamedTuple):
    """The units that a motion is drawn in, and their names."""

    time: float
    seconds: str
    length: float
    metres: str


def scales_of(units: Units | None) -> Scales:
    """As on the page: s or a part of one, and mm or m, for a beam in SI, else T* and L."""
    time, length = display_unit("time", units), display_unit("beta", units)
    if not (time and length):
        return DIMENSIONLESS
    return Scales(time.factor, time.unit, length.factor, length.unit)


DIMENSIONLESS = Scales(1.0, "T*", 1.0, "L")


def plot_deflection(
    t: NDArray, deflection: NDArray, axes: "Axes | None" = None, units: Units | None = None
) -> "Axes":
    """Draw the deflection of the tip (n,) over time (n,); in mm or m and s for a beam in SI."""
    axes, scales = axes or current_axes(), scales_of(units)
    axes.plot(scales.time * t, scales.length * deflection, color=COLOURS["bending"], lw=1.2)
    axes.axhline(0, color="0.7", lw=0.8, zorder=0)
    ylabel = f"deflection of the tip [{scales.metres}]"
    axes.set(xlim=(0, scales.time * t[-1]), xlabel=f"time t [{scales.seconds}]", ylabel=ylabel)
    return axes


def plot_second(
    axes: "Axes", t: NDArray, deflection: NDArray, title: str, units: Units | None
) -> None:
    """Draw another deflection (n,) over time (n,) into the frame of the first, and name it."""
    scales = scales_of(units)
    axes.set_ylim(axes.get_ylim())  # it may grow without end
    axes.plot(scales.time * t, scales.length * deflection, label=title, **SECOND)
    above: dict[str, Any] = {"loc": "lower left", "bbox_to_anchor": (0, 1), "borderaxespad": 0.2}
    axes.legend(frameon=False, fontsize=8, **above)


def plot_spectrum(
    frequency: NDArray, amplitude: NDArray, axes: "Axes", units: Units | None = None
) -> None:
    """Draw amplitudes (k,) over frequencies (k,), up to the last that is seen; in mm or m, and Hz,
    for a beam in SI."""
    scales, across = scales_of(units), axis_of("frequency", units)
    frequency, amplitude = across.convert(frequency), scales.length * amplitude
    axes.set(xlabel=across.label, ylabel=f"amplitude [{scales.metres}]", yscale="log")
    top = amplitude.max()
    if top == 0:
        return
    seen = np.flatnonzero(amplitude > top / 10**DECADES)
    last = max(seen[-1], min(LEAST_LINES, len(frequency) - 1))
    axes.plot(frequency[1:], amplitude[1:], color=COLOURS["bending"], lw=1.0)
    axes.set(xlim=(0, frequency[last]), ylim=(top / 10**DECADES, 2 * top))


def draw_motion(
    t: NDArray,
    deflection: NDArray,
    gamma: NDArray,
    spectrum: tuple[NDArray, NDArray],
    units: Units | None = None,
    size: tuple[float, float] = (WIDTH, HEIGHT),
    second: tuple[NDArray, NDArray, str] | None = None,
) -> "Figure":
    """A figure of a size [in] of the tip's deflection and the speed (n,) over time (n,), and of the
    spectrum; in s, mm or m, rpm and Hz for a beam in SI. second: another deflection, as times (k,),
    values (k,) and its title, as far as it stays in the frame of the first."""
    from matplotlib import rc_context

    with rc_context(STYLE):
        figure = new_figure(*size, layout="constrained")
        above, below = figure.subplots(2, 1)
        plot_deflection(t, deflection, above, units)
        if second:
            plot_second(above, *second, units)
        if np.ptp(gamma) > 0:
            right, speed = above.twinx(), axis_of("gamma", units)
            right.plot(
                scales_of(units).time * t, speed.convert(gamma), color=FAINT, lw=1.0, ls="--"
            )
            right.set_ylabel(f"{speed.label}\n(dashed)", color=INK)
            right.spines["right"].set_visible(True)
            right.set_ylim(bottom=min(0.0, float(speed.convert(gamma.min()))))
        plot_spectrum(*spectrum, below, units)
    return figure
