"""Results as text and as data: terminal tables, JSON, CSV, HTML, labelled arrays."""

import html
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from beamviz.errors import optional
from beamviz.files import csv_text, json_text, plain

if TYPE_CHECKING:
    import xarray

    from beamviz.beam import Beam, Units
    from beamviz.frequency_loci import Branch, Event, Loci
    from beamviz.solver import Problem, Solution

STATIONS = 201  # equally spaced along the beam
MAX_DECIMALS = 9
LEFT_ALIGNED = ("label", "family", "nodes x/L")
MAX_LOCI_ROWS = 21
MAX_HTML_ROWS = 20
MODEL_KEYS = ("method", "strain", "curvature", "coriolis", "plane")
EQUILIBRIUM_KEYS = ("status", "buckled_chordwise", "shape", "iterations", "tip", "max_stretch")
MODE_KEYS = {  # of the JSON, and the attributes of a solution
    "label": "labels",
    "family": "families",
    "frequency": "frequencies",
    "growth_rate": "growth_rates",  # of modes that have one
    "error": "errors",
    "bending_fraction": "bending_energy_fraction",
    "nodes": "nodes",
}
VALUE_KEYS = ("family", "frequency", "growth_rate", "error", "bending_fraction")
PER_TIME = {"units": "1/T*"}
UNITS = {"frequency": PER_TIME, "growth_rate": PER_TIME, "error": PER_TIME}  # of dataset variables


# Any table.


Columns = Mapping[str, Iterable[Any]]  # the cells of each column of a table, by its heading


def aligned_table(columns: Columns) -> list[str]:
    """The lines of a table; the cells of numbers align right."""
    aligned = []
    for heading, cells in columns.items():
        texts = [heading, *map(str, cells)]
        side, width = "<" if heading in LEFT_ALIGNED else ">", max(map(len, texts))
        aligned.append([f"{text:{side}{width}}" for text in texts])
    return ["  ".join(line).rstrip() for line in zip(*aligned, strict=True)]


def html_table(caption: str, columns: Columns) -> str:

    def row(tag: str, cells: Iterable[Any]) -> str:
        return "<tr>" + "".join(f"<{tag}>{html.escape(str(c))}</{tag}>" for c in cells) + "</tr>"

    rows = "".join(row("td", cells) for cells in zip(*columns.values(), strict=True))
    return f"<table><caption>{html.escape(caption)}</caption>{row('th', columns)}{rows}</table>"


def records_dataframe(kind: type, records: Sequence[Any]) -> Any:
    """A pandas.DataFrame of events or limits, a row for each; see Loci.events_dataframe."""
    return optional("pandas", "xarray").DataFrame(list(records), columns=list(kind.__annotations__))


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


def described_numbers(beam: "Beam", without: str = "") -> str:
    """The numbers of a beam by name, but one."""
    numbers = beam.numbers.items()
    return ", ".join(f"{name} {value:.7g}" for name, value in numbers if name != without)


def described_units(units: "Units") -> str:
    """The line of the units of a beam in SI."""
    return f"SI units     L = {units.length:g} m, T* = {units.time:.7g} s"


def dataset_attributes(beam: "Beam", problem: "Problem", units: "Units | None") -> dict[str, Any]:
    """The model, the numbers, units and version; without None, as in files."""
    from beamviz import __version__

    sizes = units.attributes if units else {}
    return {**beam.numbers, **problem.model, **sizes, "beamviz_version": __version__}


# A solution.


def mode_values(solution: "Solution") -> dict[str, Any]:
    """The values (modes,) under the keys of the JSON; with Hz and rad/s for a beam in SI."""
    values: dict[str, Any] = {"index": np.arange(1, len(solution.frequencies) + 1)}
    values |= {key: getattr(solution, name) for key, name in MODE_KEYS.items()}
    if units := solution.beam.units:
        values["hertz"] = units.hertz(solution.frequencies)
        values["rad_per_s"] = units.angular_frequency(solution.frequencies)
    return values


def along_beam(solution: "Solution") -> dict[str, np.ndarray]:
    """The equilibrium and the shapes at equally spaced stations and the mass, x (n,): position
    (n, 2), stretch (n,), shape (modes, n, 2); lengths in L, unit modal mass."""
    state, x = solution.equilibrium, np.linspace(0.0, 1.0, STATIONS)
    x = np.union1d(x, [solution.beam.beta])
    shape = np.moveaxis(solution.displacement(x), 2, 0) + 0.0  # -0.0 becomes 0.0
    return {"x": x, "position": state.position(x), "stretch": state.stretch(x), "shape": shape}


def solution_json(solution: "Solution") -> str:
    """Beam, model, equilibrium, modes and statistics of a solution as JSON."""
    state, model = solution.equilibrium, solution.problem.model
    data = {
        "beam": solution.beam.numbers,
        "model": {key: model[key] for key in MODEL_KEYS},
        "equilibrium": {key: getattr(state, key) for key in EQUILIBRIUM_KEYS},
        "modes": mode_records(solution),
        "stats": solution.stats,
    }
    if units := solution.beam.units:
        data["units"] = {"length": units.length, "time": units.time}
    return json_text(data)


def mode_records(solution: "Solution") -> list[dict[str, Any]]:
    """Each mode under the keys of the JSON; growth rates, of either sign, where there is one."""
    values = mode_values(solution)
    rows = zip(*map(plain, values.values()), strict=True)
    records = [dict(zip(values, row, strict=True)) for row in rows]
    for record in records:
        if not (record["frequency"] is None or record["growth_rate"]):
            del record["growth_rate"]
    return records


def solution_csv(solution: "Solution") -> str:
    """One line for each mode under the keys of the JSON; nodes are separated by spaces."""
    records, keys = mode_records(solution), mode_values(solution)
    for record in records:
        record["nodes"] = " ".join(map(repr, record["nodes"]))
    return csv_text(keys, ([record.get(key) for key in keys] for record in records))


def solution_table(solution: "Solution") -> str:
    """The beam, its equilibrium and its modes, to be read in a terminal."""
    beam, state, stats = solution.beam, solution.equilibrium, solution.stats
    heading = ["Beam         " + described_numbers(beam)]
    if units := beam.units:
        heading.append(f"{described_units(units)}, {units.rpm(beam.gamma):.7g} rpm")
    (x, y), bent = state.tip, ", bent" if state.shape == "bent" else ""
    heading += [
        "Model        " + solution.problem.described,
        f"Equilibrium  {described_status(solution)}{bent},"
        f" tip at ({x:.7g}, {y:.7g}) L from the clamp, greatest stretch {state.max_stretch:.7g}",
    ]
    footer = (
        f"{stats.method}: {plural(stats.elements, 'element')} of order {stats.order},"
        f" {stats.dof} unknowns, {1000 * stats.seconds:.3g} ms"
    )
    return "\n".join([*heading, "", *aligned_table(mode_columns(solution)), "", footer])


def described_status(solution: "Solution") -> str:
    """The status of the equilibrium in words."""
    state = solution.equilibrium
    if state.status == "growing":
        return "vibrations grow" + (" at this instant" if solution.beam.spin_up else "")
    if state.status == "stable" and state.buckled_chordwise:
        return "stable flapwise but buckled chordwise (unstable in the plane of rotation)"
    return state.status


def solution_html(solution: "Solution") -> str:
    """The table of the modes that a terminal shows."""
    caption = repr(solution).strip("<").partition(", frequencies")[0]  # which are in the table
    return html_table(caption, mode_columns(solution))


def mode_columns(solution: "Solution") -> dict[str, Iterable[Any]]:
    """The table of modes, to be read."""
    frequencies, errors, units = solution.frequencies, solution.errors, solution.beam.units
    columns: dict[str, Iterable[Any]] = {
        "mode": range(1, len(frequencies) + 1),
        "label": solution.labels,
        "family": solution.families,
        "frequency [1/T*]": significant_column(frequencies, errors),
        "error": [f"{error:.0e}" if math.isfinite(error) else "-" for error in errors],
    }
    if units:
        for name, convert in (("[Hz]", units.hertz), ("[rad/s]", units.angular_frequency)):
            columns[name] = significant_column(convert(frequencies), convert(errors))
    if (rates := solution.growth_rates).any():
        texts = significant_column(rates, errors)
        cells = [text if rate else "-" for text, rate in zip(texts, rates, strict=True)]
        columns["growth rate [1/T*]"] = cells
    columns["bending"] = [f"{100 * share:.0f} %" for share in solution.bending_energy_fraction]
    columns["nodes x/L"] = [" ".join(f"{x:.5f}" for x in at) or "-" for at in solution.nodes]
    return columns


def solution_dataset(solution: "Solution") -> "xarray.Dataset":
    """See Solution.to_xarray."""
    values, line = mode_values(solution), along_beam(solution)
    return optional("xarray", "xarray").Dataset(
        {
            **{key: ("mode", np.array(values[key]), UNITS.get(key)) for key in VALUE_KEYS},
            "shape": (("mode", "x", "component"), line["shape"], {"long_name": "unit modal mass"}),
            "position": (("x", "component"), line["position"], {"units": "L"}),
            "stretch": ("x", line["stretch"]),
        },
        {
            "mode": values["index"],
            "label": ("mode", np.array(values["label"])),
            "x": ("x", line["x"], {"units": "L"}),
            "component": ["along", "across"],
        },
        {
            **dataset_attributes(solution.beam, solution.problem, solution.beam.units),
            "status": solution.equilibrium.status,
        },
    )


SOLUTION_FORMATS = {"table": solution_table, "json": solution_json, "csv": solution_csv}


# Frequency loci.


def loci_json(loci: "Loci") -> str:
    """Sweep, branches, events and limits as JSON."""
    keys = ("label", *VALUE_KEYS)
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


def loci_csv(loci: "Loci") -> str:
    """One line for each value, every column a number: frequencies, growth rates of branches that
    grow or decay, bending fractions."""
    columns = {loci.over: loci.values}
    if loci.units and loci.over == "gamma":
        columns["rpm"] = loci.units.rpm(loci.values)
    columns |= {branch.label: branch.frequency for branch in loci.branches}
    if loci.units:
        columns |= {f"{b.label}_hertz": loci.units.hertz(b.frequency) for b in loci.branches}
    growing = [branch for branch in loci.branches if np.nan_to_num(branch.growth_rate).any()]
    columns |= {f"{branch.label}_growth_rate": branch.growth_rate for branch in growing}
    columns |= {f"{branch.label}_bending": branch.bending_fraction for branch in loci.branches}
    return csv_text(columns, zip(*(column.tolist() for column in columns.values()), strict=True))


def loci_table(loci: "Loci") -> str:
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


def frequency_lines(loci: "Loci") -> list[str]:
    """The table of frequencies, thinned to at most MAX_LOCI_ROWS values."""
    count = len(loci.values)
    step = math.ceil((count - 1) / (MAX_LOCI_ROWS - 1))
    rows = [*range(0, count - 1, step), count - 1]
    columns = {f"{one.label}  ": [*branch_cells(one, rows)] for one in loci.branches}
    thinned = f", one value in {step} (--format csv has all)" if step > 1 else ""
    table = aligned_table({loci.over: [f"{loci.values[i]:.7g}" for i in rows], **columns})
    lines = [f"Frequencies [1/T*]{thinned}", *table]
    if any(np.nan_to_num(branch.growth_rate[rows]).any() for branch in loci.branches):
        lines.append("+, -: growth rate [1/T*] of a mode that grows or decays")
    if any(cell[-1] in "bsm" for cells in columns.values() for cell in cells):
        lines.append("b, s, m: bending, stretching or mixed there, unlike the label")
    return lines


def branch_cells(branch: "Branch", rows: list[int]) -> Iterator[str]:
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


def event_lines(loci: "Loci") -> list[str]:
    """The table of events."""
    if not loci.events:
        return ["No crossing or veering in this range."]
    return aligned_table(event_columns(loci, loci.events))


def event_columns(loci: "Loci", events: Sequence["Event"]) -> Columns:
    """The table of events, to be read; with rpm for a beam in SI."""
    columns: dict[str, Iterable[Any]] = {
        "event": [event_name(event) for event in events],
        "branches": [" ".join(event.branches) for event in events],
        f"at {loci.over}": [f"{event.at:.6f}" for event in events],
    }
    if loci.units and loci.over == "gamma":
        columns["rpm"] = [f"{loci.units.rpm(event.at):.6g}" for event in events]
    columns["frequency [1/T*]"] = [f"{event.frequency:.5f}" for event in events]
    if any(event.kind == "veering" for event in events):
        veers = [event.kind == "veering" for event in events]
        pairs = [*zip(events, veers, strict=True)]
        columns["gap [1/T*]"] = [f"{event.gap:.3g}" if own else "-" for event, own in pairs]
        columns["veering index"] = [f"{event.index:.3f}" if own else "-" for event, own in pairs]
    return columns


def event_name(event: "Event") -> str:
    """The kind of an event; of a resonance with the multiple of the speed, as "resonance 2x"."""
    return f"{event.kind} {event.per_rev}x" if event.per_rev else event.kind


def loci_html(loci: "Loci") -> str:
    """A small table of crossings and veerings."""
    return html_table(repr(loci), event_columns(loci, loci.events[:MAX_HTML_ROWS]))


def loci_dataset(loci: "Loci") -> "xarray.Dataset":
    """See Loci.to_xarray."""
    rows = {key: [getattr(branch, key) for branch in loci.branches] for key in VALUE_KEYS}
    rows["family"] = [[name or "" for name in family] for family in rows["family"]]
    dims = loci.over, "branch"
    attributes = dataset_attributes(loci.beam, loci.problem, loci.units)
    attributes.pop(loci.over, None)
    return optional("xarray", "xarray").Dataset(
        {key: (dims, np.transpose(row), UNITS.get(key)) for key, row in rows.items()},
        {loci.over: loci.values, "branch": [branch.label for branch in loci.branches]},
        attributes,
    )


LOCI_FORMATS = {"table": loci_table, "json": loci_json, "csv": loci_csv}
