"""The viewpoint: whose it is, the server's or the visitor's, in whatever order their messages come.

The page is played by the test, which reports its camera when it likes.
"""

import math
from collections.abc import Iterator
from dataclasses import replace

import pytest
from live.browser import READY, page
from live.offline import CLOCK, Desk, Offline, Workers, lecture, offline, run
from live.server import latest, wait_until
from live.visitor import PAPER

from beamviz.explorer.camera import DEFAULT
from beamviz.scene import Camera, Scene

FIRST = Scene(PAPER).changed(playing=False, rotating_frame=False)
EASED = 30  # frames of a change of view, and a few more
LATE = 8  # frames that a message of a page on a slow connection takes


@pytest.fixture
def desk() -> Iterator[Desk]:
    with offline():
        yield Desk(FIRST)


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


def test_a_page_that_tells_where_it_is_before_the_first_picture_has_not_been_turned():
    """It is not where the server wants it yet, wherever that is."""
    with offline():
        opening = Offline(FIRST, Workers())
        camera = opening.client.camera
        camera.position = (0.0, -3.0, 1.0)
        run(opening.session.camera_moved(None))
        opening.session.tick(CLOCK.time)
        assert opening.session.visitor.state.turned is None
        assert math.dist(camera.position, (0.0, -3.0, 1.0)) > 0.1


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


def test_over_a_slow_connection_no_one_has_turned_a_view_that_follows_a_slider(desk):
    """The page tells all viewpoints, each a third of a second late."""
    told = [desk.camera]
    for k in range(40):
        desk.do("delta", round(0.2 * k, 2))
        desk.frame()
        told.append(desk.camera)
        if k >= LATE:
            now = desk.camera
            desk.report(told[k - LATE])
            assert desk.state.turned is None
            desk.frame()
            desk.report(now)
    assert not near(told[-1], told[0])


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


@pytest.mark.parametrize("is_shown", [False, True])
def test_a_change_of_the_frame_fits_the_view_though_the_visitor_turns_on(desk, is_shown):
    """The page has not heard of it yet; also where no frame has shown the turn."""
    desk.turn()
    if is_shown:
        desk.frame()
    desk.do("rotating_frame", not desk.state.view.rotating_frame)
    turned = desk.turn()
    desk.frame(EASED)
    assert not near(desk.camera, turned)
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
    """It would be invalid in a link; the page goes back to the last valid one, and tells so."""
    turned = desk.turn()
    desk.frame()
    for far in ((0.0, 0.0, 2000.0), (math.nan, 0.0, 1.0), (math.inf, 0.0, 1.0)):
        view = desk.visitor.client.camera
        view.position = far
        run(desk.session.camera_moved(None))
        desk.frame()
        assert desk.camera == desk.state.turned == turned
        desk.report(turned)
        desk.frame()
        assert desk.camera == desk.state.turned == turned


def test_a_view_that_was_turned_is_the_same_after_a_drag_of_the_mass(desk):
    """The view goes back to it from where the scene was meanwhile, and tells late where it was."""
    desk.do("rotating_frame", True)
    desk.frame(EASED)
    turned = desk.turn()
    desk.frame()
    start = float(desk.session.view.beam.frame.position[0])
    points = ((start + x, 0.0, 0.0) for x in (0.5, 0.8, 0.8))
    desk.guest.visitor.drag("/scene/rotor/mass", *points, between=desk.frame)
    passed = list[Camera]()
    for _ in range(EASED):
        desk.frame()
        if desk.visitor.clock.transition:
            passed.append(desk.camera)
    assert desk.state.case.numbers["beta"] == pytest.approx(0.8, abs=0.02)
    assert not near(passed[0], turned)
    desk.report(passed[len(passed) // 2])
    desk.frame()
    desk.report(turned)
    desk.frame()
    assert desk.camera == desk.state.turned == turned


def test_a_visitor_of_a_lecture_keeps_a_view_of_their_own():
    """Whatever the presenter edits, until that changes the frame."""
    with offline():
        lead, one = Desk(FIRST), Desk(FIRST)
        both = lecture(lead, one)
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


TURN = "void window.__viserMutable.cameraControl.rotate(0.4, 0.1, true)"  # as the mouse does, eased
HAS_VIEW = "location.search.includes('position=')"


@pytest.mark.slow
def test_a_browser_is_where_the_state_says(url, frame_loops):
    """After a turn, fitting while it goes on, a change of the frame, and of the size."""
    with page(url, 1440, 900) as shown:
        shown.wait(READY)
        session = latest(frame_loops)

        def at_rest() -> Camera | None:
            before = session.visitor.camera.present
            shown.next_frame(12)
            shown.catch_up()
            after = session.visitor.camera.present
            return None if session.visitor.clock.transition or before != after else after

        fitted = wait_until(at_rest)
        assert session.visitor.state.turned is None
        shown.evaluate(TURN)
        wait_until(lambda: session.visitor.state.turned)
        turned = wait_until(at_rest)
        assert near(turned, session.visitor.state.turned)
        assert not near(turned, fitted)
        shown.wait(HAS_VIEW)
        shown.evaluate(TURN)
        shown.send("reset_view")
        shown.evaluate(TURN)
        shown.next_frame(60)
        now = wait_until(at_rest)
        own = session.visitor.state.turned
        assert near(now, own or fitted)  # whichever the page has got last
        shown.send("reset_view", until=f"!{HAS_VIEW}")
        assert near(wait_until(at_rest), fitted)
        shown.evaluate(TURN)
        wait_until(lambda: session.visitor.state.turned)
        for is_rotating in (True, False):
            shown.send("rotating_frame", is_rotating)
            wait_until(lambda on=is_rotating: session.snapshot.state.view.rotating_frame is on)
            wait_until(lambda: session.visitor.state.turned is None)  # not on the way any more
            assert near(wait_until(at_rest), fitted) is not is_rotating
        shown.resize(1190, 900)
        wait_until(lambda: not near(session.visitor.camera.present, fitted))
        wait_until(at_rest)
        assert session.visitor.state.turned is None
