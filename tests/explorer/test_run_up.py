"""The run-up: the speed rises, and the scene shows the forced response."""

import math
from typing import Any

import numpy as np
import pytest
from live.offline import CLOCK, local
from live.visitor import PAPER, pause

from beamviz.beam import Beam
from beamviz.drawing.modes import displacement
from beamviz.explorer.features import run_up
from beamviz.explorer.features.run_up import RunUpRequest, RunUpState, next_speed
from beamviz.explorer.state import State
from beamviz.frequency_loci.forced_response import RunUp, response
from beamviz.scene import Scene
from beamviz.solver import solve


def run_of(beam: Beam) -> RunUp:
    """The run-up of a beam, with a force twice per revolution."""
    return RunUpRequest.of(State.of(Scene(beam)).with_values(RunUpState, force_per_rev=2)).run_up()


@pytest.fixture(scope="module")
def run() -> RunUp:
    """The run-up of PAPER."""
    return run_of(PAPER)


def speeds_shown(run: RunUp, seconds: float) -> list[float]:
    """The speeds from rest to the end, in steps of some seconds."""
    shown = [0.0]
    while (speed := next_speed(run, shown[-1], seconds)) is not None:
        shown.append(speed)
    return shown


def test_the_speed_increases_to_the_last_stable_one(run):
    """From rest, never back, so many speeds a second, and by far less near a resonance. An inward
    beam buckles near gamma 3."""
    first, _ = run.resonances
    gammas = np.array(speeds_shown(run, 0.1))
    assert len(gammas) - 1 == math.ceil((len(run.speeds) - 1) / (0.1 * run_up.PER_SECOND))
    assert gammas[-1] == run.speeds[-1]
    steps = np.diff(gammas)
    near = steps[abs(gammas[1:] - first.at) < 0.01 * first.at]
    assert steps.min() > 0
    assert len(near) >= 5
    assert max(near) < 0.2 * max(steps)
    last = speeds_shown(run_of(Beam(delta=-1, gamma=1)), 1.0)[-1]
    assert 2.7 < last < 3.0
    assert solve(Beam(delta=-1, gamma=last)).equilibrium.status == "stable"


def test_the_run_up_goes_beyond_the_speed_of_the_beam():
    """A beam faster than the end of the least range is in the chart, and near speeds share one."""
    fast = PAPER.replace(gamma=25)
    request = RunUpRequest.of(State.of(Scene(fast)))
    assert request.stop > fast.gamma
    assert RunUpRequest.of(State.of(Scene(fast.replace(gamma=26)))) == request


def test_the_scene_shows_the_scaled_response(guest, session):
    """All points keep phase and ratio; the highest peak has twice the amplitude, a quarter one."""
    pause(guest)
    guest.edit(coriolis=True)
    guest.do("force_per_rev", "2")
    guest.do("run_up", until=lambda _: session.visitor.state.slice(RunUpState).run_speed)
    run, amplitude = run_up.answer_of(session.snapshot).result, session.visitor.state.view.amplitude
    top = float(run.speeds[np.nanargmax(run.amplitudes)])
    for speed in (top, 1.0, 6.0):
        guest.edit(gamma=speed)
        drawn = session.snapshot.picture.drawn
        shown = -1j * drawn.amplitudes[0] * drawn.shapes.modes[0]
        solution = solve(PAPER.replace(gamma=speed), coriolis=True)
        field = response(solution, 2 * speed, run.damping, drawn.shapes.x)
        size = np.abs(shown).max() / np.abs(field).max()
        assert np.allclose(shown, size * field, atol=1e-12)
        share = min(np.abs(field).max() / np.nanmax(run.amplitudes), 1)
        peak = run_up.PEAK * amplitude * math.sqrt(share)
        assert np.abs(shown).max() == pytest.approx(peak)
        quarter = math.pi / 2 / 2  # of the hub, in a quarter of a period of the force
        moved = displacement(drawn.shapes, np.array([2 * quarter]), drawn.amplitudes)
        assert np.allclose(moved, -shown.imag, atol=1e-9)


def test_the_chart_shows_amplitudes_and_resonances(run):
    """Amplitudes over the speeds, and a button on each peak that sets its speed."""
    data = run_up.run_data(run)
    assert data["at"] == pytest.approx(run.speeds.tolist(), rel=1e-5)
    assert np.array(data["lines"][0]["y"], float) == pytest.approx(run.amplitudes, rel=1e-5)
    assert [mark["value"] for mark in data["marks"]] == [one.at for one in run.resonances]
    assert [mark["y"] for mark in data["marks"]] == [run.peak(one) for one in run.resonances]
    assert {mark["action"] for mark in data["marks"]} == {"gamma"}


def test_a_run_up_in_the_page(guest, session, monkeypatch):
    """The line of the beam and its slider move from rest; the speed of the beam is restored at the
    end. A new speed ends the run-up and keeps the result, another mass, damping or force
    discards it. The damping is clamped to 20 %; an invalid one, or a force, changes nothing."""

    def speed() -> float:
        return guest.charts["run-up-chart"].get("cursor", {"x": -1})["x"]

    def button_is(text: str) -> bool:
        return guest.texts["run-up-button"] == text

    guest.do("force_per_rev", "2")
    guest.do("run_up", until=lambda _: "resonances of the run-up" in guest.texts["run-up-list"])
    guest.wait(lambda _: 0 < speed() < 1)
    guest.wait(lambda _: 1 < speed() < 5)
    guest.wait(lambda _: abs(guest.values["gamma"] - speed()) < 1)  # the slider moves with it
    guest.do("run_up", until=lambda _: button_is("Run up from rest") and speed() == PAPER.gamma)
    assert guest.values["gamma"] == PAPER.gamma
    guest.do("run_up", until=lambda _: button_is("Stop"))
    guest.do("gamma", 4.0)
    speeds: list[float] = []
    guest.wait(lambda _: speeds.append(speed()) or button_is("Run up from rest"))
    assert max(speeds) <= PAPER.gamma  # the run-up would go on to 16
    guest.wait(lambda _: speed() == 4.0)
    assert "resonances of the run-up" in guest.texts["run-up-list"]
    for name, value in (("alpha", 2.0), ("damping", 5.0), ("force_per_rev", "3")):
        guest.do(name, value)
        guest.wait(lambda _: not session.visitor.state.slice(RunUpState).forced_response)
        with monkeypatch.context() as faster:
            faster.setattr(run_up, "PER_SECOND", 300.0)
            guest.do("run_up", until=lambda _: speed() not in (0.0, 4.0))
            guest.wait(lambda _: button_is("Run up from rest") and speed() == 4.0)
        assert "resonances of the run-up" in guest.texts["run-up-list"]
    guest.do("damping", 90.0)
    for name, value in (("damping", "much"), ("damping", math.nan), ("force_per_rev", "7")):
        guest.do(name, value)
    guest.edit(alpha=2.0, gamma=5.0)
    assert (guest.values["damping"], guest.values["force_per_rev"]) == (20, 3)


def test_a_run_up_is_not_slower_in_a_scene_that_moves(guest, session):
    """Though moments of the scene are drawn between the frames that show a new speed."""
    guest.do("run_up", until=lambda _: session.visitor.state.slice(RunUpState).run_speed)

    def speed(after: float) -> float:
        """At a frame after a time [s]."""
        session.move(CLOCK.time + after)
        session.tick(CLOCK.time + after)
        return session.visitor.state.slice(RunUpState).run_speed

    before, after = speed(0.0), speed(0.1)
    run = run_up.answer_of(session.snapshot).result
    assert after == pytest.approx(next_speed(run, before, 0.1))


def test_a_beam_compared_with_is_at_rest_in_a_run_up(guest, session):
    """The force drives the first beam only; the scene says so until a mode is chosen."""

    def is_moving(_: Any = None) -> bool:
        """Whether the beam compared with is out of its straight line."""
        second = session.view.scene.others.get(False)
        places = (
            second.bodies.places()[0] if second else np.zeros((0, 3))
        )  # none before it is drawn
        return bool((abs(places[:, 1]) > 1e-6).any())

    guest.choose("comparison", "coriolis", until=is_moving)
    guest.do("run_up", until=lambda _: "Forced response" in guest.texts["scene-caption"])
    for _ in range(10):
        guest.receive()
        assert not is_moving()
    guest.do("gamma", 4.0, until=lambda _: guest.charts["run-up-chart"]["cursor"]["x"] == 4.0)
    assert "Forced response" in guest.texts["scene-caption"]
    guest.do("only", 1, until=is_moving)
    guest.wait(lambda _: guest.texts["scene-caption"] == "")


def test_a_run_up_can_begin_at_an_unstable_beam():
    """From there to the first stable speed."""
    with local(Scene(Beam(delta=-1, gamma=10))) as guest:
        guest.do("run_up", until=lambda _: guest.texts["run-up-button"] == "Stop")
        guest.says("Stable equilibrium")
