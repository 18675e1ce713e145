"""The main jobs in Firefox."""

from collections.abc import Iterator

import pytest
from live.browser import NODES, READY, by_id
from live.firefox import FirefoxPage, firefox
from live.firefox_path import find_firefox
from live.server import wait_until

from beamviz.beam import Beam
from beamviz.explorer import explorer
from beamviz.explorer.features.lessons import LessonState
from beamviz.explorer.session import Session
from beamviz.scene import Scene

pytestmark = pytest.mark.slow
FIRST = Scene.of(Beam(alpha=1, beta=0.5, gamma=10), amplitude=0.0)
NO_FIREFOX = "no Firefox found (set BEAMVIZ_FIREFOX to one)"
ARROW_RIGHT = "\ue014"  # as WebDriver names the key


@pytest.fixture
def desk(frame_loops) -> Iterator[tuple[FirefoxPage, Session]]:
    """A page in Firefox, and its session."""
    browser = find_firefox() or pytest.skip(NO_FIREFOX)
    with explorer(FIRST) as url, firefox(browser) as shown:
        shown.open(url)
        shown.wait(READY)
        (session,) = frame_loops[-1].sessions.values()
        yield shown, session


def place(shown: FirefoxPage, x: float) -> tuple[float, float]:
    """Where a point of the beam is on the page."""
    x, y = shown.evaluate(f"""(() => {{
      const {{ camera, canvas }} = window.__viserMutable, wheel = {NODES}['/scene/rotor'];
      const at = wheel.localToWorld(wheel.position.clone().set({x}, 0, 0)).project(camera);
      const r = canvas.getBoundingClientRect();
      return [r.left + r.width * (1 + at.x) / 2, r.top + r.height * (1 - at.y) / 2]; }})()""")
    return x, y


def test_the_main_jobs(desk):
    """Numbers, a slider by its keys, undo, a drag of the mass, motion, a chart, a map, a lesson."""
    shown, session = desk
    state = session.visitor.state
    shown.wait("document.querySelectorAll('#mode-rows [data-row]').length === 5")
    assert "4.3906" in shown.evaluate("document.querySelector('#mode-rows').innerText")
    shown.wait(
        "!!document.querySelector('#tab-frequencies svg path, #tab-frequencies svg polyline')"
    )

    shown.evaluate(f"{by_id('gamma-slider')}.focus()")
    shown.key(ARROW_RIGHT)
    shown.wait("/gamma=10[.]/.test(location.search)")
    shown.click(by_id("undo"))
    shown.wait("location.search === ''")

    shown.drag(place(shown, 0.5), place(shown, 0.6), place(shown, 0.7), place(shown, 0.8))
    wait_until(lambda: abs(session.visitor.state.case.beam.beta - 0.8) < 0.03)

    angle = session.visitor.clock.angle
    wait_until(lambda: session.visitor.clock.angle != angle)  # it plays
    shown.click(by_id("play"))
    wait_until(lambda: not session.visitor.state.view.playing)

    for name in ("map", "loads", "lessons"):
        shown.click(by_id(f"to-{name}"))
        shown.wait(f"!{by_id(f'tab-{name}')}.hidden")
    shown.click("[...document.querySelectorAll('#tab-lessons button')][0]")
    wait_until(lambda: session.visitor.state.slice(LessonState).lesson)
    shown.wait(f"!{by_id('lesson')}.hidden")
    assert state.slice(LessonState).lesson == ""
    assert shown.problems == []
