"""What each method takes and gives for the beam that is shown."""

import re
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from beamviz.explorer.solver_job import answered

from beamviz.beam import Beam
from beamviz.explorer.features import method_timing as efforts_tab
from beamviz.explorer.features.method_timing import OPTION, RESOLUTIONS, Weighing, distance, efforts
from beamviz.explorer.state import Case
from beamviz.solver import METHODS, solve

PAPER = Case.of(Scene(Beam(alpha=1, beta=0.5, gamma=10)))


@pytest.fixture(scope="module")
def measured():
    """Every method on the beam of the README."""
    return efforts(PAPER)


def errors(measured, method):
    """Errors of a method, coarse to fine."""
    return [point.error for point in measured.points if point.method == method]


def test_every_method_is_tried(measured):
    """Each at every one of its resolutions; what has no error has a reason."""
    tried = {(point.method, point.resolution) for point in measured.points}
    assert tried == {
        (method, f"{OPTION[method]} {resolution:g}")
        for method in METHODS
        for resolution in RESOLUTIONS[OPTION[method]]
    }
    assert all(np.isfinite(point.error) != bool(point.reason) for point in measured.points)


def test_errors_are_those_of_the_frequencies(measured):
    """The paper's 20 elements are 0.09 % off in S1, a rigid tension 2.8 %, and auto is exact."""
    assert errors(measured, "ancf")[2] == pytest.approx(76.934327 / 76.863266 - 1, rel=1e-3)
    assert errors(measured, "foac") == pytest.approx([0.02795] * 4, rel=1e-3)
    for error, tolerance in zip(errors(measured, "auto"), RESOLUTIONS["tolerance"], strict=True):
        assert error < tolerance


def test_a_method_that_fails_says_how(measured):
    """Without stiffening the beam seems to buckle."""
    reasons = {point.reason for point in measured.points if point.method == "zoac"}
    assert reasons == {"says unstable: the beam is stable"}
    assert "says unstable: the beam is stable" in efforts_tab.chart(measured, None)


def test_modes_are_compared_by_name():
    """A stretching mode that passes a bending one is not held against it; growth rates count."""
    beam = Beam(alpha=1, gamma=4.5)
    assert distance(solve(beam, method="ancf", elements=40), solve(beam))[0] < 1e-4
    buckled = Beam(gamma=4, delta=-1)
    error, reason = distance(solve(buckled, method="ancf"), solve(buckled))
    assert reason == ""
    assert 1e-9 < error < 1e-2


def test_the_chart_names_each_method_once(measured):
    """The one in use stands out; names keep apart and within the chart."""
    svg = efforts_tab.chart(measured, solve(PAPER.beam()))
    names = re.findall(r'y="([\d.]+)" fill="#\w+" font-weight="(\d+)">([a-z-]+)<', svg)
    assert sorted(name for _, _, name in names) == sorted(set(METHODS) - {"zoac"})
    assert [name for _, weight, name in names if weight == "700"] == ["auto"]
    heights = [float(y) for y, _, _ in names]
    assert all(np.diff(heights) > 12.9)
    assert heights[-1] < efforts_tab.HEIGHT - efforts_tab.BELOW + 4


def test_what_was_used_is_said():
    """Elements, order, unknowns, time and error, as the solution has them."""
    solution = solve(PAPER.beam())
    words = efforts_tab.used(solution)
    assert words.startswith("2 elements, order 11, 44 unknowns, ")
    error = max(solution.errors / solution.frequencies)
    assert words.endswith(f"error {error:.0e}")


def test_where_there_is_no_equilibrium_nothing_is_measured():
    """The words are those of the solver."""
    found = efforts(Case.of(Beam(gamma=60), {"strain": "hencky"}))
    assert not found.points
    assert "no equilibrium beyond gamma = 45.42" in efforts_tab.chart(found, None)


def test_measuring_waits_until_it_is_asked_for():
    """Off at first; then once for every beam, whichever method it is shown by."""
    with ThreadPoolExecutor(1) as pool:
        weighing = Weighing(pool, lambda: None)
        weighing.follow(answered(PAPER, None))
        assert weighing.fresh
        assert weighing.shown()[1] is None
        assert weighing.trials.wanted is None
        weighing.switch(True)
        assert weighing.fresh
        weighing.shown()
        for _ in range(600):
            if weighing.trials.answer:
                break
            time.sleep(0.05)
        first = weighing.trials.answer
        assert first.points
        weighing.follow(answered(PAPER.changed("method", "ancf"), None))
        weighing.shown()
        assert not weighing.trials.busy
        assert weighing.trials.answer is first
        weighing.close()
