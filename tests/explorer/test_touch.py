"""What is dragged in the scene by a finger, on a phone."""

from collections.abc import Iterator

import pytest
from live.browser import NODES, READY, Page, by_id, page
from live.server import latest, wait_until

from beamviz.beam import Beam
from beamviz.dynamics import motion
from beamviz.explorer.experiment import MotionState
from beamviz.explorer.features.hub_turn import HubState
from beamviz.explorer.features.mass_drag import DragState
from beamviz.explorer.session import Session
from beamviz.scene import Scene

pytestmark = pytest.mark.slow
BEAM = Beam(alpha=1, beta=0.5, gamma=3)
FIRST = Scene.of(BEAM, shares=[1.0], amplitude=0.0, playing=False, rotating_frame=True)
PULL = "?alpha=1&beta=0.5&gamma=3&tab=motion&moving=true&motion={until=4.0}"


@pytest.fixture
def phone(url, frame_loops) -> Iterator[tuple[Page, Session]]:
    """A page on a phone, and its session."""
    with page(url, 390, 844) as shown:
        shown.wait(READY)
        shown.resize(390, 844)
        shown.evaluate("scrollTo(0, 0)")
        session = latest(frame_loops)
        yield shown, session


def place(shown: Page, x: float, y: float) -> list[float]:
    """Where a point of the plane of rotation, in the frame of the hub, is on the page."""
    return shown.evaluate(f"""(() => {{
      const {{ camera, canvas }} = window.__viserMutable, wheel = {NODES}['/scene/rotor'];
      const at = wheel.localToWorld(wheel.position.clone().set({x}, {y}, 0)).project(camera);
      const r = canvas.getBoundingClientRect();
      return [r.left + r.width * (1 + at.x) / 2, r.top + r.height * (1 - at.y) / 2]; }})()""")


def scrolled(shown: Page) -> float:
    return shown.evaluate("scrollY")


def test_the_mass_is_dragged_by_a_finger(phone):
    """To where the finger leaves it, to a hundredth; the page does not scroll meanwhile."""
    shown, session = phone
    shown.wait(f"!!{NODES}?.['/scene/rotor/mass']")
    shown.swipe(
        shown.at_rest(lambda: place(shown, 0.5, 0.0)),
        place(shown, 0.8, 0.0),
        taken=lambda: session.visitor.state.slice(DragState).grip,
        arrived=lambda: abs(shown.number("beta") - 0.8) < 0.01,
    )
    wait_until(lambda: session.visitor.state.slice(DragState).grip is None)
    shown.catch_up()
    assert shown.number("beta") == pytest.approx(0.8, abs=0.01)
    assert scrolled(shown) == 0
    assert shown.problems == []


def test_the_tip_is_pulled_by_a_finger(phone):
    """And let go: the motion begins with the force that held it there."""
    shown, session = phone
    shown.catch_up()  # the page has sent its own address, too
    shown.send("link", PULL)
    wait_until(lambda: session.visitor.clock.film and not session.is_busy)
    shown.evaluate("scrollTo(0, 0)")
    shown.send("playing", False)
    shown.send("moment", 0.4)
    wait_until(lambda: session.visitor.clock.moment == 0.4)
    shown.catch_up()
    x, y, _ = session.view.beam.line[-1]
    shown.swipe(
        shown.at_rest(lambda: place(shown, x - 0.02, y)),
        place(shown, 0.93, -0.3),
        taken=lambda: session.visitor.state.slice(MotionState).hold,
        arrived=lambda: abs(session.visitor.state.slice(MotionState).hold.deflection + 0.3) < 0.02,
    )
    wait_until(lambda: session.visitor.state.slice(MotionState).experiment.pull < 0)
    own = session.visitor.state.slice(MotionState).experiment
    held = motion(BEAM, 0.1, release=own.pull, release_at=own.pull_at)
    assert own.pull_at == 1.0
    assert held.tip[0, 1] == pytest.approx(-0.3, abs=0.02)
    assert scrolled(shown) == 0
    assert shown.problems == []


def test_the_hub_is_turned_by_a_finger(phone):
    """To the right, in a step to undo; the page does not scroll meanwhile."""
    shown, session = phone
    shown.wait(f"!!{NODES}?.['/scene/rotor/wheel']")
    x, y = shown.at_rest(lambda: place(shown, 0.0, 0.0))
    shown.swipe(
        (x, y - 20),
        (x + 100, y - 20),
        taken=lambda: session.visitor.state.slice(HubState).hub_grip,
        arrived=lambda: shown.number("gamma") > 10,
    )
    wait_until(lambda: session.visitor.state.slice(HubState).hub_grip is None)
    shown.send("undo", None)
    shown.wait(f"{by_id('gamma-field')}.value === '3'")
    assert scrolled(shown) == 0
    assert shown.problems == []


def test_a_finger_that_scrolls_the_page_sets_no_slider(phone):
    """It does where it moves along the slider, and where it taps on it."""
    shown, session = phone
    shown.resize(390, 844, touch=True)
    slider, field = by_id("gamma-slider"), f"{by_id('gamma-field')}.value"
    left, top, width, height = shown.box(slider)
    middle = left + width / 2, top + height / 2
    before = scrolled(shown)
    shown.swipe(middle, (middle[0], middle[1] - 120), arrived=lambda: scrolled(shown) > before)
    shown.wait(f"{slider}.value === '3'")  # it is back
    shown.catch_up()
    assert session.visitor.state.case.beam == BEAM
    left, top, width, height = shown.box(slider)
    for part in (0.6, 0.3):
        shown.touch("touchStart", (left + part * width, top + height / 2))
        shown.touch("touchEnd")
        shown.wait(f"Math.abs({field} / {slider}.max - {part}) < 0.05")
    ends = [(left + part * width, top + height / 2) for part in (0.3, 0.8)]
    shown.swipe(*ends, arrived=f"Math.abs({field} / {slider}.max - 0.8) < 0.05")
