"""The microscope: the same two loci with Coriolis forces and without."""

from dataclasses import replace

import numpy as np
import pytest
from charts import TIP, charted

from beamviz.display_units import frequencies, measure
from beamviz.drawing.modes import Shapes
from beamviz.explorer.features import veering as microscope_tab
from beamviz.explorer.features.loci_chart import Chart
from beamviz.explorer.features.veering import Target, magnified, motion
from beamviz.solver import solve

PLAIN = measure("gamma", None), frequencies(None)


@pytest.fixture(scope="module")
def tip() -> Chart:
    """The loci of TIP over the speed."""
    return charted(TIP)


def test_the_microscope_shows_crossing_and_veering_of_the_same_two(tip):
    """Off: gap 0 at 4.4641, every shape stays; on: gap 0.241 at 4.650, the shapes change places."""
    off, on = magnified(Target(tip.question, tip.events[0]))
    assert off.event
    assert on.event
    assert (off.event.kind, on.event.kind) == ("crossing", "veering")
    assert off.at == pytest.approx(4.4641, abs=1e-4)
    assert on.at == pytest.approx(4.650, abs=1e-3)
    assert on.event.gap == pytest.approx(0.241, abs=1e-3)
    for motions in off.motions:
        assert len({round(motion.share, 6) for motion in motions}) == 1
    for before, at, after in on.motions:
        assert abs(after.share - before.share) > 0.8
        assert at.share == pytest.approx(0.5, abs=0.05)
    words = microscope_tab.sentence(on, *PLAIN)
    assert "least gap 0.241 at γ 4.650" in words
    assert "exchange their shapes" in words
    assert "nothing couples them" in microscope_tab.sentence(off, *PLAIN)


def test_both_meetings_and_all_of_the_gap_are_in_view(tip):
    """At the edges of the view the two loci are more than twice as far apart as where they are
    nearest; of all the chart it is a small part."""
    pairs = magnified(Target(tip.question, tip.events[0]))
    for pair in pairs:
        assert pair.values[0] < pair.at < pair.values[-1]
        assert np.ptp(pair.values) < 0.2 * (tip.question.stop - tip.question.start)
    a, b = pairs[1].branches
    apart = abs(b.frequency - a.frequency)[[0, -1]]
    assert pairs[1].event
    assert apart.min() > 2 * pairs[1].event.gap


def test_shapes_keep_their_signs_across_the_view(tip):
    """A shape before the meeting and one after it are more like the one there than its opposite;
    at a crossing, where the two could be mixed at will, they are taken beside it."""
    off, on = magnified(Target(tip.question, tip.events[0]))
    for motions in (*off.motions, *on.motions):
        for end in (motions[0], motions[2]):
            assert end.along @ motions[1].along + end.across @ motions[1].across >= 0
    assert off.at not in off.values


def test_a_branch_has_no_shape_where_it_is_not(tip):
    """Above the modes that are solved for."""
    assert tip.loci
    branch = replace(tip.loci.branches[0], mode_index=np.full(len(tip.loci.values), -1))
    assert np.isnan(motion(branch, 0).along).all()


def test_what_is_too_wide_for_a_veering_is_said(tip):
    """S1 and B2 cross at 16.32; with Coriolis forces they stay far apart."""
    off, on = magnified(Target(tip.question, tip.events[1]))
    assert off.event
    assert on.event is None
    assert "do not come close" in microscope_tab.sentence(on, *PLAIN)
    arrays = microscope_tab.series((off, on), microscope_tab.LANES)
    assert len(arrays) == len(microscope_tab.styles(microscope_tab.LANES))


def test_nodes_are_marked_in_the_middle_of_a_veering():
    """There the tip moves more along than across, out of step with the bending that has nodes."""
    solution = solve(TIP.replace(gamma=4.65), coriolis=True)
    for k in (2, 3):
        marked, _ = Shapes.sampled(solution).nodes[k]
        assert marked == pytest.approx(solution.nodes[k], abs=2e-5)
        assert len(marked) == 2
