"""The paper's figures: their beams, the numbers its text prints, and the same numbers computed.

The curves of the figures are not available to this project; `plots` computes and draws them.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from beamviz.beam import PARAMETERS, Beam
from beamviz.frequency_loci import Event, Loci, loci
from beamviz.output import csv_text, markdown_table
from beamviz.paper.tables import TOLERANCE, frequencies_by_label
from beamviz.plotting import OMEGAS
from beamviz.solver import solve

COUNTS = {3: "three", 5: "five"}
ORDINALS = {1: "First", 2: "Second", 3: "Third"}


class PrintedCrossing(NamedTuple):
    """Two loci, numbered by frequency from 1, that cross at a printed value of the parameter, and
    where they cross as located independently of this project, with either curvature measure."""

    loci: tuple[int, int]
    at: str
    material: str
    spatial: str
    explanation: str = ""  # of a printed value that neither curvature measure gives

    @property
    def branches(self) -> set[str]:
        """Labels: locus k is bending mode k until the first stretching mode crosses it."""
        return {f"B{self.loci[0]}", "S1"}


class PrintedNode(NamedTuple):
    """A vibration node of a mode, counted from 1, of the beam at rest without a mass."""

    mode: int
    at: str


class LociFigure(NamedTuple):
    """Frequencies of the lowest modes as one parameter of a beam grows from 0."""

    name: str
    beam: Beam
    over: str
    stop: float
    modes: int = 5
    crossings: tuple[PrintedCrossing, ...] = ()
    nodes: tuple[PrintedNode, ...] = ()
    constants: tuple[tuple[int, str], ...] = ()  # mode, frequency that a mass does not change
    notes: str = ""

    @property
    def parameters(self) -> str:
        """The parameters held fixed: α = 1, β = 0.5, δ = 0, μ = 70."""
        return self.beam.described(name for name in PARAMETERS if name != self.over)

    @property
    def caption(self) -> str:
        """Quantity and fixed parameters."""
        first = f"First {COUNTS[self.modes]} frequencies over the {PARAMETERS[self.over].label}"
        return f"{first} ({self.parameters})"


class ShapeFigure(NamedTuple):
    """Shapes of some modes, counted from 1, of a beam with some mass ratios at its tip."""

    name: str
    beam: Beam
    modes: tuple[int, ...]
    alphas: tuple[float, ...]
    stretching: int | None = None  # the stretching mode by the text
    nodes: tuple[PrintedNode, ...] = ()
    notes: str = ""

    @property
    def parameters(self) -> str:
        """The parameters held fixed."""
        beam = self.beam.replace(alpha=self.alphas[0])
        return beam.described(tuple(PARAMETERS)[len(self.alphas) > 1 :])

    @property
    def caption(self) -> str:
        """Quantity and fixed parameters."""
        one, many = f"{ORDINALS[self.modes[0]]} mode shape", "First five mode shapes"
        return f"{one if len(self.modes) == 1 else many} ({self.parameters})"


Figure = LociFigure | ShapeFigure

NODES = (PrintedNode(2, "0.78344"), PrintedNode(3, "0.50355"), PrintedNode(3, "0.86768"))
CONSTANTS = ((2, "22.0345"), (3, "61.6982"))
OWN_RANGE = "The text does not give the range of the axis; it is ours."
OWN_MASSES = "The text does not give the mass ratios drawn; they are ours."
NO_MASS = "The nodes in the text are those of the beam without a mass, which is drawn."
HELD_ROOT = "likely from a root that holds the length of r' too: 1.584 with 20 elements"


CROSSINGS: dict[str, list[tuple[Any, ...]]] = {
    "fig5": [((3, 4), "9.2", "9.206", "9.373")],
    "fig6": [((3, 4), "6.6", "6.662", "6.824"), ((2, 3), "17.3", "17.343", "17.589")],
    "fig7": [((3, 4), "4.4", "4.406", "4.464"), ((2, 3), "16.2", "16.215", "16.319")],
    "fig8": [((3, 4), "1.59", "1.570", "1.570", HELD_ROOT)],
    "fig9": [((3, 4), "0.92", "0.921", "0.929")],
    "fig10": [((3, 4), "0.48", "0.477", "0.485"), ((2, 3), "1.74", "1.747", "1.758")],
    "fig11": [((4, 5), "0.09", "0.0877", "0.0872"), ((4, 5), "0.225", "0.2234", "0.2242")],
}


def _loci(name: str, beam: Beam, over: str, stop: float, notes: str = OWN_RANGE) -> LociFigure:
    """Five frequencies with their printed crossings."""
    crossings = tuple(PrintedCrossing(*row) for row in CROSSINGS.get(name, ()))
    return LociFigure(name, beam, over, stop, crossings=crossings, notes=notes)


FIGURES: dict[str, Figure] = {
    figure.name: figure
    for figure in (
        _loci("fig4", Beam(1, 0.3), "gamma", 20),
        _loci("fig5", Beam(1, 0.5), "gamma", 20),
        _loci("fig6", Beam(1, 0.8), "gamma", 20),
        _loci("fig7", Beam(1), "gamma", 20),
        _loci("fig8", Beam(), "alpha", 2),
        _loci("fig9", Beam(gamma=5), "alpha", 2),
        _loci("fig10", Beam(gamma=10), "alpha", 2),
        _loci("fig11", Beam(alpha=0.5, gamma=5), "beta", 1, notes=""),
        ShapeFigure("fig12", Beam(), (1,), (0, 0.5, 1, 2), notes=OWN_MASSES),
        ShapeFigure("fig13", Beam(), (2,), (0, 0.5, 1, 2), notes=OWN_MASSES),
        ShapeFigure("fig14", Beam(), (1, 2, 3, 4, 5), (1,), stretching=4),
        ShapeFigure("fig15", Beam(), (1, 2, 3, 4, 5), (2,), stretching=3),
        LociFigure("fig16", Beam(alpha=0.5), "beta", 1, modes=3, nodes=NODES, constants=CONSTANTS),
        ShapeFigure("fig17", Beam(), (2,), (0,), nodes=NODES[:1], notes=NO_MASS),
        LociFigure(
            "fig18", Beam(beta=0.78344), "alpha", 2, constants=CONSTANTS[:1], notes=OWN_RANGE
        ),
        ShapeFigure("fig19", Beam(), (3,), (0,), nodes=NODES[1:], notes=NO_MASS),
    )
}

# The printed numbers, computed.

NEIGHBOURHOOD = np.linspace(0.8, 1.25, 10)  # times a printed crossing: where its loci are solved
MASS_RATIOS = np.linspace(0, 2, 9)  # of a mass at a node
MODELS: dict[str, dict[str, Any]] = {
    "material": {"curvature": "material", "tolerance": TOLERANCE},
    "spatial": {"curvature": "spatial", "tolerance": TOLERANCE},
    "material_20": {"curvature": "material", "method": "ancf", "elements": 20},
    "spatial_20": {"curvature": "spatial", "method": "ancf", "elements": 20},
}


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


def decimals(printed: str) -> int:
    """The number of decimals of a printed number."""
    return len(printed.partition(".")[2])


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


def nearest_event(found: Loci, branches: set[str], at: float) -> Event:
    """The event of two branches nearest to a value of the parameter."""
    events = (event for event in found.events if set(event.branches) == branches)
    return min(events, key=lambda event: abs(event.at - at))


def locate(figure: LociFigure, crossing: PrintedCrossing, **options: Any) -> Event:
    """Where the two loci of a printed crossing cross, with options of `solve`."""
    at = float(crossing.at)
    found = loci(figure.beam, figure.over, at * NEIGHBOURHOOD, figure.modes, **options)
    return nearest_event(found, crossing.branches, at)


def nearest_node(nodes: np.ndarray, printed: PrintedNode) -> float:
    """The vibration node nearest to a printed one."""
    return float(nodes[abs(nodes - float(printed.at)).argmin()])


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
    return "\n\n".join([f"# {TITLE}", SUMMARY, table, verdict, VEERING]) + "\n"


def _cells(row: PrintedNumber, spec: str) -> list[str]:
    values = [format(row.values[name], spec) for name in MODELS]
    return [row.figure, row.quantity, row.printed, *values, row.fits, row.explain(row.values)]


SAME_AT_REST = "at rest the measures are the same"
TITLE = "Crossings, nodes and constant frequencies"
SUMMARY = (
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
