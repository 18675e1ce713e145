"""beamviz stability: maps of where methods fail, and of the stable states of an inward beam, as
pictures, data and text. A picture is a sheet for each plane with a panel for each method."""

from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from itertools import product
from multiprocessing import get_context
from operator import itemgetter
from pathlib import Path
from textwrap import fill
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from beamviz.beam import PARAMETERS, Beam
from beamviz.failure_maps import compute
from beamviz.failure_maps.compute import CORRECT, KINDS, STATES, Kind, Map, MethodMap, Plane
from beamviz.files import Files, json_text, make_folder, markdown_table, write_files
from beamviz.plotting import CENTRED, INK, STRIPES, STYLE, new_figure, picture_files
from beamviz.sweeps.quantities import connected

PAGE = "stability.md"
QUICK = {KINDS: (14, 9), STATES: (10, 6)}  # cells along the speed and across
FULL = {KINDS: (32, 20), STATES: (22, 12)}


def stability(out: Path, quick: bool) -> str:
    """Compute every map and write pictures, stability.json and stability.md; the text of the page.

    Raises Unavailable, before anything is computed, for a folder that cannot be written to.
    """
    make_folder(out)
    sizes, planes = QUICK if quick else FULL, (*compute.PLANES, compute.INWARD)
    with ProcessPoolExecutor(mp_context=get_context("spawn")) as pool:
        maps = [compute.compute_map(plane, sizes[plane.kinds], pool) for plane in planes]
    data = json_text([as_data(one) for one in maps], indent=None) + "\n"
    files = {PAGE: page(maps).encode(), "stability.json": data.encode()}
    for one in maps:
        files |= pictures(one)
    write_files(out, files)
    return page(maps)


def as_data(found: Map) -> dict[str, Any]:
    """The beam, the speeds and the values of the other number of a map, and its methods."""
    plane = found.plane
    data = {"over": plane.over, "beam": plane.beam.numbers}
    data |= {"gamma": found.gammas, "values": found.values}
    data["methods"] = {one.method.name: method_data(found, one) for one in found.methods}
    reference = rounded(found.methods[0].speeds("buckling"))
    return data if plane.states else {**data, "buckling": reference}


def method_data(found: Map, one: MethodMap) -> dict[str, Any]:
    """The data of a method: its stable states, or its verdicts with a command for every cell that
    is not correct."""
    options = one.method.options
    if one.refusal:
        return {"options": options, "says": one.refusal}
    limit, buckling, loss = (rounded(one.speeds(name)) for name in ("limit", "buckling", "loss"))
    if found.plane.states:
        given = options | found.plane.options
        return {"options": given, "states": one.kinds, "buckling": buckling, "limit": limit}
    verdicts = {"options": options, "kinds": one.kinds, "limit": limit, "false loss": loss}
    return {**verdicts, "failing": list(failing(found, one))}


def failing(found: Map, one: MethodMap) -> Iterator[dict[str, Any]]:
    """Each failing cell of a method: the verdict, its errors, and the command that shows it."""
    for value, row in zip(found.values.tolist(), one.rows, strict=True):
        for gamma, verdict in zip(found.gammas.tolist(), row.cells, strict=True):
            if verdict.kind not in CORRECT:
                discretisation, model = rounded((verdict.discretisation, verdict.model))
                yield {
                    "gamma": gamma,
                    found.plane.over: value,
                    "kind": verdict.kind.name,
                    "discretisation error": discretisation,
                    "model error": model,
                    "says": verdict.message,
                    "command": command(found.plane.at(gamma, value), one.method.options),
                }


def command(beam: Beam, options: dict[str, Any]) -> str:
    """The command that solves a beam with options of `solve`."""
    numbers = {name: f"{value:.10g}" for name, value in beam.numbers.items()}
    given = {**numbers, "modes": compute.MODES, **options}
    return " ".join(["beamviz modes", *(f"--{name} {value}" for name, value in given.items())])


def rounded(values: Iterable[float]) -> list[float]:
    """Numbers to seven digits."""
    return [float(f"{value:.7g}") for value in values]


def page(maps: list[Map]) -> str:
    """Shares of each kind, and for each method and kind the slowest beam that shows it."""
    parts = ["# Where methods fail", "Shares of the cells of each map [%]."]
    for found in maps:
        symbol = PARAMETERS[found.plane.over].symbol
        heading = TEXTS[found.plane.kinds][0].format(symbol)
        parts += [f"## {heading}", f"At constant speed, {found.plane.held}."]
        parts += [shares(found), "\n".join(["```", *commands(found), "```"])]
    return "\n\n".join(parts) + "\n"


def shares(found: Map) -> str:
    """A table of the share [%] of each kind; one more column where methods refuse, with why."""
    heads, rows = ["says"] * any(one.refusal for one in found.methods), []
    for one in found.methods:
        accepted = one.kinds[one.kinds != compute.OUTSIDE.name]
        counts = [np.count_nonzero(accepted == kind.name) for kind in found.plane.kinds]
        texts = [f"{100 * count / accepted.size:.0f}" if count else "" for count in counts]
        rows.append([one.method.name, *texts, *[one.refusal] * len(heads)])
    return markdown_table(["method", *(kind.name for kind in found.plane.kinds), *heads], rows)


def commands(found: Map) -> Iterator[str]:
    """The command of the slowest beam of each method and each kind that is not correct."""
    for one, kind in product(found.methods, found.plane.kinds):
        places = np.argwhere(np.isin(one.kinds.T, kind.name))  # slowest first
        if kind not in CORRECT and len(places):
            column, row = places[0]
            beam = found.plane.at(found.gammas[column], found.values[row])
            yield f"# {one.method.name}: {kind.meaning}"
            yield command(beam, one.method.options | found.plane.options)


# The pictures.

COLUMNS = 4
WIDTH, ROW, HEAD, FOOT = 11.0, 2.23, 0.94, 0.56  # [in]
TICKS = (1, 3, 10, 30, 100)
ANSYS = (40.0, 50.0)  # gamma at delta 1 for which the paper reports that ANSYS diverges
SMALLEST_NAMED = 0.035  # region, of the panel
SMALLEST_LOSS = 0.02  # of the panel must be falsely unstable for its boundary to be drawn
LETTER = 0.024  # width, of the panel
BUCKLING = (0, (3, 2))
CELLS: dict[str, Any] = {"linewidth": 0, "antialiased": False, "zorder": 1}
ABOVE: dict[str, Any] = {"textcoords": "offset points", "ha": "right", "va": "top", "zorder": 5}
TEXTS = {  # of a sheet: its two lines of heading, and the meanings of a line and of a dashed line
    KINDS: (
        "Where methods fail: speed γ and {}",
        "Five lowest modes in the plane of rotation, {}. Reference: the paper's model (green"
        " strain, spatial curvature), solved by auto.",
        "exact boundary of a failure",
        "where the beam buckles",
    ),
    STATES: (
        "Stable states of an inward beam: speed γ and {}",
        "At constant speed, {}. Bent in the plane of rotation.",
        "end of the stable states",
        "where the straight beam buckles",
    ),
}


@rc_context(STYLE)
def pictures(found: Map) -> Files:
    """The sheet of one plane as PNG and SVG, by file name: a panel for each method that does not
    refuse, one for the legend, and one for the others."""
    plane, across = found.plane, PARAMETERS[found.plane.over].axis_label
    heading, subtitle, *_ = TEXTS[plane.kinds]
    shown = [one for one in found.methods if not one.refusal]
    unable = [one.method.name for one in found.methods if one.refusal]
    rows = -(-(len(shown) + 1 + bool(unable)) // COLUMNS)
    height = HEAD + rows * ROW + FOOT
    figure = new_figure(WIDTH, height)
    figure.subplots_adjust(0.07, FOOT / height, 0.985, 1 - HEAD / height, 0.08, 0.2)
    panels = figure.subplots(rows, COLUMNS, sharex=True, sharey=True).ravel()
    head: dict[str, Any] = {"x": 0.012, "va": "center"}
    figure.text(y=1 - 0.27 / height, s=heading.format(across), weight="bold", size=12, **head)
    text = subtitle.format(plane.held)
    figure.text(y=1 - 0.54 / height, s=text, color="#555555", size=9, **head)
    for axes in panels[len(shown) :]:
        axes.set_axis_off()
    for axes in panels[::COLUMNS]:
        axes.set_ylabel(across)
    for axes, one in zip(panels, shown, strict=False):
        draw_panel(axes, found, one)
    for axes in panels[max(len(shown) - COLUMNS, 0) : len(shown)]:
        axes.tick_params(labelbottom=True)
        axes.set_xlabel(PARAMETERS["gamma"].axis_label)
    draw_legend(panels[len(shown)], found, shown)
    if unable:
        text = "\n".join(["These methods have no bent states:", "", *unable])
        axes = panels[len(shown) + 1]
        axes.text(0.0, 0.94, text, transform=axes.transAxes, va="top", size=7.2)
    return picture_files(figure, f"stability-{'states' if plane.states else plane.over}")


def draw_legend(axes: Axes, found: Map, shown: list[MethodMap]) -> None:
    """Explain colours and both kinds of line in the place of a panel: of failures what is there."""
    states, (*_, boundary, buckling) = found.plane.states, TEXTS[found.plane.kinds]
    present = {name for one in shown for name in one.kinds.flat}
    handles: list[Any] = []
    for kind in found.plane.kinds if states else (*found.plane.kinds, compute.OUTSIDE):
        if states or kind.name in present:
            text = kind.meaning + ("" if kind.name in present else " (nowhere here)")
            look: dict[str, Any] = {"fc": kind.face, "hatch": kind.hatch, "ec": STRIPES, "lw": 0.6}
            handles.append(Patch(label=fill(text, 38), **look))
    line: dict[str, Any] = {"color": INK, "lw": 1.2}
    handles.append(Line2D([], [], label=boundary, **line))
    if states or np.isfinite(shown[0].speeds("buckling")).any():
        handles.append(Line2D([], [], label=buckling, ls=BUCKLING, **line))
    place: dict[str, Any] = {"loc": "upper left", "bbox_to_anchor": (0, 0.97), "borderaxespad": 0}
    axes.legend(handles=handles, frameon=False, fontsize=7.2, **place)


def draw_panel(axes: Axes, found: Map, one: MethodMap) -> None:
    """One method: its cells, and the boundaries that are known exactly."""
    kinds, options, plane = one.kinds, one.method.options, found.plane
    draw_cells(axes, plane, kinds)
    boundaries = [one.speeds("limit")]
    if np.mean(kinds == compute.FALSELY_UNSTABLE.name) > SMALLEST_LOSS:
        boundaries.append(one.speeds("loss"))
    for gammas, ls in (*product(boundaries, "-"), (one.speeds("buckling"), BUCKLING)):
        axes.plot(gammas, found.values, color="white", lw=2.8, zorder=2)
        axes.plot(gammas, found.values, color=INK, lw=1.2, ls=ls, zorder=3)
    resolution = "".join(f"{options[k]} {k}" for k in ("elements", "terms") if k in options)
    axes.set_title(one.method.name, loc="left", size=10, pad=3, weight="bold")
    axes.set_title(resolution, loc="right", size=8.5, pad=3, color="#555555")
    if not plane.states:
        for gammas in boundaries:
            label_constant(axes, gammas)
        if plane.over == "delta" and "hencky" in one.method.name:
            mark_ansys(axes)


def draw_cells(axes: Axes, plane: Plane, names: np.ndarray) -> None:
    """Cells of kinds (rows, columns) over the speed and the plane's number."""
    x = compute.edges(compute.SLOWEST, compute.FASTEST, names.shape[1], True)
    y = compute.edges(plane.start, plane.stop, names.shape[0], plane.logarithmic)
    axes.set_xscale("log")
    axes.set_yscale("log" if plane.logarithmic else "linear")
    axes.set(xlim=x[[0, -1]], ylim=y[[0, -1]], facecolor=compute.OUTSIDE.face)
    axes.set_xticks(TICKS, [str(tick) for tick in TICKS])
    axes.minorticks_off()
    for kind in plane.kinds:
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
    error: Any = compute.answer(Beam(gamma=ANSYS[-1], delta=1), strain="hencky")
    axes.plot(ANSYS, [1, 1], ls="", marker="o", ms=4, mfc="white", mec=INK, mew=0.8, zorder=5)
    text = f"paper: ANSYS\ndiverges;\nlimit {error.limit:.2f}"
    axes.annotate(text, (compute.FASTEST, 1), (-2, -5), size=6.2, color="white", **ABOVE)
