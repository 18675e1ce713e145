"""A solution as text: a table to read, JSON and CSV for programs."""

import csv
import io
import json
import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from beamviz.solver import Solution

MAX_DECIMALS = 9
COLUMNS = (
    *("index", "label", "family", "frequency", "growth_rate"),
    *("error", "bending_fraction", "nodes"),
)
SI_COLUMNS = ("hertz", "rad_per_s")


def to_json(solution: "Solution") -> str:
    """The solution as JSON (documented in the README); what is not a number becomes null."""
    beam, model, units = solution.beam, solution.problem, solution.beam.units
    data: dict[str, Any] = {
        "beam": beam.numbers,
        "model": {
            "method": model.method,
            "strain": model.strain,
            "curvature": model.curvature,
            "coriolis": model.coriolis,
            "plane": model.plane,
        },
        "equilibrium": {
            "status": solution.equilibrium.status,
            "iterations": solution.equilibrium.iterations,
            "tip": [finite(value) for value in solution.equilibrium.tip],
            "max_stretch": finite(solution.equilibrium.max_stretch),
        },
        "modes": [mode_row(solution, k) for k in range(len(solution.frequencies))],
        "stats": {
            "dof": solution.stats.dof,
            "seconds": solution.stats.seconds,
            "method": solution.stats.method,
            "elements": solution.stats.elements,
            "order": solution.stats.order,
        },
    }
    if units:
        data["units"] = {"length": units.length, "time": units.time}
    return json.dumps(data, indent=2, allow_nan=False)


def mode_row(solution: "Solution", k: int) -> dict[str, Any]:
    """Mode k (0-based) by the names of the JSON; SI frequencies for a beam given in SI."""
    frequency = finite(solution.frequencies[k])
    row = {
        "index": k + 1,
        "label": solution.labels[k],
        "family": solution.families[k],
        "frequency": frequency,
        "error": finite(solution.errors[k]),
        "bending_fraction": finite(solution.bending_energy_fraction[k]),
        "nodes": [float(x) for x in solution.nodes[k]],
    }
    if frequency is None:
        row["growth_rate"] = finite(solution.growth_rates[k])
    if units := solution.beam.units:
        row["hertz"] = None if frequency is None else units.hertz(frequency)
        row["rad_per_s"] = None if frequency is None else units.angular_frequency(frequency)
    return row


def finite(value: float) -> float | None:
    """A plain float, or None for NaN and infinity, which JSON does not have."""
    return float(value) if math.isfinite(value) else None


def to_csv(solution: "Solution") -> str:
    """One line for each mode under the names of the JSON; nodes are separated by spaces."""
    rows = [mode_row(solution, k) for k in range(len(solution.frequencies))]
    columns = [*COLUMNS, *(SI_COLUMNS if solution.beam.units else ())]
    text = io.StringIO()
    writer = csv.DictWriter(text, columns, restval="", lineterminator="\n")
    writer.writeheader()
    writer.writerows({**row, "nodes": " ".join(map(repr, row["nodes"]))} for row in rows)
    return text.getvalue().rstrip("\n")


def to_table(solution: "Solution") -> str:
    """The beam, its equilibrium and its modes, to be read in a terminal."""
    return "\n".join([*heading(solution), "", *aligned(columns(solution)), "", foot(solution)])


FORMATS = {"table": to_table, "json": to_json, "csv": to_csv}


def heading(solution: "Solution") -> list[str]:
    """What was solved, and the state the modes vibrate about."""
    beam, model, state = solution.beam, solution.problem, solution.equilibrium
    lines = [
        "Beam         " + ", ".join(f"{name} {beam.numbers[name]:.7g}" for name in beam.numbers)
    ]
    if units := beam.units:
        speed = units.rpm(beam.gamma)
        lines.append(
            f"SI units     L = {units.length:g} m, T* = {units.time:.7g} s, {speed:.7g} rpm"
        )
    coriolis = "with" if model.coriolis else "without"
    lines.append(
        f"Model        {model.strain} strain, {model.curvature} curvature,"
        f" {model.plane}, {coriolis} Coriolis"
    )
    x, y = state.tip
    lines.append(
        f"Equilibrium  {state.status}, tip at ({x:.7g}, {y:.7g}) L from the clamp,"
        f" greatest stretch {state.max_stretch:.7g}"
    )
    return lines


def columns(solution: "Solution") -> list[list[str]]:
    """The table of modes, column by column, each with its heading first."""
    omega, error, units = solution.frequencies, solution.errors, solution.beam.units
    table = [
        ["mode", *(str(k + 1) for k in range(len(omega)))],
        ["label", *solution.labels],
        ["family", *solution.families],
        ["frequency [1/T*]", *quantities(omega, error)],
        ["error", *(f"{e:.0e}" if math.isfinite(e) else "-" for e in error)],
    ]
    if units:
        for name, scaled in (("[Hz]", units.hertz), ("[rad/s]", units.angular_frequency)):
            table.append([name, *quantities(scaled(omega), scaled(error))])
    if any(map(math.isnan, omega)):
        rates = solution.growth_rates
        table.append(["growth rate [1/T*]", *(f"{rate:.6g}" if rate else "-" for rate in rates)])
    table.append(["bending", *(f"{100 * part:.0f} %" for part in solution.bending_energy_fraction)])
    table.append(["nodes x/L", *(" ".join(f"{x:.5f}" for x in xs) or "-" for xs in solution.nodes)])
    return table


def quantities(values: Iterable[float], errors: Iterable[float]) -> list[str]:
    """Numbers with the digits their errors leave, their decimal points below each other."""
    places = [decimals(error) for error in errors]
    return [
        "unstable" if math.isnan(value) else f"{value:.{place}f}" + " " * (max(places) - place)
        for value, place in zip(values, places, strict=True)
    ]


def decimals(error: float) -> int:
    """How many decimals a number with this absolute error deserves."""
    if not (math.isfinite(error) and error > 0):
        return MAX_DECIMALS
    return min(MAX_DECIMALS, max(0, -math.floor(math.log10(error))))


def aligned(table: list[list[str]]) -> Iterable[str]:
    """The lines of a table: words to the left, numbers to the right."""
    words = ("label", "family", "nodes x/L")
    widths = [max(map(len, column)) for column in table]
    for row in zip(*table, strict=True):
        cells = (
            cell.ljust(width) if column[0] in words else cell.rjust(width)
            for cell, width, column in zip(row, widths, table, strict=True)
        )
        yield "  ".join(cells).rstrip()


def foot(solution: "Solution") -> str:
    """What the answer took."""
    stats = solution.stats
    return (
        f"{stats.method}: {plural(stats.elements, 'element')} of order {stats.order},"
        f" {stats.dof} unknowns, {1000 * stats.seconds:.3g} ms"
    )


def plural(count: int, noun: str) -> str:
    """1 element, 2 elements."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def csv_text(heading: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A CSV file as text."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(heading)
    writer.writerows(rows)
    return text.getvalue()


def markdown_table(heading: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table in markdown."""
    lines = (heading, ["---"] * len(heading), *rows)
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)
