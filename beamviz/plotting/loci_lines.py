"""The lines of the loci chart, and its scales."""

import math
from collections.abc import Callable
from typing import Any, NamedTuple, Self

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap

from beamviz.beam import PARAMETERS
from beamviz.frequency_loci import Branch, Event, Loci
from beamviz.plotting.style import COLOURS

SHADES = 20  # of colour from one family to the other
FAMILIES = LinearSegmentedColormap.from_list(
    "families", [COLOURS["stretching"], "#8C7C86", COLOURS["bending"]]
)


class Scales(NamedTuple):
    """What the axes show: SI units where the beam has them."""

    x: Callable[[Any], Any]
    y: Callable[[Any], Any]
    xlabel: str
    ylabel: str
    value: str  # of x, as a template
    unit: str  # of y

    @classmethod
    def of(cls, loci: Loci) -> Self:
        """The scales of a chart."""
        units = loci.units
        y, ylabel, unit = _same, "frequency ω [1/T*]", ""
        if units:
            y, ylabel, unit = units.hertz, "frequency [Hz]", " Hz"
        if units and loci.over == "gamma":
            return cls(units.rpm, y, "rotation speed [rpm]", ylabel, "{:.5g} rpm", unit)
        return cls(
            _same,
            y,
            PARAMETERS[loci.over].axis_label,
            ylabel,
            PARAMETERS[loci.over].symbol + " = {:#.5g}",
            unit,
        )

    def told(self, value: float) -> str:
        """A value of x in words."""
        return self.value.format(self.x(value)).replace("-", "−")


def _same(value: Any) -> Any:
    """The value as it is."""
    return value


def draw_branch(axes: Axes, scales: Scales, loci: Loci, branch: Branch) -> None:
    """One locus; its colour goes over from one family to the other where the mode does."""
    here = np.isfinite(branch.bending_fraction)
    if not here.any():
        return
    met = [event for event in loci.events if branch.label in event.branches]
    x = np.concatenate((loci.values, [event.at for event in met]))
    y = np.concatenate((branch.frequency, [_height(loci, branch, event) for event in met]))
    order = x.argsort(kind="stable")
    x, y = x[order], y[order]
    fraction = np.interp(x, loci.values[here], branch.bending_fraction[here])
    shade = np.round(fraction * SHADES).astype(int)
    starts = np.flatnonzero(np.diff(shade, prepend=-1)).tolist()
    for start, stop in zip(starts, [*starts[1:], len(x)], strict=True):
        piece = slice(start, stop + 1)  # a point more, so that the colours join
        colour = FAMILIES(shade[start] / SHADES)
        axes.plot(scales.x(x[piece]), scales.y(y[piece]), color=colour, lw=1.7, zorder=3)


def _height(loci: Loci, branch: Branch, event: Event) -> float:
    """The frequency of a branch at one of its meetings."""
    return event.frequency + event.gap * (0.5 if branch.label == upper(loci, event) else -0.5)


def upper(loci: Loci, event: Event) -> str:
    """The label of the upper one of two branches that veer."""
    two = [branch for branch in loci.branches if branch.label in event.branches]
    both = np.flatnonzero(np.minimum(*(branch.mode_index for branch in two)) >= 0)
    if not len(both):
        return event.branches[1]
    nearest = both[abs(loci.values[both] - event.at).argmin()]
    return max(two, key=lambda branch: branch.mode_index[nearest]).label


def lines_at(loci: Loci, value: float, scales: Scales) -> list[float]:
    """The heights of the lines at a value."""
    k = int(abs(loci.values - value).argmin())
    heights = [scales.y(branch.frequency[k]) for branch in loci.branches]
    return [height for height in heights if math.isfinite(height)]
