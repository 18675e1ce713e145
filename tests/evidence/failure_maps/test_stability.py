"""Failure maps: each claim about where methods fail, by the solver itself."""

import json
from itertools import pairwise

import numpy as np
import pytest
from matplotlib import rc_context
from matplotlib.colors import to_rgba

from beamviz import Beam, NoEquilibrium, NotConverged, solve
from beamviz.evidence.failure_maps import failures, kinds, lines, maps, pictures, states
from beamviz.evidence.failure_maps.failures import judge
from beamviz.evidence.failure_maps.lines import Cell, onset, subdivided
from beamviz.evidence.failure_maps.maps import PLANES
from beamviz.evidence.failure_maps.methods import METHODS, MODELS
from beamviz.plotting import STYLE, new_figure
from beamviz.solver import METHODS as SOLVER_METHODS
from beamviz.solver.problem import CHOICES

BY_NAME = {method.name: method for method in METHODS}
SLENDER = 1000.0  # nearly rigid along itself: its errors are discretisation errors
SOME = PLANES[0], PLANES[-1]  # a map of failures and that of the stable states
LOST, GONE = NotConverged("no"), NoEquilibrium("beyond", 3.0)


def verdict(name, beam):
    """The verdict on a method for a beam."""
    return failures.verdict(BY_NAME[name], failures.Models(beam))


@pytest.mark.parametrize(
    ("name", "kind", "numbers"),
    [
        ("zoac", kinds.OTHER_MODEL, {"gamma": 3.51, "delta": 1}),
        ("zoac", kinds.FALSELY_UNSTABLE, {"gamma": 3.52, "delta": 1}),
        ("foac", kinds.FALSELY_UNSTABLE, {"gamma": 115, "delta": 1}),
        ("auto, biot strain", kinds.NO_EQUILIBRIUM, {"gamma": 115, "delta": 1}),
        ("power-series", kinds.RIGHT, {"gamma": 2, "delta": 1, "mu": SLENDER}),
        ("power-series", kinds.ROUNDING, {"gamma": 25, "delta": 1, "mu": SLENDER}),
        ("power-series", kinds.ROUNDING, {"gamma": 60, "delta": 1, "mu": SLENDER}),  # it refuses
        ("power-series", kinds.NOT_CONVERGED, {"gamma": 15, "delta": 2.1}),  # more terms help
        ("assumed-modes", kinds.ROUNDING, {"mu": 316, "gamma": 30, "delta": 1}),
        # the kink at an inner mass: of first order in the number of terms
        ("assumed-modes", kinds.INACCURATE, {"alpha": 30, "beta": 0.5, "gamma": 0.6, "delta": 1}),
        ("ancf", kinds.RIGHT, {"gamma": 5, "delta": 1, "mu": SLENDER}),
        ("ancf", kinds.INACCURATE, {"gamma": 150, "delta": 1, "mu": SLENDER}),
    ],
)
def test_how_a_method_fails(name, kind, numbers):
    """By its model, its stability, rounding, or too few unknowns."""
    assert verdict(name, Beam(**numbers)).kind == kind


def test_every_method_and_strain_law_is_compared_with_its_own_model():
    """The maps leave none out that `solve` knows. On a beam that hardly stretches every model but
    that without stiffening has the frequencies of the reference."""
    compared = {method.options.get("method", "auto") for method in METHODS}
    assert compared == set(SOLVER_METHODS)
    assert {method.options.get("strain", "green") for method in METHODS} == set(CHOICES["strain"])
    beam = Beam(gamma=2, delta=1, mu=SLENDER)
    wrong = {method.name for method in METHODS if verdict(method.name, beam).kind != kinds.RIGHT}
    assert wrong == {"zoac"}


def test_methods_falsely_lose_their_stability():
    """zoac at gamma = 3.516, the first frequency at rest (Kane, Ryan & Banerjee 1987); rigid
    tension as a linear bar in resonance with its rotation: gamma = mu pi / 2, as biot's limit."""
    for model, gamma in (("unstiffened", 3.5160153), ("rigid", 35 * np.pi)):
        found = onset(Beam(delta=1), 0.5, 200, **MODELS[model])
        assert found == pytest.approx(gamma, rel=9e-6)  # the default tolerance of a solve is 1e-6


@pytest.mark.parametrize(("delta", "hencky"), [(0.0, 45.420), (1.0, 31.4887)])
def test_limit_curves(delta, hencky):
    """biot ends at mu pi / 2 whatever delta, hencky at a fold or where its force law ends."""
    found = failures.method_lines(Beam(delta=delta), np.array([20.0, 120.0]))
    rows = dict(zip(BY_NAME, found, strict=True))
    losing = {"linear", "foac", "zoac", "assumed-modes", "power-series"}
    assert rows["auto, biot strain"].limit == pytest.approx(70 * np.pi / 2, rel=1e-6)
    assert rows["auto, hencky strain"].limit == pytest.approx(hencky, abs=1e-3)
    assert np.isnan([rows["auto"].limit, rows["auto"].buckling]).all()
    assert {name for name, row in rows.items() if np.isfinite(row.loss)} == losing


@pytest.mark.parametrize(("mu", "gamma"), [(10000.0, 2.9939), (70.0, 2.9960)])
def test_inward_beams_buckle(mu, gamma):
    """delta -1: the straight state is truly unstable from there on, and methods say so."""
    beam = Beam(delta=-1, mu=mu)
    assert onset(beam, 0.5, 4, **MODELS["green"]) == pytest.approx(gamma, abs=1e-4)
    for name in BY_NAME:
        before, after = (verdict(name, beam.replace(gamma=speed)).kind for speed in (2.5, 4))
        assert before != kinds.TRULY_UNSTABLE == after, name


def test_where_more_unknowns_help():
    """More than 12 assumed modes make the answer worse, as cosh cancels, by how much depends on the
    machine's cosh; more elements make it better, where 20 are longer than the bending layers."""
    beam = Beam(gamma=10, delta=1, mu=SLENDER)
    modes = [error("foac", beam, "assumed-modes", terms=terms) for terms in (12, 16, 40)]
    assert modes[0] < 1e-4
    assert all(after > 10 * before for before, after in pairwise(modes))
    beam = Beam(mu=SLENDER, delta=1, gamma=150)
    fast = verdict("ancf", beam)
    assert fast.model == pytest.approx(0, abs=1e-9)  # its model is the reference
    few, many = (error("auto", beam, "ancf", elements=elements) for elements in (20, 80))
    assert few == pytest.approx(fast.discretisation, rel=1e-3)
    assert many < few / 20


def error(converging, beam, method, **options):
    """The largest relative error of the frequencies of a method, against those of one that
    converges to the same."""
    truth = solve(beam, method=converging, tolerance=1e-9).frequencies
    return abs(solve(beam, method=method, **options).frequencies / truth - 1).max()


def test_verdicts_without_an_equilibrium():
    """By whether the method's own model, and the reference, have one."""
    beam = Beam(gamma=20, delta=1)
    good, more = solve(beam), solve(beam, modes=10, tolerance=1e-9)
    assert judge(GONE, more, more).kind == kinds.NOT_CONVERGED
    assert judge(good, more, GONE).kind == kinds.OTHER_MODEL
    assert judge(GONE, GONE, more) == Cell(kinds.NO_EQUILIBRIUM, message="beyond", limit=3.0)


@pytest.mark.parametrize("count", [1, 2, 9, 10, 32])
def test_cells_that_are_not_solved_lie_between_two_of_their_kind(count):
    """Every boundary lies between two solved neighbours, wherever it is."""
    for boundary in range(count + 1):
        expected = [kinds.RIGHT] * boundary + [kinds.INACCURATE] * (count - boundary)
        cells = subdivided(count, lambda k, all_kinds=expected: Cell(all_kinds[k]))
        assert [cell.kind for cell in cells] == expected
        if 0 < boundary < count:
            assert cells[boundary - 1].solved
            assert cells[boundary].solved


@pytest.mark.slow
def test_maps_agree_with_maps_in_which_every_cell_is_solved(monkeypatch):
    """At most one cell of a line differs, where a method converges in some cells only by chance."""
    gammas = maps.middles(maps.SLOWEST, maps.FASTEST, 9, True)

    def computed():
        inward, bending = Beam(delta=-1), ("auto", "auto, hencky strain")
        yield from failures.method_lines(Beam(alpha=3, beta=0.5, delta=1), gammas)
        for name in bending:
            yield states.method_line(inward, gammas.tolist(), BY_NAME[name])

    subdivided_lines = list(computed())
    monkeypatch.setattr(lines, "STRIDE", 1)
    for some, every in zip(subdivided_lines, computed(), strict=True):
        pairs = zip(some.cells, every.cells, strict=True)
        assert sum(a.kind != b.kind for a, b in pairs) <= 1


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """The folder of `beamviz stability --quick` on two maps of a few cells, its data, and what is
    printed."""
    from typer.testing import CliRunner

    from beamviz.cli.commands import app

    folder, small = tmp_path_factory.mktemp("stability"), pytest.MonkeyPatch()
    subjects = [plane.subject._replace(quick_size=(4, 2)) for plane in SOME]
    planes = [plane._replace(subject=one) for plane, one in zip(SOME, subjects, strict=True)]
    small.setattr(maps, "PLANES", planes)
    result = CliRunner().invoke(app, ["stability", "--out", str(folder), "--quick"])
    small.undo()
    assert result.exit_code == 0, result.output
    return folder, json.loads((folder / "stability.json").read_text()), result.stdout


@pytest.mark.slow
def test_files_of_the_command(written):
    """A picture of each map, the page that is printed too, and the data: as many commands as cells
    that are not correct, each naming its cell's numbers."""
    folder, data, printed = written
    assert (folder / "stability.md").read_text().strip() in printed
    for plane, found in zip(SOME, data, strict=True):
        assert (folder / f"stability-{plane.name}.png").read_bytes().startswith(b"\x89PNG")
        assert (folder / f"stability-{plane.name}.svg").read_text().startswith("<?xml")
        assert set(found["methods"]) == set(BY_NAME)
        correct = {kind.name for kind in plane.subject.correct}
        for method in found["methods"].values():
            flat = (name for row in method.get("kinds", ()) for name in row)
            cells = method.get("cells", ())
            assert [cell["kind"] for cell in cells] == [
                name for name in flat if name not in correct
            ]
            for cell in cells:
                assert f"--gamma {cell['gamma']:.10g} " in cell["command"]
                assert f"--{plane.over} {cell[plane.over]:.10g} " in cell["command"]


@pytest.mark.slow
def test_the_map_of_stable_states(written):
    """Straight below the speed of buckling and bent beyond it, up to the limit of the law; methods
    without bent states say so in their rows."""
    _, (*_, found), printed = written
    bending = {name for name, one in found["methods"].items() if "kinds" in one}
    assert bending == {name for name in BY_NAME if name.startswith("auto")}
    for name in set(BY_NAME) - bending:
        said = f"method {BY_NAME[name].options['method']} has no bent states"
        assert said in found["methods"][name]["says"]
        assert said in printed
    for name in bending:
        columns = (found["methods"][name][key] for key in ("kinds", "buckling", "limit"))
        for row, buckling, limit in zip(*columns, strict=True):
            for gamma, state in zip(found["gamma"], row, strict=True):
                assert (state == kinds.STRAIGHT.name) == (gamma < buckling)
                assert (state == kinds.NO_STATE.name) == (limit is not None and gamma > limit)


def test_more_than_one_stable_state():
    """A bent beam that is accelerated slowly has two, and one when it is accelerated fast."""
    beam = Beam(4.656, 1, 5.341, -0.09663, 194.4)
    options = {"modes": 1, "state": "stable", "strain": "biot", "curvature": "material"}
    for spin_up, kind in ((0.05, kinds.SEVERAL), (0.2, kinds.BENT)):
        assert states.kind_of(solve(beam.replace(spin_up=spin_up), **options)) == kind
    assert states.kind_of(LOST) == kinds.NOT_CONVERGED
    assert states.kind_of(GONE) == kinds.NO_STATE


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "kind", "code", "shown"),
    [
        ("zoac", kinds.FALSELY_UNSTABLE, 0, "unstable"),
        ("auto, hencky strain", kinds.NO_EQUILIBRIUM, 3, "no equilibrium beyond gamma"),
    ],
)
def test_a_failing_cell_can_be_replayed(written, run, name, kind, code, shown):
    """The command of the fastest beam that fails shows the failure."""
    cells = written[1][0]["methods"][name]["cells"]
    *_, last = (cell for cell in cells if cell["kind"] == kind.name)
    found, out, err = run(*last["command"].split()[1:])
    assert found == code
    assert shown in out + err


@pytest.mark.slow
@pytest.mark.parametrize("plane", SOME, ids=lambda plane: plane.name)
def test_a_label_hides_hatches_and_boundaries(plane):
    """In a box of the colour of its region. Hatches are white where labels are."""
    for kind in plane.subject.kinds:
        with rc_context(STYLE):
            figure = new_figure(2, 2)
            axes = figure.add_axes((0, 0, 1, 1))
            pictures.draw_cells(axes, plane, np.full((9, 9), kind.name))
            figure.canvas.draw()
        (label,) = axes.texts
        assert label.get_bbox_patch().get_facecolor() == to_rgba(kind.face)
        if kind.hatch:
            white = np.asarray(figure.canvas.buffer_rgba())[..., :3].min(axis=2) > 240
            assert (white.mean() > 0.05) == (kind.ink == "white")


def test_middles_lie_between_edges():
    """On either scale, rounded to four digits."""
    for logarithmic in (False, True):
        edges, middles = (f(0.5, 200, 7, logarithmic) for f in (maps.edges, maps.middles))
        assert np.all((edges[:-1] < middles) & (middles < edges[1:]))
        assert middles.tolist() == [float(f"{x:.4g}") for x in middles]
