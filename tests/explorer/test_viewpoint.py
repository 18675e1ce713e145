"""The viewpoint: whose it is, the server's or the visitor's, in whatever order their messages come.

The page is played by the test, which reports its camera when it likes.
"""

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import pytest
from live.fresh import turned
from live.offline import CLOCK, OfflineGuest, offline, run
from live.visitor import PAPER

from beamviz.explorer.camera import DEFAULT
from beamviz.scene import Camera, Scene

FIRST = Scene(PAPER).changed(playing=False, rotating_frame=False)
FRAME = 0.04  # [s] from one frame to the next
EASED = 30  # frames of a change of view, and a few more


class Page:
    """A page at rest, whose frames come when the test says so, and which reports its camera then
    too: that of viser is where the page was placed or reported last."""

    def __init__(self, scene: Scene = FIRST):
        self.guest = OfflineGuest(scene)
        self.guest.visitor.do("link", "")
        self.guest.settle()
        self.session, self.visitor = self.guest.session, self.guest.session.visitor

    @property
    def state(self) -> Any:
        return self.visitor.state

    @property
    def camera(self) -> Camera:
        """Where the page is, or is on its way to."""
        return self.visitor.camera.present

    @property
    def address(self) -> str:
        self.guest.visitor.receive()
        return self.guest.visitor.parts["address"]

    def do(self, action: str, value: Any = None) -> None:
        self.guest.visitor.do(action, value)

    def edit(self, name: str, value: Any) -> None:
        """Another value, whose answer comes in the frame after the next."""
        self.do(name, value)
        self.frame(2)

    def report(self, camera: Camera) -> None:
        """The page tells its camera."""
        view = self.visitor.client.camera
        view.position, view.look_at = camera.position, camera.look_at
        run(self.session.camera_moved(None))

    def turn(self, angle: float = 0.5) -> Camera:
        """The visitor turns the view."""
        camera = Camera(*turned(self.camera, angle, 1.1))
        self.report(camera)
        return camera

    def frame(self, count: int = 1) -> None:
        """The next frames, which take a snapshot."""
        for _ in range(count):
            CLOCK.time += FRAME
            self.guest.workers.run()
            self.session.tick(CLOCK.time)

    def moment(self) -> None:
        """A frame that shows another moment of the last snapshot."""
        CLOCK.time += FRAME
        self.session.move(CLOCK.time)


@pytest.fixture
def desk() -> Iterator[Page]:
    with offline():
        yield Page()


def near(one: Camera, other: Camera) -> bool:
    """Whether two viewpoints are the same, but for rounding."""
    return math.dist(one.position + one.look_at, other.position + other.look_at) < 1e-3


def test_the_state_and_the_address_have_the_view_that_was_turned(desk):
    """Until it is fitted again; a larger beam does not move it, and undo does not turn it back."""
    fitted = desk.camera
    desk.edit("delta", 2.0)
    turned = desk.turn()
    desk.frame()
    assert desk.state.turned == turned
    assert "position=" in desk.address
    desk.edit("delta", 3.0)
    desk.do("undo")
    desk.frame(2)
    assert desk.camera == desk.state.viewpoint == turned
    desk.do("reset_view")
    desk.edit("delta", PAPER.delta)
    assert desk.camera == fitted
    assert desk.state.viewpoint is None
    assert "position=" not in desk.address


@pytest.mark.parametrize("is_shown", [False, True])
def test_a_view_is_fitted_though_the_visitor_turns_on(desk, is_shown):
    """The page has not heard of it yet; also where no frame has shown the turn."""
    fitted = desk.camera
    desk.turn()
    if is_shown:
        desk.frame()
    desk.do("reset_view")
    if is_shown:
        desk.turn()
    desk.frame()
    assert desk.camera == fitted
    assert desk.state.turned is None


def test_a_report_that_crosses_a_viewpoint_is_corrected_by_the_next(desk):
    """No frame in between moves the page, which is where it was told to be."""
    fitted = desk.camera
    desk.turn()
    desk.frame()
    desk.do("reset_view")
    desk.frame()
    late = desk.turn()
    desk.frame()
    assert desk.camera == late
    desk.report(fitted)
    desk.frame()
    assert desk.state.turned is None
    assert desk.camera == fitted


def test_a_view_is_not_turned_back_by_a_frame_that_only_moves_the_scene(desk):
    """Of a snapshot that was taken before."""
    desk.do("playing", True)
    desk.frame()
    turned = desk.turn()
    desk.moment()
    assert desk.camera == turned
    desk.frame()
    assert desk.camera == turned


def test_the_page_is_put_right_where_it_has_an_earlier_viewpoint(desk):
    """That before the last one, twice, the initial one, viser's own, and parts of two."""
    before = desk.camera
    desk.edit("delta", 3.0)
    last = desk.camera
    assert not near(last, before)
    parts = Camera(before.position, last.look_at)
    for old in (before, before, desk.visitor.camera.initial, DEFAULT, parts):
        desk.report(old)
        assert desk.state.turned is None
        desk.frame()
        assert desk.camera == last


def test_a_view_that_is_fitted_arrives_in_parts(desk):
    """Position and target arrive one after the other; then the page is where it should be."""
    fitted = desk.camera
    away = Camera((1.0, -2.0, 1.5), (0.5, 0.0, 0.0))
    desk.report(away)
    desk.frame()
    desk.do("reset_view")
    desk.frame()
    desk.report(Camera(fitted.position, away.look_at))
    desk.frame()
    desk.report(fitted)
    desk.frame()
    assert desk.camera == fitted
    assert desk.state.turned is None


def test_no_one_turns_a_view_that_changes(desk):
    """A camera on the way is not the visitor's, also where it is told after the end."""
    desk.turn()
    desk.frame()
    desk.do("rotating_frame", not desk.state.view.rotating_frame)
    desk.frame(5)
    on_the_way = desk.camera
    desk.report(on_the_way)
    assert desk.state.turned is None
    desk.frame(EASED)
    assert desk.visitor.clock.transition is None
    fitted = desk.camera
    desk.report(on_the_way)
    desk.frame()
    desk.report(fitted)
    desk.frame()
    assert desk.camera == fitted
    assert desk.state.turned is None


@pytest.mark.parametrize("is_still", [False, True])
def test_undo_of_the_frame_leaves_a_view_that_was_turned_in_it(desk, is_still):
    """And so does redo; undo of another edit keeps it."""
    desk.do("preferences", "still" if is_still else "")
    desk.frame()
    outside = desk.camera
    desk.do("rotating_frame", not desk.state.view.rotating_frame)
    desk.frame(EASED)
    inside = desk.camera
    assert not near(inside, outside)
    desk.turn()
    desk.frame()
    desk.do("undo")
    desk.frame(EASED)
    assert near(desk.camera, outside)
    desk.turn()
    desk.frame()
    desk.do("redo")
    desk.frame(EASED)
    assert near(desk.camera, inside)
    assert desk.state.turned is None


def test_a_scene_with_a_viewpoint_of_its_own_is_seen_from_it(desk):
    """Though the view was turned, and is turned on before the frame; undo goes back."""
    fitted, own = desk.camera, Camera((2.0, -2.0, 2.0), (0.0, 0.5, 0.0))
    desk.turn()
    desk.frame()
    desk.visitor.open(replace(FIRST, camera=own))
    desk.turn()
    desk.frame()
    assert desk.camera == desk.state.viewpoint == own
    desk.turn()
    desk.frame()
    desk.do("undo")
    desk.frame()
    assert desk.camera == fitted
    assert desk.state.viewpoint is None


def test_a_page_of_another_size_is_fitted_unless_it_was_turned(desk):
    """The page tells its size with its camera."""
    fitted, view = desk.camera, desk.visitor.client.camera
    view.aspect = 0.6
    desk.report(desk.camera)
    desk.frame()
    narrow = desk.camera
    assert not near(narrow, fitted)
    turned = desk.turn()
    desk.frame()
    view.aspect = 1.8
    desk.report(desk.camera)
    desk.frame()
    assert desk.camera == turned
    desk.do("reset_view")
    desk.frame()
    assert desk.camera != narrow


def test_a_viewpoint_too_far_away_is_left_again(desk):
    """It would be invalid in a link; the page goes back to the last valid one."""
    turned = desk.turn()
    desk.frame()
    for far in ((0.0, 0.0, 2000.0), (math.nan, 0.0, 1.0), (math.inf, 0.0, 1.0)):
        view = desk.visitor.client.camera
        view.position = far
        run(desk.session.camera_moved(None))
        desk.frame()
        assert desk.camera == desk.state.turned == turned


def test_the_mass_is_dragged_in_a_view_that_was_turned(desk):
    """The view follows the scene, which moves as the mass is released, back to where it was."""
    turned = desk.turn()
    desk.frame()
    node = "/scene/rotor/mass"
    desk.guest.visitor.drag(node, (0.0, 0.0, 0.0), (0.3, 0.0, 0.0), (0.3, 0.0, 0.0))
    for _ in range(EASED):
        desk.frame()
        desk.report(desk.camera)
    assert desk.state.grip is None
    assert desk.state.case.numbers["beta"] != PAPER.beta
    assert near(desk.camera, turned)
    assert desk.state.turned == turned


def test_a_visitor_of_a_lecture_keeps_a_view_of_their_own():
    """Whatever the presenter edits, until that changes the frame."""
    with offline():
        lead, one = Page(), Page()
        one.visitor.presenter = lambda: lead.session.snapshot
        one.visitor.update(lambda state: replace(state, following=True))

        def both(count: int = 1) -> None:
            for _ in range(count):
                lead.frame()
                one.frame()

        both()
        lead.turn()
        turned = one.turn(-1.0)
        both()
        lead.do("delta", 2.0)
        both(2)
        assert one.session.snapshot.beam.delta == 2
        assert one.camera == one.state.turned == turned
        lead.do("rotating_frame", not lead.state.view.rotating_frame)
        both(EASED)
        assert one.state.turned is None
        assert near(one.camera, lead.camera)
