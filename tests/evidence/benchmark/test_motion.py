"""The comparison of integrators: failures are told apart, and the error falls with the step."""

import numpy as np
import pytest
from helpers import load_script

from beamviz import NotConverged
from beamviz.evidence.benchmark import motion as benchmark_motion
from beamviz.evidence.benchmark.exudyn_motion import missing
from beamviz.evidence.benchmark.motion import (
    EXUDYN_MODEL,
    FINEST,
    SCENES,
    MotionRow,
    map_cell,
    map_problem,
    motion_of_map,
    peer_tip,
    reference_tip,
    row_of,
    time_to_error,
)


def test_outcomes():
    """The explicit method is unstable above 2.8 over the highest frequency, thousands over T* at
    mu = 70; the trapezoidal rule is less accurate than Radau's with four times its step."""
    reference, _ = motion_of_map(map_problem(70.0, "radau", FINEST), "radau")
    assert map_cell("explicit", 70.0, 0.02, reference).outcome == "unstable"
    assert map_cell("trapezoidal", 1000.0, 2.0, reference).outcome == "does not converge"
    coarse, fine = (map_cell("radau", 70.0, step, reference) for step in (0.2, 0.04))
    low = map_cell("trapezoidal", 70.0, 0.01, reference)
    assert fine.error < coarse.error
    assert fine.error < low.error
    assert np.isfinite(fine.seconds)


@pytest.mark.skipif(bool(missing()), reason="Exudyn is not installed")
@pytest.mark.parametrize(
    ("scene", "error"),
    [("Kane's manoeuvre", 2e-4), ("a plucked beam", 3e-3)],  # of 4 elements and these steps
)
def test_exudyn_moves_alike(scene, error):
    """In its own theory; in the paper's the tip of the plucked beam differs by more than a finer
    mesh changes it."""
    motion = SCENES[scene]
    reference = reference_tip(motion, EXUDYN_MODEL)
    tip = peer_tip(motion, 4, 2 * motion.instants)
    assert np.linalg.norm(tip - reference, axis=1).max() < error


def test_the_table_of_the_reference_page_is_that_of_its_numbers():
    """assets/motion.md holds the ratios of assets/motion.json."""
    script = load_script("measure_motions")
    page = (script._script.ROOT / "assets" / "motion.md").read_text()
    rows = script.stored_rows(script._script.ROOT / "assets")
    assert script.START in page
    assert script.renewed(page, rows) == page


def test_rows(monkeypatch):
    """A failure has its reason, and the least time of those within an error counts."""
    monkeypatch.setattr(benchmark_motion, "LEAST", 0.0)
    scene = SCENES["Kane's manoeuvre"]
    tip = np.zeros((scene.instants + 1, 2))
    blank = MotionRow("Kane's manoeuvre", "auto", "tolerance 0.001")
    row = row_of(blank, lambda: tip, tip + 1e-4)
    assert row.error == pytest.approx(np.sqrt(2) * 1e-4)

    def fails():
        raise NotConverged("the reason")

    assert row_of(blank, fails, tip).reason == "the reason"
    rows = [row._replace(seconds=s, error=e) for s, e in ((1, 1e-6), (0.5, 1e-5), (0.1, 1e-2))]
    assert time_to_error(rows, row.scene, "auto", 1e-4) == 0.5
    assert time_to_error(rows, row.scene, "auto", 1e-7) is None
