"""The paper's tables, computed: its own elements, the exact answer, and the models it compares."""

import csv
import io
import math
from itertools import product
from typing import Any, NamedTuple

from beamviz.errors import NoEquilibrium
from beamviz.paper.data import ELEMENTS, Table
from beamviz.solver import solve

ENOUGH = 6  # modes among which there are two bending ones
TOLERANCE = 1e-9
EXACT = "exact"  # the column all others deviate from


class Column(NamedTuple):
    """A way to fill a column, and why it deviates from the exact answer."""

    title: str
    options: dict[str, Any]
    cause: str = ""


COLUMNS = {
    "ancf": Column(
        "ANCF, 20 elements",
        {"method": "ancf", "elements": ELEMENTS},
        "The tension N makes bending layers of width √(EI/N) at clamp and mass, which uniform"
        " cubic elements resolve the worse the thinner they are; at δ = 0, ω₁² is the small rest"
        " of two terms near γ², which magnifies what is missed.",
    ),
    EXACT: Column("exact", {"tolerance": TOLERANCE}),
    "material": Column(
        "exact, material",
        {"tolerance": TOLERANCE, "curvature": "material"},
        "A stretch f leaves EI/f² of the bending stiffness here and EI/f⁴ with eq. 16.",
    ),
    "foac": Column(
        "FOAC",
        {"tolerance": TOLERANCE, "method": "foac"},
        "The beam keeps its reference length: the stretch f, which lengthens the arm of the load"
        " and leaves N/f of the tension's stiffness and EI/f⁴ of bending's, is not in it.",
    ),
    "linear": Column(
        "linear, 20 elements",
        {"method": "linear", "elements": ELEMENTS},
        "Prestressed linear finite elements converge to FOAC: the same cause, and the error of"
        " 20 elements.",
    ),
    "hencky": Column(
        "hencky",
        {"tolerance": TOLERANCE, "strain": "hencky"},
        "Logarithmic strain softens under tension where the paper's green strain hardens, until"
        " there is no equilibrium at all.",
    ),
}


class Row(NamedTuple):
    """The lowest two bending frequencies of one beam by column; a limit where there are none."""

    delta: float
    gamma: float
    frequencies: dict[str, tuple[float, float]]
    limits: dict[str, float]

    def deviation(self, column: str, mode: int, reference: str = EXACT) -> float:
        """Relative deviation of a column from another; nan where it has no frequencies."""
        if column in self.limits:
            return math.nan
        return self.frequencies[column][mode] / self.frequencies[reference][mode] - 1


def computed(table: Table) -> list[Row]:
    """All rows of a table."""
    return [_row(table, delta, gamma) for delta, gamma in product(table.deltas, table.gammas)]


def _row(table: Table, delta: float, gamma: float) -> Row:
    beam = table.beam.replace(delta=delta, gamma=gamma)
    row = Row(delta, gamma, {}, {})
    for name in table.columns:
        try:
            solution = solve(beam, ENOUGH, **COLUMNS[name].options)
        except NoEquilibrium as error:
            row.limits[name] = error.limit
        else:
            found = dict(zip(solution.labels, solution.frequencies.tolist(), strict=True))
            row.frequencies[name] = found["B1"], found["B2"]
    return row


def as_csv(table: Table, rows: list[Row]) -> str:
    """One line for each frequency: the columns, then their relative deviations from the exact
    answer; a column without equilibrium is empty and its limit is in the last column."""
    text = io.StringIO()
    others = [name for name in table.columns if name != EXACT]
    heading = ["delta", "gamma", "mode", *table.columns, *(f"{name}_deviation" for name in others)]
    writer = csv.DictWriter(text, [*heading, "largest_gamma"], restval="", lineterminator="\n")
    writer.writeheader()
    for row, mode in product(rows, (0, 1)):
        line = {"delta": f"{row.delta:g}", "gamma": f"{row.gamma:g}", "mode": str(mode + 1)}
        for name, pair in row.frequencies.items():
            line[name] = f"{pair[mode]:.10g}"
            if name != EXACT:
                line[f"{name}_deviation"] = f"{row.deviation(name, mode):.3e}"
        if row.limits:
            line["largest_gamma"] = " ".join(
                f"{name} {row.limits[name]:.6f}" for name in row.limits
            )
        writer.writerow(line)
    return text.getvalue()
