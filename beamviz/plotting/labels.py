"""Placement of labels in a chart: off its lines, apart from each other, inside its frame."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.path import Path
from matplotlib.transforms import Bbox
from scipy.optimize import isotonic_regression

DISTANCES = (12, 20, 30, 42, 56, 72, 90)  # [pt] from a point to its label
ANGLES = np.radians(np.arange(0, 360, 15))
DIRECTIONS = np.column_stack((np.cos(ANGLES), np.sin(ANGLES)))  # (24, 2)
NEAR = 7.0  # [pt] around a point: lines that the connector to its label may cross
PAD = 3.0  # [pt] around a label
SAMPLES = 800  # of each line
LINE_HEIGHT = 12.0  # [pt]
ASIDE = 6.0  # [pt] from the end of a line to its label
COVERED, CROSSED, FORBIDDEN = 2.0, 40.0, 1e4  # cost of a line sample, a line, a label [pt]
OFFSET: dict[str, Any] = {"textcoords": "offset points", "va": "center"}
CONNECTOR = {"arrowstyle": "-", "lw": 0.6, "color": "#555555", "shrinkA": 0, "shrinkB": 4}
LABEL: dict[str, Any] = {**OFFSET, "ha": "center", "multialignment": "left", "fontsize": 8}
LABEL |= {"arrowprops": CONNECTOR, "zorder": 7}
LEGEND: dict[str, Any] = {"loc": "center left", "frameon": False, "fontsize": 8}
LEGEND |= {"handlelength": 1.6, "columnspacing": 1.2, "borderaxespad": 0, "borderpad": 0}

EndLabel = tuple[float, str, Any, str]  # height, text, colour and font weight


class LabelPlacer:
    """Places labels one by one where they hide least.

    For each label all positions on a few rings around its point are compared by their distance and
    by the lines they cover; other labels and the outside of the frame are forbidden.
    """

    def __init__(self, axes: Axes):
        self.axes = axes
        figure: Any = axes.get_figure(root=True)
        self.point = figure.dpi / 72  # [px]
        self.frame = axes.get_window_extent()
        paths = [line.get_transform().transform_path(line.get_path()) for line in axes.lines]
        self.lines = [path for path in paths if len(path)]  # [px]
        steps = [SAMPLES // max(len(path) - 1, 1) + 1 for path in self.lines]
        dense = [path.interpolated(n) for path, n in zip(self.lines, steps, strict=True)]
        self.line_points = np.vstack([np.empty((0, 2)), *(path.vertices for path in dense)])
        self.taken: list[Bbox] = [text.get_window_extent() for text in axes.texts]

    def annotate(self, text: str, x: float, y: float, inside: bool = False, **style: Any) -> None:
        """Write a label near a point of the chart, with a connector where it is not beside it.

        inside: of a region, whose label may hide the point. style: properties of the text.
        """
        label: Any = self.axes.annotate(text, (x, y), (0, 0), **LABEL | style)
        here = self.axes.transData.transform((x, y))
        size = label.get_window_extent().size / self.point
        reach = (size / 2 / np.maximum(abs(DIRECTIONS), 1e-9)).min(axis=1)  # to the label's edge
        rings = DIRECTIONS[:, None] * np.add.outer(reach, DISTANCES)[..., None]
        offsets = np.vstack((np.zeros((int(inside), 2)), rings.reshape(-1, 2)))
        best = min(offsets, key=lambda offset: self._cost(here, offset, size))
        label.set_position(tuple(best))
        label.arrow_patch.set_visible(_distance(best, size) > DISTANCES[0] + 1)
        self.taken.append(self._box(here, best, size))

    def _box(self, here: np.ndarray, offset: np.ndarray, size: np.ndarray) -> Bbox:
        """The box [px] of a label whose middle is at an offset [pt] from a point at `here` [px]."""
        corner = here + self.point * (offset - size / 2)
        return Bbox.from_bounds(*corner, *(self.point * size)).padded(PAD * self.point)

    def _cost(self, here: np.ndarray, offset: np.ndarray, size: np.ndarray) -> float:
        """The distance of a label [pt], plus penalties for what it covers."""
        box = self._box(here, offset, size)
        outside = sum(not self.frame.contains(*corner) for corner in (box.min, box.max))
        return (
            _distance(offset, size)
            + COVERED * box.count_contains(self.line_points)
            + CROSSED * self._crosses(here, box)
            + FORBIDDEN * (box.count_overlaps(self.taken) + outside)
        )

    def _crosses(self, here: np.ndarray, box: Bbox) -> bool:
        """Whether the connector from a point to its label crosses a line of the chart."""
        there = np.clip(here, box.min, box.max)
        length, start = float(np.linalg.norm(there - here)), NEAR * self.point
        if length <= start:
            return False
        connector = Path([here + start / length * (there - here), there])
        return any(connector.intersects_path(line, filled=False) for line in self.lines)


def _distance(offset: np.ndarray, size: np.ndarray) -> float:
    """From a point to the nearest edge of a label [pt]."""
    return float(np.linalg.norm(np.maximum(abs(offset) - size / 2, 0)))


def label_line_ends(axes: Axes, ends: Sequence[EndLabel]) -> None:
    """Labels of lines beside their right ends, in their order and moved as little as possible (in
    the sum of squares) to be apart."""
    if not ends:
        return
    low, high = axes.get_ylim()
    figure: Any = axes.get_figure(root=True)
    spacing = LINE_HEIGHT / 72 * figure.dpi / axes.bbox.height * (high - low)
    order = sorted(ends, key=lambda end: end[0])
    offsets = spacing * np.arange(len(order))
    heights = isotonic_regression(np.array([end[0] for end in order]) - offsets).x + offsets
    for (_, text, color, weight), height in zip(order, heights, strict=True):
        place: dict[str, Any] = {"xycoords": ("axes fraction", "data"), **OFFSET}
        axes.annotate(text, (1, height), (ASIDE, 0), color=color, weight=weight, **place)


def draw_legend(figure: Figure, lines: Mapping[str, Any], left: float, middle: float) -> None:
    """A legend in one row at a place in fractions of the figure; lines: styles by their meaning."""
    handles = [Line2D([], [], label=label, **style) for label, style in lines.items()]
    figure.legend(handles=handles, bbox_to_anchor=(left, middle), ncols=len(lines), **LEGEND)
