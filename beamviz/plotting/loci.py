"""The loci chart as a picture: a Campbell diagram when the number varied is the speed."""

import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from beamviz.beam import PARAMETERS
from beamviz.errors import InvalidInput, Unavailable
from beamviz.files import write_files
from beamviz.frequency_loci import Loci
from beamviz.frequency_loci.forced_response import Resonance
from beamviz.frequency_loci.limits import WORDS, Limit
from beamviz.plotting.labels import LabelPlacer
from beamviz.plotting.loci_labels import MARKS, MUTED, NOTED, end_labels, inside_labels, notes, zoom
from beamviz.plotting.loci_lines import FAMILIES, Scales, draw_branch, lines_at
from beamviz.plotting.style import DPI, FAINT, STYLE

KINDS = (".png", ".svg", ".pdf")
WIDTH, HEIGHT = 7.6, 5.2  # [in]
LEFT, RIGHT, BOTTOM, TOP = 0.092, 0.925, 0.098, 0.845  # of it, the frame
ZOOMED = 2  # veerings that get a frame of their own; more would hide the chart
SHADOW = "#EDEDED"
PER_REV: dict[str, Any] = {"color": FAINT, "lw": 0.8, "ls": (0, (5, 3)), "zorder": 1}


def check_suffix(path: Path) -> None:
    """InvalidInput for a picture that is none of KINDS."""
    if path.suffix.lower() not in KINDS:
        raise InvalidInput(f"--plot {path}: must end in {', '.join(KINDS)}")


def save_chart(
    path: Path, loci: Loci, resonances: Sequence[Resonance] = (), per_rev: int = 0
) -> None:
    """Write the chart; the ending of the path says how. Raises InvalidInput, Unavailable."""
    check_suffix(path)
    kind = path.suffix.lower()[1:]
    dated = {"png": None, "svg": {"Date": None}, "pdf": {"CreationDate": None}}[kind]
    buffer = io.BytesIO()
    with rc_context(STYLE):
        draw_chart(loci, resonances, per_rev).savefig(buffer, format=kind, dpi=DPI, metadata=dated)
    try:
        write_files(path.parent, {path.name: buffer.getvalue()})
    except OSError as error:
        raise Unavailable(
            f"cannot write {path}: {error.strerror or error}; choose another place"
        ) from None


def draw_chart(loci: Loci, resonances: Sequence[Resonance] = (), per_rev: int = 0) -> Figure:
    """The chart: loci in the colours of their families, meetings, limits and per-rev lines."""
    scales = Scales.of(loci)
    with rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, HEIGHT), dpi=DPI)
        FigureCanvasAgg(figure)
        axes = figure.add_axes((LEFT, BOTTOM, RIGHT - LEFT, TOP - BOTTOM))
        for branch in loci.branches:
            draw_branch(axes, scales, loci, branch)
        axes.set(xlim=scales.x(loci.values[[0, -1]]), ylim=(0, 1.05 * axes.dataLim.y1))
        axes.set(xlabel=scales.xlabel, ylabel=scales.ylabel)
        axes.locator_params(nbins=10, steps=(1, 2, 5, 10))
        for limit in loci.limits:
            _limit(axes, scales, loci, limit)
        ends = _per_rev(axes, scales, loci, per_rev)
        end_labels(axes, scales, loci, ends)
        _marks(axes, scales, loci, resonances)
        _head(figure, loci, resonances, per_rev)
    return figure


def _limit(axes: Axes, scales: Scales, loci: Loci, limit: Limit) -> None:
    """A part without an equilibrium or a stable one, said in words."""
    first, last = loci.values[[0, -1]]
    ends = scales.x(limit.start), scales.x(limit.stop)
    axes.axvspan(*ends, color=SHADOW, lw=0, zorder=0)
    for edge in {limit.start, limit.stop} - {first, last}:
        axes.plot([scales.x(edge)] * 2, axes.get_ylim(), color=FAINT, lw=1, zorder=1)
    if limit.stop == last and limit.start > first:
        where = f"beyond {scales.told(limit.start)}"
    elif limit.start == first and limit.stop < last:
        where = f"below {scales.told(limit.stop)}"
    else:
        where = f"from {scales.told(limit.start)} to {scales.told(limit.stop)}"
    wide = (limit.stop - limit.start) > 0.28 * (last - first)
    axes.text(
        sum(ends) / 2,
        _widest_gap(lines_at(loci, (limit.start + limit.stop) / 2, scales), axes.get_ylim()[1]),
        f"{WORDS[limit.kind]}\n{where}",
        rotation=0 if wide else 90,
        ha="center",
        va="center",
        color=MUTED,
        multialignment="center",
        clip_on=True,
    )


def _widest_gap(heights: list[float], top: float) -> float:
    """The middle of the widest gap between some heights in a frame."""
    edges = np.array([0.0, *sorted(heights), top])
    k = int(np.diff(edges).argmax())
    return float(edges[k] + edges[k + 1]) / 2


def _per_rev(axes: Axes, scales: Scales, loci: Loci, count: int) -> list[tuple[float, str, Any]]:
    """Lines of whole multiples of the speed; those that leave the frame on top are named there,
    the others are returned with their heights on the right."""
    top, (first, last) = axes.get_ylim()[1], loci.values[[0, -1]]
    on_the_right = []
    for k in range(1, count + 1):
        rate = k * scales.y(1.0)
        end = min(last, top / rate)
        if end <= first:
            continue
        axes.plot(scales.x(np.array([first, end])), [rate * first, rate * end], **PER_REV)
        if end == last:
            on_the_right.append((rate * end, f"{k}×", MUTED))
            continue
        axes.annotate(
            f"{k}×",
            (scales.x(end), top),
            (0, 2),
            textcoords="offset points",
            ha="center",
            va="bottom",
            color=MUTED,
            fontsize=8,
        )
    return on_the_right


def _marks(axes: Axes, scales: Scales, loci: Loci, resonances: Sequence[Resonance]) -> None:
    """Meetings and resonances, and what they and the lines are called."""
    for resonance in resonances:
        place = scales.x(resonance.at), scales.y(resonance.frequency)
        axes.plot(*place, **MARKS["resonance"], zorder=5)
    for event in loci.events:
        axes.plot(scales.x(event.at), scales.y(event.frequency), **MARKS[event.kind], zorder=6)
    inside_labels(axes, scales, loci)
    veerings = [event for event in loci.events if event.kind == "veering"]
    placer = LabelPlacer(axes)
    noted = list(loci.events) if len(loci.events) <= NOTED else []
    for event in veerings if len(veerings) <= ZOOMED else ():
        if zoom(axes, placer, scales, loci, event) and event in noted:
            noted.remove(event)
    notes(placer, scales, noted)


def _head(figure: Figure, loci: Loci, resonances: Sequence[Resonance], per_rev: int) -> None:
    """What is held fixed, the model, and what colours and marks mean."""
    beam, model = loci.beam, loci.problem
    held = ", ".join(
        f"{PARAMETERS[n].symbol} = {beam.numbers[n]:.5g}" for n in PARAMETERS if n != loci.over
    )
    title = f"Loci over {PARAMETERS[loci.over].symbol} at {held}".replace("-", "−")
    coriolis = "with" if model.coriolis else "without"
    theory = (
        f"{model.strain} strain, {model.curvature} curvature, {model.plane}, {coriolis} Coriolis"
    )
    figure.text(0.012, 0.965, title, va="center", weight="bold")
    figure.text(0.012, 0.927, theory, va="center", color=MUTED, fontsize=8)
    figure.legend(
        handles=_legend(loci, resonances, per_rev),
        loc="center left",
        bbox_to_anchor=(0.0085, 0.887),
        ncols=9,
        frameon=False,
        fontsize=8,
        handlelength=1.6,
        columnspacing=1.2,
        borderaxespad=0,
        borderpad=0,
    )


def _legend(loci: Loci, resonances: Sequence[Resonance], per_rev: int) -> list[Line2D]:
    """What colours and marks mean, of those drawn."""
    families = {name for branch in loci.branches for name in branch.family if name}
    rows = [
        Line2D([], [], color=FAMILIES(share), lw=1.7, label=name)
        for name, share in (("bending", 1.0), ("mixed", 0.5), ("stretching", 0.0))
        if name in families
    ]
    for kind in ("crossing", "veering"):
        count = sum(event.kind == kind for event in loci.events)
        words = kind if len(loci.events) <= NOTED else f"{count} {kind}s"
        rows += [Line2D([], [], label=words, **MARKS[kind])] if count else []
    if per_rev:
        rows.append(Line2D([], [], label="per-rev line, k × speed", **PER_REV))
    if resonances:
        rows.append(Line2D([], [], label="resonance", **MARKS["resonance"]))
    return rows
