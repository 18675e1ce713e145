"""The paper's tables and figures, computed anew and written as files."""

import sys
import time
from collections.abc import Sequence
from pathlib import Path

from beamviz.errors import InvalidInput
from beamviz.paper import figures, table_page, tables
from beamviz.paper import values as numbers
from beamviz.paper.data import FIGURES, SOURCE, TABLES, Figure, LociFigure
from beamviz.plotting.files import Files, write, writing_to

NUMBERS = "numbers"
ALL = "all"
NAMES = (*TABLES, *FIGURES, NUMBERS)
INDEX = "index.md"
WHAT = (
    "Every table and figure computed anew: green strain, the spatial curvature of the paper's"
    " eq. 16 unless another model is named, and no Coriolis, as in the paper. Frequencies are in"
    " units of 1/T*, mode shapes have unit modal mass. The bodies of the paper's tables and the"
    " curves of its figures are not available to this project: what stands beside the computed"
    " numbers is what its text prints."
)


def reproduce(names: Sequence[str], folder: Path) -> Path:
    """Write the named tables and figures ("all" for every one) and an index of the folder.

    Returns the index. A file is complete, or not there. Raises InvalidInput for a name that does
    not exist, Unavailable for a folder that cannot be written to.
    """
    wanted = chosen(names)
    with writing_to(folder):
        write(folder, index(folder))  # says before all the work whether this folder will do
        for name in wanted:
            start = time.perf_counter()
            write(folder, files(name))
            print(f"{name}  {time.perf_counter() - start:.1f} s", file=sys.stderr)
        write(folder, index(folder))
    return folder / INDEX


def chosen(names: Sequence[str]) -> list[str]:
    """The names in the paper's order, each once."""
    for name in names:
        if name not in (*NAMES, ALL):
            known = ", ".join((*NAMES, ALL))
            raise InvalidInput(f"{name!r} is not in the paper: choose from {known}")
    return [name for name in NAMES if name in names or ALL in names]


def files(name: str) -> Files:
    """The files of a table, a figure, or the printed numbers."""
    if name in FIGURES:
        return figure_files(FIGURES[name])
    if name == NUMBERS:
        found = numbers.numbers()
        texts = {"csv": numbers.as_csv(found), "md": numbers.as_markdown(found)}
    else:
        table = TABLES[name]
        rows = tables.computed(table)
        texts = {"csv": tables.as_csv(table, rows), "md": table_page.as_markdown(table, rows)}
    return {f"{name}.{ending}": text.encode() for ending, text in texts.items()}


def figure_files(figure: Figure) -> Files:
    """A figure as pictures and as numbers."""
    from beamviz.paper import plots as paper_plots

    if isinstance(figure, LociFigure):
        charts = figures.charts(figure)
        picture = paper_plots.loci_plot(figure, charts, figures.meetings(figure, charts))
        text = figures.loci_csv(charts)
    else:
        curves = figures.curves(figure)
        picture = paper_plots.shape_plot(figure, curves)
        text = figures.shapes_csv(curves)
    contents = {**paper_plots.saved(picture), "csv": text.encode()}
    return {f"{figure.name}.{ending}": data for ending, data in contents.items()}


def index(folder: Path) -> Files:
    """The page of what is in a folder."""
    there = {file.name for file in folder.iterdir()}
    parts = ["# The paper, reproduced", f"{SOURCE}.", WHAT]
    if line := linked(NUMBERS, there):
        parts.append(f"**{numbers.TITLE}**, printed and computed: {line}")
    parts += [
        f"**Table {name[5:]}.** {TABLES[name].caption}: {line}"
        for name, line in lines(TABLES, there)
    ]
    for name, line in lines(FIGURES, there):
        figure = FIGURES[name]
        notes = " ".join(figure.notes)
        parts += [
            f"## Figure {name[3:]}",
            f"{figure.caption}. {notes} {line}",
            f"![{figure.caption}]({name}.png)",
        ]
    return {INDEX: ("\n\n".join(parts) + "\n").encode()}


def lines(scenes: dict, there: set[str]) -> list[tuple[str, str]]:
    """The names of scenes whose files are there, with links to these."""
    return [(name, line) for name in scenes if (line := linked(name, there))]


def linked(name: str, there: set[str]) -> str:
    """Links to the files of one name."""
    endings = [ending for ending in ("md", "csv", "png", "svg") if f"{name}.{ending}" in there]
    return ", ".join(f"[{ending}]({name}.{ending})" for ending in endings)
