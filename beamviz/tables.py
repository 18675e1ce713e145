"""Tables of results for a terminal, a notebook and pandas, made of columns and plain records."""

import html
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from beamviz.errors import requires
from beamviz.units import Units, usual_measure

if TYPE_CHECKING:  # the table of modes needs no loci
    from beamviz.frequency_loci.events.record import Event

Columns = Mapping[str, Iterable[Any]]  # the cells of each column of a table, by its heading
MAX_DECIMALS = 9
LEFT_ALIGNED = ("label", "family", "nodes x/L")


def aligned_table(columns: Columns) -> list[str]:
    """The lines of a table; the cells of numbers align right."""
    aligned = []
    for heading, cells in columns.items():
        texts = [heading, *map(str, cells)]
        side, width = "<" if heading in LEFT_ALIGNED else ">", max(map(len, texts))
        aligned.append([f"{text:{side}{width}}" for text in texts])
    return ["  ".join(line).rstrip() for line in zip(*aligned, strict=True)]


def html_table(caption: str, columns: Columns) -> str:
    """A table in HTML, with all texts escaped."""

    def row(tag: str, cells: Iterable[Any]) -> str:
        return "<tr>" + "".join(f"<{tag}>{html.escape(str(c))}</{tag}>" for c in cells) + "</tr>"

    rows = "".join(row("td", cells) for cells in zip(*columns.values(), strict=True))
    return f"<table><caption>{html.escape(caption)}</caption>{row('th', columns)}{rows}</table>"


def dataframe(columns: Sequence[str], records: Sequence[Any]) -> Any:
    """A pandas.DataFrame with these columns and a row for each record."""
    with requires("xarray"):
        import pandas
    return pandas.DataFrame(list(records), columns=list(columns))


def plural(count: int, noun: str) -> str:
    """A count and its noun: "1 element", "2 elements"."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


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


def mode_columns(modes: Mapping[str, Any], units: Units | None) -> dict[str, Iterable[Any]]:
    """The table of modes as texts, of `Solution.columns`; units: of a beam in SI."""
    frequency, error, growth_rate = (modes[key] for key in ("frequency", "error", "growth_rate"))
    columns: dict[str, Iterable[Any]] = {
        "mode": modes["index"],
        "label": modes["label"],
        "family": modes["family"],
        "frequency [1/T*]": significant_column(frequency, error),
        "error": [f"{value:.0e}" if math.isfinite(value) else "-" for value in error],
    }
    if units:
        for name, convert in (("[Hz]", units.hertz), ("[rad/s]", units.angular_frequency)):
            columns[name] = significant_column(convert(frequency), convert(error))
    if np.any(growth_rate):
        texts = significant_column(growth_rate, error)
        cells = [text if rate else "-" for text, rate in zip(texts, growth_rate, strict=True)]
        columns["growth rate [1/T*]"] = cells
    columns["bending"] = [f"{100 * share:.0f} %" for share in modes["bending_fraction"]]
    if "in_plane_fraction" in modes:
        columns["in plane"] = [f"{100 * share:.0f} %" for share in modes["in_plane_fraction"]]
    columns["nodes x/L"] = [" ".join(f"{x:.5f}" for x in at) or "-" for at in modes["nodes"]]
    return columns


def event_columns(over: str, units: Units | None, events: "Sequence[Event]") -> Columns:
    """The table of the events of loci over a parameter as texts; for a beam in SI with rpm, kg or
    mm, and Hz. Of a resonance all along a range there are the ends of it."""
    places = [(event.at, event.until) for event in events]
    heights = [(event.frequency, event.frequency_until) for event in events]
    columns: dict[str, Iterable[Any]] = {
        "event": [event.name for event in events],
        "branches": [" ".join(event.branches) for event in events],
        f"at {over}": [in_range(ends, "{:.6f}") for ends in places],
    }
    if measure := usual_measure(over, units):
        columns[measure.scale.unit] = [in_range(ends, "{:.6g}", measure.factor) for ends in places]
    columns["frequency [1/T*]"] = [in_range(ends, "{:.5f}") for ends in heights]
    if units:
        columns["[Hz]"] = [in_range(ends, "{:.6g}", units.hertz(1.0)) for ends in heights]
    if any(event.gap for event in events):
        columns["gap [1/T*]"] = [f"{event.gap:.3g}" if event.gap else "-" for event in events]
    return {**columns, **kind_columns(events)}


def kind_columns(events: "Sequence[Event]") -> Columns:
    """The columns of numbers that only some kinds of events have, where an event has one."""
    from beamviz.frequency_loci.events import FIELDS  # the table of modes needs no loci

    columns = {}
    for field in FIELDS.values():
        numbers = [getattr(event, field.name, 0.0) for event in events]
        if field.heading and any(numbers):
            columns[field.heading] = [field.form.format(x) if x else "-" for x in numbers]
    return columns


def in_range(ends: tuple[float, float | None], form: str, factor: float = 1.0) -> str:
    """A number, or the ends of a range, times a factor: "0 .. 3.2"."""
    return " .. ".join(form.format(factor * end) for end in ends if end is not None)
