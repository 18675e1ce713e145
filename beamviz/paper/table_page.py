"""A computed table as a page: frequencies, deviations with their causes, what the paper says."""

from itertools import pairwise

from beamviz.paper.data import Statement, Table
from beamviz.paper.markdown import lines
from beamviz.paper.tables import COLUMNS, EXACT, Row
from beamviz.plotting.style import OMEGAS

MODES = (0, 1)
FIXED_SPACE = "\N{NO-BREAK SPACE}"


def as_markdown(table: Table, rows: list[Row]) -> str:
    """The page of a table."""
    parts = [
        f"# Table {table.name.removeprefix('table')}",
        f"{table.caption}. The paper compares its model with {table.compared}.",
        "**The body of the paper's table is not available to this project.** None of its entries"
        " is shown; every number below is computed. In brackets: deviation from the exact answer"
        " (green strain, the spatial curvature of eq. 16).",
    ]
    for mode in MODES:
        parts += [f"## {OMEGAS[mode]}", "\n".join(_frequencies(table, rows, mode))]
    parts += ["## Largest deviations, and their causes", "\n".join(_causes(table, rows))]
    parts += ["## What the text says, and what is found", "\n".join(_statements(table, rows))]
    parts += ["## Notes", "\n".join(f"- {note}" for note in table.notes)]
    return "\n\n".join(parts) + "\n"


def percent(deviation: float) -> str:
    """+3.026 %, or that it is next to nothing; what belongs together stays on one line."""
    if abs(deviation) < 5e-6:
        return f"<0.001{FIXED_SPACE}%"
    return f"{100 * deviation:+.3f}{FIXED_SPACE}%".replace("-", "−")


def _frequencies(table: Table, rows: list[Row], mode: int) -> list[str]:
    heading = ["δ", "γ", *(COLUMNS[name].title for name in table.columns)]
    body = [
        [f"{row.delta:g}", f"{row.gamma:g}", *(_cell(row, name, mode) for name in table.columns)]
        for row in rows
    ]
    return lines(heading, body)


def _cell(row: Row, name: str, mode: int) -> str:
    if name in row.limits:
        return f"no equilibrium beyond γ = {row.limits[name]:.4f}"
    value = f"{row.frequencies[name][mode]:.4f}"
    return value if name == EXACT else f"{value} ({percent(row.deviation(name, mode))})"


def _causes(table: Table, rows: list[Row]) -> list[str]:
    others = [name for name in table.columns if name != EXACT]
    body = [
        [
            COLUMNS[name].title,
            *(_largest(rows, name, EXACT, mode) for mode in MODES),
            COLUMNS[name].cause,
        ]
        for name in others
    ]
    return lines(["column", *OMEGAS[:2], "cause"], body)


def _largest(rows: list[Row], column: str, reference: str, mode: int) -> str:
    """The largest deviation of a column, and where it is."""
    there = [row for row in rows if column in row.frequencies]
    row = max(there, key=lambda row: abs(row.deviation(column, mode, reference)))
    found = percent(row.deviation(column, mode, reference))
    return f"{found} at δ = {row.delta:g}, γ = {row.gamma:g}"


def _statements(table: Table, rows: list[Row]) -> list[str]:
    body = [
        [statement.text, CHECKS[statement.check](statement, rows)] for statement in table.statements
    ]
    return lines(["the text, shortened", "found"], body)


def _agree(statement: Statement, rows: list[Row]) -> str:
    """How far columns are apart."""
    apart = (
        f"{COLUMNS[column].title} against {COLUMNS[reference].title}: "
        + "; ".join(f"{OMEGAS[mode]} {_largest(rows, column, reference, mode)}" for mode in MODES)
        for column, reference in statement.pairs
    )
    return f"Largest differences: {'. '.join(apart)}."


def _rise(statement: Statement, rows: list[Row]) -> str:
    """Whether every frequency of a column rises from row to row of one hub radius."""
    column = statement.pairs[0][0]
    falls = [
        f"{OMEGAS[mode]} at δ = {after.delta:g}, γ = {before.gamma:g} .. {after.gamma:g}"
        for before, after in _neighbours(rows)
        for mode in MODES
        if after.frequencies[column][mode] <= before.frequencies[column][mode]
    ]
    return f"True of {COLUMNS[column].title}" + _exceptions(falls)


def _part(statement: Statement, rows: list[Row]) -> str:
    """Whether two columns part from row to row of one hub radius."""
    reference, column = statement.pairs[0]

    def off(row: Row, mode: int) -> float:
        return row.deviation(column, mode, reference)

    closer = [
        f"{OMEGAS[mode]} at δ = {after.delta:g}: {percent(off(before, mode))} at γ ="
        f" {before.gamma:g} but {percent(off(after, mode))} at {after.gamma:g}"
        for before, after in _neighbours(rows)
        for mode in MODES
        if abs(off(after, mode)) < abs(off(before, mode))
    ]
    return (
        f"True of {COLUMNS[column].title} against {COLUMNS[reference].title}{_exceptions(closer)}"
    )


def _end(statement: Statement, rows: list[Row]) -> str:
    """Where one column has no equilibrium and another has."""
    column, other = statement.pairs[0]
    gone = [row for row in rows if column in row.limits and other in row.frequencies]
    speeds = " and ".join(f"{row.gamma:g}" for row in gone)
    return (
        f"With {column} strain there is no equilibrium at γ = {speeds}, nor anywhere beyond"
        f" γ = {gone[0].limits[column]:.4f}. If ANSYS's law is logarithmic (likely, not tested"
        " here), there is nothing to converge to, and no question of stability; green strain"
        " hardens and always has an equilibrium."
    )


def _neighbours(rows: list[Row]) -> list[tuple[Row, Row]]:
    return [(a, b) for a, b in pairwise(rows) if a.delta == b.delta]


def _exceptions(found: list[str]) -> str:
    return f", except for {'; '.join(found)}." if found else ", without exception."


CHECKS = {"agree": _agree, "rise": _rise, "part": _part, "end": _end}
