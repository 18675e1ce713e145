"""Records as text and as files: tables to read in a terminal, JSON, CSV, NPZ and markdown."""

import csv
import io
import json
import math
import textwrap
from collections.abc import Iterable, Sequence
from dataclasses import is_dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from beamviz.beam import Beam, Units
    from beamviz.frequency_loci import Branch, Loci
    from beamviz.frequency_loci.forced_response import Resonance
    from beamviz.lessons.model import Lesson
    from beamviz.solver import Solution

MAX_DECIMALS = 9
LEFT_ALIGNED = ("label", "family", "nodes x/L")
MAX_LOCI_ROWS = 21
MAX_LOCI_DECIMALS = 5
LESSON_WIDTH = 88
MODEL_KEYS = ("method", "strain", "curvature", "coriolis", "plane")
EQUILIBRIUM_KEYS = ("status", "shape", "iterations", "tip", "max_stretch")
MODE_KEYS = {  # of the JSON, and the attributes of a solution
    "label": "labels",
    "family": "families",
    "frequency": "frequencies",
    "growth_rate": "growth_rates",  # of modes that have one
    "error": "errors",
    "bending_fraction": "bending_energy_fraction",
    "nodes": "nodes",
}
BRANCH_KEYS = ("label", "family", "frequency", "growth_rate", "error", "bending_fraction")


# Any records.


def json_text(data: Any, indent: int | None = 2) -> str:
    """Any data of `plain` as JSON."""
    return json.dumps(plain(data), indent=indent, allow_nan=False, ensure_ascii=False)


def plain(value: Any) -> Any:
    """A value in the types of JSON: records as dicts, arrays as lists, NaN and infinity as None."""
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    elif is_dataclass(value) and not isinstance(value, type):
        value = vars(value)
    elif hasattr(value, "_asdict"):
        value = value._asdict()
    if isinstance(value, dict):
        return {key: plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [plain(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def csv_text(heading: Iterable[str], rows: Iterable[Iterable[Any]]) -> str:
    """A heading and rows as CSV, floats with all their digits, None as an empty cell."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(heading)
    writer.writerows(rows)
    return text.getvalue()


def markdown_table(heading: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = (heading, ["---"] * len(heading), *rows)
    return "\n".join("| " + " | ".join(cells) + " |" for cells in lines)


def aligned_table(heading: Sequence[str], *rows: Sequence[Any]) -> list[str]:
    """The lines of a table; the cells of numbers align right."""
    cells = [[str(cell) for cell in row] for row in (heading, *rows)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    sides = ["<" if name in LEFT_ALIGNED else ">" for name in heading]
    form = "  ".join(f"{{:{side}{width}}}" for side, width in zip(sides, widths, strict=True))
    return [form.format(*row).rstrip() for row in cells]


def significant_decimals(error: float) -> int:
    """The decimals, at most 9, that are significant in a number with this absolute error."""
    if not (math.isfinite(error) and error > 0):
        return MAX_DECIMALS
    return min(MAX_DECIMALS, max(0, -math.floor(math.log10(error))))


def significant_column(values: Iterable[float], errors: Iterable[float]) -> list[str]:
    """Numbers with their significant decimals, decimal points aligned; NaN is "unstable"."""
    decimals = [significant_decimals(error) for error in errors]
    return [
        "unstable" if math.isnan(value) else f"{value:.{places}f}" + " " * (max(decimals) - places)
        for value, places in zip(values, decimals, strict=True)
    ]


def plural(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


# A solution.


def solution_json(solution: "Solution") -> str:
    """Beam, model, equilibrium, modes and statistics of a solution as JSON."""
    state, model, units = solution.equilibrium, solution.problem.model, solution.beam.units
    data = {
        "beam": solution.beam.numbers,
        "model": {key: model[key] for key in MODEL_KEYS},
        "equilibrium": {key: getattr(state, key) for key in EQUILIBRIUM_KEYS},
        "modes": mode_records(solution),
        "stats": solution.stats,
    }
    if units:
        data["units"] = {"length": units.length, "time": units.time}
    return json_text(data)


def mode_records(solution: "Solution") -> list[dict[str, Any]]:
    """Each mode under the keys of the JSON; with frequencies in Hz and rad/s for a beam in SI."""
    records, units = [], solution.beam.units
    for k, frequency in enumerate(solution.frequencies):
        columns = {key: getattr(solution, name)[k] for key, name in MODE_KEYS.items()}
        record = {"index": k + 1, **columns}
        if not (math.isnan(frequency) or record["growth_rate"] > 0):
            del record["growth_rate"]
        if units:
            record["hertz"] = units.hertz(frequency)
            record["rad_per_s"] = units.angular_frequency(frequency)
        records.append(plain(record))
    return records


def solution_csv(solution: "Solution") -> str:
    """One line for each mode under the keys of the JSON; nodes are separated by spaces."""
    columns = ["index", *MODE_KEYS, *(["hertz", "rad_per_s"] if solution.beam.units else ())]
    records = mode_records(solution)
    for record in records:
        record["nodes"] = " ".join(map(repr, record["nodes"]))
    return csv_text(columns, ([record.get(key) for key in columns] for record in records))


def solution_table(solution: "Solution") -> str:
    """The beam, its equilibrium and its modes, to be read in a terminal."""
    beam, state, stats = solution.beam, solution.equilibrium, solution.stats
    heading = ["Beam         " + described_numbers(beam)]
    if units := beam.units:
        heading.append(f"{described_units(units)}, {units.rpm(beam.gamma):.7g} rpm")
    (x, y), bent = state.tip, ", bent" if state.shape == "bent" else ""
    heading += [
        "Model        " + solution.problem.described,
        f"Equilibrium  {state.status}{bent}, tip at ({x:.7g}, {y:.7g}) L from the clamp,"
        f" greatest stretch {state.max_stretch:.7g}",
    ]
    footer = (
        f"{stats.method}: {plural(stats.elements, 'element')} of order {stats.order},"
        f" {stats.dof} unknowns, {1000 * stats.seconds:.3g} ms"
    )
    table = aligned_table(*zip(*mode_columns(solution), strict=True))
    return "\n".join([*heading, "", *table, "", footer])


def described_numbers(beam: "Beam", without: str = "") -> str:
    """The numbers of a beam by name, but one."""
    numbers = beam.numbers.items()
    return ", ".join(f"{name} {value:.7g}" for name, value in numbers if name != without)


def described_units(units: "Units") -> str:
    """The line of the units of a beam in SI."""
    return f"SI units     L = {units.length:g} m, T* = {units.time:.7g} s"


def mode_columns(solution: "Solution") -> list[list[str]]:
    """The table of modes by columns, each with its heading first."""
    frequencies, errors, units = solution.frequencies, solution.errors, solution.beam.units
    columns = [
        ["mode", *(str(k + 1) for k in range(len(frequencies)))],
        ["label", *solution.labels],
        ["family", *solution.families],
        ["frequency [1/T*]", *significant_column(frequencies, errors)],
        ["error", *(f"{error:.0e}" if math.isfinite(error) else "-" for error in errors)],
    ]
    if units:
        for name, convert in (("[Hz]", units.hertz), ("[rad/s]", units.angular_frequency)):
            columns.append([name, *significant_column(convert(frequencies), convert(errors))])
    if (rates := solution.growth_rates).any():
        texts = significant_column(rates, errors)
        cells = (text if rate else "-" for text, rate in zip(texts, rates, strict=True))
        columns.append(["growth rate [1/T*]", *cells])
    columns.append(["bending", *(f"{100 * s:.0f} %" for s in solution.bending_energy_fraction)])
    nodes = (" ".join(f"{x:.5f}" for x in positions) or "-" for positions in solution.nodes)
    columns.append(["nodes x/L", *nodes])
    return columns


SOLUTION_FORMATS = {"table": solution_table, "json": solution_json, "csv": solution_csv}


# Frequency loci.


def loci_json(loci: "Loci", resonances: Sequence["Resonance"] = ()) -> str:
    """Sweep, branches, crossings and veerings as JSON."""
    data: dict[str, Any] = {
        "beam": {name: x for name, x in loci.beam.numbers.items() if name != loci.over},
        "model": loci.problem.model,
        "over": loci.over,
        "values": loci.values,
        "branches": [{key: getattr(one, key) for key in BRANCH_KEYS} for one in loci.branches],
        "events": loci.events,
        "limits": loci.limits,
        "complete": loci.complete,
        "stats": {"solves": loci.solves, "seconds": loci.seconds},
    }
    if resonances:
        data["resonances"] = resonances
    if units := loci.units:
        for branch, record in zip(loci.branches, data["branches"], strict=True):
            record["hertz"] = units.hertz(branch.frequency)
        data["units"] = {"length": units.length, "time": units.time}
        if loci.over == "gamma":
            data["rpm"] = units.rpm(loci.values)
    return json_text(data)


def loci_csv(loci: "Loci", resonances: Sequence["Resonance"] = ()) -> str:
    """One line for each value, every column a number: frequencies, then bending fractions."""
    columns = {loci.over: loci.values}
    if loci.units and loci.over == "gamma":
        columns["rpm"] = loci.units.rpm(loci.values)
    columns |= {branch.label: branch.frequency for branch in loci.branches}
    if loci.units:
        columns |= {f"{b.label}_hertz": loci.units.hertz(b.frequency) for b in loci.branches}
    columns |= {f"{branch.label}_bending": branch.bending_fraction for branch in loci.branches}
    return csv_text(columns, zip(*(column.tolist() for column in columns.values()), strict=True))


def loci_table(loci: "Loci", resonances: Sequence["Resonance"] = ()) -> str:
    """The sweep, its frequencies and its events, to be read in a terminal."""
    heading = [
        "Beam         " + described_numbers(loci.beam, without=loci.over),
        f"Sweep        {loci.over} = {loci.values[0]:.7g} .. {loci.values[-1]:.7g},"
        f" {len(loci.values)} values",
        "Model        " + loci.problem.described,
    ]
    if units := loci.units:
        heading.append(described_units(units))
    footer = f"{plural(loci.solves, 'solve')}, {1000 * loci.seconds:.3g} ms"
    limits = [limit.message for limit in loci.limits]
    events, crossed = event_lines(loci), resonance_lines(loci, resonances)
    parts = [heading, frequency_lines(loci), events, crossed, limits, [footer]]
    return "\n\n".join("\n".join(part) for part in parts if part)


def frequency_lines(loci: "Loci") -> list[str]:
    """The table of frequencies, thinned to at most MAX_LOCI_ROWS values."""
    count = len(loci.values)
    step = math.ceil((count - 1) / (MAX_LOCI_ROWS - 1))
    rows = [*range(0, count - 1, step), count - 1]
    columns = [[loci.over, *(f"{loci.values[i]:.7g}" for i in rows)]]
    columns += [branch_column(branch, rows) for branch in loci.branches]
    thinned = f", one value in {step} (--format csv has all)" if step > 1 else ""
    lines = [f"Frequencies [1/T*]{thinned}", *aligned_table(*zip(*columns, strict=True))]
    if any(cell[-1] in "bsm" for column in columns[1:] for cell in column[1:]):
        lines.append("b, s, m: bending, stretching or mixed there, unlike the label")
    return lines


def branch_column(branch: "Branch", rows: list[int]) -> list[str]:
    """The label of a branch, then its frequencies with their significant decimals; a letter marks
    a family other than the label's."""
    errors = [branch.error[i] for i in rows if branch.mode_index[i] >= 0]
    decimals = min([MAX_LOCI_DECIMALS, *map(significant_decimals, errors)])
    cells = [branch.label + "  "]
    for i in rows:
        value, family = branch.frequency[i], branch.family[i]
        if family is None:
            cells.append("-  ")
            continue
        text = "unstable" if math.isnan(value) else f"{value:.{decimals}f}"
        cells.append(f"{text} {family[0] if family[0] != branch.label[0].lower() else ' '}")
    return cells


def event_lines(loci: "Loci") -> list[str]:
    """The table of events, and a note if there may be more."""
    note = [loci.warning] if loci.warning else []
    if not loci.events:
        return note or ["No crossing or veering in this range."]
    heading = ("event", "branches", f"at {loci.over}", "frequency", "gap", "veering index")
    rows = [
        (e.kind, " ".join(e.branches), f"{e.at:.6f}", f"{e.frequency:.5f}")
        + (f"{e.gap:.3g}", f"{e.index:.3f}")
        for e in loci.events
    ]
    return aligned_table(heading, *rows) + note


def resonance_lines(loci: "Loci", resonances: Sequence["Resonance"]) -> list[str]:
    """The table of resonances; with rpm for a beam in SI."""
    if not resonances:
        return []
    table = [["per rev", "branch", "at gamma", "frequency"]]
    table += [[f"{r.per_rev}", r.branch, f"{r.at:.6f}", f"{r.frequency:.5f}"] for r in resonances]
    if units := loci.units:
        rpm = ["rpm", *(f"{units.rpm(one.at):.6g}" for one in resonances)]
        table = [[*row, cell] for row, cell in zip(table, rpm, strict=True)]
    return ["Resonances, frequency = per rev x speed", *aligned_table(*table)]


LOCI_FORMATS = {"table": loci_table, "json": loci_json, "csv": loci_csv}


# Lessons.


def lessons_table(lessons: Sequence["Lesson"]) -> str:
    """Name, title and question of each lesson."""
    width = 2 + max(len(lesson.name) for lesson in lessons)
    wrap = textwrap.TextWrapper(LESSON_WIDTH, " " * width, " " * width)
    return "\n".join(
        line
        for lesson in lessons
        for line in (f"{lesson.name:<{width}}{lesson.title}", *wrap.wrap(lesson.question))
    )


def lessons_json(lessons: Sequence["Lesson"]) -> str:
    """Every lesson with its texts, computed numbers and scene; texts without marks of emphasis."""
    records = [
        {
            **{key: getattr(lesson, key) for key in ("name", "title", "question")},
            **{key: getattr(lesson, key).replace("*", "") for key in ("do", "see", "meaning")},
            "proof": {"words": lesson.proof, "numbers": lesson.numbers},
            "challenge": {
                **{key: getattr(lesson, key) for key in ("task", "number", "within")},
                "answers": [lesson.answer],
            },
            "scene": lesson.scene.tables,
        }
        for lesson in lessons
    ]
    return json_text({"lessons": records})


LESSONS_FORMATS = {"table": lessons_table, "json": lessons_json}
