"""Frequency loci as a table for a terminal, JSON and CSV."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from beamviz.datasets import QUANTITIES
from beamviz.files import csv_text, json_text
from beamviz.frequency_loci import Loci
from beamviz.frequency_loci.branches import Branch
from beamviz.frequency_loci.events import EVENT_COLUMNS, EXCHANGES, record_of
from beamviz.frequency_loci.events.record import Event
from beamviz.frequency_loci.limits import Limit
from beamviz.output import described_numbers, described_units, units_record
from beamviz.tables import aligned_table, event_columns, plural, significant_decimals
from beamviz.units import Units, usual_measure

MAX_ROWS = 21  # of the table of frequencies


def loci_json(loci: Loci) -> str:
    """Sweep, branches, events and limits as JSON."""
    keys = ("label", *QUANTITIES, "in_plane_fraction")
    data: dict[str, Any] = {
        "beam": {name: x for name, x in loci.beam.record.items() if name != loci.over},
        "model": loci.problem.model,
        "over": loci.over,
        "values": loci.values,
        "branches": [
            {key: value for key in keys if (value := getattr(branch, key)) is not None}
            for branch in loci.branches
        ],
        "events": [record_of(event) for event in loci.events],
        "limits": loci.limits,
        **({"margins": [margin.record for margin in loci.margins]} if loci.margins else {}),
        "stats": {"solves": loci.solves, "seconds": loci.seconds},
    }
    if units := loci.units:
        for record in data["branches"]:
            record["hertz"] = units.hertz(record["frequency"])
        data["units"] = units_record(units)
        data |= si_values(loci)
        data["events"] = [record_of(event) | event_si(loci, event) for event in loci.events]
        data["limits"] = [limit._asdict() | limit_si(loci, limit) for limit in loci.limits]
    return json_text(data)


def si_values(loci: Loci) -> dict[str, NDArray]:
    """The values of a beam in SI in the unit of the parameter, by the unit: rpm, kg, mm."""
    measure = usual_measure(loci.over, loci.units)
    return {measure.scale.key: measure.factor * loci.values} if measure else {}


def event_si(loci: Loci, event: Event) -> dict[str, float]:
    """The place, frequency and gap of an event of a beam in SI."""
    measure, units = usual_measure(loci.over, loci.units), loci.units
    assert units
    place = {}
    if measure:
        place[measure.scale.key] = measure.factor * event.at
        if event.until is not None:
            place[f"until_{measure.scale.key}"] = measure.factor * event.until
    gap = {"gap_hertz": units.hertz(event.gap)} if event.gap else {}
    return {**place, "hertz": units.hertz(event.frequency), **gap}


def loci_csv(loci: Loci) -> str:
    """One line for each value, every column a number: frequencies, growth rates of branches that
    grow or decay, bending fractions, in space the fractions in the plane of rotation."""
    columns = {loci.over: loci.values, **si_values(loci)}
    columns |= {branch.label: branch.frequency for branch in loci.branches}
    if units := loci.units:
        hertz = {f"{branch.label}_hertz": units.hertz(branch.frequency) for branch in loci.branches}
        columns |= hertz
    growing = [branch for branch in loci.branches if np.nan_to_num(branch.growth_rate).any()]
    columns |= {f"{branch.label}_growth_rate": branch.growth_rate for branch in growing}
    columns |= {f"{branch.label}_bending": branch.bending_fraction for branch in loci.branches}
    columns |= {
        f"{branch.label}_in_plane": branch.in_plane_fraction
        for branch in loci.branches
        if branch.in_plane_fraction is not None
    }
    return csv_text(columns, zip(*(column.tolist() for column in columns.values()), strict=True))


def events_csv(loci: Loci) -> str:
    """One line for each event, also without any a heading; the columns are the keys of JSON. The
    labels of branches are separated by a space."""
    columns: tuple[str, ...] = EVENT_COLUMNS
    records = [record_of(event) | {"branches": " ".join(event.branches)} for event in loci.events]
    if loci.units:
        measure = usual_measure(loci.over, loci.units)
        places = (measure.scale.key, f"until_{measure.scale.key}") if measure else ()
        columns = *columns, *places, "hertz", "gap_hertz"
        pairs = zip(records, loci.events, strict=True)
        records = [record | event_si(loci, event) for record, event in pairs]
    return csv_text(columns, ([record.get(name) for name in columns] for record in records))


def heading(loci: Loci) -> list[str]:
    """The lines that state the beam, the sweep and the model."""
    return [
        "Beam         " + described_numbers(loci.beam, without=loci.over),
        f"Sweep        {loci.over} = {loci.values[0]:.7g} .. {loci.values[-1]:.7g},"
        f" {len(loci.values)} values{described_range(loci)}",
        "Model        " + loci.problem.described,
        *([described_units(loci.beam, loci.units)] if loci.units else []),
    ]


def loci_notes(loci: Loci) -> list[str]:
    """The lines of the events and the limits."""
    return [*event_lines(loci), *(limit.message for limit in loci.limits)]


def loci_table(loci: Loci) -> str:
    """The sweep, its frequencies and its events, to be read in a terminal."""
    footer = f"{plural(loci.solves, 'solve')}, {1000 * loci.seconds:.3g} ms"
    limits = [limit.message for limit in loci.limits]
    parts = [heading(loci), frequency_lines(loci), event_lines(loci), limits]
    parts += [margin_lines(loci), [footer]]
    return "\n\n".join("\n".join(part) for part in parts if part)


def limit_si(loci: Loci, limit: Limit) -> dict[str, float]:
    """The ends of a range without a stable equilibrium, of a beam in SI: start_rpm, stop_rpm."""
    measure = usual_measure(loci.over, loci.units)
    if measure is None:
        return {}
    key, factor = measure.scale.key, measure.factor
    return {f"start_{key}": factor * limit.start, f"stop_{key}": factor * limit.stop}


def described_range(loci: Loci) -> str:
    """The range of the values of a beam in SI: ", 0 .. 300 rpm"."""
    measure = usual_measure(loci.over, loci.units)
    if measure is None:
        return ""
    first, last = (measure.factor * loci.values[[0, -1]]).tolist()
    return f", {first:.7g} .. {last:.7g} {measure.scale.unit}"


def frequency_lines(loci: Loci) -> list[str]:
    """The table of frequencies, in Hz for a beam in SI, thinned to at most MAX_ROWS values."""
    count = len(loci.values)
    unit, rate_unit = ("Hz", "1/s") if loci.units else ("1/T*", "1/T*")
    step = math.ceil((count - 1) / (MAX_ROWS - 1))
    rows = [*range(0, count - 1, step), count - 1]
    columns = {
        f"{branch.label}  ": [*branch_cells(branch, rows, loci.units)] for branch in loci.branches
    }
    thinned = f", one value in {step} (--format csv has all)" if step > 1 else ""
    places = {loci.over: loci.values} | {f"[{key}]": row for key, row in si_values(loci).items()}
    leading = {name: [f"{row[i]:.7g}" for i in rows] for name, row in places.items()}
    table = aligned_table({**leading, **columns})
    lines = [f"Frequencies [{unit}]{thinned}", *table]
    if any(np.nan_to_num(branch.growth_rate[rows]).any() for branch in loci.branches):
        lines.append(f"+, -: growth rate [{rate_unit}] of a mode that grows or decays")
    if any(cell[-1] in "bsmfl" for cells in columns.values() for cell in cells):
        letters = "b, s, m: bending, stretching or mixed there"
        if loci.problem.in_space:
            letters = "f, l, s: mainly flap, lag or stretching there"
        lines.append(f"{letters}, unlike the label")
    return lines


def branch_cells(branch: Branch, rows: list[int], units: Units | None) -> Iterator[str]:
    """Frequencies of a branch, in Hz with units, significant decimals; a letter marks a kind
    unlike the label's."""
    factor, per_time = (units.hertz(1.0), 1 / units.time) if units else (1.0, 1.0)
    errors = [factor * branch.error[i] for i in rows if branch.mode_index[i] >= 0]
    decimals = min([5, *map(significant_decimals, errors)])
    for i in rows:
        value, letter = factor * branch.frequency[i], (branch.kinds[i] or "").lower()
        rate = per_time * branch.growth_rate[i]
        text = f"{value:.{decimals}f}" if math.isfinite(value) else "unstable"
        if rate:
            text = f"{text} {rate:+.{decimals}f}"
        yield f"{text} {letter if letter != branch.label[0].lower() else ' '}" if letter else "-  "


def event_lines(loci: Loci) -> list[str]:
    """The table of events, and what was sought and not found."""
    events, per_rev = loci.events, loci.tracked.per_rev
    lines = aligned_table(event_columns(loci.over, loci.units, events)) if events else []
    lines += [
        f"{event.branches[0]} lies on the line {event.per_rev}x from {loci.over} = {event.at:.7g}"
        f" to {event.until:.7g}: a resonance at each of these speeds."
        for event in events
        if event.until is not None
    ]
    exchanges = [name for name in EXCHANGES if name in loci.kinds]
    if exchanges and not any(event.kind in exchanges for event in events):
        lines.append(f"No {' or '.join(exchanges)} in this range.")
    if per_rev and not any(event.per_rev for event in events):
        multiples = "1x" if per_rev == 1 else f"1x .. {per_rev}x"
        lines.append(f"No resonance with {multiples} in this range.")
    return lines


def margin_lines(loci: Loci) -> list[str]:
    """The table of the margins to per-rev lines at the operating speed; nothing without any."""
    margins = loci.margins
    if not margins:
        return []
    speed, units = margins[0].speed, loci.units
    rpm = f", {units.rpm(speed):.7g} rpm" if units else ""
    columns: dict[str, list[str]] = {
        "label": [margin.label for margin in margins],
        "frequency [1/T*]": [f"{margin.frequency:.5f}" for margin in margins],
    }
    if units:
        columns["[Hz]"] = [f"{units.hertz(margin.frequency):.5g}" for margin in margins]
    columns["Southwell"] = [
        "-" if margin.southwell is None else f"{margin.southwell:.4f}" for margin in margins
    ]
    for k in range(len(margins[0].percent)):
        columns[f"{k + 1}x"] = [
            "on it" if k + 1 in margin.on_lines else f"{margin.percent[k]:+.1f} %"
            for margin in margins
        ]
    heading = f"Margins to per-rev lines at the operating speed, gamma = {speed:.7g}{rpm}"
    return [heading, *aligned_table(columns)]


def margins_csv(loci: Loci) -> str:
    """One line for each mode at the operating speed: its frequency, its Southwell coefficient and
    its margins [%] to the per-rev lines, also without any a heading."""
    count = loci.tracked.per_rev
    lines = [f"margin_{k}x" for k in range(1, count + 1)]
    columns = ["label", "index", "speed", "frequency", "southwell", *lines, "nearest", "on_lines"]
    if loci.units:
        columns += ["rpm", "hertz"]
    rows = []
    for margin in loci.margins:
        record = margin.record
        row = [record[name] for name in columns[:5]]
        row += [*margin.percent, margin.nearest, " ".join(map(str, margin.on_lines))]
        if units := loci.units:
            row += [float(units.rpm(margin.speed)), float(units.hertz(margin.frequency))]
        rows.append(row)
    return csv_text(columns, rows)


LOCI_FORMATS = {"table": loci_table, "json": loci_json, "csv": loci_csv}
