"""The pictures of the maps: a sheet for each map, with a panel for each method."""

from itertools import product
from operator import itemgetter
from textwrap import fill
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from beamviz.beam import PARAMETERS, Beam
from beamviz.evidence.failure_maps import kinds
from beamviz.evidence.failure_maps.kinds import Kind
from beamviz.evidence.failure_maps.lines import answer_of
from beamviz.evidence.failure_maps.maps import FASTEST, SLOWEST, Map, MethodMap, Plane, edges
from beamviz.files import Files
from beamviz.plotting import CENTRED, INK, STRIPES, STYLE, new_figure, picture_files
from beamviz.sweeps.quantities import connected

COLUMNS = 4
WIDTH, ROW, HEAD, FOOT = 11.0, 2.23, 0.94, 0.56  # [in]
TICKS = (1, 3, 10, 30, 100)
ANSYS, ANSYS_DELTA = (40.0, 50.0), 1.0  # gammas for which the paper reports that ANSYS diverges
SMALLEST_NAMED = 0.035  # region, of the panel
SMALLEST_LOSS = 0.02  # of the panel must be falsely unstable for its boundary to be drawn
LETTER = 0.024  # width, of the panel
BUCKLING = (0, (3, 2))
CELLS: dict[str, Any] = {"linewidth": 0, "antialiased": False, "zorder": 1}
ABOVE: dict[str, Any] = {"textcoords": "offset points", "ha": "right", "va": "top", "zorder": 5}


@rc_context(STYLE)
def sheet(plane_map: Map) -> Files:
    """The sheet of one map as PNG and SVG, by file name: a panel for each method that does not
    refuse, one for the legend, and one for the others."""
    shown = [method_map for method_map in plane_map.methods if not method_map.refusal]
    refusing = [method_map.name for method_map in plane_map.methods if method_map.refusal]
    rows = -(-(len(shown) + 1 + bool(refusing)) // COLUMNS)
    height = HEAD + rows * ROW + FOOT
    figure = new_figure(WIDTH, height)
    figure.subplots_adjust(0.07, FOOT / height, 0.985, 1 - HEAD / height, 0.08, 0.2)
    panels = figure.subplots(rows, COLUMNS, sharex=True, sharey=True).ravel()
    draw_heading(figure, plane_map.plane, height)
    draw_labels(panels, plane_map.plane, len(shown))
    for axes, method_map in zip(panels, shown, strict=False):
        draw_panel(axes, plane_map, method_map)
    draw_legend(panels[len(shown)], plane_map, shown)
    if refusing:
        text = "\n".join(["These methods have no bent states:", "", *refusing])
        axes = panels[len(shown) + 1]
        axes.text(0.0, 0.94, text, transform=axes.transAxes, va="top", size=7.2)
    return picture_files(figure, f"stability-{plane_map.plane.name}")


def draw_heading(figure: Figure, plane: Plane, height: float) -> None:
    """The two lines above the panels of a sheet of a height [in]."""
    place: dict[str, Any] = {"x": 0.012, "va": "center"}
    heading = plane.subject.heading.format(plane.parameter.axis_label)
    figure.text(y=1 - 0.27 / height, s=heading, weight="bold", size=12, **place)
    subtitle = plane.subject.subtitle.format(plane.held)
    figure.text(y=1 - 0.54 / height, s=subtitle, color="#555555", size=9, **place)


def draw_labels(panels: np.ndarray, plane: Plane, count: int) -> None:
    """Label the axes of the first `count` panels, the others stay without."""
    for axes in panels[count:]:
        axes.set_axis_off()
    for axes in panels[::COLUMNS]:
        axes.set_ylabel(plane.parameter.axis_label)
    for axes in panels[max(count - COLUMNS, 0) : count]:
        axes.tick_params(labelbottom=True)
        axes.set_xlabel(PARAMETERS["gamma"].axis_label)


def draw_legend(axes: Axes, plane_map: Map, shown: list[MethodMap]) -> None:
    """Explain colours and both kinds of line in the place of a panel."""
    subject = plane_map.plane.subject
    handles: list[Any] = []
    present = {name for method_map in shown for name in method_map.kinds.flat}
    for kind in subject.kinds:
        text = kind.meaning + ("" if kind.name in present else " (nowhere here)")
        look: dict[str, Any] = {"fc": kind.face, "hatch": kind.hatch, "ec": STRIPES, "lw": 0.6}
        handles.append(Patch(label=fill(text, 40), **look))
    line: dict[str, Any] = {"color": INK, "lw": 1.2}
    handles.append(Line2D([], [], label=subject.boundary, **line))
    if np.isfinite(shown[0].speeds("buckling")).any():
        handles.append(Line2D([], [], label=subject.buckling, ls=BUCKLING, **line))
    place: dict[str, Any] = {"loc": "upper left", "bbox_to_anchor": (0, 0.97), "borderaxespad": 0}
    axes.legend(handles=handles, frameon=False, fontsize=7.2, **place)


def draw_panel(axes: Axes, plane_map: Map, method_map: MethodMap) -> None:
    """One method: its cells, and the boundaries that were located between them."""
    options, plane = method_map.options, plane_map.plane
    draw_cells(axes, plane, method_map.kinds)
    boundaries = [method_map.speeds("limit")]
    if np.mean(method_map.kinds == kinds.FALSELY_UNSTABLE.name) > SMALLEST_LOSS:
        boundaries.append(method_map.speeds("loss"))
    for gammas, ls in (*product(boundaries, "-"), (method_map.speeds("buckling"), BUCKLING)):
        axes.plot(gammas, plane_map.values, color="white", lw=2.8, zorder=2)
        axes.plot(gammas, plane_map.values, color=INK, lw=1.2, ls=ls, zorder=3)
    resolution = "".join(f"{options[k]} {k}" for k in ("elements", "terms") if k in options)
    axes.set_title(method_map.name, loc="left", size=10, pad=3, weight="bold")
    axes.set_title(resolution, loc="right", size=8.5, pad=3, color="#555555")
    for gammas in boundaries:
        label_constant(axes, gammas)
    if plane.over == "delta" and plane.stop > ANSYS_DELTA and options == {"strain": "hencky"}:
        mark_ansys(axes)


def draw_cells(axes: Axes, plane: Plane, names: np.ndarray) -> None:
    """Cells of kinds (rows, columns) over the speed and the plane's number."""
    x = edges(SLOWEST, FASTEST, names.shape[1], True)
    y = edges(plane.start, plane.stop, names.shape[0], plane.logarithmic)
    axes.set_xscale("log")
    axes.set_yscale("log" if plane.logarithmic else "linear")
    axes.set(xlim=x[[0, -1]], ylim=y[[0, -1]], facecolor=kinds.OUTSIDE.face)
    axes.set_xticks(TICKS, [str(tick) for tick in TICKS])
    axes.minorticks_off()
    for kind in plane.subject.kinds:
        here = names == kind.name
        if here.any():
            look = {"cmap": ListedColormap([kind.face]), "hatch": kind.hatch, **CELLS}
            look["edgecolor"] = "white" if kind.ink == "white" else STRIPES
            axes.pcolor(x, y, np.ma.masked_where(~here, here), **look)
            label_region(axes, x, y, here, kind)


def label_region(axes: Axes, x: np.ndarray, y: np.ndarray, here: np.ndarray, kind: Kind) -> None:
    """Label the largest connected region of a kind at its widest place, if there is room."""
    label = fill(kind.name, 9, break_long_words=False)
    share, row, column = max(connected(here, (1.2, 1.0)), key=itemgetter(0))
    outside = np.flatnonzero(~np.pad(here[row], 1))  # of the padded row: one to the right
    left = int(outside[outside <= column].max())
    right = int(outside[outside > column].min()) - 1
    longest = max(len(line) for line in label.split("\n"))
    if share < SMALLEST_NAMED or (right - left) / here.shape[1] < LETTER * longest:
        return
    place = (x[left] * x[right]) ** 0.5, (y[row] + y[row + 1]) / 2
    box = {"fc": kind.face, "ec": "none", "pad": 0.8}  # over hatches and boundaries
    text: dict[str, Any] = {"size": 7.5, "color": kind.ink, "bbox": box, **CENTRED}
    axes.text(*place, label, zorder=4, clip_on=True, **text)


def label_constant(axes: Axes, gammas: np.ndarray) -> None:
    """Write the speed beside a boundary where it is the same, within 0.001, in most rows."""
    speed = np.nanmedian(gammas) if np.isfinite(gammas).any() else np.nan
    if np.sum(abs(gammas - speed) < 1e-3 * speed) >= len(gammas) / 2:
        top = axes.get_xaxis_transform()
        axes.annotate(f"γ = {speed:#.4g}", (speed, 1), (-3, -3), xycoords=top, size=7.5, **ABOVE)


def mark_ansys(axes: Axes) -> None:
    """Mark the paper's ANSYS runs: beyond the limit of a beam with logarithmic strain."""
    error: Any = answer_of(Beam(gamma=ANSYS[-1], delta=ANSYS_DELTA), strain="hencky")
    axes.plot(
        ANSYS, [ANSYS_DELTA] * 2, ls="", marker="o", ms=4, mfc="white", mec=INK, mew=0.8, zorder=5
    )
    text = f"paper: ANSYS\ndiverges;\nlimit {error.limit:.2f}"
    axes.annotate(text, (FASTEST, ANSYS_DELTA), (-2, -5), size=6.2, color="white", **ABOVE)
