"""The load test with few visitors, by counts; scripts/load.py measures times."""

import asyncio
import os

import pytest
from helpers import load_script

from beamviz.explorer import explorer
from beamviz.scene import Scene

SECONDS, TIMEOUT = 2.0, 180.0
SCRIPT = load_script("load")
SCRIPT.SETTLING = 1.0  # [s]: this test compares no times


@pytest.mark.slow
@pytest.mark.parametrize(("drag", "count"), [(SCRIPT.STRAIGHT, 6), (SCRIPT.BENT, 1)])
def test_every_visitor_is_served_evenly_and_edits_are_not_queued(drag, count):
    """No visitor gets half the frames of another, and each gets answers; of edits during a solve
    only the latest is solved. The rows of the script are complete and plausible."""
    visitors = [SCRIPT.Visitor(speeds=drag.speeds) for _ in range(count)]
    with explorer(Scene(drag.beam, {"state": drag.state})) as url:
        measuring = SCRIPT.measure(url, drag, visitors, SECONDS, os.getpid(), resolves=4 * count)
        found = asyncio.run(asyncio.wait_for(measuring, TIMEOUT))
    rows = {key: value for key, value, _ in found}
    frames = sorted(visitor.frames for visitor in visitors)
    assert 0 < frames[-1] <= 2 * frames[0] + 4
    answers = [len(visitor.answers) for visitor in visitors]
    assert min(answers) > 0
    assert sum(answers) < count * SECONDS / visitors[0].pace
    assert rows["visitors"] == count
    assert 0 < rows["fewest frames"] <= rows["median frames"] <= rows["most frames"]
    assert 0 < rows["every edit to update, median"] <= rows["every edit to update, 95 %"]
    assert min(rows["server CPU"], rows["memory"]) > 0
