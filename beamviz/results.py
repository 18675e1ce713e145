"""Results as labelled arrays, tables and drawings: what the methods of Solution and Loci call."""

import html
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from beamviz.errors import optional
from beamviz.frequency_loci import Loci
from beamviz.output import mode_columns
from beamviz.plotting import COLOURS
from beamviz.solver import Solution

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes

STATIONS = 201  # along the beam
COMPONENTS = ["along", "across"]
PER_TIME = {"units": "1/T*"}
MAX_ROWS = 20  # of a table of branches


def solution_dataset(solution: Solution) -> "xarray.Dataset":
    """See Solution.to_xarray."""
    x = np.linspace(0.0, 1.0, STATIONS)
    shape = solution.displacement(x).transpose(2, 0, 1)
    return optional("xarray", "xarray").Dataset(
        {
            "frequency": ("mode", solution.frequencies, PER_TIME),
            "error": ("mode", solution.errors, PER_TIME),
            "growth_rate": ("mode", solution.growth_rates, PER_TIME),
            "family": ("mode", np.array(solution.families)),
            "bending_fraction": ("mode", solution.bending_energy_fraction),
            "shape": (("mode", "x", "component"), shape, {"long_name": "unit modal mass"}),
            "position": (("x", "component"), solution.equilibrium.position(x), {"units": "L"}),
            "stretch": ("x", solution.equilibrium.stretch(x)),
        },
        {
            "mode": np.arange(1, len(solution.frequencies) + 1),
            "label": ("mode", np.array(solution.labels)),
            "x": ("x", x, {"units": "L"}),
            "component": COMPONENTS,
        },
        {**_attributes(solution), "status": solution.equilibrium.status},
    )


def loci_dataset(loci: Loci) -> "xarray.Dataset":
    """See Loci.to_xarray."""
    dims = loci.over, "branch"
    attributes = {name: x for name, x in _attributes(loci).items() if name != loci.over}

    def columns(name: str) -> np.ndarray:
        return np.column_stack([getattr(branch, name) for branch in loci.branches])

    families = [[name or "" for name in branch.family] for branch in loci.branches]
    return optional("xarray", "xarray").Dataset(
        {
            **{
                name: (dims, columns(name), PER_TIME)
                for name in ("frequency", "error", "growth_rate")
            },
            "bending_fraction": (dims, columns("bending_fraction")),
            "family": (dims, np.array(families).T),
        },
        {loci.over: loci.values, "branch": [branch.label for branch in loci.branches]},
        attributes,
    )


def _attributes(result: Solution | Loci) -> dict[str, Any]:
    """The model, the numbers, units and version of a result; without None, as in files."""
    from beamviz import __version__

    units = result.units if isinstance(result, Loci) else result.beam.units
    sizes = units.attributes if units else {}
    return {**result.beam.numbers, **result.problem.model, **sizes, "beamviz_version": __version__}


def records_dataframe(kind: type, records: Sequence[Any]) -> Any:
    """A pandas.DataFrame of events or limits, a row for each; see Loci.events_dataframe."""
    rows = [one._asdict() if hasattr(one, "_asdict") else vars(one) for one in records]
    return optional("pandas", "xarray").DataFrame(rows, columns=list(kind.__annotations__))


def plot_solution(solution: Solution, axes: "Axes | None" = None) -> "Axes":
    """See Solution.plot."""
    axes = axes or optional("matplotlib.pyplot", "test").gca()  # the current ones, by default
    x = np.linspace(0.0, 1.0, STATIONS)
    shapes = solution.displacement(x)
    for k, share in enumerate(solution.bending_energy_fraction):
        shape = shapes[:, int(share >= 0.5), k].real
        family = "bending" if share >= 0.5 else "stretching"
        own = [label for label in solution.labels[:k] if label[0] == solution.labels[k][0]]
        axes.plot(
            x,
            shape / abs(shape).max(),
            color=COLOURS[family],
            alpha=max(1 - 0.2 * len(own), 0.3),
            ls="-" if family == "bending" else "--",
            label=f"{solution.labels[k]}  ω = {solution.frequencies[k]:.5g}",
        )
    axes.axhline(0, color="0.7", lw=0.8, zorder=0)
    axes.set(xlim=(0, 1), xlabel="reference coordinate x / L", ylabel="displacement (largest = 1)")
    axes.legend(frameon=False, fontsize=8, loc="upper left")
    return axes


def plot_loci(loci: Loci, axes: "Axes | None" = None) -> "Axes":
    """See Loci.plot."""
    from beamviz.plotting.loci import Chart

    axes = axes or optional("matplotlib.pyplot", "test").gca()
    Chart(loci, axes).annotate()
    return axes


def solution_html(solution: Solution) -> str:
    """The table of the modes that a terminal shows."""
    caption = repr(solution).strip("<").partition(", frequencies")[0]  # which are in the table
    return html_table(caption, *zip(*mode_columns(solution), strict=True))


def loci_html(loci: Loci) -> str:
    """A small table of crossings and veerings."""
    rows = [
        (e.kind, " ".join(e.branches), f"{e.at:.6g}", f"{e.frequency:.6g}", f"{e.gap:.6g}")
        for e in loci.events
    ]
    heading = ("event", "branches", f"at {loci.over}", "frequency [1/T*]", "gap [1/T*]")
    return html_table(repr(loci), heading, *rows[:MAX_ROWS])


def html_table(caption: str, heading: Iterable[str], *rows: Iterable[str]) -> str:

    def row(tag: str, cells: Iterable[str]) -> str:
        return "<tr>" + "".join(f"<{tag}>{html.escape(c)}</{tag}>" for c in cells) + "</tr>"

    lines = [row("th", heading), *(row("td", cells) for cells in rows)]
    return f"<table><caption>{html.escape(caption)}</caption>{''.join(lines)}</table>"
