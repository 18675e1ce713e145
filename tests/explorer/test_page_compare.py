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

NODES = "window.__viserMutable && window.__viserMutable.nodeRefFromName"
# What viser's own page complains about when a body of the scene is dragged.
KNOWN = "Unable to preventDefault inside passive event listener invocation."


def on_screen(shown: Page, x: float, y: float) -> tuple[float, float]:
    """Where a point of the plane of rotation, in the frame of the hub, is on the page."""
    return tuple(
        shown.evaluate(
            f"""(() => {{
              const {{ camera, canvas }} = window.__viserMutable;
              const wheel = {NODES}['/scene/rotor'];
              const place = wheel.position.clone().set({x}, {y}, 0);
              const at = wheel.localToWorld(place).project(camera);
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


@pytest.mark.parametrize(
    ("beam", "state", "end"),
    [
        (Beam(alpha=1, beta=0.5, gamma=3), "straight", 0.95),
        (Beam(alpha=0.2, beta=0.6, gamma=4, delta=-1), "stable", 0.8),
    ],
    ids=["straight", "bent"],
)
def test_the_mass_is_dragged_by_a_mouse(beam, state, end):
    """Along a beam, straight or bent, towards the tip: beta is where the drag ended, to a
    hundredth, also if the shape of the beam changes; the overlay is visible."""
    view = ViewOptions(playing=False, shares=(1.0,), amplitude=0.0)
    scene = Scene(beam, {"state": state}, view=view)

    def place(x: float) -> tuple[float, float]:
        solution = solve(beam.replace(beta=x), state=state)
        along, across = solution.equilibrium.position([x])[0]
        return on_screen(shown, beam.delta + along, across)

    position = f"parseFloat({field('position β')}.value)"

    def stays(x: float) -> str:
        there = f"Math.abs({position} - {x}) < 0.01"
        return f"{there} && new Promise(done => setTimeout(() => done({there}), 1000))"

    with explorer(scene) as url, page(url, 1280, 860) as shown:
        shown.wait(f"!!({NODES} && {NODES}['/scene/rotor/mass'])")
        shown.wait("document.body?.innerText.includes('Stable equilibrium')")
        for _ in range(4):  # a busy machine may see the pointer go by, or let go on the way
            shown.evaluate(f"beamviz.send('beta', {beam.beta})")
            shown.wait(stays(beam.beta))
            move(shown, place(beam.beta), place(end))
            with contextlib.suppress(TimeoutError):
                shown.wait(stays(end), timeout=10)
                break
        assert shown.evaluate(stays(end))
        shown.wait(f"{NODES}['/scene/rotor/overlay']?.visible === true")
        assert [problem for problem in shown.problems if KNOWN not in problem] == []
