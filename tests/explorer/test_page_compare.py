"""The real page: the mass dragged by a mouse."""

import contextlib

import numpy as np
import pytest
from live.browser import Page, field, page

from beamviz.beam import Beam
from beamviz.explorer.app import explorer
from beamviz.scene import Scene, ViewOptions
from beamviz.solver import solve

pytestmark = pytest.mark.browser

START = Beam(alpha=1, beta=0.5, gamma=3)
NODES = "window.__viserMutable && window.__viserMutable.nodeRefFromName"
# What viser's own page complains about when a body of the scene is dragged.
KNOWN = "Unable to preventDefault inside passive event listener invocation."


def on_screen(shown: Page, x: float) -> tuple[float, float]:
    """Where a point of the beam, so far from the clamp, is on the page."""
    return tuple(
        shown.evaluate(
            f"""(() => {{
              const {{ camera, canvas }} = window.__viserMutable;
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


def test_the_mass_is_dragged_by_a_mouse():
    """From the middle towards the tip: beta is where the pointer let go, to a hundredth; the
    ghost stays."""
    scene = Scene(START, view=ViewOptions(playing=False, shares=(1.0,), amplitude=0.0))
    equilibrium = solve(START).equilibrium
    position = f"parseFloat({field('position β')}.value)"
    there = f"Math.abs({position} - 0.8) < 0.01"
    with explorer(scene) as url, page(url, 1280, 860) as shown:
        shown.wait(f"!!({NODES} && {NODES}['/scene/rotor/mass'])")
        shown.wait("document.body?.innerText.includes('Stable equilibrium')")
        for _ in range(4):  # a busy machine may see the pointer go by, or let go on the way
            places = (shown.evaluate(position), 0.8)
            start, end = (on_screen(shown, equilibrium.position([x])[0, 0]) for x in places)
            move(shown, start, end)
            with contextlib.suppress(TimeoutError):
                shown.wait(there, timeout=10)
                break
        assert shown.evaluate(there)
        shown.wait(f"{NODES}['/scene/rotor/overlay']?.visible === true")
        assert [problem for problem in shown.problems if KNOWN not in problem] == []
