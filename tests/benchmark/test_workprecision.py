"""The work-precision study: its exact values, its rows, its chart and its command."""

import importlib.util
import json
import os
import re
from importlib.metadata import PackageNotFoundError
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from published import INDEPENDENT
from typer.testing import CliRunner

from beamviz import solver as solve_module
from beamviz.beam import Beam
from beamviz.benchmark import (
    plot as workprecision_plot,
)
from beamviz.benchmark import (
    report as benchmark,
)
from beamviz.benchmark import (
    solvers as contestants,
)
from beamviz.benchmark import (
    work_precision as workprecision,
)
from beamviz.benchmark.cases import MODES, SCENES
from beamviz.benchmark.external import Peer
from beamviz.benchmark.solvers import METHODS, PEERS, Contestant
from beamviz.benchmark.work_precision import (
    Effort,
    Row,
    beaten,
    error,
    front,
    limits,
    measured,
    time_at,
)
from beamviz.cli import commands as cli
from beamviz.errors import NoEquilibrium, NotConverged
from beamviz.solver import solve

ROOT = Path(__file__).parents[2]
MODELS = {
    "green": {},
    "biot": {"strain": "biot", "curvature": "material"},
    "rigid": {"method": "foac"},
    "none": {"method": "zoac"},
}
LITTLE = Effort(0.0, 1.0)


def script(name: str) -> ModuleType:
    """A module of scripts/."""
    spec = importlib.util.spec_from_file_location(name, ROOT / "scripts" / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize(("scene", "theory"), [("slow", "green"), ("inner mass", "rigid")])
def test_the_stored_limits_are_those_of_the_script(scene, theory):
    """The first mode computed anew in extended precision, to sixteen digits."""
    makes = script("limits")
    (square,) = makes.Straight(SCENES[scene], makes.THEORIES[theory], 1).squares()
    stored = limits()[scene][theory]
    assert float(square) == pytest.approx(stored[0], rel=1e-15, abs=0)


@pytest.mark.parametrize("theory", MODELS)
@pytest.mark.parametrize("scene", SCENES)
def test_the_solver_agrees_with_the_limits(scene, theory):
    """Every scene in every model: the frequencies within the reported error, or no equilibrium."""
    exact = limits()[scene][theory]
    if isinstance(exact, str):
        with pytest.raises(NoEquilibrium):
            solve(SCENES[scene], MODES, **MODELS[theory])
        return
    found = solve(SCENES[scene], MODES, tolerance=1e-9, **MODELS[theory])
    assert np.all(abs(found.omega_squared - exact) <= found.omega_squared_errors)
    assert error(found.omega_squared, exact) < 1e-8


def test_the_limits_are_the_independent_values():
    """Seven digits known before (tests/published.py), of the scenes that are there too."""
    compared = 0
    for alpha, beta, gamma, delta, bending, stretching in INDEPENDENT:
        for scene, beam in SCENES.items():
            if beam == Beam(alpha, beta, gamma, delta):
                exact = np.sqrt(limits()[scene]["green"])
                known = np.array([*bending, stretching])
                distances = abs(exact / known[:, None] - 1).min(axis=1)
                assert np.all(distances[known <= exact.max()] < 1e-7)
                compared += 1
    assert compared == 3


def test_errors_are_relative_and_count_growth_rates():
    """Half the relative error of omega^2, whatever its sign; never zero on a log axis."""
    assert error(np.array([4.0, 101.0]), np.array([4.0, 100.0])) == pytest.approx(0.005)
    assert error(np.array([-4.04]), np.array([-4.0])) == pytest.approx(0.005)
    assert error(np.ones(2), np.ones(2)) == workprecision.FLOOR


def row(name: str, seconds: float | None, value: float | None, reason: str = "") -> Row:
    return Row("slow", name, "green", "terms", 1.0, seconds, value, value, reason)


def test_only_what_nothing_of_its_own_beats_is_on_the_front():
    """A slower and worse point is left out; time to an error is that of a point, not between."""
    rows = [row("a", 1.0, 1e-2), row("a", 2.0, 1e-1), row("a", 3.0, 1e-5), row("b", 0.1, 1e-9)]
    points = front([*rows, row("a", None, None, "failed")], "a")
    assert points == [(1e-2, 1.0), (1e-5, 3.0)]
    assert time_at(points, 1e-2) == 1.0
    assert time_at(points, 1e-4) == 3.0
    assert time_at(points, 1e-6) is None


def test_what_is_sooner_and_as_near_to_the_model_beats_a_row():
    """Of the same scene, by another method, in both at once; its own model does not count."""
    ours = row("auto", 1.0, 1e-6)
    rivals = [row("sooner", 0.5, 1e-5), row("nearer", 2.0, 1e-9), row("auto", 0.5, 1e-9)]
    elsewhere = row("a", 0.5, 1e-9)._replace(scene="fast")
    of_its_own = row("b", 0.5, 1e-9)._replace(from_paper=0.1)
    assert not beaten([ours, *rivals, elsewhere, of_its_own, row("c", None, None, "no")], "auto")
    better = row("d", 0.5, 1e-6)
    assert beaten([ours, better, *rivals], "auto") == [(ours, better)]
    assert next(benchmark.on_the_front([ours, better], "auto")).startswith("slow: d, terms 1, is")


def fake(squares, **details) -> Contestant:
    return Contestant("fake", "green", "terms", (1, 2, 3), squares, **details)


def test_rows_that_fail_stay_with_their_reason():
    """A failure, a budget spent and a missing program are rows like others."""

    def fails_twice(beam, resolution, modes):
        if resolution < 3:
            raise NotConverged(f"terms = {resolution}: no")
        return limits()["slow"]["green"]

    rows = [r for r in measured([fake(fails_twice)], LITTLE, lambda _: None) if r.scene == "slow"]
    assert [r.reason for r in rows] == ["terms = 1: no", "terms = 2: no", ""]
    assert rows[2].seconds is not None
    assert rows[2].error == workprecision.FLOOR
    exact = fake(lambda beam, resolution, modes: 1.01 * limits()["slow"]["green"])
    spent = measured([exact], Effort(0.0, 0.0), lambda _: None)[:3]
    assert spent[0].seconds is not None
    assert all("out of budget" in r.reason for r in spent[1:])
    absent = measured([fake(None, absent="not installed: buy it")], LITTLE, lambda _: None)
    assert {(r.reason, r.seconds) for r in absent} == {("not installed: buy it", None)}


def test_a_peer_that_is_not_installed_says_how_to_install_it(monkeypatch):
    """An absent peer is a contestant all the same."""

    def missing() -> str:
        raise PackageNotFoundError

    peer = Peer("Other", "green", (1,), lambda *_: np.ones(5), missing, "pip install other", "")
    monkeypatch.setattr(contestants, "PEERS", (peer,))
    assert contestants.peers()[0].absent == "not installed: pip install other"


@pytest.mark.parametrize("peer", PEERS, ids=lambda peer: peer.name)
def test_peers_converge_to_the_limits_they_are_measured_against(peer):
    """A gentle scene, an inner mass: finer is closer, and the finest is within 1 %."""
    try:
        peer.version()
    except PackageNotFoundError:
        pytest.skip(f"{peer.name} is not installed: {peer.how}")
    for scene in ("slow", "inner mass"):
        exact = limits()[scene][peer.theory]
        coarse, fine = (
            error(peer.solve(SCENES[scene], n, MODES), exact) for n in peer.resolutions[1:3]
        )
        assert fine < 0.01
        assert fine < coarse


def test_modes_on_few_terms_are_the_methods_own():
    """Contestants call solve() with their own option."""
    for contestant in METHODS:
        squares = contestant.squares(Beam(gamma=2), contestant.resolutions[-2], 3)
        options = {contestant.option: contestant.resolutions[-2]}
        assert (
            squares.tolist()
            == solve(Beam(gamma=2), 3, contestant.name, **options).omega_squared.tolist()
        )


def committed() -> tuple[list[Row], dict]:
    """The measurement in assets/."""
    data = json.loads((ROOT / "assets" / "benchmark.json").read_text())
    return [Row(**values) for values in data["rows"]], data


def ratios(rows: list[Row], name: str, target: float) -> dict[str, float]:
    """Time to an error as a multiple of auto's, in the scenes where both get there."""
    found = {}
    for scene in SCENES:
        here = [r for r in rows if r.scene == scene]
        ours, theirs = (time_at(front(here, one), target) for one in ("auto", name))
        if ours and theirs:
            found[scene] = theirs / ours
    return found


def test_the_committed_measurement_is_whole():
    """Every method, peer and scene is in it, with machine, versions and date."""
    rows, data = committed()
    assert set(solve_module.METHODS) | {peer.name for peer in PEERS} == {r.name for r in rows}
    assert {r.scene for r in rows} == set(SCENES) == set(data["bare_lapack"])
    assert data["scenes"] == {scene: beam.numbers for scene, beam in SCENES.items()}
    assert {"date", "machine", "versions"} <= set(data)
    assert data["threads"] == "1"
    assert data["effort"] == "full"
    assert all(r.reason or (r.seconds and r.error and r.from_paper) for r in rows)


def test_the_readme_says_what_was_measured():
    """The ratios of its section "How fast" are those of the committed measurement."""
    rows, data = committed()
    text = " ".join((ROOT / "README.md").read_text().split())
    span = r"(\d+) to (\d+) times"
    for pattern, target in ((f"1e-4 in five .*? {span} faster", 1e-4), (f"{span} to 1e-3", 1e-3)):
        exudyn = [*ratios(rows, "Exudyn", target).values()]
        exudyn += ratios(rows, "Exudyn, paper's energy", target).values()
        match = re.search(pattern, text)
        assert match is not None
        assert [int(number) for number in match.groups()] == [
            round(min(exudyn)),
            round(max(exudyn)),
        ]
    bare = data["bare_lapack"].values()
    assert f"{min(bare):.1f} to {max(bare):.1f} times the bare LAPACK time" in text
    eigh = data["eigh"].values()
    assert f"{min(eigh):.1f} to {max(eigh):.1f} times what `scipy.linalg.eigh` takes" in text
    faster = {
        (name, scene, target)
        for name in {r.name for r in rows} - {"auto", "foac", "zoac"}
        for target in (1e-2, 1e-3, *benchmark.TARGETS)
        for scene, ratio in ratios(rows, name, target).items()
        if ratio < 1
    }
    assert "no method that stretches the beam gets to any of these errors sooner" in text
    assert not faster
    assert "none is both sooner and as near to the paper's model" in text
    assert not beaten(rows, "auto")


@pytest.fixture
def small(monkeypatch):
    """One scene, two methods and a peer that is not there, hardly measured."""
    monkeypatch.setattr(workprecision, "SCENES", {"slow": SCENES["slow"]})
    monkeypatch.setattr(benchmark, "SCENES", {"slow": SCENES["slow"]})
    monkeypatch.setattr(benchmark.contestants, "METHODS", (METHODS[0], METHODS[7]))
    monkeypatch.setattr(benchmark.contestants, "peers", lambda: [fake(None, absent="not there")])
    monkeypatch.setattr(benchmark, "QUICK", LITTLE)
    monkeypatch.setattr(benchmark, "LAPACK_REPEATS", {True: 2})
    for name in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"):
        monkeypatch.setenv(name, os.environ.get(name, "1"))


def test_the_command_writes_chart_and_numbers(small, tmp_path):
    """PNG, SVG and JSON; ratios on stdout, progress on stderr."""
    result = CliRunner().invoke(
        cli.app, ["benchmark", "--out", str(tmp_path), "--quick", "--peers"]
    )
    assert result.exit_code == 0, result.output
    assert {file.name for file in tmp_path.iterdir()} == {
        "benchmark.png",
        "benchmark.svg",
        "benchmark.json",
    }
    data = json.loads((tmp_path / "benchmark.json").read_text())
    assert {r["name"] for r in data["rows"]} == {"auto", "power-series", "fake"}
    assert [r["reason"] for r in data["rows"] if r["name"] == "fake"] == ["not there"]
    assert data["machine"]["cores"] >= 1
    assert 1 < data["eigh"]["slow"] < data["bare_lapack"]["slow"]
    assert "time to error 1e-06 / auto" in result.stdout
    assert "no answer" in result.stdout
    assert "on the Pareto front" in result.stdout or "is sooner and as" in result.stdout
    assert "slow: auto" in result.stderr


def test_a_folder_that_cannot_be_written_is_one_line(small, tmp_path, capsys):
    """Exit code 1 before anything is measured."""
    (tmp_path / "file").write_text("")
    assert cli.main(["benchmark", "--out", str(tmp_path / "file")]) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("beamviz: cannot write to ")
    assert err.count("\n") == 1


def test_the_chart_names_every_line_and_every_failure():
    """Names on the lines, reasons above the frame."""
    rows = []
    for k, name in enumerate(workprecision_plot.LOOKS):
        rows += [row(name, 1e-3 * (k + 1), 1e-3), row(name, 1e-2 * (k + 1), 10.0 ** -(4 + k))]
    rows.append(row("auto", None, None, "gamma = 2: no equilibrium beyond gamma = 1.5 (green)"))
    figure = workprecision_plot.draw(rows, workprecision.model_errors(), "measured here")
    texts = [text.get_text() for text in figure.axes[0].texts]
    assert set(workprecision_plot.LOOKS) <= set(texts)
    assert "× auto (1): no equilibrium beyond γ = 1.5" in texts
