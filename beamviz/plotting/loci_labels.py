"""Words in the loci chart: names of lines, notes on meetings, and veerings seen closer."""

from collections.abc import Sequence
from itertools import product
from typing import Any

import numpy as np
from matplotlib import patheffects
from matplotlib.axes import Axes
from matplotlib.transforms import Bbox

from beamviz.frequency_loci import Branch, Event, Loci, close_up
from beamviz.plotting.labels import LabelPlacer, label_line_ends
from beamviz.plotting.loci_lines import FAMILIES, Scales, draw_branch, lines_at, upper
from beamviz.plotting.style import INK

MUTED = "#5A5A5A"
NOTED = 10  # meetings that get words; more would hide the chart
HALO = [patheffects.withStroke(linewidth=3.5, foreground="white")]
MARKS: dict[str, dict[str, Any]] = {
    "crossing": {"marker": "o", "ms": 6, "mfc": "white", "mec": INK, "mew": 1.1, "ls": ""},
    "veering": {"marker": "D", "ms": 5.5, "mfc": INK, "mec": "white", "mew": 0.8, "ls": ""},
    "resonance": {"marker": "x", "ms": 4.5, "mec": INK, "mew": 1.1, "ls": ""},
}
SPOTS = np.linspace(0.1, 0.85, 23)  # along a line: where its name may be
ZOOM_SIZE = (0.27, 0.24)  # of the frame
ZOOM_SPOTS = np.linspace(0.0, 1.0, 15)


def end_labels(
    axes: Axes, scales: Scales, loci: Loci, others: Sequence[tuple[float, str, Any]]
) -> None:
    """Names of the lines that reach the right end, and of others given with their heights."""
    ends = [
        (scales.y(branch.frequency[-1]), branch.label, FAMILIES(branch.bending_fraction[-1]))
        for branch in loci.branches
        if np.isfinite(branch.frequency[-1])
    ]
    ends += others
    label_line_ends(axes, [(*end, "normal" if end[2] == MUTED else "bold") for end in ends])


def inside_labels(axes: Axes, scales: Scales, loci: Loci) -> None:
    """Names on the lines that end inside the frame, or that change their family."""
    taken: list[np.ndarray] = [
        np.array([scales.x(event.at), scales.y(event.frequency)]) for event in loci.events
    ]
    for branch in loci.branches:
        there = np.flatnonzero(np.isfinite(branch.frequency))
        if not len(there):
            continue
        changes = branch.family[there[0]] != branch.family[there[-1]]
        if there[-1] == len(loci.values) - 1 and not changes:
            continue
        spots = there[(SPOTS * (len(there) - 1)).astype(int)]
        if changes:
            spots = spots[: len(spots) // 3]
        k = max(spots, key=lambda k: _room(axes, scales, loci, branch, int(k), taken))
        taken.append(np.array([scales.x(loci.values[k]), scales.y(branch.frequency[k])]))
        axes.text(
            float(taken[-1][0]),
            float(taken[-1][1]),
            branch.label,
            color=FAMILIES(branch.bending_fraction[k]),
            ha="center",
            va="center",
            weight="bold",
            path_effects=HALO,
            zorder=4,
        )


def _room(
    axes: Axes, scales: Scales, loci: Loci, branch: Branch, k: int, taken: list[np.ndarray]
) -> float:
    """The distance [px] from a point of a line to the nearest other line, mark or name."""
    x, y = scales.x(loci.values[k]), scales.y(branch.frequency[k])
    heights = sorted(lines_at(loci, loci.values[k], scales), key=lambda height: abs(height - y))
    points = np.array([(x, y), *((x, height) for height in heights[1:]), *taken])
    pixels = axes.transData.transform(points)
    distances = np.linalg.norm(pixels[1:] - pixels[0], axis=1)
    distances[len(heights) - 1 :] /= 3  # a name or a mark is wider than a line
    return float(min(distances, default=np.inf))


def notes(placer: LabelPlacer, scales: Scales, events: Sequence[Event]) -> None:
    """What each meeting is, and where."""
    for event in events:
        words = [event.kind, scales.told(event.at)]
        if event.kind == "veering":
            words.append(gap(scales, event))
        placer.annotate("\n".join(words), scales.x(event.at), scales.y(event.frequency))


def gap(scales: Scales, event: Event) -> str:
    """The gap of a veering in words."""
    return f"gap {scales.y(event.gap):.3g}{scales.unit}"


def zoom(axes: Axes, placer: LabelPlacer, scales: Scales, loci: Loci, event: Event) -> bool:
    """A veering seen closer in a frame of its own, where there is room for one."""
    corner = _free(axes, placer)
    if corner is None:
        return False
    near = close_up(loci, event)
    if not near.events:
        return False
    frame = axes.inset_axes((*corner, *ZOOM_SIZE), zorder=8)
    for branch in near.branches:
        if branch.label in near.events[0].branches:
            draw_branch(frame, scales, near, branch)
    frame.set(xticks=[], yticks=[], xlim=scales.x(near.values[[0, -1]]))
    frame.margins(y=0.3)
    for side in frame.spines.values():
        side.set(visible=True, color="#B0B0B0", linewidth=0.8)
    words = f"{event.kind} at {scales.told(event.at)}: {gap(scales, event)}"
    frame.set_title(words, fontsize=8, loc="left", pad=3)
    _name_ends(frame, scales, near, loci, event)
    _join(axes, placer, corner, (scales.x(event.at), scales.y(event.frequency)))
    return True


def _free(axes: Axes, placer: LabelPlacer) -> tuple[float, float] | None:
    """The lower left corner, as a share of the frame, of the emptiest place for a zoom."""
    box = axes.get_window_extent(placer.renderer)
    origin, extent = np.array([box.x0, box.y0]), np.array([box.width, box.height])
    size = np.array(ZOOM_SIZE) + (0.03, 0.07)  # with its title, and some room

    def covered(corner: tuple[float, float]) -> int:
        low = origin + extent * corner
        high = low + extent * size
        hidden = ((placer.line_points > low) & (placer.line_points < high)).all(axis=1).sum()
        clashes = (
            other.x1 > low[0] and other.x0 < high[0] and other.y1 > low[1] and other.y0 < high[1]
            for other in placer.taken
        )
        return int(hidden) + 1000 * sum(clashes)

    spots = [
        (x * (1 - size[0]) + 0.015, y * (1 - size[1]) + 0.015)
        for y, x in product(ZOOM_SPOTS[::-1], ZOOM_SPOTS)
    ]
    best = min(spots, key=covered)
    return best if covered(best) == 0 else None


def _name_ends(frame: Axes, scales: Scales, near: Loci, loci: Loci, event: Event) -> None:
    """The names of the two lines at both ends of a zoom, in the colours they have there."""
    high = upper(loci, event)
    low = next(label for label in event.branches if label != high)
    names = {upper(near, near.events[0]): high}
    for branch in near.branches:
        if branch.label not in near.events[0].branches:
            continue
        label = names.get(branch.label, low)
        for end, side, ha in ((0, 1, "left"), (-1, -1, "right")):
            frame.annotate(
                label,
                (scales.x(near.values[end]), scales.y(branch.frequency[end])),
                (3 * side, 7 if label == high else -7),
                textcoords="offset points",
                color=FAMILIES(branch.bending_fraction[end]),
                ha=ha,
                va="center",
                fontsize=8,
                weight="bold",
            )


def _join(
    axes: Axes, placer: LabelPlacer, corner: tuple[float, float], mark: tuple[float, float]
) -> None:
    """A thin line from a zoom to its mark; the zoom is taken from now on."""
    low = np.array(corner)
    high = low + ZOOM_SIZE
    here = axes.transAxes.inverted().transform(axes.transData.transform(mark))
    axes.annotate(
        "",
        mark,
        tuple(np.clip(here, low, high)),
        textcoords="axes fraction",
        arrowprops={"arrowstyle": "-", "lw": 0.6, "color": "#555555", "shrinkA": 0, "shrinkB": 4},
        zorder=7,
    )
    box = axes.transAxes.transform([low, high + (0, 0.07)])
    placer.taken.append(Bbox(box))
