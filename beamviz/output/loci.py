"""Frequency loci as a table for a terminal, JSON and CSV."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from beamviz.datasets import QUANTITIES
from beamviz.files import csv_text, json_text
from beamviz.frequency_loci import Loci
from beamviz.frequency_loci.branches import Branch
from beamviz.output import described_numbers, described_units
from beamviz.tables import aligned_table, event_columns, plural, significant_decimals

MAX_ROWS = 21  # of the table of frequencies


def loci_json(loci: Loci) -> str:
    """Sweep, branches, events and limits as JSON."""
    keys = ("label", *QUANTITIES)
    data: dict[str, Any] = {
        "beam": {name: x for name, x in loci.beam.numbers.items() if name != loci.over},
        "model": loci.problem.model,
        "over": loci.over,
        "values": loci.values,
        "branches": [{key: getattr(branch, key) for key in keys} for branch in loci.branches],
        "events": loci.events,
        "limits": loci.limits,
        "stats": {"solves": loci.solves, "seconds": loci.seconds},
    }
    if units := loci.units:
        for record in data["branches"]:
            record["hertz"] = units.hertz(record["frequency"])
        data["units"] = {"length": units.length, "time": units.time}
        if loci.over == "gamma":
            data["rpm"] = units.rpm(loci.values)
    return json_text(data)


def loci_csv(loci: Loci) -> str:
    """One line for each value, every column a number: frequencies, growth rates of branches that
    grow or decay, bending fractions."""
    columns = {loci.over: loci.values}
    if loci.units and loci.over == "gamma":
        columns["rpm"] = loci.units.rpm(loci.values)
    columns |= {branch.label: branch.frequency for branch in loci.branches}
    if units := loci.units:
        hertz = {f"{branch.label}_hertz": units.hertz(branch.frequency) for branch in loci.branches}
        columns |= hertz
    growing = [branch for branch in loci.branches if np.nan_to_num(branch.growth_rate).any()]
    columns |= {f"{branch.label}_growth_rate": branch.growth_rate for branch in growing}
    columns |= {f"{branch.label}_bending": branch.bending_fraction for branch in loci.branches}
    return csv_text(columns, zip(*(column.tolist() for column in columns.values()), strict=True))


def loci_table(loci: Loci) -> str:
    """The sweep, its frequencies and its events, to be read in a terminal."""
    heading = [
        "Beam         " + described_numbers(loci.beam, without=loci.over),
        f"Sweep        {loci.over} = {loci.values[0]:.7g} .. {loci.values[-1]:.7g},"
        f" {len(loci.values)} values",
        "Model        " + loci.problem.described,
        *([described_units(loci.units)] if loci.units else []),
    ]
    footer = f"{plural(loci.solves, 'solve')}, {1000 * loci.seconds:.3g} ms"
    limits = [limit.message for limit in loci.limits]
    parts = [heading, frequency_lines(loci), event_lines(loci), limits, [footer]]
    return "\n\n".join("\n".join(part) for part in parts if part)


def frequency_lines(loci: Loci) -> list[str]:
    """The table of frequencies, thinned to at most MAX_ROWS values."""
    count = len(loci.values)
    step = math.ceil((count - 1) / (MAX_ROWS - 1))
    rows = [*range(0, count - 1, step), count - 1]
    columns = {f"{branch.label}  ": [*branch_cells(branch, rows)] for branch in loci.branches}
    thinned = f", one value in {step} (--format csv has all)" if step > 1 else ""
    table = aligned_table({loci.over: [f"{loci.values[i]:.7g}" for i in rows], **columns})
    lines = [f"Frequencies [1/T*]{thinned}", *table]
    if any(np.nan_to_num(branch.growth_rate[rows]).any() for branch in loci.branches):
        lines.append("+, -: growth rate [1/T*] of a mode that grows or decays")
    if any(cell[-1] in "bsm" for cells in columns.values() for cell in cells):
        lines.append("b, s, m: bending, stretching or mixed there, unlike the label")
    return lines


def branch_cells(branch: Branch, rows: list[int]) -> Iterator[str]:
    """Frequencies of a branch, significant decimals; a letter marks a family unlike the label's."""
    errors = [branch.error[i] for i in rows if branch.mode_index[i] >= 0]
    decimals = min([5, *map(significant_decimals, errors)])
    for i in rows:
        value, letter = branch.frequency[i], (branch.family[i] or "")[:1]
        rate = branch.growth_rate[i]
        text = f"{value:.{decimals}f}" if math.isfinite(value) else "unstable"
        if rate:
            text = f"{text} {rate:+.{decimals}f}"
        yield f"{text} {letter if letter != branch.label[0].lower() else ' '}" if letter else "-  "


def event_lines(loci: Loci) -> list[str]:
    """The table of events."""
    if not loci.events:
        return ["No crossing or veering in this range."]
    return aligned_table(event_columns(loci.over, loci.units, loci.events))


LOCI_FORMATS = {"table": loci_table, "json": loci_json, "csv": loci_csv}
