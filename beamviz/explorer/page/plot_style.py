"""How the live charts view: colours, lines, marks and axes they share."""

import numpy as np
from viser import GuiApi, GuiUplotHandle, uplot

from beamviz.plotting.style import COLOURS as FAMILY_COLOURS
from beamviz.solver.solution import MIXED

COLOURS = {**FAMILY_COLOURS, MIXED: "#CC79A7"}
FAINT, MARK = "#9AA0A6", "#787E85"  # seen on light and dark pages
LEFT, ABOVE, BELOW = 54, 8, 44  # [px] of the margins; at the right each chart has its own
LINE: uplot.Series = {"points": {"show": False}, "pxAlign": False}
FONTS: uplot.Axis = {"font": "11px sans-serif", "labelFont": "12px sans-serif"}


def add_plot(
    gui: GuiApi,
    data: tuple[np.ndarray, ...],
    styles: tuple[uplot.Series, ...],
    axes: tuple[uplot.Axis, ...],
    height: int,
    *,
    right: int = 12,
    visible: bool = True,
) -> GuiUplotHandle:
    """A chart that is looked at and not touched, `height` [px] in all."""
    return gui.add_uplot(
        data,
        styles,
        scales=scales((0.0, 1.0), (0.0, 1.0)),
        axes=axes,
        legend={"show": False},
        cursor={"drag": {"x": False, "y": False}, "points": {"show": False}},
        padding=(ABOVE, right, 0, 0),
        height=height,
        visible=visible,
    )


def scales(x: tuple[float, float], y: tuple[float, float]) -> dict[str, uplot.Scale]:
    """The ends of both axes; missing values spoil those the page would find by itself."""
    return {"x": {"time": False, "range": x}, "y": {"range": y}}


def axes(along: str, across: str) -> tuple[uplot.Axis, ...]:
    """The two axes, of fixed size so that labels can be put on the lines."""
    return (
        {
            "label": along,
            "size": BELOW - 18,
            "labelSize": 18,
            "labelGap": 0,
            "gap": 3,
            "space": 45,
            "ticks": {"size": 5},
            **FONTS,
        },
        {
            "label": across,
            "size": LEFT - 14,
            "labelSize": 14,
            "labelGap": 0,
            "gap": 3,
            "space": 28,
            "ticks": {"size": 5},
            **FONTS,
        },
    )


def dot(fill: str, stroke: str, size: int) -> uplot.Series_Points:
    """A round mark."""
    return {"show": True, "fill": fill, "stroke": stroke, "size": size, "width": 1.5}


def apart(places: list[float], least: float) -> list[float]:
    """Ascending places moved up until none is nearer than `least` to the one below."""
    moved: list[float] = []
    for place in places:
        moved.append(max(place, moved[-1] + least) if moved else place)
    return moved
