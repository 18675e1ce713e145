"""Dragging the mass: the position under the pointer, and the beam before as an overlay."""

import contextlib

import numpy as np
import pytest
from live.browser import NODES, Page, by_id, says
from live.visitor import PAPER, frequency_text

from beamviz.beam import Beam
from beamviz.explorer.features.comparison import number
from beamviz.explorer.features.controls import nearest
from beamviz.scene import Scene
from beamviz.solver import solve


def test_no_point_without_a_line_of_sight():
    """For a line seen end on, a line of sight of length 0, or nan."""
    line, x, origin = np.array([[0.0, 0, 0], [1.0, 0, 0]]), np.array([0.0, 1.0]), np.zeros(3)
    assert nearest(line, x, np.array([-3.0, 0, 0]), origin) is None
    assert nearest(line, x, origin, origin) is None
    assert nearest(line, x, np.array([0.0, -3.0, 1.0]), np.full(3, np.nan)) is None


# What viser's own page complains about when a body of the scene is dragged.
KNOWN = "Unable to preventDefault inside passive event listener invocation."


def on_screen(shown: Page, x: float, y: float) -> list[float]:
    """Where a point of the plane of rotation, in the frame of the hub, is on the page."""
    return shown.evaluate(f"""(() => {{
      const {{ camera, canvas }} = window.__viserMutable, wheel = {NODES}['/scene/rotor'];
      const place = wheel.position.clone().set({x}, {y}, 0);
      const at = wheel.localToWorld(place).project(camera), r = canvas.getBoundingClientRect();
      return [r.left + r.width * (1 + at.x) / 2, r.top + r.height * (1 - at.y) / 2];
    }})()""")


@pytest.mark.parametrize(
    ("beam", "state", "end", "turned"),
    [
        (PAPER.replace(delta=0.5, gamma=20), "straight", 0.95, False),
        (Beam(alpha=0.2, beta=0.6, gamma=4, delta=-1), "stable", 0.8, True),
    ],
    ids=["straight", "bent"],
)
def test_the_mass_is_dragged_by_a_mouse(shown, beam, state, end, turned):
    """Along a beam, stretched or bent, towards the tip: beta is where the drag ended, to a
    hundredth, also if the shape of the beam changes, in both frames. The beam before is drawn pale,
    with its frequencies beside the new ones."""
    view = {"shares": [1.0], "amplitude": 0.0, "pace": 0.1, "rotating_frame": not turned}
    scene = Scene.of(beam, state=state, playing=turned, **view)
    shown.send("load", f"beam.toml\n{scene.to_toml()}")
    shown.wait(f"{NODES}?.['/scene/rotor/mass'] && {says(frequency_text(beam, state=state))}")
    if turned:
        shown.wait(f"Math.abs({NODES}['/scene/rotor'].quaternion.z) > 0.1")
        shown.send("playing", False)

    def place(x: float) -> list[float]:
        solution = solve(beam.replace(beta=x), state=state)
        along, across = solution.equilibrium.position([x])[0]
        return on_screen(shown, beam.delta + along, across)

    position = f"parseFloat({by_id('beta-field')}.value)"

    def stays(x: float) -> str:
        there = f"Math.abs({position} - {x}) < 0.01"
        return f"{there} && new Promise(done => setTimeout(() => done({there}), 1000))"

    for _ in range(4):  # a busy machine may see the pointer go by, or let go on the way
        shown.send("beta", beam.beta)
        shown.wait(stays(beam.beta))
        shown.drag(place(beam.beta), place(end))
        with contextlib.suppress(TimeoutError):
            shown.wait(stays(end), timeout=10)
            break
    assert shown.evaluate(stays(end))
    shown.wait(f"{NODES}['/scene/rotor/overlay']?.visible === true")
    after = shown.number("beta")
    omegas = [solve(beam.replace(beta=x), state=state).frequencies[0] for x in (beam.beta, after)]
    for words in ("before, ω", *map(number, omegas)):
        shown.wait(f"{by_id('comparison')}.textContent.includes('{words}')")
    assert [problem for problem in shown.problems if KNOWN not in problem] == []
