"""Verdicts of the oracle on reported errors, and what scripts/measure_error_bars.py measured."""

import json
import os
import subprocess
import sys
from functools import cache, partial
from pathlib import Path

import numpy as np
import pytest
from helpers import load_script
from oracle.error_bars import (
    Scene,
    oracle_answer,
    random_bent_dip_scene,
    verdict,
)

from beamviz import Beam, NoEquilibrium, solve

SCRIPT = load_script("measure_error_bars")
ROOT = Path(__file__).parents[2]
PLAIN = {"strain": "green", "curvature": "spatial", "plane": "chordwise", "coriolis": False}
SCENE = Scene(Beam(alpha=1, beta=0.5, gamma=10), PLAIN | {"modes": 5, "tolerance": 1e-6})
answer = cache(partial(oracle_answer, SCENE))


@pytest.mark.slow
def test_the_limit_in_a_dip_is_the_same_from_two_speeds():
    """Beyond it elements over the dip have a state that finer ones have not."""
    beam, options = random_bent_dip_scene(38)
    limits = []
    for gamma in (2.2, beam.gamma):
        with pytest.raises(NoEquilibrium) as raised:
            solve(beam.replace(gamma=gamma), **options)
        limits.append(raised.value.limit)
    assert limits == pytest.approx([2.095] * 2, rel=1e-3)


def test_what_is_wrong_is_recognised():
    """The verdict turns when the truth moves by twice the reported error, and not by half; and with
    a stretch, a tip or a family that is not the oracle's."""
    fair = verdict(SCENE, answer())
    omega, error = np.array(fair["sizes"]), np.array(fair["reported"])
    families = ["bending", "stretching", "bending", "bending", "bending"]
    for change, kind in (
        ({"squares": omega**2}, "within"),
        ({"squares": omega**2 + omega * error}, "within"),
        ({"squares": omega**2 + 4 * omega * error}, "outside"),
        ({"tip": 1.2}, "wrong-branch"),
        ({"stretch": [1.2] * 9}, "wrong-branch"),
        ({"families": families}, "wrong-family"),
    ):
        assert verdict(SCENE, answer() | change)["kind"] == kind


def test_a_limit_is_held_against_the_oracle():
    """Hencky at delta 1 ends at gamma 31.4887; a solver that answers beyond is seen."""
    beyond = Scene(SCENE.beam.replace(alpha=0, gamma=40, delta=1), SCENE.options)
    lawful = beyond._replace(options=beyond.options | {"strain": "hencky"})
    assert verdict(lawful, oracle_answer(lawful))["kind"] == "no-equilibrium"
    assert verdict(beyond, oracle_answer(lawful))["kind"] == "missed-limit"


@pytest.mark.parametrize(
    ("name", "beams", "compared", "share", "kinds"),
    [
        ("error_bars", 2500, 0, "frequencies within", {"outside", "wrong-family"}),
        ("error_bars_space", 500, 400, "beams within", set()),
        ("error_bars_bent", 1000, 1000, "beams within", {"outside"}),
        ("error_bars_bent_blades", 500, 400, "beams within", set()),
    ],
)
def test_the_committed_measurement(name, beams, compared, share, kinds):
    """The goals held on the beams measured, straight and bent: the whole is too long for a test."""
    measured = json.loads((ROOT / "assets" / f"{name}.json").read_text())
    every = measured["groups"]["all"]
    assert measured["beams"] >= beams
    assert every["beams"] >= compared
    assert every[share] >= 0.999
    # In space the first mesh resolves as many modes as are asked for in either plane.
    assert every["median reported / true"] <= (1e5 if name.endswith("space") else 1000)
    assert set(measured["kinds"]) <= {*SCRIPT.GOOD, "not-converged", *kinds}


def test_the_page_lists_what_is_wrong():
    """A scene outside its bars appears with the command that shows it."""
    row = {"seed": 0} | SCRIPT.described(SCENE) | verdict(SCENE, answer())
    assert SCENE.command not in SCRIPT.page(SCRIPT.summary([row]))
    wrong = row | {"kind": "outside", "error": [10 * value for value in row["reported"]]}
    assert SCENE.command in SCRIPT.page(SCRIPT.summary([row, wrong]))


@pytest.mark.slow
def test_the_script_measures(tmp_path):
    """Three beams, from a file of truths that is filled as it goes, and read the next time."""
    command = [sys.executable, ROOT / "scripts" / "measure_error_bars.py", "--beams", "3"]
    command += ["--truths", tmp_path / "truths", "--out", tmp_path]
    for _ in range(2):
        subprocess.run(command, check=True, capture_output=True, env=os.environ, timeout=120)
        assert json.loads((tmp_path / "error_bars.json").read_text())["beams"] == 3
        assert len((tmp_path / "truths").read_text().splitlines()) == 3
