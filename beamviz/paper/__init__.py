"""The paper's tables, figures and the numbers its text prints, computed again, as files."""

import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from beamviz.beam import PARAMETERS, Beam
from beamviz.errors import InvalidInput
from beamviz.files import Files, make_folder, write_files
from beamviz.frequency_loci import Event, loci
from beamviz.output import csv_text, markdown_table
from beamviz.paper import tables
from beamviz.paper.figures import (
    FIGURES,
    NODES,
    LociFigure,
    PrintedCrossing,
    PrintedNode,
    ShapeFigure,
    decimals,
    figure_files,
    nearest_event,
    nearest_node,
)
from beamviz.paper.tables import TABLES, TOLERANCE, frequencies_by_label
from beamviz.plotting import OMEGAS
from beamviz.solver import solve

NUMBERS = "numbers"
ALL = "all"
NAMES = (*TABLES, *FIGURES, NUMBERS)
INDEX = "index.md"
EXTENSIONS = ("md", "csv", "png", "svg")
SOURCE = (
    '"Modal characteristics of a rotating flexible beam with a concentrated mass based on the'
    ' absolute nodal coordinate formulation", Nonlinear Dynamics (2017)'
)
SUMMARY = (
    "Every table and figure computed anew: green strain, the spatial curvature of the paper's"
    " eq. 16 unless another model is named, and no Coriolis, as in the paper. Frequencies are in"
    " units of 1/T*, mode shapes have unit modal mass. The bodies of the paper's tables and the"
    " curves of its figures are not available to this project: what stands beside the computed"
    " numbers is what its text prints."
)
SAME_AT_REST = "at rest the measures are the same"
TITLE = "Crossings, nodes and constant frequencies"
NUMBERS_SUMMARY = (
    "Every such number in the paper's text beside the exact answer for both curvature measures,"
    " and beside the paper's 20 cubic elements. A value fits when it is within a unit of the last"
    " printed digit."
)
VERDICT = (
    "Of the {crossings} crossings the material measure fits {material}, the spatial one of eq. 16"
    " fits {spatial}. They differ where the beam is stretched: a stretch f leaves EI/f² of the"
    " bending stiffness with the material measure and EI/f⁴ with the spatial one, so with eq. 16"
    " the bending loci climb more slowly and cross the stretching one later. The printed crossings"
    " speak for a computation with the material measure, although eq. 16 is the spatial one."
)
VEERING = (
    "What the text calls veering is crossing: without Coriolis nothing couples stretching to"
    " bending about a straight state, and the gap of every crossing above is 0."
)

NEIGHBOURHOOD = np.linspace(0.8, 1.25, 10)  # times a printed crossing: where its loci are solved
MASS_RATIOS = np.linspace(0, 2, 9)  # of a mass at a node
MODELS: dict[str, dict[str, Any]] = {
    "material": {"curvature": "material", "tolerance": TOLERANCE},
    "spatial": {"curvature": "spatial", "tolerance": TOLERANCE},
    "material_20": {"curvature": "material", "method": "ancf", "elements": 20},
    "spatial_20": {"curvature": "spatial", "method": "ancf", "elements": 20},
}


def reproduce(names: Sequence[str], folder: Path) -> Path:
    """Write tables, figures and printed numbers of the paper, and an index of the folder.

    names: of NAMES, or "all" for every one. Each file is written completely or not at all.
    Returns the path of the index. Raises InvalidInput for an unknown name and Unavailable for a
    folder that cannot be written to.
    """
    for name in names:
        if name not in (*NAMES, ALL):
            known = ", ".join((*NAMES, ALL))
            raise InvalidInput(f"{name!r} is not in the paper: choose from {known}")
    make_folder(folder)
    for name in NAMES:
        if name in names or ALL in names:
            start = time.perf_counter()
            write_files(folder, files(name))
            print(f"{name}  {time.perf_counter() - start:.1f} s", file=sys.stderr)
    write_files(folder, index(folder))
    return folder / INDEX


def files(name: str) -> Files:
    """The files of a table, a figure, or the printed numbers."""
    if name in FIGURES:
        return figure_files(FIGURES[name])
    if name in TABLES:
        table = TABLES[name]
        rows = tables.compute(table)
        texts = {"csv": tables.to_csv(table, rows), "md": tables.to_markdown(table, rows)}
    else:
        numbers = list(printed_numbers())
        texts = {"csv": to_csv(numbers), "md": to_markdown(numbers)}
    return {f"{name}.{extension}": text.encode() for extension, text in texts.items()}


def index(folder: Path) -> Files:
    """A page that lists the tables and figures in a folder."""
    parts = ["# The paper, reproduced", f"{SOURCE}.", SUMMARY]
    for name in (NUMBERS, *TABLES, *FIGURES):
        present = [ext for ext in EXTENSIONS if (folder / f"{name}.{ext}").exists()]
        links = ", ".join(f"[{ext}]({name}.{ext})" for ext in present)
        if links and name in FIGURES:
            figure = FIGURES[name]
            parts += [f"## Figure {name[3:]}", f"{figure.caption}. {figure.notes} {links}"]
            parts.append(f"![{figure.caption}]({name}.png)")
        elif links and name in TABLES:
            parts.append(f"**Table {name[5:]}.** {TABLES[name].caption}: {links}")
        elif links:
            parts.append(f"**{TITLE}**, printed and computed: {links}")
    return {INDEX: ("\n\n".join(parts) + "\n").encode()}


# The printed numbers.


@dataclass(frozen=True)
class PrintedNumber:
    """A number printed in the text, and how to compute it."""

    figure: str
    kind: str  # crossing, node, constant or mode
    quantity: str
    printed: str
    decimals: int  # shown
    compute: Callable[..., float]  # (**options of solve) -> the value
    explain: Callable[[dict[str, float]], str]  # values in MODELS -> remark
    located: str = ""  # independently of this project: by the material and the spatial measure

    @cached_property
    def values(self) -> dict[str, float]:
        """The value in each of MODELS."""
        return {name: self.compute(**options) for name, options in MODELS.items()}

    @property
    def fits(self) -> str:
        """The models within a unit of the last printed digit, the exact ones before others."""
        printed, unit = float(self.printed), last_digit(self.printed)
        close = [name for name, value in self.values.items() if abs(value - printed) <= unit]
        if {"material", "spatial"} <= set(close):
            return "both"
        return close[0].replace("material_20", "20 elements") if close else "neither"


def last_digit(printed: str) -> float:
    """A unit of the last printed digit."""
    return 10.0 ** -decimals(printed)


def printed_numbers() -> Iterator[PrintedNumber]:
    """All numbers that the text prints, in the order of the figures."""
    for figure in FIGURES.values():
        if isinstance(figure, LociFigure):
            yield from (_crossing(figure, crossing) for crossing in figure.crossings)
            yield from (_constant(figure, *constant) for constant in figure.constants)
        else:
            yield from (_node(figure, node) for node in figure.nodes)
            if figure.stretching:
                yield _stretching_mode(figure, figure.stretching)


def locate(figure: LociFigure, crossing: PrintedCrossing, **options: Any) -> Event:
    """Where the two loci of a printed crossing cross, with options of `solve`."""
    at = float(crossing.at)
    found = loci(figure.beam, figure.over, at * NEIGHBOURHOOD, figure.modes, **options)
    return nearest_event(found, crossing.branches, at)


def _crossing(figure: LociFigure, crossing: PrintedCrossing) -> PrintedNumber:
    def explain(values: dict[str, float]) -> str:
        material, spatial = (abs(values[k] - float(crossing.at)) for k in ("material", "spatial"))
        remark = f"off by {material:.2g} (material) and {spatial:.2g} (spatial)"
        if abs(values["material"] - values["spatial"]) <= TOLERANCE * 10:
            remark = f"off by {spatial:.2g}; {SAME_AT_REST}"
        return remark + (f"; {crossing.explanation}" if crossing.explanation else "")

    def compute(**options: Any) -> float:
        return locate(figure, crossing, **options).at

    low, high = crossing.loci
    quantity = f"loci {low}/{high} cross at {PARAMETERS[figure.over].symbol}"
    row = figure.name, "crossing", quantity, crossing.at, 4
    return PrintedNumber(*row, compute, explain, f"{crossing.material} {crossing.spatial}")


def _node(figure: ShapeFigure, node: PrintedNode) -> PrintedNumber:
    def compute(**options: Any) -> float:
        return nearest_node(solve(figure.beam, node.mode, **options).nodes[node.mode - 1], node)

    row = figure.name, "node", f"node of mode {node.mode}", node.at, 6
    return PrintedNumber(*row, compute, lambda values: SAME_AT_REST)


def _constant(figure: LociFigure, mode: int, printed: str) -> PrintedNumber:
    def compute(**options: Any) -> float:
        return float(solve(Beam(), mode, **options).frequencies[mode - 1])

    def explain(values: dict[str, float]) -> str:
        places = [float(node.at) for node in NODES if node.mode == mode]
        frequencies = [
            frequencies_by_label(Beam(alpha, beta), mode + 1, tolerance=TOLERANCE)[f"B{mode}"]
            for beta in places
            for alpha in MASS_RATIOS.tolist()
        ]
        remark = (
            f"a mass of α up to {MASS_RATIOS[-1]:g} at the printed node changes it by about"
            f" {np.ptp(frequencies) / frequencies[0]:.0e} of itself"
        )
        if abs(values["spatial"] - float(printed)) > last_digit(printed):
            remark = f"20 elements give it, the exact value is {values['spatial']:.6f}; {remark}"
        return remark

    row = figure.name, "constant", f"constant {OMEGAS[mode - 1]}", printed, 6
    return PrintedNumber(*row, compute, explain)


def _stretching_mode(figure: ShapeFigure, printed: int) -> PrintedNumber:
    beam = figure.beam.replace(alpha=figure.alphas[0])

    def compute(**options: Any) -> float:
        return float(solve(beam, len(figure.modes), **options).labels.index("S1") + 1)

    quantity = f"place of the stretching mode, α = {beam.alpha:g}"
    row = figure.name, "mode", quantity, str(printed), 0
    return PrintedNumber(*row, compute, lambda values: "the mode shift is the crossing of figure 8")


def to_csv(numbers: Sequence[PrintedNumber]) -> str:
    """One line for each number."""
    heading = ["figure", "quantity", "paper", *MODELS, "fits", "remark"]
    return csv_text(heading, (_cells(row, ".10g") for row in numbers))


def to_markdown(numbers: Sequence[PrintedNumber]) -> str:
    """The numbers as a page."""
    heading = ["figure", "quantity", "paper", "material", "spatial"]
    heading += ["material, 20 elements", "spatial, 20 elements", "fits", "remark"]
    body = [_cells(row, f".{row.decimals}f") for row in numbers]
    fits = [row.fits for row in numbers if row.kind == "crossing"]
    verdict = VERDICT.format(
        crossings=len(fits),
        material=sum(fit in ("material", "both") for fit in fits),
        spatial=sum(fit in ("spatial", "both") for fit in fits),
    )
    for cells in body:
        cells[0] = cells[0].removeprefix("fig")
    table = markdown_table(heading, body)
    return "\n\n".join([f"# {TITLE}", NUMBERS_SUMMARY, table, verdict, VEERING]) + "\n"


def _cells(row: PrintedNumber, spec: str) -> list[str]:
    values = [format(row.values[name], spec) for name in MODELS]
    return [row.figure, row.quantity, row.printed, *values, row.fits, row.explain(row.values)]
