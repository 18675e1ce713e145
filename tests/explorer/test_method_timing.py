"""Time and error of every method for the beam shown."""

import re
import threading
from collections.abc import Iterator

import numpy as np
import pytest
from charts import case
from live.server import wait_until
from live.visitor import PAPER, pause

from beamviz.beam import Beam
from beamviz.explorer.features import method_timing
from beamviz.explorer.features.method_timing import RESOLUTIONS, cost, frequency_error
from beamviz.solver import METHODS, solve


@pytest.fixture(scope="module", autouse=True)
def once() -> Iterator[None]:
    """Each solve is done once, as no test depends on its time."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(method_timing, "REPEATS", 1)
        yield


@pytest.fixture(scope="module")
def timings():
    """Every method on the beam of the README."""
    return method_timing.time_methods(case(PAPER))


def test_every_method_is_timed_at_each_of_its_resolutions(timings):
    """Each has an error or a reason why it has none: without stiffening the beam is unstable. The
    paper's 20 elements are 0.09 % off in S1, constant tension 2.8 %; auto has converged."""
    options = {m: getattr(row.resolution, "option", "tolerance") for m, row in METHODS.items()}
    expected = {(m, option, r) for m, option in options.items() for r in RESOLUTIONS[option]}
    found = [(timing.method, *timing.resolution.split()) for timing in timings]
    assert {(method, option, float(value)) for method, option, value in found} == expected
    assert all(np.isfinite(timing.error) != bool(timing.reason) for timing in timings)
    reason = "predicts an unstable beam; it is stable"
    assert {timing.reason for timing in timings if timing.method == "zoac"} == {reason}
    assert reason in method_timing.timing_table(timings)
    errors = {m: [t.error for t in timings if t.method == m] for m in ("ancf", "foac", "auto")}
    assert errors["ancf"][2] == pytest.approx(76.934327 / 76.863266 - 1, rel=1e-3)
    assert errors["foac"] == pytest.approx([0.02795] * 4, rel=1e-3)
    for error, tolerance in zip(errors["auto"], RESOLUTIONS["tolerance"], strict=True):
        assert error < tolerance


@pytest.mark.parametrize(
    ("beam", "coriolis", "count", "least", "most"),
    [
        (Beam(alpha=1, gamma=4.5), False, 40, 1e-9, 1e-4),
        (Beam(gamma=4, delta=-1), False, 40, 1e-9, 1e-2),  # buckled: growth rates
        (Beam(alpha=1, gamma=4.65), True, 40, 1e-9, 1e-4),  # S1 and B3 mixed, named B3 and B4
        (Beam(alpha=1, gamma=4.65), True, 10, 1e-9, 1e-3),  # and S1 and B3: 0.06 %, not 89 %
        # S1 is above B3, and below it in the converged solution: by order of frequency 0.05 %
        (PAPER.replace(gamma=9.39), False, 20, 9.2e-4, 9.5e-4),
    ],
)
def test_modes_are_matched_by_shape(beam, coriolis, count, least, most):
    """The error of some elements is small although their labels or their order differ."""
    elements = solve(beam, method="ancf", elements=count, coriolis=coriolis)
    assert least < frequency_error(elements, solve(beam, coriolis=coriolis)) < most


def test_the_chart_has_a_line_for_each_method_and_a_ring_for_the_scene(timings):
    """Time [ms] and error; the ring names the resolution and the cost; a button for each method."""
    solution = solve(PAPER)
    data = method_timing.timing_data(timings, solution)
    assert [line["label"] for line in data["lines"]] == [m for m in METHODS if m != "zoac"]
    times = [1000 * t.seconds for t in timings if not t.reason]
    errors = [min(t.error, 1.0) for t in timings if not t.reason]
    assert [x for line in data["lines"] for x in line["at"]] == pytest.approx(times, rel=1e-5)
    assert [y for line in data["lines"] for y in line["y"]] == pytest.approx(errors, rel=1e-5)
    assert data["x"]["range"][0] <= min(times) < max(times) <= data["x"]["range"][1]
    *_, ring = data["marks"]
    assert ring["text"] == f"this scene: {cost(solution)}"
    assert cost(solution).startswith(f"2 elements, order 11, {solution.stats.dof} unknowns, ")
    error = max(solution.errors / solution.frequencies)
    assert cost(solution).endswith(f"relative error {error:.0e}")
    rows = method_timing.timing_table(timings)
    assert all(f'data-set="method" data-value="&quot;{name}&quot;"' in rows for name in METHODS)


@pytest.mark.parametrize("cancelled", [False, True])
def test_methods_are_timed_on_request_while_their_tab_is_open(
    connected, served, monkeypatch, cancelled
):
    """A slow timing is named, also while paused. Another tab stops it, or forgets its cancellation;
    back, the beam is timed, but not again for another method."""
    release = threading.Event()
    monkeypatch.setattr(
        method_timing, "solve", lambda *a, **o: (release.wait(60), solve(*a, **o))[1]
    )
    monkeypatch.setattr(method_timing, "RESOLUTIONS", {o: v[:1] for o, v in RESOLUTIONS.items()})
    pause(connected)
    connected.do("tab", "methods", until="relative error")
    assert connected.props["timing-chart"]["hidden"]
    connected.do("time_methods", True)
    told = "computing: method timing.*Cancel"
    connected.wait(lambda _: re.match(told, connected.texts["timing-chart-wait"]))
    assert connected.texts["work"] == ""  # it is told once
    if cancelled:
        connected.do(
            "cancel_jobs", until=lambda _: "cancelled: method timing" in connected.texts["work"]
        )
        connected.wait(lambda _: "was cancelled" in connected.texts["timings"])
    job = served.visitor.jobs[method_timing.JOB]
    connected.do("tab", "map")
    wait_until(lambda: job.latest is None and not job.busy)  # else it may be answered all the same
    connected.wait(lambda _: connected.texts["work"] == "")
    release.set()
    connected.edit(gamma=3.0)
    assert "<table" not in connected.texts["timings"]
    connected.do("tab", "methods", until=lambda _: "<table" in connected.texts["timings"])
    connected.wait(lambda _: connected.props["timing-chart"]["data-outdated"] is None)
    before = connected.texts["timings"]
    assert job.answer.request.beam == PAPER.replace(gamma=3)
    connected.choose("method", "foac", until="foac</b>: ")
    wait_until(lambda: not served.is_busy)
    assert connected.texts["timings"] == before  # with the times measured
