"""The paper's figures as pictures."""

import io
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from beamviz.beam import PARAMETERS
from beamviz.frequency_loci import Branch, Loci
from beamviz.paper.data import LociFigure, ShapeFigure, parameters
from beamviz.paper.figures import EQ_16, OTHER, Curve, Met
from beamviz.paper.values import decimals
from beamviz.plotting.labels import EndLabel, LabelPlacer, label_line_ends
from beamviz.plotting.style import COLOURS, DPI, FAINT, INK, OMEGAS, RING, STYLE
from beamviz.solver import solve

WIDTH, HEIGHT = 7.2, 4.8  # [in]
LEFT = 0.095  # of the width: left end of every frame
LINES: dict[str, dict[str, Any]] = {
    EQ_16: {"lw": 1.6, "ls": "-"},
    OTHER: {"lw": 0.9, "ls": (0, (4, 2.5))},
}
DOT: dict[str, Any] = {"marker": "o", "ls": "", "ms": 3.2, "color": INK}
MARKS = {EQ_16: RING, OTHER: DOT}
LABELS = {EQ_16: "spatial curvature (eq. 16)", OTHER: "material curvature"}
TICK: dict[str, Any] = {"marker": "|", "ls": "", "ms": 13, "mew": 1.2, "color": INK}


def saved(picture: Figure) -> dict[str, bytes]:
    """The picture as the bytes of files, by the ending of their names."""
    files = {}
    for ending in ("png", "svg"):
        buffer = io.BytesIO()
        dated = {"Date": None} if ending == "svg" else None
        with rc_context(STYLE):
            picture.savefig(buffer, format=ending, dpi=DPI, metadata=dated)
        files[ending] = buffer.getvalue()
    return files


def loci_plot(figure: LociFigure, found: dict[str, Loci], met: Sequence[Met]) -> Figure:
    """Frequencies with their crossings, and what the paper prints of them."""
    with rc_context(STYLE):
        picture, axes = _sheet(figure, HEIGHT)
        for name, chart in found.items():
            for branch in chart.branches:
                _branch(axes, chart.values, branch, LINES[name])
        axes.set(xlim=(0, figure.stop), ylim=(0, 1.05 * axes.dataLim.y1))
        axes.set(xlabel=PARAMETERS[figure.over].axis_label, ylabel="frequency ω [1/T*]")
        axes.locator_params(nbins=10, steps=(1, 2, 5, 10))
        first = found[EQ_16].branches
        label_line_ends(
            axes, [_end(row.frequency[-1], row.label, str(row.family[-1])) for row in first]
        )
        placer = LabelPlacer(axes)
        for row in met:
            _crossing(axes, placer, row)
        if figure.constants:
            _unchanged(axes, placer, figure)
        _legend(picture, found, met)
    return picture


def _sheet(
    figure: LociFigure | ShapeFigure, height: float, right: float = 0.92
) -> tuple[Figure, Axes]:
    """A picture with one frame, and above it what is held fixed."""
    picture = Figure(figsize=(WIDTH, height))
    FigureCanvasAgg(picture)
    low, high = 0.5 / height, 1 - (0.52 if isinstance(figure, LociFigure) else 0.32) / height
    axes = picture.add_axes((LEFT, low, right - LEFT, high - low))
    picture.text(0.012, 1 - 0.12 / height, _title(figure), va="center", weight="bold")
    return picture, axes


def _title(figure: LociFigure | ShapeFigure) -> str:
    return f"Figure {figure.name.removeprefix('fig')}:  {parameters(figure)}"


def _branch(axes: Axes, values: np.ndarray, branch: Branch, style: dict[str, Any]) -> None:
    """One locus in the colour of its family."""
    family = np.array(branch.family, object)
    for name, colour in COLOURS.items():
        if name in branch.family:
            axes.plot(
                values, np.where(family == name, branch.frequency, np.nan), color=colour, **style
            )


def _end(height: float, label: str, family: str) -> EndLabel:
    """What a line is called at its right end."""
    return height, label, COLOURS[family], "bold"


def _crossing(axes: Axes, placer: LabelPlacer, met: Met) -> None:
    """A crossing by eq. 16, with the other measure, and a tick where it is printed."""
    event, other = met.events[EQ_16], met.events.get(OTHER)
    digits = decimals(met.printed.at) + 2 if met.printed else 3
    words = []
    if met.printed:
        axes.plot(float(met.printed.at), event.frequency, **TICK, zorder=4)
        words.append(f"paper {met.printed.at}")
    if other:
        axes.plot(other.at, other.frequency, **DOT, zorder=6)
        words.append(f"material {other.at:.{digits}f}")
    axes.plot(event.at, event.frequency, **RING, zorder=5)
    words.append(f"{'eq. 16' if other else 'here'} {event.at:.{digits}f}")
    placer.annotate("\n".join(words), event.at, event.frequency)


def _unchanged(axes: Axes, placer: LabelPlacer, figure: LociFigure) -> None:
    """The frequencies without a mass, and where a mass at a node leaves them."""
    free = solve(figure.beam.replace(alpha=0), figure.modes, tolerance=1e-9)
    for mode, printed in figure.constants:
        omega = float(free.frequencies[mode - 1])
        axes.axhline(omega, color=FAINT, lw=0.8, ls=(0, (1, 2)), zorder=0)
        if figure.over == "alpha":
            placer.annotate(
                f"{OMEGAS[mode - 1]} constant\npaper {printed}\nhere {omega:.4f}", 1, omega
            )
        for node in (node for node in figure.nodes if node.mode == mode):
            at = float(min(free.nodes[mode - 1], key=lambda x: abs(x - float(node.at))))
            axes.plot(at, omega, **RING, zorder=5)
            words = f"β, {OMEGAS[mode - 1]}\npaper {node.at}, {printed}\nhere {at:.6f}, {omega:.4f}"
            placer.annotate(words, at, omega)


def _legend(picture: Figure, found: dict[str, Loci], met: Sequence[Met]) -> None:
    """What colours, lines and marks mean, of those drawn."""
    families = {name for chart in found.values() for row in chart.branches for name in row.family}
    rows = [Line2D([], [], color=c, lw=1.6, label=n) for n, c in COLOURS.items() if n in families]
    for name, label in LABELS.items() if OTHER in found else ():
        mark = MARKS[name] if met else {}
        rows.append(Line2D([], [], label=label, **{**mark, "color": INK, **LINES[name]}))
    if met and OTHER not in found:
        rows.append(Line2D([], [], label="crossing", **RING))
    if any(row.printed for row in met):
        rows.append(Line2D([], [], label="in the paper", **TICK))
    picture.legend(
        handles=rows,
        loc="upper left",
        bbox_to_anchor=(0.005, 1 - 0.2 / picture.get_figheight()),
        ncols=len(rows),
        frameon=False,
        fontsize=8,
        handlelength=1.6,
        columnspacing=1.1,
        borderaxespad=0,
    )


def shape_plot(figure: ShapeFigure, found: Sequence[Curve]) -> Figure:
    """Mode shapes: several of one mode in one frame, several modes one above the other."""
    with rc_context(STYLE):
        return _stacked(figure, found) if len(figure.modes) > 1 else _overlaid(figure, found)


def _overlaid(figure: ShapeFigure, found: Sequence[Curve]) -> Figure:
    """One mode for each mass ratio."""
    picture, axes = _sheet(figure, 3.6, right=0.9)
    axes.axhline(0, color=FAINT, lw=0.8, zorder=0)
    for curve, shade in zip(found, np.linspace(1, 0.4, len(found))[::-1], strict=True):
        axes.plot(curve.x, curve.y, color=COLOURS[curve.family], alpha=shade, lw=1.6)
    axes.set(
        xlim=(0, 1),
        ylim=axes.get_ylim(),
        xlabel="x / L",
        ylabel="displacement across, unit modal mass",
    )
    axes.locator_params(axis="y", nbins=7, steps=(1, 2, 5, 10))
    if len(found) > 1:
        label_line_ends(
            axes, [_end(c.y[-1], f"α = {c.solution.beam.alpha:g}", c.family) for c in found]
        )
    placer = LabelPlacer(axes)
    for curve in found:
        axes.plot(curve.nodes, 0 * curve.nodes, **RING, clip_on=False, zorder=5)
    for node in figure.nodes:
        at = float(min(found[0].nodes, key=lambda x: abs(x - float(node.at))))
        placer.annotate(f"node\npaper {node.at}\nhere {at:.6f}", at, 0)
    return picture


def _stacked(figure: ShapeFigure, found: Sequence[Curve]) -> Figure:
    """One frame for each mode."""
    picture = Figure(figsize=(WIDTH, 5.6))
    FigureCanvasAgg(picture)
    picture.text(0.012, 1 - 0.12 / 5.6, _title(figure), va="center", weight="bold")
    frames = picture.subplots(
        len(found),
        sharex=True,
        gridspec_kw={"left": LEFT, "right": 0.77, "top": 0.94, "bottom": 0.09},
    )
    most = 1.15 * max(abs(curve.y).max() for curve in found)
    for axes, curve in zip(frames, found, strict=True):
        axes.axhline(0, color=FAINT, lw=0.8, zorder=0)
        axes.plot(curve.x, curve.y, color=COLOURS[curve.family], lw=1.6)
        axes.plot(curve.nodes, 0 * curve.nodes, **RING, clip_on=False, zorder=5)
        axes.set(xlim=(0, 1), ylim=(-most, most), yticks=[-1, 0, 1])
        omega = curve.solution.frequencies[curve.mode - 1]
        words = [f"mode {curve.mode}: {curve.label}, {curve.family}", f"ω = {omega:.4f}"]
        words += ["stretching in the paper"] * (curve.mode in figure.stretching)
        axes.text(
            1.03,
            0.5,
            "\n".join(words),
            color=COLOURS[curve.family],
            va="center",
            transform=axes.transAxes,
        )
    frames[-1].set_xlabel("x / L")
    picture.supylabel("displacement: across the beam (bending), along it (stretching)", size=9)
    return picture
