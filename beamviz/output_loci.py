"""Loci as text: a table to read, JSON and CSV for programs."""

import csv
import io
import json
import math
from collections.abc import Iterable, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from beamviz.beam import PARAMETERS, Beam, check_float, check_int, exact_text
from beamviz.errors import InvalidInput
from beamviz.output import aligned, decimals, finite, plural

if TYPE_CHECKING:
    from beamviz.frequency_loci import Branch, Loci
    from beamviz.frequency_loci.forced_response import Resonance

MAX_POINTS = 10_000
ROWS = 21  # of a table, at most
MAX_DIGITS = 5  # behind the point of a frequency in it
LETTERS = {"bending": "b", "stretching": "s", "mixed": "m"}


def values_between(over: str, start: object, stop: object, points: object) -> list[float]:
    """Equally spaced values of a number; InvalidInput names the option that is wrong."""
    first, last = bound("--start", over, start), bound("--stop", over, stop)
    if last <= first:
        raise InvalidInput(
            f"--start {exact_text(first)} --stop {exact_text(last)}: stop must be above start"
        )
    count = check_int("--points", points, 2, MAX_POINTS)
    return [first + (last - first) * i / (count - 1) for i in range(count - 1)] + [last]


def bound(option: str, over: str, value: object) -> float:
    """One end of the values."""
    try:
        return check_float(over, value, *PARAMETERS[over].limits)
    except InvalidInput as error:
        raise InvalidInput(f"{option}: {error}") from None


def unused(beam: Beam, over: str) -> str:
    """Words for a value of the number to vary that was given all the same; else nothing."""
    given = beam.numbers[over]
    if beam.units or given == getattr(Beam, over):
        return ""
    return f"--{over} {exact_text(given)} is not used: --over {over} varies it"


def to_json(loci: "Loci", resonances: Sequence["Resonance"] = ()) -> str:
    """The loci as JSON (documented in the README); what is not a number becomes null."""
    beam, model = loci.beam, loci.problem
    data: dict[str, Any] = {
        "beam": {name: beam.numbers[name] for name in beam.numbers if name != loci.over},
        "model": model.model,
        "over": loci.over,
        "values": loci.values.tolist(),
        "branches": [branch_row(loci, branch) for branch in loci.branches],
        "events": [asdict(event) for event in loci.events],
        "limits": [limit._asdict() for limit in loci.limits],
        "complete": loci.complete,
        "confidence": numbers(loci.confidence),
        "stats": {"solves": loci.solves, "seconds": loci.seconds},
    }
    if resonances:
        data["resonances"] = [resonance._asdict() for resonance in resonances]
    if units := loci.units:
        data["units"] = {"length": units.length, "time": units.time}
        if loci.over == "gamma":
            data["rpm"] = units.rpm(loci.values).tolist()
    return json.dumps(data, indent=2, allow_nan=False)


def branch_row(loci: "Loci", branch: "Branch") -> dict[str, Any]:
    """A branch by the names of the JSON; one entry for each value."""
    row = {
        "label": branch.label,
        "family": list(branch.family),
        "frequency": numbers(branch.frequency),
        "growth_rate": numbers(branch.growth_rate),
        "error": numbers(branch.error),
        "bending_fraction": numbers(branch.bending_fraction),
    }
    if units := loci.units:
        row["hertz"] = numbers(units.hertz(branch.frequency))
    return row


def numbers(array: Iterable[float]) -> list[float | None]:
    """Plain floats, None for what JSON does not have."""
    return [finite(value) for value in array]


def to_csv(loci: "Loci", resonances: Sequence["Resonance"] = ()) -> str:
    """One line for each value, all columns numbers: frequencies, then bending fractions."""
    columns = {loci.over: loci.values}
    if loci.units and loci.over == "gamma":
        columns["rpm"] = loci.units.rpm(loci.values)
    columns |= {branch.label: branch.frequency for branch in loci.branches}
    if loci.units:
        columns |= {f"{b.label}_hertz": loci.units.hertz(b.frequency) for b in loci.branches}
    columns |= {f"{branch.label}_bending": branch.bending_fraction for branch in loci.branches}
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*(column.tolist() for column in columns.values()), strict=True))
    return text.getvalue().rstrip("\n")


def to_table(loci: "Loci", resonances: Sequence["Resonance"] = ()) -> str:
    """The sweep, its frequencies and its meetings, to be read in a terminal."""
    parts = [heading(loci), frequencies(loci), meetings(loci)]
    if resonances:
        parts.append(crossed(loci, resonances))
    parts += [[limit.message for limit in loci.limits], [foot(loci)]]
    return "\n\n".join("\n".join(part) for part in parts if part)


LOCI_FORMATS = {"table": to_table, "json": to_json, "csv": to_csv}


def heading(loci: "Loci") -> list[str]:
    """What was swept, and what was held."""
    beam, model = loci.beam, loci.problem
    held = (f"{name} {beam.numbers[name]:.7g}" for name in beam.numbers if name != loci.over)
    coriolis = "with" if model.coriolis else "without"
    lines = [
        "Beam         " + ", ".join(held),
        f"Sweep        {loci.over} = {loci.values[0]:.7g} .. {loci.values[-1]:.7g},"
        f" {len(loci.values)} values",
        f"Model        {model.strain} strain, {model.curvature} curvature, {model.plane},"
        f" {coriolis} Coriolis",
    ]
    if units := loci.units:
        lines.append(f"SI units     L = {units.length:g} m, T* = {units.time:.7g} s")
    return lines


def frequencies(loci: "Loci") -> list[str]:
    """The table of frequencies, thinned to at most ROWS values."""
    count = len(loci.values)
    step = math.ceil((count - 1) / (ROWS - 1))
    rows = [*range(0, count - 1, step), count - 1]
    table = [[loci.over, *(f"{loci.values[i]:.7g}" for i in rows)]]
    table += [column(branch, rows) for branch in loci.branches]
    thinned = f", one value in {step} (--format csv has all)" if step > 1 else ""
    lines = [f"Frequencies [1/T*]{thinned}", *aligned(table)]
    if any(cell[-1:] in LETTERS.values() for row in table[1:] for cell in row[1:]):
        lines.append("b, s, m: bending, stretching or mixed there, unlike the label")
    return lines


def column(branch: "Branch", rows: list[int]) -> list[str]:
    """A branch in the table: its label, then its frequencies with the digits they deserve."""
    errors = [branch.error[i] for i in rows if branch.mode_index[i] >= 0]
    digits = min([MAX_DIGITS, *map(decimals, errors)])
    cells = [branch.label + "  "]
    for i in rows:
        value, family = branch.frequency[i], branch.family[i]
        if family is None:
            cells.append("-  ")
            continue
        text = "unstable" if math.isnan(value) else f"{value:.{digits}f}"
        unlike = LETTERS[family] != branch.label[0].lower()
        cells.append(f"{text} {LETTERS[family] if unlike else ' '}")
    return cells


def meetings(loci: "Loci") -> list[str]:
    """The table of crossings and veerings, and a word if there may be more."""
    more = [loci.warning] if loci.warning else []
    if not loci.events:
        return more or ["No two of these loci meet here."]
    table = [
        ["meeting", *(event.kind for event in loci.events)],
        ["branches", *(" ".join(event.branches) for event in loci.events)],
        [f"at {loci.over}", *(f"{event.at:.6f}" for event in loci.events)],
        ["frequency", *(f"{event.frequency:.5f}" for event in loci.events)],
        ["gap", *(f"{event.gap:.3g}" for event in loci.events)],
        ["veering index", *(f"{event.index:.3f}" for event in loci.events)],
    ]
    return list(aligned(table)) + more


def crossed(loci: "Loci", resonances: Sequence["Resonance"]) -> list[str]:
    """The table of resonances; rpm for a beam given in SI."""
    table = [
        ["per rev", *(str(resonance.per_rev) for resonance in resonances)],
        ["branch", *(resonance.branch for resonance in resonances)],
        ["at gamma", *(f"{resonance.at:.6f}" for resonance in resonances)],
        ["frequency", *(f"{resonance.frequency:.5f}" for resonance in resonances)],
    ]
    if loci.units:
        table.append(["rpm", *(f"{loci.units.rpm(resonance.at):.6g}" for resonance in resonances)])
    return ["Resonances, frequency = per rev x speed", *aligned(table)]


def foot(loci: "Loci") -> str:
    """How sure the tracking is, and what it took."""
    sure = [value for value in loci.confidence.tolist() if math.isfinite(value)]
    words = f"least MAC from value to value {min(sure):.4f}, " if sure else ""
    return f"{words}{plural(loci.solves, 'solve')}, {1000 * loci.seconds:.3g} ms"
