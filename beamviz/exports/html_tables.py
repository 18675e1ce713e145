"""Tables of numbers as HTML, for the page of the explorer and for exported ones."""

import math
from collections.abc import Collection, Iterable, Sequence

from beamviz.display_units import frequencies, rounded_to_error
from beamviz.solver import Solution

HEAD = "font-weight:500;vertical-align:bottom"
MARKED = "background:rgba(204,60,140,.14)"
TIME = "T* = √(ρ A L⁴ / E I), the time unit of the beam"


def table(
    name: str,
    heads: Sequence[str],
    rows: Iterable[Sequence[object]],
    caption: str = "",
    marked: Collection[int] = (),
) -> str:
    """A table of numbers, called `name` for those who hear the page; rows (from 0) may be
    marked."""
    title = f'<caption style="text-align:left;opacity:.8">{caption}</caption>' if caption else ""
    return (
        f'<table aria-label="{name}" style="width:calc(100% - 1.5em);margin:.2em .75em .4em;'
        "border-collapse:collapse;font-size:.8em;font-variant-numeric:tabular-nums;"
        f'line-height:1.6;text-align:right">{title}<tr style="opacity:.65;line-height:1.3">'
        + "".join(f'<th style="{HEAD}">{head}</th>' for head in heads)
        + "</tr>"
        + "".join(line(cells, k in marked) for k, cells in enumerate(rows))
        + "</table>"
    )


def line(cells: Sequence[object], marked: bool) -> str:
    """A row of a table."""
    style = f' style="{MARKED}"' if marked else ""
    return f"<tr{style}>" + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>"


def solution_table(solution: Solution, shown: list[int]) -> str:
    """The modes: number, label, kind, frequency, error; the ones shown are marked."""
    across = frequencies(solution.beam.units)
    heads = ["", "mode", "kind", f'<span title="{TIME}">{across.label}</span>', "error"]
    rows = [mode_row(solution, k) for k in range(len(solution.labels))]
    return table("modes", heads, rows, marked=shown)


def mode_row(solution: Solution, k: int) -> list[str]:
    """One mode of the table, in the units of its beam."""
    cells = [str(k + 1), f"<b>{solution.labels[k]}</b>", solution.families[k]]
    units = solution.beam.units
    if math.isfinite(solution.frequencies[k]):
        factor = frequencies(units).factor
        error = factor * solution.errors[k]
        cells += [rounded_to_error(factor * solution.frequencies[k], error), f"{error:.0e}"]
    else:
        second, unit = (units.time, "s") if units else (1.0, "T*")
        rate = f"{solution.growth_rates[k] / second:.4g} t/{unit}"
        grows = f'grows e<sup style="line-height:0">{rate}</sup>'
        cells += [grows, f"{solution.errors[k] / second:.0e}"]
    return cells
