"""The paper's tables and figures, computed again and written as files."""

import sys
import time
from collections.abc import Sequence
from pathlib import Path

from beamviz.errors import InvalidInput
from beamviz.files import Files, make_folder, write_files
from beamviz.paper import figures, tables
from beamviz.paper.figures import FIGURES
from beamviz.paper.tables import TABLES

NUMBERS = "numbers"
ALL = "all"
NAMES = (*TABLES, *FIGURES, NUMBERS)
INDEX = "index.md"
EXTENSIONS = ("md", "csv", "png", "svg")
SOURCE = (
    '"Modal characteristics of a rotating flexible beam with a concentrated mass based on the'
    ' absolute nodal coordinate formulation", Nonlinear Dynamics (2017)'
)
SUMMARY = (
    "Every table and figure computed anew: green strain, the spatial curvature of the paper's"
    " eq. 16 unless another model is named, and no Coriolis, as in the paper. Frequencies are in"
    " units of 1/T*, mode shapes have unit modal mass. The bodies of the paper's tables and the"
    " curves of its figures are not available to this project: what stands beside the computed"
    " numbers is what its text prints."
)


def reproduce(names: Sequence[str], folder: Path) -> Path:
    """Write tables, figures and printed numbers of the paper, and an index of the folder.

    names: of NAMES, or "all" for every one. Each file is written completely or not at all.
    Returns the path of the index. Raises InvalidInput for an unknown name and Unavailable for a
    folder that cannot be written to.
    """
    for name in names:
        if name not in (*NAMES, ALL):
            known = ", ".join((*NAMES, ALL))
            raise InvalidInput(f"{name!r} is not in the paper: choose from {known}")
    make_folder(folder)
    for name in NAMES:
        if name in names or ALL in names:
            start = time.perf_counter()
            write_files(folder, files(name))
            print(f"{name}  {time.perf_counter() - start:.1f} s", file=sys.stderr)
    write_files(folder, index(folder))
    return folder / INDEX


def files(name: str) -> Files:
    """The files of a table, a figure, or the printed numbers."""
    if name in FIGURES:
        from beamviz.paper.plots import figure_files

        return figure_files(FIGURES[name])
    if name in TABLES:
        table = TABLES[name]
        rows = tables.compute(table)
        texts = {"csv": tables.to_csv(table, rows), "md": tables.to_markdown(table, rows)}
    else:
        numbers = list(figures.printed_numbers())
        texts = {"csv": figures.to_csv(numbers), "md": figures.to_markdown(numbers)}
    return {f"{name}.{extension}": text.encode() for extension, text in texts.items()}


def index(folder: Path) -> Files:
    """A page that lists the tables and figures in a folder."""
    parts = ["# The paper, reproduced", f"{SOURCE}.", SUMMARY]
    for name in (NUMBERS, *TABLES, *FIGURES):
        present = [ext for ext in EXTENSIONS if (folder / f"{name}.{ext}").exists()]
        links = ", ".join(f"[{ext}]({name}.{ext})" for ext in present)
        if links and name in FIGURES:
            figure = FIGURES[name]
            parts += [f"## Figure {name[3:]}", f"{figure.caption}. {figure.notes} {links}"]
            parts.append(f"![{figure.caption}]({name}.png)")
        elif links and name in TABLES:
            parts.append(f"**Table {name[5:]}.** {TABLES[name].caption}: {links}")
        elif links:
            parts.append(f"**{figures.TITLE}**, printed and computed: {links}")
    return {INDEX: ("\n\n".join(parts) + "\n").encode()}
