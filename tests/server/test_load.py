"""The load test with few visitors, by counts; scripts/load.py measures times."""

import asyncio
import os
from typing import Any

import pytest
from helpers import load_script

from beamviz.explorer.app import explorer
from beamviz.scene import Scene

VISITORS, SECONDS, TIMEOUT = 8, 4.0, 180.0
SCRIPT = load_script("load")


def measured(drag: Any, count: int) -> tuple[list[Any], dict[str, float]]:
    """Visitors who drag for a while and until one is answered, and the rows of the script."""
    visitors = [SCRIPT.Visitor(speeds=drag.speeds) for _ in range(count)]
    with explorer(Scene(drag.beam, {"state": drag.state})) as url:
        measuring = SCRIPT.measure(url, drag, visitors, SECONDS, os.getpid(), resolves=1)
        rows = asyncio.run(asyncio.wait_for(measuring, TIMEOUT))
    return visitors, {key: value for key, value, _ in rows}


@pytest.mark.slow
def test_a_bent_beam_is_solved_while_the_slider_is_dragged():
    """An edit gets a frame of its own."""
    (one,), _ = measured(SCRIPT.BENT, 1)
    assert one.frames > 0
    assert one.answers


@pytest.mark.slow
def test_every_visitor_is_served_evenly_and_edits_are_not_queued():
    """However slow the machine, no visitor gets half the frames of another, and each gets answers;
    of the edits sent while the solver was busy only the latest is solved. The rows of the script
    are complete and plausible."""
    visitors, rows = measured(SCRIPT.STRAIGHT, VISITORS)
    frames = sorted(visitor.frames for visitor in visitors)
    assert 0 < frames[-1] <= 2 * frames[0] + 4
    answers = [len(visitor.answers) for visitor in visitors]
    assert min(answers) > 0
    assert sum(answers) < VISITORS * SECONDS / visitors[0].pace
    assert rows["visitors"] == VISITORS
    assert 0 < rows["fewest frames"] <= rows["median frames"] <= rows["most frames"]
    assert 0 < rows["every edit to update, median"] <= rows["every edit to update, 95 %"]
    assert rows["server CPU"] > 0
    assert rows["memory"] > 0
