"""What the paper prints, and what is found: its numbers, its statements, and the causes given; and
`beamviz reproduce`: every table and figure as complete, correct and readable files."""

import csv
import re
import xml.etree.ElementTree as ElementTree
from functools import cache

import numpy as np
import pytest
from helpers import contents, slow
from matplotlib.image import imread
from matplotlib.text import Annotation, Text
from scipy.integrate import trapezoid
from scipy.linalg import eigh
from scipy.optimize import brentq

from beamviz import Beam, solve
from beamviz.cli import main
from beamviz.evidence.paper import MODELS, compute, figures, tables
from beamviz.evidence.paper.figures import FIGURES, LociFigure, printed_numbers
from beamviz.evidence.paper.tables import TABLES
from beamviz.mechanics import cubic_elements as elements

# figure, printed number, the models within a unit of its last digit.
FITS = """
fig5 9.2 material, fig6 6.6 material, fig6 17.3 material, fig7 4.4 both, fig7 16.2 material,
fig8 1.59 neither, fig9 0.92 both, fig10 0.48 both, fig10 1.74 material, fig11 0.09 both,
fig11 0.225 spatial, fig14 4 both, fig15 3 both, fig16 22.0345 both, fig16 61.6982 20 elements,
fig17 0.78344 both, fig18 22.0345 both, fig19 0.50355 both, fig19 0.86768 both
"""


@cache
def computed(name):
    """The rows of a table."""
    return tables.compute(TABLES[name])


def test_captions_name_the_fixed_parameters():
    """A caption gives the paper's parameters, and none that varies."""
    assert "β = 0.5, δ = 0, μ = 70" in FIGURES["fig5"].caption
    assert "γ" not in FIGURES["fig5"].caption
    caption = "First five frequencies over the mass location (α = 0.5, γ = 5, δ = 0, μ = 70)"
    assert FIGURES["fig11"].caption == caption
    assert FIGURES["fig15"].caption.startswith("First five mode shapes (α = 2, β = 1")
    assert FIGURES["fig12"].caption.startswith("First mode shape (β = 1")


def test_a_held_root_explains_1_59():
    """With u'(0) = 0 held too, 20 cubic elements put the crossing of figure 8 at alpha = 1.584."""

    def gap(alpha, held):
        solution = solve(Beam(alpha=alpha), 5, method="ancf", elements=20)
        return bar(alpha, held) - solution.frequencies[solution.labels.index("B3")]

    assert brentq(gap, 1.4, 1.7, args=(False,)) == pytest.approx(1.5702, abs=5e-5)
    assert brentq(gap, 1.4, 1.7, args=(True,)) == pytest.approx(1.584, abs=5e-4)


def bar(alpha, held, mu=70, n=20):
    """The first stretching frequency at rest of a bar with a tip mass, of cubic elements."""
    x, weights = elements.gauss(4)
    _, dS, _ = elements.hermite(x, 1 / n)
    k = mu**2 / n * (dS.T * weights) @ dS
    parts = np.repeat(k[None], n, axis=0), elements.mass(np.linspace(0, 1, n + 1), Beam(alpha))
    free = slice(2 if held else 1, None)
    K, M = (elements.dense(elements.assemble_band(part))[free, free] for part in parts)
    return np.sqrt(eigh(K, M, eigvals_only=True)[0])


def test_columns_are_solves():
    """Every column is the answer of solve() for its beam."""
    table, row = TABLES["table2"], computed("table2")[-1]
    beam = table.beam.replace(delta=row.delta, gamma=row.gamma)
    assert (row.delta, row.gamma) == (1, 50)
    for name in table.columns:
        assert row.frequencies[name] == tuple(bending(beam, name))
    assert row.deviation("foac", 0) == pytest.approx(53.46691 / 39.74517 - 1, abs=1e-5)


def test_hencky_ends_where_the_nonlinear_model_of_ansys_diverges():
    """At gamma 40 and 50 with delta 1 a hencky beam has no equilibrium; at 30 it still has."""
    rows = computed("table4")
    page = tables.to_markdown(TABLES["table4"], rows)
    assert [row.gamma for row in rows if "hencky" in row.limits] == [40, 50]
    assert {round(row.limits["hencky"], 4) for row in rows if row.limits} == {31.4887}
    assert page.count("no equilibrium beyond γ = 31.4887") == 4
    assert "no equilibrium at γ = 40 and 50, nor anywhere beyond γ = 31.4887" in page
    last = tables.to_csv(TABLES["table4"], rows).splitlines()[-1].split(",")
    assert (last[-1], last[8]) == ("hencky 31.488726", "")


def test_pages_of_the_tables():
    """Where the text holds and where it does not; our numbers are not taken for the paper's."""
    pages = {name: tables.to_markdown(TABLES[name], computed(name)) for name in TABLES}
    for name, page in pages.items():
        assert "**The body of the paper's table is not available to this project.**" in page
        assert all(tables.COLUMNS[column].title in page for column in TABLES[name].columns)
    for name, finding in (
        ("table1", "| The frequencies rise with the speed. | True of ANCF, 20 elements, without"),
        ("table1", "FOAC against ANCF, 20 elements: ω₁ +3.019\u00a0% at δ = 0, γ = 10"),
        ("table3", "except for ω₂ at δ = 0: +0.639\u00a0% at γ = 20 but +0.220\u00a0% at 30"),
        ("table4", "linear, 20 elements against FOAC: ω₁ +0.049\u00a0% at δ = 1, γ = 50"),
    ):
        assert finding in pages[name]


def test_a_frequency_that_falls_is_an_exception():
    """Named by the hub radius and the speeds."""
    lowest = {1: 1.0, 2: 0.5, 3: 0.6}
    rows = [tables.TableRow(0, g, {"ancf": (first, 1.0 + g)}, {}) for g, first in lowest.items()]
    rise = "True of ANCF, 20 elements, except for ω₁ at δ = 0, γ = 1 .. 2."
    assert tables.rising(rows) == rise


def bending(beam, column):
    """The lowest two bending frequencies of a beam in a column."""
    found = solve(beam, 6, **tables.COLUMNS[column].options)
    return found.frequencies[[found.labels.index(label) for label in ("B1", "B2")]]


@pytest.mark.parametrize("column", ["foac", "material", "hencky"])
def test_models_differ_by_the_stretch(column):
    """FOAC, the material measure and hencky differ from the converged answer by what stretches: ten
    times the slenderness leaves a hundredth, of hencky less since it differs at second order."""
    beams = (Beam(gamma=10, delta=1, mu=mu) for mu in (700, 70))
    near, far = (bending(beam, column) / bending(beam, "converged") - 1 for beam in beams)
    assert np.all(abs(near) < abs(far) / 90)
    assert np.all(abs(far) > 1e-4)


def test_curves_rise_from_the_clamp_and_vanish_at_their_nodes():
    """A curve has unit modal mass, starts upwards, and is zero at its nodes."""
    for name in ("fig13", "fig14", "fig19"):
        for curve in figures.compute_curves(FIGURES[name]):
            assert curve.y[0] == 0 < curve.y[1]
            assert abs(np.interp(curve.nodes, curve.x, curve.y)).max(initial=0) < 1e-3
            mass = trapezoid(curve.y**2, curve.x) + curve.alpha * curve.y[-1] ** 2
            assert mass == pytest.approx(1, abs=1e-3)


# beamviz reproduce


LOCI = [figure for figure in FIGURES.values() if isinstance(figure, LociFigure)]
QUICK = [FIGURES[name] for name in ("fig6", "fig8", "fig11", "fig18")]
OTHERS = [figure for figure in LOCI if figure not in QUICK]
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


def test_files_are_linked_and_readable(folder):
    """Of some tables and figures."""
    check_files(folder, SOME)


@pytest.mark.slow
def test_the_whole_paper_is_reproduced(tmp_path):
    """By default: four tables, sixteen figures and the numbers that the text prints, with the
    models that fit each. Nine of eleven crossings fit the material measure, five the spatial one of
    eq. 16."""
    assert main(["reproduce", "--out", str(tmp_path)]) == 0
    check_files(tmp_path, [*TABLES, *FIGURES, "numbers"])
    rows = csv.DictReader((tmp_path / "numbers.csv").read_text(encoding="utf-8").splitlines())
    found = [f"{row['figure']} {row['paper']} {row['fits']}" for row in rows]
    assert found == FITS.strip().replace(",\n", ", ").split(", ")
    page = (tmp_path / "numbers.md").read_text(encoding="utf-8")
    assert "crossings the material measure fits 9, the spatial one of eq. 16 fits 5" in page
    assert "Of the 11 crossings" in page


def check_files(folder, names):
    """Every file is linked under its caption, every link leads to a file, and each figure is shown:
    a PNG of the size of a column with something on it, an SVG that is XML, and a CSV file of
    numbers with complete rows."""
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
        *slow(("fig4", 0, [])),
        ("fig6", 2, ["paper 6.6\nmaterial 6.662\neq. 16 6.824", "paper 17.3\nmaterial 17.343"]),
        ("fig8", 1, ["paper 1.59\nhere 1.5703"]),
        ("fig11", 2, ["paper 0.09\nmaterial 0.0877\neq. 16 0.0872", "0.225\nmaterial 0.22336"]),
        *slow(
            (
                "fig16",
                3,
                ["paper 0.78344, 22.0345\nhere 0.783445, 22.0345", "paper 0.50355, 61.6982"],
            )
        ),
        ("fig18", 1, ["here 1.872", "paper 22.0345\nhere 22.0345"]),
    ],
)
def test_printed_numbers_stand_beside_ours(name, count, notes):
    """Each crossing, node and constant is annotated with both numbers."""
    text = "\n".join(note.get_text() for note in drawn(FIGURES[name])[-1])
    assert all(note in text for note in notes)
    assert text.count("paper ") == count


@pytest.mark.parametrize(
    "figure", [*QUICK, *slow(*((each,) for each in OTHERS))], ids=lambda figure: figure.name
)
def test_figures_of_loci(figure):
    """Crossings are those located around printed values; loci by both curvature measures.
    Annotations lie in the frame, apart from each other."""
    computed, found, picture, notes = drawn(figure)
    printed = {row.number: row for row in found if row.number}
    assert set(printed) == set(printed_numbers(figure, "crossing"))
    for number, row in printed.items():
        for name in ("spatial", "material"):
            expected = compute(number, **MODELS[name])
            assert getattr(row, name).at == pytest.approx(expected, rel=1e-6)
    axes, renderer = picture.axes[0], picture.canvas.get_renderer()
    dashed = [line for line in axes.lines if line.get_linewidth() == 0.9]
    at_rest = figure.over != "gamma" and figure.beam.gamma == 0
    assert len(dashed) == (0 if at_rest else figure.modes)
    frame = axes.get_window_extent()
    boxes = [
        Text.get_window_extent(note, renderer)
        for note in notes
        if note.get_weight() != "bold"  # as the labels of lines are
    ]
    events = computed["spatial"].events
    assert len(boxes) == {"fig16": 3, "fig18": 1}.get(figure.name, 0) + len(events)
    for k, box in enumerate(boxes):
        assert np.all(frame.min <= box.min)
        assert np.all(box.max <= frame.max)
        assert not any(box.overlaps(other) for other in boxes[k + 1 :])


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
    """The names there are, in the paper's order, the one that is meant, exit 2, nothing written."""
    tables, figures = (f"table{k}" for k in range(1, 5)), (f"fig{k}" for k in range(4, 20))
    known = ", ".join((*tables, *figures, "numbers", "all"))
    meant = "; did you mean 'fig5'?" if wrong == "Fig5" else ""
    said = f"beamviz: {wrong!r} is not in the paper: choose from {known}{meant}\n"
    assert run("reproduce", "fig5", wrong, "--out", str(tmp_path / "new")) == (2, "", said)
    assert not (tmp_path / "new").exists()
