"""The maps of where methods fail as pictures: one sheet for each plane, one panel for each method.

Colours are told apart by eye of every kind and in grey (their lightness falls from kind to kind,
hatches help); large regions also carry their name.
"""

from textwrap import fill
from typing import Any, NamedTuple

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from scipy import ndimage

from beamviz.beam import PARAMETERS, Beam
from beamviz.errors import NoEquilibrium
from beamviz.failure_maps import verdicts as kinds
from beamviz.failure_maps.compute import FASTEST, SLOWEST, Map, edges
from beamviz.failure_maps.verdicts import CONTENDERS, attempt
from beamviz.paper.plots import saved
from beamviz.plotting.style import FAINT, INK, STYLE

COLUMNS = 4
WIDTH, HEIGHT = 11.0, 8.2  # [in]
TICKS = (1, 3, 10, 30, 100)
ANSYS = (40.0, 50.0)  # gamma, at delta 1: where the paper says ANSYS diverges
SMALLEST_NAMED = 0.035  # of the panel
LETTER = 0.024  # of the width of a panel
DRAWN = 0.02  # of the panel must be falsely unstable for its beginning to be drawn
SAME = 1e-3  # relative difference of speeds
REFUSED = "#F0F0F0"
BUCKLING = (0, (3, 2))


class Look(NamedTuple):
    """How a kind of verdict is drawn."""

    face: str
    hatch: str
    ink: str
    word: str


LOOKS = {
    kinds.RIGHT: Look("#FFFFFF", "", FAINT, "right"),
    kinds.INACCURATE: Look("#F7E98E", "", INK, "inaccurate"),
    kinds.OTHER_MODEL: Look("#A9D3F0", "", INK, "model\noff > 1 %"),
    kinds.TRULY_UNSTABLE: Look("#C4C4C4", "////", INK, "truly\nunstable"),
    kinds.ROUNDED: Look("#6FBFA6", "....", INK, "rounding"),
    kinds.NOT_CONVERGED: Look("#A0508A", "xxx", "white", "did not\nconverge"),
    kinds.FALSELY_UNSTABLE: Look("#C44601", "", "white", "falsely\nunstable"),
    kinds.NO_EQUILIBRIUM: Look("#2B2B2B", "", "white", "no\nequilibrium"),
}


def pictures(found: Map) -> dict[str, bytes]:
    """The sheet of one plane as PNG and SVG, by ending."""
    with rc_context(STYLE | {"hatch.linewidth": 0.5}):
        return saved(sheet(found))


def sheet(found: Map) -> Figure:
    """All methods over one plane."""
    figure = Figure(figsize=(WIDTH, HEIGHT))
    FigureCanvasAgg(figure)
    rows = -(-(len(CONTENDERS) + 1) // COLUMNS)
    grid = figure.subplots(rows, COLUMNS, sharex=True, sharey=True).ravel()
    figure.subplots_adjust(0.062, 0.068, 0.985, 0.885, 0.08, 0.2)
    for k, axes in enumerate(grid[: len(CONTENDERS)]):
        panel(axes, found, k)
    for axes in grid[-COLUMNS:]:
        axes.set_xlabel(PARAMETERS["gamma"].axis_label)
    for axes in grid[::COLUMNS]:
        axes.set_ylabel(PARAMETERS[found.plane.over].axis_label)
    for axes in grid[len(CONTENDERS) :]:
        legend(axes, found)
    figure.text(0.012, 0.967, title(found), va="center", weight="bold", size=12)
    figure.text(0.012, 0.934, subtitle(found), va="center", color="#555555", size=9)
    return figure


def title(found: Map) -> str:
    """What the sheet shows."""
    return f"Where methods fail: speed γ and {PARAMETERS[found.plane.over].axis_label}"


def subtitle(found: Map) -> str:
    """What was compared, with what."""
    return (
        f"Five lowest modes in the plane of rotation, {found.plane.held}. Reference: the paper's"
        " model (green strain, spatial curvature), solved by auto."
    )


def panel(axes: Axes, found: Map, contender: int) -> None:
    """One method: its verdicts, its limit of equilibrium and the true onset of buckling."""
    names = np.array([[cell[contender].kind for cell in row] for row in found.cells])
    x = edges(SLOWEST, FASTEST, names.shape[1], True)
    y = edges(found.plane.start, found.plane.stop, names.shape[0], found.plane.logarithmic)
    axes.set_xscale("log")
    axes.set_yscale("log" if found.plane.logarithmic else "linear")
    axes.set(xlim=x[[0, -1]], ylim=y[[0, -1]], facecolor=REFUSED)
    axes.set_xticks(TICKS, [str(tick) for tick in TICKS])
    axes.minorticks_off()
    for kind, look in LOOKS.items():
        here = names == kind
        if here.any():
            axes.pcolor(x, y, np.ma.masked_where(~here, here), **painted(look))
            region_names(axes, x, y, here, look)
    losses = np.where(
        np.mean(names == kinds.FALSELY_UNSTABLE) > DRAWN, found.losses[:, contender], np.nan
    )
    for boundary in (found.limits(contender), losses):
        if np.isfinite(boundary).any():
            curve(axes, boundary, found.values, ls="-")
            constant(axes, boundary)
    curve(axes, found.buckling, found.values, ls=BUCKLING)
    head(axes, contender)
    if found.plane.over == "delta" and "hencky" in CONTENDERS[contender].name:
        ansys(axes)


def head(axes: Axes, contender: int) -> None:
    """The method above its panel, and its resolution."""
    name, resolution = CONTENDERS[contender].name, CONTENDERS[contender].resolution
    axes.set_title(name, loc="left", size=10, pad=3, weight="bold")
    axes.set_title(resolution, loc="right", size=8.5, pad=3, color="#555555")


def painted(look: Look) -> dict[str, Any]:
    """How cells of a kind are filled."""
    lines = "white" if look.ink == "white" else "#777777"
    edge = lines if look.hatch else "none"
    return {
        "cmap": ListedColormap([look.face]),
        "hatch": look.hatch,
        "edgecolor": edge,
        "linewidth": 0,
        "antialiased": False,
        "zorder": 1,
    }


def region_names(axes: Axes, x: np.ndarray, y: np.ndarray, here: np.ndarray, look: Look) -> None:
    """Name the largest connected region of a kind at its widest place, where there is room."""
    regions, count = ndimage.label(here)
    sizes = ndimage.sum_labels(here, regions, range(1, count + 1)) / here.size
    inside = np.pad(regions == 1 + int(sizes.argmax()), 1)
    depth = ndimage.distance_transform_edt(inside, sampling=(1.2, 1.0))[1:-1, 1:-1]
    row, column = np.unravel_index(depth.argmax(), depth.shape)
    outside = np.flatnonzero(~inside[row + 1])  # of the padded row: one to the right
    left = int(outside[outside <= column].max())
    right = int(outside[outside > column].min()) - 1
    longest = max(len(line) for line in look.word.split("\n"))
    if sizes.max() < SMALLEST_NAMED or (right - left) / here.shape[1] < LETTER * longest:
        return
    axes.text(
        (x[left] * x[right]) ** 0.5,
        (y[row] + y[row + 1]) / 2,
        look.word,
        ha="center",
        va="center",
        size=7.5,
        color=look.ink,
        clip_on=True,
        zorder=4,
        bbox={"fc": look.face, "ec": "none", "pad": 0.8} if look.hatch else None,
    )


def curve(axes: Axes, gammas: np.ndarray, values: np.ndarray, ls: Any) -> None:
    """A boundary given as a speed for each row."""
    axes.plot(gammas, values, color="white", lw=2.8, zorder=2)
    axes.plot(gammas, values, color=INK, lw=1.2, ls=ls, zorder=3)


def constant(axes: Axes, gammas: np.ndarray) -> None:
    """The speed beside a boundary that is the same in most rows."""
    speed = np.nanmedian(gammas)
    if np.sum(abs(gammas - speed) < SAME * speed) < len(gammas) / 2:
        return
    axes.annotate(
        f"γ = {speed:#.4g}",
        (speed, 1),
        (-3, -3),
        xycoords=axes.get_xaxis_transform(),
        textcoords="offset points",
        ha="right",
        va="top",
        size=7.5,
        zorder=5,
    )


def ansys(axes: Axes) -> None:
    """The paper's claim, where a logarithmic-strain beam has no equilibrium at all."""
    beyond = attempt(Beam(gamma=ANSYS[-1], delta=1), strain="hencky")
    limit = beyond.limit if isinstance(beyond, NoEquilibrium) else np.nan
    axes.plot(ANSYS, [1, 1], ls="", marker="o", ms=4, mfc="white", mec=INK, mew=0.8, zorder=5)
    axes.annotate(
        f"paper: ANSYS\ndiverges;\nlimit {limit:.2f}",
        (FASTEST, 1),
        (-2, -5),
        textcoords="offset points",
        ha="right",
        va="top",
        size=6.2,
        color="white",
        zorder=5,
    )


def legend(axes: Axes, found: Map) -> None:
    """What colours and lines mean, in the place of a panel."""
    axes.set_axis_off()
    axes.set_title("")
    present = {cell[k].kind for row in found.cells for cell in row for k in range(len(CONTENDERS))}
    handles: list[Any] = [
        Patch(
            fc=look.face,
            ec="#777777",
            hatch=look.hatch,
            lw=0.6,
            label=fill(kinds.KINDS[kind], 36),
        )
        for kind, look in LOOKS.items()
        if kind in present
    ]
    if kinds.OUTSIDE in present:
        handles.append(Patch(fc=REFUSED, ec="#777777", lw=0.6, label="not accepted: γ above 5 μ"))
    handles.append(Line2D([], [], color=INK, lw=1.2, label="where failures begin, exactly"))
    if np.isfinite(found.buckling).any():
        dashed = Line2D([], [], color=INK, lw=1.2, ls=BUCKLING, label="where the beam buckles")
        handles.append(dashed)
    axes.legend(handles=handles, loc="upper left", frameon=False, fontsize=7.2, borderaxespad=0)
