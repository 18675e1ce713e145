"""An adjusted beam as a table for a terminal and JSON."""

import math
from typing import Any

from beamviz.adjusting.result import Adjusted
from beamviz.files import json_text
from beamviz.output import described_numbers, described_units, units_record
from beamviz.solver.problem import parse_keywords
from beamviz.tables import aligned_table

GOALS = {
    "measured": "fits measured frequencies",
    "targets": "has target frequencies",
    "clear": "keeps clear of per-rev lines",
}


def adjusted_json(answer: Adjusted) -> str:
    """The adjusted beam, its free numbers and how it meets the goal as JSON."""
    data: dict[str, Any] = {
        "beam": answer.beam.record,
        "model": parse_keywords(**answer.options).model,
        "goal": answer.goal,
        "free": answer.free,
        "bounds": answer.bounds,
        "errors": answer.errors,
        "correlations": answer.correlations,
        "undetermined": answer.undetermined,
        "at_bounds": answer.at_bounds,
        "alternatives": answer.alternatives,
        "matches": [match_record(answer, match) for match in answer.matches],
        "margin": answer.held,
        "sensitivities": answer.sensitivities,
        "stats": {"solves": answer.solves, "seconds": answer.seconds},
    }
    if units := answer.beam.units:
        data["units"] = units_record(units)
    return json_text(data)


def match_record(answer: Adjusted, match: Any) -> dict[str, Any]:
    """A match under the keys of the JSON, in Hz too of a beam in SI."""
    record = match._asdict()
    if units := answer.units:
        record["measured_hertz"] = units.hertz(match.measured)
        record["predicted_hertz"] = units.hertz(match.predicted)
    return record


def adjusted_table(answer: Adjusted) -> str:
    """The adjusted beam, its free numbers and how it meets the goal, to be read in a terminal."""
    beam = answer.beam
    lines = ["Beam         " + described_numbers(beam)]
    if units := beam.units:
        lines.append(described_units(beam, units))
    lines += [f"Goal         {GOALS[answer.goal]}", "", *aligned_table(free_columns(answer))]
    if remarks := remarks_on(answer):
        lines += ["", *remarks]
    if answer.matches:
        lines += ["", *aligned_table(match_columns(answer))]
    return "\n".join(lines)


def remarks_on(answer: Adjusted) -> list[str]:
    """What is not determined, the other answers, and the least margin, in words."""
    remarks = []
    if answer.undetermined:
        names = ", ".join(answer.undetermined)
        remarks.append(f"The data do not determine {names}: other values fit as well.")
    for values in answer.alternatives:
        texts = ", ".join(f"{name} = {value:.6g}" for name, value in values.items())
        remarks.append(f"Another fit that is as good: {texts}")
    if held := answer.held:
        remarks.append(
            f"Least margin {100 * held.margin:.4g} %: {held.mode} and {held.per_rev} per revolution"
            f" at gamma = {held.speed:.5g}"
        )
    return remarks


def free_columns(answer: Adjusted) -> dict[str, list[str]]:
    """The table of the free numbers as texts."""
    errors = [answer.errors.get(name, math.nan) for name in answer.free]
    return {
        "number": list(answer.free),
        "value": [f"{value:.7g}" for value in answer.free.values()],
        "error": [f"{error:.2g}" if math.isfinite(error) else "-" for error in errors],
        "bounds": [f"{low:g} .. {high:g}" for low, high in answer.bounds.values()],
        "note": [note_of(answer, name) for name in answer.free],
    }


def note_of(answer: Adjusted, name: str) -> str:
    """What there is to say of a free number."""
    notes = ["not determined"] * (name in answer.undetermined)
    return ", ".join(notes + ["at its bound"] * (name in answer.at_bounds)) or "-"


def match_columns(answer: Adjusted) -> dict[str, list[str]]:
    """The table of measured and predicted frequencies as texts."""
    matches, units = answer.matches, answer.units
    unit, factor = ("Hz", units.hertz(1.0)) if units else ("1/T*", 1.0)
    given = any(math.isfinite(match.error) for match in matches)
    columns = {"label": [match.mode for match in matches]}
    for name in matches[0].numbers:
        columns[name] = [f"{match.numbers[name]:.6g}" for match in matches]
    columns |= {
        f"measured [{unit}]": [f"{factor * match.measured:.6g}" for match in matches],
        f"predicted [{unit}]": [f"{factor * match.predicted:.6g}" for match in matches],
    }
    if given:
        return columns | {"residual / error": [f"{match.residual:.2f}" for match in matches]}
    return columns | {"residual": [f"{100 * match.residual:.3g} %" for match in matches]}


ADJUSTED_FORMATS = {"table": adjusted_table, "json": adjusted_json}
