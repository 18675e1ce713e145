"""The paper's figures: their beams and the numbers its text prints for them, computed and drawn.

The curves of the paper's own figures are not available to this project.
"""

from collections.abc import Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Picture

from beamviz.beam import PARAMETERS, Beam
from beamviz.evidence.paper.tables import TOLERANCE
from beamviz.files import csv_text
from beamviz.frequency_loci import Event, Loci, loci
from beamviz.plotting import COLOURS, FAINT, INK, OMEGAS, RING, STYLE, new_figure, picture_files
from beamviz.plotting.labels import LabelPlacer, draw_legend, label_line_ends
from beamviz.plotting.loci import LINE, LociDrawing
from beamviz.solver import solve

RANGE_NOT_GIVEN = "The text does not give the range of the axis; it is ours."


class PrintedNumber(NamedTuple):
    """A number that the text prints for a figure.

    Its kind is "crossing": the parameter where two loci cross; "node": of a mode of the beam at
    rest without a mass; "constant": the frequency of a mode that a mass at its node does not
    change; or "place": the number of the stretching mode by frequency.
    """

    figure: str  # a key of FIGURES
    kind: str
    modes: tuple[int, ...]  # that it belongs to, numbered by frequency from 1
    printed: str
    located: str = ""  # independently of this project: by the material and the spatial measure
    explanation: str = ""  # of a printed value that neither curvature measure gives

    @property
    def branches(self) -> set[str]:
        """Labels: locus k is bending mode k until the first stretching mode crosses it."""
        return {f"B{self.modes[0]}", "S1"}


class LociFigure(NamedTuple):
    """Frequencies of the lowest modes as one parameter of a beam grows from 0."""

    name: str
    beam: Beam
    over: str
    stop: float
    modes: int = 5
    notes: str = RANGE_NOT_GIVEN

    @property
    def parameters(self) -> str:
        """The parameters held fixed: α = 1, β = 0.5, δ = 0, μ = 70."""
        return self.beam.described(name for name in PARAMETERS if name != self.over)

    @property
    def caption(self) -> str:
        """Quantity and fixed parameters."""
        count, over = {3: "three", 5: "five"}[self.modes], PARAMETERS[self.over].label
        return f"First {count} frequencies over the {over} ({self.parameters})"


class ShapeFigure(NamedTuple):
    """Shapes of some modes, counted from 1, of a beam with some mass ratios at its tip."""

    name: str
    beam: Beam
    modes: tuple[int, ...]
    alphas: tuple[float, ...]
    notes: str = ""

    @property
    def parameters(self) -> str:
        """The parameters held fixed."""
        beam = self.beam.replace(alpha=self.alphas[0])
        return beam.described(tuple(PARAMETERS)[len(self.alphas) > 1 :])

    @property
    def caption(self) -> str:
        """Quantity and fixed parameters."""
        first = ("First", "Second", "Third")[self.modes[0] - 1]
        shapes = "mode shape" if len(self.modes) == 1 else "five mode shapes"
        return f"{first} {shapes} ({self.parameters})"


Figure = LociFigure | ShapeFigure

MASSES_NOT_GIVEN = "The text does not give the mass ratios drawn; they are ours."
NO_MASS = "The nodes in the text are those of the beam without a mass, which is drawn."
HELD_ROOT = "likely from a root that holds the length of r' too: 1.584 with 20 elements"

FIGURES: dict[str, Figure] = {
    figure.name: figure
    for figure in (
        LociFigure("fig4", Beam(1, 0.3), "gamma", 20),
        LociFigure("fig5", Beam(1, 0.5), "gamma", 20),
        LociFigure("fig6", Beam(1, 0.8), "gamma", 20),
        LociFigure("fig7", Beam(1), "gamma", 20),
        LociFigure("fig8", Beam(), "alpha", 2),
        LociFigure("fig9", Beam(gamma=5), "alpha", 2),
        LociFigure("fig10", Beam(gamma=10), "alpha", 2),
        LociFigure("fig11", Beam(alpha=0.5, gamma=5), "beta", 1, notes=""),
        ShapeFigure("fig12", Beam(), (1,), (0, 0.5, 1, 2), notes=MASSES_NOT_GIVEN),
        ShapeFigure("fig13", Beam(), (2,), (0, 0.5, 1, 2), notes=MASSES_NOT_GIVEN),
        ShapeFigure("fig14", Beam(), (1, 2, 3, 4, 5), (1,)),
        ShapeFigure("fig15", Beam(), (1, 2, 3, 4, 5), (2,)),
        LociFigure("fig16", Beam(alpha=0.5), "beta", 1, 3, notes=""),
        ShapeFigure("fig17", Beam(), (2,), (0,), notes=NO_MASS),
        LociFigure("fig18", Beam(beta=0.78344), "alpha", 2),
        ShapeFigure("fig19", Beam(), (3,), (0,), notes=NO_MASS),
    )
}
PRINTED = (
    PrintedNumber("fig5", "crossing", (3, 4), "9.2", "9.206 9.373"),
    PrintedNumber("fig6", "crossing", (3, 4), "6.6", "6.662 6.824"),
    PrintedNumber("fig6", "crossing", (2, 3), "17.3", "17.343 17.589"),
    PrintedNumber("fig7", "crossing", (3, 4), "4.4", "4.406 4.464"),
    PrintedNumber("fig7", "crossing", (2, 3), "16.2", "16.215 16.319"),
    PrintedNumber("fig8", "crossing", (3, 4), "1.59", "1.570 1.570", HELD_ROOT),
    PrintedNumber("fig9", "crossing", (3, 4), "0.92", "0.921 0.929"),
    PrintedNumber("fig10", "crossing", (3, 4), "0.48", "0.477 0.485"),
    PrintedNumber("fig10", "crossing", (2, 3), "1.74", "1.747 1.758"),
    PrintedNumber("fig11", "crossing", (4, 5), "0.09", "0.0877 0.0872"),
    PrintedNumber("fig11", "crossing", (4, 5), "0.225", "0.2234 0.2242"),
    PrintedNumber("fig14", "place", (4,), "4"),
    PrintedNumber("fig15", "place", (3,), "3"),
    PrintedNumber("fig16", "constant", (2,), "22.0345"),
    PrintedNumber("fig16", "constant", (3,), "61.6982"),
    PrintedNumber("fig17", "node", (2,), "0.78344"),
    PrintedNumber("fig18", "constant", (2,), "22.0345"),
    PrintedNumber("fig19", "node", (3,), "0.50355"),
    PrintedNumber("fig19", "node", (3,), "0.86768"),
)
NODES = [number for number in PRINTED if number.kind == "node"]


def printed_numbers(figure: Figure, kind: str) -> list[PrintedNumber]:
    """The numbers of a kind that the text prints for a figure."""
    return [number for number in PRINTED if (number.figure, number.kind) == (figure.name, kind)]


POINTS = 201
SPATIAL, MATERIAL = "spatial", "material"  # the curvature measures; eq. 16 is the spatial one

WIDTH, HEIGHT = 7.2, 4.8  # [in]
DASHED: dict[str, Any] = {"lw": 0.9, "ls": (0, (4, 2.5))}
DOT: dict[str, Any] = {"marker": "o", "ls": "", "ms": 3.2, "color": INK}
TICK: dict[str, Any] = {"marker": "|", "ls": "", "ms": 13, "mew": 1.2, "color": INK}


ByMeasure = dict[str, Loci]  # by SPATIAL and MATERIAL


class Crossing(NamedTuple):
    """A crossing of two loci by both curvature measures, and the number printed for it."""

    spatial: Event
    material: Event
    number: PrintedNumber | None


class Curve(NamedTuple):
    """One mode shape of unit modal mass: its larger component, positive beside the clamp."""

    alpha: float
    mode: int  # counted from 1
    label: str
    family: str  # bending or stretching
    frequency: float
    nodes: np.ndarray
    x: np.ndarray
    y: np.ndarray


def figure_files(figure: Figure) -> dict[str, bytes]:
    """The contents of a figure's PNG, SVG and CSV files, by file name."""
    if isinstance(figure, LociFigure):
        computed = compute_loci(figure)
        picture = draw_loci(figure, computed, crossings(figure, computed))
        text = loci_csv(computed)
    else:
        curves = compute_curves(figure)
        picture, text = draw_shapes(figure, curves), curves_csv(curves)
    return picture_files(picture, figure.name) | {f"{figure.name}.csv": text.encode()}


def compute_loci(figure: LociFigure) -> ByMeasure:
    """The loci of a figure by curvature measure; at rest the measures are the same."""
    values = np.linspace(0, figure.stop, POINTS)
    names = (SPATIAL, MATERIAL) if figure.over == "gamma" or figure.beam.gamma else (SPATIAL,)
    solve_loci = partial(loci, figure.beam, figure.over, values, figure.modes)
    return {name: solve_loci(curvature=name) for name in names}


def crossings(figure: LociFigure, by_curvature: ByMeasure) -> list[Crossing]:
    """Every crossing of a figure, with the printed ones assigned to the nearest."""
    spatial, numbers = by_curvature[SPATIAL], printed_numbers(figure, "crossing")
    material = by_curvature.get(MATERIAL, spatial)
    printed = {nearest_event(spatial, n.branches, float(n.printed)): n for n in numbers}
    return [
        Crossing(event, nearest_event(material, set(event.branches), event.at), printed.get(event))
        for event in spatial.events
    ]


def compute_curves(figure: ShapeFigure) -> list[Curve]:
    """The mode shapes of a figure."""
    x = np.linspace(0, 1, POINTS)
    curves = []
    for alpha in figure.alphas:
        beam = figure.beam.replace(alpha=alpha)
        solved = solve(beam, max(figure.modes), tolerance=TOLERANCE)
        modes = zip(solved.labels, solved.families, solved.frequencies, solved.nodes, strict=True)
        for k, (label, family, frequency, nodes) in enumerate(modes):
            if k + 1 in figure.modes:
                shape = solved.shape(k, x)[:, int(family == "bending")]
                y = np.sign(shape[1]) * shape + 0.0
                curves.append(Curve(alpha, k + 1, label, family, frequency, nodes, x, y))
    return curves


def loci_csv(by_curvature: ByMeasure) -> str:
    """One line for each value and curvature measure, one column for each branch."""
    first = by_curvature[SPATIAL]
    rows = (
        [f"{value:.10g}", name, *(f"{branch.frequency[k]:.10g}" for branch in computed.branches)]
        for name, computed in by_curvature.items()
        for k, value in enumerate(computed.values)
    )
    return csv_text([first.over, "curvature", *(branch.label for branch in first.branches)], rows)


def curves_csv(curves: Sequence[Curve]) -> str:
    """One line for each point, one column for each curve."""
    heading = [f"mode{curve.mode}_{curve.label}_alpha{curve.alpha:g}" for curve in curves]
    table = np.column_stack([curves[0].x, *(curve.y for curve in curves)])
    return csv_text(["x", *heading], ([f"{value:.10g}" for value in row] for row in table))


@rc_context(STYLE)
def draw_loci(figure: LociFigure, by_curvature: ByMeasure, marked: Sequence[Crossing]) -> Picture:
    """Frequencies with their crossings, and the numbers printed in the paper."""
    picture = _titled_picture(figure, HEIGHT, 0.52, 0.92)
    axes = picture.subplots()
    chart = LociDrawing(by_curvature[SPATIAL], axes)
    if MATERIAL in by_curvature:
        for branch in by_curvature[MATERIAL].branches:
            chart.draw_branch(axes, by_curvature[MATERIAL], branch, **DASHED)
    chart.label_ends()
    placer = LabelPlacer(axes)
    for crossing in marked:
        _mark_crossing(axes, placer, crossing)
    _mark_constants(axes, placer, figure)
    _draw_legend(picture, by_curvature, marked)
    return picture


def _titled_picture(figure: Figure, height: float, head: float, right: float) -> Picture:
    """An empty picture with the name and the fixed parameters of a figure above, and room for
    frames below a head [in], up to a fraction of the width."""
    picture = new_figure(WIDTH, height)
    title = f"Figure {figure.name.removeprefix('fig')}:  {figure.parameters}"
    picture.text(0.012, 1 - 0.12 / height, title, va="center", weight="bold")
    picture.subplots_adjust(0.095, 0.5 / height, right, 1 - head / height)
    return picture


def _mark_crossing(axes: Axes, placer: LabelPlacer, crossing: Crossing) -> None:
    """A ring at the crossing by eq. 16, a dot at the other measure's, a tick where printed."""
    event, other, number = crossing
    digits = decimals(number.printed) + 2 if number else 3
    text = f"{'here' if other is event else 'eq. 16'} {event.at:.{digits}f}"
    if other is not event:
        axes.plot(other.at, other.frequency, **DOT, zorder=6)
        text = f"material {other.at:.{digits}f}\n{text}"
    if number:
        axes.plot(float(number.printed), event.frequency, **TICK, zorder=4)
        text = f"paper {number.printed}\n{text}"
    axes.plot(event.at, event.frequency, **RING, zorder=5)
    placer.annotate(text, event.at, event.frequency)


def _mark_constants(axes: Axes, placer: LabelPlacer, figure: LociFigure) -> None:
    """The frequencies without a mass, and the nodes at which a mass does not change them."""
    free = solve(figure.beam.replace(alpha=0), figure.modes, tolerance=TOLERANCE)
    for constant in printed_numbers(figure, "constant"):
        printed, k = constant.printed, constant.modes[0] - 1
        omega, symbol = float(free.frequencies[k]), OMEGAS[k]
        axes.axhline(omega, color=FAINT, lw=0.8, ls=(0, (1, 2)), zorder=0)
        if figure.over == "alpha":
            placer.annotate(f"{symbol} constant\npaper {printed}\nhere {omega:.4f}", 1, omega)
            continue
        for node in (node for node in NODES if node.modes == constant.modes):
            at = nearest_node(free.nodes[k], node)
            axes.plot(at, omega, **RING, zorder=5)
            text = f"β, {symbol}\npaper {node.printed}, {printed}\nhere {at:.6f}, {omega:.4f}"
            placer.annotate(text, at, omega)


def _draw_legend(picture: Picture, by_curvature: ByMeasure, marked: Sequence[Crossing]) -> None:
    """Colours, lines and markers, those drawn only."""
    branches = [branch for computed in by_curvature.values() for branch in computed.branches]
    families = {name for branch in branches for name in branch.family}
    lines = {name: {"color": c, **LINE} for name, c in COLOURS.items() if name in families}
    if MATERIAL in by_curvature:
        ring, dot = (RING, DOT) if marked else ({}, {})
        lines["spatial curvature (eq. 16)"] = {**ring, "color": INK, "ls": "-", **LINE}
        lines["material curvature"] = {**dot, "color": INK, **DASHED}
    elif marked:
        lines["crossing"] = RING
    if any(crossing.number for crossing in marked):
        lines["in the paper"] = TICK
    draw_legend(picture, lines, 0.0115, 1 - 0.3 / HEIGHT)


@rc_context(STYLE)
def draw_shapes(figure: ShapeFigure, curves: Sequence[Curve]) -> Picture:
    """One frame for each mode, one above the other, with a curve for each mass ratio."""
    count = len(figure.modes)
    picture = _titled_picture(figure, 2.6 + 0.6 * count, 0.32, 0.77)
    frames = picture.subplots(count, sharex=True, sharey=True, squeeze=False).ravel()
    stretching = [number.modes for number in printed_numbers(figure, "place")]
    for axes, mode in zip(frames, figure.modes, strict=True):
        axes.axhline(0, color=FAINT, lw=0.8, zorder=0)
        by_mass = [curve for curve in curves if curve.mode == mode]
        opacities = np.linspace(1, 0.4, len(by_mass))[::-1]
        for curve, opacity in zip(by_mass, opacities, strict=True):
            axes.plot(curve.x, curve.y, color=COLOURS[curve.family], alpha=opacity, lw=1.6)
            axes.plot(curve.nodes, 0 * curve.nodes, **RING, clip_on=False, zorder=5)
        axes.set_xlim(0, 1)
        if len(by_mass) > 1:
            ends = [(c.y[-1], f"α = {c.alpha:g}", COLOURS[c.family], "bold") for c in by_mass]
            label_line_ends(axes, ends)
            continue
        (curve,) = by_mass
        text = f"mode {mode}: {curve.label}, {curve.family}\nω = {curve.frequency:.4f}"
        text += "\nstretching in the paper" if (mode,) in stretching else ""
        colour, place = COLOURS[curve.family], axes.transAxes
        axes.text(1.03, 0.5, text, color=colour, va="center", transform=place)
    placer = LabelPlacer(frames[0])
    for node in printed_numbers(figure, "node"):
        at = nearest_node(curves[0].nodes, node)
        placer.annotate(f"node\npaper {node.printed}\nhere {at:.6f}", at, 0)
    frames[-1].set_xlabel("x / L")
    picture.supylabel("displacement, unit modal mass", size=9)
    return picture


def nearest_event(computed: Loci, branches: set[str], at: float) -> Event:
    """The event of two branches nearest to a value of the parameter."""
    events = (event for event in computed.events if set(event.branches) == branches)
    return min(events, key=lambda event: abs(event.at - at))


def nearest_node(nodes: np.ndarray, node: PrintedNumber) -> float:
    """The vibration node nearest to a printed one."""
    return float(nodes[abs(nodes - float(node.printed)).argmin()])


def decimals(printed: str) -> int:
    """The number of decimals of a printed number."""
    return len(printed.partition(".")[2])
