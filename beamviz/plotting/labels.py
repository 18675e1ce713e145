"""Words in a chart where they cover as little as possible."""

import math
from collections.abc import Sequence
from itertools import product
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.transforms import Bbox

from beamviz.plotting.style import LINE

DISTANCES = (12, 20, 30, 42, 56, 72, 90)  # [pt] from a point to its note
DIRECTIONS = [math.radians(angle) for angle in range(0, 360, 15)]
NEAR = 7.0  # [pt] around a point: what a line to its note may cross
PAD = 3.0  # [pt] around a note
SAMPLES = 800  # of each line
ASIDE = 6.0  # [pt] from the end of a line to its name
COVERS, CROSSES, FORBIDDEN = 2.0, 40.0, 1e4  # costs in pt of distance: a sample, a line, a note

EndLabel = tuple[float, str, Any, str]  # of a line: its height, its name, and its colour and weight


class LabelPlacer:
    """Places notes one after the other, away from the lines of a chart and from each other."""

    def __init__(self, axes: Axes):
        self.axes = axes
        figure: Any = axes.get_figure(root=True)
        self.renderer = figure.canvas.get_renderer()
        self.point = figure.dpi / 72  # [px]
        self.line_points = np.vstack(
            [self._pixels(np.column_stack(line.get_data())) for line in axes.lines]
        )
        self.taken: list[Bbox] = [text.get_window_extent(self.renderer) for text in axes.texts]

    def _pixels(self, data: np.ndarray) -> np.ndarray:
        """Points (n, 2) of a line on the canvas, close to each other."""
        data = np.asarray(data, float)
        data = self.axes.transData.transform(data[np.isfinite(data).all(axis=1)])
        if not len(data):
            return data
        fine = np.linspace(0, len(data) - 1, SAMPLES)
        return np.column_stack([np.interp(fine, np.arange(len(data)), side) for side in data.T])

    def annotate(self, words: str, x: float, y: float, **look: Any) -> None:
        """Write words near a point of the chart, with a thin line between the two; `look` are
        properties of the text."""
        note: Any = self.axes.annotate(
            words,
            (x, y),
            (0, 0),
            textcoords="offset points",
            ha="center",
            va="center",
            multialignment="left",
            **{"fontsize": 8, **look},
            arrowprops={
                "arrowstyle": "-",
                "lw": 0.6,
                "color": "#555555",
                "shrinkA": 0,
                "shrinkB": 4,
            },
            zorder=7,
        )
        size = note.get_window_extent(self.renderer).size / self.point
        here = self.axes.transData.transform((x, y))
        places = [
            _beside(size, angle, distance) for angle, distance in product(DIRECTIONS, DISTANCES)
        ]
        best = min(places, key=lambda place: self._cost(here, place, size))
        note.set_position(tuple(best))
        note.arrow_patch.set_visible(_distance(best, size) > DISTANCES[0] + 1)
        self.taken.append(self._box(here, best, size))

    def _box(self, here: np.ndarray, place: np.ndarray, size: np.ndarray) -> Bbox:
        """A note on the canvas: its middle is at `place` [pt] from a point at `here` [px]."""
        corner = here + self.point * (place - size / 2)
        return Bbox.from_bounds(*corner, *(self.point * size)).padded(PAD * self.point)

    def _cost(self, here: np.ndarray, place: np.ndarray, size: np.ndarray) -> float:
        """How far a note there would be, and how much it would cover [pt]."""
        box = self._box(here, place, size)
        frame = self.axes.get_window_extent(self.renderer)
        inside = ((self.line_points > box.min) & (self.line_points < box.max)).all(axis=1).sum()
        forbidden = sum(box.overlaps(other) for other in self.taken)
        forbidden += box.x0 < frame.x0 or box.x1 > frame.x1
        forbidden += box.y0 < frame.y0 or box.y1 > frame.y1
        distance = float(np.linalg.norm(np.maximum(abs(place) - size / 2, 0)))
        return (
            distance + COVERS * inside + CROSSES * self._crosses(here, box) + FORBIDDEN * forbidden
        )

    def _crosses(self, here: np.ndarray, box: Bbox) -> bool:
        """Whether the line from a point to its note crosses a line of the chart."""
        there = np.clip(here, box.min, box.max)
        length = float(np.linalg.norm(there - here))
        start = NEAR * self.point
        if length <= start:
            return False
        along = (there - here) / length
        relative = self.line_points - here
        forward, aside = relative @ along, relative @ np.array([-along[1], along[0]])
        return bool(((forward > start) & (forward < length) & (abs(aside) < 2)).any())


def _distance(place: np.ndarray, size: np.ndarray) -> float:
    """From a point to the nearest edge of a note [pt]."""
    return float(np.linalg.norm(np.maximum(abs(place) - size / 2, 0)))


def _beside(size: np.ndarray, angle: float, distance: float) -> np.ndarray:
    """The middle [pt] of a note of some size whose edge is at a distance in a direction."""
    way = np.array([math.cos(angle), math.sin(angle)])
    reach = min(side / max(abs(part), 1e-9) for side, part in zip(size / 2, way, strict=True))
    return (distance + reach) * way


def label_line_ends(axes: Axes, ends: Sequence[EndLabel]) -> None:
    """Names of lines beside their right ends, kept apart."""
    low, high = axes.get_ylim()
    figure: Any = axes.get_figure(root=True)
    least = LINE / 72 * figure.dpi / axes.bbox.height * (high - low)
    heights = spread_apart([height for height, *_ in ends], least)
    for (_, label, colour, weight), height in zip(ends, heights, strict=True):
        axes.annotate(
            label,
            (1, height),
            (ASIDE, 0),
            xycoords=("axes fraction", "data"),
            textcoords="offset points",
            color=colour,
            va="center",
            weight=weight,
        )


def spread_apart(places: list[float], least: float) -> list[float]:
    """Places moved as little as needed to be `least` apart, in their order."""
    order = np.argsort(places)
    spread = np.array(places, float)[order]
    for _ in range(50):
        close = np.flatnonzero(np.diff(spread) < least - 1e-9)
        if not len(close):
            break
        for k in close:
            middle = (spread[k] + spread[k + 1]) / 2
            spread[k], spread[k + 1] = middle - least / 2, middle + least / 2
    moved = np.empty_like(spread)
    moved[order] = spread
    return moved.tolist()
