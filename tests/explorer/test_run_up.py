"""The run-up: the speed rises, and the scene shows the forced response."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from charts import SynchronousVisitor
from live.visitor import PAPER, TIMEOUT, beam_moved, visitor

from beamviz.beam import Beam
from beamviz.drawing.modes import displacement
from beamviz.explorer import explorer
from beamviz.explorer.features import run_up
from beamviz.explorer.features.run_up import RunUpPlayback, with_damping
from beamviz.explorer.state import State
from beamviz.frequency_loci.forced_response import response
from beamviz.scene import Scene
from beamviz.solver import solve


def started(beam: Beam = PAPER, **options: bool) -> RunUpPlayback:
    """A run-up about to begin, with a force twice per revolution."""
    guest: Any = SynchronousVisitor(Scene(beam, options))
    guest.change(lambda state: replace(state, force_per_rev=2))
    playback = RunUpPlayback(guest)
    playback.start_or_stop()
    assert playback.running
    return playback


def gamma(playback: RunUpPlayback) -> float:
    """The speed that is shown."""
    return playback.visitor.state.shown_case.numbers["gamma"]


def played(playback: RunUpPlayback, seconds: float) -> list[float]:
    """The speeds to the end of the run-up, in steps of some seconds."""
    gammas = []
    while playback.running:
        playback.step(seconds)
        gammas.append(gamma(playback))
    return gammas


def test_the_speed_increases_to_the_last_one_and_is_restored():
    """From rest, never back, so many speeds a second, in a tenth of a second by far less near a
    resonance than elsewhere; then that of the beam is shown."""
    playback = started()
    speeds, (first, _) = playback.run.speeds, playback.run.resonances
    *gammas, restored = played(playback, 0.1)
    assert len(gammas) == math.ceil((len(speeds) - 1) / (0.1 * run_up.PER_SECOND))
    assert (gammas[-1], restored) == (speeds[-1], PAPER.gamma)
    steps = np.diff([0.0, *gammas])
    near = steps[abs(np.array(gammas) - first.at) < 0.01 * first.at]
    assert steps.min() > 0
    assert len(near) >= 5
    assert max(near) < 0.2 * max(steps)
    playback.step(0.1)
    assert gamma(playback) == PAPER.gamma


def test_it_ends_where_the_beam_becomes_unstable():
    """An inward beam buckles near gamma 3: the last speed is a stable one."""
    *_, last, restored = played(started(Beam(delta=-1, gamma=1)), 1.0)
    assert 2.7 < last < 3.0
    assert restored == 1
    assert solve(Beam(delta=-1, gamma=last)).equilibrium.status == "stable"


def test_the_scene_shows_the_scaled_response():
    """All points keep phase and ratio; the highest peak has twice the amplitude of the view, one of
    a quarter of it half that."""
    playback = started(coriolis=True)
    run, amplitude = playback.run, playback.visitor.state.view.amplitude
    top = float(run.speeds[np.nanargmax(run.amplitudes)])
    for speed in (top, 1.0, 6.0):
        playback.visitor.change(lambda state, speed=speed: state.changed("gamma", speed))
        answer = playback.visitor.answer
        drawn = playback.drawn(answer.shapes, 1000.0)
        field = response(answer.solution, 2 * speed, run.damping, answer.shapes.x)
        size = np.abs(playback.field).max() / np.abs(field).max()
        assert np.allclose(playback.field, size * field, atol=1e-12)
        share = min(np.abs(field).max() / np.nanmax(run.amplitudes), 1)
        peak = run_up.PEAK * amplitude * math.sqrt(share)
        assert np.abs(playback.field).max() == pytest.approx(peak)
        quarter = math.pi / 2 / 2  # of the hub, in a quarter of a period of the force
        moved = displacement(drawn.shapes, np.array([2 * quarter]), drawn.amplitudes)
        assert np.allclose(moved, -playback.field.imag, atol=1e-9)


def test_another_force_damping_or_beam_ends_the_run_up():
    """Its result is no longer valid; invalid values change nothing."""
    state = State.of(Scene(PAPER))
    assert with_damping(state, "much") == with_damping(state, math.nan) == state
    assert with_damping(state, 90.0).damping == 0.2
    for edit in (lambda s: with_damping(s, 5.0), lambda s: s.changed("alpha", 2.0)):
        playback = started()
        playback.visitor.change(edit)
        playback.step(0.1)
        assert (playback.running, playback.run) == (False, None)


def test_the_chart_shows_amplitudes_and_resonances():
    """Amplitudes over the speeds, and a button on each peak that sets its speed."""
    run = started().run
    data = run_up.run_data(run)
    assert data["at"] == pytest.approx(run.speeds.tolist(), rel=1e-5)
    assert np.array(data["lines"][0]["y"], float) == pytest.approx(run.amplitudes, rel=1e-5)
    assert [mark["value"] for mark in data["marks"]] == [one.at for one in run.resonances]
    assert [mark["y"] for mark in data["marks"]] == [run.peak(one) for one in run.resonances]
    assert {mark["action"] for mark in data["marks"]} == {"gamma"}


def test_a_run_up_in_the_page(guest):
    """The line of the beam moves from rest, the speed of the beam does not change; a new speed
    ends the run-up and keeps the result, another mass discards it."""

    def speed() -> float:
        return guest.charts.get("run-up-chart", {"cursor": {"x": -1}})["cursor"]["x"]

    def button_is(text: str) -> bool:
        return guest.texts["run-up-button"] == text

    guest.do("force_per_rev", "2")
    guest.do("run_up")
    guest.wait(lambda _: "resonances of the run-up" in guest.texts["run-up-list"])
    guest.wait(lambda _: 0 < speed() < 1)
    guest.wait(lambda _: 1 < speed() < 5)
    assert guest.values["gamma"] == PAPER.gamma
    guest.do("run_up")
    guest.wait(lambda _: button_is("Run up from rest") and speed() == PAPER.gamma)
    guest.do("run_up")
    guest.wait(lambda _: button_is("Stop"))
    guest.do("gamma", 4.0)
    speeds: list[float] = []
    guest.wait(lambda _: speeds.append(speed()) or button_is("Run up from rest"))
    assert max(speeds) <= PAPER.gamma  # the run-up would go on to 16
    guest.wait(lambda _: speed() == 4.0)
    assert "resonances of the run-up" in guest.texts["run-up-list"]
    guest.do("alpha", 2.0)
    guest.wait(lambda _: "resonances of the run-up" not in guest.texts["run-up-list"])
    guest.do("damping", "nonsense")
    guest.do("force_per_rev", "7")
    guest.edit(alpha=2.0, gamma=5.0)
    assert guest.values["force_per_rev"] == 2


def test_a_beam_compared_with_is_at_rest_in_a_run_up(guest):
    """The force drives the first beam only; the scene says so until a mode is chosen, also after
    the run-up, at another speed."""

    def is_moving(messages: list[dict[str, Any]]) -> bool:
        masses = [one for one in messages if one.get("name") == "/scene/rotor/overlay/mass"]
        return any(abs(one["position"][1]) > 1e-6 for one in masses if "position" in one)

    guest.choose("comparison", "coriolis")
    guest.wait(is_moving)
    guest.do("run_up")
    guest.wait(lambda _: "Forced response" in guest.texts["scene-caption"])
    frames = [messages for _ in range(30) if beam_moved(messages := guest.receive(TIMEOUT))]
    assert len(frames) > 10
    assert not any(map(is_moving, frames))
    guest.do("gamma", 4.0)
    guest.wait(lambda _: guest.charts["run-up-chart"]["cursor"]["x"] == 4.0)
    assert "Forced response" in guest.texts["scene-caption"]
    guest.do("only", 1)
    guest.wait(is_moving)
    guest.wait(lambda _: guest.texts["scene-caption"] == "")


def test_a_run_up_can_begin_at_an_unstable_beam():
    """The scene is grey until the first stable speed."""
    with explorer(Scene(Beam(delta=-1, gamma=10))) as url, visitor(url, first="Unstable") as guest:
        guest.do("run_up")
        guest.wait(lambda _: guest.texts["run-up-button"] == "Stop")
        guest.says("Stable equilibrium")
