"""Labels of a chart: beside points, at the ends of lines, and in a legend."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib import patheffects
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.transforms import Bbox

DISTANCES = (9.0, 32.0)  # [pt] from a point to its label, the nearer preferred
DIRECTIONS = np.array(  # from a point to the middle of its label, the first preferred
    [(0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1), (1, 0), (-1, 0)]
)
SAMPLES = 400  # of each line
LINE_HEIGHT = 12.0  # [pt]
ASIDE = 6.0  # [pt] from the end of a line to its label
HALO = [patheffects.withStroke(linewidth=2.5, foreground="white")]  # over lines
OFFSET: dict[str, Any] = {"textcoords": "offset points", "va": "center"}
LABEL: dict[str, Any] = {**OFFSET, "ha": "center", "fontsize": 8, "path_effects": HALO, "zorder": 7}
LEGEND: dict[str, Any] = {"loc": "center left", "frameon": False, "fontsize": 8}
LEGEND |= {"handlelength": 1.6, "columnspacing": 1.2, "borderaxespad": 0, "borderpad": 0}

EndLabel = tuple[float, str, Any, str]  # height, text, colour and font weight


class LabelPlacer:
    """Places labels one by one beside their points, on the side where they cover least."""

    def __init__(self, axes: Axes):
        self.axes = axes
        figure: Any = axes.get_figure(root=True)
        self.point = figure.dpi / 72  # [px]
        self.frame = axes.get_window_extent()
        paths = [line.get_transform().transform_path(line.get_path()) for line in axes.lines]
        dense = [path.interpolated(SAMPLES // len(path) + 1) for path in paths if len(path)]
        self.line_points = np.vstack([np.empty((0, 2)), *(path.vertices for path in dense)])  # [px]
        self.taken: list[Bbox] = [text.get_window_extent() for text in axes.texts]

    def annotate(self, text: str, x: float, y: float, inside: bool = False, **style: Any) -> None:
        """Write a label beside a point of the chart.

        inside: of a region, whose label may hide the point. style: properties of the text.
        """
        label: Any = self.axes.annotate(text, (x, y), (0, 0), **LABEL | style)
        size = label.get_window_extent().size / self.point
        beside = [DIRECTIONS * (size / 2 + distance) for distance in DISTANCES]
        offsets = np.vstack((np.zeros((int(inside), 2)), *beside))
        here = self.axes.transData.transform((x, y))
        boxes = [
            Bbox.from_bounds(*(here + self.point * (offset - size / 2)), *(self.point * size))
            for offset in offsets
        ]
        best = min(range(len(boxes)), key=lambda k: self._hidden(boxes[k]))
        label.set_position(tuple(offsets[best]))
        self.taken.append(boxes[best])

    def _hidden(self, box: Bbox) -> tuple[int, int]:
        """What a label in a box [px] would hide: other labels, or itself outside the frame; and
        points of lines."""
        outside = sum(not self.frame.contains(*corner) for corner in (box.min, box.max))
        return box.count_overlaps(self.taken) + outside, box.count_contains(self.line_points)


def label_line_ends(axes: Axes, ends: Sequence[EndLabel]) -> None:
    """Labels of lines beside their right ends, in their order and raised where they would touch."""
    if not ends:
        return
    low, high = axes.get_ylim()
    figure: Any = axes.get_figure(root=True)
    spacing = LINE_HEIGHT / 72 * figure.dpi / axes.bbox.height * (high - low)
    order = sorted(ends, key=lambda end: end[0])
    offsets = spacing * np.arange(len(order))
    heights = np.maximum.accumulate([end[0] for end in order] - offsets) + offsets
    for (_, text, color, weight), height in zip(order, heights, strict=True):
        place: dict[str, Any] = {"xycoords": ("axes fraction", "data"), **OFFSET}
        axes.annotate(text, (1, height), (ASIDE, 0), color=color, weight=weight, **place)


def draw_legend(figure: Figure, lines: Mapping[str, Any], left: float, middle: float) -> None:
    """A legend in one row at a place in fractions of the figure; lines: styles by their meaning."""
    handles = [Line2D([], [], label=label, **style) for label, style in lines.items()]
    figure.legend(handles=handles, bbox_to_anchor=(left, middle), ncols=len(lines), **LEGEND)
