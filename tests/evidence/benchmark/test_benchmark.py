"""The benchmark: its limits, its rows, its chart, its command and the committed numbers."""

import json
import os
from functools import partial
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pytest
from helpers import contents, load_script

from beamviz import Beam, NoEquilibrium, NotConverged, solve
from beamviz.errors import BeamvizError, LeftOut
from beamviz.evidence import benchmark
from beamviz.evidence.benchmark import (
    METHODS,
    PEERS,
    SCENES,
    SolveRow,
    blade,
    motion,
    time_to_error,
    work_precision,
)
from beamviz.evidence.benchmark.work_precision import (
    SolveEffort,
    dominated,
    limits,
    measure,
    relative_error,
)
from beamviz.presets import preset
from beamviz.solver import METHODS as METHOD_NAMES

ROOT = Path(__file__).parents[3]
MODES = work_precision.MODES
SCRIPT = load_script("limits")
MODELS = {name: theory.start for name, theory in SCRIPT.THEORIES.items()}
LITTLE = SolveEffort(0.0, 1.0)
LITTLE_MOTION = motion.MotionEffort(
    tolerances=(1e-2,),
    high=(20,),
    low=(180,),
    elements=(2,),
    peer=((2,), (1,)),
    mus=(20.0,),
    steps=(0.5,),
)
CHARTS = ("benchmark", "motion-time-error", "motion-failures", "blade-time-error")


@pytest.mark.slow
@pytest.mark.parametrize(("scene", "theory"), [("inner mass", "green")])
def test_the_script_gives_the_stored_limits(scene, theory):
    """The first mode in extended precision, to sixteen digits."""
    (square,) = SCRIPT.Straight(SCENES[scene], SCRIPT.THEORIES[theory], 1).squares()
    assert float(square) == pytest.approx(limits()[scene][theory][0], rel=1e-15, abs=0)


@pytest.mark.parametrize("theory", MODELS)
@pytest.mark.parametrize("scene", SCENES)
def test_the_solver_agrees_with_the_limits(scene, theory):
    """Every scene in every model: the frequencies within the reported error, or no equilibrium."""
    limit = limits()[scene][theory]
    if isinstance(limit, str):
        with pytest.raises(NoEquilibrium):
            solve(SCENES[scene], MODES, **MODELS[theory])
        return
    found = solve(SCENES[scene], MODES, tolerance=1e-9, **MODELS[theory])
    assert np.all(abs(found.omega_squared - limit) <= found.omega_squared_errors)
    assert relative_error(found.omega_squared, limit) < 1e-8


def test_errors_are_relative_and_count_growth_rates():
    """Half the relative error of omega^2, whatever its sign; never zero on a log axis."""
    for found, limit, error in (([4, 101], [4, 100], 0.005), ([-4.04], [-4], 0.005)):
        assert relative_error(np.array(found), np.array(limit)) == pytest.approx(error)
    assert relative_error(np.ones(2), np.ones(2)) == work_precision.FLOOR


def row(name: str, seconds: float = np.nan, error: float = np.nan, reason: str = "") -> SolveRow:
    return SolveRow("slow", name, "green", "terms", 1.0, seconds, error, error, reason)


def test_a_row_is_dominated_by_one_that_is_faster_and_as_close_to_the_model():
    """By another method; the report names both."""
    ours, better = row("auto", 1.0, 1e-6), row("d", 0.5, 1e-6)
    assert dominated([ours, better], "auto") == [(ours, better)]
    report = next(benchmark.front_report([ours, better], "auto"))
    assert report.startswith("slow: d, terms 1, is faster")


def fake(omega_squared, **details) -> benchmark.Solver:
    return benchmark.Solver("fake", "green", "terms", (1, 2, 3), omega_squared, **details)


MISSING = fake(None, version=partial(version, "no-such-package"), install="buy it")


def test_rows_that_fail_stay_with_their_reason():
    """A failure, an exhausted budget and a missing program are rows too."""

    def fails_twice(beam, resolution, modes):
        if resolution < 3:
            raise NotConverged(f"terms = {resolution}: no")
        return limits()["slow"]["green"]

    *failed, found = (r for r in measure([fake(fails_twice)], LITTLE) if r.scene == "slow")
    assert [r.reason for r in failed] == ["terms = 1: no", "terms = 2: no"]
    assert (found.reason, found.error, found.seconds > 0) == ("", work_precision.FLOOR, True)
    inexact = fake(lambda beam, resolution, modes: 1.01 * limits()["slow"]["green"])
    first, *spent = measure([inexact], SolveEffort(0.0, 0.0))[:3]
    assert first.seconds > 0
    assert all("out of budget" in r.reason for r in spent)
    missing = measure([MISSING], LITTLE)
    assert {r.reason for r in missing} == {"not installed: buy it"}
    assert np.isnan([r.seconds for r in missing]).all()


@pytest.mark.slow
@pytest.mark.parametrize("peer", PEERS, ids=lambda peer: peer.name)
def test_peers_converge_to_the_limits_they_are_measured_against(peer):
    """Without and with an inner mass: finer is closer, and the finest is within 1 %."""
    if peer.missing:
        pytest.skip(f"{peer.name}: {peer.missing}")
    for scene in ("slow", "inner mass"):
        found = [peer.omega_squared(SCENES[scene], n, MODES) for n in peer.resolutions[1:3]]
        coarse, fine = (relative_error(one, limits()[scene][peer.theory]) for one in found)
        assert fine < min(0.01, coarse)


@pytest.mark.parametrize("solver", METHODS, ids=lambda solver: solver.name)
def test_methods_converge_to_the_limits_of_their_model(solver):
    """At one resolution at least, within 0.001 (assumed modes lose their digits beyond 12 terms),
    and nearer to them than to those of another model."""
    found = [solver.omega_squared(SCENES["slow"], n, MODES) for n in solver.resolutions[-4:]]
    errors = {
        theory: min(relative_error(one, limit) for one in found)
        for theory, limit in limits()["slow"].items()
    }
    assert errors[solver.theory] == min(errors.values()) < 1e-3


@pytest.fixture(scope="module")
def committed() -> tuple[list[SolveRow], dict]:
    """The measurement in assets/."""
    data = json.loads((ROOT / "assets" / "benchmark.json").read_text())
    known = ({k: v for k, v in values.items() if v is not None} for values in data["rows"])
    return [SolveRow(**values) for values in known], data


def ratios(rows: list[SolveRow], name: str, target: float) -> list[float]:
    """Time to an error as a multiple of auto's, in the scenes where both reach it."""
    scenes = [[r for r in rows if r.scene == scene] for scene in SCENES]
    times = [[time_to_error(here, one, target) for one in ("auto", name)] for here in scenes]
    return [theirs / ours for ours, theirs in times if ours and theirs]


def test_the_committed_measurement_is_complete(committed):
    """Every method, peer and scene is in it, with machine, versions and date."""
    rows, data = committed
    assert set(METHOD_NAMES) | {peer.name for peer in PEERS} == {r.name for r in rows}
    assert {r.scene for r in rows} == set(SCENES)
    assert data["scenes"] == {scene: beam.numbers for scene, beam in SCENES.items()}
    assert {"date", "machine", "versions"} <= set(data)
    assert (data["threads"], data["effort"]) == ("1", "full")
    assert all(r.reason or (r.seconds and r.error and r.from_paper) for r in rows)


def test_the_committed_reasons_are_those_of_the_program(committed):
    """Of each solve without an answer, other programs apart."""
    methods = {one.name: one for one in METHODS}
    for failed in (r for r in committed[0] if r.reason and r.name in methods):
        with pytest.raises(BeamvizError) as failure:
            methods[failed.name].omega_squared(SCENES[failed.scene], failed.resolution, MODES)
        assert str(failure.value) == failed.reason


def test_the_readme_quotes_the_committed_measurement(committed):
    """The ratios of the README are those of the committed measurement."""
    rows, _ = committed
    readme = " ".join((ROOT / "README.md").read_text().split())
    exudyn = ratios(rows, "Exudyn", 1e-4) + ratios(rows, "Exudyn, paper's energy", 1e-4)
    assert f"{min(exudyn):.0f} to {max(exudyn):.0f} times faster than Exudyn" in readme


def test_auto_was_fastest(committed):
    """No method that stretches the beam was faster, none both faster and nearer to the paper's."""
    rows, _ = committed
    for name in {r.name for r in rows if r.theory not in ("rigid", "none")} - {"auto"}:
        for target in (1e-2, 1e-3, *benchmark.TARGETS):
            assert all(ratio >= 1 for ratio in ratios(rows, name, target)), name
    assert not dominated(rows, "auto")


@pytest.fixture
def small(monkeypatch):
    """One scene, two methods and a peer that is not installed, hardly measured."""
    for module in (benchmark, work_precision):
        monkeypatch.setattr(module, "SCENES", {"slow": SCENES["slow"]})
    some = tuple(method for method in METHODS if method.name in ("auto", "power-series"))
    monkeypatch.setattr(benchmark, "METHODS", some)
    monkeypatch.setattr(benchmark, "PEERS", (MISSING,))
    monkeypatch.setattr(work_precision, "QUICK", LITTLE)
    monkeypatch.setattr(motion, "QUICK", LITTLE_MOTION)
    monkeypatch.setattr(motion, "LEAST", 0.0)
    monkeypatch.setattr(motion, "REPEATS", 1)
    for name in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"):
        monkeypatch.setenv(name, os.environ.get(name, "1"))


@pytest.mark.slow
def test_the_command_writes_chart_and_numbers(small, tmp_path, run):
    """PNG, SVG and JSON; ratios on stdout, progress on stderr."""
    code, out, err = run("benchmark", "--out", str(tmp_path), "--quick", "--peers")
    assert code == 0, err
    pictures = [f"{name}.{end}" for name in CHARTS for end in ("png", "svg")]
    assert set(contents(tmp_path)) == {*pictures, "benchmark.json", "motion.json", "blade.json"}
    blades = json.loads((tmp_path / "blade.json").read_text())["time against error"]
    assert {row["name"] for row in blades} == {"auto", "pyBModes"}
    assert all(row["error"] < row["resolution"] for row in blades if row["name"] == "auto")
    data = json.loads((tmp_path / "benchmark.json").read_text())
    reasons = {r["name"]: r["reason"] for r in data["rows"]}
    assert set(reasons) == {"auto", "power-series", "fake"}
    assert reasons["fake"] == "not installed: buy it"
    assert data["machine"]["cores"] >= 1
    assert "time to error 1e-06 / auto" in out
    assert "no answer" in out
    motions = json.loads((tmp_path / "motion.json").read_text())
    assert {row["scene"] for row in motions["time against error"]} == set(motion.SCENES)
    assert {cell["integrator"] for cell in motions["map"]} == set(motion.NAMES)
    assert "time to tip error 0.001 / auto" in out
    assert "on the Pareto front" in out or "is faster and as" in out
    assert "slow: auto" in err


@pytest.mark.slow
def test_the_chart_names_every_line_and_every_failure():
    """Names on the lines, reasons above the frame."""
    rows = []
    for k, name in enumerate(benchmark.LINE_STYLES):
        rows += [row(name, 1e-3 * (k + 1), 1e-3), row(name, 1e-2 * (k + 1), 10.0 ** -(4 + k))]
    rows.append(row("auto", reason="gamma = 2: no equilibrium beyond gamma = 1.5 (green)"))
    figure = benchmark.draw(rows, work_precision.model_errors(), "measured here")
    texts = [text.get_text() for text in figure.axes[0].texts]
    assert set(benchmark.LINE_STYLES) <= set(texts)
    assert "× auto (1): no equilibrium beyond γ = 1.5" in texts


def test_a_blade_is_given_to_another_program_as_it_is(tmp_path):
    """Read again, its files have the frequencies of the preset."""
    beam = preset(blade.PRESET).beam
    with pytest.warns(LeftOut):
        read = Beam.from_file(blade.write_elastodyn(beam, tmp_path, "title"))
    found, given = (
        each.units.hertz(solve(each, plane="both").frequencies) for each in (read, beam)
    )
    assert found == pytest.approx(given, rel=1e-3)  # without the axial stiffness


def test_pybmodes_converges_on_a_blade():
    """From 25 to 400 nodes by a factor of ten at least, where it is installed."""
    pytest.importorskip("pybmodes", reason="pyBModes is not installed")
    rows = [row for row in blade.measure() if row.name == blade.PYBMODES]
    assert rows[-1].error < 0.1 * rows[0].error < 0.01
