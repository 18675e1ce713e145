"""The load test with few visitors, by counts; scripts/load.py measures times."""

import asyncio
import os
import sys
from pathlib import Path

import pytest

from beamviz.explorer.app import explorer
from beamviz.scene import Scene

sys.path.insert(0, str(Path(__file__).parents[2] / "scripts"))

from load import BENT, STRAIGHT, Drag, Visitor, measure

VISITORS, SECONDS = 8, 4.0


def measured(drag: Drag, count: int) -> tuple[list[Visitor], dict[str, float]]:
    """Visitors who drag for a while, and the rows of the script."""
    visitors = [Visitor(speeds=drag.speeds) for _ in range(count)]
    with explorer(Scene(drag.beam, {"state": drag.state})) as url:
        rows = asyncio.run(measure(url, drag, visitors, SECONDS, os.getpid()))
    return visitors, {key: value for key, value, _ in rows}


@pytest.fixture(scope="module")
def visit() -> tuple[list[Visitor], dict[str, float]]:
    """Visitors of a straight beam."""
    return measured(STRAIGHT, VISITORS)


@pytest.mark.slow
def test_a_bent_beam_is_solved_while_the_slider_is_dragged():
    """An edit gets a frame of its own."""
    (one,), _ = measured(BENT, 1)
    assert one.frames > 0
    assert len(one.answers) > 0


@pytest.mark.slow
def test_every_visitor_is_served(visit):
    """Each receives frames and answers to its edits."""
    visitors, _ = visit
    assert min(visitor.frames for visitor in visitors) > 0
    assert min(len(visitor.answers) for visitor in visitors) > 0


@pytest.mark.slow
def test_frames_are_shared_evenly(visit):
    """However slow the machine, no visitor gets half the frames of another."""
    visitors, _ = visit
    frames = sorted(visitor.frames for visitor in visitors)
    assert frames[-1] <= 2 * frames[0] + 4


def test_edits_are_not_queued(visit):
    """Of the edits sent while the solver was busy only the latest is solved."""
    visitors, _ = visit
    sent = VISITORS * SECONDS / visitors[0].pace
    assert sum(len(visitor.answers) for visitor in visitors) < sent


def test_the_rows_of_the_script_are_complete(visit):
    """All figures of the script are present and plausible."""
    _, rows = visit
    assert rows["visitors"] == VISITORS
    assert 0 < rows["fewest frames"] <= rows["median frames"] <= rows["most frames"]
    assert 0 < rows["every edit to update, median"] <= rows["every edit to update, 95 %"]
    assert rows["server CPU"] > 0
    assert rows["memory"] > 0
