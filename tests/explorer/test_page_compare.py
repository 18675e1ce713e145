"""The real page: the mass dragged by a mouse, all modes at once."""

import contextlib
from collections.abc import Iterator

import numpy as np
import pytest
from live.browser import Page, button, field, page

from beamviz.beam import Beam
from beamviz.explorer.app import explorer
from beamviz.scene import Scene, ViewOptions
from beamviz.solver import solve

pytestmark = pytest.mark.browser

START = Beam(alpha=1, beta=0.5, gamma=3)
NODES = "window.__viserMutable && window.__viserMutable.nodeRefFromName"
# What viser's own page complains about when a body of the scene is dragged.
KNOWN = "Unable to preventDefault inside passive event listener invocation."


@pytest.fixture(scope="module")
def shown() -> Iterator[Page]:
    """One page, paused at rest: mode 1 with no amplitude."""
    scene = Scene(START, view=ViewOptions(playing=False, shares=(1.0,), amplitude=0.0))
    with explorer(scene) as url, page(url, 1280, 860) as opened:
        opened.wait(f"!!({NODES} && {NODES}['/scene/rotor/mass'])")
        opened.wait("document.body?.innerText.includes('Stable equilibrium')")
        opened.wait("!document.getElementById('root')?.innerText.includes('Connecting')")
        opened.next_frame()
        yield opened


def value(label: str) -> str:
    """The number beside a slider."""
    return f"parseFloat({field(label)}.value)"


def on_screen(shown: Page, x: float) -> tuple[float, float]:
    """Where a point of the beam, so far from the clamp, is on the page."""
    return tuple(
        shown.evaluate(
            f"""(() => {{
              const {{ camera, canvas, scene }} = (() => {{
                const m = window.__viserMutable;
                return {{ camera: m.camera, canvas: m.canvas, scene: m.scene }};
              }})();
              const wheel = {NODES}['/scene/rotor'];
              const at = wheel.localToWorld(wheel.position.clone().set({x}, 0, 0)).project(camera);
              const r = canvas.getBoundingClientRect();
              return [r.left + r.width * (1 + at.x) / 2, r.top + r.height * (1 - at.y) / 2];
            }})()"""
        )
    )


def move(shown: Page, start: tuple[float, float], end: tuple[float, float]) -> None:
    """Drag from one point of the page to another."""
    shown.mouse("mouseMoved", *start)
    shown.next_frame()
    shown.mouse("mousePressed", *start, 1)
    for share in np.linspace(0.1, 1, 10):
        x, y = (a + share * (b - a) for a, b in zip(start, end, strict=True))
        shown.mouse("mouseMoved", x, y, 1)
        shown.next_frame()
    shown.mouse("mouseReleased", *end)


def test_the_mass_is_dragged_by_a_mouse(shown):
    """From the middle towards the tip: beta is where the pointer let go, to a hundredth; the
    ghost stays, and the comparison tells how the frequencies were."""
    equilibrium = solve(START).equilibrium
    there = f"Math.abs({value('position β')} - 0.8) < 0.01"
    for _ in range(4):  # a busy machine may see the pointer go by, or let go on the way
        places = (shown.evaluate(value("position β")), 0.8)
        start, end = (on_screen(shown, equilibrium.position([x])[0, 0]) for x in places)
        move(shown, start, end)
        with contextlib.suppress(TimeoutError):
            shown.wait(there, timeout=10)
            break
    assert shown.evaluate(there)
    shown.wait(f"{NODES}['/scene/rotor/overlay']?.visible === true")
    assert [problem for problem in shown.problems if KNOWN not in problem] == []


def test_all_modes_are_drawn_above_each_other(shown):
    """Five beams, each higher than the next; the one scene is hidden."""
    shown.click(button("All"))
    shown.wait(f"!!{NODES}['/mode 5'] && {NODES}['/scene'].visible === false")
    heights = shown.evaluate(f"[1,2,3,4,5].map(k => {NODES}['/mode ' + k].position.z)")
    assert heights == sorted(heights, reverse=True)
    shown.click(button("B2"))
    shown.wait(f"{NODES}['/scene'].visible !== false")
