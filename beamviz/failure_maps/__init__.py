"""beamviz stability: maps of where methods fail, and of the stable states of an inward beam, as
pictures, data and text.

A picture is a sheet for each plane with a panel for each method. Colours are safe for the
colour-blind and in grey: lightness falls from kind to kind, and hatches help. Large regions carry
their name.
"""

from collections.abc import Iterable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from operator import itemgetter
from pathlib import Path
from textwrap import fill
from typing import Any, NamedTuple

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from beamviz.beam import PARAMETERS, Beam
from beamviz.failure_maps import compute
from beamviz.failure_maps.compute import CORRECT, METHODS, Map, Plane
from beamviz.files import Files, json_text, make_folder, markdown_table, write_files
from beamviz.plotting import FAINT, INK, STYLE, new_figure, picture_files
from beamviz.sweeps.quantities import connected

PAGE = "stability.md"
QUICK, QUICK_STATES = (14, 9), (10, 6)  # cells along the speed and across
FULL, FULL_STATES = (32, 20), (22, 12)
STABLE = {"state": "stable"}
FAILURES = {kind: kind for kind in compute.KINDS if kind not in CORRECT}


def stability(out: Path, quick: bool) -> str:
    """Compute every map and write pictures, stability.json and stability.md; the text of the page.

    Raises Unavailable, before anything is computed, for a folder that cannot be written to.
    """
    make_folder(out)
    size, state_size = (QUICK, QUICK_STATES) if quick else (FULL, FULL_STATES)
    with ProcessPoolExecutor(mp_context=get_context("spawn")) as pool:
        found = [compute.compute_map(plane, size, pool) for plane in compute.PLANES]
        states = compute.compute_map(compute.INWARD, state_size, pool)
    write_files(out, files(found, states))
    return page(found, states)


def files(found: list[Map], states: Map) -> Files:
    """Pictures, data and text by file name."""
    text = json_text([as_data(one) for one in (*found, states)], indent=None) + "\n"
    contents = {PAGE: page(found, states).encode(), "stability.json": text.encode()}
    for one in found:
        contents |= pictures(one)
    return contents | state_pictures(states)


def as_data(found: Map) -> dict[str, Any]:
    """The beam, the speeds and the values of the other number of a map, and its methods."""
    data = {
        "over": found.plane.over,
        "beam": found.plane.beam.numbers,
        "gamma": found.gammas,
        "values": found.values,
        "methods": {method.name: method_data(found, k) for k, method in enumerate(METHODS)},
    }
    reference = {} if found.plane.states else {"buckling": rounded(found.speeds(0, "buckling"))}
    return data | reference


def method_data(found: Map, method: int) -> dict[str, Any]:
    """The data of a method: its stable states, or its verdicts with a command for every cell that
    is not correct."""
    options, kinds = METHODS[method].options, found.kinds(method)
    if refusal := found.refusal(method):
        return {"options": options, "says": refusal}
    limit, buckling, loss = (
        rounded(found.speeds(method, name)) for name in ("limit", "buckling", "loss")
    )
    if found.plane.states:
        return {"options": options | STABLE, "states": kinds, "buckling": buckling, "limit": limit}
    verdicts = {"options": options, "kinds": kinds, "limit": limit, "false loss": loss}
    return {**verdicts, "failing": list(failing(found, method))}


def failing(found: Map, method: int) -> Iterator[dict[str, Any]]:
    """Each failing cell of a method: the verdict, its errors, and the command that shows it."""
    for value, row in zip(found.values.tolist(), found.rows[method], strict=True):
        for gamma, verdict in zip(found.gammas.tolist(), row.cells, strict=True):
            if verdict.kind not in CORRECT:
                discretisation, model = rounded((verdict.discretisation, verdict.model))
                yield {
                    "gamma": gamma,
                    found.plane.over: value,
                    "kind": verdict.kind,
                    "discretisation error": discretisation,
                    "model error": model,
                    "says": verdict.message,
                    "command": command(found.plane.at(gamma, value), METHODS[method].options),
                }


def command(beam: Beam, options: dict[str, Any]) -> str:
    """The command that solves a beam with options of `solve`."""
    numbers = {name: f"{value:.10g}" for name, value in beam.numbers.items()}
    given = {**numbers, "modes": compute.MODES, **options}
    return " ".join(["beamviz modes", *(f"--{name} {value}" for name, value in given.items())])


def rounded(values: Iterable[float]) -> list[float]:
    """Numbers to seven digits."""
    return [float(f"{value:.7g}") for value in values]


def page(found: list[Map], states: Map) -> str:
    """Shares of each kind, and for each method and kind the slowest beam that shows it."""
    parts = ["# Where methods fail", "", "Shares of the cells of each map [%].", ""]
    for one in found:
        parts += [f"## Speed γ and {PARAMETERS[one.plane.over].symbol} ({one.plane.held})", ""]
        parts += [shares(one, compute.KINDS), "", *commands(one, FAILURES, {}), ""]
    parts += [f"## Stable states: speed γ and {PARAMETERS[states.plane.over].symbol}", ""]
    parts += [f"An inward beam at constant speed, {states.plane.held}.", ""]
    parts += [shares(states, compute.STATES, "says"), ""]
    parts += [*commands(states, compute.STATES, STABLE), ""]
    return "\n".join(parts)


def shares(found: Map, kinds: Iterable[str], *heads: str) -> str:
    """A table of the share [%] of each kind; one more column with the message of a refusal."""
    rows = []
    for k, method in enumerate(METHODS):
        cells = found.kinds(k)
        accepted = cells[cells != compute.OUTSIDE]
        percent = [100 * np.mean(accepted == kind) if accepted.size else 0 for kind in kinds]
        texts = [f"{p:.0f}" if p else "" for p in percent]
        rows.append([method.name, *texts, *[found.refusal(k)] * len(heads)])
    return markdown_table(["method", *kinds, *heads], rows)


def commands(found: Map, names: Mapping[str, str], options: dict[str, Any]) -> Iterator[str]:
    """The command of the slowest beam of each method and each of the kinds named, as a block."""
    yield "```"
    for k, method in enumerate(METHODS):
        places: dict[str, tuple[float, float]] = {}
        for gamma, column in zip(found.gammas, found.kinds(k).T, strict=False):  # none if refused
            for value, kind in zip(found.values, column, strict=True):
                places.setdefault(str(kind), (gamma, value))
        for kind in (kind for kind in names if kind in places):
            yield f"# {method.name}: {names[kind]}"
            yield command(found.plane.at(*places[kind]), method.options | options)
    yield "```"


# The pictures.

COLUMNS = 4
WIDTH, HEIGHT = 11.0, 8.2  # [in]
TICKS = (1, 3, 10, 30, 100)
ANSYS = (40.0, 50.0)  # gamma at delta 1 for which the paper reports that ANSYS diverges
SMALLEST_NAMED = 0.035  # region, of the panel
SMALLEST_LOSS = 0.02  # of the panel must be falsely unstable for its boundary to be drawn
LETTER = 0.024  # width, of the panel
CONSTANT = 1e-3  # largest relative difference of speeds called the same
REFUSED = "#F0F0F0"
BUCKLING = (0, (3, 2))
HATCHED = STYLE | {"hatch.linewidth": 0.5}
EDGE: dict[str, Any] = {"ec": "#777777", "lw": 0.6}
ABOVE: dict[str, Any] = {"textcoords": "offset points", "ha": "right", "va": "top", "zorder": 5}


class CellStyle(NamedTuple):
    """How a kind of verdict is drawn, and the label of its regions."""

    face: str
    hatch: str
    ink: str
    label: str


CELL_STYLES = {
    compute.RIGHT: CellStyle("#FFFFFF", "", FAINT, "right"),
    compute.INACCURATE: CellStyle("#F7E98E", "", INK, "inaccurate"),
    compute.OTHER_MODEL: CellStyle("#A9D3F0", "", INK, "model\noff > 1 %"),
    compute.TRULY_UNSTABLE: CellStyle("#C4C4C4", "////", INK, "truly\nunstable"),
    compute.ROUNDING: CellStyle("#6FBFA6", "....", INK, "rounding"),
    compute.NOT_CONVERGED: CellStyle("#A0508A", "xxx", "white", "did not\nconverge"),
    compute.FALSELY_UNSTABLE: CellStyle("#C44601", "", "white", "falsely\nunstable"),
    compute.NO_EQUILIBRIUM: CellStyle("#2B2B2B", "", "white", "no\nequilibrium"),
}

STATE_STYLES = {
    compute.STRAIGHT: CellStyle("#FFFFFF", "", FAINT, "straight"),
    compute.BENT: CellStyle("#A9D3F0", "", INK, "bent"),
    compute.SEVERAL: CellStyle("#6FBFA6", "....", INK, "more\nthan one"),
    compute.NO_STATE: CellStyle("#2B2B2B", "", "white", "no stable\nstate"),
    compute.NOT_CONVERGED: CELL_STYLES[compute.NOT_CONVERGED],
}


def new_sheet(
    plane: Plane, shape: tuple[int, int], height: float, margins: tuple[float, ...], *heading: str
) -> tuple[Figure, np.ndarray]:
    """A figure with rows and columns of panels over a plane, and its heading: two lines."""
    across = PARAMETERS[plane.over].axis_label
    figure = new_figure(WIDTH, height)
    figure.subplots_adjust(*margins)
    panels = figure.subplots(*shape, sharex=True, sharey=True).ravel()
    for axes in panels[:: shape[1]]:
        axes.set_ylabel(across)
    title = f"{heading[0]}: speed γ and {across}"
    figure.text(0.012, 1 - 0.27 / height, title, va="center", weight="bold", size=12)
    figure.text(0.012, 1 - 0.54 / height, heading[1], va="center", color="#555555", size=9)
    return figure, panels


@rc_context(HATCHED)
def pictures(found: Map) -> dict[str, bytes]:
    """The sheet of one plane as PNG and SVG, by file name: a panel for each method."""
    subtitle = (
        f"Five lowest modes in the plane of rotation, {found.plane.held}. Reference: the paper's"
        " model (green strain, spatial curvature), solved by auto."
    )
    shape = -(-(len(METHODS) + 1) // COLUMNS), COLUMNS
    margins = 0.062, 0.068, 0.985, 0.885, 0.08, 0.2
    figure, panels = new_sheet(found.plane, shape, HEIGHT, margins, "Where methods fail", subtitle)
    for k, axes in enumerate(panels[: len(METHODS)]):
        limits = [found.speeds(k, "limit")]
        if np.mean(found.kinds(k) == compute.FALSELY_UNSTABLE) > SMALLEST_LOSS:
            limits.append(found.speeds(k, "loss"))
        draw_panel(axes, found, k, CELL_STYLES, limits)
        for limit in limits:
            if np.isfinite(limit).any():
                label_constant(axes, limit)
        if found.plane.over == "delta" and "hencky" in METHODS[k].name:
            mark_ansys(axes)
    for axes in panels[-COLUMNS:]:
        axes.set_xlabel(PARAMETERS["gamma"].axis_label)
    present = set(np.unique([found.kinds(k) for k in range(len(METHODS))]))
    meanings = [(CELL_STYLES[k], compute.KINDS[k]) for k in CELL_STYLES if k in present]
    if compute.OUTSIDE in present:
        meanings.append((CellStyle(REFUSED, "", INK, ""), "not accepted: γ above 5 μ"))
    buckles = np.isfinite(found.speeds(0, "buckling")).any()
    buckling = "where the beam buckles" if buckles else ""
    draw_legend(panels[-1], meanings, "exact boundary of a failure", buckling)
    return picture_files(figure, f"stability-{found.plane.over}")


@rc_context(HATCHED)
def state_pictures(found: Map) -> dict[str, bytes]:
    """The map of stable states as PNG and SVG, by file name: a panel for each method that bends."""
    heading = "Stable states of an inward beam"
    subtitle = f"At constant speed, {found.plane.held}. Bent in the plane of rotation."
    margins = 0.07, 0.09, 0.985, 0.845, 0.08, 0.36
    figure, panels = new_sheet(found.plane, (2, 3), 6.0, margins, heading, subtitle)
    able = [k for k in range(len(METHODS)) if not found.refusal(k)]
    for axes, k in zip(panels, able, strict=False):
        draw_panel(axes, found, k, STATE_STYLES, [found.speeds(k, "limit")])
        axes.tick_params(labelbottom=True)
        axes.set_xlabel(PARAMETERS["gamma"].axis_label)
    present = set(np.unique([found.kinds(k) for k in able]))
    meanings = [
        (style, compute.STATES[kind] + ("" if kind in present else " (nowhere here)"))
        for kind, style in STATE_STYLES.items()
    ]
    lines = "end of the stable states", "where the straight beam buckles"
    draw_legend(panels[-2], meanings, *lines)
    unable = [method.name for k, method in enumerate(METHODS) if k not in able]
    text = "These methods have no bent states:\n\n" + "\n".join(unable)
    panels[-1].set_axis_off()
    panels[-1].text(0.0, 0.98, text, transform=panels[-1].transAxes, va="top", size=7.2)
    return picture_files(figure, "stability-states")


def draw_legend(
    axes: Axes, meanings: list[tuple[CellStyle, str]], boundary: str, buckling: str
) -> None:
    """Explain colours and both kinds of line, those that have a text, in the place of a panel."""
    axes.set_axis_off()
    handles: list[Any] = [
        Patch(fc=style.face, hatch=style.hatch, label=fill(text, 38), **EDGE)
        for style, text in meanings
    ]
    for text, ls in ((boundary, "-"), (buckling, BUCKLING)):
        handles += [Line2D([], [], color=INK, lw=1.2, ls=ls, label=text)] if text else []
    axes.legend(handles=handles, loc="upper left", frameon=False, fontsize=7.2, borderaxespad=0)


def draw_panel(
    axes: Axes, found: Map, method: int, styles: dict[str, CellStyle], limits: list[np.ndarray]
) -> None:
    """One method: its cells, and boundaries given as a speed for each row."""
    draw_cells(axes, found.plane, found.kinds(method), styles)
    buckling = found.speeds(method, "buckling")
    for gammas, ls in [*((limit, "-") for limit in limits), (buckling, BUCKLING)]:
        axes.plot(gammas, found.values, color="white", lw=2.8, zorder=2)
        axes.plot(gammas, found.values, color=INK, lw=1.2, ls=ls, zorder=3)
    options = METHODS[method].options
    resolution = "".join(f"{options[k]} {k}" for k in ("elements", "terms") if k in options)
    axes.set_title(METHODS[method].name, loc="left", size=10, pad=3, weight="bold")
    axes.set_title(resolution, loc="right", size=8.5, pad=3, color="#555555")


def draw_cells(axes: Axes, plane: Plane, names: np.ndarray, styles: dict[str, CellStyle]) -> None:
    """Cells of kinds (rows, columns) over the speed and the plane's number."""
    x = compute.edges(compute.SLOWEST, compute.FASTEST, names.shape[1], True)
    y = compute.edges(plane.start, plane.stop, names.shape[0], plane.logarithmic)
    axes.set_xscale("log")
    axes.set_yscale("log" if plane.logarithmic else "linear")
    axes.set(xlim=x[[0, -1]], ylim=y[[0, -1]], facecolor=REFUSED)
    axes.set_xticks(TICKS, [str(tick) for tick in TICKS])
    axes.minorticks_off()
    for kind, style in styles.items():
        here = names == kind
        if here.any():
            edge = "none" if not style.hatch else "white" if style.ink == "white" else "#777777"
            axes.pcolor(
                *(x, y, np.ma.masked_where(~here, here)),
                cmap=ListedColormap([style.face]),
                hatch=style.hatch,
                edgecolor=edge,
                linewidth=0,
                antialiased=False,
                zorder=1,
            )
            label_region(axes, x, y, here, style)


def label_region(
    axes: Axes, x: np.ndarray, y: np.ndarray, here: np.ndarray, style: CellStyle
) -> None:
    """Label the largest connected region of a kind at its widest place, if there is room."""
    share, row, column = max(connected(here, (1.2, 1.0)), key=itemgetter(0))
    outside = np.flatnonzero(~np.pad(here[row], 1))  # of the padded row: one to the right
    left = int(outside[outside <= column].max())
    right = int(outside[outside > column].min()) - 1
    longest = max(len(line) for line in style.label.split("\n"))
    if share < SMALLEST_NAMED or (right - left) / here.shape[1] < LETTER * longest:
        return
    place = (x[left] * x[right]) ** 0.5, (y[row] + y[row + 1]) / 2
    box = {"fc": style.face, "ec": "none", "pad": 0.8} if style.hatch else None
    text: dict[str, Any] = {"size": 7.5, "color": style.ink, "bbox": box, "clip_on": True}
    axes.text(*place, style.label, ha="center", va="center", zorder=4, **text)


def label_constant(axes: Axes, gammas: np.ndarray) -> None:
    """Write the speed beside a boundary where it is the same in most rows."""
    speed = np.nanmedian(gammas)
    if np.sum(abs(gammas - speed) < CONSTANT * speed) < len(gammas) / 2:
        return
    top = axes.get_xaxis_transform()
    axes.annotate(f"γ = {speed:#.4g}", (speed, 1), (-3, -3), xycoords=top, size=7.5, **ABOVE)


def mark_ansys(axes: Axes) -> None:
    """Mark the paper's ANSYS runs: beyond the limit of a beam with logarithmic strain."""
    error: Any = compute.answer(Beam(gamma=ANSYS[-1], delta=1), strain="hencky")
    axes.plot(ANSYS, [1, 1], ls="", marker="o", ms=4, mfc="white", mec=INK, mew=0.8, zorder=5)
    text = f"paper: ANSYS\ndiverges;\nlimit {error.limit:.2f}"
    axes.annotate(text, (compute.FASTEST, 1), (-2, -5), size=6.2, color="white", **ABOVE)
