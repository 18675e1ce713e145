"""beamviz reproduce: every table and figure as complete, correct and readable files."""

import csv
import re
import xml.etree.ElementTree as ElementTree
from functools import cache

import numpy as np
import pytest
from helpers import contents, slow
from matplotlib.image import imread
from matplotlib.text import Annotation, Text

from beamviz import Beam, solve
from beamviz.cli import main
from beamviz.paper import MODELS, compute, figures
from beamviz.paper.figures import FIGURES, LociFigure, printed_numbers
from beamviz.paper.tables import TABLES
from beamviz.plotting.labels import LabelPlacer

LOCI = [figure for figure in FIGURES.values() if isinstance(figure, LociFigure)]
SOME = ("table4", "fig5", "fig13", "fig17")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The folder of `reproduce` for a table and three figures."""
    folder = tmp_path_factory.mktemp("paper") / "new" / "folder"
    assert main(["reproduce", *SOME, "--out", str(folder)]) == 0
    return folder


@cache
def drawn(figure):
    """The loci of a figure by curvature measure, their crossings, the picture, its annotations."""
    computed = figures.compute_loci(figure)
    crossings = figures.crossings(figure, computed)
    picture = figures.draw_loci(figure, computed, crossings)
    notes = [text for text in picture.axes[0].texts if isinstance(text, Annotation)]
    return computed, crossings, picture, notes


@pytest.mark.parametrize("names", [SOME, *slow([*TABLES, *FIGURES, "numbers"])], ids=len)
def test_files_are_linked_and_readable(names, folder, tmp_path):
    """Everything is the default: four tables and sixteen figures, the numbers and the index. Every
    file is linked under its caption, every link leads to a file, and each figure is shown: a PNG of
    the size of a column with something on it, an SVG that is XML, and a CSV file of numbers with
    complete rows."""
    if names != SOME:
        folder = tmp_path
        assert main(["reproduce", "--out", str(folder)]) == 0
    shown = FIGURES.keys() & names
    expected = {f"{name}.{ending}" for name in shown for ending in ("csv", "png", "svg")}
    expected |= {f"{name}.{ending}" for name in {*names} - shown for ending in ("csv", "md")}
    page = (folder / "index.md").read_text(encoding="utf-8")
    assert set(re.findall(r"\]\(([^)]+)\)", page)) == expected
    assert set(contents(folder)) == expected | {"index.md"}
    for words in ("**Table 4.** First and second chordwise", "## Figure 13\n\nSecond mode shape"):
        assert words in page
    assert page.count("![") == len(shown)
    assert "not available to this project" in page
    for name in shown:
        pixels = imread(folder / f"{name}.png")
        assert pixels.shape[1] == 1440
        assert 0.005 < (pixels[..., :3].min(axis=2) < 0.9).mean() < 0.2
        assert ElementTree.parse(folder / f"{name}.svg").getroot().tag.endswith("svg")
        heading, *rows = csv.reader((folder / f"{name}.csv").read_text().splitlines())
        assert len(rows) in (figures.POINTS, 2 * figures.POINTS)
        assert all(len(row) == len(heading) for row in rows)
        numbers = [float(cell) for row in rows for cell in row if cell[0] not in "sm"]
        assert np.isfinite(numbers).all()


def test_numbers_are_those_of_solves(folder):
    """The frequencies of figure 5 at gamma 10, by both measures; the last point of figure 13 is the
    tip of the second mode for each mass ratio."""
    texts = ((folder / f"{name}.csv").read_text() for name in ("fig5", "fig13"))
    fig5, fig13 = (list(csv.DictReader(text.splitlines())) for text in texts)
    rows = [row for row in fig5 if row["gamma"] == "10"]
    assert [row["curvature"] for row in rows] == ["spatial", "material"]
    for row in rows:
        solution = solve(Beam(alpha=1, beta=0.5, gamma=10), curvature=row["curvature"])
        for label, frequency in zip(solution.labels, solution.frequencies, strict=True):
            assert float(row[label]) == pytest.approx(frequency, rel=1e-6)
    for alpha in (0, 0.5, 1, 2):
        tip = solve(Beam(alpha=alpha), 2).shape(1, [1.0])[0, 1]
        found = float(fig13[-1][f"mode2_B2_alpha{alpha:g}"])
        assert abs(found) == pytest.approx(abs(tip), rel=1e-5)


@pytest.mark.parametrize(
    ("name", "count", "notes"),
    [
        ("fig4", 0, []),
        ("fig6", 2, ["paper 6.6\nmaterial 6.662\neq. 16 6.824", "paper 17.3\nmaterial 17.343"]),
        ("fig8", 1, ["paper 1.59\nhere 1.5703"]),
        ("fig11", 2, ["paper 0.09\nmaterial 0.0877\neq. 16 0.0872", "0.225\nmaterial 0.22336"]),
        ("fig16", 3, ["paper 0.78344, 22.0345\nhere 0.783445, 22.0345", "paper 0.50355, 61.6982"]),
        ("fig18", 1, ["here 1.872", "paper 22.0345\nhere 22.0345"]),
    ],
)
def test_printed_numbers_stand_beside_ours(name, count, notes):
    """Each crossing, node and constant is annotated with both numbers."""
    text = "\n".join(note.get_text() for note in drawn(FIGURES[name])[-1])
    assert all(note in text for note in notes)
    assert text.count("paper ") == count


@pytest.mark.parametrize("figure", LOCI, ids=lambda figure: figure.name)
def test_figures_of_loci(figure):
    """Crossings are those located around printed values; loci by both curvature measures.
    Annotations lie in the frame, apart from each other and off the lines."""
    computed, found, picture, notes = drawn(figure)
    printed = {row.number: row for row in found if row.number}
    assert set(printed) == set(printed_numbers(figure, "crossing"))
    for number, row in printed.items():
        for name in ("spatial", "material") if row.material else ("spatial",):
            expected = compute(number, **MODELS[name])
            assert getattr(row, name).at == pytest.approx(expected, rel=1e-6)
    axes, renderer = picture.axes[0], picture.canvas.get_renderer()
    dashed = [line for line in axes.lines if line.get_linewidth() == 0.9]
    at_rest = figure.over != "gamma" and figure.beam.gamma == 0
    assert len(dashed) == (0 if at_rest else figure.modes)
    frame, lines = axes.get_window_extent(), LabelPlacer(axes).line_points
    boxes = [Text.get_window_extent(note, renderer) for note in notes if note.arrow_patch]
    events = computed["spatial"].events
    assert len(boxes) == {"fig16": 3, "fig18": 1}.get(figure.name, 0) + len(events)
    for k, box in enumerate(boxes):
        assert np.all(frame.min <= box.min)
        assert np.all(box.max <= frame.max)
        assert not any(box.overlaps(other) for other in boxes[k + 1 :])
        assert not ((lines > box.min) & (lines < box.max)).all(axis=1).any()


@pytest.mark.slow
def test_some_names_only(folder, tmp_path, run):
    """Only what is named is written, always the same; the index is of all, in the paper's order."""
    code, out, _ = run("reproduce", "table4", "--out", str(tmp_path))
    assert (code, out) == (0, f"{tmp_path / 'index.md'}\n")
    _, _, err = run("reproduce", "fig19", "fig17", "fig19", "--out", str(tmp_path))
    assert [line.split()[0] for line in err.splitlines()] == ["fig17", "fig19"]
    index = (tmp_path / "index.md").read_text(encoding="utf-8")
    assert re.findall(r"\((\w+)\.csv\)", index) == ["table4", "fig17", "fig19"]
    found, before = contents(tmp_path), contents(folder)
    assert len(found) == 2 + 3 + 3 + 1
    same = {name for name in found if found[name] == before.get(name)}
    assert same == {name for name in found if name.startswith(("fig17", "table4"))}


@pytest.mark.parametrize("wrong", ["fig3", "fig20", "table5", "Fig5", ""])
def test_an_unknown_name(wrong, tmp_path, run):
    """The names there are, in the paper's order, exit 2, nothing written."""
    tables, figures = (f"table{k}" for k in range(1, 5)), (f"fig{k}" for k in range(4, 20))
    known = ", ".join((*tables, *figures, "numbers", "all"))
    said = f"beamviz: {wrong!r} is not in the paper: choose from {known}\n"
    assert run("reproduce", "fig5", wrong, "--out", str(tmp_path / "new")) == (2, "", said)
    assert not (tmp_path / "new").exists()
