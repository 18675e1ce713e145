"""The charts of the comparison of integrators."""

import math

import numpy as np
from matplotlib import rc_context
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from beamviz.evidence.benchmark.motion import (
    CUBIC,
    EXPLICIT,
    EXUDYN,
    NAMES,
    SCENES,
    MapCell,
    MotionRow,
)
from beamviz.plotting import STYLE, new_figure

# Okabe & Ito: safe for the colour-blind.
LINES = {
    "auto": {"color": "#0072B2", "lw": 2.4, "marker": "o"},
    "radau": {"color": "#0072B2", "lw": 0.9, "marker": "s", "ls": "--"},
    "gauss": {"color": "#007A5E", "lw": 0.9, "marker": "d", "ls": "--"},
    "generalised-alpha": {"color": "#D55E00", "lw": 1.2, "marker": "o"},
    "trapezoidal": {"color": "#D55E00", "lw": 0.9, "marker": "s", "ls": "--"},
    CUBIC: {"color": "#555555", "lw": 1.2, "marker": "d"},
    EXUDYN: {"color": "#A8417F", "lw": 1.4, "marker": "^"},
}
OTHER = {"color": "#999999", "lw": 0.9, "marker": "v"}  # of an integrator without its line
COLOURS = {
    "does not converge": "#555555",
    "unstable": "#D55E00",
    "energy grows": "#E69F00",
    "inaccurate": "#F0E442",
    "accurate": "#0072B2",
}

COLUMNS = 3  # of frames in the map
TIMES = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0)  # labelled [s]


def draw_curves(rows: list[MotionRow]) -> Figure:
    """Processor time against the error of the tip, a frame for each motion."""
    with rc_context(STYLE):
        figure = new_figure(9.0, 4.4, layout="constrained")
        frames = figure.subplots(1, len(SCENES), sharey=True)
        for axes, scene in zip(frames, SCENES, strict=True):
            for name in (*LINES, *(name for name in NAMES if name not in LINES)):
                points = front([row for row in rows if (row.scene, row.name) == (scene, name)])
                if points:
                    errors, seconds = zip(*points, strict=True)
                    axes.loglog(seconds, errors, label=name, ms=4, **LINES.get(name, OTHER))
            axes.set_title(scene, loc="left", size=10, weight="bold")
            axes.set_xlabel("processor time [s]")
            axes.set_xticks(TIMES, [f"{time:g}" for time in TIMES])
            axes.minorticks_off()
            axes.grid(color="#E6E6E6", lw=0.6)
        frames[0].set_ylabel("largest error of the tip [L]")
        handles, labels = frames[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=4, frameon=False)
    return figure


def front(rows: list[MotionRow]) -> list[tuple[float, float]]:
    """Error and time of the rows that no other row of the solver beats in both, by time."""
    points = sorted((row.seconds, row.error) for row in rows if not row.reason)
    best = [point for k, point in enumerate(points) if all(p[1] > point[1] for p in points[:k])]
    return [(error, seconds) for seconds, error in best]


def draw_map(cells: list[MapCell]) -> Figure:
    """Where each integrator fails, and how: a frame for each, step against slenderness."""
    kinds = list(COLOURS)
    with rc_context(STYLE):
        figure = new_figure(9.0, 4.6, layout="constrained")
        rows = math.ceil(len(NAMES) / COLUMNS)
        frames = figure.subplots(rows, COLUMNS, sharex=True, sharey=True).ravel()
        for axes, name in zip(frames, NAMES, strict=False):
            shown = [cell for cell in cells if cell.integrator == name]
            mus, steps = (sorted({getattr(cell, key) for cell in shown}) for key in ("mu", "step"))
            numbers = np.zeros((len(mus), len(steps)))
            for cell in shown:
                numbers[mus.index(cell.mu), steps.index(cell.step)] = kinds.index(cell.outcome)
            colours = ListedColormap([*COLOURS.values()])
            axes.pcolormesh(numbers, cmap=colours, vmin=-0.5, vmax=len(kinds) - 0.5, ec="white")
            title = "classical Runge-Kutta" if name == EXPLICIT else name
            axes.set_title(title, loc="left", size=9, weight="bold")
            axes.set_xticks(np.arange(len(steps)) + 0.5, [f"{step:.2g}" for step in steps], size=6)
            axes.set_yticks(np.arange(len(mus)) + 0.5, [f"{mu:g}" for mu in mus])
        for axes in frames[len(NAMES) :]:
            axes.set_axis_off()
        for axes in frames[len(NAMES) - COLUMNS : len(NAMES)]:
            axes.set_xlabel("step [T*]")
            axes.xaxis.set_tick_params(labelbottom=True)
        figure.supylabel("slenderness μ", size=9)
        patches = [Patch(color=colour, label=kind) for kind, colour in COLOURS.items()]
        figure.legend(handles=patches, loc="outside lower center", ncols=5, frameon=False)
    return figure
