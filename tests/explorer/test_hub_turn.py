"""The wheel on the hub, by which a visitor turns it."""

from collections.abc import Iterator

import numpy as np
import pytest
from live.offline import Desk, lecture, offline

from beamviz.beam import Beam
from beamviz.explorer.features.hub_turn import REACH
from beamviz.scene import START, Scene

HANDLE = "/scene/rotor/wheel/handle"
FIRST = START.changed(playing=False)
RANGE = 50.0  # of the slider of the speed


@pytest.fixture
def desk() -> Iterator[Desk]:
    with offline():
        yield Desk(FIRST)


def turn(desk: Desk, *across: float) -> list[float]:
    """Drag the wheel to places across the screen [L], from where it is taken. Returns the speeds of
    the beam drawn there, and after the drag."""
    eye, at = (np.array(one) for one in (desk.camera.position, desk.camera.look_at))
    right = np.cross(at - eye, (0.0, 0.0, 1.0))
    points = [tuple(far * right / np.linalg.norm(right)) for far in (0.0, *across, across[-1])]
    shown = list[float]()

    def between() -> None:
        desk.frame(3)
        shown.append(desk.session.snapshot.picture.modes.beam.gamma)

    desk.guest.visitor.drag(HANDLE, *points, between=between)
    return shown


def test_the_hub_is_turned_faster_to_the_right_and_braked_to_the_left(desk):
    """As the slider of the speed goes, within its range; back at the start the speed is the same,
    and each drag is a step to undo, however long it takes."""
    whole = REACH / RANGE  # [L] for a speed of 1
    assert turn(desk, 10 * whole, 2.3 * whole) == pytest.approx([5.0, 15.0, 7.3, 7.3])
    assert turn(desk, -1.0, 4.0, 0.0) == pytest.approx([7.3, 0.0, RANGE, 7.3, 7.3])
    turn(desk, -whole)
    for before in (7.3, 7.3, 5.0):
        desk.do("undo")
        desk.frame(3)
        assert desk.state.case.numbers["gamma"] == before
    assert not desk.session.snapshot.undo


def test_a_hub_that_is_turned_faster_turns_faster_in_the_picture(desk):
    """Time passes as before the drag, which is undone with it; the beam keeps its place."""
    rate, place = desk.session.snapshot.rate, desk.session.view.beam.frame.position
    turn(desk, 0.9)
    assert desk.session.snapshot.rate == desk.state.rate == rate
    assert np.allclose(desk.session.view.beam.frame.position, place)
    desk.do("undo")
    desk.frame()
    assert desk.state.rate is None


def test_a_real_hub_is_turned_by_the_steps_of_its_slider(desk):
    """In revolutions per minute."""
    desk.do("real.preset", "steel beam")
    desk.frame(3)
    speeds = []
    for across in (0.0, 0.1):
        turn(desk, across)
        shown = desk.guest.visitor
        shown.receive()
        speeds.append(shown.values["gamma"])
    steps = (speeds[1] - speeds[0]) / shown.props["gamma-slider"]["step"]
    assert steps > 10
    assert steps == pytest.approx(round(steps))


def test_a_visitor_of_a_lecture_turns_the_hub():
    """Which they explore by themselves then."""
    with offline():
        lead, one = Desk(FIRST), Desk(FIRST)
        lecture(lead, one)(3)
        turn(one, 0.3)
        assert not one.state.following
        assert [each.state.case.numbers["gamma"] for each in (lead, one)] == [5.0, 15.0]


@pytest.mark.parametrize("delta", [-1.0, 0.1, 3.0])
def test_the_wheel_is_on_the_rim_of_the_hub(delta):
    """On a part of a large one, or of the ring of an inward beam, which no spoke crosses; where
    modes are drawn one above the other there is none."""
    with offline():
        desk = Desk(Scene(Beam(gamma=1, delta=delta)).changed(playing=False))
        desk.frame(3)
        wheel = desk.visitor.client.scene.nodes["/scene/rotor/wheel"]
        drawn = wheel.batched_scales[:, 0] > 0
        places = np.linalg.norm(wheel.batched_positions[drawn, :2], axis=1)
        near = np.abs(places - abs(delta)) < 0.06
        assert near.sum() > 50
        assert near.all() == (delta != 0.1)
        desk.do("all_modes", True)
        desk.frame(3)
        assert not wheel.visible
