"""The paper's tables, figures and the numbers its text prints, computed again, as files."""

import sys
import time
from collections.abc import Sequence
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from beamviz.beam import PARAMETERS, Beam
from beamviz.errors import InvalidInput
from beamviz.evidence.paper import figures, tables
from beamviz.evidence.paper.figures import FIGURES, LociFigure, PrintedNumber, ShapeFigure
from beamviz.evidence.paper.tables import TABLES, TOLERANCE, frequencies_by_label
from beamviz.files import Files, csv_text, make_folder, markdown_table, write_files
from beamviz.frequency_loci import loci
from beamviz.plotting import OMEGAS
from beamviz.solver import solve

NUMBERS = "numbers"
ALL = "all"
NAMES = (*TABLES, *FIGURES, NUMBERS)
INDEX = "index.md"
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
    "Every such number in the paper's text beside the converged one for both curvature measures,"
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
DECIMALS = {"crossing": 4, "node": 6, "constant": 6, "place": 0}  # shown of a printed number
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
        return figures.figure_files(FIGURES[name])
    if name in TABLES:
        table = TABLES[name]
        rows = tables.compute(table)
        texts = {"csv": tables.to_csv(table, rows), "md": tables.to_markdown(table, rows)}
    else:
        numbers = findings()
        texts = {"csv": to_csv(numbers), "md": to_markdown(numbers)}
    return {f"{name}.{extension}": text.encode() for extension, text in texts.items()}


def index(folder: Path) -> Files:
    """A page that lists the tables and figures in a folder."""
    parts = ["# The paper, reproduced", f"{SOURCE}.", SUMMARY]
    for name in (NUMBERS, *TABLES, *FIGURES):
        paths = [f"{name}.{extension}" for extension in ("md", "csv", "png", "svg")]
        present = [path for path in paths if (folder / path).exists()]
        links = ", ".join(f"[{path.partition('.')[2]}]({path})" for path in present)
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


class Finding(NamedTuple):
    """A printed number, and its value in each of MODELS."""

    number: PrintedNumber
    values: dict[str, float]

    def error(self, model: str) -> float:
        """The distance of the value in a model from the printed one."""
        return abs(self.values[model] - float(self.number.printed))

    @property
    def fits(self) -> str:
        """The models within a unit of the last printed digit, the converged ones before others."""
        unit = 10.0 ** -figures.decimals(self.number.printed)
        close = [name for name in self.values if self.error(name) <= unit]
        if {"material", "spatial"} <= set(close):
            return "both"
        return close[0].replace("material_20", "20 elements") if close else "neither"

    @property
    def remark(self) -> str:
        """What explains the values."""
        if self.number.kind == "place":
            return "the mode shift is the crossing of figure 8"
        if self.number.kind == "node":
            return SAME_AT_REST
        if self.number.kind == "constant":
            (mode,), converged = self.number.modes, self.values["spatial"]
            remark = f"20 elements give it, the converged value is {converged:.6f}; "
            return (remark if self.fits == "20 elements" else "") + changed_by_a_mass(mode)
        material, spatial = map(self.error, ("material", "spatial"))
        remark = f"off by {material:.2g} (material) and {spatial:.2g} (spatial)"
        if abs(self.values["material"] - self.values["spatial"]) <= TOLERANCE * 10:
            remark = f"off by {spatial:.2g}; {SAME_AT_REST}"
        return "; ".join(filter(None, (remark, self.number.explanation)))

    def cells(self, spec: str = "") -> list[str]:
        """Its row of a table. spec: format of the values, by default with DECIMALS."""
        number, spec = self.number, spec or f".{DECIMALS[self.number.kind]}f"
        values = [format(self.values[name], spec) for name in MODELS]
        return [number.figure, quantity(number), number.printed, *values, self.fits, self.remark]


def findings() -> list[Finding]:
    """All numbers that the text prints, computed."""
    models = MODELS.items()
    return [
        Finding(number, {name: compute(number, **options) for name, options in models})
        for number in figures.PRINTED
    ]


def quantity(number: PrintedNumber) -> str:
    """The quantity of a printed number."""
    figure, (mode, *other) = FIGURES[number.figure], number.modes
    if isinstance(figure, LociFigure) and other:
        return f"loci {mode}/{other[0]} cross at {PARAMETERS[figure.over].symbol}"
    if isinstance(figure, ShapeFigure) and number.kind == "place":
        return f"place of the stretching mode, α = {figure.alphas[0]:g}"
    return f"node of mode {mode}" if number.kind == "node" else f"constant {OMEGAS[mode - 1]}"


def compute(number: PrintedNumber, **options: Any) -> float:
    """The value of a printed number with options of `solve`."""
    figure, at = FIGURES[number.figure], float(number.printed)
    if isinstance(figure, LociFigure) and number.kind == "crossing":
        computed = loci(figure.beam, figure.over, at * NEIGHBOURHOOD, figure.modes, **options)
        return figures.nearest_event(computed, number.branches, at).at
    if isinstance(figure, ShapeFigure) and number.kind == "place":
        beam = figure.beam.replace(alpha=figure.alphas[0])
        return solve(beam, len(figure.modes), **options).labels.index("S1") + 1.0
    solution = solve(Beam(), number.modes[0], **options)
    if number.kind == "node":
        return figures.nearest_node(solution.nodes[-1], number)
    return float(solution.frequencies[-1])


def changed_by_a_mass(mode: int) -> str:
    """How much a mass at the printed nodes of a mode changes its frequency."""
    nodes = [float(node.printed) for node in figures.NODES if node.modes == (mode,)]
    beams = [Beam(alpha, node) for node, alpha in product(nodes, MASS_RATIOS.tolist())]
    solve_beam = partial(frequencies_by_label, modes=mode + 1, tolerance=TOLERANCE)
    frequencies = [solve_beam(beam)[f"B{mode}"] for beam in beams]
    return (
        f"a mass of α up to {MASS_RATIOS[-1]:g} at the printed node changes it by about"
        f" {np.ptp(frequencies) / frequencies[0]:.0e} of itself"
    )


def to_csv(numbers: Sequence[Finding]) -> str:
    """One line for each number."""
    heading = ["figure", "quantity", "paper", *MODELS, "fits", "remark"]
    return csv_text(heading, (number.cells(".10g") for number in numbers))


def to_markdown(numbers: Sequence[Finding]) -> str:
    """The numbers as a page."""
    heading = ["figure", "quantity", "paper", "material", "spatial"]
    heading += ["material, 20 elements", "spatial, 20 elements", "fits", "remark"]
    body = [[each.number.figure.removeprefix("fig"), *each.cells()[1:]] for each in numbers]
    fits = [each.fits for each in numbers if each.number.kind == "crossing"]
    counts = {name: fits.count(name) + fits.count("both") for name in ("material", "spatial")}
    verdict = VERDICT.format(crossings=len(fits), **counts)
    table = markdown_table(heading, body)
    return "\n\n".join([f"# {TITLE}", NUMBERS_SUMMARY, table, verdict, VEERING]) + "\n"
