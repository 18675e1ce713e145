"""Every meeting, node and constant frequency the paper prints, beside what is found."""

import csv
import io
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from beamviz.beam import PARAMETERS, Beam
from beamviz.frequency_loci import Event, loci
from beamviz.paper.data import (
    ELEMENTS,
    FIGURES,
    NODES,
    Constant,
    LociFigure,
    Meeting,
    Node,
    ShapeFigure,
)
from beamviz.paper.markdown import lines
from beamviz.plotting.style import OMEGAS
from beamviz.solver import solve

TOLERANCE = 1e-9
AROUND = np.linspace(0.8, 1.25, 10)  # times a printed meeting: where its loci are solved
LADEN = np.linspace(0, 2, 9)  # mass ratios that leave a constant frequency alone

_PAPERS = {"method": "ancf", "elements": ELEMENTS}
MODELS: dict[str, dict[str, Any]] = {
    "material": {"curvature": "material", "tolerance": TOLERANCE},
    "spatial": {"curvature": "spatial", "tolerance": TOLERANCE},
    "material_20": {"curvature": "material", **_PAPERS},
    "spatial_20": {"curvature": "spatial", **_PAPERS},
}


class Number(NamedTuple):
    """A printed number, with its values by model and which of the two exact ones it fits."""

    figure: str
    quantity: str
    printed: str
    values: dict[str, float]
    decimals: int  # to show
    why: str

    @property
    def fits(self) -> str:
        """The models within a unit of the last printed digit, the exact ones before others."""
        off = {name: abs(value - float(self.printed)) for name, value in self.values.items()}
        near = [name for name in self.values if off[name] <= unit(self.printed)]
        if {"material", "spatial"} <= set(near):
            return "both"
        return near[0].replace("material_20", "20 elements") if near else "neither"


def decimals(printed: str) -> int:
    """How many decimals a number is printed with."""
    return len(printed.partition(".")[2])


def unit(printed: str) -> float:
    """A unit of the last printed digit."""
    return 10.0 ** -decimals(printed)


def numbers() -> list[Number]:
    """All of them, in the order of the figures."""
    return [number for figure in FIGURES.values() for number in _of(figure)]


def located(figure: LociFigure, meeting: Meeting, options: dict[str, Any]) -> Event:
    """Where the two loci of a printed meeting meet in a model.

    Locus k is bending mode k until the first stretching mode crosses it.
    """
    near = float(meeting.at)
    found = loci(figure.beam, figure.over, near * AROUND, figure.modes, **options).events
    pair = {f"B{meeting.loci[0]}", "S1"}
    return min(
        (event for event in found if set(event.branches) == pair),
        key=lambda event: abs(event.at - near),
    )


def _of(figure: LociFigure | ShapeFigure) -> Iterator[Number]:
    if isinstance(figure, LociFigure):
        yield from (_meeting(figure, meeting) for meeting in figure.meetings)
        yield from (_constant(figure, constant) for constant in figure.constants)
    else:
        yield from (_node(figure, node) for node in figure.nodes)
        yield from (_stretching(figure, mode) for mode in figure.stretching)


def _meeting(figure: LociFigure, meeting: Meeting) -> Number:
    values = {name: located(figure, meeting, options).at for name, options in MODELS.items()}
    off = {name: abs(values[name] - float(meeting.at)) for name in ("material", "spatial")}
    quantity = f"loci {meeting.loci[0]}/{meeting.loci[1]} meet at {PARAMETERS[figure.over].symbol}"
    if abs(values["material"] - values["spatial"]) <= TOLERANCE * 10:
        why = f"off by {off['spatial']:.2g}; at rest the measures are the same"
    else:
        why = f"off by {off['material']:.2g} (material) and {off['spatial']:.2g} (spatial)"
    why += f"; {meeting.why}" if meeting.why else ""
    return Number(figure.name, quantity, meeting.at, values, 4, why)


def _node(figure: ShapeFigure, node: Node) -> Number:
    values = {
        name: nearest(solve(figure.beam, node.mode, **options).nodes[node.mode - 1], node.at)
        for name, options in MODELS.items()
    }
    why = "at rest the measures are the same"
    return Number(figure.name, f"node of mode {node.mode}", node.at, values, 6, why)


def nearest(nodes: np.ndarray, printed: str) -> float:
    """The node nearest to a printed one."""
    return float(nodes[abs(nodes - float(printed)).argmin()])


def _constant(figure: LociFigure, constant: Constant) -> Number:
    mode, printed = constant
    values = {
        name: float(solve(Beam(), mode, **options).frequencies[mode - 1])
        for name, options in MODELS.items()
    }
    change = max(_change(mode, node) for node in _printed_nodes(mode))
    why = (
        f"a mass of α up to {LADEN[-1]:g} at the printed node changes it by about"
        f" {change:.0e} of itself"
    )
    if abs(values["spatial"] - float(printed)) > unit(printed):
        why = f"20 elements give it, the exact value is {values['spatial']:.6f}; {why}"
    return Number(figure.name, f"constant {OMEGAS[mode - 1]}", printed, values, 6, why)


def _printed_nodes(mode: int) -> list[float]:
    return [float(node.at) for node in NODES if node.mode == mode]


def _change(mode: int, beta: float) -> float:
    """The largest relative change of a bending frequency at rest by masses at a place."""
    found = []
    for alpha in LADEN:
        solution = solve(Beam(alpha=float(alpha), beta=beta), mode + 1, tolerance=TOLERANCE)
        found.append(solution.frequencies[solution.labels.index(f"B{mode}")])
    return float(np.ptp(found) / found[0])


def _stretching(figure: ShapeFigure, printed: int) -> Number:
    beam = figure.beam.replace(alpha=figure.alphas[0])
    values = {
        name: float(solve(beam, len(figure.modes), **options).labels.index("S1") + 1)
        for name, options in MODELS.items()
    }
    quantity = f"place of the stretching mode, α = {beam.alpha:g}"
    why = "the mode shift is the crossing of figure 8"
    return Number(figure.name, quantity, str(printed), values, 0, why)


def as_csv(found: list[Number]) -> str:
    """One line for each number."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["figure", "quantity", "paper", *MODELS, "fits", "why"])
    for number in found:
        values = [f"{number.values[name]:.10g}" for name in MODELS]
        writer.writerow(
            [number.figure, number.quantity, number.printed, *values, number.fits, number.why]
        )
    return text.getvalue()


def as_markdown(found: list[Number]) -> str:
    """The numbers as a page."""
    heading = ["figure", "quantity", "paper", "material", "spatial"]
    heading += ["material, 20 elements", "spatial, 20 elements", "fits", "why"]
    body = [
        [
            number.figure.removeprefix("fig"),
            number.quantity,
            number.printed,
            *(f"{number.values[name]:.{number.decimals}f}" for name in MODELS),
            number.fits,
            number.why,
        ]
        for number in found
    ]
    count = {name: sum(fits(number, name) for number in found) for name in ("material", "spatial")}
    meetings = sum("meet" in number.quantity for number in found)
    verdict = VERDICT.format(meetings=meetings, **count)
    table = "\n".join(lines(heading, body))
    return "\n\n".join([f"# {TITLE}", WHAT, table, verdict, CROSSING]) + "\n"


def fits(number: Number, measure: str) -> bool:
    """Whether a printed meeting fits a curvature measure."""
    return "meet" in number.quantity and number.fits in (measure, "both")


TITLE = "Meetings, nodes and constant frequencies"
WHAT = (
    "Every such number in the paper's text beside the exact answer for both curvature measures,"
    " and beside the paper's 20 cubic elements. A value fits when it is within a unit of the last"
    " printed digit."
)
VERDICT = (
    "Of the {meetings} meetings the material measure fits {material}, the spatial one of eq. 16"
    " fits {spatial}. They differ where the beam is stretched: a stretch f leaves EI/f² of the"
    " bending stiffness with the material measure and EI/f⁴ with the spatial one, so with eq. 16"
    " the bending loci climb more slowly and meet the stretching one later. The printed meetings"
    " speak for a computation with the material measure, although eq. 16 is the spatial one."
)
CROSSING = (
    "What the text calls veering is crossing: without Coriolis nothing couples stretching to"
    " bending about a straight state, and the gap of every meeting above is 0."
)
