"""beamviz benchmark: measure every method, write the chart and the numbers, report the ratios."""

import contextlib
import os
import platform
import re
import sys
import textwrap
from collections.abc import Iterator
from datetime import date
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from beamviz.evidence.benchmark import blade, motion, work_precision
from beamviz.evidence.benchmark.external import PEERS
from beamviz.evidence.benchmark.motion_chart import draw_curves, draw_map
from beamviz.evidence.benchmark.work_precision import (
    METHODS,
    SCENES,
    Solver,
    SolveRow,
    time_to_error,
)
from beamviz.files import json_text, make_folder, write_files
from beamviz.plotting import INK, STYLE, new_figure, picture_files
from beamviz.plotting.labels import LabelPlacer

NAME = "benchmark"
TARGETS = (1e-2, 1e-4, 1e-6)

# The chart: a frame for each scene, and one for the models.
WIDTH, HEIGHT = 9.0, 13.8  # [in]
COLUMNS = 2
SUBTITLE = (
    "Lower left is better. Error: the largest of five frequencies, against the limits to which each"
    " method's own model converges."
)
MODEL_ERROR = "Model error: distance of the limits of each model from those of the paper's model"
FRAME_TITLE: dict[str, Any] = {"loc": "left", "size": 10, "weight": "bold"}
MUTED = "#5A5A5A"
LABEL_BOX: dict[str, Any] = {"fc": "white", "ec": "none", "alpha": 0.7, "pad": 0.6}
THIN: dict[str, Any] = {"lw": 0.9, "ms": 3.0, "zorder": 2}
# Okabe & Ito: safe for the colour-blind. Same hue: same family; dashes and markers tell apart.
LINE_STYLES: dict[str, dict[str, Any]] = {
    "auto": {"color": "#0072B2", "lw": 2.6, "ms": 5.5, "marker": "o", "zorder": 5},
    "foac": {"color": "#0072B2", "marker": "s", "ls": (0, (4, 2)), **THIN},
    "zoac": {"color": "#0072B2", "marker": "d", "ls": (0, (1, 1.5)), **THIN},
    "ancf": {"color": "#D55E00", "lw": 1.5, "ms": 4, "marker": "o", "zorder": 4},
    "linear": {"color": "#D55E00", "marker": "d", "ls": (0, (1, 1.5)), **THIN},
    "chebyshev": {"color": "#007A5E", "lw": 1.5, "ms": 4, "marker": "o", "zorder": 4},
    "power-series": {"color": "#007A5E", "marker": "s", "ls": (0, (4, 2)), **THIN},
    "assumed-modes": {"color": "#007A5E", "marker": "d", "ls": (0, (1, 1.5)), **THIN},
    "Exudyn": {"color": "#A8417F", "lw": 1.5, "ms": 4, "marker": "o", "zorder": 4},
    "Exudyn, paper's energy": {"color": "#A8417F", "marker": "s", "ls": (0, (4, 2)), **THIN},
    "OpenSees": {"color": "#555555", "lw": 1.2, "ms": 3.5, "marker": "o", "zorder": 3},
    "CalculiX": {"color": "#555555", "marker": "s", "ls": (0, (4, 2)), **THIN},
}
OTHER_LINE: dict[str, Any] = {"color": "#222222", "marker": "v", **THIN}  # not in LINE_STYLES
THEORIES = {  # a model that is not the paper's: its description, colour and marker
    "rigid": ("rigid tension", "#007A5E", "s"),
    "none": ("no stiffening", "#0072B2", "d"),
    "biot": ("engineering strain, material curvature", "#A8417F", "o"),
    "solid": ("a solid", "#555555", "^"),
}
REASONS = {  # part of a reason: its short form in the chart
    "ill-conditioned": "ill-conditioned",
    "more terms may help": "too few terms",
    "inverted beam": "inverted beam",
    "static solver failed": "static solver fails",
    "out of budget": "out of time",
    "took more than": "out of time",
    "not installed": "not installed",
    "neighbours share": "shared gradient fails",
}


def benchmark(folder: Path, quick: bool, peers: bool, release: str) -> str:
    """Write benchmark.png, .svg and .json to a folder, and motion.json, motion-time-error and
    motion-failures of the motions in time, with other programs also blade.json and
    blade-time-error; the ratios as text.

    `release` is the version of beamviz that they name. Raises Unavailable, before anything is
    measured, for a folder that cannot be written to.
    """
    make_folder(folder)
    length, more = ("20 s", "") if quick else ("1.5 minutes", ", --quick 20 s")
    others = "; with other programs several times as long" if peers else ""
    print_progress(f"beamviz: this takes about {length} of a processor's time{more}{others}")
    solvers = METHODS + (PEERS if peers else ())
    effort = work_precision.QUICK if quick else work_precision.FULL
    rows = work_precision.measure(solvers, effort)
    about = environment(solvers, quick, release)
    work = motion.QUICK if quick else motion.FULL
    motions = motion.measure(work, peers, print_progress)
    cells = motion.trials(motion.NAMES, work.mus, work.steps, print_progress)
    contents = files(rows, about) | motion_files(motions, cells, about)
    lines = [*summary(rows), "", *motion.summary(motions)]
    if peers:
        blades = blade.measure()
        contents |= blade_files(blades, about)
        lines += ["", *blade.summary(blades)]
    write_files(folder, contents)
    return "\n".join(lines)


def print_progress(line: str) -> None:
    print(line, file=sys.stderr)


def motion_files(
    rows: list[motion.MotionRow], cells: list[motion.MapCell], about: dict[str, Any]
) -> dict[str, bytes]:
    """The contents of the files of the motions in time, by name."""
    data = {
        **about,
        "time against error": [row._asdict() for row in rows],
        "map": [cell._asdict() for cell in cells],
    }
    pictures = picture_files(draw_curves(rows), "motion-time-error")
    pictures |= picture_files(draw_map(cells), "motion-failures")
    return pictures | {"motion.json": (json_text(data, indent=1) + "\n").encode()}


def blade_files(rows: list[blade.BladeRow], about: dict[str, Any]) -> dict[str, bytes]:
    """The contents of the files of the blade, by name."""
    data = {**about, "time against error": [row._asdict() for row in rows]}
    pictures = picture_files(blade.draw(rows), "blade-time-error")
    return pictures | {"blade.json": (json_text(data, indent=1) + "\n").encode()}


def environment(solvers: tuple[Solver, ...], quick: bool, release: str) -> dict[str, Any]:
    """The machine, the date and the versions of a measurement."""
    versions = {"beamviz": release, "python": platform.python_version()}
    versions |= {name: version(name) for name in ("numpy", "scipy")}
    versions |= {s.name.partition(",")[0]: s.version() for s in solvers if not s.missing}
    return {
        "date": date.today().isoformat(),
        "machine": {"processor": processor(), "cores": os.cpu_count()},
        "versions": {name: number for name, number in versions.items() if number},
        "threads": os.environ.get("OPENBLAS_NUM_THREADS", "not set"),
        "effort": "quick" if quick else "full",
    }


def processor() -> str:
    """The model of the processor."""
    with contextlib.suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def files(rows: list[SolveRow], about: dict[str, Any]) -> dict[str, bytes]:
    """The contents of the files by name."""
    models = work_precision.model_errors()
    versions = ", ".join(f"{name} {number}" for name, number in about["versions"].items())
    caption = f"{about['date']}, one thread of {about['machine']['processor']}.\n{versions}."
    scenes = {scene: beam.numbers for scene, beam in SCENES.items()}
    data = {**about, "scenes": scenes, "rows": rows, "model_errors": models}
    text = json_text(data, indent=1) + "\n"
    return picture_files(draw(rows, models, caption), NAME) | {f"{NAME}.json": text.encode()}


def summary(rows: list[SolveRow]) -> Iterator[str]:
    """Times at equal error relative to auto's, and whether auto is on the Pareto front."""
    head = "".join(f"{scene:>18}" for scene in SCENES)
    for target in TARGETS:
        yield f"{f'time to error {target:g} / auto':34}{head}"
        for name in dict.fromkeys(row.name for row in rows):
            cells = "".join(f"{_ratio(rows, scene, name, target):>18}" for scene in SCENES)
            yield f"{name:34}{cells}"
        yield ""
    yield from front_report(rows, "auto")


def front_report(rows: list[SolveRow], name: str) -> Iterator[str]:
    """Whether a solver is on the Pareto front of time and distance from the paper's model."""
    pairs = work_precision.dominated(rows, name)
    if not pairs:
        yield f"{name} is on the Pareto front: nothing is faster and as close to the paper's model"
    for row, other in pairs:
        yield (
            f"{row.scene}: {other.name}, {other.option} {other.resolution:g}, is faster and as"
            f" close to the model as {name}, {row.option} {row.resolution:g}"
        )


def _ratio(rows: list[SolveRow], scene: str, name: str, target: float) -> str:
    """A time relative to auto's, or why there is none."""
    here = [row for row in rows if row.scene == scene]
    ours, theirs = (time_to_error(here, solver, target) for solver in ("auto", name))
    if ours and theirs:
        return f"{theirs / ours:.2g}" if theirs < 10 * ours else f"{theirs / ours:.0f}"
    reasons = [row.reason for row in here if row.name == name]
    return "no answer" if all(reasons) else "not reached"


@rc_context({**STYLE, "axes.axisbelow": True, "grid.color": "#E6E6E6", "grid.linewidth": 0.6})
def draw(rows: list[SolveRow], models: dict[str, dict[str, float | str]], caption: str) -> Figure:
    """The chart; the caption below it names the machine and the versions."""
    figure = new_figure(WIDTH, HEIGHT)
    figure.subplots_adjust(0.085, 0.1, 0.985, 0.925, wspace=0.16, hspace=0.43)
    lines = -(-len(SCENES) // COLUMNS)
    grid = figure.add_gridspec(lines + 1, COLUMNS, height_ratios=[1.0] * lines + [0.62])
    times = [row.seconds for row in rows if not row.reason]
    for k, scene in enumerate(SCENES):
        axes = figure.add_subplot(grid[k // COLUMNS, k % COLUMNS])
        here = [row for row in rows if row.scene == scene]
        _frame(axes, scene, here)
        axes.set_ylabel("" if k % COLUMNS else "relative error")
        axes.set_xlim(0.5e3 * min(times), 3e3 * max(times))
        _lines(axes, here)
    _model_errors(figure.add_subplot(grid[lines, :]), models)
    title = "Time of a solve against its error"
    figure.text(0.012, 0.988, title, size=14, weight="bold", va="top")
    figure.text(0.012, 0.970, SUBTITLE, color=MUTED, va="top")
    figure.text(0.012, 0.008, caption, color=MUTED, size=8, va="bottom")
    return figure


def _frame(axes: Axes, scene: str, rows: list[SolveRow]) -> None:
    """Axes of one scene; above them its name, its numbers and the solvers without an answer."""
    failures = "; ".join(_failures(rows))
    lines = textwrap.wrap(f"× {failures}", 74) if failures else []
    beam = SCENES[scene]
    names = ("alpha", "beta", "gamma", "delta") if beam.alpha else ("gamma", "delta")
    numbers = beam.described(name for name in names if beam.numbers[name])
    axes.set_title(f"{scene}: {numbers}", pad=6 + 8.5 * len(lines), **FRAME_TITLE)
    place: dict[str, Any] = {"transform": axes.transAxes, "va": "bottom"}
    axes.text(0, 1.015, "\n".join(lines), size=7, linespacing=1.05, color=MUTED, **place)
    axes.set(xscale="log", yscale="log", xlabel="processor time [ms]", ylim=(2e-16, 3))
    axes.set_yticks([1e-15, 1e-12, 1e-9, 1e-6, 1e-3, 1])
    axes.set_xticks([0.1, 1, 10, 100, 1000], ["0.1", "1", "10", "100", "1000"])
    axes.minorticks_off()
    axes.grid()


def _lines(axes: Axes, rows: list[SolveRow]) -> None:
    """The lines of one scene, named at their last points; auto first, which gets the best place."""
    ends = []
    for name in dict.fromkeys(row.name for row in rows):
        style = LINE_STYLES.get(name, OTHER_LINE)
        here = [row for row in rows if row.name == name and not row.reason]
        if here:
            x, y = np.array([(1e3 * row.seconds, min(row.error, 1.0)) for row in here]).T
            axes.plot(x, y, mfc="white" if style["lw"] < 1 else None, **style)
            ends.append((name, x[-1], here[-1].error))
    placer = LabelPlacer(axes)
    for name, x, y in sorted(ends, key=lambda end: (end[0] != "auto", end[2])):
        size, weight = (9.5, "bold") if name == "auto" else (7.5, "normal")
        colour = LINE_STYLES.get(name, OTHER_LINE)["color"]
        font: Any = {"fontsize": size, "weight": weight, "color": colour}
        placer.annotate(name, x, min(y, 1.0), bbox=LABEL_BOX, **font)


def _failures(rows: list[SolveRow]) -> list[str]:
    """Solvers without an answer, by reason; with the resolutions where only some have none."""
    solvers: dict[str, list[str]] = {}  # by reason
    for name in dict.fromkeys(row.name for row in rows):
        failed = [row for row in rows if row.name == name and row.reason]
        for short in dict.fromkeys(_short(row.reason) for row in failed):
            where = [row for row in failed if _short(row.reason) == short]
            every = len(where) == sum(row.name == name for row in rows)
            sizes = ", ".join(f"{row.resolution:g}" for row in where if row.resolution)
            solvers.setdefault(short, []).append(name if every else f"{name} ({sizes})")
    return [f"{', '.join(names)}: {short}" for short, names in solvers.items()]


def _short(reason: str) -> str:
    """A reason in a few words."""
    if match := re.search(r"no equilibrium beyond gamma = ([\d.]+)", reason):
        return f"no equilibrium beyond γ = {float(match[1]):.4g}"
    return next((short for part, short in REASONS.items() if part in reason), reason)


def _model_errors(axes: Axes, models: dict[str, dict[str, float | str]]) -> None:
    """Distance of the limits of each model from those of the paper's model, by scene."""
    axes.set_title(MODEL_ERROR, **FRAME_TITLE)
    for place, (theory, (description, colour, marker)) in enumerate(THEORIES.items()):
        names = (solver.name for solver in METHODS + PEERS if solver.theory == theory)
        label = f"{description}: {', '.join(names)}"
        points = [
            (k + 0.08 * (place - 1.5), value)
            for k, scene in enumerate(SCENES)
            if isinstance(value := models[scene].get(theory, ""), float)
        ]
        if points:
            x, y = zip(*points, strict=True)
            axes.plot(x, y, marker=marker, color=colour, ls="", ms=7, label=label, mec="white")
    axes.set(yscale="log", ylim=(1e-4, 1000), ylabel="model error", xlim=(-0.5, len(SCENES) - 0.5))
    axes.set_xticks(range(len(SCENES)), list(SCENES))
    axes.set_yticks([1e-4, 1e-2, 1, 100])
    axes.minorticks_off()
    axes.grid(axis="y")
    below: dict[str, Any] = {"loc": "upper left", "bbox_to_anchor": (-0.02, -0.14), "ncols": 2}
    axes.legend(frameon=False, fontsize=8, labelcolor=INK, handletextpad=0.3, **below)
    missing = [
        f"{scene}: {_short(value)} ({THEORIES[theory][0]})"
        for scene, theories in models.items()
        for theory, value in theories.items()
        if isinstance(value, str)
    ]
    if missing:
        corner: dict[str, Any] = {"transform": axes.transAxes, "ha": "right"}
        axes.text(0.99, 0.04, "\n".join(missing), size=7.5, color=MUTED, **corner)
