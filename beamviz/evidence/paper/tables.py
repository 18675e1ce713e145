"""The paper's tables: their beams, the computed frequencies, and a page and a CSV file of each.

The bodies of the paper's tables are not available to this project: each table is computed with the
paper's own elements, to convergence, and with the models the paper compares, and the statements its
text makes are checked against these numbers.
"""

import math
from collections.abc import Callable
from functools import partial
from itertools import pairwise, product
from typing import Any, NamedTuple

from beamviz.beam import Beam
from beamviz.errors import NoEquilibrium
from beamviz.files import csv_text, markdown_table
from beamviz.plotting import OMEGAS
from beamviz.solver import solve

TOLERANCE = 1e-9
SOLVED_MODES = 6  # enough to contain two bending modes
MODES = (0, 1)  # the bending modes in a table
CONVERGED = "converged"  # the reference column


class ModelColumn(NamedTuple):
    """A column of a table: the frequencies of one model."""

    title: str
    options: dict[str, Any]  # of `solve`
    cause: str = ""  # why it deviates from the converged column


COLUMNS = {
    "ancf": ModelColumn(
        "ANCF, 20 elements",
        {"method": "ancf", "elements": 20},
        "The tension N makes bending layers of width √(EI/N) at clamp and mass, which uniform"
        " cubic elements resolve the worse the thinner they are; at δ = 0, ω₁² is the small rest"
        " of two terms near γ², which magnifies what is missed.",
    ),
    CONVERGED: ModelColumn("converged", {"tolerance": TOLERANCE}),
    "material": ModelColumn(
        "converged, material",
        {"tolerance": TOLERANCE, "curvature": "material"},
        "A stretch f leaves EI/f² of the bending stiffness here and EI/f⁴ with eq. 16.",
    ),
    "foac": ModelColumn(
        "FOAC",
        {"tolerance": TOLERANCE, "method": "foac"},
        "The beam keeps its reference length: the stretch f, which lengthens the arm of the load"
        " and leaves N/f of the tension's stiffness and EI/f⁴ of bending's, is not in it.",
    ),
    "linear": ModelColumn(
        "linear, 20 elements",
        {"method": "linear", "elements": 20},
        "Prestressed linear finite elements converge to FOAC: the same cause, and the error of"
        " 20 elements.",
    ),
    "hencky": ModelColumn(
        "hencky",
        {"tolerance": TOLERANCE, "strain": "hencky"},
        "Logarithmic strain softens under tension where the paper's green strain hardens, until"
        " there is no equilibrium at all.",
    ),
}


class TableRow(NamedTuple):
    """A row of a table: one beam in each model."""

    delta: float
    gamma: float
    frequencies: dict[str, tuple[float, float]]  # by column: the two lowest of bending
    limits: dict[str, float]  # by column without an equilibrium: the gamma at which that ends

    def deviation(self, column: str, mode: int, reference: str = CONVERGED) -> float:
        """Relative deviation of a column from another; nan where it has no frequencies."""
        if column in self.limits:
            return math.nan
        return self.frequencies[column][mode] / self.frequencies[reference][mode] - 1


# Checks of the statements that the text makes about its tables.


def largest_difference(rows: list[TableRow], pairs: tuple[tuple[str, str], ...]) -> str:
    """The largest difference between the columns of each pair."""
    differences = (
        f"{COLUMNS[column].title} against {COLUMNS[reference].title}: "
        + "; ".join(f"{OMEGAS[mode]} {_largest(rows, column, mode, reference)}" for mode in MODES)
        for column, reference in pairs
    )
    return f"Largest differences: {'. '.join(differences)}."


def rising(rows: list[TableRow]) -> str:
    """Whether the frequencies of the paper's elements rise with the speed at each hub radius."""
    exceptions = [
        f"{OMEGAS[mode]} at δ = {after.delta:g}, γ = {before.gamma:g} .. {after.gamma:g}"
        for before, after, mode in _successive(rows)
        if after.frequencies["ancf"][mode] <= before.frequencies["ancf"][mode]
    ]
    return _verdict(COLUMNS["ancf"].title, exceptions)


def diverging(rows: list[TableRow]) -> str:
    """Whether FOAC deviates more from the paper's elements with the speed, at each hub radius."""
    exceptions = []
    for before, after, mode in _successive(rows):
        first, second = (row.deviation("foac", mode, "ancf") for row in (before, after))
        if abs(second) < abs(first):
            change = f"{percent(first)} at γ = {before.gamma:g} but {percent(second)} at"
            exceptions.append(f"{OMEGAS[mode]} at δ = {after.delta:g}: {change} {after.gamma:g}")
    return _verdict(f"{COLUMNS['foac'].title} against {COLUMNS['ancf'].title}", exceptions)


def existence(rows: list[TableRow]) -> str:
    """Where a beam of hencky strain has no equilibrium."""
    ended = [row for row in rows if "hencky" in row.limits]
    speeds = " and ".join(f"{row.gamma:g}" for row in ended)
    return (
        f"With hencky strain there is no equilibrium at γ = {speeds}, nor anywhere beyond"
        f" γ = {ended[0].limits['hencky']:.4f}. If ANSYS's law is logarithmic (likely, not tested"
        " here), there is nothing to converge to, and no question of stability; green strain"
        " hardens and always has an equilibrium."
    )


def percent(deviation: float) -> str:
    """A deviation in percent, its number and sign kept on one line: +3.026 %."""
    number = "<0.001" if abs(deviation) < 5e-6 else f"{100 * deviation:+.3f}".replace("-", "−")
    return f"{number}\N{NO-BREAK SPACE}%"


def _largest(rows: list[TableRow], column: str, mode: int, reference: str = CONVERGED) -> str:
    """The largest deviation of a column, with its δ and γ."""
    solved = [row for row in rows if column in row.frequencies]
    row = max(solved, key=lambda row: abs(row.deviation(column, mode, reference)))
    largest = percent(row.deviation(column, mode, reference))
    return f"{largest} at δ = {row.delta:g}, γ = {row.gamma:g}"


def _successive(rows: list[TableRow]) -> list[tuple[TableRow, TableRow, int]]:
    """Successive rows of one hub radius, and each mode."""
    return [(a, b, mode) for a, b in pairwise(rows) if a.delta == b.delta for mode in MODES]


def _verdict(subject: str, exceptions: list[str]) -> str:
    rest = f"except for {'; '.join(exceptions)}." if exceptions else "without exception."
    return f"True of {subject}, {rest}"


Check = Callable[[list[TableRow]], str]


class Table(NamedTuple):
    """The two lowest chordwise bending frequencies of a beam at some speeds and hub radii."""

    name: str
    beam: Beam
    deltas: tuple[float, ...]
    gammas: tuple[float, ...]
    columns: tuple[str, ...]
    compared: str  # the models the paper compares its own with
    statements: dict[str, Check]  # of the text, shortened -> their check
    notes: tuple[str, ...]

    @property
    def caption(self) -> str:
        """Quantity and fixed parameters."""
        return (
            f"First and second chordwise bending frequencies"
            f" ({self.beam.described(('alpha', 'beta', 'mu'))},"
            f" δ = {', '.join(map(str, self.deltas))})"
        )


def frequencies_by_label(beam: Beam, modes: int, **options: Any) -> dict[str, float]:
    """The lowest frequencies of a beam by label, with options of `solve`."""
    solution = solve(beam, modes, **options)
    return dict(zip(solution.labels, solution.frequencies.tolist(), strict=True))


COMPARED = ("ancf", CONVERGED, "material", "foac", "linear")
RISING: dict[str, Check] = {"The frequencies rise with the speed.": rising}
DIVERGING: dict[str, Check] = {"The deviation grows with the speed.": diverging}
FOAC_DIFFERENCE = partial(largest_difference, pairs=(("foac", "ancf"), ("foac", "material")))
LINEAR_DIFFERENCE = partial(largest_difference, pairs=(("linear", "foac"),))
NO_SLENDERNESS = "The caption leaves the slenderness out; it is taken to be 70, as elsewhere."
LONGER_ARM = (
    "At δ = 0 the longer arm of the load makes up for much of what the stretch takes from the"
    " stiffness: ω₂ of FOAC deviates little, and not steadily."
)
TABLES = {
    table.name: table
    for table in (
        Table(
            "table1",
            Beam(alpha=1),
            (0,),
            tuple(range(11)),
            COMPARED,
            "references [30] and [13], which FOAC stands in for",
            {"The discrepancy is trivial for γ from 0 to 10.": FOAC_DIFFERENCE, **RISING},
            ("The text gives the speeds as 0 to 10; the steps of 1 are ours.",),
        ),
        Table(
            "table2",
            Beam(alpha=1),
            (0, 1),
            (0, 1, 2, 3, 4, 5, 10, 20, 50),
            COMPARED,
            "reference [13], which FOAC stands in for",
            DIVERGING,
            ("The text lists the speeds as values of μ; γ is meant, μ is 70.", LONGER_ARM),
        ),
        Table(
            "table3",
            Beam(beta=0),
            (0, 1, 5),
            (2, 10, 20, 30, 40, 50),
            COMPARED,
            "references [29] and [31], which linear finite elements stand in for, and FOAC",
            RISING
            | DIVERGING
            | {"References [29], [31] and FOAC are nearly the same.": LINEAR_DIFFERENCE},
            (NO_SLENDERNESS, LONGER_ARM),
        ),
        Table(
            "table4",
            Beam(beta=0),
            (1,),
            (2, 10, 20, 30, 40, 50),
            (*COMPARED, "hencky"),
            "FOAC and the nonlinear and linear models of ANSYS, which hencky strain and linear"
            " finite elements stand in for",
            {
                "FOAC and the linear model of ANSYS are nearly the same.": LINEAR_DIFFERENCE,
                "The nonlinear model of ANSYS diverges at γ = 40 and 50, so the paper's is more"
                " stable.": existence,
            },
            (NO_SLENDERNESS,),
        ),
    )
}


def compute(table: Table) -> list[TableRow]:
    """All rows of a table."""
    rows = []
    for delta, gamma in product(table.deltas, table.gammas):
        rows.append(row := TableRow(delta, gamma, {}, {}))
        beam = table.beam.replace(delta=delta, gamma=gamma)
        for name in table.columns:
            try:
                frequencies = frequencies_by_label(beam, SOLVED_MODES, **COLUMNS[name].options)
            except NoEquilibrium as error:
                row.limits[name] = error.limit
            else:
                row.frequencies[name] = frequencies["B1"], frequencies["B2"]
    return rows


def to_csv(table: Table, rows: list[TableRow]) -> str:
    """One line for each frequency: the columns, then their relative deviations from the
    converged ones; a column without equilibrium is empty and its limit is in the last column."""
    others = [name for name in table.columns if name != CONVERGED]
    heading = ["delta", "gamma", "mode", *table.columns, *(f"{name}_deviation" for name in others)]
    lines = []
    for row, mode in product(rows, MODES):
        values = row.frequencies
        cells = [f"{values[name][mode]:.10g}" if name in values else "" for name in table.columns]
        cells += [f"{row.deviation(name, mode):.3e}" if name in values else "" for name in others]
        limits = " ".join(f"{name} {limit:.6f}" for name, limit in row.limits.items())
        lines.append([f"{row.delta:g}", f"{row.gamma:g}", mode + 1, *cells, limits])
    return csv_text([*heading, "largest_gamma"], lines)


def to_markdown(table: Table, rows: list[TableRow]) -> str:
    """The page of a table: frequencies, deviations with their causes, statements of the text."""
    columns = table.columns
    heading = ["δ", "γ", *(COLUMNS[name].title for name in columns)]
    parts = [
        f"# Table {table.name.removeprefix('table')}",
        f"{table.caption}. The paper compares its model with {table.compared}.",
        "**The body of the paper's table is not available to this project.** None of its entries"
        " is shown; every number below is computed. In brackets: deviation from the converged one"
        " (green strain, the spatial curvature of eq. 16).",
    ]
    for mode in MODES:
        body = [
            [f"{row.delta:g}", f"{row.gamma:g}", *(_cell(row, name, mode) for name in columns)]
            for row in rows
        ]
        parts += [f"## {OMEGAS[mode]}", markdown_table(heading, body)]
    causes = [
        [COLUMNS[name].title, *(_largest(rows, name, mode) for mode in MODES), COLUMNS[name].cause]
        for name in columns
        if name != CONVERGED
    ]
    findings = [[text, check(rows)] for text, check in table.statements.items()]
    parts += [
        "## Largest deviations, and their causes",
        markdown_table(["column", *OMEGAS[:2], "cause"], causes),
        "## What the text says, and what is found",
        markdown_table(["the text, shortened", "found"], findings),
        "## Notes",
        "\n".join(f"- {note}" for note in table.notes),
    ]
    return "\n\n".join(parts) + "\n"


def _cell(row: TableRow, name: str, mode: int) -> str:
    if name in row.limits:
        return f"no equilibrium beyond γ = {row.limits[name]:.4f}"
    value = f"{row.frequencies[name][mode]:.4f}"
    return value if name == CONVERGED else f"{value} ({percent(row.deviation(name, mode))})"
