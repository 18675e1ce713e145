"""Failure maps: each claim about where methods fail, by the solver itself."""

import json
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from matplotlib import rc_context
from matplotlib.colors import to_rgba
from typer.testing import CliRunner

from beamviz import Beam, NoEquilibrium, NotConverged, failure_maps, solve
from beamviz.cli.commands import app
from beamviz.failure_maps import compute as kinds
from beamviz.failure_maps.compute import METHODS, MODELS, PLANES, Verdict, judge, onset
from beamviz.plotting import STYLE, new_figure

NAMES = [method.name for method in METHODS]
SLENDER = 1000.0  # nearly rigid along itself: its errors are discretisation errors
SPEEDS = np.geomspace(0.5, 200, 12)
LOST, GONE = NotConverged("no"), NoEquilibrium("beyond", 3.0)


@cache
def by_method(**numbers):
    """The verdict on every method for a beam, by name."""
    return dict(zip(NAMES, kinds.verdicts(Beam(**numbers)), strict=True))


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
        ("assumed-modes", kinds.ROUNDING, {"alpha": 30, "beta": 0.5, "gamma": 0.6, "delta": 1}),
        ("assumed-modes", kinds.INACCURATE, {"mu": 316, "gamma": 30, "delta": 1}),  # so do these
        ("ancf", kinds.RIGHT, {"gamma": 5, "delta": 1, "mu": SLENDER}),
        ("ancf", kinds.INACCURATE, {"gamma": 150, "delta": 1, "mu": SLENDER}),
    ],
)
def test_how_a_method_fails(name, kind, numbers):
    """By its model, its stability, rounding, or too few unknowns."""
    assert by_method(**numbers)[name].kind == kind


def test_methods_falsely_lose_their_stability():
    """zoac at gamma = 3.516, the first frequency at rest (Kane, Ryan & Banerjee 1987); rigid
    tension as a linear bar in resonance with its rotation: gamma = mu pi / 2, as biot's limit."""
    for model, gamma in (("unstiffened", 3.5160153), ("rigid", 35 * np.pi)):
        assert onset(Beam(delta=1), SPEEDS, MODELS[model]) == pytest.approx(gamma, rel=9e-6)
    assert np.isnan(onset(Beam(delta=1), SPEEDS, MODELS["green"]))


@pytest.mark.parametrize(("delta", "hencky"), [(0.0, 45.420), (1.0, 31.4887)])
def test_limit_curves(delta, hencky):
    """biot ends at mu pi / 2 whatever delta, hencky at a fold or where its force law ends."""
    rows = dict(zip(NAMES, kinds.verdict_rows(PLANES[0], np.array([120.0]), delta), strict=True))
    losing = {"linear", "foac", "zoac", "assumed-modes", "power-series"}
    assert rows["auto, biot strain"].limit == pytest.approx(70 * np.pi / 2, rel=1e-6)
    assert rows["auto, hencky strain"].limit == pytest.approx(hencky, abs=1e-3)
    assert np.isnan([rows["auto"].limit, rows["auto"].buckling]).all()
    assert {name for name, row in rows.items() if np.isfinite(row.loss)} == losing


@pytest.mark.parametrize(("mu", "gamma"), [(10000.0, 2.9939), (70.0, 2.9960)])
def test_inward_beams_buckle(mu, gamma):
    """delta -1: the straight state is truly unstable from there on, and methods say so."""
    beam = Beam(delta=-1, mu=mu)
    assert onset(beam, SPEEDS, MODELS["green"]) == pytest.approx(gamma, abs=1e-4)
    after = by_method(delta=-1, mu=mu, gamma=4)
    assert {after[name].kind for name in NAMES} == {kinds.TRULY_UNSTABLE}
    before = {name: cell.kind for name, cell in by_method(delta=-1, mu=mu, gamma=2.5).items()}
    assert kinds.TRULY_UNSTABLE not in before.values()


def test_where_more_unknowns_help():
    """More than 12 assumed modes make the answer worse, as cosh cancels, by how much depends on the
    machine's cosh; more elements make it better, where 20 are longer than the bending layers."""
    assert "ill-conditioned" in by_method(mu=SLENDER, delta=1, gamma=60)["power-series"].message
    beam = Beam(gamma=10, delta=1, mu=SLENDER)
    modes = [error("foac", beam, "assumed-modes", terms=terms) for terms in (12, 16, 40)]
    assert modes[0] < 1e-4
    assert all(after > 10 * before for before, after in pairwise(modes))
    fast = by_method(mu=SLENDER, delta=1, gamma=150)["ancf"]
    assert fast.model == pytest.approx(0, abs=1e-9)
    few, many = (error("auto", beam.replace(gamma=150), "ancf", elements=n) for n in (20, 80))
    assert few == pytest.approx(fast.discretisation, rel=1e-3)
    assert many < few / 20


def error(exact, beam, method, **options):
    """The largest relative error of the frequencies of a method."""
    truth = solve(beam, method=exact, tolerance=1e-9).frequencies
    return abs(solve(beam, method=method, **options).frequencies / truth - 1).max()


def test_verdicts_without_an_equilibrium():
    """By whether the method's own model, and the reference, have one."""
    beam = Beam(gamma=20, delta=1)
    good, more = solve(beam), solve(beam, modes=10, tolerance=1e-9)
    assert judge(GONE, more, more).kind == kinds.NOT_CONVERGED
    assert judge(good, more, GONE).kind == kinds.OTHER_MODEL
    assert judge(GONE, GONE, more) == Verdict(kinds.NO_EQUILIBRIUM, message="beyond", limit=3.0)


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """`beamviz stability --quick` on maps of a few cells, one of them of no accepted beam: the
    folder, its data, and what is printed."""
    folder, small = tmp_path_factory.mktemp("stability"), pytest.MonkeyPatch()
    small.setattr(failure_maps, "QUICK", {kinds.KINDS: (5, 5), kinds.STATES: (5, 3)})
    result = CliRunner().invoke(app, ["stability", "--out", str(folder), "--quick"])
    small.undo()
    assert result.exit_code == 0, result.output
    return folder, json.loads((folder / "stability.json").read_text()), result.stdout


@pytest.mark.slow
def test_files_of_the_command(written):
    """A picture of each plane, the page that is printed too, and the data: as many commands as
    cells that fail, each naming its cell's numbers."""
    folder, data, printed = written
    correct = {kind.name for kind in kinds.CORRECT}
    assert (folder / "stability.md").read_text().strip() in printed
    for plane, found in zip(PLANES, data, strict=False):
        assert (folder / f"stability-{plane.over}.png").read_bytes().startswith(b"\x89PNG")
        picture = (folder / f"stability-{plane.over}.svg").read_text()
        assert ("γ = 3.516" in picture) == (plane.over != "alpha")  # a mass lowers it
        assert set(found["methods"]) == set(NAMES)
        for method in found["methods"].values():
            flat = (name for row in method["kinds"] for name in row)
            failing = [name for name in flat if name not in correct]
            assert [row["kind"] for row in method["failing"]] == failing
            for row in method["failing"]:
                assert f"--gamma {row['gamma']:.10g} " in row["command"]
                assert f"--{found['over']} {row[found['over']]:.10g} " in row["command"]


@pytest.mark.slow
def test_the_map_of_stable_states(written):
    """Straight below the speed of buckling and bent beyond it, up to the limit of the law; methods
    without bent states say so in their rows; each state has a command that shows it."""
    folder, (*_, found), printed = written
    assert (folder / "stability-states.png").read_bytes().startswith(b"\x89PNG")
    assert set(found["methods"]) == set(NAMES)
    bending = {name for name, one in found["methods"].items() if "states" in one}
    assert bending == {name for name in NAMES if name.startswith("auto")} | {"ancf-planar"}
    for name in set(NAMES) - bending:
        said = f"method {METHODS[NAMES.index(name)].options['method']} has no bent states"
        assert said in found["methods"][name]["says"]
        assert said in printed
    for name in bending - {"ancf-planar"}:
        columns = (found["methods"][name][key] for key in ("states", "buckling", "limit"))
        for row, buckling, limit in zip(*columns, strict=True):
            for gamma, state in zip(found["gamma"], row, strict=True):
                assert (state == kinds.STRAIGHT.name) == (gamma < buckling)
                assert (state == kinds.NO_STATE.name) == (limit is not None and gamma > limit)
    assert "--state stable" in printed


def test_more_than_one_stable_state():
    """A bent beam that is accelerated slowly has two, and one when it is accelerated fast; the
    neighbour's second state is found without a search."""
    beam = Beam(4.656, 1, 5.341, -0.09663, 194.4)
    options = {"modes": 1, "state": "stable", "strain": "biot", "curvature": "material"}
    answers = [solve(beam.replace(spin_up=spin_up), **options) for spin_up in (0.05, 0.06, 0.2)]
    several = kinds.has_others(answers)
    assert several == [True, True, False]
    found = [kinds.state_kind(*one) for one in zip(answers, several, strict=True)]
    assert found == [kinds.SEVERAL, kinds.SEVERAL, kinds.BENT]
    assert kinds.state_kind(LOST, False) == kinds.NOT_CONVERGED
    assert kinds.state_kind(GONE, False) == kinds.NO_STATE


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "code", "shown"),
    [("zoac", 0, "unstable"), ("auto, hencky strain", 3, "no equilibrium beyond gamma")],
)
def test_a_failing_cell_can_be_replayed(written, run, name, code, shown):
    """The command of the fastest beam that fails shows the failure."""
    row = written[1][0]["methods"][name]["failing"][-1]
    found, out, err = run(*row["command"].split()[1:])
    assert found == code
    assert shown in out + err


@pytest.mark.parametrize("plane", [PLANES[0], kinds.INWARD], ids=["failures", "states"])
def test_a_label_hides_hatches_and_boundaries(plane):
    """In a box of the colour of its region. Hatches are white where labels are."""
    for kind in plane.kinds:
        with rc_context(STYLE):
            figure = new_figure(2, 2)
            axes = figure.add_axes((0, 0, 1, 1))
            failure_maps.draw_cells(axes, plane, np.full((9, 9), kind.name))
            figure.canvas.draw()
        (label,) = axes.texts
        assert label.get_bbox_patch().get_facecolor() == to_rgba(kind.face)
        if kind.hatch:
            white = np.asarray(figure.canvas.buffer_rgba())[..., :3].min(axis=2) > 240
            assert (white.mean() > 0.05) == (kind.ink == "white")


def test_middles_lie_between_edges():
    """On either scale, rounded to four digits."""
    for logarithmic in (False, True):
        edges, middles = (f(0.5, 200, 7, logarithmic) for f in (kinds.edges, kinds.middles))
        assert np.all((edges[:-1] < middles) & (middles < edges[1:]))
        assert middles.tolist() == [float(f"{x:.4g}") for x in middles]
